"""Whether the bounds that hnav noise states hold: sensors at rest with known white noise, 1/f noise and random walk.

./run study noise [DIR] [--sensors 200] [--minutes 10]

Then one sensor of each grade by recordings of ten minutes and of six hours, and the chip of BROAD by the still parts of its trials.
"""

from __future__ import annotations

from typing import Annotated

import numpy as np
import typer
from rich.table import Table

from hnav.cli.console import say, show
from hnav.cli.noise import figures_table, untold
from hnav.filters.noise import TERMS, noise_of
from hnav.io.readers import read
from hnav.io.readers.broad import find_trials
from hnav.io.recordings import Recording
from hnav.native.arrays import Array
from studies.command import Trials, titled_table, tracked

DEG = np.pi / 180
GRADES = {"consumer": (7e-3 * DEG, 10 * DEG / 3600, 20 * DEG / 3600 / 60), "industrial": (3e-3 * DEG, 5 * DEG / 3600, 5 * DEG / 3600 / 60),
          "wandering": (2e-3 * DEG, 15 * DEG / 3600, 150 * DEG / 3600 / 60)}  # fmt: skip
"""Of gyroscopes: rad/s/sqrt(Hz), rad/s, rad/s/sqrt(s)."""
LENGTHS_S = {"10 min": 600.0, "6 h": 6 * 3600.0}


def noise(rng: np.random.Generator, n: int, interval_s: float, white: float, instability: float, walk: float) -> Array:
    """n x 3: white noise, a walk, and 1/f noise of the one-sided density B^2 / (pi f), whose Allan variance is (2 ln 2 / pi) B^2."""
    frequency = np.fft.rfftfreq(2 * n, interval_s)
    density = np.zeros_like(frequency)
    density[1:] = instability**2 / np.pi / frequency[1:]
    spectrum = (rng.normal(size=(3, n + 1)) + 1j * rng.normal(size=(3, n + 1))) * np.sqrt(density * 2 * n / interval_s / 4)
    flicker = np.fft.irfft(spectrum, axis=1)[:, :n].T
    walked = np.cumsum(walk * np.sqrt(interval_s) * rng.normal(size=(n, 3)), axis=0)
    return np.asarray(white / np.sqrt(interval_s) * rng.normal(size=(n, 3)) + walked + flicker)


def at_rest(seed: int, grade: str, duration_s: float, rate_hz: float = 100.0) -> Recording:
    rng = np.random.default_rng(seed)
    n = round(duration_s * rate_hz)
    force = [0, 0, -9.81] + noise(rng, n, 1 / rate_hz, 1.5e-3, 5e-4, 1e-5)
    return Recording(grade, np.arange(n) / rate_hz, noise(rng, n, 1 / rate_hz, *GRADES[grade]) + 0.01, force)


def bounds(grade: str, sensors: int, duration_s: float) -> dict[str, tuple[float, float, float]]:
    """By name of the parameter, over sensors and axes: shares of the true values that lie within 95 % and of those of which more
    than an upper limit is stated, and the median of the estimates over the true value."""
    found = [noise_of([at_rest(seed, grade, duration_s)])["gyro"].terms for seed in range(sensors)]
    made = {}
    for name, true in zip(TERMS, GRADES[grade]):
        parts = ("low", "high", "value", "is_measured")
        low, high, value, stated = (np.array([getattr(terms[name], part) for terms in found]) for part in parts)
        made[name] = float(np.mean((low <= true) & (true <= high))), float(stated.mean()), float(np.median(value) / true)
    return made


def by_length() -> Table:
    """A row for each grade, parameter and length: the true value, and for the first axis its estimate with its bounds, or an upper limit."""
    title = "one gyroscope of each grade, axis x, SI units"
    table = titled_table(title, "grade | parameter | recording", "true | estimate | 95 %")
    for grade, true in GRADES.items():
        found = {length: noise_of([at_rest(0, grade, length_s)])["gyro"].terms for length, length_s in LENGTHS_S.items()}
        for name, value in zip(TERMS, true):
            for length, terms in found.items():
                low, high = terms[name].low[0], terms[name].high[0]
                stated = f"{terms[name].value[0]:.3g}" if terms[name].is_measured[0] else f"< {high:.3g}"
                table.add_row(grade, name, length, f"{value:.3g}", stated, f"{low:.3g} to {high:.3g}")
    return table


def command(
    folder: Trials = None,
    sensors: Annotated[int, typer.Option(min=1, help="Of each grade")] = 200,
    minutes: Annotated[float, typer.Option(min=1.0, help="Of each recording")] = 10.0,
) -> None:
    table = Table(
        "grade", "parameter", "bounds hold", "more than a limit", "median / true", title=f"{sensors} gyroscopes, {minutes:g} min"
    )
    for grade in tracked(GRADES, "grades"):
        for name, (held, stated, ratio) in bounds(grade, sensors, 60 * minutes).items():
            table.add_row(grade, name, f"{held:.1%}", f"{stated:.0%}", f"{ratio:.2f}")
    show(table)
    show(by_length())
    if folder is not None:
        of_trials = noise_of([read(path) for path in find_trials(folder).values()])
        show(figures_table(of_trials, "BROAD: still parts of all trials"))
        for line in untold(of_trials):
            say(line)
