"""Errors of trajectories: those of evo, and clocks and frames that are found again."""

from __future__ import annotations

import json
import re
from pathlib import Path

import h5py
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import recorded
from browser import browse
from command_line import hnav
from hnav import HnavError
from hnav.cli.words import UsageError
from hnav.io.trajectories import read_trajectory
from hnav.reports.comparison import compare
from motion import tilted_motion
from studies.evo_peer import PAIRS, command_of_evo, motion, noisy, rows_of, tum

DEG = np.pi / 180


@pytest.mark.parametrize("pair", range(PAIRS))
def test_errors_are_those_of_evo(tmp_path, pair):
    """evo is under the GPL: a process of its own."""
    try:
        command_of_evo("ape")
    except UsageError as error:
        pytest.skip(str(error))
    for row in rows_of(pair, tmp_path):
        np.testing.assert_allclose(row.ours, row.evo, rtol=1e-6, atol=1e-6, err_msg=row.error)


@pytest.mark.parametrize("seed", range(5))
def test_clocks_off_by_3_s_and_frames_turned_by_40_deg_are_found(tmp_path, seed):
    t_s, attitude, position = motion(seed)
    turned, _ = noisy(seed, attitude, position)
    rng = np.random.default_rng(seed)
    world, body = (Rotation.from_rotvec(40 * DEG * axis / np.linalg.norm(axis)) for axis in rng.normal(size=(2, 3)))
    kept = slice(700, 5200)
    other = tum(
        tmp_path / "other.txt", t_s[kept] + 3, (world * turned * body)[kept], (1.5 * world.apply(position) + [5, 6, 7])[kept]
    )
    reference = read_trajectory(tum(tmp_path / "true.txt", t_s, attitude, position))
    found = compare(reference, read_trajectory(other), align=("clock", "world", "body", "scale"))
    assert float(found.found["clock"].split()[0]) == pytest.approx(-3, abs=5e-3)
    for name, turn in (("world", world.inv()), ("body", body.inv())):
        vector = np.array(re.search(r"\((.*)\)", found.found[name]).group(1).split(", "), float)
        assert np.degrees((Rotation.from_rotvec(vector, degrees=True).inv() * turn).magnitude()) < 0.1, name
    assert float(re.search(r"scaled by ([\d.]+)", found.found["place"]).group(1)) == pytest.approx(1 / 1.5, rel=1e-3)
    figures = {figure.name: figure.rms for figure in found.figures}
    assert figures["attitude"] < 0.8 and figures["position"] < 0.01
    # With one side alone, or none, they are as far off as they were turned.
    alone = {figure.name: figure.rms for figure in compare(reference, read_trajectory(other), align=("clock",)).figures}
    assert 20 < alone["attitude"] < 90
    with pytest.raises(HnavError, match="choose from clock, world, body, place, scale"):
        compare(reference, reference, align=("time",))


def test_a_recording_without_a_reference_is_named_as_one(tmp_path):
    files = [tum(tmp_path / "true.txt", *motion(1, 3)), recorded.house(tmp_path, tilted_motion(2).recording)]
    done = hnav("compare", *files)
    assert done.returncode == 2 and "house.csv: no attitude" in done.stderr and "hnav filter makes a table of it" in done.stderr


def test_the_same_trajectory_is_the_same_in_every_format(tmp_path):
    t_s, attitude, position = motion(1, 10)
    q = attitude.as_quat()
    euler = attitude.as_euler("ZYX", degrees=True)[:, ::-1]
    matrices = np.concatenate([attitude.as_matrix(), position[:, :, None]], axis=2).reshape(-1, 12)
    np.savetxt(tmp_path / "kitti.txt", matrices, fmt="%.15g")
    euroc = "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []"
    files = [
        tum(tmp_path / "tum.txt", t_s, attitude, position),
        recorded.write_rows(tmp_path / "euroc.csv", euroc, [1e9 * t_s, *position.T, *q[:, [3, 0, 1, 2]].T]),
        recorded.write_rows(tmp_path / "own.csv", "t_s,x,y,z,qx,qy,qz,qw", [t_s, *position.T, *q.T]),
        recorded.write_rows(tmp_path / "px4.csv", "time,x,y,z,q[0],q[1],q[2],q[3]", [t_s, *position.T, *q[:, [3, 0, 1, 2]].T]),
        recorded.write_rows(
            tmp_path / "angles.csv", "time,pos_x,pos_y,pos_z,roll_deg,pitch_deg,yaw_deg", [t_s, *position.T, *euler.T]
        ),
    ]
    reference = read_trajectory(files[0])
    for file in files[1:]:
        figures = {figure.name: figure.worst for figure in compare(reference, read_trajectory(file)).figures}
        assert figures.keys() >= {"attitude", "position", "position relative, 1 s"} and max(figures.values()) < 1e-4, file
    kitti = read_trajectory(tmp_path / "kitti.txt")
    np.testing.assert_allclose(kitti.position_m, position)
    np.testing.assert_array_equal(kitti.t_s, np.arange(len(t_s)))
    (tmp_path / "none.csv").write_text("t_s,a,b\n0,1,2\n1,1,2\n")
    with pytest.raises(HnavError, match="no attitude .* and no place"):
        read_trajectory(tmp_path / "none.csv")


def cut(trial: Path, folder: Path, rows: int) -> Path:
    """The first rows of a trial, as a trial of the same name."""
    path = folder / trial.name
    with h5py.File(trial) as whole, h5py.File(path, "w") as file:
        file.attrs.update(whole.attrs)
        for name, values in whole.items():
            file[name] = values[:rows]
    return path


def test_estimates_of_the_ahrs_against_a_trial_whatever_their_frame(tmp_path, broad_trials):
    path = cut(next(path for path in broad_trials.values() if path.suffix == ".hdf5"), tmp_path, 12_000)
    files = []
    for frame in ("enu", "ned"):
        files.append(tmp_path / f"{frame}.csv")
        assert hnav("filter", path, "--frame", frame, "--out", files[-1]).returncode == 0
    done = hnav("compare", path, *files, "--json", tmp_path / "c.json", "--report", tmp_path / "c.html")
    assert done.returncode == 0, done.stderr
    figures = json.loads((tmp_path / "c.json").read_text())
    assert figures["enu"]["attitude"]["rms"] == pytest.approx(figures["ned"]["attitude"]["rms"], rel=1e-3)
    assert figures["enu"]["attitude"]["nees"] == pytest.approx(figures["ned"]["attitude"]["nees"], rel=1e-3)
    assert 0.2 < figures["enu"]["attitude"]["rms"] < 5 and 0.03 < figures["enu"]["attitude"]["nees"] < 10
    assert (tmp_path / "c.html").stat().st_size > 1e6
    late = tmp_path / "late.csv"
    late.write_text("t_s,q0,q1,q2,q3\n1e6,1,0,0,0\n1000001,1,0,0,0\n")
    refused = hnav("compare", path, late)
    assert refused.returncode == 2 and "--align clock" in refused.stderr and refused.stderr.count("\n") == 1
    refused = hnav("compare", path, files[0], "--from", "1e9")
    assert refused.returncode == 2 and "--from 1e+09: enu has no row after it" in refused.stderr


def test_the_page_has_a_map_with_a_scale(tmp_path):
    """A circle of 50 m: a quarter of the map is less than 50 m, and the moment of the other figures is a dot on both tracks."""
    pytest.importorskip("plotly", reason="plotly is not installed: no report")
    from hnav.reports.comparison_page import write_comparison

    turn = np.linspace(0, 2 * np.pi, 300)
    place = 50 * np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    files = [tum(tmp_path / f"{name}.txt", 0.1 * np.arange(300), Rotation.from_rotvec(turn[:, None] * [0, 0, 1]), place + off)
             for name, off in (("true", 0), ("other", 1))]  # fmt: skip
    reference, other = map(read_trajectory, files)
    write_comparison([compare(reference, other)], tmp_path / "page.html")
    point = '<script>addEventListener("load", () => pointAt(10));</script></body></html>'
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    (tmp_path / "page.html").write_text(page.replace("</body></html>", point), encoding="utf-8")
    document, console, _ = browse(tmp_path / "page.html", tmp_path)
    assert not console
    assert re.search(r'<div class="bar" data-length="20 m" style="[^"]*width: \d+[.\d]*px', document)
    assert document.count('<div class="dot"') == 2
