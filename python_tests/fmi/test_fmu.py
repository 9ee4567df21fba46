"""The FMUs as an importer meets them: description, binary, rules of the standard, complete state, many instances."""

import ctypes as C
import math
import shutil
import subprocess
import sys
import threading
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest

from checkout import TOP, in_another_process
from hnav.errors import HnavError
from hnav.fmi.fmus import Fmu, fmu_path
from importing import assert_fits_the_standard, step_once

VERSIONS = (2, 3)
FLAVOURS = [(version, exchange) for version in VERSIONS for exchange in (False, True)]
flavours = pytest.mark.parametrize(
    "version, exchange", FLAVOURS, ids=lambda v: {2: "fmi2", 3: "fmi3", False: "cs", True: "me"}.get(v, v)
)
versions = pytest.mark.parametrize("version", VERSIONS, ids=lambda v: f"fmi{v}")

INPUTS = {
    "gyro": ("gyro.rate", (0.01, -0.02, 0.3)),
    "accel": ("accel.force", (0.1, -3.3, -9.2)),
    "mag": ("mag.field", (1.4e-5, 0.6e-5, 4.7e-5)),
}


MODEL = "Hrekf"


@pytest.fixture(params=("Hrekf", "Ahrs"), autouse=True)
def model(request, monkeypatch):
    """Every test here runs on each attitude filter."""
    monkeypatch.setattr(sys.modules[__name__], "MODEL", request.param)
    return request.param


ONE_SAMPLE = {"start.start_samples": 1}
"""Started by the first sample."""


def opened(version: int, exchange: bool = False, **parameters) -> Fmu:
    """Sampled periodically unless a parameter says otherwise: these samples have counters, which auto would follow."""
    fmu = Fmu(fmu_path(MODEL, version), model_exchange=exchange)
    sample_periodically(fmu)
    for name, value in parameters.items():
        fmu.set(name, value)
    return fmu


def sample_periodically(fmu: Fmu) -> None:
    if "sampling_mode" in fmu.variables:
        fmu.set("sampling_mode", 0)


def states(fmu: Fmu) -> int:
    return sum(v.derivative is not None for v in fmu.description.modelVariables)


def set_sample(fmu: Fmu, k: int, t_s: float) -> None:
    """Sample k of every sensor, a little different each time."""
    for i, (prefix, (name, value)) in enumerate(INPUTS.items()):
        for axis in range(3):
            fmu.set(f"{name}[{axis + 1}]", value[axis] * (1 + 0.01 * math.sin(k + i + axis)))
        fmu.set(f"{prefix}.t_meas", t_s)
        fmu.set(f"{prefix}.sample", k + 1)


def posterior(fmu: Fmu) -> list[float]:
    return [fmu.get(f"post.q[{i}]") for i in range(1, 5)] + [fmu.get(f"post.bias[{i}]") for i in range(1, 4)]


# --------------------------------------------------------------------------------------------- description


@versions
def test_fmpy_and_the_schemas_find_nothing_to_complain_about(version):
    assert_fits_the_standard(fmu_path(MODEL, version), version)


def test_both_versions_have_the_same_variables():
    two, three = (fmpy.read_model_description(str(fmu_path(MODEL, v))).modelVariables for v in VERSIONS)
    assert [(v.name, v.causality, v.variability, v.unit) for v in two] == [
        (v.name, v.causality, v.variability, v.unit) for v in three
    ]


@versions
def test_the_archive_holds_documentation_licences_and_an_example_input(version):
    with zipfile.ZipFile(fmu_path(MODEL, version)) as archive:
        names = set(archive.namelist())
        page = archive.read("documentation/index.html").decode()
    assert {"documentation/licenses/license.txt", "documentation/licenses/SUNDIALS.txt", "resources/example_input.csv"} <= names
    assert ({"model.png"} if version == 2 else {"terminalsAndIcons/icon.png", "terminalsAndIcons/icon.svg"}) <= names
    assert "att.q[1]" in page and "sampling_mode" in page


# --------------------------------------------------------------------------------------------- binary


@versions
def test_the_binary_is_self_contained_and_holds_nothing_of_its_build(version, tmp_path):
    with zipfile.ZipFile(fmu_path(MODEL, version)) as archive:
        name = next(n for n in archive.namelist() if n.endswith(".so"))
        binary = Path(archive.extract(name, tmp_path))
    symbols = [
        line.split()[-1] for line in subprocess.check_output(["nm", "-D", "--defined-only", binary], text=True).splitlines()
    ]
    assert symbols and all(s.startswith(f"fmi{version}") for s in symbols)
    needed = [line for line in subprocess.check_output(["readelf", "-d", binary], text=True).splitlines() if "NEEDED" in line]
    assert all("libc.so" in line or "libm.so" in line or "ld-linux" in line for line in needed), needed
    sections = subprocess.check_output(["size", "-A", binary], text=True).splitlines()
    writable = sum(int(line.split()[1]) for line in sections if line.split()[:1] in (["[.data]"], [".data"], [".bss"]))
    assert writable <= 64
    content = binary.read_bytes()
    assert str(TOP).encode() not in content


# --------------------------------------------------------------------------------------------- sampling


@versions
def test_the_same_samples_give_the_same_bits_on_every_communication_grid(version):
    """Samples every 10 ms, delivered at the next point with their t_meas."""
    rng = np.random.default_rng(1)
    grids = {
        "to the sample": np.arange(301) * 0.01,
        "3.7 ms": np.arange(0, 3.01, 0.0037),
        "2.5 ms": np.arange(0, 3.01, 0.0025),
        "random": np.r_[0, np.cumsum(rng.uniform(1e-4, 0.0099, 700))],
    }
    results = {}
    for name, points in grids.items():
        with opened(version, sampling_mode=1, **{"robust.gamma_mode": 3}) as fmu:
            fmu.initialise()
            delivered = -1
            estimates = {}
            for t, end in zip(points[:-1], points[1:]):
                k = min(math.floor(t / 0.01 + 1e-9), 290)
                if k > delivered:
                    assert k == delivered + 1, name
                    set_sample(fmu, k, k * 0.01)
                    delivered = k
                fmu.do_step(t, end - t)
                estimates[delivered] = posterior(fmu)
            assert fmu.get("count.late") == 0 and fmu.get("count.missed") == 0
        results[name] = estimates
    for name, estimates in results.items():
        assert [estimates[k] for k in range(250)] == [results["to the sample"][k] for k in range(250)], name


@versions
def test_periodic_sampling_takes_each_period_once_and_counts_what_a_coarse_step_lost(version):
    for step, missed in ((0.01, 0), (0.003, 0), (0.0025, 0), (0.05, 4 * 19 * 3)):
        with opened(version, **{"aid.period": 0.0}) as fmu:
            fmu.initialise()
            set_sample(fmu, 0, 0)
            n = round(1 / step)
            for k in range(n):
                fmu.do_step(k * step, (k + 1) * step - k * step)
            used = [fmu.get(f"count.{s}_used") for s in ("gyro", "accel", "mag")]
            points = len({math.floor(k * step / 0.01 + 1e-9) for k in range(n)})
            assert used == [points] * 3, step
            assert fmu.get("count.missed") == missed, step


@versions
def test_awkward_steps_never_stall_or_drift(version):
    for step in (0.003, 0.0173, 1.0):
        with opened(version) as fmu:
            fmu.initialise()
            set_sample(fmu, 0, 0)
            t = 0.0
            for _ in range(200):  # the importer adds up, with all its rounding
                fmu.do_step(t, step)
                t += step
            assert fmu.get("time") == t
            assert fmu.get("post.t") == pytest.approx(t - step, abs=max(step, 0.01) + 1e-9)
            assert fmu.get("align.started")


@versions
def test_samples_that_are_none_are_counted_and_stop_nothing(version):
    with opened(version) as fmu:
        fmu.initialise()
        set_sample(fmu, 0, 0)
        fmu.do_step(0, 0.01)
        before = posterior(fmu)
        for name in ("accel.force[1]", "mag.field[2]"):
            fmu.set(name, math.nan)
        fmu.set("gyro.rate[3]", math.inf)
        fmu.do_step(0.01, 0.01)
        assert fmu.get("count.non_finite") == 3
        assert posterior(fmu) == before
        set_sample(fmu, 1, 0)
        fmu.do_step(0.02, 0.01)
        assert posterior(fmu) != before


@versions
def test_a_counter_that_counts_before_initialisation_marks_a_sample(version):
    with opened(version, sampling_mode=1) as fmu:
        set_sample(fmu, 0, 0.0)  # a connected sensor has its first sample ready
        fmu.initialise()
        fmu.do_step(0, 0.01)
        assert fmu.get("count.accel_used") == 1 and fmu.get("count.missed") == 0


@versions
def test_a_sample_stamped_later_than_it_came_waits_for_its_time_event(version):
    with opened(version, exchange=True, sampling_mode=1, **ONE_SAMPLE) as fmu:
        fmu.initialise()
        set_sample(fmu, 0, 0.005)
        assert fmu.update_discrete_states() == pytest.approx(0.005)
        assert not fmu.get("align.started")
        fmu.call(fmu.fmu.enterContinuousTimeMode)
        fmu.call(fmu.fmu.setTime, 0.005)
        fmu.call(fmu.fmu.enterEventMode)
        assert fmu.update_discrete_states() is None
        assert fmu.get("align.started") and fmu.get("post.t") == 0.005


def test_event_mode_of_co_simulation_shows_the_sample_at_once():
    with opened(3) as fmu:
        f = fmu.fmu
        f.fmi3FreeInstance(f.component)
        f.instantiate(eventModeUsed=True, earlyReturnAllowed=True, logMessage=lambda *a: None)
        fmu.set(*next(iter(ONE_SAMPLE.items())))
        fmu.initialise()
        set_sample(fmu, 0, 0)
        assert fmu.update_discrete_states() == pytest.approx(0.01)
        assert fmu.get("align.started")
        f.enterStepMode()
        needed, terminate, early, last = f.doStep(0.0, 0.025)
        assert needed and early and last == pytest.approx(0.01)  # the next samples are due there
        f.enterEventMode()
        set_sample(fmu, 1, 0)
        fmu.update_discrete_states()
        assert fmu.get("count.accel_used") == 2


def test_the_intermediate_update_may_read_and_nothing_else():
    with opened(3) as fmu:
        f, seen = fmu.fmu, []

        def update(environment, t_s, _set_requested, get_allowed, *_):
            value = (C.c_double * 1)()
            read = f.dll.fmi3GetFloat64(f.component, fmu.references(["att.q[1]"]), C.c_size_t(1), value, C.c_size_t(1))
            written = f.dll.fmi3SetFloat64(f.component, fmu.references(["gyro.rate[1]"]), C.c_size_t(1), value, C.c_size_t(1))
            seen.append((t_s, bool(get_allowed), read, written))

        f.fmi3FreeInstance(f.component)
        f.instantiate(intermediateUpdate=update, logMessage=lambda *a: None)
        fmu.initialise()
        fmu.do_step(0, 0.01)
        fmu.do_step(0.01, 0.01)
        assert [t for t, *_ in seen] == pytest.approx([0.01, 0.02])
        assert all(allowed and read == 0 and written == 3 for _, allowed, read, written in seen)


@versions
def test_before_there_is_an_attitude_the_outputs_say_so(version):
    with opened(version) as fmu:
        f = fmu.fmu
        if fmu.fmi3:
            f.enterInitializationMode()
        else:
            f.setupExperiment()
            f.enterInitializationMode()
        assert [fmu.get(f"att.q[{i}]") for i in range(1, 5)] == [1, 0, 0, 0]
        assert fmu.get("att.sigma[1]") == pytest.approx(math.pi)
        f.exitInitializationMode()
        fmu.set("mag.valid", False)
        fmu.do_step(0, 0.01)
        assert [fmu.get(f"att.q[{i}]") for i in range(1, 5)] == [1, 0, 0, 0]
        assert fmu.get("cov.P[3,3]") == pytest.approx(math.pi**2)
        assert fmu.get("cov.P[4,4]") == pytest.approx(fmu.get("bias.gyro_sigma[1]") ** 2)


@flavours
def test_realignment_keeps_the_bias_and_its_sigma(version, exchange):
    precise = {
        "Hrekf": {"noise.accel_noise_per_sqrt_hz": 1e-3, "noise.mag_noise_per_sqrt_hz": 1e-3},
        "Ahrs": {"noise.velocity_noise_m_s_per_sqrt_hz": 1e-3, "noise.mag_azimuth_noise_per_sqrt_hz": 1e-4},
    }
    with opened(version, exchange, **precise[MODEL]) as fmu:
        fmu.initialise()
        solver = fmu.solver(0.0) if exchange else None

        for k in range(50):
            set_sample(fmu, k, 0)
            step_once(fmu, solver, k)
        bias, sigma = fmu.get("bias.gyro[3]"), fmu.get("bias.gyro_sigma[3]")
        assert abs(bias) > 1e-3 and sigma < 0.01
        fmu.set("realign", True)
        fmu.set("mag.valid", False)
        step_once(fmu, solver, 50)
        assert not fmu.get("align.started")
        assert fmu.get("bias.gyro[3]") == pytest.approx(bias, rel=1e-2)
        assert fmu.get("bias.gyro_sigma[3]") == pytest.approx(sigma, rel=1e-2)


@versions
def test_commands_act_on_the_rising_edge(version):
    with opened(version, **ONE_SAMPLE) as fmu:
        fmu.initialise()
        set_sample(fmu, 0, 0)
        for k in range(20):
            fmu.do_step(0.01 * k, 0.01)
        fmu.set("realign", True)
        fmu.set("mag.valid", False)
        fmu.do_step(0.2, 0.01)
        assert not fmu.get("align.started")  # no field, no heading to start with
        fmu.set("mag.valid", True)
        fmu.do_step(0.21, 0.01)
        assert fmu.get("align.started")
        used = fmu.get("count.accel_used")
        fmu.do_step(0.22, 0.01)  # still high: no second realignment
        assert fmu.get("align.started") and fmu.get("count.accel_used") == used + 1
        fmu.set("reset", True)
        fmu.do_step(0.23, 0.01)
        assert fmu.get("count.accel_used") == 1


@versions
def test_an_euler_importer_converges_at_its_order(version):
    """So the states of Model Exchange are real: the importer's integrator decides their accuracy.

    Euler's error is of first order, and in a quaternion all of that is in its length: the attitude alone converges at
    second order.
    """

    def turn(fmu: Fmu, k: int) -> None:
        set_sample(fmu, k, 0)
        for axis, rate in enumerate((3.0, -2.0, 4.0), start=1):
            fmu.set(f"gyro.rate[{axis}]", rate)

    def by_euler(step: float) -> np.ndarray:
        with opened(version, exchange=True) as fmu:
            fmu.initialise()
            f, nx = fmu.fmu, states(fmu)
            x, dx = (C.c_double * nx)(), (C.c_double * nx)()
            derivatives = f.getContinuousStateDerivatives if fmu.fmi3 else f.getDerivatives
            for k in range(10):
                turn(fmu, k)
                fmu.update_discrete_states()
                fmu.call(f.enterContinuousTimeMode)
                for i in range(round(0.01 / step)):
                    f.getContinuousStates(x, nx)
                    derivatives(dx, nx)
                    for j in range(nx):
                        x[j] += step * dx[j]
                    f.setTime(0.01 * k + step * (i + 1))
                    f.setContinuousStates(x, nx)
                f.setTime(0.01 * (k + 1))
                fmu.call(f.enterEventMode)
            return np.array(posterior(fmu)[:4])

    with opened(version) as inside:
        inside.initialise()
        for k in range(10):
            turn(inside, k)
            inside.do_step(0.01 * k, 0.01)
        exact = np.array(posterior(inside)[:4])
    errors = [np.abs(by_euler(step) - exact).max() for step in (1e-3, 0.5e-3)]
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.1)


# --------------------------------------------------------------------------------------------- directional derivatives


@versions
def test_directional_derivatives_are_those_of_central_differences(version):
    with opened(version, exchange=True) as fmu:
        fmu.initialise()
        set_sample(fmu, 0, 0)
        fmu.update_discrete_states()
        f, nx = fmu.fmu, states(fmu)
        fmu.call(f.enterContinuousTimeMode)
        known = [v.derivative.valueReference for v in fmu.description.modelVariables if v.derivative is not None]
        rates = [v.valueReference for v in fmu.description.modelVariables if v.derivative is not None]
        x, dx = (C.c_double * nx)(), (C.c_double * nx)()
        derivatives = f.getContinuousStateDerivatives if fmu.fmi3 else f.getDerivatives
        f.getContinuousStates(x, nx)
        x0 = np.array(x)
        seed = np.random.default_rng(2).normal(size=nx)

        def slope(scale: float) -> np.ndarray:
            x[:] = (x0 + scale * seed).tolist()
            f.setContinuousStates(x, nx)
            derivatives(dx, nx)
            return np.array(dx)

        central = (slope(1e-5) - slope(-1e-5)) / 2e-5
        slope(0)
        exact = f.getDirectionalDerivative(rates, known, seed.tolist())
        np.testing.assert_allclose(exact, central, atol=1e-9 * max(1, np.abs(central).max()))


# --------------------------------------------------------------------------------------------- complete state


@flavours
def test_a_saved_state_replays_bit_for_bit(version, exchange):
    def go_on(fmu: Fmu, first: int, last: int, solver) -> list:
        out = []
        for k in range(first, last):
            set_sample(fmu, k, 0)
            step_once(fmu, solver, k)
            out.append(posterior(fmu) + [fmu.get("att.q[1]"), fmu.get("cov.P[1,2]"), fmu.get("count.accel_used")])
        return out

    with opened(version, exchange) as fmu:
        fmu.initialise()
        solver = fmu.solver(0.0) if exchange else None
        go_on(fmu, 0, 5, solver)
        f = fmu.fmu
        get, put, free = (
            (f.getFMUState, f.setFMUState, f.freeFMUState) if fmu.fmi3 else (f.getFMUstate, f.setFMUstate, f.freeFMUstate)
        )
        state = get()
        straight = go_on(fmu, 5, 10, solver)
        put(state)
        assert go_on(fmu, 5, 10, solver) == straight
        free(state)


_CONTINUE = """
import test_fmu
test_fmu.MODEL = {model!r}
with test_fmu.opened({version}) as fmu:
    f = fmu.fmu
    state = f.deserializeFMUState(open({file!r}, "rb").read()) if fmu.fmi3 else f.deSerializeFMUstate(open({file!r}, "rb").read())
    (f.setFMUState if fmu.fmi3 else f.setFMUstate)(state)
    test_fmu.set_sample(fmu, 5, 0)
    fmu.do_step(0.05, 0.01)
    print([v.hex() for v in test_fmu.posterior(fmu)])
"""


@versions
def test_a_serialised_state_goes_on_in_another_process(version, tmp_path):
    with opened(version) as fmu:
        fmu.initialise()
        for k in range(5):
            set_sample(fmu, k, 0)
            fmu.do_step(0.01 * k, 0.01)
        f = fmu.fmu
        state = f.getFMUState() if fmu.fmi3 else f.getFMUstate()
        content = f.serializeFMUState(state) if fmu.fmi3 else f.serializeFMUstate(state)
        file = tmp_path / "state.bin"
        file.write_bytes(bytes(content))
        set_sample(fmu, 5, 0)
        fmu.do_step(0.05, 0.01)
        expected = str([v.hex() for v in posterior(fmu)])
    code = _CONTINUE.format(model=MODEL, version=version, file=str(file))
    assert in_another_process(code, Path(__file__).parent).strip() == expected


@versions
def test_a_damaged_state_is_refused_and_one_of_another_version_is_called_so(version):
    with opened(version) as fmu:
        fmu.initialise()
        set_sample(fmu, 0, 0)
        fmu.do_step(0, 0.01)
        f = fmu.fmu
        state = f.getFMUState() if fmu.fmi3 else f.getFMUstate()
        content = bytearray(f.serializeFMUState(state) if fmu.fmi3 else f.serializeFMUstate(state))
        for byte in (len(content) // 2, *range(16, 96, 8)):  # the middle, and every number of the header: mode, times
            content[byte] ^= 1
            with pytest.raises(HnavError, match="damaged"):
                fmu.call(f.deserializeFMUState if fmu.fmi3 else f.deSerializeFMUstate, bytes(content))
            content[byte] ^= 1
        content[7] -= 1
        with pytest.raises(HnavError, match="another version"):
            fmu.call(f.deserializeFMUState if fmu.fmi3 else f.deSerializeFMUstate, bytes(content))


# --------------------------------------------------------------------------------------------- wrong calls


@versions
def test_wrong_steps_are_refused_with_a_reason_and_change_nothing(version):
    with opened(version) as fmu:
        fmu.initialise(0.0, 1.0)
        set_sample(fmu, 0, 0)
        fmu.do_step(0, 0.5)
        for t, step, reason in (
            (0.5, math.nan, "communicationStepSize"), (0.5, math.inf, "communicationStepSize"), (0.5, 0.0, "above 0"),
            (0.5, -0.1, "above 0"), (math.nan, 0.1, "currentCommunicationPoint"), (0.4, 0.1, "last step ended"),
            (0.5 + 1e-6, 0.1, "last step ended"), (0.5, 0.6, "stopTime"),
        ):  # fmt: skip
            with pytest.raises(HnavError, match=reason):
                fmu.do_step(t, step)
        fmu.do_step(0.5 + 1e-10, 0.5)  # within the tolerance
        assert fmu.get("time") == pytest.approx(1.0)


@versions
def test_a_stop_before_the_start_and_times_that_are_none_are_refused(version):
    for start, stop in ((1.0, 0.5), (math.nan, None), (0.0, math.inf)):
        with opened(version) as fmu, pytest.raises(HnavError, match="startTime|stopTime"):
            fmu.initialise(start, stop)


@versions
def test_wrong_variables_are_named(version):
    with opened(version) as fmu:
        with pytest.raises(HnavError, match="gamma"):
            fmu.set("robust.gamma", -1.0)
        with pytest.raises(HnavError, match="no parameter or input"):
            fmu.set("att.q[1]", 1.0)
        fmu.initialise()
        with pytest.raises(HnavError, match="setting a parameter"):
            fmu.set("robust.gamma", 2.0)
        unknown = (C.c_uint32 * 1)(99999)
        with pytest.raises(HnavError, match="99999"):
            fmu.crossing("Get", "real", unknown, (C.c_double * 1)())()
        mixed = fmu.references(["gyro.rate[1]", "att.q[1]"])
        with pytest.raises(HnavError, match="att.q"):
            fmu.crossing("Set", "real", mixed, (C.c_double * 2)(7.0, 1.0))()
        assert fmu.get("gyro.rate[1]") == 0.0  # a refused call changes nothing
        wrong_type = fmu.references(["gyro.sample"])
        with pytest.raises(HnavError, match="gyro.sample"):
            fmu.crossing("Get", "real", wrong_type, (C.c_double * 1)())()
        f = fmu.fmu
        good = fmu.references(["att.q[1]"])
        with pytest.raises(HnavError, match="null"):
            fmu.call(f.fmi3GetFloat64, f.component, good, 1, None, 1) if fmu.fmi3 else fmu.call(
                f.fmi2GetReal, f.component, good, 1, None
            )
        if fmu.fmi3:  # FMI 2 has no size to get wrong
            with pytest.raises(HnavError, match="scalars"):
                fmu.call(f.fmi3GetFloat64, f.component, good, 1, (C.c_double * 2)(), 2)


ABSENT = {
    2: "SetRealInputDerivatives GetRealOutputDerivatives CancelStep GetStatus GetRealStatus GetIntegerStatus GetBooleanStatus "
    "GetStringStatus GetString SetString",
    3: "GetFloat32 SetFloat32 GetInt8 SetInt8 GetUInt8 SetUInt8 GetInt16 SetInt16 GetUInt16 SetUInt16 GetUInt32 SetUInt32 GetUInt64 "
    "SetUInt64 GetString SetString GetBinary SetBinary GetClock SetClock GetNumberOfVariableDependencies GetVariableDependencies "
    "GetIntervalDecimal GetIntervalFraction GetShiftDecimal GetShiftFraction SetIntervalDecimal "
    "SetIntervalFraction SetShiftDecimal SetShiftFraction EnterConfigurationMode ExitConfigurationMode GetOutputDerivatives",
}


@versions
def test_what_the_fmu_lacks_is_refused_by_name(version):
    """Capabilities that its description does not claim, and types that none of its variables has."""
    with opened(version) as fmu:
        fmu.initialise()
        for name in ABSENT[version].split():
            function = getattr(fmu.fmu.dll, f"fmi{version}{name}")
            # One value, and no place for it: what is refused is not looked at.
            nothing = [None if issubclass(kind, (C._Pointer, C.c_void_p)) else 1 for kind in function.argtypes[1:]]
            fmu.messages.clear()
            assert function(fmu.fmu.component, *nothing) == 3, name  # fmi2Error, fmi3Error
            assert name in fmu.messages[-1] or name[3:] in fmu.messages[-1]  # the call, or the type
        fmu.do_step(0, 0.01)


@versions
def test_an_impossible_parameter_set_stops_initialisation_with_its_name(version):
    with opened(version) as fmu:
        for i in range(1, 5):
            fmu.set(f"start.start_q_nb[{i}]", 0.0)
        with pytest.raises(HnavError, match="start_q_nb"):
            fmu.initialise()
        fmu.call(fmu.fmu.reset)  # and it is usable again
        fmu.initialise()
        fmu.do_step(0, 0.01)


@versions
def test_a_token_of_another_version_is_turned_away(version):
    description = fmpy.read_model_description(str(fmu_path(MODEL, version)))
    assert description.guid.startswith("{")
    fmu = opened(version)
    messages = fmu.messages
    fmu.fmu.freeInstance()
    fmu.fmu.guid = "{other}"
    # Loading again is for fmpy to do, so a fresh object with a wrong token it is.
    shutil.rmtree(fmu._folder, ignore_errors=True)
    broken = Fmu.__new__(Fmu)
    broken.description, broken.fmi3, broken.messages = description, version == 3, messages
    broken.model_exchange = broken._events = False
    broken.variables, broken._folder = {}, fmpy.extract(str(fmu_path(MODEL, version)))
    kind = type(fmu.fmu)
    broken.fmu = kind(guid="{other}", unzipDirectory=broken._folder, modelIdentifier=MODEL, instanceName="x")
    with pytest.raises(HnavError, match="do not belong together"):
        broken._instantiate()
    shutil.rmtree(broken._folder, ignore_errors=True)


def _calls(fmu: Fmu):
    """Every call that has its time, by name."""
    f, nx = fmu.fmu, 14
    x = (C.c_double * nx)(*([1.0] + [0.0] * 13))
    calls = {
        "initialise": lambda: fmu.initialise(),
        "exit initialization": f.exitInitializationMode,
        "terminate": f.terminate,
        "get": lambda: fmu.get("att.q[1]"),
        "set parameter": lambda: fmu.set("robust.gamma", 2.0),
        "set input": lambda: fmu.set("gyro.rate[1]", 0.0),
        "enter event mode": f.enterEventMode if hasattr(f, "enterEventMode") else None,
        "update": fmu.update_discrete_states if fmu.fmi3 or fmu.model_exchange else None,
    }
    if fmu.model_exchange:
        calls |= {
            "enter continuous-time mode": f.enterContinuousTimeMode,
            "set time": lambda: f.setTime(0.0),
            "set states": lambda: f.setContinuousStates(x, nx),
            "get states": lambda: f.getContinuousStates((C.c_double * nx)(), nx),
            "completed step": f.completedIntegratorStep,
        }
    else:
        calls["step"] = lambda: f.doStep(0.0, 0.01)
    return {name: call for name, call in calls.items() if call}


ALLOWED = {
    "instantiated": {"initialise", "set parameter", "set input"},
    "terminated": {"get", "get states"},
    "event": {"terminate", "get", "set input", "update", "enter continuous-time mode", "set time", "get states"},
    "continuous": {"terminate", "get", "set input", "enter event mode", "set time", "set states", "get states", "completed step"},
    "step": {"terminate", "get", "set input", "step"},
}


@flavours
@pytest.mark.parametrize("mode", ALLOWED)
def test_every_call_is_refused_in_each_mode_where_it_has_no_place(version, exchange, mode):
    if (mode in ("event", "continuous")) != exchange and mode not in ("instantiated", "terminated"):
        return  # a mode of the other interface
    with opened(version, exchange) as fmu:
        if mode != "instantiated":
            fmu.initialise()
        if mode == "terminated":
            fmu.fmu.terminate()
        if mode == "continuous":
            fmu.update_discrete_states()
            fmu.fmu.enterContinuousTimeMode()
        for name, call in _calls(fmu).items():
            if name in ALLOWED[mode]:
                continue
            count = len(fmu.messages)
            with pytest.raises(HnavError):
                fmu.call(call)
            assert len(fmu.messages) > count, f"{name} in {mode} gave no message"
        fmu.call(fmu.fmu.reset)
        fmu.initialise()  # usable again
        assert fmu.get("att.q[1]") == 1.0


# --------------------------------------------------------------------------------------------- many instances


def run_steps(fmu: Fmu, n: int = 20, first: int = 0) -> list[float]:
    for k in range(first, first + n):
        set_sample(fmu, k, 0)
        fmu.do_step(0.01 * k, 0.01)
    return posterior(fmu)


@versions
def test_reset_leaves_nothing_behind(version):
    with opened(version) as fmu:
        fmu.initialise()
        first = run_steps(fmu)
        fmu.call(fmu.fmu.reset)
        sample_periodically(fmu)
        fmu.initialise()
        assert fmu.get("count.accel_used") == 0
        assert run_steps(fmu) == first


@versions
def test_two_hundred_instances_leave_no_memory_behind(version):
    def resident_kb() -> int:
        return int(next(line for line in open("/proc/self/status") if line.startswith("VmRSS")).split()[1])

    with opened(version) as fmu:
        f = fmu.fmu

        def cycle():
            component = f.component
            fmu._instantiate()
            fmu.initialise()
            fmu.do_step(0, 0.01)
            (f.fmi3FreeInstance if fmu.fmi3 else f.fmi2FreeInstance)(f.component)
            f.component = component

        for _ in range(20):
            cycle()
        before = resident_kb()
        for _ in range(200):
            cycle()
        assert resident_kb() - before < 1000


@versions
def test_interleaved_instances_equal_separate_runs(version):
    with opened(version) as alone:
        alone.initialise()
        expected = run_steps(alone)
    with opened(version) as a, opened(version) as b:
        a.initialise()
        b.initialise()
        for k in range(20):
            set_sample(a, k, 0)
            set_sample(b, k + 7, 0)
            a.do_step(0.01 * k, 0.01)
            b.do_step(0.01 * k, 0.01)
        assert posterior(a) == expected != posterior(b)


@versions
def test_four_threads_on_separate_instances_agree(version):
    results: list = [None] * 4

    def work(i: int) -> None:
        with opened(version) as fmu:
            fmu.initialise()
            results[i] = run_steps(fmu, 200)

    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results[0] is not None and all(r == results[0] for r in results)


@versions
def test_paths_with_spaces_and_unicode_are_no_trouble(version, tmp_path):
    folder = tmp_path / "filter ünits 100%20"
    folder.mkdir()
    path = shutil.copy(fmu_path(MODEL, version), folder / f"{MODEL}.fmu")
    with Fmu(Path(path)) as fmu:
        fmu.initialise()
        assert len(run_steps(fmu, 3)) == 7


@versions
def test_simulate_fmu_runs_the_example_input(version):
    path = fmu_path(MODEL, version)
    with zipfile.ZipFile(path) as archive:
        signal = np.genfromtxt(archive.open("resources/example_input.csv"), delimiter=",", names=True, deletechars="")
    for kind in ("CoSimulation", "ModelExchange"):
        result = fmpy.simulate_fmu(str(path), fmi_type=kind, stop_time=2, input=signal[:201], output_interval=0.01,
                                   output=["att.euler[1]", "post.t", "align.started"])  # fmt: skip
        assert result["align.started"][-1]
        assert np.degrees(result["att.euler[1]"][50:]).max() < 25
        assert result["post.t"][-1] == pytest.approx(2, abs=0.011)
