"""The command: which measurements are made, and what is written of them."""

from __future__ import annotations

import datetime
import json
import os
import platform
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from hnav.cli.console import say
from hnav.cli.words import UsageError
from hnav.io.outputs import write_files
from hnav.places import CHECKOUT
from studies.command import check_choices
from studies.results.tables import json_text, read_printed

RESULTS = CHECKOUT / "docs" / "results"
FOLDERS = {"DIR": "BROAD_DIR", "FLIGHT": "HNAV_FLIGHT"}
"""Words of a command that stand for a folder, and the variable of the environment that names it."""
QUICK = (
    "broad", "calibration", "certificate", "certificate_rho", "certificate_slow", "coloured_time", "damaged", "hidden", "hrekf", "ins_flight",
    "ins_given", "ins_hands", "ins_speed", "motion", "observer_bounds", "observer_cost", "observer_laws", "observer_size", "observer_tank",
    "reading", "sensitivity", "sensor_calibration",
)  # fmt: skip
"""Within two minutes on two cores."""


def measurements() -> dict[str, dict[str, Any]]:
    """By name, those that their command makes again; of a file with notes a part was written by hand."""
    found = {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in sorted(RESULTS.glob("*.json"))}
    return {name: result for name, result in found.items() if "notes" not in result}


MEASUREMENTS = measurements()


def command(
    names: Annotated[list[str] | None, typer.Argument(metavar="[NAME]...", help=", ".join(MEASUREMENTS))] = None,
    everything: Annotated[bool, typer.Option("--all", help="Also what takes longer than two minutes")] = False,
    folder: Annotated[Path, typer.Option(metavar="DIR", help="Where NAME.json is written")] = RESULTS,
) -> None:
    """Measures, and writes docs/results/NAME.json for each measurement."""
    check_choices("there is no measurement", names or (), MEASUREMENTS)
    for name in names or (MEASUREMENTS if everything else QUICK):
        (line,) = MEASUREMENTS[name]["commands"]
        if missing := [FOLDERS[word] for word in line.split() if word in FOLDERS and not os.environ.get(FOLDERS[word])]:
            say(f"{name} is left out: {missing[0]} is not set")
            continue
        say(f"{name}: ./run {line}")
        result = MEASUREMENTS[name] | {"when": circumstances(), "printed": read_printed(answer_of(line))}
        write_files({folder / f"{name}.json": json_text(result)})


def answer_of(line: str) -> str:
    """What a command prints, as it is typed behind ./run. Raises UsageError when it fails."""
    words = [os.environ[FOLDERS[word]] if word in FOLDERS else word for word in shlex.split(line)]
    # The build is that of ./run study, so the modules are called by themselves.
    modules = {"study": ["-m", "studies", *words[1:]], "hnav": ["-m", "hnav", *words[1:]]}
    done = subprocess.run([sys.executable, *modules[words[0]]], capture_output=True, text=True, cwd=CHECKOUT, check=False)
    if done.returncode:
        raise UsageError(f"./run {line}: {(done.stderr.strip().splitlines() or ['failed'])[-1]}")
    return re.sub(r"[ \t]+$", "", done.stdout, flags=re.MULTILINE)


def circumstances() -> str:
    """When, on what machine, of which revision."""
    revision = git("rev-parse", "--short", "HEAD")
    # The pages are what this writes.
    changed = ", changed" if git("status", "--porcelain", "--untracked-files=no", "--", ".", ":!docs") else ""
    return f"{datetime.date.today()}, {os.cpu_count()} cores of {processor()}, revision {revision}{changed}"


def git(*arguments: str) -> str:
    return subprocess.run(["git", *arguments], capture_output=True, text=True, cwd=CHECKOUT, check=True).stdout.strip()


def processor() -> str:
    """Name of the processor, as reported by the system."""
    cpuinfo = Path("/proc/cpuinfo")
    names = re.findall(r"model name\s*: (.*)", cpuinfo.read_text()) if cpuinfo.is_file() else []
    return names[0].strip() if names else platform.machine()
