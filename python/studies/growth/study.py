"""The command: which parts, up to what size, their tables and pictures."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any

import pandas as pd
import typer
from rich.table import Table

from hnav.cli.console import show
from hnav.cli.words import UsageError
from hnav.reports import plots
from hnav.reports.colours import BLUE
from studies.command import cells, check_choices, titled_table
from studies.growth import measures

SIZE_PX = (700, 320)


def draw_lines(path: Path, x: Any, panels: Mapping[str, Any], name: str, logarithmic: bool = True) -> None:
    """panels: what is drawn over x, a panel each, by its name. They begin at zero: what is flat looks flat."""
    with plots.styled():
        fig = plots.figure(*SIZE_PX, dpi=100)
        for axes, (label, y) in zip(fig.subplots(1, len(panels), squeeze=False)[0], panels.items()):
            axes.plot(x, y, "o-", color=BLUE)
            if logarithmic:
                axes.set_xscale("log")
            axes.set_ylim(0, 1.25 * max(y))
            axes.set(xlabel=name, ylabel=label)
        fig.tight_layout()
    plots.save(fig, path)


def draw_bars(path: Path, names: Any, values: Any, label: str) -> None:
    with plots.styled():
        fig = plots.figure(*SIZE_PX, dpi=100)
        axes = fig.subplots()
        axes.barh(names, values, color=BLUE)
        axes.invert_yaxis()
        axes.set_xlabel(label)
        fig.tight_layout()
    plots.save(fig, path)


# --------------------------------------------------------------------------------------------- parts


Draw = Callable[[Path], None]


def table_of(title: str, heads: str, template: str, found: pd.DataFrame) -> Table:
    first, _, figures = heads.partition(" | ")
    rows: Any = found.to_dict("records")
    return titled_table(title, first, figures, cells(template, rows), min_width=70)


def rows_part(most_rows: int) -> tuple[Table, Draw]:
    sizes = [size for size in (10**power for power in range(4, 10)) if size <= most_rows]
    # The smallest says what it takes to begin.
    found = pd.DataFrame(measures.of_rows([1000, *sizes]))
    start = found.iloc[0]
    found = found[1:].assign(us=1e6 * (found.cpu_s - start.cpu_s) / (found.rows - start.rows))
    title, heads = "hnav filter on a table of text, into another", "rows | CPU s | us a row | memory, MB"
    table = table_of(title, heads, "{rows:.0f} | {cpu_s:.1f} | {us:.1f} | {memory_mb:.0f}", found)
    return table, lambda path: draw_lines(path, found.rows, {"us a row": found.us, "memory, MB": found.memory_mb}, "rows")


def filters_part(most_rows: int) -> tuple[Table, Draw]:
    found = pd.DataFrame(measures.of_filters((1, 10, 100, 1000), samples=min(200_000, most_rows)))
    # Few filters take less than memory is measured by.
    kb = found.kb_per_filter.map("{:.0f}".format).where(found.filters >= 100, "")
    title, heads = "AHRS in closed form side by side, ten rows in turn", "filters | us a sample | kB a filter"
    table = table_of(title, heads, "{filters} | {us_per_sample:.2f} | {kb}", found.assign(kb=kb))
    return table, lambda path: draw_lines(path, found.filters, {"us a sample": found.us_per_sample}, "filters")


def late_part(most_rows: int) -> tuple[Table, Draw]:
    found = pd.DataFrame(measures.of_age((0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 0.9), rows=min(6000, most_rows)))
    title, heads = "A field that comes late, samples at 100 Hz", "late by, s | us more than in time | us for each row since"
    table = table_of(title, heads, "{late_s:g} | {us_per_late_sample:.1f} | {us_per_row:.2f}", found)
    panels = {"us more than in time": found.us_per_late_sample.clip(lower=0.0)}
    return table, lambda path: draw_lines(path, found.late_s, panels, "late by, s", logarithmic=False)


def montecarlo_part(most_rows: int) -> tuple[Table, Draw]:
    # A run of a minute has 6000 rows.
    runs, stop_s = (10, None) if most_rows >= 10 * 6000 else (2, 0.5)
    found = pd.DataFrame(measures.of_workers(runs, (1, 2), stop_s))
    title, heads = "Monte Carlo of the turntable system, scenario nominal, 60 s", " | runs a second | of each worker"
    table = table_of(title, heads, "{how} | {runs_per_s:.2f} | {per_worker:.2f}", found)
    return table, lambda path: draw_bars(path, found.how, found.per_worker, "runs a second and worker")


PARTS = {"rows": rows_part, "filters": filters_part, "late": late_part, "montecarlo": montecarlo_part}


def command(
    part: Annotated[str | None, typer.Option(help=", ".join(PARTS) + "; all without it")] = None,
    most_rows: Annotated[
        float, typer.Option(metavar="ROWS", help="of the largest file; parts that have none are shorter too")
    ] = 1e7,
    pictures: Annotated[Path | None, typer.Option(metavar="DIR", help="also draw growth_PART.png into this folder")] = None,
) -> None:
    """Measures how time and memory grow."""
    check_choices("--part", [part], PARTS)
    if not 1e4 <= most_rows <= 1e9:
        raise UsageError(f"--most-rows {most_rows:g}: must be 1e4 to 1e9")
    for name, measure in PARTS.items():
        if part in (None, name):
            table, draw = measure(round(most_rows))
            show(table, width=100)
            if pictures is not None:
                draw(pictures / f"growth_{name}.png")
