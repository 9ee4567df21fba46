"""The command: which parts, up to what size, their tables and pictures."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Column, Table

from hnav.cli.console import show
from hnav.cli.words import UsageError
from hnav.reports import plots
from hnav.reports.colours import BLUE
from studies.command import check_choices
from studies.growth import measures

SIZE_PX = (700, 320)


def draw_lines(
    path: Path, x: Sequence[float], panels: Mapping[str, Sequence[float]], name: str, logarithmic: bool = True
) -> None:
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


def draw_bars(path: Path, names: Sequence[str], values: Sequence[float], label: str) -> None:
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


def table_of(title: str, first: str, *columns: str) -> Table:
    rest = (Column(name, justify="right", min_width=12) for name in columns)
    return Table(first, *rest, title=title, title_justify="left", min_width=70)


def rows_part(most_rows: int) -> tuple[Table, Draw]:
    sizes = [size for size in (10**power for power in range(4, 10)) if size <= most_rows]
    # The smallest says what it takes to begin.
    start, *found = measures.of_rows([1000, *sizes])
    each = [1e6 * (one.cpu_s - start.cpu_s) / (one.rows - start.rows) for one in found]
    table = table_of("hnav filter on a table of text, into another", "rows", "CPU s", "us a row", "memory, MB")
    for one, us in zip(found, each):
        table.add_row(f"{one.rows}", f"{one.cpu_s:.1f}", f"{us:.1f}", f"{one.memory_mb:.0f}")
    panels = {"us a row": each, "memory, MB": [one.memory_mb for one in found]}
    return table, lambda path: draw_lines(path, [one.rows for one in found], panels, "rows")


def filters_part(most_rows: int) -> tuple[Table, Draw]:
    found = [*measures.of_filters((1, 10, 100, 1000), samples=min(200_000, most_rows))]
    table = table_of("AHRS in closed form side by side, ten rows in turn", "filters", "us a sample", "kB a filter")
    for one in found:
        table.add_row(f"{one.filters}", f"{one.us_per_sample:.2f}", f"{one.kb_per_filter:.0f}" if one.filters >= 100 else "")
    panels = {"us a sample": [one.us_per_sample for one in found]}
    return table, lambda path: draw_lines(path, [one.filters for one in found], panels, "filters")


def late_part(most_rows: int) -> tuple[Table, Draw]:
    found = [*measures.of_age((0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 0.9), rows=min(6000, most_rows))]
    table = table_of("A field that comes late, samples at 100 Hz", "late by, s", "us more than in time", "us for each row since")
    for one in found:
        us = one.us_per_late_sample
        table.add_row(f"{one.late_s:g}", f"{us:.1f}", f"{us / round(one.late_s / measures.INTERVAL_S):.2f}")
    panels = {"us more than in time": [max(0.0, one.us_per_late_sample) for one in found]}
    return table, lambda path: draw_lines(path, [one.late_s for one in found], panels, "late by, s", logarithmic=False)


def montecarlo_part(most_rows: int) -> tuple[Table, Draw]:
    # A run of a minute has 6000 rows.
    runs, stop_s = (10, None) if most_rows >= 10 * 6000 else (2, 0.5)
    found = [*measures.of_workers(runs, (1, 2), stop_s)]
    table = table_of("Monte Carlo of the turntable system, scenario nominal, 60 s", "", "runs a second", "of each worker")
    for one in found:
        table.add_row(one.how, f"{one.runs_per_s:.2f}", f"{one.per_worker:.2f}")
    return table, lambda path: draw_bars(
        path, [one.how for one in found], [one.per_worker for one in found], "runs a second and worker"
    )


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
