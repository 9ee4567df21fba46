"""The recorded flight: starts in the air, judged by the aeroplane's own filter."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hnav.filters.ins import Aids, Ins
from hnav.systems.navigation_views import FALSE_RAD, wrapped

FIRST_S, LAST_S, STARTS = 215.0, 485.0, 28
LENGTH_S, JUDGED_S = 90.0, 60.0


@dataclass(frozen=True)
class FlightStart:
    """A start in the air; angles in rad, NaN where the heading was never ready."""

    begin_s: float
    rms: float
    """Root mean square of the difference of headings from JUDGED_S to LENGTH_S after the start."""
    ready_s: float
    error_then: float
    sigma_then: float

    @property
    def is_false(self) -> bool:
        """The heading was called ready, and was not."""
        return bool(abs(self.error_then) > max(3 * self.sigma_then, FALSE_RAD))


class Flight:
    """thor75.csv and thor75_onboard.csv in a folder."""

    def __init__(self, folder: Path):
        self.log = np.genfromtxt(folder / "thor75.csv", delimiter=",", names=True)
        self.onboard = np.genfromtxt(folder / "thor75_onboard.csv", delimiter=",", names=True)

    def start(self, begin_s: float, length_s: float = LENGTH_S, **options: object) -> FlightStart:
        """Options: those of Ins that differ from the preset consumer."""
        log = self.log[(self.log["t_s"] >= begin_s) & (self.log["t_s"] <= begin_s + length_s)]
        fix = log[np.isfinite(log["lat_deg"])]
        aids = Aids().velocity(fix["t_s"], np.stack([fix["vn"], fix["ve"], fix["vd"]], 1), 0.2)
        aids.position(fix["t_s"], np.radians(fix["lat_deg"]), np.radians(fix["lon_deg"]), fix["alt_m"], [2.0, 2.0, 4.0])
        rate, force = (np.stack([log[name + axis] for axis in "xyz"], 1) for name in "ga")
        run = Ins("consumer", solver="closed_form", **options).run(log["t_s"], rate, force, aids)
        onboard = np.interp(run.t_s, self.onboard["t_s"], np.unwrap(self.onboard["heading"]))
        error, sigma = wrapped(run.heading_rad - onboard), run.sigma_rotation_rad[:, 2]
        ready = np.flatnonzero(run.ready[:, 1])
        first = ready[0] if len(ready) else None
        late = run.t_s >= begin_s + JUDGED_S
        return FlightStart(
            begin_s,
            float(np.sqrt(np.mean(error[late] ** 2))),
            np.nan if first is None else float(run.t_s[first] - begin_s),
            np.nan if first is None else float(error[first]),
            np.nan if first is None else float(sigma[first]),
        )

    def starts(self) -> list[FlightStart]:
        """STARTS of them, evenly over the time in the air."""
        return [self.start(begin) for begin in np.linspace(FIRST_S, LAST_S, STARTS)]
