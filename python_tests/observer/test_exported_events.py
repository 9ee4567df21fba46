"""Observers as FMUs whose plant has events of its own: for Co-Simulation, with what the plant can save."""

import fmpy
import numpy as np
import pytest

from hnav.errors import HnavError
from hnav.filters.observer import Observer
from hnav.fmi.fmus import Fmu
from importing import assert_fits_the_standard
from observer.ball_fmu import SAVES, SOURCE, packed
from observer.little_fmu import compiled
from observer.test_exported_fmus import state_calls
from observer.test_fmu_events import T_S, plan_of, samples

VERSIONS = (2, 3)
versions = pytest.mark.parametrize("version", VERSIONS, ids=lambda v: f"fmi{v}")
SHOWN = ("post.h", "post.v", "post_sigma.v", "parts", "count.plant_events", "count.splits", "count.h.used")


@pytest.fixture(scope="module")
def ball_binary(tmp_path_factory):
    return compiled(tmp_path_factory.mktemp("ball"), source=SOURCE)


def exported(folder, binary, version, **more):
    plant = packed(folder / "ball.fmu", binary, **more)
    Observer(plan_of(plant), start_mode="given").export(folder / "o.fmu", version, period_s=0.05)
    return folder / "o.fmu"


def run(fmu: Fmu, begin: int, end: int) -> list[float]:
    """Counted samples, which come at the beginning of the step that ends at the next."""
    for k in range(begin, end):
        fmu.set("h.value", samples()[k])
        fmu.set("h.t_meas", T_S[k])
        fmu.set("h.sample", k + 1)
        fmu.do_step(T_S[k], 0.05)
    return [fmu.get(name) for name in SHOWN]


def begun(fmu: Fmu) -> None:
    fmu.set("sampling_mode", "counter")
    fmu.initialise()
    fmu.do_step(0.0, 0.05)


@versions
def test_a_ball_that_bounces_is_observed_bit_for_bit(ball_binary, tmp_path, version):
    path = exported(tmp_path, ball_binary, version)
    assert_fits_the_standard(path, version)
    description = fmpy.read_model_description(str(path))
    assert description.modelExchange is None and description.coSimulation.canSerializeFMUstate
    observer = Observer(plan_of(tmp_path / "ball.fmu"), start_mode="given")
    for k in range(40):
        observer.push("h", T_S[k], samples()[k])
    observer.advance(T_S[39])
    x, sigma = observer.estimate()
    info = observer.info()
    assert info.plant_events > 2 and info.splits > 0
    with Fmu(path) as fmu:
        begun(fmu)
        found = run(fmu, 0, 40)
        assert found == [x["h"], x["v"], sigma["v"], info.parts, info.plant_events, info.splits, 40]
        assert fmu.get("count.dropped") == 0 and fmu.messages == []


@versions
def test_what_the_plant_remembers_goes_with_the_saved_state(ball_binary, tmp_path, version):
    path = exported(tmp_path, ball_binary, version)
    with Fmu(path) as one, Fmu(path) as other:
        begun(one)
        run(one, 0, 20)
        take, to_bytes, _, _ = state_calls(one)
        content = to_bytes(take())
        end = run(one, 20, 40)
        other.set("sampling_mode", "counter")
        _, _, from_bytes, put = state_calls(other)
        put(from_bytes(content))
        assert run(other, 20, 40) == end


@versions
def test_a_plant_that_cannot_write_its_state_makes_an_observer_that_says_so(ball_binary, tmp_path, version):
    path = exported(tmp_path, ball_binary, version, attributes=SAVES)
    offered = fmpy.read_model_description(str(path)).coSimulation
    assert not offered.canGetAndSetFMUstate and not offered.canSerializeFMUstate
    with Fmu(path) as fmu:
        begun(fmu)
        assert np.isfinite(run(fmu, 0, 40)).all()
        with pytest.raises(HnavError, match="cannot be saved"):
            fmu.call(state_calls(fmu)[0])


def test_balls_of_others_are_exported(plants, tmp_path):
    for version in VERSIONS:
        plan = plan_of(plants / f"fmi{version}" / "BouncingBall.fmu")
        Observer(plan, start_mode="given").export(tmp_path / "o.fmu", 5 - version)
        with Fmu(tmp_path / "o.fmu") as fmu:
            begun(fmu)
            assert run(fmu, 0, 40)[4] > 2
