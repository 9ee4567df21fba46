"""Attitude and heading by the C library: the AHRS for real sensors, and the HREKF of the paper.

    run = hnav.Filter("ahrs", navigation_frame="enu").run(t_s, rate, force, field)      # n x 3 arrays in SI units
    run.q_nb                                # n x 4, scalar first, body to navigation
    run.to_dataframe()

    filter = hnav.Filter("ahrs")            # or sample by sample
    filter.push_imu(t_s, rate, force)
    filter.push_mag(t_s, field)
    filter.advance(t_s)
    filter.attitude().heading_rad

Conventions, for all that is here: n is the navigation frame, north-east-down unless the option navigation_frame says enu;
b is the body frame, the axes of the sensor turned by the option q_body_sensor. Quaternions are Hamilton's, scalar first;
q_nb turns body vectors into navigation axes. force is specific force: a sensor at rest with its z axis down reads
(0, 0, -9.81) m/s2. Times in s, rates in rad/s, forces in m/s2, fields in tesla, angles in rad. Filters of different threads
run in parallel; one filter serves one thread at a time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import numpy.typing as npt

from hnav.errors import HnavRuntimeError, HnavValueError
from hnav.filters.hybrid_view import HybridView
from hnav.native.arrays import (
    Array,
    BoolArray,
    ByteArray,
    Counted,
    Each,
    Letters,
    Named,
    Record,
    Shaped,
    address,
    doubles,
    times,
)
from hnav.native.library import PRESETS, SENSORS, continued, enumerators, failure, ffi, library, new, text
from hnav.native.options import OptionInfo, OptionSet, complete, option_rows
from hnav.renamed import now_called

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd
    from matplotlib.figure import Figure

    from hnav.io.recordings import Recording

FILTERS = {"hrekf": ("default", "paper"), "ahrs": ("default",)}
"""The filters, and the presets of each."""

VERDICTS = enumerators("hnav_field_gate", "HNAV_FIELD_")
"""What the filter made of a field."""

SENSOR_STATES = enumerators("hnav_sensor_state", "HNAV_SENSOR_STATE_")
"""What a sensor is taken to be: ok, late, outlier, stuck, saturated, missing; Run.health counts them from 0."""

HEALTH_SENSORS = SENSORS[:3]
"""The sensors of the columns of Run.health: gyro, accel, mag."""

# --------------------------------------------------------------------------------------------- options


def option_table(filter: str) -> Mapping[str, OptionInfo]:
    """The options of a filter by name, in the library's order. Raises HnavValueError for other filters."""
    if filter not in FILTERS:
        raise HnavValueError(
            "option", f"filter = {filter}{now_called(filter, 'filter')}: choose one of {', '.join(FILTERS)}", "filter"
        )
    return option_rows(filter)


def checked_preset(filter: str, preset: str) -> int:
    """The number of a preset that the filter has. Raises HnavValueError for filters and presets that do not exist."""
    option_table(filter)
    if preset not in FILTERS[filter]:
        raise HnavValueError("option", f"preset = {preset}: {filter} has {', '.join(FILTERS[filter])}", "preset")
    return PRESETS.index(preset)


def parse_setting(text: str) -> tuple[str, str]:
    """Name and value of "NAME=VALUE". Raises HnavValueError."""
    name, separator, value = text.partition("=")
    if not (separator and name and value):
        raise HnavValueError("option", f"setting = {text}: write NAME=VALUE", "setting")
    return name, value


class Options(OptionSet):
    """Options of an attitude filter, as attributes; option_table(filter) tells unit, range and meaning of each.

        Options("hrekf", "paper", gamma_mode="kl", q_body_sensor=[1, 0, 0, 0])

    filter: "ahrs" or "hrekf". preset: one of FILTERS[filter]. values: options that differ from the preset. Raises
    HnavValueError for filters, presets, names (UnknownOptionError) and values that do not exist.
    """

    def __init__(self, filter: str, preset: str = "default", **values: object):
        number = checked_preset(filter, preset)
        self.__dict__["_preset"] = preset
        super().__init__(filter, number, values)

    @property
    def filter(self) -> str:
        """The filter that the options are of: "ahrs" or "hrekf"."""
        return str(self._options)

    @property
    def preset(self) -> str:
        """The preset that the options started from."""
        return str(self._preset)

    def _arguments(self) -> tuple[str, ...]:
        return (self.filter,) if self.preset == "default" else (self.filter, self.preset)


# --------------------------------------------------------------------------------------------- results


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
        for name, axes in _COLUMNS.items():
            values = getattr(self, name)
            columns |= {axes[0]: values} if len(axes) == 1 else {column: values[:, i] for i, column in enumerate(axes)}
        words = pd.CategoricalDtype(list(SENSOR_STATES))
        columns |= {name: pd.Categorical.from_codes(columns[name], dtype=words) for name in _COLUMNS["health"]}
        return pd.DataFrame(columns, index=pd.Index(self.t_s, name="t_s"))


def _of_axes(name: str, unit: str) -> tuple[str, ...]:
    return tuple(f"{name}_{axis}_{unit}" for axis in "xyz")


# The arrays of a Run beside t_s that the library fills, and the columns of each.
_COLUMNS = {
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
    arrays: dict[str, Any] = {name: np.full((n, len(axes)) if len(axes) > 1 else n, np.nan) for name, axes in _COLUMNS.items()}
    ready = np.zeros((n, 2), bool)
    health = np.full((n, len(HEALTH_SENSORS)), SENSOR_STATES.index("missing"), np.uint8)
    return Run(t_s, **(arrays | {"ready": ready, "health": health}))


# --------------------------------------------------------------------------------------------- the filter


class Filter(HybridView):
    """An attitude filter: a hybrid system whose estimate flows between samples and jumps at each of them.

        Filter("ahrs", navigation_frame="enu", preset="default")
        Filter(Options("ahrs"))

    options: the name of a filter, with preset and values as of Options, or Options. Raises HnavValueError for options that
    are impossible, HnavRuntimeError when there is no memory.

    Samples are pushed with their times, which may come in any order within one instant and between two calls of advance,
    and up to the option horizon_s late. Every call that fails leaves the estimate as it was. Filters are copied and pickled
    with their state.
    """

    KIND = "filter"

    def __init__(self, options: Options | str, preset: str | None = None, **values: object):
        if isinstance(options, str):
            self._options = Options(options, preset or "default", **values)
        elif preset is None:
            self._options = complete(Options, options, values)
        else:
            raise HnavValueError("option", "Options are complete: a preset belongs to Options(...)", "preset")
        super().__init__(f"hnav_{self._options.filter}_create", self._options.struct)

    @property
    def options(self) -> Options:
        """A copy of the options that the filter was made with."""
        return copy(self._options)

    def __repr__(self) -> str:
        return f"Filter({self._options!r})"

    def __reduce__(self) -> tuple[Any, ...]:
        return continued, (Filter, (self._options,), self.save())

    # ----------------------------------------------------------------------------------------- samples

    def push_gyro(self, t_s: float, rate_b_rad_s: npt.ArrayLike) -> None:
        """A sample of the gyroscope: rate_b_rad_s is 3, in sensor axes.

        Raises HnavValueError for numbers that are not finite, HnavRuntimeError for late samples and a full queue.
        """
        self._push("gyro", t_s, rate_b_rad_s, "rate_b_rad_s")

    def push_accel(self, t_s: float, force_b_m_s2: npt.ArrayLike) -> None:
        """A sample of the accelerometer: force_b_m_s2 is 3, in sensor axes; errors as of push_gyro, and for a zero vector."""
        self._push("accel", t_s, force_b_m_s2, "force_b_m_s2")

    def push_mag(self, t_s: float, field_b_tesla: npt.ArrayLike) -> None:
        """A sample of the magnetometer: field_b_tesla is 3, in sensor axes; errors as of push_accel."""
        self._push("mag", t_s, field_b_tesla, "field_b_tesla")

    def push_imu(self, t_s: float, rate_b_rad_s: npt.ArrayLike, force_b_m_s2: npt.ArrayLike) -> None:
        """Gyroscope and accelerometer of one instant, both or neither; as push_gyro and push_accel."""
        rate, force = doubles(rate_b_rad_s, (3,), "rate_b_rad_s"), doubles(force_b_m_s2, (3,), "force_b_m_s2")
        self._call("push_imu", t_s, address(rate), address(force))

    def push_heading(self, t_s: float, heading_rad: float, sigma_rad: float) -> None:
        """True heading of body x, clockwise from north, by another source; sigma_rad is its standard deviation, above 0."""
        self._call("push_heading", t_s, heading_rad, sigma_rad)

    def advance(self, t_s: float) -> None:
        """Uses the samples up to t_s and shows the estimate at t_s.

        Between samples and after the newest one a copy of the estimate is predicted to t_s; what is stored stays as it is,
        so the same samples give the same bits whatever times are asked for. Raises HnavRuntimeError for a time before that
        of the last advance, and when samples led to no usable estimate: those were dropped, the others used.
        """
        self._call("advance", t_s)

    def run(
        self,
        t_s: npt.ArrayLike,
        rate_b_rad_s: npt.ArrayLike | None = None,
        force_b_m_s2: npt.ArrayLike | None = None,
        field_b_tesla: npt.ArrayLike | None = None,
        only: tuple[str, ...] = (),
        gates: bool = False,
    ) -> Run:
        """A whole recording: push and advance of row after row, bit for bit.

        t_s: n, not decreasing; the others n x 3 in sensor axes, or None. A row of NaN is a missing sample.
        only: names of the arrays of Run to fill, all if empty; sigmas cost as much as the filter itself.
        gates: fill accepted too, and the NIS that it needs, at some microseconds a row.

        A run goes on from where the filter stands: reset it before it takes another recording. Raises HnavValueError for
        arrays of other shapes, HnavRuntimeError naming the row where the filter cannot go on.
        """
        samples = (rate_b_rad_s, force_b_m_s2, field_b_tesla)
        if not gates:
            return self._batch(self._run_at_once, t_s, samples, only)
        return self._batch(self._run_by_row, t_s, samples, (*only, "accel_nis", "mag_nis") if only else only)

    def smooth(
        self,
        t_s: npt.ArrayLike,
        rate_b_rad_s: npt.ArrayLike | None = None,
        force_b_m_s2: npt.ArrayLike | None = None,
        field_b_tesla: npt.ArrayLike | None = None,
        only: tuple[str, ...] = (),
    ) -> Run:
        """As run, with hindsight: every row from all samples, before and after it. The filter is reset before and after.

        Takes five times as long as run. Raises HnavRuntimeError for the HREKF, which has no smoother, and for recordings
        that the filter cannot start on.
        """
        return self._batch(self._smooth_at_once, t_s, (rate_b_rad_s, force_b_m_s2, field_b_tesla), only)

    def realign(self) -> None:
        """Forgets the attitude and starts anew with the next samples; keeps the gyro bias and the counters."""
        self._call("realign")

    # ----------------------------------------------------------------------------------------- estimate

    def attitude(self) -> Attitude:
        """Attitude and heading at the time of the last advance. Raises HnavRuntimeError while there is none."""
        return Attitude.read(self._filled("hnav_attitude", "attitude"))

    def posterior(self) -> Posterior:
        """The estimate just after the newest used sample. Raises HnavRuntimeError while there is none."""
        return Posterior.read(self._filled("hnav_posterior", "posterior"))

    def rate(self) -> Array:
        """3, rad/s, body axes: the newest rate without the bias; zero before the first sample."""
        return self._numbers("rate", 3)[0]

    def gyro_bias(self) -> tuple[Array, Array]:
        """Bias of the gyroscope and its standard deviations: 3 each, rad/s, body axes."""
        bias, sigma = self._numbers("gyro_bias", 3, 3)
        return bias, sigma

    def gyro_calibration(self) -> tuple[Array, Array]:
        """Scale and misalignment S, rate = (I - S) reading - bias, and the sigma of each element: 3 x 3; zero in the HREKF."""
        matrix, sigma = self._numbers("gyro_calibration", (3, 3), (3, 3))
        return matrix, sigma

    def covariance(self) -> Array:
        """6 x 6: rotation about the navigation axes in rad, gyro bias in rad/s. Raises HnavRuntimeError before the start."""
        return self._numbers("covariance", (6, 6))[0]

    def field(self) -> Field:
        """What the filter holds of the magnetic field."""
        return Field.read(self._filled("hnav_field", "field"))

    def innovation(self, sensor: str) -> Innovation:
        """What the last used sample of a sensor said: "accel", "mag" or "heading".

        Raises HnavValueError for other sensors, HnavRuntimeError when none of its samples has been used yet.
        """
        if sensor not in SENSORS:
            raise HnavValueError("option", f"sensor = {sensor}: choose one of {', '.join(SENSORS[1:])}", "sensor")
        return Innovation.read(self._filled("hnav_innovation", "innovation", SENSORS.index(sensor)))

    def diagnostics(self) -> Diagnostics:
        """Counts of samples and corrections, and figures of the last correction."""
        return Diagnostics.read(self._filled("hnav_diagnostics", "diagnostics"))

    def health(self) -> Health:
        """How each sensor does, and how often attitude and time base had to begin anew."""
        return Health.read(self._filled("hnav_health", "health"))

    # ----------------------------------------------------------------------------------------- calls of the library

    def _push(self, sensor: str, t_s: float, value: npt.ArrayLike, name: str) -> None:
        self._call(f"push_{sensor}", t_s, address(doubles(value, (3,), name)))

    def _numbers(self, name: str, *shapes: int | tuple[int, ...]) -> list[Array]:
        arrays = [np.empty(shape) for shape in shapes]
        self._call(name, *map(address, arrays))
        return arrays

    def _batch(
        self, go: Callable[[_Struct, _Struct, Run], None], t_s: npt.ArrayLike, samples: tuple[npt.ArrayLike | None, ...],
        only: tuple[str, ...],
    ) -> Run:  # fmt: skip
        t = times(t_s)
        n = t.shape
        arrays: dict[str, Array | None] = {"t_s": t}
        for name, values in zip(("rate_b_rad_s", "force_b_m_s2", "field_b_tesla"), samples):
            arrays[name] = None if values is None else doubles(values, (*n, 3), name)
        run = empty_run(t)
        if unknown := set(only) - set(_COLUMNS):
            raise HnavValueError("option", f"only = {unknown.pop()}: choose from {', '.join(_COLUMNS)}", "only")
        given = _Struct("hnav_run_input", arrays)
        wanted = _Struct("hnav_run_output", {name: getattr(run, name) for name in only or _COLUMNS})
        try:
            go(given, wanted, run)
        except HnavRuntimeError as error:
            if error.status in ("late sample", "time backwards") and str(error).startswith("row 0:"):
                begins = f"t_s begins at {t[0]:g} s, before the time that this filter stands at: reset() it first"
                raise HnavRuntimeError(error.status, f"{begins} ({error})") from None
            raise
        run.options = self.options
        return run

    def _run_at_once(self, given: _Struct, wanted: _Struct, run: Run) -> None:
        self._call("run", len(run.t_s), given.struct, wanted.struct, ffi.NULL)

    def _smooth_at_once(self, given: _Struct, wanted: _Struct, run: Run) -> None:
        self._call("smooth", len(run.t_s), given.struct, wanted.struct)

    def _run_by_row(self, given: _Struct, wanted: _Struct, run: Run) -> None:
        """The same, with a look at the counters after each row: they tell what the gates made of it."""
        counts, n = new("hnav_diagnostics"), len(run.t_s)
        rows, call = library().hnav_filter_run, library().hnav_filter_diagnostics
        before = self.diagnostics().gated
        gated = np.zeros((n + 1, 2), np.int64)
        gated[0] = before["accel"], before["mag"]
        for i in range(n):
            given.stand_at(i)
            wanted.stand_at(i)
            if status := rows(self._handle, 1, given.struct, wanted.struct, ffi.NULL):
                reason = text(library().hnav_filter_message(self._handle)).removeprefix("row 0: ")
                raise failure(status, ffi.new("char[]", f"row {i}: {reason}".encode()))
            call(self._handle, counts)
            gated[i + 1] = counts.gated[1], counts.gated[2]
        run.accepted = np.isfinite(np.stack([run.accel_nis, run.mag_nis], axis=1)) & (np.diff(gated, axis=0) == 0)


class _Struct:
    """A C struct whose pointers lead to the rows of arrays, each n long."""

    def __init__(self, kind: str, arrays: Mapping[str, npt.NDArray[Any] | None]):
        begins = {name: address(array) for name, array in arrays.items()}
        self.struct = new(kind, **begins)
        self._moving = [(name, begins[name] + 0, array[:1].size) for name, array in arrays.items() if array is not None]

    def stand_at(self, row: int) -> None:
        """The struct begins at this row."""
        for name, begin, width in self._moving:
            setattr(self.struct, name, begin + width * row)
