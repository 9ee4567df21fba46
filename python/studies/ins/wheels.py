"""Cars without satellites for a while, with the speed of their wheels: measured at the sensor and in time, or as in a car that has not been
measured."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from itertools import chain

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from hnav.filters.ins import Ins
from hnav.filters.options import CAR_ACROSS_M_S
from hnav.native.arrays import Array
from studies.ins.experiment import errors_of
from studies.ins.vehicles import Samples, Truth, starts_of, vehicle
from studies.processes import in_order

OUTAGES_S = ((100.0, 10.0), (130.0, 30.0), (190.0, 10.0), (220.0, 30.0))  # after the start, and for how long
LENGTH_S = 270.0
STEP = 10  # samples of the inertial sensor for one of the speed
SIGMA_M_S, SCALE = 0.1, 0.02


@dataclass(frozen=True)
class Car:
    """How its wheels and its sensor are put."""

    text: str
    axle_b_m: tuple[float, float, float]  # of the rear axle, from the sensor; unknown to the filter
    late_s: float
    askew_rad: float  # standard deviation of yaw, pitch and roll of the sensor in the car
    step_m_s: float  # what the speed is rounded to


CARS = {
    "none": None,
    "measured": Car("at the sensor, in time", (0.0, 0.0, 0.0), 0.0, 0.0, 0.0),
    "ordinary": Car("1.6 m behind it, 0.1 s late, sensor askew by 2 deg", (-1.5, -0.5, 0.5), 0.1, 0.03, 0.1),
}
"""None: no wheels."""


def sensed(car: Car, samples: Samples, truth: Truth, rng: np.random.Generator) -> tuple[Array, Array, Array]:
    """Speeds every STEP samples, and the rates and forces of a sensor that is askew."""
    rows = slice(0, None, STEP)
    at_sensor = np.einsum("ni,ni->n", truth.velocity_e[rows], truth.attitude_e[rows].apply([1.0, 0, 0]))
    at_axle = at_sensor + np.cross(samples.rate_b_rad_s[rows], car.axle_b_m)[:, 0]
    t = samples.t_s[rows]
    speed = np.interp(t - car.late_s, t, at_axle)
    speed = (1 + SCALE * rng.standard_normal()) * speed + SIGMA_M_S * rng.standard_normal(len(t))
    if car.step_m_s > 0:
        speed = car.step_m_s * np.round(speed / car.step_m_s)
    askew: Rotation = Rotation.from_euler("ZYX", car.askew_rad * rng.standard_normal(3)).inv()
    return speed, askew.apply(samples.rate_b_rad_s), askew.apply(samples.force_b_m_s2)


def drive(name: str, grade: str, seed: int) -> list[tuple[float, float, float]]:
    """The car of CARS and the start of this number: of the end of each outage its length in s, the horizontal error in m, and the
    mean of the squared normalised errors north and east."""
    car = CARS[name]
    samples, truth = vehicle("car", grade, seed, LENGTH_S)
    valid = samples.aids.arrays()[0]
    begins = [(samples.t_s[0] + after, length) for after, length in OUTAGES_S]
    hidden = np.any([(valid > begin) & (valid <= begin + length) for begin, length in begins], axis=0)
    t_s, rate, force, aids = samples.without_fixes(hidden).arrays()
    if car is not None:
        speed, rate, force = sensed(car, samples, truth, np.random.default_rng(seed))
        aids.speed(t_s[::STEP], speed, SIGMA_M_S)
    ins = Ins(grade, solver="closed_form", car_across_m_s=0.0 if car is None else CAR_ACROSS_M_S)
    run = ins.run(t_s, rate, force, aids)
    ends = np.searchsorted(t_s, [begin + length for begin, length in begins]) - 1
    off_n = errors_of(run, truth).position_m[ends, :2]
    z2 = np.mean((off_n / run.sigma_position_m[ends, :2]) ** 2, axis=1)
    return [(length, float(np.hypot(*off_n[i])), float(z2[i])) for i, (_, length) in enumerate(begins)]


def outages(name: str, grade: str, runs: int, seed: int, workers: int) -> pd.DataFrame:
    """Of the starts of a seed, in their order."""
    found = in_order(partial(drive, name, grade), starts_of(seed, runs), workers, 4)
    return pd.DataFrame(chain.from_iterable(found), columns=["length_s", "error_m", "z2"])
