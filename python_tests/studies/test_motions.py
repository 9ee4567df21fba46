"""The set MOTION: its rates turn by what its truth turns by, and it runs without a folder."""

import csv

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from command_line import answered
from hnav import earth
from hnav.rotations import quaternion_product
from studies.bench import motions
from studies.bench.contenders import Contender, Estimate, own_contender
from studies.bench.motions import KINDS, RATE_HZ, motion, sensor_of
from studies.bench.rows import run_trial
from studies.command import main_of

main = main_of("bench")


class WithoutErrors:
    """A grade of a sensor that has none."""

    gyro_noise_rad_per_sqrt_s = start_sigma_gyro_bias_rad_s = gyro_bias_walk_rad_s_per_sqrt_s = 0.0
    accel_noise_m_s_per_sqrt_s = start_sigma_accel_bias_m_s2 = accel_bias_walk_m_s2_per_sqrt_s = 0.0
    start_sigma_gyro_scale = start_sigma_gyro_misalignment_rad = 0.0


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
@pytest.mark.parametrize("kind", KINDS)
def test_the_simulated_rate_integrates_to_the_attitude(kind, seed, monkeypatch):
    monkeypatch.setattr(motions, "sensors_of", lambda grade: WithoutErrors())
    made = motion(kind, seed, "industrial")
    T = 1 / RATE_HZ
    # Of rates that are means over their intervals, with the coning of successive turns (two-sample algorithm), less the Earth's.
    angle = made.rate_b_rad_s[1:] * T
    turn = angle + np.vstack([np.zeros(3), np.cross(angle[:-1], angle[1:]) / 12])
    q = made.reference_q_nb[0]
    for step in Rotation.from_rotvec(turn).as_quat(scalar_first=True):
        q = quaternion_product(q, step)
    earth_turn = Rotation.from_rotvec(-np.array([0, np.cos(0.85), np.sin(0.85)]) * earth.RATE_RAD_S * made.t_s[-1])
    end = earth_turn * Rotation.from_quat(q, scalar_first=True)
    true = Rotation.from_quat(made.reference_q_nb[-1], scalar_first=True)
    assert np.degrees((end * true.inv()).magnitude()) < 0.01


def test_the_set_needs_no_folder_and_reports_readiness(monkeypatch, tmp_path):
    monkeypatch.delenv("BROAD_DIR", raising=False)
    done = answered(
        main, "--sets", "MOTION", "--seeds", "1-1", "--filters", "ahrs", "--peers", "none", "--csv", tmp_path / "motion.csv"
    )
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader((tmp_path / "motion.csv").open()))
    assert [row["set"] for row in rows] == [f"MOTION {kind}" for kind in KINDS]
    assert all(float(row["tilt_z2"]) > 0 and 0 <= float(row["tilt_wrong"]) <= float(row["tilt_ready"]) <= 1 for row in rows)
    assert "tilt ready" in done.stdout


@pytest.mark.parametrize("kind, seed, gain", [("car", 0, 0.9), ("aircraft", 2, 0.5), ("foot", 0, 0.6), ("ship", 0, 1.1)])
def test_the_word_for_its_body_makes_an_estimate_better_or_true(kind, seed, gain):
    """Errors that are no larger than stated, and never ready and wrong. As a hand a ship states sigmas that are too small, and the others are
    ready for less of the time: in a hand such a motion looks like a step of the gyro bias."""
    words = ("", ":body=own", ":body=hand")
    without, own, hand = run_trial(
        "MOTION", motion(kind, seed, "industrial"), RATE_HZ, [own_contender(f"ahrs:solver=closed_form{w}") for w in words]
    )
    assert own.total_deg < gain * without.total_deg
    assert own.tilt_z2 < hand.tilt_z2 or own.tilt_ready > hand.tilt_ready
    assert own.tilt_z2 < 1.5 and own.tilt_wrong < 0.01 and own.tilt_ready > 0.5


@pytest.mark.parametrize("kind", ["tumble", "quadrotor"])
def test_with_the_datasheet_of_its_sensors_the_stated_sigma_is_nearer_to_the_error(kind):
    own, sensor = run_trial(
        "MOTION",
        motion(kind, 0, "industrial"),
        RATE_HZ,
        [own_contender(f"ahrs:solver=closed_form:body=own{w}") for w in ("", ":sensor=own")],
    )
    assert 2 * own.tilt_z2 < sensor.tilt_z2 < 2


def test_the_datasheet_of_a_recording_that_is_not_simulated_is_not_known(broad_trial):
    assert not sensor_of(broad_trial) and sensor_of(motion("head", 0, "industrial"))["gyro_noise_rad_per_sqrt_s"] == 5e-5


@pytest.mark.parametrize("kind, seed", [("car", 21), ("boat", 1), ("arm", 1)])
def test_an_unknown_body_is_ready_no_sooner_than_a_hand_and_estimates_are_the_same(kind, seed):
    recording = motion(kind, seed, "industrial")
    unknown, hand = (own_contender(f"ahrs:solver=closed_form{w}").estimate(recording, RATE_HZ) for w in ("", ":body=hand"))
    np.testing.assert_array_equal(unknown.q_nb, hand.q_nb)
    started = np.isfinite(hand.sigma_rad[:, 0])
    more = (unknown.sigma_rad - hand.sigma_rad)[started]  # it may be a vehicle until it has turned faster
    assert more[0, 0] > 0 and (kind != "arm" or not more[-1].any())
    rows = len(more) if kind == "arm" else 20 * int(RATE_HZ)  # in a vehicle a hand suspects a step of its gyro bias later
    assert more[:rows].min() >= -1e-15
    from_unknown, from_hand = (np.where(e.ready.any(0), e.ready.argmax(0), len(e.ready)) for e in (unknown, hand))
    assert (from_unknown >= from_hand).all()
    later = (hand.ready & ~unknown.ready).any(axis=0)
    assert later.tolist() == [kind != "arm"] * 2  # an arm turns faster than vehicles do


@pytest.mark.parametrize("kind, seed", [("car", 29), ("aircraft", 2), ("aircraft", 18)])
def test_an_unknown_vehicle_is_not_ready_while_it_is_wrong(kind, seed):
    """A start in motion, after which the tilt is wrong for minutes, and a rest that is followed by a straight take-off."""
    (row,) = run_trial("MOTION", motion(kind, seed, "industrial"), RATE_HZ, [own_contender("ahrs:solver=closed_form")])
    assert row.inclination_deg > 1 and row.tilt_ready > 0 and row.tilt_wrong == row.heading_wrong == 0


@pytest.mark.parametrize("kind", ["ship", "aircraft"])
def test_the_stated_tilt_of_an_unknown_vehicle_is_right(kind):
    """As that of a hand it would be off by 3 and 11 times the stated square."""
    rows = [
        run_trial("MOTION", motion(kind, seed, "industrial"), RATE_HZ, [own_contender("ahrs:solver=closed_form")])[0]
        for seed in range(6)
    ]
    assert 0.3 < np.mean([row.tilt_z2 for row in rows]) < 2


@pytest.mark.parametrize("arguments, named", [
    (["--sets", "BROAD"], "BROAD_DIR"), (["--sets", "MOTION", "--seeds", "7-0"], "--seeds 7-0"),
])  # fmt: skip
def test_a_folder_or_seeds_that_are_missing_are_named(monkeypatch, arguments, named):
    monkeypatch.delenv("BROAD_DIR", raising=False)
    done = answered(main, *arguments, "--filters", "ahrs", "--peers", "none")
    assert done.returncode == 2 and named in done.stderr and len(done.stderr.strip().splitlines()) == 1


def test_shares_of_a_filter_that_is_wrong_half_of_the_time():
    made = motion("head", 0, "industrial")
    off = made.t_s > (made.t_s[-1] + motions.SCORED_S) / 2
    tilt = Rotation.from_rotvec(np.radians(np.outer(np.where(off, 4.0, 0.0), [1.0, 0, 0]))).as_quat(scalar_first=True)
    sigma, ready = np.full((len(off), 3), np.radians(2.0)), np.ones((len(off), 2), bool)
    estimate = Estimate(quaternion_product(tilt, made.reference_q_nb), sigma, None, ready)
    contender = Contender("half", False, False, lambda recording, rate_hz: estimate, lambda recording, rate_hz: 1.0)
    (row,) = run_trial("MOTION head", made, float(RATE_HZ), [contender])
    assert (row.tilt_ready, row.heading_ready, row.heading_wrong) == (1, 1, 0)
    np.testing.assert_allclose([row.tilt_wrong, row.tilt_z2], [0.5, 1.0], atol=1e-3)
