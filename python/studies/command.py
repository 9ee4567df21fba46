"""How a study becomes a command: arguments by typer, those that several studies take, errors in one line, exit code 2, as those of
hnav itself."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any, TypeVar

import pandas as pd
import typer
from rich.table import Table

from hnav.cli.console import say
from hnav.cli.console import tracked as tracked
from hnav.cli.words import UsageError, answer
from hnav.io.outputs import write_files

Item = TypeVar("Item")
Workers = Annotated[int, typer.Option(min=1, help="Processes")]
WORKERS = min(2, os.cpu_count() or 1)
Seed = Annotated[int, typer.Option(min=0, help="Of the random numbers")]
Trials = Annotated[Path | None, typer.Argument(metavar="[DIR]", envvar="BROAD_DIR", help="BROAD trials")]
Rows = Annotated[int, typer.Option(min=100, help="Of the recording")]
Checkout = Annotated[Path, typer.Option(metavar="FOLDER", help="A checkout with its build instead of this one")]


def app_of(name: str) -> typer.Typer:
    """Of a study: the function command of its module, or of the module study in its package."""
    module = import_module(f"studies.{name}")
    app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    app.command()((import_module(f"studies.{name}.study") if hasattr(module, "__path__") else module).command)
    return app


def main_of(name: str) -> Callable[..., None]:
    """main(arguments=None) of a study."""
    app = app_of(name)

    def main(arguments: Sequence[str] | None = None) -> None:
        answer(f"study {name}", partial(app, prog_name=f"./run study {name}"), arguments)

    return main


def check_choices(option: str, chosen: Iterable[str | None], known: Collection[str]) -> None:
    """None: nothing was chosen. Raises UsageError for the first name that is not known."""
    for name in chosen:
        if name is not None and name not in known:
            raise UsageError(f"{option} {name}: choose from {', '.join(known)}")


def titled_table(title: str, names: str, figures: str = "", rows: Iterable[Iterable[str]] = (), **style: Any) -> Table:
    """Columns of names, which are not broken, and of figures to the right; " | " parts their heads."""
    table = Table(title=title, title_justify="left", **style)
    for name in names.split(" | "):
        table.add_column(name, no_wrap=True)
    for name in figures.split(" | ") if figures else ():
        table.add_column(name, justify="right")
    for row in rows:
        table.add_row(*row)
    return table


def cells(template: str, rows: Iterable[Mapping[str, Any]]) -> Iterator[list[str]]:
    """Rows of titled_table by a template of their values, such as "{plant} | {nees:.3f}"; NaN shows as a dash."""
    return (["-" if cell == "nan" else cell for cell in template.format_map(row).split(" | ")] for row in rows)


def draw_into(path: Path | None, draw: Callable[[Item], Any], found: Item) -> None:
    """Writes what draw makes of the findings and says where; nothing without a path. Raises HnavError."""
    if path:
        from hnav.reports.plots import save  # matplotlib, which a table does not need

        save(draw(found), path)
        say(str(path))


def write_rows(path: Path | None, rows: Iterable[Mapping[str, object]]) -> None:
    """As CSV: empty cells where there is no figure, flags as 0 and 1; says where. Nothing without a path. Raises OutputError."""
    if path:
        table = pd.DataFrame(list(rows))
        flags = table.select_dtypes(bool).columns
        text = table.astype(dict.fromkeys(flags, int)).to_csv(index=False, float_format="%.6g", lineterminator="\n")
        write_files({path: text})
        say(str(path))


def after(time_s: float) -> str:
    """When something was first so, for a table; NaN: it never was."""
    return "never" if math.isnan(time_s) else f"{time_s:.1f} s"
