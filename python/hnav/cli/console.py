"""Output that all commands share: lines, tables, the progress bar. --quiet suppresses it."""

from __future__ import annotations

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.status import Status
from rich.table import Table

console = Console()
# Largest width in characters of a table in a pipe, which has no width.
WIDTH_OF_A_PIPE = 140


def be_quiet(wanted: bool) -> bool:
    """Whether the following lines are printed; errors and warnings on stderr always are."""
    console.quiet = wanted
    return wanted


def say(text: str) -> None:
    """One line, whatever the width of the terminal, without colours or markup."""
    console.print(text, highlight=False, soft_wrap=True, markup=False)


def show(table: Table, width: int = WIDTH_OF_A_PIPE) -> None:
    """Prints a table, as wide as the terminal."""
    (console if console.is_terminal else Console(width=width, quiet=console.quiet)).print(table)


def bar() -> Progress:
    """A progress bar on stderr, removed at its end; none without a terminal."""
    errors = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    return Progress(*columns, console=errors, transient=True, disable=console.quiet or not errors.is_terminal)


def working(on: str) -> Status:
    """Shows the running task on stderr, removed at its end."""
    return Console(stderr=True, quiet=console.quiet).status(on)
