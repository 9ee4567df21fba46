"""The study of certificates: damaged recordings get a verdict with its reason, and the cost is announced before the run."""

import numpy as np
import pytest

from command_line import answered
from hnav.certify.certificate import certify
from hnav.certify.gain_record import GainRecord
from hnav.systems.turntable_recording import INTERVAL_S, Turntable
from studies.certificate import COSTS, DAMAGES, attack, recorded
from studies.command import main_of

main = main_of("certificate")


@pytest.fixture(scope="module")
def turntable():
    return Turntable().run(21.0, 5)


def test_a_gap_takes_rows_and_jitter_keeps_them(turntable):
    whole = turntable.recording
    lost = {name: len(whole.t_s) - len(DAMAGES[name](whole).t_s) for name in ("none", "1 row lost", "35 rows lost", "jitter")}
    assert lost == {"none": 0, "1 row lost": 1, "35 rows lost": 35, "jitter": 0}
    late = DAMAGES["jitter"](whole).t_s - whole.t_s
    assert late.min() >= 0 and INTERVAL_S / 4 < late.max() <= INTERVAL_S / 2


@pytest.mark.slow
def test_ascent_stays_below_the_bound_and_finds_a_bound_that_is_too_small(turntable):
    record = recorded(DAMAGES["5 rows lost"](turntable.recording), turntable.settings)
    short = GainRecord(record.name, record.corrections[495:510], record.largest_difference)
    found = certify(short, starts=0)
    assert found.certified, found.reason
    reached = attack(found, short)
    assert 0.9 < reached <= 1
    found.region_rate_1_s *= 40
    assert attack(found, short) > 1


def test_a_restart_is_refused_with_its_remedy():
    done = answered(main, "--part", "damaged", "--only", "gap of 3 s")
    assert "certify the parts before and after" in " ".join(done.stdout.replace("│", " ").split())


def test_a_part_that_is_not_there_is_one_line():
    done = answered(main, "--part", "space")
    assert done.returncode == 2 and done.stderr.count("\n") == 1
    assert len({cost[0] for cost in COSTS}) == len(COSTS) and np.isfinite([cost[1] for cost in COSTS]).all()
