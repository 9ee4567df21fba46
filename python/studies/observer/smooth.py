"""Observers of plants without events: errors and innovations over what they are said to be, in runs with known truth."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from scipy.linalg import cholesky

from hnav.filters.linear_model import LinearModel
from hnav.filters.observer import Observer, ObserverRun
from hnav.filters.observer_plan import Plan
from hnav.filters.plant import Plant
from hnav.native.arrays import Array
from hnav.systems.statistics import normalised_squares

SETTLED = 20  # samples that a start far off is given


def van_der_pol(rng: np.random.Generator, steps: int = 200, interval_s: float = 0.05) -> tuple[Array, Array]:
    """The states at each sample, by Heun's method with noise, and the samples of the first."""
    x, rows = np.array([2.0, 0.0]), []
    noise, h = np.array([0.01, 0.1]), interval_s / 20
    for _ in range(steps):
        for _ in range(20):
            slope = np.array([x[1], (1 - x[0] ** 2) * x[1] - x[0]])
            y = x + h * slope
            x = x + h / 2 * (slope + [y[1], (1 - y[0] ** 2) * y[1] - y[0]]) + noise * np.sqrt(h) * rng.standard_normal(2)
        rows.append(x)
    truth = np.array(rows)
    return truth, truth[:, 0] + 0.05 * rng.standard_normal(steps)


def oscillator(plant: Plant | Path, start: Array) -> Plan:
    """A plan of the van der Pol oscillator."""
    plan = Plan(plant).sensor("x0", noise=0.05)
    for name, value, noise in zip(("x0", "x1"), start, (0.01, 0.1)):
        plan.state(name, start=float(value), start_sigma=1.0, noise=noise)
    plan.options = {"start_mode": "given"}
    return plan


def in_python(mu: float = 1.0) -> Plant:
    """The same as functions."""
    return Plant(
        lambda t, x, u, p: (x[1], mu * (1 - x[0] * x[0]) * x[1] - x[0]), lambda t, x, u, p: x[0], states={"x0": 2.0, "x1": 0.0},
        sensors=["x0"], jacobian=lambda t, x, u, p: ((0, 1), (-2 * mu * x[0] * x[1] - 1, mu * (1 - x[0] * x[0]))),
    )  # fmt: skip


def oscillators(plant: Plant | Path, seeds: int) -> Iterator[tuple[Array, Array, float]]:
    """Of each run: normalised squares of errors and of innovations, and the time of a sample."""
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        start = np.array([2.0, 0.0]) + rng.standard_normal(2)
        truth, y = van_der_pol(rng)
        observer = Observer(oscillator(plant, start))
        begin = time.thread_time()
        run = observer.run(0.05 * np.arange(1, len(y) + 1), {"x0": y})
        spent = time.thread_time() - begin
        error = truth - np.stack([run.x["x0"], run.x["x1"]], axis=1)
        yield normalised_squares(error, run.covariance)[SETTLED:] / error.shape[1], run.nis["x0"][SETTLED:], spent / len(y)


def stepped(A: Array, B: Array, Q: Array, interval_s: float) -> tuple[Array, Array, Array]:
    """Of x' = A x + B u + w over an interval: the matrices of x and u, and a root of the covariance of what w adds. Q: density of w."""
    eye = np.eye(len(A))
    step = LinearModel(A=A, B=B, H=eye, Qw=Q, Qv=eye, P0=eye, interval_s=interval_s).discrete()
    return step.A, step.matrix("B"), cholesky(step.Qw, lower=True)


def room(fmu: Path, seed: int) -> tuple[Array, ObserverRun, float]:
    """A heated room whose loss G is learnt, for five hours: exact truth, a sample a minute. T_wall, T_air and G at each, the run, and the
    time of a sample."""
    T, n = 60.0, 300
    rng = np.random.default_rng(seed)
    G = 8.0 + 2.5 * np.clip(rng.standard_normal(), -2, 2)
    cooling = np.array([[-(25 + G) / 4000, 25 / 4000], [25 / 400, -25 / 400]])
    A, B, root = stepped(cooling, np.diag([G / 4000, 1 / 400]), np.diag([1e-6, 1e-5]), T)
    x = np.array([15.0, 18.0]) + [2, 0.5] * rng.standard_normal(2)
    power, outside = 400.0 * (np.arange(n) // 20 % 2), 5 + 4 * np.sin(2 * np.pi * np.arange(n) / 1440)
    rows = []
    for k in range(n):
        x = A @ x + B @ [outside[k], power[k]] + root @ rng.standard_normal(2)
        rows.append(x)
    truth = np.column_stack([*np.array(rows).T, np.full(n, G)])
    plan = Plan(fmu).sensor("T_air", noise=0.05).input("power", start=power[0]).input("T_out", start=outside[0])
    plan.state("T_wall", start=15, start_sigma=2, noise=1e-3).state("T_air", start=18, start_sigma=0.5, noise=10**-2.5)
    observer = Observer(plan.parameter("G", start_sigma=2.5), start_mode="given")
    seen = truth[:, 1] + 0.05 * rng.standard_normal(n)
    # What the inputs are from a sample on is what they were held at in the interval behind it.
    held = {"power": np.append(power[1:], power[-1]), "T_out": np.append(outside[1:], outside[-1])}
    begin = time.thread_time()
    run = observer.run(T * np.arange(1, n + 1), {"T_air": seen}, held)
    return truth, run, (time.thread_time() - begin) / n


def rooms(fmu: Path, seeds: int) -> Iterator[tuple[Array, Array, float]]:
    """As oscillators."""
    for seed in range(seeds):
        truth, run, spent = room(fmu, seed)
        error = truth - np.column_stack([*run.x.values()])
        yield normalised_squares(error, run.covariance)[SETTLED::20] / error.shape[1], run.nis["T_air"][SETTLED:], spent


def measured(name: str, runs: Iterator[tuple[Array, Array, float]]) -> dict[str, Any]:
    """The means over all runs; us_per_sample: of a processor, the median."""
    nees, nis, spent = zip(*runs)
    return {"plant": name, "nees": np.mean(nees), "nis": np.mean(nis), "us_per_sample": 1e6 * np.median(spent)}


def results(runs: int) -> list[dict[str, Any]]:
    """Of all plants that there are."""
    plants = [("van der Pol, functions in Python", oscillators(in_python(), runs))]
    folder = os.environ.get("HNAV_PLANTS")
    if folder:
        for version in (2, 3):
            fmu = Path(folder) / f"fmi{version}" / "VanDerPol.fmu"
            plants.append((f"van der Pol, FMI {version}", oscillators(fmu, runs)))
        plants.append(("heated room with unknown loss, FMI 3", rooms(Path(folder) / "fmi3/HeatedRoom.fmu", runs)))
    return [measured(name, made) for name, made in plants]
