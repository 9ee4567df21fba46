"""hnav filter --filter ins: tables and pages of recordings with satellites, from one file or two, whole or in pieces."""

import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import hnav as library
import recorded
from browser import LOADED, browse
from command_line import hnav
from driven import as_recording
from hnav.cli import navigation
from hnav.filters.ins_recording import IN_A_GAP, aids_of, paired
from hnav.filters.run_files import columns
from hnav.io.aids import AidSamples
from studies.ins.vehicles import vehicle


@pytest.fixture(scope="module")
def drive():
    """A car as a recording, and its aids as samples by kind."""
    samples, _ = vehicle("car", "industrial", 11, 40.0)
    return as_recording(samples)


def write_drive(path, drive, with_aids=True):
    header, arrays = "t_s,gx,gy,gz,ax,ay,az", [drive.t_s, *drive.rate_b_rad_s.T, *drive.force_b_m_s2.T]
    if with_aids:
        # A fix stands in the first row that does not come before it.
        header += ",lat_deg,lon_deg,alt_m,vn,ve,vd"
        for kind, factor in (("position", np.degrees([1, 1, 0]) + [0, 0, 1]), ("velocity", 1.0)):
            one, table = drive.aids[kind], np.full((len(drive.t_s), 3), np.nan)
            table[np.minimum(np.searchsorted(drive.t_s, one.t_s), len(drive.t_s) - 1)] = one.values * factor
            arrays += list(table.T)
    return recorded.write_rows(path, header, arrays)


def write_gnss(path, drive, late_s=0.0):
    position, velocity = drive.aids["position"], drive.aids["velocity"]
    times, mine, its = np.intersect1d(position.t_s, velocity.t_s, return_indices=True)
    place = position.values[mine] * (np.degrees([1, 1, 0]) + [0, 0, 1])
    columns = [times, times + late_s, *place.T, *velocity.values[its].T]
    return recorded.write_rows(path, "t_s,received_s,lat_deg,lon_deg,alt_m,vn,ve,vd", columns)


def test_a_table_is_the_run_of_its_recording(tmp_path, drive):
    path, out = write_drive(tmp_path / "drive.csv", drive), tmp_path / "out.csv"
    done = hnav("filter", path, "--filter", "ins", "--preset", "industrial", "--out", out)
    assert done.returncode == 0 and not done.stderr
    assert "ready: tilt after" in done.stdout and "position after" in done.stdout
    head = [line for line in out.read_text().splitlines() if line.startswith("#")]
    assert "# filter ins, preset industrial" in head and any(line.startswith("# phase: 0 waiting, 1 levelling") for line in head)
    read = pd.read_csv(out, comment="#")
    run = library.Ins("industrial").run_recording(library.read(path))
    for name, values in columns(run).items():
        np.testing.assert_allclose(read[name], values, rtol=1e-8, atol=1e-300)
    assert np.abs(read["lat_deg"] - np.degrees(run.place[:, 0])).max() < 1e-9
    assert set(read["phase"]) <= {0, 1, 2, 3} and read["heading_ready"].iloc[-1] == 1
    sparse = library.Ins("industrial").run_recording(library.read(path), every=10)
    np.testing.assert_array_equal(sparse.place, run.place[9::10])


def test_a_second_file_is_the_same_and_late_fixes_are_waited_for(tmp_path, drive):
    alone = write_drive(tmp_path / "imu.csv", drive, with_aids=False)
    outs = []
    for late_s in (0.0, 0.15):
        outs.append(tmp_path / f"out{late_s}.csv")
        gnss = write_gnss(tmp_path / f"gnss{late_s}.csv", drive, late_s)
        done = hnav("filter", alone, "--filter", "ins", "--preset", "industrial", "--gnss", gnss, "--out", outs[-1])
        assert done.returncode == 0 and not done.stderr, done.stderr
    punctual, late = (pd.read_csv(out, comment="#") for out in outs)
    assert "horizon_s=0.1" in outs[1].read_text().split("\nt_s,", 1)[0]
    # Once a fix is there the two agree to the bit; the last one of the late ones may not be.
    row = int(np.flatnonzero(punctual["t_s"] > drive.aids["position"].t_s[-2] + 0.17)[0])
    assert punctual["heading_ready"][row] == late["heading_ready"][row]
    np.testing.assert_array_equal(punctual.loc[row, "lat_deg":"heading"], late.loc[row, "lat_deg":"heading"])


def test_pieces_make_the_file_of_the_whole(tmp_path, drive, monkeypatch):
    path = write_drive(tmp_path / "drive.csv", drive)
    whole, parts = tmp_path / "whole.csv", tmp_path / "parts.csv"
    assert hnav("filter", path, "--filter", "ins", "--out", whole).returncode == 0
    monkeypatch.setattr("hnav.io.readers.pieces.PIECE", 1024)
    taken = []
    monkeypatch.setattr(navigation, "run_of_pieces", lambda *given: taken.append(run_of_pieces(*given)) or taken[-1])
    assert hnav("filter", path, "--filter", "ins", "--out", parts).returncode == 0
    assert taken[0] is not None and parts.read_bytes() == whole.read_bytes()


def test_a_page_costs_the_table_no_field(tmp_path, drive):
    path = write_drive(tmp_path / "drive.csv", drive)
    table = pd.read_csv(path)
    table[["mx", "my", "mz"]] = np.random.default_rng(1).normal([2e-5, 1e-5, 4e-5], 1e-7, (len(table), 3))
    table.to_csv(path, index=False)
    alone, beside = tmp_path / "alone.csv", tmp_path / "beside.csv"
    asked = ("filter", path, "--filter", "ins", "--preset", "industrial")
    done = hnav(*asked, "--out", alone), hnav(*asked, "--out", beside, "--report", tmp_path / "page.html")
    assert all(f"mag {len(table)}" in one.stdout for one in done), [one.stdout + one.stderr for one in done]
    assert alone.read_bytes() == beside.read_bytes()


run_of_pieces = navigation.run_of_pieces


def test_smoothed_it_is_the_same_with_hindsight_in_table_and_page(tmp_path, drive):
    path, out, page = write_drive(tmp_path / "drive.csv", drive), tmp_path / "out.csv", tmp_path / "page.html"
    done = hnav("filter", path, "--filter", "ins", "--preset", "industrial", "--smooth", "--out", out, "--report", page)
    assert done.returncode == 0 and not done.stderr, done.stderr
    assert "# smoothed: every row from all samples" in out.read_text() and "every row from all samples" in page.read_text()
    read = pd.read_csv(out, comment="#")
    run = library.Ins("industrial").run_recording(library.read(path), smooth=True)
    np.testing.assert_allclose(read["heading"], np.degrees(run.heading_rad) % 360, rtol=1e-8)
    assert (read["phase"] == 3).all() and read["heading_ready"].mean() > 0.7


@pytest.mark.parametrize("options, said", [
    (["--engine", "fmi3-cs"], "--engine with --filter ins"),
    (["--preset", "paper"], "--preset paper: ins has consumer, industrial"),
    (["--set", "start_hight_m=1"], "did you mean start_height_m"),
    ([], "has no positions .lat_deg, lon_deg, alt_m.: give --gnss FILE, or of a body at rest"),
    (["--gnss", "{imu}"], "no position .lat_deg, lon_deg, alt_m., velocity"),
    (["--gnss", "{other}"], "satellites have times from 1000000000 to .*give both the same clock"),
    (["--gnss", "{out}", "--out", "{out}"], "is read by this command|no such file"),
])  # fmt: skip
def test_what_cannot_be_done_is_said_in_one_line(tmp_path, drive, options, said):
    imu, out = write_drive(tmp_path / "imu.csv", drive, with_aids=False), tmp_path / "out.csv"
    other = tmp_path / "other.csv"
    other.write_text("t_s,lat_deg,lon_deg,alt_m\n1000000000,45,7,100\n1000000001,45,7,100\n")
    given = [text.format(imu=imu, other=other, out=out) for text in options]
    done = hnav("filter", imu, "--filter", "ins", "--out", out, *given)
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and re.search(said, done.stderr), done.stderr
    assert not out.exists()


def test_satellites_are_for_navigation_alone(tmp_path, drive):
    path, out = write_drive(tmp_path / "drive.csv", drive), tmp_path / "out.csv"
    done = hnav("filter", path, "--gnss", path, "--out", out)
    assert done.returncode == 2 and "attitude filters do not read it: add --filter ins" in done.stderr
    assert hnav("filter", path, "--out", out).returncode == 0  # the AHRS leaves them alone
    assert "car_across_m_s" in hnav("options", "--filter", "ins", "car").stdout


def test_a_body_at_rest_may_be_given_its_place(tmp_path, drive):
    rest = replace(
        drive, rate_b_rad_s=1e-5 * drive.rate_b_rad_s, force_b_m_s2=np.full_like(drive.force_b_m_s2, 0) + [0, 0, -9.8], aids={}
    )
    path, out = write_drive(tmp_path / "rest.csv", rest, with_aids=False), tmp_path / "out.csv"
    done = hnav("filter", path, "--filter", "ins", "--set", "start_place=given", "--set", "start_latitude_rad=0.8", "--out", out)
    assert done.returncode == 0 and re.search(
        r"the heading was never ready: its sigma reached .* deg, .* below .* deg", done.stderr
    )
    assert pd.read_csv(out, comment="#")["at_rest"].iloc[-1] == 1


def test_sensors_with_times_of_their_own_are_paired(drive):
    n = len(drive.t_s)
    rate, force = drive.rate_b_rad_s.copy(), drive.force_b_m_s2.copy()
    rate[1::2], force[::2] = np.nan, np.nan
    apart = replace(drive, rate_b_rad_s=rate, force_b_m_s2=force)
    together = paired(apart)
    assert len(together.t_s) == (n + 1) // 2 and paired(drive) is drive
    between = 0.5 * (drive.force_b_m_s2[1:-1:2][: len(together.t_s) - 2] + drive.force_b_m_s2[3::2][: len(together.t_s) - 2])
    np.testing.assert_allclose(together.force_b_m_s2[1:-1][: len(between)], between, atol=1e-9)
    run = library.Ins("industrial").run_recording(apart)
    assert run.ready[-1].all()


def test_a_gap_does_not_overflow_the_queue(drive):
    times = np.arange(0.0, 10.015, 0.01)
    one = AidSamples(times, np.full((len(times), 1), 1e5), np.full((len(times), 1), 20.0))
    kept, _, _, _ = aids_of({"pressure": one}, np.array([0.0, 0.01, 10.0, 10.01])).arrays()
    assert (kept > 0.015).sum() == IN_A_GAP + 1 and kept[-1] == pytest.approx(10.01) and (kept[2:] > 9.9).all()


def test_the_page_stands_alone(tmp_path, drive):
    pytest.importorskip("plotly", reason="plotly is not installed: no report")
    path, page = write_drive(tmp_path / "drive.csv", drive), tmp_path / "page.html"
    done = hnav("filter", path, "--filter", "ins", "--report", page)
    assert done.returncode == 0
    text = page.read_text()
    assert not LOADED.search(text)
    for title in ("Track", "What is known when", "Heading", "Height and speed", "Standard deviations", "Biases"):
        assert f">{title}</h2>" in text
    again = tmp_path / "again.html"
    assert hnav("report", path, "--filter", "ins", "--out", again).returncode == 0 and again.read_text() == text
    shown, console, network = browse(page, tmp_path)
    assert not console and not network and shown.count('class="main-svg"') >= 6


def test_a_run_that_never_started_has_a_page_too(tmp_path, drive):
    pytest.importorskip("plotly", reason="plotly is not installed: no report")
    from hnav.reports.navigation_page import write_navigation_report

    run = library.Ins("industrial").run_recording(replace(drive, aids={}).cropped(2.0))
    assert write_navigation_report(run, tmp_path / "page.html") == ["known"]


def test_a_sensor_whose_z_points_up_is_said_with_what_levels_it(tmp_path, drive):
    upright = np.array([1.0, -1.0, -1.0])
    turned = replace(drive, rate_b_rad_s=drive.rate_b_rad_s * upright, force_b_m_s2=drive.force_b_m_s2 * upright)
    path, out = write_drive(tmp_path / "up.csv", turned), tmp_path / "out.csv"
    done = hnav("filter", path, "--filter", "ins", "--preset", "industrial", "--out", out)
    assert (
        done.returncode == 0 and "z axis of the sensor points up" in done.stderr and "--set q_body_sensor=0,1,0,0" in done.stderr
    )
    done = hnav("filter", path, "--filter", "ins", "--preset", "industrial", "--set", "q_body_sensor=0,1,0,0", "--out", out)
    assert done.returncode == 0 and not done.stderr
    assert np.abs(pd.read_csv(out, comment="#")["roll"].iloc[-1]) < 30


def test_velocities_in_another_unit_are_said(tmp_path):
    samples, _ = vehicle("car", "industrial", 11, 150.0)
    fast = as_recording(samples)
    velocity = fast.aids["velocity"]
    fast = replace(fast, aids={**fast.aids, "velocity": replace(velocity, values=3.6 * velocity.values)})
    path = write_drive(tmp_path / "fast.csv", fast)
    done = hnav("filter", path, "--filter", "ins", "--preset", "industrial", "--out", tmp_path / "out.csv")
    assert done.returncode == 0 and "this looks like km/h" in done.stderr
    checked = hnav("check", path)
    assert checked.returncode == 1 and "this looks like km/h" in checked.stdout


def test_columns_that_nothing_reads_are_named(tmp_path, drive):
    path = write_drive(tmp_path / "drive.csv", drive)
    table = pd.read_csv(path).assign(rpm=900, door_open=0)
    table.to_csv(path, index=False)
    assert "columns not read: rpm, door_open" in hnav("check", path).stdout


def test_columns_reach_the_file_of_satellites_and_check_reads_it(tmp_path, drive):
    imu, gnss = write_drive(tmp_path / "imu.csv", drive, with_aids=False), write_gnss(tmp_path / "gnss.csv", drive)
    plain = hnav("check", imu, "--gnss", gnss)
    assert plain.returncode == 0 and "velocity" in plain.stdout and plain.stdout.endswith("plausible\n"), plain.stdout
    renamed = gnss.read_text().replace("t_s,received_s,lat_deg", "when,got,breadth", 1)
    gnss.write_text(renamed)
    imu.write_text(imu.read_text().replace("t_s", "moment", 1))
    named = [f"--columns={pair}" for pair in ("t_s=moment", "gnss.t_s=when", "lat_deg=breadth", "received_s=got")]
    assert hnav("check", imu, "--gnss", gnss, *named).stdout.replace(": table", ": csv") == plain.stdout
    out = tmp_path / "out.csv"
    done = hnav("filter", imu, "--filter", "ins", "--gnss", gnss, "--out", out, *named)
    assert done.returncode == 0 and len(pd.read_csv(out, comment="#")) == len(drive.t_s), done.stderr


@pytest.mark.parametrize("given, said", [
    (["--columns", "lat_deg=nowhere"], "--columns lat_deg=nowhere: .*gnss.csv, line 1 has no such column, but t_s"),
    (["--columns", "imu=/imu"], "--columns imu=/imu: .*imu.csv is read as csv, which has no such column: name t_s"),
    (["--columns", "gnss.gnss=/fix"], "--columns gnss=/fix: .*gnss.csv is read as table, which has no such column"),
    (["--gnss", "{imu}"], "no position .lat_deg"),
])  # fmt: skip
def test_a_column_that_no_role_can_use_is_refused(tmp_path, drive, given, said):
    imu, gnss = write_drive(tmp_path / "imu.csv", drive, with_aids=False), write_gnss(tmp_path / "gnss.csv", drive)
    done = hnav("check", imu, "--gnss", gnss, *(text.format(imu=imu) for text in given))
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and re.search(said, done.stderr), done.stderr


def test_satellites_alone_are_no_recording(tmp_path, drive):
    gnss = write_gnss(tmp_path / "gnss.csv", drive)
    assert "holds satellites alone: give the recording of the inertial sensors, and this as --gnss" in hnav("check", gnss).stderr
