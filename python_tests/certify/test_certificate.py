"""The certificate: known rates are found, wrong gains are refused, bounds hold on the exact equations."""

import json
from dataclasses import replace

import h5py
import numpy as np
import pytest
from scipy.linalg import expm

from command_line import hnav
from hnav import Options
from hnav.certify.boundary_starts import boundary, difference_of_measurements, flow, random_directions
from hnav.certify.certificate import (
    certify,
    free_rates,
    largest,
    largest_below,
    largest_from,
    printed_theorem,
    spectral_radii,
)
from hnav.certify.gain_record import Correction, GainRecord, WatchedReference, body_axes, body_maps, held_turns, record_gains
from hnav.certify.results_folder import filter_of_run, read_results
from hnav.certify.run import Thinning, attenuation_of, certify_run
from hnav.certify.sampled_data import SampledDataInequality, flow_matrix, multipliers_hold, return_to_sphere, with_signs
from hnav.certify.semidefinite import BASIS, CorrectionBlocks, DenseBlocks, smallest
from hnav.certify.windows import MOST_PLACES, windows_of
from hnav.errors import HnavError
from hnav.filters.attitude import Filter
from hnav.io.recordings import RecordingError
from hnav.rotations import quaternion_exp, quaternion_product
from hnav.systems.turntable_recording import DIP_RAD, INTERVAL_S, Turntable
from twins.hrekf import ReferenceFilter


@pytest.fixture(scope="module")
def turntable():
    return Turntable().run(2.0, seed=5)


@pytest.fixture(scope="module")
def record(turntable) -> GainRecord:
    return record_gains(
        turntable.recording, Options("hrekf", "paper", **turntable.settings, solver="closed_form", gamma_mode="off")
    )


@pytest.mark.parametrize("rate_rad_s", [0.0, 1e-7, 0.02, 3.0, 40.0])
def test_held_turns_equal_matrix_exponentials(rate_rad_s):
    u, T = rate_rad_s * np.array([0.6, -0.48, 0.64]), 0.5
    generator = np.zeros((6, 6))
    generator[:3, :3] = np.cross(np.eye(3), u)
    generator[:3, 3:] = np.eye(3)
    both = expm(generator * T)
    turn, path = held_turns(u[None], T)
    np.testing.assert_allclose(turn[0], both[:3, :3], atol=1e-13)
    np.testing.assert_allclose(path[0], both[:3, 3:], atol=1e-13)


@pytest.mark.parametrize("turn_rad", [0.001, 1.0, 20.0])
def test_noise_of_an_interval_equals_van_loans_integral(turn_rad):
    T, Q_b = 0.2, np.array([[3, 1, 0], [1, 2, -1], [0, -1, 4]]) * 1e-3
    watched = WatchedReference(Options("hrekf", "paper", solver="closed_form"))
    watched.rate, watched.b, watched.Q_b = turn_rad / T * np.array([0.36, 0.48, -0.8]), np.zeros(3), Q_b
    watched.q = q = np.array([0.8, 0.36, -0.48, 0.0])
    watched.flow(T)

    generator, noise = np.zeros((7, 7)), np.zeros((7, 7))
    generator[1:4, 1:4] = np.cross(np.eye(3), -watched.rate)
    generator[1:4, 4:] = -0.5 * np.eye(3)
    noise[:4, :4] = watched.options.quaternion_noise_per_sqrt_s**2 * np.eye(4)
    noise[1:4, 1:4] += 0.25 * watched.options.gyro_noise_rad_per_sqrt_s**2 * np.eye(3)
    noise[4:, 4:] = Q_b
    V = expm(np.block([[-generator, noise], [np.zeros((7, 7)), generator.T]]) * T)
    Phi, after = V[7:, 7:].T, body_axes(watched.q)
    np.testing.assert_allclose(body_maps(watched.rate, np.array([T]))[0], Phi, atol=1e-13)
    np.testing.assert_allclose(watched.Phi, after @ Phi @ body_axes(q).T, atol=1e-13)
    np.testing.assert_allclose(watched.Q, after @ Phi @ V[:7, 7:] @ after.T, atol=1e-12 * np.abs(watched.Q).max())


def invariant_record(rate_1_s: float, interval_s: float = 0.01, count: int = 4) -> GainRecord:
    """A body at rest whose every correction shrinks attitude and bias error by e^{-rate T}, a linear law with that decay."""
    shrink = 1 - np.exp(-rate_1_s * interval_s)
    H = np.zeros((6, 7))
    H[:, 1:] = np.eye(6)
    c = Correction(
        t_s=0, interval_s=interval_s, Phi=np.eye(7), H=H, K=shrink * H.T, R=1e-6 * np.eye(6), Q=1e-8 * np.eye(7), P=np.eye(7),
        turn=np.eye(7), norm=1.0, nu=np.zeros(6), q_minus=np.array([1.0, 0, 0, 0]), q=np.array([1.0, 0, 0, 0]), b=np.zeros(3),
        gamma=np.inf, turns=((np.zeros(3), interval_s),),
    )  # fmt: skip
    return GainRecord("invariant", [replace(c, t_s=k * interval_s) for k in range(count)], 0.0)


def without_field(record: GainRecord, missing) -> GainRecord:
    """The record whose corrections k have no field where missing(k)."""

    def blind(c: Correction) -> Correction:
        H, K = c.H.copy(), c.K.copy()
        H[3:], K[:, 3:] = 0, 0
        return replace(c, H=H, K=K)

    corrections = [blind(c) if missing(k) else c for k, c in enumerate(record.corrections)]
    return GainRecord(record.name, corrections, record.largest_difference)


# --------------------------------------------------------------------------------------------- the record


def test_the_record_is_of_the_run_of_the_library(record):
    assert len(record.corrections) == 200
    assert record.largest_difference < 1e-11


def test_a_run_that_the_reference_cannot_follow_is_refused_with_the_difference(turntable):
    with pytest.raises(HnavError, match="differ by .*closed_form"):
        record_gains(turntable.recording, Options("hrekf", "paper", **turntable.settings, solver="euler", euler_step_s=0.01))


def without_rows(recording, rows):
    kept = np.delete(np.arange(len(recording.t_s)), rows)
    names = ("t_s", "rate_b_rad_s", "force_b_m_s2", "field_b_tesla")
    return replace(recording, **{name: getattr(recording, name)[kept] for name in names})


@pytest.mark.parametrize("gyro_hold", ["forward", "backward"])
@pytest.mark.parametrize("lost", ["one", "two", "five", "thirty-five", "a third"])
def test_lost_rows_are_part_of_the_record(turntable, lost, gyro_hold):
    rows = {"one": [60], "two": [60, 61], "five": range(60, 65), "thirty-five": range(60, 95)}.get(lost)
    rows = list(rows) if rows else np.flatnonzero(np.random.default_rng(1).random(200) < 0.3)
    options = Options("hrekf", "paper", **turntable.settings, solver="closed_form", gamma_mode="off", gyro_hold=gyro_hold)
    found = record_gains(without_rows(turntable.recording, rows), options)
    assert found.largest_difference < 1e-11 and not found.restarts


def test_a_gap_widens_the_covariance_as_noise_of_its_interval(turntable):
    options = Options("hrekf", "paper", **turntable.settings, solver="closed_form", gamma_mode="off")
    whole, lossy = (record_gains(r, options) for r in (turntable.recording, without_rows(turntable.recording, range(60, 95))))
    longest = max(lossy.corrections, key=lambda c: c.interval_s)
    assert longest.interval_s == pytest.approx(0.36)
    usual = np.trace(whole.corrections[50].Q[1:4, 1:4]) * longest.interval_s / 0.01
    assert np.trace(longest.Q[1:4, 1:4]) > 1.1 * usual


def test_a_run_that_restarted_is_certified_in_parts(turntable):
    """After more than a second without samples no error is carried on."""
    experiment = Turntable().run(4.0, seed=5)
    options = Options("hrekf", "paper", **experiment.settings, solver="closed_form", gamma_mode="off")
    found = record_gains(without_rows(experiment.recording, range(150, 270)), options)
    assert found.restarts == (pytest.approx(2.7),)
    with pytest.raises(HnavError, match="at 2.7 s the filter found its attitude again .* certify the parts"):
        certify(found)
    assert not found.from_time(2.8).restarts


def test_a_gap_that_spoils_a_certificate_is_named_with_its_remedy(turntable):
    options = Options("hrekf", "paper", **turntable.settings, solver="closed_form", gamma_mode="off")
    lossy = record_gains(without_rows(turntable.recording, range(60, 150)), options)
    found = certify(replace(lossy, corrections=lossy.corrections[40:80]), starts=0)
    assert not found.certified
    assert "the interval of 0.91 s before 1.5 s is 91 times the usual one: certify the parts before and after it" in found.reason


def test_the_first_row_far_ahead_is_left_out_as_by_the_filter():
    """A single stamp more than ten limits ahead may be wrong; the next one agrees with it."""
    experiment = Turntable().run(15.0, seed=5)
    options = Options("hrekf", "paper", **experiment.settings, solver="closed_form", gamma_mode="off")
    found = record_gains(without_rows(experiment.recording, range(150, 1200)), options)
    assert found.restarts == (pytest.approx(12.01),) and found.largest_difference < 1e-11
    assert all(abs(c.t_s - 12.0) > 1e-9 for c in found.corrections)


def test_jitter_of_the_stamps_is_part_of_the_record(turntable):
    data = turntable.recording
    t_s = data.t_s + 0.004 * np.random.default_rng(2).random(len(data.t_s))
    options = Options("hrekf", "paper", **turntable.settings, solver="closed_form", gamma_mode="off")
    assert record_gains(replace(data, t_s=t_s), options).largest_difference < 1e-11


def test_the_closed_form_of_the_flow_is_the_integrated_one(turntable, record):
    options = Options("hrekf", **turntable.settings, gamma_mode="kl", gyro_noise_rad_per_sqrt_s=0.01)
    data, reference = turntable.recording.cropped(0.2), ReferenceFilter(options)
    reference.q, reference.P, reference.rate = np.array([0.5, 0.5, -0.5, 0.5]), 0.01 * np.eye(7), data.rate_b_rad_s[0] + 2
    watched = WatchedReference(options)
    watched.q, watched.P, watched.rate = reference.q, reference.P, reference.rate
    reference.flow(0.3)
    watched.flow(0.3)
    np.testing.assert_allclose(watched.q, reference.q, atol=1e-12)
    np.testing.assert_allclose(watched.P, reference.P, atol=1e-12)


def test_the_flow_in_navigation_axes_is_one_exponential(record):
    for c in record.corrections[::20]:
        np.testing.assert_allclose(expm(flow_matrix(c.turns[-1][0]) * c.interval_s), c.Phi[1:, 1:], atol=1e-14)


def test_the_filters_own_covariance_contracts_at_every_correction(record):
    rates = free_rates(record)
    assert len(rates) == len(record.corrections) - 1
    assert (rates > 0).all() and (np.exp(-rates * INTERVAL_S) < 1).all()


def rates_in_c(turntable, options: Options) -> list[tuple[int, float]]:
    """(corrections, decay rate) after every sample."""
    in_c, data, seen = Filter(options), turntable.recording, []
    for t_s, rate, force, field in zip(data.t_s.tolist(), data.rate_b_rad_s, data.force_b_m_s2, data.field_b_tesla):
        in_c.push_gyro(t_s, rate)
        in_c.push_accel(t_s, force)
        in_c.push_mag(t_s, field)
        in_c.advance(t_s)
        status = in_c.diagnostics()
        seen.append((status.corrections, status.decay_rate_1_s))
    return seen


@pytest.mark.parametrize("settings", [
    {"gamma_mode": "off"}, {"gamma_mode": "relative", "gamma_relative_rate_1_s": 1.0}, {"gamma_mode": "off", "quaternion_noise_per_sqrt_s": 0.0},
])  # fmt: skip
def test_the_rate_in_c_is_that_of_the_record(turntable, settings):
    options = Options("hrekf", "paper", **turntable.settings | settings, solver="closed_form")
    found = dict(rates_in_c(turntable, options))
    assert found[0] == 0
    expected = free_rates(record_gains(turntable.recording, options))
    np.testing.assert_allclose([found[k] for k in range(2, len(expected) + 2)], expected, atol=1e-9)


def test_the_rates_in_c_are_positive_and_errors_fall_at_least_so_fast(turntable, record):
    found = dict(rates_in_c(turntable, Options("hrekf", "paper", **turntable.settings, solver="closed_form", gamma_mode="off")))
    errors = np.linalg.cholesky(record.corrections[0].P[1:, 1:])  # columns on the unit ball of P^-1, and what becomes of them
    allowed = 1.0
    for k, c in enumerate(record.corrections[1:], 2):
        assert found[k] > 0
        errors = c.M[1:, 1:] @ errors
        allowed *= np.exp(-found[k] * c.interval_s)
        assert np.linalg.norm(np.linalg.solve(np.linalg.cholesky(c.P[1:, 1:]), errors), 2) <= allowed * (1 + 1e-9)


# --------------------------------------------------------------------------------------------- the bounds


def test_the_remainders_of_the_nonlinear_equations_stay_below_their_bounds(record):
    rng = np.random.default_rng(0)
    n, rho = 500, 0.4
    alpha, beta = return_to_sphere(record, rho)
    for i, c in list(enumerate(record.corrections))[1::40]:
        axis = rng.normal(size=(n, 3))
        chord = rho * rng.uniform(size=n)
        q = quaternion_exp(2 * np.arcsin(chord / 2)[:, None] * axis / np.linalg.norm(axis, axis=1, keepdims=True))
        d = -q[:, 1:]
        seen = difference_of_measurements(c, q)
        r = np.linalg.norm(seen - d @ c.H[:, 1:4].T, axis=1)
        np.testing.assert_allclose(r, chord * np.linalg.norm(d @ c.H[:, 1:4].T, axis=1), atol=1e-13)
        y = d @ c.H[:, 1:4].T
        for first, second in ((slice(0, 3), slice(0, 3)), (slice(3, 6), slice(3, 6)), (slice(0, 3), slice(3, 6))):
            lengths = np.sum(y[:, first] * y[:, second], axis=1)
            np.testing.assert_allclose(np.sum(seen[:, first] * seen[:, second], axis=1), lengths, atol=1e-13)
            across = np.sum(y[:, first] * seen[:, second] + seen[:, first] * y[:, second], axis=1)
            np.testing.assert_allclose(across, (2 - chord**2) * lengths, atol=1e-13)

        e = np.hstack([1 - q[:, :1], d]) @ c.turn[:4, :4].T - seen @ c.K[:4].T
        after = np.array([c.norm, 0, 0, 0]) - e
        d_after = -after[:, 1:] / np.linalg.norm(after, axis=1, keepdims=True)
        u = seen @ c.K[1:4].T
        before = np.hstack([1 - q[:, :1], d]) @ c.turn[1:4, :4].T  # d' of return_to_sphere
        along = before * np.sum(before * u, axis=1, keepdims=True) / c.norm**2
        assert (np.sum(along**2, axis=1) <= alpha[i] * np.sum(along * u, axis=1) * (1 + 1e-12)).all()
        rest = c.norm * d_after - (d @ c.turn[1:4, 1:4].T - u + along)
        assert (np.linalg.norm(rest, axis=1) <= beta[i] * np.linalg.norm(d, axis=1)).all()

        e_b = rng.normal(size=(n, 3))
        flown, _ = flow(c, q, e_b)
        s = np.linalg.norm(-flown[:, 1:] - np.hstack([d, e_b]) @ c.Phi[1:4, 1:].T, axis=1)
        farthest = np.maximum(
            chord, 2 * np.sin(np.arccos(np.clip(flown[:, 0], -1, 1)) / 2)
        ) + 0.5 * c.interval_s * np.linalg.norm(e_b, axis=1)
        assert (s <= 0.5 * c.interval_s * farthest * np.linalg.norm(e_b, axis=1) + 1e-14).all()


def test_every_form_of_the_inequality_holds_on_the_nonlinear_equations(record):
    """z of exact errors: B z is the error after the correction, except for m, and each form has the sign that the S-procedure uses."""
    rng = np.random.default_rng(1)
    rho, scale, n = 0.4, 2.0, 200
    inequality = SampledDataInequality(record, scale)
    k = np.arange(1, len(record.corrections), 40)
    B, forms = inequality.terms(k, rho)
    alpha, beta = (bound[k] for bound in inequality.bounds(rho))
    for i, c in enumerate(record.corrections[j] for j in k):
        axis, e_b = rng.normal(size=(n, 3)), 0.3 * rng.normal(size=(n, 3))
        chord = 0.99 * rho * rng.uniform(size=n)
        q = quaternion_exp(2 * np.arcsin(chord / 2)[:, None] * axis / np.linalg.norm(axis, axis=1, keepdims=True))
        q_minus, b_minus = flow(c, q, e_b)
        d, d_minus = -q[:, 1:], -q_minus[:, 1:]
        s = d_minus - np.hstack([d, e_b]) @ c.Phi[1:4, 1:].T
        seen = difference_of_measurements(c, q_minus)
        r, u = seen - d_minus @ c.H[:, 1:4].T, seen @ c.K[1:4].T
        turned = np.hstack([1 - q_minus[:, :1], d_minus]) @ c.turn[1:4, :4].T
        along = turned * np.sum(turned * u, axis=1, keepdims=True) / c.norm**2
        most_u = np.linalg.norm(c.K[1:4]) * np.linalg.norm(c.H[:, 1:4])
        z = np.hstack([d, scale * e_b, r / rho, s / (0.5 * rho * c.interval_s), along / (alpha[i] * most_u)])

        value = [np.einsum("ni,ij,nj->n", z, F[i], z) for F in forms]
        shorter = np.stack([value[0], 0.5 * value[2], 0.5 * value[2], value[1]], axis=1).reshape(-1, 2, 2)
        assert np.linalg.eigvalsh(shorter).min() > -1e-13
        np.testing.assert_allclose(value[3:6], 0, atol=1e-12)
        assert value[6].min() > -1e-12 and value[7].min() > -1e-9 and value[8].min() >= 0

        e = np.hstack([1 - q_minus[:, :1], d_minus, b_minus]) @ c.turn.T - seen @ c.K.T
        after = np.array([c.norm, 0, 0, 0]) - e[:, :4]
        exact = np.hstack([-after[:, 1:] / np.linalg.norm(after, axis=1, keepdims=True), scale * e[:, 4:]])
        missing = exact - z @ B[i].T / np.sqrt(1 + beta[i])
        assert (np.linalg.norm(missing[:, :3], axis=1) <= beta[i] / c.norm * np.linalg.norm(d_minus, axis=1)).all()
        np.testing.assert_allclose(missing[:, 3:], 0, atol=1e-13)


def test_starts_lie_on_the_boundary():
    rng = np.random.default_rng(3)
    A = rng.normal(size=(6, 6))
    P = A @ A.T + 6 * np.eye(6)
    q, b = boundary(P, 0.3, random_directions(50, rng))
    e = np.hstack([-q[:, 1:], b])
    np.testing.assert_allclose(np.einsum("ki,ij,kj->k", e, P, e), 0.3, rtol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1, atol=1e-14)


def test_the_printed_theorem_needs_a_flow_that_contracts_and_has_none(record):
    printed = printed_theorem(record)
    gain = max(np.linalg.norm(c.K, 2) for c in record.corrections)
    assert printed.smallest_d == pytest.approx(np.log(1 + 2 * gain * np.sqrt(8)))
    assert printed.flow_rate_1_s == 0 and not printed.holds


# --------------------------------------------------------------------------------------------- the inequality


@pytest.mark.parametrize("rate", [0.5, 5.0])
def test_a_linear_law_is_certified_with_its_decay(rate):
    found = certify(invariant_record(rate), starts=0)
    assert found.rate_1_s == pytest.approx(rate, rel=0.01)
    assert found.rate_1_s <= rate * (1 + 1e-9)
    assert found.certified, found.reason


def test_simulated_starts_catch_a_record_that_is_not_of_the_filters_equations():
    """Its H has a column for the bias, as no sensor has: the inequality depends on it, the equations do not."""
    found = certify(invariant_record(0.5), starts=20)
    assert not found.certified
    assert "simulated start" in found.reason


def test_figures_scale_with_time():
    """Twice the decay at half the interval is the same law in other seconds."""
    slow, fast = certify(invariant_record(1.0, 0.02), starts=0), certify(invariant_record(2.0, 0.01), starts=0)
    assert fast.rate_1_s == pytest.approx(2 * slow.rate_1_s, rel=1e-3)
    assert fast.free_rate_1_s == pytest.approx(2 * slow.free_rate_1_s)


def test_gains_that_push_the_wrong_way_are_refused_with_the_correction_named(record):
    found = certify(record.with_gain(-1), starts=0)
    assert not found.certified
    assert "spectral radius" in found.reason and "error grows" in found.reason


def test_an_inequality_that_holds_holds_for_every_correction(record):
    steady = GainRecord(record.name, record.corrections[150:], record.largest_difference)
    inequality = SampledDataInequality(steady, 2.0)
    rate = -np.log(max(np.abs(np.linalg.eigvals(c.M[1:, 1:])).max() for c in steady.corrections)) / INTERVAL_S
    P, tau, smallest = inequality.solve(0.2 * rate, 0.0)
    assert smallest >= 0
    for k in range(len(steady.corrections)):
        assert np.linalg.eigvalsh(inequality.X(np.array([k]), P, tau, 0.2 * rate, 0.0)[0])[0] >= 0
    assert inequality.solve(1.1 * rate, 0.0) is None


def test_remainders_are_paid_for_by_decay(record):
    """With a smaller decay the same corrections hold a larger region; the answer is verified again from P and tau alone."""
    steady = GainRecord(record.name, record.corrections[150:], record.largest_difference)
    inequality = SampledDataInequality(steady, 2.0)
    rate = -np.log(max(np.abs(np.linalg.eigvals(c.M[1:, 1:])).max() for c in steady.corrections)) / INTERVAL_S
    P, tau, least = inequality.solve(0.1 * rate, 0.05)
    assert P.shape == (1, 6, 6) and multipliers_hold(tau[0]) and np.linalg.eigvalsh(P[0, :3, :3])[-1] <= tau[0, -1]
    again = SampledDataInequality(steady, 2.0).smallest_eigenvalues(P, tau, 0.1 * rate, 0.05)
    assert len(again) == 50 and again.min() == pytest.approx(least) and least >= 0
    assert inequality.solve(0.9 * rate, 0.05) is None


def test_the_progress_of_each_stage_grows_and_ends_full(record):
    reported: dict[str, list[tuple[int, int]]] = {}
    expected: list[float] = []
    found = certify(
        GainRecord(record.name, record.corrections[192:], 0.0),
        lambda what, done, of: reported.setdefault(what, []).append((done, of)),
        starts=2,
        announce=lambda seconds: expected.append(seconds if not reported else -1.0),
    )
    assert expected[0] > 0.05 and expected[0] < 5 * found.seconds < 25 * expected[0]
    assert found.processor_s > 0
    assert list(reported) == ["decay rate", "region", "longest interval", "starts"]
    for steps in reported.values():
        assert [done for done, _ in steps] == sorted(done for done, _ in steps)
        assert steps[-1][0] == steps[-1][1]


def test_intervals_nest(record):
    """Any order of intervals is more than one interval at a time, and no P helps where a single correction lets errors grow."""
    steady = GainRecord(record.name, record.corrections[150:], record.largest_difference)
    np.testing.assert_allclose(
        SampledDataInequality(steady, 2.0).with_interval(INTERVAL_S).M, SampledDataInequality(steady, 2.0).M, atol=1e-14
    )
    # The body turns back faster than the gains have learnt: an interval too long turns the bias error away from them.
    turned = [replace(c, turns=((np.array([0, 0, -0.3]), INTERVAL_S),)) for c in steady.corrections[::10]]
    found = certify(GainRecord("turned", turned, 0.0), starts=0)
    inequality = SampledDataInequality(GainRecord("turned", turned, 0.0), 2.0)
    assert INTERVAL_S < found.mixed_interval_s <= found.longest_interval_s
    assert INTERVAL_S < found.region_interval_s <= found.longest_interval_s
    grows = [
        np.abs(np.linalg.eigvals(inequality.with_interval(t).M)).max() >= 1
        for t in (found.interval_limit_s, 1.01 * found.interval_limit_s)
    ]
    assert found.longest_interval_s <= found.interval_limit_s and grows == [False, True]
    P, tau, _ = inequality.and_interval(found.mixed_interval_s).solve(0.0, 0.0)
    for t in (INTERVAL_S, found.mixed_interval_s):
        assert inequality.with_interval(t).smallest_eigenvalues(P, tau, 0.0, 0.0).min() >= 0


def test_the_solver_is_asked_what_is_meant():
    F = np.zeros((3, 3, 2))
    F[0, 0, 0] = F[1, 1, 1] = F[0, 2, 0] = F[2, 0, 0] = 1.0
    F[2, 2] = [0.0, 1.0]

    def blocks(F, unknowns, least):
        return DenseBlocks(F[None], np.array([unknowns]), least * np.eye(len(F))[None])

    # [[x1, 0, x1], [0, x2, 0], [x1, 0, x2]] >= 0.5 I needs (x1 - 0.5)(x2 - 0.5) >= x1^2.
    x = smallest(np.array([0.0, 1.0]), [blocks(F, [0, 1], 0.5)])
    assert np.linalg.eigvalsh(F @ x)[0] == pytest.approx(0.5, abs=1e-3)
    assert x[1] == pytest.approx(0.5 + min(v**2 / (v - 0.5) for v in np.linspace(0.6, 3, 2401)), rel=2e-3)
    one = np.ones((1, 1, 1))
    assert smallest(np.array([1.0]), [blocks(-one, [0], 1.0), blocks(one, [0], 0.0)]) is None
    # The same block of other unknowns, and of one unknown twice: x0 + x2 >= 3 and x0 + x0 >= 1.
    two = np.ones((1, 1, 2))
    x = smallest(np.array([2.0, 0.0, 1.0]), [blocks(two, [0, 2], 3.0), blocks(two, [0, 0], 1.0)])
    np.testing.assert_allclose(x[[0, 2]], [0.5, 2.5], atol=2e-3)


def test_blocks_of_corrections_are_those_of_their_matrices():
    """The structured products against F in full, for matrices that are not symmetric too."""
    rng = np.random.default_rng(3)
    m, z, count = 4, 9, 2
    share, B, forms = rng.random(m), rng.normal(size=(m, 6, z)), rng.normal(size=(m, count, z, z))
    forms = forms + np.swapaxes(forms, 2, 3)
    of_P = np.moveaxis(BASIS.reshape(6, 6, -1), -1, 0)
    before = np.zeros((m, len(of_P), z, z))
    before[:, :, :6, :6] = share[:, None, None, None] * of_P
    after = -np.swapaxes(B, 1, 2)[:, None] @ of_P @ B[:, None]
    F = np.moveaxis(np.concatenate([before, after, -forms], axis=1), 1, -1)
    unknowns, constant = rng.integers(0, 60, (m, F.shape[-1])), np.zeros((m, z, z))
    ours, full = CorrectionBlocks(share, B, forms, unknowns, constant), DenseBlocks(F, unknowns, constant)
    Y, Z = (w @ np.swapaxes(w, 1, 2) for w in rng.normal(size=(2, m, z, z)))
    x = rng.normal(size=60)
    np.testing.assert_allclose(ours.value(x), full.value(x), rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(ours.adjoint(Z), full.adjoint(Z), rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(ours.products(Y, Z), full.products(Y, Z), rtol=1e-10, atol=1e-9)


def test_multipliers_get_the_signs_that_they_missed_by_rounding():
    tau = np.array([1.0, 1e-9, -2e-8, -0.5, 0.0, 0.5, -1e-12, 0.1, 2.0])
    assert not multipliers_hold(tau)
    assert multipliers_hold(with_signs(tau))
    np.testing.assert_allclose(with_signs(tau), tau, atol=1e-7)


def test_bisection_finds_the_edge():
    assert largest_from(lambda x: x if x < 0.3 else None, 1e-3, 1.0, 2.0, 12) == pytest.approx(0.3, rel=1e-3)
    assert largest_from(lambda x: None, 1e-3, 1.0, 2.0, 5) == 1e-3
    assert largest_from(lambda x: x, 1e-3, 1.0, 2.0, 5) == 1.0
    assert largest(lambda x: x if x < 0.3 else None, 1e-3, 1.0, 20)[0] == pytest.approx(0.3, rel=1e-4)
    assert largest(lambda x: None, 1e-3, 1.0, 5) is None
    assert largest_below(lambda x: x if x < 0.03 else None, 1.0, 1e-4, 12)[0] == pytest.approx(0.03, rel=1e-3)
    assert largest_below(lambda x: None, 1.0, 1e-4, 5) is None


# --------------------------------------------------------------------------------------------- windows


def test_a_window_ends_when_every_sensor_was_seen():
    record = without_field(invariant_record(1.0, count=9), lambda k: k not in (2, 3, 7))
    windows = windows_of(record)
    np.testing.assert_array_equal(windows.before, [0, 1, 2, 0, 0, 1, 2, 3, 0])
    np.testing.assert_array_equal(windows.after, [1, 2, 0, 0, 1, 2, 3, 0, 1])
    assert windows.longest == 4 and windows.places == 4
    np.testing.assert_array_equal(windows.begins(), [0, 3, 4])
    np.testing.assert_array_equal(windows.ends(), [2, 3, 7])
    M = np.arange(9)[:, None, None] + 1.0 + np.zeros((9, 1, 1))
    np.testing.assert_allclose(windows.products(M).ravel(), [6, 4, 5 * 6 * 7 * 8])
    assert windows.unfinished == 1
    whole = windows_of(invariant_record(1.0))
    assert whole.longest == 1 and whole.places == 1


def test_a_sensor_that_is_gone_for_long_is_named():
    record = without_field(invariant_record(1.0, count=MOST_PLACES + 5), lambda k: k > 1)
    with pytest.raises(HnavError, match="the field is not seen in 151 corrections before 1.52 s"):
        windows_of(record)


def test_a_law_whose_field_comes_at_every_third_correction_decays_with_its_windows():
    """There the bias is seen once in three corrections, and falls by a third of the rate; no single P would allow any."""
    found = certify(without_field(invariant_record(1.0, count=6), lambda k: k % 3 != 2), starts=0)
    assert found.certified, found.reason
    assert found.longest_window == 3 and found.P.shape == (3, 6, 6)
    assert found.rate_1_s == pytest.approx(1 / 3, rel=0.01) and found.rate_1_s <= found.spectral_rate_1_s * (1 + 1e-9)


def test_what_holds_at_every_place_holds_for_the_product_over_every_window():
    thinned = without_field(invariant_record(5.0, count=26), lambda k: k % 4 != 3 or k == 15)
    inequality = SampledDataInequality(thinned, 2.0)
    windows = inequality.windows
    assert windows.longest == 8
    spans = np.diff(np.cumsum(inequality.T)[windows.ends()], prepend=0)
    rate = 0.1 * (-np.log(spectral_radii(inequality)) / spans).min()
    P, tau, least = inequality.solve(rate, 0.05)
    again = SampledDataInequality(thinned, 2.0).smallest_eigenvalues(P, tau, rate, 0.05)
    assert again.min() == pytest.approx(least) and least >= 0
    for M, T in zip(windows.products(inequality.M), spans):
        assert np.linalg.eigvalsh(np.exp(-2 * rate * T) * P[0] - M.T @ P[0] @ M)[0] >= 0
    assert np.abs(np.linalg.eigvals(inequality.M[0])).max() == pytest.approx(1)  # no single P falls at a correction by force


def test_gains_that_push_the_wrong_way_are_refused_with_their_window(record):
    found = certify(without_field(record, lambda k: k % 10 != 9).with_gain(-1), starts=0)
    assert not found.certified
    assert "over the 10 corrections from" in found.reason and "every sensor is seen" in found.reason


def test_thinning_keeps_every_nth_sample_and_loses_a_share(turntable):
    data = Thinning(field_every=10, lost=0.1).of(turntable.recording, seed=1)
    force, field = (np.isfinite(v).all(axis=1) for v in (data.force_b_m_s2, data.field_b_tesla))
    assert set(np.flatnonzero(field)) <= set(range(0, 201, 10)) and 14 <= field.sum() <= 20
    assert 0.8 < force.mean() < 0.97
    assert Thinning().of(turntable.recording, 1) is turntable.recording
    for name, value in (("force_every", 0), ("field_every", -1), ("lost", 1.0)):
        with pytest.raises(HnavError, match=f"{name} = "):
            Thinning(**{name: value})


# --------------------------------------------------------------------------------------------- experiment and command


def test_the_attenuation_of_the_robust_law_stays_below_gamma_squared(turntable):
    options = Options("hrekf", "paper", **turntable.settings, solver="closed_form", gamma_relative_rate_1_s=10.5)
    robust = record_gains(turntable.recording, options)
    ratio = attenuation_of(robust, turntable, options)
    assert 0 < ratio < max(c.gamma for c in robust.corrections) ** 2


def test_the_turntable_integrates_to_its_own_attitude():
    quiet = Turntable(gyro_noise_deg_s=0, gyro_bias_deg_s=0, gyro_scale=0, accel_noise=0, mag_noise=0).run(30, seed=1)
    q = quiet.q_nb[0]
    for rate in quiet.recording.rate_b_rad_s[:-1]:
        q = quaternion_product(q, quaternion_exp(0.5 * INTERVAL_S * rate[None])[0])
    np.testing.assert_allclose(q, quiet.q_nb[-1], atol=1e-12)
    assert np.degrees(np.abs(quiet.recording.rate_b_rad_s).max()) == pytest.approx(10, rel=1e-6)
    assert np.arctan2(quiet.recording.field_b_tesla[0, 2], np.linalg.norm(quiet.recording.field_b_tesla[0, :2])) == pytest.approx(
        DIP_RAD
    )


def test_a_seed_is_one_experiment():
    a, b, c = (Turntable().run(0.5, seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(a.recording.rate_b_rad_s, b.recording.rate_b_rad_s)
    assert not np.array_equal(a.recording.rate_b_rad_s, c.recording.rate_b_rad_s)


def test_results_of_a_simulation_are_read_by_the_names_of_their_signals(tmp_path):
    values = np.arange(12.0).reshape(4, 3)
    with h5py.File(tmp_path / "signals.h5", "w") as file:
        file["t_s"] = np.arange(4) * 0.01
        file["imu.gyro.rate"] = values
        file["imu.accel.force"] = values + 1
        for i in range(3):
            file[f"compass.mag.field[{i + 1}]"] = values[:, i] + 2
    data = read_results(tmp_path)
    np.testing.assert_array_equal(data.rate_b_rad_s, values)
    np.testing.assert_array_equal(data.field_b_tesla, values + 2)


def test_values_held_between_samples_are_no_samples(tmp_path):
    with h5py.File(tmp_path / "signals.h5", "w") as file:
        file["t_s"] = np.arange(4) * 0.01
        for end in ("gyro.rate", "accel.force", "mag.field"):
            for i in range(3):
                file[f"imu.{end}[{i + 1}]"] = np.array([0.0, 1.0, 1.0, 2.0])
        file["imu.mag.sample"] = np.array([0.0, 1.0, 1.0, 2.0])
    data = read_results(tmp_path)
    np.testing.assert_array_equal(np.isfinite(data.field_b_tesla).all(axis=1), [False, True, False, True])
    assert np.isfinite(data.rate_b_rad_s).all()


def write_run(folder, parameters: dict) -> None:
    (folder / "run.json").write_text(json.dumps({"parameters": parameters}))


def test_a_folder_names_the_filter_that_was_simulated(tmp_path):
    with pytest.raises(RecordingError, match="run.json: file not found: the simulation is not whole"):
        filter_of_run(tmp_path)
    write_run(tmp_path, {"sensor.seed": 1})
    assert filter_of_run(tmp_path) == ("default", {})
    start = {f"hrekf.start.start_q_nb[{i}]": v for i, v in enumerate((0.6, 0.0, 0.8, 0.0), start=1)}
    write_run(
        tmp_path,
        start
        | {
            "hrekf.preset": "paper",
            "hrekf.robust.gamma_mode": "kl",
            "hrekf.solver.solver": "erkstep",
            "hrekf.robust.gamma": 0.1,
            "hrekf.sampling_mode": "counter",
            "hekf.robust.gamma": 9,
        },
    )
    preset, settings = filter_of_run(tmp_path)
    options = Options("hrekf", preset, **settings)
    assert preset == "paper" and sorted(settings) == ["gamma", "gamma_mode", "start_q_nb"]
    assert (options.gamma_mode, options.gamma, list(options.start_q_nb)) == ("kl", 0.1, [0.6, 0.0, 0.8, 0.0])
    write_run(tmp_path, {"hrekf.preset": 1})
    with pytest.raises(RecordingError, match="run.json: no parameters"):
        filter_of_run(tmp_path)


def test_the_certificate_of_a_folder_is_of_the_simulated_filter(tmp_path, turntable):
    """The gains of the folder are those that its settings give, not those of the default preset."""
    data = turntable.recording
    with h5py.File(tmp_path / "signals.h5", "w") as file:
        file["t_s"] = data.t_s
        for end, values in (
            ("gyro.rate", data.rate_b_rad_s),
            ("accel.force", data.force_b_m_s2),
            ("mag.field", data.field_b_tesla),
        ):
            file[f"sensor.{end}"] = values
    write_run(tmp_path, {"hrekf.preset": "paper", "hrekf.robust.gamma_mode": "off"})

    def found(preset, settings):
        return certify_run(tmp_path, preset=preset, settings=settings, begin_s=0.5, seed=1, gain_factor=-1.0)

    assert found(None, {}).printed == found("paper", {"gamma_mode": "off"}).printed != found("default", {}).printed


def test_results_without_a_sensor_are_refused_by_its_name(tmp_path):
    with pytest.raises(RecordingError, match="no signals.h5"):
        read_results(tmp_path)
    with h5py.File(tmp_path / "signals.h5", "w") as file:
        file["t_s"] = np.arange(4) * 0.01
    with pytest.raises(RecordingError, match=r"ends in gyro\.rate"):
        read_results(tmp_path)


@pytest.mark.parametrize(
    "arguments, named",
    [
        ([], "--experiment turntable"),
        (["--experiment", "carousel"], "carousel"),
        (["--experiment", "turntable", "--filter", "ahrs"], "ahrs"),
        (["--experiment", "turntable", "--duration", "0.5"], "--from"),
        (["--experiment", "turntable", "--field-every", "0"], "field_every = 0: give 1 or more"),
    ],
)
def test_what_cannot_be_certified_is_said_in_one_line(arguments, named):
    done = hnav("certify", *arguments)
    assert done.returncode == 2
    assert named in done.stderr and len(done.stderr.strip().splitlines()) == 1


def test_the_command_refuses_wrong_gains_and_writes_why(tmp_path):
    out, picture = tmp_path / "c.json", tmp_path / "c.png"
    done = hnav("certify", "--experiment", "turntable", "--preset", "paper", "--duration", 1, "--from", 0.5, "--gain-factor", -1, "--out", out, "--picture", picture)  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "not certified" in done.stdout
    figures = json.loads(out.read_text())
    assert figures["certified"] is False and "spectral radius" in figures["reason"]
    assert figures["region_deg"] is None and figures["printed"]["holds"] is False
    assert picture.stat().st_size > 10_000
