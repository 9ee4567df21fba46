"""Filters of the literature beside the HREKF, in NumPy, each for many runs at once: what a reviewer would ask for.

All estimate attitude and gyroscope bias from the same samples and the same noise, by an error state of six: rotation (rad), bias
(rad/s). They differ in where the error lives and in what they do with a measurement that does not fit.

multiplicative    error about the body axes, q (x) exp(theta / 2): Lefferts, Markley, Shuster, J. Guidance 5(5), 1982
invariant         error about the navigation axes, exp(theta / 2) (x) q, whose measurement matrix does not depend on the estimate:
                  Bonnabel, Martin, Salaun, CDC 2009; "imperfect", because the bias is additive (Barrau 2015)
unscented         13 points about the body axes: Crassidis and Markley, J. Guidance 26(4), 2003, with rotation vectors
huber             multiplicative, each whitened residual of measurement and prediction weighed by min(1, 1.345 / |residual|):
                  Karlgaard and Schaub, J. Guidance 30(3), 2007
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

HUBER = 1.345  # of a standard deviation: 95 % efficient for normal errors (Huber 1964)
UP = np.array([0.0, 0.0, -1.0])


@dataclass(frozen=True)
class Assumed:
    """Noise and start of every peer."""

    gyro_noise: float  # rad/sqrt(s)
    walk: float  # rad/s/sqrt(s)
    direction_noise: float  # 1/sqrt(Hz), of force and field in units of their lengths
    field_n: np.ndarray  # 3, unit length
    sigma_tilt_rad: float
    sigma_heading_rad: float
    sigma_bias_rad_s: float


@dataclass
class State:
    """Of N runs."""

    R_nb: np.ndarray  # N x 3 x 3, body to navigation
    b: np.ndarray  # N x 3
    P: np.ndarray  # N x 6 x 6


def cross(v: np.ndarray) -> np.ndarray:
    """... x 3 x 3: cross(v) @ x = v cross x."""
    zero = np.zeros_like(v[..., 0])
    rows = [zero, -v[..., 2], v[..., 1], v[..., 2], zero, -v[..., 0], -v[..., 1], v[..., 0], zero]
    return np.stack(rows, axis=-1).reshape(*v.shape, 3)


def turned(v: np.ndarray) -> np.ndarray:
    """... x 3 x 3 of rotation vectors."""
    return np.asarray(Rotation.from_rotvec(v.reshape(-1, 3)).as_matrix().reshape(*v.shape, 3))


def swap(M: np.ndarray) -> np.ndarray:
    return np.swapaxes(M, -1, -2)


def begin(q_start: Rotation, assumed: Assumed, body_axes: bool) -> State:
    """q_start: N attitudes, wrong by the error of the start."""
    R = q_start.as_matrix()
    P = np.zeros((len(R), 6, 6))
    rotation = np.diag([assumed.sigma_tilt_rad**2, assumed.sigma_tilt_rad**2, assumed.sigma_heading_rad**2])
    P[:, :3, :3] = swap(R) @ rotation @ R if body_axes else rotation
    P[:, 3:, 3:] = assumed.sigma_bias_rad_s**2 * np.eye(3)
    return State(R, np.zeros((len(R), 3)), P)


def noise_of(assumed: Assumed, T: float) -> np.ndarray:
    return T * np.diag([assumed.gyro_noise**2] * 3 + [assumed.walk**2] * 3)


def flow(s: State, rate: np.ndarray, T: float, assumed: Assumed, body_axes: bool) -> None:
    """Over an interval in which the rate is held; the noise of the rotation is isotropic, the same in both axes."""
    turn = turned(T * (rate - s.b))
    F = np.broadcast_to(np.eye(6), s.P.shape).copy()
    if body_axes:
        F[:, :3, :3], F[:, :3, 3:] = swap(turn), -T * np.eye(3)
    else:
        F[:, :3, 3:] = -T * s.R_nb
    s.R_nb = s.R_nb @ turn
    s.P = F @ s.P @ swap(F) + noise_of(assumed, T)


def weights(whitened: np.ndarray) -> np.ndarray:
    """N x 1 x n, of whitened residuals N x n."""
    return np.asarray(np.minimum(1, HUBER / np.maximum(1e-12, np.abs(whitened)))[:, None, :])


def correct(s: State, y: np.ndarray, H: np.ndarray, expected: np.ndarray, variance: float, body_axes: bool, robust: bool) -> None:
    """y, expected: N x 6, H: N x 6 x 6."""
    residual = y - expected
    R = np.broadcast_to(variance * np.eye(6), s.P.shape)
    P = s.P
    x = np.zeros((len(y), 6))
    for _ in range(4 if robust else 1):
        S = H @ P @ swap(H) + R
        K = swap(np.linalg.solve(S, H @ P))
        x = np.einsum("nij,nj->ni", K, residual)
        if robust:
            R = variance * np.eye(6) / weights((residual - np.einsum("nij,nj->ni", H, x)) / np.sqrt(variance))
            L = np.linalg.cholesky(s.P)
            P = (L / weights(np.linalg.solve(L, x[..., None])[..., 0])) @ swap(L)
    IKH = np.eye(6) - K @ H
    s.P = IKH @ P @ swap(IKH) + K @ R @ swap(K)
    apply(s, x, body_axes)


def apply(s: State, x: np.ndarray, body_axes: bool) -> None:
    small = turned(x[:, :3])
    s.R_nb = s.R_nb @ small if body_axes else small @ s.R_nb
    s.b = s.b + x[:, 3:]


Peer = Callable[[np.ndarray, np.ndarray, float, Rotation, Assumed], np.ndarray]
"""(rate N x n x 3, y N x n x 6: force and field in units of their lengths, T, N starts, assumed): N x n x 3 x 3, body to navigation."""


def extended(body_axes: bool, robust: bool = False) -> Peer:
    def run(rate: np.ndarray, y: np.ndarray, T: float, q_start: Rotation, assumed: Assumed) -> np.ndarray:
        s = begin(q_start, assumed, body_axes)
        known = np.stack([UP, assumed.field_n])  # of force and field
        found = [s.R_nb]
        for k in range(1, rate.shape[1]):
            flow(s, rate[:, k - 1], T, assumed, body_axes)
            seen = known @ s.R_nb  # N x 2 x 3: R' r
            H = np.zeros((len(s.b), 6, 6))
            if body_axes:
                H[:, :, :3] = cross(seen).reshape(-1, 6, 3)
                measured, expected = y[:, k], seen.reshape(-1, 6)
            else:  # in navigation axes: R y = r + r x theta
                H[:, :, :3] = cross(known).reshape(6, 3)
                measured = (y[:, k].reshape(-1, 2, 3) @ swap(s.R_nb)).reshape(-1, 6)
                expected = np.broadcast_to(known.ravel(), measured.shape)
            correct(s, measured, H, expected, assumed.direction_noise**2 / T, body_axes, robust)
            found.append(s.R_nb)
        return np.stack(found, axis=1)

    return run


def unscented(rate: np.ndarray, y: np.ndarray, T: float, q_start: Rotation, assumed: Assumed) -> np.ndarray:
    s = begin(q_start, assumed, True)
    known = np.stack([UP, assumed.field_n])
    n, kappa = 6, -3.0  # n + kappa = 3, as for normal errors; the middle weight is negative, so P is floored
    weight = np.r_[kappa / (n + kappa), np.full(2 * n, 0.5 / (n + kappa))]
    found = [s.R_nb]
    for k in range(1, rate.shape[1]):
        root = np.linalg.cholesky((n + kappa) * (s.P + 0.5 * noise_of(assumed, T)))
        x = np.concatenate([np.zeros((len(s.b), 1, 6)), swap(root), -swap(root)], axis=1)
        R = s.R_nb[:, None] @ turned(x[..., :3])
        bias = s.b[:, None] + x[..., 3:]
        R = R @ turned(T * (rate[:, None, k - 1] - bias))
        away = Rotation.from_matrix((swap(R[:, :1]) @ R).reshape(-1, 3, 3)).as_rotvec().reshape(*R.shape[:2], 3)
        x = np.concatenate([away, bias], axis=2)
        mean = np.einsum("p,npi->ni", weight, x)
        z = (known @ R).reshape(*R.shape[:2], 6)
        expected = np.einsum("p,npi->ni", weight, z)
        dx, dz = x - mean[:, None], z - expected[:, None]
        P = floored(np.einsum("p,npi,npj->nij", weight, dx, dx) + 0.5 * noise_of(assumed, T))
        S = floored(np.einsum("p,npi,npj->nij", weight, dz, dz)) + assumed.direction_noise**2 / T * np.eye(6)
        K = swap(np.linalg.solve(S, swap(np.einsum("p,npi,npj->nij", weight, dx, dz))))
        step = np.einsum("nij,nj->ni", K, y[:, k] - expected)
        s = State(R[:, 0] @ turned(mean[:, :3] + step[:, :3]), mean[:, 3:] + step[:, 3:], floored(P - K @ S @ swap(K)))
        found.append(s.R_nb)
    return np.stack(found, axis=1)


def floored(P: np.ndarray) -> np.ndarray:
    """Symmetric, with eigenvalues of at least 1e-9 of the largest."""
    values, vectors = np.linalg.eigh(0.5 * (P + swap(P)))
    values = np.maximum(values, 1e-9 * values[:, -1:])
    return np.asarray((vectors * values[:, None, :]) @ swap(vectors))


PEERS: dict[str, Peer] = {
    "multiplicative EKF": extended(body_axes=True),
    "invariant EKF": extended(body_axes=False),
    "UKF": unscented,
    "Huber KF": extended(body_axes=True, robust=True),
}
