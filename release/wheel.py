"""Builds the wheel of the Python package with library, FMUs and model files inside: it needs no compiler where it is used.

    python release/wheel.py BUILD DIST

BUILD has libhnav.so for x86-64 Linux with glibc 2.17; DIST/fmi2 and DIST/fmi3 hold the FMUs, DIST receives the wheel, with a
list of what is inside (sbom.py) where PEP 770 wants it. Equal content gives equal bytes, by SOURCE_DATE_EPOCH (source_date.py).
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import sbom
import source_date

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


def run(*module: str) -> None:
    done = subprocess.run([sys.executable, "-m", *module], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"wheel: {' '.join(module)}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")


def pure_wheel(library: Path, dist: Path, folder: Path) -> Path:
    """As pip makes it."""
    stage(library, dist, folder / "source")
    run("pip", "wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", str(folder), str(folder / "source"))
    return next(folder.glob("hnav-*.whl"))


def add_list_of_parts(wheel: Path, inside: bytes, folder: Path) -> None:
    """folder: to unpack the wheel in."""
    run("wheel", "unpack", "--dest", str(folder), str(wheel))
    unpacked = next(folder.glob("hnav-*"))
    lists = next(unpacked.glob("*.dist-info")) / "sboms"
    lists.mkdir()
    (lists / "hnav.cdx.json").write_bytes(inside)
    # Access rights travel in the wheel, and those of checkouts differ.
    for path in unpacked.rglob("*"):
        path.chmod(0o755 if path.is_dir() else 0o644)
    run("wheel", "pack", "--dest-dir", str(wheel.parent), str(unpacked))


def main(build: Path, dist: Path) -> None:
    source_date.seconds()  # pip and wheel would take the time of day
    for old in dist.glob("hnav-*.whl"):
        old.unlink()
    parts = sbom.read_parts(build)
    library = (build / "c_src" / "libhnav.so").resolve()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        pure = pure_wheel(library, dist, folder)
        # setuptools takes a package without extension modules for one that runs anywhere.
        run("wheel", "tags", "--remove", "--python-tag=py3", "--abi-tag=none", f"--platform-tag={PLATFORM}", str(pure))
        made = next(folder.glob("hnav-*.whl"))
        inside = {"hnav/libhnav.so": library.read_bytes()}
        inside |= {f"hnav/fmus/{p.relative_to(dist)}": p.read_bytes() for p in sorted(dist.glob("fmi?/*.fmu"))}
        holds = {n: sbom.LIBRARY if n.endswith(".so") else sbom.holdings(n.removeprefix("hnav/fmus/")) for n in inside}
        listed = sbom.document(made.name, [parts[n] for n in sbom.WHEEL], inside, holds)
        add_list_of_parts(made, listed, folder / "unpacked")
        shutil.move(made, dist / made.name)
    print(f"{made.name}: {(dist / made.name).stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
