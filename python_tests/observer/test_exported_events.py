"""Exported observers of plants with events, for each kind of access to the plant's state."""

import ctypes as C
from pathlib import Path

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
    """Counted samples, each set before the step that ends at the next one."""
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


@pytest.fixture(params=VERSIONS, ids=lambda v: f"fmi{v}")
def keeping(request, ball_binary, tmp_path) -> Path:
    """An observer with late samples, of a plant that can get and set its state but not serialise it."""
    plan = plan_of(packed(tmp_path / "ball.fmu", ball_binary, SAVES))
    Observer(plan, start_mode="given", horizon_s=0.12).export(tmp_path / "o.fmu", request.param, period_s=0.05)
    return tmp_path / "o.fmu"


def frees(fmu: Fmu):
    return fmu.fmu.freeFMUState if fmu.fmi3 else fmu.fmu.freeFMUstate


def copies_out(fmu: Fmu) -> C.c_int:
    """States that the inner plant has allocated and that are not freed."""
    (binary,) = Path(fmu._folder).glob("resources/plant/binaries/*/ball.so")
    return C.c_int.in_dll(C.CDLL(str(binary)), "copies")


def test_a_plant_that_keeps_its_states_itself_makes_an_observer_that_goes_back(keeping, ball_binary, tmp_path):
    with Fmu(keeping) as fmu:
        begun(fmu)
        saved, ends = {}, {}
        for k in range(40):
            saved[k] = fmu.call(state_calls(fmu)[0])
            ends[k] = run(fmu, k, k + 1)
        # Events before and after each, and hypotheses alive at some.
        assert ends[39][4] > 2 and max(end[3] for end in ends.values()) > 1
        put = state_calls(fmu)[3]
        for k in (0, 39, 12, 5, 12, 30, *range(0, 40, 7)):
            fmu.call(put, saved[k])
            assert run(fmu, k, 40) == ends[39]
        for k in range(40):
            fmu.call(put, saved[k])
            assert run(fmu, k, k + 1) == ends[k]
        assert fmu.messages == []
    # As where the plant writes its state down.
    plan = plan_of(packed(tmp_path / "writes.fmu", ball_binary))
    Observer(plan, start_mode="given", horizon_s=0.12).export(tmp_path / "w.fmu", 2, period_s=0.05)
    with Fmu(tmp_path / "w.fmu") as writes:
        begun(writes)
        assert run(writes, 0, 40) == ends[39]


def test_its_saved_states_cannot_leave_it_and_it_says_the_cure(keeping):
    offered = fmpy.read_model_description(str(keeping))
    for interface in (offered.coSimulation, offered.modelExchange):
        assert interface.canGetAndSetFMUstate and not interface.canSerializeFMUstate
    with Fmu(keeping) as fmu:
        begun(fmu)
        run(fmu, 0, 15)
        take, to_bytes, _, put = state_calls(fmu)
        state = take()
        with pytest.raises(HnavError, match="export it with canSerializeFMUstate, and the observer again"):
            fmu.call(to_bytes, state)
        expected = run(fmu, 15, 20)
        fmu.call(put, state)
        assert run(fmu, 15, 20) == expected
        with Fmu(keeping) as other:
            begun(other)
            with pytest.raises(HnavError, match="a snapshot ends with the observer that it was taken of"):
                other.call(state_calls(other)[3], state)
        fmu.call(fmu.fmu.reset)
        begun(fmu)
        with pytest.raises(HnavError, match="a snapshot ends with the observer that it was taken of"):
            fmu.call(put, state)
        # The instance is as new then.
        begun(fmu)
        assert run(fmu, 0, 20) == expected
        fmu.call(frees(fmu), state)


def test_states_of_the_plant_are_freed_with_those_of_the_observer(keeping):
    with Fmu(keeping) as fmu:
        begun(fmu)
        out = copies_out(fmu)
        take, _, _, put = state_calls(fmu)
        take_into = fmu._call_of("GetFMUState" if fmu.fmi3 else "GetFMUstate")
        run(fmu, 0, 20)
        start = take()
        run(fmu, 20, 40)
        fmu.call(put, start)
        alone = out.value
        for _ in range(20):
            # Freed without having been set, after it was set, and after another was taken into it.
            run(fmu, 20, 30)
            states = [take() for _ in range(3)]
            run(fmu, 30, 40)
            fmu.call(put, states[1])
            fmu.call(take_into, fmu.fmu.component, C.byref(states[2]))
            for state in states:
                fmu.call(frees(fmu), state)
            fmu.call(put, start)
        assert out.value <= 2 * alone
        kept = [take() for _ in range(50)]
        assert out.value <= 2 * alone
        fmu.call(frees(fmu), kept[0])
    # The instance takes with it what was not freed.
    assert out.value == 0


def test_an_integrator_of_the_importer_goes_back_through_events(keeping):
    with Fmu(keeping, model_exchange=True) as fmu:
        fmu.set("sampling_mode", "counter")
        fmu.initialise()
        out, y, t_s, names = copies_out(fmu), samples(), [0.0, *T_S], (*SHOWN, "est.v", "sigma.v", "time")

        def goes_on(begin: int, end: int) -> list[float]:
            for k in range(begin, end):
                exchange_to(fmu, t_s[k], t_s[k + 1])
                for name, value in (("value", y[k]), ("t_meas", T_S[k]), ("sample", k + 1)):
                    fmu.set(f"h.{name}", value)
            return [fmu.get(name) for name in names]

        take, _, _, put = state_calls(fmu)
        goes_on(0, 8)
        before = fmu.call(take)
        after = {end: goes_on(begin, end) for begin, end in ((8, 12), (12, 30))}
        assert after[30][4] >= 2
        for _ in range(3):
            fmu.call(put, before)
            assert {end: goes_on(begin, end) for begin, end in ((8, 12), (12, 30))} == after
        assert fmu.messages == []
    assert out.value == 0


@versions
def test_an_integrator_of_the_importer_crosses_events(ball_binary, tmp_path, version):
    """Equals Co-Simulation where there is one hypothesis: two bounces far from samples, with an estimated restitution."""
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
    """From event mode to event mode, as an importer integrates: to each root of the indicators, then to the end."""
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
def test_steps_of_the_importer_reach_the_plant(ball_binary, tmp_path, version):
    """A bounce at the end of a step."""
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
