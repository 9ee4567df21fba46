"""Integers of receivers in tables, whose names state no unit: converted where they are certain, refused where they are not."""

import numpy as np
import pytest

import recorded
from hnav.io.readers import read, read_aids
from hnav.io.recordings import RecordingError
from motion import tilted_motion

E7, MM = 1e7, 1e3
PLACE, VELOCITY, SIGMA = (48.1234567, 11.3456789, 520.345), (0.05, 0.06, -0.02), (1.5, 2.5, 0.2)
TIMES = np.arange(20.0)
NAV_PVT = "lat,lon,height,velN,velE,velD,hAcc,vAcc,sAcc"


def fixes(path, header, *scales, t="t_s"):
    values = [round(value * scale) if scale else value for value, scale in zip((*PLACE, *VELOCITY, *SIGMA), scales)]
    return recorded.write_rows(path, f"{t},{header}", [TIMES, *(np.full(len(TIMES), value) for value in values)])


@pytest.mark.parametrize(("header", "scales", "noted"), [
    (NAV_PVT, (E7, E7, *7 * [MM]), "lat in 1e-7 deg, lon in 1e-7 deg, height in mm"),
    ("pvt_" + NAV_PVT.replace(",", ",pvt_"), (E7, E7, *7 * [MM]), "pvt_height in mm"),
    (NAV_PVT, (0, 0, *7 * [MM]), "height in mm, velN in mm/s"),  # by pyubx2
    ("lat,lon,alt,vel_n_m_s,vel_e_m_s,vel_d_m_s,eph,epv,s", (E7, E7, MM, 0, 0, 0, 0, 0, 0), "lat in 1e-7 deg, lon in 1e-7 deg, alt in mm"),
])  # fmt: skip
def test_integers_of_a_receiver_are_converted(tmp_path, header, scales, noted):
    aids = read_aids(fixes(tmp_path / "fixes.csv", header, *scales))
    np.testing.assert_allclose(aids["position"].values[0], [*np.radians(PLACE[:2]), PLACE[2]], atol=1e-9)
    np.testing.assert_allclose(aids["velocity"].values[0], VELOCITY)
    np.testing.assert_allclose(aids["position"].sigma[0], [SIGMA[0], SIGMA[0], SIGMA[1]])
    assert "integers of a receiver: " in aids.notes[-1] and noted in aids.notes[-1]


def test_a_course_in_1e_5_deg(tmp_path):
    path = recorded.write_rows(
        tmp_path / "f.csv",
        "t_s,lat,lon,height,gSpeed,headMot",
        [TIMES, *np.outer([481234567, 113456789, 520345, 2000, 9000000], np.ones(20))],
    )
    np.testing.assert_allclose(read_aids(path)["velocity"].values[0, :2], [0, 2], atol=1e-9)


@pytest.mark.parametrize(
    ("header", "scales"), [("lat,lon,alt,hAcc,vAcc", (0, 0, 1, 1, 1)), ("lat,lon,alt,vn,ve,vd", (0, 0, 1, 1, 1, 1))]
)
def test_whole_meters_stay_what_they_are(tmp_path, header, scales):
    aids = read_aids(fixes(tmp_path / "fixes.csv", header, *scales))
    assert aids["position"].values[0, 2] == 520 and not aids.notes


def test_integers_that_may_be_in_two_units_are_refused_with_the_cure(tmp_path):
    path = fixes(tmp_path / "fixes.csv", "lat,lon,alt,vel_n,vel_e,vel_d", E7, E7, MM, MM, MM, MM)
    with pytest.raises(RecordingError, match=r"column vel_n holds whole numbers .* columns vn='vel_n \[mm/s\]'"):
        read_aids(path)
    aids = read_aids(path, columns={f"v{axis}": f"vel_{axis} [mm/s]" for axis in "ned"})
    np.testing.assert_allclose(aids["velocity"].values[0], VELOCITY)


def test_integers_that_may_be_in_two_units_cost_the_aids_alone(tmp_path):
    motion = tilted_motion(1).recording
    n = len(motion.t_s)
    columns = [motion.t_s, *recorded.columns(motion)[:6], *np.outer([481234567, 113456789, 5000], np.ones(n))]
    path = recorded.write_rows(tmp_path / "walk.csv", "t_s,gx,gy,gz,ax,ay,az,lat,lon,alt", columns)
    recording = read(path)
    assert len(recording.t_s) == n and not recording.aids
    assert [
        note for note in recording.origin.notes if note.startswith("positions were left out: the column alt holds whole numbers")
    ]
