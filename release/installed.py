"""Installs the wheel of this machine into a folder of its own and runs what its users run, away from the checkout.

    python release/installed.py DIST PLATFORM=PROGRAM...

`hnav filter` reads the example input of an FMU as a recording, by the library and by both FMU versions, which have to agree;
`hnav simulate` runs the systems by name. What the wheel depends on is taken from the environment of this Python. PROGRAM is
c_src/examples/minimal.c for a platform of release/platforms.py: it runs with the library of that platform's wheel, elsewhere
than here under an emulator; a platform without one is named. Exits with the first thing that fails.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import packages
from platforms import PLATFORMS, Platform

ENGINES = ("c", "fmi2-cs", "fmi3-cs")
SYSTEMS = (("turntable", "5"), ("aircraft", "5"))
COLUMNS = "t_s,gx,gy,gz,ax,ay,az,mx,my,mz"


def run(folder: Path, *command: str) -> str:
    """In the folder, with the package that is installed there. Exits with the end of what the command said when it fails."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith("HNAV_")} | {"PYTHONPATH": str(folder / "package")}
    done = subprocess.run([sys.executable, *command], cwd=folder, env=environment, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"installed: {' '.join(command)}\n{(done.stdout + done.stderr)[-2000:]}")
    return done.stdout


def wheel_of(platform: Platform, dist: Path) -> Path:
    """Exits when there is none, or more than one."""
    wheels = list(dist.glob(f"hnav-*-{platform.wheel}.whl"))
    if len(wheels) != 1:
        sys.exit(f"installed: {len(wheels)} wheels for {platform.name} in {dist}, there has to be one")
    return wheels[0]


def library_answers(platform: Platform, wheel: Path, program: Path) -> None:
    """The example in C, with the library that is in the wheel. Exits when it says something else than it should."""
    with tempfile.TemporaryDirectory(prefix="hnav wheel ") as name:
        folder = Path(name)
        shutil.copy(program, folder)
        with zipfile.ZipFile(wheel) as archive:
            content = archive.read(f"hnav/{platform.library}")
        # By the name that a program asks for: on Linux the one with the version of the interface.
        asked_for = platform.library + (f".{packages.version().rpartition('.')[0]}" if platform.suffix == ".so" else "")
        Path(folder, asked_for).write_bytes(content)
        environment = os.environ | {"LD_LIBRARY_PATH": str(folder), "WINEDEBUG": "-all"}
        command = [*(platform.runner() or []), folder / program.name]
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    if packages.ANSWER not in done.stdout:
        sys.exit(f"installed: {wheel.name}: {program.name} says {(done.stdout + done.stderr).strip()[-500:] or 'nothing'}")
    print(f"{wheel.name}: a C program with its library finds the attitude on {platform.name}")


def main(dist: Path, programs: dict[str, Path]) -> None:
    here = wheel_of(PLATFORMS[0], dist)
    package_works(here, dist)
    for platform in (p for p in PLATFORMS if p.name in programs):
        if platform.runner() is None:
            print(f"installed: the wheel for {platform.name} not tried: {platform.advice()}")
        else:
            library_answers(platform, wheel_of(platform, dist), programs[platform.name])


def package_works(wheel: Path, dist: Path) -> None:
    """Command line, library, FMUs and systems of the wheel."""
    with tempfile.TemporaryDirectory(prefix="hnav wheel ") as name:
        folder = Path(name).resolve()
        run(
            folder,
            "-m",
            "pip",
            "install",
            "--disable-pip-version-check",
            "--no-deps",
            "--target",
            "package",
            str(wheel.resolve()),
        )
        where = run(folder, "-c", "import hnav; print(hnav.__file__)").strip()
        if not Path(where).is_relative_to(folder):
            sys.exit(f"installed: Python takes {where}, not what was installed")

        with zipfile.ZipFile(dist / "fmi3" / "Hrekf.fmu") as fmu:
            rows = fmu.read("resources/example_input.csv").decode().splitlines()[1:]
        Path(folder, "recording.csv").write_text("\n".join([COLUMNS, *rows]) + "\n")
        last = {}
        for engine in ENGINES:
            run(folder, "-m", "hnav", "filter", "recording.csv", "--engine", engine, "--out", f"{engine}.csv")
            last[engine] = Path(folder, f"{engine}.csv").read_text().splitlines()[-1]
        if len(set(last.values())) != 1:
            sys.exit("installed: hnav filter ends differently: " + "; ".join(f"{engine}: {row}" for engine, row in last.items()))
        for system, stop in SYSTEMS:
            run(folder, "-m", "hnav", "simulate", system, "--stop", stop, "--out", f"{system}_out")
    print(
        f"{wheel.name}, installed: hnav filter by {', '.join(ENGINES)} with equal last rows; hnav simulate {', '.join(s for s, _ in SYSTEMS)}"
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]), {p: Path(f) for p, f in (a.split("=", 1) for a in sys.argv[2:])})
