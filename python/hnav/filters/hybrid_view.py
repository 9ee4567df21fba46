"""Filters as hybrid systems, for callers that bring their own integrator."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hnav.native.arrays import Array, address, doubles
from hnav.native.library import StatefulObject, ffi


class HybridView(StatefulObject):
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
        x = np.empty(self.nx)
        self._call("get_x", address(x))
        return x

    def nominal_x(self) -> Array:
        """nx: sizes to scale tolerances by, all positive."""
        nominal = np.empty(self.nx)
        self._call("nominal_x", address(nominal))
        return nominal

    def derivative(self, t_s: float, x: npt.ArrayLike) -> Array:
        """nx: dx/dt at t_s and x (nx). Changes nothing."""
        dx = np.empty(self.nx)
        self._call("derivative", t_s, address(doubles(x, (self.nx,), "x")), address(dx))
        return dx

    def derivative_along(self, t_s: float, x: npt.ArrayLike, seed: npt.ArrayLike) -> Array:
        """nx: the exact directional derivative (df/dx) seed of derivative at x; x and seed are nx. Changes nothing."""
        at, along, out = doubles(x, (self.nx,), "x"), doubles(seed, (self.nx,), "seed"), np.empty(self.nx)
        self._call("derivative_along", t_s, address(at), address(along), address(out))
        return out

    def next_event_s(self) -> float:
        """Time of the earliest waiting sample, infinite if none waits."""
        time = ffi.new("double *")
        self._call("next_event_s", time)
        return float(time[0])

    def jump(self, t_s: float, x_minus: npt.ArrayLike) -> Array:
        """nx: the state after the waiting samples up to t_s have been applied to x_minus (nx) at t_s."""
        x_plus = np.empty(self.nx)
        self._call("jump", t_s, address(doubles(x_minus, (self.nx,), "x_minus")), address(x_plus))
        return x_plus

    def show(self, t_s: float, x: npt.ArrayLike) -> None:
        """Lets the answers of the filter show the state x (nx) at t_s."""
        self._call("show", t_s, address(doubles(x, (self.nx,), "x")))
