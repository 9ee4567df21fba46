"""The BROAD errors: answers that can be worked out by hand."""

import numpy as np
import pytest
from hnav.scores import errors_rad, score
from scipy.spatial.transform import Rotation


def scalar_first(rotation: Rotation) -> np.ndarray:
    return np.atleast_2d(rotation.as_quat())[:, [3, 0, 1, 2]]


def test_a_turn_about_the_vertical_is_heading_alone():
    truth = Rotation.random(20, random_state=1)
    turned = Rotation.from_euler("z", [[10.0]] * 20, degrees=True) * truth
    total, heading, inclination = errors_rad(scalar_first(turned), scalar_first(truth))
    np.testing.assert_allclose(np.degrees(total), 10, atol=1e-6)
    np.testing.assert_allclose(np.degrees(heading), 10, atol=1e-6)
    np.testing.assert_allclose(inclination, 0, atol=1e-6)


def test_a_turn_about_a_horizontal_axis_is_inclination_alone():
    truth = Rotation.random(20, random_state=2)
    tilted = Rotation.from_euler("y", [[7.0]] * 20, degrees=True) * truth
    total, heading, inclination = errors_rad(scalar_first(tilted), scalar_first(truth))
    np.testing.assert_allclose(np.degrees(inclination), 7, atol=1e-6)
    np.testing.assert_allclose(heading, 0, atol=1e-6)
    np.testing.assert_allclose(np.degrees(total), 7, atol=1e-6)


def test_opposite_signs_are_the_same_rotation():
    q = scalar_first(Rotation.random(5, random_state=3))
    assert score(-q, q).total == pytest.approx(0, abs=1e-6)


def test_only_movement_with_a_known_truth_counts():
    truth = scalar_first(Rotation.identity(4))
    estimate = scalar_first(Rotation.from_euler("z", [[0.0], [3.0], [4.0], [90.0]], degrees=True))
    movement = np.array([True, True, True, False])
    assert score(estimate, truth, movement).total == pytest.approx(np.sqrt((9 + 16) / 3))
    truth[0] = np.nan
    assert score(estimate, truth, movement).total == pytest.approx(np.sqrt((9 + 16) / 2))
    assert np.isnan(score(estimate, truth, np.zeros(4, bool)).total)
