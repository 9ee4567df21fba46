"""Whether hnav calibrate --sensor states its errors rightly, and what an AHRS gains by it: simulated cheap sensors of known errors.

./run study sensor_calibration [DIR] [--sensors 200] [--drives 20]

Each sensor is laid down in 16 attitudes within two minutes, and turned by hand in between. NEES: squared error of the 21 parameters by their
covariance, over 21. The AHRS then runs over another motion, with the readings as they are and corrected by the file.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from scipy.spatial.transform import Rotation, Slerp

from hnav.cli.console import say, show
from hnav.errors import HnavError
from hnav.filters.attitude import Filter
from hnav.filters.calibration import calibrate_magnetometer
from hnav.filters.sensor_calibration import UPPER, SensorCalibration, calibrate_sensors
from hnav.io.readers import read
from hnav.io.readers.broad import find_trials
from hnav.io.recordings import Recording
from hnav.native.arrays import Array
from hnav.reports.scores import score
from hnav.units import G_M_S2
from studies.command import Trials, titled_table, tracked

RATE_HZ = 100.0
RESTS, REST_S, TURN_S = 16, 3.9, 3.62
FIELD_N = 5e-5 * np.array([np.cos(np.radians(65)), 0, np.sin(np.radians(65))])  # north-east-down, T
GYRO_NOISE, ACCEL_NOISE, MAG_NOISE = np.radians(0.007), 150e-6 * G_M_S2, 60e-9
"""Densities of a consumer chip: rad/s/sqrt(Hz), m/s2/sqrt(Hz), T/sqrt(Hz)."""


@dataclass(frozen=True)
class Sensor:
    """Readings = inverse(matrix) corrected + offset, of each sensor."""

    accel: tuple[Array, Array]
    gyro: tuple[Array, Array]
    mag: tuple[Array, Array]

    @property
    def parameters(self) -> Array:
        """21, in the order of SensorCalibration."""
        (matrix_a, offset_a), (matrix_g, offset_g) = self.accel, self.gyro
        return np.concatenate([offset_a, matrix_a[UPPER], offset_g, matrix_g.ravel()])

    def record(self, t_s: Array, attitude: Rotation, rng: np.random.Generator) -> Recording:
        """What it reads of a motion. attitude: body to north-east-down, at each time."""
        interval_s = 1 / RATE_HZ
        fine = (attitude[:-1].inv() * attitude[1:]).as_rotvec() / interval_s
        rate = np.concatenate([fine[:1], 0.5 * (fine[1:] + fine[:-1]), fine[-1:]])
        true = (attitude.apply([0, 0, -G_M_S2], inverse=True), rate, attitude.apply(FIELD_N, inverse=True))
        noise = (ACCEL_NOISE, GYRO_NOISE, MAG_NOISE)
        force, rate, field = (
            values @ np.linalg.inv(matrix).T + offset + density * np.sqrt(RATE_HZ) * rng.normal(size=values.shape)
            for values, (matrix, offset), density in zip(true, (self.accel, self.gyro, self.mag), noise)
        )
        return Recording("simulated", t_s, rate, force, field)


def sensor_of(rng: np.random.Generator) -> Sensor:
    """Cheap: 50 mg, 2 % and 1 deg of force; 1 deg/s, 2 % and 1 deg of rate; 5 uT, 2 % and 1 deg of field, one sigma."""

    def matrix() -> Array:
        scale, angles = 0.02 * np.diag(rng.normal(size=3)), np.radians(1) * rng.normal(size=(3, 3)) * (1 - np.eye(3))
        return np.asarray(np.eye(3) + scale + angles, float)

    return Sensor(
        (np.triu(matrix()), 0.05 * G_M_S2 * rng.normal(size=3)), (matrix(), np.radians(1) * rng.normal(size=3)),
        (matrix(), 5e-6 * rng.normal(size=3)),
    )  # fmt: skip


def rests_and_turns(rng: np.random.Generator) -> tuple[Array, Rotation]:
    """Two minutes: rests in attitudes all over the sphere, each turn with a smooth begin and end."""
    stops = Rotation.random(RESTS, rng)
    t_s = np.arange(0, RESTS * (REST_S + TURN_S), 1 / RATE_HZ)
    number, within = np.divmod(t_s, REST_S + TURN_S)
    share = np.clip((within - REST_S) / TURN_S, 0, 1)
    way = np.clip(number + 10 * share**3 - 15 * share**4 + 6 * share**5, 0, RESTS - 1)
    return t_s, Slerp(np.arange(RESTS), stops)(way)


def drive(rng: np.random.Generator) -> tuple[Array, Rotation]:
    """Two minutes of turning by hand about all axes, up to 3 rad/s."""
    t_s = np.arange(0, 120, 1 / RATE_HZ)
    phases = rng.uniform(0, 2 * np.pi, (3, 3))
    angles = sum(
        amplitude * np.sin(2 * np.pi * t_s[:, None] * rates + phase)
        for amplitude, rates, phase in zip((0.8, 0.5, 0.2), ((0.05, 0.08, 0.03), (0.21, 0.17, 0.11), (0.9, 0.7, 0.5)), phases)
    )
    return t_s, Rotation.from_euler("ZYX", np.stack([np.pi * angles[:, 0], 0.8 * angles[:, 1], angles[:, 2]], axis=1))


def nees(sensor: Sensor, found: SensorCalibration) -> float:
    """Over the number of parameters."""
    error = found.parameters - sensor.parameters
    return float(error @ np.linalg.solve(found.covariance, error) / len(error))


def gain(sensor: Sensor, rests: Recording, found: SensorCalibration, rng: np.random.Generator) -> tuple[float, float]:
    """Errors of the AHRS in deg, root mean square from 30 s on: as read, and corrected."""
    t_s, attitude = drive(rng)
    read = sensor.record(t_s, attitude, rng)
    field = calibrate_magnetometer(rests.needed("field_b_tesla"), found.accel.apply(rests.force_b_m_s2))
    raw = (read.rate_b_rad_s, read.force_b_m_s2, read.needed("field_b_tesla"))
    true = attitude.as_quat(scalar_first=True)
    errors = []
    for rate, force, magnetic in (raw, (found.gyro.apply(raw[0]), found.accel.apply(raw[1]), field.apply(raw[2]))):
        run, late = Filter("ahrs").run(t_s, rate, force, magnetic, check=False), t_s > 30
        errors.append(score(run.q_nb[late], true[late]).total)
    return errors[0], errors[1]


FIGURES: dict[str, tuple[str, Callable[[SensorCalibration], float]]] = {
    "sigma of accelerometer offset": ("mg", lambda found: 1e3 / G_M_S2 * found.accel.sigma_offset.max()),
    "sigma of accelerometer scale": ("%", lambda found: 100 * np.diag(found.accel.sigma_matrix).max()),
    "sigma of gyroscope scale": ("%", lambda found: 100 * np.diag(found.gyro.sigma_matrix).max()),
    "chi2": ("", lambda found: found.chi2),
}


def command(
    folder: Trials = None,
    sensors: Annotated[int, typer.Option(min=1, help="That are calibrated")] = 200,
    drives: Annotated[int, typer.Option(min=0, help="Of them, that an AHRS is run with")] = 20,
) -> None:
    found: list[tuple[float, SensorCalibration]] = []
    gains, refused = [], 0
    for seed in tracked(range(sensors), "sensors"):
        rng = np.random.default_rng(seed)
        sensor = sensor_of(rng)
        recording = sensor.record(*rests_and_turns(rng), rng)
        try:
            calibration = calibrate_sensors(recording)
        except HnavError:
            refused += 1
            continue
        found.append((nees(sensor, calibration), calibration))
        if seed < drives:
            gains.append(gain(sensor, recording, calibration, rng))
    table = titled_table(f"{sensors} sensors, {refused} refused", "figure", "mean | median | largest")
    rows = {"NEES": ("", [one for one, _ in found])}
    rows |= {name: (unit, [pick(one) for _, one in found]) for name, (unit, pick) in FIGURES.items()}
    rows |= {name: ("deg", [pair[i] for pair in gains]) for i, name in enumerate(("AHRS as read", "AHRS corrected")) if gains}
    for name, (unit, values) in rows.items():
        table.add_row(name, *(f"{of(values):.3g} {unit}" for of in (np.mean, np.median, np.max)))
    show(table)
    if folder is not None:
        say_trials(folder)


def say_trials(folder: Path) -> None:
    """BROAD was not recorded for this: which trials are calibrated, and the reasons of the others."""
    reasons: Counter[str] = Counter()
    for path in find_trials(folder).values():
        try:
            calibrate_sensors(read(path))
            reasons["calibrated"] += 1
        except HnavError as error:
            reasons[re.sub(r"^.*?: |: lay.*|\d+ (?=attitudes)", "", str(error))] += 1
    for reason, n in reasons.most_common():
        say(f"BROAD: {n} trials: {reason}")
