"""A recording in JSON whose logger was stopped in the midst of it is read up to there, and a note says so."""

import json

import numpy as np
import pytest

from hnav.io.readers import read
from hnav.io.recordings import RecordingError

ROWS = [
    {"t": 0.02 * i, "gyro": [0.1, 0.2, 0.3 + i], "acc": {"x": 0.5, "y": 0.25, "z": 9.75}, "of": 'a "]" in {'} for i in range(50)
]
COLUMNS = {name: [row[name] for row in ROWS] for name in ("t", "gyro")}
COLUMNS |= {"acc": [list(row["acc"].values()) for row in ROWS], "mag": [[20.0, 1.5, -44.25]] * 50}
WHOLE = {
    "rows": json.dumps(ROWS),
    "indented": json.dumps(ROWS, indent=2),
    "inside": json.dumps({"device": {"name": "watch"}, "samples": ROWS}),
    "lines": "\n".join(map(json.dumps, ROWS)),
}


@pytest.mark.parametrize("shape", WHOLE)
@pytest.mark.parametrize("share", (0.5, 0.61, 0.777, 0.9, 0.9999))
def test_what_is_complete_is_read_and_the_rest_is_noted(tmp_path, shape, share):
    path = tmp_path / "walk.json"
    text = WHOLE[shape][: int(share * len(WHOLE[shape]))]
    path.write_text(text)
    recording = read(path)
    complete = (text.replace(ROWS[0]["of"].replace('"', '\\"'), "").count("}") - (shape == "inside")) // 2
    assert len(recording.t_s) == complete > 20
    np.testing.assert_array_equal(recording.rate_b_rad_s[:, 2], 0.3 + np.arange(complete))
    assert np.isfinite(recording.force_b_m_s2).all()
    assert any("cut off" in note for note in recording.origin.notes)


def test_columns_that_are_complete_are_read(tmp_path):
    path, text = tmp_path / "walk.json", json.dumps(COLUMNS)
    path.write_text(text[:-40])
    recording = read(path)
    assert len(recording.t_s) == 50 and recording.field_b_tesla is None
    assert any("cut off" in note for note in recording.origin.notes)
    path.write_text(text[: text.index('"acc"') + 200])
    with pytest.raises(RecordingError, match="; the file was cut off$"):
        read(path)


@pytest.mark.parametrize("text", ('[{"t": 0}, }', '{"t": [0, 1', '[{"t": 1]', '{"a": 1, "b', "[{]"))
def test_what_holds_no_samples_is_refused(tmp_path, text):
    (tmp_path / "walk.json").write_text(text)
    with pytest.raises(RecordingError):
        read(tmp_path / "walk.json")


def test_a_fault_in_the_midst_is_no_end(tmp_path):
    lines = WHOLE["lines"].splitlines()
    (tmp_path / "walk.json").write_text("\n".join([*lines[:20], lines[20][:-8] + "?", *lines[21:]]))
    with pytest.raises(RecordingError, match="no JSON"):
        read(tmp_path / "walk.json")
