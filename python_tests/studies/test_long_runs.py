"""Long runs and random streams: short runs of both studies."""

import re
import stat

import numpy as np
import pytest

from command_line import answered
from hnav.cli.words import UsageError
from hnav.filters.attitude import Filter
from studies.command import main_of
from studies.long import Day, Motion, days_of, is_flat
from studies.streams import SHARE, counts_of, random_streams

long = main_of("long")


def test_rates_of_the_motion_lead_from_attitude_to_attitude():
    motion = Motion()
    np.testing.assert_allclose(np.linalg.norm(motion.q_nb, axis=1), 1, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(motion.field, axis=1), np.hypot(2.0e-5, 4.5e-5), rtol=1e-9)
    # The forces are of their instants.
    filter = Filter("ahrs", gyro_hold="backward", solver="closed_form", start_accel_latency=0.0)
    run = filter.run(0.01 * np.arange(3000), motion.rate[:3000], motion.force[:3000], motion.field[:3000])
    error = 2 * np.arccos(np.minimum(1, np.abs(np.sum(run.q_nb * motion.q_nb[:3000], axis=1))))
    assert np.degrees(error[1000:]).max() < 0.05


def test_a_day_is_cut_at_its_end_and_the_settling_is_left_out():
    days = list(days_of(Filter("ahrs", gyro_hold="backward", solver="closed_form"), 0.0116))  # one period
    assert len(days) == 1 and 0 < days[0].rms_deg < days[0].worst_deg < 1


@pytest.mark.parametrize("days, rows", [(0.5, 1), (1, 1), (3, 3), (30, 30), (2.5, 3)])
def test_days_are_as_many_as_were_asked_for(monkeypatch, days, rows):
    monkeypatch.setattr(
        "studies.long.errors_rad", lambda filter, periods, start_s, seed: (np.full(70000, 0.1) for _ in range(periods))
    )
    monkeypatch.setattr("studies.long.memory_mb", lambda: 100.0)
    assert len(list(days_of(Filter("ahrs"), days))) == rows


def test_flat_is_an_error_that_does_not_grow_and_memory_that_stays():
    first = Day(0.1, 1, 100)
    assert is_flat([first, Day(0.11, 5, 101)])
    assert not is_flat([first, Day(0.13, 1, 100)])
    assert not is_flat([first, first, Day(0.1, 1, 105)])
    swinging = [Day(0.1, 1, memory) for memory in (104, 110, 100, 109, 101, 111)]
    assert is_flat(swinging)
    assert not is_flat(swinging + [Day(0.1, 1, memory) for memory in (106, 112, 109)])


def test_the_command_prints_its_days():
    done = answered(long, "--days", 0.0116)
    assert done.returncode == 0, done.stderr
    assert re.search(r"flat$", done.stdout.strip()) and "memory" in done.stdout


def program(folder, text):
    path = folder / "program"
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(path.stat().st_mode | stat.S_IEXEC)
    return path


def test_streams_are_shared_out_and_their_counts_added(tmp_path):
    found = random_streams(program(tmp_path, 'echo "$2 streams, $2 calls: 3 samples used"'), 0, 2 * SHARE + 7)
    assert found == {"streams": 2 * SHARE + 7, "calls": 2 * SHARE + 7, "samples used": 9}


@pytest.mark.parametrize("end", ["exit 3", "echo 'x.cpp:7: this does not hold: a > 0' >&2; exit 134"])
def test_a_stream_that_is_not_clean_is_named(tmp_path, end):
    with pytest.raises(UsageError, match="seed 7: (exit status 3|does not hold: a > 0)"):
        counts_of(program(tmp_path, f"echo seed 7; {end}"), 7, 1)
