"""An attitude filter over a recording, whole or in pieces; it waits for fields that arrive late.

run = hnav.Filter("ahrs").run_recording(recording)
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from hnav.filters.attitude import SPEED_SIGMA_M_S, Filter
from hnav.filters.attitude_answers import Run, empty_run
from hnav.filters.filter_answers import HEALTH_SENSORS, SENSOR_STATES
from hnav.filters.options import Options
from hnav.io.recordings import Recording

CHUNK = 20000  # rows that the library runs between two reports of progress
Progress = Callable[[int, int], None]  # rows done, rows in all


def run_recording(recording: Recording, options: Options, progress: Progress | None = None, smooth: bool = False) -> Run:
    """A whole recording. smooth: with hindsight, by the AHRS. Raises HnavError."""
    if recording.field_t_s is not None and not smooth:
        return _run_by_arrival(recording, options, progress)
    # The smoother takes a late field at the row in which it was measured.
    return _run_at_once(recording.in_order_of_measurement(), options, progress, smooth)


class LibraryRun:
    """A filter of the library and a recording that comes in pieces.

    Raises HnavError for impossible options.
    """

    def __init__(self, options: Options):
        self.options, self._seconds, self._rows = options, 0.0, 0
        self._filter = Filter(options)

    def go_on(self, recording: Recording, rows: slice = slice(None), smooth: bool = False, speeds: Speeds | None = None) -> Run:
        """These rows, which go on from those of the last call. smooth: with hindsight, and then all rows at once. speeds: of all rows of
        the recording; without them those that it has."""
        t_s, rate, force = recording.t_s[rows], recording.rate_b_rad_s[rows], recording.force_b_m_s2[rows]
        field = None if recording.field_b_tesla is None else recording.field_b_tesla[rows]
        speeds = speeds or speeds_of(recording, self.options)
        of_rows: dict[str, Any] = {}
        if speeds is not None:
            of_rows = {"speed_m_s": speeds.m_s[rows], "speed_sigma_m_s": speeds.sigma_m_s[rows]}
        begin = time.perf_counter()
        run = self._filter.run(t_s, rate, force, field, smooth=smooth, check=False, **of_rows)
        self._seconds, self._rows = self._seconds + time.perf_counter() - begin, self._rows + len(t_s)
        return run

    @property
    def us_per_sample(self) -> float:
        """Time of the filter for a row, in microseconds."""
        return 1e6 * self._seconds / self._rows

    @property
    def counts(self) -> dict[str, int]:
        """Used, gated, late, ... by name."""
        return _counts(self._filter)


class Speeds(NamedTuple):
    """Speeds along body x of n rows."""

    m_s: np.ndarray
    """n; NaN in rows without one."""
    sigma_m_s: np.ndarray
    """n, standard deviations."""


def speeds_of(recording: Recording, options: Options) -> Speeds | None:
    """Those that the filter uses, each in the first row that is not earlier."""
    if options.filter != "ahrs" or "speed" not in recording.aids:
        return None
    given, n = recording.aids["speed"], len(recording.t_s)
    at = np.searchsorted(recording.t_s, given.t_s)
    inside = (at < n) & (given.t_s >= recording.t_s[0])
    speed, sigma = np.full(n, np.nan), np.full(n, SPEED_SIGMA_M_S)
    speed[at[inside]] = given.values[inside, 0]
    sigma[at[inside]] = np.where(np.isfinite(given.sigma[inside, 0]), given.sigma[inside, 0], SPEED_SIGMA_M_S)
    return Speeds(speed, sigma)


def _run_at_once(recording: Recording, options: Options, progress: Progress | None, smooth: bool) -> Run:
    library, n, speeds = LibraryRun(options), len(recording.t_s), speeds_of(recording, options)
    chunk = n if smooth or progress is None else CHUNK
    parts: list[Run] = []
    for i in range(0, n, chunk):
        parts.append(library.go_on(recording, slice(i, i + chunk), smooth, speeds))
        if progress:
            progress(min(i + chunk, n), n)
    arrays = {
        name: np.concatenate([vars(p)[name] for p in parts]) for name, a in vars(parts[0]).items() if isinstance(a, np.ndarray)
    }
    return Run(**arrays, options=options, us_per_sample=library.us_per_sample, counts=library.counts)


def _run_by_arrival(recording: Recording, options: Options, progress: Progress | None) -> Run:
    """Pushes each sample when it arrives, with the time of its measurement; the filter waits for late ones."""
    field, measured_s = recording.needed("field_b_tesla"), recording.needed("field_t_s")
    _wait_for_late(options, recording.t_s, measured_s)
    attitude_filter = Filter(options)
    n = len(recording.t_s)
    run = empty_run(recording.t_s)
    samples = (recording.rate_b_rad_s, recording.force_b_m_s2, field)
    seen = np.stack([np.isfinite(values).all(axis=1) for values in samples], axis=1)
    speeds = speeds_of(recording, options)
    started = False
    begin = time.perf_counter()
    for i, t_s in enumerate(recording.t_s.tolist()):
        if seen[i, 0]:
            attitude_filter.push_gyro(t_s, recording.rate_b_rad_s[i])
        if seen[i, 1]:
            attitude_filter.push_accel(t_s, recording.force_b_m_s2[i])
        if seen[i, 2]:
            attitude_filter.push_mag(measured_s[i], field[i])
        if speeds and np.isfinite(speeds.m_s[i]):
            attitude_filter.push_speed(t_s, speeds.m_s[i], speeds.sigma_m_s[i])
        attitude_filter.advance(t_s)
        sensors = attitude_filter.health().sensor
        run.health[i] = [SENSOR_STATES.index(sensors[name].state) for name in HEALTH_SENSORS]
        started = started or attitude_filter.diagnostics().started
        if started:
            _note(attitude_filter, run, i)
        if progress and (i % 1000 == 999 or i == n - 1):
            progress(i + 1, n)
    run.us_per_sample = 1e6 * (time.perf_counter() - begin) / n
    run.options, run.counts = options, _counts(attitude_filter)
    return run


def _wait_for_late(options: Options, t_s: np.ndarray, measured_s: np.ndarray) -> None:
    """Sets the horizon and the length of the queue by the longest delay of a field."""
    delay_s = float(np.nanmax(t_s - measured_s, initial=0.0))
    interval_s = float(np.median(np.diff(t_s)))
    if options.horizon_s < delay_s:
        # One row longer than the longest delay, because of rounding.
        options.horizon_s = delay_s + interval_s
        options.queue_capacity = max(options.queue_capacity, 2 * int(np.ceil(options.horizon_s / interval_s)) + 8)


def _note(attitude_filter: Filter, run: Run, i: int) -> None:
    """Writes the estimate of now to row i; the NIS stay NaN, because the samples may be corrected later."""
    attitude = attitude_filter.attitude()
    run.q_nb[i], run.euler_rad[i], run.sigma_rad[i] = attitude.q_nb, attitude.euler_rad, attitude.sigma_rad
    run.ready[i] = attitude.tilt_ready, attitude.heading_ready
    run.gyro_bias_rad_s[i], run.gyro_bias_sigma_rad_s[i] = attitude_filter.gyro_bias()


def _counts(attitude_filter: Filter) -> dict[str, int]:
    seen = attitude_filter.diagnostics()
    counts = {f"{sensor}_used": used for sensor, used in seen.used.items()}
    counts |= {f"{sensor}_gated": gated for sensor, gated in seen.gated.items()}
    for name in ("late", "non_finite", "zero", "corrections", "gamma_raised", "covariance_repaired"):
        counts[name] = getattr(seen, name)
    counts["rhs_evals"] = seen.solver_rhs_evals
    return counts
