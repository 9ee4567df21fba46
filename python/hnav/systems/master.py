"""A co-simulation master for systems of FMUs: fixed steps, Jacobi, exact communication times.

At every communication point t_k all components get what the others put out at t_k, then all step to t_{k+1}. None
waits for another's step, so the order of the elements cannot matter and every value carries the time at which it was
put out. Gauss-Seidel order would spare nothing here: no output of ours depends directly on an input, and it would hand
a sensor, which samples at t_k, the truth of t_{k+1}. The price of Jacobi is one step of delay per connection, which
measurement time stamps tell.

Times are t_0 + k h, never a sum of steps. All variables of a type cross into an FMU by one call; the values of the
whole system lie in one vector, so that a connection is an index.
"""

from __future__ import annotations

import ctypes as C
import re
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hnav.errors import HnavError, HnavValueError
from hnav.fmi.engines import Progress
from hnav.fmi.fmus import Fmu
from hnav.systems.structure import Component, System

# Everything that is put out but the covariances of the bias: the 3 x 3 of the rotation is enough for a NEES.
RECORDED, UNRECORDED = ("*",), re.compile(r".*\.cov\.P\[\d,[456]\]")
LOST = re.compile(r"(.+\.)?missed")  # counters of samples that fell between two communication points
STEP_SLACK = 1e-9  # of a step: a stop time that is a whole number of steps but for rounding
PROGRESS_PARTS = 200


@dataclass
class Record:
    """What a run left: a column (float64, one value per communication point) for each recorded "component.variable".

    Booleans are 0 and 1. `failure` says why the run ended early ("" if it did not); the columns end there.
    """

    t_s: np.ndarray
    columns: dict[str, np.ndarray]
    units: dict[str, str]
    wall_s: dict[str, float]  # by component: inside its FMU, calls included
    lost: dict[str, int]  # by component: samples that fell between two communication points
    failure: str = ""


def communication_points(start_s: float, stop_s: float, step_s: float) -> np.ndarray:
    """start + k step up to the last that does not pass stop. Raises HnavError for steps and times that make none."""
    if not (np.isfinite(step_s) and step_s > 0):
        raise HnavValueError("option", f"step {step_s:g} must be above 0 seconds")
    if not (np.isfinite(start_s) and np.isfinite(stop_s) and stop_s - start_s >= step_s * (1 - STEP_SLACK)):
        raise HnavValueError("option", f"stop {stop_s:g} s must be at least a step of {step_s:g} s after start {start_s:g} s")
    return start_s + step_s * np.arange(int(np.floor((stop_s - start_s) / step_s + STEP_SLACK)) + 1)


def run_system(
    system: System,
    stop_s: float,
    step_s: float,
    record: Sequence[str] = RECORDED,
    inputs: Mapping[str, np.ndarray] | None = None,
    progress: Progress | None = None,
) -> Record:
    """Runs a checked system with the parameters that it holds.

    record: patterns of * and ? over "component.variable" (outputs); of cov.P only the block of the rotation. inputs: for
    connectors of the system one value for each step, held over it; others keep the FMUs' start values. Raises
    HnavError for what cannot begin; a component that fails a step ends the run, see Record.failure.
    """
    points = communication_points(system.start_s, stop_s, step_s)
    parts = [_Part(component, system, record) for component in system.components.values()]
    place = {("", name): i for i, name in enumerate(n for n, c in system.connectors.items() if c.kind == "input")}
    outside = len(place)
    for part in parts:
        place |= {(part.name, name): len(place) + i for i, name in enumerate(part.read)}
    driven = _input_table(system, inputs or {}, list(place)[:outside], len(points) - 1)
    table = np.full((len(points), len(place)), np.nan)
    try:
        for part in parts:
            part.open(place, system.connections, float(points[0]), float(points[-1]), set(inputs or {}))
        failure, done = _steps(parts, points, driven, table, progress)
    finally:
        for part in parts:
            part.close()
    names = {(part.name, name): part.component.variables[name] for part in parts for name in part.recorded}
    return Record(
        t_s=points[:done],
        columns={".".join(key): np.ascontiguousarray(table[:done, place[key]]) for key in names},
        units={".".join(key): variable.unit for key, variable in names.items()},
        wall_s={part.name: part.wall_s for part in parts},
        lost={p.name: int(sum(table[done - 1, place[p.name, n]] for n in p.counters)) for p in parts if p.counters},
        failure=failure,
    )


def _input_table(system: System, inputs: Mapping[str, np.ndarray], connectors: list[tuple[str, str]], steps: int) -> np.ndarray:
    table = np.zeros((steps, len(connectors)))
    names = [name for _, name in connectors]
    for name, values in inputs.items():
        if name not in names:
            raise HnavValueError("option", f"system {system.name} has no input {name}")
        if np.shape(values) != (steps,):
            raise HnavValueError(
                "option", f"input {name} has shape {np.shape(values)}; ({steps},) is wanted, a value for each step"
            )
        table[:, names.index(name)] = values
    return table


def _steps(
    parts: list[_Part], points: np.ndarray, driven: np.ndarray, table: np.ndarray, progress: Progress | None
) -> tuple[str, int]:
    """Fills the table; returns why it ended early ("" if not) and how many rows are good."""
    outside, times, steps = driven.shape[1], points.tolist(), len(points) - 1
    often = max(1, steps // PROGRESS_PARTS)
    for part in parts:
        part.fetch(table[0])
    for k in range(steps):
        now, then, t_s = table[k], table[k + 1], times[k]
        now[:outside] = driven[k]
        try:
            for part in parts:
                part.step(now, then, t_s, times[k + 1] - t_s)
        except HnavError as error:
            return f"{part.name} failed the step from {t_s:.9g} s: {error}", k + 1
        if progress and (k % often == 0 or k == steps - 1):
            progress(k + 1, steps)
    return "", len(points)


class _Part:
    """A component at work: its FMU and buffers through which its variables cross in blocks of one type."""

    def __init__(self, component: Component, system: System, record: Sequence[str]):
        self.component, self.name, self.wall_s = component, component.name, 0.0
        outputs = [v for v in component.variables.values() if v.causality == "output" and v.kind != "String"]
        self.recorded = [v.name for v in outputs if _matches(f"{self.name}.{v.name}", record)]
        self.counters = [v.name for v in outputs if LOST.fullmatch(v.name)]
        wanted = {*self.recorded, *self.counters, *(c.start[1] for c in system.connections if c.start[0] == self.name)}
        # By type, so that each type is one block of the vector of all values.
        blocks = [[v.name for v in outputs if v.name in wanted and _block(v.kind) == block] for block in range(3)]
        self.read = [name for block in blocks for name in block]
        self._read_blocks = blocks
        self.fmu: Fmu | None = None

    def open(self, place: Mapping, connections: list, start_s: float, stop_s: float, inputs: set[str]) -> None:
        """Instantiates, sets parameters, initialises, makes the buffers. Raises HnavError that names the component."""
        try:
            self.fmu = Fmu(self.component.fmu, name=self.name)
            for name, value in self.component.parameters.items():
                self.fmu.set(name, value)
            self.fmu.initialise(start_s, stop_s)
        except HnavError as error:
            raise HnavValueError("option", f"component {self.name}: {error}") from None
        # An input of the system that nobody drives must not overwrite the FMU's start value.
        fed = {c.end[1]: place[c.start] for c in connections if c.end[0] == self.name and (c.start[0] or c.start[1] in inputs)}
        fmu, variables = self.fmu, self.component.variables
        setters, getters = (
            (fmu.set_reals, fmu.set_integers, fmu.set_booleans),
            (fmu.get_reals, fmu.get_integers, fmu.get_booleans),
        )
        first = place[self.name, self.read[0]] if self.read else 0
        self._sets, self._gets = [], []
        for block, names in enumerate(self._read_blocks):
            fed_here = [name for name in fed if _block(variables[name].kind) == block]
            if fed_here:
                index = np.array([fed[name] for name in fed_here])
                self._sets.append((setters[block], *self._buffer(block, fed_here), index))
            if names:
                self._gets.append((getters[block], *self._buffer(block, names), slice(first, first + len(names))))
                first += len(names)

    def _buffer(self, block: int, names: list[str]) -> tuple[C.Array, C.Array, np.ndarray]:
        """References, the ctypes array that the FMU sees, and NumPy's view of the same memory."""
        kind = (C.c_double, C.c_int32, C.c_bool if self.fmu.fmi3 else C.c_int32)[block]
        values = (kind * len(names))()
        return self.fmu.references(names), values, np.ctypeslib.as_array(values)

    def step(self, now: np.ndarray, then: np.ndarray, t_s: float, step_s: float) -> None:
        begin = time.perf_counter()
        for set_values, references, values, view, index in self._sets:
            view[:] = now[index]
            set_values(references, values)
        self.fmu.do_step(t_s, step_s)
        self.fetch(then)
        self.wall_s += time.perf_counter() - begin

    def fetch(self, row: np.ndarray) -> None:
        """The outputs into their places of the row."""
        for get_values, references, values, view, rows in self._gets:
            get_values(references, values)
            row[rows] = view

    def close(self) -> None:
        if self.fmu is not None:
            self.fmu.__exit__()


def _block(kind: str) -> int:
    return {"Real": 0, "Boolean": 2}.get(kind, 1)


def _matches(name: str, patterns: Sequence[str]) -> bool:
    """Patterns of * and ?; brackets stand for themselves, for in these names they are an index."""
    expressions = (re.escape(p).replace(r"\*", ".*").replace(r"\?", ".") for p in patterns)
    return not UNRECORDED.fullmatch(name) and any(re.fullmatch(e, name) for e in expressions)
