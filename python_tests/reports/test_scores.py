"""The BROAD errors: answers that can be worked out by hand."""

import numpy as np
import pytest
from scipy import stats
from scipy.spatial.transform import Rotation

from hnav.reports.scores import errors_rad, nees, score


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


def scattered(covariance: np.ndarray, n: int = 20_000) -> tuple[np.ndarray, np.ndarray]:
    """Estimate and truth (n x 4) whose errors about the navigation axes are Gaussian with this covariance."""
    truth = Rotation.random(n, random_state=4)
    errors = np.random.default_rng(5).multivariate_normal(np.zeros(3), covariance, n)
    return scalar_first(Rotation.from_rotvec(-errors) * truth), scalar_first(truth)


def chi_square_bounds(n: int, dimension: int = 3) -> tuple[float, float]:
    """99.9 % bounds of NEES / 3 of n independent errors."""
    low, high = stats.chi2.ppf([0.0005, 0.9995], n * dimension)
    return low / (n * dimension), high / (n * dimension)


CORRELATED = 1e-4 * np.array([[4.0, 1.5, -0.5], [1.5, 1.0, 0.2], [-0.5, 0.2, 2.0]])


def test_nees_is_one_for_independent_errors_as_large_as_the_sigmas_say():
    sigma = np.array([0.02, 0.005, 0.05])
    estimate, truth = scattered(np.diag(sigma**2))
    low, high = chi_square_bounds(len(truth))
    found = nees(estimate, np.tile(sigma, (len(truth), 1)), truth)
    assert low < found < high


def test_nees_falls_with_the_square_of_the_stated_sigma():
    estimate, truth = scattered(CORRELATED, 50)
    sigma = np.full((50, 3), 0.01)
    assert nees(estimate, sigma, truth) == pytest.approx(4 * nees(estimate, 2 * sigma, truth))


def test_nees_is_of_scored_rows_that_are_known():
    truth = scalar_first(Rotation.identity(4))
    estimate = scalar_first(Rotation.from_euler("z", [[0.0], [0.03], [0.04], [1.0]]))
    sigma = np.full((4, 3), 0.01)
    movement = np.array([True, True, True, False])
    assert nees(estimate, sigma, truth, movement) == pytest.approx((9 + 16) / 3 / 3)
    sigma[1] = np.nan
    assert nees(estimate, sigma, truth, movement) == pytest.approx(16 / 2 / 3)
    assert np.isnan(nees(estimate, sigma, truth, np.zeros(4, bool)))


@pytest.mark.parametrize("spread, named", [
    (np.ones((3, 3)), "shape"),
    (np.zeros((5, 3)), "standard deviation is not positive"),
    (np.tile(np.eye(3), (5, 1, 1)), "shape"),
])  # fmt: skip
def test_an_impossible_spread_is_named(spread, named):
    q = scalar_first(Rotation.identity(5))
    with pytest.raises(ValueError, match=named):
        nees(q, spread, q)
