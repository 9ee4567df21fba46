"""Observers as FMUs whose plant has events of its own, with what the plant can save."""

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
    assert description.modelExchange.canSerializeFMUstate and description.coSimulation.canSerializeFMUstate
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


@versions
def test_an_integrator_of_the_importer_crosses_events(ball_binary, tmp_path, version):
    """As Co-Simulation where no hypotheses are: bounces far from samples, known well. Two of them, and learnt restitution."""
    plant = packed(tmp_path / "ball.fmu", ball_binary)
    plan = plan_of(plant).state("h", start_sigma=0.002).state("v", start_sigma=0.01, noise=0.001).sensor("h", noise=0.002)
    plan.parameter("e", start=0.7, start_sigma=0.01)
    Observer(plan, start_mode="given").export(tmp_path / "o.fmu", version, period_s=1e6)
    assert_fits_the_standard(tmp_path / "o.fmu", version)
    t_s, y = np.array([0.1, 0.25, 0.6, 0.8, 0.95, 1.3]), [0.951, 0.692, 0.3, 0.452, 0.287, 0.15]
    shown, ends = {}, [*t_s[1:], 1.4]
    for exchange in (False, True):
        with Fmu(tmp_path / "o.fmu", model_exchange=exchange) as fmu:
            fmu.set("sampling_mode", "counter")
            fmu.initialise()
            now = 0.0
            for k, end in enumerate(ends):
                goes_to(fmu, now, t_s[k], exchange)
                for name, value in (("value", y[k]), ("t_meas", t_s[k]), ("sample", k + 1)):
                    fmu.set(f"h.{name}", value)
                goes_to(fmu, t_s[k], end, exchange)
                now = end
            names = [*SHOWN, *(f"{kind}.{name}" for kind in ("est", "sigma") for name in ("h", "v", "e"))]
            shown[exchange] = {name: fmu.get(name) for name in names}
            assert fmu.messages == []
    inside, outside = shown[False], shown[True]
    assert inside["parts"] == outside["parts"] == 1 and inside["count.splits"] == 0
    assert inside["count.plant_events"] == outside["count.plant_events"] == 2 and outside["count.h.used"] == 6
    for name in ("h", "v", "e"):
        sigma = inside[f"sigma.{name}"]
        assert abs(outside[f"est.{name}"] - inside[f"est.{name}"]) < 1e-2 * sigma
        assert outside[f"sigma.{name}"] == pytest.approx(sigma, rel=1e-2)


def goes_to(fmu: Fmu, begin_s: float, end_s: float, exchange: bool) -> None:
    if end_s > begin_s and exchange:
        exchange_to(fmu, begin_s, end_s)
    elif end_s > begin_s:
        fmu.do_step(begin_s, end_s - begin_s)


def exchange_to(fmu: Fmu, begin_s: float, end_s: float) -> None:
    """From event mode to event mode, as any importer: to each root of the indicators, and the end."""
    while begin_s < end_s:
        fmu.update_discrete_states()
        fmu.call(fmu.fmu.enterContinuousTimeMode)
        solver = fmu.solver(begin_s)
        _, _, begin_s = solver.step(begin_s, end_s)
        fmu.call(fmu.fmu.setTime, begin_s)
        fmu.call(fmu.fmu.enterEventMode)


@versions
@pytest.mark.parametrize("kind", ["CoSimulation", "ModelExchange"])
def test_fmpy_simulates_an_observer_of_a_ball(ball_binary, tmp_path, version, kind):
    path = exported(tmp_path, ball_binary, version)
    rows = np.array(list(zip(T_S, samples())), [("time", float), ("h.value", float)])
    result = fmpy.simulate_fmu(
        str(path), fmi_type=kind, stop_time=1.5, output_interval=0.05, input=rows, output=["est.h", "parts", "count.plant_events"]
    )
    assert result["count.plant_events"][-1] >= 2 and abs(result["est.h"][-1] - samples()[29]) < 0.15
    assert result["parts"].max() == 1 or kind == "CoSimulation"


@versions
def test_steps_of_the_importer_are_told_to_the_plant(ball_binary, tmp_path, version):
    """This one has its bounce at the end of a step."""
    plan = plan_of(packed(tmp_path / "ball.fmu", ball_binary), "step_event")
    Observer(plan, start_mode="given").export(tmp_path / "o.fmu", version, period_s=1e6)
    result = fmpy.simulate_fmu(
        str(tmp_path / "o.fmu"),
        fmi_type="ModelExchange",
        stop_time=0.6,
        output_interval=0.01,
        output=["est.v", "count.plant_events"],
    )
    assert result["count.plant_events"][-1] == 1 and result["est.v"][-1] > 1


def test_balls_of_others_are_exported(plants, tmp_path):
    for version in VERSIONS:
        plan = plan_of(plants / f"fmi{version}" / "BouncingBall.fmu")
        Observer(plan, start_mode="given").export(tmp_path / "o.fmu", 5 - version)
        with Fmu(tmp_path / "o.fmu") as fmu:
            begun(fmu)
            assert run(fmu, 0, 40)[4] > 2
