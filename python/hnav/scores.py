"""Errors of an attitude against a reference, as the BROAD benchmark defines them.

With e = q_est conj(q_ref) in earth axes: total = 2 acos|e0|, heading = 2 atan|e3/e0|, inclination =
2 acos sqrt(e0^2 + e3^2); root mean squares over the samples flagged as movement, in degrees; the mean over trials is
the plain mean. No heading alignment. Laidig et al., Data 6(7):72, 2021, section 4, doi 10.3390/data6070072.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hnav.rotations import quaternion_product


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
