"""A simulated motion with known attitude and bias."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from hnav.io.recordings import Recording


@dataclass(frozen=True)
class Motion:
    """A tumbling body with known attitude and bias, as an ideal north-east-down sensor would record it."""

    recording: Recording
    bias: np.ndarray


def tilted_motion(duration_s: float, noise: float = 1.0, seed: int = 7, bias=(0.03, -0.05, 0.02)) -> Motion:
    """Tilted by 20 deg, rates up to 10 rad/s, 100 Hz; the rate of a row is the mean over the interval that follows."""
    rng = np.random.default_rng(seed)
    t = np.arange(0, duration_s, 0.01)
    w = np.stack([4 * np.sin(1.1 * t), 5 * np.cos(0.7 * t), 7.5 * np.sin(0.4 * t)], axis=1)
    attitude = Rotation.concatenate([Rotation.from_euler("x", 20, degrees=True), Rotation.from_rotvec(0.01 * w[:-1])])
    turns = 1  # of each product so far
    while turns < len(t):
        attitude = Rotation.concatenate([attitude[:turns], attitude[:-turns] * attitude[turns:]])
        turns *= 2
    force = attitude.apply([0, 0, -9.81], inverse=True) + noise * 0.05 * rng.normal(size=w.shape)
    field = attitude.apply([2e-5, 0, 4.5e-5], inverse=True) + noise * 2e-7 * rng.normal(size=w.shape)
    rate = w + bias + noise * 0.01 * rng.normal(size=w.shape)
    q = attitude.as_quat()[:, [3, 0, 1, 2]]
    return Motion(Recording("tilted motion", t, rate, force, field, q), np.array(bias))


def turning(t_s: np.ndarray) -> Rotation:
    """Attitudes of a body at rest for 3 s that then turns by up to 40 deg/s."""
    moving = np.maximum(t_s - 3, 0)
    yaw, pitch, roll = 1.2 * np.sin(0.4 * moving), 0.4 * np.sin(0.7 * moving), 0.5 * np.sin(0.5 * moving)
    return Rotation.from_euler("ZYX", np.stack([yaw, pitch, roll], axis=-1))


def readings(t_s: np.ndarray, noise: float = 1.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """n x 3 each: rate, force and field of that body at these instants, no means over intervals."""
    rng = np.random.default_rng(3)
    half_s = 5e-5  # of the interval over which the rate is derived
    rate = (turning(t_s - half_s).inv() * turning(t_s + half_s)).as_rotvec() / (2 * half_s)
    into_body = turning(t_s).inv()
    force, field = into_body.apply([0, 0, -9.80665]), into_body.apply([2e-5, 0, 4.5e-5])
    sigmas = (3e-3, 0.03, 4e-7)
    with_noise = (value + noise * sigma * rng.normal(size=value.shape) for value, sigma in zip((rate, force, field), sigmas))
    return tuple(with_noise)  # type: ignore[return-value]
