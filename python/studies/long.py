"""Do error and memory of a filter stay constant for a month? Simulated days at 100 Hz, with stamps of today's clocks.

    ./run study long --days 30 [--filter ahrs]

A body turns about all axes; its sensors are those of a telephone, the bias of the gyroscope walks by the hour. Stamps begin at
1.7e9 s, where doubles lie a quarter of a microsecond apart. Printed for every day: error and memory of the process. The exit
status is 1 when they are not flat: a day whose error is a fifth above that of the first; memory of which the least in the last
third of the days is more than 4 MB above that in the first.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray
from rich.table import Table

from hnav.cli.console import say, show
from hnav.cli.parameters import FilterName
from hnav.filters.attitude import Filter
from hnav.rotations import quaternion_of_euler, rotated, rotation_error_rad
from studies.command import tracked

PERIOD_S = 1000  # after which the motion repeats
INTERVAL_S = 0.01
GYRO_SIGMA, FORCE_SIGMA, FIELD_SIGMA = 2e-3, 0.05, 3e-7  # of a sample, SI
BIAS_SIGMA, BIAS_TIME_S = 2e-3, 3600.0
GRAVITY, FIELD = np.array([0, 0, -9.81]), np.array([2.0e-5, 0, 4.5e-5])  # specific force at rest and field, north-east-down
SETTLED_S = 600  # from when on errors count
MORE_ERROR, MORE_MEMORY_MB = 1.2, 4.0


@dataclass(frozen=True)
class Day:
    """rms_deg, worst_deg: the total error; memory_mb: of the process at the day's end."""

    rms_deg: float
    worst_deg: float
    memory_mb: float


class Motion:
    """One period: attitude, rate, force and field of 100 000 instants. Row 0 follows the last one."""

    def __init__(self) -> None:
        turns = 2 * np.pi * np.arange(round(PERIOD_S / INTERVAL_S)) * INTERVAL_S / PERIOD_S
        roll = 0.5 * np.sin(97 * turns) + 0.3 * np.sin(331 * turns)
        pitch = 0.6 * np.sin(61 * turns + 1) + 0.2 * np.sin(419 * turns)
        yaw = 3 * turns + 1.5 * np.sin(43 * turns) + 0.3 * np.sin(257 * turns)
        self.q_nb = quaternion_of_euler(np.stack([roll, pitch, yaw], axis=1))
        to_body, before = self.q_nb * [1, -1, -1, -1], np.roll(self.q_nb, 1, axis=0)
        # The mean rate of the interval before: what an integrating gyroscope gives.
        self.rate = rotation_error_rad(to_body, before * [1, -1, -1, -1]) / INTERVAL_S
        self.force, self.field = rotated(to_body, GRAVITY), rotated(to_body, FIELD)


def memory_mb() -> float:
    """Of this process; NaN where the system does not report it."""
    status = Path("/proc/self/status")
    if not status.is_file():
        return float("nan")
    return next(float(line.split()[1]) for line in status.read_text().splitlines() if line.startswith("VmRSS:")) / 1024


def errors_rad(filter: Filter, periods: int, start_s: float, seed: int) -> Iterator[NDArray[np.float64]]:
    """Of the instants of each period: the angle between estimate and truth."""
    motion, random = Motion(), np.random.default_rng(seed)
    rows = len(motion.rate)
    bias, keep = random.normal(0, BIAS_SIGMA, 3), np.exp(-PERIOD_S / BIAS_TIME_S)
    for period in range(periods):
        t_s = start_s + (np.arange(rows) + period * rows) * INTERVAL_S
        goal = keep * bias + np.sqrt(1 - keep**2) * random.normal(0, BIAS_SIGMA, 3)
        drift = bias + np.linspace(0, 1, rows)[:, None] * (goal - bias)
        bias = goal
        readings = (
            motion.rate + drift + random.normal(0, GYRO_SIGMA, (rows, 3)),
            motion.force + random.normal(0, FORCE_SIGMA, (rows, 3)),
            motion.field + random.normal(0, FIELD_SIGMA, (rows, 3)),
        )
        run = filter.run(t_s, *readings, only=("q_nb",))
        yield np.linalg.norm(rotation_error_rad(run.q_nb, motion.q_nb), axis=1)


def days_of(filter: Filter, days: float, start_s: float = 1.7e9, seed: int = 1) -> Iterator[Day]:
    """Day after day, the last one maybe shorter."""
    periods = max(1, round(days * 86400 / PERIOD_S))
    ends = {round(day * 86400 / PERIOD_S) for day in range(1, int(days) + 1)} | {periods}
    squares, worst, count = 0.0, 0.0, 0
    for period, error in enumerate(errors_rad(filter, periods, start_s, seed)):
        settled = error[round(SETTLED_S / INTERVAL_S) :] if period == 0 else error
        squares, worst, count = squares + float(settled @ settled), max(worst, float(np.max(settled))), count + len(settled)
        if period + 1 in ends:
            yield Day(float(np.degrees(np.sqrt(squares / count))), float(np.degrees(worst)), memory_mb())
            squares, worst, count = 0.0, 0.0, 0


def is_flat(days: list[Day]) -> bool:
    """Whether no day is worse than the first by more than chance, and memory does not grow.

    Arrays of a period are freed between two measurements of the memory; retained memory shows in the minimum over many days.
    """
    third = max(1, len(days) // 3)
    begin, end = (min(day.memory_mb for day in some) for some in (days[:third], days[-third:]))
    return all(day.rms_deg <= MORE_ERROR * days[0].rms_deg for day in days) and not end > begin + MORE_MEMORY_MB


def command(
    days: Annotated[float, typer.Option(min=0.01, help="Simulated days; one takes about half a minute")] = 30,
    filter: FilterName = "ahrs",
    seed: int = 1,
) -> None:
    """Prints error and memory of every day; the exit status is 1 when they are not flat."""
    made = Filter(filter, gyro_hold="backward", solver="closed_form")
    table = Table("day", "rms error, deg", "worst, deg", "memory, MB", title=f"{filter}, 100 Hz from t = 1.7e9 s, closed form")
    found: list[Day] = []
    for day in tracked(days_of(made, days, seed=seed), "days", days):
        found.append(day)
        table.add_row(f"{len(found)}", f"{day.rms_deg:.3f}", f"{day.worst_deg:.2f}", f"{day.memory_mb:.1f}")
    show(table)
    say("flat" if is_flat(found) else "NOT flat")
    if not is_flat(found):
        raise typer.Exit(1)
