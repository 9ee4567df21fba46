"""The files of the turntable experiment: models/systems/turntable, written from the FMUs, the grades and the scenarios.

python -m hnav.systems.turntable_system FOLDER
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from xml.sax.saxutils import quoteattr

import fmpy
from fmpy.model_description import ScalarVariable

from hnav.fmi.fmus import fmu_path
from hnav.systems.parameter_sets import BASE_UNITS, parameter_element, parameter_set, unit_elements
from hnav.systems.sensors import GRADES
from hnav.systems.turntable_scenarios import COMPONENTS, FILTERS, SAMPLES, SCENARIOS, TRUTH, Values, grade_values

DESCRIPTIONS = {
    "turntable": "truth", "sensor": "samples with counters and time stamps", "hekf": "gamma off: the hybrid extended Kalman filter",
    "hrekf": "the hybrid robust extended Kalman filter", "ahrs": "the filter for real sensors",
}  # fmt: skip
BOUND_ALWAYS: Values = {"sampling_mode": "counter"}  # of each filter
HEAD = """<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription version="1.0" name="turntable"
    description="A turntable, its sensors, and three filters side by side"
    xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"
    xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon"
    xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues">
  <ssd:System name="turntable">
    <ssd:Elements>
"""


@cache
def _variables() -> dict[str, dict[str, ScalarVariable]]:
    """Of each component: FMI variables by name."""
    by_fmu = {
        name: {v.name: v for v in fmpy.read_model_description(str(fmu_path(name, 2))).modelVariables}
        for name in set(COMPONENTS.values())
    }
    return {component: by_fmu[name] for component, name in COMPONENTS.items()}


def parameters() -> dict[str, ScalarVariable]:
    """The parameters of the FMUs, by component.parameter."""
    return {
        f"{component}.{v.name}": v
        for component, variables in _variables().items()
        for v in variables.values()
        if v.causality == "parameter"
    }


def connector(variable: ScalarVariable, kind: str) -> str:
    """ssd:Connector of a variable."""
    element = variable.type if variable.type in ("Real", "Boolean") else "Integer"
    unit = f" unit={quoteattr(variable.unit)}" if element == "Real" and variable.unit in BASE_UNITS else ""
    return f'          <ssd:Connector name={quoteattr(variable.name)} kind="{kind}"><ssc:{element}{unit}/></ssd:Connector>\n'


def _connectors(name: str, variables: Mapping[str, ScalarVariable], bound: set[str]) -> str:
    """Inputs that are fed, outputs, and parameters that a scenario or a grade sets."""
    lines = []
    for v in variables.values():
        if v.name in TRUTH + SAMPLES and v.causality == "input":
            lines.append(connector(v, "input"))
        elif v.causality == "output":
            lines.append(connector(v, "output"))
        elif f"{name}.{v.name}" in bound or v.name == "seed" or (name in FILTERS and v.name in BOUND_ALWAYS):
            lines.append(connector(v, "parameter"))
    return "".join(lines)


def _component(name: str, variables: Mapping[str, ScalarVariable], bound: set[str]) -> str:
    # Bound at the component, because that is where every importer looks; all of one name, because some ask for it.
    nominal = {key.partition(".")[2]: value for key, value in SCENARIOS["nominal"][1].items() if key.startswith(name + ".")}
    if name in FILTERS:
        nominal = BOUND_ALWAYS | nominal
    elements = [" " * 18 + parameter_element(key, value, variables[key]) for key, value in nominal.items()]
    return (
        f'      <ssd:Component name="{name}" description={quoteattr(DESCRIPTIONS[name])} type="application/x-fmu-sharedlibrary"'
        f' source="resources/{COMPONENTS[name]}.fmu" implementation="CoSimulation">\n        <ssd:Connectors>\n'
        f"{_connectors(name, variables, bound)}        </ssd:Connectors>\n"
        "        <ssd:ParameterBindings>\n          <ssd:ParameterBinding>\n            <ssd:ParameterValues>\n"
        '              <ssv:ParameterSet version="1.0" name="nominal">\n                <ssv:Parameters>\n'
        f"{''.join(elements)}"
        "                </ssv:Parameters>\n              </ssv:ParameterSet>\n            </ssd:ParameterValues>\n"
        "          </ssd:ParameterBinding>\n        </ssd:ParameterBindings>\n      </ssd:Component>\n"
    )


def structure() -> str:
    """The text of SystemStructure.ssd."""
    every = _variables()
    bound = {key for _, values in SCENARIOS.values() for key in values} | {key for grade in GRADES for key in grade_values(grade)}
    ends = [("turntable", "sensor", name) for name in TRUTH] + [("sensor", f, name) for f in FILTERS for name in SAMPLES]
    units = {v.unit for variables in every.values() for v in variables.values() if v.unit}
    connections = [
        f'      <ssd:Connection startElement="{start}" startConnector={quoteattr(name)}'
        f' endElement="{end}" endConnector={quoteattr(name)}/>\n'
        for start, end, name in ends
    ]
    return (
        f"{HEAD}{''.join(_component(name, variables, bound) for name, variables in every.items())}"
        f"    </ssd:Elements>\n    <ssd:Connections>\n{''.join(connections)}"
        f"    </ssd:Connections>\n  </ssd:System>\n  <ssd:Units>\n{unit_elements(units, '    ')}  </ssd:Units>\n"
        '  <ssd:DefaultExperiment startTime="0" stopTime="60"/>\n</ssd:SystemStructureDescription>\n'
    )


def write_system(folder: Path) -> None:
    """SystemStructure.ssd, scenarios/*.ssv and grades/*.ssv. The FMUs must be built."""
    texts = {"SystemStructure.ssd": structure()}
    for name, (description, values) in SCENARIOS.items():
        texts[f"scenarios/{name}.ssv"] = parameter_set(name, values, parameters(), description)
    for name in GRADES:
        told = f"Sensors of the grade {name}, filters told of their noise"
        texts[f"grades/{name}.ssv"] = parameter_set(name, grade_values(name), parameters(), told)
    for name, text in texts.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)


if __name__ == "__main__":
    write_system(Path(sys.argv[1]))
