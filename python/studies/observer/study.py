"""The command: which part, and its tables."""

from __future__ import annotations

from typing import Annotated

import typer
from rich.table import Column, Table

from hnav.cli.console import show
from studies.command import check_choices
from studies.observer import bounds, cost, events, hindsight, laws, size, smooth, tank


def command(
    runs: Annotated[int, typer.Option(min=1, help="Of each plant")] = 50,
    part: Annotated[str | None, typer.Option(help="errors, hindsight, laws, tank, bounds, size or cost")] = None,
) -> None:
    """Whether the observer's sigmas are right, and what it costs."""
    check_choices("--part", [part], ("errors", "hindsight", "laws", "tank", "bounds", "size", "cost"))
    if part in (None, "errors"):
        show(smooth_table(runs))
        show(events_table(runs), width=120)
    if part in (None, "hindsight"):
        show(hindsight_table(runs), width=120)
    if part in (None, "laws"):
        show(laws_table(), width=120)
    if part in (None, "tank"):
        show(tank_table(), width=120)
    if part in (None, "bounds"):
        show(bounds_table())
    if part in (None, "size"):
        show(size_table())
    if part in (None, "cost"):
        show(cost_table())


def table_of(first: str, *figures: str) -> Table:
    return Table(first, *(Column(name, justify="right") for name in figures))


def smooth_table(runs: int) -> Table:
    table = table_of("plant", "NEES/n", "NIS", "us/sample")
    for r in smooth.results(runs):
        table.add_row(r.plant, f"{r.nees:.3f}", f"{r.nis:.3f}", f"{r.us_per_sample:.1f}")
    return table


def events_table(runs: int) -> Table:
    table = table_of("plant with events", "NEES/n", "rms error", "of particles", "ratio", "parts", "us/sample")
    for e in events.results(runs):
        figures = f"{e.nees:.3f}", f"{e.rms:.4f}", f"{e.rms_particles:.4f}", f"{e.rms / e.rms_particles:.3f}", f"{e.parts:.2f}"
        table.add_row(e.plant, *figures, f"{e.us_per_sample:.1f}")
    return table


def hindsight_table(runs: int) -> Table:
    table = table_of("plant, with hindsight", "NEES/n, filter", "smoother", "rms, filter", "smoother", "ratio")
    for r in hindsight.results(runs):
        figures = [f"{value:.3f}" for value in r.nees] + [f"{value:.4f}" for value in r.rms] + [f"{r.rms[1] / r.rms[0]:.3f}"]
        table.add_row(r.plant, *figures)
    return table


def laws_table() -> Table:
    table = table_of("figure", "right", *laws.KINDS)
    for law in laws.results():
        table.add_row(law.figure, law.right, *(f"{law.by_kind[kind]:.3g}" if kind in law.by_kind else "-" for kind in laws.KINDS))
    return table


def tank_table() -> Table:
    table = table_of("tank that runs empty", "runs", "found again", "NEES/n", "held", "dropped", "ready there", "ready later, %")
    for r in tank.results():
        counts = (str(count) for count in (r.held, r.dropped, r.ready_meanwhile))
        table.add_row(r.plan, str(r.runs), str(r.found), f"{r.nees:.3f}", *counts, f"{100 * r.ready:.1f}")
    return table


def bounds_table() -> Table:
    table = table_of("a loss near zero", "NEES/n", "rms error, 1/s", "estimates below 0, %")
    for r in bounds.results():
        table.add_row(r.filter, f"{r.nees:.3f}", f"{r.rms:.5f}", f"{100 * r.negative:.1f}")
    return table


def size_table() -> Table:
    table = table_of("rod of so many cells, FMI 2", "ms/sample", "memory, MB", "NEES/n")
    for r in size.results():
        table.add_row(str(r.states), f"{r.ms_per_sample:.3f}", f"{r.memory_mb:.1f}", f"{r.nees:.3f}")
    return table


def cost_table() -> Table:
    table = table_of("plant in C", "instructions", "us of CPU, least", "median")
    for c in cost.results():
        table.add_row(
            c.case, "-" if c.instructions is None else f"{c.instructions:.0f}", f"{c.least_us:.2f}", f"{c.median_us:.2f}"
        )
    return table
