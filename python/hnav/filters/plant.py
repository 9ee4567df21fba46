"""A plant in Python: the model of what is observed, as functions. Slow beside C or an FMU, and quick to write."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np
import numpy.typing as npt
from numpy.lib.mixins import NDArrayOperatorsMixin

from hnav.errors import HnavError, HnavValueError
from hnav.native.arrays import Array
from hnav.native.library import ffi

Function = Callable[..., npt.ArrayLike]
"""Of time, states, inputs and parameters, and of the discrete state where there is one."""
Event = Callable[..., Any]
"""The same: answers the states after an event, and the discrete state where there is one."""

_FUNCTION = "int(void *, double, const double *, const double *, const double *, double *)"
_AT_POINTS = "int(void *, int32_t, double, const double *, const double *, const double *, double *)"


def _check_names(sensors: Sequence[str], **starts: object) -> None:
    for name, given in starts.items():
        if not isinstance(given or {}, Mapping):
            raise HnavValueError("option", f'{name} = {given!r}: write names and starts, {name}={{"name": 0.0}}')
    if isinstance(sensors, str) or len(set(sensors)) < len(sensors):
        raise HnavValueError("option", f"sensors = {sensors!r}: write a list of names, each of them once", "sensors")


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
        _check_names(sensors, states=states, inputs=inputs, parameters=parameters, discrete=discrete)
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


class Row(NDArrayOperatorsMixin, list[float]):
    """An array as far as functions of plants see it, whose elements are Python's numbers: to take those out of an array and to compute with
    them takes ten times as long."""

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **more: Any) -> Any:
        return getattr(ufunc, method)(*(np.array(one) if isinstance(one, Row) else one for one in inputs), **more)

    def __getitem__(self, key: Any) -> Any:
        return list.__getitem__(self, key) if type(key) is int else np.array(self)[key]

    def __bool__(self) -> bool:
        return bool(np.array(self))

    def copy(self) -> Any:
        """The elements as an array of NumPy."""
        return np.array(self)


class Asked:
    """A plant as the C library asks it: some of its inputs, parameters and outputs, in another order.

    What the functions raise is kept, and raised again by whoever called the library.
    """

    def __init__(self, plant: Plant, sensors: Sequence[str], inputs: Sequence[str], parameters: Sequence[str]):
        self.plant = plant
        self.error: BaseException | None = None
        n, free = len(plant.states), len(inputs) + len(parameters)
        # Of x, u and p: how many the library has, the plant's own, and where those of the library stand among them; empty: in order.
        self._kinds: list[tuple[int, list[float], list[int]]] = [(n, _floats(plant.states), [])]
        for names, known in ((inputs, plant.inputs), (parameters, plant.parameters)):
            places = [[*known].index(name) for name in names]
            self._kinds.append((len(names), _floats(known), [] if places == [*range(len(known))] else places))
        self._discrete = np.array([*plant.discrete.values()], float)
        self.functions: dict[str, Any] = {}
        self.sizes: dict[str, int] = {}
        sensors_used = [plant.sensors.index(name) for name in sensors]
        for name, function, length, rows in (
            ("derivatives", plant.derivatives, n, [*range(n)]),
            ("outputs", plant.outputs, len(plant.sensors), sensors_used),
        ):
            called = self._called(function, length, name, rows)
            self.functions[name] = _of_one_point(called)
            self.functions[f"{name}_at_points"] = ffi.callback(_AT_POINTS, called, error=-1)
        if plant.event is not None:
            self._add_events(plant)
        jacobian = plant.jacobian
        if jacobian is not None and free == 0:
            self.functions["derivatives_jacobian"] = self._plainly(
                lambda *at: _shaped(jacobian(*at), (n, n), "jacobian"), "jacobian"
            )

    def _keep(self, error: BaseException, name: str, t: float) -> None:
        """What a function has raised, for who called the library: the first, unless a later one interrupts."""
        if self.error is None or not isinstance(error, Exception):
            self.error = _located(error, name, t)

    def raise_kept(self) -> None:
        """What a function has raised first since the last time."""
        error, self.error = self.error, None
        if error is not None:
            raise error

    def _add_events(self, plant: Plant) -> None:
        self.sizes["n_discrete"] = len(self._discrete)
        self.functions["event"] = self._plainly(self._event, "event")
        if plant.indicators is not None:
            indicators = plant.indicators
            count = np.atleast_1d(np.asarray(indicators(0.0, *map(np.array, self._start), *self._also_discrete()), float)).size
            self.sizes["n_indicators"] = count
            self.functions["indicators"] = _of_one_point(self._called(indicators, count, "indicators", [*range(count)]))
        if plant.next_event is not None:
            self.functions["next_event_s"] = ffi.callback("double(void *, double)", self._next_event, error=float("inf"))
        if len(self._discrete):
            self.functions["get_discrete"] = ffi.callback("void(void *, double *)", self._get_discrete)
            self.functions["set_discrete"] = ffi.callback("void(void *, const double *)", self._set_discrete)

    def _event(self, *at: Any) -> Array:
        assert self.plant.event is not None
        sides, n = self.plant.event(*at), len(self.plant.states)
        if len(self._discrete):
            sides, discrete = sides
            self._discrete = _shaped(discrete, self._discrete.shape, "discrete state after event")
        return _shaped(sides, (n,), "event")

    def _next_event(self, _: Any, t: float) -> float:
        assert self.plant.next_event is not None
        try:
            answer = float(self.plant.next_event(t, *self._also_discrete()))
            if not (answer > t or answer == t == -math.inf):
                raise HnavValueError(
                    "option",
                    f"next_event of the plant answers {answer:.9g} s at t = {t:.9g} s: it must be later, or inf",
                    "next_event",
                )
            return answer
        except BaseException as error:
            self._keep(error, "next_event", t)
            return float("inf")

    def _get_discrete(self, _: Any, values: Any) -> None:
        values[0 : len(self._discrete)] = self._discrete.tolist()

    def _set_discrete(self, _: Any, values: Any) -> None:
        self._discrete = np.array(ffi.unpack(values, len(self._discrete)))

    def _also_discrete(self) -> tuple[Array, ...]:
        return (self._discrete.copy(),) if len(self._discrete) else ()

    @property
    def _start(self) -> list[list[float]]:
        return [own for _, own, _ in self._kinds]

    def _points(self, count: int, *pointers: Any) -> Iterable[Any]:
        """x, u and p at so many points, with the inputs and parameters that the library has not."""
        rows = []
        for pointer, (size, own, places) in zip(pointers, self._kinds):
            given = ffi.unpack(pointer, count * size) if size else []
            cut = [given[k : k + size] for k in range(0, count * size, size)] if size else [own] * count
            rows.append([_placed(own, places, row) for row in cut] if places else cut)
        return [*zip(*rows)]

    def _called(self, function: Function, length: int, name: str, rows: list[int]) -> Callable[..., int]:
        """The function at many points, some rows of its values. It has Python's numbers if it answers numbers, unless it needs NumPy's, at
        all or there: a root of a negative number is NaN."""

        def answers(t: float, points: Iterable[Any], kind: Callable[[list[float]], Any]) -> list[Any]:
            return [function(t, kind(x), kind(u), kind(p), *self._also_discrete()) for x, u, p in points]

        def write(found: Iterable[Any], values: Any) -> None:
            flat = [one[row] for one in found for row in rows]
            if any(isinstance(one, complex) for one in flat):  # of NumPy: a conversion would take the real part
                raise TypeError
            values[0 : len(flat)] = flat

        def write_quickly(t: float, points: Iterable[Any], values: Any) -> bool:
            try:
                found = answers(t, points, Row)
                if is_number:
                    found = [(one,) for one in found]
                sound = all(len(one) == length for one in found)
                if sound:
                    write(found, values)
            except Exception:  # raised again where it is the function's own
                return False
            return sound

        def called(_: Any, count: int, t: float, x: Any, u: Any, p: Any, values: Any) -> int:
            try:
                points = self._points(count, x, u, p)
                if not (quick and write_quickly(t, points, values)):
                    write([_shaped(one, (length,), name) for one in answers(t, points, np.array)], values)
            except BaseException as error:
                self._keep(error, name, t)
                return -1
            return 0

        quick = is_number = False
        with suppress(Exception):
            (first,) = answers(0.0, [self._start], np.array)
            is_number = isinstance(first, int | float)
            quick = isinstance(first, int | float | tuple | list) and write_quickly(0.0, [self._start], [0.0] * len(rows))
        return called

    def _plainly(self, answer: Callable[..., Array], name: str) -> Any:
        """A function of one point that answers an array."""

        def called(_: Any, count: int, t: float, x: Any, u: Any, p: Any, values: Any) -> int:
            try:
                (at,) = self._points(count, x, u, p)
                found = answer(t, *map(np.array, at), *self._also_discrete()).ravel()
                values[0 : len(found)] = found.tolist()
            except BaseException as error:
                self._keep(error, name, t)
                return -1
            return 0

        return _of_one_point(called)


def _of_one_point(called: Callable[..., int]) -> Any:
    return ffi.callback(_FUNCTION, lambda context, *at: called(context, 1, *at), error=-1)


def _floats(known: Mapping[str, float]) -> list[float]:
    return [*map(float, known.values())]


def _placed(own: list[float], places: Iterable[int], values: list[float]) -> list[float]:
    full = own.copy()
    for place, value in zip(places, values):
        full[place] = value
    return full


def _located(error: BaseException, name: str, t: float) -> BaseException:
    """What a function has raised, with its name and the time: in the message of an error of arithmetic, in a note of others."""
    where = f"{name} of the plant at t = {t:.9g} s"
    if isinstance(error, ArithmeticError | ValueError) and not isinstance(error, HnavError) and [*map(type, error.args)] == [str]:
        error.args = (f"{error.args[0]} ({where})",)
    elif not isinstance(error, HnavError):
        error.add_note(f"raised by {where}")
    return error


def _shaped(values: npt.ArrayLike, shape: tuple[int, ...], name: str) -> Array:
    if values is None:
        raise HnavValueError("option", f"{name} of the plant answers None: it must return its values", name)
    if np.iscomplexobj(np.asarray(values)):
        raise HnavValueError("option", f"{name} of the plant answers complex numbers: it must return real ones", name)
    array = np.array(values, float, ndmin=1)
    if array.shape != shape:
        raise HnavValueError("size", f"{name} of the plant has the shape {array.shape}, expected {shape}", name)
    return array
