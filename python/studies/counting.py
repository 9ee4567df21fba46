"""Programs that are measured: built with the library of a checkout, timed, and their instructions counted by valgrind, which do not
depend on what else the machine does."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hnav.cli.words import UsageError
from hnav.io.readers import read
from hnav.io.readers.broad import find_trial
from studies.processes import said_by

TRIAL, ROWS = 7, 20000  # of BROAD: 70 s at 286 Hz


def has_valgrind() -> bool:
    return shutil.which("valgrind") is not None


def counted(function: str, command: Sequence[str | Path]) -> int:
    """All instructions of the calls of a C function. Raises UsageError when the program fails."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            ["valgrind", "--tool=callgrind", "--collect-atstart=no", f"--toggle-collect={function}",
             f"--callgrind-out-file={folder}/out", *map(str, command)],
            capture_output=True, text=True, check=False,
        )  # fmt: skip
    found = re.search(r"Collected : (\d+)", done.stderr)
    if done.returncode or not found:
        raise UsageError(f"{' '.join(map(str, command))} failed:\n{done.stderr[-1500:]}")
    return int(found.group(1))


def compile_program(
    sources: Sequence[Path], program: Path, checkout: Path, folders: Sequence[Path] = (), objects: Sequence[Path] = ()
) -> Path:
    """A program of C++ sources and objects, with headers in these folders and beside this file, linked with the library of a checkout.

    Raises UsageError.
    """
    program.parent.mkdir(parents=True, exist_ok=True)
    headers = [f"-I{folder}" for folder in (checkout / "c_src/include", Path(__file__).parent, *folders)]
    library = checkout / "build/c_src"
    link: list[str | Path] = ["-L", library, "-lhnav", f"-Wl,-rpath,{library}", "-o", program]
    said_by(["c++", "-std=c++17", "-O3", *headers, *sources, *objects, *link])
    return program


def times_ns(command: Sequence[str | Path]) -> list[float]:
    """What a program prints, one number a line. Raises UsageError with what it complains about."""
    return [float(line) for line in said_by(command).split()]


def write_samples(file: Path, rows: int) -> None:
    """t_s (n), rate, force and field (n x 3) as doubles, one behind the other. Raises UsageError without the recording."""
    if "BROAD_DIR" not in os.environ:
        raise UsageError("BROAD_DIR is not set: it names the folder of the BROAD trials")
    data = read(find_trial(os.environ["BROAD_DIR"], TRIAL))
    arrays = (data.t_s, data.rate_b_rad_s, data.force_b_m_s2, data.field_b_tesla)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(b"".join(np.ascontiguousarray(a[:rows]).tobytes() for a in arrays if a is not None))


class Cost(NamedTuple):
    """Of a command: seconds of the clock and of the processor, and the most memory of its process or of one of its workers."""

    wall_s: float
    cpu_s: float
    memory_bytes: float


LAUNCHER = """
import resource, subprocess, sys, time
begin = time.perf_counter()
code = subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL).returncode
wall, used = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
print(wall, used.ru_utime + used.ru_stime, used.ru_maxrss * (1 if sys.platform == "darwin" else 1024))
sys.exit(code)
"""


def cost_of_hnav(*words: object) -> Cost:
    """Of hnav with these words. Raises UsageError when it fails.

    A small process starts it: the largest memory of a process includes that of its parent at the start.
    """
    said = said_by([sys.executable, "-c", LAUNCHER, sys.executable, "-m", "hnav", *map(str, words)])
    return Cost(*map(float, said.split()))
