"""Events of a few seconds in simulated motion whose truth is exact: shocks, clipped and stuck sensors, gaps.

A hand-held body (studies.readiness.starts) runs undisturbed for BEFORE_S, then the event, then AFTER_S more. The sensors
are those of the simulated starts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from studies.readiness import starts
from studies.readiness.starts import GRAVITY_M_S2, RATE_HZ, Motion

BEFORE_S, AFTER_S = 60.0, 120.0
EDGE_S = 0.5  # of fast motion
SHOCK_M_S2 = 16 * GRAVITY_M_S2
CLIP_RAD_S = 2.0
SPIKE_RAD_S = 35.0
BIAS_STEP_RAD_S = np.radians(1.0)
DAY_S = 86400.0


@dataclass
class Samples:
    """Of one run, n rows at 100 Hz; attitude: body to east-north-up. Axes of vectors: body."""

    t_s: np.ndarray
    rate: np.ndarray
    force: np.ndarray
    field: np.ndarray
    attitude: Rotation
    during: np.ndarray  # rows of the event
    rng: np.random.Generator


class Event(NamedTuple):
    """How long it lasts, how fast the body turns meanwhile, what it does to the samples, and what it disturbs."""

    duration_s: float
    damage: Callable[[Samples], None]
    turn: str = "hand-held"  # key of MOTIONS, during the event
    turned_rad: float = 0.0  # from the event on, about an axis of chance
    heading: bool = False  # the heading suffers, not the tilt


def changed(array: str, change: Callable[[np.ndarray], np.ndarray]) -> Callable[[Samples], None]:
    """change: the samples of the event -> those instead."""

    def damage(samples: Samples) -> None:
        values = getattr(samples, array)
        values[samples.during] = change(values[samples.during])

    return damage


def shock(samples: Samples) -> None:
    samples.force[samples.during, samples.rng.integers(3)] = samples.rng.choice([-1, 1]) * SHOCK_M_S2


def added_shock(samples: Samples) -> None:
    samples.force[samples.during, samples.rng.integers(3)] += samples.rng.choice([-1, 1]) * SHOCK_M_S2


def spike(samples: Samples) -> None:
    samples.rate[samples.during, samples.rng.integers(3)] = samples.rng.choice([-1, 1]) * SPIKE_RAD_S


def gap(length_s: float) -> Callable[[Samples], None]:
    def damage(samples: Samples) -> None:
        samples.t_s[int(np.argmax(samples.during)) :] += length_s

    return damage


def dead_axis(samples: Samples) -> None:
    samples.rate[samples.during, samples.rng.integers(3)] = 0


def bias_step(samples: Samples) -> None:
    """It stays to the end."""
    samples.rate[int(np.argmax(samples.during)) :] += BIAS_STEP_RAD_S * unit_vector(samples.rng)


clipped = changed("rate", lambda rate: np.clip(rate, -CLIP_RAD_S, CLIP_RAD_S))
EVENTS = {
    "gyro clipped for 10 s of fast motion": Event(10, clipped, "fast turning"),
    "16 g on one axis for 1 s": Event(1, shock),
    "16 g on one axis for 0.1 s": Event(0.1, shock),
    "16 g added on one axis for 1 s": Event(1, added_shock),
    "16 g added on one axis for 0.1 s": Event(0.1, added_shock),
    "one gyro sample of 35 rad/s": Event(1 / RATE_HZ, spike),
    "gap of a day, turned by 90 deg": Event(1 / RATE_HZ, gap(DAY_S), turned_rad=np.pi / 2),
    "gap of 60 s": Event(1 / RATE_HZ, gap(60)),
    "gap of 1 h": Event(1 / RATE_HZ, gap(3600)),
    "gyro axis dead for 10 s": Event(10, dead_axis),
    "gyro stuck for 10 s": Event(10, changed("rate", lambda rate: rate[:1])),
    "gyro bias steps by 1 deg/s": Event(1 / RATE_HZ, bias_step, heading=True),
    "field stuck for 20 s": Event(20, changed("field", lambda field: field[:1]), heading=True),
    "field x and y flipped for 20 s": Event(20, changed("field", lambda field: field * [-1, -1, 1]), heading=True),
}


def simulated(name: str, seed: int) -> Samples:
    """The run of an event with a seed; the same seed has the same motion and noise in every event."""
    event = EVENTS[name]
    rng = np.random.default_rng([seed, 15])
    motion, fast = starts.draw_motion(rng, starts.MOTIONS["hand-held"]), starts.draw_motion(rng, starts.MOTIONS["fast turning"])
    sensors, earth = starts.draw_sensors(rng), starts.draw_earth_field(rng)
    turn = Rotation.from_rotvec(event.turned_rad * unit_vector(rng))
    count = round((BEFORE_S + event.duration_s + AFTER_S) * RATE_HZ)
    t_s = np.arange(count) / RATE_HZ
    during = (np.arange(count) >= BEFORE_S * RATE_HZ) & (np.arange(count) < round((BEFORE_S + event.duration_s) * RATE_HZ))

    def attitude(at_s: np.ndarray) -> Rotation:
        left_s = np.minimum(at_s - BEFORE_S, BEFORE_S + event.duration_s - at_s)  # above 0 during the event
        return _between(motion, fast, (event.turn == "fast turning") * starts.smooth_step(left_s / EDGE_S), at_s)

    truth = attitude(t_s)
    rate = (attitude(t_s - 1 / RATE_HZ).inv() * truth).as_rotvec() * RATE_HZ
    if event.turned_rad:
        before = np.arange(count) < BEFORE_S * RATE_HZ
        truth = Rotation.concatenate([truth[before], turn * truth[~before]])
    force = truth.apply(motion.acceleration(t_s) + [0, 0, GRAVITY_M_S2], inverse=True)
    field = truth.apply(np.tile(earth, (count, 1)), inverse=True)
    samples = Samples(t_s, *sensors.read(rng, rate, force, field), truth, during, rng)
    event.damage(samples)
    return samples


def _between(slow: Motion, fast: Motion, share: np.ndarray, t_s: np.ndarray) -> Rotation:
    """The slow motion's attitude, with this share of the fast one's angles added."""
    angles = np.stack([wave(t_s) for wave in slow.angles_rad], axis=1) * slow.size(t_s)[:, None]
    angles += share[:, None] * np.stack([wave(t_s) for wave in fast.angles_rad], axis=1)
    return Rotation.from_euler("ZYX", angles + [slow.yaw_rad, 0, 0]) * slow.mounting


def unit_vector(rng: np.random.Generator) -> np.ndarray:
    """In any direction."""
    v = rng.normal(size=3)
    return np.asarray(v / np.linalg.norm(v))
