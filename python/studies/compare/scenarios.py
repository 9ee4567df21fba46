"""All scenarios by name, in the order in which they run."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from studies.compare import attitude, calibration, fmi, hybrid_view, ins_error, simulation, tables, twins
from studies.compare.scenario import Named


def all_scenarios(inputs: Path) -> Iterator[Named]:
    """inputs: the folder of the prepared recordings; without recordings the scenarios of made motion remain."""
    trials = sorted(int(re.sub(r"\D", "", path.stem)) for path in inputs.glob("trial_*.npz"))
    yield from tables.scenarios()
    yield from attitude.scenarios(trials)
    yield from hybrid_view.scenarios()
    yield from ins_error.scenarios()
    yield from calibration.scenarios(trials)
    yield from simulation.scenarios()
    yield from twins.scenarios(trials)
    yield from fmi.scenarios(trials)


def tolerance_of(name: str) -> float:
    """0: bit for bit. NumPy's twins may choose another order of the same sums."""
    return 1e-12 if name.startswith("twin/") else 0.0
