"""Vehicles over the turning Earth: their truth is consistent, and integrated sensor readings reproduce it."""

import pickle

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from driven import brought_about, missed_m
from hnav import HnavValueError, earth
from hnav.simulation.vehicle import Drive, Vehicle

KINDS = ("car", "aircraft", "ship", "rest")
kinds = pytest.mark.parametrize("kind", KINDS)
STEP_S = 1e-3
EARTH_E = np.array([0, 0, earth.RATE_RAD_S])


def axes_e(drive: Drive) -> np.ndarray:
    """n x 3 x 3: north, east, down as columns in Earth-fixed axes."""
    return earth.axes_at(drive.place)


def attitude_e(drive: Drive) -> Rotation:
    """Body to Earth-fixed axes."""
    return Rotation.from_matrix(axes_e(drive)) * Rotation.from_quat(drive.q_nb[:, [1, 2, 3, 0]])


def velocity_e(drive: Drive) -> np.ndarray:
    return np.einsum("nij,nj->ni", axes_e(drive), drive.velocity_n_m_s)


@pytest.mark.parametrize("latitude_deg", (-90, -33, 0, 45, 89.99))
def test_a_body_at_rest_reads_gravity_and_the_rate_of_the_earth(latitude_deg):
    latitude = np.radians(latitude_deg)
    drive = Vehicle(kind="rest", sway=0, latitude_rad=latitude, height_m=300).run([0.0, 10.0])
    body = Rotation.from_quat(drive.q_nb[:, [1, 2, 3, 0]])
    rate_n = earth.RATE_RAD_S * np.array([np.cos(latitude), 0, -np.sin(latitude)])
    np.testing.assert_allclose(body.apply(drive.rate_b_rad_s), [rate_n, rate_n], atol=1e-16)
    gravity = np.linalg.norm(earth.gravity_at(earth.position_of(drive.place)), axis=1)
    np.testing.assert_allclose(body.apply(drive.force_b_m_s2), np.outer(gravity, [0, 0, -1]), atol=1e-9)
    np.testing.assert_allclose(drive.place[1], drive.place[0], atol=1e-9)
    assert np.linalg.norm(drive.field_b_tesla[0]) == pytest.approx(5e-5)


@kinds
@pytest.mark.parametrize("latitude_deg", (-20, 89.995))
def test_velocity_rate_and_force_are_the_derivatives_of_what_they_move(kind, latitude_deg):
    t_s = np.add.outer([3.0, 41.3, 77.7], [-STEP_S, 0, STEP_S]).ravel()
    drive = Vehicle(kind=kind, seed=4, latitude_rad=np.radians(latitude_deg)).run(t_s)
    before, at, after = (slice(i, None, 3) for i in range(3))
    position, velocity, body = earth.position_of(drive.place), velocity_e(drive), attitude_e(drive)
    np.testing.assert_allclose(velocity[at], (position[after] - position[before]) / (2 * STEP_S), atol=2e-5)
    turn = (body[before].inv() * body[after]).as_rotvec() / (2 * STEP_S) + body[at].inv().apply(EARTH_E)
    np.testing.assert_allclose(drive.rate_b_rad_s[at], turn, atol=1e-6)
    gained = (velocity[after] - velocity[before]) / (2 * STEP_S)
    force = gained + 2 * np.cross(EARTH_E, velocity[at]) - earth.gravity_at(position[at])
    np.testing.assert_allclose(body[at].apply(drive.force_b_m_s2[at]), force, atol=3e-5)
    assert np.abs(turn).max() > 1e-5


@kinds
def test_means_of_rate_and_force_bring_the_motion_about_in_the_filter(kind):
    t_s = np.arange(6001) / 100
    drive = Vehicle(kind=kind, seed=3, mean_over_s=0.01).run(t_s)
    run = brought_about(drive)
    assert missed_m(run, drive) < 0.02
    np.testing.assert_allclose(run.velocity_n_m_s[-1], drive.velocity_n_m_s[-1], atol=1e-3)
    np.testing.assert_allclose(
        run.euler_rad[-1], Rotation.from_quat(drive.q_nb[-1, [1, 2, 3, 0]]).as_euler("ZYX")[::-1], atol=1e-6
    )


@kinds
def test_a_mean_is_that_of_the_instants_within(kind):
    t_s = 10 + np.arange(0, 0.0101, 0.0005)
    fine, mean = Vehicle(kind=kind, seed=2).run(t_s), Vehicle(kind=kind, seed=2, mean_over_s=0.01).run(t_s[-1:])
    for name, tolerance in (("rate_b_rad_s", 2e-6), ("force_b_m_s2", 1e-4)):
        values = getattr(fine, name)
        trapezoid = (values[0] / 2 + values[1:-1].sum(axis=0) + values[-1] / 2) / (len(values) - 1)
        np.testing.assert_allclose(getattr(mean, name)[0], trapezoid, atol=tolerance)
    np.testing.assert_array_equal(
        Vehicle(kind=kind, seed=2).run([10.0]).q_nb, Vehicle(kind=kind, seed=2, mean_over_s=0.5).run([10.0]).q_nb
    )


def test_vibration_is_as_strong_as_given_and_turns_nothing_away():
    settings = {"kind": "rest", "sway": 0, "seed": 3, "vibration_m_s2": 0.2}
    drive, still = Vehicle(**settings).run(np.arange(8000) / 1000), Vehicle(kind="rest", sway=0, seed=3).run([0.0])
    np.testing.assert_allclose(drive.force_b_m_s2.std(axis=0)[[0, 2]], 0.2, rtol=0.05)
    # A metre from the axis of both turns the force would be as large.
    acceleration = np.gradient(drive.rate_b_rad_s[:, :2], 1e-3, axis=0)
    np.testing.assert_allclose(acceleration.std(axis=0), 0.2, rtol=0.05)
    turned = Rotation.from_quat(drive.q_nb[:, [1, 2, 3, 0]]) * Rotation.from_quat(still.q_nb[:, [1, 2, 3, 0]]).inv()
    assert np.abs(turned.as_rotvec()).max() < 2e-4 and np.ptp(drive.place[:, 2]) < 0.02


def test_integrating_sensors_read_the_rate_and_not_the_turn_of_a_coning():
    """Roll and pitch that sway out of step turn a body further than the integral of its mean rate."""
    settings = {"kind": "ship", "sway": 20, "seed": 2}
    t_s = np.linspace(30, 30.5, 5001)
    fine, mean = Vehicle(**settings).run(t_s), Vehicle(**settings, mean_over_s=0.5).run(t_s[-1:])
    integral = (fine.rate_b_rad_s[0] / 2 + fine.rate_b_rad_s[1:-1].sum(axis=0) + fine.rate_b_rad_s[-1] / 2) / (len(t_s) - 1)
    body = attitude_e(fine)
    turn = (body[0].inv() * Rotation.from_rotvec(EARTH_E * 0.5) * body[-1]).as_rotvec() / 0.5
    np.testing.assert_allclose(mean.rate_b_rad_s[0], integral, atol=1e-6)
    assert np.abs(turn - integral).max() > 1e-4


def test_no_place_is_special():
    """Over a pole and the date line a car moves as elsewhere: its height stays, and its own rates are the same."""
    t_s = np.arange(0, 60, 0.1)
    drives = {
        name: Vehicle(seed=5, heading_unknown_rad=0, heading_rad=np.radians(heading), latitude_rad=np.radians(latitude), longitude_rad=np.radians(longitude)).run(t_s)
        for name, latitude, longitude, heading in (("plain", 45, 10, 0), ("pole", 89.999, 10, 0), ("date line", 45, 179.999, 90))
    }  # fmt: skip
    own = {}
    for name, drive in drives.items():
        np.testing.assert_allclose(drive.place[:, 2], 50, atol=1e-6)
        own[name] = drive.rate_b_rad_s - attitude_e(drive).inv().apply(EARTH_E)
        np.testing.assert_allclose(own[name], own["plain"], atol=1e-5)
    assert np.ptp(drives["pole"].place[:, 1]) > 1 and np.ptp(drives["date line"].place[:, 1]) > 6


def test_headings_are_any_and_follow_from_the_seed():
    headings = np.array([Vehicle(seed=seed).run([0.0]).heading_rad[0] for seed in range(200)])
    for quadrant in range(4):
        assert 30 < np.sum(np.floor(headings / (np.pi / 2)) + 2 == quadrant) < 75
    heading_rad = Vehicle(seed=3, heading_rad=1.0, heading_unknown_rad=0.1).run([0.0]).heading_rad[0]
    assert abs(heading_rad - 1) <= 0.1 and heading_rad != 1
    np.testing.assert_array_equal(Vehicle(seed=3).run([7.0]).place, Vehicle(seed=3).run([7.0]).place)
    assert not np.array_equal(Vehicle(seed=3).run([7.0]).place, Vehicle(seed=4).run([7.0]).place)


def test_the_motion_belongs_to_the_time_since_the_start():
    late, early = Vehicle(seed=1, start_s=1000.0).run([1020.0]), Vehicle(seed=1).run([20.0])
    for name in ("place", "q_nb", "rate_b_rad_s", "force_b_m_s2"):
        np.testing.assert_allclose(getattr(late, name), getattr(early, name), atol=1e-10)


def test_a_vehicle_is_copied_and_refuses_what_it_cannot_do():
    vehicle = Vehicle(kind="ship", seed=9, start_s=2.0)
    again = pickle.loads(pickle.dumps(vehicle))
    assert again.options == vehicle.options
    np.testing.assert_array_equal(again.run([5.0]).place, vehicle.run([5.0]).place)
    with pytest.raises(HnavValueError, match="before the start at 2 s"):
        vehicle.run([0.5])
    with pytest.raises(HnavValueError, match="t_s must increase"):
        vehicle.run([3.0, 2.5])
    with pytest.raises(HnavValueError, match="not finite"):
        vehicle.run([np.nan])
    with pytest.raises(HnavValueError, match="latitude_rad"):
        Vehicle(latitude_rad=2)
