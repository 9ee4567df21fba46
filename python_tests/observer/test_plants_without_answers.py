"""While a plant fails, the estimate is held, its sigma grows and ready is false; later samples are used."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hnav.filters.observer import Observer
from hnav.filters.observer_plan import Plan
from hnav.filters.plant import Plant
from studies.observer import tank


@pytest.mark.parametrize(("runs", "bounds"), [(2, {}), (20, {"min": 0.0})], ids=["free", "bounded"])
def test_a_tank_that_runs_empty_is_estimated_when_it_is_full_again(runs, bounds):
    result = tank.measured("", runs, **bounds)
    assert result["found"] >= 0.95 * runs and 0.8 < result["nees"] < 1.3
    assert result["dropped"] == 0 and result["ready_meanwhile"] == 0 and result["ready"] > 90
    assert (result["held"] > 0) != bool(bounds)
    assert not bounds or result["negative"] == 0


def gap() -> Plant:
    """A mass on a spring whose plant fails from 4 s to 6 s."""

    def derivatives(t, x, u, p):
        return [math.nan, math.nan] if 4 < t < 6 else [x[1], -4 * x[0]]

    return Plant(states={"x": 1.0, "v": 0.0}, sensors=["x"], derivatives=derivatives, outputs=lambda t, x, u, p: [x[0]])


def test_a_gap_in_the_plant_is_held_over_and_forgotten():
    t = np.arange(0.1, 12, 0.1)
    rng = np.random.default_rng(1)
    y = np.cos(2 * t) + 0.01 * rng.normal(size=len(t))
    known = Plan(gap()).sensor("x", noise=0.01).state("x", start_sigma=0.1, ready_sigma=0.1, noise=1e-3)
    run = Observer(known.state("v", start_sigma=0.1, noise=1e-3, ready_sigma=0.1)).run(t, {"x": y})
    missing = (t > 4.05) & (t < 6.05)
    assert run.dropped == 0 and run.held == missing.sum()
    assert not run.ready[missing].any() and run.ready[(t > 2.5) & (t < 3.95)].all()
    v = -2 * np.sin(2 * t)
    error = np.abs(run.x["v"] - v) / run.sigma["v"]
    assert np.mean(error < 3) > 0.95
    assert run.ready[t > 9].all() and np.abs(run.x["v"] - v)[t > 9].max() < 0.05


def test_a_sensor_without_an_answer_costs_its_samples_and_the_estimate_is_not_ready():
    t = np.arange(0.1, 8, 0.1)
    plant = Plant(
        states={"x": 1.0, "v": 0.0}, sensors=["x"], derivatives=lambda t, x, u, p: [x[1], -4 * x[0]],
        outputs=lambda t, x, u, p: [math.nan if 4 < t < 6 else x[0]],
    )  # fmt: skip
    known = Plan(plant).sensor("x", noise=0.01).state("x", start_sigma=0.1, noise=1e-3).state("v", start_sigma=0.1, noise=1e-3)
    run = Observer(known).run(t, {"x": np.cos(2 * t) + 0.01 * np.random.default_rng(2).normal(size=len(t))})
    missing = (t > 4.05) & (t < 5.95)
    assert run.dropped == missing.sum() and not run.ready[missing].any() and run.ready[(t > 3) & (t < 4)].all()
    assert run.sigma["x"][missing][-1] > 1.1 * run.sigma["x"][t < 4][-1]
    assert run.ready[-1] and abs(run.x["v"][-1] + 2 * math.sin(2 * t[-1])) < 0.02


@pytest.mark.parametrize("count", [1, 10, 20])
def test_a_few_good_samples_of_a_second_sensor_leave_the_estimate_ready(count):
    """A sensor with fewer than 20 samples was an inconsistency for the rest of the run."""
    rng, t = np.random.default_rng(0), np.arange(0, 40, 0.05)
    plant = Plant(
        states={"x": 1.0, "v": 0.0}, sensors=["x", "v"], derivatives=lambda t, x, u, p: [x[1], -4 * x[0]], outputs=lambda t, x, u, p: [x[0], x[1]]
    )  # fmt: skip
    known = Plan(plant).sensor("x", noise=0.1).sensor("v", noise=0.1)
    known = known.state("x", start_sigma=0.1, noise=1e-3).state("v", start_sigma=0.1, noise=1e-3)
    seldom = np.full(len(t), math.nan)
    at = np.linspace(300, 700, count).astype(int)
    seldom[at] = -2 * np.sin(2 * t[at]) + 0.1 * rng.normal(size=count)
    run = Observer(known).run(t, {"x": np.cos(2 * t) + 0.1 * rng.normal(size=len(t)), "v": seldom})
    assert run.ready[280] and run.ready[320:].all()


def test_a_correction_ends_where_the_plant_answers():
    """x' = -ln x: a sample far below moves the estimate below 0, where the plant has no value."""
    plant = Plant(
        states={"x": 1.0}, sensors=["x"], derivatives=lambda t, x, u, p: [-math.log(x[0]) if x[0] > 0 else math.nan],
        outputs=lambda t, x, u, p: [x[0]],
    )  # fmt: skip
    known = Plan(plant).sensor("x", noise=0.05).state("x", start_sigma=0.5, noise=0.05)
    run = Observer(known, outlier_sigma=0).run(np.arange(1.0, 6.0), {"x": np.array([-0.4, 0.9, 1.0, 1.0, 1.0])})
    assert run.dropped == 0 and run.held == 0 and run.x["x"][0] > 0
    assert run.sigma["x"][0] > 0.05 and abs(run.x["x"][-1] - 1) < 0.1
