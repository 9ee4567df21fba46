"""Many recordings by one command: time beside one by one, memory, and the rate at which tables come.

./run study many [--recordings 1000] [--workers 2]

Writes so many recordings of a minute at 100 Hz into a temporary folder; hnav filter takes them all. Memory is the largest of the process and
of its workers, at a tenth of the recordings and at all of them.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from hnav.cli.console import show
from studies.command import titled_table, tracked
from studies.counting import cost_of_hnav

ROWS, RATE_HZ = 6000, 100.0
ALONE = 5  # recordings that are filtered by a command each, for comparison


def write_recordings(folder: Path, count: int) -> None:
    """A body that turns slowly, with noise that differs from file to file."""
    t_s = np.arange(ROWS) / RATE_HZ
    rng = np.random.default_rng(1)
    turn = 0.5 * np.sin(0.3 * t_s)
    rate = np.stack([0 * t_s, 0 * t_s, 0.15 * np.cos(0.3 * t_s)], axis=1)
    field = np.stack([2e-5 * np.cos(turn), -2e-5 * np.sin(turn), 4.5e-5 + 0 * turn], axis=1)
    for i in tracked(range(count), "recordings"):
        noisy = [rate + 1e-3 * rng.normal(size=rate.shape), [0, 0, -9.81] + 0.02 * rng.normal(size=rate.shape), field]
        table = np.column_stack([t_s, *noisy])
        np.savetxt(folder / f"{i:04d}.csv", table, "%.9g", ",", header="t_s,gx,gy,gz,ax,ay,az,mx,my,mz", comments="")


def command(
    recordings: Annotated[int, typer.Option(min=20, help="Of a minute each")] = 1000,
    workers: Annotated[int, typer.Option(min=1, help="Processes")] = 2,
) -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_recordings(folder, recordings)
        table = titled_table(f"recordings of a minute, {workers} workers", "recordings", "seconds | per recording | memory")
        alone = [cost_of_hnav("filter", folder / f"{i:04d}.csv", "--out", folder / "alone.csv") for i in range(ALONE)]
        (folder / "alone.csv").unlink()
        seconds = [one.wall_s for one in alone]
        table.add_row("one by one, a command each", f"{sum(seconds):.1f} for {ALONE}", f"{np.mean(seconds):.2f} s", "-")
        for count in (recordings // 10, recordings):
            chosen = sorted(folder.glob("*.csv"))[:count]
            cost = cost_of_hnav("filter", *chosen, "--out", folder / f"out{count}", "--workers", workers)
            table.add_row(str(count), f"{cost.wall_s:.1f}", f"{cost.wall_s / count:.3f} s", f"{cost.memory_bytes / 1e6:.0f} MB")
        show(table)
