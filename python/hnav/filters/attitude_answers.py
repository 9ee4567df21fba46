"""Outputs of the attitude filters only, and the arrays of a run."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from hnav.filters.filter_answers import HEALTH_SENSORS, SENSOR_STATES
from hnav.filters.options import Options
from hnav.filters.run_base import RunBase
from hnav.native.arrays import Array, BoolArray, ByteArray, Record, named
from hnav.native.library import enumerators

if TYPE_CHECKING:
    from hnav.filters.observability import RunObservability
    from hnav.io.recordings import Recording

VERDICTS = enumerators("hnav_field_gate", "HNAV_FIELD_")
"""Verdicts of the gate on a sample of the magnetic field."""


@dataclass(frozen=True, eq=False)
class Posterior(Record):
    """The estimate just after the newest sample that is not in the future of the last advance."""

    t_s: float
    """The time of the newest used sample."""
    q_nb: Array
    """4: unit quaternion, scalar first, body to navigation."""
    gyro_bias_rad_s: Array
    """3, body axes: bias of the gyroscope."""
    sigma: Array
    """6: standard deviations of the rotations about the three navigation axes in rad and of the three biases in rad/s."""
    near_singular: bool
    """Pitch is beyond 85 deg: roll and yaw are ill defined."""
    tilt_ready: bool
    """Roll and pitch are determined, see Attitude."""
    heading_ready: bool
    """The heading is determined, see Attitude."""


@dataclass(frozen=True, eq=False)
class Field(Record):
    """Estimates of the magnetic field and its sensor, just after the newest used sample."""

    strength_tesla: float
    """Strength of the reference field; NaN while there is none."""
    dip_rad: float
    """Dip of the reference field, positive when it points down; NaN while there is none."""
    latency_s: float
    """Estimated delay of the magnetometer behind its time stamps (ahrs)."""
    latency_sigma_s: float
    """Standard deviation of latency_s."""
    evidence_s: float
    """Time for which the reference field was measured; time at rest counts less (ahrs)."""
    heading_trust_s: float
    """The same time for the heading, kept when the reference changes (ahrs)."""
    reference_changes: int
    """Number of reference fields after the first one (ahrs)."""
    gate: Annotated[str, named(VERDICTS)]
    """Verdict on the last field: one of VERDICTS."""
    at_rest: bool
    """The filter detected that the body lies still (ahrs)."""


@dataclass(repr=False)
class Run(RunBase):
    """Arrays of a run of an attitude filter, one row for each instant; NaN before the start and where no sample was used."""

    t_s: Array
    """n: the instants."""
    q_nb: Array
    """n x 4: scalar first, body to navigation."""
    euler_rad: Array
    """n x 3: roll, pitch, yaw; rotation order z y x."""
    sigma_rad: Array
    """n x 3: standard deviation of the rotation error about the navigation axes; the third is heading."""
    gyro_bias_rad_s: Array
    """n x 3, body axes."""
    gyro_bias_sigma_rad_s: Array
    """n x 3."""
    accel_nis: Array
    """n: normalised innovation squared of the force, where one was used."""
    mag_nis: Array
    """n: of the field."""
    ready: BoolArray
    """n x 2: tilt, heading."""
    health: ByteArray
    """n x 3: gyro, accel, mag as places in SENSOR_STATES, 0 for ok; np.array(SENSOR_STATES)[run.health] are the words."""
    accepted: BoolArray | None = None
    """n x 2, force and field: a sample was used and its gate let it pass as it was; None where the run did not ask."""
    options: Options | None = None
    """Those of the filter."""
    us_per_sample: float = np.nan
    """Time of the filter for a row in microseconds, where the run is of a recording."""
    counts: dict[str, int] = field(default_factory=dict)
    """Samples used, gated, late, ... by name, likewise."""

    @property
    def heading_rad(self) -> Array:
        """n: true heading of body x, clockwise from north, in (-pi, pi], whatever the navigation frame."""
        yaw = self.euler_rad[:, 2]
        east_first = self.options is not None and self.options.navigation_frame == "enu"
        heading: Array = -np.remainder(np.pi - (np.pi / 2 - yaw if east_first else yaw), 2 * np.pi) + np.pi
        return heading

    def observability(self, recording: Recording | None = None) -> RunObservability:
        """Which errors of attitude and gyro bias the samples determine, by what and from when on; print(*found.sentences(), sep="\\n").

        recording: what the run was made of; without it the rests that the AHRS finds determine nothing. Raises HnavValueError for a run
        without an attitude.
        """
        from hnav.filters.attitude_observability import attitude_observability

        return attitude_observability(self, recording)

    def in_one_line(self) -> str:
        """Rows, length, last attitude."""
        from hnav.filters.run_summary import in_one_line

        return in_one_line(self)

    def _repr_html_(self) -> str:
        """What a notebook shows."""
        from hnav.filters.run_summary import as_html

        return as_html(self)

    def columns(self) -> dict[str, Any]:
        """Those of the table; those of health hold words."""
        import pandas as pd

        columns: dict[str, Any] = {}
        for name, axes in RUN_COLUMNS.items():
            values = getattr(self, name)
            columns |= {axes[0]: values} if len(axes) == 1 else {column: values[:, i] for i, column in enumerate(axes)}
        words = pd.CategoricalDtype(list(SENSOR_STATES))
        return columns | {name: pd.Categorical.from_codes(columns[name], dtype=words) for name in RUN_COLUMNS["health"]}


def of_axes(name: str, unit: str) -> tuple[str, ...]:
    """Names of the columns of three axes."""
    return tuple(f"{name}_{axis}_{unit}" for axis in "xyz")


# The arrays of a Run beside t_s that the library fills, and the columns of each.
RUN_COLUMNS = {
    "q_nb": ("q_w", "q_x", "q_y", "q_z"),
    "euler_rad": ("roll_rad", "pitch_rad", "yaw_rad"),
    "sigma_rad": of_axes("sigma", "rad"),
    "gyro_bias_rad_s": of_axes("gyro_bias", "rad_s"),
    "gyro_bias_sigma_rad_s": of_axes("gyro_bias_sigma", "rad_s"),
    "accel_nis": ("accel_nis",),
    "mag_nis": ("mag_nis",),
    "ready": ("tilt_ready", "heading_ready"),
    "health": tuple(f"{sensor}_health" for sensor in HEALTH_SENSORS),
}


def empty_run(t_s: Array) -> Run:
    """An empty Run of these instants: every sensor is missing."""
    n = len(t_s)
    arrays: dict[str, Any] = {name: np.full((n, len(axes)) if len(axes) > 1 else n, np.nan) for name, axes in RUN_COLUMNS.items()}
    ready = np.zeros((n, 2), bool)
    health = np.full((n, len(HEALTH_SENSORS)), SENSOR_STATES.index("missing"), np.uint8)
    return Run(t_s, **(arrays | {"ready": ready, "health": health}))
