"""Runs in importers that have a Python or a program of their own, as studies.importers makes them; tests are skipped by name without."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from hnav.systems.structure import System
from studies import importers
from studies.importers import PYFMI, ImporterMissing

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
with open("setup.json") as file:
    setup = json.load(file)
models = {name: load_fmu(path, kind="CS") for name, path in setup["fmus"].items()}
for name, parameters in setup["parameters"].items():
    for parameter, value in parameters.items():
        models[name].set(parameter, value)
wires = [(models[start], output, models[end], input) for start, output, end, input in setup["wires"]]
result = Master(list(models.values()), wires).simulate(final_time=setup["stop_s"], options=setup["options"])
columns = {f"{name}.{output}": list(result[models[name]][output]) for name, output in setup["outputs"]}
t_s = list(result[models[setup["outputs"][0][0]]]["time"])
with open("answer.json", "w") as file:
    json.dump({"t_s": t_s, "columns": columns, "log": [line for model in models.values() for line in model.get_log()]}, file)
"""


def run_pyfmi_script(script: str, arguments: tuple[str, ...], folder: Path) -> dict:
    """The content of answer.json, which the script writes in the folder, and its errors."""
    try:
        return importers.run_pyfmi(script, arguments, folder)
    except ImporterMissing as reason:
        pytest.skip(str(reason))


def run_pyfmi(path: Path, kind: str, folder: Path) -> dict:
    """Simulated by its default experiment: t_s, ends, errors."""
    return run_pyfmi_script(PYFMI, (str(path), kind), folder)


def pyfmi_state_space(path: Path, folder: Path) -> dict:
    """A and differences (n x n each), errors."""
    return run_pyfmi_script(PYFMI_STATE_SPACE, (str(path),), folder)


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
    setup = {
        "fmus": {c.name: str(c.fmu) for c in components},
        "parameters": numbers,
        "wires": [[*c.start, *c.end] for c in system.connections if c.start[0] in names and c.end[0] in names],
        "outputs": [output.split(".", 1) for output in outputs],
        "stop_s": stop_s,
        "options": options,
    }
    (folder / "setup.json").write_text(json.dumps(setup))
    return run_pyfmi_script(PYFMI_MASTER, (), folder)


def run_omsimulator(path: Path, folder: Path, t_s: float, *options: str) -> dict[str, float]:
    """An FMU or a system, as it is: all signals at this time."""
    try:
        rows = importers.run_omsimulator(path, folder, *options)
    except ImporterMissing as reason:
        pytest.skip(str(reason))
    # It adds up its steps; what it writes twice at a time is the same.
    return next(row for row in rows if abs(row["time"] - t_s) < 1e-9)
