"""Aiding samples: satellites, pressure, wheels, headings. Each kind has its own time stamps, independent of the rows of a recording."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

AIDS = {
    "position": ("latitude_rad", "longitude_rad", "height_m"),
    "velocity": ("north_m_s", "east_m_s", "down_m_s"),
    "pressure": ("pressure_pa",),
    "speed": ("speed_m_s",),
    "heading": ("heading_rad",),
}
"""Kinds of aids and the columns of their values. Heights are ellipsoidal if the file states it; the vertical velocity may be
NaN; speed is the wheel speed along body x; heading is that of body x, by two antennas."""


@dataclass(frozen=True)
class AidSamples:
    """Samples of one kind."""

    t_s: np.ndarray
    """m: times of validity in s."""
    values: np.ndarray
    """m x 3 or m x 1, columns as in AIDS."""
    sigma: np.ndarray
    """As values: standard deviations (position north, east, down, in m); NaN where the file states none."""
    received_s: np.ndarray | None = None
    """m, not decreasing: when each arrived; None: at t_s."""
    above_sea: bool = False
    """Of positions: the file states that some heights are above sea level, and not how high the geoid is there."""

    def __repr__(self) -> str:
        span = f"; {self.t_s.min():.10g} to {self.t_s.max():.10g} s" if len(self.t_s) else ""
        return f"AidSamples({len(self.t_s)} of {self.values.shape[1]} numbers{span})"

    @property
    def arrived_s(self) -> np.ndarray:
        """m: when each arrived."""
        return self.t_s if self.received_s is None else self.received_s

    def rows(self, keep: np.ndarray) -> AidSamples:
        """The samples at these indices, or those with a true flag."""
        received_s = None if self.received_s is None else self.received_s[keep]
        return AidSamples(self.t_s[keep], self.values[keep], self.sigma[keep], received_s, self.above_sea)

    def without_repeats(self) -> AidSamples:
        """The samples that differ from their predecessor."""
        fresh = np.ones(len(self.t_s), bool)
        fresh[1:] = [not np.array_equal(a, b, equal_nan=True) for a, b in zip(self.values[1:], self.values[:-1])]
        return self.rows(fresh)


class AidsOfFile(dict[str, AidSamples]):
    """By kind, the samples of a file of their own."""

    notes: tuple[str, ...] = ()
    """Choices of the reader: columns left out, quality of the fixes."""


def none_within(t_s: np.ndarray, begin_s: float, end_s: float) -> bool:
    """Whether there are times, and all lie outside: they are of another clock."""
    return bool(len(t_s)) and not ((t_s >= begin_s) & (t_s <= end_s)).any()


def by_arrival(samples: AidSamples) -> AidSamples:
    """The samples in order of arrival."""
    return samples.rows(np.argsort(samples.arrived_s, kind="stable"))


def arrived_within(aids: Mapping[str, AidSamples], after_s: float, until_s: float) -> dict[str, AidSamples]:
    """Samples that arrived after the first time and up to the second; kinds without samples are left out."""
    within = {kind: one.rows((one.arrived_s > after_s) & (one.arrived_s <= until_s)) for kind, one in aids.items()}
    return {kind: one for kind, one in within.items() if len(one.t_s)}
