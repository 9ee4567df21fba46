"""Calibration of accelerometer and gyroscope by rests and turns: found values, stated sigmas, refusals, files, and the AHRS with the result."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

import recorded
from command_line import hnav
from hnav.errors import HnavError
from hnav.filters.sensor_calibration import calibrate_sensors, largest_gap, rests_of
from hnav.io.recordings import Recording
from hnav.io.sensors import read_grade
from studies.sensor_calibration import REST_S, RESTS, TURN_S, Sensor, drive, gain, nees, rests_and_turns, sensor_of


def cut(r: Recording, begin_s: float, end_s: float) -> Recording:
    keep = (r.t_s >= begin_s) & (r.t_s < end_s)
    return Recording(r.name, r.t_s[keep], r.rate_b_rad_s[keep], r.force_b_m_s2[keep], r.field_b_tesla[keep])


@pytest.fixture(scope="module")
def sensor() -> Sensor:
    return sensor_of(np.random.default_rng(5))


@pytest.fixture(scope="module")
def rests(sensor) -> Recording:
    return sensor.record(*rests_and_turns(np.random.default_rng(6)), np.random.default_rng(7))


@pytest.fixture(scope="module")
def file(rests, tmp_path_factory):
    return recorded.house(tmp_path_factory.mktemp("rests"), rests)


def test_the_rests_are_found(rests):
    found = rests_of(rests)
    begins = np.arange(RESTS) * (REST_S + TURN_S)
    assert len(found.t_s) == RESTS and len(found.after) == RESTS - 1
    ends = [*(begins[:-1] + REST_S), rests.t_s[-1]]  # the last turn is none
    # By whole windows of half a second; a turn begins so slowly that a part of it is still.
    assert (np.abs(found.t_s - np.stack([begins, ends], axis=1)) < 0.6).all()


def test_errors_are_those_of_the_sensor_within_their_sigmas(sensor, rests):
    found = calibrate_sensors(rests)
    assert nees(sensor, found) < 2 and 0.5 < found.chi2 < 1.6
    assert np.allclose(found.parameters, sensor.parameters, atol=2e-3)
    assert found.accel.sigma_offset.max() < 2e-3 and found.gyro.sigma_matrix.max() < 5e-4
    assert np.allclose(np.linalg.norm(found.accel.apply(rests_of(rests).force), axis=1), 9.80665, atol=2e-3)


def test_stated_covariance_over_sensors():
    found = []
    for seed in range(6):
        rng = np.random.default_rng(100 + seed)
        one = sensor_of(rng)
        found.append(nees(one, calibrate_sensors(one.record(*rests_and_turns(rng), rng))))
    assert 0.6 < np.mean(found) < 1.5  # 126 parameters: 0.74 to 1.27 in 95 % of such means


def test_another_gravity_is_another_scale(rests):
    one, other = calibrate_sensors(rests), calibrate_sensors(rests, 9.78)
    assert np.allclose(other.accel.matrix * 9.80665, one.accel.matrix * 9.78, rtol=1e-4, atol=1e-4)
    assert np.allclose(other.gyro.matrix, one.gyro.matrix, atol=1e-4)


def test_the_ahrs_errs_less_than_half_as_much(sensor, rests):
    as_read, corrected = gain(sensor, rests, calibrate_sensors(rests), np.random.default_rng(8))
    assert corrected < 0.5 * as_read


def test_too_few_attitudes_are_refused_with_what_is_missing(rests):
    with pytest.raises(HnavError, match=r"\d attitudes at rest, 9 are needed: lay it with .* up") as refused:
        calibrate_sensors(cut(rests, 0, 45))
    assert refused.value.status == "ill-conditioned"
    t_s, attitude = drive(np.random.default_rng(1))
    with pytest.raises(HnavError, match="0 rests of 1 s were found"):
        calibrate_sensors(sensor_of(np.random.default_rng(1)).record(t_s, attitude, np.random.default_rng(2)))


@pytest.mark.parametrize(
    ("kept", "text"),
    [(0, "no turn between two rests is shorter than 30 s"), (1, "do not determine the gyroscope: turn it about")],
)
def test_turns_with_gaps_leave_the_gyroscope_open(rests, kept, text):
    """Attitudes all over the sphere, and gaps in all turns but so many."""
    number, within = np.divmod(rests.t_s, REST_S + TURN_S)
    gap = (number >= kept) & (within > REST_S + 1.5) & (within < REST_S + 2)
    with pytest.raises(HnavError, match=text):
        calibrate_sensors(replace(rests, rate_b_rad_s=np.where(gap[:, None], np.nan, rests.rate_b_rad_s)))


def test_the_direction_without_a_rest():
    axes = np.concatenate([np.eye(3), -np.eye(3)[:2]])
    missing, gap = largest_gap(axes)
    assert missing[2] < -0.99 and gap == pytest.approx(np.pi / 2, abs=0.1)


def test_the_command_writes_a_file_that_corrects_recordings(sensor, file, tmp_path):
    out, page = tmp_path / "sensor.json", tmp_path / "page.html"
    out.write_text(json.dumps({"version": 1, "name": "mine", "gyro": {"noise": {"value": 7, "unit": "mdeg/s/sqrt(Hz)"}}}))
    done = hnav("calibrate", file, "--sensor", out, "--report", page)
    assert done.returncode == 0 and "axes yx, zx, zy" in done.stdout, done.stderr
    assert "Attitudes at rest" in page.read_text()
    grade = read_grade(out)
    assert (
        grade.name == "mine"
        and "gyro.noise_deg_per_sqrt_h" in grade.values
        and set(grade.corrections) == {"gyro", "accel", "mag"}
    )
    assert np.allclose(grade.corrections["accel"].offset, sensor.accel[1], atol=5e-3)
    moved = recorded.house(tmp_path, sensor.record(*drive(np.random.default_rng(3)), np.random.default_rng(4)))
    tables = []
    for name, options in (("with", ["--sensor", out]), ("without", [])):
        assert hnav("filter", moved, "--out", tmp_path / f"{name}.csv", *options).returncode == 0
        tables.append(pd.read_csv(tmp_path / f"{name}.csv", comment="#"))
    true = drive(np.random.default_rng(3))[1]
    errors = [
        np.degrees((Rotation.from_quat(t[["q1", "q2", "q3", "q0"]].to_numpy()[3000:]) * true[3000:].inv()).magnitude()).mean()
        for t in tables
    ]
    assert errors[0] < 0.5 * errors[1]
    assert f"# sensors by {out}" in (tmp_path / "with.csv").read_text()


def test_the_command_shows_what_is_missing(rests, tmp_path):
    short = recorded.house(tmp_path, cut(rests, 0, 45))
    done = hnav("calibrate", short, "--sensor", tmp_path / "s.json", "--report", tmp_path / "page.html")
    assert done.returncode == 2 and "9 are needed" in done.stderr and not (tmp_path / "s.json").exists()
    assert "missing most" in (tmp_path / "page.html").read_text() and "9 are needed" in (tmp_path / "page.html").read_text()


@pytest.mark.parametrize(
    ("entry", "text"),
    [
        ({"unit": "deg/s"}, "must have matrix, offset"),
        (
            {"unit": "rad/s", "matrix": [[1]], "offset": [0, 0, 0], "sigma_matrix": [[0] * 3] * 3, "sigma_offset": [0] * 3},
            "3 x 3 finite",
        ),
        (
            {
                "unit": "rad/s",
                "matrix": [[0] * 3] * 3,
                "offset": [0, 0, "x"],
                "sigma_matrix": [[0] * 3] * 3,
                "sigma_offset": [0] * 3,
            },
            "3 finite",
        ),
    ],
)
def test_a_file_with_another_calibration_is_refused(entry, text, tmp_path):
    (tmp_path / "s.json").write_text(json.dumps({"name": "s", "gyro": {"calibration": entry}}))
    with pytest.raises(HnavError, match=text):
        read_grade(tmp_path / "s.json")


def test_options_that_do_not_go_together(file, tmp_path):
    for options, text in (
        (["--report", tmp_path / "x.html"], "--report"),
        (["--sensor", tmp_path / "s.json", "--out", tmp_path / "m.json"], "leave --out"),
    ):
        done = hnav("calibrate", file, *options)
        assert done.returncode == 2 and text in done.stderr and done.stderr.count("\n") == 1
