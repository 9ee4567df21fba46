"""Recorded hands: BROAD trials that move about, with optical positions as of GNSS or cameras."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

import hnav
from hnav import earth
from hnav.filters.ins_answers import PHASES, InsRun
from hnav.native.arrays import Array
from hnav.rotations import quaternion_product, rotation_error_rad
from hnav.systems.navigation_views import FALSE_RAD
from studies.processes import in_order

LENGTH_S, APART_S, FIRST_S = 60.0, 20.0, 5.0
LAST_S = 10.0  # the filter is judged over the last ones of its minute
PLACE = np.array([0.8, 0.2, 400.0])
"""Latitude, longitude and height of the room, chosen: the trials have none, and at this grade it does not matter."""
FIELD_STEP = 6  # samples of the inertial sensor for one of the magnetometer
NED = np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]])
"""Room axes, z up, to north-east-down; the direction of north in the room is chosen."""


@dataclass(frozen=True)
class Fixes:
    """Added to the optical positions: white noise of each axis."""

    text: str
    rate_hz: float
    sigma_m: float
    sigma_m_s: float
    with_field: bool = False  # the magnetometer too, as it is: three of the trials have a magnet near it or on it


WAYS = (
    Fixes("optical accuracy: 2 cm, 20 a second", 20.0, 0.02, 0.1),
    Fixes("as satellites do: 1.5 m, 5 a second", 5.0, 1.5, 0.1),
    Fixes("the same, and the magnetometer", 5.0, 1.5, 0.1, with_field=True),
)


class Trial:
    """An .hdf5 of BROAD in SI units."""

    def __init__(self, path: Path):
        import h5py

        recording = hnav.read(path)
        self.t_s, self.rate, self.force = recording.t_s, recording.rate_b_rad_s, recording.force_b_m_s2
        self.field = recording.field_b_tesla
        with h5py.File(path) as trial:
            self.position_n = trial["opt_pos"][:] @ NED.T
        q_nb = quaternion_product(Rotation.from_matrix(NED).as_quat(scalar_first=True), recording.needed("reference_q_nb"))
        self.q_nb = np.where(np.isfinite(self.position_n).all(1, keepdims=True), q_nb, np.nan)

    def begins(self) -> Array:
        """Times of starts of which a whole minute follows."""
        return np.arange(FIRST_S, self.t_s[-1] - LENGTH_S, APART_S)

    def aids(self, rows: slice, fixes: Fixes, rng: np.random.Generator) -> hnav.Aids:
        """Positions, and velocities from those a twentieth of a second before and after."""
        t, position = self.t_s[rows], self.position_n[rows]
        rate_hz = 1 / np.median(np.diff(t))
        half = round(0.05 * rate_hz)
        fix = np.arange(round(rate_hz), len(t) - half, round(rate_hz / fixes.rate_hz))
        velocity = (position[fix + half] - position[fix - half]) / (t[fix + half] - t[fix - half])[:, None]
        seen = np.isfinite(velocity).all(1) & np.isfinite(position[fix]).all(1)
        fix, velocity = fix[seen], velocity[seen]
        velocity += rng.normal(0, fixes.sigma_m_s, velocity.shape)
        fixed = earth.position_of(PLACE) + (position[fix] + rng.normal(0, fixes.sigma_m, velocity.shape)) @ earth.axes_at(PLACE).T
        latitude, longitude, height = earth.place_of(fixed).T
        aids = hnav.Aids().velocity(t[fix], velocity, fixes.sigma_m_s)
        if fixes.with_field and self.field is not None:
            aids.mag(t[::FIELD_STEP], self.field[rows][::FIELD_STEP])
        return aids.position(t[fix], latitude, longitude, height, fixes.sigma_m)

    def minute(self, begin_s: float, fixes: Fixes) -> dict[str, Any]:
        """The headings of filter and smoother from there on, by the preset consumer. rms, stated, z2: error and sigma of the
        filter over the last LAST_S, rad; smoothed_rms, smoothed_z2: of the whole minute, NaN where the heading was never found
        and the smoother has nothing to add; is_false: it was called ready while it was not."""
        first, last = np.searchsorted(self.t_s, [begin_s, begin_s + LENGTH_S])
        rows = slice(first, last)
        aids = self.aids(rows, fixes, np.random.default_rng(round(begin_s)))
        samples = self.t_s[rows], self.rate[rows], self.force[rows], aids
        ins = hnav.Ins("consumer", solver="closed_form")
        filtered, smoothed = ins.run(*samples), ins.smooth(*samples)
        late = filtered.t_s > filtered.t_s[-1] - LAST_S
        error, sigma = self.error(filtered, rows), filtered.sigma_rotation_rad[:, 2]
        after, sigma_after = self.error(smoothed, rows), smoothed.sigma_rotation_rad[:, 2]
        found = (smoothed.phase == PHASES.index("navigating")).any()
        is_off = (np.abs(error) > np.fmax(3 * sigma, FALSE_RAD)) & filtered.ready[:, 1]
        return {
            "rms": np.sqrt(np.nanmean(error[late] ** 2)),
            "stated": np.sqrt(np.mean(sigma[late] ** 2)),
            "z2": np.nanmean((error / sigma)[late] ** 2),
            "smoothed_rms": np.sqrt(np.nanmean(after**2)) if found else np.nan,
            "smoothed_z2": np.nanmean((after / sigma_after) ** 2) if found else np.nan,
            "is_ready": filtered.ready[:, 1].any(),
            "is_false": is_off.any(),
        }

    def error(self, run: InsRun, rows: slice) -> Array:
        """n: of the attitude about the vertical, rad; NaN where one of both is not known."""
        return rotation_error_rad(self.q_nb[rows], run.q_nb)[:, 2]


def minutes_of(path: Path, fixes: Fixes) -> pd.DataFrame:
    """Those of a trial in which the optics see the body at the end."""
    trial = Trial(path)
    found = [trial.minute(begin, fixes) for begin in trial.begins()]
    return pd.DataFrame([minute for minute in found if np.isfinite(minute["rms"])])


def trials(folder: Path) -> list[Path]:
    """Those in which the hand does more than turn the body: without a way there is no heading."""
    return sorted(path for path in folder.glob("*.hdf5") if "_rotation" not in path.name)


def minutes(folder: Path, fixes: Fixes, workers: int) -> pd.DataFrame:
    """All minutes of all trials."""
    return pd.concat(in_order(partial(minutes_of, fixes=fixes), trials(folder), workers))
