"""A plant in Python: the model of what is observed, as functions. Slow beside C or an FMU, and quick to write."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from hnav.errors import HnavValueError
from hnav.native.arrays import Array
from hnav.native.library import ffi

Function = Callable[..., npt.ArrayLike]
"""Of time, states, inputs and parameters, and of the discrete state where there is one."""
Event = Callable[..., Any]
"""The same: answers the states after an event, and the discrete state where there is one."""

_FUNCTION = "int(void *, double, const double *, const double *, const double *, double *)"


class Plant:
    """x' = derivatives(t, x, u, p), y = outputs(t, x, u, p).

        def derivatives(t, x, u, p):
            return x[1], -p[0] * np.sin(x[0]) - 0.2 * x[1] + u[0]

        plant = hnav.Plant(derivatives, lambda t, x, u, p: x[0], states={"angle": 0.1, "rate": 0.0}, sensors=["angle"],
                           inputs={"torque": 0.0}, parameters={"g_over_l": 9.81})

    x, u and p are arrays in the order of states, inputs and parameters, whose values are where they start; sensors names what
    outputs answers. jacobian(t, x, u, p): derivatives by x, rows of derivatives; without it, or where it is found
    wrong, differences are taken. The functions must depend on their arguments alone.

    A plant with events: where one of indicators(t, x, u, p) leaves its domain, above 0 or not, when inputs are new, and at the time
    that next_event(t) names, event(t, x, u, p) answers the states after it:

        ball = hnav.Plant(lambda t, x, u, p: (x[1], -9.81), lambda t, x, u, p: x[0], states={"h": 1.0, "v": 0.0}, sensors=["h"],
                          indicators=lambda t, x, u, p: x[0],
                          event=lambda t, x, u, p: (0.0, -0.7 * x[1]) if x[0] <= 0 and x[1] < 0 else x)

    discrete: what only events change, by name and start. All functions take it as an array behind p (next_event behind t), and event
    answers the states and it.
    """

    def __init__(
        self,
        derivatives: Function,
        outputs: Function,
        *,
        states: Mapping[str, float],
        sensors: Sequence[str],
        inputs: Mapping[str, float] | None = None,
        parameters: Mapping[str, float] | None = None,
        jacobian: Function | None = None,
        indicators: Function | None = None,
        event: Event | None = None,
        next_event: Callable[..., float] | None = None,
        discrete: Mapping[str, float] | None = None,
    ):
        for name, given in (("states", states), ("inputs", inputs), ("parameters", parameters), ("discrete", discrete)):
            if not isinstance(given or {}, Mapping):
                raise HnavValueError("option", f'{name} = {given!r}: write names and starts, {name}={{"name": 0.0}}')
        self.derivatives, self.outputs, self.jacobian = derivatives, outputs, jacobian
        self.indicators, self.event, self.next_event = indicators, event, next_event
        self.discrete = dict(discrete or {})
        if event is None and (indicators is not None or next_event is not None or discrete):
            raise HnavValueError("option", "indicators, next_event and discrete need event, which says what happens", "event")
        self.states, self.sensors = dict(states), tuple(sensors)
        self.inputs, self.parameters = dict(inputs or {}), dict(parameters or {})
        names = [*self.states, *self.inputs, *self.parameters]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise HnavValueError(
                "option", f"{twice} is the name of two things: states, inputs and parameters need names of their own", twice
            )

    def __repr__(self) -> str:
        named = {kind: ", ".join(getattr(self, kind)) for kind in ("states", "inputs", "parameters", "discrete", "sensors")}
        return f"<Plant: {'; '.join(f'{kind} {names}' for kind, names in named.items() if names)}>"


class Asked:
    """A plant as the C library asks it: some of its inputs, parameters and outputs, in another order.

    What the functions raise is kept, and raised again by whoever called the library.
    """

    def __init__(self, plant: Plant, sensors: Sequence[str], inputs: Sequence[str], parameters: Sequence[str]):
        self.plant = plant
        self.error: BaseException | None = None
        self._rows = [plant.sensors.index(name) for name in sensors]
        self._inputs = [list(plant.inputs).index(name) for name in inputs]
        self._parameters = [list(plant.parameters).index(name) for name in parameters]
        n, free = len(plant.states), len(inputs) + len(parameters)
        self._sizes = (n, len(inputs), len(parameters))
        self._own_inputs, self._own_parameters = (np.array([*of.values()], float) for of in (plant.inputs, plant.parameters))
        self.functions = {
            "derivatives": self._function(lambda *at: self._vector(plant.derivatives, at, n, "derivatives")),
            "outputs": self._function(lambda *at: self._vector(plant.outputs, at, len(plant.sensors), "outputs")[self._rows]),
        }
        self.sizes: dict[str, int] = {}
        self._discrete = np.array([*plant.discrete.values()], float)
        if plant.event is not None:
            self._add_events(plant)
        jacobian = plant.jacobian
        if jacobian is not None and free == 0:
            self.functions["derivatives_jacobian"] = self._function(
                lambda *at: _shaped(jacobian(*self._full(*at)), (n, n), "jacobian").ravel()
            )

    def raise_kept(self) -> None:
        """What a function has raised since the last time."""
        error, self.error = self.error, None
        if error is not None:
            raise error

    def _add_events(self, plant: Plant) -> None:
        self.sizes["n_discrete"] = len(self._discrete)
        self.functions["event"] = self._function(self._event)
        if plant.indicators is not None:
            indicators = plant.indicators
            start = (0.0, np.array([*plant.states.values()], float), np.zeros(self._sizes[1]), np.zeros(self._sizes[2]))
            start[2][:] = [[*plant.inputs.values()][i] for i in self._inputs]
            start[3][:] = [[*plant.parameters.values()][i] for i in self._parameters]
            count = np.atleast_1d(np.asarray(indicators(*self._full(*start)), float)).size
            self.sizes["n_indicators"] = count
            self.functions["indicators"] = self._function(lambda *at: self._vector(indicators, at, count, "indicators"))
        if plant.next_event is not None:
            self.functions["next_event_s"] = ffi.callback("double(void *, double)", self._next_event, error=float("inf"))
        if len(self._discrete):
            self.functions["get_discrete"] = ffi.callback("void(void *, double *)", self._get_discrete)
            self.functions["set_discrete"] = ffi.callback("void(void *, const double *)", self._set_discrete)

    def _event(self, *at: Any) -> Array:
        assert self.plant.event is not None
        sides, n = self.plant.event(*self._full(*at)), self._sizes[0]
        if len(self._discrete):
            sides, discrete = sides
            self._discrete = _shaped(
                np.atleast_1d(np.asarray(discrete, float)), self._discrete.shape, "discrete state after event"
            )
        return _shaped(np.atleast_1d(np.asarray(sides, float)), (n,), "event")

    def _next_event(self, _: Any, t: float) -> float:
        assert self.plant.next_event is not None
        try:
            return float(self.plant.next_event(t, *self._also_discrete()))
        except BaseException as error:
            self.error = error
            return float("inf")

    def _get_discrete(self, _: Any, values: Any) -> None:
        values[0 : len(self._discrete)] = self._discrete.tolist()

    def _set_discrete(self, _: Any, values: Any) -> None:
        self._discrete = np.array(ffi.unpack(values, len(self._discrete)))

    def _also_discrete(self) -> tuple[Array, ...]:
        return (self._discrete.copy(),) if len(self._discrete) else ()

    def _full(self, t: float, x: Array, u: Array, p: Array) -> tuple[Any, ...]:
        # Copies, and no more work than needed: this is done some fifty times for a sample.
        inputs, parameters = self._own_inputs.copy(), self._own_parameters.copy()
        if self._inputs:
            inputs[self._inputs] = u
        if self._parameters:
            parameters[self._parameters] = p
        return (t, x, inputs, parameters, *self._also_discrete())

    def _vector(self, function: Function, at: Any, length: int, name: str) -> Array:
        values = np.array(function(*self._full(*at)), float, ndmin=1)
        return values if values.shape == (length,) else _shaped(values, (length,), name)

    def _function(self, answer: Callable[..., Array]) -> Any:
        sizes = self._sizes

        def called(_: Any, t: float, x: Any, u: Any, p: Any, values: Any) -> int:
            try:
                at = [np.array(ffi.unpack(pointer, size)) if size else np.zeros(0) for pointer, size in zip((x, u, p), sizes)]
                found = answer(t, *at)
                values[0 : len(found)] = found.tolist()
            except BaseException as error:
                self.error = error
                return -1
            return 0

        return ffi.callback(_FUNCTION, called, error=-1)


def _shaped(values: npt.ArrayLike, shape: tuple[int, ...], name: str) -> Array:
    array = np.asarray(values, float)
    if array.shape != shape:
        raise HnavValueError("size", f"{name} of the plant has the shape {array.shape}, expected {shape}", name)
    return array
