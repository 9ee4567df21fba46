"""Interrupted commands: a fixed small sample of the study, and that it would notice."""

import tempfile
import time

import pytest

from checkout import built_system
from command_line import answered
from hnav.filters import run_files
from studies.command import main_of
from studies.interrupted import study as commands
from studies.interrupted.study import FULL, KILLED, NEW, NOT_WHOLE, OLD, READ_ONLY, interrupt, table

main = main_of("interrupted")

KILLS = {"simulate": 2, "filter": 2, "montecarlo": 1, "report": 2}


@pytest.fixture(autouse=True)
def built(monkeypatch):
    built_system("turntable")
    monkeypatch.setattr(tempfile, "tempdir", None)
    monkeypatch.setattr(commands, "ROWS", 1000)


@pytest.mark.parametrize("name", ["simulate", "filter", "montecarlo", pytest.param("report", marks=pytest.mark.slow)])
def test_a_command_that_is_interrupted_leaves_the_old_output_or_the_new_one(name, tmp_path, monkeypatch):
    monkeypatch.setattr(commands, "RUNS", 2)
    if name != "report":
        monkeypatch.setattr(commands, "prepare", lambda folder, run: None)
    if name == "montecarlo":
        pytest.importorskip("pyarrow", reason="pyarrow is not installed: no Parquet")
    (trial,) = interrupt(KILLS[name], 1, tmp_path, [name])
    assert trial.faults == []
    assert trial.found[KILLED].total() >= KILLS[name] and set(trial.found[KILLED]) <= {OLD, NEW, NOT_WHOLE}
    assert trial.found[FULL] == trial.found[READ_ONLY] == {OLD: 1}
    assert trial.resumed_equal == trial.resumed and (trial.resumed == KILLS[name] or name != "montecarlo")
    assert table([trial]).row_count == 3


@pytest.mark.slow
def test_a_command_that_writes_bit_by_bit_is_found_out(tmp_path, monkeypatch):
    def write_slowly(contents):
        for path, pieces in contents.items():
            text = b"".join(pieces)
            with path.open("wb") as file:
                for part in range(10):
                    file.write(text[part * len(text) // 10 : (part + 1) * len(text) // 10])
                    file.flush()
                    time.sleep(0.05)  # in all longer than the rest of the command

    monkeypatch.setattr(run_files, "write_files", write_slowly)
    monkeypatch.setattr(commands, "prepare", lambda folder, run: None)
    (trial,) = interrupt(4, 1, tmp_path, ["filter"])
    assert trial.found[KILLED]["fault"] > 0
    assert "filter, killed: out.csv: neither the old output nor the new one" in trial.faults
    assert any(fault.startswith("filter, full disk") for fault in trial.faults)


def test_the_command_wants_a_kill():
    done = answered(main, "--kills", "0")
    assert done.returncode == 2 and "--kills" in done.stderr
