"""The tilt of bodies that do not turn for a while, from the moment on at which it is found: trains, and quadrotors that hover first."""

from __future__ import annotations

import numpy as np

from hnav.filters.ins import Ins
from hnav.native.arrays import BoolArray
from studies.ins.experiment import DURATIONS_S, EVERY, LARGEST, tilt_errors
from studies.ins.vehicles import receiver, vehicle

AFTER_S = (5.0, 15.0, 30.0, 60.0, 120.0, 180.0, 225.0)  # after the tilt is found
KINDS = ("train", "hover")


def tilt(kind: str, grade: str, seed: int) -> list[float]:
    """Of the start of this number: means of the two squared normalised errors at AFTER_S and of all rows, and of the rows with
    tilt_ready the share whose error is beyond both five sigmas and 1 deg."""
    samples, truth = vehicle(kind, grade, seed, DURATIONS_S[kind])
    colour_m = receiver(kind).colour_m
    ins = Ins(grade, solver="closed_form", position_colour_m=(colour_m, colour_m))
    run = ins.run(samples.t_s, samples.rate_b_rad_s, samples.force_b_m_s2, samples.aids, every=EVERY)
    rows = np.arange(EVERY - 1, len(samples.t_s), EVERY)
    found: BoolArray = np.isfinite(run.q_nb[:, 0])
    error, sigma = tilt_errors(run, truth, rows, found), run.sigma_rotation_rad[found, :2]
    z2 = np.minimum(np.mean((error / sigma) ** 2, axis=1), LARGEST)
    since_s = run.t_s[found] - run.t_s[found][0]
    false: BoolArray = np.any(np.abs(error) > np.maximum(5 * sigma, np.radians(1)), axis=1, keepdims=True)
    return [*z2[np.searchsorted(since_s, AFTER_S)], z2.mean(), false[run.ready[found, 0]].mean()]
