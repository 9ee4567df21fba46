"""Plants of more than 64 estimated numbers, up to the limit of memory."""

import re

import numpy as np
import pytest

from command_line import hnav as command
from hnav.errors import HnavValueError
from hnav.filters import observer_export
from hnav.filters.observer import Observer
from hnav.filters.observer_plan import Plan
from hnav.filters.plant import Plant
from observer.test_fmu_plants import little_plan
from studies.observer.size import plan_of, rod_fmu

N = 150
RATES = np.linspace(0.1, 2.0, N)


def decays(count: int = N) -> Plan:
    """Independent decays, of which the first is measured."""
    rates = np.resize(RATES, count)
    names = [f"x{i}" for i in range(count)]
    plant = Plant(
        lambda t, x, u, p: -rates * x, lambda t, x, u, p: [x[0]], states=dict.fromkeys(names, 1.0), sensors=["x0"],
        jacobian=lambda t, x, u, p: -np.diag(rates),
    )  # fmt: skip
    plan = Plan(plant).sensor("x0", noise=0.1)
    for name in names:
        plan.state(name, start_sigma=0.5, noise=0.2)
    return plan


def test_150_numbers_have_their_own_moments():
    t = np.array([0.5, 1.0])
    run = Observer(decays(), start_mode="given").run(t, {"x0": np.exp(-RATES[0] * t)})
    for k, t_s in enumerate(t):
        decay = np.exp(-2 * RATES * t_s)
        variance = 0.25 * decay + 0.04 * (1 - decay) / (2 * RATES)
        sigma = np.array([run.sigma[name][k] for name in run.x])
        assert sigma[1:] == pytest.approx(np.sqrt(variance)[1:], rel=1e-4)
        assert (np.abs(np.array([run.x[name][k] for name in run.x]) - np.sqrt(decay)) < 1e-5 * sigma)[1:].all()
    smooth = Observer(decays(), start_mode="given").smooth(t, {"x0": np.exp(-RATES[0] * t)})
    assert smooth.sigma["x0"][0] < run.sigma["x0"][0] and smooth.sigma["x9"][0] == pytest.approx(run.sigma["x9"][0], rel=1e-9)


@pytest.mark.slow
def test_memory_alone_limits_how_many_numbers_are_estimated():
    assert Observer(decays(1001), queue_capacity=4).info().dropped == 0


@pytest.mark.parametrize("count", [2500, 5001])
def test_more_numbers_than_memory_holds_are_refused_with_a_remedy(count):
    with pytest.raises(
        HnavValueError, match=f"{count} states, unknown inputs and parameters .* 1 GiB.*: estimate fewer parameters"
    ):
        Observer(decays(count))


def test_numbers_beyond_the_memory_are_refused_with_a_remedy_that_holds():
    with pytest.raises(HnavValueError, match="150 states.* an observer may take 1 GiB: take queue_capacity") as refused:
        Observer(decays(), queue_capacity=20_000)
    remedy = int(re.search(r"queue_capacity = (\d+), estimate fewer", str(refused.value))[1])
    with pytest.raises(HnavValueError, match="an observer may take 1 GiB"):
        Observer(decays(), queue_capacity=int(1.02 * remedy))
    assert Observer(decays(), queue_capacity=remedy).info().dropped == 0


def test_the_command_names_the_plan_of_the_user(little_fmu, tmp_path):
    plan = tmp_path / "mine.toml"
    plan.write_text("[plant]\n[sensor.x]\nnoise = 0.1\n")
    refused = command("observe", little_fmu, "--plan", plan)
    assert refused.returncode == 2 and "mine.toml: every start_sigma is 0 and there is no noise" in refused.stderr


def test_an_exported_observer_has_a_limit_of_its_own(little_fmu, tmp_path, monkeypatch):
    monkeypatch.setattr(observer_export, "MOST", 1)
    with pytest.raises(HnavValueError, match="estimates 2 numbers, an exported observer at most 1"):
        Observer(little_plan(little_fmu)).export(tmp_path / "Observer.fmu")
    assert not (tmp_path / "Observer.fmu").exists()


CELLS, T_S = 30, np.arange(1.0, 6.0)


def rod_run(folder, **said):
    """The observer of a rod with these declared dependencies, and its run."""
    observer = Observer(plan_of(rod_fmu(folder, CELLS, **said), CELLS), start_mode="given")
    return observer, observer.run(T_S, {name: np.sin(T_S + i) for i, name in enumerate(observer.plan.sensors)})


def test_dependencies_that_an_fmu_declares_change_its_cost_alone(tmp_path):
    observer, silent = rod_run(tmp_path, reach=None)
    assert "depends" not in observer.plan.text() and not observer.proof()
    for directional in (False, True):
        observer, run = rod_run(tmp_path, reach=1, directional=directional)
        lines = [line for line in observer.plan.text().splitlines() if line.startswith("depends")]
        assert len(lines) == CELLS and lines[0] == "depends 0 0 1" and lines[5] == "depends 5 4 5 6" and not observer.lies()
        assert run.covariance == pytest.approx(silent.covariance, abs=1e-9)
        assert all(run.x[name] == pytest.approx(silent.x[name], abs=1e-8) for name in run.x)


def test_dependencies_that_an_fmu_declares_wrongly_are_named_and_not_used(tmp_path):
    _, silent = rod_run(tmp_path, reach=None)
    observer, run = rod_run(tmp_path, reach=0)
    assert observer.lies() == [
        "derivatives by states: the plant says d der(x0) / d x1 = 0, differences 0.2; differences are used"
    ]
    assert (run.covariance == silent.covariance).all()
    # Directional derivatives that are right are used nevertheless.
    observer, run = rod_run(tmp_path, reach=0, directional=True)
    assert observer.proof()["derivatives_by_states"].exact and run.covariance == pytest.approx(silent.covariance, abs=1e-9)


@pytest.mark.parametrize("version", [2, 3])
def test_dependencies_are_read_by_index_and_by_reference(plants, version):
    plan = Plan(plants / f"fmi{version}" / "VanDerPol.fmu").sensor("x0", noise=0.1)
    assert [line for line in plan.text().splitlines() if line.startswith("depends")] == ["depends 0 1"]
