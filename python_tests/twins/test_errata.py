"""Each erratum of docs/errata.md that an equation decides: both sides are computed, the printed one fails, the corrected one holds."""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from hnav.certify.durations import is_gap, usual_interval
from hnav.certify.hrekf import C_bn, Omega, Xi, measurement
from twins.hrekf import printed_A, printed_measurement

RATE = np.array([0.3, -0.7, 1.1])
DIP = np.array([np.cos(1.1), 0, np.sin(1.1)])


@pytest.fixture
def q():
    q = np.random.default_rng(1).normal(size=4)
    return q / np.linalg.norm(q)


def by_scipy(q):
    """Body to navigation."""
    return Rotation.from_quat(q[[1, 2, 3, 0]])


def test_9_a_rate_in_body_axes_stands_on_the_right_of_the_product(q):
    dt = 1e-3
    turned = (by_scipy(q) * Rotation.from_rotvec(RATE * dt)).as_matrix()
    right, printed = (expm(A * dt) @ q for A in (Omega(RATE), printed_A(RATE, q)[:4, :4]))
    assert np.abs(by_scipy(right).as_matrix() - turned).max() < 1e-12
    assert np.abs(by_scipy(printed).as_matrix() - turned).max() > 1e-4


def test_9_six_of_twelve_entries_are_wrong(q):
    """Of the rates in the rows of the quaternion: the signs of the cross product, two in each of three rows."""
    right = Omega(RATE)
    printed = printed_A(RATE, q)[:4, :4]
    wrong = np.abs(right - printed) > 1e-12
    assert wrong.sum() == 6 and not wrong[0].any() and (wrong[1:].sum(axis=1) == 2).all()


def test_10_is_the_euler_step_and_11_its_jacobian(q):
    dt, b = 0.01, np.array([0.02, -0.01, 0.03])

    def step(x):
        return np.r_[x[:4] + dt * Xi(x[:4]) @ (RATE - x[4:]), x[4:]]

    x = np.r_[q, b]
    jacobian = np.stack([(step(x + 1e-6 * e) - step(x - 1e-6 * e)) / 2e-6 for e in np.eye(7)], axis=1)
    A = np.zeros((7, 7))
    A[:4, :4], A[:4, 4:] = Omega(RATE - b), -Xi(q)
    np.testing.assert_allclose(jacobian, np.eye(7) + dt * A, atol=1e-9)
    assert np.abs(jacobian - np.eye(7) - dt * printed_A(RATE - b, q)).max() > 1e-3


def test_11_in_the_place_of_A_makes_P_grow_as_e_to_2t():
    P, dt = np.eye(7), 1e-3
    for _ in range(1000):
        F = np.eye(7)  # I + dt A of a body at rest with no bias error
        P = P + dt * (F @ P + P @ F.T)
    assert P[0, 0] == pytest.approx(np.exp(2), rel=2e-3)


def test_13_to_16_the_rotation_matrix_turns_sensors_vectors(q):
    """The corrected prediction is the rotation by SciPy; as printed four rows of (16) are not."""
    C = by_scipy(q).as_matrix().T
    np.testing.assert_allclose(C_bn(q), C, atol=1e-12)
    right = np.r_[measurement(q, np.array([0, 0, -1.0]))[0], measurement(q, DIP)[0]]
    np.testing.assert_allclose(right, np.r_[C @ [0, 0, -1], C @ DIP], atol=1e-12)
    printed = printed_measurement(q, DIP[0], DIP[2])[0]
    assert (np.flatnonzero(np.abs(printed - right) > 1e-9) + 1).tolist() == [2, 4, 5, 6]


def test_17_roll_and_pitch_are_about_x_and_y():
    yaw, pitch, roll = 0.4, 0.3, -0.8
    a, b, c, d = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_quat()[[3, 0, 1, 2]]
    assert np.arctan2(2 * (a * b + c * d), 1 - 2 * (b * b + c * c)) == pytest.approx(roll)
    assert np.arcsin(2 * (a * c - d * b)) == pytest.approx(pitch)


def test_x0_of_zero_never_starts():
    """h is quadratic, so its derivative at zero is zero: no gain ever."""
    h, H = measurement(np.zeros(4), DIP)
    assert not h.any() and not H.any()


def test_5_takes_the_estimate_away_from_the_state_and_6_is_its_error():
    """A scalar state measured twice as far as expected; e = x - x_hat of (4)."""
    x, x_hat, K = 2.0, 1.0, 0.6
    nu = x - x_hat
    corrected, printed = x_hat + K * nu, x_hat - K * nu
    assert abs(x - corrected) < abs(x - x_hat) < abs(x - printed)
    assert x - corrected == pytest.approx((x - x_hat) - K * nu)  # (6) as printed


def test_algorithm_2_weighs_the_estimate_and_keeps_M():
    """gamma^-2 L'L leaves the information; Woodbury's form needs no inverse of P. Noise M v has the covariance M R M'."""
    rng = np.random.default_rng(2)
    G = rng.normal(size=(3, 3))
    P, L, gamma = G @ G.T + np.eye(3), np.diag([1.0, 0.5, 0.0]), 4.0
    inflated = P + P @ L.T @ np.linalg.solve(gamma**2 * np.eye(3) - L @ P @ L.T, L @ P)
    np.testing.assert_allclose(inflated, np.linalg.inv(np.linalg.inv(P) - L.T @ L / gamma**2), rtol=1e-9)
    M, sigma = np.diag([1.0, 3.0]), 0.2
    v = sigma * rng.normal(size=(2, 200_000))
    np.testing.assert_allclose(np.cov(M @ v), M @ (sigma**2 * np.eye(2)) @ M.T, atol=0.02)


# --------------------------------------------------------------------------------------------- the second paper


def differenced_noise(An, Qv, Qw, steps, seed=3):
    """xi(k) = w(k) + v(k+1) - An v(k), one channel."""
    rng = np.random.default_rng(seed)
    v, w = np.sqrt(Qv) * rng.normal(size=steps + 1), np.sqrt(Qw) * rng.normal(size=steps)
    return w + v[1:] - An * v[:-1]


def test_whiteness_of_xi_holds_without_v_alone():
    An, Qv, Qw, steps = 0.9, 2.0, 1.0, 400_000
    xi = differenced_noise(An, Qv, Qw, steps)
    assert np.mean(xi[1:] * xi[:-1]) == pytest.approx(-An * Qv, abs=0.03)
    white = differenced_noise(An, 0.0, Qw, steps)
    assert abs(np.mean(white[1:] * white[:-1])) < 0.01


def test_S_star_is_biased_in_a_healthy_channel():
    """max(1, S_ii) of M white normal innovations has the mean 1 + 1/sqrt(pi M)."""
    M = 20
    S = np.mean(np.random.default_rng(4).normal(size=(200_000, M)) ** 2, axis=1)
    assert np.mean(np.maximum(1, S)) == pytest.approx(1 + 1 / np.sqrt(np.pi * M), abs=5e-3)


def test_S_star_R_is_symmetric_for_a_diagonal_R_only():
    S = np.diag([1.0, 3.0])
    full, diagonal = np.array([[1.0, 0.4], [0.4, 2.0]]), np.diag([1.0, 2.0])
    assert not np.allclose(S @ full, (S @ full).T) and np.allclose(S @ diagonal, (S @ diagonal).T)


def test_the_gain_of_the_next_prediction_takes_C():
    """cov(x(k+1), e) = A P Hd' + C: by sampling one step of a scalar system without v."""
    A, H, G, An, P, Qw, QU, n = 0.9, 1.0, 1.0, 0.5, 2.0, 1.5, 0.3, 400_000
    rng = np.random.default_rng(5)
    error, w, U = (np.sqrt(s) * rng.normal(size=n) for s in (P, Qw, QU))
    Hd = H * A - An * H
    e = Hd * error + H * G * w + U  # the innovation, by the error of x(k)
    after = A * error + G * w
    C = G * Qw * G * H
    assert np.mean(after * e) == pytest.approx(A * P * Hd + C, rel=0.02)
    assert np.mean(error * e) == pytest.approx(P * Hd, rel=0.05)  # x(k) itself has no C
    assert np.mean(e * e) == pytest.approx(Hd * P * Hd + H * G * Qw * G * H + QU, rel=0.02)


def test_euler_of_the_gauss_markov_error_is_its_first_term_and_loses_variance():
    dt, tau, sigma = 0.5, 1.0, 2.0
    exact, euler = np.exp(-dt / tau), 1 - dt / tau
    QU = sigma**2 * (1 - np.exp(-2 * dt / tau))
    assert QU / (1 - exact**2) == pytest.approx(sigma**2)
    assert QU / (1 - euler**2) < 0.9 * sigma**2


# --------------------------------------------------------------------------------------------- gaps in the reference


def test_a_gap_is_three_usual_intervals_and_a_slower_sensor_is_accepted():
    assert not is_gap(0.03, 0.0) and not is_gap(0.03, 0.01) and is_gap(0.031, 0.01)
    usual = 0.01
    for _ in range(40):
        usual = usual_interval(0.04, usual)
    assert usual == pytest.approx(0.04, rel=0.2)
