"""Fixtures of all tests, and the --all switch."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from hnav.io import device_recordings
from hnav.io.readers import read
from hnav.io.readers.broad import find_trials
from hnav.io.recordings import Recording
from motion import Motion, tilted_motion


def pytest_addoption(parser):
    parser.addoption("--all", action="store_true", help="also run the slow tests: whole recordings by every engine")


def pytest_configure(config):
    config.addinivalue_line("markers", "slow: runs only with --all")
    if config.getoption("--all"):
        os.environ.setdefault("HNAV_FUZZ_EXAMPLES", "600")


def pytest_collection_modifyitems(config, items):
    if config.getoption("--all"):
        return
    for item in items:
        if "slow" in item.keywords:
            item.add_marker(pytest.mark.skip(reason="slow: run with --all"))


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
    return read(next(iter(broad_trials.values())))


@pytest.fixture(scope="session")
def wheel() -> Path:
    try:
        return device_recordings.find_wheel()
    except device_recordings.WheelUnavailable as reason:
        pytest.skip(str(reason))


@pytest.fixture(scope="session", params=["xsens", "x_imu"])
def device_recording(request, wheel):
    return getattr(device_recordings, f"read_{request.param}")(wheel).recording
