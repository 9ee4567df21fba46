"""The set MOTION: bodies that are held in a hand, walk, swim, fly and drive, simulated with exact truth.

recording = motion("boat", 3)

Rates are derivatives of angles: what the samples of the gyroscope turn by is what the truth turns by. The field is true, but for
white noise. A start is at rest or in the midst of the motion, and amplitudes, periods and sensors are drawn, all by the seed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from hnav import earth
from hnav.io.aids import AidSamples
from hnav.io.recordings import Recording
from hnav.native.arrays import Array
from studies.ins.motions import MOTIONS, RATE_HZ, Motion, smooth, stairs, turned_on, walked
from studies.ins.vehicles import Truth, ideal, real, sensors_of

MOTION = "MOTION"
LENGTH_S, WARM_S, REST_S = 120.0, 15.0, 6.0
SCORED_S = 10.0  # from so long after the beginning on
FIELD_T, DIP_RAD, FIELD_NOISE_T = 48e-6, 1.15, 3e-7
SPEED_HZ, SPEED_SIGMA_M_S = 1, 0.3
GRADES = ("consumer", "industrial")  # presets of the INS that the sensors are drawn from
GAINS_M_S2 = 2.0  # what a body that starts from rest accelerates by, at the most and about
ENU = Rotation.from_matrix([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]])


def _waves(rng: np.random.Generator, t: Array, sizes: tuple[float, ...], hz: tuple[float, float], count: int = 3) -> Array:
    """n x len(sizes): sums of sines of random frequencies, each axis of about this amplitude."""
    made = np.zeros((len(t), len(sizes)))
    for i, size in enumerate(sizes):
        for _ in range(count):
            made[:, i] += rng.uniform(0.4, 1) * np.sin(2 * np.pi * rng.uniform(*hz) * t + rng.uniform(0, 2 * np.pi))
        made[:, i] *= size / np.sqrt(count)
    return made


def _place(place: Array, angles: Array, held: Rotation | None = None) -> Motion:
    """The motion of a body whose place and roll, pitch, yaw are given."""
    attitude: Rotation = Rotation.from_euler("ZYX", angles[:, ::-1])
    return np.gradient(place, 1 / RATE_HZ, axis=0), attitude if held is None else attitude * held


def _held(rng: np.random.Generator) -> Rotation:
    return Rotation.from_euler("ZYX", rng.uniform([-3, -1, -1], [3, 1, 1]))


def head(rng: np.random.Generator, t: Array) -> Motion:
    """A headset: looks about, leans."""
    looks = smooth(stairs(rng, t, lambda: rng.uniform(-1.2, 1.2), (0.8, 3)), RATE_HZ // 3)
    angles = _waves(rng, t, (0.1, 0.25, 0.1), (0.1, 0.6))
    angles[:, 2] += looks
    return _place(_waves(rng, t, (0.08, 0.08, 0.03), (0.1, 0.7)), angles)


def arm(rng: np.random.Generator, t: Array) -> Motion:
    """A wrist that reaches about, in bouts."""
    bouts = smooth(stairs(rng, t, lambda: rng.uniform(0.1, 1), (3, 10)), RATE_HZ)[:, None]
    place, angles = bouts * _waves(rng, t, (0.25, 0.25, 0.2), (0.2, 1.2)), bouts * _waves(rng, t, (0.8, 0.6, 0.8), (0.15, 1.0))
    return _place(place, angles, _held(rng))


def tumble(rng: np.random.Generator, t: Array) -> Motion:
    """A body that is turned over and over in the hands."""
    rate = _waves(rng, t, (1.2, 1.2, 1.2), (0.05, 0.4))
    attitude = turned_on(Rotation.identity(), Rotation.from_rotvec(rate[1:] / RATE_HZ))
    return np.gradient(_waves(rng, t, (0.1, 0.1, 0.1), (0.1, 0.8)), 1 / RATE_HZ, axis=0), attitude


def waist(rng: np.random.Generator, t: Array) -> Motion:
    """On the belt of somebody who walks, stands and turns."""
    speed, course, steps = walked(rng, t)
    phase = 2 * np.pi * rng.uniform(0.8, 1.0) * t  # of the steps
    ahead, aside = speed + 0.12 * steps * np.sin(2 * phase), 0.1 * steps * np.sin(phase)
    velocity = np.stack([ahead * np.cos(course) - aside * np.sin(course), ahead * np.sin(course) + aside * np.cos(course),
                         0.3 * steps * np.sin(2 * phase + 1)], 1)  # fmt: skip
    angles = np.stack([0.05 * steps * np.sin(phase), 0.04 * steps * np.sin(2 * phase), course + 0.08 * steps * np.sin(phase)], 1)
    return velocity, Rotation.from_euler("ZYX", angles[:, ::-1]) * _held(rng)


def foot(rng: np.random.Generator, t: Array) -> Motion:
    """On a shoe: it stands while the other foot swings."""
    speed, course, steps = walked(rng, t)
    phase = 2 * np.pi * rng.uniform(0.8, 1.0) * t  # of the steps
    swing = np.maximum(0, np.sin(phase)) ** 2  # a quarter in the mean
    ahead = 4 * speed * swing
    velocity = np.stack([ahead * np.cos(course), ahead * np.sin(course), -0.8 * steps * swing * np.sin(2 * phase)], 1)
    pitch = 0.6 * steps * swing * np.sin(2 * phase - 0.5)
    return velocity, Rotation.from_euler("ZYX", np.stack([course, pitch, 0.1 * steps * swing], 1))


def boat(rng: np.random.Generator, t: Array) -> Motion:
    """A small boat in waves."""
    speed = smooth(stairs(rng, t, lambda: rng.uniform(0, 5), (15, 40)), 3 * RATE_HZ)
    turns = stairs(rng, t, lambda: rng.choice([0.0, 0, 1, -1]) * rng.uniform(0.05, 0.2), (5, 15))
    course = rng.uniform(-np.pi, np.pi) + np.cumsum(smooth(turns, RATE_HZ)) / RATE_HZ
    angles = _waves(rng, t, (rng.uniform(0.05, 0.2), rng.uniform(0.03, 0.1), 0.05), (0.15, 0.4))
    angles[:, 2] += course
    swell = np.gradient(_waves(rng, t, (0.2, 0.2, rng.uniform(0.1, 0.5)), (0.15, 0.3)), 1 / RATE_HZ, axis=0)
    ahead = np.stack([np.cos(course), np.sin(course), 0 * t], 1)
    return speed[:, None] * ahead + swell, Rotation.from_euler("ZYX", angles[:, ::-1])


KINDS: dict[str, Callable[[np.random.Generator, Array], Motion]] = {
    "head": head, "arm": arm, "tumble": tumble, "waist": waist, "foot": foot, "boat": boat,
    **{name: MOTIONS[name] for name in ("quadrotor", "car", "ship", "aircraft", "walker")},
}  # fmt: skip


BODIES = {
    "head": "hand", "arm": "hand", "tumble": "hand", "waist": "walker", "foot": "walker", "walker": "walker", "boat": "ship",
    "ship": "ship", "quadrotor": "quadrotor", "car": "car", "aircraft": "aircraft",
}  # fmt: skip
"""The option body of the AHRS for each kind."""
ALONG_X = ("boat", "car", "ship", "aircraft")  # kinds that move where body x points: their recordings have its speed


def motion(kind: str, seed: int, grade: str | None = None) -> Recording:
    """A recording of two minutes with its true attitude. Even seeds begin at rest, odd ones in the midst of the motion.

    grade: of the sensors, one of GRADES; None: drawn. The motion is the same with any.
    """
    entropy = [seed, sum(map(ord, kind))]
    if grade is None:
        grade = GRADES[int(np.random.default_rng([*entropy, 1]).integers(len(GRADES)))]
    rng = np.random.default_rng(entropy)
    t = np.arange(int((LENGTH_S + WARM_S) * RATE_HZ) + 1) / RATE_HZ
    velocity, attitude = KINDS[kind](rng, t)
    kept = slice(int(WARM_S * RATE_HZ), None)
    t, velocity, attitude = t[kept] - WARM_S, velocity[kept], attitude[kept]
    if seed % 2 == 0:
        velocity, attitude = _from_rest(t, velocity, attitude)
    place = np.array([0.85, 0.2, 100.0])
    axes = earth.axes_at(place)
    way = np.vstack([np.zeros(3), np.cumsum(0.5 * (velocity[1:] + velocity[:-1]) / RATE_HZ, axis=0)])
    turned = Rotation.from_matrix(axes) * attitude
    truth = Truth(t, earth.position_of(place) + way @ axes.T, velocity @ axes.T, turned)
    rate, force = real(rng, *ideal(truth), sensors_of(grade))
    field_n = FIELD_T * np.array([np.cos(DIP_RAD), 0, np.sin(DIP_RAD)])
    field = attitude.inv().apply(field_n) + rng.normal(0, FIELD_NOISE_T, (len(t), 3))
    reference = (ENU * attitude).as_quat(scalar_first=True)
    aids = {}
    if kind in ALONG_X:
        ahead = np.sum(velocity * attitude.apply([1.0, 0, 0]), axis=1)
        aids["speed"] = _measured_speed(np.random.default_rng([seed, 7]), t, ahead)
    return Recording(f"{kind} {seed} {grade}", t, rate, force, field, reference_q_nb=reference, movement=t > SCORED_S, aids=aids)


def _measured_speed(rng: np.random.Generator, t: Array, ahead_m_s: Array) -> AidSamples:
    """Of the velocity along body x, as a GNSS receiver measures it."""
    rows = slice(None, None, RATE_HZ // SPEED_HZ)
    measured = ahead_m_s[rows] + rng.normal(0, SPEED_SIGMA_M_S, len(t[rows]))
    return AidSamples(t[rows], measured[:, None], np.full((len(measured), 1), SPEED_SIGMA_M_S))


def _from_rest(t: Array, velocity: Array, attitude: Rotation) -> Motion:
    """The same motion after a rest: for some seconds the body stands where it begins, then time goes ever faster to its pace."""
    within_s = max(4.0, np.max(np.linalg.norm(velocity, axis=1)) / GAINS_M_S2)
    pace = smooth(np.clip((t - REST_S) / within_s, 0, 1), RATE_HZ)
    at = np.cumsum(pace) / RATE_HZ
    moved = np.stack([np.interp(at, t, axis) for axis in velocity.T], 1) * pace[:, None]
    return moved, Slerp(t, attitude)(np.minimum(at, t[-1]))


def motions(seeds: Iterable[int]) -> list[Recording]:
    """Of each kind one recording a seed."""
    return [motion(kind, seed) for kind in KINDS for seed in seeds]


SENSOR = {
    "gyro_noise_rad_per_sqrt_s": "gyro_noise_rad_per_sqrt_s",
    "gyro_rate_noise_sqrt_s": "gyro_rate_noise_sqrt_s",
    "gyro_bias_walk_rad_s_per_sqrt_s": "gyro_bias_walk_rad_s_per_sqrt_s",
    "start_sigma_bias_rad_s": "start_sigma_gyro_bias_rad_s",
    "start_sigma_gyro_scale": "start_sigma_gyro_scale",
    "start_sigma_gyro_misalignment_rad": "start_sigma_gyro_misalignment_rad",
    "start_sigma_accel_bias_m_s2": "start_sigma_accel_bias_m_s2",
}
"""Options of the AHRS that a datasheet states, and the entries of a preset of the INS, by which `real` makes the samples."""


def sensor_of(recording: Recording) -> dict[str, float]:
    """The datasheet of its sensors as options; none for recordings that are not simulated here."""
    if kind_of(recording) not in KINDS:
        return {}
    grade = sensors_of(recording.name.rpartition(" ")[2])
    return {option: getattr(grade, entry) for option, entry in SENSOR.items()}


def kind_of(recording: Recording) -> str:
    return recording.name.partition(" ")[0]


def body_of(recording: Recording) -> str:
    """The option body for it; recordings of BROAD were held in a hand."""
    return BODIES.get(kind_of(recording), "hand")
