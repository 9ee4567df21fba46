"""The cost of a sample: of the attitude filters beside the peers, whose sources the study has fetched, and of the navigation filter."""

import os
import re

import pytest

from hnav.cli.words import UsageError
from hnav.places import CHECKOUT
from studies.counting import times_ns, write_samples
from studies.ins_speed import SOLVERS, words, write_drive
from studies.ins_speed import built as built_for_ins
from studies.instructions import CASES
from studies.speed.study import CONTENDERS, WORK, built, built_alone, fetched_sources

needs_recordings = pytest.mark.skipif("BROAD_DIR" not in os.environ, reason="BROAD_DIR is not set: no BROAD recordings")
needs_library = pytest.mark.skipif(not (CHECKOUT / "build/c_src/libhnav.so").is_file(), reason="no build: ./run build")
needs_sources = pytest.mark.skipif(not (WORK / "archives").is_dir(), reason="no sources of peers: ./run study speed fetches them")


def test_each_contender_has_a_name_and_a_peer():
    names = [name for *_, name, _ in CONTENDERS]
    assert len(set(names)) == len(names)
    assert {peer for *_, peer in CONTENDERS} <= set(names)


def test_the_sources_are_pinned_by_their_hash():
    lines = (CHECKOUT / "python/studies/speed/requirements.txt").read_text().splitlines()
    pins = [line for line in lines if not line.startswith("#")]
    assert pins and all(re.fullmatch(r"\w+==[\d.]+ --hash=sha256:[0-9a-f]{64}", pin) for pin in pins)


@pytest.mark.slow
@needs_recordings
@needs_library
@needs_sources
def test_all_run_over_the_same_samples(tmp_path):
    samples, rows = tmp_path / "samples.bin", 2000
    write_samples(samples, rows)
    program = built(CHECKOUT, fetched_sources())
    for *_, name, _ in CONTENDERS:
        assert all(time > 0 for time in times_ns([program, samples, str(rows), name, "1"])), name


@needs_library
def test_the_navigation_filter_is_timed_over_a_drive_at_whose_end_it_navigates(tmp_path):
    drive = write_drive(tmp_path / "drive.bin", 60.0)
    assert (drive.rows, drive.aids) == (6001, 600)
    program = built_for_ins(tmp_path / "timing")
    for solver in SOLVERS.values():
        times = times_ns(words(program, drive, solver, drive.rows, 2))
        assert len(times) == 2 and min(times) > 0
    with pytest.raises(UsageError, match="DRIVE ends early"):
        times_ns(words(program, drive._replace(aids=drive.aids + 1), 0, 1, 1))


@needs_recordings
@needs_library
def test_the_program_whose_instructions_are_counted_runs_every_case(tmp_path):
    samples, rows = tmp_path / "samples.bin", 500
    write_samples(samples, rows)
    program = built_alone(CHECKOUT, tmp_path / "timing")
    for name in CASES.values():
        assert all(time > 0 for time in times_ns([program, samples, str(rows), name, "1"])), name
