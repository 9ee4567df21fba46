"""States of the sensors of a run, in words: which were not ok, and for how long.

for finding in findings(run.t_s, run.health): print(finding)            # gyro saturated for 4.2 s, from 12.3 s on
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hnav.filters.filter_answers import HEALTH_SENSORS, SENSOR_STATES
from hnav.native.arrays import Array

LONGEST_ROW_S = 1.0  # longest time that a row counts for: the state during a gap is unknown
STARTING_S = 1.0  # a sensor that is missing for a shorter time has not sent its first sample yet


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

    A sensor of which no row has anything is not there, and no finding; nor is a sensor whose first sample comes within a second.
    """
    tally = Tally()
    tally.add(t_s, health)
    return tally.findings()


class Tally:
    """The findings of a run that comes in pieces."""

    def __init__(self) -> None:
        shape = len(HEALTH_SENSORS), len(SENSOR_STATES)
        self._lasted_s, self._first_s = np.zeros(shape), np.full(shape, np.nan)
        self._last: tuple[float, npt.NDArray[np.integer]] | None = None  # time and states of the newest row

    def add(self, t_s: Array, health: npt.NDArray[np.integer]) -> None:
        """t_s: n, 1 or more; health: n x 3. They go on from the rows of the last call."""
        if self._last is not None:
            before_s, states = self._last
            self._lasted_s[np.arange(len(states)), states] += min(max(float(t_s[0]) - before_s, 0.0), LONGEST_ROW_S)
        lasts_s = np.minimum(np.diff(t_s, append=t_s[-1:]), LONGEST_ROW_S).clip(0)
        for sensor, states in enumerate(health.T):
            for state in np.unique(states):
                rows = states == state
                self._lasted_s[sensor, state] += lasts_s[rows].sum()
                if np.isnan(self._first_s[sensor, state]):
                    self._first_s[sensor, state] = t_s[np.argmax(rows)]
        self._last = float(t_s[-1]), health[-1]

    def findings(self) -> list[Finding]:
        """As of the whole run."""
        missing = SENSOR_STATES.index("missing")
        found: list[Finding] = []
        for name, lasted_s, first_s in zip(HEALTH_SENSORS, self._lasted_s, self._first_s):
            seen = np.flatnonzero(~np.isnan(first_s))
            if [*seen] == [missing]:
                continue
            of_sensor = [
                Finding(name, SENSOR_STATES[state], float(lasted_s[state]), float(first_s[state])) for state in seen if state
            ]
            found += sorted(of_sensor, key=lambda finding: -finding.lasted_s)
        return [f for f in found if f.state != SENSOR_STATES[missing] or f.lasted_s > STARTING_S]


def spells(t_s: Array, states: npt.NDArray[np.integer]) -> Iterator[tuple[str, float, float]]:
    """(state, begin, end) of each stretch of rows in which a sensor is in one state other than ok; t_s, states: n."""
    begins = np.flatnonzero(np.diff(states, prepend=-1))
    for begin, end in zip(begins, [*begins[1:], len(t_s) - 1]):
        if states[begin]:
            yield SENSOR_STATES[states[begin]], float(t_s[begin]), float(t_s[end])
