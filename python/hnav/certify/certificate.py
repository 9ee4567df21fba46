"""Stability certificate of a recorded run: Theorem 1 of the paper in a form that can hold, and can fail.

As printed the theorem asks the flow to contract; quaternion kinematics never do, and its dwell condition points the
wrong way (printed_theorem). Here flow and jump are taken together, from just after one correction to just after the
next, and one V = e'Pe is sought that falls by e^{-2 sigma T} at every correction once e is in {V <= level}: the inequality,
its remainders and its solution stand in sampled_data. Only what passed on all corrections is reported. Where a sensor is
missing at corrections, P depends on the place in the window that ends when every sensor was seen (windows).
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np
from scipy.optimize import brentq

from hnav.certify.boundary_starts import BoundaryStarts, fall_from_boundary, random_directions
from hnav.certify.gain_record import GainRecord
from hnav.certify.sampled_data import ATTITUDE, BIAS, LEAST_MARGIN, SampledDataInequality, Solution, flow_matrix
from hnav.errors import HnavRuntimeError

SHARE_OF_RATE = 0.25  # of the linear rate that is kept when the region is sought: the rest pays for the remainders
LONGEST_HOLD_S, BETWEEN = 10.0, 4  # no longer interval is tried; intervals that are checked between two with one P
LONG_INTERVALS = 10.0  # times the usual one: a gap, which a reason names
LARGEST_RADIUS, LEAST_RADIUS = 1.0, 1e-4  # of c: 120 and 0.01 deg
Progress = Callable[[str, int, int], None]  # what, done, of


@dataclass(frozen=True)
class PrintedTheorem:
    """What the theorem asks as printed. d > 0: its block (1,1) is (e^-d - 1) P, negative for every P > 0. d < 0: below."""

    smallest_d: float  # |d| at least, for d < 0: ln(1 + 2 |K| sqrt(eta))
    needed_flow_rate_1_s: float  # contraction that the flow must then have, more than |d|/T
    flow_rate_1_s: float  # what it has
    holds: bool


@dataclass
class Certificate:
    """Figures of a record; NaN where the search did not come so far."""

    name: str
    corrections: int
    interval_s: float  # median
    largest_difference: float  # of library and reference, see gain_record
    certified: bool = False
    reason: str = ""
    longest_window: int = 1  # corrections; more than 1 where a sensor is missing at some
    unfinished: int = 0  # corrections at the end, in a window that did not end: V is bounded there, decay is not claimed
    spectral_rate_1_s: float = np.nan  # of the product over the slowest window: no certificate can exceed it
    rate_1_s: float = np.nan  # of |e| near zero: linear part, one P for all windows
    region_rate_1_s: float = np.nan  # of |e| inside the region, remainders included
    region_deg: float = np.nan  # largest attitude error inside the region
    region_bias_deg_s: float = np.nan  # largest bias error inside
    sure_deg: float = np.nan  # every attitude error below this is inside, if the bias error is zero
    noise_floor_deg: float = np.nan  # bound on the rms attitude error that noise sustains
    noise_share: float = np.nan  # bound on E V over the level of the region; above 1 noise may leave it
    longest_interval_s: float = np.nan  # T_max, linear part: all corrections equally far apart, one P for each interval
    interval_limit_s: float = np.nan  # no T_max can exceed it: there the error grows over a window; NaN if nowhere
    interval_limit_at_s: float = np.nan  # when that window ends
    mixed_interval_s: float = np.nan  # linear part: intervals from the actual one to this in any order, one P
    region_interval_s: float = np.nan  # as T_max with the remainders, in a region of half the radius; no decay asked
    smallest_eigenvalue: float = np.nan  # of all X_k at the radius reported
    tau: np.ndarray | None = None  # places x 9, multipliers, see sampled_data
    P: np.ndarray | None = None  # places x 6 x 6, the first at the ends of windows
    level: float = np.nan
    vertices: int = 0
    solves: int = 0
    seconds: float = np.nan  # that passed; more than those of the processor on a machine with other work
    processor_s: float = np.nan
    free_rate_1_s: np.ndarray = field(default_factory=lambda: np.empty(0))  # see free_rates
    t_s: np.ndarray = field(default_factory=lambda: np.empty(0))
    starts: BoundaryStarts | None = None
    printed: PrintedTheorem | None = None
    attenuation: float = np.nan  # error energy over disturbance energy; needs the truth
    gamma_squared: float = np.nan  # largest in the record: what the attenuation must stay below; infinite without gamma

    def figures(self) -> dict[str, Any]:
        """Plain numbers for JSON and reports; what is not known is None."""
        known = {k: v for k, v in vars(self).items() if k not in ("P", "t_s", "free_rate_1_s", "starts", "printed", "tau")}
        known |= {name: None if value is None else value.tolist() for name, value in (("tau", self.tau), ("P", self.P))}
        known |= {"dwell_ratio": self.longest_interval_s / self.interval_s}
        known |= {
            f"free_rate_{name}_1_s": float(f(self.free_rate_1_s))
            for name, f in (("min", np.min), ("median", np.median))
            if len(self.free_rate_1_s)
        }
        for name in ("starts", "printed"):
            part = getattr(self, name)
            known[name] = None if part is None else {k: v for k, v in vars(part).items() if not isinstance(v, np.ndarray)}
        return {k: None if isinstance(v, float) and not np.isfinite(v) else v for k, v in known.items()}


# --------------------------------------------------------------------------------------------- what needs no solver


def free_rates(record: GainRecord) -> np.ndarray:
    """1/s, one for each correction but the first: -ln |L_k^-1 M_k L_{k-1}| / T with P_k = L_k L_k'.

    The rate at which e'P_k^-1 e falls, P_k the filter's own covariance; it needs one P for each correction, so it
    proves less than a common P, and costs next to nothing. Along q the covariance is zero: six coordinates.
    """
    L = np.linalg.cholesky(np.stack([c.P[1:, 1:] for c in record.corrections]))
    M = np.stack([c.M[1:, 1:] for c in record.corrections])
    factor = np.linalg.norm(np.linalg.solve(L[1:], M[1:] @ L[:-1]), 2, axis=(1, 2))
    return np.asarray(-np.log(factor) / np.array([c.interval_s for c in record.corrections[1:]]))


def printed_theorem(record: GainRecord) -> PrintedTheorem:
    """For d < 0 the printed inequality is e^|d| - 1 = g with g P >= P K K' P + eta I. Some P does exactly when
    g >= 2 |K| sqrt(eta): along the first singular vector of K, g x >= |K|^2 + eta x^2. eta = 8 bounds the remainder of h
    for any two unit quaternions, |h(e)|^2 = 2 |e|^4 <= 8 |e|^2. The flow's error matrix has no eigenvalue off the imaginary axis."""
    gain = max(np.linalg.norm(c.K, 2) for c in record.corrections)
    d = np.log1p(2 * gain * np.sqrt(8.0))
    T = np.median([c.interval_s for c in record.corrections])
    some = record.corrections[:: max(1, len(record.corrections) // 50)]
    flow = -max(np.linalg.eigvals(flow_matrix(c.turns[-1][0])).real.max() for c in some)
    return PrintedTheorem(float(d), float(d / T), 0.0 if abs(flow) < 1e-12 else float(flow), bool(flow > d / T))


# --------------------------------------------------------------------------------------------- searches


Answer = TypeVar("Answer")
Holds = Callable[[float], Answer | None]  # None where a condition does not hold
Best = tuple[float, Answer]  # the value, and what Holds answered there


def largest(
    holds: Holds[Answer], low: float, high: float, probes: int, geometric: bool = True, best: Best[Answer] | None = None
) -> Best[Answer] | None:
    """The largest value for which the function is true, by bisection; best if it is never true."""
    for _ in range(probes):
        middle = np.sqrt(low * high) if geometric else 0.5 * (low + high)
        answer = holds(middle)
        if answer is None:
            high = middle
        else:
            low, best = middle, (middle, answer)
    return best


def largest_below(holds: Holds[Answer], high: float, least: float, probes: int) -> Best[Answer] | None:
    """As largest, between the halves of high: what holds is mostly found in few probes, and the dear ones are those that fail."""
    while high > least:
        answer = holds(high / 2)
        if answer is not None:
            return largest(holds, high / 2, high, probes, best=(high / 2, answer))
        high /= 2
    return None


def largest_from(holds: Holds[Answer], low: float, high: float, growth: float, probes: int) -> float:
    """The largest up to which every value that was tried holds: from low upwards by the factor, then by bisection."""
    while low < high:
        further = min(growth * low, high)
        if holds(further) is None:
            found = largest(holds, low, further, probes)
            return low if found is None else found[0]
        low = further
    return low


# --------------------------------------------------------------------------------------------- the certificate

# The whole search costs as much as so many programs with remainders at this radius, and more for each place in a window.
TRIED_RADIUS, PROGRAMS, PROGRAMS_EACH_PLACE = 1e-2, 80.0, 17.0
PROBES = {"decay rate": 8, "region": 7, "longest interval": 22}  # about: more when the region is small or the interval long


def certify(
    record: GainRecord,
    progress: Progress | None = None,
    starts: int = 100,
    seed: int = 1,
    announce: Callable[[float], None] | None = None,
) -> Certificate:
    """Decay, region, noise floor, dwell and verdict of a record; starts: simulated errors on the boundary of the region.

    announce: gets the time that the search is expected to take, s, before it begins. Raises HnavError for records of fewer than two corrections.
    """
    if len(record.corrections) < 2:
        raise HnavRuntimeError(
            "no data", f"{record.name}: {len(record.corrections)} corrections; a certificate needs two or more"
        )
    if record.restarts:
        raise HnavRuntimeError(
            "no data", f"{record.name}: at {record.restarts[0]:g} s the filter found its attitude again (after a gap of more than a second, or "
            "because the force spoke against its horizon); certify the parts before and after it (--duration, --from)"
        )  # fmt: skip
    begin, processor_begin = time.perf_counter(), time.process_time()
    T = np.array([c.interval_s for c in record.corrections])
    found = Certificate(record.name, len(T), float(np.median(T)), record.largest_difference)
    found.t_s = np.array([c.t_s for c in record.corrections])
    found.free_rate_1_s = free_rates(record)
    found.gamma_squared = max(c.gamma for c in record.corrections) ** 2
    found.printed = printed_theorem(record)
    inequality = SampledDataInequality(record, bias_scale(record))
    if announce:
        announce(expected_seconds(inequality))
    found.reason = _search(found, inequality, progress or (lambda *_: None), starts, seed)
    found.certified = not found.reason
    found.reason += gap_remedy(found, T) if found.reason else ""
    found.vertices, found.solves = max(inequality.programs, default=0), len(inequality.programs)
    found.seconds, found.processor_s = time.perf_counter() - begin, time.process_time() - processor_begin
    return found


def gap_remedy(found: Certificate, T: np.ndarray) -> str:
    """What helps where one interval is far longer than the others; empty where none is."""
    worst = int(np.argmax(T))
    if T[worst] < LONG_INTERVALS * found.interval_s:
        return ""
    return (
        f"; the interval of {T[worst]:.3g} s before {found.t_s[worst]:g} s is {T[worst] / found.interval_s:.0f} times the usual one: certify the "
        "parts before and after it (--duration, --from)"
    )


def expected_seconds(inequality: SampledDataInequality) -> float:
    """How long the search will take, by the time of one program of its kind: within a factor of two or so."""
    begin = time.perf_counter()
    inequality.solve_at_vertices(0.0, TRIED_RADIUS, LEAST_MARGIN)
    return (time.perf_counter() - begin) * (PROGRAMS + PROGRAMS_EACH_PLACE * inequality.windows.places)


def bias_scale(record: GainRecord) -> float:
    """s: how much attitude error goes with a bias error, from the filter's own sigmas at the median."""
    ratios = [np.trace(c.P[1:4, 1:4]) / np.trace(c.P[4:, 4:]) for c in record.corrections]
    return float(np.sqrt(np.median(ratios)))


class _Stages:
    """Reports the progress of the search by the number of programs solved in each stage."""

    def __init__(self, progress: Progress):
        self._progress, self._done = progress, dict.fromkeys(PROBES, 0)

    def counted(self, stage: str, holds: Holds[Answer]) -> Holds[Answer]:
        """holds, and each call is counted."""

        def probe(value: float) -> Answer | None:
            answer = holds(value)
            self._done[stage] += 1
            self._progress(stage, min(self._done[stage], PROBES[stage]), PROBES[stage])
            return answer

        return probe

    def complete(self, stage: str) -> None:
        self._progress(stage, PROBES[stage], PROBES[stage])


def _search(found: Certificate, inequality: SampledDataInequality, progress: Progress, starts: int, seed: int) -> str:
    """Fills in the figures one after the other; returns why there is no certificate, empty if there is one."""
    record = inequality.record
    found.longest_window, found.unfinished = inequality.windows.longest, inequality.windows.unfinished
    radius = spectral_radii(inequality)
    rates = -np.log(radius) / np.diff(np.cumsum(inequality.T)[inequality.windows.ends()], prepend=0)
    found.spectral_rate_1_s = float(rates.min())
    if not found.spectral_rate_1_s > 0:
        return _where_the_error_grows(found, inequality, int(np.argmin(rates)), float(radius[np.argmin(rates)]))

    stages = _Stages(progress)
    rate = largest(stages.counted("decay rate", lambda s: inequality.solve(s, 0.0)), 1e-3 * found.spectral_rate_1_s,
                   found.spectral_rate_1_s * (1 + 1e-9), PROBES["decay rate"], geometric=False)  # fmt: skip
    if rate is None:
        return f"no common P for the linear part, although every single {unit(found)} contracts (slowest {found.spectral_rate_1_s:.3g} 1/s)"
    found.rate_1_s = rate[0]

    sigma = found.region_rate_1_s = SHARE_OF_RATE * found.rate_1_s
    inequality.forget_vertices()
    region = largest_below(stages.counted("region", lambda rho: inequality.solve(sigma, rho)), LARGEST_RADIUS, LEAST_RADIUS, 5)
    if region is None:
        return "no region: the quadratic remainders destroy the decrease for attitude errors of any size that was tried"
    stages.complete("region")
    rho, (P, tau, found.smallest_eigenvalue) = region
    found.P, found.tau = inequality.D @ P @ inequality.D, tau
    _measure_region(found, found.P, inequality, rho)
    _measure_intervals(found, inequality, rho, stages)
    stages.complete("longest interval")
    if starts:
        found.starts = fall_from_boundary(
            record, found.P, inequality.after, found.level, sigma, random_directions(starts, np.random.default_rng(seed)),
            lambda done, of: progress("starts", done, of),
        )  # fmt: skip
        if found.starts.worst_ratio > 1 + 1e-9:
            return f"a simulated start on the boundary exceeds the bound by {found.starts.worst_ratio - 1:.1e}"
    if not found.noise_share < 1:
        return f"noise may leave the region: E V is bounded by {found.noise_share:.3g} times its level only"
    return ""


def spectral_radii(inequality: SampledDataInequality) -> np.ndarray:
    """Of the linear error map of every window."""
    return np.asarray(np.abs(np.linalg.eigvals(inequality.windows.products(inequality.M))).max(axis=1))


def unit(found: Certificate) -> str:
    """What has to contract: a correction, or a window of several."""
    return "correction" if found.longest_window == 1 else "window"


def _where_the_error_grows(found: Certificate, inequality: SampledDataInequality, window: int, radius: float) -> str:
    first, last = inequality.windows.begins()[window], inequality.windows.ends()[window]
    if first == last:
        return f"the error grows at the correction at {found.t_s[last]:g} s: spectral radius of (I - KH) Phi is {radius:.6f}"
    return (
        f"the error grows over the {last - first + 1} corrections from {found.t_s[first]:g} to {found.t_s[last]:g} s, "
        f"in which every sensor is seen: spectral radius of the product of (I - KH) Phi is {radius:.6f}"
    )


def _measure_intervals(found: Certificate, inequality: SampledDataInequality, rho: float, stages: _Stages) -> None:
    """With the gains as they are, from the actual interval upwards; nothing holds beyond LONGEST_HOLD_S, for nothing is tried there."""
    T = found.interval_s

    def growing(t: float) -> np.ndarray:
        return spectral_radii(inequality.with_interval(t))

    limit = largest_from(lambda t: t if growing(t).max() < 1 else None, T, LONGEST_HOLD_S, 2.0, 10)
    if limit < LONGEST_HOLD_S:
        found.interval_limit_s = float(limit)
        found.interval_limit_at_s = float(found.t_s[inequality.windows.ends()[np.argmax(growing(1.01 * limit))]])

    def mixed(t: float) -> Solution | None:
        answer = inequality.and_interval(t).solve(0.0, 0.0)
        if answer is None:
            return None
        between = (inequality.with_interval(x) for x in np.linspace(T, t, BETWEEN + 2)[1:-1])
        return None if any(at.smallest_eigenvalues(*answer[:2], 0.0, 0.0).min() < 0 for at in between) else answer

    def constant(t: float, radius: float) -> Solution | None:
        changed = inequality.with_interval(t)
        answer = changed.solve(0.0, radius)
        inequality.vertices = changed.vertices  # where the next interval begins
        return answer

    def longest(holds: Holds[Solution]) -> Holds[Solution]:
        return stages.counted("longest interval", holds)

    inequality.forget_vertices()
    found.longest_interval_s = float(largest_from(longest(lambda t: constant(t, 0.0)), T, limit, 2.0, 5))
    inequality.forget_vertices()
    found.mixed_interval_s = float(largest_from(longest(mixed), T, found.longest_interval_s, 2.0, 5))
    found.region_interval_s = float(largest_from(longest(lambda t: constant(t, 0.5 * rho)), T, found.longest_interval_s, 2.0, 2))


def _measure_region(found: Certificate, P: np.ndarray, inequality: SampledDataInequality, rho: float) -> None:
    """Level, size and noise of {e'Pe <= level}, at every place in a window, chosen so that c <= rho also while the error flows."""
    P_inverse = np.linalg.inv(P)
    attitude, bias = (float(np.sqrt(np.max(np.linalg.eigvalsh(P_inverse[:, part, part])))) for part in (ATTITUDE, BIAS))

    def farthest(size: float) -> float:
        """c before the next correction: |d| = sin(angle / 2), and a bias error adds at most T/2 |e_b|."""
        return float(2 * np.sin(0.5 * np.arcsin(size * attitude)) + 0.5 * inequality.T.max() * size * bias)

    size = brentq(lambda x: farthest(x) - rho, 0, min(1, rho) / attitude)
    found.level = float(size**2)
    found.region_deg = float(np.degrees(2 * np.arcsin(size * attitude)))
    found.region_bias_deg_s = float(np.degrees(size * bias))
    found.sure_deg = float(np.degrees(2 * np.arcsin(min(1, size / np.sqrt(np.linalg.eigvalsh(P[:, ATTITUDE, ATTITUDE]).max())))))
    floor = 0.0
    for c, after in zip(inequality.record.corrections, inequality.after):
        G, F = (c.J @ c.K)[1:], (c.J @ c.IKH)[1:]
        injected = float(np.trace(P[after] @ (G @ c.R @ G.T + F @ c.Q @ F.T)))
        floor = max(floor, float(injected / -np.expm1(-2 * found.region_rate_1_s * c.interval_s)))
    found.noise_share = float(floor / found.level)
    found.noise_floor_deg = float(np.degrees(2 * np.sqrt(floor) * attitude))
