"""The sensors from Python: their values and times; the noise depends on the sample's number alone."""

import pickle

import numpy as np
import pytest

from hnav import HnavError, HnavValueError
from hnav.native.options import option_rows
from hnav.simulation.imu_mag_sensor import KINDS, ImuMagSensor, ImuMagSensorOptions
from hnav.simulation.turntable import Turntable

NOISE = dict(gyro_noise_deg_per_sqrt_h=0.3, accel_noise_ug_per_sqrt_hz=100, mag_noise_nt_per_sqrt_hz=50)
TABLE = Turntable(yaw_motion="sine", yaw_amplitude_rad=1.0)
TRUE = {"gyro": "rate_b_rad_s", "accel": "force_b_m_s2", "mag": "field_b_tesla"}


def readings(sensor: ImuMagSensor, times, kinds=KINDS) -> np.ndarray:
    rows = []
    for t_s in times:
        sensor.sample(t_s, TABLE.at(t_s))
        sensor.advance(t_s)
        rows.append(np.concatenate([sensor.reading(kind).value for kind in kinds]))
    return np.array(rows)


def test_sensors_without_errors_read_the_truth():
    sensor = ImuMagSensor()
    readings(sensor, 0.01 * np.arange(50))
    truth = TABLE.at(0.49)
    for kind in KINDS:
        reading = sensor.reading(kind)
        np.testing.assert_array_equal(reading.value, getattr(truth, TRUE[kind]))
        assert (reading.t_meas_s, reading.count, reading.missed, reading.dropped) == (0.49, 50, 0, 0)


def test_a_sample_is_delivered_its_latency_later():
    sensor = ImuMagSensor(mag_latency_s=0.025)
    sensor.sample(0.0, TABLE.at(0.0))
    sensor.advance(0.0)
    assert sensor.reading("mag").count == 0 and sensor.reading("gyro").count == 1
    assert sensor.next_event_s() == pytest.approx(0.01)
    sensor.advance(0.025)
    assert sensor.reading("mag").count == 1 and sensor.reading("mag").t_meas_s == 0.0


def test_noise_is_that_of_the_datasheet_and_belongs_to_seed_and_sample():
    times = 0.01 * np.arange(4000)
    noisy = readings(ImuMagSensor(**NOISE, seed=1), times, ["gyro"])
    error = noisy - [TABLE.at(t).rate_b_rad_s for t in times]
    density = ImuMagSensor(**NOISE).noise_psd("gyro")
    assert density == pytest.approx(np.radians(0.3 / 60) ** 2)
    assert error.std() == pytest.approx(np.sqrt(density / 0.01), rel=0.03)
    alone = readings(ImuMagSensor(gyro_noise_deg_per_sqrt_h=0.3, seed=1), times[:100], ["gyro"])
    np.testing.assert_array_equal(alone, noisy[:100])
    assert not np.array_equal(readings(ImuMagSensor(**NOISE, seed=2), times[:100], ["gyro"]), alone)


def test_a_copy_continues_and_a_reset_restarts():
    times = 0.01 * np.arange(60)
    sensor = ImuMagSensor(ImuMagSensorOptions(**NOISE, seed=7, gyro_dropout=0.2), start_s=0.0)
    begin = readings(sensor, times[:30])
    again = pickle.loads(pickle.dumps(sensor))
    assert again.options == sensor.options
    np.testing.assert_array_equal(readings(again, times[30:]), readings(sensor, times[30:]))
    assert again.reading("gyro") == sensor.reading("gyro") and sensor.reading("gyro").dropped > 0
    sensor.reset()
    np.testing.assert_array_equal(readings(sensor, times[:30]), begin)
    with pytest.raises(HnavError):
        ImuMagSensor(seed=8).load(again.save())


def test_faults_work_in_their_window():
    sensor = ImuMagSensor(fault_bias_jump_start_s=0.1, fault_bias_jump_stop_s=0.2, fault_bias_jump_gyro_rad_s=[0.5, 0, 0])
    times = 0.01 * np.arange(30)
    error = readings(sensor, times, ["gyro"])[:, 0] - [TABLE.at(t).rate_b_rad_s[0] for t in times]
    np.testing.assert_allclose(error, np.where((times > 0.095) & (times < 0.195), 0.5, 0.0), atol=1e-12)


@pytest.mark.parametrize("call, named", [
    (lambda: ImuMagSensor(gyro_period_s=0), "gyro.period_s"),
    (lambda: ImuMagSensor(gyro_rate=1), "no option gyro_rate"),
    (lambda: ImuMagSensor(ImuMagSensorOptions(), seed=1), "ImuMagSensorOptions are complete"),
    (lambda: ImuMagSensor().reading("baro"), "sensor = baro: choose one of gyro, accel, mag"),
    (lambda: ImuMagSensor().noise_psd("heading"), "sensor = heading"),
    (lambda: ImuMagSensor().sample(np.nan, TABLE.at(0)), "t_s"),
])  # fmt: skip
def test_what_cannot_be_is_named(call, named):
    with pytest.raises(HnavValueError, match=named):
        call()


def test_options_are_described():
    assert {"gyro.noise_deg_per_sqrt_h", "fault.stuck.sensor", "seed"} <= set(option_rows("imu_mag_sensor"))
    assert option_rows("imu_mag_sensor")["fault.stuck.sensor"].choices == ("none", "gyro", "accel", "mag")
