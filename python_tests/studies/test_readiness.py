"""Simulated starts: exact truth, the same whoever computes them, and figures that can be counted by hand."""

import csv

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from command_line import Answer, answered
from studies.command import main_of
from studies.readiness import starts as readiness
from studies.readiness.starts import DISTURBANCES, GROUPS, HIDDEN_GROUPS, MOTIONS, simulated_start
from studies.readiness.study import Start, experiment, figures, judge

main = main_of("readiness")


def run(*arguments: str) -> Answer:
    return answered(main, *arguments)


def attitude(recording) -> Rotation:
    return Rotation.from_quat(recording.reference_q_nb[:, [1, 2, 3, 0]])


def start(index=0, motion="rest", disturbance="none", field_true_s=0.0, ready_s=1.0, error=1.0, sigma=1.0) -> Start:
    return Start(index, motion, disturbance, field_true_s, ready_s, error, error, sigma)


# ------------------------------------------------------------------------------------------ the simulation


@pytest.mark.parametrize("index", range(len(GROUPS)))
def test_rates_turn_the_true_attitude_up_to_bias_and_noise(index):
    recording, _, _, _, sensors, _ = simulated_start(index, duration_s=20)
    truth = attitude(recording)
    turned = (truth[:-1].inv() * truth[1:]).as_rotvec() * readiness.RATE_HZ
    rest = recording.rate_b_rad_s[1:] - turned
    # Four standard errors of a mean, and of a standard deviation.
    np.testing.assert_allclose(rest.mean(axis=0), sensors.gyro_bias_rad_s, atol=4 * sensors.gyro_noise_rad_s / np.sqrt(len(rest)))
    np.testing.assert_allclose(rest.std(axis=0), sensors.gyro_noise_rad_s, rtol=4 / np.sqrt(2 * len(rest)))


@pytest.mark.parametrize("index", range(4))
def test_force_and_field_are_those_of_the_earth_in_the_mean(index):
    simulated = simulated_start(index)
    truth = attitude(simulated.recording)
    assert simulated.disturbance == "none" and simulated.field_true_s == 0
    up = truth.apply(simulated.recording.force_b_m_s2).mean(axis=0)
    np.testing.assert_allclose(up, [0, 0, readiness.GRAVITY_M_S2], atol=0.4)
    field = truth.apply(simulated.recording.field_b_tesla)
    assert abs(field[:, 0].mean()) < 0.03 * np.linalg.norm(field.mean(axis=0))
    assert field[:, 1].mean() > 0
    assert 24e-6 < np.linalg.norm(field, axis=1).mean() < 66e-6


def test_a_late_magnetometer_sees_the_attitude_of_before():
    recording, motion, _, _, sensors, _ = simulated_start(3)
    assert motion == "fast turning"
    earth = attitude(recording).apply(recording.field_b_tesla)
    mean = earth.mean(axis=0)
    # To first order a field that is late by d is measured turned by -d w: its distance from the mean along w x m gives d.
    turning = np.cross(mean, attitude(recording).apply(recording.rate_b_rad_s - sensors.gyro_bias_rad_s))
    latency_s = -np.sum(turning * (earth - mean)) / np.sum(turning**2)
    assert latency_s == pytest.approx(sensors.mag_latency_s, abs=0.0005)


def test_kinds_of_motion_differ_in_their_rates():
    rate = {
        name: np.percentile(np.linalg.norm(simulated_start(i).recording.rate_b_rad_s, axis=1), 90)
        for i, name in enumerate(MOTIONS)
    }
    assert rate["rest"] < np.radians(3)
    assert rate["rest"] < rate["hand-held"] < rate["fast turning"]
    assert rate["fast turning"] > 1.5


@pytest.mark.parametrize("disturbance", [name for name in DISTURBANCES if name != "none"])
def test_the_field_is_true_from_the_stated_time(disturbance):
    index = GROUPS.index(("rest", disturbance))
    simulated = simulated_start(index)
    field = attitude(simulated.recording).apply(simulated.recording.field_b_tesla)
    earth = field[-500:].mean(axis=0)
    distance = np.linalg.norm(field - earth, axis=1)
    noise = 5e-6
    assert (distance[simulated.recording.t_s > simulated.field_true_s] < noise).all()
    assert (distance[simulated.recording.t_s < simulated.field_true_s] > noise).any()


def test_a_start_depends_on_seed_and_index_alone():
    a, b, c = simulated_start(5, seed=3), simulated_start(5, seed=3), simulated_start(5, seed=4)
    np.testing.assert_array_equal(a.recording.rate_b_rad_s, b.recording.rate_b_rad_s)
    assert not np.array_equal(a.recording.rate_b_rad_s, c.recording.rate_b_rad_s)


def test_workers_do_not_change_a_figure():
    alone = list(experiment(6, "ahrs", {}, workers=1))
    assert repr(alone) == repr(list(experiment(6, "ahrs", {}, workers=2)))
    assert [s.index for s in alone] == list(range(6))


@pytest.mark.parametrize("filter", ["hrekf", "ahrs"])
def test_undisturbed_starts_become_ready_and_are_right(filter):
    for index in range(4):
        outcome = judge(index, filter, {})
        assert outcome.ready and not outcome.wrong, outcome


def test_every_error_adds_those_of_accelerometer_and_gyroscope_and_changes_nothing_else():
    plain, full = (simulated_start(3, duration_s=20, every_error=every) for every in (False, True))
    sensors = full.sensors
    assert 0.003 < np.linalg.norm(sensors.accel_bias_m_s2) < 0.2 and 1e-4 < np.abs(sensors.gyro_errors).max() < 0.01
    np.testing.assert_allclose(full.recording.force_b_m_s2 - plain.recording.force_b_m_s2,
                               np.tile(sensors.accel_bias_m_s2, (len(plain.recording.t_s), 1)), atol=1e-12)  # fmt: skip
    right = full.recording.rate_b_rad_s @ (np.eye(3) - sensors.gyro_errors).T
    np.testing.assert_allclose(right, plain.recording.rate_b_rad_s, atol=1e-12)
    np.testing.assert_array_equal(full.recording.field_b_tesla, plain.recording.field_b_tesla)


def test_hidden_fields_are_false_to_the_end():
    for index, (motion, disturbance) in enumerate(HIDDEN_GROUPS):
        if motion != "rest":
            continue
        simulated = simulated_start(index, duration_s=40, hidden=True)
        assert simulated.disturbance == disturbance and simulated.field_true_s == np.inf
        field = attitude(simulated.recording).apply(simulated.recording.field_b_tesla)[-100:].mean(axis=0)
        assert abs(field[0]) > 3e-7  # the earth's has no part to the east


def test_the_sigma_of_heading_is_judged_whether_the_filter_became_ready_or_not():
    outcome = judge(0, "ahrs", {})
    assert len(outcome.heading_z2) == 3 and np.isfinite(outcome.heading_z2).all()
    unready = judge(0, "ahrs", {"ready_undisturbed_s": "1e6"})
    assert not unready.ready and unready.heading_z2 == outcome.heading_z2
    assert figures([outcome, unready])["heading_z2"] == pytest.approx(outcome.heading_z2)


# ------------------------------------------------------------------------------------------ the figures


def test_wrong_is_beyond_three_sigma_and_five_degrees():
    assert not start(error=4.9, sigma=0.1).wrong
    assert start(error=5.1, sigma=0.1).wrong
    assert not start(error=8.0, sigma=3.0).wrong
    assert start(error=9.1, sigma=3.0).wrong
    never = start(ready_s=np.nan, error=np.nan, sigma=np.nan)
    assert not never.ready and not never.wrong


def test_wrong_before_the_field_is_true_is_counted_apart():
    assert not start(error=50, field_true_s=5, ready_s=4).wrong_in_true_field
    assert start(error=50, field_true_s=5, ready_s=6).wrong_in_true_field
    assert not start(error=1, field_true_s=5, ready_s=6).wrong_in_true_field


def test_shares_and_times_of_a_group_are_counted():
    group = [start(ready_s=s, error=e) for s, e in ((1, 1), (2, 2), (3, 60), (np.nan, np.nan))]
    found = figures(group)
    assert (found["starts"], found["wrong_share"], found["never_share"]) == (4, 0.25, 0.25)
    assert (found["median_s"], found["median_error_deg"]) == (2, 2)
    assert found["late_s"] == pytest.approx(2.9)
    assert found["wrong_low"] < 0.25 < found["wrong_high"]


def test_a_group_that_is_never_ready_has_no_times():
    found = figures([start(ready_s=np.nan, error=np.nan)])
    assert found["never_share"] == 1 and np.isnan(found["median_s"])


# ------------------------------------------------------------------------------------------ the command


def test_the_command_prints_groups_and_writes_a_row_for_each_start(tmp_path):
    out = tmp_path / "starts.csv"
    done = run("--starts", "12", "--workers", "1", "--csv", str(out))
    assert done.returncode == 0, done.stderr
    for word in (*MOTIONS, *DISTURBANCES):
        assert word in done.stdout
    rows = list(csv.DictReader(out.open()))
    assert [int(row["index"]) for row in rows] == list(range(12))
    assert {row["wrong"] for row in rows} <= {"0", "1"}


@pytest.mark.parametrize("arguments, named", [
    (["--filter", "magic"], "magic"),
    (["--starts", "0"], "--starts"),
    (["--workers", "0"], "--workers"),
    (["--seed", "-1"], "--seed"),
    (["--starts", "1", "--set", "no_such=1"], "no_such"),
    (["--starts", "1", "--set", "gamma"], "NAME=VALUE"),
    (["--starts", "1", "--workers", "1", "--csv", "/nonexistent/starts.csv"], "/nonexistent/starts.csv"),
])  # fmt: skip
def test_what_cannot_be_done_is_one_line_and_exit_code_2(arguments, named):
    done = run(*arguments)
    assert done.returncode == 2
    assert named in done.stderr and len(done.stderr.strip().splitlines()) == 1, done.stderr
