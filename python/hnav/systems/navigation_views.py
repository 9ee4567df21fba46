"""Errors of position, velocity and heading of the navigation filters in a finished simulation, with the stated sigmas.

The names by which such a filter and its truth are known stand here and nowhere else.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hnav import earth
from hnav.native.arrays import Array
from hnav.systems.results import Run

PLACE = ("latitude", "longitude", "height")
FALSE_RAD = np.radians(5)
ANY_HEADING = 2
"""Phases with an estimate begin with this one."""


def wrapped(angle: Array) -> Array:
    """Angles in (-pi, pi]."""
    return np.asarray(np.pi - np.remainder(np.pi - angle, 2 * np.pi))


def truth_of_place(run: Run) -> str | None:
    """The component that outputs the true position."""
    return next((c for c in run.components if run.has(c, *(f"truth.{name}" for name in PLACE), "truth.euler[3]")), None)


def navigators(run: Run) -> list[Navigator]:
    """The navigation filters of a run, in the order of the system; none in a run without the true position."""
    if truth_of_place(run) is None:
        return []
    wanted = (*(f"nav.{name}" for name in PLACE), "nav.sigma_position[3]", "att.heading", "att.sigma[3]", "align.phase")
    return [Navigator(run, c) for c in run.components if run.has(c, *wanted)]


@dataclass(frozen=True)
class Navigator:
    """One filter beside the truth; NaN in rows without an estimate."""

    run: Run
    name: str

    @cached_property
    def known(self) -> np.ndarray:
        """n: whether there is an estimate."""
        return self.run[f"{self.name}.align.phase"] >= ANY_HEADING

    def _where_known(self, values: Array) -> Array:
        return np.where(self.known if values.ndim == 1 else self.known[:, None], values, np.nan)

    def _place(self, component: str, group: str) -> Array:
        return np.column_stack([self.run[f"{component}.{group}.{name}"] for name in PLACE])

    @property
    def truth(self) -> str:
        """For navigators there is a truth."""
        component = truth_of_place(self.run)
        assert component is not None
        return component

    @cached_property
    def off_m(self) -> Array:
        """n x 3: estimate minus truth, north, east, down."""
        true = self._place(self.truth, "truth")
        off = earth.position_of(self._place(self.name, "nav")) - earth.position_of(true)
        return self._where_known(np.einsum("nij,ni->nj", earth.axes_at(true), off))

    @cached_property
    def sigma_m(self) -> Array:
        """n x 3: stated sigmas."""
        return self._where_known(self.run.vector(self.name, "nav.sigma_position", 3))

    @cached_property
    def heading_off_rad(self) -> Array:
        """n: estimate minus truth, in (-pi, pi]. Corrected for the convergence of the meridians between the estimated and the
        true position, which is significant near a pole.
        """
        off = self.run[f"{self.name}.att.heading"] - self.run[f"{self.truth}.truth.euler[3]"]
        east = wrapped(self.run[f"{self.name}.nav.longitude"] - self.run[f"{self.truth}.truth.longitude"])
        return self._where_known(wrapped(off - east * np.sin(self.run[f"{self.truth}.truth.latitude"])))

    @cached_property
    def heading_sigma_rad(self) -> Array:
        """n: the stated sigma, up to that of the whole circle."""
        return self._where_known(self.run[f"{self.name}.att.sigma[3]"])

    @cached_property
    def ready_row(self) -> int | None:
        """The first row with a ready heading; None if there is none."""
        rows = np.flatnonzero(self.run[f"{self.name}.align.heading_ready"] > 0.5)
        return int(rows[0]) if len(rows) else None

    @property
    def ready_s(self) -> float:
        """Time in s at which the heading is ready; NaN if never."""
        return np.nan if self.ready_row is None else float(self.run.t_s[self.ready_row])

    @property
    def is_false(self) -> bool:
        """Whether a ready heading had an error above three sigma and five degrees."""
        if self.ready_row is None:
            return False
        off, sigma = abs(self.heading_off_rad[self.ready_row]), self.heading_sigma_rad[self.ready_row]
        return bool(off > max(3 * sigma, FALSE_RAD))

    @cached_property
    def figures(self) -> dict[str, float]:
        """Of the whole run; angles in deg. A squared error over its variance is normalised; the position's is the mean of three."""
        rows = slice(self.ready_row, None)
        level_m, sigma_m = (np.hypot(of[rows, 0], of[rows, 1]) for of in (self.off_m, self.sigma_m))
        normalised = (self.off_m[-1] / self.sigma_m[-1]) ** 2
        ready = self.ready_row is not None
        return {
            "heading_ready_s": self.ready_s,
            "false_ready": float(self.is_false),
            "heading_end_deg": float(np.degrees(self.heading_off_rad[-1])),
            "heading_end_sigma_deg": float(np.degrees(self.heading_sigma_rad[-1])),
            "heading_z2": float((self.heading_off_rad[-1] / self.heading_sigma_rad[-1]) ** 2),
            "position_end_m": float(np.hypot(*self.off_m[-1, :2])),
            "position_z2": float(np.mean(normalised)),
            "position_worst_m": float(level_m.max()) if ready else np.nan,
            "position_within_3_sigma": float(np.mean(level_m <= 3 * sigma_m)) if ready else np.nan,
        }
