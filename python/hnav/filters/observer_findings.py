"""What stands out in an observer's run, as intervals of time: unknown inputs and parameters away from their usual value, bounds that are
active, samples beyond their gate, innovations larger than stated.

    for finding in findings(run, plan):
        print(finding.sentence(run.t_s[0]))
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hnav.filters.observer import ObserverRun
from hnav.filters.observer_plan import Plan
from hnav.native.arrays import Array, stretches

SIGMAS = 3.0  # beyond which something is away from its usual value
SURE = 5.0  # that it has to reach: of thousands of samples some are beyond 3 sigma
WINDOW = 50  # samples of a mean of NIS, as the observer's own
MAX_MEAN = 1.79  # 99.9 % of such means lie below
LARGE = 10.8  # 99.9 % of NIS lie below
HUGE = 100.0  # ten sigma
_REST = 20  # samples in between end an interval of single ones
_CLOCK_S = 1e8  # times beyond are those of a clock since 1970
_HALF = (2 / (np.pi - 2)) ** 0.5  # mean over sigma of the half of a Gaussian
_SPREAD = 1.4826  # sigma of a Gaussian over its median deviation


@dataclass(frozen=True)
class Finding:
    """An interval in which something of a run was unusual."""

    name: str
    """Of what is estimated, or the sensors."""
    kind: str
    """"away", "at its bound", "beyond its gate" or "larger than stated"."""
    start_s: float
    """Of its first row."""
    end_s: float
    """Of its last."""
    what: str
    """What was unusual."""

    def sentence(self, origin_s: float = 0.0) -> str:
        """In words, times from the origin on, and of the day for those of a clock since 1970."""
        return f"{self.what} from {moment(self.start_s, origin_s)} to {moment(self.end_s, origin_s)}"


def moment(t_s: float, origin_s: float = 0.0) -> str:
    """A time in words."""
    told = f"{t_s - origin_s:.6g} s"
    if t_s < _CLOCK_S:
        return told
    return f"{told} ({time.strftime('%Y-%m-%d %H:%M:%S', time.gmtime(t_s))} UTC)"


def findings(run: ObserverRun, plan: Plan) -> list[Finding]:
    """In the order of time. What is estimated is looked at where it may change, that is, has noise; its usual value is the median of
    the run, or 0 of an unknown input with a time constant."""
    found = [*_away(run, plan), *_bounded(run, plan)]
    for name, sensor in plan.sensors.items():
        found += _gated(run, name, sensor.gate_nis)
    found += _large(run, [*plan.sensors])
    return sorted(found, key=lambda one: (one.start_s, one.name))


def _away(run: ObserverRun, plan: Plan) -> Iterator[Finding]:
    for name, known in {**plan.unknown_inputs, **plan.parameters}.items():
        x, sigma = run.x[name], run.sigma[name]
        if known.noise == 0 or len(x) == 0:
            continue
        usual = 0.0 if known.time_constant_s > 0 else float(np.median(x))
        # A value that wanders by more than its sigma is not away wherever it has wandered to.
        spread = _SPREAD * float(np.median(np.abs(x - usual)))
        away = np.abs(x - usual) / np.maximum(np.maximum(sigma, spread), 1e-300)
        for first, last in _between(away, SIGMAS):
            if not np.max(away[first : last + 1]) > SURE:
                continue
            peak = x[first + int(np.argmax(away[first : last + 1]))]
            what = f"{name} was beyond {SIGMAS:g} sigma of its usual {usual:.3g}, at most {peak:.3g},"
            yield Finding(name, "away", float(run.t_s[first]), float(run.t_s[last]), what)


def _bounded(run: ObserverRun, plan: Plan) -> Iterator[Finding]:
    """Where half or more of a Gaussian lies beyond a bound: what is left of it is less than 1.32 of its sigmas from there in the mean."""
    for name, known in {**plan.states, **plan.unknown_inputs, **plan.parameters}.items():
        for bound, word in ((known.min, "min"), (known.max, "max")):
            if not np.isfinite(bound) or known.log:
                continue
            rows = np.flatnonzero(np.abs(run.x[name] - bound) < _HALF * run.sigma[name])
            for group in _groups(rows, np.ones(len(run.t_s), bool)):
                what = f"{name} was at its {word} {bound:g} in {len(group)} rows: the samples alone would lead beyond,"
                yield Finding(name, "at its bound", float(run.t_s[group[0]]), float(run.t_s[group[-1]]), what)


def _between(values: Array, above: float) -> list[tuple[int, int]]:
    """First and last rows of intervals above a limit."""
    return [(first, end - 1) for first, end in stretches(np.asarray(values > above))]


def _gated(run: ObserverRun, name: str, gate: float) -> Iterator[Finding]:
    """Samples that the gate has used with more noise: it does where the estimate was ready before."""
    nis = run.nis[name]
    was_ready = np.concatenate([[False], run.ready[:-1]]) if len(nis) else run.ready
    hit = (nis > gate) & was_ready if gate > 0 else np.zeros(len(nis), bool)
    for rows in _groups(np.flatnonzero(hit), np.isfinite(nis)):
        count = f"{len(rows)} sample{'s' * (len(rows) > 1)}"
        what = f"{name}: {count} beyond the gate"
        yield Finding(name, "beyond its gate", float(run.t_s[rows[0]]), float(run.t_s[rows[-1]]), what)


def _groups(rows: npt.NDArray[np.intp], used: npt.NDArray[np.bool_]) -> Iterator[npt.NDArray[np.intp]]:
    """Rows that lie near each other, counted in those that are used."""
    place = np.cumsum(used)
    for group in np.split(rows, np.flatnonzero(np.diff(place[rows]) > _REST) + 1):
        if len(group):
            yield group


def _single(run: ObserverRun, rows: npt.NDArray[np.intp], names: list[str]) -> str:
    """What may help where a few are beyond 10 sigma and most of those around them fit; "" elsewhere."""
    around = slice(max(0, rows[0] - WINDOW), rows[-1] + WINDOW)
    for name in names:
        nis = run.nis[name][around]
        nis = nis[np.isfinite(nis)]
        if len(nis) and np.max(nis) > HUGE and np.median(nis) < 2:
            return '; most around fit: outliers want gate_nis, jumps of a stiff plant propagation = "sigma_points"'
    return ""


def _large(run: ObserverRun, names: list[str]) -> Iterator[Finding]:
    """Where the mean of WINDOW squares is larger than 99.9 % of such means: the large ones among them, of all sensors."""
    hits, worst = np.zeros(len(run.t_s), bool), np.zeros(len(run.t_s))
    of = dict[str, npt.NDArray[np.bool_]]()
    for name in names:
        samples = np.flatnonzero(np.isfinite(run.nis[name]))
        of[name] = np.zeros(len(run.t_s), bool)
        if len(samples) < WINDOW:
            continue
        nis = run.nis[name][samples]
        sums = np.concatenate([[0.0], np.cumsum(nis)])
        means = (sums[WINDOW:] - sums[:-WINDOW]) / WINDOW
        for first, last in _between(means, MAX_MEAN):
            rows = samples[first : last + WINDOW]
            large = rows[run.nis[name][rows] > LARGE]
            of[name][large if len(large) else rows] = True
            worst[rows] = np.maximum(worst[rows], means[first : last + 1].max())
        hits |= of[name]
    for rows in _groups(np.flatnonzero(hits), np.ones(len(hits), bool)):
        inside = slice(rows[0], rows[-1] + 1)
        who = ", ".join(name for name in names if of[name][inside].any())
        what = f"{who}: innovations larger than stated (mean NIS of {WINDOW} up to {np.max(worst[inside]):.1f}{_single(run, rows, names)})"
        yield Finding(who, "larger than stated", float(run.t_s[rows[0]]), float(run.t_s[rows[-1]]), what)
