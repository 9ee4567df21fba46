"""The FMU Ins: bit for bit the library, whatever the FMI version and step; by an importer's solver the same to its tolerance;
its outputs before the first estimate."""

import ctypes as C

import fmpy
import numpy as np
import pytest
from fmpy import simulate_fmu

import hnav
from hnav import earth
from hnav.errors import HnavError
from hnav.filters.ins_answers import PHASES
from hnav.filters.options import INS_PRESETS, Options, option_table
from hnav.fmi.fmus import Fmu, fmu_path
from hnav.native.library import SENSORS
from importing import assert_fits_the_standard
from studies.ins.vehicles import vehicle

VERSIONS = (2, 3)
versions = pytest.mark.parametrize("version", VERSIONS, ids=lambda v: f"fmi{v}")
VECTORS = {"nav.velocity": "velocity_n_m_s", "att.q": "q_nb", "nav.sigma_position": "sigma_position_m", "att.sigma": "sigma_rotation_rad",
           "bias.gyro": "gyro_bias_rad_s", "bias.accel_sigma": "sigma_accel_bias_m_s2"}  # fmt: skip
KINDS = {"position": "gnss", "velocity": "gnssvel", "mag": "mag"}
LENGTH = 2500  # rows
LATE_S = 0.15


def driven_by(magnetometer):
    """Rows of rate and force, and by row the aids that came with it: kind, time of validity, values."""
    samples, _ = vehicle("car", "industrial", 11, 26.0, magnetometer)
    valid, received, sensor, value = samples.aids.arrays()
    fixes = {}
    for t, kind, values in zip(received, sensor, value):
        row = int(np.searchsorted(samples.t_s, t - 1e-9))
        fixes.setdefault(row, {})[KINDS[SENSORS[kind]]] = (float(samples.t_s[min(row, LENGTH)]), values)
    return samples, fixes


@pytest.fixture(scope="module")
def drive():
    return driven_by(magnetometer=False)


def opened(version, exchange=False, **parameters):
    fmu = Fmu(fmu_path("Ins", version), model_exchange=exchange)
    for name, value in {"sampling_mode": "counter", "preset": "industrial", "solver.solver": "closed_form", **parameters}.items():
        fmu.set(name, value)
    return fmu


def set_vector(fmu, name, values):
    for i, value in enumerate(values, start=1):
        fmu.set(f"{name}[{i}]", float(value))


def set_samples(fmu, drive, k, late_rows=0):
    """The aids that came with row k; fixes come the given number of rows after they were valid."""
    samples, fixes = drive
    t_s = float(samples.t_s[k])
    set_vector(fmu, "gyro.rate", samples.rate_b_rad_s[k])
    set_vector(fmu, "accel.force", samples.force_b_m_s2[k])
    came = dict.fromkeys(("gyro", "accel"), (t_s, None)) | fixes.get(k - late_rows, {})
    for name, (valid_s, values) in came.items():
        if name == "gnss":
            for part, value in zip(("latitude", "longitude", "height"), values):
                fmu.set(f"gnss.{part}", float(value))
        elif name == "gnssvel":
            set_vector(fmu, "gnssvel.velocity", values[:3])
        elif name == "mag":
            set_vector(fmu, "mag.field", values[:3])
        if values is not None:
            fmu.set(f"{name}.valid", True)
            if name != "mag":
                set_vector(fmu, f"{name}.sigma", values[3:])
        fmu.set(f"{name}.t_meas", valid_s)
        fmu.set(f"{name}.sample", fmu.get(f"{name}.sample") + 1)


def shown(fmu):
    numbers = [fmu.get(f"nav.{name}") for name in ("latitude", "longitude", "height")] + [fmu.get("align.heading_second_share")]
    vectors = [fmu.get(v) for name in VECTORS for v in fmu.variables if v.startswith(f"{name}[")]
    counts = [fmu.get(f"count.{name}") for name in ("imu_used", "gnss_used", "gnssvel_used", "mag_used", "gnss_inflated", "late")]
    return [*numbers, *vectors, *counts, str(fmu.get("align.phase")), fmu.get("align.heading_ready"), fmu.get("innov.gnss[2]")]


def driven(version, drive, every=1, late_rows=0, rows=LENGTH, **parameters):
    """Co-Simulation; the outputs at the end."""
    samples, _ = drive
    with opened(version, **parameters) as fmu:
        fmu.initialise(float(samples.t_s[0]))
        for k in range(rows):
            set_samples(fmu, drive, k, late_rows)
            begin, end = float(samples.t_s[k]), float(samples.t_s[k + 1])
            for i in range(every):
                fmu.do_step(begin + i * (end - begin) / every, (end - begin) / every)
        return shown(fmu), fmu.get("count.missed")


def take_row(ins, drive, k, late_rows=0):
    samples, fixes = drive
    ins.push_imu(samples.t_s[k], samples.rate_b_rad_s[k], samples.force_b_m_s2[k])
    for name, (valid_s, values) in fixes.get(k - late_rows, {}).items():
        if name == "gnss":
            ins.push_position(valid_s, *values[:3], values[3:])
        elif name == "gnssvel":
            ins.push_velocity(valid_s, values[:3], values[3:])
        else:
            ins.push_mag(valid_s, values[:3])


def library(drive, rows=LENGTH, **options):
    samples, _ = drive
    ins = hnav.Ins("industrial", solver="closed_form", **options)
    for k in range(rows):
        take_row(ins, drive, k)
        ins.advance(samples.t_s[k + 1])
    return ins


def expected(ins):
    now, seen = ins.navigation(), ins.diagnostics()
    vectors = [float(x) for field in VECTORS.values() for x in getattr(now, field)]
    counts = [
        seen.used["gyro"],
        seen.used["position"],
        seen.used["velocity"],
        seen.used["mag"],
        seen.gated["position"],
        seen.late,
    ]
    phase = PHASES.index(now.phase)
    numbers = [now.latitude_rad, now.longitude_rad, now.height_m, now.heading_second_share]
    return [*numbers, *vectors, *counts, str(phase), now.heading_ready, float(ins.innovation("position").value[1])]


@versions
def test_the_filter_is_the_library_bit_for_bit_on_every_communication_grid(drive, version):
    ins = library(drive)
    assert ins.navigation().phase == "navigating" and ins.diagnostics().used["position"] > 50
    assert driven(version, drive) == (expected(ins), 0)
    if version == 3:
        assert driven(version, drive, every=3) == (expected(ins), 0)


@versions
def test_a_magnetometer_is_an_input_like_the_others(version):
    with_field, rows = driven_by(magnetometer=True), 1500
    ins = library(with_field, rows)
    assert ins.diagnostics().used["mag"] > 80
    assert driven(version, with_field, rows=rows) == (expected(ins), 0)


def exchanged(fmu, drive, rows, rtol=1e-6, late_rows=0):
    """Model Exchange by fmpy's CVODE: for each row, stops just after its event, and again just before the next."""
    samples, _ = drive
    f = fmu.fmu
    fmu.initialise(float(samples.t_s[0]))
    solver = fmu.solver(float(samples.t_s[0]), rtol)
    for k in range(rows):
        begin, end = float(samples.t_s[k]), float(samples.t_s[k + 1])
        set_samples(fmu, drive, k, late_rows)
        fmu.update_discrete_states()
        yield k, True
        fmu.call(f.enterContinuousTimeMode)
        solver.reset(begin)
        fmu.call(solver.step, begin, end)
        fmu.call(f.setTime, end)
        fmu.call(f.completedIntegratorStep)
        yield k, False
        fmu.call(f.enterEventMode)


MOTION = ("nav.latitude", "nav.longitude", "nav.height", *(f"nav.velocity[{i}]" for i in (1, 2, 3)),
          *(f"att.euler[{i}]" for i in (1, 2, 3)))  # fmt: skip


def off_in_sigmas(fmu, now):
    """The motion outputs of an FMU against the library: the largest difference, as a part of its sigma."""
    metres = earth.EQUATOR_M * np.array([1, np.cos(now.latitude_rad)])
    off = np.array([fmu.get(v) for v in MOTION]) - [
        now.latitude_rad, now.longitude_rad, now.height_m, *now.velocity_n_m_s, *now.euler_rad
    ]  # fmt: skip
    off[:2] *= metres
    return np.abs(off / [*now.sigma_position_m, *now.sigma_velocity_m_s, *now.sigma_rotation_rad]).max()


@pytest.mark.parametrize("rtol, close", [(1e-8, 2e-3), (1e-11, 1e-5)])
@versions
def test_an_importers_solver_finds_what_co_simulation_finds_through_every_phase(drive, version, rtol, close):
    samples, _ = drive
    ins, phases = hnav.Ins("industrial", solver="erkstep", solver_rtol=1e-12, solver_atol=1e-12), set()
    with opened(version, exchange=True) as fmu:
        for k, at_event in exchanged(fmu, drive, LENGTH, rtol):
            if at_event:
                take_row(ins, drive, k)
            elif k % 100:
                continue
            ins.advance(samples.t_s[k + (not at_event)])
            now = ins.navigation()
            phases.add(now.phase)
            if k % 100 or now.phase in ("waiting", "levelling"):
                continue
            assert off_in_sigmas(fmu, now) < close, (k, at_event)
            if at_event:
                sigma = [fmu.get(f"{name}[{i}]") for name in ("nav.sigma_position", "att.sigma") for i in (1, 2, 3)]
                np.testing.assert_allclose(sigma, [*now.sigma_position_m, *now.sigma_rotation_rad], rtol=close)
                assert fmu.get("align.heading_ready") == now.heading_ready
        seen = ins.diagnostics()
        assert phases == {"levelling", "any_heading", "navigating"} and seen.used["position"] > 50
        for name, sensor in (("imu", "gyro"), ("gnss", "position"), ("gnssvel", "velocity")):
            assert fmu.get(f"count.{name}_used") == seen.used[sensor]


@versions
def test_displacement_velocity_and_attitude_are_the_continuous_states_and_flow_between_events_alone(drive, version):
    with opened(version, exchange=True) as fmu:
        derivatives = [v for v in fmu.description.modelVariables if v.derivative is not None]
        assert [v.derivative.name for v in derivatives] == [
            *(f"state.displacement[{i}]" for i in (1, 2, 3)), *(f"state.velocity[{i}]" for i in (1, 2, 3)),
            *(f"state.q[{i}]" for i in (1, 2, 3, 4)),
        ]  # fmt: skip
        nominals, states = (C.c_double * 10)(), (C.c_double * 10)()
        sigma, before = [f"att.sigma[{i}]" for i in (1, 2, 3)] + [f"nav.sigma_velocity[{i}]" for i in (1, 2, 3)], None
        for k, at_event in exchanged(fmu, drive, 700):
            if k < 650:
                continue
            now = [fmu.get(name) for name in sigma]
            assert at_event or now == before
            before = now
            fmu.fmu.getContinuousStates(states, 10)
            assert [fmu.get(v.derivative.name) for v in derivatives] == list(states)
            assert [fmu.get(f"der(state.displacement[{i}])") for i in (1, 2, 3)] == list(states)[3:6]
        fmu.fmu.getNominalsOfContinuousStates(nominals, 10)
        assert list(nominals) == [1.0] * 10 and np.linalg.norm(list(states)[6:]) == pytest.approx(1, abs=1e-6)


@versions
def test_in_model_exchange_late_fixes_are_waited_for_too_and_the_filter_integrates_inside(drive, version):
    samples, _ = drive
    late_rows, rows = round(100 * LATE_S), 1000
    ins = hnav.Ins("industrial", solver="closed_form", horizon_s=0.2)
    with opened(version, exchange=True, **{"timing.horizon_s": 0.2}) as fmu:
        for k, at_event in exchanged(fmu, drive, rows, late_rows=late_rows):
            if not at_event:
                continue
            take_row(ins, drive, k, late_rows)
            ins.advance(samples.t_s[k])
            if ins.navigation().phase not in ("waiting", "levelling"):
                assert off_in_sigmas(fmu, ins.navigation()) == 0, k
        assert fmu.get("count.late") == 0 and fmu.get("count.gnss_used") == ins.diagnostics().used["position"] > 20


@versions
def test_late_fixes_that_are_refused_are_logged_once_with_the_cure(drive, version):
    samples, _ = drive
    with opened(version) as fmu:
        fmu.initialise(float(samples.t_s[0]))
        for k in range(600):
            set_samples(fmu, drive, k, late_rows=20)
            fmu.do_step(float(samples.t_s[k]), float(samples.t_s[k + 1] - samples.t_s[k]))
        assert fmu.get("count.late") > 10 and fmu.get("count.gnss_used") == 0
        assert len(fmu.messages) == 1 and "is late" in fmu.messages[0] and "horizon_s" in fmu.messages[0]


@versions
def test_a_reset_in_model_exchange_brings_the_importers_states_back(drive, version):
    with opened(version, exchange=True) as fmu:
        for k, at_event in exchanged(fmu, drive, 702):
            if at_event and k == 700:
                assert fmu.get("align.phase") > 1 and fmu.get("state.velocity[1]") != 0
                fmu.set("reset", True)
                fmu.update_discrete_states()
                states = (C.c_double * 10)()
                fmu.fmu.getContinuousStates(states, 10)
                assert list(states) == [0.0] * 6 + [1.0, 0.0, 0.0, 0.0]
                assert fmu.get("count.imu_used") == 0 and fmu.get("att.sigma[3]") == np.pi


@versions
def test_a_sample_stamped_later_than_it_came_is_an_event_in_time(drive, version):
    samples, _ = drive
    with opened(version, exchange=True) as fmu:
        fmu.initialise(0.0)
        set_samples(fmu, drive, 0)
        for name in ("gyro", "accel"):
            fmu.set(f"{name}.t_meas", 0.25)
        assert fmu.update_discrete_states() == 0.25
        assert fmu.get("count.imu_used") == 0
        fmu.call(fmu.fmu.enterContinuousTimeMode)
        fmu.call(fmu.fmu.setTime, 0.25)
        fmu.call(fmu.fmu.enterEventMode)
        assert fmu.update_discrete_states() is None
        assert fmu.get("count.imu_used") == 1


@versions
def test_late_fixes_are_waited_for_and_give_the_same_estimate(drive, version):
    # The end lies between a late fix and the next.
    samples, fixes = drive
    late_rows = round(100 * LATE_S)
    last = max(k for k in fixes if k < 1000)
    rows, punctual = last + late_rows + 2, {"timing.horizon_s": 0.2}
    assert not any(last < k < rows for k in fixes)
    one, other = (driven(version, drive, late_rows=late, rows=rows, **punctual)[0] for late in (0, late_rows))
    assert one == other


@versions
def test_fmpy_and_the_schemas_find_nothing_to_complain_about(version):
    assert_fits_the_standard(fmu_path("Ins", version), version)


def test_both_versions_have_the_same_variables():
    names = [
        [(v.name, v.causality) for v in fmpy.read_model_description(str(fmu_path("Ins", v))).modelVariables] for v in VERSIONS
    ]
    assert names[0] == names[1]


def test_parameters_are_the_options_of_the_library():
    variables = {v.name: v for v in fmpy.read_model_description(str(fmu_path("Ins", 3))).modelVariables}
    defaults = Options("ins", "consumer")
    for name, info in option_table("ins").items():
        place = f"{info.group}.{info.name}"
        variable = variables.get(place) or variables.get(f"{place}[1]") or variables.get(info.name)
        assert variable is not None and variable.causality == "parameter", name
        if not info.choices:
            default = np.ravel(getattr(defaults, name))[0]
            assert float(variable.start) == default, name
    assert [item.name for item in variables["preset"].declaredType.items] == list(INS_PRESETS)


@versions
def test_before_there_is_a_tilt_the_outputs_say_so(version):
    with opened(version) as fmu:
        fmu.initialise()
        fmu.do_step(0.0, 0.01)
        assert (fmu.get("att.q[1]"), fmu.get("att.sigma[3]"), fmu.get("nav.sigma_position[1]")) == (1.0, np.pi, 1e7)
        assert (
            not fmu.get("align.tilt_ready")
            and np.isfinite([fmu.get(v) for v in fmu.variables if v.startswith(("nav.", "att.", "bias."))]).all()
        )


@versions
def test_reset_and_a_saved_state_bring_back_what_was(drive, version):
    samples, _ = drive
    half = 500

    def go(fmu, rows):
        for k in rows:
            set_samples(fmu, drive, k)
            fmu.do_step(float(samples.t_s[k]), float(samples.t_s[k + 1] - samples.t_s[k]))
        return shown(fmu)

    with opened(version) as fmu:
        fmu.initialise(float(samples.t_s[0]))
        go(fmu, range(half))
        state = (fmu.fmu.getFMUState if fmu.fmi3 else fmu.fmu.getFMUstate)()
        first = go(fmu, range(half, 2 * half))
        (fmu.fmu.setFMUState if fmu.fmi3 else fmu.fmu.setFMUstate)(state)
        assert go(fmu, range(half, 2 * half)) == first
        (fmu.fmu.freeFMUState if fmu.fmi3 else fmu.fmu.freeFMUstate)(state)
        fmu.set("reset", True)
        fmu.do_step(float(samples.t_s[2 * half]), 0.01)
        assert fmu.get("count.imu_used") == 0 and fmu.get("att.sigma[3]") == np.pi


@versions
def test_impossible_parameters_stop_initialisation_with_their_names(version):
    for name, value in (("timing.horizon_s", 1e9), ("gnss.period", 1e-9)):
        with pytest.raises(HnavError, match=name.split(".")[1] if name.startswith("timing") else name), opened(version) as fmu:
            fmu.set(name, value)
            fmu.initialise()


@pytest.mark.parametrize("version, kind", [(2, "CoSimulation"), (3, "ModelExchange")])
def test_simulate_fmu_runs_the_example_input(version, kind, tmp_path):
    path = fmu_path("Ins", version)
    folder = fmpy.extract(str(path), str(tmp_path))
    signal = np.genfromtxt(f"{folder}/resources/example_input.csv", delimiter=",", names=True, deletechars="")
    signal = signal[signal["time"] <= 40]
    result = simulate_fmu(folder, fmi_type=kind, input=signal, stop_time=40.0, output_interval=0.01,
                          output=["att.heading", "att.sigma[3]", "align.phase", "nav.velocity[1]"])  # fmt: skip
    end = result[-1]
    speed = np.hypot(signal["gnssvel.velocity[1]"], signal["gnssvel.velocity[2]"])[-1]
    course = np.arctan2(signal["gnssvel.velocity[2]"], signal["gnssvel.velocity[1]"])[-1]
    assert end["align.phase"] == PHASES.index("navigating") and end["att.sigma[3]"] < np.radians(3)
    assert abs(end["att.heading"] - course) < 3 * end["att.sigma[3]"]
    assert abs(end["nav.velocity[1]"] - speed * np.cos(course)) < 0.5


@versions
def test_a_value_in_a_wrong_unit_is_said_once_with_the_right_one(version):
    with opened(version) as fmu:
        for _ in range(2):
            count = len(fmu.messages)
            fmu.set("sampling_mode", "auto")
            fmu.set("gnss.latitude", 48.1)
            fmu.set("gnss.valid", True)
            fmu.initialise()
            for k in range(50):
                fmu.do_step(0.01 * k, 0.01 * (k + 1) - 0.01 * k)
            said = fmu.messages[count:]
            assert len(said) == 1 and "latitude of 48.1: it must be in rad" in said[0] and "not used" in said[0]
            assert fmu.get("count.gnss_used") == 0
            fmu.call(fmu.fmu.reset)
