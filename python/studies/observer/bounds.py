"""A positive parameter near zero: the observer with and without its bound, beside filterpy's unscented filter, which has none."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from filterpy.kalman import MerweScaledSigmaPoints, UnscentedKalmanFilter

from hnav.filters.observer import Observer
from hnav.filters.observer_plan import Plan
from hnav.filters.plant import Plant
from hnav.native.arrays import Array

RUNS = 200
T_S = np.arange(1.0, 41.0)
NOISE, START_SIGMA, LOSS_SIGMA = 0.05, 0.1, 0.005


def room() -> Plant:
    """It cools through its wall: T' = -g T."""
    return Plant(
        states={"T": 1.0}, parameters={"g": 0.0}, sensors=["T"],
        derivatives=lambda t, x, u, p: [-p[0] * x[0]], outputs=lambda t, x, u, p: [x[0]],
    )  # fmt: skip


def observed(min: float) -> Callable[[Array], tuple[Array, Array, Array]]:
    """Losses at all samples, and the last estimate with its covariance."""
    plan = Plan(room()).sensor("T", noise=NOISE).state("T", start_sigma=START_SIGMA)
    plan.parameter("g", start_sigma=LOSS_SIGMA, min=min)

    def run(y: Array) -> tuple[Array, Array, Array]:
        made = Observer(plan, start_mode="given").run(T_S, {"T": y})
        return made.x["g"], np.array([made.x["T"][-1], made.x["g"][-1]]), made.covariance[-1]

    return run


def unscented(y: Array) -> tuple[Array, Array, Array]:
    """The same of filterpy."""
    points = MerweScaledSigmaPoints(2, alpha=0.1, beta=2.0, kappa=1.0)
    ukf = UnscentedKalmanFilter(
        2, 1, 1.0, hx=lambda x: x[:1], fx=lambda x, dt: np.array([x[0] * math.exp(-x[1] * dt), x[1]]), points=points
    )
    ukf.x, ukf.P = np.array([1.0, 0.0]), np.diag([START_SIGMA**2, LOSS_SIGMA**2])
    ukf.Q, ukf.R = np.zeros((2, 2)), np.array([[NOISE**2]])
    losses = []
    for sample in y:
        ukf.predict()
        ukf.update(np.array([sample]))
        losses.append(ukf.x[1])
    return np.array(losses), ukf.x, ukf.P


def results(runs: int = RUNS) -> list[dict[str, Any]]:
    """Of all filters on the same samples, whose loss is the absolute value of a Gaussian number. nees, rms: at the end, rms of
    the loss in 1/s; negative: percent of all samples at which the estimated loss is below 0."""
    filters = {"hnav, min = 0": observed(0.0), "hnav, no bound": observed(-math.inf), "filterpy UKF, no bound": unscented}
    made = []
    for name, run in filters.items():
        rng, squares, errors, negative = np.random.default_rng(3), [], [], []
        for _ in range(runs):
            g, start = abs(LOSS_SIGMA * rng.normal()), 1 + START_SIGMA * rng.normal()
            losses, x, P = run(start * np.exp(-g * T_S) + NOISE * rng.normal(size=len(T_S)))
            error = x - [start * math.exp(-g * T_S[-1]), g]
            squares.append(error @ np.linalg.solve(P, error) / 2)
            errors.append(error[1])
            negative.append(np.mean(losses < 0))
        rms = np.sqrt(np.mean(np.square(errors)))
        made.append({"filter": name, "nees": np.mean(squares), "rms": rms, "negative": 100 * np.mean(negative)})
    return made
