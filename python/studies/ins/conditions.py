"""What a start may meet beside what every start meets: a wrong compass, wrong first fixes, a wrong given state, late or noisy fixes, an antenna
beside the sensor, wheels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from hnav import earth
from hnav.filters.options import CAR_ACROSS_M_S
from hnav.native.library import SENSORS
from studies.ins.motions import RATE_HZ
from studies.ins.vehicles import EARTH_M, Samples, Truth, arriving, fixes

OFF_RAD = np.radians(170.0)
COMPASS_SIGMA_RAD = 0.1
COMPASS_EVERY = 10  # samples of the inertial sensor for one of the compass, and of the wheels
FIRST_S, FIRST_OFF_M = 7.0, 300.0  # from switching on: the filter takes its first position after 5 s of levelling
LATE_S = 0.4
NOISIER = 4.0
ANTENNA_M = 0.5
WHEELS_M_S, WHEELS_SCALE = 0.1, 0.01

Change = Callable[[Samples, Truth, np.random.Generator], Samples]


def _no_options(_: Truth) -> dict[str, object]:
    return {}


@dataclass(frozen=True)
class Condition:
    """What it does to the samples, and the options of the filter that go with it."""

    text: str
    change: Change
    options: Callable[[Truth], dict[str, object]] = _no_options


def _as_it_is(samples: Samples, _: Truth, __: np.random.Generator) -> Samples:
    return samples


def _wrong_compass(samples: Samples, truth: Truth, rng: np.random.Generator) -> Samples:
    rows = slice(0, None, COMPASS_EVERY)
    heading = truth.heading_rad()[rows] + OFF_RAD
    samples.aids.heading(samples.t_s[rows], heading + COMPASS_SIGMA_RAD * rng.standard_normal(len(heading)), COMPASS_SIGMA_RAD)
    return samples


def _wrong_first_fixes(samples: Samples, _: Truth, rng: np.random.Generator) -> Samples:
    valid, _received, sensor, value = samples.aids.arrays()
    first = (valid < valid[0] + FIRST_S) & (sensor == SENSORS.index("position"))
    angle = rng.uniform(-np.pi, np.pi)
    off_rad = FIRST_OFF_M / EARTH_M
    value[first, 0] += off_rad * np.cos(angle)
    value[first, 1] += off_rad * np.sin(angle) / np.cos(value[first, 0])
    return replace(samples, aids=fixes(valid, sensor, value))


def _wrong_state(truth: Truth) -> dict[str, object]:
    """The state of the first row as the given start, with the velocity as it is, and a heading that is OFF_RAD off."""
    to_north = Rotation.from_matrix(earth.axes_at(earth.place_of(truth.position_e[0]))).inv()
    q_nb = Rotation.from_rotvec([0, 0, OFF_RAD]) * to_north * truth.attitude_e[0]
    return dict(
        start="state", start_q_nb=tuple(q_nb.as_quat(scalar_first=True)),
        start_velocity_n_m_s=tuple(to_north.apply(truth.velocity_e[0])), start_sigma_heading_rad=COMPASS_SIGMA_RAD,
    )  # fmt: skip


def _late(samples: Samples, _: Truth, __: np.random.Generator) -> Samples:
    return arriving(samples, LATE_S)


def _noisy(samples: Samples, _: Truth, rng: np.random.Generator) -> Samples:
    """Satellites that are NOISIER times as noisy as they state."""
    valid, _received, sensor, value = samples.aids.arrays()
    added = np.sqrt(NOISIER**2 - 1) * value[:, 3:6] * rng.standard_normal((len(value), 3))
    places = sensor == SENSORS.index("position")
    added[places, :2] /= EARTH_M
    added[places, 1] /= np.cos(value[places, 0])
    value[:, :3] += added
    return replace(samples, aids=fixes(valid, sensor, value))


def _antenna(samples: Samples, truth: Truth, rng: np.random.Generator) -> Samples:
    """An antenna ANTENNA_M from the sensor, which no option states."""
    direction = rng.standard_normal(3)
    arm = truth.attitude_e.apply(ANTENNA_M * direction / np.linalg.norm(direction))
    swing = np.gradient(arm, truth.t_s, axis=0)
    valid, _received, sensor, value = samples.aids.arrays()
    latency_s = valid[0] - truth.t_s[1]  # the first fix is of the second sample
    rows = np.rint((valid - latency_s - truth.t_s[0]) * RATE_HZ).astype(int)
    places, velocities = (sensor == SENSORS.index(kind) for kind in ("position", "velocity"))
    value[places, :3] = earth.place_of(earth.position_of(value[places, :3]) + arm[rows[places]])
    axes = earth.axes_at(earth.place_of(truth.position_e[rows[velocities]]))
    value[velocities, :3] += np.einsum("nij,ni->nj", axes, swing[rows[velocities]])
    return replace(samples, aids=fixes(valid, sensor, value))


def _wheels(samples: Samples, truth: Truth, rng: np.random.Generator) -> Samples:
    rows = slice(0, None, COMPASS_EVERY)
    ahead = truth.attitude_e[rows].apply([1.0, 0, 0])
    speed = (1 + WHEELS_SCALE * rng.standard_normal()) * np.einsum("ni,ni->n", truth.velocity_e[rows], ahead)
    samples.aids.speed(samples.t_s[rows], speed + WHEELS_M_S * rng.standard_normal(len(speed)), WHEELS_M_S)
    return samples


CONDITIONS = {
    "usual": Condition("", _as_it_is),
    "compass": Condition("compass 170 deg off", _wrong_compass),
    "first_fixes": Condition("first positions 300 m off for 2 s", _wrong_first_fixes),
    "state": Condition("given state with a heading 170 deg off", _as_it_is, _wrong_state),
    "late": Condition(f"every fix stamped {LATE_S:g} s late", _late),
    "noisy": Condition(f"satellites {NOISIER:g} times as noisy as they state", _noisy),
    "antenna": Condition(f"antenna {ANTENNA_M:g} m off, unstated", _antenna),
    "wheels": Condition("wheels", _wheels, lambda _: {"car_across_m_s": CAR_ACROSS_M_S}),
}
