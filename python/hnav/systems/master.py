"""A co-simulation master for systems of FMUs: fixed steps, Jacobi, exact communication times.

At every communication point t_k all components get what the others put out at t_k, then all step to t_{k+1}. None
waits for another's step, so the order of the elements cannot matter and every value carries the time at which it was
put out. Gauss-Seidel order would spare nothing here: no output of ours depends directly on an input, and it would hand
a sensor, which samples at t_k, the truth of t_{k+1}. The price of Jacobi is one step of delay per connection, which
measurement time stamps say.

Times are t_0 + k h, never a sum of steps. All variables of a type cross into an FMU by one call; the values of the
whole system lie in one vector, so that a connection is an index.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hnav.errors import HnavError
from hnav.filters.attitude_recording import Progress
from hnav.fmi.fmus import Fmu, KeptFmus
from hnav.fmi.points import check_points
from hnav.io.outputs import OutputError
from hnav.systems.structure import Component, Connection, System, refuse

# All outputs except the covariances of the bias: the NEES needs the 3 x 3 block of the rotation only.
RECORDED, UNRECORDED = ("*",), re.compile(r".*\.cov\.P\[\d,[456]\]")
LOST = re.compile(r"(.+\.)?missed")  # counters of samples that fell between two communication points
STEP_SLACK = 1e-9  # share of a step: rounding error of a stop time that is a whole number of steps
PROGRESS_PARTS = 200
CROSSING = ("real", "integer", "boolean")  # types whose variables are transferred in one call


@dataclass
class Record:
    """The result of a run: a column (float64, one value per communication point) for each recorded "component.variable".

    Booleans are 0 and 1. `failure` states why the run ended early ("" if it did not); the columns end there.
    """

    t_s: np.ndarray
    columns: dict[str, np.ndarray]
    units: dict[str, str]
    wall_s: dict[str, float]  # processor time by component: inside its FMU, calls included
    lost: dict[str, int]  # by component: samples that fell between two communication points
    failure: str = ""


def communication_points(start_s: float, stop_s: float, step_s: float, values: int = 0) -> np.ndarray:
    """start + k step up to the last that does not pass stop. Raises HnavError for steps and times that make none, or more
    than this machine can keep. values: kept at each."""
    if not (np.isfinite(step_s) and step_s > 0):
        refuse(f"step_s = {step_s:g}: must be above 0 seconds", "step_s")
    if not (np.isfinite(start_s) and np.isfinite(stop_s) and stop_s - start_s >= step_s * (1 - STEP_SLACK)):
        refuse(f"stop_s = {stop_s:g}: must be at least a step of {step_s:g} s after the start at {start_s:g} s", "stop_s")
    check_points((stop_s - start_s) / step_s, values, step_s, max(abs(start_s), abs(stop_s)))
    return start_s + step_s * np.arange(int(np.floor((stop_s - start_s) / step_s + STEP_SLACK)) + 1)


def run_system(
    system: System,
    stop_s: float,
    step_s: float,
    record: Sequence[str] = RECORDED,
    inputs: Mapping[str, np.ndarray] | None = None,
    progress: Progress | None = None,
    fmus: KeptFmus | None = None,
) -> Record:
    """Runs a checked system with the parameters that it holds.

    record: patterns of * and ? over "component.variable" (outputs); of cov.P only the block of the rotation. inputs: for
    connectors of the system one value for each step, held over it; others keep the FMUs' start values. fmus: where those
    that are loaded already are, and stay. Raises HnavError for what cannot begin; a component that fails a step ends the
    run, see Record.failure.
    """
    inputs = inputs or {}
    parts = [_Part(component, system, record) for component in system.components.values()]
    place = _places(system, parts)
    points = communication_points(system.start_s, stop_s, step_s, len(place))
    driven = _input_table(system, inputs, len(points) - 1)
    table = np.full((len(points), len(place)), np.nan)
    with nullcontext(fmus) if fmus is not None else KeptFmus() as loaded:
        for part in parts:
            part.open(loaded, place, system.connections, float(points[0]), float(points[-1]), set(inputs))
        failure, done = _steps(parts, points, driven, table, progress)
    return _record(parts, place, points, table, done, failure)


def _places(system: System, parts: Sequence[_Part]) -> dict[tuple[str, str], int]:
    """Index of a value in the vector of all values: the inputs of the system, then the outputs of the components."""
    values = [("", name) for name in _input_names(system)] + [(part.name, name) for part in parts for name in part.read]
    return {value: i for i, value in enumerate(values)}


def _record(
    parts: Sequence[_Part], place: Mapping[tuple[str, str], int], points: np.ndarray, table: np.ndarray, done: int, failure: str
) -> Record:
    """The recorded columns of the first `done` rows."""
    recorded = [(part, name) for part in parts for name in part.recorded]
    return Record(
        t_s=points[:done],
        columns={f"{p.name}.{name}": np.ascontiguousarray(table[:done, place[p.name, name]]) for p, name in recorded},
        units={f"{p.name}.{name}": p.component.variables[name].unit for p, name in recorded},
        wall_s={p.name: p.wall_s for p in parts},
        lost={p.name: int(sum(table[done - 1, place[p.name, n]] for n in p.counters)) for p in parts if p.counters},
        failure=failure,
    )


def _input_names(system: System) -> list[str]:
    return [name for name, connector in system.connectors.items() if connector.kind == "input"]


def _input_table(system: System, inputs: Mapping[str, np.ndarray], steps: int) -> np.ndarray:
    """steps x inputs of the system: the value held over each step."""
    names = _input_names(system)
    table = np.zeros((steps, len(names)))
    for name, values in inputs.items():
        if name not in names:
            refuse(f"system {system.name} has no input {name}")
        if np.shape(values) != (steps,):
            refuse(f"input {name} has shape {np.shape(values)}; ({steps},) is wanted, a value for each step")
        table[:, names.index(name)] = values
    return table


def _steps(
    parts: list[_Part], points: np.ndarray, driven: np.ndarray, table: np.ndarray, progress: Progress | None
) -> tuple[str, int]:
    """Fills the table; returns why it ended early ("" if not) and the number of valid rows."""
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


class _Block(NamedTuple):
    """Variables of one type that one call transfers: the call, NumPy's view of its memory, and their places in the vector of
    all values.
    """

    cross: Callable[[], None]
    view: np.ndarray
    place: slice | np.ndarray


class _Part:
    """A running component: its FMU and one buffer for each type of variables."""

    def __init__(self, component: Component, system: System, record: Sequence[str]):
        self.component, self.name, self.wall_s = component, component.name, 0.0
        outputs = {v.name: v for v in component.variables.values() if v.causality == "output" and v.kind != "String"}
        self.recorded = [name for name in outputs if _matches(f"{self.name}.{name}", record)]
        self.counters = [name for name in outputs if LOST.fullmatch(name)]
        passed_on = {c.start[1] for c in system.connections if c.start[0] == self.name}
        # Sorted by type, so that each type is one block of the vector of all values.
        self._read: dict[str, list[str]] = {kind: [] for kind in CROSSING}
        for name, variable in outputs.items():
            if name in passed_on.union(self.recorded, self.counters):
                self._read[_crosses_as(variable.kind)].append(name)
        self.read = [name for names in self._read.values() for name in names]
        self._fmu: Fmu | None = None
        self._sets: list[_Block] = []
        self._gets: list[_Block] = []

    def open(
        self, loaded: KeptFmus, place: Mapping[tuple[str, str], int], connections: list[Connection], start_s: float,
        stop_s: float, inputs: set[str],
    ) -> None:  # fmt: skip
        """Instantiates, sets parameters, initialises, creates the buffers. Raises HnavError that names the component."""
        try:
            self._fmu = fmu = loaded.instance(self.component.fmu, self.name)
            for name, value in self.component.parameters.items():
                fmu.set(name, value)
            fmu.initialise(start_s, stop_s)
        except OutputError:
            raise
        except HnavError as error:
            refuse(f"component {self.name}: {error}")
        # An unconnected input of the system must not overwrite the FMU's start value.
        fed = {c.end[1]: place[c.start] for c in connections if c.end[0] == self.name and (c.start[0] or c.start[1] in inputs)}
        for kind, names in self._read.items():
            to = [name for name in fed if _crosses_as(self.component.variables[name].kind) == kind]
            if to:
                self._sets.append(_Block(*fmu.block("Set", kind, to), np.array([fed[name] for name in to])))
            if names:
                first = place[self.name, names[0]]
                self._gets.append(_Block(*fmu.block("Get", kind, names), slice(first, first + len(names))))

    def step(self, now: np.ndarray, then: np.ndarray, t_s: float, step_s: float) -> None:
        begin = time.perf_counter()
        for cross, view, place in self._sets:
            view[:] = now[place]
            cross()
        assert self._fmu is not None
        self._fmu.do_step(t_s, step_s)
        self.fetch(then)
        self.wall_s += time.perf_counter() - begin

    def fetch(self, row: np.ndarray) -> None:
        """Reads the outputs into their columns of the row."""
        for cross, view, place in self._gets:
            cross()
            row[place] = view


def _crosses_as(kind: str) -> str:
    return {"Real": "real", "Boolean": "boolean"}.get(kind, "integer")


def _matches(name: str, patterns: Sequence[str]) -> bool:
    """Patterns of * and ?; brackets are literal, because names contain them as an index."""
    expressions = (re.escape(p).replace(r"\*", ".*").replace(r"\?", ".") for p in patterns)
    return not UNRECORDED.fullmatch(name) and any(re.fullmatch(e, name) for e in expressions)
