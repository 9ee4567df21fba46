"""Noise of sensors at rest: still parts of recordings, their overlapping Allan deviation, and the noise parameters fitted to it with their confidence.

    found = noise_of([hnav.read("night.csv")])
    found["gyro"].terms["white"].value         # rad/s/sqrt(Hz), of each axis
    hnav.write_sensor("sensor.json", figures(found))

Model of the Allan variance (IEEE Std 952, annex C): N^2 / tau + (2 ln 2 / pi) B^2 + K^2 tau / 3, with the density N of white noise, the bias
instability B and the random walk K. Confidence is by the degrees of freedom of each octave of tau.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hnav.errors import HnavValueError
from hnav.io.recordings import ARRAYS, Recording
from hnav.native.arrays import Array, stretches
from hnav.units import G_M_S2

WINDOW_S = 0.5
STILL = {"gyro": np.radians(1.0), "accel": 0.3}
"""Standard deviation within a window, rad/s and m/s2: above it the body moves or vibrates, whatever the sensor."""
QUIET = 3.0
"""Factor on the median of the still windows above which a window is disturbed: somebody touched the table."""
TURNS_RAD_S = np.radians(1.0)
"""Distance of the mean rate of a window from the median of all: above it the body turns evenly."""
LEAST_S = 20.0
"""Shortest still part: a shorter one determines the white noise only."""
PART_OF_LENGTH = 5
"""The longest tau as a share of the longest still part."""
FIRST = 8
"""Samples in the shortest tau that is fitted: chips filter faster noise."""
DRAWS = 400
"""Number of random draws of the points, for the confidence of the fitted parameters."""
COLOURED = 0.4
"""Share of the degrees of freedom where noise is not white: there Haar's octaves depend on each other. Chosen so that the bounds hold in 95 %
of simulated sensors."""
CONFIDENCE = (0.025, 0.975)
FLICKER = 2 * math.log(2) / math.pi
TERMS = ("white", "instability", "walk")
DEG = math.pi / 180
ENTRIES: dict[str, dict[str, tuple[str, str, float]]] = {
    "gyro": {"white": ("noise", "deg/s/sqrt(Hz)", DEG), "instability": ("bias_instability", "deg/h", DEG / 3600),
             "walk": ("random_walk", "deg/h/sqrt(h)", DEG / 3600 / 60)},
    "accel": {"white": ("noise", "ug/sqrt(Hz)", 1e-6 * G_M_S2), "instability": ("bias_instability", "ug", 1e-6 * G_M_S2),
              "walk": ("random_walk", "ug/sqrt(h)", 1e-6 * G_M_S2 / 60)},
    "mag": {"white": ("noise", "nT/sqrt(Hz)", 1e-9), "instability": ("bias_instability", "nT", 1e-9),
            "walk": ("random_walk", "nT/sqrt(h)", 1e-9 / 60)},
}  # fmt: skip
"""Of a sensor file: entry, unit, and that unit in SI."""


@dataclass(frozen=True)
class Term:
    """A parameter of the noise, for each of three axes, in SI: x/sqrt(Hz), x, or x/sqrt(s), with x rad/s, m/s2 or T."""

    value: Array
    """3."""
    low: Array
    """3: the lower end of 95 %; 0 where the recording is too short to distinguish it from 0."""
    high: Array
    """3: the upper end."""

    @property
    def is_measured(self) -> np.ndarray:
        """3: whether the recording measures it, and not only an upper limit."""
        return self.low > 0

    @property
    def mean(self) -> float:
        """Root mean square over the axes, NaN where one of them is not measured."""
        return float(np.sqrt(np.mean(self.value**2))) if self.is_measured.all() else math.nan


@dataclass(frozen=True)
class SensorNoise:
    """The noise of one sensor."""

    rate_hz: float
    """Of its samples."""
    length_s: float
    """Of all still parts."""
    tau_s: Array
    """m."""
    deviation: Array
    """m x 3: overlapping Allan deviation."""
    degrees: Array
    """m x 3: degrees of freedom of each point."""
    terms: dict[str, Term]
    """By name, of TERMS."""

    def fitted(self) -> Array:
        """m x 3: the deviation of the model."""
        values = np.stack([self.terms[name].value for name in TERMS])
        return np.asarray(np.sqrt(_columns(self.tau_s) @ values**2))


def still_parts(recording: Recording) -> dict[str, list[tuple[Array, Array]]]:
    """Times and samples of each sensor while the body was still, in one piece each. Raises HnavValueError where there are none."""
    found: dict[str, list[tuple[Array, Array]]] = {sensor: [] for sensor in ARRAYS}
    for begin_s, end_s in still_stretches(recording, LEAST_S):
        for sensor in ARRAYS:
            t_s, values = recording.samples(sensor)
            rows = (t_s >= begin_s) & (t_s < end_s)
            if rows.sum() > LEAST_S:
                found[sensor].append((t_s[rows], values[rows]))
    if not found["gyro"]:
        raise HnavValueError(
            "no data", f"{recording.name}: no part of {LEAST_S:g} s in which the body is still: leave it lying longer"
        )
    return found


def still_stretches(recording: Recording, least_s: float) -> list[tuple[float, float]]:
    """Begin and end of the parts of so long in which the body is still."""
    windows = np.arange(recording.t_s[0], recording.t_s[-1], WINDOW_S)
    still = np.ones(len(windows), bool)
    for sensor, limit in STILL.items():
        mean, deviation = _windows(*recording.samples(sensor), windows)
        still &= deviation < limit
        if still.any():
            still &= deviation < QUIET * np.median(deviation[still])
        if still.any() and sensor == "gyro":
            still &= np.linalg.norm(mean - np.median(mean[still], axis=0), axis=1) < TURNS_RAD_S
    spans = [(float(windows[first]), float(windows[end - 1] + WINDOW_S)) for first, end in stretches(still)]
    return [(begin_s, end_s) for begin_s, end_s in spans if end_s - begin_s >= least_s]


def _windows(t_s: Array, values: Array, begins: Array) -> tuple[Array, Array]:
    """Mean (m x 3) and standard deviation (m, largest axis) of the samples of each window; infinite where there are few."""
    places = np.searchsorted(t_s, np.append(begins, begins[-1] + WINDOW_S if len(begins) else 0.0))
    count = np.diff(places)[:, None]
    sums, squares = (np.concatenate([np.zeros((1, 3)), np.cumsum(v, axis=0)])[places] for v in _centred(values))
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.diff(sums, axis=0) / count
        variance = np.diff(squares, axis=0) / count - mean**2
    return mean, np.where(count[:, 0] > 5, np.sqrt(np.maximum(variance, 0)).max(axis=1), np.inf)


def _centred(values: Array) -> tuple[Array, Array]:
    middle = values - (np.median(values, axis=0) if len(values) else 0.0)
    return middle, middle**2


def noise_of(recordings: Sequence[Recording], seed: int = 1) -> dict[str, SensorNoise]:
    """The noise of each sensor, by all still parts of all recordings of one device. seed: of the draws for the confidence. Raises
    HnavValueError where there is no still part, or allantools is missing."""
    parts: dict[str, list[tuple[Array, Array]]] = {}
    for recording in recordings:
        for sensor, of in still_parts(recording).items():
            parts.setdefault(sensor, []).extend(of)
    return {sensor: _noise(of, np.random.default_rng(seed)) for sensor, of in parts.items() if of}


def _noise(parts: Sequence[tuple[Array, Array]], rng: np.random.Generator) -> SensorNoise:
    interval_s = float(np.median(np.concatenate([np.diff(t_s) for t_s, _ in parts])))
    longest = max(len(t_s) for t_s, _ in parts)
    factors = 2 ** np.arange(0, max(1, int(np.log2(longest / PART_OF_LENGTH))) + 1)
    variance, degrees = _allan(parts, factors, 1 / interval_s)
    tau_s = np.asarray(factors * interval_s, float)
    slow = factors >= min(FIRST, factors[-1])
    terms = [_fit(tau_s[slow], variance[slow, axis], degrees[slow, axis], rng) for axis in range(3)]
    parts_of_term = ("value", "low", "high")
    joined = {name: Term(*(np.array([getattr(of[name], part)[0] for of in terms]) for part in parts_of_term)) for name in TERMS}
    length_s = sum(len(t_s) for t_s, _ in parts) * interval_s
    return SensorNoise(1 / interval_s, length_s, tau_s, np.asarray(np.sqrt(variance), float), degrees, joined)


def _allan(parts: Sequence[tuple[Array, Array]], factors: np.ndarray, rate_hz: float) -> tuple[Array, Array]:
    """m x 3 each: variance, and degrees of freedom; parts count by what they add. The latter are those of octaves of Haar's wavelets, which
    are independent: those of overlapping variances, added, would count every sample twice."""
    try:
        import allantools
    except ImportError:
        raise HnavValueError(
            "option", "the Allan deviation needs allantools: python -m pip install allantools (the extra 'noise')"
        ) from None
    total, weight = np.zeros((len(factors), 3)), np.zeros((len(factors), 1))
    for _, values in parts:
        usable = factors[factors <= len(values) // PART_OF_LENGTH]
        if not len(usable):
            continue
        found = [allantools.oadev(column, rate=rate_hz, data_type="freq", taus=usable / rate_hz)[1] ** 2 for column in values.T]
        freedom = (len(values) / (2 * usable))[:, None]
        total[: len(usable)] += freedom * np.stack(found, axis=1)
        weight[: len(usable)] += freedom
    kept = weight[:, 0] > 0
    variance = np.full_like(total, np.nan)
    variance[kept] = total[kept] / weight[kept]
    return variance, np.repeat(weight, 3, axis=1)


def _columns(tau_s: Array) -> Array:
    """m x 3: what a unit of N^2, B^2 and K^2 adds to the variance."""
    return np.stack([1 / tau_s, np.full(len(tau_s), FLICKER), tau_s / 3], axis=1)


def _fit(tau_s: Array, variance: Array, degrees: Array, rng: np.random.Generator) -> dict[str, Term]:
    """Least squares with squares that are not negative, each point by its degrees of freedom; confidence by drawing the points again."""
    from scipy.optimize import nnls

    columns = _columns(tau_s)

    def solve(points: Array, expected: Array) -> Array:
        weight = np.sqrt(degrees / 2) / expected
        scale = np.linalg.norm(weight[:, None] * columns, axis=0)
        return np.asarray(nnls(weight[:, None] * columns / scale, weight * points)[0] / scale)

    squares = solve(variance, variance)
    for _ in range(3):  # weights by the model, not by points that happen to be small
        squares = solve(variance, columns @ squares)
    expected = columns @ squares
    freedom = np.where(columns[:, 0] * squares[0] > 0.5 * expected, degrees, COLOURED * degrees)
    draws = np.array([solve(expected * rng.chisquare(freedom) / freedom, expected) for _ in range(DRAWS)])
    low, high = np.quantile(draws, CONFIDENCE, axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        # What is drawn is as far from what was fitted as this is from the truth, by its factor. Where it may be none, a larger truth would
        # scatter more than what is drawn.
        ends = np.where(low > 0, [squares**2 / high, squares**2 / low], [0 * high, squares + 2 * np.maximum(high - squares, 0)])
    value, low, high = np.sqrt(squares), *np.sqrt(ends)
    return {name: Term(value[i : i + 1], low[i : i + 1], high[i : i + 1]) for i, name in enumerate(TERMS)}


def figures(found: Mapping[str, SensorNoise]) -> dict[str, dict[str, Any]]:
    """Of each sensor the figures that the recordings give, as entries of a sensor file, in units of datasheets."""
    made: dict[str, dict[str, Any]] = {}
    for sensor, noise in found.items():
        made[sensor] = {"period": {"value": float(f"{1e3 / noise.rate_hz:.6g}"), "unit": "ms"}}
        for term, (entry, unit, si) in ENTRIES[sensor].items():
            if np.isfinite(value := noise.terms[term].mean):
                made[sensor][entry] = {"value": float(f"{value / si:.4g}"), "unit": unit}
    return made
