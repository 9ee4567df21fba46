"""Solutions of RTKLIB give positions and velocities in UTC, with the sigmas and the quality that it states."""

import numpy as np
import pytest

from hnav import read
from hnav.io.readers import read_aids
from hnav.io.recordings import RecordingError

HEAD = """% program   : RTKLIB ver.2.4.3 b34
% pos mode  : kinematic
% ref pos   :  35.160000000  136.960000000    65.5000
%
% (lat/lon/height=WGS84/{datum},Q=1:fix,2:float,3:sbas,4:dgps,5:single,6:ppp,ns=# of satellites)
"""
PLACE = {
    "latitude(deg) longitude(deg) height(m)": "35.160001000 -136.960002000 66.5000",
    "latitude(d'\") longitude(d'\") height(m)": "35 09 36.00360 -136 57 36.00720 66.5000",
    "e-baseline(m) n-baseline(m) u-baseline(m)": "3.0000 4.0000 1.0000",
}
USUAL = "latitude(deg) longitude(deg) height(m)"
SIGMAS = {"e": "sde(m) sdn(m) sdu(m) sden(m) sdnu(m) sdue(m)", "l": "sdn(m) sde(m) sdu(m) sdne(m) sdeu(m) sdun(m)"}
TIMES = {"calendar": "2021/05/01 00:00:{:06.3f}", "week": "2155 {:.3f}"}
BEGIN_S = 1619827200.0


def solution(tmp_path, coordinates=USUAL, clock="GPST", times="calendar", mark=" ", velocity=False, datum="ellipsoidal"):
    sigmas = "0.0200 0.0100 0.0300" if coordinates[0] == "e" else "0.0100 0.0200 0.0300"
    names = f"{coordinates} Q ns {SIGMAS[coordinates[0]]} age(s) ratio" + (
        " vn(m/s) ve(m/s) vu(m/s) sdvn sdve sdvu" if velocity else ""
    )
    rows = []
    for k in range(20):
        time = TIMES[times].format(0.2 * k + (518400 if times == "week" else 0))
        behind = f"{1 if k < 15 else 5} 9 {sigmas} 0.001 0.002 0.003 0.00 999.9" + (
            " 1.0 2.0 0.5 0.05 0.06 0.07" if velocity else ""
        )
        rows.append(mark.join(f"{time} {PLACE[coordinates]} {behind}".split()))
    path = tmp_path / "rover.pos"
    path.write_text(HEAD.format(datum=datum) + f"%  {mark.join([clock, *names.split()])}\n" + "\n".join(rows) + "\n")
    return path


@pytest.mark.parametrize("coordinates", [name for name in PLACE if name.startswith("lat")])
@pytest.mark.parametrize("mark", [" ", ",", "\t"])
@pytest.mark.parametrize(
    "clock, times, late_s",
    [("GPST", "calendar", -18), ("GPST", "week", -18), ("UTC", "calendar", 0), ("JST", "calendar", -32400)],
)
def test_positions_have_their_sigmas_and_their_utc(tmp_path, coordinates, mark, clock, times, late_s):
    aids = read_aids(solution(tmp_path, coordinates, clock, times, mark))
    position = aids["position"]
    np.testing.assert_allclose(position.t_s, BEGIN_S + late_s + 0.2 * np.arange(20))
    np.testing.assert_allclose(np.degrees(position.values[:, :2]), [[35.160001, -136.960002]] * 20, rtol=0, atol=1e-9)
    np.testing.assert_allclose(position.values[:, 2], 66.5)
    np.testing.assert_allclose(position.sigma, [[0.01, 0.02, 0.03]] * 20)
    assert "rover.pos: positions by quality: fix 15, single 5" in aids.notes and "velocity" not in aids
    assert (f"rover.pos: times of {clock} were converted to UTC" in aids.notes) == (clock != "UTC")


def test_a_baseline_begins_at_the_base(tmp_path):
    path = solution(tmp_path, "e-baseline(m) n-baseline(m) u-baseline(m)")
    position = read_aids(path)["position"]
    latitude, longitude, height = position.values[0]
    np.testing.assert_allclose(np.degrees(latitude) - 35.16, 4 / 110_945, rtol=1e-3)
    np.testing.assert_allclose(np.degrees(longitude) - 136.96, 3 / 91_130, rtol=1e-3)
    assert height == pytest.approx(66.5, abs=1e-4) and position.sigma[0].tolist() == [0.01, 0.02, 0.03]
    path.write_text(path.read_text().replace("% ref pos", "% rover"))
    with pytest.raises(RecordingError, match="a baseline, and not the place of its base.*Lat/Lon/Height"):
        read_aids(path)
    path.write_text(path.read_text().replace("e-baseline(m) n-baseline(m) u-baseline(m)", "x-ecef(m) y-ecef(m) z-ecef(m)"))
    with pytest.raises(RecordingError, match="holds x-ecef.*Lat/Lon/Height"):
        read_aids(path)


def test_velocities_point_down_and_heights_may_be_above_the_sea(tmp_path):
    aids = read_aids(solution(tmp_path, velocity=True, datum="geodetic"))
    np.testing.assert_allclose(aids["velocity"].values, [[1, 2, -0.5]] * 20)
    np.testing.assert_allclose(aids["velocity"].sigma, [[0.05, 0.06, 0.07]] * 20)
    assert aids["position"].above_sea and not read_aids(solution(tmp_path))["position"].above_sea


def test_rows_without_a_header_are_those_of_emlid_and_a_row_that_was_cut_off_is_none(tmp_path):
    path = solution(tmp_path)
    rows = "".join(line for line in path.read_text().splitlines(True) if line[0] != "%")
    path.write_text(rows[:-40])
    aids = read_aids(path)
    assert len(aids["position"].t_s) == 19 and "rover.pos: rows that were cut off: 1" in aids.notes
    with pytest.raises(RecordingError, match="satellites alone.*--gnss"):
        read(path)
    path.write_text(rows.replace(" 35.160001000", " 35.160001x00", 1))
    with pytest.raises(RecordingError, match="no header|no solution of RTKLIB"):
        read_aids(path)
    path.write_text(solution(tmp_path).read_text().split("2021/05/01")[0])
    with pytest.raises(RecordingError, match="no row of a solution"):
        read_aids(path)
