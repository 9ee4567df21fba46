"""Smoothing: equal to the batch solution of a linear plant; on other plants more accurate than the filter, with consistent sigmas."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.linalg import expm

from hnav.errors import HnavError, HnavValueError
from hnav.filters.observer import Observer, ObserverRun
from hnav.filters.observer_plan import Plan
from hnav.filters.plant import Plant
from hnav.systems.statistics import normalised_squares
from observer.test_bounds import T_S as DAYS
from observer.test_bounds import room
from observer.test_bounds import samples as temperatures
from observer.test_fmu_plants import T_S, little_plan, samples
from studies.observer import tank
from studies.observer.events import cases, plan_of, truth_and_samples

A = np.array([[0, 1, 0], [-4, -0.3, 0], [0.2, 0, -0.2]])
NOISE, START, START_SIGMA = np.array([0, 0.3, 0.02]), np.array([1, 0, 0.3]), np.array([0.5, 0.7, 0.2])
SENSORS = {"a": (0, 0.05), "c": (2, 0.1)}  # index of the state, sigma


def linear_plan() -> Plan:
    plant = Plant(
        lambda t, x, u, p: A @ x, lambda t, x, u, p: [x[0], x[2]], states={"a": 1.0, "b": 0.0, "c": 0.3}, sensors=["a", "c"]
    )
    plan = Plan(plant)
    for name, (_, sigma) in SENSORS.items():
        plan.sensor(name, noise=sigma)
    for name, sigma, noise in zip("abc", START_SIGMA, NOISE):
        plan.state(name, start_sigma=sigma, noise=noise)
    return plan


def recording(seed: int, n: int = 60) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Irregular times; samples missing, in some rows all of them."""
    rng = np.random.default_rng(seed)
    t, y = np.cumsum(rng.uniform(0.02, 0.2, n)), rng.normal(size=(n, 2))
    y[rng.random((n, 2)) < 0.4] = math.nan
    y[0] = 1, 0.2
    return t, dict(zip(SENSORS, y.T))


def batch(t: np.ndarray, y: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """The least squares solution of all rows at once, and its covariance."""
    n, N, Q = len(t), len(A), np.diag(NOISE**2)
    information, vector = np.zeros((n * N, n * N)), np.zeros(n * N)
    information[:N, :N], vector[:N] = np.diag(START_SIGMA**-2.0), START / START_SIGMA**2
    for k in range(n):
        for name, (state, sigma) in SENSORS.items():
            if np.isfinite(y[name][k]):
                information[k * N + state, k * N + state] += sigma**-2
                vector[k * N + state] += y[name][k] / sigma**2
        if k > 0:
            pair = expm(np.block([[-A, Q], [np.zeros((N, N)), A.T]]) * (t[k] - t[k - 1]))
            F = pair[N:, N:].T
            step = np.hstack([-F, np.eye(N)])
            both = slice((k - 1) * N, (k + 1) * N)
            information[both, both] += step.T @ np.linalg.solve(F @ pair[:N, N:], step)
    covariance = np.linalg.inv(information)
    return (covariance @ vector).reshape(n, N), covariance.reshape(n, N, n, N)[np.arange(n), :, np.arange(n), :]


def test_of_a_linear_plant_it_is_the_batch_solution():
    t, y = recording(0)
    run = Observer(linear_plan(), rtol=1e-12, covariance_rtol=1e-12).smooth(t, y)
    x, P = batch(t, y)
    sigma = np.sqrt(np.einsum("kii->ki", P))
    assert np.abs((np.column_stack([*run.x.values()]) - x) / sigma).max() < 1e-9
    assert np.abs((run.covariance - P) / (sigma[:, :, None] * sigma[:, None, :])).max() < 1e-9
    assert np.abs(np.column_stack([*run.sigma.values()]) / sigma - 1).max() < 1e-9
    assert run.smoothed and "smoothed" in repr(run)


def test_sigma_points_smooth_a_linear_plant_likewise():
    t, y = recording(1)
    t = 0.1 * t
    by_points = Observer(linear_plan(), rtol=1e-12, propagation="sigma_points").smooth(t, y)
    # Half of the noise enters before an interval and half after: the same for short intervals.
    usual = Observer(linear_plan()).smooth(t, y)
    for name in "abc":
        assert np.abs((by_points.x[name] - usual.x[name]) / usual.sigma[name]).max() < 0.01
        assert np.abs(by_points.sigma[name] / usual.sigma[name] - 1).max() < 1e-3


def test_the_filter_stays_where_it_is_and_the_last_row_is_its_own():
    t, y = recording(2)
    y = {name: np.nan_to_num(values) for name, values in y.items()}
    observer = Observer(linear_plan())
    run = observer.run(t, y)
    before = observer.estimate(), observer.info()
    smooth = observer.smooth(t, y)
    assert (observer.estimate(), observer.info()) == before
    for name in "abc":
        assert smooth.x[name][-1] == run.x[name][-1]
        assert (smooth.sigma[name] <= run.sigma[name] * (1 + 1e-9)).all()
        assert (smooth.sigma[name] < 0.9 * run.sigma[name])[:-10].all()
        assert np.array_equal(smooth.nis[name], run.nis[name]) if name in run.nis else name == "b"
    again = observer.smooth(t, y)
    assert all(np.array_equal(again.x[name], smooth.x[name]) for name in "abc")


def swings(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """A pendulum of unknown length: angle, rate and length at each sample, and samples of the angle, of which half are missing."""
    rng = np.random.default_rng(seed)
    length, x, dt, steps, rows = 1 + 0.1 * rng.normal(), np.array([0.5, 0.2 * rng.normal()]), 0.05, 20, []
    x[0] += 0.05 * rng.normal()
    for _ in range(120):
        for _ in range(steps):
            d = dt / steps
            x = x + d * np.array([x[1], -9.81 / length * np.sin(x[0]) - 0.1 * x[1]])
            x[1] += 0.1 * np.sqrt(d) * rng.normal()
        rows.append([*x, length])
    y = np.array(rows)[:, 0] + 0.03 * rng.normal(size=120)
    y[rng.random(120) < 0.5] = math.nan
    return np.array(rows), y


def pendulum() -> Plan:
    plant = Plant(
        lambda t, x, u, p: (x[1], -9.81 / p[0] * np.sin(x[0]) - 0.1 * x[1]), lambda t, x, u, p: x[0], states={"angle": 0.5, "rate": 0.0},
        parameters={"length": 1.0}, sensors=["angle"],
    )  # fmt: skip
    plan = Plan(plant).sensor("angle", noise=0.03).state("angle", start_sigma=0.05)
    return plan.state("rate", start_sigma=0.2, noise=0.1).parameter("length", start_sigma=0.1)


def scores(runs: list[tuple[np.ndarray, ObserverRun]]) -> tuple[float, np.ndarray]:
    """NEES/n and the RMS of each error."""
    errors = [truth - np.column_stack([*run.x.values()]) for truth, run in runs]
    squares = [normalised_squares(e, run.covariance) / e.shape[1] for e, (_, run) in zip(errors, runs)]
    return float(np.mean(squares)), np.sqrt(np.mean(np.square(errors), axis=(0, 1)))


def compare(filtered, smoothed, gain: float) -> None:
    """Smoothed errors are smaller by the gain at least, and as large as stated."""
    (_, of_filter), (nees, of_smoother) = scores(filtered), scores(smoothed)
    assert (of_smoother < gain * of_filter).all(), of_smoother / of_filter
    assert 0.8 < nees < 1.3


@pytest.mark.parametrize("options", [{}, {"propagation": "sigma_points"}], ids=["derivatives", "sigma points"])
def test_a_pendulum_of_unknown_length(options):
    runs = [swings(seed) for seed in range(12)]
    t = 0.05 * np.arange(1, 121)
    made = {
        smooth: [(x, Observer(pendulum(), start_mode="given", **options).run(t, {"angle": y}, smooth=smooth)) for x, y in runs]
        for smooth in (False, True)
    }
    compare(made[False], made[True], 0.7)


@pytest.mark.parametrize("case", [case for case in cases() if isinstance(case.plant, Plant)], ids=lambda case: case.name)
def test_plants_with_events(case):
    made: dict[bool, list] = {False: [], True: []}
    sensor = next(iter(case.start))
    plan = plan_of(case)
    for seed in range(8):
        truth, y = truth_and_samples(case, np.random.default_rng(seed))
        for smooth, runs in made.items():
            runs.append(
                (
                    truth,
                    Observer(plan, start_mode="given").run(
                        case.interval_s * np.arange(1, len(y) + 1), {sensor: y}, smooth=smooth
                    ),
                )
            )
    compare(made[False], made[True], 1.0)


@pytest.mark.parametrize(("runs", "bounds"), [(2, {}), (5, {"min": 0.0})], ids=["free", "bounded"])
def test_a_tank_that_runs_empty(runs, bounds):
    made: dict[bool, list] = {False: [], True: []}
    for seed in range(runs):
        h, y = tank.emptied(seed)
        for smooth, runs in made.items():
            runs.append((h[:, None], Observer(tank.plan(**bounds)).run(tank.T_S, {"h": y}, {"q": tank.inflow()}, smooth=smooth)))
    compare(made[False], made[True], 0.9)
    assert all((run.x["h"] >= 0).all() for _, run in made[True]) or not bounds
    assert [run.held for _, run in made[True]] == [run.held for _, run in made[False]]


@pytest.mark.parametrize(
    "bound",
    [{"start": 0.0, "start_sigma": 0.005, "min": 0.0}, {"start": 0.02, "start_sigma": 0.004, "log": True}],
    ids=["min", "log"],
)
def test_bounds_hold_with_hindsight(bound):
    squares, rng = [], np.random.default_rng(5)
    plan = Plan(room()).sensor("T", noise=0.05).state("T", start_sigma=0.1).parameter("g", **bound)
    for _ in range(60):
        g = abs(0.005 * rng.normal()) if "min" in bound else 0.02 * math.exp(0.198 * rng.normal() - 0.0196)
        start = 1 + 0.1 * rng.normal()
        run = Observer(plan).smooth(DAYS, {"T": temperatures(g, start, rng)})
        assert (run.x["g"] > 0).all()
        truth = np.column_stack([start * np.exp(-g * DAYS), np.full(len(DAYS), g)])
        squares.append(normalised_squares(truth - np.column_stack([*run.x.values()]), run.covariance)[5] / 2)
    assert 0.7 < np.mean(squares) < 1.35


def test_of_an_fmu(little_fmu):
    x = np.where(np.arange(len(T_S)) % 2 == 0, samples(), np.nan)
    observer = Observer(little_plan(little_fmu))
    run, smooth = observer.run(T_S, {"x": x}, {"u": np.sin(T_S)}), observer.smooth(T_S, {"x": x}, {"u": np.sin(T_S)})
    assert smooth.x["v"][-1] == run.x["v"][-1]
    assert (smooth.sigma["v"] < run.sigma["v"])[:-1].all()
    assert smooth.columns().keys() == run.columns().keys()


def test_samples_that_are_none_are_refused_as_by_run():
    t, y = recording(3)
    with pytest.raises(HnavValueError, match="not finite"):
        Observer(linear_plan()).smooth(t, y | {"a": np.where(np.arange(len(t)) == 7, math.inf, y["a"])})
    with pytest.raises(HnavError, match="backwards|before"):
        Observer(linear_plan()).smooth(t[::-1], y)
    empty = Observer(linear_plan()).smooth(t[:0], {})
    assert len(empty.t_s) == 0
