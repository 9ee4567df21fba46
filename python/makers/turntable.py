"""The files of the turntable experiment: models/systems/turntable, written from the FMUs, the grades and the scenarios.

python -m makers.turntable FOLDER
"""

from __future__ import annotations

import sys
from pathlib import Path

from hnav.io.sensors import GRADES
from makers.system_files import Definition
from makers.turntable_scenarios import COMPONENTS, FILTERS, SAMPLES, SCENARIOS, TRUTH, grade_values

DESCRIPTIONS = {
    "turntable": "truth", "sensor": "samples with counters and time stamps", "hekf": "gamma off: the hybrid extended Kalman filter",
    "hrekf": "the hybrid robust extended Kalman filter", "ahrs": "the filter for real sensors",
}  # fmt: skip
TURNTABLE = Definition(
    name="turntable",
    description="A turntable, its sensors, and three filters side by side",
    components={name: (fmu, DESCRIPTIONS[name]) for name, fmu in COMPONENTS.items()},
    connections=[
        *(("turntable", "sensor", name) for name in TRUTH),
        *(("sensor", filter_, name) for filter_ in FILTERS for name in SAMPLES),
    ],
    scenarios=SCENARIOS,
    grades={name: (f"Sensors of the grade {name}, filters that assume their noise", grade_values(name)) for name in GRADES},
    bound_always={name: {"sampling_mode": "counter"} for name in FILTERS},
    stop_s=60,
)

if __name__ == "__main__":
    TURNTABLE.write(Path(sys.argv[1]))
