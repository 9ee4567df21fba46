"""The demo: the frames found in the device recordings hold, the figures are printed, bad input gets one line."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

from hnav.cli import demo
from hnav.filters.rotations import rotation_error_rad
from hnav.io import device_recordings
from hnav.io.recordings import read_recording
from hnav.reports import plots
from studies import overview

RNG_SEED = 20240508


@pytest.fixture(scope="session")
def wheel() -> Path:
    try:
        return device_recordings.find_wheel()
    except device_recordings.WheelUnavailable as reason:
        pytest.skip(str(reason))


@pytest.fixture(scope="session", params=["xsens", "x_imu"])
def device_recording(request, wheel):
    return getattr(device_recordings, f"read_{request.param}")(wheel).recording


def run_demo(*arguments: str):
    return CliRunner().invoke(demo.app, list(arguments), env={"COLUMNS": "120"})


def known_attitude(recording) -> tuple[np.ndarray, Rotation]:
    rows = np.flatnonzero(np.isfinite(recording.reference_q_nb).all(axis=1))
    return rows, Rotation.from_quat(recording.reference_q_nb[rows][:, [1, 2, 3, 0]])


def write_csv(file: Path, seconds: float = 3.0, rate_hz: float = 50.0) -> Path:
    """A sensor lying still, x forward y right z down, heading north, in a field of 50 uT and 60 deg dip."""
    t_s = np.arange(0.0, seconds, 1.0 / rate_hz)
    noise = np.random.default_rng(RNG_SEED).normal(size=(len(t_s), 9)) * ([1e-3] * 3 + [1e-2] * 3 + [1e-7] * 3)
    level = [0.0, 0.0, 0.0, 0.0, 0.0, -9.81, 25e-6, 0.0, 43.3e-6]
    np.savetxt(file, np.column_stack([t_s, noise + level]), delimiter=",", comments="", header="t_s,gx,gy,gz,ax,ay,az,mx,my,mz")
    return file


# ------------------------------------------------------------------------------------------ frames and units


def test_device_attitude_turns_specific_force_into_up(device_recording):
    rows, attitude = known_attitude(device_recording)
    mean_force = np.median(attitude.apply(device_recording.force_b_m_s2[rows]), axis=0)
    assert np.degrees(np.arctan2(np.hypot(*mean_force[:2]), mean_force[2])) < 1.0
    assert abs(mean_force[2] - 9.8) < 0.15


def test_force_points_up_sample_by_sample_in_quiet_moments(device_recording):
    rows, attitude = known_attitude(device_recording)
    force = device_recording.force_b_m_s2[rows]
    quiet = (np.abs(np.linalg.norm(force, axis=1) - 9.8) < 0.2) & (
        np.linalg.norm(device_recording.rate_b_rad_s[rows], axis=1) < np.radians(10)
    )
    up = attitude.apply(force)[quiet]
    angle_deg = np.degrees(np.arctan2(np.hypot(up[:, 0], up[:, 1]), up[:, 2]))
    assert quiet.sum() > 20
    assert np.median(angle_deg) < 3.0


def test_device_attitude_turns_by_the_measured_rate(device_recording):
    rows, attitude = known_attitude(device_recording)
    dt_s = np.diff(device_recording.t_s[rows])[:, None]
    turned = (attitude[:-1].inv() * attitude[1:]).as_rotvec() / dt_s
    # The rate of a row is the mean over the interval that ends there; the x-IMU's attitude skips every second row.
    measured = (
        device_recording.rate_b_rad_s[rows[1:]]
        + device_recording.rate_b_rad_s[rows[:-1] + (rows[1] - rows[0]) // 2 * 1 if rows[1] - rows[0] == 2 else rows[1:]]
    ) / 2
    fit = np.linalg.lstsq(measured, turned, rcond=None)[0]
    assert np.abs(fit - np.eye(3)).max() < 0.03


def test_field_of_quiet_phases_points_to_magnetic_north(device_recording):
    rows, attitude = known_attitude(device_recording)
    moving = np.linalg.norm(device_recording.rate_b_rad_s[rows], axis=1) > np.radians(10)
    field = attitude.apply(np.nan_to_num(device_recording.field_b_tesla[rows]))
    seen = np.isfinite(device_recording.field_b_tesla[rows]).all(axis=1) & ~moving
    east, north, up = field[seen].mean(axis=0)
    assert abs(np.degrees(np.arctan2(east, north))) < 10.0
    assert up < 0.0


def test_rates_of_the_xsens_are_means_over_the_past_interval(wheel):
    recording = device_recordings.read_xsens(wheel).recording
    rows, attitude = known_attitude(recording)
    turned = (attitude[:-1].inv() * attitude[1:]).as_rotvec() * 50.0
    past = np.median(np.linalg.norm(turned - recording.rate_b_rad_s[1:], axis=1))
    coming = np.median(np.linalg.norm(turned - recording.rate_b_rad_s[:-1], axis=1))
    assert np.degrees(past) < 1.0
    assert coming > 10.0 * past


def test_repeated_fields_of_the_x_imu_are_no_samples(wheel):
    field = device_recordings.read_x_imu(wheel).recording.field_b_tesla
    seen = np.isfinite(field).all(axis=1)
    assert 0.6 < seen.mean() < 0.7
    neighbours = seen[1:] & seen[:-1]
    assert (np.abs(np.diff(field, axis=0))[neighbours].max(axis=1) > 0).all()


# ------------------------------------------------------------------------------------------ comparison and pictures


def test_a_constant_heading_offset_is_found_and_removed():
    t_s = np.arange(0.0, 4.0, 0.02)
    truth = Rotation.random(len(t_s), rng=np.random.default_rng(RNG_SEED))
    turned = Rotation.from_euler("z", 25.0, degrees=True) * truth
    against = demo.compare(t_s, scalar_first(turned), scalar_first(truth))
    assert against.heading_offset_deg == pytest.approx(25.0, abs=1e-9)
    assert np.nanmax(np.abs(against.heading_deg)) < 1e-9
    assert np.nanmax(against.inclination_deg) < 1e-5
    assert np.nanmedian(against.total_deg) == pytest.approx(25.0, abs=1e-9)


def test_an_inclination_is_not_taken_for_heading():
    t_s = np.arange(0.0, 4.0, 0.02)
    truth = Rotation.random(len(t_s), rng=np.random.default_rng(RNG_SEED))
    tilted = Rotation.from_euler("x", 4.0, degrees=True) * truth
    against = demo.compare(t_s, scalar_first(tilted), scalar_first(truth))
    assert np.nanmax(np.abs(against.heading_deg)) < 1e-9
    np.testing.assert_allclose(against.inclination_deg[np.isfinite(against.inclination_deg)], 4.0, atol=1e-9)


def test_the_first_second_is_left_out_of_the_comparison():
    t_s = 100.0 + np.arange(0.0, 4.0, 0.02)
    q = np.tile([1.0, 0.0, 0.0, 0.0], (len(t_s), 1))
    assert (np.isfinite(demo.compare(t_s, q, q).total_deg) == (t_s >= 101.0)).all()


def test_rotation_error_leads_from_estimate_to_reference():
    estimate = Rotation.from_euler("ZYX", [40.0, 10.0, -20.0], degrees=True)
    error = np.array([0.01, -0.02, 0.3])
    found = rotation_error_rad(scalar_first(estimate)[None], scalar_first(Rotation.from_rotvec(error) * estimate)[None])
    np.testing.assert_allclose(found[0], error, atol=1e-12)


def test_a_turn_is_one_line_of_yaw():
    yaw_deg = np.linspace(0.0, 720.0, 200)
    turning = scalar_first(Rotation.from_euler("z", yaw_deg[:, None], degrees=True))
    np.testing.assert_allclose(plots.euler_deg(turning)[:, 2], yaw_deg, atol=1e-9)


def test_quaternions_of_one_rotation_are_drawn_without_sign_jumps():
    turning = scalar_first(Rotation.from_euler("z", np.linspace(0.0, 700.0, 200)[:, None], degrees=True))
    flipped = turning * np.where(np.arange(200) % 3 == 0, -1.0, 1.0)[:, None]
    assert np.abs(np.diff(plots.continuous_quaternion(flipped), axis=0)).max() < 0.05


def test_the_share_inside_the_band_is_counted():
    axes = plots.figure(200, 200).subplots()
    error_deg = np.array([0.5, 2.9, -3.1, np.nan])
    assert plots.draw_error_band(axes, np.arange(4.0), error_deg, np.ones(4), "error") == pytest.approx(2 / 3)


def test_running_means_lie_side_by_side_and_skip_gaps():
    t_s = np.arange(0.0, 4.0, 0.5)
    values = np.array([1.0, 3.0, np.nan, np.nan, 5.0, np.nan, 7.0, 9.0])
    middle_s, mean = plots.running_mean(t_s, values, 1.0)
    np.testing.assert_allclose(middle_s, [0.5, 2.5, 3.5])
    np.testing.assert_allclose(mean, [2.0, 5.0, 8.0])


def scalar_first(rotation: Rotation) -> np.ndarray:
    return rotation.as_quat()[..., [3, 0, 1, 2]]


# ------------------------------------------------------------------------------------------ the command


def test_demo_prints_its_figures_and_writes_the_picture(wheel, tmp_path, monkeypatch):
    monkeypatch.setenv(device_recordings.WHEEL_VARIABLE, str(wheel))
    done = run_demo("--part", "recordings", "--out", str(tmp_path))
    assert done.exit_code == 0, done.output
    for row in ("total", "heading, offset removed", "inclination"):
        assert len(re.findall(r"\d+\.\d +\d+\.\d deg", re.search(rf"│ +{row} .*", done.output)[0])) == 2, row
    for word in (
        "constant heading offset",
        "mean NIS force (expected 3)",
        "mean NIS field (expected 3)",
        "gyro bias z",
        "time per row",
        "no ground truth",
        "demo.png",
    ):
        assert word in done.output
    assert "nan" not in done.output
    assert (tmp_path / "demo.png").read_bytes().startswith(b"\x89PNG")


def test_demo_runs_the_experiment_in_closed_co_simulation(tmp_path):
    pytest.importorskip("plotly", reason="plotly is not installed: no report")
    done = run_demo("--part", "experiment", "--runs", "2", "--out", str(tmp_path))
    if "has not been built" in done.output:
        pytest.skip(done.output)
    assert done.exit_code == 0, done.output
    for word in ("the paper", "3.61", "fitted", "honest P0", "report.html"):
        assert word in done.output
    assert (tmp_path / "turntable" / "report.html").stat().st_size > 1e6


def test_a_part_that_is_none_is_named():
    done = run_demo("--part", "half")
    assert done.exit_code == 2 and "--part half: choose one of all, experiment, recordings" in done.output


def test_filter_and_device_agree_on_the_vertical(device_recording):
    run = demo.run_engine(device_recording, "device", "hrekf", "c", {})
    against = demo.compare(device_recording.t_s, run.result.q_nb, device_recording.reference_q_nb)
    assert np.nanmedian(against.inclination_deg) < 4.0
    assert abs(against.heading_offset_deg) < 10.0


def test_a_users_file_is_run_without_a_reference(tmp_path):
    done = run_demo(str(write_csv(tmp_path / "still.csv")), "--out", str(tmp_path), "--engine", "c")
    assert done.exit_code == 0, done.output
    assert "difference to" not in done.output
    assert "gyro bias x" in done.output
    assert (tmp_path / "demo.png").stat().st_size > 10_000


def test_a_broad_trial_is_compared_with_the_optics(broad_trials, tmp_path):
    done = run_demo(
        str(next(iter(broad_trials.values()))), "--out", str(tmp_path), "--engine", "c", "--set", "gyro_hold=backward"
    )
    assert done.exit_code == 0, done.output
    assert "difference to the optics" in done.output
    assert "gyro_hold=backward" in done.output
    assert float(re.search(r"total +│ +([\d.]+)", done.output)[1]) < 10.0


def test_a_recording_without_a_field_does_not_start_and_says_so(tmp_path):
    file = write_csv(tmp_path / "no_field.csv")
    rows = [",".join(line.split(",")[:7]) for line in file.read_text().splitlines()]
    file.write_text("\n".join(rows) + "\n")
    done = run_demo(str(file), "--out", str(tmp_path), "--engine", "c")
    assert done.exit_code == 2
    assert done.stderr.count("\n") == 1
    assert "did not start" in done.stderr and "start_mode=heading" in done.stderr
    assert run_demo(str(file), "--out", str(tmp_path), "--engine", "c", "--set", "start_mode=heading").exit_code == 0


def test_one_row_is_no_recording(tmp_path):
    done = run_demo(str(write_csv(tmp_path / "one.csv", seconds=0.02)), "--out", str(tmp_path), "--engine", "c")
    assert done.exit_code == 2
    assert "one.csv" in done.stderr


def test_a_folder_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "taken").write_text("a file")
    done = run_demo(str(write_csv(tmp_path / "still.csv")), "--out", str(tmp_path / "taken"), "--engine", "c")
    assert done.exit_code == 2
    assert "taken" in done.stderr and done.stderr.count("\n") == 1


def test_a_bad_file_gets_one_line_and_exit_code_2(tmp_path):
    bad = write_csv(tmp_path / "bad.csv")
    lines = bad.read_text().splitlines()
    lines[7] = lines[7].replace(",", ",abc", 1)
    bad.write_text("\n".join(lines))
    done = run_demo(str(bad), "--out", str(tmp_path))
    assert done.exit_code == 2
    assert done.stderr.count("\n") == 1
    assert "bad.csv" in done.stderr and "line 8" in done.stderr and "gx" in done.stderr
    assert not (tmp_path / "demo.png").exists()


@pytest.mark.parametrize(
    "arguments, named",
    [
        (["nowhere.csv"], "nowhere.csv"),
        (["--engine", "fmi9"], "fmi9"),
        (["--set", "no_such_option=1"], "no_such_option"),
        (["--set", "navigation_frame=ned"], "navigation_frame"),
    ],
)
def test_wrong_arguments_are_named_in_one_line(arguments, named, tmp_path):
    own = [] if arguments[0].endswith(".csv") else [str(write_csv(tmp_path / "still.csv"))]
    done = run_demo(*own, *arguments, "--out", str(tmp_path))
    assert done.exit_code == 2
    assert done.stderr.count("\n") == 1
    assert named in done.stderr


def test_without_network_the_package_and_the_way_out_are_named(monkeypatch, tmp_path):
    monkeypatch.delenv(device_recordings.WHEEL_VARIABLE, raising=False)
    monkeypatch.setattr(device_recordings, "cache_folder", lambda: tmp_path / "empty")
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    done = run_demo("--part", "recordings", "--out", str(tmp_path))
    assert done.exit_code == 2
    assert done.stderr.count("\n") == 1
    assert "scikit-kinematics 0.10.4" in done.stderr and "HNAV_DEMO_WHEEL" in done.stderr


def test_a_wheel_with_another_hash_is_refused(monkeypatch, tmp_path):
    (tmp_path / "other.whl").write_bytes(b"not the wheel")
    monkeypatch.setenv(device_recordings.WHEEL_VARIABLE, str(tmp_path / "other.whl"))
    done = run_demo("--out", str(tmp_path))
    assert done.exit_code == 2
    assert "other.whl" in done.stderr and "sha256" in done.stderr


# ------------------------------------------------------------------------------------------ the picture of the README


def test_the_picture_of_the_readme_is_made_by_a_command(broad_trials, tmp_path):
    if overview.TRIAL not in broad_trials:
        pytest.skip(f"BROAD_DIR has no trial {overview.TRIAL:02d}")
    folder = broad_trials[overview.TRIAL].parent
    picture = tmp_path / "overview.png"
    done = CliRunner().invoke(plots.app, ["overview", "--broad", str(folder), "--out", str(picture)])
    assert done.exit_code == 0, done.output
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert picture.stat().st_size < 200_000


def test_a_folder_without_trials_gets_one_line(tmp_path):
    done = CliRunner().invoke(plots.app, ["overview", "--broad", str(tmp_path), "--out", str(tmp_path / "overview.png")])
    assert done.exit_code == 2
    assert done.stderr.count("\n") == 1 and "BROAD" in done.stderr


def test_sigma_grows_between_samples_and_falls_at_them(broad_trials):
    recording = read_recording(next(iter(broad_trials.values())))
    zoom = overview.look_between(recording, 10.0, 0.05, {"navigation_frame": "enu"})
    sum_of_squares = (zoom.sigma_rad**2).sum(axis=1)
    at_jump = np.zeros(len(zoom.t_s) - 1, bool)
    at_jump[zoom.after_jump[1:] - 1] = True
    assert (np.diff(sum_of_squares)[at_jump] < 0).all()
    assert (np.diff(sum_of_squares)[~at_jump] > 0).all()
