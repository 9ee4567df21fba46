"""The comparison of filters on flights of the F-4C."""

import pytest

from command_line import answered
from hnav.systems.aircraft import models_folder, read_aircraft
from studies.command import main_of
from studies.ins_error_table import FAULT, ORACLE, OURS, PAPER, alarms, compare

main = main_of("ins_error_table")

LONGITUDINAL = models_folder() / "f4c_longitudinal.json"
LATERAL = models_folder() / "f4c_lateral.json"


@pytest.mark.parametrize("path", [LONGITUDINAL, LATERAL], ids=lambda p: p.stem)
def test_the_augmented_filter_with_joint_hypotheses_beats_the_paper_and_comes_near_the_oracle(path):
    aircraft = read_aircraft(path)
    flight, results = compare(aircraft, 200, 1, (PAPER, OURS))
    ours, paper, oracle = (results[n].rmse(FAULT).mean(axis=0) for n in (OURS, PAPER, ORACLE))
    assert (ours < paper).all()
    assert (ours / oracle).max() < 1.13 and (ours / oracle).mean() < 1.06
    assert 0.9 < results[OURS].nees[:, 30:80].mean() / 4 < 1.1
    assert results[OURS].nees[:, FAULT].mean() / 4 < 1.3
    a = alarms(aircraft, flight, results[OURS])
    assert (a.within_10.dropna() > 0.95).all() and (a.false_per_1000 < 1).all()


def test_the_tables_print_themselves():
    done = answered(main, "--runs", 3)
    assert done.returncode == 0, done.stderr
    assert "RMSE in the fault window" in done.stdout and "oracle" in done.stdout and "false alarms per 1000" in done.stdout
    done = answered(main, "--runs", 3, "--settings", 1)
    assert done.returncode == 0 and "of 1 settings" in done.stdout
