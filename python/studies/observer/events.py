"""Observers of plants with events beside particle filters with the same model and samples."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hnav.filters.observer import Observer
from hnav.filters.observer_plan import Plan
from hnav.filters.plant import Plant
from hnav.native.arrays import Array
from hnav.systems.statistics import normalised_squares

GRAVITY = 9.81
PARTICLES = 5000
SUBSTEPS = 100
SEEDS = (0, 1000, 2000)  # the first of each set


@dataclass(frozen=True)
class Case:
    """A plant with events, what is known of it, and how it moves."""

    name: str
    plant: Plant | Path
    start: dict[str, float]
    sigma: tuple[float, ...]
    noise: tuple[float, ...]
    sensor_sigma: float
    interval_s: float
    samples: int
    step: Callable[[Array, float, Array], None]
    """Moves rows of states (and of a discrete number behind them) over a short time, given their noise."""
    worst: int
    """The state whose error is shown."""


def bounce(x: Array, d: float, noise: Array) -> None:
    """A ball."""
    before = x[:, 1].copy()
    x[:, 1] += noise[:, 1] - GRAVITY * d
    x[:, 0] += 0.5 * (before + x[:, 1]) * d
    hit = (x[:, 0] <= 0) & (x[:, 1] < 0)
    x[hit, 0], x[hit, 1] = 0, -0.7 * x[hit, 1]


def swing(x: Array, d: float, noise: Array) -> None:
    """A pendulum with a stop."""
    x[:, 1] += noise[:, 1] - d * (GRAVITY * np.sin(x[:, 0]) + 0.1 * x[:, 1])
    x[:, 0] += d * x[:, 1]
    hit = (x[:, 0] <= -0.2) & (x[:, 1] < 0)
    x[hit, 0], x[hit, 1] = -0.4 - x[hit, 0], -0.8 * x[hit, 1]


def heat(x: Array, d: float, noise: Array) -> None:
    """A heater and its thermostat, whose position stands behind the temperature."""
    x[:, 0] += noise[:, 0] + d * (np.where(x[:, 1] > 0, 3, -3) - x[:, 0])
    x[:, 1] = np.where(x[:, 0] >= 1, 0, np.where(x[:, 0] <= -1, 1, x[:, 1]))


def ball() -> Plant:
    """As functions."""
    return Plant(
        lambda t, x, u, p: (x[1], -GRAVITY), lambda t, x, u, p: x[0], states={"h": 1.0, "v": 0.0}, sensors=["h"],
        indicators=lambda t, x, u, p: x[0], event=lambda t, x, u, p: (0.0, -0.7 * x[1]) if x[0] <= 0 and x[1] < 0 else x,
    )  # fmt: skip


def pendulum() -> Plant:
    """As functions."""
    return Plant(
        lambda t, x, u, p: (x[1], -GRAVITY * np.sin(x[0]) - 0.1 * x[1]), lambda t, x, u, p: x[0], states={"angle": 0.5, "rate": 0.0},
        sensors=["angle"], indicators=lambda t, x, u, p: x[0] + 0.2,
        event=lambda t, x, u, p: (x[0], -0.8 * x[1]) if x[0] <= -0.2 and x[1] < 0 else x,
    )  # fmt: skip


def heater() -> Plant:
    """As functions."""
    return Plant(
        lambda t, x, u, p, q: (3 if q[0] else -3) - x, lambda t, x, u, p, q: x[0], states={"T": 0.0}, sensors=["T"], discrete={"on": 1.0},
        indicators=lambda t, x, u, p, q: 1 - x[0] if q[0] else x[0] + 1,
        event=lambda t, x, u, p, q: (x, [1 - q[0]] if (x[0] >= 1 if q[0] else x[0] <= -1) else q),
    )  # fmt: skip


def cases() -> Iterator[Case]:
    """All that there are: of a ball also the Reference FMUs, where HNAV_PLANTS names their folder."""
    folder = os.environ.get("HNAV_PLANTS")
    balls: list[tuple[str, Plant | Path]] = [("ball, functions in Python", ball())]
    if folder:
        balls += [(f"ball, FMI {v}", Path(folder) / f"fmi{v}/BouncingBall.fmu") for v in (2, 3)]
    for name, plant in balls:
        yield Case(name, plant, {"h": 1.0, "v": 0.0}, (0.05, 0.3), (0, 0.02**0.5), 0.02, 0.05, 24, bounce, 1)
    yield Case("pendulum with a stop", pendulum(), {"angle": 0.5, "rate": 0.0}, (0.05, 0.1), (0, 0.05), 0.02, 0.05, 40, swing, 1)
    yield Case("relay with hysteresis", heater(), {"T": 0.0}, (0.3,), (0.1,), 0.1, 0.1, 60, heat, 0)


def plan_of(case: Case) -> Plan:
    """What is known of it."""
    plan = Plan(case.plant).sensor(next(iter(case.start)), noise=case.sensor_sigma)
    for name, sigma, noise in zip(case.start, case.sigma, case.noise):
        plan.state(name, start=case.start[name], start_sigma=sigma, noise=noise)
    return plan


def truth_and_samples(case: Case, rng: np.random.Generator) -> tuple[Array, Array]:
    """States at each sample, and the samples of the first of them."""
    x = _begin(case, rng, 1)
    rows = []
    for _ in range(case.samples):
        _move(case, x, rng)
        rows.append(x[0, : len(case.sigma)].copy())
    truth = np.array(rows)
    return truth, truth[:, 0] + case.sensor_sigma * rng.standard_normal(case.samples)


def particles(case: Case, y: Array, rng: np.random.Generator) -> Array:
    """Their means at each sample."""
    n = len(case.sigma)
    x, means = _begin(case, rng, PARTICLES), []
    for sample in y:
        _move(case, x, rng)
        weight = np.exp(-0.5 * ((sample - x[:, 0]) / case.sensor_sigma) ** 2) + 1e-300
        weight /= weight.sum()
        means.append(weight @ x[:, :n])
        drawn = np.searchsorted(np.cumsum(weight), (np.arange(PARTICLES) + rng.random()) / PARTICLES)
        x = x[drawn.clip(0, PARTICLES - 1)]
    return np.array(means)


def _begin(case: Case, rng: np.random.Generator, count: int) -> Array:
    x = np.array([*case.start.values()]) + np.array(case.sigma) * rng.standard_normal((count, len(case.sigma)))
    return np.column_stack([x, np.ones(count)])


def _move(case: Case, x: Array, rng: np.random.Generator) -> None:
    d = case.interval_s / SUBSTEPS
    scale = np.array(case.noise) * np.sqrt(d)
    for _ in range(SUBSTEPS):
        case.step(x, d, scale * rng.standard_normal((len(x), len(scale))))


def measured(case: Case, runs: int, first_seed: int) -> dict[str, Any]:
    """Of one plant and one set of seeds; rms, rms_particles: of the errors of the state `worst`; us_per_sample: of a
    processor."""
    nees, errors, of_particles, parts, spent = [], [], [], [], []
    sensor = next(iter(case.start))
    for seed in range(first_seed, first_seed + runs):
        truth, y = truth_and_samples(case, np.random.default_rng(seed))
        observer = Observer(plan_of(case), start_mode="given")
        begin = time.thread_time()
        run = observer.run(case.interval_s * np.arange(1, len(y) + 1), {sensor: y})
        spent.append((time.thread_time() - begin) / len(y))
        error = truth - np.stack([run.x[name] for name in case.start], axis=1)
        nees.append(np.mean(normalised_squares(error, run.covariance)) / error.shape[1])
        errors.append(error[:, case.worst])
        of_particles.append((truth - particles(case, y, np.random.default_rng(10**6 + seed)))[:, case.worst])
        parts.append(run.parts.mean())
    rms, rms_particles = (np.sqrt(np.mean(np.square(e))) for e in (errors, of_particles))
    return {
        "plant": f"{case.name}, seeds from {first_seed}", "nees": np.mean(nees), "rms": rms, "rms_particles": rms_particles,
        "ratio": rms / rms_particles, "parts": np.mean(parts), "us_per_sample": 1e6 * np.median(spent),
    }  # fmt: skip


def results(runs: int) -> Iterator[dict[str, Any]]:
    """Of all plants: three sets of seeds where they are functions, one where they are FMUs."""
    for case in cases():
        for seed in SEEDS if isinstance(case.plant, Plant) else SEEDS[:1]:
            yield measured(case, runs, seed)
