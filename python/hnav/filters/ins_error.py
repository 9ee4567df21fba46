"""Estimation of a linear system from measurements with time-correlated errors, such as those of an INS, by the C library.

    model = LinearModel(A=A, B=B, H=H, Qw=Qw, Qv=Qv, An=An, QU=QU, P0=P0)
    run = InsErrorFilter(model, form="augmented").run(u, z)
    run.x, run.sigma, run.compensated, run.fault_probability        # one row for each step

    x(k) = A x(k-1) + B u(k-1) + G w(k-1)            w ~ (0, Qw)
    z(k) = H x(k) + v(k) + lambda(k)                 v ~ (0, Qv)
    lambda(k) = An lambda(k-1) + Bn U(k-1)           U ~ (0, QU), lambda(0) ~ (0, Lambda0)

Units are the model's. Filters of different threads run in parallel; one filter serves one thread at a time. Source of the
printed forms: Hajiyev and Hacizade, WSEAS Trans. Systems and Control 18, 2023, doi 10.37394/23203.2023.18.51.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from hnav.errors import HnavValueError
from hnav.filters.hybrid_view import NumberedObject
from hnav.filters.linear_model import LinearModel
from hnav.native.arrays import Array, Record, address, doubles
from hnav.native.library import enumerators, ffi, library, new, text
from hnav.native.options import OptionSet, complete

FORMS = enumerators("hnav_ins_error_form", "HNAV_INS_ERROR_")
"""How the filter treats the correlation: the printed mdkf and amdkf, differenced, augmented (optimal), plain (ignores it)."""

NOISE_SCALINGS = enumerators("hnav_noise_scaling", "HNAV_NOISE_SCALING_")
"""Adaptation of Qv by channel."""


class InsErrorOptions(OptionSet):
    """Options of the filter for coloured errors, as attributes; option_rows("ins_error") has unit, range and meaning of each.

        InsErrorOptions(form="amdkf", window=20)

    Raises HnavValueError for names (UnknownOptionError) and values that do not exist.
    """

    LIST = "ins_error"


@dataclass
class InsErrorRun:
    """Arrays of a batch run: row k is what the filter shows after step k (of step k - 1 for mdkf, amdkf and lag)."""

    x: Array
    """n x nx: the state."""
    sigma: Array
    """n x nx: its standard deviations."""
    covariance: Array
    """n x nx x nx: its covariance."""
    lam: Array
    """n x nz: the coloured error lambda; forms other than augmented have no such state and answer z - H x, lambda + v."""
    lam_sigma: Array
    """n x nz: its standard deviations."""
    compensated: Array
    """n x nz: z - lambda, NaN where z is missing."""
    innovation: Array
    """n x nz: innovation, NaN where z is missing."""
    nis: Array
    """n: normalised innovation squared of the channels with a measurement."""
    noise_scale: Array
    """n x nz: factor on Qv (on R in amdkf)."""
    fault_probability: Array
    """n x nz: probability that the noise of the channel exceeds Qv."""
    bias_fault_probability: Array
    """n x nz: probability that the coloured error of the channel has jumped; it decays once the jump is estimated. 0 unless noise_scaling is joint."""
    process_fault_probability: Array
    """n: probability that the process noise of the state or of the coloured errors exceeds Qw or QU. 0 unless noise_scaling is joint."""


OUTPUTS = tuple(f.name for f in fields(InsErrorRun))
_IN_C = {"lam": "lambda", "lam_sigma": "lambda_sigma"}  # lambda is a word of Python


@dataclass(frozen=True, eq=False)
class InsErrorInfo(Record):
    """The number of steps so far, and the sizes of the model."""

    steps: int
    """Number of steps since creation or reset."""
    shown_step: int
    """The step, counted from 0, of the outputs."""
    nx: int
    """Number of states."""
    nu: int
    """Number of inputs."""
    nz: int
    """Number of measurements."""
    estimates_lambda: bool
    """The coloured error lambda is a state."""


class InsErrorFilter(NumberedObject):
    """A Kalman filter for measurements with time-correlated errors.

        InsErrorFilter(model, form="amdkf", window=20)
        InsErrorFilter(model, InsErrorOptions(form="amdkf"))

    Raises HnavValueError, naming the matrix or option, for models and options that are impossible: a matrix that is no covariance,
    an unstable An, an unstable mode of A that is not observable. Filters are copied and pickled with
    their state.
    """

    KIND = "ins_error_filter"

    def __init__(self, model: LinearModel, options: InsErrorOptions | None = None, **values: object):
        self._options = complete(InsErrorOptions, options, values)
        self._first_model, self.model = model, model
        super().__init__("hnav_ins_error_filter_create", self._options.struct, model.struct())

    @property
    def options(self) -> InsErrorOptions:
        """A copy of the options that the filter was made with."""
        return copy(self._options)

    def __reduce__(self) -> tuple[Any, ...]:
        return _continued, (self._first_model, self._options, self.model, self.save())

    def step(self, u: npt.ArrayLike | None, z: npt.ArrayLike, present: npt.ArrayLike | None = None) -> None:
        """One step: u is nu, held since the last step (None without input), z is nz, NaN where a channel is missing.

        The first step does not read u: its prior is x0 and P0. present: nz, false where missing, or None. Raises
        HnavValueError for numbers that are not finite, HnavRuntimeError for an estimate without bound.
        """
        held = doubles(np.zeros(0) if u is None else np.atleast_1d(np.asarray(u)), (self.model.nu,), "u")
        seen = doubles(np.atleast_1d(np.asarray(z)), (self.model.nz,), "z")
        self._call("step", address(held), address(seen), address(_mask(present, (self.model.nz,))))

    def run(self, u: npt.ArrayLike | None, z: npt.ArrayLike, present: npt.ArrayLike | None = None) -> InsErrorRun:
        """Step after step, bit for bit: u is n x nu or None, z and present are n x nz; row k goes to step k."""
        nx, nu, nz, n = self.model.nx, self.model.nu, self.model.nz, len(np.asarray(z))
        held = doubles(np.zeros((n, 0)) if u is None else u, (n, nu), "u")
        seen, mask = doubles(z, (n, nz), "z"), _mask(present, (n, nz))
        widths: dict[str, tuple[int, ...]]
        widths = dict(x=(nx,), sigma=(nx,), covariance=(nx, nx), nis=(), process_fault_probability=())
        run = InsErrorRun(**{name: np.empty((n, *widths.get(name, (nz,)))) for name in OUTPUTS})
        given = new("hnav_ins_error_run_input", u=address(held), z=address(seen), present=address(mask))
        wanted = new("hnav_ins_error_run_output", **{_IN_C.get(name, name): address(getattr(run, name)) for name in OUTPUTS})
        self._call("run", n, given, wanted, ffi.NULL)
        return run

    def replace_model(self, model: LinearModel) -> None:
        """Other matrices of the same sizes from the next step on; x0, P0 and Lambda0 count again at a reset.

        Raises HnavValueError as the filter itself does.
        """
        self._call("replace_model", model.struct())
        self.model = model

    def estimate(self) -> tuple[Array, Array]:
        """State and its standard deviations: nx each, of the newest step, or of the one before (mdkf, amdkf, lag = 1)."""
        x, sigma = self._numbers("estimate", self.model.nx, self.model.nx)
        return x, sigma

    def covariance(self) -> Array:
        """nx x nx: of the state."""
        return self._numbers("covariance", (self.model.nx, self.model.nx))[0]

    def coloured_error(self) -> tuple[Array, Array, Array]:
        """lambda, its standard deviations, and the compensated measurement z - lambda: nz each."""
        lam, sigma, compensated = self._numbers("coloured_error", *[self.model.nz] * 3)
        return lam, sigma, compensated

    def innovation(self) -> tuple[Array, Array, float]:
        """Of the newest sample: innovation (nz), its covariance S (nz x nz), NIS. Raises HnavRuntimeError before the first."""
        nu, S, nis = self._numbers("innovation", self.model.nz, (self.model.nz, self.model.nz), 1)
        return nu, S, float(nis[0])

    def noise(self) -> tuple[Array, Array]:
        """By channel (nz each): factor on the noise, and the probability that it is above 1."""
        scale, fault_probability = self._numbers("noise", self.model.nz, self.model.nz)
        return scale, fault_probability

    def faults(self) -> tuple[Array, Array, float]:
        """Probabilities of a fault: of the noise of each channel (nz), of a jump of its coloured error (nz), of the process."""
        noise, bias, process = self._numbers("faults", self.model.nz, self.model.nz, 1)
        return noise, bias, float(process[0])

    @property
    def warning(self) -> str:
        """What is legal but suspicious in the model: states and coloured errors that separate poorly; empty if nothing."""
        return text(library().hnav_ins_error_filter_warning(self._handle))

    def separability(self) -> float:
        """0: a mode of A moves the measurements just as lambda does; 1: nothing like it. The smallest over the modes."""
        return float(self._numbers("separability", 1)[0][0])

    def info(self) -> InsErrorInfo:
        """The number of steps so far, and the sizes of the model."""
        return InsErrorInfo.read(self._filled("hnav_ins_error_info", "info"))


def _continued(first_model: LinearModel, options: InsErrorOptions, model: LinearModel, state: bytes) -> InsErrorFilter:
    filter = InsErrorFilter(first_model, options)
    filter.load(state)
    if model is not first_model:
        filter.replace_model(model)
    return filter


def _mask(present: npt.ArrayLike | None, shape: tuple[int, ...]) -> npt.NDArray[np.uint8] | None:
    if present is None:
        return None
    mask = np.ascontiguousarray(present, np.uint8)
    if mask.shape != shape:
        raise HnavValueError("size", f"present has the shape {mask.shape}, expected {shape}", "present")
    return mask
