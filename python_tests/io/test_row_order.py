"""Tables whose rows stand in another order than their times, and rows that share one."""

import numpy as np
import pandas as pd
import pytest

from hnav.io.readers import read
from hnav.io.readers.row_order import by_time
from hnav.io.recordings import Recording, RecordingError

HEADER = "t_s,gx,gy,gz,ax,ay,az,lat_deg,lon_deg,alt_m"
RNG = np.random.default_rng(3)
IMU = [(i / 100, *RNG.normal(0, 0.01, 3), *(RNG.normal(0, 0.1, 3) + [0, 0, 9.8])) for i in range(400)]
FIXES = [(i / 5, 48 + 1e-6 * i, 11.5, 500.0) for i in range(20)]


def written(path, rows):
    """rows: times and cells, those of a fix with four; in this order."""
    cells = [(*row, *3 * ("",)) if len(row) == 7 else (row[0], *6 * ("",), *row[1:]) for row in rows]
    lines = [",".join(map(str, row)) for row in cells]
    path.write_text("\n".join([HEADER, *lines]) + "\n")
    return path


def same(one, other):
    np.testing.assert_array_equal(one.samples("gyro")[0], other.samples("gyro")[0])
    np.testing.assert_array_equal(one.samples("gyro")[1], other.samples("gyro")[1])
    np.testing.assert_array_equal(one.aids["position"].t_s, other.aids["position"].t_s)
    np.testing.assert_array_equal(one.aids["position"].values, other.aids["position"].values)


def sorted_drive(tmp_path):
    between = [(t + 0.004, *cells) for t, *cells in FIXES]
    return read(written(tmp_path / "sorted.csv", sorted(IMU + between))), between


def test_rows_in_the_order_of_arrival_are_those_in_the_order_of_time(tmp_path):
    plain, between = sorted_drive(tmp_path)
    arrived = sorted(IMU + between, key=lambda row: row[0] + (0.8 if len(row) == 4 else 0.0))
    data = read(written(tmp_path / "arrived.csv", arrived))
    same(data, plain)
    (finding,) = [one for one in data.check() if one.code == "clock"]
    moved = sum(row[0] < max(r[0] for r in arrived[:i]) for i, row in enumerate(arrived) if i)
    assert f"{moved} rows stood behind later ones" in finding.message and "received_s" in finding.advice
    assert not [one for one in plain.check() if one.code == "clock"]


def test_rows_of_one_stamp_that_fill_different_cells_are_one_instant(tmp_path):
    """They were spread over half an interval: a fix of 0.2 s was stamped 0.205 s."""
    for first in (IMU + FIXES, FIXES + IMU):
        data = read(written(tmp_path / "shared.csv", sorted(first, key=lambda row: row[0])))
        np.testing.assert_array_equal(data.t_s, [row[0] for row in IMU])
        np.testing.assert_array_equal(data.aids["position"].t_s, [row[0] for row in FIXES])
        assert not [one for one in data.check() if one.code == "clock"] and not data.origin.notes


def test_inertial_rows_that_share_whole_milliseconds_are_spread_beside_a_fix(tmp_path):
    fast = [(round(0.0005 * i - 1e-6, 3), *row[1:]) for i, row in enumerate(IMU)]
    data = read(written(tmp_path / "fast.csv", sorted(fast + [(0.1, *FIXES[0][1:])], key=lambda row: row[0])))
    assert len(data.samples("gyro")[0]) == len(IMU) and data.aids["position"].t_s == pytest.approx(0.1)
    assert np.diff(data.samples("gyro")[0]).max() < 0.001


def test_rows_in_another_order_with_losses_are_sorted(tmp_path):
    kept = [row for i, row in enumerate(IMU) if i % 17 not in (3, 4)]
    swapped = kept.copy()
    swapped[50], swapped[51] = swapped[51], swapped[50]
    data, plain = read(written(tmp_path / "swapped.csv", swapped)), read(written(tmp_path / "kept.csv", kept))
    np.testing.assert_array_equal(data.t_s, plain.t_s)
    np.testing.assert_array_equal(data.rate_b_rad_s, plain.rate_b_rad_s)
    assert any("a row stood behind later ones" in note for note in data.origin.notes)


def test_a_clock_that_was_set_back_is_no_order_of_arrival(tmp_path):
    plain, between = sorted_drive(tmp_path)
    rows = [(t - (0.5 if t > 2 else 0.0), *cells) for t, *cells in sorted(IMU + between)]
    data = read(written(tmp_path / "back.csv", rows))
    assert any("set back once" in note for note in data.origin.notes)
    np.testing.assert_array_equal(data.samples("gyro")[1], plain.samples("gyro")[1])
    hopeless = [(RNG.uniform(0, 4), *row[1:]) for row in IMU]
    with pytest.raises(RecordingError, match="does not increase"):
        read(written(tmp_path / "none.csv", hopeless))


def test_rows_in_no_order_are_refused_with_the_line_that_sorts_them():
    """The jumps between them were taken for intervals, and seconds for milliseconds."""
    frame = pd.DataFrame(IMU, columns=HEADER.split(",")[:7]).rename(columns={"t_s": "time"})
    shuffled = frame.assign(time=10 * frame.time).sample(frac=1, random_state=1)
    with pytest.raises(
        RecordingError, match=r'does not increase after .*; sort the rows by it, in pandas sort_values\("time"\)$'
    ):
        Recording.from_dataframe(shuffled)
    data = Recording.from_dataframe(shuffled.sort_values("time"))
    np.testing.assert_allclose(data.t_s, 10 * frame.time)
    np.testing.assert_array_equal(data.rate_b_rad_s[:, 0], frame.gx)


def test_what_is_in_order_stays_as_it_is():
    values = {"t_s": np.arange(5.0), "gx": np.array([1, np.nan, 2, np.nan, 3])}
    assert by_time(values) == (values, ())


@pytest.mark.parametrize("late", [1, 5])
def test_packets_that_come_twice_and_in_another_order_are_those_that_were_sent(tmp_path, late):
    """Of a link without order, such as UDP: some rows are lost, others come again after some rows, or before the row ahead of them."""
    sent = [row for i, row in enumerate(IMU) if i % 37 != 5]
    plain = read(written(tmp_path / "sent.csv", sent))
    arrived = list(sent)
    for i in range(300, 0, -60):
        arrived.insert(i + late, arrived[i])
    for i in range(20, 380, 45):
        arrived[i], arrived[i + 1] = arrived[i + 1], arrived[i]
    data = read(written(tmp_path / "arrived.csv", arrived))
    np.testing.assert_array_equal(data.samples("gyro")[0], plain.samples("gyro")[0])
    np.testing.assert_array_equal(data.samples("accel")[1], plain.samples("accel")[1])
    said = " ".join(one.message for one in data.check() if one.code == "clock")
    assert "5 rows came twice, and were used once" in said and "rows stood behind later ones" in said
