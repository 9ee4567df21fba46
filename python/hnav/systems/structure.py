"""Systems of FMUs as SSP 1.0 describes them: read, checked, and named where they are wrong.

A system is an archive NAME.ssp or a folder with SystemStructure.ssd; FMUs that a folder names and does not hold are
those of the build. Parameter sets (SSV) come from bindings in the SSD, of the system or of a component, and from files
*.ssv beside it: `grade_NAME.ssv` or `grades/NAME.ssv` is a grade, `scenario_NAME.ssv` or `scenarios/NAME.ssv` a
scenario. What comes later overrides: component, system, grade, scenario, the caller; see System.choose.

The standard library parses: fmpy's reader drops the types and units that are to be checked and takes archives only;
pyssp-standard reads well, but brings a unit package and a schema package along for the dozen attributes used here.
Nested systems, signal dictionaries, transformations and parameter mappings are refused by name, never ignored.
"""

from __future__ import annotations

import os
import shutil
import tempfile
import xml.etree.ElementTree as ElementTree
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import fmpy
from fmpy.model_description import ModelDescription

from hnav.errors import HnavError, HnavValueError
from hnav.fmi.fmus import fmu_path
from hnav.places import CHECKOUT, PACKAGE
from hnav.renamed import new_name, now_called

SSD = "{http://ssp-standard.org/SSP1/SystemStructureDescription}"
SSC = "{http://ssp-standard.org/SSP1/SystemStructureCommon}"
SSV = "{http://ssp-standard.org/SSP1/SystemStructureParameterValues}"
STRUCTURE = "SystemStructure.ssd"
BASE_UNITS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
# FMI 3 splits what SSP 1.0 calls by one name; an enumeration's value is an integer.
KIND_OF_TYPE = {
    "Real": "Real", "Float64": "Real", "Float32": "Real", "Boolean": "Boolean", "String": "String", "Enumeration": "Enumeration", "Integer": "Integer",
    **{f"{sign}Int{bits}": "Integer" for sign in ("", "U") for bits in (8, 16, 32, 64)},
}  # fmt: skip
# Far more than anyone counts runs, and a system of many plants stays within 32 bits.
SEED_STRIDE = 1_000_000
TYPE_OF_KIND = {"Real": float, "Integer": int, "Boolean": bool, "String": str}
BOOLEANS = {"true": True, "1": True, "false": False, "0": False}


@dataclass(frozen=True)
class Variable:
    """A variable of an FMU as a system sees it. kind: Real, Integer, Boolean, Enumeration or String."""

    name: str
    kind: str
    causality: str
    unit: str
    items: Mapping[str, int] = field(default_factory=dict)  # of an enumeration


@dataclass(frozen=True)
class Connector:
    """A connector that the SSD declares. kind: input, output, parameter, ...; type and unit may be left open (empty)."""

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
    parameters: dict[str, object] = field(default_factory=dict)


@dataclass(frozen=True)
class Connection:
    """From start to end, each (element, connector); the element "" is the system itself."""

    start: tuple[str, str]
    end: tuple[str, str]


@dataclass(frozen=True)
class Parameter:
    """One entry of a parameter set, before it is held against a component. type: Real, Integer, ...; "" is untyped text."""

    name: str
    type: str
    value: str
    unit: str = ""


@dataclass
class System:
    """A checked system, ready to run. Use as a context manager: unpacked archives go when it ends."""

    name: str
    description: str
    components: dict[str, Component]
    connectors: dict[str, Connector]
    connections: list[Connection]
    grades: dict[str, list[Parameter]]
    scenarios: dict[str, list[Parameter]]
    start_s: float
    stop_s: float | None
    step_s: float | None
    _folder: Path | None = None

    def __enter__(self) -> System:
        return self

    def __exit__(self, *_) -> None:
        if self._folder:
            shutil.rmtree(self._folder, ignore_errors=True)

    def apply(self, parameters: list[Parameter], where: str) -> None:
        """Sets parameters named component.parameter. Raises HnavError that begins with `where`."""
        for parameter in parameters:
            component, name = self._owner(parameter.name, where)
            component.parameters[name] = parameter_value(component, name, parameter, where)

    def choose(self, grade: str | None = None, scenario: str | None = None) -> None:
        """Applies a grade and a scenario by name. A scenario that names sensors too lays over a grade only what it changes
        against the sets bound in the SSD: the disturbance stays, the sensor is the grade's.
        """
        for kind, name, sets in (("grade", grade, self.grades), ("scenario", scenario, self.scenarios)):
            if name is not None and name not in sets:
                known = f"it has {', '.join(sorted(sets))}" if sets else "it has none"
                raise HnavValueError("option", f"system {self.name} has no {kind} {name}: {known}")
        bound = self.parameters()
        if grade is not None:
            self.apply(self.grades[grade], f"grade {grade}")
        if scenario is not None:
            graded = self.parameters()
            self.apply(self.scenarios[scenario], f"scenario {scenario}")
            if grade is not None:
                for name, value in self.parameters().items():
                    if value == bound.get(name) and name in graded:
                        component, _, parameter = name.partition(".")
                        self.components[component].parameters[parameter] = graded[name]

    def seed(self, seed: int) -> None:
        """Sets the parameter `seed` of every component that has one: seed, seed + SEED_STRIDE, ... in the order of
        their names, so that no two plants draw the same noise."""
        seeded = [c for _, c in sorted(self.components.items()) if "seed" in c.variables]
        if not seeded:
            raise HnavValueError("option", f"seed {seed}: no component of system {self.name} has a parameter seed")
        for i, component in enumerate(seeded):
            self.apply([Parameter(f"{component.name}.seed", "", str(seed + i * SEED_STRIDE))], "seed")

    def parameters(self) -> dict[str, object]:
        """All that is set, by component.parameter; the rest are the FMUs' own start values."""
        return {f"{c.name}.{name}": value for c in self.components.values() for name, value in sorted(c.parameters.items())}

    def _owner(self, name: str, where: str) -> tuple[Component, str]:
        component, _, parameter = name.partition(".")
        if component not in self.components or not parameter:
            new = new_name(component, "component")
            hint = f"; {component} is now called {new}" if new else ""
            raise HnavValueError(
                "option", f"{where}: {name} names no component of system {self.name} ({', '.join(self.components)}){hint}"
            )
        return self.components[component], parameter


# --------------------------------------------------------------------------------------------- finding and reading


def system_path(text: str) -> Path:
    """An .ssp file, a folder with an SSD, or a name: HNAV_SYSTEMS/NAME.ssp, else the build's, else the package's."""
    path = Path(text)
    if path.suffix == ".ssp" or path.is_dir() or os.sep in text:
        if not path.exists():
            raise HnavValueError("option", f"{text}: file not found")
        return path
    known = _known_systems()
    if text in known:
        return known[text]
    hint = f"there are {', '.join(sorted(known))}" if known else "./run fmus makes them, or set HNAV_SYSTEMS to their folder"
    raise HnavValueError("option", f"there is no system {text}: {hint}")


def _known_systems() -> dict[str, Path]:
    """By name: archives beside the FMUs of a build, or the folders of a wheel, which has each FMU once, among its own."""

    def archives(folder: Path) -> dict[str, Path]:
        return {path.stem: path for path in folder.glob("*.ssp")}

    if "HNAV_SYSTEMS" in os.environ:
        return archives(Path(os.environ["HNAV_SYSTEMS"]))
    packaged = {path.parent.name: path.parent for path in PACKAGE.glob(f"models/systems/*/{STRUCTURE}")}
    built = archives(Path(os.environ["HNAV_FMUS"]).parent / "ssp") if "HNAV_FMUS" in os.environ else {}
    return packaged | archives(CHECKOUT / "build" / "ssp") | built


def read_system(path: Path | str) -> System:
    """Reads and checks a system. Raises HnavError that names the thing: file, element, connector, parameter, unit."""
    path = Path(path)
    if path.is_dir():
        return _read_folder(path, path)
    if not path.is_file():
        raise HnavValueError("option", f"{path}: file not found")
    folder = Path(tempfile.mkdtemp(prefix="hnav_system_"))
    try:
        try:
            with zipfile.ZipFile(path) as archive:
                archive.extractall(folder)
        except (zipfile.BadZipFile, OSError) as error:
            raise HnavValueError("option", f"{path}: no SSP archive: {error}") from None
        system = _read_folder(folder, path)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    system._folder = folder
    return system


def _parse(path: Path, shown: str) -> ElementTree.Element:
    try:
        return ElementTree.parse(path).getroot()
    except FileNotFoundError:
        raise HnavValueError("option", f"{shown}: file not found") from None
    except (ElementTree.ParseError, OSError) as error:
        raise HnavValueError("option", f"{shown}: cannot be read: {error}") from None


def _read_folder(folder: Path, shown: Path) -> System:
    root = _parse(folder / STRUCTURE, f"{shown}/{STRUCTURE}")
    element = root.find(f"{SSD}System")
    if element is None:
        raise HnavValueError("option", f"{shown}/{STRUCTURE}: there is no ssd:System")
    _refuse_what_is_not_done(element, shown)
    units = _units(root.findall(f"{SSD}Units/{SSC}Unit"))
    experiment = root.find(f"{SSD}DefaultExperiment")
    experiment = {} if experiment is None else experiment.attrib
    master = element.find(f"{SSD}SimulationInformation/{SSD}FixedStepMaster")
    components = {e.get("name", ""): _read_component(e, folder, shown) for e in element.iterfind(f"{SSD}Elements/{SSD}Component")}
    if not components:
        raise HnavValueError("option", f"{shown}: the system has no components")
    sets = {kind: dict(_beside(folder, kind)) for kind in ("grade", "scenario")}
    system = System(
        name=element.get("name", shown.stem), description=root.get("description", ""), components=components,
        connectors=_connectors(element), connections=[_connection(e) for e in element.iterfind(f"{SSD}Connections/{SSD}Connection")],
        grades=sets["grade"], scenarios=sets["scenario"], start_s=_number(experiment.get("startTime", "0"), "startTime"),
        stop_s=_number(experiment["stopTime"], "stopTime") if "stopTime" in experiment else None,
        step_s=_step(master, components),
    )  # fmt: skip
    for component in components.values():
        _check_connectors(component, units)
    for connection in system.connections:
        _check_connection(system, connection, units)
    _check_single_source(system.connections)
    for e in element.iterfind(f"{SSD}Elements/{SSD}Component"):
        system.apply(_bound(e, folder, shown, prefix=e.get("name", "") + "."), f"component {e.get('name')}")
    system.apply(_bound(element, folder, shown), f"system {system.name}")
    return system


def _step(master: ElementTree.Element | None, components: dict[str, Component]) -> float | None:
    """The step that the SSD asks for, else the finest that an FMU asks for."""
    if master is not None and "stepSize" in master.attrib:
        return _number(master.get("stepSize", ""), "stepSize")
    asked = [c.description.defaultExperiment.stepSize for c in components.values() if c.description.defaultExperiment]
    asked = [float(step) for step in asked if step]
    return min(asked) if asked else None


def _number(text: str, name: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise HnavValueError("option", f"{name} = {text}: not a number") from None


def _refuse_what_is_not_done(system: ElementTree.Element, shown: Path) -> None:
    for tag in ("System", "SignalDictionaryReference"):
        for e in system.iterfind(f"{SSD}Elements/{SSD}{tag}"):
            raise HnavValueError("option", f"{shown}: {e.get('name')} is a {tag}; hnav runs components only")
    for connection in system.iterfind(f"{SSD}Connections/{SSD}Connection"):
        for child in connection:
            if child.tag.endswith("Transformation"):
                raise HnavValueError(
                    "option",
                    f"{shown}: connection {_text(_connection(connection))} has a {child.tag.rpartition('}')[2]}, which hnav does not do",
                )
    for mapping in system.iter(f"{SSD}ParameterMapping"):
        raise HnavValueError(
            "option", f"{shown}: ParameterMapping {mapping.get('source', '')}: hnav takes parameters by their own names only"
        )


def _units(elements: list[ElementTree.Element]) -> dict[str, tuple[float, ...]]:
    """Exponents of the base units, factor and offset, by name of the unit; without a BaseUnit the name alone counts."""
    found = {}
    for element in elements:
        base = element.find(f"{SSC}BaseUnit")
        if base is not None:
            powers = [float(base.get(name, 0)) for name in BASE_UNITS]
            found[element.get("name", "")] = (*powers, float(base.get("factor", 1)), float(base.get("offset", 0)))
    return found


def _fmu_units(description: ModelDescription) -> dict[str, tuple[float, ...]]:
    bases = {unit.name: unit.baseUnit for unit in description.unitDefinitions if unit.baseUnit}
    return {
        name: (*(float(getattr(base, power, 0) or 0) for power in BASE_UNITS), float(base.factor or 1), float(base.offset or 0))
        for name, base in bases.items()
    }


def _read_component(element: ElementTree.Element, folder: Path, shown: Path) -> Component:
    name, source = element.get("name", ""), element.get("source", "")
    fmu = folder / source
    if not fmu.is_file():
        # An archive is complete in itself; a folder of the repository holds no binaries.
        try:
            fmu = fmu if zipfile.is_zipfile(shown) else fmu_path(Path(source).stem, 2)
        except HnavError as error:
            raise HnavValueError("option", f"{shown}: component {name}: {source or 'its source'} is missing: {error}") from None
    if not fmu.is_file():
        raise HnavValueError("option", f"{shown}: component {name}: {source or 'its source'} is missing")
    if element.get("implementation", "CoSimulation") not in ("CoSimulation", "any"):
        raise HnavValueError("option", f"{shown}: component {name}: hnav runs Co-Simulation, not {element.get('implementation')}")
    try:
        description = fmpy.read_model_description(str(fmu), validate=False)
    except Exception as error:  # fmpy raises bare Exception too
        raise HnavValueError("option", f"{shown}: component {name}: {source} is no FMU: {error}") from None
    if description.coSimulation is None:
        raise HnavValueError("option", f"{shown}: component {name}: {source} has no Co-Simulation interface")
    return Component(name, fmu, description, {v.name: _variable(v) for v in description.modelVariables}, _connectors(element))


def _variable(v) -> Variable:
    declared = v.declaredType
    items = {i.name: int(i.value) for i in declared.items} if declared is not None and getattr(declared, "items", None) else {}
    return Variable(
        v.name, KIND_OF_TYPE.get(v.type, v.type), v.causality or "local", v.unit or getattr(declared, "unit", None) or "", items
    )


def _connectors(element: ElementTree.Element) -> dict[str, Connector]:
    found = {}
    for c in element.iterfind(f"{SSD}Connectors/{SSD}Connector"):
        typed = next((child for child in c if child.tag.startswith(SSC)), None)
        type, unit = ("", "") if typed is None else (typed.tag[len(SSC) :], typed.get("unit", ""))
        found[c.get("name", "")] = Connector(c.get("name", ""), c.get("kind", ""), type, unit)
    return found


def _connection(element: ElementTree.Element) -> Connection:
    ends = [(element.get(f"{side}Element", ""), element.get(f"{side}Connector", "")) for side in ("start", "end")]
    return Connection(*ends)


# --------------------------------------------------------------------------------------------- parameter sets


def _bound(element: ElementTree.Element, folder: Path, shown: Path, prefix: str = "") -> list[Parameter]:
    """The parameters of an element's bindings, inline or by file, in their order."""
    found = []
    for binding in element.iterfind(f"{SSD}ParameterBindings/{SSD}ParameterBinding"):
        sets = binding.findall(f"{SSD}ParameterValues/{SSV}ParameterSet")
        source = binding.get("source")
        if source is not None:
            # sourceBase component would mean a file inside the FMU.
            if binding.get("sourceBase", "SSD") != "SSD":
                raise HnavValueError("option", f"{shown}: {source}: a parameter set inside a component is not read")
            sets.append(_parse(folder / source, f"{shown}/{source}"))
        for parameter_set in sets:
            found += list(_entries(parameter_set, prefix + binding.get("prefix", "")))
    return found


def _entries(parameter_set: ElementTree.Element, prefix: str = "") -> Iterator[Parameter]:
    for parameter in parameter_set.iterfind(f"{SSV}Parameters/{SSV}Parameter"):
        for typed in parameter:
            if typed.tag.startswith(SSV):
                yield Parameter(
                    prefix + parameter.get("name", ""), typed.tag[len(SSV) :], typed.get("value", ""), typed.get("unit", "")
                )


def _beside(folder: Path, kind: str) -> Iterator[tuple[str, list[Parameter]]]:
    """Name and parameters of the sets that lie in the system without being bound."""
    for path in sorted(folder.rglob("*.ssv")):
        if path.stem.startswith(f"{kind}_"):
            name = path.stem[len(kind) + 1 :]
        elif path.parent.name in (kind, f"{kind}s"):
            name = path.stem
        else:
            continue
        yield name, list(_entries(_parse(path, path.name)))


def parameter_value(component: Component, name: str, parameter: Parameter, where: str) -> object:
    """The value as the variable's type. Raises HnavError for unknown names, wrong types and foreign units."""
    variable, full = component.variables.get(name), f"{component.name}.{name}"
    if variable is None:
        raise HnavValueError(
            "option",
            f"{where}: component {component.name} ({component.description.modelName}) has no parameter {name}"
            f"{now_called(name, 'option', 'variable')}",
        )
    # SSP sets start values of inputs by the same entries.
    if variable.causality not in ("parameter", "structuralParameter", "input"):
        raise HnavValueError("option", f"{where}: {full} is a variable of kind {variable.causality}, not a parameter")
    if parameter.type and not types_agree(parameter.type, variable.kind):
        raise HnavValueError("option", f"{where}: {full} is {variable.kind}, not {parameter.type}")
    if parameter.unit and variable.unit != parameter.unit:
        raise HnavValueError("option", f"{where}: {full} is in {variable.unit or '1 (no unit)'}, not in {parameter.unit}")
    try:
        return _converted(variable, parameter.value.strip())
    except ValueError:
        wanted = f"one of {', '.join(variable.items)}" if variable.items else f"a {variable.kind}"
        raise HnavValueError("option", f"{where}: {full} = {parameter.value}: {wanted} is wanted") from None


def _converted(variable: Variable, text: str) -> object:
    if variable.kind == "Enumeration":
        if text in variable.items:
            return variable.items[text]
        if variable.items and int(text) not in variable.items.values():
            raise ValueError(text)
        return int(text)
    if variable.kind == "Boolean":
        if text.lower() not in BOOLEANS:
            raise ValueError(text)
        return BOOLEANS[text.lower()]
    return TYPE_OF_KIND[variable.kind](text)


# --------------------------------------------------------------------------------------------- checks


def types_agree(one: str, other: str) -> bool:
    """SSP 1.0 lets an enumeration be given by its number."""
    return one == other or {one, other} == {"Integer", "Enumeration"}


def _units_agree(one: str, ones: Mapping[str, tuple], other: str, others: Mapping[str, tuple]) -> bool:
    """The same name, or names whose definitions are the same. A unit that is left open agrees with all."""
    return one == other or not one or not other or (one in ones and ones[one] == others.get(other))


def _check_connectors(component: Component, units: Mapping[str, tuple]) -> None:
    fmu_units = _fmu_units(component.description)
    for connector in component.connectors.values():
        variable, full = component.variables.get(connector.name), f"{component.name}.{connector.name}"
        if variable is None:
            raise HnavValueError(
                "option",
                f"connector {full}: {component.description.modelName} has no variable {connector.name}{now_called(connector.name, 'option', 'variable')}",
            )
        if connector.kind in ("input", "output", "parameter") and connector.kind != variable.causality:
            raise HnavValueError(
                "option",
                f"connector {full} is an {connector.kind} in the SSD and a variable of kind {variable.causality} in the FMU",
            )
        if connector.type and not types_agree(connector.type, variable.kind):
            raise HnavValueError("option", f"connector {full} is {connector.type} in the SSD and {variable.kind} in the FMU")
        if not _units_agree(connector.unit, units, variable.unit, fmu_units):
            raise HnavValueError(
                "option", f"connector {full} is in {connector.unit} in the SSD and in {variable.unit} in the FMU"
            )


def _text(connection: Connection) -> str:
    return " -> ".join(".".join(filter(None, end)) for end in (connection.start, connection.end))


def _check_connection(system: System, connection: Connection, units: Mapping[str, tuple]) -> None:
    """Data flow out of an output (or the system's input) into an input (or the system's output), of one type and unit."""
    kinds, types, unit_names, definitions = [], [], [], []
    for element, name in (connection.start, connection.end):
        if element and element not in system.components:
            raise HnavValueError("option", f"connection {_text(connection)}: there is no element {element}")
        declared = system.components[element].connectors if element else system.connectors
        if name not in declared:
            raise HnavValueError(
                "option", f"connection {_text(connection)}: {element or f'system {system.name}'} has no connector {name}"
            )
        connector, kind = declared[name], declared[name].kind
        # Seen from inside, the system's inputs give and its outputs take.
        kinds.append(kind if element else {"input": "output", "output": "input"}.get(kind, kind))
        variable = system.components[element].variables[name] if element else None
        types.append(variable.kind if variable else connector.type)
        unit_names.append(variable.unit if variable else connector.unit)
        definitions.append(_fmu_units(system.components[element].description) if element else units)
    if kinds != ["output", "input"]:
        raise HnavValueError(
            "option",
            f"connection {_text(connection)}: it runs from an {kinds[0]} to an {kinds[1]}; an output to an input is wanted",
        )
    if types[0] and types[1] and types[0] != types[1]:
        raise HnavValueError("option", f"connection {_text(connection)}: {types[0]} does not fit {types[1]}")
    if not _units_agree(unit_names[0], definitions[0], unit_names[1], definitions[1]):
        raise HnavValueError("option", f"connection {_text(connection)}: {unit_names[0]} does not fit {unit_names[1]}")


def _check_single_source(connections: list[Connection]) -> None:
    ends: dict[tuple[str, str], Connection] = {}
    for connection in connections:
        other = ends.setdefault(connection.end, connection)
        if other is not connection:
            raise HnavValueError(
                "option",
                f"connection {_text(connection)}: {'.'.join(connection.end)} is already fed by {'.'.join(filter(None, other.start))}",
            )
