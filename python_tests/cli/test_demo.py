"""The demo: a user's own file, recordings of devices, the closed loop; the printed lines name the pages that were written."""

import re
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest

from checkout import built_system
from command_line import Answer, hnav
from hnav.cli import demo
from hnav.cli.demo import SCENARIOS, recommended_first, rmse_deg, run_ahrs
from hnav.filters.run_summary import rows, summary
from hnav.fmi.engines import run_recording
from hnav.io import device_recordings
from hnav.io.readers import read
from hnav.reports.recording_run import compare
from hnav.systems.simulation import read_run

RNG_SEED = 20240508


def run_demo(*arguments: object) -> Answer:
    return hnav("demo", "--no-open", *arguments)


def write_csv(file: Path, seconds: float = 3.0, rate_hz: float = 50.0) -> Path:
    """A sensor lying still, x forward y right z down, heading north, in a field of 50 uT and 60 deg dip."""
    t_s = np.arange(0.0, seconds, 1.0 / rate_hz)
    noise = np.random.default_rng(RNG_SEED).normal(size=(len(t_s), 9)) * ([1e-3] * 3 + [1e-2] * 3 + [1e-7] * 3)
    level = [0.0, 0.0, 0.0, 0.0, 0.0, -9.81, 25e-6, 0.0, 43.3e-6]
    np.savetxt(file, np.column_stack([t_s, noise + level]), delimiter=",", comments="", header="t_s,gx,gy,gz,ax,ay,az,mx,my,mz")
    return file


def pages(done: Answer) -> list[Path]:
    """Those that it names."""
    return [Path(path) for path in re.findall(r"page.*: (\S+\.html)$", done.stdout, re.MULTILINE)]


short_run = cache(partial(demo.simulate, stop_s=3.0))


@pytest.fixture
def short(monkeypatch):
    """The closed loop for a few seconds and seeds."""
    built_system("turntable")
    monkeypatch.setattr(demo, "simulate", short_run)
    monkeypatch.setattr(demo, "SEEDS", range(1, 4))


# ------------------------------------------------------------------------------------------------ one's own file


def test_ones_own_file_comes_first_with_the_figures_of_the_filter_and_a_page(tmp_path):
    pytest.importorskip("plotly", reason="plotly is not installed: no page")
    file = write_csv(tmp_path / "still.csv")
    done = run_demo(file, "--out", tmp_path / "pages")
    assert done.returncode == 0, done.stderr
    data = read(file)
    said = rows(summary(run_recording(data, "ahrs", "c", {})))
    lines = [" ".join(line.split()) for line in done.stdout.splitlines()]
    assert lines == [repr(data), *(f"{name} {value}" for name, value in said), f"page: {tmp_path / 'pages' / 'still.html'}"]
    assert pages(done) == list((tmp_path / "pages").iterdir())
    assert "turntable" not in done.stdout


def test_what_is_not_plausible_in_a_file_is_said(tmp_path):
    pytest.importorskip("plotly", reason="plotly is not installed: no page")
    table = np.loadtxt(write_csv(tmp_path / "si.csv"), delimiter=",", skiprows=1)
    table[:, 4:7] /= 9.80665
    np.savetxt(tmp_path / "g.csv", table, delimiter=",", comments="", header="t_s,gx,gy,gz,ax,ay,az,mx,my,mz")
    assert "--accel-unit g" in run_demo(tmp_path / "g.csv", "--out", tmp_path, "--force").stderr
    assert run_demo(tmp_path / "g.csv", "--out", tmp_path).returncode == 2
    assert run_demo(tmp_path / "g.csv", "--out", tmp_path, "--strict").returncode == 2
    assert run_demo(tmp_path / "g.csv", "--out", tmp_path, "--accel-unit", "g", "--strict").returncode == 0


@pytest.mark.parametrize("rows, columns", [(150, 7), (1, 10), (2, 10), (3, 10)])
def test_a_recording_of_which_little_can_be_said_is_one_too(tmp_path, rows, columns):
    pytest.importorskip("plotly", reason="plotly is not installed: no page")
    file = write_csv(tmp_path / "little.csv")
    lines = [",".join(line.split(",")[:columns]) for line in file.read_text().splitlines()]
    file.write_text("\n".join(lines[: rows + 1]) + "\n")
    done = run_demo(file, "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    assert "heading ready never" in " ".join(done.stdout.split()) and "nan" not in done.stdout
    assert len(pages(done)) == 1


@pytest.mark.parametrize("arguments, named", [
    (["nowhere.csv"], "nowhere.csv"),
    (["FILE", "--set", "no_such_option=1"], "no_such_option"),
    (["FILE", "--gyro-unit", "knots"], "--gyro-unit knots"),
    (["FILE", "--out", "TAKEN"], "taken"),
    (["BAD"], "line 8"),
])  # fmt: skip
def test_what_cannot_be_done_is_one_line(arguments, named, tmp_path):
    bad = write_csv(tmp_path / "bad.csv")
    lines = bad.read_text().splitlines()
    lines[7] = lines[7].replace(",", ",abc", 1)
    bad.write_text("\n".join(lines))
    (tmp_path / "taken").write_text("a file")
    places = {"FILE": write_csv(tmp_path / "still.csv"), "BAD": bad, "TAKEN": tmp_path / "taken"}
    done = run_demo("--out", tmp_path / "pages", *(places.get(argument, argument) for argument in arguments))
    assert done.returncode == 2
    assert named in done.stderr and done.stderr.count("\n") == 1
    assert not (tmp_path / "pages").exists()


# ------------------------------------------------------------------------------------------------ what comes with it


@pytest.mark.usefixtures("short")
def test_without_a_file_it_shows_devices_and_the_closed_loop(wheel, tmp_path, monkeypatch):
    pytest.importorskip("plotly", reason="plotly is not installed: no page")
    monkeypatch.setenv(device_recordings.WHEEL_VARIABLE, str(wheel))
    done = run_demo("--out", tmp_path)
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) <= 12 and "nan" not in done.stdout
    assert "Xsens" in done.stdout and "x-IMU" in done.stdout
    assert len(pages(done)) == 3 and all(page.is_file() for page in pages(done))
    assert all(text in done.stdout for text in SCENARIOS.values())


@pytest.mark.usefixtures("short")
def test_the_page_of_the_closed_loop_is_of_the_run_in_the_middle(tmp_path, monkeypatch):
    pytest.importorskip("plotly", reason="plotly is not installed: no page")
    made = []
    short = demo.simulate
    monkeypatch.setattr(demo, "simulate", lambda *a, **named: made.append(short(*a, **named)) or made[-1])
    page = demo.show_closed_loop(tmp_path)
    last = made[-len(demo.SEEDS) :]
    errors = [rmse_deg(run, "ahrs") for run in last]
    shown = read_run(page.parent)
    assert rmse_deg(shown, "ahrs") == np.median(errors)
    assert shown.about["seed"] == list(demo.SEEDS)[int(np.argsort(errors)[1])]
    assert recommended_first(shown)[0] == "ahrs" and set(recommended_first(shown)) == {"ahrs", "hekf", "hrekf"}


def test_the_ahrs_and_the_device_agree_on_the_vertical(device_recording):
    result = run_ahrs(device_recording, {"navigation_frame": "enu"})
    against = compare(device_recording.t_s, result.q_nb, device_recording.reference_q_nb)
    assert np.nanmedian(against.inclination_deg) < 4.0


@pytest.mark.usefixtures("short")
def test_without_network_the_way_out_is_named_and_the_rest_is_shown(monkeypatch, tmp_path):
    pytest.importorskip("plotly", reason="plotly is not installed: no page")
    monkeypatch.delenv(device_recordings.WHEEL_VARIABLE, raising=False)
    monkeypatch.setattr(device_recordings, "cache_folder", lambda: tmp_path / "empty")
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    done = run_demo("--out", tmp_path)
    assert done.returncode == 0, done.stderr
    assert "scikit-kinematics 0.10.4" in done.stdout and "HNAV_DEMO_WHEEL" in done.stdout
    assert len(pages(done)) == 1


@pytest.mark.usefixtures("short")
def test_a_wheel_with_another_hash_is_not_read(monkeypatch, tmp_path):
    pytest.importorskip("plotly", reason="plotly is not installed: no page")
    (tmp_path / "other.whl").write_bytes(b"not the wheel")
    monkeypatch.setenv(device_recordings.WHEEL_VARIABLE, str(tmp_path / "other.whl"))
    done = run_demo("--out", tmp_path)
    assert "other.whl" in done.stdout and "sha256" in done.stdout and "Xsens" not in done.stdout
