"""The smoother beside the filter: simulated starts of which each row's truth is known, with half a minute without satellites."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from hnav import earth
from hnav.filters.ins import Ins
from hnav.filters.ins_answers import PHASES, InsRun
from hnav.native.arrays import Array, BoolArray
from studies.ins.experiment import EVERY, errors_of
from studies.ins.vehicles import Truth, vehicle

OUTAGE_S = (90.0, 120.0)
LENGTH_S = 150.0
PARTS = ("before it is known", "from then on", "middle of the outage")
"""Rows before the heading was found; rows from then on; the ten seconds in the middle of the outage."""


def compared(kind: str, grade: str, seed: int) -> Array:
    """2 x 3 x 6 of the start of this number: by filter and smoother, of the rows of each of PARTS, mean squares of errors
    (heading and tilt in rad, horizontal position in m) and of errors over sigmas. NaN where there is no such row."""
    samples, truth = vehicle(kind, grade, seed, LENGTH_S)
    begin, end = (samples.t_s[0] + t for t in OUTAGE_S)
    valid = samples.aids.arrays()[0]
    arrays = samples.without_fixes((valid > begin) & (valid <= end)).arrays()
    ins = Ins(grade, solver="closed_form")
    filtered, smoothed = ins.run(*arrays, EVERY), ins.smooth(*arrays, EVERY)
    known = filtered.phase == PHASES.index("navigating")
    again = (smoothed.phase == PHASES.index("navigating")) & ~known
    middle = known & (np.abs(filtered.t_s - 0.5 * (begin + end)) < 5)
    nothing = np.zeros_like(known)  # the heading is not found before
    runs = ((filtered, nothing), (smoothed, again))
    return np.array([[mean_squares(run, truth, rows) for rows in (before, known, middle)] for run, before in runs])


def mean_squares(run: InsRun, truth: Truth, rows: BoolArray) -> Array:
    """6: of heading, tilt and horizontal position, and normalised, over some rows of the run."""
    if not rows.any():
        return np.full(6, np.nan)
    axes, off = earth.axes_at(run.place[rows]), errors_of(run, truth, EVERY).position_m[rows]
    shown = Rotation.from_matrix(axes) * Rotation.from_quat(run.q_nb[rows], scalar_first=True)
    turned = np.einsum("nij,ni->nj", axes, (shown * truth.attitude_e[EVERY - 1 :: EVERY][rows].inv()).as_rotvec())
    z, z_turned = off / run.sigma_position_m[rows], turned / run.sigma_rotation_rad[rows]
    columns = (turned[:, 2:], turned[:, :2], off[:, :2], z_turned[:, 2:], z_turned[:, :2], z)
    return np.array([np.mean(column**2) for column in columns])


def summary(of: Sequence[Array]) -> Array:
    """2 x 3 x 6, by filter and smoother and part: rms of heading and tilt in deg, of the horizontal position in m; means of the
    normalised squares, each start at most 50."""
    means = np.array(of)
    means[..., 3:] = np.minimum(means[..., 3:], 50)
    there = np.isfinite(means)
    mean = np.where(there, means, 0).sum(axis=0) / np.where(there.any(axis=0), there.sum(axis=0), np.nan)
    return np.asarray(np.concatenate([np.sqrt(mean[..., :3]) * [180 / np.pi, 180 / np.pi, 1], mean[..., 3:]], axis=-1))
