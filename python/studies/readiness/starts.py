"""Simulated starts: recordings whose truth is exact.

Attitude from angles that are sums of sines (roll, pitch, yaw, on a random mounting), so truth is exact; a gyro that
integrates over its interval, as real ones do (gyro_hold = backward), with white noise and a constant bias; specific force
with motion accelerations; a field measured some milliseconds before its time stamp.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from hnav.io.recordings import Recording

RATE_HZ = 100.0
DURATION_S = 60.0
GRAVITY_M_S2 = 9.81

Range = tuple[float, float]


class Wave(NamedTuple):
    """A sum of sines: amplitude, rad/s and phase of each (k)."""

    amplitude: np.ndarray
    pulsation_rad_s: np.ndarray
    phase_rad: np.ndarray

    def __call__(self, t_s: np.ndarray) -> np.ndarray:
        return np.asarray(np.sin(np.multiply.outer(t_s, self.pulsation_rad_s) + self.phase_rad) @ self.amplitude)


def draw_wave(rng: np.random.Generator, amplitude: Range, frequency_hz: Range, terms: int = 3) -> Wave:
    """The terms share the amplitude and have frequencies of their own."""
    share = rng.dirichlet(np.ones(terms))
    return Wave(rng.uniform(*amplitude) * share, 2 * np.pi * rng.uniform(*frequency_hz, terms), rng.uniform(0, 2 * np.pi, terms))


def smooth_step(x: np.ndarray) -> np.ndarray:
    """From 0 below 0 to 1 above 1."""
    x = np.clip(x, 0, 1)
    return np.asarray(x * x * (3 - 2 * x))


class Kind(NamedTuple):
    """A way of moving: amplitudes and frequencies of roll and pitch, of yaw, and of the acceleration on each axis."""

    tilt_deg: Range
    tilt_hz: Range
    yaw_deg: Range
    yaw_hz: Range
    level_m_s2: Range
    vertical_m_s2: Range
    shake_hz: Range


MOTIONS = {
    "rest": Kind((0, 0), (1, 1), (0, 0), (1, 1), (0, 0), (0, 0), (1, 1)),
    "hand-held": Kind((10, 40), (0.2, 0.8), (10, 60), (0.1, 0.6), (0.3, 1.5), (0.3, 1.5), (0.5, 2.0)),
    "walking": Kind((5, 15), (0.8, 2.0), (20, 120), (0.03, 0.2), (0.5, 1.5), (1.5, 4.0), (1.5, 2.2)),
    "fast turning": Kind((30, 80), (0.3, 0.8), (90, 240), (0.3, 0.8), (0.5, 3.0), (0.5, 3.0), (0.5, 2.0)),
}


@dataclass(frozen=True)
class Motion:
    """Attitude and acceleration at any time; it begins at begin_s and grows to its size within a second."""

    begin_s: float
    mounting: Rotation
    yaw_rad: float
    angles_rad: tuple[Wave, Wave, Wave]  # yaw, pitch, roll
    acceleration_m_s2: tuple[Wave, Wave, Wave]  # east, north, up

    def size(self, t_s: np.ndarray) -> np.ndarray:
        return smooth_step(t_s - self.begin_s)

    def attitude(self, t_s: np.ndarray) -> Rotation:
        """Body to east-north-up."""
        angles = np.stack([wave(t_s) for wave in self.angles_rad], axis=1) * self.size(t_s)[:, None]
        return Rotation.from_euler("ZYX", angles + [self.yaw_rad, 0, 0]) * self.mounting

    def acceleration(self, t_s: np.ndarray) -> np.ndarray:
        """n x 3, in east-north-up."""
        return np.asarray(np.stack([wave(t_s) for wave in self.acceleration_m_s2], axis=1) * self.size(t_s)[:, None])


def draw_motion(rng: np.random.Generator, kind: Kind) -> Motion:
    """Half of the starts move from the first sample on, the others rest for up to 5 s."""

    def angle(size_deg: Range, frequency_hz: Range) -> Wave:
        return draw_wave(rng, (np.radians(size_deg[0]), np.radians(size_deg[1])), frequency_hz)

    # The order of the draws is part of what a seed means.
    pitch, roll = angle(kind.tilt_deg, kind.tilt_hz), angle(kind.tilt_deg, kind.tilt_hz)
    yaw = angle(kind.yaw_deg, kind.yaw_hz)
    east, north = draw_wave(rng, kind.level_m_s2, kind.shake_hz), draw_wave(rng, kind.level_m_s2, kind.shake_hz)
    up = draw_wave(rng, kind.vertical_m_s2, kind.shake_hz)
    begin_s = -1.0 if rng.random() < 0.5 else rng.uniform(0, 5)
    return Motion(begin_s, Rotation.random(rng=rng), rng.uniform(-np.pi, np.pi), (yaw, pitch, roll), (east, north, up))


# --------------------------------------------------------------------------------------------- the field


class Field(NamedTuple):
    """The field in east-north-up, n x 3 in tesla, at times (n), and from when on it is the earth's alone."""

    at: Callable[[np.ndarray], np.ndarray]
    true_from_s: float
    iron_b_tesla: np.ndarray = np.zeros(3)  # fixed to the body, in body axes


def draw_earth_field(rng: np.random.Generator) -> np.ndarray:
    """25 to 65 uT, dip up to 75 deg on either hemisphere, along magnetic north, in tesla."""
    strength, dip = rng.uniform(25e-6, 65e-6), rng.choice([-1, 1]) * np.radians(rng.uniform(0, 75))
    return strength * np.array([0, np.cos(dip), -np.sin(dip)])


def undisturbed(rng: np.random.Generator, earth: np.ndarray) -> Field:
    return Field(lambda t_s: np.tile(earth, (len(t_s), 1)), 0.0)


def false_at_first(rng: np.random.Generator, earth: np.ndarray) -> Field:
    """Turned by 30 to 90 deg about any axis and scaled by 0.6 to 1.5 for the first 2 to 15 s; gone within a second."""
    end_s, scale = rng.uniform(2, 15), rng.uniform(0.6, 1.5)
    axis = rng.normal(size=3)
    turn = Rotation.from_rotvec(np.radians(rng.uniform(30, 90)) * axis / np.linalg.norm(axis))
    false = scale * turn.apply(earth)
    return Field(lambda t_s: earth + np.clip(end_s + 1 - t_s, 0, 1)[:, None] * (false - earth), end_s + 1)


def passing(rng: np.random.Generator, earth: np.ndarray) -> Field:
    """10 to 60 uT in any direction that come and go within seconds (a bell), at some time of the first 20 s."""
    peak = rng.normal(size=3)
    peak *= rng.uniform(10e-6, 60e-6) / np.linalg.norm(peak)
    middle_s, width_s = rng.uniform(0, 20), rng.uniform(0.3, 3)
    return Field(lambda t_s: earth + np.exp(-0.5 * ((t_s - middle_s) / width_s) ** 2)[:, None] * peak, middle_s + 3 * width_s)


def steady(rng: np.random.Generator, earth: np.ndarray) -> Field:
    """Turned and scaled as the field that is false at first, and false to the end."""
    false = false_at_first(rng, earth).at(np.zeros(1))[0]
    return Field(lambda t_s: np.tile(false, (len(t_s), 1)), np.inf)


def growing(rng: np.random.Generator, earth: np.ndarray) -> Field:
    """10 to 60 uT in any direction that grow within 20 to 60 s and stay."""
    false = rng.normal(size=3)
    false *= rng.uniform(10e-6, 60e-6) / np.linalg.norm(false)
    full_s = rng.uniform(20, 60)
    return Field(lambda t_s: earth + np.clip(t_s / full_s, 0, 1)[:, None] * false, np.inf)


def iron_on_the_body(rng: np.random.Generator, earth: np.ndarray) -> Field:
    """Hard iron of 15 % of the field on each axis, one sigma."""
    iron = 0.15 * np.linalg.norm(earth) * rng.normal(size=3)
    return Field(lambda t_s: np.tile(earth, (len(t_s), 1)), np.inf, iron)


DISTURBANCES = {"none": undisturbed, "false at first": false_at_first, "passing": passing}
GROUPS = [(motion, disturbance) for disturbance in DISTURBANCES for motion in MOTIONS]
# Not observable from the measurements: no limit is set, and the rates are printed.
HIDDEN = {"false and steady": steady, "slowly growing": growing, "iron on the body": iron_on_the_body}
HIDDEN_GROUPS = [(motion, disturbance) for disturbance in HIDDEN for motion in MOTIONS]


# --------------------------------------------------------------------------------------------- sensors


class Sensors(NamedTuple):
    """Errors of one set of consumer-grade sensors; noise as the standard deviation of a sample."""

    gyro_noise_rad_s: float
    gyro_bias_rad_s: np.ndarray
    accel_noise_m_s2: float
    mag_noise_tesla: float
    mag_latency_s: float
    accel_bias_m_s2: np.ndarray = np.zeros(3)
    gyro_errors: np.ndarray = np.zeros((3, 3))  # S of reading - S reading: scale and misalignment

    def read(self, rng: np.random.Generator, *true: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rate, force and field (n x 3) for the true ones, but for the latency of the field."""
        noise = (self.gyro_noise_rad_s, self.accel_noise_m_s2, self.mag_noise_tesla)
        bias = (self.gyro_bias_rad_s, self.accel_bias_m_s2, 0.0)
        rate, force, field = (x + b + sigma * rng.normal(size=x.shape) for x, b, sigma in zip(true, bias, noise))
        return rate @ np.linalg.inv(np.eye(3) - self.gyro_errors).T, force, field


def with_every_error(sensors: Sensors, rng: np.random.Generator) -> Sensors:
    """With those too that the options of the AHRS allow for by their defaults."""
    errors = np.where(np.eye(3), 2e-3, 0.56e-3) * rng.normal(size=(3, 3))
    return sensors._replace(accel_bias_m_s2=0.035 * rng.normal(size=3), gyro_errors=errors)


def draw_sensors(rng: np.random.Generator) -> Sensors:
    """0.005 to 0.02 deg/s/rtHz, bias to 1 deg/s per axis; 100 to 400 ug/rtHz; 0.2 to 1 uT; field 0 to 15 ms old."""
    per_sample = np.sqrt(RATE_HZ)
    return Sensors(
        gyro_noise_rad_s=np.radians(rng.uniform(0.005, 0.02)) * per_sample,
        gyro_bias_rad_s=np.radians(rng.uniform(-1, 1, 3)),
        accel_noise_m_s2=rng.uniform(100e-6, 400e-6) * GRAVITY_M_S2 * per_sample,
        mag_noise_tesla=rng.uniform(0.2e-6, 1e-6),
        mag_latency_s=rng.uniform(0, 0.015),
    )


class Simulated(NamedTuple):
    """The samples of a start with the true attitude as reference, its group, and the truth about field and sensors; the field of the
    earth in east-north-up, in tesla."""

    recording: Recording
    motion: str
    disturbance: str
    field_true_s: float
    sensors: Sensors
    earth_tesla: np.ndarray


def simulated_start(
    index: int, seed: int = 1, duration_s: float = DURATION_S, hidden: bool = False, every_error: bool = False
) -> Simulated:
    """Start `index`; groups take turns. hidden: with a field that is false in a way that cannot be known from inside. every_error: with
    sensors that have a bias of the accelerometer and errors of scale too, all else being equal."""
    rng = np.random.default_rng([seed, index])
    groups = HIDDEN_GROUPS if hidden else GROUPS
    motion_name, disturbance = groups[index % len(groups)]
    motion, sensors = draw_motion(rng, MOTIONS[motion_name]), draw_sensors(rng)
    if every_error:
        sensors = with_every_error(sensors, np.random.default_rng([seed, index, 1]))
    earth = draw_earth_field(rng)
    field = (DISTURBANCES | HIDDEN)[disturbance](rng, earth)
    t_s = np.arange(0, duration_s, 1 / RATE_HZ)
    attitude = motion.attitude(t_s)
    turned_rad = (motion.attitude(t_s - 1 / RATE_HZ).inv() * attitude).as_rotvec()
    force = attitude.apply(motion.acceleration(t_s) + [0, 0, GRAVITY_M_S2], inverse=True)
    measured_s = t_s - sensors.mag_latency_s
    magnetic = motion.attitude(measured_s).apply(field.at(measured_s), inverse=True) + field.iron_b_tesla
    samples = sensors.read(rng, turned_rad * RATE_HZ, force, magnetic)
    name, reference = f"start {index}: {motion_name}, {disturbance}", attitude.as_quat(scalar_first=True)
    recording = Recording(name, t_s, *samples, reference_q_nb=reference, movement=np.ones(len(t_s), bool))
    return Simulated(recording, motion_name, disturbance, field.true_from_s, sensors, earth)
