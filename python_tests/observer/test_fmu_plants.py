"""Observers of FMUs: estimates, refusals, and failing FMUs."""

import os
import signal
import subprocess
import sys
import time
import zipfile

import numpy as np
import pytest

import hnav
from checkout import in_another_process
from command_line import hnav_process
from hnav.errors import HnavValueError
from hnav.filters.observer import Observer
from hnav.filters.observer_plan import Plan
from hnav.io import archive_room
from observer.little_fmu import DERIVATIVES, MODES, VARIABLES, compiled, packed

T_S = np.arange(0, 4, 0.05)


def little_plan(fmu, mode="sound"):
    plan = Plan(fmu).set("mode", MODES.index(mode)).sensor("x", noise=np.float64(0.02)).input("u", start=np.float32(0))
    return plan.state("x", start_sigma=0.2).state("v", start_sigma=0.5, noise=0.1)


def spring(t, x, u, p):
    return x[1], -p[0] * x[0] - 0.3 * x[1] + u[0]


def spring_plan():
    plant = hnav.Plant(
        spring, lambda t, x, u, p: (x[0], x[0] + u[1]), states={"x": 1.0, "v": 0.0}, sensors=["x", "y"],
        inputs={"u": 0.0, "d": 0.0}, parameters={"k": 4.0},
    )  # fmt: skip
    plan = Plan(plant).sensor("x", noise=0.02).input("u")
    return plan.state("x", start_sigma=0.2).state("v", start_sigma=0.5, noise=0.1)


def samples(seed=1, k=4.0, offset=0.0):
    rng = np.random.default_rng(seed)
    return offset + np.cos(np.sqrt(k) * T_S) * np.exp(-0.15 * T_S) + rng.normal(0, 0.02, len(T_S))


def oscillator(fmu_or_plant):
    plan = Plan(fmu_or_plant).sensor("x0", noise=0.05).state("x0", start_sigma=1.0, noise=0.01)
    return plan.state("x1", start_sigma=1.0, noise=0.1)


# --------------------------------------------------------------------------------------------- laws


def test_an_fmu_and_its_equations_give_the_same_estimate(little_fmu):
    u = {"u": np.where(np.arange(len(T_S)) % 20 == 0, np.sin(T_S), np.nan)}
    of_fmu = Observer(little_plan(little_fmu)).run(T_S, {"x": samples()}, u)
    of_functions = Observer(spring_plan()).run(T_S, {"x": samples()}, u)
    for name in ("x", "v"):
        assert np.abs(of_fmu.x[name] - of_functions.x[name]).max() < 1e-9
        assert np.abs(of_fmu.sigma[name] / of_functions.sigma[name] - 1).max() < 1e-7
    assert of_fmu.proof["derivatives_by_states"].exact


def test_a_derivative_without_a_list_of_dependencies_depends_on_everything(little_binary, tmp_path):
    silent = packed(tmp_path / "silent.fmu", little_binary)
    one_list = packed(
        tmp_path / "one_list.fmu", little_binary, derivatives='<Unknown index="3" dependencies="2"/><Unknown index="4"/>'
    )
    runs = [Observer(little_plan(fmu)).run(T_S, {"x": samples()}) for fmu in (silent, one_list)]
    assert not Observer(little_plan(one_list)).lies()
    np.testing.assert_allclose(runs[1].covariance, runs[0].covariance, atol=1e-12)


def test_fmi_2_fmi_3_and_functions_agree(plants):
    y = 2 * np.cos(T_S) + np.random.default_rng(1).normal(0, 0.05, len(T_S))
    plant = hnav.Plant(
        lambda t, x, u, p: (x[1], (1 - x[0] ** 2) * x[1] - x[0]), lambda t, x, u, p: x[0], states={"x0": 2.0, "x1": 0.0}, sensors=["x0"],
        jacobian=lambda t, x, u, p: [[0, 1], [-2 * x[0] * x[1] - 1, 1 - x[0] ** 2]],
    )  # fmt: skip
    runs = [Observer(oscillator(p)).run(T_S, {"x0": y}) for p in (*(plants / f"fmi{v}/VanDerPol.fmu" for v in (2, 3)), plant)]
    for name in ("x0", "x1"):
        assert np.array_equal(runs[0].x[name], runs[1].x[name])
        assert np.abs(runs[0].x[name] - runs[2].x[name]).max() < 1e-12
        assert np.abs(runs[0].sigma[name] / runs[2].sigma[name] - 1).max() < 1e-11


def test_derivatives_that_lie_are_found_and_named(plants, little_fmu):
    for version in (2, 3):
        observer = Observer(oscillator(plants / f"fmi{version}/VanDerPol.fmu"))
        proof = observer.proof()
        assert proof["derivatives_by_states"].exact
        assert not proof["outputs_by_states"].exact
        assert (proof["outputs_by_states"].stated, proof["outputs_by_states"].measured) == (0, pytest.approx(1))
        assert observer.lies() == ["outputs by states: the plant says d x0 / d x0 = 0, differences 1; differences are used"]
    lies = Observer(little_plan(little_fmu, "lies"))
    (sentence,) = lies.lies()
    assert "d der(v) / d v = 0.3, differences -0.3" in sentence
    honest = Observer(little_plan(little_fmu)).run(T_S, {"x": samples()})
    assert np.abs(lies.run(T_S, {"x": samples()}).x["v"] - honest.x["v"]).max() < 1e-6


def test_a_parameter_of_a_room_is_learnt(plants):
    plan = Plan(plants / "fmi3/HeatedRoom.fmu").sensor("T_air", noise=0.05).input("power").input("T_out")
    plan.state("T_wall", start=15, start_sigma=2, noise=1e-3).state("T_air", start=18, start_sigma=0.5, noise=10**-2.5)
    plan.parameter("G", start_sigma=2.5)
    observer = Observer(plan)
    assert all(block.exact for block in observer.proof().values()) and len(observer.proof()) == 4
    rng, G = np.random.default_rng(2), 9.7
    t = np.arange(1, 301) * 60.0
    x, seen, power, outside = np.array([14.0, 18.2]), [], [], []
    for k in range(300):
        power.append(400.0 * (k // 20 % 2))
        outside.append(5 + 4 * np.sin(2 * np.pi * k / 1440))
        for _ in range(60):
            wall = (25 * (x[1] - x[0]) - G * (x[0] - outside[-1])) / 4000
            x = x + [wall, (power[-1] - 25 * (x[1] - x[0])) / 400] + rng.normal(0, [1e-3, 10**-2.5])
        seen.append(x[1] + rng.normal(0, 0.05))
    # An input holds from the beginning of its interval on.
    for index in range(300):
        observer.push_input("power", t[index] - 60, power[index])
        observer.push_input("T_out", t[index] - 60, outside[index])
        observer.push("T_air", t[index], seen[index])
        observer.advance(t[index])
    estimate, sigma = observer.estimate()
    assert abs(estimate["G"] - G) < 4 * sigma["G"] < 0.4
    assert abs(estimate["T_wall"] - x[0]) < 4 * sigma["T_wall"]
    assert observer.info().ready


def test_a_parameter_and_an_unknown_input_of_an_fmu(little_fmu):
    plan = little_plan(little_fmu).parameter("k", start_sigma=1.0).unknown_input("d", start_sigma=0.5).sensor("y", noise=0.02)
    observer = Observer(plan)
    assert observer.names == ("x", "v", "d", "k")
    proof = observer.proof()
    assert {name for name, block in proof.items() if block.exact} == {
        "derivatives_by_states", "derivatives_by_unknown_inputs", "outputs_by_states", "outputs_by_unknown_inputs",
    }  # fmt: skip
    run = observer.run(T_S, {"x": samples(k=5.0), "y": samples(2, k=5.0, offset=0.3)})
    assert abs(run.x["k"][-1] - 5) < 4 * run.sigma["k"][-1] < 0.6
    assert abs(run.x["d"][-1] - 0.3) < 4 * run.sigma["d"][-1] < 0.1


def test_samples_come_in_their_own_unit(little_fmu):
    plan = little_plan(little_fmu)
    in_mm = little_plan(little_fmu).sensor("x", noise=20.0, unit="mm")
    a, b = Observer(plan).run(T_S, {"x": samples()}), Observer(in_mm).run(T_S, {"x": 1000 * samples()})
    assert np.abs(a.x["v"] - b.x["v"]).max() < 1e-9
    assert np.nanmax(np.abs(1000 * a.innovation["x"] - b.innovation["x"])) < 1e-6


def test_a_saved_state_goes_on_in_another_observer(little_fmu):
    plan = little_plan(little_fmu).parameter("k", start_sigma=0.5)
    whole, first, second = (Observer(plan) for _ in range(3))
    y, u = samples(), np.sin(T_S)
    expected = whole.run(T_S, {"x": y}, {"u": u})
    first.run(T_S[:33], {"x": y[:33]}, {"u": u[:33]})
    second.load(first.save())
    rest = second.run(T_S[33:], {"x": y[33:]}, {"u": u[33:]})
    assert np.array_equal(rest.covariance, expected.covariance[33:])
    assert all(np.array_equal(rest.x[name], expected.x[name][33:]) for name in rest.x)


def test_two_observers_in_turn_are_as_alone(little_fmu):
    y = samples()
    alone = Observer(little_plan(little_fmu)).run(T_S, {"x": y}).x["v"]
    a, b, shown = Observer(little_plan(little_fmu)), Observer(little_plan(little_fmu)), []
    for t, value in zip(T_S, y):
        for observer, sample in ((a, value), (b, -value)):
            observer.push("x", t, sample)
            observer.advance(t)
        shown.append(a.estimate()[0]["v"])
    assert np.array_equal(shown, alone)


# --------------------------------------------------------------------------------------------- FMUs that fail


@pytest.mark.parametrize(
    ("mode", "said"),
    [
        ("nan_after_1", "not finite"), ("error_after_1", "the spring broke"), ("fatal_after_1", "the house burnt down"),
        ("discards_above_3", None),
    ],
)  # fmt: skip
def test_an_fmu_without_an_answer_costs_its_samples_and_nothing_else(little_fmu, mode, said):
    observer, sound = Observer(little_plan(little_fmu, mode)), Observer(little_plan(little_fmu))
    y, before = samples(), T_S < 0.9
    run = observer.run(T_S, {"x": y})
    expected = sound.run(T_S, {"x": y})
    assert np.array_equal(run.x["v"][before], expected.x["v"][before])
    if said is None:
        assert run.dropped == 0
        return
    assert run.held > 50 and said in run.dropped_because and not run.ready[T_S > 1.1].any()
    if mode == "nan_after_1":
        assert run.dropped == 0  # its sensor goes on
        return
    assert run.dropped > 50
    with pytest.raises(hnav.HnavRuntimeError, match=said):
        observer.push("x", 5.0, 0.0)
        observer.advance(5.0)
    # It stands where it was, and a new beginning is as good as the first.
    assert observer.estimate()[0]["v"] == run.x["v"][-1]
    observer.reset()
    if mode != "fatal_after_1":
        again = observer.run(T_S[before], {"x": y[before]})
        assert np.array_equal(again.x["v"], expected.x["v"][before])


@pytest.mark.parametrize(
    ("mode", "said"),
    [
        ("iterates", "its event iteration does not end"), ("terminates", "it asks to terminate"),
        ("remembers", "the plant remembers what it was asked"), ("event_at_5", "little has events and cannot save its state: export it with canGetAndSetFMUstate"),
    ],
)  # fmt: skip
def test_an_fmu_that_cannot_be_observed_is_refused(little_fmu, mode, said):
    with pytest.raises(hnav.HnavError, match=said):
        Observer(little_plan(little_fmu, mode))


def test_an_fmu_that_dies_of_a_question_is_asked_no_more(little_fmu):
    observer = Observer(little_plan(little_fmu, "one_question").sensor("y", noise=0.02))
    assert not any(block.exact for block in observer.proof().values())
    expected = Observer(little_plan(little_fmu).sensor("y", noise=0.02)).run(T_S, {"x": samples()})
    assert np.abs(observer.run(T_S, {"x": samples()}).x["v"] - expected.x["v"]).max() < 1e-6


def test_illegal_questions_are_not_asked(little_fmu):
    # z is a local variable and k a parameter: this FMU dies when it is asked for derivatives of the one or by the other.
    plan = little_plan(little_fmu).sensor("z", noise=0.1).parameter("k", start_sigma=0.5)
    proof = Observer(plan).proof()
    assert set(proof) == {"derivatives_by_states"}


def test_an_fmu_that_crashes_when_it_is_freed(tmp_path, monkeypatch):
    fmu = packed(tmp_path / "crashes.fmu", compiled(tmp_path, crashes_when_freed=True))
    (tmp_path / "temporary").mkdir()
    monkeypatch.setenv("TMPDIR", str(tmp_path / "temporary"))
    done = hnav_process("observe", fmu)
    assert not list((tmp_path / "temporary").iterdir())
    assert done.returncode == 2
    assert (
        "crashes.fmu crashed (SIGABRT), and took its process with it: ask its maker; if it crashes when it is freed, set"
        in done.stderr
    )
    plan = tmp_path / "plan.toml"
    plan.write_text("[plant]\nnever_freed = true\n[sensor.x]\nnoise = 0.02\n[state.x]\nstart_sigma = 0.2\n")
    table = np.column_stack([T_S, samples()])
    np.savetxt(tmp_path / "rec.csv", table, delimiter=",", header="t_s,x", comments="")
    done = hnav_process(
        "observe",
        fmu,
        "--plan",
        plan,
        "--data",
        tmp_path / "rec.csv",
        "--out",
        tmp_path / "out.csv",
        "--export",
        tmp_path / "o.fmu",
    )
    assert done.returncode == 0 and "80 rows to" in done.stdout, done.stderr
    shown = in_another_process(
        f"""
from hnav.fmi.fmus import Fmu
with Fmu({str(tmp_path / "o.fmu")!r}) as fmu:
    fmu.initialise()
    fmu.do_step(0.0, 0.05)
print("whole")
"""
    )
    assert shown == "whole\n"


def test_an_fmu_that_exists_once_in_a_process(tmp_path):
    binary = compiled(tmp_path, once=True)
    fmu = packed(tmp_path / "once.fmu", binary, attributes='canBeInstantiatedOnlyOncePerProcess="true"')
    observer = Observer(little_plan(fmu))
    assert observer.proof()["derivatives_by_states"].exact
    with pytest.raises(hnav.HnavError, match="once.fmu can exist only once in a process"):
        Observer(little_plan(fmu))
    del observer
    assert Observer(little_plan(fmu)).info().begun is False


# --------------------------------------------------------------------------------------------- refusals


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            {"interface": "CoSimulation"},
            "offers Co-Simulation only and cannot get and set its state .canGetAndSetFMUstate.: export it for Model Exchange, or write its "
            "derivatives as functions",
        ),
        ({"interface": "Nothing"}, "offers neither Model Exchange nor Co-Simulation"),
        ({"folder": "win64"}, r"has no binary for linux64 \(it has win64\)"),
        ({"attributes": 'needsExecutionTool="true"'}, "needs its tool at run time"),
        ({"indicators": 2}, "it has 2 state events and cannot save its state .canGetAndSetFMUstate.: export it with that"),
        ({"derivatives": ""}, "has no continuous states: there is nothing to estimate"),
        ({"derivatives": '<Unknown index="1"/>'}, "names a derivative whose state cannot be found"),
        ({"variables": VARIABLES.replace('name="z" ', 'name="z" variability="discrete" ')}, r"discrete variables \(z\)"),
        ({"variables": "<"}, "has a modelDescription.xml that cannot be read"),
    ],
)  # fmt: skip
def test_an_fmu_is_refused_with_a_sentence(little_binary, tmp_path, change, said):
    with pytest.raises(hnav.HnavValueError, match=said):
        Plan(packed(tmp_path / "other.fmu", little_binary, **change))


def test_events_that_change_nothing_are_taken_when_the_user_says_so(little_binary, tmp_path):
    fmu = packed(tmp_path / "other.fmu", little_binary, indicators=2, derivatives=DERIVATIVES)
    plan = Plan(fmu, memoryless=True).sensor("x", noise=0.02).state("v", start_sigma=0.5)
    assert Observer(plan).run(T_S, {"x": samples()}).dropped == 0


def test_files_that_are_no_fmus(tmp_path):
    with pytest.raises(hnav.HnavValueError, match="cannot be read"):
        Plan(tmp_path / "missing.fmu")
    (tmp_path / "text.fmu").write_text("text")
    with pytest.raises(hnav.HnavValueError, match="it is no zip archive"):
        Plan(tmp_path / "text.fmu")


def test_plants_of_others_are_refused_by_what_they_are(plants):
    for name, said in {
        "fmi2/Stair": "no continuous states",
        "fmi3/Feedthrough": "no continuous states",
        "fmi3/StateSpace": r"has an array for a state \(x\)",
        "fmi2/Resource": "no continuous states",
    }.items():
        with pytest.raises(hnav.HnavValueError, match=said):
            Plan(plants / f"{name}.fmu")
    with pytest.raises(hnav.HnavValueError, match="mu is fixed: it cannot be estimated; export it as tunable"):
        Plan(plants / "fmi2/VanDerPol.fmu").parameter("mu", start_sigma=1)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda p: p.sensor("xx", noise=1), "has no variable 'xx'"),
        (lambda p: p.sensor("on", noise=1), "on is Boolean: a sensor must be real"),
        (lambda p: p.sensor("x", noise=1, unit="s"), "x is in m, which s cannot be converted to"),
        (lambda p: p.sensor("x", noise=1, unit="inch"), "does not say what inch is"),
        (lambda p: p.input("x"), "x is no input but output; inputs: u, d"),
        (lambda p: p.state("u", noise=1), "the plant has no state 'u'; it has x, v"),
        (lambda p: p.set("z", 1), "z has no start value"),
        (lambda p: p.sensor("x", noise=0), "noise of x is 0: it must be above 0"),
        (lambda p: p.state("x", noise=-1), "noise of x is -1: it must be at least 0"),
        (lambda p: Observer(p.sensor("x", noise=1)), "every start_sigma is 0 and there is no noise"),
        (lambda p: Observer(p.state("x", start_sigma=1)), "no sensor is named"),
    ],
)
def test_a_plan_is_refused_with_a_sentence(little_fmu, call, said):
    with pytest.raises(hnav.HnavValueError, match=said):
        call(Plan(little_fmu))


def test_folders_that_are_empty_are_no_files(little_fmu, tmp_path):
    """Archives of some tools list folders, empty ones too."""
    fmu, poor = tmp_path / "folders.fmu", tmp_path / "poor.fmu"
    for path, left_out in ((fmu, ""), (poor, "binaries/linux64/")):
        with zipfile.ZipFile(little_fmu) as archive, zipfile.ZipFile(path, "w") as made:
            for folder in ("binaries/", "binaries/win32/", "binaries/linux64/", "resources/", "resources/empty/"):
                made.writestr(folder, "")
            for name in archive.namelist():
                if not left_out or not name.startswith(left_out):
                    made.writestr(name, archive.read(name))
    assert Observer(little_plan(fmu)).run(T_S[:5], {"x": samples()[:5]}).dropped == 0
    assert little_plan(fmu).export(tmp_path / "o.fmu") == []
    with pytest.raises(hnav.HnavValueError, match=r"has no binary for linux64 \(it has none\)"):
        little_plan(poor)


def test_an_fmu_that_calls_exit_is_named_also_where_it_says_that_all_is_well(tmp_path):
    fmu = packed(tmp_path / "exits.fmu", compiled(tmp_path, define=("EXITS",)))
    done = hnav_process("observe", fmu)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "exits.fmu called exit(0), and took its process with it: ask its maker" in done.stderr


ENDLESS = """import hnav

def rates(t, x, u, p):
    open("loops", "w").close()
    while True:
        pass

plant = hnav.Plant(rates, lambda t, x, u, p: x[0], states={"x": 1.0}, sensors=["x"])
"""


@pytest.mark.parametrize(
    "name, said", [("endless.fmu", "endless.fmu did not come back within 2 s"), ("endless.py", "interrupted")]
)
def test_a_plant_that_loops_for_ever_ends_by_an_interrupt(tmp_path, name, said):
    if name.endswith(".fmu"):
        packed(tmp_path / name, compiled(tmp_path, define=("ENDLESS",)))
    else:
        (tmp_path / name).write_text(ENDLESS)
    states = ["x", "v"] if name.endswith(".fmu") else ["x"]
    plan = ["[sensor.x]", "noise = 0.02", *(line for state in states for line in (f"[state.{state}]", "start_sigma = 0.2"))]
    (tmp_path / "plan.toml").write_text("\n".join(plan))
    command = [sys.executable, "-m", "hnav", "observe", name, "--plan", "plan.toml"]
    surroundings = os.environ | {"LITTLE_LOOPS": "loops"}
    with subprocess.Popen(
        command,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        cwd=tmp_path,
        env=surroundings,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # a shell in the background ignores it
    ) as process:
        while not (tmp_path / "loops").exists():
            assert process.poll() is None, process.stderr.read()
            time.sleep(0.05)
        os.killpg(process.pid, signal.SIGINT)
        answer = process.communicate(timeout=60)[1]
    assert (process.returncode, answer.count("\n")) == (130, 1) and said in answer


@pytest.mark.parametrize("kept", [0, 100, 5000])
def test_a_library_that_was_cut_off_is_refused(tmp_path, little_binary, kept):
    cut = tmp_path / "little.so"
    cut.write_bytes(little_binary.read_bytes()[:kept])
    done = hnav_process("observe", packed(tmp_path / "cut.fmu", cut))
    assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
    assert "cut.fmu" in done.stderr


def test_an_fmu_that_unpacks_to_more_than_a_disk_holds_is_refused(tmp_path, little_fmu, monkeypatch):
    monkeypatch.setattr(archive_room, "MOST_BYTES", 1000)
    with pytest.raises(HnavValueError, match="little.fmu: unpacks to more than 0 MB; ask its maker for a smaller one"):
        Observer(little_plan(little_fmu))
