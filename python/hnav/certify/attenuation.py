"""The attenuation of a run whose truth is known: error energy over disturbance energy, the ratio the paper bounds by gamma^2.

    sum |L e_k|^2 / ( e_0' P_0^-1 e_0 + sum w_k' Q^-1 w_k + sum v_k' R^-1 v_k ) < gamma^2

e: attitude (vector part of the quaternion error, navigation axes) and bias after each correction; w: what the true rate
and bias do beyond the model; v: what the samples are beyond h of the truth.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hnav.certify.gain_record import Correction
from hnav.certify.hrekf import C_bn
from hnav.rotations import quaternion_product

SMALLEST_SHARE = 1e-9  # of the largest eigenvalue: below, a covariance contains no disturbance in that direction


def energy(e: np.ndarray, covariance: np.ndarray) -> float:
    """e' C^+ e over the directions in which C is not zero."""
    values, vectors = np.linalg.eigh(covariance)
    used = values > SMALLEST_SHARE * values[-1]
    return float(np.sum((vectors[:, used].T @ e) ** 2 / values[used]))


def attenuation(corrections: Sequence[Correction], q_true: np.ndarray, bias_true: np.ndarray, weight: np.ndarray) -> float:
    """q_true: n x 4 at each correction, magnetic north-east-down; bias_true: 3, rad/s, constant; weight: L, 6."""

    def error(true: np.ndarray, q: np.ndarray, b: np.ndarray) -> np.ndarray:
        p = quaternion_product(true, q * [1, -1, -1, -1])
        return np.concatenate([np.copysign(1, p[0]) * p[1:], C_bn(q).T @ (bias_true - b)])

    e = np.stack([error(true, c.q, c.b) for true, c in zip(q_true, corrections)])
    disturbance = energy(e[0], corrections[0].P[1:, 1:])
    for k, c in enumerate(corrections[1:], start=1):
        # What the predicted error is beyond what the model makes of the error before entered during the flow.
        predicted = error(q_true[k], c.q_minus, corrections[k - 1].b)
        disturbance += energy(predicted - c.Phi[1:, 1:] @ e[k - 1], c.Q[1:, 1:])
        disturbance += energy(c.nu - c.H[:, 1:] @ predicted, c.R)
    return float(np.sum((e * weight) ** 2) / disturbance)
