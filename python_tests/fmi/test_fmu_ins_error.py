"""The FMUs InsErrorFilter and AircraftIns: bit for bit the library, whatever the FMI version, interface and step."""

import json
import math
import subprocess
import threading
import zipfile
from dataclasses import dataclass
from pathlib import Path

import fmpy
import numpy as np
import pytest

from checkout import TOP, in_another_process
from hnav.errors import HnavError
from hnav.filters.ins_error import FORMS, InsErrorFilter, InsErrorOptions
from hnav.fmi.fmus import Fmu, fmu_path
from hnav.native.options import option_rows
from hnav.simulation.aircraft import Aircraft, AircraftPlant
from hnav.systems.aircraft import models_folder, read_aircraft
from importing import assert_fits_the_standard

VERSIONS = (2, 3)
versions = pytest.mark.parametrize("version", VERSIONS, ids=lambda v: f"fmi{v}")
flavours = pytest.mark.parametrize(
    "version, exchange",
    [(v, e) for v in VERSIONS for e in (False, True)],
    ids=lambda v: {2: "fmi2", 3: "fmi3", False: "cs", True: "me"}[v],
)
SETTINGS = (
    [dict(form=form) for form in FORMS]
    + [dict(noise_scaling=s) for s in ("none", "paper_match", "gated_match", "hmm")]
    + [dict(lag=1)]
)
FAULTS = ("noise_scale", "fault_probability", "bias_fault_probability")
PER_CHANNEL = ("estimate", "sigma", "lambda", "lambda_sigma", "compensated", "innov", *FAULTS)


@dataclass(frozen=True)
class Axis:
    name: str
    aircraft: Aircraft

    @property
    def states(self) -> list[str]:
        return [c.name for c in self.aircraft.channels]

    @property
    def controls(self) -> list[str]:
        return [c.name for c in self.aircraft.controls]

    @property
    def plant(self) -> str:
        return f"AircraftIns{self.name}"

    @property
    def filter(self) -> str:
        return f"InsErrorFilter{self.name}"

    @property
    def outputs(self) -> list[str]:
        return [f"{name}.{s}" for name in PER_CHANNEL for s in self.states] + ["nis", "process_fault_probability", "post.t"]


@pytest.fixture(params=("Longitudinal", "Lateral"))
def axis(request) -> Axis:
    return Axis(request.param, read_aircraft(models_folder() / f"f4c_{request.param.lower()}.json"))


@pytest.fixture(params=("filter", "plant"))
def model(axis, request) -> str:
    return getattr(axis, request.param)


def opened(name: str, version: int, exchange: bool = False, **parameters) -> Fmu:
    fmu = Fmu(fmu_path(name, version), model_exchange=exchange)
    for parameter, value in parameters.items():
        fmu.set(parameter, value)
    return fmu


def choices(setting: dict) -> dict:
    """Options by name as the numbers of the FMU's enumerations."""
    table = option_rows("ins_error")
    return {f"{table[k].group}.{k}": table[k].choices.index(v) if table[k].choices else v for k, v in setting.items()}


def deliver(fmu: Fmu, axis: Axis, flight, k: int) -> None:
    for i, state in enumerate(axis.states):
        fmu.set(f"z.{state}", flight.z[k, i])
    for j, control in enumerate(axis.controls):
        fmu.set(f"u.{control}", flight.u[k, j])
    fmu.set("z.t_meas", axis.aircraft.interval_s * k)
    fmu.set("z.sample", k + 1)


def read(fmu: Fmu, names: list[str]) -> list[float]:
    return [fmu.get(name) for name in names]


def event(fmu: Fmu, t_s: float) -> float | None:
    """Model Exchange: to the event at t_s from anywhere before it; the next time event."""
    fmu.call(fmu.fmu.enterContinuousTimeMode)
    fmu.call(fmu.fmu.setTime, t_s)
    fmu.call(fmu.fmu.enterEventMode)
    return fmu.update_discrete_states()


def expected_rows(axis: Axis, flight, setting: dict) -> np.ndarray:
    """The library's answers after each sample, in the order of Axis.outputs; None where there is none."""
    run = InsErrorFilter(AircraftPlant(axis.aircraft).filter_model(), InsErrorOptions(**setting)).run(flight.u, flight.z)
    late = setting.get("form") in ("mdkf", "amdkf") or setting.get("lag") == 1
    k = np.arange(len(flight.z))
    t_s = axis.aircraft.interval_s * np.maximum(k - late, 0)
    names = ("x", "sigma", "lam", "lam_sigma", "compensated", "innovation", *FAULTS, "nis", "process_fault_probability")
    return np.nan_to_num(np.column_stack([*(getattr(run, n) for n in names), t_s]))


# --------------------------------------------------------------------------------------------- description


@versions
def test_fmpy_and_the_schemas_find_nothing_to_complain_about(model, version):
    assert_fits_the_standard(fmu_path(model, version), version)


def test_both_versions_have_the_same_variables(model):
    two, three = (fmpy.read_model_description(str(fmu_path(model, v))).modelVariables for v in VERSIONS)
    assert [(v.name, v.causality, v.variability, v.unit) for v in two] == [
        (v.name, v.causality, v.variability, v.unit) for v in three
    ]


def test_the_plants_outputs_bear_the_names_types_and_units_of_the_filters_inputs(axis):
    plant, fmu = (fmpy.read_model_description(str(fmu_path(n, 3))).modelVariables for n in (axis.plant, axis.filter))
    outputs = {v.name: (v.type, v.unit, v.variability) for v in plant if v.causality == "output"}
    inputs = {v.name: (v.type, v.unit, v.variability) for v in fmu if v.causality == "input"}
    for name in [f"z.{s}" for s in axis.states] + [f"u.{c}" for c in axis.controls] + ["z.sample", "z.t_meas"]:
        assert outputs[name] == inputs[name], name


def test_start_values_are_those_of_the_model_file_to_the_last_bit(axis, model):
    data = json.loads((models_folder() / f"f4c_{axis.name.lower()}.json").read_text())
    variables = {v.name: v for v in fmpy.read_model_description(str(fmu_path(model, 3))).modelVariables}
    for prefix, entry in {
        "process_noise": "process_noise_per_sqrt_s", "measurement_sigma": "measurement_sigma", "ins_error_sigma": "ins_error_sigma",
        "ins_error_time_constant": "ins_error_time_constant_s", "start_sigma": "start_sigma",
    }.items():  # fmt: skip
        assert [float(variables[f"{prefix}.{s}"].start) for s in axis.states] == data[entry]
    assert float(variables["interval"].start) == data["interval_s"]
    if model == axis.plant:
        for control in data["inputs"]:
            started = [float(variables[f"command_{n}.{control['name']}"].start) for n in ("amplitude", "period", "phase")]
            assert started == [control["amplitude"], control["period_s"], control["phase_rad"]]
        factors = {f["channel"]: f["noise_factor"] for f in data["faults"]}
        assert [float(variables[f"fault_factor.{s}"].start) for s in axis.states] == [factors.get(s, 1) for s in axis.states]


def test_parameters_of_the_filter_are_the_options_of_the_library(axis):
    variables = {v.name: v for v in fmpy.read_model_description(str(fmu_path(axis.filter, 3))).modelVariables}
    defaults = InsErrorOptions()
    for name, info in option_rows("ins_error").items():
        value = getattr(defaults, name)
        variable = variables[f"{info.group}.{name}"]
        assert float(variable.start) == float(info.choices.index(value) if info.choices else value), name
        assert variable.description.removeprefix("[basic] ") == info.description


@versions
def test_the_archive_holds_documentation_licences_an_icon_and_an_example_input(model, version):
    with zipfile.ZipFile(fmu_path(model, version)) as archive:
        names = set(archive.namelist())
        page = archive.read("documentation/index.html").decode()
    assert {"documentation/licenses/license.txt", "resources/example_input.csv"} <= names
    assert ({"model.png"} if version == 2 else {"terminalsAndIcons/icon.png", "terminalsAndIcons/icon.svg"}) <= names
    assert f"<title>{model}</title>" in page and "measurement_sigma" in page


@versions
def test_the_binary_is_self_contained_and_holds_nothing_of_its_build(model, version, tmp_path):
    with zipfile.ZipFile(fmu_path(model, version)) as archive:
        binary = Path(archive.extract(next(n for n in archive.namelist() if n.endswith(".so")), tmp_path))
    symbols = [
        line.split()[-1] for line in subprocess.check_output(["nm", "-D", "--defined-only", binary], text=True).splitlines()
    ]
    assert symbols and all(s.startswith(f"fmi{version}") for s in symbols)
    needed = [line for line in subprocess.check_output(["readelf", "-d", binary], text=True).splitlines() if "NEEDED" in line]
    assert all("libc.so" in line or "libm.so" in line or "ld-linux" in line for line in needed), needed
    sections = subprocess.check_output(["size", "-A", binary], text=True).splitlines()
    assert sum(int(line.split()[1]) for line in sections if line.split()[:1] in ([".data"], [".bss"])) <= 64
    assert str(TOP).encode() not in binary.read_bytes()


# --------------------------------------------------------------------------------------------- twins


@flavours
@pytest.mark.parametrize("setting", SETTINGS, ids=lambda s: " ".join(map(str, s.values())))
def test_the_filter_is_the_library_bit_for_bit(axis, version, exchange, setting):
    flight = AircraftPlant(axis.aircraft, seed=2).run(160)
    expected = expected_rows(axis, flight, setting)
    dt = axis.aircraft.interval_s
    rows = []
    with opened(axis.filter, version, exchange, sampling_mode=1, **choices(setting)) as fmu:
        fmu.initialise()
        for k in range(len(flight.z)):
            if exchange and k > 0:
                event(fmu, dt * k)
            deliver(fmu, axis, flight, k)
            if exchange:
                assert fmu.update_discrete_states() is None
            else:
                fmu.do_step(dt * k, dt * (k + 1) - dt * k)
            rows.append(read(fmu, axis.outputs))
        assert fmu.get("count.samples") == len(rows)
        assert [fmu.get(f"count.{c}") for c in ("missed", "non_finite", "failed")] == [0, 0, 0]
    rows = np.array(rows)
    shown_late = expected[:, -1] < dt * np.arange(len(rows)) - dt / 2
    np.testing.assert_array_equal(rows[:, -1], expected[:, -1])
    assert shown_late.any() == (setting.get("form") in ("mdkf", "amdkf") or setting.get("lag") == 1)
    np.testing.assert_array_equal(rows, expected)


@flavours
def test_the_plant_is_the_library_bit_for_bit(axis, version, exchange):
    flight = AircraftPlant(axis.aircraft, seed=7).run(170)
    dt = axis.aircraft.interval_s
    columns = dict(z=flight.z, truth=flight.x)
    with opened(axis.plant, version, exchange, seed=7) as fmu:
        fmu.initialise()
        for k in range(len(flight.z)):
            if exchange:
                due = fmu.update_discrete_states() if k == 0 else event(fmu, dt * k)
                assert due == pytest.approx(dt * (k + 1))
            for name, rows in columns.items():
                assert read(fmu, [f"{name}.{s}" for s in axis.states]) == rows[k].tolist(), (name, k)
            assert read(fmu, [f"lambda.{s}" for s in axis.states]) == flight.lam[k].tolist()
            assert read(fmu, [f"u.{c}" for c in axis.controls]) == flight.u[k].tolist()
            assert read(fmu, [f"fault.{s}" for s in axis.states]) == (flight.noise_factor[k] != 1).tolist()
            assert fmu.get("z.sample") == k + 1 and fmu.get("z.t_meas") == dt * k
            if not exchange:
                fmu.do_step(dt * k, dt * (k + 1) - dt * k)


@versions
def test_seeds_make_different_flights_and_reset_brings_the_first_one_back(axis, version):
    def fly(fmu: Fmu) -> list[float]:
        fmu.initialise()
        out = []
        for k in range(30):
            fmu.do_step(0.1 * k, 0.1)
            out += read(fmu, [f"z.{s}" for s in axis.states])
        return out

    with opened(axis.plant, version) as zero, opened(axis.plant, version, seed=1) as one:
        first = fly(zero)
        assert fly(one) != first
        zero.call(zero.fmu.reset)
        assert fly(zero) == first


@versions
def test_the_parameters_of_the_model_reach_plant_and_filter(axis, version):
    state = axis.states[0]
    changes = {
        "measurement_sigma": 0.7,
        "ins_error_sigma": 1.5,
        "ins_error_time_constant": 30.0,
        "process_noise": 0.4,
        "start": 2.0,
        "start_sigma": 0.2,
    }
    for name in (axis.plant, axis.filter):
        output = f"z.{state}" if name == axis.plant else f"sigma.{state}"
        if name == axis.filter:
            changes.pop("start")
        for parameter, value in (
            {f"{k}.{state}": v for k, v in changes.items()}
            | {"euler_colour": True, "exact_process_noise": True, "interval": 0.05}
        ).items():
            results = []
            for changed in (False, True):
                with opened(name, version, **({parameter: value} if changed else {})) as fmu:
                    fmu.initialise()
                    for k in range(20):
                        fmu.do_step(0.1 * k, 0.1)
                    results.append(fmu.get(output))
            assert results[0] != results[1], (name, parameter)


@versions
def test_any_window_of_fault_can_be_set_for_each_channel(axis, version):
    state, other = axis.states[1], axis.states[2]
    quiet = {f"fault_factor.{s}": 1.0 for s in axis.states}
    window = {f"fault_start.{state}": 2.0, f"fault_stop.{state}": 3.5, f"fault_factor.{state}": 6.0}
    with opened(axis.plant, version, **(quiet | window)) as fmu:
        fmu.initialise()
        active = []
        for k in range(60):
            active.append(fmu.get(f"fault.{state}"))
            assert not fmu.get(f"fault.{other}")
            fmu.do_step(0.1 * k, 0.1)
    assert [k for k, is_active in enumerate(active) if is_active] == list(range(20, 36))


@versions
def test_commands_add_to_the_square_waves_and_those_that_are_no_numbers_are_counted(axis, version):
    control = axis.controls[0]
    silent = {f"command_amplitude.{c}": 0.0 for c in axis.controls}
    with opened(axis.plant, version, **silent) as fmu:
        fmu.initialise()
        fmu.set(f"command.{control}", 0.02)
        fmu.do_step(0.0, 0.1)
        assert fmu.get(f"u.{control}") == 0.02
        fmu.set(f"command.{control}", math.nan)
        fmu.do_step(0.1, 0.1)
        assert fmu.get(f"u.{control}") == 0.02 and fmu.get("count.non_finite") == 1
        assert math.isfinite(fmu.get(f"z.{axis.states[0]}"))


# --------------------------------------------------------------------------------------------- sampling


GRIDS = {
    "to the sample": np.arange(101) * 0.1,
    "25 ms": np.arange(401) * 0.025,
    "37 ms": np.arange(0, 10.1, 0.037),
    "random": np.r_[0, np.cumsum(np.random.default_rng(1).uniform(1e-3, 0.099, 240))],
}


@versions
def test_communication_steps_do_not_matter_to_plant_and_filter(axis, version):
    """Together, as a master would run them; by the counter each sample is used once."""
    results = {}
    for name, points in GRIDS.items():
        estimates = {}
        with opened(axis.plant, version, seed=3) as plant, opened(axis.filter, version, sampling_mode=1) as fmu:
            plant.initialise()
            fmu.initialise()
            names = [f"z.{s}" for s in axis.states] + [f"u.{c}" for c in axis.controls] + ["z.sample", "z.t_meas"]
            for t, end in zip(points[:-1], points[1:]):
                for signal in names:
                    fmu.set(signal, plant.get(signal))
                fmu.do_step(t, end - t)
                plant.do_step(t, end - t)
                estimates[fmu.get("count.samples")] = read(fmu, axis.outputs)
            assert fmu.get("count.missed") == 0
        results[name] = estimates
    for name, estimates in results.items():
        assert [estimates[k] for k in range(1, 95)] == [results["to the sample"][k] for k in range(1, 95)], name


@versions
def test_periodic_sampling_takes_each_interval_once(axis, version):
    flight = AircraftPlant(axis.aircraft, seed=2).run(50)
    expected = expected_rows(axis, flight, {})
    for step in (0.1, 0.02, 0.1 / 7):
        with opened(axis.filter, version) as fmu:
            fmu.initialise()
            for k in range(round(4.9 / step)):
                row = math.floor(k * step / 0.1 + 1e-6)
                deliver(fmu, axis, flight, row)
                fmu.do_step(k * step, (k + 1) * step - k * step)
            assert fmu.get("count.samples") == 49 and fmu.get("count.missed") == 0
            assert read(fmu, axis.outputs)[:-1] == expected[48, :-1].tolist()
            assert fmu.get("post.t") == pytest.approx(4.8)


@versions
@pytest.mark.parametrize("mode", [0, 1], ids=["periodic", "counter"])
def test_lost_samples_pass_as_steps_without_a_measurement_and_are_counted(axis, version, mode):
    flight = AircraftPlant(axis.aircraft, seed=2).run(31)
    kept = np.zeros(flight.z.shape, bool)
    kept[::3] = True
    u = np.vstack([flight.u[:1], np.repeat(flight.u[3::3], 3, axis=0)])  # a lost step is made with the control of the next sample
    run = InsErrorFilter(AircraftPlant(axis.aircraft).filter_model()).run(u, flight.z, kept)
    with opened(axis.filter, version, sampling_mode=mode) as fmu:
        fmu.initialise()
        for k in range(0, 31, 3):
            deliver(fmu, axis, flight, k)
            fmu.do_step(0.1 * k, 0.1 * (k + 3) - 0.1 * k)
        assert fmu.get("count.samples") == 11 and fmu.get("count.missed") == 20
        assert read(fmu, [f"estimate.{s}" for s in axis.states]) == run.x[-1].tolist()


@versions
def test_a_counter_may_begin_anywhere_stand_still_and_restart(axis, version):
    flight = AircraftPlant(axis.aircraft, seed=2).run(10)
    with opened(axis.filter, version, sampling_mode=1) as fmu:
        fmu.initialise()
        for k, count in enumerate((57, 58, 58, 1, 2, 2000000000)):
            deliver(fmu, axis, flight, k)
            fmu.set("z.sample", count)
            fmu.do_step(0.1 * k, 0.1)
        assert fmu.get("count.samples") == 5
        assert fmu.get("count.missed") == 2000000000 - 3
        assert all(math.isfinite(value) for value in read(fmu, axis.outputs))


@versions
def test_missing_channels_are_left_out(axis, version):
    flight = AircraftPlant(axis.aircraft, seed=2).run(20)
    present = np.ones(flight.z.shape, bool)
    present[5:10, 1] = present[8, :] = False
    run = InsErrorFilter(AircraftPlant(axis.aircraft).filter_model()).run(flight.u, flight.z, present)
    state = axis.states[1]
    with opened(axis.filter, version) as fmu:
        fmu.initialise()
        for k in range(20):
            deliver(fmu, axis, flight, k)
            for i, s in enumerate(axis.states):
                fmu.set(f"present.{s}", bool(present[k, i]))
            if k == 9:  # NaN says the same, and infinity is no measurement either
                fmu.set(f"present.{state}", True)
                fmu.set(f"z.{state}", math.nan if version == 2 else math.inf)
            fmu.do_step(0.1 * k, 0.1)
            assert read(fmu, [f"estimate.{s}" for s in axis.states]) == run.x[k].tolist()
            if not present[k, 1]:
                assert fmu.get(f"compensated.{state}") == fmu.get(f"estimate.{state}") and fmu.get(f"innov.{state}") == 0
        assert fmu.get("count.non_finite") == (0 if version == 2 else 1)


@versions
def test_a_control_that_is_no_number_is_counted_and_the_one_before_is_held(axis, version):
    flight = AircraftPlant(axis.aircraft, seed=2).run(10)
    u = flight.u.copy()
    u[5] = u[4]
    run = InsErrorFilter(AircraftPlant(axis.aircraft).filter_model()).run(u, flight.z)
    with opened(axis.filter, version) as fmu:
        fmu.initialise()
        for k in range(10):
            deliver(fmu, axis, flight, k)
            for control in axis.controls if k == 5 else ():
                fmu.set(f"u.{control}", math.nan)
            fmu.do_step(0.1 * k, 0.1)
        assert fmu.get("count.non_finite") == len(axis.controls)
        assert read(fmu, [f"estimate.{s}" for s in axis.states]) == run.x[-1].tolist()


@versions
def test_the_reset_command_acts_on_the_rising_edge(axis, version):
    flight = AircraftPlant(axis.aircraft, seed=2).run(10)
    with opened(axis.filter, version) as fmu:
        fmu.initialise()
        for k in range(6):
            deliver(fmu, axis, flight, k)
            fmu.set("reset", k >= 3)
            fmu.do_step(0.1 * k, 0.1)
        assert fmu.get("count.samples") == 3


def test_event_mode_of_co_simulation_shows_the_sample_at_once(axis):
    flight = AircraftPlant(axis.aircraft, seed=2).run(3)
    with opened(axis.filter, 3) as fmu:
        f = fmu.fmu
        f.fmi3FreeInstance(f.component)
        f.instantiate(eventModeUsed=True, earlyReturnAllowed=True, logMessage=lambda *a: None)
        fmu.set("sampling_mode", "periodic")
        fmu.initialise()
        deliver(fmu, axis, flight, 0)
        assert fmu.update_discrete_states() == pytest.approx(0.1)
        assert fmu.get("count.samples") == 1
        f.enterStepMode()
        needed, terminate, early, last = f.doStep(0.0, 0.25)
        assert needed and early and last == pytest.approx(0.1)


# --------------------------------------------------------------------------------------------- complete state


def steps(fmu: Fmu, axis: Axis, flight, first: int, last: int) -> list:
    """The plant flies, the filter is fed from flight."""
    names = axis.outputs if "form.form" in fmu.variables else [f"{n}.{s}" for n in ("z", "truth", "lambda") for s in axis.states]
    out = []
    for k in range(first, last):
        if "form.form" in fmu.variables:
            deliver(fmu, axis, flight, k)
        fmu.do_step(0.1 * k, 0.1)
        out.append(read(fmu, names))
    return out


def snapshot(fmu: Fmu):
    return fmu.fmu.getFMUState() if fmu.fmi3 else fmu.fmu.getFMUstate()


@versions
def test_a_saved_state_replays_bit_for_bit(axis, model, version):
    flight = AircraftPlant(axis.aircraft, seed=2).run(120)
    with opened(model, version) as fmu:
        fmu.initialise()
        steps(fmu, axis, flight, 0, 85)
        state = snapshot(fmu)
        straight = steps(fmu, axis, flight, 85, 120)
        (fmu.fmu.setFMUState if fmu.fmi3 else fmu.fmu.setFMUstate)(state)
        assert steps(fmu, axis, flight, 85, 120) == straight
        (fmu.fmu.freeFMUState if fmu.fmi3 else fmu.fmu.freeFMUstate)(state)


_CONTINUE = """
import test_fmu_ins_error as t
axis = t.Axis({axis!r}, t.read_aircraft(t.models_folder() / "f4c_{file}.json"))
flight = t.AircraftPlant(axis.aircraft, seed=2).run(10)
with t.opened({model!r}, {version}) as fmu:
    f = fmu.fmu
    state = f.deserializeFMUState(open({path!r}, "rb").read()) if fmu.fmi3 else f.deSerializeFMUstate(open({path!r}, "rb").read())
    (f.setFMUState if fmu.fmi3 else f.setFMUstate)(state)
    print([v.hex() for row in t.steps(fmu, axis, flight, 5, 10) for v in row])
"""


@versions
def test_a_serialised_state_goes_on_in_another_process_and_a_damaged_one_is_refused(axis, model, version, tmp_path):
    flight = AircraftPlant(axis.aircraft, seed=2).run(10)
    with opened(model, version) as fmu:
        fmu.initialise()
        steps(fmu, axis, flight, 0, 5)
        f, state = fmu.fmu, snapshot(fmu)
        content = bytearray(f.serializeFMUState(state) if fmu.fmi3 else f.serializeFMUstate(state))
        path = tmp_path / "state.bin"
        path.write_bytes(content)
        expected = str([v.hex() for row in steps(fmu, axis, flight, 5, 10) for v in row])
        content[len(content) // 2] ^= 1
        with pytest.raises(HnavError, match="damaged"):
            fmu.call(f.deserializeFMUState if fmu.fmi3 else f.deSerializeFMUstate, bytes(content))
    code = _CONTINUE.format(axis=axis.name, file=axis.name.lower(), model=model, version=version, path=str(path))
    assert in_another_process(code, Path(__file__).parent).strip() == expected


# --------------------------------------------------------------------------------------------- wrong calls


@versions
def test_wrong_steps_are_refused_with_a_reason_and_change_nothing(model, version):
    with opened(model, version) as fmu:
        fmu.initialise(0.0, 1.0)
        fmu.do_step(0, 0.5)
        for t, step, reason in (
            (0.5, math.nan, "communicationStepSize"), (0.5, math.inf, "communicationStepSize"), (0.5, 0.0, "above 0"),
            (0.5, -0.1, "above 0"), (math.nan, 0.1, "currentCommunicationPoint"), (0.4, 0.1, "last step ended"), (0.5, 0.6, "stopTime"),
        ):  # fmt: skip
            with pytest.raises(HnavError, match=reason):
                fmu.do_step(t, step)
        fmu.do_step(0.5, 0.5)
        assert fmu.get("time") == 1.0


@versions
def test_impossible_parameters_stop_initialisation_with_their_names(axis, version):
    state = axis.states[2]
    with opened(axis.filter, version, euler_colour=True, **{f"ins_error_time_constant.{state}": 0.01}) as fmu:
        with pytest.raises(HnavError, match=f"^ins_error_time_constant.{state} = 0.01 is impossible with euler_colour"):
            fmu.initialise()
        fmu.call(fmu.fmu.reset)  # and it is usable again
        fmu.initialise()
        fmu.do_step(0, 0.1)
    for name, parameter, value in (
        (axis.filter, "measurement_sigma", -1.0),
        (axis.plant, "fault_factor", -1.0),
        (axis.filter, "start_sigma", math.nan),
    ):
        with opened(name, version) as fmu, pytest.raises(HnavError, match=f"{parameter}.{state}"):
            fmu.set(f"{parameter}.{state}", value)


@flavours
def test_every_call_is_refused_in_each_mode_where_it_has_no_place(model, version, exchange):
    with opened(model, version, exchange) as fmu:
        f = fmu.fmu
        some_output = next(v.name for v in fmu.description.modelVariables if v.causality == "output")
        some_input = next(v.name for v in fmu.description.modelVariables if v.causality == "input")
        calls = {
            "initialise": fmu.initialise, "exit initialization": f.exitInitializationMode, "terminate": f.terminate,
            "get": lambda: fmu.get(some_output), "set parameter": lambda: fmu.set("interval", 0.1), "set input": lambda: fmu.set(some_input, 0.0),
        }  # fmt: skip
        if exchange:
            calls |= {
                "enter event mode": f.enterEventMode, "update": fmu.update_discrete_states, "enter continuous-time mode": f.enterContinuousTimeMode,
                "set time": lambda: f.setTime(0.0), "set states": lambda: f.setContinuousStates(None, 0),
                "get states": lambda: f.getContinuousStates(None, 0), "completed step": f.completedIntegratorStep,
            }  # fmt: skip
        else:
            calls["step"] = lambda: f.doStep(0.0, 0.01)
        allowed = {
            "instantiated": {"initialise", "set parameter", "set input"},
            "event": {"terminate", "get", "set input", "update", "enter continuous-time mode", "set time", "get states"},
            "continuous": {
                "terminate",
                "get",
                "set input",
                "enter event mode",
                "set time",
                "set states",
                "get states",
                "completed step",
            },
            "step": {"terminate", "get", "set input", "step"},
            "terminated": {"get", "get states"},
        }

        def refused(mode: str) -> None:
            for name, call in calls.items():
                if name in allowed[mode]:
                    continue
                count = len(fmu.messages)
                with pytest.raises(HnavError):
                    fmu.call(call)
                assert len(fmu.messages) > count, f"{name} in {mode} gave no message"

        refused("instantiated")
        fmu.initialise()
        refused("event" if exchange else "step")
        if exchange:
            fmu.update_discrete_states()
            for name in ("get states", "enter continuous-time mode", "set states", "completed step"):  # no states, no objection
                fmu.call(calls[name])
            refused("continuous")
        f.terminate()
        refused("terminated")
        fmu.call(f.reset)
        fmu.initialise()
        assert fmu.get(some_output) is not None


# --------------------------------------------------------------------------------------------- many instances


@versions
def test_four_threads_on_separate_instances_agree(axis, model, version):
    flight = AircraftPlant(axis.aircraft, seed=2).run(60)
    results: list = [None] * 4

    def work(i: int) -> None:
        with opened(model, version) as fmu:
            fmu.initialise()
            results[i] = steps(fmu, axis, flight, 0, 60)

    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results[0] is not None and all(r == results[0] for r in results)


@versions
def test_reset_leaves_nothing_behind(axis, model, version):
    flight = AircraftPlant(axis.aircraft, seed=2).run(30)
    with opened(model, version) as fmu:
        fmu.initialise()
        first = steps(fmu, axis, flight, 0, 30)
        fmu.call(fmu.fmu.reset)
        fmu.initialise()
        assert steps(fmu, axis, flight, 0, 30) == first


@versions
@pytest.mark.parametrize("kind", ["CoSimulation", "ModelExchange"])
def test_simulate_fmu_runs_the_example_input(axis, model, version, kind):
    path = fmu_path(model, version)
    with zipfile.ZipFile(path) as archive:
        signal = np.genfromtxt(archive.open("resources/example_input.csv"), delimiter=",", names=True, deletechars="")
    names = [f"estimate.{s}" for s in axis.states] if model == axis.filter else [f"truth.{s}" for s in axis.states]
    result = fmpy.simulate_fmu(str(path), fmi_type=kind, stop_time=15, input=signal, output_interval=0.1, output=names)
    if model == axis.filter:
        truth = AircraftPlant(axis.aircraft, seed=1).run(151).x
        last = np.array([result[name][-1] for name in names])
        assert (np.abs(last - truth[150]) < 6 * (axis.aircraft.ins_error_sigma + axis.aircraft.start_sigma)).all()
    else:
        flight = AircraftPlant(axis.aircraft).run(151)
        np.testing.assert_array_equal([result[name][-1] for name in names], flight.x[150])
