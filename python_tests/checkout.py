"""The folders of the checkout and of its build."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

HELPERS = Path(__file__).resolve().parent
TOP = HELPERS.parent
BUILD = Path(os.environ.get("HNAV_BUILD", TOP / "build"))


def built_system(name: str) -> str:
    """The archive of a system; the test is skipped where it is not built."""
    path = BUILD / "ssp" / f"{name}.ssp"
    if not path.is_file():
        pytest.skip(f"{path} is not built")
    return str(path)


def in_another_process(code: str, *folders: Path) -> str:
    """The output of Python code in a process of its own, which finds the modules of the folders and the helpers of the tests."""
    paths = [str(folder) for folder in (*folders, HELPERS)]
    done = subprocess.run(
        [sys.executable, "-c", f"import sys\nsys.path[:0] = {paths!r}\n{code}"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout
