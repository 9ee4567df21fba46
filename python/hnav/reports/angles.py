"""Angles for display: in degrees, without jumps by a whole turn."""

from __future__ import annotations

import numpy as np

from hnav.rotations import euler_rad


def euler_deg(q_nb: np.ndarray) -> np.ndarray:
    """Roll, pitch, yaw in deg (n x 3) of unit quaternions (n x 4, scalar first, body to navigation).

    Rotation order z y x, each angle unwrapped in time so that a turn is one line; NaN rows stay NaN.
    """
    angles = euler_rad(q_nb)
    known = np.isfinite(angles).all(axis=1)
    angles[known] = np.unwrap(angles[known], axis=0)
    return np.asarray(np.degrees(angles))


def near_turn(angles_deg: np.ndarray, near_deg: np.ndarray) -> np.ndarray:
    """angles_deg moved by whole turns to within half a turn of near_deg, element by element.

    Rows without a near_deg are moved as the row before them, so that a line does not jump; the first as the first that has one.
    """
    turns = np.round((near_deg - angles_deg) / 360.0).reshape(len(angles_deg), -1)
    for column in turns.T:
        known = np.flatnonzero(np.isfinite(column))
        if len(known):
            column[:] = column[known[np.searchsorted(known, np.arange(len(column)), side="right").clip(1) - 1]]
    return np.asarray(angles_deg + 360.0 * np.nan_to_num(turns).reshape(angles_deg.shape))
