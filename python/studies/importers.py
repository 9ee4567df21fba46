"""Which importer runs which archive with its defaults: fmpy, PyFMI and OMSimulator over build/fmus, in each kind that both have.

HNAV_PYFMI: a Python with PyFMI; HNAV_OMSIMULATOR: the folder of OMSimulator.
"""

from __future__ import annotations

import csv
import json
import math
import os
import re
import subprocess
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import fmpy

from hnav.cli.console import say, show
from hnav.cli.words import UsageError
from studies.calls.study import cases
from studies.command import titled_table, tracked

# As a user does who sets nothing; the end of each output, and what the log has of errors.
PYFMI = """
import json, sys, warnings
warnings.simplefilter("ignore")
from pyfmi import load_fmu
model = load_fmu(sys.argv[1], kind=sys.argv[2])
result = model.simulate(options={"silent_mode": True} if sys.argv[2] == "CS" else {})
ends = {name: float(result[name][-1]) for name in model.get_output_list()}
with open("answer.json", "w") as file:
    json.dump({"t_s": float(result["time"][-1]), "ends": ends, "log": model.get_log()}, file)
"""
# FMILibrary reads the terminals of an archive as those of another version.
XML_REMARK = re.compile(r"FMI3XML|terminalsAndIcons|Unknown (element|attribute)|Skipping nested XML")
FMI_TYPES = {"CS": "CoSimulation", "ME": "ModelExchange"}
TIMEOUT_S = 300


class ImporterMissing(UsageError):
    """The variable of the environment that names an importer is not set, or names none."""


def run_pyfmi(script: str, arguments: tuple[str, ...], folder: Path) -> dict[str, Any]:
    """What the script leaves in answer.json of the folder, with `errors`, those of its log. Raises UsageError."""
    python = os.environ.get("HNAV_PYFMI")
    if not python or not Path(python).is_file():
        raise ImporterMissing("HNAV_PYFMI is not set to a Python with PyFMI")
    done = subprocess.run(
        [python, "-c", script, *arguments], cwd=folder, capture_output=True, text=True, timeout=TIMEOUT_S, check=False
    )
    if done.returncode:
        raise UsageError(f"PyFMI failed: {done.stderr[-3000:] or done.returncode}")
    answer: dict[str, Any] = json.loads((folder / "answer.json").read_text())
    log = answer.pop("log")
    answer["errors"] = [line for line in log if re.search(r"log level = [12]\b", line) and not XML_REMARK.search(line)]
    return answer


def run_omsimulator(path: Path, folder: Path, *options: str) -> list[dict[str, float]]:
    """An FMU or a system, as it is: all signals, which begin with the names of model and system, of each row. Raises UsageError."""
    program = Path(os.environ.get("HNAV_OMSIMULATOR", "")) / "bin" / "OMSimulator"
    if not os.environ.get("HNAV_OMSIMULATOR") or not program.is_file():
        raise ImporterMissing("HNAV_OMSIMULATOR is not set to the folder of OMSimulator")
    command = [str(program), str(path), "--resultFile=result.csv", f"--tempDir={folder}", *options]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=TIMEOUT_S, check=False)
    log = done.stdout + done.stderr
    if done.returncode or re.search(r"^error:", log, re.M):
        raise UsageError(f"OMSimulator failed: {log[-3000:]}")
    with (folder / "result.csv").open(newline="") as file:
        names, *rows = [row for row in csv.reader(file, skipinitialspace=True) if row]
    return [{name: float(value) for name, value in zip(names, row, strict=False) if value} for row in rows]


# --------------------------------------------------------------------------------------------- the table


def _ends_of_fmpy(path: Path, kind: str, _folder: Path) -> Mapping[str, float]:
    rows = fmpy.simulate_fmu(str(path), fmi_type=FMI_TYPES[kind], validate=False, logger=lambda *_: None)
    return {name: float(rows[-1][name]) for name in rows.dtype.names if rows[name].ndim == 1}


def _ends_of_pyfmi(path: Path, kind: str, folder: Path) -> Mapping[str, float]:
    answer = run_pyfmi(PYFMI, (str(path), kind), folder)
    if answer["errors"]:
        raise UsageError(answer["errors"][0])
    ends: dict[str, float] = answer["ends"]
    return ends


def _ends_of_omsimulator(path: Path, kind: str, folder: Path) -> Mapping[str, float]:
    return run_omsimulator(path, folder, f"--mode={kind.lower()}")[-1]


IMPORTERS = {"fmpy": _ends_of_fmpy, "PyFMI": _ends_of_pyfmi, "OMSimulator": _ends_of_omsimulator}
LACKS = {("PyFMI", 3, "CS"), ("OMSimulator", 3, "ME")}  # kinds that an importer does not have at all
UNKNOWN = {("PyFMI", "arrays"), ("OMSimulator", "arrays"), ("OMSimulator", "clocks")}
"""Parts of FMI 3 that an importer does not support: it stops with its own error; use the scalar archive without clocks."""


def cell(importer: str, path: Path, version: int, kind: str) -> str:
    """What came of an archive: ok, fails (said why), not finite, or what the importer does not have."""
    special = {"Arrays": "arrays", "Clocks": "clocks"}.get(path.stem[-6:], "")
    if (importer, version, kind) in LACKS:
        return "-"
    if (importer, special) in UNKNOWN:
        return f"no {special}"
    with tempfile.TemporaryDirectory() as folder:
        try:
            ends = IMPORTERS[importer](path, kind, Path(folder))
        except ImporterMissing:
            raise
        except Exception as error:  # whatever it is, the archive does not run there
            say(f"{path.stem}, FMI {version} {kind}, {importer}: {str(error).splitlines()[-1]}")
            return "fails"
    return "ok" if all(math.isfinite(end) for end in ends.values()) else "not finite"


def command() -> None:
    """Runs every archive in every importer, with defaults, and prints what came of it."""
    table = titled_table("archives by importer, each with its defaults", "FMU | kind", " | ".join(IMPORTERS))
    for path, version, kind in tracked(sorted(cases(), key=lambda case: case.archive.stem), "archives"):
        table.add_row(path.stem, f"FMI {version} {kind}", *(cell(importer, path, version, kind) for importer in IMPORTERS))
    show(table)
