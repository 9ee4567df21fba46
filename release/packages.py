"""Unpacks the .deb and the .tar.gz of a release and uses each as another project would.

    python release/packages.py DIST

c_src/examples/consumer is built by find_package, with the shared and with the static library, and its one source by
pkg-config, also as one static program; all four have to run and find the attitude. Exits with the first thing that fails.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

TOP = Path(__file__).resolve().parents[1]
EXAMPLE = TOP / "c_src" / "examples"
ANSWER = "roll 20.0  pitch 5.0  heading 30.0 deg"


def run(package: str, *command: str | Path, **environment: str) -> str:
    """Standard output. Exits with the end of what the command said when it fails."""
    done = subprocess.run(command, capture_output=True, text=True, env=os.environ | environment)
    if done.returncode:
        sys.exit(f"packages: {package}: {' '.join(map(str, command))}\n{(done.stdout + done.stderr)[-2000:]}")
    return done.stdout


def unpack(package: Path, folder: Path) -> Path:
    """The folder inside with include and lib."""
    if package.suffix == ".deb":
        run(package.name, "dpkg-deb", "-x", package, folder)
    else:
        with tarfile.open(package) as archive:
            archive.extractall(folder)
    found = list(folder.glob("**/pkgconfig/hnav.pc"))
    if len(found) != 1:
        sys.exit(f"packages: {package.name}: {len(found)} files hnav.pc inside, there has to be one")
    return found[0].parents[2]


def use(package: str, prefix: Path, build: Path) -> str:
    """Builds and runs the programs. Returns the version by pkg-config."""
    run(package, "cmake", "-S", EXAMPLE / "consumer", "-B", build, f"-DCMAKE_PREFIX_PATH={prefix}", "-DCMAKE_BUILD_TYPE=Release")
    run(package, "cmake", "--build", build)
    pkg_config = {"PKG_CONFIG_PATH": str(prefix / "lib" / "pkgconfig")}
    flags = shlex.split(run(package, "pkg-config", "--cflags", "--libs", "hnav", **pkg_config))
    run(package, "cc", EXAMPLE / "minimal.c", "-o", build / "by_pkg_config", *flags)
    flags = shlex.split(run(package, "pkg-config", "--static", "--cflags", "--libs", "hnav", **pkg_config))
    run(package, "cc", EXAMPLE / "minimal.c", "-o", build / "all_static", "-static", *flags)
    for name in ("with_shared", "with_static", "by_pkg_config", "all_static"):
        said = run(package, build / name, LD_LIBRARY_PATH=str(prefix / "lib"))
        if ANSWER not in said:
            sys.exit(f"packages: {package}: {name} says {said.strip() or 'nothing'}, not {ANSWER}")
    return run(package, "pkg-config", "--modversion", "hnav", **pkg_config).strip()


def version() -> str:
    """Of the project, which the public header says."""
    header = (TOP / "c_src" / "include" / "hnav" / "types.h").read_text()
    return ".".join(re.findall(r"define HNAV_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)", header))


def main(dist: Path) -> None:
    for pattern in ("*.tar.gz", "*.deb"):
        packages = list(dist.glob(f"libhnav-dev*{pattern[1:]}"))
        if len(packages) != 1:
            sys.exit(f"packages: {len(packages)} files {pattern} in {dist}, there has to be one")
        package = packages[0]
        if package.suffix == ".deb" and shutil.which("dpkg-deb") is None:
            print(f"packages: {package.name} not checked: dpkg-deb is missing (Debian, Ubuntu: apt-get install dpkg)")
            continue
        # A blank in the path, which users have.
        with tempfile.TemporaryDirectory(prefix="hnav package ") as folder:
            found = use(package.name, unpack(package, Path(folder, "root")), Path(folder, "build"))
        if found != version():
            sys.exit(f"packages: {package.name}: pkg-config says version {found}, hnav/types.h {version()}")
        size = package.stat().st_size / 1e6
        print(f"{package.name}: {size:.1f} MB; find_package with shared and static library and pkg-config give programs that run")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
