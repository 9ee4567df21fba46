"""Stamps that differ in their last bits are the same stamps: estimates differ by less than a millionth of their sigma."""

import math
import random

import numpy as np
import pytest

from hnav import Filter
from hnav.filters.options import Options

ALMOST_S = 1e-13
LARGEST = 1e-6
RATES_HZ = (25, 50, 100, 104, 119, 128, 200, 225, 238, 250, 256, 285.7, 300, 400, 416, 500, 512, 833, 952, 1000)


def accumulated(period_s: float, samples: int) -> list[float]:
    t = [0.0]
    for _ in range(samples - 1):
        t.append(t[-1] + period_s)
    return t


def stamps(variant: str, period_s: float, samples: int) -> list[tuple[float, float, float, float]]:
    """Of gyroscope, accelerometer and magnetometer, and the time that is then asked for."""
    draw, exact = random.Random(7), [k * period_s for k in range(samples)]
    if variant == "accumulated":
        return [(t, t, t, t) for t in accumulated(period_s, samples)]
    rows = []
    for t in exact:
        moves = [draw.uniform(-ALMOST_S, ALMOST_S) for _ in range(4)]
        moves = {"exact": [0.0] * 4, "together": moves[:1] * 4, "apart": moves}[variant]
        rows.append(tuple(t + move for move in moves))
    return rows


def run(name: str, variant: str, period_s: float = 0.01, samples: int = 600) -> np.ndarray:
    """Attitude and sigma after each row, with a body that sways."""
    noise, rows = np.random.default_rng(3).normal(size=(samples, 9)), []
    f = Filter(name, start_samples=1)
    for k, (gyro, accel, mag, asked) in enumerate(stamps(variant, period_s, samples)):
        roll = 0.4 * math.sin(k * period_s)
        f.push_gyro(gyro, np.array([0.4 * math.cos(k * period_s), 0, 0]) + 0.002 * noise[k, :3])
        f.push_accel(accel, np.array([0, -9.81 * math.sin(roll), -9.81 * math.cos(roll)]) + 0.05 * noise[k, 3:6])
        f.push_mag(mag, np.array([2e-5, 4.5e-5 * math.sin(roll), 4.5e-5 * math.cos(roll)]) + 5e-7 * noise[k, 6:])
        f.advance(asked)
        shown = f.attitude()
        rows.append([*shown.q_nb, *shown.sigma_rad])
    return np.array(rows)


def assert_same(found: np.ndarray, expected: np.ndarray) -> None:
    sigma = np.min(expected[:, 4:], axis=1, keepdims=True)
    assert np.max(np.abs(found - expected) / sigma) < LARGEST


@pytest.mark.parametrize("variant", ("accumulated", "together", "apart"))
@pytest.mark.parametrize("name", ("ahrs", "hrekf"))
def test_last_bits_of_stamps_change_no_estimate(name, variant):
    assert_same(run(name, variant), run(name, "exact"))


@pytest.mark.parametrize("rate_hz", RATES_HZ)
def test_no_usual_rate_has_two_samples_equally_near_to_a_correction(rate_hz):
    for name in ("ahrs", "ins"):
        samples = Options(name).correction_interval_s * rate_hz
        assert abs(samples % 1 - 0.5) > 1e-3


def test_samples_of_one_instant_are_one_event_whatever_their_order():
    found = []
    for turn in (1, -1):
        f = Filter("hrekf")
        for k in range(200):
            t = 0.01 * k
            calls = [
                (f.push_gyro, t + 5e-14, [0.1, 0, 0]),
                (f.push_accel, t, [0, 0, -9.81]),
                (f.push_mag, t + 9e-14, [2e-5, 0, 4.5e-5]),
            ]
            for push, stamp_s, value in calls[::turn]:
                push(stamp_s, value)
            f.advance(t)
        found.append((tuple(f.attitude().q_nb), f.diagnostics().corrections))
    assert found[0] == found[1] and found[0][1] == 198  # two samples are the start
