"""The table of importers: the text of each cell."""

import pytest

from hnav.fmi.fmus import fmu_path
from studies.importers import ImporterMissing, cell


def test_a_cell_says_what_came_of_an_archive(tmp_path, capsys):
    broken = tmp_path / "Broken.fmu"
    broken.write_bytes(b"no archive")
    assert cell("fmpy", fmu_path("Turntable", 2), 2, "CS") == "ok"
    assert cell("fmpy", broken, 2, "ME") == "fails"
    assert "Broken, FMI 2 ME, fmpy: " in capsys.readouterr().out
    assert cell("PyFMI", fmu_path("Ahrs", 3), 3, "CS") == "-"
    assert cell("OMSimulator", fmu_path("AhrsClocks", 3), 3, "CS") == "no clocks"


def test_an_importer_that_is_not_there_is_named(monkeypatch):
    monkeypatch.delenv("HNAV_PYFMI", raising=False)
    with pytest.raises(ImporterMissing, match="HNAV_PYFMI is not set"):
        cell("PyFMI", fmu_path("Turntable", 2), 2, "CS")
