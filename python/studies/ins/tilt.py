"""The tilt of bodies that do not turn for a while, from the moment on at which it is found: trains, and quadrotors that hover first."""

from __future__ import annotations

import numpy as np

from hnav.native.arrays import BoolArray
from studies.ins.experiment import DURATIONS_S, EVERY, LARGEST, errors_of
from studies.ins.vehicles import filter_of, vehicle

AFTER_S = (5.0, 15.0, 30.0, 60.0, 120.0, 180.0, 225.0)  # after the tilt is found
KINDS = ("train", "hover")


def tilt(kind: str, grade: str, seed: int) -> list[float]:
    """Of the start of this number: means of the two squared normalised errors at AFTER_S and of all rows, and of the rows with
    tilt_ready the share whose error is beyond both five sigmas and 1 deg."""
    samples, truth = vehicle(kind, grade, seed, DURATIONS_S[kind])
    run = filter_of(kind, grade).run(*samples.arrays(), every=EVERY)
    found: BoolArray = np.isfinite(run.q_nb[:, 0])
    error, sigma = errors_of(run, truth, EVERY).tilt_rad[found], run.sigma_rotation_rad[found, :2]
    z2 = np.minimum(np.mean((error / sigma) ** 2, axis=1), LARGEST)
    since_s = run.t_s[found] - run.t_s[found][0]
    false: BoolArray = np.any(np.abs(error) > np.maximum(5 * sigma, np.radians(1)), axis=1, keepdims=True)
    return [*z2[np.searchsorted(since_s, AFTER_S)], z2.mean(), false[run.ready[found, 0]].mean()]
