"""Reads modelDescription.xml (FMI 2 and 3) of an FMU for Model Exchange, or else Co-Simulation, as far as an observer needs it.

hnav has its own reader because others refuse some valid files (FMI 3 by Dymola) or ignore providesDirectionalDerivatives.
"""

from __future__ import annotations

import difflib
import math
import platform
import sys
import zipfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn
from xml.etree import ElementTree

from hnav.errors import HnavValueError

REALS = ("Real", "Float64")
_TYPES = ("Real", "Integer", "Boolean", "String", "Enumeration")  # FMI 2
DIMENSIONS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
_NO_BOUND = 1e100
_STEP_S = 0.01  # step in s of a Co-Simulation FMU that states none
_TOO_LARGE = 200_000_000  # largest size of a description in bytes, above that of any tool


@dataclass(frozen=True)
class Unit:
    """value in SI base units = factor * value + offset."""

    factor: float
    offset: float
    dimensions: tuple[int, ...]
    """Exponents of kg, m, s, A, K, mol, cd, rad."""


@dataclass(frozen=True)
class Variable:
    """One variable of an FMU."""

    name: str
    reference: int
    type: str
    """"Real", "Float64", "Boolean", ..."""
    causality: str
    variability: str
    unit: str
    """Of the variable or of its declared type; empty if none is given."""
    description: str
    start: float
    """NaN: none is given."""
    min: float
    """-inf: none is given."""
    max: float
    """inf: none is given."""
    is_array: bool
    derivative_of: int | None
    """FMI 2: number of the state in the list, from 1; FMI 3: reference of the state."""

    @property
    def is_real(self) -> bool:
        """Of type Real or Float64, and no array."""
        return self.type in REALS and not self.is_array


@dataclass(frozen=True)
class ModelDescription:
    """An FMU for Model Exchange, or with Co-Simulation only, created by read_model_description."""

    path: Path
    fmi: int
    """FMI version: 2 or 3."""
    name: str
    identifier: str
    """Name of the binary for Model Exchange."""
    token: str
    """GUID or instantiation token."""
    variables: dict[str, Variable]
    """By name, in the order of the file."""
    states: tuple[tuple[Variable, Variable], ...]
    """State and derivative, in the order of the FMU."""
    depends: tuple[frozenset[int] | None, ...]
    """References of the variables on which each derivative depends; None: the FMU declares none, so all."""
    indicators: int
    """Number of declared event indicators; in FMI 3, of all listed ones."""
    offers_derivatives: bool
    once: bool
    """Only one instance for each process."""
    discrete: tuple[str, ...]
    """Names of the discrete variables, which keep their values between events."""
    state_access: int
    """0: the state cannot be saved; 1: it can be read and set; 2: it can also be serialised."""
    step_done: bool
    """The solver must report completed steps."""
    step_s: float
    """Default step in s of an FMU with Co-Simulation only; 0: Model Exchange."""
    binary: str
    """Path inside the FMU of the binary for this machine."""
    units: dict[str, Unit] = field(default_factory=dict)

    def variable(self, name: str) -> Variable:
        """Raises HnavValueError that proposes the nearest names."""
        found = self.variables.get(name)
        if found is None:
            near = difflib.get_close_matches(name, self.variables, n=3)
            raise HnavValueError(
                "option", f"{self.path.name} has no variable {name!r}" + (f"; nearest: {', '.join(near)}" if near else ""), name
            )
        return found


def read_model_description(path: Path | str) -> ModelDescription:
    """Raises HnavValueError, with the remedy, for an FMU that an observer cannot use."""
    path = Path(path)
    root, names = _read(path)
    fmi = {"2": 2, "3": 3}.get(root.get("fmiVersion", "")[:1])
    if fmi is None:
        _refuse(path, f"FMI {root.get('fmiVersion', 'of an unknown version')}: export it for FMI 2 or 3")
    exchange, step_s = root.find("ModelExchange"), 0.0
    if exchange is None:
        exchange, step_s = _cosimulation(path, root)
    if _says(exchange, "needsExecutionTool"):
        _refuse(path, "needs its tool at run time: export it with the solver's and the tool's code inside")
    variables, order = _variables(root, fmi)
    states, depends = _states(path, root, fmi, order)
    identifier = exchange.get("modelIdentifier", "")
    return ModelDescription(
        path=path,
        fmi=fmi,
        name=root.get("modelName", path.stem),
        identifier=identifier,
        token=root.get("guid" if fmi == 2 else "instantiationToken", ""),
        variables={variable.name: variable for variable in variables},
        states=states,
        depends=(None,) * len(states) if step_s else depends,  # over a step each state may depend on all
        indicators=_indicators(root, fmi),
        offers_derivatives=_says(exchange, "providesDirectionalDerivative", "providesDirectionalDerivatives") and not step_s,
        once=_says(exchange, "canBeInstantiatedOnlyOncePerProcess"),
        discrete=tuple(v.name for v in variables if v.variability == "discrete" and v.causality in ("local", "output")),
        state_access=_state_access(exchange),
        step_done=not _says(exchange, "completedIntegratorStepNotNeeded")
        if fmi == 2
        else _says(exchange, "needsCompletedIntegratorStep"),
        step_s=step_s,
        binary=_binary(path, names, identifier, fmi),
        units=_units(root),
    )


def _cosimulation(path: Path, root: ElementTree.Element) -> tuple[ElementTree.Element, float]:
    """Sigma points need steps of any length from any state."""
    element = root.find("CoSimulation")
    remedy = "export it for Model Exchange, or write its derivatives as functions (hnav.Plant)"
    if element is None:
        _refuse(path, f"offers neither Model Exchange nor Co-Simulation: {remedy}")
    if not _state_access(element):
        _refuse(path, f"offers Co-Simulation only and cannot get and set its state (canGetAndSetFMUstate): {remedy}")
    if not _says(element, "canHandleVariableCommunicationStepSize"):
        _refuse(path, f"offers Co-Simulation only, with steps of one length (canHandleVariableCommunicationStepSize): {remedy}")
    experiment = root.find("DefaultExperiment")
    step_s = _number(element.get("fixedInternalStepSize") or (None if experiment is None else experiment.get("stepSize")))
    return element, step_s if step_s > 0 and math.isfinite(step_s) else _STEP_S


def _says(element: ElementTree.Element, *names: str) -> bool:
    """Whether one of these attributes, as FMI 2 and 3 call it, is true."""
    return any(element.get(name) == "true" for name in names)


def _state_access(exchange: ElementTree.Element) -> int:
    if not _says(exchange, "canGetAndSetFMUstate", "canGetAndSetFMUState"):
        return 0
    return 2 if _says(exchange, "canSerializeFMUstate", "canSerializeFMUState") else 1


def _refuse(path: Path, reason: str) -> NoReturn:
    raise HnavValueError("option", f"{path.name} {reason}", "fmu") from None


def _read(path: Path) -> tuple[ElementTree.Element, list[str]]:
    try:
        with zipfile.ZipFile(path) as archive:
            info = archive.getinfo("modelDescription.xml")
            if info.file_size > _TOO_LARGE:
                _refuse(path, "has a modelDescription.xml beyond all sense")
            return ElementTree.fromstring(archive.read(info)), archive.namelist()
    except OSError as error:
        raise HnavValueError("file", f"{path}: cannot be read: {error.strerror or error}", "fmu") from None
    except zipfile.BadZipFile:
        _refuse(path, "is no FMU: it is no zip archive")
    except KeyError:
        _refuse(path, "is no FMU: it holds no modelDescription.xml")
    except (ElementTree.ParseError, RuntimeError, ValueError) as error:
        _refuse(path, f"has a modelDescription.xml that cannot be read: {error}")


def _number(text: str | None) -> float:
    try:
        return float((text or "nan").split()[0])
    except (ValueError, IndexError):
        return math.nan


def _declared(kind: ElementTree.Element | None, attribute: str) -> str:
    return "" if kind is None else kind.get(attribute, "")


def _bound(typed: ElementTree.Element, kind: ElementTree.Element | None, attribute: str, none: float) -> float:
    """A limit of the variable or of its declared type. Some tools write the largest double where there is no limit."""
    bound = _number(typed.get(attribute) or _declared(kind, attribute) or None) if typed.tag in REALS else none
    return none if math.isnan(bound) or abs(bound) >= _NO_BOUND else bound


def _variables(root: ElementTree.Element, fmi: int) -> tuple[list[Variable], dict[int, Variable]]:
    """All variables, and the real ones by number from 1 (FMI 2) or value reference (FMI 3)."""
    declared = {kind.get("name"): kind if fmi == 3 else next(iter(kind), kind) for kind in root.findall("TypeDefinitions/*")}
    variables, order = list[Variable](), dict[int, Variable]()
    for number, element in enumerate(root.findall("ModelVariables/*"), 1):
        typed = element if fmi == 3 else next((child for child in element if child.tag in _TYPES), element)
        derivative = typed.get("derivative")
        variable = Variable(
            name=element.get("name", ""),
            reference=int(element.get("valueReference", "0")),
            type=typed.tag,
            causality=element.get("causality", "local"),
            variability=element.get("variability", "continuous" if typed.tag in REALS else "discrete"),
            unit=typed.get("unit") or _declared(declared.get(typed.get("declaredType")), "unit"),
            description=element.get("description", ""),
            start=_number(typed.get("start")) if typed.tag in REALS else math.nan,
            min=_bound(typed, declared.get(typed.get("declaredType")), "min", -math.inf),
            max=_bound(typed, declared.get(typed.get("declaredType")), "max", math.inf),
            is_array=element.find("Dimension") is not None,
            derivative_of=int(derivative) if derivative is not None else None,
        )
        variables.append(variable)
        order[number if fmi == 2 else variable.reference] = variable
    return variables, order


def _states(
    path: Path, root: ElementTree.Element, fmi: int, order: dict[int, Variable]
) -> tuple[tuple[tuple[Variable, Variable], ...], tuple[frozenset[int] | None, ...]]:
    """States with their derivatives and dependencies."""
    structure = root.find("ModelStructure")
    if structure is None:
        _refuse(path, "has no ModelStructure: export it with a tool that writes one")
    unknowns = structure.findall("Derivatives/Unknown") if fmi == 2 else structure.findall("ContinuousStateDerivative")
    attribute = "index" if fmi == 2 else "valueReference"
    states, depends = [], []
    for unknown in unknowns:
        derivative = order.get(int(unknown.get(attribute, "-1")))
        state = order.get(derivative.derivative_of) if derivative and derivative.derivative_of is not None else None
        if derivative is None or state is None:
            _refuse(path, "names a derivative whose state cannot be found: its modelDescription.xml is wrong")
        if state.is_array:
            _refuse(path, f"has an array for a state ({state.name}): export it with scalar states")
        states.append((state, derivative))
        depends.append(_dependencies(unknown.get("dependencies"), order))
    if not states:
        _refuse(path, "has no continuous states: there is nothing to estimate")
    return tuple(states), tuple(depends)


def _dependencies(listed: str | None, order: dict[int, Variable]) -> frozenset[int] | None:
    """Variables by reference; a list with an unknown reference is ignored."""
    if listed is None or not all(number.isdecimal() and int(number) in order for number in listed.split()):
        return None
    return frozenset(order[int(number)].reference for number in listed.split())


def _indicators(root: ElementTree.Element, fmi: int) -> int:
    if fmi == 2:
        return int(root.get("numberOfEventIndicators") or 0)
    return len(root.findall("ModelStructure/EventIndicator"))


def _platform(fmi: int) -> tuple[str, str]:
    """The folder of binaries for this machine, and their suffix."""
    system = {"win32": "windows", "darwin": "darwin"}.get(sys.platform, "linux")
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(platform.machine().lower(), platform.machine().lower())
    ending = {"windows": ".dll", "darwin": ".dylib"}.get(system, ".so")
    if fmi == 3:
        return f"{machine}-{system}", ending
    bits = {"x86_64": "64"}.get(machine, "")
    return ({"windows": "win", "darwin": "darwin", "linux": "linux"}[system] + bits if bits else f"{machine}-{system}"), ending


def _binary(path: Path, names: list[str], identifier: str, fmi: int) -> str:
    folder, ending = _platform(fmi)
    binary = f"binaries/{folder}/{identifier}{ending}"
    if binary not in names:
        files = [name for name in names if name.startswith("binaries/") and not name.endswith("/")]
        has = sorted({name.split("/")[1] for name in files if name.count("/") > 1})
        _refuse(path, f"has no binary for {folder} (it has {', '.join(has) or 'none'}): export or compile it for this machine")
    return binary


def _units(root: ElementTree.Element) -> dict[str, Unit]:
    units = dict[str, Unit]()
    for unit in root.findall("UnitDefinitions/Unit"):
        base = unit.find("BaseUnit")
        if base is not None:
            dimensions = tuple(int(base.get(name, "0")) for name in DIMENSIONS)
            own = units[unit.get("name", "")] = Unit(*_scale(base), dimensions)
            # The display unit: displayed = factor * value + offset.
            for shown in unit.findall("DisplayUnit"):
                factor, offset = _scale(shown)
                if not _says(shown, "inverse") and factor != 0:
                    scale = own.factor / factor
                    units.setdefault(shown.get("name", ""), Unit(scale, own.offset - scale * offset, dimensions))
    return units


def _scale(element: ElementTree.Element) -> tuple[float, float]:
    return float(element.get("factor", "1")), float(element.get("offset", "0"))
