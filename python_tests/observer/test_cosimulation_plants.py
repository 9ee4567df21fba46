"""FMUs that offer Co-Simulation only: sigma points pass through their steps."""

import json
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest

import hnav
from command_line import hnav as command
from hnav.filters.observer import Observer
from hnav.fmi.fmus import Fmu
from importers import run_omsimulator, run_pyfmi_script
from importing import assert_fits_the_standard
from observer.little_fmu import compiled
from observer.test_exported_fmus import state_calls
from observer.test_exported_in_importers import PYFMI

STATE = 'canGetAndSetFMUstate="true"'
CAPABLE = f'{STATE} canSerializeFMUstate="true" canHandleVariableCommunicationStepSize="true"'
DESCRIPTION_2 = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Steps" guid="{{steps}}">
<CoSimulation modelIdentifier="steps_fmu" {capable}/>
<DefaultExperiment stepSize="0.01"/>
<ModelVariables>
<ScalarVariable name="x" valueReference="0" causality="output" initial="exact"><Real start="1"/></ScalarVariable>
<ScalarVariable name="v" valueReference="1" initial="exact"><Real start="0"/></ScalarVariable>
<ScalarVariable name="der(x)" valueReference="2"><Real derivative="1"/></ScalarVariable>
<ScalarVariable name="der(v)" valueReference="3"><Real derivative="2"/></ScalarVariable>
<ScalarVariable name="k" valueReference="4" causality="parameter" variability="tunable"><Real start="4"/></ScalarVariable>
<ScalarVariable name="u" valueReference="5" causality="input"><Real start="0"/></ScalarVariable>
<ScalarVariable name="y" valueReference="6" causality="output"><Real/></ScalarVariable>
<ScalarVariable name="late" valueReference="7" causality="output"><Real/></ScalarVariable>
<ScalarVariable name="wall" valueReference="8" causality="parameter" variability="fixed"><Real start="0"/></ScalarVariable>
<ScalarVariable name="mode" valueReference="9" causality="parameter" variability="fixed"><Real start="0"/></ScalarVariable>
<ScalarVariable name="sine" valueReference="10" causality="parameter" variability="fixed"><Real start="0"/></ScalarVariable>
</ModelVariables>
<ModelStructure><Outputs><Unknown index="1"/><Unknown index="7"/><Unknown index="8"/></Outputs>
<Derivatives><Unknown index="3"/><Unknown index="4"/></Derivatives></ModelStructure>
</fmiModelDescription>
"""
DESCRIPTION_3 = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="Steps" instantiationToken="{{steps}}">
<CoSimulation modelIdentifier="steps_fmu" {capable}/>
<DefaultExperiment stepSize="0.01"/>
<ModelVariables>
<Float64 name="time" valueReference="11" causality="independent"/>
<Float64 name="x" valueReference="0" causality="output" initial="exact" start="1"/>
<Float64 name="v" valueReference="1" initial="exact" start="0"/>
<Float64 name="der(x)" valueReference="2" derivative="0"/>
<Float64 name="der(v)" valueReference="3" derivative="1"/>
<Float64 name="k" valueReference="4" causality="parameter" variability="tunable" start="4"/>
<Float64 name="u" valueReference="5" causality="input" start="0"/>
<Float64 name="y" valueReference="6" causality="output"/>
<Float64 name="late" valueReference="7" causality="output"/>
<Float64 name="wall" valueReference="8" causality="parameter" variability="fixed" start="0"/>
<Float64 name="mode" valueReference="9" causality="parameter" variability="fixed" start="0"/>
<Float64 name="sine" valueReference="10" causality="parameter" variability="fixed" start="0"/>
</ModelVariables>
<ModelStructure><Output valueReference="0"/><Output valueReference="6"/><Output valueReference="7"/>
<ContinuousStateDerivative valueReference="2"/><ContinuousStateDerivative valueReference="3"/></ModelStructure>
</fmiModelDescription>
"""
T_S = np.arange(100) * 0.1
NOISE = np.array([0.0, 0.05])  # densities


@pytest.fixture(scope="module")
def binaries(tmp_path_factory):
    """By the version of FMI."""
    source = Path(__file__).with_name("steps_fmu.c")
    return {fmi: compiled(tmp_path_factory.mktemp("steps"), source=source, define=("FMI3",) * (fmi == 3)) for fmi in (2, 3)}


@pytest.fixture(scope="module", params=[2, 3])
def pack(request, binaries, tmp_path_factory):
    def made(capable=CAPABLE):
        path = tmp_path_factory.mktemp("steps") / "steps.fmu"
        if request.param == 2:
            description, folder = DESCRIPTION_2.format(capable=capable), "linux64"
        else:
            description, folder = DESCRIPTION_3.format(capable=capable.replace("FMUstate", "FMUState")), "x86_64-linux"
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("modelDescription.xml", description)
            archive.write(binaries[request.param], f"binaries/{folder}/steps_fmu.so")
        return path

    return made


@pytest.fixture(scope="module")
def steps(pack):
    return pack()


def plan_of(fmu, noise=0.05, **values):
    plan = hnav.Plan(fmu).sensor("x", noise=noise).state("x", start_sigma=0.2).state("v", start_sigma=0.3, noise=NOISE[1])
    for name, value in values.items():
        plan.set(name, value)
    return plan


def one_step(x, broken=False, k=4.0, u=0.0, wall=False, sine=False, steps=100):
    """The step of steps_fmu.c."""
    for _ in range(steps):
        pull = np.sin(x[0]) if sine else x[0]
        x = x + 1e-3 * np.array([x[1], -(k / 2 if broken else k) * pull - 0.3 * x[1] + u])
        if wall and x[0] < -0.9 and x[1] < 0:
            x[1], broken = -x[1], True
    return x, broken


def simulated(seed, k=4.0, n=100, sine=False, wall=False, drive=1.0):
    """True states, driven by the noise of the plan, and samples."""
    rng = np.random.default_rng(seed)
    x, broken, rows = np.array([1.0, 0.0]) + [0.2, 0.3] * rng.normal(size=2), False, []
    for i in range(n):
        if i:
            x = x + 0.5**0.5 * drive * NOISE * np.sqrt(0.1) * rng.normal(size=2)
            x, broken = one_step(x, broken, k=k, sine=sine, wall=wall)
            x = x + 0.5**0.5 * drive * NOISE * np.sqrt(0.1) * rng.normal(size=2)
        rows.append(x)
    return np.array(rows), np.array(rows)[:, 0] + 0.05 * rng.normal(size=n)


def kalman(y, F, Q, H, R, x, P):
    """States and covariances of a Kalman filter at each sample; half of the process noise is added before an interval, half after it."""
    rows = []
    for k, value in enumerate(y):
        if k:
            x, P = F @ x, F @ (P + Q / 2) @ F.T + Q / 2
        S = H @ P @ H + R
        K = P @ H / S
        x, P = x + K * (value - H @ x), P - np.outer(K, K) * S
        rows.append((x, P))
    return rows


@pytest.mark.parametrize("sensor", ["x", "y"])
def test_of_a_linear_plant_it_is_a_kalman_filter(steps, sensor):
    truth, y = simulated(1)
    y, H = (y, np.array([1.0, 0.0])) if sensor == "x" else (y + truth[:, 1], np.array([1.0, 1.0]))
    plan = hnav.Plan(steps).sensor(sensor, noise=0.05).state("x", start_sigma=0.2).state("v", start_sigma=0.3, noise=NOISE[1])
    run = Observer(plan).run(T_S, {sensor: y})
    F = np.linalg.matrix_power(np.eye(2) + 1e-3 * np.array([[0, 1], [-4, -0.3]]), 100)
    rows = kalman(y, F, 0.1 * np.diag(NOISE**2), H, 0.05**2, np.array([1.0, 0.0]), np.diag([0.04, 0.09]))
    for k, (x, P) in enumerate(rows):
        e, found = truth[k] - x, truth[k] - [run.x["x"][k], run.x["v"][k]]
        assert np.abs(e - found) == pytest.approx(0, abs=1e-6 * np.sqrt(P[1, 1]))
        assert found @ np.linalg.solve(run.covariance[k], found) == pytest.approx(e @ np.linalg.solve(P, e), rel=1e-6, abs=1e-6)
    assert run.dropped == run.held == 0 and run.ready[-1]


@pytest.mark.parametrize("fmi", [2, 3])
def test_fmus_of_other_makers(plants, tmp_path, fmi):
    """Dahlquist's x' = -x in steps of .1 s beside a Kalman filter; states of BouncingBall cannot be set between steps."""
    dahlquist, ball = (
        only_cosimulation(plants / f"fmi{fmi}/{name}.fmu", tmp_path / f"{name}.fmu") for name in ("Dahlquist", "BouncingBall")
    )
    t_s, y = np.arange(50) * 0.2, np.exp(-np.arange(50) * 0.2) + 0.05 * np.random.default_rng(1).normal(size=50)
    run = Observer(hnav.Plan(dahlquist).sensor("x", noise=0.05).state("x", start_sigma=0.3, noise=0.1)).run(t_s, {"x": y})
    one = np.eye(1)
    for k, (x, P) in enumerate(kalman(y, 0.81 * one, 0.002 * one, np.ones(1), 0.05**2, np.ones(1), 0.09 * one)):
        assert run.x["x"][k] == pytest.approx(x[0], abs=1e-6 * run.sigma["x"][k])
        assert run.sigma["x"][k] ** 2 == pytest.approx(P[0, 0], rel=1e-6)
    with pytest.raises(
        hnav.HnavError,
        match="offers Co-Simulation only, and its states cannot be set between steps: .*Variable .h. can only be set",
    ):
        Observer(hnav.Plan(ball).sensor("h", noise=0.1).state("h", start_sigma=0.1))


def only_cosimulation(fmu, path):
    with zipfile.ZipFile(fmu) as archive, zipfile.ZipFile(path, "w") as made:
        for entry in archive.infolist():
            data = archive.read(entry)
            if entry.filename == "modelDescription.xml":
                root = ElementTree.fromstring(data)
                root.remove(root.find("ModelExchange"))
                data = ElementTree.tostring(root)
            made.writestr(entry, data)
    return path


def test_a_nonlinear_plant_with_an_unknown_parameter_states_its_errors(steps):
    nees, rng = [], np.random.default_rng(5)
    for seed in range(20):
        k = 4 + 0.3 * rng.normal()
        truth, y = simulated(seed, k=k, n=60, sine=True)
        run = Observer(plan_of(steps, sine=1).parameter("k", start_sigma=0.3)).run(T_S[:60], {"x": y})
        e = np.column_stack([truth - np.column_stack([run.x["x"], run.x["v"]]), k - run.x["k"]])
        nees.append(np.mean([row @ np.linalg.solve(P, row) for row, P in zip(e, run.covariance)]) / 3)
    assert 0.8 < np.mean(nees) < 1.3


def test_what_only_the_fmu_remembers_goes_on_along_the_estimate(steps):
    """Its spring is half as stiff after the wall; a plant without the wall does not follow."""
    truth, y = simulated(3, wall=True)
    assert one_step(np.array([-0.89, -1.0]), wall=True)[1]
    follows, other = (Observer(plan_of(steps, wall=wall)).run(T_S, {"x": y}) for wall in (1, 0))
    last = slice(50, None)
    rms = [np.sqrt(np.mean((run.x["v"][last] - truth[last, 1]) ** 2)) for run in (follows, other)]
    assert rms[0] < 0.1 < 0.3 < rms[1]


@pytest.mark.parametrize("capable", [CAPABLE, CAPABLE.replace('canSerializeFMUstate="true" ', "")])
def test_times_of_output_and_late_samples_change_no_bit(pack, capable):
    _, y = simulated(3, wall=True)
    plan = plan_of(pack(capable), wall=1).input("u")
    u = 0.2 * np.sin(T_S)
    expected = Observer(plan).run(T_S, {"x": y}, {"u": u})
    observer = Observer(plan, horizon_s=0.5)
    for k, t in enumerate(T_S):
        observer.push_input("u", t, u[k])
        observer.push("x", t, y[k]) if k % 3 != 1 else None
        observer.advance(t + 0.04 * (k < 99))
        if k % 3 == 2:
            observer.push("x", T_S[k - 1], y[k - 1])
    assert observer.estimate()[0] == {name: x[-1] for name, x in expected.x.items()}


def test_a_saved_state_goes_on_with_the_same_bits(steps):
    _, y = simulated(3, wall=True)
    expected, first, second = (Observer(plan_of(steps, wall=1)) for _ in range(3))
    run = expected.run(T_S, {"x": y})
    first.run(T_S[:40], {"x": y[:40]})
    second.load(first.save())
    assert np.array_equal(second.run(T_S[40:], {"x": y[40:]}).x["v"], run.x["v"][40:])


def test_a_recording_is_smoothed(steps):
    truth, y = simulated(7)
    run, smooth = (of(T_S, {"x": y}) for of in (Observer(plan_of(steps)).run, Observer(plan_of(steps)).smooth))
    rms = [np.sqrt(np.mean((one.x["v"] - truth[:, 1]) ** 2)) for one in (run, smooth)]
    assert rms[1] < 0.8 * rms[0] and (smooth.sigma["v"] <= run.sigma["v"] + 1e-12).all()


def test_steps_that_fail_are_held(steps):
    _, y = simulated(2)
    run = Observer(plan_of(steps, mode=3)).run(T_S, {"x": y})
    assert run.held > 0 and not run.ready[-1] and "the spring broke" in run.dropped_because
    assert np.isfinite(run.x["v"]).all() and run.sigma["v"][-1] > run.sigma["v"][5]


@pytest.mark.parametrize(
    ("capable", "said"),
    [
        ("", "offers Co-Simulation only and cannot get and set its state .canGetAndSetFMUstate.: export it for Model Exchange"),
        (STATE, "with steps of one length .canHandleVariableCommunicationStepSize."),
    ],
)
def test_a_capability_that_is_missing_is_named(pack, capable, said):
    with pytest.raises(hnav.HnavValueError, match=said):
        hnav.Plan(pack(capable))


def test_states_and_sensors_that_steps_alone_compute_are_refused(steps):
    with pytest.raises(hnav.HnavError, match="its states cannot be set between steps: .*not between steps; export it for Model"):
        Observer(plan_of(steps, mode=1))
    with pytest.raises(hnav.HnavError, match="its sensor 0 does not follow its states between steps: take a state as sensor"):
        Observer(hnav.Plan(steps).sensor("late", noise=0.1).state("x", start_sigma=1))


@pytest.fixture(scope="module", params=[2, 3])
def exported(request, steps, tmp_path_factory):
    """The version of FMI, and the exported observer of a spring behind a wall."""
    path = tmp_path_factory.mktemp("exported") / "observer.fmu"
    assert plan_of(steps, wall=1).export(path, request.param, period_s=0.1) == []
    return request.param, path


def step_through(fmu, y, begin, end, parts=1):
    for k in range(begin, end):
        fmu.set("x.value", y[k])
        fmu.set("x.t_meas", T_S[k])
        fmu.set("x.sample", k + 1)
        for part in range(parts):
            fmu.do_step(T_S[k] + part * 0.1 / parts, 0.1 / parts)


def test_an_exported_observer_has_the_same_bits_on_every_grid(exported, steps):
    version, path = exported
    _, y = simulated(3, wall=True)
    observer = Observer(plan_of(steps, wall=1))
    for k in range(60):
        observer.push("x", T_S[k], y[k])
        observer.advance(T_S[k] + 0.1)
    with Fmu(path) as one, Fmu(path) as other:
        for fmu, parts in ((one, 1), (other, 4)):
            fmu.set("sampling_mode", "counter")
            fmu.initialise()
            step_through(fmu, y, 0, 60, parts)
        assert {name: one.get(f"est.{name}") for name in "xv"} == observer.estimate()[0]
        assert {name: one.get(f"sigma.{name}") for name in "xv"} == observer.estimate()[1]
        posteriors = [[fmu.get(f"{of}.{name}") for of in ("post", "post_sigma") for name in "xv"] for fmu in (one, other)]
        assert posteriors[0] == posteriors[1] and one.get("count.held") == one.get("count.dropped") == 0


def test_an_exported_observer_is_saved_with_what_its_plant_remembers(exported):
    version, path = exported
    _, y = simulated(3, wall=True)
    with Fmu(path) as one, Fmu(path) as other:
        for fmu in (one, other):
            fmu.set("sampling_mode", "counter")
        one.initialise()
        step_through(one, y, 0, 30)
        take, to_bytes, _, _ = state_calls(one)
        content = to_bytes(take())
        step_through(one, y, 30, 60)
        _, _, from_bytes, put = state_calls(other)
        put(from_bytes(content))
        step_through(other, y, 30, 60)
        assert [one.get(f"est.{name}") for name in "xv"] == [other.get(f"est.{name}") for name in "xv"]


def test_an_exported_observer_offers_what_its_plant_offers(exported, tmp_path):
    version, path = exported
    assert_fits_the_standard(path, version)
    with zipfile.ZipFile(path) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
        sizes = archive.read("resources/variables.txt").decode().splitlines()[1]
    assert root.find("CoSimulation") is not None and root.find("ModelExchange") is None and sizes == "sizes 2 0 0 0 1 0"
    claims = with_model_exchange(path, tmp_path / "claims.fmu")
    with Fmu(claims, model_exchange=True) as fmu, pytest.raises(hnav.HnavError, match="import it for Co-Simulation"):
        fmu.initialise()


def with_model_exchange(fmu, path):
    with zipfile.ZipFile(fmu) as archive, zipfile.ZipFile(path, "w") as made:
        for name in archive.namelist():
            data = archive.read(name)
            if name == "modelDescription.xml":
                data = data.replace(b"  <CoSimulation", b'  <ModelExchange modelIdentifier="Observer"/>\n  <CoSimulation')
            made.writestr(name, data)
    return path


@pytest.mark.parametrize("exported", [2], indirect=True)
def test_an_exported_observer_in_pyfmi(exported, tmp_path):
    _, path = exported
    _, y = simulated(3, wall=True)
    outputs = [f"{of}.{name}" for of in ("est", "post", "sigma") for name in "xv"]
    (tmp_path / "given.json").write_text(json.dumps({"samples": list(y[:40]), "step_s": 0.125, "outputs": outputs}))
    answer = run_pyfmi_script(PYFMI, (str(path),), tmp_path)
    with Fmu(path) as fmu:
        fmu.initialise()
        for k in range(40):
            fmu.set("x.value", y[k])
            fmu.do_step(k * 0.125, 0.125)
        assert answer["errors"] == [] and answer["ends"] == {name: fmu.get(name) for name in outputs}


def test_on_the_command_line(steps, tmp_path):
    plan, data, out = tmp_path / "plan.toml", tmp_path / "data.csv", tmp_path / "out.csv"
    listed = command("observe", steps)
    assert listed.returncode == 0 and "Co-Simulation only" in listed.stdout
    plan.write_text(
        '[plant]\nfmu = "x"\n[sensor.x]\nnoise = 0.05\n[state.x]\nstart_sigma = 0.2\n[state.v]\nstart_sigma = 0.3\nnoise = 0.05\n'
    )
    truth, y = simulated(1)
    pd.DataFrame({"t_s": T_S, "x": y}).to_csv(data, index=False)
    done = command("observe", steps, "--plan", plan, "--data", data, "--out", out)
    assert done.returncode == 0, done.stderr
    assert np.sqrt(np.mean((pd.read_csv(out, comment="#")["v"] - truth[:, 1]) ** 2)) < 0.1


def test_an_exported_observer_in_omsimulator(exported, tmp_path):
    """Its sample stays at its start; the plant goes on."""
    _, path = exported
    outputs = [f"{of}.{name}" for of in ("est", "post", "sigma") for name in "xv"]
    row = run_omsimulator(path, tmp_path, 4.0, "--stopTime=5", "--stepSize=0.1", "--mode=cs")
    with Fmu(path) as fmu:
        fmu.initialise()
        for k in range(40):
            fmu.do_step(0.1 * k, 0.1)
        expected = {name: fmu.get(name) for name in outputs}
    assert {name: row[name] for name in outputs} == pytest.approx(expected, rel=1e-9, abs=1e-12)
    assert row["count.x.used"] == 40 and row["est.v"] != 0
