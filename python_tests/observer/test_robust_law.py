"""The robust law of the observer: the covariance grows by the formula of its rate."""

import numpy as np
import pytest
from scipy.linalg import expm

import hnav
from hnav.filters.observer import Observer

A = np.array([[0.0, 1.0], [-4.0, -0.3]])
T, R = 0.1, 0.02**2


def plan_of(**options):
    plant = hnav.Plant(lambda t, x, u, p: A @ x, lambda t, x, u, p: x[0], states={"x": 1.0, "v": 0.0}, sensors=["x"])
    plan = hnav.Plan(plant).sensor("x", noise=0.02).state("x", start_sigma=0.2).state("v", start_sigma=3.0)
    plan.options = options
    return plan


def samples(n=60, k=4.0):
    t_s = T * np.arange(n)
    free = np.array([[0.0, 1.0], [-k, -0.3]])
    x = np.array([(expm(free * t) @ [1.1, -0.5])[0] for t in t_s])
    return t_s, x + 0.02 * np.random.default_rng(1).standard_normal(n)


@pytest.mark.parametrize("rate", [0.5, 3.0, 100.0])
def test_the_covariance_before_a_correction_is_that_of_the_formula(rate):
    t_s, y = samples()
    run = Observer(plan_of(robust_rate_1_s=rate)).run(t_s, {"x": y})
    weight = np.diag([1.0, 1 / 3.0])  # of the inverse scales
    x, P, Phi = np.array([1.0, 0.0]), np.diag([0.04, 9.0]), expm(A * T)
    for k, value in enumerate(y):
        if k:
            x, P = Phi @ x, Phi @ P @ Phi.T
            largest = np.linalg.eigvalsh(weight @ P @ weight)[-1]
            theta = min(0.95, 1 - np.exp(-rate * T)) / largest
            P = np.linalg.inv(np.linalg.inv(P) - theta * weight @ weight)
        K = P[:, 0] / (P[0, 0] + R)
        x, P = x + K * (value - x[0]), P - np.outer(K, P[0])
        assert run.covariance[k] == pytest.approx(P, rel=1e-4, abs=1e-7), k
        assert [run.x["x"][k], run.x["v"][k]] == pytest.approx(x, abs=1e-4)


@pytest.mark.parametrize("rate", [0.1, 1.0, 10.0])
def test_of_two_equal_states_whose_sum_is_measured_the_difference_is_found(rate):
    """The largest variance lies along (1, -1), on which the vector of ones has no part."""
    plant = hnav.Plant(
        lambda t, x, u, p: [0.0, 0.0], lambda t, x, u, p: x[0] + x[1], states={"a": 0.0, "b": 0.0}, sensors=["sum"]
    )
    plan = hnav.Plan(plant).sensor("sum", noise=0.1).state("a", start_sigma=1.0).state("b", start_sigma=1.0)
    plan.options = {"robust_rate_1_s": rate}
    n = 4
    run = Observer(plan).run(T * np.arange(n), {"sum": np.zeros(n)})
    P, h = np.eye(2), np.ones(2)
    for k in range(n):
        if k:
            L = np.diag((P.diagonal() < 1) * 1.0)
            theta = min(0.95, 1 - np.exp(-rate * T)) / max(np.linalg.eigvalsh(L @ P @ L)[-1], 1e-9)
            P = np.linalg.inv(np.linalg.inv(P) - theta * L)
        P = P - np.outer(P @ h, P @ h) / (h @ P @ h + 0.1**2)
        assert run.covariance[k] == pytest.approx(P, rel=1e-6), k


def test_a_state_that_no_sensor_observes_stays_as_uncertain_as_at_the_start():
    """Its variance grew without end, the law forgot nothing of the other state, and after 800 s no sample corrected it."""
    plant = hnav.Plant(
        lambda t, x, u, p: [0.0, 0.0], lambda t, x, u, p: x[0], states={"seen": 0.0, "hidden": 1.0}, sensors=["seen"]
    )
    plan = hnav.Plan(plant).sensor("seen", noise=0.1).state("seen", start_sigma=1.0).state("hidden", start_sigma=2.0)
    plan.options = {"robust_rate_1_s": 0.5}
    run = Observer(plan).run(np.arange(0, 2000.0, 0.5), {"seen": np.full(4000, 0.3)})
    assert run.x["seen"][-1] == pytest.approx(0.3, abs=1e-6)
    kept = np.exp(-0.5 * 0.5)  # of the information between two samples
    assert run.covariance[-1] == pytest.approx(np.diag([(1 - kept) * 0.1**2, 4.0]), rel=1e-6)


def test_a_model_that_is_not_right_is_followed():
    """The spring is a fifth stiffer than the model, which has no noise."""
    t_s, y = samples(300, k=4.8)
    plain = Observer(plan_of()).run(t_s, {"x": y})
    robust = Observer(plan_of(robust_rate_1_s=3.0)).run(t_s, {"x": y})
    assert np.nanmean(plain.nis["x"][100:]) > 20 > 3 > np.nanmean(robust.nis["x"][100:])


def test_without_a_rate_nothing_changes():
    t_s, y = samples()
    plain, off = (Observer(plan).run(t_s, {"x": y}) for plan in (plan_of(), plan_of(robust_rate_1_s=0.0)))
    assert np.array_equal(plain.covariance, off.covariance)
