"""Errors of an attitude against a reference, as the BROAD benchmark defines them.

With e = q_est conj(q_ref) in earth axes: total = 2 acos|e0|, heading = 2 atan|e3/e0|, inclination =
2 acos sqrt(e0^2 + e3^2); root mean squares over the samples flagged as movement, in degrees; the mean over trials is
the plain mean. No heading alignment. Laidig et al., Data 6(7):72, 2021, section 4, doi 10.3390/data6070072.

Whether a filter's errors are as large as it says: the normalised estimation error squared (NEES), Bar-Shalom, Li and
Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001, section 5.4.2.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hnav.rotations import quaternion_product, rotation_error_rad


class Score(NamedTuple):
    """Root mean square errors in degrees."""

    total: float
    heading: float
    inclination: float


def errors_rad(q_est: np.ndarray, q_ref: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Total, heading and inclination error of each row, all >= 0; q: n x 4, body to the same earth frame, z vertical."""
    q_est = q_est / np.linalg.norm(q_est, axis=1, keepdims=True)
    q_ref = q_ref / np.linalg.norm(q_ref, axis=1, keepdims=True)
    e = np.abs(quaternion_product(q_est, q_ref * [1, -1, -1, -1]))
    return (
        2 * np.arccos(np.clip(e[:, 0], 0, 1)),
        2 * np.arctan2(e[:, 3], e[:, 0]),
        2 * np.arccos(np.clip(np.hypot(e[:, 0], e[:, 3]), 0, 1)),
    )


def score(q_est: np.ndarray, q_ref: np.ndarray, movement: np.ndarray | None = None) -> Score:
    """RMS in degrees over the rows of movement where both attitudes are known."""
    known = np.isfinite(q_ref).all(axis=1) & np.isfinite(q_est).all(axis=1)
    if movement is not None:
        known &= movement
    if not known.any():
        return Score(np.nan, np.nan, np.nan)
    return Score(*(float(np.degrees(np.sqrt(np.mean(e**2)))) for e in errors_rad(q_est[known], q_ref[known])))


def nees(q_est: np.ndarray, sigma_rad: np.ndarray, q_ref: np.ndarray, movement: np.ndarray | None = None) -> float:
    """NEES / 3: 1 when the errors are as large as stated, above 1 when they are larger (the filter is overconfident).

    Mean over the rows of movement where attitudes and sigmas are known; NaN if there are none. sigma_rad: n x 3, of the rotation
    between estimate and reference about the navigation axes; correlations are left out. Raises ValueError for another shape, and
    for a sigma that is not positive.
    """
    if np.shape(sigma_rad) != (len(q_est), 3):
        raise ValueError(f"sigma_rad has the shape {np.shape(sigma_rad)}, expected n x 3, n = {len(q_est)}")
    error = rotation_error_rad(q_est, q_ref)
    known = np.isfinite(error).all(axis=1) & np.isfinite(sigma_rad).all(axis=1)
    if movement is not None:
        known &= movement
    if not known.any():
        return float("nan")
    if not (sigma_rad[known] > 0).all():
        raise ValueError("sigma_rad: a standard deviation is not positive")
    return float(np.mean(np.sum((error[known] / sigma_rad[known]) ** 2, axis=1)) / 3)
