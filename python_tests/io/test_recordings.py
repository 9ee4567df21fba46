"""Readers: right values are read, wrong ones are named by file, line and column."""

import numpy as np
import pytest

from hnav.io.readers import read
from hnav.io.readers.broad import find_trial, find_trials
from hnav.io.recordings import RecordingError

HEADER = "t_s,gx,gy,gz,ax,ay,az,mx,my,mz"
ROW = "0.00,0.1,0.2,0.3,0,0,-9.81,20,0,45"
NEXT = "0.01,0.1,0.2,0.3,0,0,-9.81,20,0,45"


@pytest.fixture
def csv(tmp_path):
    def write(*lines: str, name: str = "flight.csv"):
        path = tmp_path / name
        path.write_text("\n".join(lines) + "\n")
        return path

    return write


def test_a_csv_is_read_in_si_units(csv):
    recording = read(csv(HEADER, ROW, NEXT), mag_unit="uT")
    assert recording.name == "flight"
    np.testing.assert_allclose(recording.t_s, [0, 0.01])
    np.testing.assert_allclose(recording.rate_b_rad_s[0], [0.1, 0.2, 0.3])
    np.testing.assert_allclose(recording.field_b_tesla[0], [20e-6, 0, 45e-6])


@pytest.mark.parametrize("unit, factor", [("T", 1), ("uT", 1e-6), ("G", 1e-4), ("au", 5e-5)])
def test_the_unit_of_the_field_is_a_choice(csv, unit, factor):
    np.testing.assert_allclose(read(csv(HEADER, ROW), mag_unit=unit).field_b_tesla[0], np.array([20, 0, 45]) * factor)


def test_columns_may_stand_in_any_order_and_others_beside_them(csv):
    recording = read(csv("ax,ay,az,note,t_s,gx,gy,gz", "1,2,3,7,0,4,5,6"))
    np.testing.assert_allclose(recording.force_b_m_s2, [[1, 2, 3]])
    np.testing.assert_allclose(recording.rate_b_rad_s, [[4, 5, 6]])
    assert recording.field_b_tesla is None


def test_empty_cells_and_nan_are_missing_samples(csv):
    recording = read(csv(HEADER, ROW, "0.01,0.1,0.2,0.3,0,0,-9.81,,,", "0.02,nan,nan,nan,0,0,-9.81,1,2,3"))
    assert np.isnan(recording.field_b_tesla[1]).all()
    assert np.isnan(recording.rate_b_rad_s[2]).all()


@pytest.mark.parametrize("lines, named", [
    ((HEADER, ROW, "0.01,abc,0.2,0.3,0,0,-9.81,20,0,45"), "line 3, column gx: 'abc' is not a number"),
    ((HEADER, ROW, "0.01,0.1"), "line 3: 2 cells, the header has 10 columns"),
    ((HEADER, ROW, ROW), "line 3, column t_s: time 0 does not increase after 0"),
    ((HEADER, ROW, NEXT, ROW), "line 4, column t_s"),
    ((HEADER, ",0.1,0.2,0.3,0,0,-9.81,20,0,45"), "line 2, column t_s: a time is missing"),
    ((ROW, NEXT), "line 1: no header"),
    (("t_s,gx,gy,ax,ay,az", "0,1,2,3,4,5"), "line 1: the column gz is missing"),
    (("t_s,gx,gy,gz,ax,ay,az,mx,my", "0,1,2,3,4,5,6,7,8"), "line 1: the column mz is missing"),
    ((HEADER + ",gx", ROW + ",1"), "line 1: a column appears twice: gx: choose by its place, columns gx=2 or gx=11"),
    ((HEADER,), "no rows after the header"),
    (("",), "empty"),
])  # fmt: skip
def test_a_fault_is_named_by_file_line_and_column(csv, lines, named):
    path = csv(*lines)
    with pytest.raises(RecordingError) as error:
        read(path)
    assert "flight.csv" in str(error.value) and named in str(error.value)
    assert "\n" not in str(error.value)


def test_files_that_are_none_are_named(csv, tmp_path):
    for path, word in ((tmp_path / "nowhere.csv", "no such file"), (tmp_path / "picture.png", "no such file")):
        with pytest.raises(RecordingError, match=word):
            read(path)
    for name in ("broken.hdf5", "broken.mat"):
        with pytest.raises(RecordingError, match=name):
            read(csv("nothing of the kind", name=name))
    with pytest.raises(RecordingError, match="mag_unit = stone"):
        read(csv(HEADER, ROW), mag_unit="stone")
    with pytest.raises(RecordingError, match="no BROAD trials"):
        find_trials(tmp_path)
    with pytest.raises(RecordingError, match="no such folder"):
        find_trials(tmp_path / "nowhere")


def test_a_long_csv_is_read_in_a_moment(csv):
    rows = np.column_stack([np.arange(60000) / 285.7, np.ones((60000, 9))])
    path = csv(name="long.csv")
    np.savetxt(path, rows, delimiter=",", header=HEADER, comments="", fmt="%.9g")
    assert len(read(path).t_s) == 60000


def test_broad_trials_are_read_from_both_formats(broad_trials):
    names = {path.suffix: path for path in broad_trials.values()}
    for path in names.values():
        trial = read(path)
        n = len(trial.t_s)
        assert trial.rate_b_rad_s.shape == trial.force_b_m_s2.shape == trial.field_b_tesla.shape == (n, 3)
        assert trial.reference_q_nb.shape == (n, 4) and trial.movement.dtype == bool
        assert 1 / np.diff(trial.t_s).mean() == pytest.approx(285.7, abs=0.1)
        assert np.median(np.linalg.norm(trial.force_b_m_s2, axis=1)) == pytest.approx(9.81, abs=0.2)
        assert 2e-5 < np.median(np.linalg.norm(trial.field_b_tesla, axis=1)) < 8e-5
    number = next(iter(broad_trials))
    assert find_trial(next(iter(broad_trials.values())).parent, number) == broad_trials[number]
