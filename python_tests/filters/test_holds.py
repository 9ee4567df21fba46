"""What a sampled rate and force stand for: the option gyro_hold."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hnav import Filter, Ins
from hnav.simulation.vehicle import Vehicle, VehicleOptions
from motion import readings, turning

DURATION_S = 40.0


def attitude_error(name: str, hold: str, step_s: float) -> float:
    """Root mean square, rad, of a filter that is led by its rate alone: it starts with the attitude and gets no force and field."""
    t = 3.5 + step_s * np.arange(round(DURATION_S / step_s))  # at 3 s it begins to turn at once
    rate, _, _ = readings(t, noise=0.0)
    first = turning(t[:1]).as_quat(scalar_first=True)[0]
    none = np.full((len(t), 3), np.nan)
    run = Filter(name, gyro_hold=hold, start_mode="attitude", start_q_nb=tuple(first)).run(t, rate, none, none)
    errors = (Rotation.from_quat(run.q_nb, scalar_first=True) * turning(t).inv()).magnitude()
    return float(np.sqrt(np.mean(errors**2)))


def way_error(hold: str, step_s: float) -> float:
    """Root mean square, m/s, of the velocity of an INS without satellites, started with the state of a car."""
    t = step_s * np.arange(round(DURATION_S / step_s))
    drive = Vehicle(VehicleOptions(kind="car")).run(t)
    ins = Ins(
        gyro_hold=hold, start="state", start_place="given", start_latitude_rad=drive.place[0, 0],
        start_longitude_rad=drive.place[0, 1], start_height_m=drive.place[0, 2], start_q_nb=tuple(drive.q_nb[0]),
        start_velocity_n_m_s=tuple(drive.velocity_n_m_s[0]), rest_rate_rad_s=0.0, solver="closed_form",
    )  # fmt: skip
    velocity = np.empty((len(t), 3))
    for k, t_s in enumerate(t):
        ins.push_imu(t_s, drive.rate_b_rad_s[k], drive.force_b_m_s2[k])
        ins.advance(t_s)
        velocity[k] = ins.navigation().velocity_n_m_s
    return float(np.sqrt(np.mean(np.sum((velocity - drive.velocity_n_m_s) ** 2, axis=1))))


@pytest.mark.filterwarnings("ignore:accel. none::", "ignore:mag. none::")
@pytest.mark.parametrize("error", (lambda *a: attitude_error("ahrs", *a), lambda *a: attitude_error("hrekf", *a), way_error))
def test_readings_of_instants_have_an_error_of_second_order(error):
    """Held until the next sample they are late by half an interval, taken for means early by as much: of first order."""
    for hold, order in (("forward", 1), ("backward", 1), ("instant", 2)):
        assert np.log2(error(hold, 0.04) / error(hold, 0.02)) == pytest.approx(order, abs=0.15)
    assert error("instant", 0.02) < 0.1 * min(error("forward", 0.02), error("backward", 0.02))
