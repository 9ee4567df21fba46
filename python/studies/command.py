"""How a study becomes a command: arguments by typer, errors in one line, exit code 2, as those of hnav itself."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import typer

from hnav.cli.words import answer


def study(name: str, command: Callable[..., Any]) -> Callable[..., None]:
    """main(arguments=None) of the study whose function is given."""
    app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    app.command()(command)

    def main(arguments: Sequence[str] | None = None) -> None:
        answer(f"study {name}", app, arguments)

    return main


def after(time_s: float) -> str:
    """When something was first so, for a table; NaN: it never was."""
    return "never" if math.isnan(time_s) else f"{time_s:.1f} s"
