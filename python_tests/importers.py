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

from hnav.systems.structure import System

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
# A of its linear model at the start, by PyFMI's own means, and by central differences of the derivatives.
PYFMI_STATE_SPACE = """
import json, sys, warnings
warnings.simplefilter("ignore")
from pyfmi import load_fmu
model = load_fmu(sys.argv[1], kind="ME")
model.setup_experiment()
model.initialize()
model.event_update()
model.enter_continuous_time_mode()
A = model.get_state_space_representation(C=False)[0].toarray()
x, columns = model.continuous_states.copy(), []
for i in range(len(x)):
    h, sides = 1e-6 * max(1.0, abs(x).max()), []
    for side in (h, -h):
        moved = x.copy()
        moved[i] += side
        model.continuous_states = moved
        sides.append(model.get_derivatives())
    columns.append(((sides[0] - sides[1]) / (2 * h)).tolist())
differences = [list(row) for row in zip(*columns)]
with open("answer.json", "w") as file:
    json.dump({"A": A.tolist(), "differences": differences, "log": model.get_log()}, file)
"""
# Components of a system by pyfmi.Master; the options are those of its simulate.
PYFMI_MASTER = """
import json, warnings
warnings.simplefilter("ignore")
from pyfmi import Master, load_fmu
with open("told.json") as file:
    told = json.load(file)
models = {name: load_fmu(path, kind="CS") for name, path in told["fmus"].items()}
for name, parameters in told["parameters"].items():
    for parameter, value in parameters.items():
        models[name].set(parameter, value)
wires = [(models[start], output, models[end], input) for start, output, end, input in told["wires"]]
result = Master(list(models.values()), wires).simulate(final_time=told["stop_s"], options=told["options"])
columns = {f"{name}.{output}": list(result[models[name]][output]) for name, output in told["outputs"]}
t_s = list(result[models[told["outputs"][0][0]]]["time"])
with open("answer.json", "w") as file:
    json.dump({"t_s": t_s, "columns": columns, "log": [line for model in models.values() for line in model.get_log()]}, file)
"""
# FMILibrary reads the terminals of an archive as those of another version.
XML_REMARK = re.compile(r"FMI3XML|terminalsAndIcons|Unknown (element|attribute)|Skipping nested XML")


def _run_pyfmi(script: str, arguments: tuple[str, ...], folder: Path) -> dict:
    """What the script leaves in answer.json, with the errors of its log. Skips the test where there is no PyFMI."""
    python = os.environ.get("HNAV_PYFMI")
    if not python or not Path(python).is_file():
        pytest.skip("HNAV_PYFMI is not set to a Python with PyFMI")
    done = subprocess.run([python, "-c", script, *arguments], cwd=folder, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    answer = json.loads((folder / "answer.json").read_text())
    log = answer.pop("log")
    answer["errors"] = [line for line in log if re.search(r"log level = [12]\b", line) and not XML_REMARK.search(line)]
    return answer


def run_pyfmi(path: Path, kind: str, folder: Path) -> dict:
    """Simulated by its default experiment: t_s, ends, errors."""
    return _run_pyfmi(PYFMI, (str(path), kind), folder)


def pyfmi_state_space(path: Path, folder: Path) -> dict:
    """A and differences (n x n each), errors."""
    return _run_pyfmi(PYFMI_STATE_SPACE, (str(path),), folder)


def run_pyfmi_master(
    system: System, names: tuple[str, ...], outputs: tuple[str, ...], folder: Path, stop_s: float, **options
) -> dict:
    """These components of a system of FMI 2, coupled as it says: t_s, columns of "component.output", errors."""
    components = [system.components[name] for name in names]
    numbers = {
        c.name: {
            key: c.variables[key].items.get(value, value) if isinstance(value, str) else value
            for key, value in c.parameters.items()
        }
        for c in components
    }
    told = {
        "fmus": {c.name: str(c.fmu) for c in components},
        "parameters": numbers,
        "wires": [[*c.start, *c.end] for c in system.connections if c.start[0] in names and c.end[0] in names],
        "outputs": [output.split(".", 1) for output in outputs],
        "stop_s": stop_s,
        "options": options,
    }
    (folder / "told.json").write_text(json.dumps(told))
    return _run_pyfmi(PYFMI_MASTER, (), folder)


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
