"""Where the FMUs are, and one instance of an FMU: the calls that FMI 2 and FMI 3 share, by fmpy's classes."""

from __future__ import annotations

import ctypes as C
import errno
import shutil
import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, Self

import fmpy
import numpy as np
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Model, FMU2Slave, defaultCallbacks, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.fmi3 import FMU3Model, FMU3Slave
from fmpy.model_description import ModelDescription, ScalarVariable
from fmpy.sundials import CVodeSolver

from hnav.errors import HnavError, HnavValueError, nearest
from hnav.io.fmu_files import fmu_path as fmu_path
from hnav.io.outputs import cannot_write, temporary_folder
from hnav.native.options import OptionInfo

# These errors are faults of the disk, not of the FMU.
NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EACCES)
MODEL_EXCHANGE_RTOL = 1e-8
# fmpy moves the working directory, which all threads share, while it loads a library.
_LOADING = threading.Lock()
# Names of our types in the functions of FMI 2 and FMI 3.
_TYPES = {
    "real": ("Real", "Float64"),
    "integer": ("Integer", "Int32"),
    "boolean": ("Boolean", "Boolean"),
    "enumeration": ("Integer", "Int64"),
}
_ELEMENTS: dict[str, tuple[Any, Any]] = {
    "real": (C.c_double, C.c_double), "integer": (C.c_int32, C.c_int32),
    "boolean": (C.c_int32, C.c_bool), "enumeration": (C.c_int32, C.c_int64),
}  # fmt: skip
_SINGLE = ("Real", "Float64", "Boolean", "String", "Int32")
# Calls that set or get many variables, in FMI 2 and in FMI 3: references, how many, values, and how many once more.
_CROSSINGS = (
    C.CFUNCTYPE(C.c_int, C.c_void_p, C.c_void_p, C.c_size_t, C.c_void_p),
    C.CFUNCTYPE(C.c_int, C.c_void_p, C.c_void_p, C.c_size_t, C.c_void_p, C.c_size_t),
)
_WARNING = 1  # the status above which a call has failed
# Most files of an archive, which no running instance reads.
_FOR_READERS = ("sources/", "documentation/", "terminalsAndIcons/")


def description_of(path: Path | str) -> ModelDescription:
    """fmpy's description of an FMU. Do not change it: a file that has not changed is read once. Raises whatever fmpy does."""
    found = Path(path).stat()
    return _description(str(Path(path).resolve()), found.st_mtime_ns, found.st_size)


@lru_cache(64)
def _description(path: str, _changed_ns: int, _size: int) -> ModelDescription:
    return fmpy.read_model_description(path, validate=False)


class Fmu:
    """One instance of an FMU, FMI 2 or 3, Co-Simulation or Model Exchange, with the calls both versions share.

    Use as a context manager: the instance and the unpacked archive go when it ends. Errors are HnavError with the
    FMU's own message.
    """

    def __init__(self, path: Path | str, model_exchange: bool = False, name: str = "instance", events: bool = False):
        """events: Co-Simulation of FMI 3 with event mode, in which it is after initialisation."""
        self._events = events
        self._folder = temporary_folder("hnav_fmu_")
        try:
            self._load(path, model_exchange, name)
            self._instantiate()
        except BaseException as error:
            self._forget()
            if isinstance(error, OSError) and error.errno in NO_ROOM:
                raise cannot_write(f"{self._folder} (unpacking {path})", error) from None
            if isinstance(error, HnavError) or not isinstance(error, Exception):
                raise
            # fmpy raises bare Exception.
            reason = (str(error) or type(error).__name__).splitlines()[0]
            raise HnavValueError("option", f"{path}: cannot be loaded: {reason}") from None

    def _load(self, path: Path | str, model_exchange: bool, name: str) -> None:
        """Description and library. Raises whatever fmpy does."""
        self.description = description_of(path)
        self.fmi3 = self.description.fmiVersion.startswith("3")
        self.model_exchange = model_exchange
        self.variables: dict[str, ScalarVariable] = {v.name: v for v in self.description.modelVariables}
        self.messages: list[str] = []
        fmpy.extract(str(path), self._folder, include=lambda name: not name.removeprefix("./").startswith(_FOR_READERS))
        kinds = {(False, False): FMU2Slave, (False, True): FMU2Model, (True, False): FMU3Slave, (True, True): FMU3Model}
        interface = self.description.modelExchange if model_exchange else self.description.coSimulation
        arguments = {
            "guid": self.description.guid, "unzipDirectory": self._folder, "modelIdentifier": interface.modelIdentifier,
            "instanceName": name,
        }  # fmt: skip
        with _LOADING:
            self.fmu: Any = kinds[self.fmi3, model_exchange](**arguments)

    def _instantiate(self) -> None:
        try:
            if self.fmi3:
                events = {} if self.model_exchange else {"eventModeUsed": self._events, "earlyReturnAllowed": self._events}
                self.fmu.instantiate(logMessage=lambda *said: self.messages.append(said[-1].decode()), **events)
            else:
                self._callbacks = fmi2CallbackFunctions()
                self._callbacks.logger = fmi2CallbackLoggerTYPE(lambda *said: self.messages.append(said[-1].decode()))
                self._callbacks.allocateMemory = defaultCallbacks.allocateMemory
                self._callbacks.freeMemory = defaultCallbacks.freeMemory
                self.fmu.instantiate(callbacks=self._callbacks)
        except Exception:  # fmpy raises bare Exception
            raise HnavValueError("option", self.messages[-1] if self.messages else "the FMU cannot be instantiated") from None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.fmu.freeInstance()
        self._forget()

    def renew(self) -> None:
        """Replaces the instance by a new one of the loaded library and binds the variables to it. Raises
        HnavError when there is none, and then this is no longer of use."""
        self._call_of("FreeInstance")(self.fmu.component)
        self.messages.clear()
        try:
            self._instantiate()
        except HnavError:
            self.fmu.freeLibrary()
            self._forget()
            raise

    def _call_of(self, name: str) -> Callable[..., Any]:
        """fmpy's method for a function of FMI, by its name without fmi2 or fmi3."""
        method: Callable[..., Any] = getattr(self.fmu, f"fmi{3 if self.fmi3 else 2}{name}")
        return method

    def _forget(self) -> None:
        shutil.rmtree(self._folder, ignore_errors=True)

    def call(self, method: Callable[..., Any], *arguments: Any) -> Any:
        """A method of fmpy's FMU class; a refusal becomes an HnavError with the FMU's message."""
        try:
            return method(*arguments)
        except FMICallException as error:
            raise self._refusal(str(error)) from None

    def _refusal(self, otherwise: str) -> HnavValueError:
        return HnavValueError("option", self.messages[-1] if self.messages else otherwise)

    # ------------------------------------------------------------------------------------------- variables

    def _variable(self, name: str) -> ScalarVariable:
        if name not in self.variables:
            raise HnavValueError("option", f"the FMU has no variable {name}{nearest(name, self.variables)}")
        return self.variables[name]

    def _single(self, verb: str, variable: ScalarVariable) -> Callable[..., Any]:
        """The method that sets or gets one variable, by the type that it has; enumerations are integers."""
        kind = variable.type if variable.type in _SINGLE else "Int64" if self.fmi3 else "Integer"
        method: Callable[..., Any] = getattr(self.fmu, verb + kind)
        return method

    def set(self, name: str, value: float | bool | str) -> None:
        """One variable, by the type it has; an enumeration also by the name of its item."""
        variable = self._variable(name)
        if variable.type == "Enumeration" and isinstance(value, str):
            value = item_value(variable, value)
        self.call(self._single("set", variable), [variable.valueReference], [value])

    def get(self, name: str) -> Any:
        """One variable; numbers as Python numbers."""
        variable = self._variable(name)
        return self.call(self._single("get", variable), [variable.valueReference])[0]

    # Many variables of one type at once: references and values are ctypes arrays that the caller keeps.

    def references(self, names: Iterable[str]) -> C.Array[C.c_uint32]:
        numbers = [self._variable(name).valueReference for name in names]
        return (C.c_uint32 * len(numbers))(*numbers)

    def block(self, verb: str, kind: str, names: Sequence[str]) -> tuple[Callable[[], None], np.ndarray]:
        """As crossing, and NumPy's view of the values. kind boolean: c_bool in FMI 3, c_int32 in FMI 2."""
        values = (_ELEMENTS[kind][self.fmi3] * len(names))()
        return self.crossing(verb, kind, self.references(names), values), np.ctypeslib.as_array(values)

    def crossing(self, verb: str, kind: str, references: C.Array[C.c_uint32], values: C.Array[Any]) -> Callable[[], None]:
        """What sets or gets (verb: Set, Get) these variables of this instance, for loops: all is bound, and a call costs a
        quarter of one through fmpy. kind: real, integer, boolean or enumeration."""
        name = f"fmi{3 if self.fmi3 else 2}{verb}{_TYPES[kind][self.fmi3]}"
        function, n = _CROSSINGS[self.fmi3]((name, self.fmu.dll)), C.c_size_t(len(references))
        fixed = (C.c_void_p(self.fmu.component), C.cast(references, C.c_void_p), n, C.cast(values, C.c_void_p))
        arguments = (*fixed, n) if self.fmi3 else fixed

        def cross() -> None:
            if function(*arguments) > _WARNING:
                raise self._refusal(f"{name} failed")

        return cross

    # ------------------------------------------------------------------------------------------- time

    def initialise(self, start_s: float = 0.0, stop_s: float | None = None) -> None:
        """Parameters set before this take effect here."""
        self.enter_initialization(start_s, stop_s)
        self.call(self.fmu.exitInitializationMode)

    def enter_initialization(self, start_s: float = 0.0, stop_s: float | None = None) -> None:
        f = self.fmu
        if self.fmi3:
            self.call(lambda: f.enterInitializationMode(startTime=start_s, stopTime=stop_s))
        else:
            self.call(lambda: f.setupExperiment(startTime=start_s, stopTime=stop_s))
            self.call(f.enterInitializationMode)

    def update_discrete_states(self) -> float | None:
        """In event mode: the next event time, None if there is none."""
        *_, defined, next_s = self.call(self.fmu.updateDiscreteStates if self.fmi3 else self.fmu.newDiscreteStates)
        return next_s if defined else None

    def iterate(self) -> bool:
        """In event mode of FMI 3: one iteration, at whose end clocks are inactive; whether another one is needed."""
        return bool(self.call(self.fmu.updateDiscreteStates)[0])

    def tick(self, names: Iterable[str]) -> None:
        """Input clocks are active from here to the end of the iteration."""
        clocks = [self._variable(name).valueReference for name in names]
        self.call(self.fmu.setClock, clocks, [True] * len(clocks))

    def ticks(self, name: str) -> bool:
        """Whether a clock is active."""
        return bool(self.call(self.fmu.getClock, [self._variable(name).valueReference])[0])

    def do_step(self, t_s: float, step_s: float) -> None:
        self.call(self.fmu.doStep, t_s, step_s)

    def solver(self, start_s: float, rtol: float = MODEL_EXCHANGE_RTOL) -> CVodeSolver:
        """fmpy's CVODE over this Model Exchange instance."""
        f = self.fmu
        nx = sum(v.derivative is not None for v in self.description.modelVariables)
        return CVodeSolver(
            nx=nx, nz=self.description.numberOfEventIndicators, get_x=f.getContinuousStates, set_x=f.setContinuousStates,
            get_dx=f.getContinuousStateDerivatives if self.fmi3 else f.getDerivatives, get_z=f.getEventIndicators,
            get_nominals=f.getNominalsOfContinuousStates, set_time=f.setTime, input=_HeldInputs(), startTime=start_s,
            relativeTolerance=rtol, maxNumSteps=100000,
        )  # fmt: skip


class _HeldInputs:
    """fmpy's solver asks for inputs at each look for a root; these change at events alone."""

    def apply(self, _t_s: float) -> None:
        pass


class KeptFmus:
    """FMUs of Co-Simulation that stay loaded from run to run. Use as a context manager: they go when it ends."""

    def __init__(self) -> None:
        self._loaded: dict[tuple[Path, str], Fmu] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        while self._loaded:
            self._loaded.popitem()[1].__exit__()

    def instance(self, path: Path, name: str) -> Fmu:
        """A new instance of this name; the last one of that name is gone. Raises HnavError."""
        key = path, name
        fmu = self._loaded.pop(key, None)
        if fmu is not None and fmu.description.coSimulation.canBeInstantiatedOnlyOncePerProcess:
            fmu.__exit__()
            fmu = None
        if fmu is None:
            fmu = Fmu(path, name=name)
        else:
            fmu.renew()
        self._loaded[key] = fmu
        return fmu


def parameter_values(table: Mapping[str, OptionInfo], values: Mapping[str, Any]) -> dict[str, float | int | str]:
    """Options of an attitude filter as parameters of its FMU: GROUP.NAME, arrays as GROUP.NAME[1] and so on."""
    found: dict[str, float | int | str] = {}
    for name, value in values.items():
        parameter = f"{table[name].group}.{name}"
        if isinstance(value, (str, int, float)):
            found[parameter] = value
        else:
            found |= {f"{parameter}[{i}]": float(v) for i, v in enumerate(value, start=1)}
    return found


def items_of(variable: ScalarVariable) -> dict[str, int]:
    """The choices of an enumeration, name to value; empty for variables of other types."""
    declared = variable.declaredType
    return {item.name: int(item.value) for item in getattr(declared, "items", None) or []}


def item_value(variable: ScalarVariable, name: str) -> int:
    """The value of a choice by its name. Raises HnavError."""
    items = items_of(variable)
    if name not in items:
        raise HnavValueError("option", f"{variable.name} = {name}: choose one of {', '.join(items)}", variable.name)
    return items[name]
