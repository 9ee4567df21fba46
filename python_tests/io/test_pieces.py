"""Long tables in pieces: the same recording bit for bit, the same file of the command, and memory that does not grow."""

import tracemalloc

import numpy as np
import pandas as pd
import pytest

from command_line import hnav
from hnav.errors import HnavError
from hnav.filters import run_files
from hnav.filters.attitude_recording import LibraryRun
from hnav.filters.calibration import calibrate_magnetometer
from hnav.filters.options import Options
from hnav.filters.run_files import write_pieces
from hnav.io.readers import pieces, read
from hnav.io.readers.pieces import long_table
from hnav.io.recordings import ARRAYS, Recording, RecordingError
from hnav.io.sensors import Grade, write_sensor
from motion import tilted_motion

NAMES = ["t_s", "gx", "gy", "gz", "ax", "ay", "az", "mx", "my", "mz"]


@pytest.fixture(autouse=True)
def short(monkeypatch):
    """Pieces of 64 rows."""
    monkeypatch.setattr(pieces, "PIECE", 64)
    monkeypatch.setattr(run_files, "ROW_GROUP", 64)


@pytest.fixture(scope="module")
def frame() -> pd.DataFrame:
    """300 rows, with a field at every second."""
    data = tilted_motion(3).recording
    field = data.field_b_tesla.copy()
    field[1::2] = np.nan
    return pd.DataFrame(np.column_stack([data.t_s, data.rate_b_rad_s, data.force_b_m_s2, field]), columns=NAMES)


@pytest.fixture
def write(tmp_path):
    def written(frame: pd.DataFrame, **options) -> str:
        path = tmp_path / "long.csv"
        frame.to_csv(path, **{"index": False} | options)
        return str(path)

    return written


def assert_same(parts: list[Recording], whole: Recording) -> None:
    for name in ("t_s", *ARRAYS.values()):
        values = [getattr(part, name) for part in parts]
        if getattr(whole, name) is None:
            assert all(part is None for part in values)
        else:
            np.testing.assert_array_equal(np.concatenate(values), getattr(whole, name))
    assert all((part.name, part.origin) == (whole.name, whole.origin) for part in parts)


VARIANTS = {
    "house": ({}, {}),
    "decimal commas": ({"sep": ";", "decimal": ","}, {}),
    "another encoding": ({"encoding": "cp1252", "header": [*NAMES[:7], "mx (\u00b5T)", "my (\u00b5T)", "mz (\u00b5T)"]}, {}),
    "no header": ({"header": False}, {"columns": {name: str(i + 1) for i, name in enumerate(NAMES)}}),
    "units, axes and rate": ({}, {"gyro_unit": "deg/s", "axes": {"mag": "y,x,-z"}, "rate_hz": 30.0}),
    "blanks": ({"sep": " ", "na_rep": "nan"}, {}),
    "no field": ({"columns": NAMES[:7]}, {}),
}


@pytest.mark.parametrize("name", VARIANTS)
def test_pieces_together_are_the_recording(frame, write, name):
    form, options = VARIANTS[name]
    path = write(frame, **form)
    table = long_table(path, **options)
    assert table is not None and table.rows == len(frame)
    parts = list(table)
    assert [len(part.t_s) for part in parts] == [64, 64, 64, 64, 44]
    assert_same(parts, read(path, **options))
    assert_same(list(table), read(path, **options))


def test_instants_of_a_calendar_are_read_in_pieces(frame, write):
    stamps = pd.Timestamp("2026-03-29 00:59:59", tz="UTC") + pd.to_timedelta(frame["t_s"], unit="s")
    path = write(frame.assign(t_s=stamps.dt.strftime("%Y-%m-%d %H:%M:%S.%f")))
    assert_same(list(long_table(path)), read(path))


def test_what_is_corrected_is_corrected_in_every_piece(frame, write):
    path, data = write(frame), tilted_motion(3).recording
    found = calibrate_magnetometer(data.field_b_tesla * 1e6, data.force_b_m_s2, "uT", allow_hard_iron_only=1)
    iron = Grade("iron", {}, {"mag": found.correction})
    assert_same(list(long_table(path, corrected=iron.apply_to)), iron.apply_to(read(path)))


def twice(frame):
    return pd.concat([frame[:100], frame[99:]])


def back(frame):
    return frame.assign(t_s=np.where(np.arange(len(frame)) == 64, 0.6, frame["t_s"]))


@pytest.mark.parametrize(
    "spoil",
    [twice, back, lambda frame: frame.assign(gx=["x", *frame["gx"][1:]]), lambda frame: frame[:64]],
    ids=["rows twice", "back between two pieces", "no number", "one piece"],
)
def test_what_is_no_plain_table_is_read_as_a_whole(frame, write, spoil):
    assert long_table(write(spoil(frame))) is None


def test_other_files_are_read_as_a_whole(frame, write, tmp_path):
    assert long_table(write(frame), drop_repeats=True) is None
    assert long_table(write(frame, encoding="utf-16")) is None
    path = write(frame)
    with open(path, "a", encoding="utf-8") as file:
        file.write("3.0,0.1,0.2\n")
    assert long_table(path) is None
    with pytest.raises(RecordingError, match="line 302: 3 cells"):
        read(path)
    assert long_table(tmp_path) is None and long_table(tmp_path / "none") is None
    with pytest.raises(HnavError, match="hemisphere"):
        long_table(write(frame), "west")


def test_a_gap_longer_than_a_piece_is_found(frame, write, monkeypatch):
    monkeypatch.setattr(pieces, "PIECE", 256)
    many = pd.concat([frame] * 4, ignore_index=True)
    off = {name: np.where(many.index.to_series().between(200, 800), np.nan, many[name]) for name in NAMES[7:]}
    path = write(many.assign(**off, t_s=0.02 * np.arange(len(many))))
    (gap,) = (f for f in long_table(path).findings if f.code == "gaps")
    assert gap in read(path).check() and gap.sensor == "mag"


def test_findings_of_the_pieces_are_those_of_the_whole(frame, write):
    gap = frame.assign(t_s=frame["t_s"] + np.where(np.arange(len(frame)) >= 128, 7.0, 0.0))
    path = write(gap.assign(gx=57.3 * gap["gx"], gy=57.3 * gap["gy"], gz=57.3 * gap["gz"]))
    found = {(f.level, f.code, f.sensor) for f in long_table(path).findings if f.level != "note"}
    assert {("warning", "gaps", "gyro"), ("warning", "unit", "gyro")} <= found
    # A sensor without samples in one piece still has samples in the recording.
    silent = frame.assign(**{name: np.where(np.arange(len(frame)) < 130, np.nan, frame[name]) for name in NAMES[4:]})
    assert not {"no_samples", "absent"} & {f.code for f in long_table(write(silent)).findings}
    assert [f.code for f in long_table(write(frame.assign(ax=np.nan))).findings if f.level == "error"] == ["no_samples"]


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
@pytest.mark.parametrize("filter", ["ahrs", "hrekf"])
def test_the_command_writes_the_same_bytes(frame, write, tmp_path, monkeypatch, suffix, filter):
    monkeypatch.setattr(pieces, "PIECE", 128)
    if suffix == "parquet":
        pytest.importorskip("pyarrow", reason="pyarrow is not installed: no Parquet")
    path = write(frame.assign(t_s=frame["t_s"] + np.where(np.arange(len(frame)) >= 128, 7.0, 0.0)))
    data = tilted_motion(3).recording
    iron = calibrate_magnetometer(data.field_b_tesla, None, allow_hard_iron_only=1)
    write_sensor(tmp_path / "iron.json", {"mag": iron.correction})
    command = ("filter", path, "--filter", filter, "--sensor", tmp_path / "iron.json", "--out")
    said = []
    for name, answer in (("pieces", long_table), ("whole", lambda *_, **__: None)):
        monkeypatch.setattr("hnav.cli.recordings.long_table", answer)
        done = hnav(*command, tmp_path / f"{name}.{suffix}")
        assert done.returncode == 0, done.stderr
        counts = done.stdout.replace(name, "").partition("us/sample")
        said.append((counts[0].split("; ")[0], counts[2], done.stderr))
    assert (tmp_path / f"pieces.{suffix}").read_bytes() == (tmp_path / f"whole.{suffix}").read_bytes()
    assert said[0] == said[1] and "gap" in said[0][2]


def test_a_file_that_changes_meanwhile_leaves_the_old_output(frame, write, tmp_path):
    table, out = long_table(write(frame)), tmp_path / "out.csv"
    out.write_text("old")
    write(frame[:200])
    run = LibraryRun(Options("ahrs"))
    with pytest.raises(RecordingError, match="it changed while it was read"):
        write_pieces(out, (run.go_on(piece) for piece in table))
    assert out.read_text() == "old"


def peak_bytes(path: str, out) -> int:
    tracemalloc.start()
    try:
        run = LibraryRun(Options("ahrs", solver="closed_form"))
        write_pieces(out, (run.go_on(piece) for piece in long_table(path)))
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_memory_does_not_grow_with_the_table(frame, write, tmp_path, monkeypatch):
    monkeypatch.setattr(pieces, "PIECE", 512)
    monkeypatch.setattr(pieces, "BLOCK_BYTES", 2**14)
    peaks = []
    for copies in (4, 8, 24):  # the first loads modules
        many = pd.concat([frame.ffill()] * copies, ignore_index=True)
        peaks.append(peak_bytes(write(many.assign(t_s=0.01 * np.arange(len(many)))), tmp_path / "out.csv"))
    assert peaks[2] < 1.1 * peaks[1]


def test_a_device_that_begins_late_in_a_long_table_is_found(frame, write):
    """Behind the first piece, and behind all lines by which the header is found."""
    path = write(frame.assign(device=["A"] * 250 + ["B"] * 50))
    assert long_table(path) is None  # and hnav.read refuses it
    with pytest.raises(RecordingError, match=r"rows of 2 devices by the column device \(A, B\)"):
        read(path)
    assert long_table(write(frame.assign(device="A"))).rows == 300
