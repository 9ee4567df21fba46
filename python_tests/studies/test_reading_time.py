"""The study of reading times writes files that are read whole, of the size that it says."""

import pytest

from hnav.io.readers import read, read_aids
from studies import reading


@pytest.mark.parametrize("format", reading.FORMATS)
def test_files_have_the_size_that_is_said_and_all_rows(tmp_path, format):
    file = tmp_path / "recording.txt"
    size, seconds = reading.seconds_for(file, format, 0.05)
    assert size == pytest.approx(0.05, rel=0.1) and seconds > 0
    lines = file.read_text().count(
        "ms:"
        if format == "serial"
        else "GPGGA"
        if format == "NMEA"
        else "\n"
        if format == "table"
        else "gyro"
        if format == "long"
        else "gx"
    )
    found = len(read_aids(file)["position"].t_s) if format == "NMEA" else len(read(file).t_s)
    assert found == lines - (format == "table")
