"""What an attitude filter answers: the estimate and what it is made of, and the arrays of a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from hnav.filters.attitude_options import Options
from hnav.native.arrays import Array, BoolArray, ByteArray, Counted, Each, Letters, Named, Record, Shaped
from hnav.native.library import SENSORS, enumerators

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd
    from matplotlib.figure import Figure

    from hnav.io.recordings import Recording

VERDICTS = enumerators("hnav_field_gate", "HNAV_FIELD_")
"""What the filter made of a field."""

SENSOR_STATES = enumerators("hnav_sensor_state", "HNAV_SENSOR_STATE_")
"""What a sensor is taken to be: ok, late, outlier, stuck, saturated, missing; Run.health counts them from 0."""

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
    """Roll and pitch are known: a small sigma that was earned from samples."""
    heading_ready: bool
    """Heading is known, likewise."""


@dataclass(frozen=True, eq=False)
class Posterior(Record):
    """The estimate just after the newest sample that is not in the future of the last advance."""

    t_s: float
    """The time of that sample."""
    q_nb: Array
    """4: unit quaternion, scalar first, body to navigation."""
    gyro_bias_rad_s: Array
    """3, body axes."""
    sigma: Array
    """6: rotations about the three navigation axes in rad, three biases in rad/s."""
    near_singular: bool
    """As in Attitude."""
    tilt_ready: bool
    """As in Attitude."""
    heading_ready: bool
    """As in Attitude."""


@dataclass(frozen=True, eq=False)
class Innovation(Record):
    """What the last used sample of a sensor said."""

    t_s: float
    """The time of that sample."""
    value: Array
    """3, of which the first `dimension` count: measured minus expected. Force and field are in units of gravity and of the
    reference strength, heading in rad; of the AHRS, force: minus the velocity in m/s, north and east, and the field is in
    navigation axes."""
    S: Annotated[Array, Shaped(3, 3)]
    """3 x 3, of which `dimension` rows and columns count: its covariance, with the noise of the options."""
    nis: float
    """value' S^-1 value: about `dimension` on average when model and noise are right."""
    noise_scale: float
    """Noise that was used over that of the options: 1 unless the gate inflated it, infinite when it rejected the sample."""
    dimension: int
    """3; 1 for heading; 2 for the force of the AHRS."""
    accepted: bool
    """Whether the gate let the sample pass as it was."""


@dataclass(frozen=True, eq=False)
class Field(Record):
    """What the filter holds of the magnetic field and its sensor, just after the newest used sample."""

    strength_tesla: float
    """Of the reference field; NaN while there is none."""
    dip_rad: float
    """Of the reference field, positive when it points down; NaN while there is none."""
    latency_s: float
    """Estimated delay of the magnetometer behind its time stamps (ahrs)."""
    latency_sigma_s: float
    """Its standard deviation."""
    evidence_s: float
    """Time for which the reference was seen, counted less at rest (ahrs)."""
    heading_trust_s: float
    """The same for the heading, through changes of the reference (ahrs)."""
    reference_changes: int
    """References taken after the first (ahrs)."""
    gate: Annotated[str, Named(VERDICTS)]
    """What was made of the last field: one of VERDICTS."""
    at_rest: bool
    """The body lies still (ahrs)."""


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
    used: Annotated[dict[str, int], Counted(SENSORS)]
    """Samples used, by sensor: gyro, accel, mag, heading."""
    gated: Annotated[dict[str, int], Counted(SENSORS)]
    """Of those, with inflated noise."""
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
    """Covariances that the integrator had spoilt and that were mended."""
    solver_rhs_evals: int
    """Evaluations of the differential equation by the solver."""
    solver_steps: int
    """Steps of the solver."""
    started: bool
    """There is an attitude."""
    waiting: int
    """Instants in the queue that are still in the future of the last advance."""
    decay_rate_1_s: float
    """Rate at which the last correction and the flow before it make the HREKF forget (its paper's Theorem 1, sampled); 0
    before the first correction, and of the AHRS."""


@dataclass(frozen=True, eq=False)
class SensorHealth(Record):
    """What a sensor is taken to be at the time of the last advance, and the samples that were not believed so far.

    Samples that are stuck, saturated or outliers are left out; those of a gyroscope are used, outliers apart, because nothing
    better is known, and the sigma of the attitude grows by what they may have missed.
    """

    state: Annotated[str, Named(SENSOR_STATES)]
    """ok; late: within the last second a sample was refused as older than the committed estimate; outlier: within the last
    second one lay far from those beside it; stuck: an axis repeats one value although the body moves; saturated: an axis is at
    the end of its range; missing: no sample yet, or none for a second and ten of its usual intervals."""
    since_s: float
    """Time at which the state began; NaN when it has been so from the first."""
    axes: Annotated[str, Letters("xyz")]
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
    """Taken in and not used: outliers, stuck, saturated, stamps far ahead."""


@dataclass(frozen=True, eq=False)
class Health(Record):
    """How the sensors do, and how often the filter had to begin anew."""

    sensor: Annotated[dict[str, SensorHealth], Each(SENSORS, SensorHealth)]
    """By sensor: gyro, accel, mag, heading."""
    times_lost: int
    """The attitude was found wrong, or a gap was too long, and it was found anew."""
    clock_jumps: int
    """Stamps ran back: a new time base began."""
    stamps_left_out: int
    """Samples whose stamp lay far ahead of all others."""
    lost: bool
    """The attitude is being found anew: nothing is ready."""


@dataclass(repr=False)
class Run:
    """Arrays of a batch run, one row for each instant; NaN before the start and where no sample was used.

    In a notebook it shows its figures; plot() draws it, report(path) makes the page of it.
    """

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

    @property
    def heading_rad(self) -> Array:
        """n: true heading of body x, clockwise from north, in (-pi, pi], whatever the navigation frame."""
        yaw = self.euler_rad[:, 2]
        east_first = self.options is not None and self.options.navigation_frame == "enu"
        heading: Array = -np.remainder(np.pi - (np.pi / 2 - yaw if east_first else yaw), 2 * np.pi) + np.pi
        return heading

    def __repr__(self) -> str:
        from hnav.filters.run_summary import in_one_line

        return f"<{type(self).__name__}: {in_one_line(self)}>"

    def _repr_html_(self) -> str:
        """What a notebook shows."""
        from hnav.filters.run_summary import as_html

        return as_html(self)

    def plot(self, recording: Recording | None = None) -> Figure:
        """Attitude, sigma, innovations and bias over time, as a figure of Matplotlib: savefig, or look at it in a notebook.

        recording: what the run was made of; its reference attitude is drawn beside, if it has one.
        """
        import hnav  # what draws stands above the filters; hnav itself knows both

        return hnav.plot_run(self, recording)

    def report(self, path: str | Path, recording: Recording | None = None) -> None:
        """Writes one HTML page that needs no network. Needs Plotly. Raises HnavError if the file cannot be written.

        recording: what the run was made of; the page then shows its field, its rates and its reference attitude too.
        """
        import hnav  # as in plot

        hnav.report_run(self, path, recording)

    def to_dataframe(self) -> pd.DataFrame:
        """The run as a table of pandas, indexed by t_s: a column for each component, its unit at the end of its name; those
        of health hold words."""
        import pandas as pd

        columns: dict[str, Any] = {}
        for name, axes in RUN_COLUMNS.items():
            values = getattr(self, name)
            columns |= {axes[0]: values} if len(axes) == 1 else {column: values[:, i] for i, column in enumerate(axes)}
        words = pd.CategoricalDtype(list(SENSOR_STATES))
        columns |= {name: pd.Categorical.from_codes(columns[name], dtype=words) for name in RUN_COLUMNS["health"]}
        return pd.DataFrame(columns, index=pd.Index(self.t_s, name="t_s"))


def _of_axes(name: str, unit: str) -> tuple[str, ...]:
    return tuple(f"{name}_{axis}_{unit}" for axis in "xyz")


# The arrays of a Run beside t_s that the library fills, and the columns of each.
RUN_COLUMNS = {
    "q_nb": ("q_w", "q_x", "q_y", "q_z"),
    "euler_rad": ("roll_rad", "pitch_rad", "yaw_rad"),
    "sigma_rad": _of_axes("sigma", "rad"),
    "gyro_bias_rad_s": _of_axes("gyro_bias", "rad_s"),
    "gyro_bias_sigma_rad_s": _of_axes("gyro_bias_sigma", "rad_s"),
    "accel_nis": ("accel_nis",),
    "mag_nis": ("mag_nis",),
    "ready": ("tilt_ready", "heading_ready"),
    "health": tuple(f"{sensor}_health" for sensor in HEALTH_SENSORS),
}


def empty_run(t_s: Array) -> Run:
    """A Run of these instants that knows nothing yet: every sensor is missing."""
    n = len(t_s)
    arrays: dict[str, Any] = {name: np.full((n, len(axes)) if len(axes) > 1 else n, np.nan) for name, axes in RUN_COLUMNS.items()}
    ready = np.zeros((n, 2), bool)
    health = np.full((n, len(HEALTH_SENSORS)), SENSOR_STATES.index("missing"), np.uint8)
    return Run(t_s, **(arrays | {"ready": ready, "health": health}))
