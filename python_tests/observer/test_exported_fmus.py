"""Exported observers: bit-equal estimates, failing plants, and refused exports."""

import ctypes as C
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest

import hnav
from checkout import in_another_process
from command_line import hnav as command
from hnav.filters.observer import Observer
from hnav.fmi.fmus import Fmu
from importing import assert_fits_the_standard, ecos
from observer.little_fmu import VARIABLES, compiled, packed
from observer.test_fmu_plants import T_S, little_plan, samples, spring_plan
from observer.test_plan_files import TEXT
from studies.observer.size import rod_fmu

VERSIONS = (2, 3)
versions = pytest.mark.parametrize("version", VERSIONS, ids=lambda v: f"fmi{v}")
STEP_S = 0.05
COUNT = 64  # the most


def whole_plan(fmu, mode="sound"):
    plan = little_plan(fmu, mode).parameter("k", start_sigma=0.5)
    return plan.unknown_input("d", start_sigma=0.1, noise=0.01)


@pytest.fixture(scope="session")
def exported(little_fmu, tmp_path_factory) -> dict[int, Path]:
    """Observers of all states, inputs and parameters of the little FMU."""
    paths = {version: tmp_path_factory.mktemp(f"fmi{version}") / "little_observer.fmu" for version in VERSIONS}
    for version, path in paths.items():
        assert whole_plan(little_fmu).export(path, version, period_s=STEP_S) == []
    return paths


def estimates(fmu: Fmu, prefix: str = "est") -> list[float]:
    return [fmu.get(f"{prefix}.{name}") for name in ("x", "v", "d", "k")]


def deliver(fmu: Fmu, k: int) -> None:
    """Sample k of the sensor; its input changes every second."""
    fmu.set("x.value", samples()[k])
    fmu.set("u.value", float(np.sin(T_S[k - k % 20])))
    for name in ("x", "u"):
        fmu.set(f"{name}.t_meas", T_S[k])
        fmu.set(f"{name}.sample", k + 1 if name == "x" else k // 20 + 1)


def run(fmu: Fmu, end: int, begin: int = 0, parts: int = 1) -> None:
    """Counted samples from one instant to another, in parts of their interval."""
    for k in range(begin, end):
        deliver(fmu, k)
        for part in range(parts):
            fmu.do_step(T_S[k] + part * STEP_S / parts, STEP_S / parts)


def state_calls(fmu: Fmu):
    f = fmu.fmu
    if fmu.fmi3:
        return f.getFMUState, f.serializeFMUState, f.deserializeFMUState, f.setFMUState
    return f.getFMUstate, f.serializeFMUstate, f.deSerializeFMUstate, f.setFMUstate


# --------------------------------------------------------------------------------------------- laws


@versions
def test_it_fits_the_standard_and_holds_plant_and_licences(exported, version):
    assert_fits_the_standard(exported[version], version)
    with zipfile.ZipFile(exported[version]) as archive:
        names = set(archive.namelist())
    assert {
        "resources/plant/binaries/linux64/little.so",
        "resources/plant/observer.plan",
        "documentation/licenses/license.txt",
    } <= names


@versions
def test_equal_plans_give_equal_bytes(exported, little_fmu, tmp_path, version):
    whole_plan(little_fmu).export(tmp_path / "again.fmu", version, period_s=STEP_S)
    assert (tmp_path / "again.fmu").read_bytes() == exported[version].read_bytes()


@versions
def test_it_is_the_observer_bit_for_bit_on_every_grid(exported, little_fmu, version):
    observer, expected = Observer(whole_plan(little_fmu)), []
    for k in range(60):
        if k % 20 == 0:
            observer.push_input("u", T_S[k], float(np.sin(T_S[k])))
        observer.push("x", T_S[k], samples()[k])
        observer.advance(T_S[k] + STEP_S)
        expected.append(list(observer.estimate()[0].values()))
    with Fmu(exported[version]) as one, Fmu(exported[version]) as other:
        for fmu, parts in ((one, 1), (other, 3)):
            fmu.set("sampling_mode", "counter")
            fmu.initialise()
            run(fmu, 59, parts=parts)
        assert estimates(one, "post") == estimates(other, "post")
        assert [one.get(f"post_sigma.{name}") for name in "xv"] == [other.get(f"post_sigma.{name}") for name in "xv"]
        run(one, 60, begin=59)
        assert estimates(one) == expected[-1]
        assert [one.get(f"sigma.{name}") for name in "xvdk"] == list(observer.estimate()[1].values())
        P = observer.covariance()
        assert [one.get(f"cov[{i + 1},{j + 1}]") for i in range(4) for j in range(i, 4)] == list(P[np.triu_indices(4)])
        assert (one.get("count.x.used"), one.get("count.corrections"), one.get("count.missed")) == (60, 60, 0)
        assert one.get("post.t") == T_S[59] and one.messages == []


@versions
def test_an_offset_of_a_sensor_is_a_parameter(little_fmu, tmp_path, version):
    """It was lost, and the estimate was off by it."""
    plan = whole_plan(little_fmu).sensor("x", noise=0.02, offset=0.25)
    plan.export(tmp_path / "offset.fmu", version, period_s=STEP_S)
    observer = Observer(plan)
    end = T_S[39] + STEP_S
    expected = observer.run(
        np.append(T_S[:40], end), {"x": np.append(samples()[:40], np.nan)}, {"u": np.append(np.sin(T_S[:40]), np.nan)}
    )
    with Fmu(tmp_path / "offset.fmu") as fmu:
        assert fmu.get("x.offset") == 0.25
        fmu.set("sampling_mode", "counter")
        fmu.initialise()
        for k in range(40):
            deliver(fmu, k)
            fmu.set("u.value", float(np.sin(T_S[k])))
            fmu.set("u.sample", k + 1)
            fmu.do_step(T_S[k], STEP_S)
        assert estimates(fmu) == pytest.approx([expected.x[name][-1] for name in ("x", "v", "d", "k")], abs=1e-9)


@versions
def test_an_integrator_of_the_importer_finds_the_same(exported, version):
    with Fmu(exported[version]) as steps, Fmu(exported[version], model_exchange=True) as exchange:
        for fmu in (steps, exchange):
            fmu.set("sampling_mode", "counter")
            fmu.initialise()
        solver = exchange.solver(0.0)
        for k in range(40):
            deliver(steps, k)
            deliver(exchange, k)
            steps.do_step(T_S[k], STEP_S)
            exchange.update_discrete_states()
            exchange.call(exchange.fmu.enterContinuousTimeMode)
            solver.reset(T_S[k])
            solver.step(T_S[k], T_S[k + 1])
            exchange.call(exchange.fmu.setTime, T_S[k + 1])
            exchange.call(exchange.fmu.enterEventMode)
        sigma = np.array([steps.get(f"sigma.{name}") for name in "xvdk"])
        assert np.abs((np.array(estimates(steps)) - estimates(exchange)) / sigma).max() < 1e-3
        assert np.abs([exchange.get(f"sigma.{name}") for name in "xvdk"] / sigma - 1).max() < 1e-3
        assert exchange.get("count.x.used") == 40


@versions
def test_a_state_that_is_not_declared_as_a_dependency_changes_nothing(exported, version):
    with Fmu(exported[version], model_exchange=True) as fmu:
        fmu.set("sampling_mode", "counter")
        fmu.initialise()
        deliver(fmu, 0)
        fmu.update_discrete_states()
        fmu.call(fmu.fmu.enterContinuousTimeMode)
        fmu.call(fmu.fmu.setTime, T_S[0] + 0.2 * STEP_S)
        states = [v.derivative.valueReference for v in fmu.description.modelVariables if v.derivative is not None]
        listed = [*fmu.description.outputs, *fmu.description.derivatives]
        real = [u for u in listed if u.variable.type in ("Real", "Float64")]
        references = fmu.references(u.variable.name for u in real)
        named = [{d.valueReference for d in u.dependencies} for u in real]
        declared = np.array([[k in known for k in states] for known in named])

        def values(x):
            fmu.fmu.setContinuousStates((C.c_double * len(x))(*x), len(x))
            out = (C.c_double * len(real))()
            fmu.crossing("Get", "real", references, out)()
            return np.array(out)

        x = np.random.default_rng(1).uniform(0.01, 0.02, len(states))
        changed = np.stack([values(x + step) != values(x) for step in 0.01 * np.eye(len(x))], axis=1)
        assert not (changed & ~declared).any()
        # The last one is the clock, which this plant does not read.
        assert changed[:, :-1].any(axis=0).all() and changed.sum() > 0.3 * declared.sum()
        assert declared[-len(states) :].mean() < 0.6


@versions
def test_a_saved_state_goes_on_in_another_instance(exported, version):
    with Fmu(exported[version]) as one, Fmu(exported[version]) as other:
        for fmu in (one, other):
            fmu.set("sampling_mode", "counter")
        one.initialise()
        run(one, 20)
        take, to_bytes, _, _ = state_calls(one)
        content = to_bytes(take())
        run(one, 40, begin=20)
        _, _, from_bytes, put = state_calls(other)
        put(from_bytes(content))
        run(other, 40, begin=20)
        assert estimates(one) == estimates(other)
        assert one.get("count.x.used") == other.get("count.x.used") == 40


@versions
def test_parameters_are_those_of_the_plan(little_fmu, tmp_path, version):
    """Setting a noise of the FMU equals a plan with that noise; samples have the plant's units."""
    first = little_plan(little_fmu).sensor("x", noise=20.0, unit="mm")
    first.export(tmp_path / "first.fmu", version, period_s=STEP_S)
    other = Observer(little_plan(little_fmu).sensor("x", noise=0.07).state("v", start=0.3, start_sigma=0.4, noise=0.2), rtol=1e-6)
    for k in range(20):
        other.push_input("u", k * STEP_S, 0.0)
        other.push("x", k * STEP_S, samples()[k])
        other.advance(k * STEP_S + STEP_S)
    with Fmu(tmp_path / "first.fmu") as fmu:
        assert float(fmu.variables["x.noise"].start) == pytest.approx(0.02)
        for name, value in {"x.noise": 0.07, "start.v": 0.3, "start_sigma.v": 0.4, "noise.v": 0.2, "solver.rtol": 1e-6}.items():
            fmu.set(name, value)
        fmu.initialise()
        for k in range(20):
            fmu.set("x.value", samples()[k])
            fmu.do_step(k * STEP_S, STEP_S)
        # Steps add up to times that differ from products in the last bit.
        assert fmu.get("est.v") == pytest.approx(other.estimate()[0]["v"], rel=1e-9)
        assert fmu.get("sigma.v") == pytest.approx(other.estimate()[1]["v"], rel=1e-9)


@versions
def test_bounds_cut_a_start_once(little_fmu, tmp_path, version):
    """The mean of a start that bounds cut is not the start that they cut."""
    plan = little_plan(little_fmu).parameter("k", start_sigma=2.0, min=0.0)
    plan.export(tmp_path / "bounded.fmu", version, period_s=STEP_S)
    observer, of_plant = Observer(plan), plan.plant.variables["k"].start
    assert observer.estimate()[0]["k"] > of_plant + 0.1
    with Fmu(tmp_path / "bounded.fmu") as fmu:
        assert float(fmu.variables["start.k"].start) == of_plant
        fmu.initialise()
        assert fmu.get("est.k") == pytest.approx(observer.estimate()[0]["k"], rel=1e-12)


@versions
def test_estimates_do_not_depend_on_who_reads_them(exported, version):
    """The look-ahead is computed only where it is read."""
    with Fmu(exported[version]) as read, Fmu(exported[version]) as unread:
        for fmu in (read, unread):
            fmu.set("sampling_mode", "counter")
            fmu.initialise()
        for k in range(20):
            run(read, k + 1, begin=k)
            run(unread, k + 1, begin=k)
            estimates(read)
        assert estimates(read) == estimates(unread)
        assert estimates(read, "post") == estimates(unread, "post") != estimates(read)


@versions
def test_reset_restarts(exported, version):
    with Fmu(exported[version]) as fmu:
        fmu.set("sampling_mode", "counter")
        fmu.initialise()
        start = estimates(fmu)
        run(fmu, 20)
        fmu.set("reset", True)
        fmu.do_step(20 * STEP_S, STEP_S)
        assert estimates(fmu) == start and not fmu.get("begun")


# --------------------------------------------------------------------------------------------- hostile surroundings


@pytest.mark.parametrize("mode", ["nan_after_1", "error_after_1", "fatal_after_1"])
def test_a_plant_that_breaks_costs_its_samples_and_is_logged_once(little_fmu, tmp_path, mode):
    little_plan(little_fmu, mode).export(tmp_path / "o.fmu", period_s=STEP_S)
    with Fmu(tmp_path / "o.fmu") as fmu:
        fmu.initialise()
        for k in range(40):
            fmu.set("x.value", samples()[k])
            fmu.do_step(k * STEP_S, STEP_S)
        goes_on = mode == "nan_after_1"  # its sensor does: the estimate is held, and samples are used
        assert fmu.get("count.held") > 10 and not fmu.get("ready")
        assert (fmu.get("count.dropped") > 10) != goes_on and (fmu.get("count.x.used") == 21) != goes_on
        assert np.isfinite(fmu.get("est.v"))
        (sentence,) = fmu.messages
        assert ("was held before" if goes_on else "were dropped: the plant") in sentence


@versions
def test_names_that_are_open_to_all_do_not_reach_the_plant(tmp_path, version):
    """An importer may load FMUs with global symbols: a plant that calls its own functions must not reach those of the observer."""
    fmu = packed(tmp_path / "self.fmu", compiled(tmp_path, calls_itself=True))
    little_plan(fmu).export(tmp_path / "o.fmu", version, period_s=STEP_S)
    code = f"""
import ctypes, glob
from hnav.fmi.fmus import Fmu
with Fmu({str(tmp_path / "o.fmu")!r}) as fmu:
    ctypes.CDLL(glob.glob(str(fmu._folder) + "/binaries/*/Observer.*")[0], mode=ctypes.RTLD_GLOBAL)
    fmu.initialise()
    fmu.set("x.value", 0.9)
    for k in range(10):
        fmu.do_step(0.05 * k, 0.05)
    print(fmu.get("count.x.used"), fmu.messages)
"""
    assert in_another_process(code) == "10 []\n"


def test_numbers_of_the_archive_are_read_in_every_locale(exported):
    """A process that has called setlocale, as programs with windows do, expects a decimal comma in many countries."""
    with zipfile.ZipFile(exported[2]) as archive:
        lines = archive.read("resources/variables.txt").decode().splitlines()[2:-1]
    assert not any("." in number for line in lines for number in line.split()[2:5])
    german = "import locale; locale.setlocale(locale.LC_ALL, 'de_DE.UTF-8')"
    if subprocess.run([sys.executable, "-c", german], capture_output=True).returncode:
        pytest.skip("this machine has no locale with a decimal comma")
    in_another_process(f"{german}; import fmpy; fmpy.simulate_fmu({str(exported[2])!r}, stop_time=0.1)")


@pytest.mark.parametrize(
    ("file", "change", "said"),
    [
        ("resources/variables.txt", lambda t: t.replace("sizes 2", "sizes 3"), "states and derivatives|its index|do not belong"),
        ("resources/variables.txt", lambda t: t.replace("estimate 0", "estimate 9"), "line .*: its index is impossible"),
        ("resources/variables.txt", lambda t: t[: len(t) // 2], "variables.txt, line"),
        ("resources/variables.txt", lambda t: t.replace("est.x", "est.y"), "do not belong together"),
        ("resources/plant/observer.plan", lambda t: t.replace("state 1", "state one"), "observer.plan, line"),
        ("resources/plant/observer.plan", lambda t: t.replace("end\n", "depends 0 x\nend\n"), "observer.plan, line"),
        ("resources/plant/observer.plan", lambda t: t.replace("{little}", "{big}"), "could not be instantiated"),
        ("resources/plant/observer.plan", lambda t: t.replace("little.*", "large.*"), "large.so cannot be loaded"),
    ],
)
def test_a_damaged_archive_is_refused_with_a_sentence(exported, tmp_path, file, change, said):
    with zipfile.ZipFile(exported[2]) as whole, zipfile.ZipFile(tmp_path / "damaged.fmu", "w") as damaged:
        for name in whole.namelist():
            content = whole.read(name)
            damaged.writestr(name, change(content.decode()) if name == file else content)
    with pytest.raises(hnav.HnavError, match=said), Fmu(tmp_path / "damaged.fmu") as fmu:
        fmu.initialise()


@versions
@pytest.mark.parametrize("name", ["body.frame_a.r_0[1]", 'mass <a> & "b"', "überlast", "long." + 30 * "name"])
def test_names_of_plants_are_kept_whatever_they_are(little_binary, tmp_path, version, name):
    quoted = name.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
    fmu = packed(tmp_path / "named.fmu", little_binary, variables=VARIABLES.replace('name="x"', f'name="{quoted}"'))
    hnav.Plan(fmu).sensor(name, noise=0.02).state(name, start_sigma=0.2).export(tmp_path / "o.fmu", version)
    assert_fits_the_standard(tmp_path / "o.fmu", version)
    with Fmu(tmp_path / "o.fmu") as observer:
        observer.initialise()
        observer.set(f"{name}.value", 0.9)
        for k in range(10):
            observer.do_step(0.01 * k, 0.01)
        assert observer.get(f"est.{name}") == pytest.approx(0.9, abs=0.1) and observer.messages == []


@versions
def test_the_folder_that_it_lies_in_may_be_called_anything(exported, tmp_path, monkeypatch, version):
    """FMI 2 passes the folder of resources as a URI, whose escapes are decoded once."""
    folder = tmp_path / "a b %41 ü"
    folder.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    with Fmu(exported[version]) as fmu:
        assert str(folder) in str(fmu._folder)
        fmu.initialise()
        assert fmu.messages == []


def test_a_plant_that_exists_once_makes_an_observer_that_does(tmp_path):
    fmu = packed(tmp_path / "once.fmu", compiled(tmp_path, once=True), attributes='canBeInstantiatedOnlyOncePerProcess="true"')
    little_plan(fmu).export(tmp_path / "o.fmu", 3)
    description = fmpy.read_model_description(str(tmp_path / "o.fmu"))
    assert description.coSimulation.canBeInstantiatedOnlyOncePerProcess
    with Fmu(tmp_path / "o.fmu") as observer:
        observer.initialise()
        observer.do_step(0, 0.01)
        assert observer.messages == []


def test_what_cannot_be_exported_is_said(little_fmu, tmp_path, monkeypatch):
    def refused(said, plan, *arguments, **more):
        with pytest.raises(hnav.HnavValueError, match=said):
            plan.export(tmp_path / "o.fmu", *arguments, **more)
        assert not (tmp_path / "o.fmu").exists()

    refused("functions in Python cannot be put into an FMU: export the model itself", spring_plan())
    refused("fmi_version is 1: it must be 2 or 3", little_plan(little_fmu), 1)
    refused("period_s is 0: it must lie in", little_plan(little_fmu), period_s=0)
    clash = packed(tmp_path / "clash.fmu", compiled(tmp_path), variables=VARIABLES.replace('name="v"', 'name="value"')
                   .replace('name="x" ', 'name="est" '))  # fmt: skip
    refused("would be called est.value: rename one", hnav.Plan(clash).sensor("est", noise=1).state("value", start_sigma=1))
    monkeypatch.setenv("HNAV_FMUS", str(tmp_path))
    refused("Observer.fmu for FMI 2 is not built: ./run fmus makes it", little_plan(little_fmu))
    (tmp_path / "fmi2").mkdir()
    with zipfile.ZipFile(tmp_path / "fmi2" / "Observer.fmu", "w") as shell:
        shell.writestr("binaries/win64/Observer.dll", "")
    refused("has binaries for x86_64-linux, the observer for x86_64-windows: export the plant", little_plan(little_fmu))


# --------------------------------------------------------------------------------------------- importers, command line


@versions
def test_ecos_runs_it(exported, version):
    ecospy = ecos()
    structure = ecospy.EcosSimulationStructure()
    structure.add_model("observer", str(exported[version]))
    structure.add_parameter_set("held", {"observer::x.value": 0.9})
    with ecospy.EcosSimulation(structure=structure, step_size=STEP_S) as simulation:
        simulation.init(parameter_set="held")
        simulation.step(20)
        assert simulation.get_bool("observer::begun") and simulation.get_integer("observer::count.x.used") == 20
        simulation.terminate()


@versions
@pytest.mark.parametrize("kind", ["CoSimulation", "ModelExchange"])
def test_fmpy_simulates_it(exported, version, kind):
    dtype = [("time", float), ("x.value", float)]
    rows = np.array(list(zip(T_S, samples())), dtype)
    result = fmpy.simulate_fmu(
        str(exported[version]), fmi_type=kind, stop_time=2.0, output_interval=STEP_S, input=rows, output=["est.x", "count.x.used"]
    )
    assert result["count.x.used"][-1] >= 39
    assert abs(result["est.x"][-1] - np.interp(2.0, T_S, samples())) < 0.2


def test_the_command_exports(little_fmu, tmp_path):
    plan, fmu = tmp_path / "plan.toml", tmp_path / "o.fmu"
    plan.write_text(TEXT)
    done = command("observe", little_fmu, "--plan", plan, "--export", fmu, "--fmi", 3, "--period", 0.05)
    assert done.returncode == 0, done.stderr
    said, names = done.stdout.splitlines()
    assert said == f"{fmu}: FMI 3, Co-Simulation and Model Exchange; Little and its licences are inside"
    description = fmpy.read_model_description(str(fmu))
    known = {variable.name: variable.causality for variable in description.modelVariables}
    for group in names.split("; "):
        causality, *listed = group.partition(", a sample")[0].replace(",", "").split()
        assert listed and all(known[name] == causality.removesuffix("s") for name in listed)
    assert (description.fmiVersion, description.modelName) == ("3.0", "Observer of Little")
    again = command("observe", little_fmu, "--export", fmu)
    assert again.returncode == 2 and "a plan is missing" in again.stderr
    over = command("observe", little_fmu, "--plan", plan, "--export", little_fmu)
    assert over.returncode == 2 and "is read by this command" in over.stderr


@versions
def test_covariances_are_outputs_on_request(little_fmu, tmp_path, version):
    outputs = {}
    for wanted in (True, False, None):
        path = tmp_path / f"{wanted}.fmu"
        whole_plan(little_fmu).export(path, version, covariance=wanted)
        assert_fits_the_standard(path, version)
        names = [variable.name for variable in fmpy.read_model_description(str(path)).modelVariables]
        outputs[wanted] = [name for name in names if name.startswith("cov[")]
        assert "sigma.k" in names
    assert len(outputs[True]) == len(outputs[None]) == 10 and outputs[False] == []


def test_an_observer_of_many_numbers_has_covariances_too(little_fmu, tmp_path, monkeypatch):
    monkeypatch.setattr("hnav.filters.observer_export.LARGEST_COVARIANCE", 3)
    plan = whole_plan(little_fmu)
    for wanted, count in ((None, 0), (True, 10)):
        plan.export(tmp_path / "o.fmu", 2, covariance=wanted, period_s=STEP_S)
        with Fmu(tmp_path / "o.fmu") as fmu:
            fmu.initialise()
            run(fmu, 3)
            names = [name for name in fmu.variables if name.startswith("cov[")]
            assert len(names) == count
            for i, name in enumerate("xvdk" if count else ""):
                assert fmu.get(f"cov[{i + 1},{i + 1}]") == pytest.approx(fmu.get(f"sigma.{name}") ** 2, rel=1e-12)


@versions
def test_an_observer_of_the_most_numbers_shows_all_of_its_covariance(tmp_path, version):
    plan = hnav.Plan(rod_fmu(tmp_path, COUNT)).sensor("x0", noise=0.05).sensor("x20", noise=0.05)
    for i in range(COUNT):
        plan.state(f"x{i}", start_sigma=0.5, noise=0.1)
    path, observer = tmp_path / "o.fmu", Observer(plan)
    observer.export(path, version, period_s=STEP_S, covariance=True)
    # The schemas take minutes for so many variables, whose kinds other tests hold against them.
    with Fmu(path) as fmu:
        assert len(fmu.variables) == len(fmu.description.modelVariables)
        fmu.initialise()
        for k in range(4):
            for name in ("x0", "x20"):
                fmu.set(f"{name}.value", 0.1 * k)
                observer.push(name, k * STEP_S, 0.1 * k)
            fmu.do_step(k * STEP_S, STEP_S)
            observer.advance((k + 1) * STEP_S)
        P = observer.covariance()
        names = [(i, j) for i in range(COUNT) for j in range(i, COUNT)]
        assert len(names) == 2080
        assert [fmu.get(f"cov[{i + 1},{j + 1}]") for i, j in names] == [P[i, j] for i, j in names]
        assert fmu.get("count.dropped") == 0 and np.isfinite(P).all() and np.linalg.eigvalsh(P).min() > 0


def test_plants_of_others_are_exported(plants, tmp_path):
    for version in VERSIONS:
        plan = hnav.Plan(plants / f"fmi{version}" / "VanDerPol.fmu").sensor("x0", noise=0.05)
        plan.state("x0", start_sigma=1.0, noise=0.01).state("x1", start_sigma=1.0, noise=0.1)
        plan.export(tmp_path / "o.fmu", 5 - version)
        assert_fits_the_standard(tmp_path / "o.fmu", 5 - version)
        observer = Observer(plan)
        with Fmu(tmp_path / "o.fmu") as fmu:
            fmu.set("sampling_mode", "periodic")
            fmu.initialise()
            fmu.set("x0.value", 2.0)
            for k in range(50):
                observer.push("x0", k / 64, 2.0)
                observer.advance((k + 1) / 64)
                fmu.set("x0.value", 2.0)
                fmu.do_step(k / 64, 1 / 64)
            assert fmu.get("est.x1") == observer.estimate()[0]["x1"]
