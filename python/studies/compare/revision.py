"""A revision of this repository, built once beside this checkout."""

from __future__ import annotations

import sys
from pathlib import Path

from hnav.places import CHECKOUT
from studies.processes import fmi_headers, said_by, sundials_source

REVISION = "d7bc172"
FOLDER = CHECKOUT / ".cache/compare"
LEAN = ["-DHNAV_BUILD_FMUS=ON", "-DHNAV_BUILD_TESTS=OFF", "-DHNAV_BUILD_BENCH=OFF", "-DHNAV_BUILD_EXAMPLES=OFF"]


def built(revision: str) -> Path:
    """The folder of the revision, with library, binding and FMUs. Raises UsageError when it cannot be made."""
    commit = said_by(["git", "rev-parse", "--verify", f"{revision}^{{commit}}"], cwd=CHECKOUT)
    folder = FOLDER / commit[:12]
    complete = folder / "complete"  # written last
    if complete.is_file():
        return folder
    print(f"building revision {revision} in {folder}, once", file=sys.stderr)
    folder.mkdir(parents=True, exist_ok=True)
    said_by(["git", "archive", "--output", folder / "source.tar", folder.name], cwd=CHECKOUT)
    said_by(["tar", "-x", "-f", "source.tar"], cwd=folder)
    places = {"FMI_HEADERS": fmi_headers(), "PYTHON": sys.executable, "SUNDIALS_SOURCE": sundials_source()}
    said_by(["cmake", "--preset", "release", *LEAN, *(f"-DHNAV_{name}={place}" for name, place in places.items())], cwd=folder)
    said_by(["cmake", "--build", "build", "--target", "python_binding", "hnav", "fmus"], cwd=folder)
    complete.touch()
    return folder
