"""Observers of FMUs with events: the discrete state follows the estimate, and a failing event costs samples only."""

import subprocess
import sys

import numpy as np
import pytest

import hnav
from command_line import hnav as command
from hnav.filters.observer import Observer
from hnav.filters.observer_plan import Plan
from hnav.fmi.fmus import Fmu
from observer.ball_fmu import MODES, SAVES, SOURCE, packed
from observer.little_fmu import compiled

T_S = np.arange(1, 41) * 0.05


@pytest.fixture(scope="module")
def ball_binary(tmp_path_factory):
    return compiled(tmp_path_factory.mktemp("ball"), source=SOURCE)


@pytest.fixture(scope="module")
def ball_fmu(ball_binary, tmp_path_factory):
    return packed(tmp_path_factory.mktemp("ball") / "ball.fmu", ball_binary)


def plan_of(fmu, mode=None, sensor="h"):
    plan = Plan(fmu).sensor(sensor, noise=0.02).state("h", start_sigma=0.05).state("v", start_sigma=0.3, noise=0.14)
    return plan if mode is None else plan.set("mode", MODES.index(mode))


def observer_of(fmu, mode=None, **options):
    return Observer(plan_of(fmu, mode), start_mode="given", **options)


def in_python():
    plant = hnav.Plant(
        lambda t, x, u, p, q: (x[1], 0.0 if q[0] else -9.81), lambda t, x, u, p, q: x[0], states={"h": 1.0, "v": 0.0}, sensors=["h"],
        indicators=lambda t, x, u, p, q: 1.0 if q[0] else x[0], event=bounce, discrete={"rests": 0.0, "kicked": 0.0},
        inputs={"kick": 0.0}, parameters={"e": 0.7},
    )  # fmt: skip
    return plan_of(plant)


def bounce(t, x, u, p, q):
    h, v = x
    rests, kicked = q
    if u[0] != kicked:
        v, rests, kicked = v + u[0], 0.0, u[0]
    if h <= 0 and v < 0 and not rests:
        h, v = 1e-300, -p[0] * v
        if v < 0.1:
            v, rests = 0.0, 1.0
    return (h, v), (rests, kicked)


def samples(seed=1, count=40, e=0.7):
    rng = np.random.default_rng(seed)
    h, v, rows = 1.0, 0.0, []
    for _ in range(count):
        for _ in range(100):
            d = 5e-4
            h, v = h + d * (v - 0.5 * 9.81 * d), v - 9.81 * d
            if h <= 0 and v < 0:
                h, v = 0.0, -e * v
        rows.append(h)
    return np.array(rows) + rng.normal(0, 0.02, count)


# --------------------------------------------------------------------------------------------- laws


def test_an_fmu_and_its_equations_give_the_same_estimate(ball_fmu):
    kick = {"kick": np.where(np.isclose(T_S, 1.5), 2.0, np.nan)}
    of_fmu = Observer(plan_of(ball_fmu).input("kick"), start_mode="given").run(T_S, {"h": samples()}, kick)
    of_functions = Observer(in_python().input("kick"), start_mode="given").run(T_S, {"h": samples()}, kick)
    assert of_fmu.plant_events[-1] > 2.9 and of_fmu.dropped == 0
    assert of_fmu.x["v"][29] - of_fmu.x["v"][28] > 1
    assert np.array_equal(of_fmu.parts, of_functions.parts) and of_fmu.parts.max() > 1
    for name in ("h", "v"):
        assert np.abs(of_fmu.x[name] - of_functions.x[name]).max() < 1e-9
        assert np.abs(of_fmu.sigma[name] / of_functions.sigma[name] - 1).max() < 1e-6


def test_balls_of_fmi_2_and_3_are_one(plants):
    runs = [observer_of(plants / f"fmi{version}/BouncingBall.fmu").run(T_S, {"h": samples()}) for version in (2, 3)]
    assert np.array_equal(runs[0].covariance, runs[1].covariance)
    assert runs[0].plant_events[-1] > 2
    # A bounce and no sample: as the closed form has it.
    plan = plan_of(plants / "fmi3/BouncingBall.fmu").state("h", start_sigma=0.02).state("v", start_sigma=0.1)
    observer = Observer(plan, start_mode="given")
    observer.advance(0.7)
    bounce_s = np.sqrt(2 / 9.81)
    flow = [np.array([[1, t], [0, 1]]) for t in (bounce_s, 0.7 - bounce_s)]
    Phi = flow[1] @ np.array([[-0.7, 0], [9.81 * 1.7 / (9.81 * bounce_s), -0.7]]) @ flow[0]
    assert observer.covariance() == pytest.approx(Phi @ np.diag([4e-4, 1e-2]) @ Phi.T, rel=1e-5)


def test_the_restitution_of_an_fmu_is_learnt(plants, ball_fmu):
    for fmu in (ball_fmu, plants / "fmi2/BouncingBall.fmu"):
        plan = plan_of(fmu).parameter("e", start=0.75, start_sigma=0.05)
        run = Observer(plan, start_mode="given").run(T_S[:30], {"h": samples()[:30]})
        assert run.dropped == 0
        assert abs(run.x["e"][-1] - 0.7) < 3 * run.sigma["e"][-1] < 0.06


def test_late_samples_and_other_times_give_the_same_bits(ball_fmu, ball_binary, tmp_path):
    # As well where the FMU keeps the copies of its states itself.
    for fmu in (ball_fmu, packed(tmp_path / "keeps.fmu", ball_binary, SAVES)):
        y, in_order, late = samples(), observer_of(fmu, horizon_s=0.3), observer_of(fmu, horizon_s=0.3)
        for k, t in enumerate(T_S):
            in_order.push("h", t, y[k])
            in_order.advance(t)
            late.advance(t)
            for index in (k - 2, k - 1) if k % 2 else ():
                if index >= 0:
                    late.push("h", T_S[index], y[index])
        late.push("h", T_S[39], y[39])
        for observer in (in_order, late):
            observer.advance(2.1)
        assert in_order.info().splits > 1
        assert np.array_equal(late.covariance(), in_order.covariance())


def test_a_saved_state_goes_on_in_another_process(ball_fmu, tmp_path):
    y, cut = samples(), 19
    expected = observer_of(ball_fmu).run(T_S, {"h": y})
    first = observer_of(ball_fmu)
    first.run(T_S[:cut], {"h": y[:cut]})
    (tmp_path / "state").write_bytes(first.save())
    np.save(tmp_path / "y.npy", y)
    program = f"""
import numpy as np, hnav
plan = hnav.Plan({str(ball_fmu)!r}).sensor("h", noise=0.02).state("h", start_sigma=0.05).state("v", start_sigma=0.3, noise=0.14)
observer = hnav.Observer(plan, start_mode="given")
observer.load(open({str(tmp_path / "state")!r}, "rb").read())
y = np.load({str(tmp_path / "y.npy")!r})
run = observer.run(np.arange(1, 41)[{cut}:] * 0.05, {{"h": y[{cut}:]}})
np.save({str(tmp_path / "P.npy")!r}, run.covariance)
"""
    subprocess.run([sys.executable, "-c", program], check=True)
    assert np.array_equal(np.load(tmp_path / "P.npy"), expected.covariance[cut:])


def test_an_fmu_that_keeps_its_states_itself(ball_fmu, ball_binary, tmp_path):
    keeps = observer_of(packed(tmp_path / "keeps.fmu", ball_binary, SAVES), horizon_s=0.1)
    t, y = np.arange(1, 2001) * 0.05, np.tile(samples(), 50)
    run = keeps.run(t, {"h": y})
    assert run.dropped == 0 and keeps.info().plant_events > 3
    serialized = observer_of(ball_fmu, horizon_s=0.1).run(t, {"h": y})
    assert np.array_equal(run.covariance, serialized.covariance)
    with pytest.raises(
        hnav.HnavError, match="cannot write down what it remembers .canSerializeFMUstate.: its observer cannot be saved"
    ):
        keeps.save()
    keeps.reset()
    assert np.array_equal(keeps.run(T_S, {"h": samples()}).covariance, run.covariance[:40])


@pytest.mark.parametrize("version", [2, 3])
def test_an_exported_observer_gives_the_same_estimates(ball_fmu, tmp_path, version):
    path, y = tmp_path / "observer.fmu", samples()
    plan_of(ball_fmu).export(path, version, period_s=0.05)
    observer = Observer(plan_of(ball_fmu))
    with Fmu(path) as fmu:
        fmu.set("sampling_mode", "counter")
        fmu.initialise()
        for k in range(30):
            t = 0.05 * k
            fmu.set("h.value", y[k])
            fmu.set("h.t_meas", t)
            fmu.set("h.sample", k + 1)
            fmu.do_step(t, 0.05)
            observer.push("h", t, y[k])
            observer.advance(t + 0.05)
            assert fmu.get("est.v") == observer.estimate()[0]["v"]
            assert fmu.get("parts") == observer.info().parts
        assert fmu.get("count.plant_events") > 1


def test_the_command_prints_events(ball_fmu, tmp_path):
    (tmp_path / "plan.toml").write_text(
        f"[plant]\nfmu = '{ball_fmu}'\n[sensor.h]\nnoise = 0.02\n[state.h]\nstart_sigma = 0.05\n"
        "[state.v]\nstart_sigma = 0.3\nnoise = 0.14\n[options]\nstart_mode = 'given'\n"
    )
    np.savetxt(tmp_path / "rec.csv", np.column_stack([T_S, samples()]), delimiter=",", header="t_s,h", comments="")
    done = command(
        "observe", ball_fmu, "--plan", tmp_path / "plan.toml", "--data", tmp_path / "rec.csv", "--out", tmp_path / "out.csv"
    )
    assert "4 events of the plant; in " in done.stdout
    rows = [line.split(",") for line in (tmp_path / "out.csv").read_text().splitlines() if not line.startswith("#")]
    events = [float(row[rows[0].index("plant_events")]) for row in rows[1:]]
    assert events[0] == 0 and round(events[-1]) == 4


def hardly_coming(fmu):
    """A ball whose mean just touches the floor, so that points are propagated through the FMU."""
    plan = Plan(fmu).sensor("h", noise=0.5).set("mode", MODES.index("lifts"))
    return plan.state("h", start=0.5, start_sigma=0.02).state("v", start=-np.sqrt(9.81), start_sigma=0.1, noise=0.01)


def test_points_go_through_an_fmu_that_keeps_its_states_itself(ball_fmu, ball_binary, tmp_path):
    t, y = np.arange(1, 7) * 0.1, [0.25, 0.1, 0.0, 0.0, 0.1, 0.3]
    serialises, keeps = ball_fmu, packed(tmp_path / "keeps.fmu", ball_binary, SAVES)
    expected = Observer(hardly_coming(serialises), start_mode="given")
    run = expected.run(t, {"h": y})
    assert expected.info().grazing > 0 and run.parts.max() > 1 and run.dropped == 0
    observer = Observer(hardly_coming(keeps), start_mode="given")
    # A hundred times as many points as copies that the FMU gives.
    for _ in range(200):
        assert np.array_equal(observer.run(t, {"h": y}).covariance, run.covariance)
        observer.reset()
    for version in (2, 3):
        observer.export(tmp_path / "o.fmu", version, period_s=0.1)
        with Fmu(tmp_path / "o.fmu") as fmu:
            fmu.set("sampling_mode", "counter")
            fmu.initialise()
            fmu.do_step(0, 0.1)
            for k in range(6):
                for name, value in (("value", y[k]), ("t_meas", t[k]), ("sample", k + 1)):
                    fmu.set(f"h.{name}", value)
                fmu.do_step(t[k], 0.1)
            assert fmu.get("count.grazing") == expected.info().grazing and fmu.get("parts") == run.parts[-1]
            assert [fmu.get("post.h"), fmu.get("post.v")] == [run.x["h"][-1], run.x["v"][-1]]


def test_events_at_ends_of_steps_are_found(ball_fmu):
    # This one has its bounce at the end of a step: a little too deep.
    run = observer_of(ball_fmu, "step_event").run(T_S[:12], {"h": samples()[:12]})
    assert run.dropped == 0
    assert run.plant_events[-1] == 1
    assert run.x["v"][7] < -3 and run.x["v"][-1] > 1


# --------------------------------------------------------------------------------------------- FMUs that fail


@pytest.mark.parametrize(
    ("mode", "said"),
    [
        ("iterates", "its event iteration does not end"), ("terminates", "it asks to terminate"), ("error_in_event", "the floor broke"),
        ("nan_after_event", "derivatives"), ("grows", "its state has grown"),
    ],
)  # fmt: skip
def test_an_event_that_fails_is_held_before(ball_fmu, mode, said):
    observer, sound, y = observer_of(ball_fmu, mode), observer_of(ball_fmu), samples()
    run, expected = observer.run(T_S, {"h": y}), sound.run(T_S, {"h": y})
    assert np.array_equal(run.x["v"][:6], expected.x["v"][:6])
    assert run.held > 20 and said in run.dropped_because and not run.ready[-20:].any()
    assert np.isfinite(run.covariance).all()
    observer.reset()
    assert np.array_equal(observer.run(T_S[:6], {"h": y[:6]}).covariance, expected.covariance[:6])


def test_an_fmu_that_names_times_without_end(ball_fmu):
    observer = observer_of(ball_fmu, "endless_times")
    run = observer.run([0.1], {"h": [1.0]})
    assert run.held == 1 and "the events of the plant do not end at t = 0" in run.dropped_because


def test_an_fmu_that_has_failed_takes_its_own_states_with_it(ball_binary, tmp_path):
    fmu = packed(tmp_path / "keeps.fmu", ball_binary, SAVES)
    observer = observer_of(fmu, "error_in_event")
    assert observer.run(T_S, {"h": samples()}).dropped > 20
    with pytest.raises(hnav.HnavRuntimeError, match="the states that it has saved are lost with it: make a new observer"):
        observer.push("h", 3.0, 0.0)
        observer.advance(3.0)


def test_an_fmu_with_events_that_exists_once_in_a_process(plants, ball_binary, tmp_path):
    once = 'canGetAndSetFMUstate="true" canSerializeFMUstate="true" canBeInstantiatedOnlyOncePerProcess="true"'
    observer = observer_of(packed(tmp_path / "once.fmu", ball_binary, once, token="{once}"))
    assert observer.run(T_S, {"h": samples()}).dropped == 0


def test_a_state_that_cannot_be_saved_is_refused(ball_binary, tmp_path):
    with pytest.raises(hnav.HnavValueError, match="it has 1 state event and cannot save its state"):
        Plan(packed(tmp_path / "no.fmu", ball_binary, ""))
    with pytest.raises(hnav.HnavValueError, match=r"it has discrete variables \(rests, bounces\) and cannot save its state"):
        Plan(packed(tmp_path / "no.fmu", ball_binary, "", indicators=0))
