"""Adaptive filters on flights with a fault of every kind: a short sample of the study."""

import numpy as np
import pytest

from command_line import answered
from hnav.systems.aircraft import models_folder, read_aircraft
from studies.command import main_of
from studies.ins_error_faults.peers import Matched, Peer, run_oracle, run_peer
from studies.ins_error_faults.study import FILTERS, OURS, Case, cases_of, fly_case, scores_of
from studies.ins_error_table import FAULT, run_filter

main = main_of("ins_error_faults")

PLANE = read_aircraft(models_folder() / "f4c_longitudinal.json")
CASES = cases_of(PLANE)


class Plain(Peer):
    """The peers' common part alone."""

    def correct(self, z):
        self.x, self.P = self.m.correct(self.x, self.P, z, np.broadcast_to(self.m.r, z.shape))
        return np.ones(z.shape)


def test_the_peers_stand_on_the_model_of_the_oracle_and_of_the_filter():
    flight, healthy = fly_case(PLANE, Case(), 3, 1)
    assert healthy.all()
    plain = run_peer(Plain, PLANE, flight)
    for other in (run_oracle(PLANE, flight), run_filter(PLANE, flight, FILTERS["none"])):
        np.testing.assert_allclose(plain.error, other.error, rtol=0, atol=1e-9)
        np.testing.assert_allclose(plain.nees, other.nees, rtol=1e-6)


def test_a_peer_that_matches_takes_noise_for_noise():
    flight, healthy = fly_case(PLANE, CASES["the paper's fault"], 6, 2)
    scale = run_peer(Matched, PLANE, flight).noise_scale
    assert np.median(scale[:, 110:150, 2]) > 20 and np.median(scale[:, 30:80]) < 2
    assert not healthy[:, FAULT, 2].any() and healthy[:, :, 0].all()


@pytest.mark.parametrize("case", ["the paper's fault", "process noise x3", "error of q jumps", "5 % outliers"])
def test_joint_hypotheses_are_near_the_best_of_all_and_blame_no_healthy_channel(case):
    scores = scores_of(PLANE, CASES[case], 20, 11)
    ours = scores.pop(OURS)
    assert ours["ratio"] < 1.06 * min(score["ratio"] for score in scores.values())
    assert ours["nees"] < 2
    assert ours["noise_alarms"] < 0.02 and ours["bias_alarms"] < 0.02
    assert ours["process_alarms"] > 0.3 if case == "process noise x3" else ours["process_alarms"] < 0.15


def test_the_tables_print_themselves():
    done = answered(main, "--runs", 2, "--only", "nothing wrong")
    assert done.returncode == 0, done.stderr
    for words in ("RMS error over the oracle's", "NEES/n", "called faulty", "nothing wrong"):
        assert words in done.stdout
    done = answered(main, "--only", "a storm")
    assert done.returncode == 2 and "no case 'a storm'; there are: the paper's fault" in done.stderr
