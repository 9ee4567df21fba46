"""Recordings on the command line: options reach the reader, findings name options, and exit codes state the result."""

from dataclasses import replace

import numpy as np
import pytest

import recorded
from command_line import hnav
from motion import tilted_motion


@pytest.fixture(scope="module")
def motion():
    return tilted_motion(15).recording


@pytest.fixture
def in_g(tmp_path, motion):
    return recorded.house(tmp_path, replace(motion, force_b_m_s2=motion.force_b_m_s2 / recorded.G))


def test_filter_stops_with_the_cure_and_the_cure_cures(in_g, tmp_path):
    out = tmp_path / "out.csv"
    refused = hnav("filter", in_g, "--out", out)
    assert refused.returncode == 2 and not out.is_file()
    cure = "house.csv: accel: median |force| 1.0 m/s2: this looks like g; use --accel-unit g"
    assert f"{cure}; --force goes on" in refused.stderr.replace(" 1 m", " 1.0 m")
    warned = hnav("filter", in_g, "--force", "--out", out)
    assert warned.returncode == 0 and out.is_file()
    assert f"warning: {cure}\n" in warned.stderr.replace(" 1 m", " 1.0 m")
    assert not hnav("filter", in_g, "--accel-unit", "g", "--out", out).stderr


def test_all_that_stops_is_named_at_once_and_the_cures_together_cure(tmp_path, motion):
    wrong = replace(motion, rate_b_rad_s=np.degrees(motion.rate_b_rad_s), force_b_m_s2=motion.force_b_m_s2 / recorded.G)
    path, out = recorded.house(tmp_path, wrong), tmp_path / "out.csv"
    refused = hnav("filter", path, "--out", out)
    assert refused.returncode == 2 and refused.stderr.count("\n") == 1
    assert (
        "use --accel-unit g" in refused.stderr
        and "use --gyro-unit deg/s" in refused.stderr
        and "more" not in refused.stderr.split("gyro:")[0]
    )
    assert hnav("filter", path, "--accel-unit", "g", "--gyro-unit", "deg/s", "--out", out).returncode == 0


@pytest.mark.parametrize("said", [["--hemisphere", "south"], ["--place-and-date", "-33.9,151.2,10,2026.5"], ["--force"]])
def test_a_field_that_points_up_has_to_be_said_to_be_right(tmp_path, motion, said):
    upward = recorded.house(tmp_path, replace(motion, force_b_m_s2=-motion.force_b_m_s2))
    out = tmp_path / "out.csv"
    refused = hnav("filter", upward, "--out", out)
    assert refused.returncode == 2 and not out.is_file()
    assert "use --axes accel=-x,-y,-z; or say --hemisphere south" in refused.stderr
    assert hnav("filter", upward, *said, "--out", out).returncode == 0 and out.is_file()


def test_strict_refuses_before_anything_is_written(in_g, tmp_path):
    out = tmp_path / "out.csv"
    refused = hnav("filter", in_g, "--strict", "--out", out)
    assert refused.returncode == 2 and not out.exists()
    assert refused.stderr.count("\n") == 1 and "use --accel-unit g" in refused.stderr


def test_a_sensor_that_is_zero_is_an_error_and_not_rows_of_nan(tmp_path, motion):
    dead = recorded.house(tmp_path, replace(motion, force_b_m_s2=0 * motion.force_b_m_s2))
    refused = hnav("filter", dead, "--out", tmp_path / "out.csv")
    assert refused.returncode == 2 and "accel: all 1500 samples are zero" in refused.stderr


def test_check_says_what_was_read_and_found(in_g, tmp_path, motion):
    found = hnav("check", in_g)
    assert found.returncode == 1
    assert "accel 1500 at 100 Hz (m/s2 assumed)" in found.stdout and "use --accel-unit g" in found.stdout
    good = hnav("check", recorded.x_io(tmp_path, motion))
    assert good.returncode == 0 and good.stdout.endswith("plausible\n")


def test_columns_axes_and_rate_are_options(tmp_path, motion):
    plain = recorded.columns(motion, field=1)
    path = recorded.write_rows(tmp_path / "odd.csv", "p,q,r,ax,ay,az,my,mx,mz", [plain[i] for i in (0, 1, 2, 3, 4, 5, 6, 7, 8)])
    names = [f"--columns={role}={name}" for role, name in (("gx", "p"), ("gy", "q"), ("gz", "r"))]
    swapped = hnav("check", path, *names, "--rate", 100)
    assert swapped.returncode == 1 and "use --axes mag=y,x,z" in swapped.stdout
    assert hnav("check", path, *names, "--rate", 100, "--axes", "mag=y,x,z").returncode == 0
    assert hnav("check", path, *names, "--rate", 100, "--columns", "mx=my,my=mx").returncode == 0
    untimed = hnav("check", path, *names)
    assert untimed.returncode == 2 and "such as --columns t_s=NAME, or give --rate" in untimed.stderr


@pytest.mark.parametrize("arguments, named", [
    (["--accel-unit", "stone"], "--accel-unit stone: choose one of m/s2, g, mg"),
    (["--columns", "gx"], "--columns gx: write NAME=VALUE"),
    (["--axes", "mag=x,y"], "--axes x,y: write three axes"),
    (["--rate", "0"], "--rate 0: must be above 0 Hz"),
    (["--hemisphere", "east"], "--hemisphere east: choose one of north, south"),
    (["--format", "tcx"], "--format tcx: choose one of broad"),
])  # fmt: skip
def test_options_that_cannot_be_are_named_as_they_were_typed(in_g, arguments, named):
    refused = hnav("check", in_g, *arguments)
    assert refused.returncode == 2 and named in refused.stderr


def test_a_magnetometer_with_wrong_axes_is_not_calibrated(tmp_path, motion):
    out = tmp_path / "sensor.json"
    mirrored = recorded.x_io(tmp_path, replace(motion, field_b_tesla=motion.field_b_tesla * [1, 1, -1]))
    done = hnav("calibrate", mirrored, "--out", str(out))
    assert done.returncode == 2 and not out.exists()
    assert "use --axes mag=x,y,-z: a calibration would take this for soft iron" in done.stderr


def test_a_field_that_is_mostly_rejected_is_said(tmp_path, motion):
    iron = recorded.x_io(tmp_path, replace(motion, field_b_tesla=motion.field_b_tesla + [3e-5, -2e-5, 1.5e-5]))
    done = hnav("filter", iron, "--out", str(tmp_path / "out.csv"))
    assert done.returncode == 0 and "samples of the field did not fit" in done.stderr + done.stdout


def test_calibrate_takes_what_a_raw_magnetometer_gives(tmp_path, motion):
    rng = np.random.default_rng(1)
    raw = replace(motion, field_b_tesla=motion.field_b_tesla + [3e-4, 0, 0] + 1e-8 * rng.normal(size=motion.field_b_tesla.shape))
    done = hnav("calibrate", recorded.x_io(tmp_path, raw))
    assert done.returncode == 0, done.stderr
    assert "uT" in done.stdout and not done.stderr
