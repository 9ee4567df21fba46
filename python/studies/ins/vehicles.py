"""Simulated vehicles with exact truth, and the sensors in them.

recording, truth = vehicle("car", "industrial", seed)
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from hnav import earth
from hnav.filters.ins import Ins
from hnav.filters.ins_aids import Aids
from hnav.filters.options import Options
from hnav.native.arrays import Array, BoolArray
from hnav.native.library import SENSORS
from studies.ins.motions import AT_REST, MOTIONS, RATE_HZ, WARM_S

OUTLIERS = 0.01  # share of the fixes that lie far off
EARTH_M = 6.37e6  # radius that turns metres into latitude, about


@dataclass(frozen=True)
class Receiver:
    """Satellites as a kind of vehicle has them; standard deviations of each axis."""

    rate_hz: int = 5
    colour_m: float = 1.5  # of the position, over a minute
    noise_m: float = 0.5
    noise_m_s: float = 0.1
    swing_m_s: float = 0.0  # of the velocity, over three seconds


RECEIVERS = {"walker": Receiver(1, 3.0, 2.0, 0.2, 0.1)}


def receiver(kind: str) -> Receiver:
    """Of a vehicle of this kind."""
    return RECEIVERS.get(kind, Receiver())


def filter_of(kind: str, grade: str, **options: object) -> Ins:
    """For a vehicle of this kind: with the size of the slow error of its satellites."""
    colour_m = receiver(kind).colour_m
    return Ins(grade, solver="closed_form", position_colour_m=(colour_m, colour_m), **options)


MISALIGNED_RAD = {"consumer": 2e-3, "industrial": 3e-5, "tactical": 3e-5, "navigation": 3e-6}
"""Of simulated gyroscopes, which were aligned with care. The presets allow for more."""


def sensors_of(grade: str) -> Options:
    """The errors of simulated sensors: those of the preset, with axes that are better aligned."""
    return Options("ins", grade, start_sigma_gyro_misalignment_rad=MISALIGNED_RAD[grade])


CONING = (113 / 840, -13 / 420, 1 / 280)
"""Shares of the products with the three turns before, newest first: they leave of a steady coning its seventh order."""


def latitude_at_rest(kind: str) -> float:
    """Of a kind that stands, in rad."""
    return float(np.radians(80.0 if kind == "polar" else 45.0))


VIBRATION = dict.fromkeys(("quadrotor", "hover"), (0.05, 3.0))
"""What of it samples show, at the most: rad/s and m/s2 of each axis."""


@dataclass(frozen=True)
class Truth:
    """Where the body is at the times of the samples."""

    t_s: Array  # n
    position_e: Array  # n x 3: Earth-centred, Earth-fixed
    velocity_e: Array  # n x 3: in the same axes
    attitude_e: Rotation  # n: body to these axes

    def heading_rad(self) -> Array:
        """n: of body x, clockwise from north."""
        axes = earth.axes_at(earth.place_of(self.position_e))
        ahead = np.einsum("nij,ni->nj", axes, self.attitude_e.apply([1.0, 0, 0]))
        return np.asarray(np.arctan2(ahead[:, 1], ahead[:, 0]))

    def in_rows(self, rows: slice | Array) -> Truth:
        """At some of the times."""
        return Truth(self.t_s[rows], self.position_e[rows], self.velocity_e[rows], self.attitude_e[rows])


@dataclass(frozen=True)
class Samples:
    """What the sensors of a body give."""

    t_s: Array  # n
    rate_b_rad_s: Array  # n x 3
    force_b_m_s2: Array  # n x 3
    aids: Aids

    def arrays(self) -> tuple[Array, Array, Array, Aids]:
        """The first arguments of Ins.run."""
        return self.t_s, self.rate_b_rad_s, self.force_b_m_s2, self.aids

    def without_fixes(self, hit: BoolArray) -> Samples:
        """Without these of the velocities and positions."""
        valid, _received, sensor, value = self.aids.arrays()
        return replace(self, aids=fixes(valid[~hit], sensor[~hit], value[~hit]))


def starts_of(seed: int, runs: int) -> range:
    """The numbers of so many starts."""
    return range(seed * 1_000_000, seed * 1_000_000 + runs)


def vehicle(kind: str, grade: str, seed: int, duration_s: float = 150.0, magnetometer: bool = False) -> tuple[Samples, Truth]:
    """Samples from the moment on at which the filter is switched on, and the truth at their times.

    kind: one of MOTIONS; grade: a preset of the filter; magnetometer: with fields of one. Everything follows from these, the
    duration and the seed; a magnetometer changes nothing else.
    """
    rng = np.random.default_rng([seed, 7])
    t = np.arange(int((duration_s + WARM_S) * RATE_HZ) + 1) / RATE_HZ
    place = np.array([rng.uniform(-1.2, 1.2), rng.uniform(-3, 3), 50.0])
    if kind in AT_REST:
        place[0] = latitude_at_rest(kind)
    velocity, attitude = MOTIONS[kind](rng, t)
    d = np.vstack([np.zeros(3), np.cumsum(0.5 * (velocity[1:] + velocity[:-1]) / RATE_HZ, axis=0)])
    axes = earth.axes_at(place)
    truth = Truth(t, earth.position_of(place) + d @ axes.T, velocity @ axes.T, Rotation.from_matrix(axes @ attitude.as_matrix()))
    rate, force = ideal(truth)
    sensors = sensors_of(grade)
    rate, force = real(rng, rate, force, sensors)
    if kind in VIBRATION:
        sizes = rng.uniform(0.1, 1) * np.array(VIBRATION[kind])
        rate, force = (y + size * shaken(rng, y.shape, sensors.vibration_share) for y, size in zip((rate, force), sizes))
    begin = int(WARM_S * RATE_HZ)
    aids = satellites(rng, truth, begin, receiver(kind)) if kind not in AT_REST else Aids()
    kept = slice(begin, None)
    at = truth.in_rows(kept)
    if magnetometer:
        aids.mag(*fields(np.random.default_rng([seed, 8]), at))
    return Samples(t[kept], rate[kept], force[kept], aids), at


# --------------------------------------------------------------------------------------------- sensors


def ideal(truth: Truth) -> tuple[Array, Array]:
    """Rate and force (n x 3) that sensors which integrate read: the means over the interval before each time."""
    T, earth_rate = 1 / RATE_HZ, np.array([0, 0, earth.RATE_RAD_S])
    before, after = truth.attitude_e[:-1], truth.attitude_e[1:]
    turn = (before.inv() * Rotation.from_rotvec(earth_rate * T) * after).as_rotvec()
    v = truth.velocity_e
    acceleration = np.diff(v, axis=0) / T - earth.gravity_at(truth.position_e[:-1]) + 2 * np.cross(earth_rate, v[:-1])
    gain = T * np.linalg.solve(_mean_turn(turn), before.inv().apply(acceleration)[..., None])[..., 0]
    # Turn and gain are what, held, brings the truth about; sensors miss of them what axes that move within the interval add.
    coning, sculling = np.zeros_like(turn), np.zeros_like(gain)
    for k, share in enumerate(CONING, 1):
        coning[k:] += share * np.cross(turn[:-k], turn[k:])
        sculling[k:] += share * (np.cross(turn[:-k], gain[k:]) + np.cross(gain[:-k], turn[k:]))
    rate, force = (turn - coning) / T, (gain - sculling) / T
    return np.vstack([rate[:1], rate]), np.vstack([force[:1], force])


def _mean_turn(turn: Array) -> Array:
    """n x 3 x 3: the mean over [0, 1] of the rotation by s turn, to fourth order."""
    K = np.zeros((len(turn), 3, 3))
    x, y, z = turn.T
    K[:, 0, 1], K[:, 0, 2], K[:, 1, 0], K[:, 1, 2], K[:, 2, 0], K[:, 2, 1] = -z, y, z, -x, -y, x
    K2 = K @ K
    return np.asarray(np.eye(3) + K / 2 + K2 / 6 + K @ K2 / 24 + K2 @ K2 / 120)


def real(rng: np.random.Generator, rate: Array, force: Array, grade: Options) -> tuple[Array, Array]:
    """With the errors of scale and axes, the white noise, the start bias and its walk of the preset."""

    def noise(white: float, start: float, walk: float) -> Array:
        n = len(rate)
        bias = start * rng.standard_normal(3) + np.cumsum(walk * RATE_HZ**-0.5 * rng.standard_normal((n, 3)), axis=0)
        return np.asarray(bias + white * RATE_HZ**0.5 * rng.standard_normal((n, 3)))

    axes = np.eye(3) + np.diag(grade.start_sigma_gyro_scale * rng.standard_normal(3))
    axes += grade.start_sigma_gyro_misalignment_rad * rng.standard_normal((3, 3)) * (1 - np.eye(3))
    return (
        rate @ axes.T
        + noise(grade.gyro_noise_rad_per_sqrt_s, grade.start_sigma_gyro_bias_rad_s, grade.gyro_bias_walk_rad_s_per_sqrt_s),
        force + noise(grade.accel_noise_m_s_per_sqrt_s, grade.start_sigma_accel_bias_m_s2, grade.accel_bias_walk_m_s2_per_sqrt_s),
    )


def shaken(rng: np.random.Generator, shape: tuple[int, ...], white: float) -> Array:
    """Noise of variance 1, of which this share is white; the rest, of sensors that integrate, leaves nothing in the sum of samples.
    0: the sensor is on dampers, and there is none."""
    noise: Array = np.sqrt(white) * rng.standard_normal(shape)
    if 0 < white < 1:
        noise += np.sqrt((1 - white) / 2) * np.diff(rng.standard_normal((shape[0] + 1, *shape[1:])), axis=0)
    return noise


def satellites(rng: np.random.Generator, truth: Truth, begin: int, of: Receiver) -> Aids:
    """Fixes with white and slow errors, outliers, and an unknown latency."""
    rows = np.arange(begin + 1, len(truth.t_s), RATE_HZ // of.rate_hz)
    n, latency_s = len(rows), rng.uniform(0, 0.1)
    slow = _fading(rng, n, of.colour_m, 60 * of.rate_hz)
    place = earth.place_of(truth.position_e[rows])
    axes = earth.axes_at(place)
    off, v_off = slow + of.noise_m * rng.standard_normal((n, 3)), of.noise_m_s * rng.standard_normal((n, 3))
    bad = rng.random(n) < OUTLIERS
    off[bad] += 20 * rng.standard_normal((bad.sum(), 3))
    v_off[bad] += 2 * rng.standard_normal((bad.sum(), 3))
    if of.swing_m_s > 0:
        v_off += _fading(rng, n, of.swing_m_s, 3 * of.rate_hz)
    seen = earth.place_of(truth.position_e[rows] + np.einsum("nij,nj->ni", axes, off))
    velocity = np.einsum("nij,ni->nj", earth.axes_at(seen), truth.velocity_e[rows]) + v_off
    t = truth.t_s[rows] + latency_s
    return Aids().velocity(t, velocity, of.noise_m_s).position(t, seen[:, 0], seen[:, 1], seen[:, 2], of.noise_m)


def fixes(valid_s: Array, sensor: np.ndarray, value: Array, received_s: Array | None = None) -> Aids:
    """The velocities and positions of Aids.arrays, as aids again; received_s: None for at once."""
    received_s = valid_s if received_s is None else received_s
    velocity, position = (sensor == SENSORS.index(kind) for kind in ("velocity", "position"))
    aids = Aids().velocity(valid_s[velocity], value[velocity, :3], value[velocity, 3:], received_s[velocity])
    place = value[position, :3]
    return aids.position(valid_s[position], place[:, 0], place[:, 1], place[:, 2], value[position, 3:], received_s[position])


def arriving(samples: Samples, late_s: Array | float) -> Samples:
    """Stamps that name the time of arrival, so long after that of validity: of all fixes, or of each."""
    valid, _received, sensor, value = samples.aids.arrays()
    return replace(samples, aids=fixes(valid + late_s, sensor, value))


def fields(rng: np.random.Generator, truth: Truth) -> tuple[Array, Array]:
    """Times (m) and fields (m x 3) of an uncalibrated magnetometer, ten a second: hard iron of up to one and a half times the
    horizontal field, soft iron, an unknown declination, steel beside the path; for one in four a false field of the same size as the
    true one for half a minute."""
    rows = np.arange(1, len(truth.t_s), RATE_HZ // 10)
    n, dip = len(rows), rng.uniform(0.9, 1.25)
    axes = earth.axes_at(earth.place_of(truth.position_e[rows]))
    points = 0.1 * rng.standard_normal() + _fading(rng, n, 0.03, 200)[:, 0]
    true = np.stack([np.cos(points), np.sin(points), np.full(n, np.tan(dip))], 1)
    seconds = truth.t_s[rows] - truth.t_s[0]
    begin, false, iron = rng.uniform(10, 60), rng.standard_normal(3), rng.standard_normal(3)
    disturbed = (seconds > begin) & (seconds < begin + 30) & (rng.random() < 0.25)
    true += disturbed[:, None] * false / np.linalg.norm(false)
    body = truth.attitude_e[rows].inv().apply(np.einsum("nij,nj->ni", axes, true))
    soft = np.eye(3) + 0.03 * rng.standard_normal((3, 3))
    hard = rng.uniform(0, 1.5) * iron / np.linalg.norm(iron)
    return truth.t_s[rows], 20e-6 * (body @ soft.T + hard + 0.02 * rng.standard_normal((n, 3)))


def _fading(rng: np.random.Generator, n: int, sigma: float, samples: float) -> Array:
    """n x 3 of a Gauss-Markov error that fades within so many samples."""
    keep = np.exp(-1 / samples)
    drive = np.vstack([sigma * rng.standard_normal((1, 3)), sigma * np.sqrt(1 - keep**2) * rng.standard_normal((n - 1, 3))])
    return np.asarray(lfilter([1], [1, -keep], drive, axis=0))
