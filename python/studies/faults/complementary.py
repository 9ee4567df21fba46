"""The peer of the table of events: a complementary filter for the tilt, with one time constant."""

from __future__ import annotations

import numpy as np

TIME_CONSTANT_S = 3.0


def tilt_errors_rad(t_s: np.ndarray, rate: np.ndarray, force: np.ndarray, up_b: np.ndarray) -> np.ndarray:
    """Angles between its vertical and the true one, m x n. Arrays of m runs: t_s m x n, the others m x n x 3, body axes.

    The vertical turns with the body, and towards the direction of the force at the error's sine over TIME_CONSTANT_S.
    """
    interval_s = np.minimum(np.diff(t_s, axis=1, prepend=t_s[:, :1]), 0.1)
    direction = force / np.linalg.norm(force, axis=2, keepdims=True)
    up = direction[:, 0]
    errors = np.empty(t_s.shape)
    for k in range(t_s.shape[1]):
        turn = -rate[:, k] + np.cross(up, direction[:, k]) / TIME_CONSTANT_S
        up = _turned(up, turn * interval_s[:, k, None])
        errors[:, k] = np.arccos(np.clip(np.sum(up * up_b[:, k], axis=1), -1, 1))
    return errors


def _turned(v: np.ndarray, angle: np.ndarray) -> np.ndarray:
    size = np.maximum(np.linalg.norm(angle, axis=1, keepdims=True), 1e-12)
    axis = angle / size
    along = np.sum(axis * v, axis=1, keepdims=True)
    return np.asarray(v * np.cos(size) + np.cross(axis, v) * np.sin(size) + axis * along * (1 - np.cos(size)))
