"""Two attitudes compared, and the figures that are drawn of them."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hnav.reports import plots
from hnav.reports.recording_run import compare
from hnav.rotations import continuous_quaternion, rotation_error_rad

RNG_SEED = 20240508


def test_a_constant_heading_offset_is_found_and_removed():
    t_s = np.arange(0.0, 4.0, 0.02)
    truth = Rotation.random(len(t_s), rng=np.random.default_rng(RNG_SEED))
    turned = Rotation.from_euler("z", 25.0, degrees=True) * truth
    against = compare(t_s, scalar_first(turned), scalar_first(truth))
    assert against.heading_offset_deg == pytest.approx(25.0, abs=1e-9)
    assert np.nanmax(np.abs(against.heading_deg)) < 1e-9
    assert np.nanmax(against.inclination_deg) < 1e-5
    assert np.nanmedian(against.total_deg) == pytest.approx(25.0, abs=1e-9)


def test_an_inclination_is_not_taken_for_heading():
    t_s = np.arange(0.0, 4.0, 0.02)
    truth = Rotation.random(len(t_s), rng=np.random.default_rng(RNG_SEED))
    tilted = Rotation.from_euler("x", 4.0, degrees=True) * truth
    against = compare(t_s, scalar_first(tilted), scalar_first(truth))
    assert np.nanmax(np.abs(against.heading_deg)) < 1e-9
    np.testing.assert_allclose(against.inclination_deg[np.isfinite(against.inclination_deg)], 4.0, atol=1e-9)


def test_the_first_second_is_left_out_of_the_comparison():
    t_s = 100.0 + np.arange(0.0, 4.0, 0.02)
    q = np.tile([1.0, 0.0, 0.0, 0.0], (len(t_s), 1))
    assert (np.isfinite(compare(t_s, q, q).total_deg) == (t_s >= 101.0)).all()


def test_rotation_error_leads_from_estimate_to_reference():
    estimate = Rotation.from_euler("ZYX", [40.0, 10.0, -20.0], degrees=True)
    error = np.array([0.01, -0.02, 0.3])
    found = rotation_error_rad(scalar_first(estimate)[None], scalar_first(Rotation.from_rotvec(error) * estimate)[None])
    np.testing.assert_allclose(found[0], error, atol=1e-12)


def test_a_turn_is_one_line_of_yaw():
    yaw_deg = np.linspace(0.0, 720.0, 200)
    turning = scalar_first(Rotation.from_euler("z", yaw_deg[:, None], degrees=True))
    np.testing.assert_allclose(plots.euler_deg(turning)[:, 2], yaw_deg, atol=1e-9)


def test_quaternions_of_one_rotation_are_drawn_without_sign_jumps():
    turning = scalar_first(Rotation.from_euler("z", np.linspace(0.0, 700.0, 200)[:, None], degrees=True))
    flipped = turning * np.where(np.arange(200) % 3 == 0, -1.0, 1.0)[:, None]
    assert np.abs(np.diff(continuous_quaternion(flipped), axis=0)).max() < 0.05


def test_the_share_inside_the_band_is_counted():
    axes = plots.figure(200, 200).subplots()
    error_deg = np.array([0.5, 2.9, -3.1, np.nan])
    assert plots.draw_error_band(axes, np.arange(4.0), error_deg, np.ones(4), "error") == pytest.approx(2 / 3)


def test_running_means_lie_side_by_side_and_skip_gaps():
    t_s = np.arange(0.0, 4.0, 0.5)
    values = np.array([1.0, 3.0, np.nan, np.nan, 5.0, np.nan, 7.0, 9.0])
    middle_s, mean = plots.running_mean(t_s, values, 1.0)
    np.testing.assert_allclose(middle_s, [0.5, 2.5, 3.5])
    np.testing.assert_allclose(mean, [2.0, 5.0, 8.0])


def scalar_first(rotation: Rotation) -> np.ndarray:
    return rotation.as_quat()[..., [3, 0, 1, 2]]
