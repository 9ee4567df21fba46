"""Motions of vehicles: velocity north-east-down and attitude over time, at random.

velocity, attitude = MOTIONS["car"](numpy.random.default_rng(1), t_s)

hnav.simulation.vehicle simulates vehicles too, and shares no line with this: it goes step by step, as FMUs do, and finds what sensors read
from derivatives in closed form; here thousands of starts go through NumPy as arrays, with kinds that are not meant for users, and sensors
follow from successive places and attitudes. That both agree is a test.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from scipy.ndimage import convolve1d
from scipy.spatial.transform import Rotation

from hnav.native.arrays import Array

RATE_HZ = 100
AT_REST = ("rest", "swaying", "vibrating", "polar")
"""Kinds at rest at a given position; the last one at 80 degrees of latitude, the others at 45."""
WARM_S = 20.0  # the filter is switched on after so long, mostly in motion

Levels = Callable[[], float]


def smooth(values: Array, samples: int) -> Array:
    """A mean over so many samples on either side, with soft edges."""
    window = np.hanning(2 * samples + 1)[1:-1]
    return np.asarray(convolve1d(values, window / window.sum(), mode="nearest"))


def stairs(rng: np.random.Generator, t: Array, levels: Levels, hold_s: tuple[float, float]) -> Array:
    """Levels that are each held for a random time."""
    values, begin = np.zeros(len(t)), 0.0
    while begin < t[-1]:
        end = begin + rng.uniform(*hold_s)
        values[(t >= begin) & (t < end)] = levels()
        begin = end
    return values


def turned_on(start: Rotation, turns: Rotation) -> Rotation:
    """n + 1 attitudes: a start, and each of n turns about body axes after it."""
    found = [start.as_quat()]
    for turn in turns.as_quat():
        x, y, z, w = found[-1]
        found.append(np.array([[w, -z, y, x], [z, w, -x, y], [-y, x, w, z], [-x, -y, -z, w]]) @ turn)
    return Rotation.from_quat(found)


Motion = tuple[Array, Rotation]


def _along(speed: Array, heading: Array, climb: Array, roll: Array, pitch: Array) -> Motion:
    """The velocity north-east-down of a body that moves where it points, and its attitude."""
    ahead = speed * np.cos(climb)
    velocity = np.stack([ahead * np.cos(heading), ahead * np.sin(heading), -speed * np.sin(climb)], 1)
    return velocity, Rotation.from_euler("ZYX", np.stack([heading, pitch, roll], 1))


def _course(rng: np.random.Generator, rate: Array) -> Array:
    return np.asarray(rng.uniform(-np.pi, np.pi) + np.cumsum(rate) / RATE_HZ)


def car(rng: np.random.Generator, t: Array) -> Motion:
    """Stops, goes and turns as in a town."""
    n, white = len(t), RATE_HZ**0.5
    speed = smooth(stairs(rng, t, lambda: float(rng.choice([0.0, 5.0, 9.0, 14.0, 20.0])), (6, 20)), 2 * RATE_HZ)
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


def straight(rng: np.random.Generator, t: Array) -> Motion:
    """A car that stands, gains speed straight ahead, keeps it for half a minute, and only then turns; switched on before or during it."""
    n, white = len(t), RATE_HZ**0.5
    begin, length = WARM_S + rng.uniform(-5, 10), rng.uniform(5, 12)
    gain = smooth(np.where((t > begin) & (t < begin + length), rng.uniform(0.5, 4), 0.0), RATE_HZ // 3)
    turns = stairs(rng, t, lambda: rng.choice([0.0, 0, 0, 1, -1]) * rng.uniform(0.1, 0.35), (3, 8))
    rate = smooth(turns, RATE_HZ) * (t > begin + length + 30)
    roll = smooth(0.005 * rng.standard_normal(n) * white, RATE_HZ) + 0.02
    pitch = smooth(0.005 * rng.standard_normal(n) * white, 2 * RATE_HZ) + rng.uniform(-0.03, 0.03)
    return _along(np.cumsum(gain) / RATE_HZ, _course(rng, rate), 0 * t, roll, pitch)


def take_off(rng: np.random.Generator, t: Array) -> Motion:
    """An aeroplane that runs, lifts its nose, climbs and turns; switched on before or during the run."""
    n, gain, lifts = len(t), rng.uniform(2, 5), rng.uniform(25, 70)
    run_s = lifts / gain
    begin = WARM_S + rng.uniform(-0.7 * run_s, 10)
    speed = np.cumsum(smooth(np.where((t > begin) & (t < begin + run_s + 3), gain, 0.0), RATE_HZ // 3)) / RATE_HZ
    climb = smooth(np.where(t > begin + run_s + 2, rng.uniform(0.08, 0.2), 0.0), RATE_HZ)
    banks = stairs(rng, t, lambda: rng.choice([0.0, 0, 1, -1]) * rng.uniform(0.1, 0.5), (8, 30))
    bank = smooth(banks * (t > begin + run_s + 20), 2 * RATE_HZ)
    nose = smooth(np.where(t > begin + run_s + 0.5, rng.uniform(0.1, 0.2), rng.uniform(-0.02, 0.1)), RATE_HZ)
    pitch = nose + smooth(0.005 * rng.standard_normal(n) * RATE_HZ**0.5, 2 * RATE_HZ)
    return _along(speed, _course(rng, 9.8 * np.tan(bank) / np.maximum(speed, 20)), climb, bank, pitch)


def train(rng: np.random.Generator, t: Array) -> Motion:
    """Stands, gains speed for up to a minute, and brakes as long, on straight track with wide, canted bends and gentle gradients."""
    n, white = len(t), RATE_HZ**0.5
    begin, gain = WARM_S + rng.uniform(5, 30), np.zeros(len(t))
    while begin < t[-1]:
        size, length, cruise = rng.uniform(0.3, 0.7), rng.uniform(30, 60), rng.uniform(30, 60)
        gain[(t >= begin) & (t < begin + length)] = size
        gain[(t >= begin + length + cruise) & (t < begin + 2 * length + cruise)] = -size
        begin += 2 * length + cruise + rng.uniform(20, 40)
    speed = np.maximum(np.cumsum(smooth(gain, 2 * RATE_HZ)) / RATE_HZ, 0)
    across = smooth(stairs(rng, t, lambda: rng.choice([0.0, 0, 1, -1]) * rng.uniform(0.2, 0.8), (20, 40)), 5 * RATE_HZ)
    across *= np.minimum(1, speed / 10)
    roll = rng.uniform(-0.05, 0.05) + 0.6 * across / 9.8 + smooth(0.002 * rng.standard_normal(n) * white, RATE_HZ)
    climb = smooth(stairs(rng, t, lambda: rng.uniform(-0.01, 0.01), (20, 60)), 5 * RATE_HZ)
    pitch = rng.uniform(-0.05, 0.05) + climb + smooth(0.001 * rng.standard_normal(n) * white, RATE_HZ)
    return _along(speed, _course(rng, across / np.maximum(speed, 10)), climb, roll, pitch)


def quadrotor(rng: np.random.Generator, t: Array, flies: Array | float = 1.0) -> Motion:
    """Hovers in wind, moves slowly at random, and turns about its thrust at random. flies: 0 where it hovers only."""
    n, white = len(t), RATE_HZ**0.5
    fastest, hovers = rng.uniform(0.5, 6), rng.choice([0.3, 0.6, 0.9])
    ways = [flies * stairs(rng, t, lambda: (rng.random() > hovers) * rng.uniform(-fastest, fastest), (3, 10)) for _ in "ne"]
    ways.append(flies * stairs(rng, t, lambda: (rng.random() > 0.7) * rng.uniform(-1, 1), (3, 10)))
    gusts = [smooth(0.1 * rng.standard_normal(n) * white, RATE_HZ) for _ in "ned"]
    velocity = np.stack([smooth(way, 4 * RATE_HZ // 5) + gust for way, gust in zip(ways, gusts)], 1)
    wind = np.stack([smooth(0.1 * rng.standard_normal(n) * white, RATE_HZ) for _ in "ned"], 1)
    thrust = np.gradient(velocity, 1 / RATE_HZ, axis=0) - [0, 0, 9.8] + wind
    turns = flies * stairs(rng, t, lambda: (rng.random() > 0.6) * rng.uniform(-0.6, 0.6), (2, 8))
    yaw = _course(rng, smooth(turns, RATE_HZ // 2))
    down = -thrust / np.linalg.norm(thrust, axis=1)[:, None]
    right = np.cross(down, np.stack([np.cos(yaw), np.sin(yaw), 0 * yaw], 1))
    right /= np.linalg.norm(right, axis=1)[:, None]
    return velocity, Rotation.from_matrix(np.stack([np.cross(right, down), right, down], 2))


def hover(rng: np.random.Generator, t: Array) -> Motion:
    """A quadrotor that hovers for up to a minute, then flies."""
    return quadrotor(rng, t, np.where(t > WARM_S + rng.uniform(30, 60), 1.0, 0.0))


def walked(rng: np.random.Generator, t: Array) -> tuple[Array, Array, Array]:
    """Speed and course of somebody who walks, stands and turns, and how much of a step there is."""
    speed = smooth(stairs(rng, t, lambda: float(rng.choice([0, 1.2, 1.4, 1.5, 1.3])), (8, 30)), RATE_HZ // 2)
    turns = stairs(rng, t, lambda: rng.choice([0, 0, 1, -1]) * rng.uniform(0.3, 1.2), (2, 5))
    return speed, _course(rng, smooth(turns, RATE_HZ // 2)), np.minimum(speed, 1.2) / 1.2


def walker(rng: np.random.Generator, t: Array) -> Motion:
    """A telephone in a hand or a pocket: steps, swings, any attitude."""
    n, white = len(t), RATE_HZ**0.5
    speed, course, moves = walked(rng, t)
    phase = 2 * np.pi * rng.uniform(1.6, 2.1) * t + smooth(0.5 * rng.standard_normal(n) * white, RATE_HZ)
    ahead, aside = speed + 0.15 * moves * np.sin(phase + 1), 0.12 * moves * np.sin(phase / 2)
    north, east = ahead * np.cos(course) - aside * np.sin(course), ahead * np.sin(course) + aside * np.cos(course)
    held: Rotation = Rotation.from_euler("ZYX", [rng.uniform(-3, 3), rng.uniform(-1.2, 0.9), rng.uniform(-1, 1)])
    size = rng.choice([0.06, 0.06, 0.3])
    sways = [rng.uniform(0.3, 1) * size * moves * np.sin(phase / 2 + rng.uniform(0, 6)) for _ in "xyz"]
    sways = [sway + smooth(0.05 * rng.standard_normal(n) * white, RATE_HZ) for sway in sways]
    looks = smooth(stairs(rng, t, lambda: (rng.random() > 0.7) * rng.uniform(-0.5, 0.5), (4, 15)), RATE_HZ // 2)
    velocity = np.stack([north, east, 0.25 * moves * np.sin(phase)], 1)
    return velocity, Rotation.from_euler("z", (course + looks)[:, None]) * held * Rotation.from_rotvec(np.stack(sways, 1))


def rest(rng: np.random.Generator, t: Array, swaying: float = 1.0, vibration_m_s2: float = 0.0) -> Motion:
    """Stands on something that sways by so many millimetres, and perhaps vibrates as beside an engine."""

    def sway(size: float) -> Array:
        waves = [rng.standard_normal() * np.sin(2 * np.pi * f * t + rng.uniform(0, 6)) for f in (0.15, 0.4, 1.1, 3.0)]
        return np.asarray(swaying * size * np.sum(waves, axis=0))

    def shaken(order: int) -> Array:
        """Its derivative of this order has the root mean square that is asked for."""
        rates = 2 * np.pi * np.array([11.3, 19.7, 31.1, 43.9])
        waves = [np.sin(w * t + rng.uniform(0, 6)) / w**order for w in rates]
        return np.asarray(vibration_m_s2 / np.sqrt(2) * np.sum(waves, axis=0))

    speed, roll, pitch = sway(2e-3), rng.uniform(-0.1, 0.1) + sway(3e-4), rng.uniform(-0.1, 0.1) + sway(3e-4)
    heading = rng.uniform(-np.pi, np.pi) + sway(3e-4)
    velocity, attitude = _along(speed + shaken(1), heading, 0 * t, roll + shaken(2), pitch + shaken(2))
    velocity[:, 2] += shaken(1)
    return velocity, attitude


MOTIONS: dict[str, Callable[[np.random.Generator, Array], Motion]] = {
    "car": car,
    "aircraft": aircraft,
    "ship": ship,
    "rest": rest,
    "polar": rest,
    "swaying": partial(rest, swaying=4.0),
    "vibrating": partial(rest, vibration_m_s2=0.2),
    "straight": straight,
    "take_off": take_off,
    "train": train,
    "quadrotor": quadrotor,
    "hover": hover,
    "walker": walker,
}
