"""One instance of an FMU at a time: some lose events while a second exists. Two instances are compared before both are used."""

from __future__ import annotations

import gc
import shutil
from pathlib import Path

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


def test_a_copy_of_a_library_goes_to_the_temporary_folder_where_its_own_has_no_room(lonely, tmp_path, monkeypatch):
    """A path that is as long as paths may be leaves none for the name of a copy."""
    gc.collect()
    plan = plan_of(lonely)
    folder = observers._unpack(plan.plant, plan.text())
    long = tmp_path
    while (rest := 980 - len(str(long / folder.name))) > 1:
        long /= "d" * min(200, rest - 1)
    long.mkdir(parents=True)
    folder = shutil.move(folder, long / folder.name)
    monkeypatch.setattr(observers, "_unpack", lambda *_: folder)
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    monkeypatch.setenv("TMPDIR", str(temporary))
    h, _ = truth(30.0, 0.5)
    first, second = Observer(plan), Observer(plan)
    assert mapped("temporary/hnav_")
    runs = [observer.run(T_S, {"h": h}) for observer in (first, second)]
    np.testing.assert_array_equal(runs[0].covariance, runs[1].covariance)
    assert not list(temporary.iterdir())


@pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="only Linux says which files a process has mapped")
def test_the_library_of_a_plant_is_unloaded_with_its_observer(lonely):
    gc.collect()
    before = len(mapped("ball.so"))  # by observers of other tests
    observer = Observer(plan_of(lonely))
    assert len(mapped("ball.so")) > before
    del observer
    gc.collect()
    assert len(mapped("ball.so")) <= before


def mapped(name: str) -> list[str]:
    """The files with this in their names that this process has mapped, once for each piece."""
    lines = Path("/proc/self/maps").read_text().splitlines()
    return [path for path in (line.split(maxsplit=5)[-1] for line in lines) if name in path]


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
