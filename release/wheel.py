"""Makes a wheel of the Python package for each platform, with library, FMUs and model files inside: none needs a compiler.

    python release/wheel.py BUILD DIST PLATFORM=FOLDER...

BUILD says what the libraries hold of others (sbom.py); FOLDER has the library of a platform of release/platforms.py; DIST/fmi2 and
DIST/fmi3 hold the FMUs, DIST receives the wheels, each with the list of what is inside where PEP 770 wants it. Equal content gives
equal bytes, by SOURCE_DATE_EPOCH (source_date.py).
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import sbom
import source_date
from platforms import PLATFORMS, Platform

from hnav.native.headers import write_binding

TOP = Path(__file__).resolve().parents[1]
CACHES = shutil.ignore_patterns("__pycache__", "*.egg-info", "build")


def stage(library: Path, dist: Path, folder: Path) -> None:
    """The package as it is installed: hnav/ with what hnav.places looks for beside the modules, as cmake/python_package.cmake puts it."""
    shutil.copytree(TOP / "python" / "hnav", folder / "python" / "hnav", ignore=CACHES)
    for name in ("pyproject.toml", "LICENSE"):
        shutil.copy(TOP / name, folder)
    shutil.copytree(TOP / "release" / "from_source", folder / "release" / "from_source", ignore=CACHES)
    package = folder / "python" / "hnav"
    shutil.copy(library, package / library.name)
    write_binding(TOP / "c_src" / "include", package / "native" / "_hnav.py", "cc")
    for version in ("fmi2", "fmi3"):
        shutil.copytree(dist / version, package / "fmus" / version)
    shutil.copytree(TOP / "models", package / "models")


def run(*module: str) -> None:
    done = subprocess.run([sys.executable, "-m", *module], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"wheel: {' '.join(module)}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")


def plain_wheel(platform: Platform, library: Path, dist: Path, folder: Path) -> Path:
    """As pip makes it of what is built already."""
    stage(library, dist, folder / "source")
    settings = ("wheel.cmake=false", "wheel.platlib=true", "wheel.reproducible=true", f"wheel.tags=py3-none-{platform.wheel}")
    options = [f"--config-settings={setting}" for setting in settings]
    run("pip", "wheel", "--no-deps", "--no-build-isolation", *options, "--wheel-dir", str(folder), str(folder / "source"))
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


def make(platform: Platform, library: Path, dist: Path, parts: dict[str, sbom.Part]) -> None:
    """The wheel of one platform, into DIST."""
    if not library.is_file():
        sys.exit(f"wheel: {library} is not built")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        made = plain_wheel(platform, library, dist, folder)
        inside = {f"hnav/{library.name}": library.read_bytes()}
        inside |= {f"hnav/fmus/{p.relative_to(dist)}": p.read_bytes() for p in sorted(dist.glob("fmi?/*.fmu"))}
        holds = {n: sbom.holdings(n.removeprefix("hnav/fmus/")) for n in inside}
        listed = sbom.document(made.name, [parts[n] for n in sbom.WHEEL], inside, holds)
        add_list_of_parts(made, listed, folder / "unpacked")
        shutil.move(made, dist / made.name)
    print(f"{made.name}: {(dist / made.name).stat().st_size / 1e6:.1f} MB")


def main(build: Path, dist: Path, folders: dict[str, Path]) -> None:
    source_date.seconds()  # pip and wheel would take the time of day
    for old in dist.glob("hnav-*.whl"):
        old.unlink()
    parts = sbom.read_parts(build)
    for platform in (p for p in PLATFORMS if p.name in folders):
        make(platform, folders[platform.name] / platform.library, dist, parts)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), {p: Path(f) for p, f in (a.split("=", 1) for a in sys.argv[3:])})
