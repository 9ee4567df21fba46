"""Health of the sensors as the filters report it: states, times, and equal answers from every call."""

from dataclasses import replace

import numpy as np
import pytest

from hnav import Filter
from hnav.filters.filter_answers import HEALTH_SENSORS, SENSOR_STATES
from hnav.filters.health import Finding, findings
from hnav.filters.options import FILTERS
from motion import tilted_motion

CLIPPED_RAD_S = 4.5
STUCK_ROW = 800


@pytest.fixture(scope="module")
def faulty():
    """A gyroscope that is clipped and a magnetometer that sticks."""
    recording = tilted_motion(20).recording
    field = recording.field_b_tesla.copy()
    field[STUCK_ROW:] = field[STUCK_ROW]
    return replace(recording, rate_b_rad_s=recording.rate_b_rad_s.clip(-CLIPPED_RAD_S, CLIPPED_RAD_S), field_b_tesla=field)


def samples(recording):
    return recording.t_s, recording.rate_b_rad_s, recording.force_b_m_s2, recording.field_b_tesla


@pytest.mark.parametrize("filter", FILTERS)
def test_a_clipped_and_a_stuck_sensor_are_named_with_axes_and_times(filter, faulty):
    f = Filter(filter)
    run = f.run(*samples(faulty))
    gyro, mag = f.health().sensor["gyro"], f.health().sensor["mag"]
    assert (gyro.state, gyro.axes) == ("saturated", "z") and gyro.saturated > 1000 and gyro.left_out == 0
    assert (mag.state, mag.axes) == ("stuck", "xyz") and mag.left_out == mag.stuck
    assert faulty.t_s[STUCK_ROW] < mag.since_s < faulty.t_s[STUCK_ROW] + 2
    assert f.health().sensor["accel"].state == "ok" and f.health().sensor["heading"].state == "missing"
    np.testing.assert_array_equal(run.t_s[run.health[:, 2] == SENSOR_STATES.index("stuck")][0], mag.since_s)


def test_health_by_row_equals_that_of_each_advance(faulty):
    short, f = faulty.cropped(9), Filter("ahrs")
    run = Filter("ahrs").run(*samples(short))
    states = []
    for t_s, rate, force, field in zip(*samples(short)):
        f.push_imu(t_s, rate, force)
        f.push_mag(t_s, field)
        f.advance(t_s)
        states.append([f.health().sensor[name].state for name in HEALTH_SENSORS])
    np.testing.assert_array_equal(np.array(SENSOR_STATES)[run.health], states)


def test_every_sensor_is_missing_before_its_first_sample_and_after_its_last(motion):
    f = Filter("ahrs")
    assert {sensor.state for sensor in f.health().sensor.values()} == {"missing"}
    assert np.isnan(f.health().sensor["gyro"].since_s) and not f.health().lost
    f.run(*samples(motion.recording))
    assert f.health().sensor["mag"].state == "ok"
    end_s = motion.recording.t_s[-1]
    f.advance(end_s + 3)
    assert f.health().sensor["mag"].state == "missing" and f.health().sensor["mag"].since_s == end_s


def test_a_clock_that_is_set_back_is_counted(motion):
    f, recording = Filter("ahrs"), motion.recording
    f.run(*samples(replace(recording, t_s=recording.t_s + 100)))
    for t_s, rate, force, field in zip(*samples(recording)):
        f.push_imu(t_s, rate, force)
        f.push_mag(t_s, field)
        f.advance(t_s)
    assert f.health().clock_jumps == 1 and f.health().stamps_left_out == 0


def test_a_gap_in_which_the_body_may_have_turned_to_anywhere_is_counted(motion):
    f, recording = Filter("ahrs"), motion.recording
    f.run(*samples(recording))
    assert f.health().times_lost == 0
    f.run(*samples(replace(recording, t_s=recording.t_s + 86400)))
    assert f.health().times_lost == 1


def test_findings_are_by_sensor_the_longest_state_first():
    number = SENSOR_STATES.index
    health = np.zeros((100, 3), np.uint8)
    health[10:20, 0] = number("outlier")
    health[30:70, 0] = number("saturated")
    health[:, 1] = number("missing")  # a sensor that is not there is no finding
    found = findings(0.1 * np.arange(100) + 5, health)
    assert [(f.sensor, f.state, round(f.lasted_s, 9), f.first_s) for f in found] == [
        ("gyro", "saturated", 4.0, 8.0), ("gyro", "outlier", 1.0, 6.0),
    ]  # fmt: skip
    assert str(found[0]) == "gyro saturated for 4.0 s, from 8.0 s on"


def test_a_gap_does_not_lengthen_a_finding():
    health = np.full((2, 3), SENSOR_STATES.index("ok"), np.uint8)
    health[0, 0] = SENSOR_STATES.index("stuck")
    assert findings(np.array([0.0, 3600.0]), health) == [Finding("gyro", "stuck", 1.0, 0.0)]


def test_without_a_force_the_tilt_is_lost_by_the_gyroscope_alone():
    """The robust law, which lets a wrong start converge, does not act where no force corrects the tilt."""
    motion = tilted_motion(120).recording
    force = motion.force_b_m_s2.copy()
    force[motion.t_s > motion.t_s[0] + 5] = np.nan
    sigma = {
        mode: Filter("ahrs", gamma_mode=mode, solver="closed_form")
        .run(motion.t_s, motion.rate_b_rad_s, force, motion.field_b_tesla, check=False)
        .sigma_rad[-1, :2]
        for mode in ("relative", "off")
    }
    np.testing.assert_allclose(sigma["relative"], sigma["off"], rtol=0.5)
    assert sigma["relative"].max() < 1
