"""Recordings without a fault, as they come from a hand, a pocket, a vehicle and a table, by sensors of three grades."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from hnav.io.recordings import Recording
from hnav.io.sensors import GRADES, read_grade
from hnav.simulation.imu_mag_sensor import ImuMagSensor, ImuMagSensorOptions
from hnav.simulation.turntable import Truth
from hnav.units import G_M_S2

RATE_HZ = 100.0
Motion = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Rates of the body, its acceleration and changes of the field in north-east-down."""


def _wander(rng: np.random.Generator, n: int, corner_hz: float, sizes: tuple[float, float, float]) -> np.ndarray:
    """n x 3: noise below a corner, of these standard deviations."""
    frequency = np.fft.rfftfreq(n, 1 / RATE_HZ)
    spectrum = rng.normal(size=(3, len(frequency))) + 1j * rng.normal(size=(3, len(frequency)))
    signal = np.fft.irfft(spectrum * (frequency < corner_hz) * (frequency > 0), n)
    return np.asarray((signal / signal.std(axis=1, keepdims=True)).T * sizes)


def hand(rng: np.random.Generator, n: int) -> Motion:
    """Turned about all axes, with rests."""
    busy = np.repeat(rng.random(n // 500 + 1) < 0.7, 500)[:n, None]
    return busy * _wander(rng, n, 1.0, (1.2, 1.2, 1.2)), busy * _wander(rng, n, 2.0, (1.0, 1.0, 1.0)), np.zeros((n, 3))


def pocket(rng: np.random.Generator, n: int) -> Motion:
    """A walk: the leg swings, heels strike, ways bend, steel passes."""
    t_s = np.arange(n) / RATE_HZ
    step_hz = rng.uniform(1.6, 2.1)
    swing = 0.5 * np.pi * step_hz * np.sin(np.pi * step_hz * t_s)[:, None] * [0.2, 0.9, 0.1]
    strike = np.maximum(0, np.sin(2 * np.pi * step_hz * t_s)) ** 9
    acceleration = np.stack(
        [2 * np.cos(2 * np.pi * step_hz * t_s), np.sin(np.pi * step_hz * t_s), -9 * (strike - strike.mean())], axis=1
    )
    return swing + _wander(rng, n, 0.3, (0.1, 0.1, 0.4)), acceleration, _wander(rng, n, 0.2, (4e-6, 4e-6, 4e-6))


def vehicle(rng: np.random.Generator, n: int) -> Motion:
    """Bends, braking, vibration, steel that passes."""
    rate = _wander(rng, n, 0.15, (0.01, 0.01, 0.15)) + _wander(rng, n, 5.0, (0.02, 0.02, 0.005))
    acceleration = _wander(rng, n, 0.2, (1.2, 1.0, 0.1)) + _wander(rng, n, 30.0, (0.4, 0.4, 0.6))
    return rate, acceleration, _wander(rng, n, 0.5, (2e-6, 2e-6, 2e-6))


def still(rng: np.random.Generator, n: int) -> Motion:
    """On a table, in any attitude."""
    return np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((n, 3))


MOTIONS: dict[str, Callable[[np.random.Generator, int], Motion]]
MOTIONS = {"hand": hand, "pocket": pocket, "vehicle": vehicle, "still": still}


def good_recording(motion: str, grade: str, seed: int, duration_s: float = 40.0) -> Recording:
    """A recording by sensors of a grade; the place lies between 35 and 65 deg of magnetic latitude north."""
    rng = np.random.default_rng([seed, list(MOTIONS).index(motion), GRADES.index(grade)])
    n = round(duration_s * RATE_HZ)
    rate, acceleration, disturbance = MOTIONS[motion](rng, n)
    turns = Rotation.from_rotvec(rate / RATE_HZ)
    level = motion == "vehicle"
    attitude = Rotation.from_euler("z", rng.uniform(-180, 180), degrees=True) if level else Rotation.from_quat(rng.normal(size=4))
    dip = rng.uniform(0.6, 1.25)
    field_n = rng.uniform(35e-6, 60e-6) * np.array([np.cos(dip), 0, np.sin(dip)])
    sensor = ImuMagSensor(ImuMagSensorOptions(seed=seed, **{k.replace(".", "_"): v for k, v in read_grade(grade).values.items()}))
    values = np.full((n, 9), np.nan)
    counts = [0, 0, 0]
    for k in range(n):
        force = attitude.apply(acceleration[k] - [0, 0, G_M_S2], inverse=True)
        field = attitude.apply(field_n + disturbance[k], inverse=True)
        truth = Truth(k / RATE_HZ, np.roll(attitude.as_quat(), 1), np.zeros(3), rate[k], force, field)
        sensor.sample(k / RATE_HZ, truth)
        sensor.advance(k / RATE_HZ)
        for i, name in enumerate(("gyro", "accel", "mag")):
            reading = sensor.reading(name)
            if reading.count > counts[i]:
                counts[i], values[k, 3 * i : 3 * i + 3] = reading.count, reading.value
        attitude = attitude * turns[k]
    t_s = np.arange(n) / RATE_HZ
    return Recording(f"{motion}, {grade}, seed {seed}", t_s, values[:, :3].copy(), values[:, 3:6].copy(), values[:, 6:].copy())
