"""A speed along body x: what the AHRS estimates of a body that moves where it points."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hnav import Filter, HnavRuntimeError, HnavValueError
from hnav.filters.attitude_recording import run_recording
from hnav.filters.options import Options
from hnav.io.readers import read
from hnav.reports.scores import errors_rad
from studies.bench.motions import motion

HZ, G_M_S2 = 100, 9.80665
FIELD_N = 5e-5 * np.array([0.5, 0, 0.866])


def drive(acceleration_m_s2, rate_rad_s, start_m_s=0.0):
    """Time, rate, force, field, speed, and yaw of a level car, whose samples are exact."""
    acceleration, rate = np.asarray(acceleration_m_s2, float), np.asarray(rate_rad_s, float)
    t_s = np.arange(len(rate)) / HZ
    yaw = np.cumsum(np.r_[0, rate[1:]]) / HZ  # a rate holds since the sample before
    speed = start_m_s + np.cumsum(np.r_[0, acceleration[1:]]) / HZ
    zero = np.zeros(len(t_s))
    field = Rotation.from_euler("z", yaw[:, None]).inv().apply(FIELD_N)
    rates, force = np.stack([zero, zero, rate], 1), np.stack([acceleration, speed * rate, zero - G_M_S2], 1)
    return t_s, rates, force, field, speed, yaw


def each_second(speed):
    """Speeds in every hundredth row."""
    given = np.full(len(speed), np.nan)
    given[::HZ] = speed[::HZ]
    return given


def tilt_deg(run):
    """From the second row on: the first has no attitude yet."""
    return np.degrees(np.hypot(run.euler_rad[1:, 0], run.euler_rad[1:, 1]))


def constant(value, seconds):
    return np.full(int(seconds * HZ), float(value))


BRAKE = np.r_[constant(0, 5), constant(2.5, 12), constant(0, 10), constant(-4, 6), constant(0, 5)]
"""Stands, gains 30 m/s, keeps them, brakes to 6 m/s."""


def test_a_car_that_gains_speed_and_brakes_straight_ahead_stays_level():
    t_s, rate, force, field, speed, _ = drive(BRAKE, 0 * BRAKE)
    run = Filter("ahrs").run(t_s, rate, force, field, speed_m_s=each_second(speed), speed_sigma_m_s=0.1)
    alone = Filter("ahrs").run(t_s, rate, force, field)
    assert tilt_deg(run).max() < 0.2 < 0.8 < tilt_deg(alone).max()
    assert run.ready[300:, 0].all()


@pytest.mark.parametrize("body", ["any", "car"])
def test_a_start_in_a_constant_turn_finds_the_horizon_from_the_speed(body):
    """20 m/s and 0.2 rad/s are 22 deg of apparent tilt, which nothing but the speed contradicts."""
    t_s, rate, force, field, speed, yaw = drive(constant(0, 40), constant(0.2, 40), 20.0)
    run = Filter("ahrs", body=body).run(t_s, rate, force, field, speed_m_s=each_second(speed))
    alone = Filter("ahrs", body=body).run(t_s, rate, force, field)
    assert tilt_deg(run)[0] > 20 and tilt_deg(alone)[3000:].mean() > 5
    assert tilt_deg(run)[1500:].max() < 1 and (run.ready[1500:, 0].all() or body == "car")
    assert not (run.ready[1:, 0] & (tilt_deg(run) > 3)).any()
    heading = np.degrees(np.abs((run.euler_rad[:, 2] - yaw + np.pi) % (2 * np.pi) - np.pi))
    assert heading[3000:].max() < 2


def test_a_car_that_drives_backwards_gives_a_negative_speed():
    t_s, rate, force, field, speed, _ = drive(-np.abs(BRAKE), 0 * BRAKE)
    run = Filter("ahrs").run(t_s, rate, force, field, speed_m_s=each_second(speed))
    assert speed[-1] < -50 and tilt_deg(run).max() < 0.2


def test_after_the_last_speed_the_filter_goes_on_as_without_one():
    """The cruise at 30 m/s goes on without speeds: the horizon stays, and its sigma grows to that of the filter alone."""
    acceleration = np.r_[BRAKE[: 20 * HZ], constant(0, 60)]
    t_s, rate, force, field, speed, _ = drive(acceleration, 0 * acceleration)
    given = each_second(speed)
    given[20 * HZ :] = np.nan
    run = Filter("ahrs").run(t_s, rate, force, field, speed_m_s=given)
    assert tilt_deg(run).max() < 0.3
    assert run.sigma_rad[-1, 0] < np.radians(2)


def test_a_single_wrong_speed_moves_the_horizon_little():
    """In km/h where the others are in m/s."""
    t_s, rate, force, field, speed, _ = drive(BRAKE, 0 * BRAKE)
    given = each_second(speed)
    given[25 * HZ] *= 3.6
    filter = Filter("ahrs")
    run = filter.run(t_s, rate, force, field, speed_m_s=given)
    assert tilt_deg(run).max() < 1.5 and filter.diagnostics().gated["speed"] >= 1


def test_wrong_speeds_are_refused_by_name():
    ahrs = Filter("ahrs")
    for call, says in [
        (lambda: ahrs.push_speed(0, np.nan, 0.1), "speed sample at t = 0 s is not finite: speed nan, sigma 0.1"),
        (lambda: ahrs.push_speed(0, 1e9, 0.1), "speed sample at t = 0 s is 1e+09, beyond 10000"),
        (lambda: ahrs.push_speed(0, 1, 0), "sigma_m_s = 0 of the speed sample at t = 0 s must be above 0"),
    ]:
        with pytest.raises(HnavValueError) as refused:
            call()
        assert says in str(refused.value)
    assert ahrs.diagnostics().non_finite == 3 and ahrs.diagnostics().used["speed"] == 0
    with pytest.raises(HnavRuntimeError, match="this filter takes no speed samples"):
        Filter("hrekf").push_speed(0, 1, 0.1)


def test_a_run_with_speeds_is_push_and_advance_row_by_row():
    t_s, rate, force, field, speed, _ = drive(BRAKE[: 15 * HZ], 0.1 * np.sin(np.arange(15 * HZ) / 200))
    given, single = each_second(speed), Filter("ahrs")
    run = Filter("ahrs").run(t_s, rate, force, field, speed_m_s=given, speed_sigma_m_s=0.2)
    for i, t in enumerate(t_s):
        single.push_imu(t, rate[i], force[i])
        single.push_mag(t, field[i])
        if np.isfinite(given[i]):
            single.push_speed(t, given[i], 0.2)
        single.advance(t)
    np.testing.assert_array_equal(single.attitude().q_nb, run.q_nb[-1])
    assert single.innovation("speed").dimension == 2 and single.innovation("speed").accepted
    state, again = single.save(), Filter("ahrs")
    again.load(state)
    for one in (single, again):
        one.push_imu(15.0, rate[-1], force[-1])
        one.push_speed(15.0, speed[-1], 0.2)
        one.advance(15.0)
    np.testing.assert_array_equal(single.attitude().q_nb, again.attitude().q_nb)


def test_the_smoother_uses_the_speeds_in_both_directions():
    recording = motion("aircraft", 5, "industrial")
    given = recording.aids["speed"]
    speed = np.full(len(recording.t_s), np.nan)
    speed[::HZ] = given.values[:, 0]
    filter = Filter("ahrs", navigation_frame="enu")
    arrays = recording.t_s, recording.rate_b_rad_s, recording.force_b_m_s2, recording.field_b_tesla

    def tilt_rms_deg(run):
        return np.degrees(np.sqrt(np.mean(errors_rad(run.q_nb[1000:], recording.reference_q_nb[1000:])[2] ** 2)))

    alone = tilt_rms_deg(filter.smooth(*arrays))
    filtered = tilt_rms_deg(filter.run(*arrays, speed_m_s=speed, speed_sigma_m_s=0.3))
    filter.reset()
    smoothed = tilt_rms_deg(filter.smooth(*arrays, speed_m_s=speed, speed_sigma_m_s=0.3))
    assert smoothed < min(filtered, alone / 3)


def test_the_column_speed_m_s_of_a_recording_is_used_by_the_ahrs_alone(tmp_path):
    t_s, rate, force, field, speed, _ = drive(BRAKE, 0 * BRAKE)
    file, given = tmp_path / "car.csv", each_second(speed)
    cells = [f"{v:.9g}" if np.isfinite(v) else "" for v in given]
    lines = [",".join([*map(repr, row.tolist()), cell]) for row, cell in zip(np.column_stack([t_s, rate, force, field]), cells)]
    file.write_text("t_s,gx,gy,gz,ax,ay,az,mx,my,mz,speed_m_s\n" + "\n".join(lines) + "\n")
    recording = read(file, gyro_unit="rad/s", accel_unit="m/s2", mag_unit="T")
    run = run_recording(recording, Options("ahrs"))
    assert run.counts["speed_used"] == len(BRAKE) // HZ and tilt_deg(run).max() < 0.2
    assert run_recording(recording, Options("hrekf")).counts["speed_used"] == 0
