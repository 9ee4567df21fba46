"""What an observer is to estimate, by which sensors, and what is known beforehand: a Plan, in Python or as a TOML file."""

from __future__ import annotations

import difflib
import math
import re
import runpy
import tomllib
from collections.abc import Iterable, Iterator
from copy import copy
from dataclasses import dataclass, replace
from inspect import Parameter, signature
from pathlib import Path
from typing import Any, Self

from hnav.errors import HnavValueError
from hnav.filters.plant import Plant
from hnav.io.model_description import ModelDescription, Variable, read_model_description


@dataclass(frozen=True)
class Estimated:
    """What is known of a state, an unknown input or a parameter, in its unit."""

    start: float = math.nan
    """NaN: the plant's own."""
    start_sigma: float = 0.0
    """Its standard deviation."""
    noise: float = 0.0
    """White noise that drives it, unit / sqrt(s)."""
    ready_sigma: float = math.inf
    """Below it is ready."""
    time_constant_s: float = 0.0
    """Of an unknown input that decays; 0: a random walk."""
    nominal: float = 0.0
    """Usual size, where start and start_sigma do not tell it."""
    min: float = -math.inf
    """It is at least that."""
    max: float = math.inf
    """It is at most that."""
    log: bool = False
    """A positive parameter that is estimated by its logarithm."""


@dataclass(frozen=True)
class Sensor:
    """What is known of a sensor, in its own unit: value of the plant = factor * value + offset."""

    noise: float
    """Sigma of a sample."""
    gate_nis: float = 0.0
    """NIS beyond which a sample is used with more noise; 0: never."""
    factor: float = 1.0
    """From its unit to the plant's."""
    offset: float = 0.0
    """In the plant's unit."""
    of: str = ""
    """The variable of the plant that it reads."""
    own_offset: float = 0.0
    """What the plan adds to its samples, in its own unit."""


@dataclass(frozen=True)
class Input:
    """A known input: value of the plant = factor * sample + offset."""

    start: float = math.nan
    """Before its first sample, in the plant's unit; NaN: the plant's own."""
    column: str = ""
    """Its samples in a table."""
    factor: float = 1.0
    """From a sample to the plant's unit."""
    offset: float = 0.0
    """In the plant's unit."""
    interpolation: str = "hold"
    """"hold", or "linear" between the samples of a recording."""


class Plan:
    """A plant, FMU or Plant, and what is known of its states, inputs and sensors.

        plan = hnav.Plan("oscillator.fmu").sensor("x0", noise=0.05).state("x1", start_sigma=1.0, noise=0.1)

    The plant needs one sensor at least, and a start_sigma or noise somewhere. Each call returns the plan; it raises HnavValueError
    for names that the plant does not have, and for what its FMU does not let one do. memoryless: the FMU has event indicators or
    discrete variables, but remembers nothing: its answers depend on time, states, inputs and parameters alone. never_freed: the FMU
    crashes when it is freed, so its instances stay until the process ends.
    """

    def __init__(self, plant: str | Path | Plant, memoryless: bool = False, never_freed: bool = False):
        self.plant = plant if isinstance(plant, Plant) else read_model_description(plant)
        self.memoryless = memoryless
        self.never_freed = never_freed
        self.states: dict[str, Estimated] = {name: self._bounded(name, Estimated()) for name in self._state_names()}
        self.unknown_inputs: dict[str, Estimated] = {}
        self.parameters: dict[str, Estimated] = {}
        self.inputs: dict[str, Input] = {}
        self.sensors: dict[str, Sensor] = {}
        self.set_values: dict[str, float] = {}
        self.options: dict[str, Any] = {}
        if isinstance(self.plant, ModelDescription) and not memoryless:
            _refuse_events(self.plant)

    @property
    def estimated(self) -> tuple[str, ...]:
        """Names of all that is estimated, in the order of the library: states, unknown inputs, parameters."""
        return (*self.states, *self.unknown_inputs, *self.parameters)

    def state(
        self, name: str, *, start: float = math.nan, start_sigma: float = 0.0, noise: float = 0.0, ready_sigma: float = math.inf,
        nominal: float = 0.0, min: float | None = None, max: float | None = None,
    ) -> Self:  # fmt: skip
        """start: NaN for the plant's own; noise: white noise that drives the state, unit / sqrt(s); ready_sigma: sigma below which it is
        ready; nominal: its usual size, where start and start_sigma do not tell it; min, max: its bounds, None for those of the FMU,
        -inf and inf for none."""
        if name not in self.states:
            raise _unknown(name, "state", self.states)
        self.states[name] = self._bounded(name, Estimated(start, start_sigma, noise, ready_sigma, nominal=nominal), min, max)
        return self

    def parameter(
        self, name: str, *, start: float = math.nan, start_sigma: float, noise: float = 0.0, ready_sigma: float = math.inf,
        min: float | None = None, max: float | None = None, log: bool = False,
    ) -> Self:  # fmt: skip
        """A parameter that is estimated; of an FMU it must be tunable. noise: random walk, unit / sqrt(s). min, max: as of a state.
        log: it is positive, and estimated by its logarithm; start, sigmas and noise stay its own, noise as it is at the start."""
        if isinstance(self.plant, Plant):
            _among(name, "parameter", self.plant.parameters)
        else:
            variable = self._real(name, "a parameter")
            if variable.variability != "tunable" or variable.causality != "parameter":
                raise _impossible(
                    self.plant, name, f"{name} is {variable.variability}: it cannot be estimated; export it as tunable"
                )
        self.parameters[name] = self._bounded(name, Estimated(start, start_sigma, noise, ready_sigma, log=bool(log)), min, max)
        return self

    def unknown_input(
        self, name: str, *, start: float = math.nan, start_sigma: float, noise: float = 0.0, time_constant_s: float = 0.0,
        ready_sigma: float = math.inf, min: float | None = None, max: float | None = None,
    ) -> Self:  # fmt: skip
        """An input that is not measured, estimated as a random walk, or, with a time constant, as one that decays to 0. min, max: as of
        a state."""
        self._input(name)
        known = Estimated(start, start_sigma, noise, ready_sigma, time_constant_s)
        self.unknown_inputs[name] = self._bounded(name, known, min, max)
        self.inputs.pop(name, None)
        return self

    def input(
        self, name: str, *, start: float = math.nan, column: str = "", factor: float = 1.0, unit: str = "", interpolation: str = "hold",
    ) -> Self:  # fmt: skip
        """An input that is sampled. start: before its first sample, in the plant's unit, NaN for the plant's own. column: in a table of
        samples, its own name if none is told. factor: what a sample is multiplied with, as the power of a heater that is recorded as 0
        and 1; unit: of the product, the plant's if none is told. interpolation: "hold" from sample to sample, or "linear" for what changes
        smoothly between the samples of a recording: Observer.run knows the next one, push_input and the FMU hold. Inputs that are not named stay at their start."""
        self._input(name)
        scale, offset = self._converted(name, "an input", unit)
        if not math.isfinite(factor) or factor == 0:
            raise HnavValueError("option", f"factor of {name} is {factor:g}: it must be finite and not 0", "factor")
        if interpolation not in _INTERPOLATIONS:
            wrong = f"interpolation of {name} is {interpolation!r}: it must be {' or '.join(_INTERPOLATIONS)}"
            raise HnavValueError("option", wrong, "interpolation")
        self.unknown_inputs.pop(name, None)
        self.inputs[name] = Input(start, column or name, scale * factor, offset, interpolation)
        return self

    def sensor(
        self, name: str, *, noise: float, gate_nis: float = 0.0, unit: str = "", of: str = "", offset: float = 0.0
    ) -> Self:  # fmt: skip
        """noise: sigma of a sample, in unit; unit: of the samples, the plant's if none is told; gate_nis: NIS beyond which a sample is
        used with more noise, once the estimate is ready, 0 for never. of: the variable that it reads, where that has another name, as
        when several sensors read one; offset: added to its samples, in their unit."""
        of = of or name
        if isinstance(self.plant, Plant):
            _among(of, "sensor", self.plant.sensors)
        factor, shift = self._converted(of, "a sensor", unit)
        _check(name, "noise", noise, above_0=True)
        _check(name, "gate_nis", gate_nis)
        if not math.isfinite(offset):
            raise HnavValueError("option", f"offset of {name} is {offset:g}: it must be finite", "offset")
        self.sensors[name] = Sensor(noise, gate_nis, factor, shift + factor * offset, of, offset)
        return self

    def set(self, name: str, value: float) -> Self:
        """A start value of the FMU, or of a parameter that is not estimated."""
        if isinstance(self.plant, Plant):
            _among(name, "parameter", self.plant.parameters)
            self.plant = copy(self.plant)
            self.plant.parameters = {**self.plant.parameters, name: float(value)}
        else:
            variable = self._real(name, "a start value")
            if variable.causality not in ("parameter", "input") and math.isnan(variable.start):
                raise _impossible(self.plant, name, f"{name} has no start value that could be set: it is {variable.causality}")
        self.set_values[name] = float(value)
        return self

    def export(
        self, path: str | Path, fmi_version: int = 2, *, period_s: float = 0.01, covariance: bool | None = None
    ) -> list[str]:
        """The observer of this plan as an FMU; see Observer.export."""
        from hnav.filters.observer import Observer

        return Observer(self).export(path, fmi_version, period_s=period_s, covariance=covariance)

    def copy(self) -> Plan:
        """A plan of its own for the same plant."""
        made = copy(self)
        for name in ("states", "unknown_inputs", "parameters", "inputs", "sensors", "set_values", "options"):
            setattr(made, name, dict(getattr(self, name)))
        return made

    def _bounded(self, name: str, known: Estimated, least: float | None = None, most: float | None = None) -> Estimated:
        """Within the given bounds, or those of the FMU. Raises HnavValueError for a sigma, noise or time constant below 0."""
        for key in ("start_sigma", "noise", "ready_sigma", "time_constant_s"):
            _check(name, key, getattr(known, key), above_0=key == "ready_sigma")
        own = None if isinstance(self.plant, Plant) else self.plant.variable(name)
        low = least if least is not None else own.min if own else -math.inf
        high = most if most is not None else own.max if own else math.inf
        if not low < high:
            raise HnavValueError("option", f"min of {name} is {low:g} and its max {high:g}: min must be below max", "min")
        return replace(known, min=float(low), max=float(high))

    def _state_names(self) -> list[str]:
        return list(self.plant.states) if isinstance(self.plant, Plant) else [state.name for state, _ in self.plant.states]

    def _input(self, name: str) -> None:
        if isinstance(self.plant, Plant):
            _among(name, "input", self.plant.inputs)
            return
        variable = self._real(name, "an input")
        if variable.causality != "input":
            inputs = [v.name for v in self.plant.variables.values() if v.causality == "input"]
            raise _impossible(
                self.plant, name, f"{name} is no input but {variable.causality}; inputs: {', '.join(inputs) or 'none'}"
            )

    def _converted(self, name: str, role: str, unit: str) -> tuple[float, float]:
        """Factor and offset from samples in a unit to a variable."""
        if not isinstance(self.plant, Plant):
            return _conversion(self.plant, self._real(name, role), unit)
        if unit:
            raise _impossible(self.plant, name, f"{name}: a plant of functions has no units: convert the samples")
        return 1.0, 0.0

    def _real(self, name: str, role: str) -> Variable:
        """A variable of the FMU that can have this role."""
        assert isinstance(self.plant, ModelDescription)
        variable = self.plant.variable(name)
        if variable.is_array:
            raise _impossible(self.plant, name, f"{name} is an array: {role} must be a scalar")
        if not variable.is_real:
            raise _impossible(self.plant, name, f"{name} is {variable.type}: {role} must be real")
        return variable

    def text(self, binary: str = "") -> str:
        """The plan as the library reads it, observer.plan in the folder of the unpacked FMU. binary: path in there, if not that for this
        machine."""
        assert isinstance(self.plant, ModelDescription)
        fmu, lines = self.plant, ["hnav_observer_plan 1"]
        lines += [f"fmi {fmu.fmi}", f"identifier {fmu.identifier}", f"token {fmu.token}", f"binary {binary or fmu.binary}"]
        lines += [f"indicators {fmu.indicators}", f"derivatives {fmu.offers_derivatives:d}", f"once {fmu.once:d}"]
        lines += [f"memoryless {self.memoryless:d}", f"never_freed {self.never_freed:d}", f"discrete {bool(fmu.discrete):d}"]
        lines += [f"state_access {fmu.state_access}", f"step_done {fmu.step_done:d}"]
        lines += [f"cosimulation {_text(fmu.step_s)}"] if fmu.step_s else []
        lines += [f"set {fmu.variables[name].reference} {_text(value)} {name}" for name, value in self.set_values.items()]
        for (state, derivative), known in zip(fmu.states, self.states.values()):
            lines.append(f"state {state.reference} {derivative.reference} {_numbers(known)} {state.name}")
        for name, input in self.inputs.items():
            variable = fmu.variables[name]
            lines.append(f"input {variable.reference} {variable.variability == 'discrete':d} {_text(input.start)} {name}")
        for name, told in self.unknown_inputs.items():
            lines.append(f"unknown {fmu.variables[name].reference} {_numbers(told)} {_text(told.time_constant_s)} {name}")
        lines += [f"parameter {fmu.variables[n].reference} {_numbers(known)} {n}" for n, known in self.parameters.items()]
        for name, sensor in self.sensors.items():
            variable = fmu.variables[sensor.of]
            noise = abs(sensor.factor) * sensor.noise
            lines.append(
                f"sensor {variable.reference} {variable.causality == 'output':d} {_text(noise)} {_text(sensor.gate_nis)} {name}"
            )
        for place, told in enumerate((*self.states.values(), *self.unknown_inputs.values(), *self.parameters.values())):
            if math.isfinite(told.min) or math.isfinite(told.max):
                lines.append(f"bound {place} {_text(told.min)} {_text(told.max)}")
        lines += self._dependencies()
        lines += [f"logarithmic {place}" for place, told in enumerate(self.parameters.values()) if told.log]
        return "\n".join([*lines, "end", ""])

    def _dependencies(self) -> Iterator[str]:
        """Lines on what the derivatives depend on, of those that do not depend on everything that moves."""
        fmu = self.plant
        assert isinstance(fmu, ModelDescription)
        moving = [fmu.variables[name].reference for name in (*self.states, *self.unknown_inputs)]
        for row, known in enumerate(fmu.depends):
            if known is None or known.issuperset(moving):
                continue
            places = [str(place) for place, reference in enumerate(moving) if reference in known]
            for first in range(0, max(len(places), 1), _PLACES):
                yield " ".join(["depends", str(row), *places[first : first + _PLACES]])


_PLACES = 100  # in one line of a plan


def _text(number: float) -> str:
    """In full, whatever kind of number it is."""
    return repr(float(number))


def _numbers(known: Estimated) -> str:
    return " ".join(_text(v) for v in (known.start, known.start_sigma, known.noise, known.nominal, known.ready_sigma))


_INTERPOLATIONS = ("hold", "linear")


def _check(name: str, key: str, value: float, above_0: bool = False) -> None:
    if not (value > 0 if above_0 else value >= 0):
        bound = "above 0" if above_0 else "at least 0"
        raise HnavValueError("option", f"{key} of {name} is {value:g}: it must be {bound}", key)


def _refuse_events(fmu: ModelDescription) -> None:
    if fmu.state_access > 0 or fmu.step_s > 0:
        return
    remedy = (
        "and cannot save its state (canGetAndSetFMUstate): export it with that, or without events, or say memoryless if its answers "
        "depend on time, states, inputs and parameters alone"
    )
    if fmu.indicators:
        raise _impossible(fmu, "fmu", f"it has {fmu.indicators} state event{'s' * (fmu.indicators > 1)} {remedy}")
    if fmu.discrete:
        shown = ", ".join(fmu.discrete[:3]) + (", ..." if len(fmu.discrete) > 3 else "")
        raise _impossible(fmu, "fmu", f"it has discrete variables ({shown}) {remedy}")


def _impossible(fmu: ModelDescription | Plant, argument: str, reason: str) -> HnavValueError:
    where = f"{fmu.path.name}: " if isinstance(fmu, ModelDescription) else ""
    return HnavValueError("option", where + reason, argument)


def _unknown(name: str, kind: str, names: Iterable[str]) -> HnavValueError:
    known = list(names)
    near = difflib.get_close_matches(name, known, n=3) or known[:8]
    return HnavValueError("option", f"the plant has no {kind} {name!r}; it has {', '.join(near) or 'none'}", name)


def _among(name: str, kind: str, names: Iterable[str]) -> None:
    if name not in names:
        raise _unknown(name, kind, names)


def _conversion(fmu: ModelDescription, variable: Variable, unit: str) -> tuple[float, float]:
    """Factor and offset from a unit of samples to that of a variable."""
    if unit in ("", variable.unit):
        return 1.0, 0.0
    own, given = fmu.units.get(variable.unit), fmu.units.get(unit)
    if own is None or given is None:
        raise _impossible(
            fmu, variable.name, f"{variable.name} is in {variable.unit or 'no unit'}, and the FMU does not say what {unit} is: convert "
            f"the samples; it knows {', '.join(sorted(fmu.units)) or 'no units'}"
        )  # fmt: skip
    if own.dimensions != given.dimensions:
        raise _impossible(fmu, variable.name, f"{variable.name} is in {variable.unit}, which {unit} cannot be converted to")
    return given.factor / own.factor, (given.offset - own.offset) / own.factor


# --------------------------------------------------------------------------------------------- files


def plant_of_file(path: Path | str) -> Path | Plant:
    """The plant in a file of Python, which is run; other files are FMUs. Raises HnavValueError where there is none, or more than one."""
    path = Path(path)
    if path.suffix != ".py":
        return path
    if not path.is_file():
        raise HnavValueError("file", f"{path}: there is no such file", "fmu")
    plants = {id(value): value for value in runpy.run_path(str(path)).values() if isinstance(value, Plant)}
    if len(plants) != 1:
        raise HnavValueError("option", f"{path.name} has {len(plants) or 'no'} hnav.Plant at its top: it needs one", "fmu")
    return plants.popitem()[1]


_TABLES = ("sensor", "input", "state", "parameter", "unknown_input")
"""Calls of a plan; the entries of a table of a file are their keywords."""
_FLAGS = ("memoryless", "never_freed")


def read_plan(path: Path | str, fmu: Path | str | None = None) -> Plan:
    """A plan from TOML.

        [plant]
        fmu = "oscillator.fmu"        # beside this file; not read when fmu is given
        set = {mu = 1.5}
        [sensor.x0]
        noise = 0.05
        [state.x1]
        start_sigma = 1.0
        noise = 0.1
        [options]
        horizon_s = 0.2

    Raises HnavValueError that names the file and the entry.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
        data = tomllib.loads(text)
    except OSError as error:
        raise HnavValueError("file", f"{path}: cannot be read: {error.strerror}") from None
    except ValueError as error:
        raise HnavValueError("file", f"{path}: no TOML: {error}") from None
    try:
        return _plan_of(data, text, path.parent, fmu)
    except HnavValueError as error:
        raise HnavValueError(error.status, f"{path.name}: {error}", error.argument) from None


def _line_of(text: str, table: str, name: str, key: str) -> str:
    """ "line 12: " of an entry of a plan; the line of its table where the key does not stand in one of its own, "" where neither does."""
    header_line, inside = 0, False
    for number, line in enumerate(text.splitlines(), 1):
        if header := re.fullmatch(r"\s*\[(.*?)\]\s*(#.*)?", line):
            inside = re.sub(r"[\"'\s]", "", header[1]) == re.sub(r"[\"'\s]", "", f"{table}.{name}")
            header_line = number if inside else header_line
        elif inside and re.match(rf"\s*{re.escape(key)}\s*=", line):
            return f"line {number}: "
    return f"line {header_line}: " if header_line else ""


def _plan_of(data: dict[str, Any], text: str, folder: Path, fmu: Path | str | None) -> Plan:
    unknown = next((name for name in data if name not in {"plant", "options", *_TABLES}), None)
    if unknown is not None:
        raise HnavValueError(
            "option", f"[{unknown}] is no table of a plan; there are plant, {', '.join(_TABLES)}, options", unknown
        )
    plant = data.get("plant", {})
    wrong = next((name for name in plant if name not in {"fmu", "set", *_FLAGS}), None)
    if wrong is not None:
        raise HnavValueError("option", f"[plant] has no {wrong}; it has fmu, set, {', '.join(_FLAGS)}", wrong)
    if fmu is None and "fmu" not in plant:
        raise HnavValueError("option", "[plant] names no fmu", "fmu")
    model = fmu if fmu is not None else folder / str(plant["fmu"])
    plan = Plan(plant_of_file(model), **{name: bool(plant.get(name, False)) for name in _FLAGS})
    for name, value in plant.get("set", {}).items():
        plan.set(name, _number(value, f"plant.set.{name}"))
    for table in _TABLES:
        for name, entry in data.get(table, {}).items():
            _take(plan, table, name, entry, text)
    plan.options = dict(data.get("options", {}))
    return plan


def _take(plan: Plan, table: str, name: str, entry: object, text: str) -> None:
    """An entry into the plan."""
    try:
        getattr(plan, table)(name, **_entry(table, name, entry))
    except HnavValueError as error:
        where = _line_of(text, table, name, str(error.argument or "").rsplit(".", 1)[-1])
        raise HnavValueError(error.status, f"{where}{error}", error.argument) from None


def _entry(table: str, name: str, entry: object) -> dict[str, Any]:
    """The arguments of a plan's call."""
    keywords = {p.name: p for p in signature(getattr(Plan, table)).parameters.values() if p.kind is Parameter.KEYWORD_ONLY}
    if not isinstance(entry, dict):
        raise HnavValueError("option", f'[{table}] has no tables: write [{table}."{name}"]', name)
    wrong = next((key for key in entry if key not in keywords), None)
    if wrong is not None:
        raise HnavValueError("option", f'[{table}."{name}"] has no {wrong}; it has {", ".join(sorted(keywords))}', wrong)
    needed = next((key for key, keyword in keywords.items() if keyword.default is Parameter.empty and key not in entry), None)
    if needed is not None:
        raise HnavValueError("option", f'[{table}."{name}"] needs {needed}', name)
    return {key: _taken(value, keywords[key].annotation, f"{table}.{name}.{key}") for key, value in entry.items()}


def _taken(value: object, annotation: str, name: str) -> object:
    """A value of the type that the call has for it."""
    if annotation == "bool" and not isinstance(value, bool):
        raise HnavValueError("option", f"{name} = {value!r} is neither true nor false", name)
    if annotation == "str" and not isinstance(value, str):
        raise HnavValueError("option", f"{name} = {value!r} is no text: write it in quotes", name)
    return value if annotation in ("bool", "str") else _number(value, name)


def _number(value: object, name: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise HnavValueError("option", f"{name} = {value!r} is no number", name)
    return float(value)
