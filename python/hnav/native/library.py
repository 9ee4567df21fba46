"""The C library by ctypes; c_src/include/hnav/hnav.h is the reference for everything here.

    options = Options("ahrs", navigation_frame="enu")
    attitude = Filter(options).run(t_s, rate, force, field)     # n x 3 arrays in SI units
    attitude.q_nb                                               # n x 4, scalar first, body to navigation

ctypes releases the interpreter's lock during a call, so filters run in parallel threads.
"""

from __future__ import annotations

import ctypes as C
import os
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from hnav.errors import HnavRuntimeError, HnavValueError, error_of
from hnav.places import CHECKOUT, PACKAGE
from hnav.renamed import now_called

STATUS = (
    "ok", "null argument", "option", "options stamp", "out of memory", "non-finite", "zero vector", "out of range",
    "late sample", "queue full", "time backwards", "not started", "no data", "size", "state corrupt", "solver",
    "unsupported", "ill-conditioned", "state version",
)  # fmt: skip
SENSORS = ("gyro", "accel", "mag", "heading")
# The filters of the library, and the presets of each.
FILTERS = {"hrekf": ("default", "paper"), "ahrs": ("default",)}
# What else has options.
OTHERS = ("ins_error", "magnetometer", "turntable", "imu_mag_sensor", "aircraft")
PRESETS = ("default", "paper")  # in the order of the C enum


# --------------------------------------------------------------------------------------------- the C structs


class _OptionInfo(C.Structure):
    _fields_ = [
        ("name", C.c_char_p), ("group", C.c_char_p), ("unit", C.c_char_p), ("description", C.c_char_p), ("reason", C.c_char_p),
        ("choices", C.POINTER(C.c_char_p)), ("choice_descriptions", C.POINTER(C.c_char_p)),
        ("default_values", C.POINTER(C.c_double)), ("offset", C.c_size_t), ("min", C.c_double), ("max", C.c_double),
        ("count", C.c_int32), ("choice_count", C.c_int32), ("kind", C.c_int), ("min_is_open", C.c_int32),
        ("max_is_open", C.c_int32), ("advanced", C.c_int32),
    ]  # fmt: skip


class _Struct(C.Structure):
    """A struct of results whose fields read as floats, arrays or integers."""

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{n}={_plain(getattr(self, n))}' for n, _ in self._fields_)})"


class Attitude(_Struct):
    _fields_ = [
        ("t_s", C.c_double), ("q_nb", C.c_double * 4), ("euler_rad", C.c_double * 3), ("heading_rad", C.c_double),
        ("sigma_rad", C.c_double * 3), ("near_singular", C.c_int32), ("tilt_ready", C.c_int32),
        ("heading_ready", C.c_int32),
    ]  # fmt: skip


class Posterior(_Struct):
    _fields_ = [
        ("t_s", C.c_double), ("q_nb", C.c_double * 4), ("gyro_bias_rad_s", C.c_double * 3), ("sigma", C.c_double * 6),
        ("near_singular", C.c_int32), ("tilt_ready", C.c_int32), ("heading_ready", C.c_int32), ("reserved", C.c_int32),
    ]  # fmt: skip


class Innovation(_Struct):
    _fields_ = [
        ("t_s", C.c_double), ("value", C.c_double * 3), ("S", C.c_double * 9), ("nis", C.c_double),
        ("noise_scale", C.c_double), ("dimension", C.c_int32), ("accepted", C.c_int32),
    ]  # fmt: skip


class Status(_Struct):
    _fields_ = [
        ("gamma_used", C.c_double), ("gamma_margin", C.c_double), ("adapted_bias_walk_rad_s_per_sqrt_s", C.c_double),
        ("newest_sample_s", C.c_double), ("used", C.c_uint64 * 4), ("gated", C.c_uint64 * 4), ("late", C.c_uint64),
        ("non_finite", C.c_uint64), ("zero", C.c_uint64), ("corrections", C.c_uint64), ("gamma_raised", C.c_uint64),
        ("covariance_repaired", C.c_uint64), ("solver_rhs_evals", C.c_uint64), ("solver_steps", C.c_uint64),
        ("started", C.c_int32), ("waiting", C.c_int32), ("decay_rate_1_s", C.c_double),
    ]  # fmt: skip


class Field(_Struct):
    """What the filter holds of the magnetic field and its sensor."""

    _fields_ = [
        ("strength_tesla", C.c_double), ("dip_rad", C.c_double), ("latency_s", C.c_double), ("latency_sigma_s", C.c_double),
        ("evidence_s", C.c_double), ("heading_trust_s", C.c_double), ("reference_changes", C.c_int32), ("gate", C.c_int32),
        ("at_rest", C.c_int32), ("reserved", C.c_int32),
    ]  # fmt: skip


class _RunInput(C.Structure):
    _fields_ = [(n, C.c_void_p) for n in ("t_s", "rate_b_rad_s", "force_b_m_s2", "field_b_tesla")]


class _RunOutput(C.Structure):
    _fields_ = [
        (n, C.c_void_p)
        for n in (
            "q_nb", "euler_rad", "sigma_rad", "gyro_bias_rad_s", "gyro_bias_sigma_rad_s", "accel_nis", "mag_nis", "ready",
        )
    ]  # fmt: skip


def _plain(value):
    return list(value) if isinstance(value, C.Array) else value


# --------------------------------------------------------------------------------------------- the library


def library_path() -> Path:
    """HNAV_LIBRARY, else the library beside this package (wheel), else the build of the checkout."""
    given = os.environ.get("HNAV_LIBRARY")
    if given:
        return Path(given)
    for candidate in (PACKAGE / "libhnav.so", CHECKOUT / "build" / "c_src" / "libhnav.so"):
        if candidate.is_file():
            return candidate
    raise HnavRuntimeError("unsupported", "libhnav.so is not built: ./run build makes it, or set HNAV_LIBRARY to its path")


@cache
def library() -> C.CDLL:
    lib = C.CDLL(str(library_path()))
    for name in ("hnav_version", "hnav_status_text", "hnav_filter_message"):
        getattr(lib, name).restype = C.c_char_p
    for name in (*FILTERS, *OTHERS):
        getattr(lib, f"hnav_{name}_option").restype = C.POINTER(_OptionInfo)
    pointers = [C.c_void_p] * 6
    for name, arguments in {
        "hnav_filter_message": pointers[:1],
        "hnav_filter_destroy": pointers[:1],
        "hnav_filter_advance": [C.c_void_p, C.c_double],
        "hnav_filter_push_heading": [C.c_void_p, C.c_double, C.c_double, C.c_double],
        "hnav_filter_run": [C.c_void_p, C.c_size_t, *pointers[:3]],
        "hnav_filter_smooth": [C.c_void_p, C.c_size_t, *pointers[:2]],
        "hnav_filter_innovation": [C.c_void_p, C.c_int, C.c_void_p],
        "hnav_filter_save": [C.c_void_p, C.c_void_p, C.c_size_t],
        "hnav_filter_load": [C.c_void_p, C.c_void_p, C.c_size_t],
        "hnav_filter_derivative": [C.c_void_p, C.c_double, *pointers[:2]],
        "hnav_filter_derivative_along": [C.c_void_p, C.c_double, *pointers[:3]],
        "hnav_filter_jump": [C.c_void_p, C.c_double, *pointers[:2]],
        "hnav_filter_show": [C.c_void_p, C.c_double, C.c_void_p],
    }.items():
        getattr(lib, name).argtypes = arguments
    for name in ("gyro", "accel", "mag"):
        getattr(lib, f"hnav_filter_push_{name}").argtypes = [C.c_void_p, C.c_double, C.c_void_p]
    lib.hnav_filter_push_imu.argtypes = [C.c_void_p, C.c_double, C.c_void_p, C.c_void_p]
    return lib


def version() -> str:
    return library().hnav_version().decode()


# --------------------------------------------------------------------------------------------- options


@dataclass(frozen=True)
class OptionInfo:
    """One option: its unit, range and meaning as the library states them."""

    name: str
    group: str
    unit: str
    description: str
    reason: str  # why the default is what it is
    choices: tuple[str, ...]
    choice_descriptions: tuple[str, ...]
    default: tuple[float, ...]
    min: float
    max: float
    is_integer: bool
    advanced: bool
    offset: int

    @property
    def count(self) -> int:
        return len(self.default)

    def parse(self, text: str) -> float | int | list[float]:
        """A value from text: a choice by name, numbers separated by commas for arrays. Raises ValueError."""
        if self.choices:
            if text not in self.choices:
                raise ValueError(f"{self.name} = {text}: choose one of {', '.join(self.choices)}")
            return self.choices.index(text)
        parts = text.split(",")
        if len(parts) != self.count:
            raise ValueError(f"{self.name} takes {self.count} number{'s' * (self.count > 1)}, not {len(parts)}")
        try:
            numbers = [float(p) for p in parts]
        except ValueError:
            raise ValueError(f"{self.name} = {text}: not a number") from None
        if self.is_integer and numbers[0] != int(numbers[0]):
            raise ValueError(f"{self.name} = {text}: not a whole number")
        return numbers if self.count > 1 else int(numbers[0]) if self.is_integer else numbers[0]


@cache
def option_table(filter: str) -> dict[str, OptionInfo]:
    """The options of a filter, or of one of OTHERS, by name in the library's order."""
    if filter not in (*FILTERS, *OTHERS):
        raise HnavValueError("option", f"--filter {filter}{now_called(filter, 'filter')}: choose one of {', '.join(FILTERS)}")
    table = {}
    while row := getattr(library(), f"hnav_{filter}_option")(len(table)):
        r = row[0]
        texts = (text.decode() for text in (r.name, r.group, r.unit, r.description, r.reason))
        choices = (tuple(names[i].decode() for i in range(r.choice_count)) for names in (r.choices, r.choice_descriptions))
        default = tuple(r.default_values[: r.count])
        table[r.name.decode()] = OptionInfo(*texts, *choices, default, r.min, r.max, r.kind != 0, r.advanced != 0, r.offset)
    return table


def parse_setting(text: str) -> tuple[str, str]:
    """NAME=VALUE as the command line takes it. Raises HnavError."""
    name, separator, value = text.partition("=")
    if not (separator and name and value):
        raise HnavValueError("option", f"--set {text}: write NAME=VALUE")
    return name, value


class Options:
    """Options of a filter, or of one of OTHERS; attributes are the fields of hnav_..._options, choices go by name.

    Options("hrekf", "paper", gamma_mode="kl", q_body_sensor=[1, 0, 0, 0])
    """

    def __init__(self, filter: str, preset: str = "default", **values):
        table = option_table(filter)
        presets = FILTERS.get(filter, ("default",))
        if preset not in presets:
            raise HnavValueError("option", f"preset = {preset}: {filter} has {', '.join(presets)}")
        last = max(table.values(), key=lambda o: o.offset)
        words = (last.offset + 4 * last.count + 7) // 8
        struct = type("_Options", (C.Structure,), {"_fields_": [("words", C.c_uint64 * words)]})
        make = C.CFUNCTYPE(struct, C.c_int)((f"hnav_{filter}_defaults", library()))
        object.__setattr__(self, "filter", filter)
        object.__setattr__(self, "struct", make(PRESETS.index(preset)))
        for name, value in values.items():
            setattr(self, name, value)

    def _info(self, name: str) -> OptionInfo:
        try:
            return option_table(self.filter)[name]
        except KeyError:
            known = f"`hnav options --filter {self.filter}` lists them"
            if self.filter not in FILTERS:
                known = f"the options are {', '.join(option_table(self.filter))}"
            raise HnavValueError("option", f"{self.filter} has no option {name}{now_called(name, 'option')}; {known}") from None

    def _field(self, info: OptionInfo):
        kind = C.c_int32 if info.is_integer else C.c_double
        return (kind * info.count).from_buffer(self.struct, info.offset)

    def __getattr__(self, name: str):
        info = self._info(name)
        values = list(self._field(info))
        if info.choices:
            return info.choices[values[0]]
        return values if info.count > 1 else values[0]

    def __setattr__(self, name: str, value):
        info = self._info(name)
        if isinstance(value, str):
            try:
                value = info.parse(value)
            except ValueError as error:
                raise HnavValueError("option", str(error)) from None
        values = np.ravel(value)
        if len(values) != info.count:
            raise HnavValueError("option", f"{name} takes {info.count} numbers, not {len(values)}")
        field = self._field(info)
        for i, v in enumerate(values):
            field[i] = int(v) if info.is_integer else float(v)


# --------------------------------------------------------------------------------------------- filters


@dataclass
class Run:
    """Arrays of a batch run, one row for each instant; NaN before the start and where no sample was used."""

    t_s: np.ndarray
    q_nb: np.ndarray  # n x 4, scalar first
    euler_rad: np.ndarray  # n x 3: roll, pitch, yaw
    sigma_rad: np.ndarray  # n x 3: rotation about the navigation axes
    gyro_bias_rad_s: np.ndarray  # n x 3
    gyro_bias_sigma_rad_s: np.ndarray  # n x 3
    accel_nis: np.ndarray  # n
    mag_nis: np.ndarray  # n
    ready: np.ndarray  # n x 2, bool: tilt, heading


def empty_run(t_s: np.ndarray) -> Run:
    """A Run of these instants that knows nothing yet."""
    n = len(t_s)
    return Run(
        t_s, np.full((n, 4), np.nan), *(np.full((n, 3), np.nan) for _ in range(4)), np.full(n, np.nan), np.full(n, np.nan),
        np.zeros((n, 2), bool),
    )  # fmt: skip


def _doubles(values, shape: tuple[int, ...], name: str) -> np.ndarray:
    array = np.ascontiguousarray(values, float)
    if array.shape != shape:
        raise HnavValueError("size", f"{name} has the shape {array.shape}, expected {shape}")
    return array


class LibraryObject:
    """An object of the C library, whose functions are hnav_KIND_...; destroyed with this one. Raises HnavError with its message."""

    KIND: str

    def __init__(self, lib: C.CDLL, create, *arguments):
        self._lib = lib
        self._handle = C.c_void_p()
        message = C.create_string_buffer(320)
        status = create(C.byref(self._handle), *arguments, message, len(message))
        if status:
            raise error_of(STATUS[status], message.value.decode())

    def __del__(self):
        if getattr(self, "_handle", None):
            getattr(self._lib, f"hnav_{self.KIND}_destroy")(self._handle)

    def _call(self, name: str, *arguments) -> None:
        status = getattr(self._lib, f"hnav_{self.KIND}_{name}")(self._handle, *arguments)
        if status:
            raise error_of(STATUS[status], getattr(self._lib, f"hnav_{self.KIND}_message")(self._handle).decode())

    def save(self) -> bytes:
        size = C.c_size_t()
        self._call("state_size", C.byref(size))
        buffer = C.create_string_buffer(size.value)
        self._call("save", buffer, size)
        return buffer.raw

    def load(self, state: bytes) -> None:
        self._call("load", state, len(state))


class Filter(LibraryObject):
    """An attitude filter; every method is the C function of that name and raises HnavError with its message."""

    KIND = "filter"

    def __init__(self, options: Options):
        lib = library()
        super().__init__(lib, getattr(lib, f"hnav_{options.filter}_create"), C.byref(options.struct))

    def _vector(self, value, name: str):
        return _doubles(value, (3,), name).ctypes.data_as(C.c_void_p)

    def push_gyro(self, t_s: float, rate_b_rad_s) -> None:
        self._call("push_gyro", t_s, self._vector(rate_b_rad_s, "rate_b_rad_s"))

    def push_accel(self, t_s: float, force_b_m_s2) -> None:
        self._call("push_accel", t_s, self._vector(force_b_m_s2, "force_b_m_s2"))

    def push_mag(self, t_s: float, field_b_tesla) -> None:
        self._call("push_mag", t_s, self._vector(field_b_tesla, "field_b_tesla"))

    def push_imu(self, t_s: float, rate_b_rad_s, force_b_m_s2) -> None:
        force = self._vector(force_b_m_s2, "force_b_m_s2")
        self._call("push_imu", t_s, self._vector(rate_b_rad_s, "rate_b_rad_s"), force)

    def push_heading(self, t_s: float, heading_rad: float, sigma_rad: float) -> None:
        self._call("push_heading", t_s, heading_rad, sigma_rad)

    def advance(self, t_s: float) -> None:
        self._call("advance", t_s)

    def run(self, t_s, rate_b_rad_s=None, force_b_m_s2=None, field_b_tesla=None, only: tuple[str, ...] = ()) -> Run:
        """t_s: n, not decreasing; the others n x 3 or None. A row of NaN is a missing sample.

        only: names of the arrays of Run to fill, all if empty; sigmas cost as much as the filter itself.
        """
        return self._batch("run", t_s, (rate_b_rad_s, force_b_m_s2, field_b_tesla), only, None)

    def smooth(self, t_s, rate_b_rad_s=None, force_b_m_s2=None, field_b_tesla=None, only: tuple[str, ...] = ()) -> Run:
        """As run, with hindsight; the filter is reset before and after."""
        return self._batch("smooth", t_s, (rate_b_rad_s, force_b_m_s2, field_b_tesla), only)

    def _batch(self, function: str, t_s, samples, only: tuple[str, ...], *more) -> Run:
        t = _doubles(t_s, np.shape(t_s)[:1], "t_s")
        n = len(t)
        inputs = [t]
        for name, values in zip(("rate_b_rad_s", "force_b_m_s2", "field_b_tesla"), samples):
            inputs.append(None if values is None else _doubles(values, (n, 3), name))
        run = empty_run(t)
        arrays_in = _RunInput(*(None if a is None else a.ctypes.data for a in inputs))
        names = [name for name, _ in _RunOutput._fields_]
        if unknown := set(only) - set(names):
            raise HnavValueError("option", f"only = {unknown.pop()}: choose from {', '.join(names)}")
        arrays_out = _RunOutput(*(getattr(run, name).ctypes.data if not only or name in only else None for name in names))
        self._call(function, n, C.byref(arrays_in), C.byref(arrays_out), *more)
        return run

    def _get(self, name: str, struct):
        value = struct()
        self._call(name, C.byref(value))
        return value

    def attitude(self) -> Attitude:
        return self._get("attitude", Attitude)

    def posterior(self) -> Posterior:
        return self._get("posterior", Posterior)

    def status(self) -> Status:
        return self._get("get_status", Status)

    def field(self) -> Field:
        return self._get("field", Field)

    def gyro_calibration(self) -> tuple[np.ndarray, np.ndarray]:
        """Scale and misalignment S, rate = (I - S) reading - bias, and the sigma of each element: 3 x 3."""
        matrix, sigma = (C.c_double * 9)(), (C.c_double * 9)()
        self._call("gyro_calibration", matrix, sigma)
        return np.array(matrix).reshape(3, 3), np.array(sigma).reshape(3, 3)

    def innovation(self, sensor: str) -> Innovation:
        value = Innovation()
        self._call("innovation", SENSORS.index(sensor), C.byref(value))
        return value

    def rate(self) -> np.ndarray:
        return np.array(self._get("rate", C.c_double * 3))

    def gyro_bias(self) -> tuple[np.ndarray, np.ndarray]:
        bias, sigma = (C.c_double * 3)(), (C.c_double * 3)()
        self._call("gyro_bias", bias, sigma)
        return np.array(bias), np.array(sigma)

    def covariance(self) -> np.ndarray:
        """6 x 6: rotation about the navigation axes in rad, gyro bias in rad/s."""
        return np.array(self._get("covariance", C.c_double * 36)).reshape(6, 6)

    def reset(self) -> None:
        self._call("reset")

    def realign(self) -> None:
        self._call("realign")

    # ----------------------------------------------------------------------------------------- hybrid view

    @property
    def nx(self) -> int:
        return self._get("nx", C.c_int32).value

    def get_x(self) -> np.ndarray:
        return np.array(self._get("get_x", C.c_double * self.nx))

    def nominal_x(self) -> np.ndarray:
        return np.array(self._get("nominal_x", C.c_double * self.nx))

    def derivative(self, t_s: float, x) -> np.ndarray:
        x, dx = _doubles(x, (self.nx,), "x"), np.empty(self.nx)
        self._call("derivative", t_s, x.ctypes.data, dx.ctypes.data)
        return dx

    def derivative_along(self, t_s: float, x, seed) -> np.ndarray:
        x, seed, out = _doubles(x, (self.nx,), "x"), _doubles(seed, (self.nx,), "seed"), np.empty(self.nx)
        self._call("derivative_along", t_s, x.ctypes.data, seed.ctypes.data, out.ctypes.data)
        return out

    def next_event_s(self) -> float:
        return self._get("next_event_s", C.c_double).value

    def jump(self, t_s: float, x_minus) -> np.ndarray:
        x_minus, x_plus = _doubles(x_minus, (self.nx,), "x_minus"), np.empty(self.nx)
        self._call("jump", t_s, x_minus.ctypes.data, x_plus.ctypes.data)
        return x_plus

    def show(self, t_s: float, x) -> None:
        x = _doubles(x, (self.nx,), "x")
        self._call("show", t_s, x.ctypes.data)
