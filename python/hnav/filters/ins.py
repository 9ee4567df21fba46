"""Position, velocity and attitude from inertial sensors and aids, aligned from any heading, by the C library.

    aids = hnav.Aids().velocity(fix_s, velocity_n, 0.1).position(fix_s, latitude_rad, longitude_rad, height_m, 2.0)
    run = hnav.Ins("industrial").run(t_s, rate, force, aids)        # n x 3 arrays in SI units
    run.place, run.velocity_n_m_s, run.heading_rad, run.ready
    run.to_dataframe()

    ins = hnav.Ins("industrial")                                     # or sample by sample
    ins.push_imu(t_s, rate, force)
    ins.push_velocity(fix_s, velocity_n, 0.1)
    ins.push_position(fix_s, latitude_rad, longitude_rad, height_m, 2.0)
    ins.advance(t_s)
    ins.navigation().euler_rad

n is north-east-down at the place of the body, b the body: the axes of the sensor turned by the option q_body_sensor. Quaternions
are Hamilton's, scalar first, body to n. Heights are above the ellipsoid of WGS 84. Filters of different threads run in
parallel; one filter serves one thread at a time.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any, ParamSpec

import numpy as np
import numpy.typing as npt

from hnav.errors import HnavValueError
from hnav.filters.hybrid_view import HybridView
from hnav.native.arrays import Array, BoolArray, ByteArray, Counted, Named, Record, address, doubles, times
from hnav.native.library import continued, enumerators, ffi, new
from hnav.native.options import OptionInfo, OptionSet, complete, option_rows

if TYPE_CHECKING:
    import pandas as pd

    from hnav.io.recordings import Recording

INS_PRESETS = enumerators("hnav_ins_preset", "HNAV_INS_")
"""Grades of inertial sensors: consumer, industrial, tactical, navigation."""

INS_SENSORS = enumerators("hnav_ins_sensor", "HNAV_INS_")[:-1]
"""What samples are of: imu, and the aids rest, speed, pressure, velocity, position, heading."""

PHASES = enumerators("hnav_ins_phase", "HNAV_INS_PHASE_")
"""Where the filter stands: waiting, levelling, any_heading, navigating; InsRun.phase counts them from 0."""

READY = ("tilt", "heading", "velocity", "position")
"""The columns of InsRun.ready."""

# --------------------------------------------------------------------------------------------- options


def ins_option_table() -> Mapping[str, OptionInfo]:
    """The options by name, in the library's order: unit, range, meaning."""
    return option_rows("ins")


class InsOptions(OptionSet):
    """Options of the navigation filter, as attributes; ins_option_table() tells unit, range and meaning of each.

        InsOptions("industrial", car_across_m_s=0.1)

    preset: one of INS_PRESETS. values: options that differ from it. Raises HnavValueError for presets, names
    (UnknownOptionError) and values that do not exist.
    """

    def __init__(self, preset: str = "consumer", **values: object):
        if preset not in INS_PRESETS:
            raise HnavValueError("option", f"preset = {preset}: choose one of {', '.join(INS_PRESETS)}", "preset")
        self.__dict__["_preset"] = preset
        super().__init__("ins", INS_PRESETS.index(preset), values)

    @property
    def filter(self) -> str:
        """The filter that the options are of."""
        return str(self._options)

    @property
    def preset(self) -> str:
        """The preset that the options started from."""
        return str(self._preset)

    def _arguments(self) -> tuple[str, ...]:
        return (self.preset,)


# --------------------------------------------------------------------------------------------- results


@dataclass(frozen=True, eq=False)
class Navigation(Record):
    """The estimate at the time of the last advance; numbers are NaN before there is a tilt. While the heading is unknown they are
    those of the likeliest heading."""

    t_s: float
    """The time of the last advance."""
    latitude_rad: float
    """Of the body."""
    longitude_rad: float
    """Of the body."""
    height_m: float
    """Above the ellipsoid."""
    velocity_n_m_s: Array
    """3: north, east, down."""
    q_nb: Array
    """4: body to north-east-down, scalar first."""
    euler_rad: Array
    """3: roll, pitch, yaw; yaw is the true heading of body x."""
    position_e_m: Array
    """3: Earth-centred, Earth-fixed."""
    velocity_e_m_s: Array
    """3: in the same axes."""
    gyro_bias_rad_s: Array
    """3, body axes."""
    accel_bias_m_s2: Array
    """3, body axes."""
    sigma_position_m: Array
    """3: north, east, down."""
    sigma_velocity_m_s: Array
    """3: north, east, down."""
    sigma_rotation_rad: Array
    """3: about north, east, down; the third is heading, its spread over the whole circle."""
    sigma_gyro_bias_rad_s: Array
    """3."""
    sigma_accel_bias_m_s2: Array
    """3."""
    heading_second_rad: float
    """The strongest other heading."""
    heading_second_share: float
    """Its probability; 0: there is none."""
    latency_s: float
    """Of the satellites behind their stamps."""
    sigma_latency_s: float
    """Its standard deviation."""
    phase: Annotated[str, Named(PHASES)]
    """One of PHASES."""
    tilt_ready: bool
    """Known: a small sigma that was earned from samples."""
    heading_ready: bool
    """Likewise."""
    velocity_ready: bool
    """Likewise."""
    position_ready: bool
    """Likewise."""
    at_rest: bool
    """The body stands."""
    gyro_scale: Array
    """3, body axes: how much more than the rate each gyroscope shows, in parts of it."""
    sigma_gyro_scale: Array
    """3."""


@dataclass(frozen=True, eq=False)
class Observed(Record):
    """Nats gained about the heading since the start, by what brought them: half the logarithm of the ratio of variances."""

    by_rest: float
    """By standing still: the rate of the Earth."""
    by_speed: float
    """By wheels."""
    by_pressure: float
    """By heights."""
    by_velocity: float
    """By velocities of the satellites."""
    by_position: float
    """By their positions."""
    by_heading: float
    """By a heading aid."""
    by_field: float
    """By a magnetometer."""


@dataclass(frozen=True, eq=False)
class InsInnovation(Record):
    """What the last used sample of an aid said."""

    t_s: float
    """The time of that sample."""
    value: Array
    """3, of which the first `dimension` count: measured minus expected."""
    variance: Array
    """3: of each."""
    nis: float
    """Normalised innovation squared: about `dimension` on average when model and noise are right."""
    noise_scale: float
    """Above 1: the gate inflated the noise."""
    dimension: int
    """1 to 3."""


@dataclass(frozen=True, eq=False)
class InsDiagnostics(Record):
    """Counts since the start."""

    newest_sample_s: float
    """Time of the newest used sample; NaN if there was none."""
    mean_nis: float
    """Over dimension, of the last satellites and rests; above 1 the sigmas are too small."""
    gyro_vibration_rad_s: float
    """Root mean square of the rate between neighbouring samples."""
    accel_vibration_m_s2: float
    """Of the force."""
    used: Annotated[dict[str, int], Counted(INS_SENSORS)]
    """Samples used, by sensor."""
    inflated: Annotated[dict[str, int], Counted(INS_SENSORS)]
    """Of those, with inflated noise, or left out: while the heading is not known, or as another field."""
    late: int
    """Samples refused: older than the committed estimate."""
    non_finite: int
    """Samples refused for their numbers."""
    times_lost: int
    """The start or the search for the heading began anew."""
    corrections: int
    """Jumps of the estimate."""
    solver_rhs_evals: int
    """Evaluations of the differential equation by the solver."""
    solver_steps: int
    """Steps of the solver."""


@dataclass(repr=False)
class InsRun:
    """Arrays of a batch run, one row for each instant; NaN before there is a tilt."""

    t_s: Array
    """n: the instants."""
    place: Array
    """n x 3: latitude, longitude in rad, height in m above the ellipsoid."""
    velocity_n_m_s: Array
    """n x 3: north, east, down."""
    q_nb: Array
    """n x 4: body to north-east-down, scalar first."""
    sigma_position_m: Array
    """n x 3: north, east, down."""
    sigma_velocity_m_s: Array
    """n x 3: north, east, down."""
    sigma_rotation_rad: Array
    """n x 3: about north, east, down; the third is heading, its spread over the whole circle."""
    gyro_bias_rad_s: Array
    """n x 3, body axes."""
    accel_bias_m_s2: Array
    """n x 3, body axes."""
    heading_second: Array
    """n x 2: the strongest other heading in rad and its probability."""
    phase: ByteArray
    """n: places in PHASES."""
    ready: BoolArray
    """n x 4: tilt, heading, velocity, position."""
    at_rest: BoolArray
    """n: the body stands."""
    options: InsOptions | None = field(default=None, kw_only=True)
    """Those of the filter."""

    @property
    def euler_rad(self) -> Array:
        """n x 3: roll, pitch, yaw."""
        from hnav.rotations import euler_rad

        return euler_rad(self.q_nb)

    @property
    def heading_rad(self) -> Array:
        """n: true heading of body x, clockwise from north, in (-pi, pi]."""
        heading: Array = self.euler_rad[:, 2]
        return heading

    def __repr__(self) -> str:
        n = len(self.t_s)
        if n == 0:
            return "<InsRun: no rows>"
        last = np.degrees(self.heading_rad[-1]) % 360
        known = [name for name, flag in zip(READY, self.ready[-1]) if flag]
        return (
            f"<InsRun: {n} rows in {self.t_s[-1] - self.t_s[0]:.6g} s, {PHASES[self.phase[-1]]}, last heading {last:.1f} deg, "
            f"ready: {', '.join(known) or 'nothing'}>"
        )

    def to_dataframe(self) -> pd.DataFrame:
        """The run as a table of pandas, indexed by t_s: a column for each component, its unit at the end of its name."""
        import pandas as pd

        return pd.DataFrame(ins_columns(self), index=pd.Index(self.t_s, name="t_s"))


_AXES = ("north", "east", "down")
_COLUMNS = {
    "place": ("latitude_rad", "longitude_rad", "height_m"),
    "velocity_n_m_s": tuple(f"velocity_{axis}_m_s" for axis in _AXES),
    "q_nb": ("q_w", "q_x", "q_y", "q_z"),
    "euler_rad": ("roll_rad", "pitch_rad", "yaw_rad"),
    "sigma_position_m": tuple(f"sigma_{axis}_m" for axis in _AXES),
    "sigma_velocity_m_s": tuple(f"sigma_velocity_{axis}_m_s" for axis in _AXES),
    "sigma_rotation_rad": ("sigma_about_north_rad", "sigma_about_east_rad", "sigma_heading_rad"),
    "gyro_bias_rad_s": tuple(f"gyro_bias_{axis}_rad_s" for axis in "xyz"),
    "accel_bias_m_s2": tuple(f"accel_bias_{axis}_m_s2" for axis in "xyz"),
    "heading_second": ("heading_second_rad", "heading_second_share"),
    "ready": tuple(f"{name}_ready" for name in READY),
}


def ins_columns(run: InsRun) -> dict[str, np.ndarray]:
    """The columns of a run by name, each n long; phase as a word."""
    columns = {name: getattr(run, array)[:, i] for array, names in _COLUMNS.items() for i, name in enumerate(names)}
    return {**columns, "phase": np.array(PHASES)[run.phase], "at_rest": run.at_rest}


_OUTPUTS = {
    "t_s": (), "place": (3,), "velocity_n_m_s": (3,), "q_nb": (4,), "sigma_position_m": (3,), "sigma_velocity_m_s": (3,),
    "sigma_rotation_rad": (3,), "gyro_bias_rad_s": (3,), "accel_bias_m_s2": (3,), "heading_second": (2,),
    "phase": (), "ready": (4,), "at_rest": (),
}  # fmt: skip
_BYTES = {"phase": np.uint8, "ready": bool, "at_rest": bool}


# --------------------------------------------------------------------------------------------- aids


@dataclass
class Aids:
    """Samples of aids for Ins.run, from any number of sources. Each call adds m samples and answers the same object.

    t_s is the time of validity; received_s, where it differs, the time at which the filter is given the sample: the option
    horizon_s has to be at least their difference. Rows with a NaN are left out, but for a missing vertical velocity. A
    sigma is a number, or one for each row, or one for each row and axis.
    """

    _parts: list[tuple[Array, Array, int, Array]] = field(default_factory=list)
    """What was added, call by call: times of validity and of arrival, sensor, values."""

    def position(
        self, t_s: npt.ArrayLike, latitude_rad: npt.ArrayLike, longitude_rad: npt.ArrayLike, height_m: npt.ArrayLike,
        sigma_n_m: npt.ArrayLike, received_s: npt.ArrayLike | None = None,
    ) -> Aids:  # fmt: skip
        """Places: m each; sigma north, east, down."""
        place = np.stack(np.broadcast_arrays(*(times(np.atleast_1d(v)) for v in (latitude_rad, longitude_rad, height_m))), 1)
        return self._add("position", t_s, place, sigma_n_m, received_s)

    def velocity(
        self,
        t_s: npt.ArrayLike,
        velocity_n_m_s: npt.ArrayLike,
        sigma_n_m_s: npt.ArrayLike,
        received_s: npt.ArrayLike | None = None,
    ) -> Aids:
        """Velocities: m x 3, north, east, down, the last NaN where it is not known; sigma likewise."""
        return self._add("velocity", t_s, np.asarray(velocity_n_m_s, float), sigma_n_m_s, received_s)

    def pressure(
        self, t_s: npt.ArrayLike, pressure_pa: npt.ArrayLike, sigma_pa: npt.ArrayLike, received_s: npt.ArrayLike | None = None
    ) -> Aids:
        """Pressures of the air: m."""
        return self._add("pressure", t_s, np.asarray(pressure_pa, float), sigma_pa, received_s)

    def speed(
        self, t_s: npt.ArrayLike, speed_m_s: npt.ArrayLike, sigma_m_s: npt.ArrayLike, received_s: npt.ArrayLike | None = None
    ) -> Aids:
        """Speeds along body x: m."""
        return self._add("speed", t_s, np.asarray(speed_m_s, float), sigma_m_s, received_s)

    def heading(
        self, t_s: npt.ArrayLike, heading_rad: npt.ArrayLike, sigma_rad: npt.ArrayLike, received_s: npt.ArrayLike | None = None
    ) -> Aids:
        """Headings of body x: m."""
        return self._add("heading", t_s, np.asarray(heading_rad, float), sigma_rad, received_s)

    def mag(self, t_s: npt.ArrayLike, field_b: npt.ArrayLike, received_s: npt.ArrayLike | None = None) -> Aids:
        """Fields of a magnetometer: m x 3, any unit, in sensor axes; those of zero are left out."""
        field = np.atleast_2d(np.asarray(field_b, float))
        field = np.where((field == 0).all(axis=-1, keepdims=True), np.nan, field)
        return self._add("mag", t_s, field, None, received_s)

    def rest(self, t_s: npt.ArrayLike, sigma_m_s: npt.ArrayLike, received_s: npt.ArrayLike | None = None) -> Aids:
        """Instants at which the body is known to stand: m; sigma of its velocity."""
        return self._add("rest", t_s, np.empty((len(np.atleast_1d(np.asarray(t_s))), 0)), sigma_m_s, received_s)

    def arrays(self) -> tuple[Array, Array, npt.NDArray[np.int32], Array]:
        """Times of validity (m), times of arrival (m), places in INS_SENSORS (m), values (m x 6); in the order of arrival."""
        if not self._parts:
            return np.empty(0), np.empty(0), np.empty(0, np.int32), np.empty((0, 6))
        t, received, value = (np.concatenate([part[i] for part in self._parts]) for i in (0, 1, 3))
        sensor = np.concatenate([np.full(len(part[0]), part[2], np.int32) for part in self._parts])
        order = np.argsort(received, kind="stable")
        return t[order], received[order], sensor[order], np.ascontiguousarray(value[order])

    def _add(
        self, sensor: str, t_s: npt.ArrayLike, values: np.ndarray, sigma: npt.ArrayLike | None, received_s: npt.ArrayLike | None
    ) -> Aids:
        t = times(np.atleast_1d(np.asarray(t_s, float)))
        read = values.reshape(len(t), -1) if values.size == len(t) * (values.size // max(1, len(t))) else values
        if read.ndim != 2 or len(read) != len(t):
            raise HnavValueError(
                "size", f"{sensor} has the shape {values.shape}, expected one row for each of {len(t)} times", sensor
            )
        width = 0 if sigma is None else max(1, read.shape[1])
        sigmas = np.asarray(0.0 if sigma is None else sigma, float)
        sigmas = np.broadcast_to(sigmas[:, None] if sigmas.shape == (len(t),) else sigmas, (len(t), width))
        table = np.zeros((len(t), 6))
        table[:, : read.shape[1]] = read
        table[:, read.shape[1] : read.shape[1] + width] = sigmas
        needed = [0, 1, 3, 4] if sensor == "velocity" else range(read.shape[1] + width)
        received = t if received_s is None else times(np.atleast_1d(np.asarray(received_s, float)))
        if received.shape != t.shape:
            raise HnavValueError("size", f"received_s has the shape {received.shape}, expected {t.shape}", "received_s")
        whole = np.isfinite(table[:, list(needed)]).all(axis=1) & np.isfinite(t) & np.isfinite(received)
        self._parts.append((t[whole], received[whole], INS_SENSORS.index(sensor), table[whole]))
        return self


# --------------------------------------------------------------------------------------------- the filter

_Arguments = ParamSpec("_Arguments")


def _with_arguments_of(run: Callable[_Arguments, InsRun]) -> Callable[[Callable[..., InsRun]], Callable[_Arguments, InsRun]]:
    """A method that takes what another one does, and shows it: the arguments are stated once."""

    def shown(method: Callable[..., InsRun]) -> Callable[_Arguments, InsRun]:
        known = inspect.signature(run)
        kept = [one for name, one in known.parameters.items() if name != method.__name__]
        method.__signature__ = known.replace(parameters=kept)  # type: ignore[attr-defined]
        return method

    return shown


class Ins(HybridView):
    """The navigation filter.

        Ins("industrial", car_across_m_s=0.1)
        Ins(InsOptions("industrial"))

    options: a preset, with values as of InsOptions, or InsOptions. Raises HnavValueError for options that are impossible,
    HnavRuntimeError when there is no memory. Samples are pushed with their times of validity, in any order within one
    instant and between two calls of advance, and up to the option horizon_s late. Every call that fails leaves the
    estimate as it was. Filters are copied and pickled with their state.
    """

    KIND = "ins"

    def __init__(self, options: InsOptions | str = "consumer", **values: object):
        self._options = InsOptions(options, **values) if isinstance(options, str) else complete(InsOptions, options, values)
        super().__init__("hnav_ins_create", self._options.struct)

    @property
    def options(self) -> InsOptions:
        """A copy of the options that the filter was made with."""
        return copy(self._options)

    def __repr__(self) -> str:
        return f"Ins({self._options!r})"

    def __reduce__(self) -> tuple[Any, ...]:
        return continued, (Ins, (self._options,), self.save())

    def push_imu(self, t_s: float, rate_b_rad_s: npt.ArrayLike, force_b_m_s2: npt.ArrayLike) -> None:
        """Rate and force of one instant: 3 each, in sensor axes. Raises HnavValueError for numbers that are not finite,
        HnavRuntimeError for late samples and a full queue; the other push calls likewise."""
        rate, force = doubles(rate_b_rad_s, (3,), "rate_b_rad_s"), doubles(force_b_m_s2, (3,), "force_b_m_s2")
        self._call("push_imu", t_s, address(rate), address(force))

    def push_position(
        self, t_s: float, latitude_rad: float, longitude_rad: float, height_m: float, sigma_n_m: npt.ArrayLike
    ) -> None:
        """A place; sigma_n_m: a number, or 3 for north, east, down."""
        self._call("push_position", t_s, latitude_rad, longitude_rad, height_m, address(_three(sigma_n_m)))

    def push_velocity(self, t_s: float, velocity_n_m_s: npt.ArrayLike, sigma_n_m_s: npt.ArrayLike) -> None:
        """Velocity north, east, down (3; down NaN when it is not known); sigma_n_m_s: a number, or 3."""
        velocity = doubles(velocity_n_m_s, (3,), "velocity_n_m_s")
        self._call("push_velocity", t_s, address(velocity), address(_three(sigma_n_m_s)))

    def push_pressure(self, t_s: float, pressure_pa: float, sigma_pa: float) -> None:
        """Pressure of the air."""
        self._call("push_pressure", t_s, pressure_pa, sigma_pa)

    def push_speed(self, t_s: float, speed_m_s: float, sigma_m_s: float) -> None:
        """Speed along body x, by wheels; used once the heading is found."""
        self._call("push_speed", t_s, speed_m_s, sigma_m_s)

    def push_rest(self, t_s: float, sigma_m_s: float) -> None:
        """The body is known to stand; sigma_m_s is of its velocity."""
        self._call("push_rest", t_s, sigma_m_s)

    def push_heading(self, t_s: float, heading_rad: float, sigma_rad: float) -> None:
        """Heading of body x, clockwise from north; the option declination_rad is added."""
        self._call("push_heading", t_s, heading_rad, sigma_rad)

    def push_mag(self, t_s: float, field_b: npt.ArrayLike) -> None:
        """Field of a magnetometer (3), any unit, in sensor axes; tells of the heading alone, iron in the body is estimated."""
        self._call("push_mag", t_s, address(doubles(field_b, (3,), "field_b")))

    def advance(self, t_s: float) -> None:
        """Uses the samples up to t_s and shows the estimate at t_s.

        The same samples give the same bits whatever times are asked for. Raises HnavRuntimeError for a time before that of
        the last advance, and when samples led to no usable estimate: those were dropped, the others used.
        """
        self._call("advance", t_s)

    def run(
        self,
        t_s: npt.ArrayLike,
        rate_b_rad_s: npt.ArrayLike,
        force_b_m_s2: npt.ArrayLike,
        aids: Aids | None = None,
        every: int = 1,
        smooth: bool = False,
    ) -> InsRun:
        """A whole recording, bit for bit as sample by sample.

        t_s: n, not decreasing; rate and force n x 3 in sensor axes, NaN for a missing sample. every: a row of the result for
        each so many rows, the last of them. Aids that came after the last row are not used. A run goes on from where the
        filter stands: reset it before it takes another recording. smooth: with hindsight, as the method smooth tells. Raises
        HnavValueError for arrays of other shapes, HnavRuntimeError naming the row where the filter cannot go on.
        """
        if every < 1:
            raise HnavValueError("option", f"every = {every}: it is at least 1", "every")
        t = times(t_s)
        rate, force = doubles(rate_b_rad_s, (len(t), 3), "rate_b_rad_s"), doubles(force_b_m_s2, (len(t), 3), "force_b_m_s2")
        valid, received, sensor, value = (aids or Aids()).arrays()
        rows = len(t) // every
        arrays: dict[str, Any] = {name: np.empty((rows, *axes), _BYTES.get(name, float)) for name, axes in _OUTPUTS.items()}
        run = InsRun(**arrays)
        given = new(
            "hnav_ins_run_input", t_s=address(t), rate_b_rad_s=address(rate), force_b_m_s2=address(force), aids=len(valid),
            aid_t_s=address(valid), aid_received_s=address(received), aid_sensor=ffi.from_buffer("int32_t[]", sensor),
            aid_value=address(value),
        )  # fmt: skip
        wanted = new("hnav_ins_run_output", every=every, **{name: address(getattr(run, name)) for name in _OUTPUTS})
        if smooth:
            self._call("smooth", len(t), given, wanted)
        else:
            self._call("run", len(t), given, wanted, ffi.NULL)
        run.options = self.options
        return run

    @_with_arguments_of(run)
    def smooth(self, *samples: Any, **named: Any) -> InsRun:
        """The same with hindsight: every row from all samples, before it and after it, by a filter with the options of this one,
        which stays as it is. It takes the arguments of run.

        Aids act at their times of validity, however late they came. Rows from before the heading was found are navigation too, from
        the first sample on; where nothing later tells it they are those of run, and so is the last row. Takes some ten times as long
        as run. Raises as run does, and HnavRuntimeError when there is no memory.
        """
        return self.run(*samples, **(named | {"smooth": True}))

    def run_recording(self, recording: Recording, every: int = 1, smooth: bool = False) -> InsRun:
        """A recording with its satellites, pressure and wheels, by a filter with the options of this one, which stays as it is.

        every: as of run. smooth: with hindsight, as by smooth. Late samples are waited for, whatever horizon_s is; where gyroscope
        and accelerometer have times of their own, the force is interpolated. Raises HnavError.
        """
        from hnav.filters.ins_recording import run_recording  # it knows this filter

        return run_recording(recording, self._options, every, smooth)

    def navigation(self) -> Navigation:
        """The estimate at the time of the last advance."""
        return Navigation.read(self._filled("hnav_navigation", "navigation"))

    def covariance(self) -> Array:
        """15 x 15: of position, velocity (north, east, down), rotation about them, gyro bias, accelerometer bias. Raises
        HnavRuntimeError before there is a tilt."""
        matrix = np.empty((15, 15))
        self._call("covariance", address(matrix))
        return matrix

    def observed(self) -> Observed:
        """What has told the heading, and how much."""
        return Observed.read(self._filled("hnav_observed", "observed"))

    def innovation(self, sensor: str) -> InsInnovation:
        """What the last used sample of an aid said; sensor: one of INS_SENSORS but imu.

        Raises HnavValueError for other sensors, HnavRuntimeError when none of its samples has been used yet.
        """
        if sensor not in INS_SENSORS[1:]:
            raise HnavValueError("option", f"sensor = {sensor}: choose one of {', '.join(INS_SENSORS[1:])}", "sensor")
        return InsInnovation.read(self._filled("hnav_ins_innovation", "last_innovation", INS_SENSORS.index(sensor)))

    def diagnostics(self) -> InsDiagnostics:
        """Counts of samples and corrections."""
        return InsDiagnostics.read(self._filled("hnav_ins_diagnostics", "get_diagnostics"))


def _three(sigma: npt.ArrayLike) -> Array:
    return doubles(np.broadcast_to(np.asarray(sigma, float), (3,)), (3,), "sigma")
