"""The .deb and the .tar.gz of the C library, by cpack.

    python release/c_packages.py BUILD DIST

Equal content gives equal bytes: every file carries SOURCE_DATE_EPOCH (source_date.py), and the .tar.gz is written again, for
cpack puts its files in the order of the disk and names who has built it.
"""

from __future__ import annotations

import gzip
import shutil
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

import source_date


def repack(package: Path, target: Path) -> None:
    """The same files, sorted, of one date and of root."""
    with (
        tarfile.open(package) as source,
        target.open("wb") as file,
        gzip.GzipFile("", "wb", fileobj=file, mtime=source_date.seconds()) as packed,
        tarfile.open(mode="w", fileobj=packed, format=tarfile.GNU_FORMAT) as archive,
    ):
        for member in sorted(source.getmembers(), key=lambda m: m.name):
            member.mtime = source_date.seconds()
            member.uid = member.gid = 0
            member.uname = member.gname = "root"
            archive.addfile(member, source.extractfile(member) if member.isfile() else None)


def cpack() -> str:
    """The one beside this Python, which the release pins: versions of cpack write the control file of a .deb differently."""
    pinned = Path(sys.executable).with_name("cpack")
    return str(pinned) if pinned.is_file() else "cpack"


def main(build: Path, dist: Path) -> None:
    source_date.seconds()  # cpack would take the time of day
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run([cpack(), "-G", "DEB;TGZ", "-B", folder], cwd=build, capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"c_packages: cpack\n{(done.stdout + done.stderr)[-2000:]}")
        for package in Path(folder).glob("*.deb"):
            shutil.move(package, dist / package.name)
        for package in Path(folder).glob("*.tar.gz"):
            repack(package, dist / package.name)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
