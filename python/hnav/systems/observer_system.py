"""The files of the pendulum and its observer: models/systems/observer, written from the plan and the FMUs.

python -m hnav.systems.observer_system FOLDER

The FMU Observer in build/fmus is made of what this writes. It is the shell that hnav.Observer.export fills anew for other plants.
"""

from __future__ import annotations

import sys
from pathlib import Path

import fmpy

from hnav.filters.observer import Observer
from hnav.filters.observer_export import texts
from hnav.filters.observer_plan import read_plan
from hnav.fmi.fmus import Fmu
from hnav.io.fmu_files import fmu_path
from hnav.systems.parameter_sets import parameter_element, unit_elements
from hnav.systems.structure import Value
from hnav.systems.system_files import connector

PLANT = "Pendulum"
PERIOD_S = 0.02
VERSIONS = (2, 3)
EXAMPLE = "resources/example_input.csv"
EXAMPLE_SAMPLES = 301
COMPONENTS = {"pendulum": (PLANT, "truth, and samples of its angle"), "observer": ("Observer", "the pendulum by its samples")}
WIRES = {"measured.value": "angle.value", "measured.sample": "angle.sample", "measured.t_meas": "angle.t_meas"}
BOUND: dict[str, dict[str, Value]] = {"pendulum": {"seed": 1}, "observer": {"sampling_mode": "counter"}}
HEAD = """<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription version="1.0" name="observer" description="A pendulum and its observer, side by side"
    xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"
    xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon"
    xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues">
  <ssd:System name="observer">
    <ssd:Elements>
"""


def observer(folder: Path, fmi_version: int) -> Observer:
    """Of the plan in the folder."""
    return Observer(read_plan(folder / "plan.toml", fmu_path(PLANT, fmi_version)))


def write_fmu_texts(folder: Path, plan_folder: Path) -> None:
    """All of the FMU but its binaries: Observer/both, what the versions of FMI have in common, Observer/fmi2 and Observer/fmi3."""
    made = {version: texts(observer(plan_folder, version), version, PERIOD_S) for version in VERSIONS}
    for version, files in made.items():
        for name, text in {**files, EXAMPLE: example_input()}.items():
            same = all(other.get(name, text) == text for other in made.values())
            path = folder / "Observer" / ("both" if same else f"fmi{version}") / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")


def example_input() -> str:
    """Samples of the pendulum's angle, as the archive brings them for those who try it."""
    lines = ["time,angle.value"]
    with Fmu(fmu_path(PLANT, 2)) as pendulum:
        pendulum.initialise()
        for k in range(EXAMPLE_SAMPLES):
            lines.append(f"{k * PERIOD_S:.9g},{pendulum.get('measured.value' if k > 0 else 'truth.angle'):.9g}")
            pendulum.do_step(k * PERIOD_S, PERIOD_S)
    return "\n".join([*lines, ""])


def _component(name: str) -> tuple[str, set[str]]:
    """The element, and its units."""
    fmu, text = COMPONENTS[name]
    variables = {v.name: v for v in fmpy.read_model_description(str(fmu_path(fmu, 2))).modelVariables}
    ends = set(WIRES.values())
    shown = [connector(v, "input") for v in variables.values() if v.causality == "input" and v.name in ends]
    shown += [connector(v, "output") for v in variables.values() if v.causality == "output"]
    shown += [connector(variables[parameter], "parameter") for parameter in BOUND[name]]
    bound = [" " * 18 + parameter_element(p, value, variables[p]) for p, value in BOUND[name].items()]
    element = (
        f'      <ssd:Component name="{name}" description="{text}" type="application/x-fmu-sharedlibrary"'
        f' source="resources/{fmu}.fmu" implementation="CoSimulation">\n        <ssd:Connectors>\n{"".join(shown)}'
        "        </ssd:Connectors>\n        <ssd:ParameterBindings>\n          <ssd:ParameterBinding>\n            <ssd:ParameterValues>\n"
        '              <ssv:ParameterSet version="1.0" name="parameters">\n                <ssv:Parameters>\n'
        f"{''.join(bound)}                </ssv:Parameters>\n              </ssv:ParameterSet>\n            </ssd:ParameterValues>\n"
        "          </ssd:ParameterBinding>\n        </ssd:ParameterBindings>\n      </ssd:Component>\n"
    )
    return element, {v.unit for v in variables.values() if v.unit}


def structure() -> str:
    """The text of SystemStructure.ssd."""
    elements, units = zip(*map(_component, COMPONENTS))
    wires = [
        f'      <ssd:Connection startElement="pendulum" startConnector="{start}" endElement="observer" endConnector="{end}"/>\n'
        for start, end in WIRES.items()
    ]
    return (
        f"{HEAD}{''.join(elements)}    </ssd:Elements>\n    <ssd:Connections>\n{''.join(wires)}    </ssd:Connections>\n  </ssd:System>\n"
        f"  <ssd:Units>\n{unit_elements(set().union(*units), '    ')}  </ssd:Units>\n"
        f'  <ssd:DefaultExperiment startTime="0" stopTime="20"/>\n</ssd:SystemStructureDescription>\n'
    )


def write_system(folder: Path, plan_folder: Path) -> None:
    """All of them. The FMUs must be built: when variables have changed, build and write twice."""
    write_fmu_texts(folder, plan_folder)
    (folder / "SystemStructure.ssd").write_text(structure(), encoding="utf-8")


if __name__ == "__main__":
    write_system(Path(sys.argv[1]), Path(sys.argv[1]))
