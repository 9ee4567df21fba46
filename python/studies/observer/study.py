"""The command: which part, and its tables."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Annotated, Any, NamedTuple

import typer
from rich.table import Table

from hnav.cli.console import show
from studies.command import cells, check_choices, titled_table
from studies.observer import bounds, cost, events, hindsight, laws, size, smooth, tank

Rows = Iterable[Mapping[str, Any]]


class Part(NamedTuple):
    """A table: heads of its first column and of its figures, template of a row, and who measures the rows by the number of
    runs."""

    first: str
    figures: str
    row: str
    measured: Callable[[int], Rows]

    def table(self, runs: int) -> Table:
        return titled_table("", self.first, self.figures, cells(self.row, self.measured(runs)))


PARTS = {
    "errors": (
        Part(
            "plant", "NEES/n | NIS | us/sample",
            "{plant} | {nees:.3f} | {nis:.3f} | {us_per_sample:.1f}", lambda runs: smooth.results(runs),
        ),
        Part(
            "plant with events", "NEES/n | rms error | of particles | ratio | parts | us/sample",
            "{plant} | {nees:.3f} | {rms:.4f} | {rms_particles:.4f} | {ratio:.3f} | {parts:.2f} | {us_per_sample:.1f}",
            lambda runs: events.results(runs),
        ),
    ),
    "hindsight": (
        Part(
            "plant, with hindsight", "NEES/n, filter | smoother | rms, filter | smoother | ratio",
            "{plant} | {nees[0]:.3f} | {nees[1]:.3f} | {rms[0]:.4f} | {rms[1]:.4f} | {ratio:.3f}", lambda runs: hindsight.results(runs),
        ),
    ),
    "laws": (
        Part(
            "figure", " | ".join(("right", *laws.KINDS)), " | ".join(("{figure}", "{right}", *(f"{{{kind}:.3g}}" for kind in laws.KINDS))),
            lambda _: laws.results(),
        ),
    ),
    "tank": (
        Part(
            "tank that runs empty", "runs | found again | NEES/n | held | dropped | ready there | ready later, %",
            "{plan} | {runs} | {found} | {nees:.3f} | {held} | {dropped} | {ready_meanwhile} | {ready:.1f}", lambda _: tank.results(),
        ),
    ),
    "bounds": (
        Part(
            "a loss near zero", "NEES/n | rms error, 1/s | estimates below 0, %",
            "{filter} | {nees:.3f} | {rms:.5f} | {negative:.1f}", lambda _: bounds.results(),
        ),
    ),
    "size": (
        Part(
            "rod of so many cells, FMI 2", "ms/sample | memory, MB | NEES/n",
            "{states} | {ms_per_sample:.3f} | {memory_mb:.1f} | {nees:.3f}", lambda _: size.results(),
        ),
    ),
    "cost": (
        Part(
            "plant in C", "instructions | us of CPU, least | median",
            "{case} | {instructions:.0f} | {least_us:.2f} | {median_us:.2f}", lambda _: cost.results(),
        ),
    ),
}  # fmt: skip


def command(
    runs: Annotated[int, typer.Option(min=1, help="Of each plant")] = 50,
    part: Annotated[str | None, typer.Option(help=f"{', '.join(PARTS)}; all without it")] = None,
) -> None:
    """Whether the observer's sigmas are right, and what it costs."""
    check_choices("--part", [part], PARTS)
    for name, tables in PARTS.items():
        if part in (None, name):
            for one in tables:
                show(one.table(runs), width=120)
