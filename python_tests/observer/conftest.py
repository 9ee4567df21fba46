"""Plants of the tests: a small FMU compiled here, and FMUs of other tools in the folder HNAV_PLANTS."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from observer.little_fmu import compiled, packed


@pytest.fixture(scope="session")
def little_binary(tmp_path_factory) -> Path:
    return compiled(tmp_path_factory.mktemp("little"))


@pytest.fixture(scope="session")
def little_fmu(little_binary, tmp_path_factory) -> Path:
    return packed(tmp_path_factory.mktemp("little") / "little.fmu", little_binary)


@pytest.fixture(scope="session")
def plants() -> Path:
    folder = os.environ.get("HNAV_PLANTS")
    if not folder:
        pytest.skip("HNAV_PLANTS is not set: no FMUs of other makers")
    return Path(folder)
