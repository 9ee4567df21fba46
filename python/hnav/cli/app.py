"""The command `hnav`: what there is, the version, and how errors end. A command's own module is loaded when it is called."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from hnav import __version__
from hnav.cli.words import UsageError, answer

# The module of a command has its name and defines `command`; this is its line of help.
COMMANDS = {
    "filter": "Runs a filter over a recording and writes attitude, bias and sigmas.",
    "check": "Says what a recording was taken for, and what is not plausible in it: units, axes, signs, gaps.",
    "score": "Scores a filter on all BROAD trials of a folder.",
    "options": "Prints the options of a filter with unit, default, range and meaning.",
    "calibrate": "Calibrates a magnetometer: hard iron, soft iron, scale and misalignment, by an ellipsoid and gravity.",
    "simulate": "Runs a system of FMUs in closed co-simulation. FMUs are native code: an archive runs with all your rights.",
    "report": "One self-contained HTML page about a recording or a simulation.",
    "montecarlo": "Many runs of a system, and their table with 95 % confidence intervals.",
    "certify": "Certifies the stability of a run: decay, region of attraction, noise floor, dwell; or says why it cannot.",
    "demo": "The paper's experiment in closed co-simulation, and a filter's FMU over real recordings, with pictures.",
}
MOVED = {"bench": "it is a study now: ./run study bench, in a checkout"}


def load(name: str) -> Any:
    """A command with its arguments and options."""
    alone = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    alone.command(name, help=COMMANDS[name])(importlib.import_module(f"hnav.cli.{name}").command)
    return typer.main.get_command(alone)


class _Later(TyperCommand):
    """A command that the overview shows; its module is loaded when it is called."""

    def make_context(self, info_name: str | None, args: list[str], *more: Any, **extra: Any) -> Any:
        return load(str(self.name)).make_context(info_name, args, *more, **extra)


class _Commands(TyperGroup):
    def list_commands(self, ctx: Any) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        if cmd_name in MOVED:
            raise UsageError(f"{cmd_name}: {MOVED[cmd_name]}")
        return _Later(cmd_name, callback=None, help=COMMANDS[cmd_name]) if cmd_name in COMMANDS else None


app = typer.Typer(
    cls=_Commands, add_completion=False, no_args_is_help=True, pretty_exceptions_enable=False, help="Hybrid navigation filters."
)


def show_version(wanted: bool) -> None:
    if wanted:
        from hnav.native.library import version

        print(f"hnav {__version__}, library {version()}")
        raise typer.Exit


@app.callback()
def root(
    version: Annotated[bool, typer.Option("--version", callback=show_version, is_eager=True, help="Show the version")] = False,
) -> None:
    pass


def main(arguments: Sequence[str] | None = None) -> None:
    """One line on stderr and exit code 2 for everything that the user can mend."""
    answer("hnav", app, arguments)
