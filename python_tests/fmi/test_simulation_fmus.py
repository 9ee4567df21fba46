"""The FMUs of the plants: the descriptions of all of them, and Turntable and ImuMagSensor."""

import ctypes as C
import inspect
import math
import xml.etree.ElementTree as ElementTree
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
import test_fmu

from checkout import in_another_process
from closed_loop import REALS
from hnav.fmi.fmus import Fmu, fmu_path
from importing import assert_fits_the_standard, step_once
from makers.turntable_scenarios import SAMPLES, TRUTH

VERSIONS = (2, 3)
versions = pytest.mark.parametrize("version", VERSIONS, ids=lambda v: f"fmi{v}")
plants = pytest.mark.parametrize("name", ("Turntable", "ImuMagSensor"))
all_plants = pytest.mark.parametrize("name", ("Turntable", "ImuMagSensor", "Vehicle", "Gnss", "Baro", "Wheel"))
NOISY = {
    "gyro.noise_deg_per_sqrt_h": 0.5, "gyro.bias_instability_rad_s": 1e-4, "gyro.random_walk_deg_per_h_per_sqrt_h": 50.0, "gyro.bias_sigma_rad_s": 0.01,
    "accel.noise_ug_per_sqrt_hz": 100.0, "accel.dropout": 0.1, "mag.noise_nt_per_sqrt_hz": 50.0, "mag.period_s": 0.02, "mag.latency_s": 0.03,
}  # fmt: skip
WIDE = {
    "pitch.motion": 2,
    "pitch.amplitude_rad": 0.5,
    "pitch.period_s": 3.0,
    "roll.motion": 1,
    "roll.amplitude_rad": 0.8,
    "roll.start_s": 0.505,
}


def opened(name: str, version: int, parameters=None, model_exchange: bool = False) -> Fmu:
    fmu = Fmu(fmu_path(name, version), model_exchange)
    for parameter, value in (parameters or {}).items():
        fmu.set(parameter, value)
    return fmu


def truth_of(fmu: Fmu) -> list[float]:
    return [fmu.get(name) for name in TRUTH]


def samples_of(fmu: Fmu) -> list:
    return [fmu.get(name) for name in SAMPLES]


def state_calls(fmu: Fmu):
    f = fmu.fmu
    return (f.getFMUState, f.setFMUState, f.freeFMUState) if fmu.fmi3 else (f.getFMUstate, f.setFMUstate, f.freeFMUstate)


# --------------------------------------------------------------------------------------------- description


@versions
@all_plants
def test_fmpy_and_the_schemas_find_nothing_to_complain_about(name, version):
    assert_fits_the_standard(fmu_path(name, version), version)


@all_plants
def test_both_versions_have_the_same_variables(name):
    two, three = (fmpy.read_model_description(str(fmu_path(name, v))).modelVariables for v in VERSIONS)
    assert [(v.name, v.causality, v.variability, v.unit) for v in two] == [
        (v.name, v.causality, v.variability, v.unit) for v in three
    ]


@versions
def test_outputs_bear_the_names_types_and_units_of_the_inputs_they_feed(version):
    def described(name: str, causality: str) -> dict:
        variables = fmpy.read_model_description(str(fmu_path(name, version))).modelVariables
        return {v.name: (v.type, v.unit) for v in variables if v.causality == causality}

    table, sensor_in, sensor_out = (
        described("Turntable", "output"),
        described("ImuMagSensor", "input"),
        described("ImuMagSensor", "output"),
    )
    assert sorted(sensor_in) == sorted(TRUTH)
    for name in sensor_in:
        assert sensor_in[name] == table[name], name
    for target in ("Hrekf", "Ahrs"):
        inputs = described(target, "input")
        wanted = {name for name in inputs if name.startswith(("gyro.", "accel.", "mag."))}
        assert wanted == set(SAMPLES)
        for name in wanted:
            assert inputs[name] == sensor_out[name], name


def test_plugs_of_the_sensor_have_the_members_of_the_filters_plugs():
    def plugs(name: str) -> dict:
        with zipfile.ZipFile(fmu_path(name, 3)) as archive:
            root = ElementTree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
        return {t.get("name"): [m.get("memberName") for m in t] for t in root.iter("Terminal")}

    sensor, hrekf = plugs("ImuMagSensor"), plugs("Hrekf")
    assert list(sensor) == ["truth", "gyro", "accel", "mag"]
    for name in ("gyro", "accel", "mag"):
        assert sensor[name] == hrekf[name]
    assert set(sensor["truth"]) < set(plugs("Turntable")["truth"])


@versions
def test_the_noise_density_is_published_in_si(version):
    with opened("ImuMagSensor", version, NOISY) as fmu:
        fmu.initialise()
        assert fmu.variables["gyro.noise_psd"].causality == "calculatedParameter"
        assert fmu.get("gyro.noise_psd") == pytest.approx(math.radians(0.5 / 60) ** 2, rel=1e-12)
        assert fmu.get("accel.noise_psd") == pytest.approx((1e-4 * 9.80665) ** 2, rel=1e-12)
        assert fmu.get("mag.noise_psd") == pytest.approx(50e-9**2, rel=1e-12)


# What holds for every FMU, as the tests of the filters say it.
GENERAL = (
    test_fmu.test_the_binary_is_self_contained_and_holds_nothing_of_its_build,
    test_fmu.test_a_token_of_another_version_is_turned_away,
    test_fmu.test_two_hundred_instances_leave_no_memory_behind,
)


@versions
@pytest.mark.parametrize("name", ("Turntable", "ImuMagSensor", "Pendulum", "Observer", "Vehicle", "Gnss", "Baro", "Wheel"))
@pytest.mark.parametrize("law", GENERAL, ids=lambda law: law.__name__.removeprefix("test_"))
def test_what_holds_for_every_fmu(law, name, version, monkeypatch, tmp_path):
    monkeypatch.setattr(test_fmu, "MODEL", name)
    arguments = {"version": version, "tmp_path": tmp_path}
    law(**{key: arguments[key] for key in inspect.signature(law).parameters})


@versions
@plants
def test_the_archive_holds_documentation_and_licences(name, version):
    with zipfile.ZipFile(fmu_path(name, version)) as archive:
        names = set(archive.namelist())
        page = archive.read("documentation/index.html").decode()
    assert {"documentation/licenses/license.txt", "documentation/licenses/SUNDIALS.txt"} <= names
    assert ("resources/example_input.csv" in names) == (name == "ImuMagSensor")
    assert "truth.q[1]" in page


@versions
def test_simulate_fmu_runs_both(version):
    for kind in ("CoSimulation", "ModelExchange"):
        result = fmpy.simulate_fmu(
            str(fmu_path("Turntable", version)), fmi_type=kind, stop_time=8, output_interval=0.1, output=["truth.euler[3]"]
        )
        assert np.degrees(result["truth.euler[3]"][-1]) == pytest.approx(40, abs=1e-4)
    path = fmu_path("ImuMagSensor", version)
    with zipfile.ZipFile(path) as archive:
        signal = np.genfromtxt(archive.open("resources/example_input.csv"), delimiter=",", names=True, deletechars="")
    result = fmpy.simulate_fmu(
        str(path), stop_time=1, input=signal, output_interval=0.01, output=["gyro.rate[3]", "mag.sample", "mag.valid"]
    )
    assert np.degrees(result["gyro.rate[3]"][-1]) == pytest.approx(20)
    assert result["mag.valid"][-1] and result["mag.sample"][-1] == 100


# --------------------------------------------------------------------------------------------- turntable


@versions
def test_the_truth_does_not_depend_on_the_steps(version):
    ends = []
    for step in (0.003, 0.0173, 1.0):
        with opened("Turntable", version, WIDE) as fmu:
            fmu.initialise()
            t = 0.0
            while t < 7 - 1e-9:
                end = min(t + step, 7.0)
                fmu.do_step(t, end - t)
                t = end
            ends.append(truth_of(fmu))
    np.testing.assert_allclose(ends[1:], [ends[0]] * 2, rtol=0, atol=1e-13)


@versions
def test_model_exchange_follows_the_closed_form_across_corners(version):
    with opened("Turntable", version, WIDE) as exact, opened("Turntable", version, WIDE, model_exchange=True) as fmu:
        exact.initialise()
        fmu.initialise()
        solver = fmu.solver(0.0)
        t, corners = 0.0, []
        for k in range(70):
            exact.do_step(0.1 * k, 0.1 * (k + 1) - 0.1 * k)
            while t < 0.1 * (k + 1) - 1e-12:
                corner = fmu.update_discrete_states()
                end = min(0.1 * (k + 1), corner if corner is not None else math.inf)
                if corner is not None and corner == end:
                    corners.append(round(corner, 9))
                fmu.call(fmu.fmu.enterContinuousTimeMode)
                solver.reset(t)
                solver.step(t, end)
                fmu.call(fmu.fmu.setTime, end)
                fmu.call(fmu.fmu.enterEventMode)
                t = end
            fmu.update_discrete_states()
            # q within 1e-6 at a tolerance of 1e-8; a force turns by twice that and is ten times as large
            scale = np.array([1.0] * 7 + [20.0] * 3 + [1e-4] * 3)
            np.testing.assert_allclose(np.array(truth_of(fmu)) / scale, np.array(truth_of(exact)) / scale, rtol=0, atol=1e-6)
        roll_end = round(0.505 + 0.8 / math.radians(10), 9)
        assert corners == [0.505, roll_end, 6.0]


@versions
def test_directional_derivatives_are_those_of_the_flow(version):
    with opened("Turntable", version, WIDE, model_exchange=True) as fmu:
        fmu.initialise()
        fmu.update_discrete_states()
        fmu.call(fmu.fmu.enterContinuousTimeMode)
        f = fmu.fmu
        fmu.call(f.setTime, 0.3)
        known = [fmu.variables[f"state.q[{i}]"].valueReference for i in range(1, 5)]
        unknown = [fmu.variables[f"der(state.q[{i}])"].valueReference for i in range(1, 5)]
        for seed in np.eye(4).tolist():
            slope = np.array(f.getDirectionalDerivative(unknown, known, seed))
            rate = [fmu.get(f"truth.rate[{i}]") for i in (1, 2, 3)]
            # The flow is linear in q: its slope along seed is half the product of seed and rate.
            w, v = seed[0], np.array(seed[1:])
            expected = 0.5 * np.concatenate([[-v @ rate], w * np.array(rate) + np.cross(v, rate)])
            np.testing.assert_allclose(slope, expected, atol=1e-15)


@versions
@pytest.mark.parametrize("exchange", (False, True), ids=("cs", "me"))
def test_a_saved_turntable_replays_bit_for_bit(version, exchange):
    with opened("Turntable", version, WIDE, exchange) as fmu:
        fmu.initialise()
        solver = fmu.solver(0.0) if exchange else None

        def go_on(first: int, last: int) -> list:
            out = []
            for k in range(first, last):
                step_once(fmu, solver, k)
                out.append(truth_of(fmu))
            return out

        go_on(0, 5)
        get, put, free = state_calls(fmu)
        state = get()
        straight = go_on(5, 10)
        put(state)
        assert go_on(5, 10) == straight
        free(state)


# --------------------------------------------------------------------------------------------- sensor


def run_sensor(fmu: Fmu, first: int, last: int, step_s: float = 0.01) -> list:
    out = []
    for k in range(first, last):
        fmu.set("truth.rate[1]", math.sin(0.3 * math.floor(k * step_s / 0.01 + 1e-6)))
        fmu.do_step(k * step_s, (k + 1) * step_s - k * step_s)
        out.append(samples_of(fmu))
    return out


@versions
def test_a_saved_sensor_replays_bit_for_bit_and_reset_restores(version):
    with opened("ImuMagSensor", version, NOISY) as fmu:
        fmu.initialise()
        beginning = run_sensor(fmu, 0, 20)
        get, put, free = state_calls(fmu)
        state = get()
        straight = run_sensor(fmu, 20, 60)
        put(state)
        assert run_sensor(fmu, 20, 60) == straight
        free(state)
        fmu.call(fmu.fmu.reset)
        for parameter, value in NOISY.items():
            fmu.set(parameter, value)
        fmu.initialise()
        assert run_sensor(fmu, 0, 20) == beginning


_CONTINUE = """
from test_simulation_fmus import opened, run_sensor
with opened("ImuMagSensor", {version}) as fmu:
    f = fmu.fmu
    state = f.deserializeFMUState(open({file!r}, "rb").read()) if fmu.fmi3 else f.deSerializeFMUstate(open({file!r}, "rb").read())
    (f.setFMUState if fmu.fmi3 else f.setFMUstate)(state)
    print(run_sensor(fmu, 20, 40))
"""


@versions
def test_a_serialised_sensor_goes_on_in_another_process(version, tmp_path):
    with opened("ImuMagSensor", version, NOISY) as fmu:
        fmu.initialise()
        run_sensor(fmu, 0, 20)
        f = fmu.fmu
        state = f.getFMUState() if fmu.fmi3 else f.getFMUstate()
        file = tmp_path / "state.bin"
        file.write_bytes(bytes(f.serializeFMUState(state) if fmu.fmi3 else f.serializeFMUstate(state)))
        expected = str(run_sensor(fmu, 20, 40))
    code = _CONTINUE.format(version=version, file=str(file))
    assert in_another_process(code, Path(__file__).parent).strip() == expected


def test_both_versions_give_the_same_samples_and_seeds_zero_and_one_do_not():
    runs = []
    for version, seed in ((2, 0), (3, 0), (2, 1)):
        with opened("ImuMagSensor", version, NOISY | {"seed": seed}) as fmu:
            fmu.initialise()
            runs.append(run_sensor(fmu, 0, 50))
    assert runs[0] == runs[1]
    assert runs[0] != runs[2]


@versions
def test_the_same_samples_come_on_every_grid_that_meets_their_times(version):
    def samples(step_s: float) -> dict:
        seen = {}
        with opened("ImuMagSensor", version, NOISY) as fmu:
            fmu.initialise()
            for row in run_sensor(fmu, 0, round(0.5 / step_s), step_s):
                for s in range(3):
                    *value, count, stamp, _ = row[6 * s : 6 * s + 6]
                    seen[s, count] = (value, round(stamp, 9))
        return seen

    coarse, fine = samples(0.01), samples(0.0025)
    assert len(coarse) > 90
    # A late sensor delivers the last ones beyond the end of one of the runs.
    common = set(coarse) & set(fine)
    assert len(common) >= len(coarse) - 1
    assert all(coarse[key] == fine[key] for key in common)


@versions
def test_missed_samples_of_a_coarse_step_are_counted(version):
    with opened("ImuMagSensor", version) as fmu:
        fmu.initialise()
        run_sensor(fmu, 0, 10, 0.05)
        assert fmu.get("count.gyro.missed") == 36  # 46 samples are due up to 0.45 s
        assert fmu.get("gyro.sample") == 10
        assert fmu.get("gyro.t_meas") == pytest.approx(0.45)


def test_event_mode_returns_early_at_the_next_sample_and_delivers_it_at_once():
    with opened("ImuMagSensor", 3) as fmu:
        f = fmu.fmu
        f.fmi3FreeInstance(f.component)
        f.instantiate(eventModeUsed=True, earlyReturnAllowed=True, logMessage=lambda *a: None)
        fmu.initialise()
        assert fmu.update_discrete_states() == pytest.approx(0.01)
        assert fmu.get("gyro.sample") == 1
        f.enterStepMode()
        event, terminate, early, t = f.doStep(0.0, 1.0)
        assert (bool(event), bool(early), t) == (True, True, pytest.approx(0.01))
        f.enterEventMode()
        fmu.update_discrete_states()
        assert fmu.get("gyro.sample") == 2
        assert fmu.get("gyro.t_meas") == pytest.approx(0.01)


@versions
def test_an_input_that_is_no_attitude_yet_takes_no_sample(version):
    with opened("ImuMagSensor", version, {"truth.q[1]": 0.0}) as fmu:
        fmu.initialise()
        fmu.do_step(0.0, 0.01)
        assert not fmu.get("gyro.valid")
        fmu.set("truth.q[1]", 1.0)
        fmu.do_step(0.01, 0.01)
        assert fmu.get("gyro.valid")
        assert fmu.get("gyro.t_meas") == pytest.approx(0.01)
        # What waited for a truth was not lost by a coarse step.
        assert fmu.get("count.gyro.missed") == 0 and fmu.messages == []


@versions
def test_an_impossible_parameter_set_stops_initialisation_with_its_name(version):
    from hnav.errors import HnavError

    with (
        opened("ImuMagSensor", version, {"mag.jitter_s": 0.02}) as fmu,
        pytest.raises(HnavError, match="mag.jitter_s = 0.02 must be below half of mag.period_s"),
    ):
        fmu.initialise()
    with opened("Turntable", version) as fmu, pytest.raises(HnavError, match="gravity_m_s2"):
        fmu.set("gravity_m_s2", -1.0)


# --------------------------------------------------------------------------------------------- noise


def numpy_normals(seed: int, stream: int, count: int) -> np.ndarray:
    """Twin of RandomStream::normal: Box and Muller over the uniforms of numpy's Philox."""
    words = np.random.Philox(key=[seed, stream]).random_raw(count)
    uniform = (words >> np.uint64(11)) * 2.0**-53
    radius, angle = np.sqrt(-2 * np.log(1 - uniform[0::2])), 6.283185307179586 * uniform[1::2]
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1).ravel()


def test_white_noise_is_the_numpy_twin_to_twelve_digits():
    seed, n, density = 5, 200, 1.0  # deg/sqrt(h)
    with opened("ImuMagSensor", 2, {"seed": seed, "gyro.noise_deg_per_sqrt_h": density}) as fmu:
        fmu.initialise()
        rates = []
        for k in range(n):
            fmu.do_step(0.01 * k, 0.01)
            rates.append([fmu.get(f"gyro.rate[{i}]") for i in (1, 2, 3)])
    expected = numpy_normals(seed, 16, 4 * n).reshape(n, 4)[:, :3]  # stream of the gyroscope's white noise
    sigma = math.radians(density) / 60 / math.sqrt(0.01)
    np.testing.assert_allclose(np.array(rates) / sigma, expected, rtol=0, atol=1e-12)


def long_record(parameters: dict, steps: int, period_s: float) -> np.ndarray:
    """steps x 3 rates of a body at rest."""
    with opened("ImuMagSensor", 2, {"gyro.period_s": period_s, "accel.period_s": 1e6, "mag.period_s": 1e6} | parameters) as fmu:
        fmu.initialise()
        references = fmu.references([n for n in REALS if n.startswith("gyro.rate")])
        values, rows = (C.c_double * 3)(), np.empty((steps, 3))
        f = fmu.fmu
        for k in range(steps):
            f.fmi2DoStep(f.component, k * period_s, (k + 1) * period_s - k * period_s, 0)
            fmu.crossing("Get", "real", references, values)()
            rows[k] = values
    return rows


def allan(rates: np.ndarray, period_s: float, taus: list[float]) -> np.ndarray:
    """Pooled over the three axes, which are independent: overlapping estimate."""
    allantools = pytest.importorskip("allantools", reason="allantools is not installed")
    deviations = [allantools.oadev(axis, rate=1 / period_s, data_type="freq", taus=taus)[1] for axis in rates.T]
    assert all(len(d) == len(taus) for d in deviations)
    return np.sqrt(np.mean(np.square(deviations), axis=0))


# Standard error of an Allan deviation from n averages without overlap: 1/sqrt(2 (n - 1)) (IEEE Std 952, annex C); the
# overlapping estimate is at least as good. Tolerance: 4 of them, over three axes.
def tolerance(steps: int, period_s: float, tau_s: float) -> float:
    return 4 / math.sqrt(2 * (3 * steps * period_s / tau_s - 1))


def test_allan_deviation_recovers_the_white_noise():
    steps, period = 40_000, 0.1
    rates = long_record({"gyro.noise_deg_per_sqrt_h": 0.6}, steps, period)
    taus = [0.1, 1.0, 10.0, 100.0]
    for tau, deviation in zip(taus, allan(rates, period, taus), strict=True):
        assert deviation == pytest.approx(math.radians(0.6 / 60) / math.sqrt(tau), rel=tolerance(steps, period, tau)), tau


def test_allan_deviation_recovers_the_random_walk():
    steps, period = 40_000, 0.1
    rates = long_record({"gyro.random_walk_deg_per_h_per_sqrt_h": 30.0}, steps, period)
    walk = math.radians(30.0) / 3600 / 60  # rad/s/sqrt(s)
    taus = [10.0, 30.0, 100.0]
    for tau, deviation in zip(taus, allan(rates, period, taus), strict=True):
        assert deviation == pytest.approx(walk * math.sqrt(tau / 3), rel=tolerance(steps, period, tau)), tau


def flicker_deviation(tau_s: np.ndarray | float) -> np.ndarray:
    """Allan deviation of the eight processes that stand for flicker noise, in units of its floor."""
    tau_s = np.asarray(tau_s, float)
    variance = np.zeros_like(tau_s)
    for j in range(8):
        x = tau_s / (0.25 * 4.0**j)
        # A Gauss-Markov process of unit variance (IEEE Std 952, annex C).
        variance += 2 / x * (1 - (3 - 4 * np.exp(-x) + np.exp(-2 * x)) / (2 * x))
    return np.sqrt(variance)


def test_the_sum_of_eight_processes_is_flat_within_five_percent_from_two_to_a_thousand_seconds():
    assert np.abs(flicker_deviation(np.geomspace(2, 1000, 200)) - 1).max() < 0.05


def test_allan_deviation_recovers_the_bias_instability():
    steps, period = 100_000, 0.1
    floor = math.radians(10) / 3600
    rates = long_record({"gyro.bias_instability_rad_s": floor}, steps, period)
    taus = [2.0, 8.0, 32.0, 128.0, 512.0]
    for tau, deviation in zip(taus, allan(rates, period, taus), strict=True):
        assert deviation == pytest.approx(floor * flicker_deviation(tau), rel=tolerance(steps, period, tau)), tau


def test_all_three_together_add_their_variances():
    steps, period = 100_000, 0.1
    white, floor, walk = 0.05, math.radians(20) / 3600, 600.0
    rates = long_record(
        {"gyro.noise_deg_per_sqrt_h": white, "gyro.bias_instability_rad_s": floor, "gyro.random_walk_deg_per_h_per_sqrt_h": walk},
        steps,
        period,
    )
    taus = np.array([2.0, 16.0, 256.0])
    expected = np.sqrt(
        math.radians(white / 60) ** 2 / taus
        + (floor * flicker_deviation(taus)) ** 2
        + (math.radians(walk) / 3600 / 60) ** 2 * taus / 3
    )
    for tau, deviation, want in zip(taus, allan(rates, period, taus.tolist()), expected, strict=True):
        assert deviation == pytest.approx(want, rel=tolerance(steps, period, tau)), tau
