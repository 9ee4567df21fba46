"""Runs in importers that have a Python or a program of their own, as studies.importers makes them; tests are skipped by name without."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from hnav.systems.structure import System
from studies import importers
from studies.importers import PYFMI, PYFMI_MASTER, PYFMI_STATE_SPACE, ImporterMissing


def run_pyfmi_script(script: str, arguments: tuple[str, ...], folder: Path) -> dict:
    """What the script writes to answer.json in the folder, and errors."""
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
