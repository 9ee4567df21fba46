"""Output that all commands share: lines, tables, the progress bar. --quiet suppresses it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import TypeVar

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.status import Status
from rich.table import Table

Item = TypeVar("Item")
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


@contextmanager
def counting(what: str, total: float | None = None) -> Iterator[Callable[[int, int], None]]:
    """A progress bar, and what sets it: how many are done, and of how many."""
    with bar() as progress:
        task = progress.add_task(what, total=total)
        yield lambda done, of: progress.update(task, completed=done, total=of)


def tracked(items: Iterable[Item], what: str, total: float | None = None) -> Iterator[Item]:
    """Each of the items, beside a bar that says how many there were. total: where the items have no length."""
    with bar() as progress:
        yield from progress.track(items, total, description=what)


def written(*files: Path | None) -> str:
    """The files that were asked for."""
    return " and ".join(str(file) for file in files if file is not None)


def load_pages(report: Path | None) -> None:
    """Where a page is asked for: Plotly takes a while to load, and where it is missing this says so before the work."""
    if report is not None:
        import_module("hnav.reports.page")


def working(on: str) -> Status:
    """Shows the running task on stderr, removed at its end."""
    return Console(stderr=True, quiet=console.quiet).status(on)
