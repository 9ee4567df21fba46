"""Sigma points: propagation from sample to sample without derivatives."""

import numpy as np
import pytest
from scipy.linalg import expm

import hnav
from hnav.filters.observer import Observer
from hnav.systems.statistics import normalised_squares
from studies.observer.smooth import van_der_pol

POINTS = {"propagation": "sigma_points", "start_mode": "given"}


def linear(noise, **options):
    """An oscillator whose spring is estimated."""
    plant = hnav.Plant(lambda t, x, u, p: (x[1] + u[0], -p[0] * x[0] - 0.3 * x[1]), lambda t, x, u, p: x[0], states={"x": 1.0, "v": 0.0},
                       sensors=["x"], inputs={"d": 0.1}, parameters={"k": 4.0})  # fmt: skip
    plan = hnav.Plan(plant).sensor("x", noise=0.02).state("x", start_sigma=0.2).state("v", start_sigma=0.5, noise=noise)
    plan.unknown_input("d", start_sigma=0.1, noise=noise, time_constant_s=2.0)
    plan.options = options
    return plan


def samples(n=40):
    return np.arange(1, n + 1) * 0.05, 1 + 0.1 * np.random.default_rng(1).standard_normal(n)


def test_of_a_linear_plant_they_say_what_derivatives_do():
    t_s, y = samples()
    points, derivatives = (Observer(linear(0.0, **options)).run(t_s, {"x": y}) for options in (POINTS, {"start_mode": "given"}))
    for name in ("x", "v", "d"):
        assert points.x[name] == pytest.approx(derivatives.x[name], abs=1e-5 * derivatives.sigma[name].min())
    assert points.covariance == pytest.approx(derivatives.covariance, rel=1e-4, abs=1e-9)
    # Noise that enters in two halves is a matter of the second order.
    points, derivatives = (Observer(linear(0.1, **options)).run(t_s, {"x": y}) for options in (POINTS, {"start_mode": "given"}))
    assert points.sigma["v"] == pytest.approx(derivatives.sigma["v"], rel=2e-3)


def test_a_parameter_is_learnt():
    t_s = np.arange(1, 200) * 0.05
    y = np.array([(expm(np.array([[0, 1], [-5.0, -0.3]]) * t) @ [1.0, 0.0])[0] for t in t_s])
    plan = linear(0.01, **POINTS).input("d", start=0.0).parameter("k", start_sigma=1.0)
    run = Observer(plan).run(t_s, {"x": y + 0.02 * np.random.default_rng(2).standard_normal(len(t_s))})
    assert run.x["k"][-1] == pytest.approx(5.0, abs=4 * run.sigma["k"][-1]) and run.sigma["k"][-1] < 0.1


def test_the_oscillator_of_van_der_pol_has_errors_as_stated():
    plant = hnav.Plant(lambda t, x, u, p: (x[1], (1 - x[0] * x[0]) * x[1] - x[0]), lambda t, x, u, p: x[0], states={"x0": 2.0, "x1": 0.0},
                       sensors=["x0"])  # fmt: skip
    nees = []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        start = np.array([2.0, 0.0]) + rng.standard_normal(2)
        truth, y = van_der_pol(rng, steps=100)
        plan = hnav.Plan(plant).sensor("x0", noise=0.05)
        for name, value, noise in zip(("x0", "x1"), start, (0.01, 0.1)):
            plan.state(name, start=float(value), start_sigma=1.0, noise=noise)
        plan.options = POINTS
        run = Observer(plan).run(0.05 * np.arange(1, 101), {"x0": y})
        nees.append(normalised_squares(truth - np.column_stack([run.x["x0"], run.x["x1"]]), run.covariance)[20:].mean() / 2)
    assert 0.6 < np.mean(nees) < 1.5


def test_a_relay_without_indicators_is_seen():
    """Its derivative is 0 but where it jumps. x goes to 0.1 from both sides with a speed of 1: after 0.08 s points from 0 +- 1 are 0.16
    nearer to each other."""
    plant = hnav.Plant(lambda t, x, u, p: -np.sign(x[0] - 0.1), lambda t, x, u, p: x[0], states={"x": 0.0}, sensors=["x"])
    plan = hnav.Plan(plant).sensor("x", noise=0.1).state("x", start_sigma=1.0)
    sigma = {}
    for propagation in ("derivatives", "sigma_points"):
        observer = Observer(plan, start_mode="given", propagation=propagation)
        observer.advance(0)
        observer.advance(0.08)
        sigma[propagation] = observer.estimate()[1]["x"]
    assert sigma["derivatives"] == pytest.approx(1.0, abs=1e-3) and sigma["sigma_points"] == pytest.approx(0.92, abs=1e-3)


def test_the_same_samples_have_the_same_bits():
    t_s, y = samples()

    def after(shares, saved_at=None):
        observer = Observer(linear(0.1, **POINTS))
        for k, (t, value) in enumerate(zip(t_s, y)):
            for share in shares:
                observer.advance(t - 0.05 * share)
            observer.push("x", t, value)
            observer.advance(t)
            if k == saved_at:
                state, observer = observer.save(), Observer(linear(0.1, **POINTS))
                observer.load(state)
        return observer.covariance().tobytes()

    assert after([]) == after([0.7, 0.2]) == after([], saved_at=11)


def test_a_plant_with_events_is_refused():
    ball = hnav.Plant(
        derivatives=lambda t, x, u, p: (x[1], -9.81), outputs=lambda t, x, u, p: x[0], states={"h": 1.0, "v": 0.0}, sensors=["h"],
        indicators=lambda t, x, u, p: x[0], event=lambda t, x, u, p: x,
    )  # fmt: skip
    plan = hnav.Plan(ball).sensor("h", noise=0.02).state("h", start_sigma=0.05)
    with pytest.raises(hnav.HnavValueError, match="sigma_points is for plants without events"):
        Observer(plan, propagation="sigma_points")
