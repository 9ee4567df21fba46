"""Errors by hnav compare beside those of evo (Grupp 2017) on the same files: three pairs of trajectories.

    ./run study evo_peer

evo is under the GPL: it is installed by the extra `peers`, and runs as a process of its own.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from hnav.cli.console import say, show
from hnav.cli.words import UsageError
from hnav.io.trajectories import read_trajectory
from hnav.native.arrays import Array
from hnav.reports.comparison import Comparison, compare
from studies.command import titled_table, tracked
from studies.ins.motions import turned_on

PAIRS = 3
RATE_HZ, DURATION_S = 100, 20.0
DELTA_S = 0.5


class Row(NamedTuple):
    """Of one error of one pair: root mean square, median and largest, in deg or m."""

    pair: int
    error: str
    ours: Array
    evo: Array


def motion(seed: int, duration_s: float = 60.0) -> tuple[Array, Rotation, Array]:
    """Times at 100 Hz, attitude, and a way along the body's x axis."""
    rng = np.random.default_rng(seed)
    t_s = np.arange(0, duration_s, 1 / RATE_HZ)
    waves = [rng.normal(size=3) * np.sin(rng.uniform(0.3, 4) * t_s[:, None] + rng.uniform(0, 6, 3)) for _ in range(3)]
    attitude = turned_on(Rotation.identity(), Rotation.from_rotvec(np.sum(waves, axis=0)[:-1] / RATE_HZ))
    return t_s, attitude, np.cumsum(attitude.apply([1, 0, 0]), axis=0) / RATE_HZ


def noisy(seed: int, attitude: Rotation, position: Array) -> tuple[Rotation, Array]:
    """Noise of 0.3 deg, and a walk of the place."""
    rng = np.random.default_rng(seed)
    n = len(position)
    walk = np.cumsum(0.001 * rng.normal(size=(n, 3)), axis=0)
    return attitude * Rotation.from_rotvec(np.radians(0.3) * rng.normal(size=(n, 3))), position + walk


def tum(path: Path, t_s: Array, attitude: Rotation, position: Array) -> Path:
    """Writes a trajectory."""
    np.savetxt(path, np.column_stack([t_s, position, attitude.as_quat()]), fmt="%.12g")
    return path


def command_of_evo(tool: str) -> str:
    """Its path. Raises UsageError where evo is not installed."""
    found = shutil.which(f"evo_{tool}", path=str(Path(sys.executable).parent))
    if found is None:
        raise UsageError("evo is not installed: python -m pip install evo (the extra 'peers')")
    return found


def rows_of(pair: int, folder: Path) -> Iterator[Row]:
    """The third pair has another scale. Raises UsageError where evo is not installed."""
    t_s, attitude, position = motion(pair, DURATION_S)
    turned, moved = noisy(pair, attitude, position)
    scaled = pair == PAIRS - 1
    moved = Rotation.from_rotvec([0.1, 0.2, 0.4]).apply(moved) * (1.3 if scaled else 1) + [3, 4, 5]
    true, mine = tum(folder / "true.txt", t_s, attitude, position), tum(folder / "mine.txt", t_s, turned, moved)
    plain, placed = (
        compare(read_trajectory(true), read_trajectory(mine), align=chosen, delta_s=DELTA_S)
        for chosen in ((), ("scale" if scaled else "place",))
    )
    relative = ["--delta", f"{RATE_HZ * DELTA_S:.0f}", "--delta_unit", "f"]

    def of(found: Comparison, name: str, shown: str, tool: str, *options: str) -> Row:
        figure = next(figure for figure in found.figures if figure.name == name)
        arguments = [command_of_evo(tool), "tum", str(true), str(mine), *options]
        printed = subprocess.run(arguments, capture_output=True, text=True, check=True).stdout
        theirs = {key: float(value) for key, value in re.findall(r"^\s*(\w+)\s+([\d.]+)$", printed, re.MULTILINE)}
        ours = np.array([figure.rms, figure.median, figure.worst])
        return Row(pair + 1, shown, ours, np.array([theirs["rmse"], theirs["median"], theirs["max"]]))

    yield of(plain, "attitude", "attitude, deg", "ape", "-r", "angle_deg")
    yield of(plain, "position", "position, m", "ape", "-r", "trans_part")
    aligned = f"position after Umeyama{' with scale' if scaled else ''}, m"
    yield of(placed, "position", aligned, "ape", "-r", "trans_part", "-as" if scaled else "-a")
    yield of(plain, f"attitude relative, {DELTA_S:g} s", "attitude relative, deg", "rpe", "-r", "angle_deg", *relative)
    yield of(plain, f"position relative, {DELTA_S:g} s", "position relative, m", "rpe", "-r", "trans_part", *relative)


def command() -> None:
    """Compares three pairs of files by both."""
    table = titled_table("root mean square | median | largest", "pair | error", "hnav | evo | difference")
    worst = 0.0
    with tempfile.TemporaryDirectory() as name:
        for pair in tracked(range(PAIRS), "pairs"):
            for row in rows_of(pair, Path(name)):
                difference = float(np.abs(row.ours - row.evo).max())
                worst = max(worst, difference)
                figures = (", ".join(f"{v:.6f}" for v in of) for of in (row.ours, row.evo))
                table.add_row(str(row.pair), row.error, *figures, f"{difference:.1e}")
    show(table, width=140)
    say(f"largest difference {worst:.1e}")
