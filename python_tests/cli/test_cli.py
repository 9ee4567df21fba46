"""The command line as a user types it."""

import json
import os
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest

from command_line import hnav, hnav_process
from hnav import __version__
from hnav.cli.parameters import parse_settings
from hnav.cli.words import UsageError
from motion import tilted_motion


@pytest.fixture
def flight(tmp_path, motion):
    m = motion.recording.cropped(1)
    path = tmp_path / "flight.csv"
    table = np.column_stack([m.t_s, m.rate_b_rad_s, m.force_b_m_s2, m.field_b_tesla * 1e6])
    np.savetxt(path, table, delimiter=",", header="t_s,gx,gy,gz,ax,ay,az,mx,my,mz", comments="")
    return path


@pytest.mark.parametrize("engine", ["c", "fmi3-cs"])
def test_filter_writes_one_row_for_each_sample(flight, tmp_path, engine):
    out = tmp_path / "out.csv"
    done = hnav(
        "filter", flight, "--filter", "hrekf", "--engine", engine, "--mag-unit", "uT", "--set", "gamma_mode=kl", "--out", out
    )
    assert done.returncode == 0, done.stderr
    table = pd.read_csv(out, comment="#")
    assert len(table) == 100
    assert tuple(table.columns[:8]) == ("t_s", "q0", "q1", "q2", "q3", "roll_deg", "pitch_deg", "yaw_deg")
    np.testing.assert_allclose(sum(table[f"q{i}"][1:] ** 2 for i in range(4)), 1, atol=1e-8)
    assert np.isnan(table["q0"][0])  # a start needs two samples that agree
    assert table["roll_deg"][1] == pytest.approx(20, abs=1)
    assert "100 rows" in done.stdout


def test_a_communication_step_gives_the_same_rows_where_samples_arrive(flight, tmp_path):
    tables = []
    for step in ([], ["--step", "0.0037"]):
        out = tmp_path / "out.csv"
        done = hnav("filter", flight, "--engine", "fmi2-cs", "--mag-unit", "uT", *step, "--out", out)
        assert done.returncode == 0, done.stderr
        tables.append(out.read_text().splitlines())
    assert tables[0] == tables[1]


def test_frames_are_a_choice(flight, tmp_path):
    yaw = {}
    for frame in ("ned", "enu"):
        out = tmp_path / f"{frame}.csv"
        assert hnav("filter", flight, "--frame", frame, "--mag-unit", "uT", "--out", out).returncode == 0
        yaw[frame] = pd.read_csv(out, comment="#")["q0"]
    assert not np.allclose(yaw["ned"], yaw["enu"])


def test_a_grade_sets_options_of_the_filter(flight, tmp_path):
    sigma = {}
    for grade in ("consumer", "tactical"):
        out = tmp_path / f"{grade}.csv"
        assert hnav("filter", flight, "--mag-unit", "uT", "--grade", grade, "--out", out).returncode == 0
        table = pd.read_csv(out, comment="#")
        sigma[grade] = table[next(name for name in table if "bias" in name and "sigma" in name)][1]
    assert sigma["consumer"] > 10 * sigma["tactical"]


def test_a_body_sets_what_the_filter_assumes_of_the_motion(flight, tmp_path):
    for name, body in (("any", ["--body", "any"]), ("unset", []), ("car", ["--body", "car"])):
        assert hnav("filter", flight, "--mag-unit", "uT", *body, "--out", tmp_path / f"{name}.csv").returncode == 0
    rows = {name: pd.read_csv(tmp_path / f"{name}.csv", comment="#") for name in ("any", "unset", "car")}
    assert rows["any"].equals(rows["unset"]) and not rows["car"].equals(rows["unset"])


def test_a_place_and_a_date_turn_the_heading_to_true_north(flight, tmp_path):
    pytest.importorskip("pygeomag")
    yaw = []
    for name, given in (("magnetic", ()), ("true", ("--place-and-date", "48.1,11.6,500,2026.5"))):
        out = tmp_path / f"{name}.csv"
        done = hnav("filter", flight, "--mag-unit", "uT", *given, "--out", out)
        assert done.returncode == 0, done.stderr
        yaw.append(pd.read_csv(out, comment="#")["yaw_deg"][1])
    assert yaw[1] - yaw[0] == pytest.approx(4.33, abs=0.01)  # the declination


@pytest.mark.parametrize("arguments, named", [
    (["filter", "nowhere.csv", "--out", "x.csv"], "nowhere.csv"),
    (["filter", "FLIGHT", "--out", "/nonexistent/x.csv"], "/nonexistent/x.csv"),
    (["filter", "FLIGHT", "--out", "OUT", "--engine", "fmi9"], "--engine fmi9: choose one of c"),
    (["filter", "FLIGHT", "--out", "OUT", "--filter", "magic"], "--filter magic: choose one of hrekf, ahrs, ins"),
    (["filter", "FLIGHT", "--out", "OUT", "--set", "gamma"], "NAME=VALUE"),
    (["filter", "FLIGHT", "--out", "OUT", "--set", "no_such=1"], "no_such"),
    (["filter", "FLIGHT", "--out", "OUT", "--set", "gamma=-1"], "gamma"),
    (["filter", "FLIGHT", "--out", "OUT", "--set", "gamma=-1", "--engine", "fmi3-cs"], "gamma"),
    (["filter", "FLIGHT", "--out", "OUT", "--frame", "down"], "--frame down"),
    (["filter", "FLIGHT", "--out", "OUT", "--preset", "best"], "preset"),
    (["filter", "FLIGHT", "--out", "OUT", "--grade", "best"], "--grade best: choose one of consumer, industrial, tactical"),
    (["filter", "FLIGHT", "--out", "OUT", "--grade", "consumer", "--sensor", "x.json"], "--grade and --sensor: give one of them"),
    (["filter", "FLIGHT", "--out", "OUT", "--sensor", "nowhere.json"], "nowhere.json"),
    (["filter", "FLIGHT", "--out", "OUT", "--place-and-date", "48,11"], "write LAT,LON,HEIGHT,YEAR"),
    (["filter", "FLIGHT", "--out", "OUT", "--body", "boat"], "--body boat: write ship"),
    (["check", "FLIGHT", "--body", "boat"], "--body boat: write ship"),
    (["check", "FLIGHT", "--frame", "eu"], "--frame eu: choose one of ned, enu"),
    (["check", "FLIGHT", "--set", "gyro_hodl=instant"], "did you mean gyro_hold?"),
    (["filter", "FLIGHT", "--out", "OUT", "--filter", "hrekf", "--body", "car"], "--body car: hrekf has no such option"),
    (["filter", "FLIGHT", "--out", "OUT", "--step", "-1"], "--step -1: must be above 0"),
    (["filter", "FLIGHT", "--out", "OUT", "--mag-unit", "furlong"], "--mag-unit furlong: choose one of T"),
    (["compare", "nowhere", "--filter", "ahrs"], "nowhere"),
    (["options", "--filter", "magic"], "magic: choose one of"),
])  # fmt: skip
def test_what_cannot_be_done_is_one_line_and_exit_code_2(flight, tmp_path, arguments, named):
    places = {"FLIGHT": str(flight), "OUT": str(tmp_path / "out.csv")}
    done = hnav(*(places.get(a, a) for a in arguments))
    assert done.returncode == 2
    assert named in done.stderr and len(done.stderr.strip().splitlines()) == 1, done.stderr


@pytest.mark.parametrize("text, found", [("a=b", {"a": "b"}), ("a=b=c", {"a": "b=c"}), ("a", None), ("=b", None), ("a=", None)])
def test_a_setting_is_name_and_value(text, found):
    if found is None:
        with pytest.raises(UsageError, match="write NAME=VALUE"):
            parse_settings([text])
    else:
        assert parse_settings([text]) == found


def test_a_command_that_is_terminated_leaves_nothing_unfinished(flight, tmp_path):
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    code = """
import os, signal
from hnav.cli.app import main
from hnav.fmi.fmus import Fmu
Fmu.do_step = lambda *_: os.kill(os.getpid(), signal.SIGTERM)
main(["filter", FLIGHT, "--engine", "fmi2-cs", "--out", OUT])
"""
    code = code.replace("FLIGHT", repr(str(flight))).replace("OUT", repr(str(tmp_path / "out.csv")))
    done = subprocess.run(
        [sys.executable, "-c", code], env=os.environ | {"TMPDIR": str(temporary)}, capture_output=True, text=True
    )
    assert done.returncode == 130 and len(done.stderr.splitlines()) <= 1, done.stderr
    assert list(temporary.iterdir()) == [] and not (tmp_path / "out.csv").exists()


def test_options_are_listed_with_unit_and_range():
    done = hnav("options")
    assert done.returncode == 0
    for word in ("gyro_noise_rad_per_sqrt_s", "rad/sqrt(s)", "off, fixed", "navigation_frame"):
        assert word in done.stdout.replace("\n", " ")


def test_version_names_package_and_library():
    assert hnav_process("--version").stdout.startswith(f"hnav {__version__}, library {__version__}")


def test_compare_with_a_filter_prints_all_trials_and_writes_json(broad_trials, tmp_path):
    folder, some = tmp_path / "trials", list(broad_trials.values())[::4]
    folder.mkdir()
    for path in some:
        (folder / path.name).symlink_to(path)
    out = tmp_path / "scores.json"
    done = hnav("compare", folder, "--filter", "ahrs", "--set", "solver=closed_form", "--json", out)
    assert done.returncode == 0, done.stderr
    figures = json.loads(out.read_text())
    assert len(figures["trials"]) == len(some)
    assert figures["mean"]["total"] < 4.0
    assert "undisturbed" in done.stdout and "NEES/3" in done.stdout


def test_sensors_that_were_not_ok_are_reported_with_the_cure(tmp_path):
    m = tilted_motion(12).recording
    path, out = tmp_path / "clipped.csv", tmp_path / "out.csv"
    field = m.field_b_tesla * 1e6
    field[500:] = field[500]
    table = np.column_stack([m.t_s, m.rate_b_rad_s.clip(-4.5, 4.5), m.force_b_m_s2, field])
    np.savetxt(path, table, delimiter=",", header="t_s,gx,gy,gz,ax,ay,az,mx,my,mz", comments="")
    done = hnav("filter", path, "--mag-unit", "uT", "--out", out)
    assert done.returncode == 0, done.stderr
    _, gyro, mag, gated = done.stdout.strip().splitlines()
    assert "samples of the field did not fit" in gated
    assert gyro.startswith("gyro saturated for ") and "--set gyro_range_rad_s=..." in gyro
    assert mag.startswith("mag stuck for ") and "cable" in mag
    written = pd.read_csv(out, comment="#")
    assert set(written["gyro_health"]) == {0, 4} and set(written["mag_health"]) == {0, 3} and set(written["accel_health"]) == {0}


def test_sensors_that_were_ok_are_not_spoken_of(flight, tmp_path):
    done = hnav("filter", flight, "--mag-unit", "uT", "--out", tmp_path / "out.csv")
    assert len(done.stdout.strip().splitlines()) == 1


def test_a_sensor_whose_z_points_up_is_named_unless_its_mounting_is_stated(tmp_path):
    rng, up = np.random.default_rng(1), tmp_path / "up.csv"
    rows = rng.normal([0, 0, 0, 0, 0, 9.81, 20, 0, -43], [0.01] * 3 + [0.05] * 3 + [0.3] * 3, (200, 9))
    table = np.column_stack([0.01 * np.arange(200), rows])
    np.savetxt(up, table, delimiter=",", header="t_s,gx,gy,gz,ax,ay,az,mx,my,mz", comments="")
    for given, named in (((), True), (("--set", "q_body_sensor=0,1,0,0"), False)):
        done = hnav("filter", up, *given, "--out", tmp_path / "out.csv", "--force")
        assert done.returncode == 0 and ("z axis of the sensor points up" in done.stdout + done.stderr) == named


def test_a_recording_is_checked_with_the_options_of_the_filter(tmp_path):
    """South of the magnetic equator the field points up: a place says so as the hemisphere does."""
    rng, path = np.random.default_rng(2), tmp_path / "south.csv"
    rows = rng.normal([0, 0, 0, 0, 0, -9.81, 20, 0, -43], [0.01] * 3 + [0.05] * 3 + [0.3] * 3, (200, 9))
    table = np.column_stack([0.01 * np.arange(200), rows])
    np.savetxt(path, table, delimiter=",", header="t_s,gx,gy,gz,ax,ay,az,mx,my,mz", comments="")
    common = ("--gyro-unit", "rad/s", "--frame", "ned", "--body", "hand", "--grade", "consumer", "--set", "gyro_hold=instant")
    plain, placed = (hnav("check", path, *common, *more) for more in ((), ("--place-and-date", "-33.9,18.4,50,2026.5")))
    assert "the field points up" in plain.stdout and plain.returncode == 1
    assert "the field points up" not in placed.stdout and placed.returncode == 0 and placed.stdout.endswith("plausible\n")
