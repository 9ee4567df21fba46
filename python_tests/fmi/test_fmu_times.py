"""Times far from 0, corners, steps and periods that are too small or too large, and the cost of a step whose outputs are not read."""

import ctypes as C
import math

import fmpy
import numpy as np
import pytest

from hnav.errors import HnavError
from hnav.fmi.fmus import Fmu, fmu_path

VERSIONS = (2, 3)
STARTS = (0.0, 1e7, 1.7e9)  # the last: seconds since 1970
versions = pytest.mark.parametrize("version", VERSIONS, ids=lambda v: f"fmi{v}")
FILTERS = ("Hrekf", "Ahrs")
SAMPLE = {
    **{f"gyro.rate[{i}]": v for i, v in enumerate((0.01, -0.02, 0.3), start=1)},
    **{f"accel.force[{i}]": v for i, v in enumerate((0.1, -3.3, -9.2), start=1)},
    **{f"mag.field[{i}]": v for i, v in enumerate((1.4e-5, 0.6e-5, 4.7e-5), start=1)},
}
COUNTS = {
    "Hrekf": ("count.gyro_used", "count.accel_used", "count.missed"), "Ahrs": ("count.gyro_used", "count.mag_used", "count.missed"),
    "InsErrorFilterLateral": ("count.samples", "count.missed"), "AircraftInsLateral": ("z.sample",),
    "ImuMagSensor": ("gyro.sample", "mag.sample", "count.gyro.missed"), "Pendulum": ("measured.sample",),
    "Ins": ("count.imu_used", "count.missed"), "Baro": ("baro.sample", "count.missed"), "Wheel": ("wheel.sample", "count.missed"),
}  # fmt: skip
SENSORS = ("ImuMagSensor", "Baro", "Wheel")  # in Co-Simulation alone


def set_sample(fmu: Fmu) -> None:
    for name, value in SAMPLE.items():
        if name in fmu.variables and fmu.variables[name].causality == "input":
            fmu.set(name, value)


# --------------------------------------------------------------------------------------------- times since 1970


def counts_in_co_simulation(name: str, version: int, start_s: float, step_s: float, mode: str) -> list[int]:
    with Fmu(fmu_path(name, version)) as fmu:
        if "sampling_mode" in fmu.variables:
            fmu.set("sampling_mode", mode)
        fmu.initialise(start_s, start_s + 3)
        set_sample(fmu)
        points = start_s + step_s * np.arange(round(3 / step_s) + 1)
        for t, end in zip(points[:-1], points[1:]):
            fmu.do_step(float(t), float(end - t))
        return [fmu.get(count) for count in COUNTS[name]]


@pytest.mark.parametrize("name", COUNTS)
@versions
def test_a_clock_that_counts_from_1970_loses_no_sample_in_co_simulation(name, version):
    for step_s, mode in ((0.01, "periodic"), (0.0025, "periodic"), (0.05, "held")):
        expected = counts_in_co_simulation(name, version, 0.0, step_s, mode)
        assert expected[0] > 25
        for start_s in STARTS[1:]:
            assert counts_in_co_simulation(name, version, start_s, step_s, mode) == expected, (start_s, step_s)


def counts_in_model_exchange(name: str, version: int, start_s: float) -> list[int]:
    """By an importer that goes from event to event, with Euler's method between them."""
    with Fmu(fmu_path(name, version), model_exchange=True) as fmu:
        f = fmu.fmu
        nx = sum(v.derivative is not None for v in fmu.description.modelVariables)
        fmu.initialise(start_s)
        set_sample(fmu)
        x, dx, t = (C.c_double * nx)(), (C.c_double * nx)(), start_s
        while t < start_s + 2.995:
            next_s = fmu.update_discrete_states()
            assert next_s > t
            fmu.call(f.enterContinuousTimeMode)
            f.getContinuousStates(x, nx)
            (f.getContinuousStateDerivatives if fmu.fmi3 else f.getDerivatives)(dx, nx)
            for i in range(nx):
                x[i] += (next_s - t) * dx[i]
            t = next_s
            fmu.call(f.setTime, t)
            f.setContinuousStates(x, nx)
            fmu.call(f.enterEventMode)
        fmu.update_discrete_states()
        return [fmu.get(count) for count in COUNTS[name]]


@pytest.mark.parametrize("name", [n for n in COUNTS if n not in SENSORS])
@versions
def test_a_clock_that_counts_from_1970_loses_no_sample_in_model_exchange(name, version):
    expected = counts_in_model_exchange(name, version, 0.0)
    assert expected[0] > 25
    for start_s in STARTS[1:]:
        assert counts_in_model_exchange(name, version, start_s) == expected, start_s


@versions
def test_the_turntable_turns_at_the_right_time_far_from_0(version):
    def yaw(start_s: float) -> list[float]:
        with Fmu(fmu_path("Turntable", version)) as fmu:
            fmu.set("yaw.motion", "triangle")
            fmu.set("yaw.amplitude_rad", 0.5)
            fmu.set("yaw.start_s", start_s + 1.0)
            fmu.initialise(start_s)
            out = []
            for k in range(60):
                fmu.do_step(start_s + 0.1 * k, 0.1)
                out.append(fmu.get("truth.euler[3]"))
            return out

    # From 1e7 s on numbers lie 2e-9 s apart.
    np.testing.assert_allclose(yaw(1e7), yaw(0.0), atol=1e-7)


@pytest.mark.parametrize("name", ["filter", "turntable", "aircraft"])
def test_a_system_of_fmus_runs_since_1970_as_from_zero(name):
    from hnav.systems.master import run_system
    from hnav.systems.ssp_reader import read_system, system_path

    found = []
    for start_s in (0.0, 1.7e9):
        with read_system(system_path(name)) as system:
            system.start_s = start_s
            record = run_system(system, start_s + 2, system.step_s, record=("*_used", "*.missed", "augmented_*"))
            assert record.failure == "" and not any(record.lost.values())
            # The motion of the turntable is one of absolute time, and gamma depends on it.
            found.append({n: column[-1] for n, column in record.columns.items() if not n.endswith(("gamma_used", "post.t"))})
    assert found[0] == found[1] and found[0]


# --------------------------------------------------------------------------------------------- corners


TRIANGLE = {"yaw.motion": 3, "yaw.amplitude_rad": 0.5, "yaw.rate_rad_s": 1.0, "pitch.motion": 1, "pitch.amplitude_rad": 0.4,
            "pitch.rate_rad_s": 0.7, "pitch.start_s": 0.3}  # fmt: skip


def changed(fmu: Fmu) -> tuple[bool, float]:
    answers = fmu.call(fmu.fmu.updateDiscreteStates if fmu.fmi3 else fmu.fmu.newDiscreteStates)
    return bool(answers[3]), answers[-1]


@versions
def test_an_integrator_restarts_where_the_rate_jumps(version):
    with Fmu(fmu_path("Turntable", version), model_exchange=True) as fmu:
        for name, value in TRIANGLE.items():
            fmu.set(name, value)
        fmu.initialise()
        said, corner_s = changed(fmu)
        assert not said
        for _ in range(6):
            fmu.call(fmu.fmu.enterContinuousTimeMode)
            fmu.call(fmu.fmu.setTime, corner_s)
            fmu.call(fmu.fmu.enterEventMode)
            said, corner_s = changed(fmu)
            assert said
        assert changed(fmu)[0] is False  # asked again, nothing has jumped


@versions
def test_integrators_cross_the_corners_at_every_tolerance(version):
    with Fmu(fmu_path("Turntable", version)) as exact:
        for name, value in TRIANGLE.items():
            exact.set(name, value)
        exact.initialise()
        exact.do_step(0, 20)
        q = np.array([exact.get(f"truth.q[{i}]") for i in range(1, 5)])
    for tolerance in (1e-6, 1e-7, 1e-8, 1e-9):
        result = fmpy.simulate_fmu(
            str(fmu_path("Turntable", version)), fmi_type="ModelExchange", stop_time=20, relative_tolerance=tolerance,
            output_interval=0.5, start_values=TRIANGLE, output=[f"truth.q[{i}]" for i in range(1, 5)],
        )  # fmt: skip
        found = np.array([result[f"truth.q[{i}]"][-1] for i in range(1, 5)])
        assert np.abs(found - q).max() < 300 * tolerance, tolerance


# --------------------------------------------------------------------------------------------- honest bounds


REFUSED = [
    ("Hrekf", {"gyro.period": 1e-9}, "gyro.period"), ("Ahrs", {"mag.period": 5e-324}, "mag.period"),
    ("AircraftInsLateral", {"interval": 1e-9}, "interval"), ("InsErrorFilterLateral", {"interval": 0.0}, "interval"),
    ("ImuMagSensor", {"gyro.period_s": 1e-12}, "gyro.period_s"), ("Turntable", {"yaw.rate_rad_s": 5e-324}, "yaw.rate_rad_s"),
    ("Turntable", {"yaw.motion": 3, "yaw.amplitude_rad": 5e-324}, "yaw.amplitude_rad"),
]  # fmt: skip


@pytest.mark.parametrize("name, parameters, named", REFUSED)
@versions
def test_what_is_too_small_is_refused_by_name(name, parameters, named, version):
    with Fmu(fmu_path(name, version)) as fmu, pytest.raises(HnavError, match=named):
        for parameter, value in parameters.items():
            fmu.set(parameter, value)
        fmu.initialise()


@pytest.mark.parametrize("name", [*COUNTS, "Turntable", "Observer", "Vehicle"])
@versions
def test_times_beyond_1e12_s_are_refused_everywhere(name, version):
    for start_s in (1e15, -1e13):
        with Fmu(fmu_path(name, version)) as fmu, pytest.raises(HnavError, match="startTime"):
            fmu.initialise(start_s)
    with Fmu(fmu_path(name, version)) as fmu:
        fmu.initialise()
        with pytest.raises(HnavError, match="beyond 1e"):
            fmu.do_step(0, 1e13)
    if name not in SENSORS:
        with Fmu(fmu_path(name, version), model_exchange=True) as fmu:
            fmu.initialise()
            with pytest.raises(HnavError, match="beyond 1e"):
                fmu.call(fmu.fmu.setTime, 2e12)


@versions
def test_a_step_with_more_samples_than_anybody_waits_for_is_refused(version):
    with Fmu(fmu_path("AircraftInsLateral", version)) as fmu:
        fmu.initialise()
        with pytest.raises(HnavError, match="more than 50000 samples at interval = 0.1 s"):
            fmu.do_step(0, 1e7)
        fmu.do_step(0, 1)
        assert fmu.get("z.sample") == 11


# --------------------------------------------------------------------------------------------- cost


@pytest.mark.parametrize("name", FILTERS)
@versions
def test_the_look_ahead_is_computed_for_those_who_read_it(name, version):
    """Half the evaluations of the flow, and the same estimates."""

    def run(read: bool) -> tuple[int, list[float]]:
        with Fmu(fmu_path(name, version)) as fmu:
            fmu.initialise()
            set_sample(fmu)
            for k in range(200):
                fmu.do_step(0.01 * k, 0.01)
                if read:
                    assert math.isfinite(fmu.get("att.q[1]"))
            shown = [fmu.get(v) for v in ("post.q[1]", "post.q[4]", "att.q[1]", "att.q[4]", "att.sigma[3]", "cov.P[1,1]")]
            return fmu.get("solver.rhs_evals"), shown

    (few, unread), (many, seen) = run(False), run(True)
    assert unread == seen
    assert few < 0.55 * many


@pytest.mark.parametrize("name", FILTERS)
@versions
def test_states_go_back_and_forth_while_samples_wait(name, version):
    """With a horizon several solved events are part of the state, and how many changes."""

    def snapshot():
        return f.getFMUState() if fmu.fmi3 else f.getFMUstate()

    def go(first: int, last: int) -> list[float]:
        for k in range(first, last):
            fmu.set("gyro.rate[3]", 0.3 + 0.01 * math.sin(k))
            fmu.do_step(0.01 * k, 0.01)
        return [fmu.get(v) for v in ("post.q[1]", "post.q[4]", "att.q[4]", "count.gyro_used", "solver.rhs_evals")]

    with Fmu(fmu_path(name, version)) as fmu:
        f = fmu.fmu
        fmu.set("timing.horizon_s", 0.05)
        fmu.initialise()
        set_sample(fmu)
        states, ends = [], []
        for part in range(4):  # the first are shorter than the horizon
            states.append(snapshot())
            ends.append(go(3 * part, 3 * part + 3))
        for part in (2, 0, 3, 1):
            (f.setFMUState if fmu.fmi3 else f.setFMUstate)(states[part])
            assert go(3 * part, 3 * part + 3) == ends[part]
        content = f.serializeFMUState(states[2]) if fmu.fmi3 else f.serializeFMUstate(states[2])
    with Fmu(fmu_path(name, version)) as fmu:  # another instance, with other parameters until then
        f = fmu.fmu
        fmu.initialise()
        state = f.deserializeFMUState(content) if fmu.fmi3 else f.deSerializeFMUstate(content)
        (f.setFMUState if fmu.fmi3 else f.setFMUstate)(state)
        assert go(6, 9) == ends[2]


@pytest.mark.parametrize("name", ["Ahrs", "Ins"])
@pytest.mark.parametrize(
    "stamp", [lambda t_s: 0.0, lambda t_s: 1.7e9 + t_s, lambda t_s: 1e3 * t_s], ids=["none", "since 1970", "ms"]
)
def test_counted_samples_without_a_time_of_the_simulation_are_logged_once(name, stamp):
    with Fmu(fmu_path(name, 3)) as fmu:
        fmu.initialise()
        for k in range(120):
            for sensor in ("gyro", "accel"):
                fmu.set(f"{sensor}.sample", k + 1)
                fmu.set(f"{sensor}.t_meas", stamp(0.01 * k))
            fmu.set("accel.force[3]", -9.81)
            fmu.do_step(0.01 * k, 0.01)
        assert sum(".sample counts samples whose t_meas does not change" in line for line in fmu.messages) == 1
