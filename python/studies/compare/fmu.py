"""FMUs of either side through fmpy: variables by name, old or new, many of them in one call."""

from __future__ import annotations

import ctypes as C
import shutil
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.fmi3 import FMU3Model, FMU3Slave
from fmpy.sundials import CVodeSolver
from numpy.typing import NDArray

from studies.compare.names import Names

RTOL = 1e-8  # of the integrator that a Model Exchange FMU is given
KINDS_2: dict[str, tuple[str, Any]] = {"Real": ("Real", C.c_double), "Boolean": ("Boolean", C.c_int32)}
KINDS_3: dict[str, Any] = {
    "Float64": C.c_double,
    "Boolean": C.c_bool,
    "Int32": C.c_int32,
    "UInt32": C.c_uint32,
    "UInt64": C.c_uint64,
}


class Port:
    """Variables of one type, set or read by one call; view: their values."""

    def __init__(self, fmu: Fmu, kind: str, names: list[str]):
        if fmu.fmi3:
            call, number = (kind, KINDS_3[kind]) if kind in KINDS_3 else ("Int64", C.c_int64)
        else:
            call, number = KINDS_2.get(kind, ("Integer", C.c_int32))
        self._values = (number * len(names))()
        self._references = (C.c_uint32 * len(names))(*(fmu.variable(name).valueReference for name in names))
        self._fmu, self._call, self.view = fmu, call, np.ctypeslib.as_array(self._values)

    def _pass(self, direction: str) -> None:
        fmu, n = self._fmu.fmu, len(self._values)
        prefix, more = ("fmi3", [n]) if self._fmu.fmi3 else ("fmi2", [])
        getattr(fmu, prefix + direction + self._call)(fmu.component, self._references, n, self._values, *more)

    def set(self) -> None:
        self._pass("Set")

    def get(self) -> NDArray[Any]:
        self._pass("Get")
        return self.view


class Values:
    """Variables of any types in the order of their names, as one row of numbers."""

    def __init__(self, fmu: Fmu, names: Iterable[str]):
        self.names = list(names)
        kinds = [fmu.variable(name).type for name in self.names]
        self._ports = []
        for kind in dict.fromkeys(kinds):
            places = [i for i, k in enumerate(kinds) if k == kind]
            self._ports.append((np.array(places), Port(fmu, kind, [self.names[i] for i in places])))

    def set(self, row: NDArray[Any]) -> None:
        for places, port in self._ports:
            port.view[:] = row[places]
            port.set()

    def get(self) -> NDArray[Any]:
        row = np.empty(len(self.names))
        for places, port in self._ports:
            row[places] = port.get()
        return row


class Fmu:
    """One instance; a context manager that frees it and its unpacked archive."""

    def __init__(self, path: Path, names: Names, exchange: bool = False):
        self.description = fmpy.read_model_description(str(path), validate=False)
        self.fmi3, self.exchange = self.description.fmiVersion.startswith("3"), exchange
        self._names = names
        self._variables = {v.name: v for v in self.description.modelVariables}
        self._folder = fmpy.extract(str(path))
        kinds = {(False, False): FMU2Slave, (False, True): FMU2Model, (True, False): FMU3Slave, (True, True): FMU3Model}
        interface = self.description.modelExchange if exchange else self.description.coSimulation
        self.fmu = kinds[self.fmi3, exchange](
            guid=self.description.guid, unzipDirectory=self._folder, modelIdentifier=interface.modelIdentifier,
            instanceName="compare",
        )  # fmt: skip
        self.fmu.instantiate()

    def __enter__(self) -> Fmu:
        return self

    def __exit__(self, *_: object) -> None:
        self.fmu.freeInstance()
        shutil.rmtree(self._folder, ignore_errors=True)

    def variable(self, name: str) -> Any:
        """By its old or new name; what follows a bracket is an index. Raises KeyError."""
        base, bracket, index = name.partition("[")
        for kind in ("variable", "option"):
            for candidate in self._names.candidates(kind, base):
                if found := self._variables.get(candidate + bracket + index):
                    return found
                # Parameters of options stand in groups: robust.gamma.
                if found := next((v for n, v in self._variables.items() if n.endswith(f".{candidate}{bracket}{index}")), None):
                    return found
        raise KeyError(f"{self.description.modelName} has no variable {name}")

    def canonical(self, name: str) -> str:
        base, bracket, index = name.partition("[")
        return self._names.canonical("option", self._names.canonical("variable", base)) + bracket + index

    def of_causality(self, *causalities: str) -> list[str]:
        return [v.name for v in self.description.modelVariables if v.causality in causalities and v.type != "String"]

    def set(self, values: dict[str, object]) -> None:
        """Numbers, choices of enumerations by name, lists as name[1], name[2], ..."""
        for name, value in values.items():
            if isinstance(value, list):
                self.set({f"{name}[{i}]": v for i, v in enumerate(value, start=1)})
                continue
            variable = self.variable(name)
            if isinstance(value, str):
                value = self._choice(variable, value)
            port = Port(self, variable.type, [variable.name])
            port.view[:] = value
            port.set()

    def _choice(self, variable: Any, text: str) -> int:
        items = {item.name: int(item.value) for item in variable.declaredType.items}
        return items[self._names.find("choice", text, items)]

    def initialise(self, start_s: float = 0.0) -> None:
        if self.fmi3:
            self.fmu.enterInitializationMode(startTime=start_s)
        else:
            self.fmu.setupExperiment(startTime=start_s)
            self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def update_discrete_states(self) -> float:
        """In event mode, until nothing changes; returns the time of the next event, infinity if there is none."""
        update = self.fmu.updateDiscreteStates if self.fmi3 else self.fmu.newDiscreteStates
        for _ in range(10):
            again, _, _, _, defined, next_s = update()
            if not again:
                return next_s if defined else np.inf
        raise RuntimeError(f"{self.description.modelName} does not leave its event")

    def states(self) -> int:
        return sum(v.derivative is not None for v in self.description.modelVariables)

    def solver(self, start_s: float) -> CVodeSolver:
        f = self.fmu
        return CVodeSolver(
            nx=self.states(), nz=0, get_x=f.getContinuousStates, set_x=f.setContinuousStates,
            get_dx=f.getContinuousStateDerivatives if self.fmi3 else f.getDerivatives, get_z=f.getEventIndicators,
            get_nominals=f.getNominalsOfContinuousStates, set_time=f.setTime, input=None, startTime=start_s,
            relativeTolerance=RTOL, maxNumSteps=100000,
        )  # fmt: skip

    def directional_derivatives(self) -> NDArray[Any]:
        """Of all derivatives of states along all states, with a seed in every direction."""
        derivatives = [v for v in self.description.modelVariables if v.derivative is not None]
        unknowns, knowns = ([v.valueReference for v in vs] for vs in (derivatives, [v.derivative for v in derivatives]))
        seed = (1.0 + 0.1 * np.arange(len(knowns))).tolist()
        return np.array(self.fmu.getDirectionalDerivative(unknowns, knowns, seed))
