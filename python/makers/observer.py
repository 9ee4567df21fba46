"""The files of the pendulum and its observer: models/systems/observer, written from the plan and the FMUs.

python -m makers.observer FOLDER

The FMU Observer in build/fmus is made of what this writes. It is the shell that hnav.Observer.export fills again for other plants.
"""

from __future__ import annotations

import sys
from pathlib import Path

from hnav.filters.observer import Observer
from hnav.filters.observer_export import texts
from hnav.filters.observer_plan import read_plan
from hnav.fmi.fmus import Fmu
from hnav.io.fmu_files import fmu_path
from makers.system_files import NOMINAL, Definition

PLANT = "Pendulum"
PERIOD_S = 0.02
VERSIONS = (2, 3)
EXAMPLE = "resources/example_input.csv"
EXAMPLE_SAMPLES = 301
SYSTEM = Definition(
    name="observer",
    description="A pendulum and its observer, side by side",
    components={"pendulum": (PLANT, "truth, and samples of its angle"), "observer": ("Observer", "the pendulum by its samples")},
    connections=[("pendulum", "observer", f"measured.{name}", f"angle.{name}") for name in ("value", "sample", "t_meas")],
    scenarios={NOMINAL: ("", {})},
    grades={},
    bound_always={"pendulum": {"seed": 1}, "observer": {"sampling_mode": "counter"}},
    stop_s=20,
)


def observer(folder: Path, fmi_version: int) -> Observer:
    """Of the plan in the folder."""
    return Observer(read_plan(folder / "plan.toml", fmu_path(PLANT, fmi_version)))


def write_fmu_texts(folder: Path, plan_folder: Path) -> None:
    """All of the FMU except its binaries: Observer/both for all versions of FMI, Observer/fmi2 and Observer/fmi3."""
    example = {EXAMPLE: example_input()}
    made = {version: texts(observer(plan_folder, version), version, PERIOD_S) | example for version in VERSIONS}
    for version, files in made.items():
        for name, text in files.items():
            same = all(other.get(name) == text for other in made.values())
            path = folder / "Observer" / ("both" if same else f"fmi{version}") / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")


def example_input() -> str:
    """Samples of the pendulum's angle, the example input of the archive."""
    lines = ["time,angle.value"]
    with Fmu(fmu_path(PLANT, 2)) as pendulum:
        pendulum.initialise()
        for k in range(EXAMPLE_SAMPLES):
            lines.append(f"{k * PERIOD_S:.9g},{pendulum.get('measured.value' if k > 0 else 'truth.angle'):.9g}")
            pendulum.do_step(k * PERIOD_S, PERIOD_S)
    return "\n".join([*lines, ""])


def write_system(folder: Path, plan_folder: Path) -> None:
    """Writes all files. The FMUs must be built: when variables have changed, build and write twice."""
    write_fmu_texts(folder, plan_folder)
    (folder / "SystemStructure.ssd").write_text(SYSTEM.structure(), encoding="utf-8")


if __name__ == "__main__":
    write_system(Path(sys.argv[1]), Path(sys.argv[1]))
