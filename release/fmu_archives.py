"""Puts the binaries of every platform into the FMUs and systems that a build for this machine has made.

    python release/fmu_archives.py BUILD DIST PLATFORM=FOLDER...

BUILD/fmus/fmiN/NAME.fmu brings description, documentation, licences and icons; FOLDER/fmiN/NAME.so or .dll are the
binaries of a platform of release/platforms.py, and DIST/fmiN/NAME.fmu holds those alone. DIST/ssp/NAME.ssp is
BUILD/ssp/NAME.ssp with these FMUs. Each FMU lists what it holds of others (sbom.py) and brings their licences. Equal content
gives equal bytes: every file carries SOURCE_DATE_EPOCH (source_date.py).
"""

from __future__ import annotations

import sys
import zipfile
from pathlib import Path

import sbom
import source_date
from platforms import PLATFORMS

# FMI 2 (from 2.0.2) and FMI 3 keep the names of folders in extra by domain.
SBOM = "extra/org.cyclonedx/sbom.cdx.json"
PLANT = "resources/plant/"  # what an observer observes


def write_archive(built: Path, added: dict[str, bytes], target: Path) -> None:
    """The archive with its binaries, and what else goes by the same name, replaced by added: content by path inside."""
    target.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(built) as source, zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        entries = {n.removeprefix("./"): n for n in source.namelist() if not n.endswith("/")}
        files = {name: source.read(entry) for name, entry in entries.items() if not name.startswith("binaries/")} | added
        for name in sorted(files):
            archive.writestr(zipfile.ZipInfo(name, source_date.of_zip()), files[name], zipfile.ZIP_DEFLATED)


def plants_of(built: Path) -> list[str]:
    """FMUs that lie inside an observer."""
    with zipfile.ZipFile(built) as archive:
        return sorted(
            {
                Path(n).stem
                for n in archive.namelist()
                if n.removeprefix("./").startswith(f"{PLANT}binaries/") and not n.endswith("/")
            }
        )


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


def fmus_of(system: Path, dist: Path) -> dict[str, bytes]:
    """The FMUs of a system as they are in DIST, by path inside the archive. Exits when one is not there."""
    with zipfile.ZipFile(system) as archive:
        names = [n.removeprefix("./") for n in archive.namelist() if n.endswith(".fmu")]
    found = {name: dist / "fmi2" / Path(name).name for name in names}
    for name, path in found.items():
        if not path.is_file():
            sys.exit(f"fmu_archives: {system.name} holds {name}, and there is no {path}")
    return {name: path.read_bytes() for name, path in found.items()}


def about_parts(name: str, binaries: dict[str, bytes], parts: list[sbom.Part]) -> dict[str, bytes]:
    """The list of what the FMU's binaries hold, and the licences that want to be with them, by path inside the archive."""
    licences = {f"documentation/licenses/{part.name}.txt": part.text.read_bytes() for part in parts if part.text}
    return {SBOM: sbom.document(name, parts, binaries)} | licences


def main(build: Path, dist: Path, folders: dict[str, Path]) -> None:
    parts = sbom.read_parts(build)
    for version in (2, 3):
        fmus = sorted((build / "fmus" / f"fmi{version}").glob("*.fmu"))
        if not fmus:
            sys.exit(f"fmu_archives: no FMU in {build / 'fmus' / f'fmi{version}'}")
        for fmu in fmus:
            target = dist / f"fmi{version}" / fmu.name
            binaries = collect(fmu.stem, version, folders)
            for plant in plants_of(fmu):
                binaries |= {PLANT + path: content for path, content in collect(plant, version, folders).items()}
            write_archive(fmu, binaries | about_parts(fmu.name, binaries, [parts[n] for n in sbom.FMU[version]]), target)
            sizes = ", ".join(f"{path.split('/')[1]} {len(content) / 1e6:.2f}" for path, content in binaries.items())
            print(f"{target.relative_to(dist)}: {target.stat().st_size / 1e6:.2f} MB; binaries in MB: {sizes}")
    for system in sorted((build / "ssp").glob("*.ssp")):
        target = dist / "ssp" / system.name
        fmus = fmus_of(system, dist)
        write_archive(system, fmus, target)
        print(f"{target.relative_to(dist)}: {target.stat().st_size / 1e6:.2f} MB; {len(fmus)} FMUs")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), {p: Path(f) for p, f in (a.split("=", 1) for a in sys.argv[3:])})
