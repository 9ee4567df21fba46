"""Puts the binaries of every platform into the FMUs that this machine's build has made.

    python release/fmu_archives.py HOST_FMUS DIST PLATFORM=FOLDER...

HOST_FMUS/fmiN/NAME.fmu brings description, documentation, licences and icons; FOLDER/fmiN/NAME.so or .dll are the
binaries of a platform of release/platforms.py. DIST/fmiN/NAME.fmu holds those and none of this machine's own, whose
glibc would be too new for others. Equal content gives equal bytes: the archives carry no time of day.
"""

from __future__ import annotations

import sys
import zipfile
from pathlib import Path

from platforms import PLATFORMS

LONG_AGO = (1980, 1, 1, 0, 0, 0)


def write_archive(host: Path, binaries: dict[str, bytes], target: Path) -> None:
    """binaries: content by path inside the archive."""
    target.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(host) as source, zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        entries = {n.removeprefix("./"): n for n in source.namelist() if not n.endswith("/")}
        files = {name: source.read(entry) for name, entry in entries.items() if not name.startswith("binaries/")} | binaries
        for name in sorted(files):
            archive.writestr(zipfile.ZipInfo(name, LONG_AGO), files[name], zipfile.ZIP_DEFLATED)


def collect(name: str, version: int, folders: dict[str, Path]) -> dict[str, bytes]:
    """The FMU's binaries for every platform that its version has a name for. Exits when one was not built."""
    binaries = {}
    for platform in PLATFORMS:
        if platform.folder(version) is None or platform.name not in folders:
            continue
        path = folders[platform.name] / f"fmi{version}" / f"{name}{platform.suffix}"
        if not path.is_file():
            sys.exit(f"fmu_archives: {path} is not built")
        binaries[f"binaries/{platform.folder(version)}/{name}{platform.suffix}"] = path.read_bytes()
    return binaries


def main(host: Path, dist: Path, folders: dict[str, Path]) -> None:
    for version in (2, 3):
        fmus = sorted((host / f"fmi{version}").glob("*.fmu"))
        if not fmus:
            sys.exit(f"fmu_archives: no FMU in {host / f'fmi{version}'}")
        for fmu in fmus:
            target = dist / f"fmi{version}" / fmu.name
            binaries = collect(fmu.stem, version, folders)
            write_archive(fmu, binaries, target)
            print(f"{target.relative_to(dist)}: {', '.join(b.split('/')[1] for b in binaries)}, {target.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), {p: Path(f) for p, f in (a.split("=", 1) for a in sys.argv[3:])})
