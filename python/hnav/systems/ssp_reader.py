"""Finds, reads and checks systems in SSP 1.0.

A system is an archive NAME.ssp or a folder with SystemStructure.ssd; FMUs that a folder names and does not hold are
those of the build. Parameter sets (SSV) come from bindings in the SSD, of the system or of a component, and from files
*.ssv beside it: `grade_NAME.ssv` or `grades/NAME.ssv` is a grade, `scenario_NAME.ssv` or `scenarios/NAME.ssv` a
scenario.

The standard library parses: fmpy's reader drops the types and units that are to be checked and takes archives only;
pyssp-standard reads well, but brings a unit package and a schema package along for the dozen attributes used here.
Nested systems, signal dictionaries, transformations and parameter mappings are refused by name, never ignored.
"""

from __future__ import annotations

import math
import os
import shutil
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from pathlib import Path

from fmpy.model_description import ScalarVariable

from hnav.errors import HnavError
from hnav.fmi.fmus import description_of, fmu_path, items_of
from hnav.io.outputs import temporary_folder
from hnav.places import CHECKOUT, PACKAGE
from hnav.systems.ssp_archive import SystemFiles, unpack
from hnav.systems.ssp_checks import BASE_UNITS, Units, check_system, text_of
from hnav.systems.structure import Component, Connection, Connector, Parameter, ParameterSet, System, Variable, refuse

SSD = "{http://ssp-standard.org/SSP1/SystemStructureDescription}"
SSC = "{http://ssp-standard.org/SSP1/SystemStructureCommon}"
SSV = "{http://ssp-standard.org/SSP1/SystemStructureParameterValues}"
STRUCTURE = "SystemStructure.ssd"
# Types of FMI 3 by their name in SSP 1.0; the value of an enumeration is an integer.
KIND_OF_TYPE = {
    "Real": "Real", "Float64": "Real", "Float32": "Real", "Boolean": "Boolean", "String": "String", "Enumeration": "Enumeration", "Integer": "Integer",
    **{f"{sign}Int{bits}": "Integer" for sign in ("", "U") for bits in (8, 16, 32, 64)},
}  # fmt: skip


def system_path(text: str) -> Path:
    """An .ssp file, a folder with an SSD, or a name: HNAV_SYSTEMS/NAME.ssp, else the build's, else the package's."""
    path = Path(text)
    if path.suffix == ".ssp" or path.is_dir() or os.sep in text:
        if not path.exists():
            refuse(f"{text}: file not found")
        if path.is_file() and path.suffix == ".fmu":
            refuse(f"{text}: an FMU is no system: hnav observe estimates its states, fmpy simulates it alone")
        return path
    known = known_systems()
    if text in known:
        return known[text]
    hint = f"there are {', '.join(sorted(known))}" if known else "./run fmus makes them, or set HNAV_SYSTEMS to their folder"
    refuse(f"there is no system {text}: {hint}")


def known_systems() -> dict[str, Path]:
    """By name: archives beside the FMUs of a build, or the folders of a wheel, which has each FMU once, among its own."""

    def archives(folder: Path) -> dict[str, Path]:
        return {path.stem: path for path in folder.glob("*.ssp")}

    if "HNAV_SYSTEMS" in os.environ:
        return archives(Path(os.environ["HNAV_SYSTEMS"]))
    packaged = {path.parent.name: path.parent for path in PACKAGE.glob(f"models/systems/*/{STRUCTURE}")}
    built = archives(Path(os.environ["HNAV_FMUS"]).parent / "ssp") if "HNAV_FMUS" in os.environ else {}
    return packaged | archives(CHECKOUT / "build" / "ssp") | built


def system_files(text: str) -> list[Path]:
    """The archive of a system, or all files in its folder."""
    path = system_path(text)
    return sorted(file for file in path.rglob("*") if file.is_file()) if path.is_dir() else [path]


def read_system(path: Path | str, allow_outside: bool = False) -> System:
    """Reads and checks a system. Raises HnavError that names the thing: file, element, connector, parameter, unit.

    allow_outside: an archive may name files that are not in it. A folder may always.
    """
    path = Path(path)
    if path.is_dir():
        return _read_system(SystemFiles(path, path))
    if not path.is_file():
        refuse(f"{path}: file not found")
    folder = temporary_folder("hnav_system_")
    try:
        files = SystemFiles(folder, path, archive=True, allow_outside=allow_outside)
        unpack(path, folder, files.room)
        system = _read_system(files)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    system._folder = folder
    return system


def _parse(path: Path, shown: str) -> ElementTree.Element:
    try:
        return ElementTree.parse(path).getroot()
    except FileNotFoundError:
        refuse(f"{shown}: file not found")
    except Exception as error:  # an unknown encoding is a LookupError, and so on
        refuse(f"{shown}: cannot be read: {(str(error) or type(error).__name__).splitlines()[0]}")


def _read_system(files: SystemFiles) -> System:
    folder, shown = files.folder, files.shown
    root = _parse(folder / STRUCTURE, f"{shown}/{STRUCTURE}")
    element = root.find(f"{SSD}System")
    if element is None:
        refuse(f"{shown}/{STRUCTURE}: there is no ssd:System")
    _refuse_what_is_not_done(element, shown)
    units = _units(root.findall(f"{SSD}Units/{SSC}Unit"))
    declared = root.find(f"{SSD}DefaultExperiment")
    experiment = {} if declared is None else declared.attrib
    master = element.find(f"{SSD}SimulationInformation/{SSD}FixedStepMaster")
    components = {e.get("name", ""): _read_component(e, files) for e in element.iterfind(f"{SSD}Elements/{SSD}Component")}
    if not components:
        refuse(f"{shown}: the system has no components")
    sets = {kind: dict(_beside(folder, kind)) for kind in ("grade", "scenario")}
    system = System(
        name=element.get("name", shown.stem), description=root.get("description", ""), components=components,
        connectors=_connectors(element), connections=[_connection(e) for e in element.iterfind(f"{SSD}Connections/{SSD}Connection")],
        grades=sets["grade"], scenarios=sets["scenario"], start_s=_number(experiment.get("startTime", "0"), "startTime"),
        stop_s=_number(experiment["stopTime"], "stopTime") if "stopTime" in experiment else None,
        step_s=_step(master, components),
    )  # fmt: skip
    check_system(system, units)
    for e in element.iterfind(f"{SSD}Elements/{SSD}Component"):
        system.apply(_bound(e, files, prefix=e.get("name", "") + "."), f"component {e.get('name')}")
    system.apply(_bound(element, files), f"system {system.name}")
    return system


def _step(master: ElementTree.Element | None, components: dict[str, Component]) -> float | None:
    """The step stated in the SSD, otherwise the smallest step stated in an FMU."""
    if master is not None and "stepSize" in master.attrib:
        return _number(master.get("stepSize", ""), "stepSize")
    asked = [c.description.defaultExperiment.stepSize for c in components.values() if c.description.defaultExperiment]
    asked = [_number(step, "stepSize of an FMU") for step in asked if step]
    return min(asked) if asked else None


def _number(text: str, name: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        refuse(f"{name} = {text[:40]!r}: not a finite number")
    return value


def _refuse_what_is_not_done(system: ElementTree.Element, shown: Path) -> None:
    for tag in ("System", "SignalDictionaryReference"):
        for e in system.iterfind(f"{SSD}Elements/{SSD}{tag}"):
            refuse(f"{shown}: {e.get('name')} is a {tag}; hnav runs components only")
    for connection in system.iterfind(f"{SSD}Connections/{SSD}Connection"):
        for child in connection:
            if child.tag.endswith("Transformation"):
                kind = child.tag.rpartition("}")[2]
                refuse(f"{shown}: connection {text_of(_connection(connection))} has a {kind}, which hnav does not do")
    for mapping in system.iter(f"{SSD}ParameterMapping"):
        refuse(f"{shown}: ParameterMapping {mapping.get('source', '')}: hnav takes parameters by their own names only")


def _units(elements: list[ElementTree.Element]) -> Units:
    """A unit without a BaseUnit is omitted: only its name is compared."""
    found = {}
    for element in elements:
        base = element.find(f"{SSC}BaseUnit")
        if base is not None:
            unit = element.get("name", "")
            defaults = dict.fromkeys(BASE_UNITS, "0") | {"factor": "1", "offset": "0"}
            found[unit] = tuple(_number(base.get(name, default), f"unit {unit}: {name}") for name, default in defaults.items())
    return found


def _read_component(element: ElementTree.Element, files: SystemFiles) -> Component:
    name, source, shown = element.get("name", ""), element.get("source", ""), files.shown
    fmu = files.find(source, f"component {name}")
    if not _is_file(fmu):
        # An archive is self-contained; a folder of the repository has no binaries.
        try:
            fmu = fmu if files.archive else fmu_path(Path(source).stem, 2)
        except HnavError as error:
            refuse(f"{shown}: component {name}: {source[:80] or 'its source'} is missing: {error}")
    if not _is_file(fmu):
        refuse(f"{shown}: component {name}: {source[:80] or 'its source'} is missing")
    files.check_fmu(fmu, f"component {name}: {source}")
    if element.get("implementation", "CoSimulation") not in ("CoSimulation", "any"):
        refuse(f"{shown}: component {name}: hnav runs Co-Simulation, not {element.get('implementation')}")
    try:
        description = description_of(fmu)
        variables = {v.name: _variable(v) for v in description.modelVariables}
    except Exception as error:  # fmpy raises bare Exception too
        refuse(f"{shown}: component {name}: {source} is no FMU: {(str(error) or type(error).__name__).splitlines()[0]}")
    if description.coSimulation is None:
        refuse(f"{shown}: component {name}: {source} has no Co-Simulation interface")
    return Component(name, fmu, description, variables, _connectors(element))


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # the name is too long for the file system
        return False


def _variable(v: ScalarVariable) -> Variable:
    unit = v.unit or getattr(v.declaredType, "unit", None) or ""
    return Variable(v.name, KIND_OF_TYPE.get(v.type, v.type), v.causality or "local", unit, items_of(v))


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


def _bound(element: ElementTree.Element, files: SystemFiles, prefix: str = "") -> list[Parameter]:
    """The parameters of an element's bindings, inline or by file, in their order."""
    found = []
    for binding in element.iterfind(f"{SSD}ParameterBindings/{SSD}ParameterBinding"):
        sets = binding.findall(f"{SSD}ParameterValues/{SSV}ParameterSet")
        source = binding.get("source")
        if source is not None:
            # sourceBase component would mean a file inside the FMU.
            if binding.get("sourceBase", "SSD") != "SSD":
                refuse(f"{files.shown}: {source}: a parameter set inside a component is not read")
            sets.append(_parse(files.find(source, "a parameter set"), f"{files.shown}/{source}"))
        for parameter_set in sets:
            found += list(_entries(parameter_set, prefix + binding.get("prefix", "")))
    return found


def _entries(parameter_set: ElementTree.Element, prefix: str = "") -> Iterator[Parameter]:
    for parameter in parameter_set.iterfind(f"{SSV}Parameters/{SSV}Parameter"):
        for typed in parameter:
            if typed.tag.startswith(SSV):
                name, type = prefix + parameter.get("name", ""), typed.tag[len(SSV) :]
                yield Parameter(name, type, typed.get("value", ""), typed.get("unit", ""))


def _beside(folder: Path, kind: str) -> Iterator[tuple[str, ParameterSet]]:
    """Name and content of the parameter sets in the system that are not bound."""
    for path in sorted(folder.rglob("*.ssv")):
        if path.stem.startswith(f"{kind}_"):
            name = path.stem[len(kind) + 1 :]
        elif path.parent.name in (kind, f"{kind}s"):
            name = path.stem
        else:
            continue
        root = _parse(path, path.name)
        yield name, ParameterSet(list(_entries(root)), root.get("description", ""))
