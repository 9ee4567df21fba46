"""The study of the checks counts what they say, and its recordings are what they are called."""

import numpy as np
import pytest

from hnav import Recording
from hnav.units import G_M_S2
from studies.plausibility import study as program
from studies.plausibility.good import MOTIONS, good_recording
from studies.plausibility.study import FAULTS


@pytest.fixture(scope="module")
def held() -> Recording:
    return good_recording("hand", "industrial", 3, duration_s=20)


def test_good_recordings_hold_the_earth_and_rates_of_their_own():
    for motion in MOTIONS:
        recording = good_recording(motion, "tactical", 1, duration_s=15)
        forces, fields = (np.linalg.norm(recording.samples(sensor)[1], axis=1) for sensor in ("accel", "mag"))
        assert np.median(forces) == pytest.approx(G_M_S2, abs=2)
        assert 30e-6 < np.median(fields) < 70e-6
        assert (np.abs(recording.rate_b_rad_s).max() > 0.1) == (motion != "still")
        again = good_recording(motion, "tactical", 1, duration_s=15)
        np.testing.assert_array_equal(again.force_b_m_s2, recording.force_b_m_s2)


def test_outcomes_are_named_said_or_silent(held):
    assert list(program.outcomes(FAULTS["force in g"], [held, held])) == ["named", "named"]
    without = Recording("no field", held.t_s, held.rate_b_rad_s, held.force_b_m_s2)
    mild = program.Fault(lambda r: r, "accel", "unit", "g")
    assert list(program.outcomes(mild, [without])) == ["silent"]
    assert list(program.outcomes(mild, [FAULTS["force in mg"].make(held)])) == ["said"]


def test_the_tables_have_a_row_for_each_motion_and_fault(held, monkeypatch):
    monkeypatch.setattr(program, "FAULTS", {name: FAULTS[name] for name in ("force in g", "time in ms")})
    alarm = program.alarm_table({"hand": [[], FAULTS["force in g"].make(held).check()]})
    assert [list(column.cells) for column in alarm.columns] == [["hand"], ["2"], ["1"], ["accel unit 1"]]
    faults = program.fault_table([held], [])
    assert list(faults.columns[0].cells) == ["force in g", "time in ms"] and list(faults.columns[2].cells) == ["1", "1"]
