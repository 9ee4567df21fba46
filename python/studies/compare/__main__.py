"""python -m studies.compare: the two sides at work side by side, and what comes of it."""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import time
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from studies.compare import frozen
from studies.compare.inputs import prepare_trials
from studies.compare.old_revision import FOLDER, TOP, old_revision
from studies.compare.scenarios import all_scenarios, tolerance_of
from studies.compare.verdict import declared_exceptions, differences, reason_for
from studies.compare.worker import file_of

POLL_S = 0.05
SHOWN = 6  # differences of one scenario that are printed
WORK = TOP / ".cache" / "compare"
INPUTS = WORK / "inputs"


class Answers:
    """A worker process of one side and the files that it leaves."""

    def __init__(self, folder: Path, checkout: Path, names: list[str]):
        self._folder, self._log = folder, folder / "log"
        folder.mkdir()
        python = [str(checkout / "python"), str(TOP / "python")]
        found_there = {
            "PYTHONPATH": os.pathsep.join(python), "HNAV_LIBRARY": str(checkout / "build/c_src/libhnav.so"),
            "HNAV_FMUS": str(checkout / "build/fmus"), "HNAV_SYSTEMS": str(checkout / "build/ssp"),
            "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1",
        }  # fmt: skip
        command = [sys.executable, "-m", "studies.compare.worker", str(checkout), str(INPUTS), str(folder), *names]
        with self._log.open("wb") as log:
            self._process = subprocess.Popen(command, stdout=log, stderr=log, cwd=folder, env=os.environ | found_there)

    def take(self, name: str) -> dict[str, NDArray[Any]]:
        """The answers to a scenario as soon as they are there, once. Raises SystemExit when the worker died."""
        file = file_of(self._folder, name)
        while not file.is_file():
            if self._process.poll() is not None and not file.is_file():
                raise SystemExit(f"study compare: the worker died over {name}:\n{self._log.read_text()[-2000:]}")
            time.sleep(POLL_S)
        with np.load(file) as data:
            answers = {key: data[key] for key in data.files}
        file.unlink()
        return answers

    def stop(self) -> None:
        self._process.terminate()
        self._process.wait()


def compare(old: Path, new: Path, names: list[str]) -> int:
    """Prints a line for each scenario; returns how many differ without a declared reason."""
    # Who ends this process ends its workers.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    counts, values, begin = {"equal": 0, "as declared": 0, "different": 0}, 0, time.monotonic()
    with tempfile.TemporaryDirectory(dir=WORK) as folder:
        sides = [Answers(Path(folder) / label, checkout, names) for label, checkout in (("old", old), ("new", new))]
        try:
            for name in names:
                before, after = (side.take(name) for side in sides)
                counts[judge(name, before, after)] += 1
                values += sum(array.size for array in before.values())
        finally:
            for side in sides:
                side.stop()
    total = ", ".join(f"{count} {verdict}" for verdict, count in counts.items())
    print(f"{len(names)} scenarios, {values} numbers: {total}; {time.monotonic() - begin:.0f} s")
    return counts["different"]


def judge(name: str, before: dict[str, NDArray[Any]], after: dict[str, NDArray[Any]]) -> str:
    """Prints and returns the verdict on a scenario, with the differences that there are."""
    found, declared = differences(before, after, tolerance_of(name)), declared_exceptions()
    reasons = [reason_for(name, difference, declared) for difference in found]
    verdict = "equal" if not found else "different" if None in reasons else "as declared"
    print(f"{verdict:<12} {name}  ({sum(array.size for array in before.values())} numbers)", flush=True)
    for difference, reason in list(zip(found, reasons))[:SHOWN]:
        print(f"             {difference.value}: {difference.text}" + (f" [{reason}]" if reason else ""))
    if len(found) > SHOWN:
        print(f"             and {len(found) - SHOWN} more values")
    return verdict


def main() -> None:
    parser = argparse.ArgumentParser(prog="./run study compare", description="Old against new, bit for bit.")
    parser.add_argument("--only", metavar="PATTERN", action="append", help="scenarios whose names match, * and ? allowed")
    parser.add_argument("--old", type=Path, metavar="FOLDER", help=f"a checkout with its build instead of {FOLDER}")
    parser.add_argument("--new", type=Path, metavar="FOLDER", default=TOP, help="a checkout with its build instead of this one")
    parser.add_argument("--list", action="store_true", help="names of the scenarios")
    parser.add_argument("--freeze", action="store_true", help="rewrite the answers that python_tests keep, by the old side")
    chosen = parser.parse_args()
    if chosen.freeze:
        frozen.main(str((chosen.old or old_revision()).resolve()))
        return
    INPUTS.mkdir(parents=True, exist_ok=True)
    trials = prepare_trials(INPUTS)
    if not trials:
        print("BROAD_DIR is not set: without recordings", file=sys.stderr)
    patterns = chosen.only or ["*"]
    names = [name for name, _ in all_scenarios(INPUTS) if any(fnmatch(name, pattern) for pattern in patterns)]
    if not names:
        raise SystemExit(f"study compare: no scenario is called {' or '.join(patterns)}; --list tells their names")
    if chosen.list:
        print("\n".join(names))
        return
    sys.exit(1 if compare((chosen.old or old_revision()).resolve(), chosen.new.resolve(), names) else 0)


if __name__ == "__main__":
    main()
