"""What the tests share: simulated motion, BROAD trials, and the --all switch."""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hnav.io.recordings import Recording, find_trials, read_recording


def pytest_addoption(parser):
    parser.addoption("--all", action="store_true", help="also run the slow tests: whole recordings by every engine")


def pytest_configure(config):
    config.addinivalue_line("markers", "slow: runs only with --all")


def pytest_collection_modifyitems(config, items):
    if config.getoption("--all"):
        return
    for item in items:
        if "slow" in item.keywords:
            item.add_marker(pytest.mark.skip(reason="slow: run with --all"))


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
    attitude = [Rotation.from_euler("x", 20, degrees=True)]
    for k in range(len(t) - 1):
        attitude.append(attitude[-1] * Rotation.from_rotvec(w[k] * 0.01))
    attitude = Rotation.concatenate(attitude)
    force = attitude.apply([0, 0, -9.81], inverse=True) + noise * 0.05 * rng.normal(size=w.shape)
    field = attitude.apply([2e-5, 0, 4.5e-5], inverse=True) + noise * 2e-7 * rng.normal(size=w.shape)
    rate = w + bias + noise * 0.01 * rng.normal(size=w.shape)
    q = attitude.as_quat()[:, [3, 0, 1, 2]]
    return Motion(Recording("tilted motion", t, rate, force, field, q), np.array(bias))


@pytest.fixture(scope="session")
def motion() -> Motion:
    return tilted_motion(3)


@pytest.fixture(scope="session")
def broad_trials() -> dict:
    folder = os.environ.get("BROAD_DIR")
    if not folder:
        pytest.skip("BROAD_DIR is not set: no BROAD recordings")
    return find_trials(folder)


@pytest.fixture(scope="session")
def broad_trial(broad_trials) -> Recording:
    return read_recording(next(iter(broad_trials.values())))
