"""Linear models whose measurements have time-correlated errors, for the filter hnav.filters.ins_error and the simulation
hnav.simulation.aircraft."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy.linalg import expm, solve_discrete_lyapunov

from hnav.errors import HnavValueError
from hnav.native.arrays import Array, address
from hnav.native.library import new

MATRICES = ("A", "B", "G", "H", "An", "Bn", "Qw", "Qv", "QU", "Lambda0", "x0", "P0")
_NEEDED = ("A", "H", "Qw", "Qv", "P0")


@dataclass(frozen=True, eq=False)
class LinearModel:
    """x(k) = A x(k-1) + B u(k-1) + G w, z(k) = H x(k) + v + lambda(k), lambda(k) = An lambda(k-1) + Bn U.

    Raises HnavValueError, naming the matrix, for a missing matrix or a shape that does not fit the others.
    """

    A: Array
    """nx x nx."""
    H: Array
    """nz x nx."""
    Qw: Array
    """nw x nw: covariance of w."""
    Qv: Array
    """nz x nz: covariance of v."""
    P0: Array
    """nx x nx: covariance of x before the first step."""
    B: Array | None = None
    """nx x nu; None: no input."""
    G: Array | None = None
    """nx x nw; None: the identity."""
    An: Array | None = None
    """nz x nz; None: no coloured errors."""
    Bn: Array | None = None
    """nz x nl; None: the identity."""
    QU: Array | None = None
    """nl x nl: covariance of U; not None when An is not."""
    Lambda0: Array | None = None
    """nz x nz: covariance of lambda before the first step; None: the stationary one."""
    x0: Array | None = None
    """nx: x before the first step; None: zero."""
    interval_s: float = 0.0
    """0: the matrices are those of one step. Above: those of the differential equations dx/dt = A x + B u + G w and
    dlambda/dt = An lambda + Bn U with spectral densities Qw and QU, discretised exactly over this interval, u held."""
    nx: int = field(init=False)
    """Number of states."""
    nu: int = field(init=False)
    """Number of inputs."""
    nz: int = field(init=False)
    """Number of measurements."""

    def __post_init__(self) -> None:
        for name in MATRICES:
            value = getattr(self, name)
            if value is not None:
                self._put(name, _of_rank(value, 1 if name == "x0" else 2, name))
            elif name in _NEEDED or (name == "QU" and self.An is not None):
                raise HnavValueError("null argument", f"{name} is None", name)
        self._put("nx", len(self.A))
        self._put("nz", len(self.H))
        self._put("nu", 0 if self.B is None else self.B.shape[1])
        nx, nu, nz = self.nx, self.nu, self.nz
        nw = nx if self.G is None else self.G.shape[1]
        nl = nz if self.Bn is None else self.Bn.shape[1]
        expected: dict[str, tuple[int, ...]] = dict(
            A=(nx, nx), B=(nx, nu), G=(nx, nw), H=(nz, nx), An=(nz, nz), Bn=(nz, nl), Qw=(nw, nw), Qv=(nz, nz), QU=(nl, nl),
            Lambda0=(nz, nz), x0=(nx,), P0=(nx, nx),
        )  # fmt: skip
        for name, shape in expected.items():
            value = getattr(self, name)
            if value is not None and value.shape != shape:
                raise HnavValueError("size", f"{name} has the shape {value.shape}, expected {shape}", name)

    def _put(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)

    def matrix(self, name: str) -> Array:
        """One of MATRICES. Raises HnavValueError for a matrix that the model does not have."""
        value: Array | None = getattr(self, name)
        if value is None:
            raise HnavValueError("null argument", f"{name} is None", name)
        return value

    def struct(self) -> Any:
        """The C struct of the model; its matrices are those of this object, which must live as long."""
        matrices = {name: address(getattr(self, name)) for name in MATRICES}
        sizes = dict(nx=self.nx, nu=self.nu, nz=self.nz)
        sizes |= dict(nw=0 if self.G is None else self.G.shape[1], nl=0 if self.Bn is None else self.Bn.shape[1])
        return new("hnav_ins_error_model", interval_s=self.interval_s, **sizes, **matrices)

    def discrete(self) -> LinearModel:
        """The same model with discrete matrices and no defaults left but An (Van Loan 1978)."""
        nx, nz = self.nx, self.nz
        A, Qw, An, QU, Lambda0 = self.A, self.Qw, self.An, self.QU, self.Lambda0
        B = np.zeros((nx, 0)) if self.B is None else self.B
        G = np.eye(nx) if self.G is None else self.G
        Bn = np.eye(nz) if An is not None and self.Bn is None else self.Bn
        if self.interval_s > 0:
            A, B, Qw = _discretise(A, B, G @ Qw @ G.T, self.interval_s)
            G = np.eye(nx)
        if An is not None and QU is not None and Bn is not None:
            if self.interval_s > 0:
                An, _, QU = _discretise(An, np.zeros((nz, 0)), Bn @ QU @ Bn.T, self.interval_s)
                Bn = np.eye(nz)
            if Lambda0 is None:
                Lambda0 = np.asarray(solve_discrete_lyapunov(An, Bn @ QU @ Bn.T), np.float64)
        x0 = np.zeros(nx) if self.x0 is None else self.x0
        return replace(self, A=A, B=B, G=G, Qw=Qw, An=An, Bn=Bn, QU=QU, Lambda0=Lambda0, x0=x0, interval_s=0.0)


def _of_rank(value: Array, rank: int, name: str) -> Array:
    array = np.ascontiguousarray(value, np.float64)
    if array.ndim != rank:
        kind = "vector" if rank == 1 else "matrix"
        raise HnavValueError("size", f"{name} has the shape {array.shape}, expected a {kind}", name)
    return array


def _discretise(A: Array, B: Array, Q: Array, T: float) -> tuple[Array, Array, Array]:
    n, m = B.shape
    held = expm(np.block([[A, B], [np.zeros((m, n + m))]]) * T)
    M = expm(np.block([[-A, Q], [np.zeros((n, n)), A.T]]) * T)
    Qd = M[n:, n:].T @ M[:n, n:]
    return held[:n, :n], held[:n, n:], 0.5 * (Qd + Qd.T)
