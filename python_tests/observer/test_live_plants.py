"""One instance of an FMU at a time: some lose events while a second exists. Two instances are compared before both are used."""

from __future__ import annotations

import gc

import numpy as np
import pytest

import hnav
from hnav.filters import observer as observers
from hnav.filters.observer import Observer
from observer.ball_fmu import MODES, SAVES, SERIALIZES, SOURCE, packed
from observer.little_fmu import compiled

T_S = np.arange(0.05, 2.0, 0.05)
NOISE, V_SIGMA = 0.05, 1.0


@pytest.fixture(scope="module")
def lonely_binary(tmp_path_factory):
    return compiled(tmp_path_factory.mktemp("lonely"), source=SOURCE)


@pytest.fixture(params=[SERIALIZES, SAVES], ids=["serialises", "saves"])
def lonely(lonely_binary, tmp_path, request):
    return packed(tmp_path / "lonely.fmu", lonely_binary, request.param)


def plan_of(fmu, mode: str = "switches", h: float = 30.0, v_sigma: float = V_SIGMA) -> hnav.Plan:
    plan = hnav.Plan(fmu).sensor("h", noise=NOISE).state("h", start=h, start_sigma=0.1).state("v", start=0.0, start_sigma=v_sigma)
    return plan.set("mode", MODES.index(mode))


def truth(h: float, v: float):
    """Gravity points down for a second, and then up."""
    t, late = np.minimum(T_S, 1.0), np.maximum(T_S - 1.0, 0.0)
    v_1 = v - 9.81
    return np.where(T_S <= 1, h + v * t - 4.905 * t**2, h + v - 4.905 + v_1 * late + late**2), np.where(
        T_S <= 1, v - 9.81 * t, v_1 + 2 * late
    )


def bounced(h: float, v: float):
    """A ball that comes back from the floor with 0.7 of its speed."""
    rows, t_0 = [], 0.0
    for t in T_S[:28]:
        while t > (hit := t_0 + (v + np.sqrt(v * v + 2 * 9.81 * h)) / 9.81):
            t_0, h, v = hit, 0.0, 0.7 * (9.81 * (hit - t_0) - v)
        rows.append((h + v * (t - t_0) - 4.905 * (t - t_0) ** 2, v - 9.81 * (t - t_0)))
    return np.array(rows).T


def nees(plan: hnav.Plan, moved, seeds: int) -> float:
    """At the last sample."""
    squares = []
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        h, v = moved(*(plan.states[name].start + plan.states[name].start_sigma * rng.normal() for name in ("h", "v")))
        run = Observer(plan).run(T_S[: len(h)], {"h": h + NOISE * rng.normal(size=len(h))})
        error = np.array([run.x["h"][-1] - h[-1], run.x["v"][-1] - v[-1]])
        squares.append(error @ np.linalg.solve(run.covariance[-1], error) / 2)
    return float(np.mean(squares))


def test_the_proof_leaves_no_second_instance_behind(lonely):
    assert 0.8 < nees(plan_of(lonely), truth, 60) < 1.3


def test_a_bounce_is_passed_with_the_error_that_is_stated(lonely):
    assert 0.8 < nees(plan_of(lonely, "sound", h=1.0, v_sigma=0.3), bounced, 60) < 1.3


def test_observers_of_one_fmu_share_nothing_that_is_static_in_its_library(lonely, monkeypatch):
    gc.collect()
    first = Observer(plan_of(lonely))
    folder = observers._unpack(first.plan.plant, first.plan.text())
    monkeypatch.setattr(observers, "_unpack", lambda *_: folder)
    h, _ = truth(30.0, 0.5)
    alone = first.run(T_S, {"h": h})
    both = Observer(plan_of(lonely)), Observer(plan_of(lonely))
    runs = [observer.run(T_S, {"h": h}) for observer in both]
    for run in runs:
        np.testing.assert_array_equal(run.covariance, alone.covariance)
        np.testing.assert_array_equal(run.x["v"], alone.x["v"])
    assert not list(folder.glob("binaries/linux64/hnav_*"))


@pytest.mark.parametrize("attributes", [SERIALIZES, SAVES], ids=["serialises", "saves"])
def test_a_plant_that_disturbs_another_in_the_process_is_refused_by_name(tmp_path, attributes):
    gc.collect()
    binary = compiled(tmp_path, source=SOURCE, define=("SHARES_PROCESS",))
    fmu = packed(tmp_path / "jealous.fmu", binary, attributes, token=f"{{jealous {len(attributes)}}}")
    first = Observer(plan_of(fmu))
    with pytest.raises(
        hnav.HnavError, match="ball does not bear a second instance in one process: its (state|derivative|next event)"
    ):
        Observer(plan_of(fmu))
    del first
    gc.collect()
    h, _ = truth(30.0, 0.5)
    assert Observer(plan_of(fmu)).run(T_S, {"h": h}).nis["h"].max() < 1
