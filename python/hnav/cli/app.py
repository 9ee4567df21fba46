"""The command `hnav`: the list of commands, the version, and the handling of errors. A command's module is loaded when it is
called.
"""

from __future__ import annotations

import difflib
import importlib
import os
import sys
from collections.abc import Sequence
from functools import partial
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from hnav import __version__
from hnav.cli.words import UsageError, answer

# The module of a command has its name, with _ for -, and defines `command`; this is its line of help.
COMMANDS = {
    "filter": "Runs a filter over a recording and writes attitude, bias and sigmas.",
    "check": "Shows the format and units of a recording, and implausible units, axes, signs and gaps.",
    "compare": "Errors of attitudes and places against a reference, clocks and frames aligned; with --filter, of a filter on a folder of BROAD trials.",
    "options": "Prints the options of a filter with unit, default, range and meaning; with words, those that match.",
    "noise": "Noise of a sensor at rest: Allan deviation, densities with their confidence, a sensor file.",
    "calibrate": "Calibrates a magnetometer of a turned device; with --sensor also accelerometer and gyroscope, by rests in many attitudes.",
    "simulate": "Runs a system of FMUs in closed co-simulation. FMUs are native code: an archive runs with all your rights.",
    "systems": "Lists the systems, and of one its components, scenarios and grades.",
    "report": "One self-contained HTML page about a recording, a simulation, or many of them.",
    "montecarlo": "Many runs of a system, and their table with 95 % confidence intervals.",
    "certify": "Certifies the stability of a run: decay, region of attraction, noise floor, dwell; or states why it cannot.",
    "observe": "An estimator made of an FMU and a plan of its sensors. FMUs are native code: one runs with all your rights.",
    "live": "A filter over samples that arrive now: serial port, UDP, TCP, MAVLink, standard input; estimates, recording, page.",
    "demo": "Your own recording, or two of devices and a closed loop of FMUs: what the filter makes of it, and a page.",
}


EXIT_CODES = (
    "Exit codes: 0 done; 1 hnav check found something that is not plausible; 2 the request cannot be carried out, and a line on "
    "stderr states why; 130 interrupted."
)


def load(name: str) -> Any:
    """A command with its arguments and options."""
    command = _typed(name, COMMANDS[name], importlib.import_module(f"hnav.cli.{name.replace('-', '_')}").command)
    command.params += _typed("shared", "", shared).params
    return command


def shared(
    quiet: Annotated[
        bool, typer.Option("--quiet", "-q", callback=be_quiet, expose_value=False, help="Print errors and warnings only")
    ] = False,
) -> None:
    """Options of every command."""


def be_quiet(wanted: bool) -> None:
    # Loading Rich takes time; a command loads it anyway.
    from hnav.cli.console import be_quiet

    be_quiet(wanted)


def _typed(name: str, text: str, function: Any) -> Any:
    """A command made by typer from the arguments of a function."""
    alone = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    alone.command(name, help=text)(function)
    return typer.main.get_command(alone)


class _Later(TyperCommand):
    """A command in the overview; its module is loaded when it is called."""

    def make_context(self, info_name: str | None, args: list[str], *more: Any, **extra: Any) -> Any:
        return load(str(self.name)).make_context(info_name, args, *more, **extra)


class _Commands(TyperGroup):
    def list_commands(self, ctx: Any) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        if cmd_name not in COMMANDS and not cmd_name.startswith("-") and not ctx.resilient_parsing:
            near = difflib.get_close_matches(cmd_name, COMMANDS, n=1)
            meant = f"did you mean {near[0]}?" if near else f"there are {', '.join(COMMANDS)}"
            raise UsageError(f"there is no command {cmd_name}: {meant}")
        return _Later(cmd_name, callback=None, help=COMMANDS[cmd_name]) if cmd_name in COMMANDS else None


app = typer.Typer(
    cls=_Commands, pretty_exceptions_enable=False, help="Attitude, heading, position and velocity from recordings and in simulations.",
    epilog=EXIT_CODES, context_settings={"help_option_names": ["-h", "--help"]},
)  # fmt: skip


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
    """One line on stderr and exit code 2 for every error that the user can correct."""
    # The matrices are small: further threads of BLAS only wait, which doubles the processor time. NumPy reads this variable
    # when it is loaded.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    typed = list(sys.argv[1:] if arguments is None else arguments)
    answer("hnav", partial(app, prog_name="hnav"), typed or ["--help"])
