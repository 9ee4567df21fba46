"""python -m studies.instructions: builds the driver for each side and runs it under callgrind."""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from fnmatch import fnmatch
from pathlib import Path

import numpy as np

from studies.compare.inputs import prepare_trials, trial
from studies.compare.names import Names
from studies.compare.native import Library
from studies.compare.old_revision import REVISION, TOP, old_revision

TRIAL, ROWS = 7, 20000
WORK = TOP / ".cache" / "instructions"
TOLERANCE = 0.02  # of the old count; above it the study fails
# Filter, call, outputs, choices.
CASES = {
    "ahrs closed form, q": ("ahrs", "run", "q", "solver=closed_form"),
    "ahrs closed form, q and sigma": ("ahrs", "run", "sigma", "solver=closed_form"),
    "ahrs ERKStep, q": ("ahrs", "run", "q"),
    "ahrs ERKStep, q and sigma": ("ahrs", "run", "sigma"),
    "smoother closed form": ("ahrs", "smooth", "q", "solver=closed_form"),
    "smoother ERKStep": ("ahrs", "smooth", "q"),
    **{
        f"hrekf {label} gamma {mode}": ("hrekf", "run", "q", f"solver={solver}", f"gamma_mode={mode}")
        for label, solver in (("closed form", "closed_form"), ("ERKStep", "erkstep"))
        for mode in ("off", "fixed", "relative", "kl")
    },
}


def renamed(checkout: Path, names: Names) -> list[str]:
    """Macros that give the driver, which is written in new names, the names that this checkout has."""
    library = Library(checkout / "build/c_src/libhnav.so", checkout / "c_src/include", names)
    wanted = set(re.findall(r"\bhnav_\w+", (Path(__file__).parent / "driver.c").read_text()))
    macros = []
    for name in sorted(wanted):
        for kind, is_there in (("call", library.has_function), ("type", library.has_type)):
            old = [c for c in names.candidates(kind, name) if c != name and is_there(c)]
            if old and not is_there(name):
                macros.append(f"-D{name}={old[0]}")
    sized = [library.ffi.typeof(f"hnav_run_{side}").fields[0][0] == "size" for side in ("input", "output")]
    return macros + (["-DSIZED"] if all(sized) else [])


def driver_of(checkout: Path, label: str) -> Path:
    """The driver, linked with the library of a checkout."""
    folder, program = checkout / "build/c_src", WORK / f"driver_{label}"
    command = ["cc", "-O2", "-o", str(program), str(Path(__file__).parent / "driver.c"), "-I", str(checkout / "c_src/include")]
    command += renamed(checkout, Names()) + ["-L", str(folder), "-lhnav", f"-Wl,-rpath,{folder}"]
    subprocess.run(command, check=True)
    return program


def count(program: Path, samples: Path, rows: int, case: tuple[str, ...]) -> int:
    """Instructions of the one call, divided by the rows. Raises SystemExit when it fails."""
    filter, call, *more = case
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            ["valgrind", "--tool=callgrind", "--collect-atstart=no", f"--toggle-collect=hnav_filter_{call}",
             f"--callgrind-out-file={folder}/out", str(program), str(samples), str(rows), filter, call, *more],
            capture_output=True, text=True, check=False,
        )  # fmt: skip
    found = re.search(r"Collected : (\d+)", done.stderr)
    if done.returncode or not found:
        raise SystemExit(f"study instructions: {program.name} {' '.join(case)} failed:\n{done.stderr[-1500:]}")
    return round(int(found.group(1)) / rows)


def write_samples(rows: int) -> Path:
    inputs = TOP / ".cache" / "compare" / "inputs"
    inputs.mkdir(parents=True, exist_ok=True)
    if TRIAL not in prepare_trials(inputs):
        raise SystemExit(f"study instructions: BROAD_DIR holds no trial {TRIAL:02d}")
    samples, file = trial(inputs, TRIAL), WORK / "samples.bin"
    arrays = (samples.t_s, samples.rate, samples.force, samples.field)
    file.write_bytes(b"".join(np.ascontiguousarray(a[:rows]).tobytes() for a in arrays))
    return file


def main() -> None:
    parser = argparse.ArgumentParser(prog="./run study instructions", description="Instructions for each IMU sample.")
    parser.add_argument("--only", metavar="PATTERN", default="*", help="cases whose names match, * and ? allowed")
    parser.add_argument("--rows", type=int, default=ROWS, help=f"rows of the recording ({ROWS})")
    parser.add_argument("--old", type=Path, metavar="FOLDER", help=f"a checkout with its build instead of {REVISION}")
    parser.add_argument("--new", type=Path, metavar="FOLDER", default=TOP, help="a checkout with its build instead of this one")
    chosen = parser.parse_args()
    if not shutil.which("valgrind"):
        raise SystemExit("study instructions: valgrind is not here (apt-get install valgrind)")
    WORK.mkdir(parents=True, exist_ok=True)
    samples = write_samples(chosen.rows)
    sides = {"old": (chosen.old or old_revision()).resolve(), "new": chosen.new.resolve()}
    drivers = {label: driver_of(checkout, label) for label, checkout in sides.items()}
    print(f"{'instructions for each sample':<34}{'old':>9}{'new':>9}{'ratio':>9}")
    worst = 0.0
    with ThreadPoolExecutor(2) as pool:
        for name, case in CASES.items():
            if not fnmatch(name, chosen.only):
                continue
            before, after = pool.map(lambda program, case=case: count(program, samples, chosen.rows, case), drivers.values())
            worst = max(worst, after / before)
            print(f"{name:<34}{before:>9}{after:>9}{after / before:>9.3f}", flush=True)
    sys.exit(1 if worst > 1 + TOLERANCE else 0)


if __name__ == "__main__":
    main()
