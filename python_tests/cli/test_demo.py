"""The demo: the figures are printed, the picture is written, bad input gets one line."""

import re
from pathlib import Path

import numpy as np
import pytest

from command_line import Answer, hnav
from hnav.cli.demo import run_engine
from hnav.io import device_recordings
from hnav.reports.recording_run import compare

RNG_SEED = 20240508


def run_demo(*arguments: str) -> Answer:
    return hnav("demo", *arguments)


def write_csv(file: Path, seconds: float = 3.0, rate_hz: float = 50.0) -> Path:
    """A sensor lying still, x forward y right z down, heading north, in a field of 50 uT and 60 deg dip."""
    t_s = np.arange(0.0, seconds, 1.0 / rate_hz)
    noise = np.random.default_rng(RNG_SEED).normal(size=(len(t_s), 9)) * ([1e-3] * 3 + [1e-2] * 3 + [1e-7] * 3)
    level = [0.0, 0.0, 0.0, 0.0, 0.0, -9.81, 25e-6, 0.0, 43.3e-6]
    np.savetxt(file, np.column_stack([t_s, noise + level]), delimiter=",", comments="", header="t_s,gx,gy,gz,ax,ay,az,mx,my,mz")
    return file


def test_demo_prints_its_figures_and_writes_the_picture(wheel, tmp_path, monkeypatch):
    monkeypatch.setenv(device_recordings.WHEEL_VARIABLE, str(wheel))
    done = run_demo("--part", "recordings", "--out", str(tmp_path))
    assert done.returncode == 0, done.stdout
    for row in ("total", "heading, offset removed", "inclination"):
        assert len(re.findall(r"\d+\.\d +\d+\.\d deg", re.search(rf"│ +{row} .*", done.stdout)[0])) == 2, row
    for word in (
        "constant heading offset",
        "mean NIS force (expected 3)",
        "mean NIS field (expected 3)",
        "gyro bias z",
        "time per row",
        "no ground truth",
        "demo.png",
    ):
        assert word in done.stdout
    assert "nan" not in done.stdout
    assert (tmp_path / "demo.png").read_bytes().startswith(b"\x89PNG")


def test_demo_runs_the_experiment_in_closed_co_simulation(tmp_path):
    pytest.importorskip("plotly", reason="plotly is not installed: no report")
    done = run_demo("--part", "experiment", "--out", str(tmp_path))
    if "is not built" in done.stderr:
        pytest.skip(done.stderr)
    assert done.returncode == 0, done.stdout
    for word in ("the paper", "closed co-simulation", "report.html"):
        assert word in done.stdout
    assert (tmp_path / "turntable" / "report.html").stat().st_size > 1e6


def test_a_part_that_is_none_is_named():
    done = run_demo("--part", "half")
    assert done.returncode == 2 and "--part half: choose one of all, experiment, recordings" in done.stderr


def test_filter_and_device_agree_on_the_vertical(device_recording):
    run = run_engine(device_recording, "device", "hrekf", "c", {})
    against = compare(device_recording.t_s, run.result.q_nb, device_recording.reference_q_nb)
    assert np.nanmedian(against.inclination_deg) < 4.0
    assert abs(against.heading_offset_deg) < 10.0


def test_a_users_file_is_run_without_a_reference(tmp_path):
    done = run_demo(str(write_csv(tmp_path / "still.csv")), "--out", str(tmp_path), "--engine", "c")
    assert done.returncode == 0, done.stdout
    assert "difference to" not in done.stdout
    assert "gyro bias x" in done.stdout
    assert (tmp_path / "demo.png").stat().st_size > 10_000


def test_a_broad_trial_is_compared_with_the_optics(broad_trials, tmp_path):
    done = run_demo(
        str(next(iter(broad_trials.values()))), "--out", str(tmp_path), "--engine", "c", "--set", "gyro_hold=backward"
    )
    assert done.returncode == 0, done.stdout
    assert "difference to the optics" in done.stdout
    assert "gyro_hold=backward" in done.stdout
    assert float(re.search(r"total +│ +([\d.]+)", done.stdout)[1]) < 10.0


def test_a_recording_without_a_field_does_not_start_and_says_so(tmp_path):
    file = write_csv(tmp_path / "no_field.csv")
    rows = [",".join(line.split(",")[:7]) for line in file.read_text().splitlines()]
    file.write_text("\n".join(rows) + "\n")
    done = run_demo(str(file), "--out", str(tmp_path), "--engine", "c")
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "did not start" in done.stderr and "start_mode=heading" in done.stderr
    assert run_demo(str(file), "--out", str(tmp_path), "--engine", "c", "--set", "start_mode=heading").returncode == 0


def test_one_row_is_no_recording(tmp_path):
    done = run_demo(str(write_csv(tmp_path / "one.csv", seconds=0.02)), "--out", str(tmp_path), "--engine", "c")
    assert done.returncode == 2
    assert "one.csv" in done.stderr


def test_a_folder_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "taken").write_text("a file")
    done = run_demo(str(write_csv(tmp_path / "still.csv")), "--out", str(tmp_path / "taken"), "--engine", "c")
    assert done.returncode == 2
    assert "taken" in done.stderr and done.stderr.count("\n") == 1


def test_a_bad_file_gets_one_line_and_exit_code_2(tmp_path):
    bad = write_csv(tmp_path / "bad.csv")
    lines = bad.read_text().splitlines()
    lines[7] = lines[7].replace(",", ",abc", 1)
    bad.write_text("\n".join(lines))
    done = run_demo(str(bad), "--out", str(tmp_path))
    assert done.returncode == 2
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
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert named in done.stderr


def test_without_network_the_package_and_the_way_out_are_named(monkeypatch, tmp_path):
    monkeypatch.delenv(device_recordings.WHEEL_VARIABLE, raising=False)
    monkeypatch.setattr(device_recordings, "cache_folder", lambda: tmp_path / "empty")
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    done = run_demo("--part", "recordings", "--out", str(tmp_path))
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "scikit-kinematics 0.10.4" in done.stderr and "HNAV_DEMO_WHEEL" in done.stderr


def test_a_wheel_with_another_hash_is_refused(monkeypatch, tmp_path):
    (tmp_path / "other.whl").write_bytes(b"not the wheel")
    monkeypatch.setenv(device_recordings.WHEEL_VARIABLE, str(tmp_path / "other.whl"))
    done = run_demo("--out", str(tmp_path))
    assert done.returncode == 2
    assert "other.whl" in done.stderr and "sha256" in done.stderr
