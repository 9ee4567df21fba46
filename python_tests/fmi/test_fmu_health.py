"""An FMU reports the same sensor health as the C library: a clipped gyroscope, a stuck magnetometer."""

import fmpy
import numpy as np
import pytest

from hnav import Filter, HnavError
from hnav.filters.filter_answers import HEALTH_SENSORS, SENSOR_STATES
from hnav.fmi.engines import run_recording
from hnav.fmi.fmus import Fmu, fmu_path, items_of
from motion import tilted_motion

COUNTS = ("outliers", "stuck", "saturated", "late", "left_out")
CLIPPED_RAD_S, STUCK_ROW = 4.5, 200
START_S = 100.0
INPUTS = {"gyro": "gyro.rate", "accel": "accel.force", "mag": "mag.field"}


@pytest.fixture(scope="module")
def faulty():
    """Rates that are clipped, a field that sticks, from START_S on."""
    recording = tilted_motion(6).recording
    recording.rate_b_rad_s.clip(-CLIPPED_RAD_S, CLIPPED_RAD_S, out=recording.rate_b_rad_s)
    recording.field_b_tesla[STUCK_ROW:] = recording.field_b_tesla[STUCK_ROW]
    recording.t_s[:] += START_S
    return recording


def deliver(fmu: Fmu, recording, row: int) -> None:
    values = (recording.rate_b_rad_s[row], recording.force_b_m_s2[row], recording.field_b_tesla[row])
    for (sensor, name), value in zip(INPUTS.items(), values):
        for axis in range(3):
            fmu.set(f"{name}[{axis + 1}]", float(value[axis]))
        fmu.set(f"{sensor}.t_meas", float(recording.t_s[row]))
        fmu.set(f"{sensor}.sample", row + 1)


def assert_same_health(fmu: Fmu, health, start_s: float) -> None:
    for sensor in HEALTH_SENSORS:
        said = health.sensor[sensor]
        assert SENSOR_STATES[fmu.get(f"health.{sensor}.state")] == said.state, sensor
        assert fmu.get(f"health.{sensor}.since") == (start_s if np.isnan(said.since_s) else said.since_s)
        assert fmu.get(f"health.{sensor}.axes") == sum(1 << "xyz".index(axis) for axis in said.axes)
        for count in COUNTS:
            assert fmu.get(f"health.{sensor}.{count}") == getattr(said, count), (sensor, count)
    for name in ("times_lost", "clock_jumps", "stamps_left_out", "lost"):
        assert fmu.get(f"health.{name}") == getattr(health, name), name


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("filter", ["hrekf", "ahrs"])
def test_every_output_of_health_is_that_of_the_library(filter, version, faulty):
    f = Filter(filter)
    with Fmu(fmu_path(filter.capitalize(), version)) as fmu:
        fmu.set("sampling_mode", "counter")
        fmu.initialise(START_S)
        assert_same_health(fmu, f.health(), START_S)
        for row, t_s in enumerate(faulty.t_s.tolist()):
            deliver(fmu, faulty, row)
            fmu.do_step(t_s, 0.01)
            f.push_imu(t_s, faulty.rate_b_rad_s[row], faulty.force_b_m_s2[row])
            f.push_mag(t_s, faulty.field_b_tesla[row])
            f.advance(t_s + 0.01)
            if row % 50 == 49:
                assert_same_health(fmu, f.health(), START_S)
        assert f.health().sensor["gyro"].saturated > 0 and f.health().sensor["mag"].stuck > 0
        fmu.do_step(faulty.t_s[-1] + 0.01, 5.0)
        f.advance(faulty.t_s[-1] + 5.01)
        assert fmu.get("health.mag.state") == SENSOR_STATES.index("missing")
        assert_same_health(fmu, f.health(), START_S)


@pytest.mark.parametrize("engine", ["fmi2-cs", "fmi2-me", "fmi3-cs", "fmi3-me"])
def test_every_engine_finds_the_same_health_in_every_row(engine, faulty):
    by_fmu, by_library = (run_recording(faulty, "ahrs", name).health for name in (engine, "c"))
    assert set(np.array(SENSOR_STATES)[by_library].ravel()) == {"ok", "saturated", "stuck"}
    np.testing.assert_array_equal(by_fmu, by_library)


@pytest.mark.parametrize("version", [2, 3])
def test_states_are_described_and_named_as_in_the_library(version):
    variables = {v.name: v for v in fmpy.read_model_description(str(fmu_path("Ahrs", version))).modelVariables}
    for sensor in HEALTH_SENSORS:
        state = variables[f"health.{sensor}.state"]
        assert tuple(items_of(state)) == SENSOR_STATES and list(items_of(state).values()) == list(range(len(SENSOR_STATES)))
        assert state.causality == "output" and state.variability == "discrete"


def test_a_state_cannot_be_set():
    with Fmu(fmu_path("Ahrs", 3)) as fmu, pytest.raises(HnavError):
        fmu.set("health.gyro.state", "ok")
