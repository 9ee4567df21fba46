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
from typing import Any

import numpy as np
import numpy.typing as npt

from hnav.errors import HnavRuntimeError, HnavValueError
from hnav.filters.attitude_answers import RUN_COLUMNS, Attitude, Diagnostics, Field, Health, Innovation, Posterior, Run, empty_run
from hnav.filters.attitude_options import Options
from hnav.filters.hybrid_view import HybridView
from hnav.native.arrays import Array, address, doubles, times
from hnav.native.library import SENSORS, continued, failure, ffi, library, new, text
from hnav.native.options import complete


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
        if unknown := set(only) - set(RUN_COLUMNS):
            raise HnavValueError("option", f"only = {unknown.pop()}: choose from {', '.join(RUN_COLUMNS)}", "only")
        given = _Struct("hnav_run_input", arrays)
        wanted = _Struct("hnav_run_output", {name: getattr(run, name) for name in only or RUN_COLUMNS})
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
