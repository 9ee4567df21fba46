"""Tracks in files of other programs: the estimate is read back unchanged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import recorded
from command_line import hnav
from driven import as_recording
from hnav import Filter, Ins
from hnav.io.readers import read_aids
from hnav.io.trajectories import read_trajectory
from hnav.reports.comparison import compare
from hnav.reports.track_files import write_gpx, write_tum
from motion import tilted_motion
from studies.ins.vehicles import vehicle


@pytest.fixture(scope="module")
def run():
    samples, _ = vehicle("car", "industrial", 12, 60.0)
    return Ins("industrial").run_recording(as_recording(samples))


def test_a_navigation_is_read_back_from_tum(tmp_path, run):
    write_tum(tmp_path / "drive.tum", [run])
    back = read_trajectory(tmp_path / "drive.tum")
    known = np.isfinite(run.place).all(axis=1) & np.isfinite(run.q_nb).all(axis=1)
    np.testing.assert_array_equal(back.t_s, run.t_s[known])
    np.testing.assert_allclose(back.q_nb, run.q_nb[known], atol=1e-8)
    own = np.column_stack([run.t_s, run.place * (np.degrees([1, 1, 0]) + [0, 0, 1])])[known]
    table = recorded.write_rows(tmp_path / "own.csv", "t_s,lat_deg,lon_deg,alt_m", list(own.T))
    there = compare(read_trajectory(table), read_trajectory(table)).reference.position_m
    np.testing.assert_allclose(back.position_m, there, atol=1e-3)


def test_a_track_is_read_back_from_gpx(tmp_path, run):
    later = replace(run, t_s=run.t_s + 1.7e9)
    write_gpx(tmp_path / "drive.gpx", [later], "a <drive>")
    place = read_aids(tmp_path / "drive.gpx")["position"]
    rows = np.searchsorted(later.t_s, place.t_s - 1e-4)
    np.testing.assert_allclose(place.values[:, :2], later.place[rows, :2], atol=1e-10)
    np.testing.assert_allclose(place.values[:, 2], later.place[rows, 2], atol=1e-3)
    assert np.diff(place.t_s).min() > 0.19 and len(place.t_s) > 150
    # Times of no clock are left out, which leaves a track for maps alone.
    write_gpx(tmp_path / "drive.gpx", [run], "drive")
    assert "<time>" not in (tmp_path / "drive.gpx").read_text() and "<trkpt" in (tmp_path / "drive.gpx").read_text()


def test_the_suffix_says_what_is_written(tmp_path):
    recording = tilted_motion(15).recording
    path = recorded.house(tmp_path, recording)
    assert hnav("filter", path, "--out", tmp_path / "walk.tum").returncode == 0
    back, own = read_trajectory(tmp_path / "walk.tum"), Filter("ahrs").run_recording(recording)
    np.testing.assert_allclose(back.q_nb, own.q_nb[np.isfinite(own.q_nb).all(axis=1)], atol=1e-8)
    assert (back.position_m == 0).all()
    refused = hnav("filter", path, "--out", tmp_path / "walk.gpx")
    assert refused.returncode == 2 and "attitude filters have no track: add --filter ins" in refused.stderr
