"""A system of FMUs: components, connections, grades and scenarios, and how parameters are set.

What comes later overrides: component, system, grade, scenario, the caller; see System.choose. hnav.systems.ssp_reader
makes a System of the files of SSP 1.0.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NoReturn, Self

from fmpy.model_description import ModelDescription

from hnav.errors import HnavValueError, nearest
from hnav.filters.options import option_table
from hnav.fmi.fmus import parameter_values
from hnav.io.sensors import read_grade

# Larger than any number of runs, and small enough that the seeds of many plants fit into 32 bits.
SEED_STRIDE = 1_000_000
SENSOR_FILE = ".json"
SENSORS, FILTERS = ("ImuMagSensor", "ImuMagSensorClocks"), {"Ahrs": "ahrs", "Hrekf": "hrekf"}
"""Models set by a sensor file: parameters of the sensors, and options of the filters."""
BOOLEANS = {"true": True, "1": True, "false": False, "0": False}
# Type of a parameter's value; the text of an enumeration is the name of its item.
Value = float | int | bool | str
TYPE_OF_KIND: dict[str, Callable[[str], Value]] = {"Real": float, "Integer": int, "String": str}


def refuse(text: str, argument: str | None = None) -> NoReturn:
    """A file, or a request to a system, is wrong."""
    raise HnavValueError("option", text, argument) from None


@dataclass(frozen=True)
class Variable:
    """A variable of an FMU as seen by a system. kind: Real, Integer, Boolean, Enumeration or String."""

    name: str
    kind: str
    causality: str
    unit: str
    items: Mapping[str, int] = field(default_factory=dict)  # of an enumeration


@dataclass(frozen=True)
class Connector:
    """A connector declared in the SSD. kind: input, output, parameter, ...; type and unit may be unspecified (empty)."""

    name: str
    kind: str
    type: str
    unit: str


@dataclass
class Component:
    """One FMU in its place in the system."""

    name: str
    fmu: Path
    description: ModelDescription
    variables: dict[str, Variable]
    connectors: dict[str, Connector]
    parameters: dict[str, Value] = field(default_factory=dict)


@dataclass(frozen=True)
class Connection:
    """From start to end, each (element, connector); the element "" is the system itself."""

    start: tuple[str, str]
    end: tuple[str, str]


@dataclass(frozen=True)
class Parameter:
    """One entry of a parameter set, before it is matched to a component. type: Real, Integer, ...; "" is untyped text."""

    name: str
    type: str
    value: str
    unit: str = ""


@dataclass(frozen=True)
class ParameterSet:
    """Parameters chosen together by name: a grade or a scenario."""

    parameters: list[Parameter]
    description: str = ""


@dataclass
class System:
    """A checked system, ready to run. Use as a context manager: it removes unpacked archives."""

    name: str
    description: str
    components: dict[str, Component]
    connectors: dict[str, Connector]
    connections: list[Connection]
    grades: dict[str, ParameterSet]
    scenarios: dict[str, ParameterSet]
    start_s: float
    stop_s: float | None
    step_s: float | None
    _folder: Path | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._folder:
            shutil.rmtree(self._folder, ignore_errors=True)

    def as_bound(self) -> System:
        """A copy with separate parameters, those bound in its files, to be set for one run; it owns no unpacked files."""
        components = {name: replace(c, parameters=dict(c.parameters)) for name, c in self.components.items()}
        return replace(self, components=components, _folder=None)

    def apply(self, parameters: Sequence[Parameter], where: str) -> None:
        """Sets parameters named component.parameter; an input of the system sets all connected inputs. Raises HnavError that
        begins with `where`.
        """
        for parameter in parameters:
            for component, name in self._owners(parameter.name, where):
                component.parameters[name] = parameter_value(component, name, parameter, where)

    def choose(self, grade: str | None = None, scenario: str | None = None) -> None:
        """Applies a grade, by name or by a sensor file (.json), and a scenario by name. A scenario that names sensors too lays over a
        grade only what it changes against the sets bound in the SSD: the disturbance stays, the sensor is the grade's. Raises HnavError.
        """
        grades = self.grades
        if grade is not None and grade.endswith(SENSOR_FILE):
            grades = {grade: ParameterSet(self._of_sensor_file(grade))}
        for kind, name, sets in (("grade", grade, grades), ("scenario", scenario, self.scenarios)):
            if name is not None and name not in sets:
                known = f"it has {', '.join(sorted(sets))}" if sets else "it has none"
                refuse(f"system {self.name} has no {kind} {name}: {known}")
        bound = self.parameters()
        if grade is not None:
            self.apply(grades[grade].parameters, f"grade {grade}")
        if scenario is not None:
            graded = self.parameters()
            self.apply(self.scenarios[scenario].parameters, f"scenario {scenario}")
            if grade is not None:
                for name, value in self.parameters().items():
                    if value == bound.get(name) and name in graded:
                        component, _, parameter = name.partition(".")
                        self.components[component].parameters[parameter] = graded[name]

    def _of_sensor_file(self, file: str) -> list[Parameter]:
        """Sets sensors and attitude filters from a sensor file; other parameters keep their values. Raises HnavError."""
        grade = read_grade(file)
        if not any(c.description.modelName in SENSORS for c in self.components.values()):
            refuse(f"sensor file {file}: system {self.name} has no component {SENSORS[0]}")
        of_model = dict.fromkeys(SENSORS, grade.parameters()) | {
            model: parameter_values(option_table(filter), grade.options(filter)) for model, filter in FILTERS.items()
        }
        return [
            Parameter(f"{component.name}.{name}", "", str(value))
            for component in self.components.values()
            for name, value in of_model.get(component.description.modelName, {}).items()
        ]

    def seed(self, seed: int) -> None:
        """Sets the parameter `seed` of every component that has one: seed, seed + SEED_STRIDE, ... in the order of their
        names, so that no two plants draw the same noise.
        """
        seeded = [c for _, c in sorted(self.components.items()) if "seed" in c.variables]
        if not seeded:
            refuse(
                f"seed = {seed}: no component of system {self.name} has a parameter seed, so every run would be the same: take a system "
                "with noise of its own (hnav systems)",
                "seed",
            )
        for i, component in enumerate(seeded):
            self.apply([Parameter(f"{component.name}.seed", "", str(seed + i * SEED_STRIDE))], "seed")

    def parameters(self) -> dict[str, Value]:
        """Values that were set, by component.parameter; others keep the start values of the FMUs."""
        return {f"{c.name}.{name}": value for c in self.components.values() for name, value in sorted(c.parameters.items())}

    def _owners(self, name: str, where: str) -> list[tuple[Component, str]]:
        if name in self.connectors and self.connectors[name].kind == "input":
            fed = [c.end for c in self.connections if c.start == ("", name)]
            return [(self.components[element], connector) for element, connector in fed if element]
        component, _, parameter = name.partition(".")
        if component not in self.components or not parameter:
            refuse(f"{where}: {name} names no component of system {self.name} ({', '.join(self.components)})", where)
        return [(self.components[component], parameter)]


# --------------------------------------------------------------------------------------------- values


def types_agree(one: str, other: str) -> bool:
    """SSP 1.0 allows an enumeration to be given by its number."""
    return one == other or {one, other} == {"Integer", "Enumeration"}


def parameter_value(component: Component, name: str, parameter: Parameter, where: str) -> Value:
    """The value as the variable's type. Raises HnavError for unknown names, wrong types and foreign units."""
    variable, full = component.variables.get(name), f"{where}: {component.name}.{name}"
    if variable is None:
        model, hint = component.description.modelName, nearest(name, component.variables)
        refuse(f"{where}: component {component.name} ({model}) has no parameter {name}{hint}", where)
    # SSP sets start values of inputs by the same entries.
    if variable.causality not in ("parameter", "structuralParameter", "input"):
        refuse(f"{full} is a variable of kind {variable.causality}, not a parameter", where)
    if parameter.type and not types_agree(parameter.type, variable.kind):
        refuse(f"{full} is {variable.kind}, not {parameter.type}", where)
    if parameter.unit and variable.unit != parameter.unit:
        refuse(f"{full} is in {variable.unit or '1 (no unit)'}, not in {parameter.unit}", where)
    try:
        value = _converted(variable, parameter.value.strip())
        if variable.kind == "Integer" and not -(2**31) <= int(value) < 2**31:
            raise ValueError  # larger integers exist in FMI 3 only; FMI 2 would truncate them
        return value
    except (ValueError, KeyError):
        wanted = f"one of {', '.join(variable.items)}" if variable.items else f"a {variable.kind}"
        refuse(f"{full} = {parameter.value}: {wanted} is wanted", where)


def _converted(variable: Variable, text: str) -> Value:
    """Raises ValueError or KeyError for a text that is no value of the variable."""
    if variable.kind == "Enumeration":
        if text in variable.items:
            return text
        names = {value: name for name, value in variable.items.items()}
        return names[int(text)] if names else int(text)
    if variable.kind == "Boolean":
        return BOOLEANS[text.lower()]
    return TYPE_OF_KIND[variable.kind](text)
