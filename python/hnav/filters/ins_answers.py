"""Outputs of the navigation filter: the estimate, the sources of its heading, and the arrays of a run."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from hnav.filters.options import Options
from hnav.filters.run_base import RunBase
from hnav.native.arrays import Array, BoolArray, ByteArray, Record, named
from hnav.native.library import enumerators

if TYPE_CHECKING:
    from hnav.filters.ins_aids import Aids
    from hnav.filters.observability import RunObservability

PHASES = enumerators("hnav_ins_phase", "HNAV_INS_PHASE_")
"""Where the filter stands: waiting, levelling, any_heading, navigating; InsRun.phase counts them from 0."""

READY = ("tilt", "heading", "velocity", "position")
"""The columns of InsRun.ready."""


@dataclass(frozen=True, eq=False)
class Navigation(Record):
    """The estimate at the time of the last advance; numbers are NaN before the tilt is initialised. While several headings
    are possible they are those of the most probable one."""

    t_s: float
    """The time of the last advance."""
    latitude_rad: float
    """Geodetic latitude of the body."""
    longitude_rad: float
    """Longitude of the body."""
    height_m: float
    """Height of the body above the ellipsoid."""
    velocity_n_m_s: Array
    """3: velocity north, east, down."""
    q_nb: Array
    """4: attitude, body to north-east-down, scalar first."""
    euler_rad: Array
    """3: roll, pitch, yaw; yaw is the true heading of body x."""
    position_e_m: Array
    """3: position in Earth-centred, Earth-fixed axes."""
    velocity_e_m_s: Array
    """3: velocity in Earth-centred, Earth-fixed axes."""
    gyro_bias_rad_s: Array
    """3, body axes: bias of the gyroscopes."""
    accel_bias_m_s2: Array
    """3, body axes: bias of the accelerometers."""
    sigma_position_m: Array
    """3: standard deviation of the position north, east, down."""
    sigma_velocity_m_s: Array
    """3: of the velocity north, east, down."""
    sigma_rotation_rad: Array
    """3: of the rotation about north, east, down; the third is the spread of the heading over the whole circle."""
    sigma_gyro_bias_rad_s: Array
    """3, body axes: of the gyroscope bias."""
    sigma_accel_bias_m_s2: Array
    """3, body axes: of the accelerometer bias."""
    heading_second_rad: float
    """The heading of the second most probable hypothesis."""
    heading_second_share: float
    """The probability of that hypothesis; 0 if there is none."""
    latency_s: float
    """Estimated delay of the satellite fixes behind their time stamps."""
    sigma_latency_s: float
    """Standard deviation of latency_s."""
    phase: Annotated[str, named(PHASES)]
    """One of PHASES."""
    tilt_ready: bool
    """Roll and pitch are determined: the filter reached a small sigma by samples, not by its start."""
    heading_ready: bool
    """The heading is determined, likewise."""
    velocity_ready: bool
    """The velocity is determined, likewise."""
    position_ready: bool
    """The position is determined, likewise."""
    at_rest: bool
    """The filter detected that the body stands."""
    gyro_scale: Array
    """3, body axes: scale error of each gyroscope, (shown - true) / true."""
    sigma_gyro_scale: Array
    """3: standard deviation of gyro_scale."""
    protection_m: Array
    """2: bounds that the horizontal and the vertical error of the position exceed for less than 1e-3 of the time."""
    protection_heading_rad: float
    """Bound that the heading error exceeds for less than 1e-3 of the time."""


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
class InsSamples:
    """The samples that a run of the INS used."""

    rate_b_rad_s: Array
    """n x 3, sensor axes, n a multiple of the rows of the run or somewhat more."""
    force_b_m_s2: Array
    """n x 3, likewise."""
    aids: Aids
    """All of them."""

    @classmethod
    def joined(cls, parts: list[InsSamples]) -> InsSamples:
        """Of a recording in pieces."""
        rate, force = (np.concatenate([getattr(part, name) for part in parts]) for name in ("rate_b_rad_s", "force_b_m_s2"))
        return cls(rate, force, parts[0].aids.and_those_of([part.aids for part in parts[1:]]))


@dataclass(repr=False)
class InsRun(RunBase):
    """Arrays of a run of the INS, one row for each instant; NaN before there is a tilt."""

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
    protection_m: Array
    """n x 2: bounds that the horizontal and the vertical error of the position exceed for less than 1e-3 of the time."""
    protection_heading_rad: Array
    """n: that of the heading."""
    phase: ByteArray
    """n: places in PHASES."""
    ready: BoolArray
    """n x 4: tilt, heading, velocity, position."""
    at_rest: BoolArray
    """n: the body stands."""
    options: Options | None = field(default=None, kw_only=True)
    """Those of the filter."""
    smoothed: bool = field(default=False, kw_only=True)
    """Every row is estimated from all samples, earlier and later."""
    samples: InsSamples | None = field(default=None, kw_only=True)
    """The samples that the filter got."""

    def observability(self) -> RunObservability:
        """Which errors of attitude and biases the samples determine, by what and from when on; print(*found.sentences(), sep="\\n").

        Raises HnavValueError for a run without an attitude, or without its samples.
        """
        from hnav.filters.ins_observability import ins_observability

        return ins_observability(self)

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

    def in_one_line(self) -> str:
        """Rows, length, phase, last heading, what is ready."""
        if not len(self.t_s):
            return "no rows"
        last = np.degrees(self.heading_rad[-1]) % 360
        known = [name for name, flag in zip(READY, self.ready[-1]) if flag]
        return f"{self.size_in_words()}, {PHASES[self.phase[-1]]}, last heading {last:.1f} deg, ready: {', '.join(known) or 'nothing'}"

    def columns(self) -> dict[str, np.ndarray]:
        """Those of the table; phase as a word."""
        columns = {name: getattr(self, array)[:, i] for array, names in _COLUMNS.items() for i, name in enumerate(names)}
        columns["protection_heading_rad"] = self.protection_heading_rad
        return {**columns, "phase": np.array(PHASES)[self.phase], "at_rest": self.at_rest}


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
    "protection_m": ("protection_horizontal_m", "protection_vertical_m"),
    "ready": tuple(f"{name}_ready" for name in READY),
}


# The arrays of an InsRun, which the library fills, and the axes of each beside its rows.
INS_RUN_ARRAYS: dict[str, tuple[int, ...]]
INS_RUN_ARRAYS = {name: (len(columns),) for name, columns in _COLUMNS.items() if name != "euler_rad"}
INS_RUN_ARRAYS |= dict.fromkeys(("t_s", "protection_heading_rad", "phase", "at_rest"), ())
_BYTES = {"phase": np.uint8, "ready": bool, "at_rest": bool}


def unfilled_run(rows: int) -> InsRun:
    """A run of so many rows, before the library has written them."""
    arrays: dict[str, Any] = {name: np.empty((rows, *axes), _BYTES.get(name, float)) for name, axes in INS_RUN_ARRAYS.items()}
    return InsRun(**arrays)
