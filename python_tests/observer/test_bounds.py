"""Bounds: estimates stay within them, sigmas are those of the truncated density, and positive parameters stay positive."""

from __future__ import annotations

import math

import numpy as np
import pytest

import hnav
from hnav.filters.observer import Observer
from hnav.filters.observer_findings import findings
from hnav.filters.observer_plan import Plan
from hnav.filters.plant import Plant

T_S = np.arange(1.0, 41.0)
NOISE = 0.05


def room() -> Plant:
    """A room that cools through its wall: T' = -g (T - 0), heated by u; the conductance g may be near 0."""
    return Plant(
        states={"T": 1.0}, parameters={"g": 0.01}, sensors=["T"],
        derivatives=lambda t, x, u, p: [-p[0] * x[0]], outputs=lambda t, x, u, p: [x[0]],
    )  # fmt: skip


def samples(g: float, start: float, rng: np.random.Generator) -> np.ndarray:
    return start * np.exp(-g * T_S) + NOISE * rng.normal(size=len(T_S))


def nees(run, truth: tuple[float, float]) -> float:
    error = np.array([run.x["T"][-1] - truth[0], run.x["g"][-1] - truth[1]])
    return float(error @ np.linalg.solve(run.covariance[-1], error) / 2)


def test_a_loss_near_zero_is_never_negative_and_its_sigma_is_right():
    squares = []
    rng = np.random.default_rng(3)
    plan = Plan(room()).sensor("T", noise=NOISE).state("T", start_sigma=0.1).parameter("g", start=0.0, start_sigma=0.005, min=0.0)
    for _ in range(200):
        g, start = abs(0.005 * rng.normal()), 1 + 0.1 * rng.normal()
        run = Observer(plan).run(T_S, {"T": samples(g, start, rng)})
        assert (run.x["g"] > 0).all()
        squares.append(nees(run, (start * math.exp(-40 * g), g)))
    assert 0.8 < np.mean(squares) < 1.3


def test_a_loss_by_its_logarithm_is_never_negative_and_its_sigma_is_right():
    squares = []
    rng = np.random.default_rng(4)
    plan = (
        Plan(room()).sensor("T", noise=NOISE).state("T", start_sigma=0.1).parameter("g", start=0.02, start_sigma=0.004, log=True)
    )
    s2 = math.log1p(0.04)
    for _ in range(200):
        g, start = math.exp(math.log(0.02) - s2 / 2 + math.sqrt(s2) * rng.normal()), 1 + 0.1 * rng.normal()
        run = Observer(plan).run(T_S, {"T": samples(g, start, rng)})
        assert (run.x["g"] > 0).all()
        squares.append(nees(run, (start * math.exp(-40 * g), g)))
    assert 0.8 < np.mean(squares) < 1.3


def test_the_start_of_a_logarithm_is_what_was_given():
    plan = (
        Plan(room()).sensor("T", noise=NOISE).state("T", start_sigma=0.1).parameter("g", start=0.02, start_sigma=0.03, log=True)
    )
    x, sigma = Observer(plan).estimate()
    assert x["g"] == pytest.approx(0.02, rel=1e-12) and sigma["g"] == pytest.approx(0.03, rel=1e-12)


def test_the_start_is_cut_too():
    plan = Plan(room()).sensor("T", noise=NOISE).state("T", start=0.0, start_sigma=0.1, min=0.0, max=0.05)
    x, sigma = Observer(plan).estimate()
    a = np.linspace(0, 0.05, 100001)
    w = np.exp(-0.5 * (a / 0.1) ** 2)
    mean = np.average(a, weights=w)
    assert x["T"] == pytest.approx(mean, rel=1e-4)
    assert sigma["T"] == pytest.approx(math.sqrt(np.average((a - mean) ** 2, weights=w)), rel=1e-3)


def test_bounds_that_are_far_change_no_bit():
    y = samples(0.01, 1.0, np.random.default_rng(5))
    free = Plan(room()).sensor("T", noise=NOISE).state("T", start_sigma=0.1).parameter("g", start_sigma=0.001)
    bounded = free.copy().state("T", start_sigma=0.1, min=-100, max=100).parameter("g", start_sigma=0.001, min=-1)
    one, other = Observer(free).run(T_S, {"T": y}), Observer(bounded).run(T_S, {"T": y})
    np.testing.assert_array_equal(one.x["g"], other.x["g"])
    np.testing.assert_array_equal(one.covariance, other.covariance)
    assert not findings(other, bounded)


def test_a_bound_that_is_active_is_a_finding():
    plan = Plan(room()).sensor("T", noise=NOISE).state("T", start_sigma=0.1).parameter("g", start=0.01, start_sigma=0.01, min=0.0)
    run = Observer(plan).run(T_S, {"T": 1 + 0.01 * T_S})
    found = [one for one in findings(run, plan) if one.kind == "at its bound"]
    assert [one.name for one in found] == ["g"] and "g was at its min 0" in found[0].sentence()
    assert run.x["g"][-1] < 0.002


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"min": 1.0, "max": 0.5}, "min of g is 1 and its max 0.5"),
        ({"log": True, "start": 0.0}, "above 0: it is estimated by its logarithm"),
        ({"log": True, "start": 1e-200}, r"start\[1\] = 1e-200 is too far below its start_sigma and noise: raise it"),
    ],
)
def test_bounds_that_cannot_be(change, said):
    with pytest.raises(hnav.HnavError, match=said):
        Observer(Plan(room()).sensor("T", noise=NOISE).parameter("g", **{"start": 0.01, "start_sigma": 0.01, **change}))


def test_a_plan_file_has_bounds(tmp_path):
    (tmp_path / "room.py").write_text(
        "import hnav\nplant = hnav.Plant(states={'T': 1.0}, parameters={'g': 0.01}, sensors=['T'],\n"
        "    derivatives=lambda t, x, u, p: [-p[0] * x[0]], outputs=lambda t, x, u, p: [x[0]])\n"
    )
    (tmp_path / "room.toml").write_text(
        "[plant]\nfmu = 'room.py'\n[sensor.T]\nnoise = 0.05\n[state.T]\nmin = -1\nmax = 3\nstart_sigma = 1\n"
        "[parameter.g]\nstart_sigma = 0.01\nlog = true\n"
    )
    plan = hnav.read_plan(tmp_path / "room.toml")
    assert (plan.states["T"].min, plan.states["T"].max, plan.parameters["g"].log) == (-1, 3, True)
