"""Quaternions, one or n x 4: scalar first, Hamilton, body to navigation."""

from __future__ import annotations

import numpy as np

NED_AND_ENU = np.array([0.0, np.sqrt(0.5), np.sqrt(0.5), 0.0])
"""q from north-east-down axes to east-north-up ones, half a turn about the bisector of the first two; it is its own inverse."""


def quaternion_product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a (x) b: n x 4 each and row by row, or 4; one factor of 4 stands for every row."""
    w, x, y, z = np.asarray(a).T
    p, q, r, s = np.asarray(b).T
    return np.stack([w * p - x * q - y * r - z * s, w * q + x * p + y * s - z * r,
                     w * r - x * s + y * p + z * q, w * s + x * r - y * q + z * p], axis=-1)  # fmt: skip


def rotated(q: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """q vector q*, n x 3: vectors (n x 3, or one of 3) from the axes on the right of q to those on its left."""
    of_three = np.atleast_2d(vector)
    pure = np.concatenate([np.zeros((len(of_three), 1)), of_three], axis=1)
    turned: np.ndarray = quaternion_product(quaternion_product(q, pure), q * [1, -1, -1, -1])[:, 1:]
    return turned


def quaternion_exp(half_turn: np.ndarray) -> np.ndarray:
    """n x 4, from n x 3 half rotation vectors."""
    angle = np.linalg.norm(half_turn, axis=1, keepdims=True)
    return np.hstack([np.cos(angle), half_turn * np.sinc(angle / np.pi)])


def euler_rad(q: np.ndarray) -> np.ndarray:
    """Roll, pitch, yaw (n x 3), rotation order z y x; NaN rows stay NaN."""
    w, x, y, z = q.T
    return np.stack([
        np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
        np.arcsin(np.clip(2 * (w * y - z * x), -1, 1)),
        np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
    ], axis=1)  # fmt: skip


def quaternion_of_euler(euler: np.ndarray) -> np.ndarray:
    """n x 4 of roll, pitch, yaw (n x 3, rad), rotation order z y x; NaN rows stay NaN."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(0.5 * euler.T), np.sin(0.5 * euler.T)
    return np.stack([cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy,
                     cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy], axis=1)  # fmt: skip


def continuous_quaternion(q: np.ndarray) -> np.ndarray:
    """The same rotations (n x 4) with signs chosen so that neighbours lie on the same half of the sphere."""
    q = q.copy()
    known = np.flatnonzero(np.isfinite(q).all(axis=1))
    if len(known):
        turns = np.sign(np.einsum("ij,ij->i", q[known][1:], q[known][:-1]))
        turns[turns == 0] = 1
        q[known[1:]] *= np.cumprod(turns)[:, None]
    return q


def rotation_error_rad(q_est: np.ndarray, q_ref: np.ndarray) -> np.ndarray:
    """Rotation vector (n x 3, rad, navigation axes) that turns the estimate into the reference.

    q_ref = exp(error / 2) q_est: the error whose sigma the filter states. Rows with a NaN give NaN.
    """
    between = quaternion_product(q_ref, q_est * [1, -1, -1, -1])
    between *= np.where(between[:, :1] < 0, -1.0, 1.0)  # the short way round
    sine = np.linalg.norm(between[:, 1:], axis=1, keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        error: np.ndarray = between[:, 1:] * np.where(sine > 0, 2 * np.arctan2(sine, between[:, :1]) / sine, 2.0)
    return error
