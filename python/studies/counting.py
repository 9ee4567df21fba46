"""Instructions of one function of a program, counted by valgrind: they do not depend on what else the machine does."""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from hnav.cli.words import UsageError
from studies.compare.inputs import prepare_trials, trial
from studies.compare.old_revision import TOP

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


def write_samples(file: Path, rows: int) -> None:
    """t_s (n), rate, force and field (n x 3) as doubles, one behind the other. Raises UsageError without the recording."""
    inputs = TOP / ".cache" / "compare" / "inputs"
    inputs.mkdir(parents=True, exist_ok=True)
    if TRIAL not in prepare_trials(inputs):
        raise UsageError(f"BROAD_DIR holds no trial {TRIAL:02d}")
    samples = trial(inputs, TRIAL)
    arrays = (samples.t_s, samples.rate, samples.force, samples.field)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(b"".join(np.ascontiguousarray(a[:rows]).tobytes() for a in arrays))
