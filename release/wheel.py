"""Builds the wheel of the Python package with library, FMUs and model files inside: it needs no compiler where it is used.

    python release/wheel.py LIBRARY DIST

LIBRARY is libhnav.so for x86-64 Linux with glibc 2.17; DIST/fmi2 and DIST/fmi3 hold the FMUs, DIST receives the wheel.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from hnav.native.headers import write_binding

TOP = Path(__file__).resolve().parents[1]
PLATFORM = "manylinux_2_17_x86_64"
CACHES = shutil.ignore_patterns("__pycache__", "*.egg-info", "build")


def stage(library: Path, dist: Path, folder: Path) -> None:
    """The package as it is installed: hnav/ with what hnav.native.library, hnav.fmi.fmus and hnav.io.model_files look for beside them."""
    shutil.copytree(TOP / "python" / "hnav", folder / "python" / "hnav", ignore=CACHES)
    shutil.copy(TOP / "pyproject.toml", folder)
    package = folder / "python" / "hnav"
    shutil.copy(library, package / "libhnav.so")
    write_binding(TOP / "c_src" / "include", package / "native" / "_hnav.py", "cc")
    for version in ("fmi2", "fmi3"):
        shutil.copytree(dist / version, package / "fmus" / version)
    shutil.copytree(TOP / "models", package / "models")
    shutil.copy(TOP / "LICENSE", folder)


def run(*command: str) -> None:
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"wheel: {' '.join(command)}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")


def main(library: Path, dist: Path) -> None:
    for old in dist.glob("hnav-*.whl"):
        old.unlink()
    with tempfile.TemporaryDirectory() as folder:
        stage(library, dist, Path(folder, "source"))
        run(
            sys.executable,
            "-m",
            "pip",
            "wheel",
            "--no-deps",
            "--no-build-isolation",
            "--wheel-dir",
            folder,
            str(Path(folder, "source")),
        )
        # setuptools takes a package without extension modules for one that runs anywhere.
        pure = next(Path(folder).glob("hnav-*.whl"))
        run(
            sys.executable,
            "-m",
            "wheel",
            "tags",
            "--remove",
            "--python-tag=py3",
            "--abi-tag=none",
            f"--platform-tag={PLATFORM}",
            str(pure),
        )
        made = next(Path(folder).glob("hnav-*.whl"))
        shutil.move(made, dist / made.name)
    print(f"{made.name}: {(dist / made.name).stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
