"""Simulated vehicles with exact truth, and the sensors in them: a car, an aircraft, a ship, a body at rest that sways.

recording, truth = vehicle("car", "industrial", seed)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import convolve1d
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from hnav.filters.ins import Aids, InsOptions
from hnav.native.arrays import Array
from hnav.reference import earth

RATE_HZ = 100
WARM_S = 20.0
"""The filter is switched on after so long, in motion."""
OUTLIERS = 0.01
"""Share of the fixes that lie far off."""

Levels = Callable[[], float]


@dataclass(frozen=True)
class Truth:
    """Where the body is at the times of the samples."""

    t_s: Array
    """n."""
    position_e: Array
    """n x 3: Earth-centred, Earth-fixed."""
    velocity_e: Array
    """n x 3: in the same axes."""
    attitude_e: Rotation
    """n: body to these axes."""

    def heading_rad(self) -> Array:
        """n: of body x, clockwise from north."""
        axes = earth.axes_at(earth.place_of(self.position_e))
        ahead = np.einsum("nij,ni->nj", axes, self.attitude_e.apply([1.0, 0, 0]))
        heading: Array = np.arctan2(ahead[:, 1], ahead[:, 0])
        return heading


@dataclass(frozen=True)
class Samples:
    """What the sensors of a body give."""

    t_s: Array
    """n."""
    rate_b_rad_s: Array
    """n x 3."""
    force_b_m_s2: Array
    """n x 3."""
    aids: Aids


def vehicle(kind: str, grade: str, seed: int, duration_s: float = 150.0) -> tuple[Samples, Truth]:
    """Samples from the moment on at which the filter is switched on, and the truth at their times.

    kind: car, aircraft, ship or rest; grade: a preset of the filter. Everything follows from kind, grade, duration and seed.
    """
    rng = np.random.default_rng([seed, 7])
    t = np.arange(int((duration_s + WARM_S) * RATE_HZ) + 1) / RATE_HZ
    place = np.array([rng.uniform(-1.2, 1.2), rng.uniform(-3, 3), 50.0])
    velocity, attitude = MOTIONS[kind](rng, t)
    d = np.vstack([np.zeros(3), np.cumsum(0.5 * (velocity[1:] + velocity[:-1]) / RATE_HZ, axis=0)])
    axes = earth.axes_at(place)
    truth = Truth(t, earth.position_of(place) + d @ axes.T, velocity @ axes.T, Rotation.from_matrix(axes @ attitude.as_matrix()))
    rate, force = ideal(truth)
    rate, force = real(rng, rate, force, InsOptions(grade))
    begin = int(WARM_S * RATE_HZ)
    aids = satellites(rng, truth, begin) if kind != "rest" else Aids()
    kept = slice(begin, None)
    at = Truth(t[kept], truth.position_e[kept], truth.velocity_e[kept], truth.attitude_e[kept])
    return Samples(t[kept], rate[kept], force[kept], aids), at


# --------------------------------------------------------------------------------------------- motions


def smooth(values: Array, samples: int) -> Array:
    """A mean over so many samples on either side, with soft edges."""
    window = np.hanning(2 * samples + 1)[1:-1]
    smoothed: Array = convolve1d(values, window / window.sum(), mode="nearest")
    return smoothed


def stairs(rng: np.random.Generator, t: Array, levels: Levels, hold_s: tuple[float, float]) -> Array:
    """Levels that are each held for a random time."""
    values, begin = np.zeros(len(t)), 0.0
    while begin < t[-1]:
        end = begin + rng.uniform(*hold_s)
        values[(t >= begin) & (t < end)] = levels()
        begin = end
    return values


Motion = tuple[Array, Rotation]


def _along(speed: Array, heading: Array, climb: Array, roll: Array, pitch: Array) -> Motion:
    """The velocity north-east-down of a body that moves where it points, and its attitude."""
    ahead = speed * np.cos(climb)
    velocity = np.stack([ahead * np.cos(heading), ahead * np.sin(heading), -speed * np.sin(climb)], 1)
    return velocity, Rotation.from_euler("ZYX", np.stack([heading, pitch, roll], 1))


def _course(rng: np.random.Generator, rate: Array) -> Array:
    heading: Array = rng.uniform(-np.pi, np.pi) + np.cumsum(rate) / RATE_HZ
    return heading


def car(rng: np.random.Generator, t: Array) -> Motion:
    """Stops, goes and turns as in a town."""
    n, white = len(t), RATE_HZ**0.5
    speed = smooth(stairs(rng, t, lambda: rng.choice([0.0, 5.0, 9.0, 14.0, 20.0]), (6, 20)), 2 * RATE_HZ)
    turns = stairs(rng, t, lambda: rng.choice([0.0, 0, 0, 1, -1]) * rng.uniform(0.1, 0.35), (3, 8))
    rate = smooth(turns, RATE_HZ) * np.minimum(1, speed / 5)
    roll = smooth(0.01 * rng.standard_normal(n) * white, RATE_HZ) + 0.02
    return _along(speed, _course(rng, rate), 0 * t, roll, smooth(0.02 * rng.standard_normal(n) * white, 2 * RATE_HZ))


def aircraft(rng: np.random.Generator, t: Array) -> Motion:
    """Banks into its turns, climbs and sinks."""
    speed = rng.uniform(25, 85) + smooth(stairs(rng, t, lambda: rng.uniform(-5, 5), (10, 30)), 3 * RATE_HZ)
    banks = stairs(rng, t, lambda: rng.choice([0.0, 0, 1, -1]) * rng.uniform(0.1, 0.6), (8, 30))
    bank = smooth(banks, 2 * RATE_HZ)
    pitch = smooth(stairs(rng, t, lambda: rng.uniform(-0.1, 0.15), (10, 25)), 3 * RATE_HZ)
    return _along(speed, _course(rng, 9.8 * np.tan(bank) / speed), pitch, bank, pitch)


def ship(rng: np.random.Generator, t: Array) -> Motion:
    """Slow, in a swell."""
    speed = smooth(stairs(rng, t, lambda: rng.uniform(2, 9), (30, 90)), 15 * RATE_HZ)
    rate = smooth(stairs(rng, t, lambda: rng.choice([0.0, 1, -1]) * rng.uniform(0.01, 0.04), (20, 60)), 5 * RATE_HZ)
    roll = rng.uniform(0.02, 0.12) * np.sin(2 * np.pi * t / rng.uniform(7, 12) + rng.uniform(0, 6))
    pitch = rng.uniform(0.01, 0.05) * np.sin(2 * np.pi * t / rng.uniform(5, 9))
    velocity, attitude = _along(speed, _course(rng, rate), 0 * t, roll, pitch)
    velocity[:, 2] += rng.uniform(0.2, 0.6) * np.cos(2 * np.pi * t / 8)
    return velocity, attitude


def rest(rng: np.random.Generator, t: Array) -> Motion:
    """Stands on something that sways by millimetres."""

    def sway(size: float) -> Array:
        waves = [rng.standard_normal() * np.sin(2 * np.pi * f * t + rng.uniform(0, 6)) for f in (0.15, 0.4, 1.1, 3.0)]
        swayed: Array = size * np.sum(waves, axis=0)
        return swayed

    speed, roll, pitch = sway(2e-3), rng.uniform(-0.1, 0.1) + sway(3e-4), rng.uniform(-0.1, 0.1) + sway(3e-4)
    return _along(speed, rng.uniform(-np.pi, np.pi) + sway(3e-4), 0 * t, roll, pitch)


MOTIONS: dict[str, Callable[[np.random.Generator, Array], Motion]] = {
    "car": car,
    "aircraft": aircraft,
    "ship": ship,
    "rest": rest,
}

# --------------------------------------------------------------------------------------------- sensors


def ideal(truth: Truth) -> tuple[Array, Array]:
    """Rate and force (n x 3) whose values, held over the interval before each time, bring the truth about."""
    T, earth_rate = 1 / RATE_HZ, np.array([0, 0, earth.RATE_RAD_S])
    before, after = truth.attitude_e[:-1], truth.attitude_e[1:]
    turn = (before.inv() * Rotation.from_rotvec(earth_rate * T) * after).as_rotvec()
    v = truth.velocity_e
    acceleration = np.diff(v, axis=0) / T - earth.gravity_at(truth.position_e[:-1]) + 2 * np.cross(earth_rate, v[:-1])
    force = np.linalg.solve(_mean_turn(turn), before.inv().apply(acceleration)[..., None])[..., 0]
    return np.vstack([turn[:1], turn]) / T, np.vstack([force[:1], force])


def _mean_turn(turn: Array) -> Array:
    """n x 3 x 3: the mean over [0, 1] of the rotation by s turn, to fourth order."""
    K = np.zeros((len(turn), 3, 3))
    x, y, z = turn.T
    K[:, 0, 1], K[:, 0, 2], K[:, 1, 0], K[:, 1, 2], K[:, 2, 0], K[:, 2, 1] = -z, y, z, -x, -y, x
    K2 = K @ K
    mean: Array = np.eye(3) + K / 2 + K2 / 6 + K @ K2 / 24 + K2 @ K2 / 120
    return mean


def real(rng: np.random.Generator, rate: Array, force: Array, grade: InsOptions) -> tuple[Array, Array]:
    """With the errors of scale and axes, the white noise, the bias at the start and its walk that the preset tells."""

    def noise(white: float, start: float, walk: float) -> Array:
        n = len(rate)
        bias = start * rng.standard_normal(3) + np.cumsum(walk * RATE_HZ**-0.5 * rng.standard_normal((n, 3)), axis=0)
        noisy: Array = bias + white * RATE_HZ**0.5 * rng.standard_normal((n, 3))
        return noisy

    axes = np.eye(3) + np.diag(grade.start_sigma_gyro_scale * rng.standard_normal(3))
    axes += grade.gyro_scale * rng.standard_normal((3, 3)) * (1 - np.eye(3))
    return (
        rate @ axes.T
        + noise(grade.gyro_noise_rad_per_sqrt_s, grade.start_sigma_gyro_bias_rad_s, grade.gyro_bias_walk_rad_s_per_sqrt_s),
        force + noise(grade.accel_noise_m_s_per_sqrt_s, grade.start_sigma_accel_bias_m_s2, grade.accel_bias_walk_m_s2_per_sqrt_s),
    )


def satellites(rng: np.random.Generator, truth: Truth, begin: int) -> Aids:
    """Five fixes a second: white and slow errors, some that lie far off, and a latency that nobody tells."""
    rows = np.arange(begin + 1, len(truth.t_s), RATE_HZ // 5)
    n, latency_s = len(rows), rng.uniform(0, 0.1)
    keep = np.exp(-0.2 / 60)
    drive = np.vstack([1.5 * rng.standard_normal((1, 3)), 1.5 * np.sqrt(1 - keep**2) * rng.standard_normal((n - 1, 3))])
    slow = lfilter([1], [1, -keep], drive, axis=0)
    place = earth.place_of(truth.position_e[rows])
    axes = earth.axes_at(place)
    off, v_off = slow + 0.5 * rng.standard_normal((n, 3)), 0.1 * rng.standard_normal((n, 3))
    bad = rng.random(n) < OUTLIERS
    off[bad] += 20 * rng.standard_normal((bad.sum(), 3))
    v_off[bad] += 2 * rng.standard_normal((bad.sum(), 3))
    seen = earth.place_of(truth.position_e[rows] + np.einsum("nij,nj->ni", axes, off))
    velocity = np.einsum("nij,ni->nj", axes, truth.velocity_e[rows]) + v_off
    t = truth.t_s[rows] + latency_s
    return Aids().velocity(t, velocity, 0.1).position(t, seen[:, 0], seen[:, 1], seen[:, 2], 0.5)
