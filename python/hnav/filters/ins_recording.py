"""The navigation filter over a recording, whole or in pieces: its aids, with sigmas where a file has none.

run = NavigationRun.over(recording, Options("ins", "industrial")).go_on(inertial_rows(recording))
hnav.Ins("industrial").run_recording(recording)                     # the same, of a whole one
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping
from copy import copy
from dataclasses import replace

import numpy as np

from hnav.errors import HnavValueError
from hnav.filters.attitude import SPEED_SIGMA_M_S
from hnav.filters.ins import Ins
from hnav.filters.ins_aids import AIDS, Aids
from hnav.filters.ins_answers import InsRun
from hnav.filters.options import Options
from hnav.io.aids import AidSamples, AidsOfFile, arrived_within, none_within
from hnav.io.recordings import Recording
from hnav.native.arrays import Array

SIGMA = {
    "position": (2.0, 2.0, 4.0),
    "velocity": (0.2, 0.2, 0.2),
    "pressure": (20.0,),
    "speed": (SPEED_SIGMA_M_S,),
    "heading": (0.02,),
}
"""Standard deviations of aids where a file has none, in SI units. Chosen: a usual receiver, pressure chip, wheels and two antennas a metre apart."""
IN_A_GAP = 8
"""Samples of each aid that are kept of a gap without rows: the filter starts again after it."""
PRESSURE_S = 0.1
"""Interval from which one pressure is used: neighbours have the same error, and as independent samples they would weigh too
much."""
PAIRED_SHARE = 0.5
"""Share of the rows with a rate that also have a force; below it both sensors have time stamps of their own."""


def with_aids(recording: Recording, aids: Mapping[str, AidSamples]) -> Recording:
    """The recording with aids of a file of their own, which go before those of their kind that it has. Raises HnavValueError
    when no time of theirs lies within the recording."""
    begin_s, end_s = float(recording.t_s[0]), float(recording.t_s[-1])
    refuse_other_clock(recording.name, begin_s, end_s, aids)
    origin, notes = recording.origin, aids.notes if isinstance(aids, AidsOfFile) else ()
    origin = replace(origin, notes=(*origin.notes, *notes)) if origin else None
    return replace(recording, aids={**recording.aids, **aids}, origin=origin)


def refuse_other_clock(name: str, begin_s: float, end_s: float, aids: Mapping[str, AidSamples]) -> None:
    """Raises HnavValueError when no time of the aids lies within that of the rows."""
    times = np.concatenate([one.t_s for one in aids.values()] or [np.empty(0)])
    if none_within(times, begin_s, end_s):
        raise HnavValueError(
            "no data", f"{name}: satellites have times from {times.min():.10g} to {times.max():.10g} s, its rows from {begin_s:.10g} to "
            f"{end_s:.10g} s: give both the same clock"
        )  # fmt: skip


def paired(recording: Recording) -> Recording:
    """Rate and force in the same rows: where the two sensors have times of their own, the force is interpolated to the times of
    the rate."""
    rate, force = (np.isfinite(values).all(axis=1) for values in (recording.rate_b_rad_s, recording.force_b_m_s2))
    if (rate & force).sum() >= PAIRED_SHARE * rate.sum() or not rate.any() or not force.any():
        return recording
    t_s = recording.t_s[rate]
    between = np.stack(
        [np.interp(t_s, recording.t_s[force], axis, np.nan, np.nan) for axis in recording.force_b_m_s2[force].T], 1
    )
    return Recording(recording.name, t_s, recording.rate_b_rad_s[rate], between, aids=aids_in(recording), origin=recording.origin)


def field_of(recording: Recording) -> dict[str, AidSamples]:
    """Samples of the magnetometer, as an aid without a sigma."""
    if recording.field_b_tesla is None or not (seen := np.isfinite(recording.field_b_tesla).all(axis=1)).any():
        return {}
    arrived_s, field = recording.t_s[seen], recording.field_b_tesla[seen]
    measured_s = arrived_s if recording.field_t_s is None else recording.field_t_s[seen]
    return {"mag": AidSamples(measured_s, field, np.full_like(field, np.nan), arrived_s)}


def aids_in(recording: Recording) -> dict[str, AidSamples]:
    """All aids of the recording, with its magnetometer."""
    return {**field_of(recording), **recording.aids}


class NavigationRun:
    """The filter and a recording that comes in pieces.

    options: horizon_s is raised to the longest delay of the aids given here. aids: those of a file of their own. Raises
    HnavError for impossible options.
    """

    def __init__(self, options: Options, aids: Mapping[str, AidSamples] | None = None, interval_s: float = 0.01):
        self.options = _waiting(options, aids or {}, interval_s)
        self.ins = Ins(self.options)
        self._waiting = dict(aids or {})
        self._until_s, self._seconds, self._rows = -np.inf, 0.0, 0
        self._last_pressure = -np.inf  # the interval of the newest one, counted from time 0

    @classmethod
    def over(cls, recording: Recording, options: Options) -> NavigationRun:
        """Over a recording that is whole: it has all of its aids from the first row on, and goes on with its inertial_rows."""
        return cls(options, aids_in(recording), interval_of(recording))

    def go_on(self, recording: Recording, every: int = 1, smooth: bool = False) -> InsRun:
        """These rows, which go on from those of the last call. smooth: with hindsight, and then all rows at once."""
        if not len(recording.t_s):
            raise HnavValueError("size", f"{recording.name}: no samples")
        end_s = float(recording.t_s[-1])
        if np.isneginf(self._until_s):  # aids before the first row are not used
            self._until_s = np.nextafter(recording.t_s[0], -np.inf)
        for kind, one in aids_in(recording).items():
            self._waiting[kind] = joined([self._waiting[kind], one]) if kind in self._waiting else one
        arrived = arrived_within(self._waiting, self._until_s, end_s)
        if "pressure" in arrived:
            arrived["pressure"] = self._thinned(arrived["pressure"])
        aids = aids_of(arrived, recording.t_s)
        self._waiting = arrived_within(self._waiting, end_s, np.inf)
        self._until_s = end_s
        begin = time.perf_counter()
        run = self.ins.run(recording.t_s, recording.rate_b_rad_s, recording.force_b_m_s2, aids, every, check=False)
        if smooth:
            run = self.ins.smooth(recording.t_s, recording.rate_b_rad_s, recording.force_b_m_s2, aids, every, check=False)
        self._seconds, self._rows = self._seconds + time.perf_counter() - begin, self._rows + len(recording.t_s)
        return run

    def _thinned(self, one: AidSamples) -> AidSamples:
        """The first of each interval of PRESSURE_S, wherever a piece begins."""
        interval = np.floor(one.t_s / PRESSURE_S)
        fresh = np.diff(interval, prepend=self._last_pressure) > 0
        self._last_pressure = max(self._last_pressure, float(interval[-1]))
        return one.rows(fresh)

    def without(self, kinds: Iterable[str]) -> NavigationRun:
        """A copy that continues without the samples of these kinds that have not arrived yet; this run is not changed."""
        made = copy(self)
        made.ins = copy(self.ins)
        made._waiting = {kind: one for kind, one in self._waiting.items() if kind not in kinds}
        return made

    @property
    def us_per_sample(self) -> float:
        """Time of the filter for a row, in microseconds."""
        return 1e6 * self._seconds / self._rows

    @property
    def counts(self) -> dict[str, int]:
        """Counters by name: used samples of each kind, inflated and late samples, lost alignments."""
        seen = self.ins.diagnostics()
        used, inflated = {name: seen.used[name] for name in AIDS}, {f"{name}_inflated": seen.gated[name] for name in AIDS}
        refused = {"late": seen.late, "non_finite": seen.non_finite, "times_lost": self.ins.health().times_lost}
        return {"imu": seen.used["gyro"], **used, **inflated, **refused}


def inertial_rows(recording: Recording, rows: slice = slice(None)) -> Recording:
    """Rate and force of some rows alone."""
    return Recording(recording.name, recording.t_s[rows], recording.rate_b_rad_s[rows], recording.force_b_m_s2[rows])


def interval_of(recording: Recording) -> float:
    """Between neighbouring rows, as usual."""
    return float(np.median(np.diff(recording.t_s))) if len(recording.t_s) > 1 else 0.01


def aids_of(aids: Mapping[str, AidSamples], t_s: Array | None = None) -> Aids:
    """For Ins.run. t_s: of the rows; of the samples that came between two of them the last IN_A_GAP of each kind are kept."""
    made = Aids()
    for kind, one in aids.items():
        kept = one if t_s is None else one.rows(_newest(one.arrived_s, t_s))
        if kind == "mag":
            made.mag(kept.t_s, kept.values, kept.received_s)
            continue
        sigma = np.where(np.isfinite(kept.sigma), kept.sigma, SIGMA[kind])
        given = kept.values.T if kind == "position" else [kept.values if kind == "velocity" else kept.values[:, 0]]
        getattr(made, kind)(kept.t_s, *given, sigma, received_s=kept.received_s)
    return made


def _newest(arrived_s: Array, t_s: Array) -> Array:
    """Which samples are among the last IN_A_GAP of those that the same row takes."""
    row = np.searchsorted(t_s, arrived_s)
    after = np.searchsorted(row, row, side="right") - np.arange(len(row))
    return np.asarray(after <= IN_A_GAP)


def joined(parts: Iterable[AidSamples]) -> AidSamples:
    """One after the other."""
    parts = list(parts)
    received_s = None if all(one.received_s is None for one in parts) else np.concatenate([one.arrived_s for one in parts])
    t_s, values, sigma = (np.concatenate([getattr(one, name) for one in parts]) for name in ("t_s", "values", "sigma"))
    return AidSamples(t_s, values, sigma, received_s, any(one.above_sea for one in parts))


def _waiting(options: Options, aids: Mapping[str, AidSamples], interval_s: float) -> Options:
    """Options whose horizon and queue are long enough for the longest delay."""
    made = copy(options)
    delay_s = max((float(np.max(one.arrived_s - one.t_s, initial=0.0)) for one in aids.values()), default=0.0)
    if made.horizon_s < delay_s:
        # Some rows longer than the longest delay: a sample arrives with the row after it.
        made.horizon_s = delay_s + 2 * interval_s
    if made.horizon_s > 0:
        made.queue_capacity = max(made.queue_capacity, 3 * int(np.ceil(made.horizon_s / interval_s)) + 64)
    return made
