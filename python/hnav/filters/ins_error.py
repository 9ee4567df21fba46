"""Estimation under coloured INS errors by the C library; hnav.h (section coloured INS errors) is the reference.

model = LinearModel(A=A, B=B, H=H, Qw=Qw, Qv=Qv, An=An, QU=QU, P0=P0)
run = InsErrorFilter(model, InsErrorOptions(form="augmented")).run(u, z)
run.x, run.sigma, run.compensated, run.fault_probability        # one row for each step
"""

from __future__ import annotations

import ctypes as C
from dataclasses import dataclass, field, fields, replace
from functools import cache

import numpy as np
from scipy.linalg import expm, solve_discrete_lyapunov

from hnav.errors import HnavValueError
from hnav.native.library import LibraryObject, Options, _doubles, library

FORMS = ("mdkf", "amdkf", "differenced", "augmented", "plain")
NOISE_SCALINGS = ("none", "paper_match", "gated_match", "hmm")


# --------------------------------------------------------------------------------------------- the C structs


MATRICES = ("A", "B", "G", "H", "An", "Bn", "Qw", "Qv", "QU", "Lambda0", "x0", "P0")


class _Model(C.Structure):
    _fields_ = [
        *((n, C.c_int32) for n in ("nx", "nu", "nz", "nw", "nl")),
        ("interval_s", C.c_double),
        *((n, C.c_void_p) for n in MATRICES),
    ]


class _Status(C.Structure):
    _fields_ = [
        ("steps", C.c_uint64), ("shown_step", C.c_uint64), ("nx", C.c_int32), ("nu", C.c_int32), ("nz", C.c_int32),
        ("estimates_lambda", C.c_int32),
    ]  # fmt: skip


class _RunInput(C.Structure):
    _fields_ = [(n, C.c_void_p) for n in ("u", "z", "present")]


OUTPUTS = (
    "x", "sigma", "covariance", "lam", "lam_sigma", "compensated", "innovation", "nis", "noise_scale", "fault_probability",
)  # fmt: skip


class _RunOutput(C.Structure):
    _fields_ = [(n, C.c_void_p) for n in OUTPUTS]


@cache
def _library() -> C.CDLL:
    lib = library()
    p = C.c_void_p
    for name in ("message", "warning"):
        getattr(lib, f"hnav_ins_error_filter_{name}").restype = C.c_char_p
    for name, arguments in {
        "create": [p, p, p, p, C.c_size_t], "destroy": [p], "reset": [p], "message": [p], "warning": [p],
        "separability": [p, p], "replace_model": [p, p], "step": [p, p, p, p], "estimate": [p, p, p], "covariance": [p, p],
        "coloured_error": [p, p, p, p], "innovation": [p, p, p, p], "noise": [p, p, p], "get_status": [p, p],
        "run": [p, C.c_size_t, p, p, p], "state_size": [p, p], "save": [p, p, C.c_size_t], "load": [p, p, C.c_size_t],
    }.items():  # fmt: skip
        getattr(lib, f"hnav_ins_error_filter_{name}").argtypes = arguments
    return lib


# --------------------------------------------------------------------------------------------- options and model


class InsErrorOptions(Options):
    """Options; attributes are the fields of hnav_ins_error_options, choices go by name.

    InsErrorOptions(form="amdkf", window=20)
    """

    def __init__(self, **values):
        super().__init__("ins_error", **values)


@dataclass(frozen=True)
class LinearModel:
    """x(k) = A x(k-1) + B u(k-1) + G w, z(k) = H x(k) + v + lambda(k), lambda(k) = An lambda(k-1) + Bn U.

    None: the default of hnav.h. interval_s above 0: A, B, G, Qw, An, Bn, QU are those of differential equations.
    """

    A: np.ndarray  # nx x nx
    H: np.ndarray  # nz x nx
    Qw: np.ndarray  # nw x nw
    Qv: np.ndarray  # nz x nz
    P0: np.ndarray  # nx x nx
    B: np.ndarray | None = None  # nx x nu; None: no input
    G: np.ndarray | None = None  # nx x nw; None: the identity
    An: np.ndarray | None = None  # nz x nz; None: no coloured errors
    Bn: np.ndarray | None = None  # nz x nl; None: the identity
    QU: np.ndarray | None = None  # nl x nl
    Lambda0: np.ndarray | None = None  # nz x nz; None: the stationary covariance
    x0: np.ndarray | None = None  # nx; None: zero
    interval_s: float = 0.0
    nx: int = field(init=False)
    nu: int = field(init=False)
    nz: int = field(init=False)

    def __post_init__(self):
        def put(name, value):
            object.__setattr__(self, name, value)

        for name in MATRICES:
            value = getattr(self, name)
            if value is not None:
                value = np.ascontiguousarray(value, float)
                if value.ndim != (1 if name == "x0" else 2):
                    raise HnavValueError(
                        "size", f"{name} has the shape {value.shape}, expected a {'vector' if name == 'x0' else 'matrix'}"
                    )
                put(name, value)
        for name in ("A", "H", "Qw", "Qv", "P0"):
            if getattr(self, name) is None:
                raise HnavValueError("null argument", f"{name} is None")
        put("nx", len(self.A))
        put("nz", len(self.H))
        put("nu", 0 if self.B is None else self.B.shape[1])
        nw = self.nx if self.G is None else self.G.shape[1]
        nl = self.nz if self.Bn is None else self.Bn.shape[1]
        nx, nz = self.nx, self.nz
        expected = dict(
            A=(nx, nx), B=(nx, self.nu), G=(nx, nw), H=(nz, nx), An=(nz, nz), Bn=(nz, nl), Qw=(nw, nw), Qv=(nz, nz),
            QU=(nl, nl), Lambda0=(nz, nz), x0=(nx,), P0=(nx, nx),
        )  # fmt: skip
        for name, shape in expected.items():
            value = getattr(self, name)
            if value is not None and value.shape != shape:
                raise HnavValueError("size", f"{name} has the shape {value.shape}, expected {shape}")

    def _struct(self) -> _Model:
        nw = 0 if self.G is None else self.G.shape[1]
        nl = 0 if self.Bn is None else self.Bn.shape[1]
        pointers = {n: v.ctypes.data for n in MATRICES if (v := getattr(self, n)) is not None}
        return _Model(nx=self.nx, nu=self.nu, nz=self.nz, nw=nw, nl=nl, interval_s=self.interval_s, **pointers)

    def discrete(self) -> LinearModel:
        """The same model with discrete matrices and no defaults left but An (Van Loan 1978)."""
        nx, nz = self.nx, self.nz
        B = np.zeros((nx, 0)) if self.B is None else self.B
        G = np.eye(nx) if self.G is None else self.G
        A, Qw, An, Bn, QU, Lambda0 = self.A, self.Qw, self.An, self.Bn, self.QU, self.Lambda0
        if An is not None and Bn is None:
            Bn = np.eye(nz)
        if self.interval_s > 0:
            A, B, Qw = _discretise(A, B, G @ Qw @ G.T, self.interval_s)
            G = np.eye(nx)
            if An is not None:
                An, _, QU = _discretise(An, np.zeros((nz, 0)), Bn @ QU @ Bn.T, self.interval_s)
                Bn = np.eye(nz)
        if An is not None and Lambda0 is None:
            Lambda0 = solve_discrete_lyapunov(An, Bn @ QU @ Bn.T)
        x0 = np.zeros(nx) if self.x0 is None else self.x0
        return replace(self, A=A, B=B, G=G, Qw=Qw, An=An, Bn=Bn, QU=QU, Lambda0=Lambda0, x0=x0, interval_s=0.0)


def _discretise(A, B, Q, T):
    n, m = B.shape
    held = expm(np.block([[A, B], [np.zeros((m, n + m))]]) * T)
    M = expm(np.block([[-A, Q], [np.zeros((n, n)), A.T]]) * T)
    Qd = M[n:, n:].T @ M[:n, n:]
    return held[:n, :n], held[:n, n:], 0.5 * (Qd + Qd.T)


# --------------------------------------------------------------------------------------------- the filter


@dataclass
class InsErrorRun:
    """Arrays of a batch run: row k is what the filter shows after step k (of step k - 1 for mdkf, amdkf and lag)."""

    x: np.ndarray  # n x nx
    sigma: np.ndarray  # n x nx
    covariance: np.ndarray  # n x nx x nx
    lam: np.ndarray  # n x nz: coloured error lambda
    lam_sigma: np.ndarray  # n x nz
    compensated: np.ndarray  # n x nz: z - lambda
    innovation: np.ndarray  # n x nz
    nis: np.ndarray  # n
    noise_scale: np.ndarray  # n x nz
    fault_probability: np.ndarray  # n x nz


class InsErrorFilter(LibraryObject):
    """Every method is the C function of that name and raises HnavError with its message."""

    KIND = "ins_error_filter"

    def __init__(self, model: LinearModel, options: InsErrorOptions | None = None):
        self.model, self.options = model, options or InsErrorOptions()
        lib = _library()
        super().__init__(lib, lib.hnav_ins_error_filter_create, C.byref(self.options.struct), C.byref(model._struct()))

    def step(self, u, z, present=None) -> None:
        """u: nu, held since the last step; z: nz, NaN where missing; present: nz, false where missing."""
        u = _doubles(np.zeros(0) if u is None else np.atleast_1d(u), (self.model.nu,), "u")
        z = _doubles(np.atleast_1d(z), (self.model.nz,), "z")
        mask = _mask(present, (self.model.nz,))
        self._call("step", u.ctypes.data, z.ctypes.data, None if mask is None else mask.ctypes.data)

    def run(self, u, z, present=None) -> InsErrorRun:
        """u: n x nu or None; z, present: n x nz; row k goes to step k."""
        nx, nu, nz = self.model.nx, self.model.nu, self.model.nz
        n = len(z)
        u = _doubles(np.zeros((n, 0)) if u is None else u, (n, nu), "u")
        z = _doubles(z, (n, nz), "z")
        widths = dict(x=(nx,), sigma=(nx,), covariance=(nx, nx), nis=())
        run = InsErrorRun(**{f.name: np.empty((n, *widths.get(f.name, (nz,)))) for f in fields(InsErrorRun)})
        mask = _mask(present, (n, nz))
        arrays_in = _RunInput(u.ctypes.data, z.ctypes.data, None if mask is None else mask.ctypes.data)
        arrays_out = _RunOutput(*(getattr(run, name).ctypes.data for name in OUTPUTS))
        self._call("run", n, C.byref(arrays_in), C.byref(arrays_out), None)
        return run

    def replace_model(self, model: LinearModel) -> None:
        """Other matrices of the same sizes from the next step on."""
        self._call("replace_model", C.byref(model._struct()))
        self.model = model

    def reset(self) -> None:
        self._call("reset")

    def _arrays(self, name: str, *shapes) -> list[np.ndarray]:
        arrays = [np.empty(shape) for shape in shapes]
        self._call(name, *(a.ctypes.data for a in arrays))
        return arrays

    def estimate(self) -> tuple[np.ndarray, np.ndarray]:
        """State and its standard deviations."""
        return tuple(self._arrays("estimate", self.model.nx, self.model.nx))

    def covariance(self) -> np.ndarray:
        return self._arrays("covariance", (self.model.nx, self.model.nx))[0]

    def coloured_error(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """lambda, its standard deviations, compensated measurement z - lambda."""
        return tuple(self._arrays("coloured_error", *[self.model.nz] * 3))

    def innovation(self) -> tuple[np.ndarray, np.ndarray, float]:
        """Innovation, its covariance S, NIS."""
        nu, S, nis = self._arrays("innovation", self.model.nz, (self.model.nz, self.model.nz), 1)
        return nu, S, float(nis[0])

    def noise(self) -> tuple[np.ndarray, np.ndarray]:
        """Noise scale and fault probability by channel."""
        return tuple(self._arrays("noise", self.model.nz, self.model.nz))

    @property
    def warning(self) -> str:
        return self._lib.hnav_ins_error_filter_warning(self._handle).decode()

    def separability(self) -> float:
        return float(self._arrays("separability", 1)[0][0])

    def status(self) -> _Status:
        status = _Status()
        self._call("get_status", C.byref(status))
        return status


def _mask(present, shape) -> np.ndarray | None:
    if present is None:
        return None
    mask = np.ascontiguousarray(present, np.uint8)
    if mask.shape != shape:
        raise HnavValueError("size", f"present has the shape {mask.shape}, expected {shape}")
    return mask
