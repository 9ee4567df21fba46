"""The recorded flight: starts in the air, compared with the aeroplane's own filter.

That filter is no truth: a part of the difference is its own.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd
from scipy.spatial.transform import Rotation

from hnav.filters.ins import Ins
from hnav.filters.ins_aids import Aids
from hnav.filters.ins_answers import InsRun
from hnav.native.arrays import Array
from hnav.systems.navigation_views import FALSE_RAD, wrapped

FIRST_S, LAST_S, STARTS = 215.0, 485.0, 28
LENGTH_S, JUDGED_S = 90.0, 60.0
TAKE_OFF_S, LANDING_S = 212.0, 577.0


def first_ready(run: InsRun, error: Array, begin_s: float) -> dict[str, Any]:
    """ready_s: from switching on to the first heading_ready, NaN for never; is_false: whether the heading was called ready there,
    and was not. error: of the heading in the rows of the run, rad."""
    row = int(np.argmax(run.ready[:, 1]))
    if not run.ready[row, 1]:
        return {"ready_s": np.nan, "is_false": False}
    limit_rad = max(3 * run.sigma_rotation_rad[row, 2], FALSE_RAD)
    return {"ready_s": float(run.t_s[row] - begin_s), "is_false": bool(abs(error[row]) > limit_rad)}


class Flight:
    """thor75.csv and thor75_onboard.csv in a folder."""

    def __init__(self, folder: Path):
        self.log = np.genfromtxt(folder / "thor75.csv", delimiter=",", names=True)
        self.onboard = np.genfromtxt(folder / "thor75_onboard.csv", delimiter=",", names=True)
        self.late_s = self.reference_late_s()
        self.onboard["t_s"] -= self.late_s

    def reference_late_s(self) -> float:
        """Latency of the reference behind the gyroscopes in samples, from its rotation, for any heading."""
        t, interval_s = self.onboard["t_s"], float(np.median(np.diff(self.log["t_s"])))
        flies = np.flatnonzero((t > TAKE_OFF_S) & (t < LANDING_S))
        angles = np.stack([self.onboard[name] for name in ("heading", "pitch", "roll")], 1)
        attitude = Rotation.from_euler("ZYX", angles)
        turns = (attitude[flies[:-1]].inv() * attitude[flies[1:]]).as_rotvec()
        turned = np.cumsum(np.stack([self.log["g" + axis] for axis in "xyz"], 1) * interval_s, axis=0)

        def misfit(late_s: float) -> float:
            at = np.stack([np.interp(t[flies] - late_s, self.log["t_s"], angle) for angle in turned.T], 1)
            return float(np.var(turns - np.diff(at, axis=0), axis=0).sum())

        return min((k * interval_s for k in range(-5, 6)), key=misfit)

    def from_the_ground(self) -> float:
        """Root mean square of the difference of headings, from JUDGED_S after take-off to the landing, switched on at the begin."""
        run = self.run(self.log)
        judged = (run.t_s > TAKE_OFF_S + JUDGED_S) & (run.t_s < LANDING_S)
        return float(np.sqrt(np.mean(self.error(run)[judged] ** 2)))

    def error(self, run: InsRun) -> Array:
        """n: of the heading in rad, seen from the reference."""
        onboard = np.interp(run.t_s, self.onboard["t_s"], np.unwrap(self.onboard["heading"]))
        return wrapped(run.heading_rad - onboard)

    @staticmethod
    def run(log: npt.NDArray[np.void], **options: object) -> InsRun:
        """Over some rows of the log, by the preset consumer with these options."""
        rate, force = (np.stack([log[name + axis] for axis in "xyz"], 1) for name in "ga")
        return Ins("consumer", solver="closed_form", **options).run(log["t_s"], rate, force, Flight.aids(log))

    @staticmethod
    def aids(log: npt.NDArray[np.void]) -> Aids:
        """The fixes of some rows of the log."""
        fix = log[np.isfinite(log["lat_deg"])]
        aids = Aids().velocity(fix["t_s"], np.stack([fix["vn"], fix["ve"], fix["vd"]], 1), 0.2)
        return aids.position(fix["t_s"], np.radians(fix["lat_deg"]), np.radians(fix["lon_deg"]), fix["alt_m"], [2.0, 2.0, 4.0])

    def start(self, begin_s: float, **options: object) -> dict[str, Any]:
        """A start in the air as of first_ready; rms, mean: of the difference of headings from JUDGED_S to LENGTH_S after it, rad.
        Options: those of Ins that differ from the preset consumer."""
        run = self.run(self.log[(self.log["t_s"] >= begin_s) & (self.log["t_s"] <= begin_s + LENGTH_S)], **options)
        error = self.error(run)
        late = error[run.t_s >= begin_s + JUDGED_S]
        return first_ready(run, error, begin_s) | {"rms": np.sqrt(np.mean(late**2)), "mean": np.mean(late)}

    def starts(self, **options: object) -> pd.DataFrame:
        """STARTS of them, evenly over the time in the air."""
        return pd.DataFrame([self.start(begin, **options) for begin in np.linspace(FIRST_S, LAST_S, STARTS)])
