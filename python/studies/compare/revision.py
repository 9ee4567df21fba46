"""A revision of this repository, built once beside this checkout."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path

from hnav.places import CHECKOUT

REVISION = "d7bc172"
FOLDER = CHECKOUT / ".cache/compare"
# Written last: its presence marks a complete build.
COMPLETE = "complete"
LEAN = ["-DHNAV_BUILD_FMUS=ON", "-DHNAV_BUILD_TESTS=OFF", "-DHNAV_BUILD_BENCH=OFF", "-DHNAV_BUILD_EXAMPLES=OFF"]


def built(revision: str) -> Path:
    """The folder of the revision, with library, binding and FMUs. Raises SystemExit when it cannot be made."""
    commit = _run(["git", "-C", str(CHECKOUT), "rev-parse", "--verify", "--quiet", f"{revision}^{{commit}}"], revision)
    folder = FOLDER / commit.decode().strip()[:12]
    if (folder / COMPLETE).is_file():
        return folder
    print(f"building revision {revision} in {folder}, once", file=sys.stderr)
    folder.mkdir(parents=True, exist_ok=True)
    archive = _run(["git", "-C", str(CHECKOUT), "archive", folder.name], revision)
    subprocess.run(["tar", "-x", "-C", str(folder)], input=archive, check=True)
    fmpy = importlib.util.find_spec("fmpy")
    headers = Path(str(fmpy and fmpy.origin)).parent / "c-code"
    places = [f"-DHNAV_FMI_HEADERS={headers}", f"-DHNAV_PYTHON={sys.executable}"]
    # Reuses the downloads of this checkout.
    sundials = [f"-DHNAV_SUNDIALS_SOURCE={path}" for path in CHECKOUT.glob("build/sundials/source/sundials-*")]
    _run(["cmake", "--preset", "release", *LEAN, *places, *sundials[:1]], revision, folder)
    _run(["cmake", "--build", "build", "--target", "python_binding", "hnav", "fmus"], revision, folder)
    (folder / COMPLETE).touch()
    return folder


def _run(command: list[str], revision: str, folder: Path = CHECKOUT) -> bytes:
    done = subprocess.run(command, cwd=folder, capture_output=True, check=False)
    if done.returncode:
        said = (done.stderr or done.stdout).decode(errors="replace").strip()[-1500:]
        raise SystemExit(f"study compare: revision {revision}: {' '.join(command[:4])} failed: {said}")
    return done.stdout
