"""Importers that have a Python or a program of their own: where they are, and one run in each. HNAV_PYFMI: a Python with PyFMI;
HNAV_OMSIMULATOR: the folder of OMSimulator."""

from __future__ import annotations

import csv
import json
import os
import re
import subprocess
from pathlib import Path

import pytest

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


def run_pyfmi(path: Path, kind: str, folder: Path) -> dict:
    """Simulated by its default experiment: t_s, ends, and the errors of the log. Skips the test where there is no PyFMI."""
    python = os.environ.get("HNAV_PYFMI")
    if not python or not Path(python).is_file():
        pytest.skip("HNAV_PYFMI is not set to a Python with PyFMI")
    done = subprocess.run([python, "-c", PYFMI, str(path), kind], cwd=folder, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    answer = json.loads((folder / "answer.json").read_text())
    errors = [line for line in answer["log"] if re.search(r"log level = [12]\b", line) and not XML_REMARK.search(line)]
    return {"t_s": answer["t_s"], "ends": answer["ends"], "errors": errors}


def run_omsimulator(path: Path, folder: Path, t_s: float, *options: str) -> dict[str, float]:
    """An FMU or a system, as it is: all signals at this time, which begin with the names of model and system. Skips the test where there is no OMSimulator."""
    program = Path(os.environ.get("HNAV_OMSIMULATOR", "")) / "bin" / "OMSimulator"
    if not os.environ.get("HNAV_OMSIMULATOR") or not program.is_file():
        pytest.skip("HNAV_OMSIMULATOR is not set to the folder of OMSimulator")
    command = [str(program), str(path), "--resultFile=result.csv", f"--tempDir={folder}", *options]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300)
    log = done.stdout + done.stderr
    assert done.returncode == 0 and not re.search(r"^error:", log, re.M), log[-3000:]
    with (folder / "result.csv").open(newline="") as file:
        names, *rows = [row for row in csv.reader(file, skipinitialspace=True) if row]
    # It adds up its steps; what it writes twice at a time is the same.
    row = next(row for row in rows if abs(float(row[0]) - t_s) < 1e-9)
    return {name: float(value) for name, value in zip(names, row) if value}
