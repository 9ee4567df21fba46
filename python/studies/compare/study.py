"""Runs both revisions in parallel and prints the comparison."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections import Counter
from dataclasses import asdict
from fnmatch import fnmatch
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from numpy.typing import NDArray

from hnav.cli.console import say
from hnav.cli.words import UsageError
from hnav.io.outputs import write_files
from hnav.places import CHECKOUT
from studies.compare import worker
from studies.compare.recordings import write
from studies.compare.revision import FOLDER, REVISION, built
from studies.compare.scenarios import Scenario, all_scenarios
from studies.compare.verdict import Verdict, judged
from studies.compare.worker import FAILURE, file_of

POLL_S = 0.05
SHOWN = 6  # columns of one scenario that are printed


class Side:
    """A worker process of one side and its files; a worker that crashes is started again after the scenario concerned."""

    def __init__(self, folder: Path, checkout: Path, inputs: Path, scenarios: list[Scenario]):
        self._folder, self._checkout, self._inputs, self._left = folder, checkout, inputs, list(scenarios)
        folder.mkdir()
        self._start()

    def _start(self) -> None:
        (self._folder / "scenarios.json").write_text(json.dumps([asdict(scenario) for scenario in self._left]))
        found_there = {
            "PYTHONPATH": str(self._checkout / "python"), "HNAV_LIBRARY": str(self._checkout / "build/c_src/libhnav.so"),
            "HNAV_FMUS": str(self._checkout / "build/fmus"), "HNAV_SYSTEMS": str(self._checkout / "build/ssp"),
            "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1",
        }  # fmt: skip
        places = map(str, (self._checkout, self._inputs, self._folder, self._folder / "scenarios.json"))
        with (self._folder / "log").open("wb") as log:
            command = [sys.executable, str(worker.__file__), *places]
            self._process = subprocess.Popen(command, stdout=log, stderr=log, cwd=self._folder, env=os.environ | found_there)

    def take(self, scenario: Scenario) -> dict[str, NDArray[Any]]:
        """The answers to the next scenario as soon as they are there."""
        file = file_of(self._folder, scenario.name)
        while not file.is_file():
            if self._process.poll() is not None and not file.is_file():
                return self._buried()
            time.sleep(POLL_S)
        self._left.pop(0)
        with np.load(file) as data:
            answers = dict(data)
        file.unlink()
        return answers

    def _buried(self) -> dict[str, NDArray[Any]]:
        said = (self._folder / "log").read_text(errors="replace")[-400:]
        self._left.pop(0)
        out = self._folder / "out"
        if out.is_dir():
            out.rename(self._folder / f"out_{len(self._left)}")
        self._start()
        return {FAILURE: np.array(f"its process ended with {self._process.returncode}: {said}")}

    def stop(self) -> None:
        self._process.terminate()
        self._process.wait()


def compared(old: Path, new: Path, scenarios: list[Scenario]) -> list[Verdict]:
    """Prints a line for each scenario."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=FOLDER) as name:
        folder, found = Path(name), []
        (folder / "in").mkdir()
        for file in sorted({file for scenario in scenarios for file in scenario.inputs()}):
            write(file, folder / "in")
        sides = [Side(folder / label, checkout, folder / "in", scenarios) for label, checkout in (("old", old), ("new", new))]
        try:
            for scenario in scenarios:
                found.append(judged(scenario.name, *(side.take(scenario) for side in sides)))
                say("\n".join(lines_of(found[-1])))
        finally:
            for side in sides:
                side.stop()
    return found


def lines_of(verdict: Verdict) -> list[str]:
    """The line of a scenario, and a line for each of the columns that moved most."""
    sides = {"old": verdict.only_old, "new": verdict.only_new}
    one_side = [f"{len(names)} columns {side} only" for side, names in sides.items() if names]
    lines = [f"{verdict.verdict:<7} {verdict.scenario}  ({', '.join([f'{verdict.numbers} numbers', *one_side])})"]
    lines += [f"        {verdict.failure}"] if verdict.failure else []
    most = sorted(verdict.moved, key=lambda moved: -(moved.sigmas or 0))
    lines += [f"        {moved}" for moved in most[:SHOWN]]
    return lines + ([f"        and {len(most) - SHOWN} more columns"] if len(most) > SHOWN else [])


def scenarios_like(patterns: list[str]) -> list[Scenario]:
    """Raises UsageError where there is none."""
    if found := [scenario for scenario in all_scenarios() if any(fnmatch(scenario.name, pattern) for pattern in patterns)]:
        return found
    raise UsageError(f"no scenario is called {' or '.join(patterns)}; --list prints the names")


def command(
    revision: Annotated[str, typer.Argument(help="What this checkout is compared with; built once")] = REVISION,
    only: Annotated[
        list[str] | None, typer.Option(metavar="PATTERN", help="Scenarios whose names match, * and ? allowed")
    ] = None,
    show: Annotated[bool, typer.Option("--list", help="Print the names of the scenarios")] = False,
    table: Annotated[Path | None, typer.Option("--json", metavar="FILE", help="Write the verdicts there")] = None,
    old: Annotated[Path | None, typer.Option(metavar="FOLDER", help="A checkout with its build instead of the revision")] = None,
) -> None:
    """This checkout's answers beside another revision's, bit for bit; exit code 1 when anything moved."""
    chosen = scenarios_like(only or ["*"])
    if show:
        say("\n".join(scenario.name for scenario in chosen))
        return
    if not {"BROAD_DIR", "HNAV_FLIGHT", "HNAV_PLANTS"} <= os.environ.keys():
        say("BROAD_DIR, HNAV_FLIGHT and HNAV_PLANTS name folders; scenarios are left out whose folder is not set")
    begin = time.monotonic()
    found = compared(built(revision) if old is None else old.resolve(), CHECKOUT, chosen)
    counts, numbers = Counter(verdict.verdict for verdict in found), sum(verdict.numbers for verdict in found)
    by_kind = ", ".join(f"{counts[kind]} {kind}" for kind in ("equal", "moved", "failed"))
    say(f"{len(found)} scenarios, {numbers} numbers: {by_kind}; {time.monotonic() - begin:.0f} s")
    if table is not None:
        answer = {"revision": revision, "counts": counts, "scenarios": [asdict(verdict) for verdict in found]}
        write_files({table: json.dumps(answer, indent=1) + "\n"})
    if any(verdict.verdict != "equal" for verdict in found):
        raise typer.Exit(1)
