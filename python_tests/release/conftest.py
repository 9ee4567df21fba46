"""Fixtures of the release tests: its programs as modules, a date, and dist/ where ./run release has made one."""

import os
import sys
from pathlib import Path

import pytest

from checkout import TOP

sys.path.insert(0, str(TOP / "release"))

DIST = Path(os.environ.get("HNAV_DIST", TOP / "dist"))


@pytest.fixture(autouse=True)
def source_date(monkeypatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")


@pytest.fixture
def dist() -> Path:
    if not list(DIST.glob("fmi3/*.fmu")):
        pytest.skip(f"no FMU in {DIST}: ./run release makes them")
    return DIST
