"""Claims of docs/errata.md, papers.md and filters.md that an equation decides: the page says so, and both sides are computed."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

import hnav
from checkout import TOP
from hnav.certify.hrekf import C_bn, Omega, Xi, measurement
from hnav.filters.observability import removed
from hnav.filters.options import option_table
from hnav.rotations import quaternion_product, rotated
from twins.hrekf import printed_A

U = np.array([0.3, -0.7, 1.1])
DIP = 1.1


def said(page: str, *claims: str) -> None:
    """The page has these words, wherever its lines break."""
    text = " ".join((TOP / "docs" / f"{page}.md").read_text(encoding="utf-8").split())
    for claim in claims:
        assert " ".join(claim.split()) in text, f"{page}.md no longer says: {claim}"


@pytest.fixture
def rng():
    return np.random.default_rng(7)


@pytest.fixture
def q(rng):
    q = rng.normal(size=4)
    return q / np.linalg.norm(q)


@pytest.fixture
def P(rng):
    G = rng.normal(size=(4, 4))
    return G @ G.T + np.eye(4)


def rotation(q):
    """Body to navigation, 3 x 3, by SciPy."""
    return Rotation.from_quat(q[[1, 2, 3, 0]]).as_matrix()


# --------------------------------------------------------------------------------------------- errata, first paper


def test_the_two_products_of_a_quaternion_and_a_rate(q):
    said(
        "errata",
        r"q \otimes (0, u) = (-v \cdot u,\; q_0 u + v \times u)",
        r"(0, u) \otimes q = (-v \cdot u,\; q_0 u - v \times u)",
    )
    v = q[1:]
    for left, right, sign in ((q, np.r_[0, U], 1), (np.r_[0, U], q, -1)):
        np.testing.assert_allclose(quaternion_product(left, right), np.r_[-v @ U, q[0] * U + sign * np.cross(v, U)], atol=1e-15)


def test_a_level_body_that_yaws_hides_the_error():
    said("errata", "A level body that yaws has v along u; the product vanishes")
    level, rate = np.array([0.8, 0, 0, 0.6]), np.array([0, 0, 1.3])
    tilted = np.array([0.8, 0.6, 0, 0])
    for q, differs in ((level, False), (tilted, True)):
        assert (np.abs(Omega(rate) @ q - printed_A(rate, q)[:4, :4] @ q).max() > 1e-3) == differs


def test_omega_and_xi_are_the_derivatives_of_the_kinematics(q):
    said("errata", r"A is $\Omega(u)$ by q and $-\Xi(q)$ by the bias")
    flow = 0.5 * quaternion_product(q, np.r_[0, U])
    np.testing.assert_allclose(Omega(U) @ q, flow, atol=1e-15)
    np.testing.assert_allclose(Xi(q) @ U, flow, atol=1e-15)


def test_the_printed_transition_in_the_place_of_A(P, rng):
    said("errata", r"\dot P = F P + P F' + L Q L' = 2 P + dt\,(A P + P A') + L Q L'")
    A, Q, dt = rng.normal(size=(4, 4)), np.eye(4), 0.01
    F = np.eye(4) + dt * A
    np.testing.assert_allclose(F @ P + P @ F.T + Q, 2 * P + dt * (A @ P + P @ A.T) + Q, atol=1e-12)


def test_the_continuous_covariance_is_the_limit_of_the_step(P, rng):
    said("errata", r"dividing by dt gives $\dot P = A P + P A' + L Q L'$")
    A, Q, dt = rng.normal(size=(4, 4)), np.eye(4), 1e-7
    Phi = np.eye(4) + dt * A
    np.testing.assert_allclose((Phi @ P @ Phi.T + Q * dt - P) / dt, A @ P + P @ A.T + Q, rtol=1e-5, atol=1e-5)


def test_the_rotation_matrix_of_the_page(q):
    said("errata", r"q_0^2+q_1^2-q_2^2-q_3^2 & 2(q_1 q_2 - q_0 q_3) & 2(q_1 q_3 + q_0 q_2)")
    a, b, c, d = q
    R = [[a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)],
         [2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)],
         [2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d]]  # fmt: skip
    np.testing.assert_allclose(R, rotation(q), atol=1e-15)


def test_the_accelerometer_at_rest_sees_minus_the_third_row(q):
    said("errata", "The accelerometer at rest sees C (0, 0, -1), minus the third row of R")
    np.testing.assert_allclose(measurement(q, np.array([0, 0, -1.0]))[0], -rotation(q)[2], atol=1e-14)


def test_the_field_is_of_the_first_and_the_third_row(q):
    said("errata", "The field is cos dip times the first row plus sin dip times the third")
    seen = measurement(q, np.array([np.cos(DIP), 0, np.sin(DIP)]))[0]
    np.testing.assert_allclose(seen, np.cos(DIP) * rotation(q)[0] + np.sin(DIP) * rotation(q)[2], atol=1e-14)


def test_elements_of_the_matrix_by_the_angles():
    said(
        "errata",
        "$R_{32}$ is cos pitch sin roll and $R_{33}$ cos pitch cos roll",
        r"pitch $= -\arcsin R_{31}$, yaw $= \operatorname{atan2}(R_{21}, R_{11})$",
    )
    yaw, pitch, roll = 0.4, 0.3, -0.8
    R = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_matrix()
    np.testing.assert_allclose(R[2, 1:], np.cos(pitch) * np.array([np.sin(roll), np.cos(roll)]), atol=1e-15)
    assert (-np.arcsin(R[2, 0]), np.arctan2(R[1, 0], R[0, 0])) == pytest.approx((pitch, yaw))


def test_h_is_quadratic_and_H_linear(q):
    said("errata", "h is quadratic in q, so H is linear in q and H(0) = 0")
    field = np.array([np.cos(DIP), 0, np.sin(DIP)])
    (h, H), (h2, H2) = measurement(q, field), measurement(2 * q, field)
    np.testing.assert_allclose(h2, 4 * h, atol=1e-14)
    np.testing.assert_allclose(H2, 2 * H, atol=1e-14)
    assert not measurement(0 * q, field)[1].any()


def test_without_H_there_is_no_gain(P):
    said("errata", "Then K = 0 and q stays 0, whatever is measured")
    H, R = np.zeros((3, 4)), np.eye(3)
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    assert not (K @ np.array([5.0, -3.0, 2.0])).any()


def test_the_mean_of_the_squared_correction_is_what_the_covariance_falls_by(P, rng):
    said("errata", r"$P^+ = P^- - K S K'$", r"E[K \nu \nu' K'] = K S K' = P^-_k - P^+_k")
    H, R = rng.normal(size=(2, 4)), np.eye(2)
    S = H @ P @ H.T + R
    K = P @ H.T @ np.linalg.inv(S)
    np.testing.assert_allclose(P - K @ S @ K.T, (np.eye(4) - K @ H) @ P, atol=1e-12)
    nu = np.linalg.cholesky(S) @ rng.normal(size=(2, 200_000))
    np.testing.assert_allclose((K @ nu) @ (K @ nu).T / nu.shape[1], K @ S @ K.T, atol=0.03)


def test_as_printed_the_adaptation_is_a_hundredth_of_Q_at_100_hz():
    said("errata", r"where P+ has settled the mean is T Q, a hundredth of Q at 100 Hz")
    Q, T, R, p = 0.3, 0.01, 2.0, 1.0
    for _ in range(20_000):
        before = p + T * Q
        K = before / (before + R)
        p = (1 - K) * before
    assert K**2 * (before + R) == pytest.approx(T * Q, rel=1e-9)
    assert (K**2 * (before + R) + p - p) / T == pytest.approx(Q, rel=1e-9)  # the corrected form


def test_woodbury_needs_no_inverse_of_P(P):
    said("errata", r"(P^{-1} - \gamma^{-2} L'L)^{-1} = P + P L'\,(\gamma^2 I - L P L')^{-1} L P")
    L, gamma = np.diag([1.0, 0.5, 0.2, 0.0]), 5.0
    left = np.linalg.inv(np.linalg.inv(P) - L.T @ L / gamma**2)
    np.testing.assert_allclose(left, P + P @ L.T @ np.linalg.inv(gamma**2 * np.eye(4) - L @ P @ L.T) @ L @ P, rtol=1e-9)


@pytest.mark.parametrize("factor", [0.99, 1.01])
def test_the_robust_covariance_exists_below_gamma(P, factor):
    said("errata", r"it exists while $\lambda_{\max}(L P L') < \gamma^2$")
    gamma2 = np.linalg.eigvalsh(P)[-1] * factor
    information = np.linalg.inv(P) - np.eye(4) / gamma2
    assert (np.linalg.eigvalsh(information)[0] > 0) == (factor > 1)


def test_the_flow_of_a_quaternion_does_not_contract(rng):
    said("errata", "of a quaternion preserves the length of differences, so it cannot contract")
    flow = expm(Omega(U) * 3.0)
    a, b = rng.normal(size=(2, 4))
    assert np.linalg.norm(flow @ (a - b)) == pytest.approx(np.linalg.norm(a - b), rel=1e-12)
    np.testing.assert_allclose(np.linalg.eigvals(Omega(U)).real, 0, atol=1e-12)


# --------------------------------------------------------------------------------------------- errata, second paper

A, H, G, An = np.array([[0.9, 0.1], [-0.2, 0.8]]), np.eye(2), np.eye(2), np.diag([0.95, 0.7])
Qw, Qv, QU = np.diag([0.5, 0.2]), np.diag([1.0, 2.0]), np.diag([0.3, 0.1])
Hd = H @ A - An @ H
C = G @ Qw @ G.T @ H.T


def white(rng, Q, n):
    return np.linalg.cholesky(Q) @ rng.normal(size=(len(Q), n))


def test_a_difference_measures_the_state_and_xi(rng):
    said("errata", r"\mu(k) &= z(k+1) - A_n z(k) = H_d\,x(k) + H B\,u(k) + \xi(k), \qquad H_d = H A - A_n H")
    x, colour, w, noise, later, U_k, Bu = rng.normal(size=(7, 2))
    z = H @ x + noise + colour
    z_next = H @ (A @ x + Bu + G @ w) + later + An @ colour + U_k
    xi = H @ G @ w + U_k + later - An @ noise
    np.testing.assert_allclose(z_next - An @ z, Hd @ x + H @ Bu + xi, atol=1e-14)


def test_the_covariances_of_xi(rng):
    said("errata", r"R &= E[\xi \xi'] = H G Q_w G'H' + B_n Q_U B_n' + Q_v + A_n Q_v A_n', \qquad C = E[G w \xi'] = G Q_w G'H'")
    n = 400_000
    w, U_k, noise, later = (white(rng, Q, n) for Q in (Qw, QU, Qv, Qv))
    xi = H @ G @ w + U_k + later - An @ noise
    np.testing.assert_allclose(xi @ xi.T / n, C + QU + Qv + An @ Qv @ An.T, atol=0.03)
    np.testing.assert_allclose(G @ w @ xi.T / n, C, atol=0.01)


def test_neighbours_share_a_noise(rng):
    said("errata", r"$E[\xi(k)\,\xi(k-1)'] = -A_n Q_v$")
    v = white(rng, Qv, 400_001)
    xi = v[:, 1:] - An @ v[:, :-1]
    np.testing.assert_allclose(xi[:, 1:] @ xi[:, :-1].T / (xi.shape[1] - 1), -An @ Qv, atol=0.02)


def predicted(K, P):
    """Covariance of x(k+1) when K e corrects its prediction, v = 0: e and w are correlated by C."""
    S = Hd @ P @ Hd.T + C + QU
    cross = A @ P @ Hd.T + C
    return A @ P @ A.T + Qw - K @ cross.T - cross @ K.T + K @ S @ K.T


def test_the_gain_with_C_is_the_best(rng):
    said("errata", r"K = (A P H_d' + C)\,S^{-1}, \quad x(k+1) = A x + B u + K e")
    P = np.diag([2.0, 1.0])
    S = Hd @ P @ Hd.T + C + QU
    best = (A @ P @ Hd.T + C) @ np.linalg.inv(S)
    least = np.trace(predicted(best, P))
    assert np.trace(predicted(A @ P @ Hd.T @ np.linalg.inv(S), P)) > 1.05 * least
    assert all(np.trace(predicted(best + 0.1 * rng.normal(size=(2, 2)), P)) > least for _ in range(20))


def test_the_error_of_x_is_independent_of_what_acts_on_the_next(rng):
    said("errata", "The error of x(k) is independent of w(k), which acts on x(k+1)")
    n, P = 400_000, np.diag([2.0, 1.0])
    error, w, U_k = white(rng, P, n), white(rng, Qw, n), white(rng, QU, n)
    e = Hd @ error + H @ G @ w + U_k
    np.testing.assert_allclose(error @ e.T / n, P @ Hd.T, atol=0.02)
    np.testing.assert_allclose((A @ error + G @ w) @ e.T / n, A @ P @ Hd.T + C, atol=0.02)


def test_a_mode_at_the_rate_of_the_colour_is_not_seen():
    said("errata", "A mode a of A with $H_d a = 0$ is not seen by any $\\mu$")
    a, same = np.array([1.0, -1.0]), 0.95
    mode = same * np.outer(a, a) / 2 + 0.3 * np.ones((2, 2)) / 2  # eigenvectors a and (1, 1)
    seen = H @ mode - same * np.eye(2) @ H
    np.testing.assert_allclose(seen @ a, 0, atol=1e-15)
    for k in range(5):
        np.testing.assert_allclose(seen @ np.linalg.matrix_power(mode, k) @ a, 0, atol=1e-15)


def test_z0_is_the_only_absolute_information():
    said("errata", r"$z(0) = H x(0) + v + \lambda(0)$ is an ordinary measurement of noise $Q_v + \Lambda_0$")
    P, Lambda = np.diag([50.0, 80.0]), np.diag([0.5, 0.4])
    both = np.block([[P, np.zeros((2, 2))], [np.zeros((2, 2)), Lambda]])  # x and lambda as states
    Ha = np.hstack([H, np.eye(2)])
    with_states = both - both @ Ha.T @ np.linalg.inv(Ha @ both @ Ha.T + Qv) @ Ha @ both
    as_noise = P - P @ H.T @ np.linalg.inv(H @ P @ H.T + Qv + Lambda) @ H @ P
    np.testing.assert_allclose(with_states[:2, :2], as_noise, rtol=1e-12)


def test_the_transpose_of_S_star_R():
    said("errata", "(S\\* R)' = R S\\*: equal to S\\* R for a diagonal R only")
    S, full = np.diag([1.0, 3.0]), np.array([[1.0, 0.4], [0.4, 2.0]])
    np.testing.assert_allclose((S @ full).T, full @ S)
    assert np.abs(S @ full - full @ S).max() > 0.5 and np.allclose(S @ np.diag([1.0, 2.0]), np.diag([1.0, 2.0]) @ S)


def test_twenty_samples_overstate_by_an_eighth(rng):
    said(
        "errata",
        r"With M = 20 the noise of healthy channels is overstated by 12.6 % on the mean",
        r"$S_{ii}$ is about $1 + \sqrt{2/M}\,n$",
    )
    M = 20
    S = rng.chisquare(M, 400_000) / M
    assert np.std(S) == pytest.approx(np.sqrt(2 / M), rel=0.01)
    assert 1 / np.sqrt(np.pi * M) == pytest.approx(0.126, abs=5e-4)
    assert np.mean(np.maximum(1, S)) - 1 == pytest.approx(0.126, abs=5e-3)


def test_josephs_form_is_of_any_gain_and_the_other_is_too_small(P, rng):
    said(
        "errata",
        r"$P^+ = (I - K H)\,P\,(I - K H)' + K R K'$ holds for any K",
        "If K is computed with S\\* R and P with R, P is that of the unadapted gain and too small",
    )
    H1, R, faulty = rng.normal(size=(2, 4)), np.eye(2), 9 * np.eye(2)
    K = P @ H1.T @ np.linalg.inv(H1 @ P @ H1.T + faulty)
    kept = np.eye(4) - K @ H1
    e, v = np.linalg.cholesky(P) @ rng.normal(size=(4, 200_000)), 3 * rng.normal(size=(2, 200_000))
    after = kept @ e - K @ v
    true = kept @ P @ kept.T + K @ faulty @ K.T
    np.testing.assert_allclose(after @ after.T / 200_000, true, atol=0.05 * np.trace(P))
    unadapted = P - P @ H1.T @ np.linalg.inv(H1 @ P @ H1.T + R) @ H1 @ P
    assert np.linalg.eigvalsh(true - unadapted)[0] > -1e-12 and np.trace(unadapted) < 0.9 * np.trace(true)


def test_the_exact_step_of_a_gauss_markov_error(rng):
    said(
        "errata",
        r"Euler's $1 - dt/\tau$ is its first term",
        r"$\sigma^2 = A_n^2 \sigma^2 + Q_U$, $Q_U = \sigma^2 (1 - e^{-2\,dt/\tau})$",
    )
    sigma, tau = 1.7, 4.0
    for dt in (1e-3, 1e-2):
        assert abs(np.exp(-dt / tau) - (1 - dt / tau)) == pytest.approx((dt / tau) ** 2 / 2, rel=0.01)
    a = np.exp(-0.5 / tau)
    x = sigma * rng.normal(size=200_000)
    for _ in range(20):
        x = a * x + sigma * np.sqrt(1 - a * a) * rng.normal(size=len(x))
    assert np.std(x) == pytest.approx(sigma, rel=0.01)


# --------------------------------------------------------------------------------------------- papers.md


def test_the_ratios_of_the_second_papers_table_are_those_of_the_result():
    """AMDKF over MDKF, channel by channel, one sample late as they are."""
    shown = "0.98 | 0.61 | 1.45 | 0.98 | 1.03 | 1.03 | 1.01 | 1.00"
    said("papers", f"| 1000 flights of the F-4C | {shown} |")
    rows = json.loads((TOP / "docs/results/coloured.json").read_text())["printed"][0]["rows"]
    errors = {row[0]: np.array([float(cell.split()[0]) for cell in row[1:]]) for row in rows}
    ratios = errors["AMDKF, M = 20"] / errors["MDKF"]
    np.testing.assert_allclose(ratios, [float(cell) for cell in shown.split(" | ")], atol=0.03)


def test_every_option_of_the_table_exists():
    said("papers", "`quaternion_noise_per_sqrt_s`, `gyro_noise_rad_per_sqrt_s`, `gyro_bias_walk_rad_s_per_sqrt_s`")
    table = (TOP / "docs/papers.md").read_text().split("## Coloured")[0]
    known = option_table("hrekf")
    named = set(re.findall(r"`((?:gamma|gyro|accel|mag|quaternion|start|reference|navigation)_[a-z_]*[a-z])`", table))
    assert len(named) >= 9 and named <= set(known)


@pytest.mark.parametrize("scenario", ["fitted", "fitted_honest"])
def test_the_scenarios_of_the_experiment_exist(scenario):
    said("papers", f"`{scenario}`")
    assert list((TOP / "models/systems/turntable").rglob(f"*{scenario}.ssv")), scenario


# --------------------------------------------------------------------------------------------- filters.md


def test_q_turns_body_vectors_into_navigation_axes(q):
    said("filters", "q is Hamilton, scalar first, $v_n = R(q)\\,v_b$")
    v = np.array([0.2, -1.0, 0.5])
    np.testing.assert_allclose(rotated(q[None], v)[0], rotation(q) @ v, atol=1e-15)
    np.testing.assert_allclose(C_bn(q), rotation(q).T, atol=1e-14)
    i, j, k = np.eye(4)[1:]
    np.testing.assert_allclose(quaternion_product(i, j), k)  # Hamilton's: i j = k


def test_level_and_at_rest_is_minus_g_downwards():
    said(
        "filters", "f is the specific force, level and at rest $(0, 0, -g)$", r"The field is $m_n = (\cos\delta, 0, \sin\delta)$"
    )
    n = 100
    force, field = np.tile([0, 0, -9.81], (n, 1)), 5e-5 * np.tile([np.cos(DIP), 0, np.sin(DIP)], (n, 1))
    run = hnav.Filter("ahrs").run(0.01 * np.arange(n), np.zeros((n, 3)), force, field)
    np.testing.assert_allclose(run.q_nb[-1], [1, 0, 0, 0], atol=1e-9)


def test_the_estimate_does_not_depend_on_the_times_of_output(rng):
    said("filters", "a function of the samples alone, not of the times of output")
    answers = []
    for more in (0, 3):
        one = hnav.Filter("ahrs")
        for k in range(60):
            one.push_imu(0.01 * k, [0.1, 0.2, 0.3], [0.1, 0, -9.8])
            one.push_mag(0.01 * k, [2e-5, 0, 4e-5])
            for i in range(more + 1):
                one.advance(0.01 * k + 0.003 * i)
        answers.append(one.posterior())
    np.testing.assert_array_equal(answers[0].q_nb, answers[1].q_nb)
    np.testing.assert_array_equal(answers[0].sigma, answers[1].sigma)


@pytest.mark.parametrize("m", [1, 3])
def test_the_nis_is_chi_square(rng, m):
    said(
        "filters",
        r"A measurement of $m$ rows has the NIS $\nu' S^{-1} \nu$, with a chi-square distribution of $m$ degrees of freedom",
    )
    B = rng.normal(size=(m, m)) + 2 * np.eye(m)
    nu = B @ rng.normal(size=(m, 100_000))
    nis = np.einsum("ik,ik->k", nu, np.linalg.solve(B @ B.T, nu))
    for share in (0.5, 0.95):
        assert np.mean(nis < chi2.ppf(share, m)) == pytest.approx(share, abs=6e-3)


def gated(nu, law, hph=4.0, R=1.0, limit=9.0):
    """NIS after a law beyond the limit, and the influence K nu of the sample on the measured quantity."""
    o = nu**2 / (hph + R) / limit
    if law == "noise":
        R = o * R
    elif law == "redescending":
        hph, R = o * hph, o * o * R
    S = (hph + R) * (o if law == "innovation" else 1)
    return nu**2 / S, hph / S * nu


def test_the_innovation_law_brings_the_nis_to_its_limit():
    """Huber's law would divide the gain by the root of o, and keep the influence."""
    said("filters", r"$S \leftarrow o S$: the NIS becomes the limit (Chang 2014), the influence falls with the distance")
    assert [gated(nu, "innovation")[0] for nu in (10.0, 30.0, 300.0)] == pytest.approx([9.0] * 3)
    assert gated(30.0, "innovation")[1] == pytest.approx(10 * gated(300.0, "innovation")[1])


def test_noise_alone_leaves_the_nis_between():
    said("filters", r"| noise | $R \leftarrow o R$ |")
    for nu in (10.0, 30.0, 300.0):
        assert 9.0 < gated(nu, "noise")[0] < nu**2 / 5.0


def test_the_redescending_law_forgets_what_is_far_off():
    said("filters", r"$H P H' \leftarrow o\,H P H'$, $R \leftarrow o^2 R$: the influence falls with the distance")
    near, far, farther = (gated(nu, "redescending")[1] for nu in (30.0, 300.0, 3000.0))
    assert near > far > farther and far / farther == pytest.approx(10, rel=0.01)


def test_the_information_of_a_correction():
    said("filters", "A correction from the variance $p^-$ to $p^+$ adds $1/p^+ - 1/p^-$")
    before, h, R = 3.0, 0.7, 0.5
    after = before - (before * h) ** 2 / (h * before * h + R)
    assert 1 / after - 1 / before == pytest.approx(h * h / R)


def test_successive_differences_measure_noise_and_not_slow_changes(rng):
    said("filters", "is sensitive to noise and insensitive to slow changes")
    noise, slow = rng.normal(size=20_000), np.linspace(0, 30, 20_000)
    measured = [np.mean(np.diff(x) ** 2) / 2 for x in (noise, noise + slow, 2 * noise)]
    assert measured == pytest.approx([1, 1, 4], rel=0.05)
    assert np.var(noise + slow) > 50


def test_the_innovations_of_a_consistent_filter_are_white_and_their_mean_has_its_variance(rng):
    said(
        "filters",
        "The normalised innovations of a consistent filter are white with unit variance",
        "Its square divided by its variance is 1 for a consistent filter",
    )
    a, Q, R, n = 0.98, 0.2, 1.0, 100_000
    w, v = np.sqrt(Q) * rng.normal(size=n), np.sqrt(R) * rng.normal(size=n)
    x = x_hat = 0.0
    p, found = 1.0, np.empty(n)
    for k in range(n):
        x, x_hat, p = a * x + w[k], a * x_hat, a * a * p + Q
        S = p + R
        nu = x + v[k] - x_hat
        found[k], x_hat, p = nu / np.sqrt(S), x_hat + p / S * nu, p * R / S
    assert np.var(found) == pytest.approx(1, abs=0.02) and abs(np.mean(found[1:] * found[:-1])) < 0.02
    windows = found[: n // 100 * 100].reshape(-1, 100).mean(axis=1)
    assert np.mean(windows**2) / (1 / 100) == pytest.approx(1, abs=0.12)


def test_the_eigenvalues_of_what_samples_leave(P):
    said("filters", "the eigenvalues of P are $1/(1 + s)$")
    information = np.linalg.inv(P)
    left = np.linalg.inv(np.eye(4) + information)
    s = np.linalg.eigvalsh(information)
    np.testing.assert_allclose(np.sort(np.linalg.eigvalsh(left)), np.sort(1 / (1 + s)), rtol=1e-12)
    names = ("a", "b", "c", "d")
    share = removed(names, np.eye(4), left).share
    np.testing.assert_allclose([share[name] for name in names], 1 - np.diag(left))
