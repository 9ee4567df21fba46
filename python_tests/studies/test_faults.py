"""The table of faults: each damage is as named, figures can be counted by hand, every fault has its row."""

import numpy as np
import pytest

from command_line import answered
from hnav.io.recordings import Recording
from hnav.rotations import quaternion_product
from motion import tilted_motion
from studies.bench.peers import Peer
from studies.command import main_of
from studies.faults import experiment
from studies.faults import study as program
from studies.faults.events import AFTER_S, BEFORE_S, CLIP_RAD_S, EVENTS, simulated
from studies.faults.experiment import damage_of, options_of, recoveries, settled_s
from studies.faults.first_samples import first_samples, verdict
from studies.faults.recordings import FAULTS

main = main_of("faults")

SHORT = ("16 g on one axis for 1 s", "field stuck for 20 s")


@pytest.fixture(scope="module")
def moving() -> Recording:
    recording = tilted_motion(30).recording
    # Recordings of the study are east-north-up; these samples were made for north-east-down.
    half = np.sqrt(0.5)
    recording.reference_q_nb[:] = quaternion_product(np.array([0, half, half, 0]), recording.reference_q_nb)
    return recording


def test_an_event_damages_its_own_rows_alone():
    clean, shocked = simulated("gap of 60 s", 4), simulated(SHORT[0], 4)
    begin = round(100 * BEFORE_S)
    np.testing.assert_array_equal(clean.rate[:begin], shocked.rate[:begin])
    assert np.flatnonzero(np.abs(shocked.force).max(axis=1) > 100).tolist() == list(range(begin, begin + 100))
    clipped = simulated("gyro clipped for 10 s of fast motion", 4)
    assert np.abs(clipped.rate[clipped.during]).max() == CLIP_RAD_S
    assert clipped.t_s[-1] == pytest.approx(BEFORE_S + 10 + AFTER_S, abs=0.02)


def test_settled_counts_from_the_end_of_the_event_to_the_last_wrong_row():
    error = np.zeros(1000)
    assert settled_s(error, 100) == 0
    error[50:90] = 20
    assert settled_s(error, 100) == 0
    error[300] = 20
    assert settled_s(error, 100) == pytest.approx(2.01)
    error[-1] = np.nan
    assert settled_s(error, 100) == np.inf


@pytest.mark.parametrize("event", SHORT)
def test_three_seeds_of_an_event(event):
    found = recoveries(range(3), event, "ahrs", {})
    assert [*found.seed] == [0, 1, 2]
    assert (found.settled_s < 20).all() and (found.false_share < 0.2).all()
    assert found.peer_settled_s.isna().all() == EVENTS[event].heading
    assert recoveries(range(1), event, "ahrs", {}).equals(found[:1])


def test_the_table_has_a_row_for_each_event(monkeypatch):
    for module in (experiment, program):
        monkeypatch.setattr(module, "EVENTS", {name: EVENTS[name] for name in SHORT})
    done = answered(main, "--part", "events", "--seeds", "1", "--workers", "1")
    assert done.returncode == 0, done.stderr
    assert all(name in done.stdout for name in SHORT)


def test_what_is_wrong_and_what_was_noticed_on_a_damaged_recording(moving, monkeypatch):
    monkeypatch.setattr(Peer, "installed", lambda self: False)
    clean, stuck = (damage_of(moving, fault, 0, "ahrs", {}) for fault in ("none", "magnetometer stuck from 1/3"))
    assert clean["said"] == {} and np.isnan(clean["peer_deg"])
    assert stuck["said"]["mag stuck"] == pytest.approx(2 / 3, abs=0.1)


@pytest.mark.parametrize("fault", FAULTS)
def test_a_damaged_recording_is_as_long_as_its_stamps(fault, moving):
    damaged = FAULTS[fault](moving, np.random.default_rng(0))
    lengths = {len(damaged.t_s), len(damaged.rate_b_rad_s), len(damaged.force_b_m_s2), len(damaged.needed("reference_q_nb"))}
    assert len(lengths) == 1 and (fault == "none") == (damaged is moving)


def test_a_false_first_sample_leaves_the_attitude_as_it_is_without_it():
    for sensor in ("force", "field"):
        found = list(first_samples(8, sensor, options_of("ahrs", {})))
        assert len(found) == 8 and "8 of 8 starts as good" in verdict(sensor, found)
        assert max(without_deg for _, without_deg in found) > 0.05
    assert "0 of 1 starts as good" in verdict("force", [(2.0, 1.0)])


def test_the_first_sample_decides_where_one_is_enough():
    found = list(first_samples(4, "force", options_of("ahrs", {"start_samples": "1"})))
    assert max(false_deg - without_deg for false_deg, without_deg in found) > 0.05
    assert "of 4 starts as good" in answered(main, "--part", "starts", "--seeds", "4", "--workers", "1").stdout


def test_what_cannot_be_is_refused_in_one_line(monkeypatch):
    monkeypatch.delenv("BROAD_DIR", raising=False)
    assert "choose from starts, events, recordings" in answered(main, "--part", "all").stderr
    assert "set BROAD_DIR" in answered(main, "--part", "recordings").stderr
