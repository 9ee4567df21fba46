"""Convergence and the filters of the literature: errors from a start within the assumed covariance, and from one outside it."""

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from command_line import answered
from studies import gamma
from studies.command import main_of
from studies.convergence import (
    AT_REST,
    ERRORS_DEG,
    FILTERS,
    at_rest,
    cell,
    converge,
    draw,
    settles,
    times_table,
)
from studies.peers import PEERS, Assumed, cross, turned
from studies.robust import DIRECTION_NOISE, FIELD_N, GYRO_NOISE, WALK, Scenario, errors_of, simulate

main = main_of("convergence")

T = 0.02


def errors_deg(name, start_rad, seeds=4, outliers=0.0):
    """Of the peer's attitude over 10 s, seeds x n, when its start is off by this rotation vector."""
    runs = [simulate(Scenario(outliers=outliers), seed, 10.0, 1 / T) for seed in range(seeds)]
    starts = [Rotation.from_rotvec(start_rad) * run.attitude[0] for run in runs]
    return errors_of(PEERS[name], runs, starts, Assumed(GYRO_NOISE, WALK, DIRECTION_NOISE, FIELD_N / 5e-5, 0.05, 0.5, 0.02))


def test_a_turn_is_the_exponential_of_its_cross_product():
    v = np.array([[1e-4, -2e-4, 3e-4]])
    np.testing.assert_allclose(turned(v)[0], np.eye(3) + cross(v)[0], atol=1e-7)


@pytest.mark.parametrize("name", PEERS)
def test_every_peer_finds_the_attitude_from_the_given_start(name):
    error = errors_deg(name, [0.02, -0.02, 0.4])
    assert error[:, 0].min() > 20
    assert np.sqrt(np.mean(error[:, 250:] ** 2)) < 0.6


def test_the_two_extended_filters_are_one_where_errors_are_small():
    """They differ in coordinates only."""
    body, navigation = (errors_deg(name, [0.01, 0.0, 0.02]) for name in ("multiplicative EKF", "invariant EKF"))
    difference, size = (np.sqrt(np.mean(e[:, 250:] ** 2)) for e in (body - navigation, body))
    assert difference < 0.05 * size


def test_the_invariant_filter_is_faster_from_a_large_error():
    body, navigation = (errors_deg(name, [0.0, 0.0, 2.3]) for name in ("multiplicative EKF", "invariant EKF"))
    assert np.median([settles(e) for e in navigation]) < 0.7 * np.median([settles(e) for e in body])


def test_weights_help_against_outliers():
    plain, huber = (errors_deg(name, [0.0, 0.0, 0.1], outliers=0.05) for name in ("multiplicative EKF", "Huber KF"))
    assert np.sqrt(np.mean(huber[:, 250:] ** 2)) < 0.5 * np.sqrt(np.mean(plain[:, 250:] ** 2))


def test_converged_is_a_second_below_the_limit():
    error = np.r_[np.full(100, 5.0), np.full(20, 1.0), np.full(10, 4.0), np.full(60, 1.0)]
    assert settles(error) == pytest.approx(130 * T)
    assert settles(np.full(100, 4.0)) == np.inf and settles(np.full(100, np.nan)) == np.inf


def test_the_times_become_a_table_and_a_picture():
    found = {(name, 5.0, 5.0): converge((name, 5.0, 5.0), 2) for name in FILTERS}
    assert {name for (name, _, _), seconds in found.items() if np.isfinite(seconds).all()} >= set(PEERS) | {"HEKF"}
    assert len(draw(found).axes) == 3
    with pytest.raises(KeyError):
        times_table(found, {"HEKF": ("HEKF", 30.0)}, "")


def test_the_rate_of_the_earth_corrects_a_heading_at_rest():
    """Half a degree per minute across the heading: slow, and to far less than the limit."""
    error = at_rest(1, 90.0, 100.0)
    assert error[0] == pytest.approx(90, abs=3) and 20 < settles(error, 10.0) < 120 and error[-600:].max() < 1
    found = {(AT_REST, e, 5.0): np.array([1.0, np.inf]) for e in ERRORS_DEG}
    assert times_table(found, {"": (AT_REST, 5.0)}, "").row_count == 1 and cell(found[AT_REST, 5.0, 5.0]) == "-, -, 50 %"


@pytest.mark.slow
def test_gamma_is_shown_between_the_filter_without_it_and_one_that_follows_noise():
    found = pd.DataFrame([gamma.measured(case, 2) for case in (("off", 0.0), ("relative", 1.5), ("relative", 20.0))])
    assert found.rmse_deg.is_monotonic_increasing and found.sigma_deg.is_monotonic_increasing
    assert found.seconds[1] < found.seconds[0] < found.seconds[2]
    robust = found[1:]
    assert (
        (robust.attenuation > 0).all()
        and (robust.attenuation <= robust.worst).all()
        and (robust.worst < robust.gamma_squared).all()
    )
    assert np.isinf(found.gamma_squared[0])
    assert len(gamma.draw(pd.concat([found, robust.assign(mode="kl")])).axes) == 3


def test_a_wrong_count_is_one_line():
    done = answered(main, "--seeds", "1")
    assert done.returncode == 2 and done.stderr.count("\n") == 1
