"""Decides whether rates without a stated unit are rad/s or deg/s, also for bodies that hardly turn.

Evidence, in order: the rotation of gravity and field against that of the rates; a bias too large for any gyroscope; noise. A chip of a telephone has
0.004 to 0.03 deg/s/sqrt(Hz) (datasheets of BMI088, ICM-20948, LSM6DSO, MPU-6050, L3GD20), a tactical one 0.0007 or more: numbers with a
noise density between SILENT and LOUD may be either unit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hnav.io.findings import Samples
from hnav.io.turning import integral

WINDOWS_S = {"mag": (0.1, 0.5, 2.0, 8.0), "accel": (0.1, 0.5, 2.0)}
"""Window lengths. In longer ones a coordinated turn of an aircraft leaves the force constant in the body."""
STEP_S = 0.02
AS_RAD, AS_DEG = (0.5, 2.0), (0.5 / 57.3, 2.0 / 57.3)
"""Ratio of the observed rotation to that of the rates in rad/s."""
SURE = 0.85
"""Least correlation of the observed rotation with that of the rates."""
LEAST_TURNING = 0.004
"""Rotation in rad over a window that noise of gravity and field can imitate."""
STOOD_STILL, NOISE_RAD, TURNED = 0.06, 0.003, (0.03, 1.0)
"""Largest share of the integrated rotation that is observed when the body turned 57 times less; margin for noise in rad; least
and largest integrated rotation in rad. A body that turns further within a window may return to its attitude."""
ASKEW = 0.06
"""Angle in rad by which the vector may seem to lie beside itself: an accelerometer bias of 0.6 m/s2, axes that are 3 deg off. A body that turns
about the vector by an angle seems to turn by so much of it across, and is not seen to."""
FIELD_TURNED, AS_FAST = 0.05, 0.3
"""Rotation of the field in rad over a window, more than passing iron causes, and its least share of the rotation in rad/s."""
LARGEST_BIAS = 0.35
"""Rate noise that as rad/s would be 20 deg/s, the largest in the data sheet of the MPU-6050."""
STAYED = 0.95
"""Smallest ratio of the mean over an eighth of the recording to the magnitude, for a vector that stays in the body. The mean
of a body that turns repeatedly is small."""
SILENT, LOUD = 5e-4, 2.6e-3
"""Numbers per sqrt(Hz): as deg/s below the best tactical gyroscopes, as rad/s five times the noise of the worst chips."""
SHAKEN_M_S2, SLOW = 0.3, 0.6
"""With a force that varies as much, a body that as deg/s never turned faster than this would be implausible: the rates are rad/s.
"""
ENOUGH = 8  # windows


@dataclass(frozen=True)
class Evidence:
    """The unit of the rates, with the reason."""

    unit: str | None
    """rad/s, deg/s, or None: nothing decides."""
    because: str


def unit_of_rates(live: Samples, time_factor: float = 1.0) -> Evidence:
    """Decides for samples whose rates were read as rad/s."""
    gyro_s, rate = live["gyro"][0] * time_factor, live["gyro"][1]
    shaken = "accel" in live and float(np.max(live["accel"][1].std(axis=0))) > SHAKEN_M_S2
    if shaken and float(np.quantile(np.abs(rate).max(axis=1), 0.99)) < SLOW:
        return Evidence("rad/s", "the body is shaken, and in deg/s would never turn")
    for sensor, windows_s in WINDOWS_S.items():
        if sensor not in live:
            continue
        t_s, vector = live[sensor][0] * time_factor, live[sensor][1]
        both_s = max(gyro_s[0], t_s[0]), min(gyro_s[-1], t_s[-1])
        turned = integral(gyro_s, rate, t_s)
        for window_s in windows_s:
            if evidence := _turning(t_s, vector, turned, both_s, window_s, sensor == "mag"):
                return evidence
    if evidence := _steady(rate, live):
        return evidence
    return Evidence(None, "the body is shaken") if shaken else _by_noise(gyro_s, rate)


def _turning(
    t_s: np.ndarray, vector: np.ndarray, turned: np.ndarray, both_s: tuple[float, float], window_s: float, is_field: bool
) -> Evidence | None:
    """The observed rotation of a vector over windows against the integrated rates, without their mean, while both are there."""
    begin_s, end_s = both_s
    count = int((end_s - begin_s) / window_s)
    if count < ENOUGH or count > len(t_s):
        return None
    edges_s = begin_s + window_s * np.arange(count + 1)
    means = _means(t_s, vector, edges_s)
    size = float(np.median(np.linalg.norm(means, axis=1)))
    if not size > 0 or not np.isfinite(means).all():
        return None
    unit = means / size
    # Of both the means: a swing that is faster than the windows leaves neither.
    angle = np.diff(_means(t_s, turned, edges_s), axis=0)
    # Small angles: dv = v x theta.
    turning = np.cross(unit[:-1], angle)
    said = np.cross(unit[:-1], angle - np.median(angle, axis=0))
    askew = ASKEW * float(np.sqrt(((unit[:-1] * angle).sum(axis=1) ** 2).mean()))
    return _by_turning(np.diff(unit, axis=0), turning, said, askew, window_s, is_field)


def _rms(vectors: np.ndarray) -> float:
    return float(np.sqrt((vectors**2).sum(axis=1).mean()))


def _by_turning(
    seen: np.ndarray, turning: np.ndarray, said: np.ndarray, askew: float, window_s: float, is_field: bool
) -> Evidence | None:
    """Changes of a unit vector over windows: observed, and predicted by the rates in rad/s, with and without their mean. askew: what errors
    of the vector's direction may predict."""
    said_rms, seen_rms = _rms(said), _rms(seen)
    if seen_rms < NOISE_RAD + STOOD_STILL * said_rms and TURNED[0] + askew < said_rms < TURNED[1]:
        because = (
            f"as rad/s it would have turned {57.3 * said_rms:.2g} deg every {window_s:g} s, and turned {57.3 * seen_rms:.2g}"
        )
        return Evidence("deg/s", because)
    if seen_rms < LEAST_TURNING or not said_rms > 0:
        return None
    if is_field and seen_rms > max(FIELD_TURNED, AS_FAST * _rms(turning)):
        # Independent of the axes: in deg/s the field would turn 57 times as fast as the body.
        return Evidence("rad/s", "the field turns as fast")
    seen = seen - seen.mean(axis=0)  # the rates are centred too
    correlation = float((said * seen).sum() / (np.linalg.norm(said) * np.linalg.norm(seen)))
    scale = float((said * seen).sum() / (said**2).sum())
    if correlation > SURE and AS_RAD[0] < scale < AS_RAD[1]:
        return Evidence("rad/s", "they turn as they say")
    if correlation > SURE and AS_DEG[0] < scale < AS_DEG[1]:
        return Evidence("deg/s", f"it turned {scale:.3f} times as far as they say in rad/s")
    return None


def _density(gyro_s: np.ndarray, rate: np.ndarray) -> float:
    """Noise density of the quietest axis, in the unit of the rates per sqrt(Hz), from differences of samples."""
    steps = np.diff(rate, axis=0)
    sigma = 1.4826 * np.median(np.abs(steps - np.median(steps, axis=0)), axis=0) / np.sqrt(2)
    return float(sigma.min() * np.sqrt(2 * np.median(np.diff(gyro_s))))


def _by_noise(gyro_s: np.ndarray, rate: np.ndarray) -> Evidence:
    density = _density(gyro_s, rate)
    if density > LOUD:
        because = f"a body that hardly turns has a noise of {density:.2g} per sqrt(Hz), and no gyroscope as much in rad/s"
        return Evidence("deg/s", because)
    if 0 < density < SILENT:
        return Evidence("rad/s", "no gyroscope is as silent in deg/s")
    return Evidence(None, "the body hardly turns, and its noise may be of either")


def _steady(rate: np.ndarray, live: Samples) -> Evidence | None:
    """Whether a mean rate perpendicular to gravity or field, which these do not follow, is larger than any bias."""
    # The median is not moved by spikes, the mean not by a swing that is faster one way than back.
    middle, mean = np.median(rate, axis=0), rate.mean(axis=0)
    for sensor in ("accel", "mag"):
        if sensor in live:
            t_s, vector = live[sensor]
            count = len(vector) // ENOUGH
            means = vector[: count * ENOUGH].reshape(ENOUGH, count, 3).mean(axis=1)
            lengths = np.linalg.norm(means, axis=1, keepdims=True)
            if float(np.min(lengths)) < STAYED * float(np.median(np.linalg.norm(vector, axis=1))):
                continue
            unit = means / lengths
            across = min(float(np.median(np.linalg.norm(np.cross(unit, of), axis=1))) for of in (middle, mean))
            seen = float(np.max(np.linalg.norm(np.diff(unit, axis=0), axis=1))) * ENOUGH / float(t_s[-1] - t_s[0])
            if across > LARGEST_BIAS and seen < 0.2 * across:
                return Evidence("deg/s", f"a mean of {across:.2g} would turn the body on and on in rad/s, and it did not turn")
    return None


def _means(t_s: np.ndarray, values: np.ndarray, edges_s: np.ndarray) -> np.ndarray:
    """Means of the samples between consecutive edges; NaN where there are none."""
    places = np.searchsorted(t_s, edges_s)
    sums = np.concatenate([np.zeros((1, 3)), np.cumsum(values, axis=0)])[places]
    counts = np.diff(places)[:, None]
    return np.asarray(np.where(counts > 0, np.diff(sums, axis=0) / np.maximum(counts, 1), np.nan))
