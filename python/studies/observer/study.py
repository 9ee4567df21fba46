"""The command: which part, and its tables."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Annotated

import typer
from rich.table import Table

from hnav.cli.console import show
from studies.command import check_choices, titled_table
from studies.observer import bounds, cost, events, hindsight, laws, size, smooth, tank


def smooth_table(runs: int) -> Table:
    rows = ((r.plant, f"{r.nees:.3f}", f"{r.nis:.3f}", f"{r.us_per_sample:.1f}") for r in smooth.results(runs))
    return titled_table("", "plant", "NEES/n | NIS | us/sample", rows)


def events_table(runs: int) -> Table:
    rows = (
        (e.plant, f"{e.nees:.3f}", f"{e.rms:.4f}", f"{e.rms_particles:.4f}", f"{e.rms / e.rms_particles:.3f}", f"{e.parts:.2f}",
         f"{e.us_per_sample:.1f}")
        for e in events.results(runs)
    )  # fmt: skip
    return titled_table("", "plant with events", "NEES/n | rms error | of particles | ratio | parts | us/sample", rows)


def hindsight_table(runs: int) -> Table:
    rows = (
        (r.plant, *(f"{value:.3f}" for value in r.nees), *(f"{value:.4f}" for value in r.rms), f"{r.rms[1] / r.rms[0]:.3f}")
        for r in hindsight.results(runs)
    )
    return titled_table("", "plant, with hindsight", "NEES/n, filter | smoother | rms, filter | smoother | ratio", rows)


def laws_table() -> Table:
    rows = (
        (law.figure, law.right, *(f"{law.by_kind[kind]:.3g}" if kind in law.by_kind else "-" for kind in laws.KINDS))
        for law in laws.results()
    )
    return titled_table("", "figure", " | ".join(("right", *laws.KINDS)), rows)


def tank_table() -> Table:
    heads = "runs | found again | NEES/n | held | dropped | ready there | ready later, %"
    rows = (
        (r.plan, *map(str, (r.runs, r.found, f"{r.nees:.3f}", r.held, r.dropped, r.ready_meanwhile)), f"{100 * r.ready:.1f}")
        for r in tank.results()
    )
    return titled_table("", "tank that runs empty", heads, rows)


def bounds_table() -> Table:
    rows = ((r.filter, f"{r.nees:.3f}", f"{r.rms:.5f}", f"{100 * r.negative:.1f}") for r in bounds.results())
    return titled_table("", "a loss near zero", "NEES/n | rms error, 1/s | estimates below 0, %", rows)


def size_table() -> Table:
    rows = ((str(r.states), f"{r.ms_per_sample:.3f}", f"{r.memory_mb:.1f}", f"{r.nees:.3f}") for r in size.results())
    return titled_table("", "rod of so many cells, FMI 2", "ms/sample | memory, MB | NEES/n", rows)


def cost_table() -> Table:
    rows = (
        (c.case, "-" if c.instructions is None else f"{c.instructions:.0f}", f"{c.least_us:.2f}", f"{c.median_us:.2f}")
        for c in cost.results()
    )
    return titled_table("", "plant in C", "instructions | us of CPU, least | median", rows)


PARTS: dict[str, Callable[[int], Sequence[Table]]] = {
    "errors": lambda runs: (smooth_table(runs), events_table(runs)),
    "hindsight": lambda runs: (hindsight_table(runs),),
    "laws": lambda _: (laws_table(),),
    "tank": lambda _: (tank_table(),),
    "bounds": lambda _: (bounds_table(),),
    "size": lambda _: (size_table(),),
    "cost": lambda _: (cost_table(),),
}


def command(
    runs: Annotated[int, typer.Option(min=1, help="Of each plant")] = 50,
    part: Annotated[str | None, typer.Option(help=f"{', '.join(PARTS)}; all without it")] = None,
) -> None:
    """Whether the observer's sigmas are right, and what it costs."""
    check_choices("--part", [part], PARTS)
    for name, tables in PARTS.items():
        if part in (None, name):
            for table in tables(runs):
                show(table, width=120)
