"""What all commands share when they talk to the user: lines, tables, the progress bar. --quiet silences all of it."""

from __future__ import annotations

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.status import Status
from rich.table import Table

console = Console()
# A pipe has no width of its own: a table is as wide as its columns want, up to this.
WIDTH_OF_A_PIPE = 140


def be_quiet(wanted: bool) -> bool:
    """Whether what follows is printed; errors and warnings on stderr are."""
    console.quiet = wanted
    return wanted


def say(text: str) -> None:
    """One line, whatever the width of the terminal, without colours or markup of its own."""
    console.print(text, highlight=False, soft_wrap=True, markup=False)


def show(table: Table, width: int = WIDTH_OF_A_PIPE) -> None:
    """Prints a table, as wide as the terminal."""
    (console if console.is_terminal else Console(width=width, quiet=console.quiet)).print(table)


def bar() -> Progress:
    """A progress bar on stderr that is gone when it ends; nothing where nobody looks."""
    errors = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    return Progress(*columns, console=errors, transient=True, disable=console.quiet or not errors.is_terminal)


def working(on: str) -> Status:
    """Says on stderr what takes so long, and is gone when it ends."""
    return Console(stderr=True, quiet=console.quiet).status(on)
