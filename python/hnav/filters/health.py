"""What a run says of its sensors, in words: which were not ok, and for how long.

for finding in findings(run.t_s, run.health): print(finding)            # gyro saturated for 4.2 s, from 12.3 s on
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hnav.filters.attitude import HEALTH_SENSORS, SENSOR_STATES
from hnav.native.arrays import Array

LONGEST_ROW_S = 1.0  # no row stands for more: what happened in a gap is not known
STARTING_S = 1.0  # a sensor that is missing for less has not sent its first sample yet


@dataclass(frozen=True)
class Finding:
    """A sensor was in a state other than ok."""

    sensor: str
    """gyro, accel or mag."""
    state: str
    """One of SENSOR_STATES."""
    lasted_s: float
    """In all."""
    first_s: float
    """Time of the first row in this state."""

    def __str__(self) -> str:
        return f"{self.sensor} {self.state} for {self.lasted_s:.1f} s, from {self.first_s:.1f} s on"


def findings(t_s: Array, health: npt.NDArray[np.integer]) -> list[Finding]:
    """By sensor, the longest state first. t_s: n; health: n x 3 as Run.health.

    A sensor of which no row has anything is not there, and no finding; nor is one that sends its first sample within a second.
    """
    lasts_s = np.minimum(np.diff(t_s, append=t_s[-1:]), LONGEST_ROW_S).clip(0)
    missing = SENSOR_STATES.index("missing")
    found: list[Finding] = []
    for name, states in zip(HEALTH_SENSORS, health.T):
        if (states == missing).all():
            continue
        of_sensor = [
            Finding(name, state, float(lasts_s[rows].sum()), float(t_s[np.argmax(rows)]))
            for number, state in enumerate(SENSOR_STATES)
            if number and (rows := states == number).any()
        ]
        found += sorted(of_sensor, key=lambda finding: -finding.lasted_s)
    return [f for f in found if f.state != SENSOR_STATES[missing] or f.lasted_s > STARTING_S]


def spells(t_s: Array, states: npt.NDArray[np.integer]) -> Iterator[tuple[str, float, float]]:
    """(state, begin, end) of each stretch of rows in which a sensor is in one state other than ok; t_s, states: n."""
    begins = np.flatnonzero(np.diff(states, prepend=-1))
    for begin, end in zip(begins, [*begins[1:], len(t_s) - 1]):
        if states[begin]:
            yield SENSOR_STATES[states[begin]], float(t_s[begin]), float(t_s[end])
