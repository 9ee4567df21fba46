"""Outputs of every filter: attitude, innovations, counters, and the states of its sensors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from hnav.native.arrays import Array, Record, counted, each, letters, named, shaped
from hnav.native.library import SENSORS, enumerators

SENSOR_STATES = enumerators("hnav_sensor_state", "HNAV_SENSOR_STATE_")
"""States of a sensor: ok, late, outlier, stuck, saturated, missing; Run.health holds their places from 0."""

HEALTH_SENSORS = SENSORS[:3]
"""The sensors of the columns of Run.health: gyro, accel, mag."""


@dataclass(frozen=True, eq=False)
class Attitude(Record):
    """The estimate at the time of the last advance."""

    t_s: float
    """The time of the last advance."""
    q_nb: Array
    """4: unit quaternion, scalar first, body to navigation."""
    euler_rad: Array
    """3: roll, pitch, yaw of the body in navigation axes; rotation order z y x."""
    heading_rad: float
    """True heading of body x, clockwise from north, in (-pi, pi], whatever the navigation frame."""
    sigma_rad: Array
    """3: standard deviation of the rotation error about the navigation axes; the third is heading."""
    near_singular: bool
    """Pitch is beyond 85 deg: roll and yaw are ill defined."""
    tilt_ready: bool
    """Roll and pitch are determined: the filter reached a small sigma by samples, not by its start."""
    heading_ready: bool
    """The heading is determined, likewise."""


@dataclass(frozen=True, eq=False)
class Innovation(Record):
    """The innovation of the last used sample of a sensor."""

    t_s: float
    """The time of that sample."""
    value: Array
    """3, of which the first `dimension` count: measured minus expected. Force and field are in units of gravity and of the
    reference strength, heading in rad; of the AHRS, force: minus the velocity in m/s, north and east, and the field is in
    navigation axes; of the INS m, m/s and rad, north, east, down."""
    S: Annotated[Array, shaped(3, 3)]
    """3 x 3, of which `dimension` rows and columns count: its covariance, with the noise of the options; of the INS
    the diagonal."""
    nis: float
    """value' S^-1 value: about `dimension` on average when model and noise are right."""
    noise_scale: float
    """Noise that was used over that of the options: 1 unless the gate inflated it, infinite when it rejected the sample."""
    dimension: int
    """3; 1 for heading; 2 for the force of the AHRS; 1 to 3 of the INS."""
    accepted: bool
    """Whether the gate let the sample pass as it was."""


@dataclass(frozen=True, eq=False)
class Diagnostics(Record):
    """Counts since the start, and figures of the last correction."""

    gamma_used: float
    """Of the last correction; infinite when the robust law is off."""
    gamma_margin: float
    """1 - lmax(L P L') / gamma^2: 1 when off, always above 0."""
    adapted_bias_walk_rad_s_per_sqrt_s: float
    """Root of the mean of the diagonal of Q on the bias."""
    newest_sample_s: float
    """Time of the newest used sample; NaN if there was none."""
    used: Annotated[dict[str, int], counted(SENSORS)]
    """Samples used, by sensor."""
    gated: Annotated[dict[str, int], counted(SENSORS)]
    """Of those, with inflated noise; of the INS or left out: while the heading is not known, or as another field."""
    late: int
    """Samples refused: older than the committed estimate."""
    non_finite: int
    """Samples refused: NaN, infinite, beyond 1e6 in any unit."""
    zero: int
    """Samples refused: zero vectors."""
    corrections: int
    """Jumps of the estimate; samples of one instant are corrected together."""
    gamma_raised: int
    """Corrections whose gamma was infeasible and had to be raised."""
    covariance_repaired: int
    """Covariances that were no longer positive definite after the integration, and were repaired."""
    solver_rhs_evals: int
    """Evaluations of the differential equation by the solver."""
    solver_steps: int
    """Steps of the solver."""
    started: bool
    """The attitude is initialised."""
    waiting: int
    """Instants in the queue that are still in the future of the last advance."""
    decay_rate_1_s: float
    """Decay rate of the error over the last flow and correction of the HREKF (Theorem 1 of its paper, sampled); 0
    before the first correction, and of the AHRS."""
    mean_nis: float
    """Over dimension, of the last satellites and rests of the INS; above 1 the sigmas are too small."""
    gyro_vibration_rad_s: float
    """Root mean square of the rate between neighbouring samples (INS)."""
    accel_vibration_m_s2: float
    """Of the force (INS)."""


@dataclass(frozen=True, eq=False)
class SensorHealth(Record):
    """The state of a sensor at the time of the last advance, and the number of its rejected samples.

    Samples that are stuck, saturated or outliers are left out; those of a gyroscope are used, outliers apart, because nothing
    better is known, and the sigma of the attitude grows by what they may have missed.
    """

    state: Annotated[str, named(SENSOR_STATES)]
    """ok; late: within the last second a sample was refused as older than the committed estimate; outlier: within the last
    second one lay far from those beside it; stuck: an axis repeats one value although the body moves; saturated: an axis is at
    the end of its range; missing: no sample yet, or none for a second and ten of its usual intervals."""
    since_s: float
    """Time at which the state began; NaN if it has not changed since the start."""
    axes: Annotated[str, letters("xyz")]
    """Stuck or saturated now: "" or some of "xyz", of the sensor's axes turned to the body."""
    outliers: int
    """Samples so far."""
    stuck: int
    """Samples so far."""
    saturated: int
    """Samples so far."""
    late: int
    """Samples so far."""
    left_out: int
    """Samples that were accepted from the caller and not used: outliers, stuck, saturated, time stamps far ahead."""


@dataclass(frozen=True, eq=False)
class Health(Record):
    """The state of each sensor, and how often the filter started again."""

    sensor: Annotated[dict[str, SensorHealth], each(SENSORS, SensorHealth)]
    """By sensor."""
    times_lost: int
    """How often the attitude was initialised again, after a long gap or because the samples contradicted it."""
    clock_jumps: int
    """How often time stamps ran back, so that a new time base began."""
    stamps_left_out: int
    """Samples whose time stamp is far ahead of all others."""
    lost: bool
    """The attitude is being initialised again: nothing is ready."""
