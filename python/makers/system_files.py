"""The files of a system, written from its definition and its FMUs: SystemStructure.ssd, scenarios/*.ssv, grades/*.ssv."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from xml.sax.saxutils import quoteattr

import fmpy
from fmpy.model_description import ScalarVariable

from hnav.fmi.fmus import fmu_path
from hnav.systems.structure import Value
from makers.parameter_sets import BASE_UNITS, parameter_element, parameter_set, unit_elements

Values = dict[str, Value]
NOMINAL = "nominal"
"""The scenario that the structure binds."""


MASTER_STEP_S = 0.01
"""Of all systems, as hnav simulate steps them."""
MASTER = (
    '    <ssd:Annotations>\n      <ssc:Annotation type="org.openmodelica">\n'
    '        <oms:Annotations xmlns:oms="https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd">\n'
    "          <oms:SimulationInformation>\n"
    f'            <oms:FixedStepMaster description="oms-ma" stepSize="{MASTER_STEP_S:g}" absoluteTolerance="0.0001" relativeTolerance="0.0001"/>\n'
    "          </oms:SimulationInformation>\n        </oms:Annotations>\n      </ssc:Annotation>\n    </ssd:Annotations>\n"
)
"""Annotation that OMSimulator needs to open a system. The last element of ssd:System."""


def _connector(variable: ScalarVariable, kind: str) -> str:
    """ssd:Connector of a variable."""
    element = variable.type if variable.type in ("Real", "Boolean") else "Integer"
    unit = f" unit={quoteattr(variable.unit)}" if element == "Real" and variable.unit in BASE_UNITS else ""
    return f'          <ssd:Connector name={quoteattr(variable.name)} kind="{kind}"><ssc:{element}{unit}/></ssd:Connector>\n'


@dataclass(frozen=True)
class Definition:
    """A system as data. Values are named component.parameter."""

    name: str
    description: str
    components: Mapping[str, tuple[str, str]]
    """Name -> FMU, its role in the system."""
    connections: Sequence[tuple[str, ...]]
    """From component, to component, the connector, and what it is called at the end where that is another name."""
    scenarios: Mapping[str, tuple[str, Values]]
    """Name -> what it is, values; each sets every parameter that any of them sets, so that one may follow another."""
    grades: Mapping[str, tuple[str, Values]]
    """Likewise, applied after a scenario."""
    bound_always: Mapping[str, Values]
    """Of a component: what no scenario and no grade changes."""
    stop_s: float

    @cached_property
    def variables(self) -> dict[str, dict[str, ScalarVariable]]:
        """Of each component: FMI variables by name."""
        by_fmu = {
            fmu: {v.name: v for v in fmpy.read_model_description(str(fmu_path(fmu, 2))).modelVariables}
            for fmu in {fmu for fmu, _ in self.components.values()}
        }
        return {component: by_fmu[fmu] for component, (fmu, _) in self.components.items()}

    def parameters(self) -> dict[str, ScalarVariable]:
        """The parameters of the FMUs, by component.parameter."""
        return {
            f"{component}.{v.name}": v
            for component, variables in self.variables.items()
            for v in variables.values()
            if v.causality == "parameter"
        }

    def structure(self) -> str:
        """The text of SystemStructure.ssd."""
        sets = [values for _, values in (*self.scenarios.values(), *self.grades.values())]
        bound = {key for values in sets for key in values}
        components = "".join(self._component(name, bound) for name in self.components)
        units = {v.unit for variables in self.variables.values() for v in variables.values() if v.unit}
        connections = [
            f'      <ssd:Connection startElement="{start}" startConnector={quoteattr(names[0])}'
            f' endElement="{end}" endConnector={quoteattr(names[-1])}/>\n'
            for start, end, *names in self.connections
        ]
        return (
            f"{self._head()}{components}    </ssd:Elements>\n    <ssd:Connections>\n{''.join(connections)}"
            f"    </ssd:Connections>\n{MASTER}  </ssd:System>\n  <ssd:Units>\n{unit_elements(units, '    ')}  </ssd:Units>\n"
            f'  <ssd:DefaultExperiment startTime="0" stopTime="{self.stop_s:g}"/>\n</ssd:SystemStructureDescription>\n'
        )

    def _head(self) -> str:
        return (
            f'<?xml version="1.0" encoding="UTF-8"?>\n<ssd:SystemStructureDescription version="1.0" name="{self.name}"\n'
            f"    description={quoteattr(self.description)}\n"
            '    xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"\n'
            '    xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon"\n'
            '    xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues">\n'
            f'  <ssd:System name="{self.name}">\n    <ssd:Elements>\n'
        )

    def _connectors(self, component: str, bound: set[str]) -> str:
        """Inputs that are fed, outputs, and parameters that a scenario or a grade sets."""
        fed = {names[-1] for _, end, *names in self.connections if end == component}
        always = {"seed", *self.bound_always.get(component, ())}
        lines = []
        for v in self.variables[component].values():
            if v.name in fed and v.causality == "input":
                lines.append(_connector(v, "input"))
            elif v.causality == "output":
                lines.append(_connector(v, "output"))
            elif f"{component}.{v.name}" in bound or v.name in always:
                lines.append(_connector(v, "parameter"))
        return "".join(lines)

    def _component(self, component: str, bound: set[str]) -> str:
        # Bound at the component, where every importer reads bindings; all have the same name, because some importers require it.
        fmu, description = self.components[component]
        nominal = self.scenarios[NOMINAL][1].items()
        own = {key.partition(".")[2]: value for key, value in nominal if key.startswith(component + ".")}
        values = {**self.bound_always.get(component, {}), **own}
        elements = [" " * 18 + parameter_element(key, value, self.variables[component][key]) for key, value in values.items()]
        return (
            f'      <ssd:Component name="{component}" description={quoteattr(description)} type="application/x-fmu-sharedlibrary"'
            f' source="resources/{fmu}.fmu" implementation="CoSimulation">\n        <ssd:Connectors>\n'
            f"{self._connectors(component, bound)}        </ssd:Connectors>\n"
            "        <ssd:ParameterBindings>\n          <ssd:ParameterBinding>\n            <ssd:ParameterValues>\n"
            f'              <ssv:ParameterSet version="1.0" name="{NOMINAL}">\n                <ssv:Parameters>\n'
            f"{''.join(elements)}"
            "                </ssv:Parameters>\n              </ssv:ParameterSet>\n            </ssd:ParameterValues>\n"
            "          </ssd:ParameterBinding>\n        </ssd:ParameterBindings>\n      </ssd:Component>\n"
        )

    def write(self, folder: Path) -> None:
        """All the files. The FMUs must be built."""
        texts = {"SystemStructure.ssd": self.structure()}
        for kind, sets in (("scenarios", self.scenarios), ("grades", self.grades)):
            for name, (description, values) in sets.items():
                texts[f"{kind}/{name}.ssv"] = parameter_set(name, values, self.parameters(), description)
        for name, text in texts.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_text(text)
