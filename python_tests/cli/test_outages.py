"""hnav filter --filter ins --truth: errors against an exact truth, outages, and the message for a truth that does not fit."""

import re

import numpy as np
import pytest

import recorded
from command_line import hnav
from driven import as_recording
from hnav import earth, read
from hnav.filters.ins_recording import with_aids
from hnav.filters.options import Options
from hnav.io.readers import read_aids
from hnav.io.trajectories import read_trajectory, read_truth
from hnav.reports.comparison import compare
from hnav.reports.navigation_scores import navigation_score
from hnav.rotations import rotation_error_rad
from studies.ins.vehicles import vehicle

TRUTH = "t_s,lat_deg,lon_deg,alt_m,vn,ve,vd,roll_deg,pitch_deg,heading_deg"


@pytest.fixture(scope="module")
def drive(tmp_path_factory):
    """A car, 80 s, as recording and truth in files."""
    folder = tmp_path_factory.mktemp("drive")
    samples, truth = vehicle("car", "industrial", 12, 80.0)
    recording = as_recording(samples)
    imu = recorded.write_rows(
        folder / "imu.csv", "t_s,gx,gy,gz,ax,ay,az", [samples.t_s, *samples.rate_b_rad_s.T, *samples.force_b_m_s2.T]
    )
    position, velocity = recording.aids["position"], recording.aids["velocity"]
    place = position.values * (np.degrees([1, 1, 0]) + [0, 0, 1])
    seen = velocity.values[np.searchsorted(velocity.t_s, position.t_s)]
    gnss = recorded.write_rows(folder / "gnss.csv", "t_s,lat_deg,lon_deg,alt_m,vn,ve,vd", [position.t_s, *place.T, *seen.T])
    place = earth.place_of(truth.position_e)
    axes = earth.axes_at(place)
    body = np.einsum("nji,njk->nik", axes, truth.attitude_e.as_matrix())
    angles = [np.arctan2(body[:, 2, 1], body[:, 2, 2]), np.arcsin(-body[:, 2, 0]), np.arctan2(body[:, 1, 0], body[:, 0, 0])]
    rows = [
        truth.t_s,
        *np.degrees(place[:, :2]).T,
        place[:, 2],
        *np.einsum("nji,nj->in", axes, truth.velocity_e),
        *np.degrees(angles),
    ]
    path = recorded.write_rows(folder / "truth.csv", TRUTH, [column[::10] for column in rows])
    return recording, imu, gnss, path


def test_errors_are_as_stated_and_grow_with_the_outage(drive):
    recording, _, _, path = drive
    truth = read_truth(path)
    found = navigation_score(recording, truth, Options("ins", "industrial"), [5.0, 20.0])
    figures = {figure.name: figure for figure in found.figures}
    assert 0 < found.ready_s < 60 and not found.is_false
    assert figures["heading"].rms < 1.0 and figures["position, horizontal"].rms < 6.0 and figures["tilt"].rms < 0.3
    # The error of satellites stays for a minute: that of the position is one draw.
    assert all(figure.nees < (9 if "position" in figure.name else 2) for figure in found.figures)
    short, long = found.outages
    assert len(short.horizontal_m) > len(long.horizontal_m) > 0
    assert np.median(short.horizontal_m) < np.median(long.horizontal_m) < 100
    assert (long.horizontal_m < 5 * long.sigma_m).all()
    # Outages run on copies of the filter and do not change it.
    alone = navigation_score(recording, truth, Options("ins", "industrial")).figures
    for one, other in zip(alone, found.figures, strict=True):
        assert (one.name, one.unit, one.nees) == (other.name, other.unit, other.nees)
        np.testing.assert_array_equal(one.values, other.values)


def test_the_command_prints_errors_and_outages_and_writes_the_table(drive, tmp_path):
    _, imu, gnss, truth = drive
    out = tmp_path / "nav.csv"
    given = ("--filter", "ins", "--gnss", gnss, "--preset", "industrial")
    done = hnav("filter", imu, *given, "--truth", truth, "--outages", "10", "--out", out)
    assert done.returncode == 0 and not done.stderr, done.stderr
    assert "position, horizontal" in done.stdout and "10 s" in done.stdout and "heading ready after" in done.stdout
    assert "of the truth taken for deg" in done.stdout
    # compare and the score give equal figures for the same run and truth.
    data = with_aids(read(imu), read_aids(gnss))
    score = navigation_score(data, read_truth(truth), Options("ins", "industrial"))
    compared = compare(read_trajectory(truth), read_trajectory(out), begin_s=score.begin_s)
    rms = {figure.name: figure.rms for figure in compared.figures}
    printed = {figure.name: figure.rms for figure in score.figures}
    assert rms["position"] == pytest.approx(np.hypot(printed["position, horizontal"], printed["position, vertical"]), rel=0.01)
    assert rms["velocity"] == pytest.approx(np.hypot(printed["velocity, horizontal"], printed["velocity, vertical"]), rel=0.01)
    assert rms["heading"] == pytest.approx(printed["heading"], rel=0.01)
    alone = hnav("filter", imu, "--truth", truth, "--out", out)
    assert alone.returncode == 2 and "attitude filters do not read it" in alone.stderr
    lengths = hnav("filter", imu, *given, "--outages", "10", "--out", out)
    assert lengths.returncode == 2 and "add --truth FILE" in lengths.stderr


def test_angles_and_quaternions_are_the_same_truth(drive, tmp_path):
    path = drive[3]
    in_degrees = read_truth(path)
    rows = np.genfromtxt(path, delimiter=",", skip_header=1)
    header = "time,Latitude,Longitude,Altitude,vel_n,vel_e,vel_d,roll,pitch,yaw"
    radians = recorded.write_rows(tmp_path / "radians.csv", header, [*rows[:, :7].T, *np.radians(rows[:, 7:]).T])
    quaternions = recorded.write_rows(
        tmp_path / "q.csv", TRUTH.split(",roll")[0] + ",q0,q1,q2,q3", [*rows[:, :7].T, *in_degrees.q_nb.T]
    )
    for other, angles in ((read_truth(radians), "rad"), (read_truth(quaternions), "quaternion")):
        assert other.angles == angles
        np.testing.assert_allclose(other.q_nb, in_degrees.q_nb, atol=1e-12)
        np.testing.assert_allclose(other.place, in_degrees.place)
    between = in_degrees.at(in_degrees.t_s[:-1] + 0.05)
    assert np.abs(rotation_error_rad(between.q_nb, in_degrees.q_nb[:-1])).max() < 0.1
    assert np.isnan(in_degrees.at(in_degrees.t_s[-1:] + 1).place).all()


@pytest.mark.parametrize("options, said", [
    (["--outages", "10,x"], "--outages 10,x: write lengths in s"), (["--outages", "-1"], "--outages -1: write lengths"),
    (["--truth", "{imu}"], "imu.csv has no column lat_deg; a truth has t_s, lat_deg"),
    (["--truth", "{late}"], "lies within the truth, 1e.06|give both the same clock"), (["--truth", "{nothing}"], "cannot be read"),
])  # fmt: skip
def test_what_cannot_be_scored_is_said_in_one_line(drive, tmp_path, options, said):
    _, imu, gnss, truth = drive
    late = tmp_path / "late.csv"
    late.write_text("t_s,lat_deg,lon_deg,alt_m\n1000000,45,7,100\n1000001,45,7,100\n")
    given = [text.format(imu=imu, late=late, nothing=tmp_path / "nothing.csv") for text in options]
    done = hnav("filter", imu, "--filter", "ins", "--gnss", gnss, "--truth", truth, "--preset", "industrial", *given)
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and re.search(said, done.stderr), done.stderr


def test_a_warning_about_the_recording_is_said_once(drive, tmp_path):
    _, imu, gnss, truth = drive
    table = np.loadtxt(gnss, delimiter=",", skiprows=1)
    table[:, 4:] *= 3.6
    fast = recorded.write_rows(tmp_path / "fast.csv", "t_s,lat_deg,lon_deg,alt_m,vn,ve,vd", list(table.T))
    done = hnav("filter", imu, "--filter", "ins", "--gnss", fast, "--truth", truth, "--out", tmp_path / "out.csv")
    assert done.stderr.count("this looks like km/h") == 1
