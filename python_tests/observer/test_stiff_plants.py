"""Plants with fast and slow modes: an implicit solver replaces the explicit one."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import hnav
from hnav.filters.observer import Observer
from hnav.filters.observer_findings import findings

MU = 1000.0
NOISE = np.array([1e-3, 1e-3])


def slope(t, x, u, p):
    return x[1], MU * (1 - x[0] ** 2) * x[1] - x[0]


def jacobian(t, x, u, p):
    return (0, 1), (-2 * MU * x[0] * x[1] - 1, MU * (1 - x[0] ** 2))


def plan_of_oscillator():
    plant = hnav.Plant(slope, lambda t, x, u, p: x[0], states={"x": 2.0, "v": 0.0}, sensors=["x"], jacobian=jacobian)
    plan = hnav.Plan(plant).sensor("x", noise=0.05).state("x", start_sigma=0.1, noise=NOISE[0])
    plan.state("v", start_sigma=1e-3, noise=NOISE[1], nominal=1e-2)
    plan.options = {"start_mode": "given"}
    return plan


@pytest.mark.parametrize("interval_s", [1.0, 100.0])
@pytest.mark.filterwarnings("ignore:overflow")
def test_mean_and_covariance_are_those_of_a_tight_solution(interval_s):
    def packed(t, y):
        A, P = np.array(jacobian(t, y[:2], 0, 0)), y[2:].reshape(2, 2)
        return np.concatenate([slope(t, y[:2], 0, 0), (A @ P + P @ A.T + np.diag(NOISE**2)).ravel()])

    start = [2, 0, 0.01, 0, 0, 1e-6]
    expected = solve_ivp(packed, (0, interval_s), start, method="Radau", rtol=1e-8, atol=1e-14).y[:, -1]
    observer = Observer(plan_of_oscillator())
    observer.advance(0)
    observer.advance(interval_s)
    x, sigma = observer.estimate()
    assert np.array([x["x"], x["v"]]) == pytest.approx(expected[:2], abs=0.01 * min(sigma.values()))
    assert observer.covariance().ravel() == pytest.approx(expected[2:], rel=5e-3)
    assert observer.info().steps < 600  # 500 of them before the implicit solver was asked


@pytest.mark.filterwarnings("ignore:overflow")
def test_a_start_on_the_slow_motion_is_followed():
    t_s = np.arange(1, 41) * 10.0
    truth = solve_ivp(lambda t, x: slope(t, x, 0, 0), (0, t_s[-1]), [2, 0], method="Radau", rtol=1e-9, atol=1e-12, t_eval=t_s)
    y = truth.y[0] + 0.05 * np.random.default_rng(1).standard_normal(len(t_s))
    observer = Observer(plan_of_oscillator())
    run = observer.run(t_s, {"x": y})
    assert run.dropped == 0 and 0.5 < run.nis["x"].mean() < 1.6
    assert np.abs((run.x["x"] - truth.y[0]) / run.sigma["x"]).max() < 4
    # An explicit method needs 1000 steps a second.
    assert observer.info().steps < 4000


@pytest.mark.filterwarnings("ignore:overflow")
def test_sigma_points_follow_a_plant_that_jumps_and_derivatives_are_advised_against():
    """At 807 s it jumps within milliseconds; derivatives treat the time of the jump as exact."""
    t_s = np.arange(1, 101) * 10.0
    truth = solve_ivp(lambda t, x: slope(t, x, 0, 0), (0, t_s[-1]), [2, 0], method="Radau", rtol=1e-9, atol=1e-12, t_eval=t_s)
    y = truth.y[0] + 0.05 * np.random.default_rng(0).standard_normal(len(t_s))
    runs = {}
    for propagation in ("derivatives", "sigma_points"):
        runs[propagation] = Observer(plan_of_oscillator(), propagation=propagation).run(t_s, {"x": y})
    assert 0.6 < runs["sigma_points"].nis["x"].mean() < 1.4 and runs["sigma_points"].dropped == 0
    assert findings(runs["sigma_points"], plan_of_oscillator()) == []
    assert runs["derivatives"].nis["x"].max() > 100
    (finding,) = findings(runs["derivatives"], plan_of_oscillator())
    assert 'jumps of a stiff plant propagation = "sigma_points"' in finding.sentence() and 800 <= finding.start_s <= 820


@pytest.mark.filterwarnings("ignore:overflow")
def test_a_guard_on_the_slow_motion_is_found():
    """Where x has fallen to 1.9 it is reset to 2, with a fast transient each time."""
    plan = hnav.Plan(
        hnav.Plant(
            slope, lambda t, x, u, p: x[0], states={"x": 2.0, "v": 0.0}, sensors=["x"], jacobian=jacobian,
            indicators=lambda t, x, u, p: x[0] - 1.9, event=lambda t, x, u, p: (2.0, 0.0) if x[0] <= 1.9 else x,
        )
    ).sensor("x", noise=0.05)  # fmt: skip
    plan.state("x", start_sigma=0.01).state("v", start_sigma=1e-5, nominal=1e-2)
    observer = Observer(plan, start_mode="given")

    def guard(t, x):
        return x[0] - 1.9

    guard.terminal = True
    legs, t, x = [], 0.0, [2.0, 0.0]
    for _ in range(3):
        leg = solve_ivp(lambda t, x: slope(t, x, 0, 0), (t, t + 500), x, method="Radau", rtol=1e-9, atol=1e-12, events=guard)
        t, x = leg.t[-1], [2.0, 0.0]
        legs.append(t)
    observer.advance(0)
    observer.push("x", legs[1] + 50, 1.96)
    observer.advance(legs[1] + 50)
    expected = solve_ivp(lambda t, x: slope(t, x, 0, 0), (0, 50), [2.0, 0.0], method="Radau", rtol=1e-9, atol=1e-12).y[:, -1]
    info = observer.info()
    assert (info.plant_events, info.parts, info.dropped) == (2, 1, 0)
    assert info.steps < 4000
    assert observer.estimate()[0]["x"] == pytest.approx(expected[0], abs=0.005)
    # What is late at the guard by a time is behind by it now: sigma is that of the start over its slope, times the slope here.
    slow = [x / (MU * (1 - x * x)) for x in (2.0, expected[0])]
    assert observer.estimate()[1]["x"] == pytest.approx(0.01 * slow[1] / slow[0], rel=0.06)


@pytest.mark.filterwarnings("ignore:overflow")
def test_the_same_samples_have_the_same_bits():
    y = [1.99, 1.97, 2.0, 1.96, 1.98]

    def after(times):
        observer = Observer(plan_of_oscillator())
        saved = None
        for k, value in enumerate(y):
            for share in times:
                observer.advance(3.0 * (k + share))
            observer.push("x", 3.0 * (k + 1), value)
            observer.advance(3.0 * (k + 1))
            if k == 2 and len(times) == 1:
                saved = observer.save()
                observer = Observer(plan_of_oscillator())
                observer.load(saved)
        return observer.covariance().tobytes()

    assert after([]) == after([0.3, 0.7]) == after([0.5])


def test_a_linear_plant_with_modes_far_apart_is_a_kalman_filter():
    """1 and 1e5 1/s."""
    A, Q, T, R = np.array([[-1.0, 1.0], [0.0, -1e5]]), np.array([0.1, 30.0]), 0.5, 0.02**2
    plant = hnav.Plant(lambda t, x, u, p: A @ x, lambda t, x, u, p: x[0], states={"a": 1.0, "b": 1.0}, sensors=["a"])
    plan = (
        hnav.Plan(plant).sensor("a", noise=0.02).state("a", start_sigma=0.5, noise=Q[0]).state("b", start_sigma=0.5, noise=Q[1])
    )
    y = 1 + 0.1 * np.random.default_rng(2).standard_normal(20)
    run = Observer(plan).run(T * np.arange(20), {"a": y})
    values, V = (np.real(part) for part in np.linalg.eig(A))
    W = np.linalg.inv(V)
    inside = W @ np.diag(Q**2) @ W.T
    sums = values[:, None] + values[None, :]
    added = V @ (inside * np.expm1(sums * T) / sums) @ V.T
    x, P, Phi = np.ones(2), 0.25 * np.eye(2), expm(A * T)
    for k in range(20):
        if k:
            x, P = Phi @ x, Phi @ P @ Phi.T + added
        K = P[:, 0] / (P[0, 0] + R)
        x, P = x + K * (y[k] - x[0]), P - np.outer(K, P[0])
        sigma = np.sqrt(np.diag(P))
        assert np.array([run.x["a"][k], run.x["b"][k]]) == pytest.approx(x, abs=1e-4 * sigma.min())
        assert run.covariance[k] == pytest.approx(P, abs=1e-4 * sigma.min() ** 2)
