"""Installs the wheel of a release into a folder of its own and runs what its users run, away from the checkout.

    python release/installed.py DIST

`hnav filter` reads the example input of an FMU as a recording, by the library and by both FMU versions, which have to agree;
`hnav simulate` runs the systems by name. What the wheel depends on is taken from the environment of this Python. Exits with
the first thing that fails.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

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


def main(dist: Path) -> None:
    wheels = list(dist.glob("hnav-*.whl"))
    if len(wheels) != 1:
        sys.exit(f"installed: {len(wheels)} wheels in {dist}, there has to be one")
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
            str(wheels[0].resolve()),
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
        f"{wheels[0].name}, installed: hnav filter by {', '.join(ENGINES)} with equal last rows; hnav simulate {', '.join(s for s, _ in SYSTEMS)}"
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]))
