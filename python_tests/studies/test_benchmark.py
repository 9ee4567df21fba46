"""The benchmark: peers in our conventions, figures that equal those of hnav compare, nothing lost."""

import csv
import json
from dataclasses import replace

import h5py
import numpy as np
import pytest
from matplotlib.container import BarContainer

from command_line import answered, hnav
from hnav.cli.words import UsageError
from hnav.errors import HnavError
from hnav.filters.options import FILTERS
from hnav.io.readers import read
from hnav.io.readers.broad import find_trials, is_disturbed
from hnav.io.recordings import Recording
from hnav.reports.scores import score
from studies.bench import peers
from studies.bench.contenders import DEFAULT_FILTERS, Contender, Estimate, contenders, own_contender
from studies.bench.peers import PEERS, Peer, run_peer, samples_of
from studies.bench.picture import draw_benchmark
from studies.bench.rows import Row, run_trial, summary
from studies.bench.stress import variants
from studies.command import main_of, write_rows
from studies.readiness.starts import simulated_start

main = main_of("bench")

RATE_HZ = 100.0


def still_then_moving(index: int, duration_s: float = 30.0, scored_from_s: float = 15.0) -> Recording:
    recording = simulated_start(index, duration_s=duration_s).recording
    return replace(recording, movement=recording.t_s >= scored_from_s)


@pytest.fixture(scope="module")
def recording() -> Recording:
    return still_then_moving(1)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two simulated trials in the format of BROAD, named as one undisturbed and one disturbed."""
    place = tmp_path_factory.mktemp("trials")
    for name, index in (("02_undisturbed_simulated", 1), ("26_disturbed_simulated", 3)):
        r = still_then_moving(index)
        with h5py.File(place / f"{name}.hdf5", "w") as file:
            file.attrs["sampling_rate"] = RATE_HZ
            file["imu_gyr"], file["imu_acc"], file["imu_mag"] = r.rate_b_rad_s, r.force_b_m_s2, r.field_b_tesla * 1e6
            file["opt_quat"], file["movement"] = r.reference_q_nb, r.movement
    return place


def contender(name: str, estimate, time_us=lambda recording, rate_hz: 1.0, ours: bool = False) -> Contender:
    return Contender(name, ours, False, estimate, time_us)


def truth(recording: Recording, rate_hz: float) -> Estimate:
    return Estimate(recording.reference_q_nb, None, None)


def row(filter: str, trial: str, total: float, disturbed: bool, us: float = 1.0, failure: str = "", nees: float = np.nan) -> Row:
    return Row("BROAD", filter, trial, disturbed, total, total, total, nees, us, 0, failure)


# ------------------------------------------------------------------------------------------ peers


@pytest.mark.parametrize("name", PEERS)
@pytest.mark.parametrize("index", [1, 3])
def test_a_peer_answers_in_our_conventions(name, index):
    pytest.importorskip(PEERS[name].package)
    r = still_then_moving(index)
    quiet = replace(r, rate_b_rad_s=r.rate_b_rad_s - (r.rate_b_rad_s - true_rate(r)).mean(axis=0))
    q, us = run_peer(name, quiet)
    assert q.shape == (len(r.t_s), 4) and us > 0
    assert score(q, r.reference_q_nb, r.movement).total < 10


def true_rate(recording: Recording) -> np.ndarray:
    from scipy.spatial.transform import Rotation

    attitude = Rotation.from_quat(recording.reference_q_nb[:, [1, 2, 3, 0]])
    turned = (attitude[:-1].inv() * attitude[1:]).as_rotvec() * RATE_HZ
    return np.vstack([turned[:1], turned])


def test_a_peer_scored_against_itself_makes_no_error(recording):
    pytest.importorskip("vqf")
    itself = replace(recording, reference_q_nb=run_peer("vqf", recording, RATE_HZ)[0])
    entered, missing = contenders([], ["vqf"])
    (result,) = run_trial("BROAD", itself, RATE_HZ, entered)
    assert missing == [] and result.failure == ""
    assert max(result.total_deg, result.heading_deg, result.inclination_deg) < 1e-5


def test_missing_samples_are_held_and_marked(recording):
    field = recording.field_b_tesla.copy()
    field[[0, 7, 8]] = np.nan
    samples = samples_of(replace(recording, field_b_tesla=field))
    assert list(np.flatnonzero(~samples.seen_field)) == [0, 7, 8]
    np.testing.assert_array_equal(samples.field_ut[8], field[6] * 1e6)
    np.testing.assert_array_equal(samples.field_ut[0], field[1] * 1e6)


def test_lost_rows_are_put_back_for_filters_of_fixed_rate(recording):
    lost = np.zeros(len(recording.t_s), bool)
    lost[[5, 6, 20]] = True
    gappy = Recording(
        recording.name,
        *(v[~lost] for v in (recording.t_s, recording.rate_b_rad_s, recording.force_b_m_s2, recording.field_b_tesla)),
    )
    samples = samples_of(gappy)
    assert len(samples.rate_rad_s) == len(recording.t_s)
    np.testing.assert_array_equal(samples.row, np.flatnonzero(~lost))
    np.testing.assert_array_equal(samples.rate_rad_s[6], recording.rate_b_rad_s[4])
    assert len(run_peer("vqf", gappy)[0]) == len(gappy.t_s)


def test_irregular_stamps_do_not_determine_lost_rows(recording):
    (jittered,) = variants("JITTER", [recording])
    np.testing.assert_array_equal(samples_of(jittered, RATE_HZ).row, np.arange(len(jittered.t_s)))


def test_a_recording_without_a_field_is_refused_by_name(recording):
    with pytest.raises(HnavError, match="no field"):
        run_peer("vqf", replace(recording, field_b_tesla=None))


def test_a_peer_that_is_not_installed_is_named_and_skipped(monkeypatch):
    monkeypatch.setitem(peers.PEERS, "imaginary", Peer("no_such_package", lambda samples: samples.rate_rad_s))
    entered, missing = contenders(["ahrs"], ["imaginary"])
    assert [c.name for c in entered] == ["ahrs"]
    assert len(missing) == 1 and "imaginary" in missing[0] and "pip install no_such_package" in missing[0]


# ------------------------------------------------------------------------------------------ contenders and trials


@pytest.mark.parametrize("filters, named", [
    (["magic"], "magic"), (["magic-smooth"], "magic"), (["ahrs:no_such=1"], "no_such"), (["ahrs:gyro_hold"], "NAME=VALUE"),
])  # fmt: skip
def test_an_unknown_filter_or_option_is_refused_before_the_first_run(filters, named):
    with pytest.raises((HnavError, UsageError), match=named):
        contenders(filters, [])


def test_every_filter_of_the_library_is_entered_by_default():
    entered, _ = contenders(DEFAULT_FILTERS, [])
    assert {c.name for c in entered} >= set(FILTERS)
    assert [c.name for c in entered if c.offline] == ["ahrs-smooth"]


def test_options_make_another_contender(recording):
    entered, _ = contenders(["ahrs", "ahrs:gyro_hold=forward"], [])
    ours, other = run_trial("BROAD", recording, RATE_HZ, entered)
    assert other.filter == "ahrs:gyro_hold=forward"
    assert other.total_deg != ours.total_deg


def test_everybody_runs_in_turn(recording):
    calls = []

    def noted(name):
        def time_us(recording, rate_hz):
            calls.append(name)
            return float(len(calls))

        return time_us

    rows = run_trial("BROAD", recording, RATE_HZ, [contender(n, truth, noted(n)) for n in "ab"], repeats=3)
    assert calls == ["a", "b", "a", "b", "a", "b"]
    assert [r.us_per_sample for r in rows] == [3.0, 4.0]


def test_a_first_run_that_is_timed_is_not_run_twice(recording):
    calls = []

    def estimate(recording, rate_hz):
        calls.append("estimate")
        return Estimate(recording.reference_q_nb, None, 7.0)

    (only,) = run_trial(
        "BROAD", recording, RATE_HZ, [contender("a", estimate, lambda recording, rate_hz: pytest.fail("timed again"))]
    )
    assert calls == ["estimate"] and only.us_per_sample == 7.0


def test_a_failure_is_a_row_and_does_not_stop_the_others(recording):
    def broken(recording, rate_hz):
        raise ZeroDivisionError("matrix is singular\nsecond line")

    failed, good = run_trial("CROP", recording, RATE_HZ, [contender("bad", broken), contender("good", truth)], repeats=2)
    assert failed.failure == "matrix is singular" and np.isnan(failed.total_deg)
    assert good.failure == "" and good.total_deg < 1e-5
    lines = summary([failed, good])
    assert [(line.trials, line.failures) for line in lines] == [(0, 1), (1, 0)]


def test_samples_without_an_estimate_are_counted(recording):
    q = recording.reference_q_nb.copy()
    q[-5:] = np.nan
    some, none = run_trial("BROAD", recording, RATE_HZ, [
        contender("some", lambda recording, rate_hz: Estimate(q, None, None)),
        contender("none", lambda recording, rate_hz: Estimate(np.full_like(q, np.nan), None, None)),
    ])  # fmt: skip
    assert some.missing == 5 and some.failure == ""
    assert none.failure == "no estimate in the scored phase"


def test_late_fields_are_not_timed_when_python_pushes_them(recording):
    (late,) = variants("LATE", [recording.cropped(20)])
    ours = own_contender("ahrs")
    assert np.isnan(ours.time_us(late, RATE_HZ))
    assert ours.time_us(recording, RATE_HZ) > 0


# ------------------------------------------------------------------------------------------ results


def test_means_are_plain_means_over_trials():
    rows = [
        row("a", "01", 1.0, False, us=1),
        row("a", "02", 2.0, False, us=5),
        row("a", "30", 6.0, True, us=2, nees=4.0),
        row("b", "01", 9.0, False),
    ]
    a, b = summary(rows)
    assert (a.total_deg, a.undisturbed_deg, a.disturbed_deg, a.us_per_sample, a.nees_per_axis) == (3.0, 1.5, 6.0, 2.0, 4.0)
    assert b.total_deg == 9.0 and np.isnan(b.disturbed_deg) and np.isnan(b.nees_per_axis)


def test_a_trial_is_disturbed_by_its_name():
    assert not is_disturbed("23_undisturbed_x") and is_disturbed("24_disturbed_x #2")


def test_csv_has_a_row_for_each_set_filter_and_trial_with_empty_cells_for_the_unknown(tmp_path):
    write_rows(tmp_path / "b.csv", map(vars, [row("a", "01", 1.25, False), row("a", "02", np.nan, True, failure="one, two")]))
    found = list(csv.DictReader((tmp_path / "b.csv").open()))
    assert found[0]["total_deg"] == "1.25" and found[0]["nees_per_axis"] == "" and found[0]["disturbed"] == "0"
    assert found[1]["total_deg"] == "" and found[1]["failure"] == "one, two" and found[1]["disturbed"] == "1"


def test_the_picture_shows_the_means_best_first_and_hindsight_apart():
    rows = [row("good", "01", 1.0, False), row("good", "30", 2.0, True), row("bad", "01", 5.0, False), row("bad", "30", 7.0, True, us=90.0),
            row("past", "01", 0.5, False), row("past", "30", 0.5, True)]  # fmt: skip
    entered = [contender("bad", truth), contender("good", truth, ours=True), replace(contender("past", truth), offline=True)]
    errors, times = draw_benchmark(summary(rows), entered).axes
    assert [label.get_text() for label in errors.get_yticklabels()] == ["good", "bad", "past"]
    bars = [c for c in errors.containers if isinstance(c, BarContainer)]
    np.testing.assert_allclose([[bar.get_width() for bar in c] for c in bars[:2]], [[1.0, 5.0, 0.5], [2.0, 7.0, 0.5]])
    assert times.get_xscale() == "log"


def test_the_picture_does_without_disturbed_trials():
    errors, _ = draw_benchmark(summary([row("a", "01", 1.0, False)]), [contender("a", truth)]).axes
    assert [label.get_text() for label in errors.get_yticklabels()] == ["a"]


# ------------------------------------------------------------------------------------------ the command


def test_bench_gives_the_figures_of_score(folder, tmp_path):
    out, scores, picture = tmp_path / "bench.csv", tmp_path / "scores.json", tmp_path / "bench.png"
    done = answered(main, folder, "--sets", "BROAD,CROP", "--peers", "vqf", "--csv", out, "--picture", picture, "--repeat", "2")
    assert done.returncode == 0, done.stderr
    for word in ("ahrs-smooth", "hrekf", "vqf", "CROP", "undisturbed"):
        assert word in done.stdout
    assert picture.read_bytes().startswith(b"\x89PNG")
    rows = list(csv.DictReader(out.open()))
    assert len(rows) == 2 * 2 * (len(DEFAULT_FILTERS) + 1) and not any(r["failure"] for r in rows)
    assert hnav("compare", folder, "--filter", "ahrs", "--json", scores).returncode == 0
    figures = json.loads(scores.read_text())
    for trial in figures["trials"].values():
        (mine,) = [r for r in rows if (r["set"], r["filter"], r["trial"]) == ("BROAD", "ahrs", trial["name"])]
        for ours, theirs in (
            ("total_deg", "total"),
            ("heading_deg", "heading"),
            ("inclination_deg", "inclination"),
            ("nees_per_axis", "nees_per_axis"),
        ):
            assert float(mine[ours]) == pytest.approx(trial[theirs], rel=1e-5)
    trials = [read(path) for path in find_trials(folder).values()]
    theirs = [float(r["total_deg"]) for r in rows if (r["set"], r["filter"]) == ("BROAD", "vqf")]
    assert np.mean(theirs) == pytest.approx(
        np.mean([score(run_peer("vqf", r)[0], r.reference_q_nb, r.movement).total for r in trials]), rel=1e-5
    )


def test_failures_are_printed(folder):
    done = answered(main, folder, "--sets", "BROAD", "--peers", "none", "--filters", "hrekf-smooth,ahrs")
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("failed: BROAD, hrekf-smooth") == 2
    assert "2 failed" in done.stdout


@pytest.mark.parametrize("arguments, named", [
    (["nowhere"], "nowhere"),
    (["EMPTY"], "no BROAD trials"),
    (["FOLDER", "--peers", "magic"], "magic"),
    (["FOLDER", "--filters", "magic"], "magic"),
    (["FOLDER", "--sets", "magic"], "magic"),
    (["FOLDER", "--sets", ""], "--sets"),
    (["FOLDER", "--filters", "", "--peers", "none"], "no filter"),
    (["FOLDER", "--sets", "CROP", "--picture", "x.png"], "BROAD"),
    (["FOLDER", "--sets", "BROAD", "--filters", "ahrs", "--peers", "none", "--csv", "/nonexistent/x.csv"], "/nonexistent/x.csv"),
])  # fmt: skip
def test_what_cannot_be_done_is_one_line_and_exit_code_2(folder, tmp_path, arguments, named):
    places = {"FOLDER": str(folder), "EMPTY": str(tmp_path)}
    done = answered(main, *(places.get(a, a) for a in arguments))
    assert done.returncode == 2
    assert named in done.stderr and len(done.stderr.strip().splitlines()) == 1, done.stderr
