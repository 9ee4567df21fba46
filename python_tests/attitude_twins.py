"""Shared by the tests of twins: noise of precise sensors, and the angle between two attitudes."""

import numpy as np

PRECISE = dict(
    gyro_noise_rad_per_sqrt_s=1e-3, gyro_bias_walk_rad_s_per_sqrt_s=1e-4, accel_noise_per_sqrt_hz=5e-4,
    mag_noise_per_sqrt_hz=5e-4, start_sigma_bias_rad_s=0.05, accel_gate_nis=13.9, mag_gate_nis=13.9,
)  # fmt: skip


def difference(q: np.ndarray, p: np.ndarray) -> float:
    """Largest component difference of equal rotations."""
    known = np.isfinite(q).all(axis=1)
    sign = np.sign(np.sum(q[known] * p[known], axis=1))[:, None]
    return float(np.abs(q[known] * sign - p[known]).max())
