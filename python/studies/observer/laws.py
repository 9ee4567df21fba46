"""Single figures of the observer beside what they have to be: closed forms, a Kalman filter, 20 000 samples, known parameters."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from hnav.filters.observer import Observer
from hnav.filters.observer_plan import Plan
from hnav.filters.plant import Plant
from hnav.native.arrays import Array
from studies.observer import events, smooth

SAMPLES = 20000
RUNS = 100  # of what is learnt
STIFF = 1000.0  # mu of the stiff oscillator
KINDS = ("functions", "FMI 2", "FMI 3")


def plants_of(fmu: str, functions: Plant | None) -> dict[str, Plant | Path]:
    """The kinds of a plant that are here."""
    found: dict[str, Plant | Path] = {"functions": functions} if functions else {}
    folder = os.environ.get("HNAV_PLANTS")
    for version in (2, 3) if folder else ():
        path = Path(folder or "") / f"fmi{version}" / f"{fmu}.fmu"
        if path.is_file():
            found[f"FMI {version}"] = path
    return found


def results() -> Iterator[dict[str, Any]]:
    """All of them: figure, what it is where all is right, and its value by kind of the same plant, NaN where there is none."""
    for figures, of, plants in all_figures():
        measured = {kind: of(plants[kind]) if kind in plants else [math.nan] * len(figures) for kind in KINDS}
        for k, (figure, right) in enumerate(figures):
            yield {"figure": figure, "right": right} | {kind: values[k] for kind, values in measured.items()}


Figures = tuple[tuple[str, str], ...]


def all_figures() -> Iterator[tuple[Figures, Callable[[Plant | Path], tuple[float, ...]], dict[str, Plant | Path]]]:
    """Names of figures and what is right, who measures them, and of which plants."""
    decay = Plant(lambda t, x, u, p: -x, lambda t, x, u, p: x[0], states={"x": 1.0}, sensors=["x"])
    normalised = ("    its square over sigma's", "1")
    sigmas = (("    sigma of h over that of 20 000 samples", "1"), ("    sigma of v", "1"))
    yield (("linear decay: off its Kalman filter, in sigma", "0"),), beside_kalman, plants_of("Dahlquist", decay)
    yield (
        (("a bounce: mean of h off that of 20 000 samples, in sigma", "0"), *sigmas), bounced, plants_of("BouncingBall", events.ball()),
    )  # fmt: skip
    yield (("a ceiling hardly reached: mean of h, in sigma", "0"), *sigmas), grazed, {"functions": ceiling()}
    yield (
        (("a ball after 1.5 s: rms error of its restitution", ""), normalised), restitution,
        plants_of("BouncingBall", ball_with_restitution()),
    )  # fmt: skip
    yield (("a room after 5 h: rms error of its loss", ""), normalised), loss, plants_of("HeatedRoom", None)
    yield (
        (("stiff oscillator through its jumps: NIS by sigma points", "1"), ("    by derivatives", "1")), stiff_nis,
        plants_of("VanDerPol", smooth.in_python(STIFF)),
    )  # fmt: skip


# --------------------------------------------------------------------------------------------- plants


def ball_with_restitution() -> Plant:
    """The ball, its restitution a parameter."""
    return Plant(
        lambda t, x, u, p: (x[1], -events.GRAVITY), lambda t, x, u, p: x[0], states={"h": 1.0, "v": 0.0}, sensors=["h"],
        parameters={"e": 0.7}, indicators=lambda t, x, u, p: x[0],
        event=lambda t, x, u, p: (0.0, -p[0] * x[1]) if x[0] <= 0 and x[1] < 0 else x,
    )  # fmt: skip


def ceiling() -> Plant:
    """Thrown up from 0.5 m to a ceiling at 1 m, which throws back."""
    return Plant(
        lambda t, x, u, p: (x[1], -events.GRAVITY), lambda t, x, u, p: x[0],
        states={"h": 0.5, "v": math.sqrt(events.GRAVITY)}, sensors=["h"], indicators=lambda t, x, u, p: 1 - x[0],
        event=lambda t, x, u, p: (x[0], -0.7 * x[1] - 1) if x[0] >= 1 and x[1] > 0 else x,
    )  # fmt: skip


# --------------------------------------------------------------------------------------------- figures


def beside_kalman(plant: Plant | Path) -> tuple[float, ...]:
    """x' = -x + w: the largest difference of mean and sigma, in sigma, over 100 samples."""
    T, q, r = 0.1, 0.3, 0.05
    plan = Plan(plant).sensor("x", noise=r).state("x", start_sigma=0.5, noise=q)
    y = np.exp(-T * np.arange(1, 101)) + r * np.random.default_rng(1).standard_normal(100)
    run = Observer(plan, start_mode="given").run(T * np.arange(1, 101), {"x": y})
    x, P, flow, most = 1.0, 0.25, math.exp(-T), 0.0
    for k, sample in enumerate(y):
        x, P = flow * x, flow * flow * P + q * q * 0.5 * (1 - flow * flow)
        gain = P / (P + r * r)
        x, P = x + gain * (sample - x), (1 - gain) * P
        sigma = math.sqrt(P)
        most = max(most, abs(run.x["x"][k] - x) / sigma, abs(run.sigma["x"][k] / sigma - 1))
    return (most,)


def beside_samples(plan: Plan, t_s: float, truth: Array) -> tuple[float, ...]:
    """Mean of h and sigmas of both after one uninformative sample, beside those of many true states."""
    run = Observer(plan, start_mode="given").run([t_s], {"h": [0.0]})
    mean, sigma = truth.mean(axis=0), truth.std(axis=0)
    return float(run.x["h"][0] - mean[0]) / sigma[0], run.sigma["h"][0] / sigma[0], run.sigma["v"][0] / sigma[1]


def bounced(plant: Plant | Path) -> tuple[float, ...]:
    """Of the ball at 0.7 s, after its first bounce."""
    plan = Plan(plant).sensor("h", noise=1e6).state("h", start_sigma=0.02).state("v", start_sigma=0.1)
    h, v = (np.random.default_rng(1).standard_normal((SAMPLES, 2)) * [0.02, 0.1] + [1, 0]).T
    hit_s = (v + np.sqrt(v * v + 2 * events.GRAVITY * h)) / events.GRAVITY
    up, left_s = -0.7 * (v - events.GRAVITY * hit_s), 0.7 - hit_s
    truth = np.column_stack([up * left_s - 0.5 * events.GRAVITY * left_s**2, up - events.GRAVITY * left_s])
    return beside_samples(plan, 0.7, truth)


def grazed(plant: Plant | Path) -> tuple[float, ...]:
    """Of the ball at 0.6 s, whose mean just touches the ceiling."""
    plan = Plan(plant).sensor("h", noise=1e6).state("h", start_sigma=0.02).state("v", start_sigma=0.1)
    g, T, start = events.GRAVITY, 0.6, [0.5, math.sqrt(events.GRAVITY)]
    h, v = (np.random.default_rng(3).standard_normal((SAMPLES, 2)) * [0.02, 0.1] + start).T
    left = v * v - 2 * g * (1 - h)
    w = np.sqrt(np.maximum(left, 0))
    down, after_s = -0.7 * w - 1, T - (v - w) / g
    touched = np.column_stack([1 + down * after_s - 0.5 * g * after_s**2, down - g * after_s])
    free = np.column_stack([h + v * T - 0.5 * g * T * T, v - g * T])
    return beside_samples(plan, T, np.where((left > 0)[:, None], touched, free))


def restitution(plant: Plant | Path) -> tuple[float, ...]:
    """Of the ball, from 0.05 off, by 30 samples."""
    case = events.Case("", plant, {"h": 1, "v": 0}, (0.02, 0.05), (0, 0.005**0.5), 0.01, 0.05, 30, events.bounce, 1)
    pairs = []
    for seed in range(RUNS):
        truth, y = events.truth_and_samples(case, np.random.default_rng(seed))
        start = 0.7 + float(np.clip(0.05 * np.random.default_rng(10**6 + seed).standard_normal(), -0.15, 0.13))
        plan = events.plan_of(case).parameter("e", start=start, start_sigma=0.05)
        run = Observer(plan, start_mode="given").run(case.interval_s * np.arange(1, len(y) + 1), {"h": y})
        pairs.append((run.x["e"][-1] - 0.7, run.sigma["e"][-1]))
    return errors(pairs)


def loss(fmu: Plant | Path) -> tuple[float, ...]:
    """Of the heated room, from 2.5 off."""
    assert isinstance(fmu, Path)
    pairs = []
    for seed in range(RUNS):
        truth, run, _ = smooth.room(fmu, seed)
        pairs.append((run.x["G"][-1] - truth[-1, 2], run.sigma["G"][-1]))
    return errors(pairs)


def errors(pairs: list[tuple[float, float]]) -> tuple[float, ...]:
    """Their root mean square, and the mean of their squares over variances."""
    error, sigma = np.array(pairs).T
    return float(np.sqrt(np.mean(error**2))), float(np.mean((error / sigma) ** 2))


def stiff_nis(plant: Plant | Path) -> tuple[float, ...]:
    """Over 2000 s, samples every 10 s, with two jumps at times with a sigma of a second."""
    t_s = np.arange(1, 201) * 10.0

    def slope(t: float, x: Array) -> tuple[float, float]:
        return x[1], STIFF * (1 - x[0] ** 2) * x[1] - x[0]

    true = solve_ivp(slope, (0, t_s[-1]), [2, 0], method="Radau", rtol=1e-9, atol=1e-12, t_eval=t_s).y[0]
    y = true + 0.05 * np.random.default_rng(0).standard_normal(len(t_s))
    plan = Plan(plant).sensor("x0", noise=0.05).state("x0", start=2, start_sigma=0.1, noise=1e-3)
    plan.state("x1", start=0, start_sigma=1e-3, noise=1e-3, nominal=1e-2)
    if isinstance(plant, Path):
        plan.set("mu", STIFF)
    means = []
    for propagation in ("sigma_points", "derivatives"):
        run = Observer(plan, start_mode="given", propagation=propagation).run(t_s, {"x0": y})
        means.append(float(np.nanmean(run.nis["x0"])))
    return tuple(means)
