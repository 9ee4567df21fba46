"""Lines that arrive become rows: formats, units, clocks, and counts of the lines that are left out."""

from __future__ import annotations

import time

import numpy as np
import pytest

from hnav.io.live_lines import LiveLines
from hnav.io.live_sources import Chunk, address_of
from hnav.io.readers.streams import Wishes
from hnav.io.recordings import RecordingError

HEADER = "t_s,gx,gy,gz,ax,ay,az,mx,my,mz"


def taken(
    *parts: str | bytes, connections: tuple[int, ...] = (), aids: bool = False, **wishes: object
) -> tuple[np.ndarray, LiveLines]:
    """The rows of texts that arrived one after the other."""
    lines = LiveLines(Wishes(**wishes), aids)
    chunks = [
        Chunk(time.monotonic(), part.encode() if isinstance(part, str) else part, number)
        for part, number in zip(parts, connections or [1] * len(parts))
    ]
    return lines.take(chunks, ending=True), lines


@pytest.mark.parametrize(
    "text",
    [
        "t_ms,gx (deg/s),gy (deg/s),gz (deg/s),ax (g),ay (g),az (g)\n500,180,0,90,0,0,1\n",
        "time_ms;GyroX [deg/s];GyroY [deg/s];GyroZ [deg/s];AccX [g];AccY [g];AccZ [g]\n500,0;180,0;0,0;90,0;0,0;0,0;1,0\n",
        "t_ms gx_dps gy_dps gz_dps ax_g ay_g az_g\n500 180 0 90 0 0 1\n",
        '{"t_ms": 500, "gyro_dps": [180, 0, 90], "acc_g": {"x": 0, "y": 0, "z": 1}}\n',
    ],
)
def test_formats(text):
    units = {"gyro_unit": "deg/s", "accel_unit": "g"} if text.startswith("{") else {}
    rows, lines = taken(text, **units)
    assert np.allclose(rows[0, :7], [0.5, np.pi, 0, np.pi / 2, 0, 0, 9.80665]) and np.isnan(rows[0, 7:]).all()
    assert lines.counts["rows"] == 1 and lines.counts["no sample"] == 0


def test_sentences_of_vectornav():
    """Field in gauss, force, rate; one whose checksum is wrong is no sample."""
    sentence = "$VNMAR,+0.2500,-0.1000,+0.4000,+0.100,-0.200,-9.800,+0.010000,-0.020000,+0.030000*6F\r\n"
    expected = [0.01, -0.02, 0.03, 0.1, -0.2, -9.8, 2.5e-5, -1e-5, 4e-5]
    rows, lines = taken(sentence, sentence.replace("9.8", "8.8"), sentence, rate_hz=40.0)
    np.testing.assert_allclose(rows, [[0, *expected], [0.025, *expected]])
    assert lines.counts["no sample"] == 1
    rows, _ = taken(f"7.5 {sentence}7.6 {sentence}")
    np.testing.assert_allclose(rows, [[7.5, *expected], [7.6, *expected]])
    with pytest.raises(RecordingError, match="the column t_s is missing.*or give rate_hz"):
        taken(sentence)


def test_numbers_without_a_header():
    rows, lines = taken("0,1,2,3,4,5,6\n0.01,1,2,3,4,5,6\n")
    assert rows[1, 0] == 0.01 and "no header: taken for t,gx,gy,gz,ax,ay,az in SI units" in lines.notes
    places = {role: str(i) for i, role in enumerate(("ax", "ay", "az", "gx", "gy", "gz"), 2)}
    rows, _ = taken("7 1 2 3 4 5 6\n", columns={"t_s": "1", **places})
    assert rows[0, :7].tolist() == [7, 4, 5, 6, 1, 2, 3]
    with pytest.raises(RecordingError, match="the source: no line is a sample, the first is 1,2,3: write t_s,gx,gy"):
        taken("1,2,3\n")


def test_times_without_a_header_may_be_in_milliseconds_and_rates_in_a_unit_that_is_none():
    rows, lines = taken("".join(f"{10 * k},1,2,3,4,5,6\n" for k in range(60)))
    assert np.allclose(rows[:, 0], 0.01 * np.arange(60)) and "time: ms by its intervals" in lines.notes
    with pytest.raises(RecordingError, match="the unit 'furlong/s' of the column gy .furlong/s. is not supported"):
        taken("t_s,gx [deg/s],gy [furlong/s],gz [deg/s],ax,ay,az\n0,1,2,3,4,5,6\n")


def test_lines_of_one_sensor_each_are_rows_side_by_side_or_refused():
    text = "".join(
        f'{{"t": {0.01 * k}, "sensor": "{name}", "x": {v}, "y": 2, "z": 3}}\n'
        for k in range(3)
        for v, name in enumerate(("gyroscope", "accelerometer", "magnetometer"))
    )
    rows, lines = taken(text, mag_unit="T")
    assert len(rows) == 9 and lines.counts["late"] == 0 and (np.diff(rows[:, 0]) > 0).all()
    assert [np.flatnonzero(np.isfinite(row)).tolist() for row in rows[:3]] == [[0, 1, 2, 3], [0, 4, 5, 6], [0, 7, 8, 9]]
    long = "time,sensor,x,y,z\n" + "".join(f"{k},gyro,1,2,3\n{k},acc,1,2,3\n" for k in range(30))
    with pytest.raises(RecordingError, match="the source: each line is of one sensor: write t_s,gx"):
        taken(long)


def test_axes_rate_and_repeats():
    text = f"{HEADER}\n" + "".join(f"{9 - i},{i},2,3,0,0,9.8,{i // 2},5,6\n" for i in range(4))
    rows, lines = taken(text, rate_hz=100.0, axes={"mag": "y,x,-z"}, drop_repeats=True, mag_unit="uT")
    assert rows[:, 0].tolist() == [0, 0.01, 0.02, 0.03]
    assert np.allclose(rows[0, 7:], [5e-6, 0, -6e-6]) and np.isnan(rows[1, 7:]).all() and rows[2, 8] == pytest.approx(1e-6)
    assert np.isnan(rows[1, 4]) and rows[1, 1] == 1


def test_lines_are_put_together_within_a_connection_alone():
    row = "0.{},0,0,0,0,0,9.8,1,2,3\n"
    rows, lines = taken(f"{HEADER}\n" + row.format(1)[:9], row.format(1)[9:] + "0.15,0,", row.format(2), connections=(1, 1, 2))
    assert rows[:, 0].tolist() == [0.1, 0.2] and lines.counts["cut off"] == 1


def test_garbage_is_counted_and_not_shown_as_it_is():
    rows, lines = taken(
        f"{HEADER}\n0,1,2,3,4,5,6,7,8,9\n", b"\x1b[31m\xff\n", "1,x,2,3,4,5,6,7,8,9\n{\n[]\n1,2\n,,,\n1,inf,2,3,4,5,6,7,8,9\n"
    )
    assert len(rows) == 1 and lines.counts["no sample"] == 7 == lines.counts["lines"] - 2
    assert not any("\x1b" in note for note in lines.notes)
    with pytest.raises(RecordingError, match="no line is a sample, the first is a line without end"):
        taken(b"x" * 70_000)


def rows_of(stamps: list[float]) -> tuple[np.ndarray, LiveLines]:
    return taken(f"{HEADER}\n" + "".join(f"{t!r},{i},2,3,4,5,6,7,8,9\n" for i, t in enumerate(stamps)))


def test_clocks_that_are_set():
    rows, lines = rows_of([0, 0.01, 0.01, 0.005, 0.02, -90, -89.99, 1e9, 1e9 + 0.01, 0.5])
    assert lines.counts["late"] == 2 and lines.counts["clock set"] == 3 and lines.counts["stamps mended"] == 0
    assert (np.diff(rows[:, 0]) > 0).all() and rows[-1, 0] < 0.1 and lines.counts["rows"] == 8
    assert len([note for note in lines.notes if note.startswith("the clock of the source was set by")]) == 3


@pytest.mark.parametrize("wrong", [7.5, -3.0, 1e300, -1e300, 1e18])
def test_a_single_wrong_stamp_lies_between_its_neighbours(wrong):
    rows, lines = rows_of([0, 0.01, 0.02, wrong, 0.04, 0.05])
    assert np.allclose(rows[:, 0], [0, 0.01, 0.02, 0.03, 0.04, 0.05]) and rows[:, 1].tolist() == [0, 1, 2, 3, 4, 5]
    assert lines.counts["stamps mended"] == 1 and lines.counts["clock set"] == 0


def test_a_gap_in_a_recording_that_is_sent_at_once_stays():
    rows, lines = rows_of([0, 0.01, 30, 30.01, 30.02])
    assert rows[:, 0].tolist() == [0, 0.01, 30, 30.01, 30.02] and lines.counts["clock set"] == 0


def test_a_source_without_a_sensor_says_which():
    with pytest.raises(RecordingError, match="the column ax is missing"):
        taken("t_s,gx,gy,gz,mx,my,mz\n0,1,2,3,4,5,6\n")
    with pytest.raises(RecordingError, match="t_s is missing.*rate_hz"):
        taken("gx,gy,gz,ax,ay,az\n1,2,3,4,5,6\n")


def test_what_aids_goes_into_the_next_row_unless_its_time_goes_on():
    gga, rmc = (
        "$GPGGA,120000,4800.0000000,N,01130.0000000,E,1,8,1.0,500.0,M,46.0,M,,*",
        "$GPRMC,120000,A,4800.0,N,01130.0,E,19.438445,90.0,010126,,*",
    )
    text = f"{HEADER},lat,lon,alt,speed,course,pressure\n"
    imu = "{},1,2,3,4,5,6,,,,,,,,,\n"
    fix = "{},,,,,,,,,,47,{},400,-1,,1013.25\n"
    rows, lines = taken(
        text + fix.format("", 9) + imu.format(1) + fix.format(1.004, 10) + imu.format(1.01) + fix.format(1e9, 11) + f"{gga}71\n{gga}70\n{rmc}2E\n$GPGSV,1,1,00*79\n"
        + imu.format(1.02) + imu.format(1.03) + '{"speed": 10, "course": 180}\n' + imu.format(1.04), aids=True,
    )  # fmt: skip
    column = dict(zip(lines.columns, rows.T))
    assert column["t_s"].tolist() == [1, 1.004, 1.01, 1.02, 1.03, 1.04]
    assert column["lon_deg"].tolist()[:2] == [9, 10] and np.isnan(column["lon_deg"][2]) and column["lon_deg"][3] == 11
    # The sentence comes after the fix that has the first row; its checksum is wrong once.
    assert column["lon_deg"][4] == pytest.approx(11.5) and column["alt_m"][4] == pytest.approx(546) and column["sigma_v"][4] == 3
    assert column["vn"][3] == pytest.approx(0, abs=1e-9) and column["ve"][3] == pytest.approx(10)
    assert column["vn"][5] == pytest.approx(-10) and np.isnan(column["vn"][[0, 1, 2, 4]]).all()
    assert column["pressure_pa"][0] == pytest.approx(101325) and np.isnan(column["speed_m_s"]).all()
    assert lines.counts["no sample"] == 1 and lines.counts["other sentences"] == 1 and lines.counts["clock set"] == 0


def test_a_fix_that_is_repeated_is_none_and_without_rows_the_oldest_are_late():
    text = f"{HEADER},lat,lon,alt\n" + "".join(f"{0.01 * i},1,2,{i},4,5,6,,,,48,{11 + i // 3},500\n" for i in range(6))
    rows, lines = taken(text, aids=True, drop_repeats=True)
    assert np.isfinite(rows[:, lines.columns.index("lat_deg")]).tolist() == [True, False, False, True, False, False]
    _, lines = taken(text + ",,,,,,,,,,48,11,500\n" * 70, aids=True)
    assert lines.counts["late"] == 6


def test_addresses():
    assert address_of("udp://:5") == ("", 5) and address_of("tcp://[::1]:80") == ("::1", 80)
    with pytest.raises(ValueError, match="write udp://HOST:PORT"):
        address_of("udp://127.0.0.1:x")
