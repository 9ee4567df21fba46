"""The recordings of devices: the frames and units found in them hold."""

import numpy as np
from scipy.spatial.transform import Rotation

from hnav.io import device_recordings


def known_attitude(recording) -> tuple[np.ndarray, Rotation]:
    rows = np.flatnonzero(np.isfinite(recording.reference_q_nb).all(axis=1))
    return rows, Rotation.from_quat(recording.reference_q_nb[rows][:, [1, 2, 3, 0]])


def test_device_attitude_turns_specific_force_into_up(device_recording):
    rows, attitude = known_attitude(device_recording)
    mean_force = np.median(attitude.apply(device_recording.force_b_m_s2[rows]), axis=0)
    assert np.degrees(np.arctan2(np.hypot(*mean_force[:2]), mean_force[2])) < 1.0
    assert abs(mean_force[2] - 9.8) < 0.15


def test_force_points_up_sample_by_sample_in_quiet_moments(device_recording):
    rows, attitude = known_attitude(device_recording)
    force = device_recording.force_b_m_s2[rows]
    quiet = (np.abs(np.linalg.norm(force, axis=1) - 9.8) < 0.2) & (
        np.linalg.norm(device_recording.rate_b_rad_s[rows], axis=1) < np.radians(10)
    )
    up = attitude.apply(force)[quiet]
    angle_deg = np.degrees(np.arctan2(np.hypot(up[:, 0], up[:, 1]), up[:, 2]))
    assert quiet.sum() > 20
    assert np.median(angle_deg) < 3.0


def test_device_attitude_turns_by_the_measured_rate(device_recording):
    rows, attitude = known_attitude(device_recording)
    dt_s = np.diff(device_recording.t_s[rows])[:, None]
    turned = (attitude[:-1].inv() * attitude[1:]).as_rotvec() / dt_s
    # The rate of a row is the mean over the interval that ends there; the x-IMU's attitude skips every second row.
    measured = (
        device_recording.rate_b_rad_s[rows[1:]]
        + device_recording.rate_b_rad_s[rows[:-1] + (rows[1] - rows[0]) // 2 * 1 if rows[1] - rows[0] == 2 else rows[1:]]
    ) / 2
    fit = np.linalg.lstsq(measured, turned, rcond=None)[0]
    assert np.abs(fit - np.eye(3)).max() < 0.03


def test_field_of_quiet_phases_points_to_magnetic_north(device_recording):
    rows, attitude = known_attitude(device_recording)
    moving = np.linalg.norm(device_recording.rate_b_rad_s[rows], axis=1) > np.radians(10)
    field = attitude.apply(np.nan_to_num(device_recording.field_b_tesla[rows]))
    seen = np.isfinite(device_recording.field_b_tesla[rows]).all(axis=1) & ~moving
    east, north, up = field[seen].mean(axis=0)
    assert abs(np.degrees(np.arctan2(east, north))) < 10.0
    assert up < 0.0


def test_rates_of_the_xsens_are_means_over_the_past_interval(wheel):
    recording = device_recordings.read_xsens(wheel).recording
    rows, attitude = known_attitude(recording)
    turned = (attitude[:-1].inv() * attitude[1:]).as_rotvec() * 50.0
    past = np.median(np.linalg.norm(turned - recording.rate_b_rad_s[1:], axis=1))
    coming = np.median(np.linalg.norm(turned - recording.rate_b_rad_s[:-1], axis=1))
    assert np.degrees(past) < 1.0
    assert coming > 10.0 * past


def test_repeated_fields_of_the_x_imu_are_no_samples(wheel):
    field = device_recordings.read_x_imu(wheel).recording.field_b_tesla
    seen = np.isfinite(field).all(axis=1)
    assert 0.6 < seen.mean() < 0.7
    neighbours = seen[1:] & seen[:-1]
    assert (np.abs(np.diff(field, axis=0))[neighbours].max(axis=1) > 0).all()
