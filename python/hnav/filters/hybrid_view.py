"""Filters as hybrid systems, for callers that bring their own integrator."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from hnav.native.arrays import Array, address, doubles
from hnav.native.library import StatefulObject, ffi


class NumberedObject(StatefulObject):
    """An object whose functions write arrays of numbers."""

    def _numbers(self, name: str, *shapes: int | tuple[int, ...], given: tuple[Any, ...] = ()) -> list[Array]:
        """Arrays of these shapes that hnav_KIND_name(object, given, arrays) has filled."""
        arrays = [np.empty(shape) for shape in shapes]
        self._call(name, *given, *map(address, arrays))
        return arrays


class HybridView(NumberedObject):
    """A filter whose states x' = derivative(t, x) flow between events and jump at them, x = jump(t, x).

    Not to be mixed with advance and run. What the states are stands in hnav/filter.h.
    """

    @property
    def nx(self) -> int:
        """Number of states of the hybrid view."""
        number = ffi.new("int32_t *")
        self._call("nx", number)
        return int(number[0])

    def get_x(self) -> Array:
        """nx: the state just after the last jump."""
        return self._numbers("get_x", self.nx)[0]

    def nominal_x(self) -> Array:
        """nx: sizes to scale tolerances by, all positive."""
        return self._numbers("nominal_x", self.nx)[0]

    def derivative(self, t_s: float, x: npt.ArrayLike) -> Array:
        """nx: dx/dt at t_s and x (nx). Changes nothing."""
        return self._numbers("derivative", self.nx, given=(t_s, address(doubles(x, (self.nx,), "x"))))[0]

    def derivative_along(self, t_s: float, x: npt.ArrayLike, seed: npt.ArrayLike) -> Array:
        """nx: the exact directional derivative (df/dx) seed of derivative at x; x and seed are nx. Changes nothing."""
        at, along = doubles(x, (self.nx,), "x"), doubles(seed, (self.nx,), "seed")
        return self._numbers("derivative_along", self.nx, given=(t_s, address(at), address(along)))[0]

    def next_event_s(self) -> float:
        """Time of the earliest waiting sample, infinite if none waits."""
        time = ffi.new("double *")
        self._call("next_event_s", time)
        return float(time[0])

    def jump(self, t_s: float, x_minus: npt.ArrayLike) -> Array:
        """nx: the state after the waiting samples up to t_s have been applied to x_minus (nx) at t_s."""
        return self._numbers("jump", self.nx, given=(t_s, address(doubles(x_minus, (self.nx,), "x_minus"))))[0]

    def show(self, t_s: float, x: npt.ArrayLike) -> None:
        """Lets the answers of the filter show the state x (nx) at t_s."""
        self._call("show", t_s, address(doubles(x, (self.nx,), "x")))
