"""Many runs: the same numbers for any number of workers, failures kept, intervals that cover what they should."""

import tempfile

import numpy as np
import pandas as pd
import pytest

from command_line import hnav
from hnav.errors import HnavError, HnavValueError
from hnav.fmi.fmus import Fmu, KeptFmus, fmu_path
from hnav.io.outputs import OutputError
from hnav.systems import montecarlo
from hnav.systems.montecarlo import Job, finished_runs, jobs, rows_of, run_jobs, write_table
from hnav.systems.ssp_reader import read_system
from hnav.systems.statistics import mean_interval, nees_bounds, ratio_interval
from importing import built_fmu
from made_systems import NOISE, make_system, make_turntable


@pytest.fixture(scope="module")
def system(tmp_path_factory) -> str:
    for name in ("Turntable", "ImuMagSensor", "Hrekf", "Ahrs"):
        built_fmu(name)
    return str(make_turntable(tmp_path_factory.mktemp("turntable")))


def test_the_same_seeds_give_the_same_numbers_for_any_number_of_workers(system):
    pytest.importorskip("distributed", reason="distributed is not installed: one worker only")
    work = jobs(system, [None, "gamma_off"], 3, settings=NOISE, stop_s=2)
    one, two = run_jobs(work, 1), run_jobs(work, 2)
    assert len(one) == 2 * 3 * 3
    assert one["mse_deg2"].nunique() > 6
    pd.testing.assert_frame_equal(one, two, check_exact=True)


@pytest.fixture
def loads(monkeypatch, tmp_path):
    """Names of the instances whose library was loaded; what is unpacked goes to a folder of its own, also given."""
    names, load = [], Fmu._load
    monkeypatch.setattr(Fmu, "_load", lambda fmu, path, exchange, name: [names.append(name), load(fmu, path, exchange, name)])
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return names, tmp_path


def test_runs_of_a_command_load_once_and_are_what_runs_by_themselves_are(system, loads):
    names, folder = loads
    work = jobs(system, [None, "gamma_off"], 2, settings=NOISE, stop_s=2)
    together = run_jobs(work)
    assert sorted(names) == sorted(read_system(system).components)
    assert not list(folder.iterdir())
    # Backwards, so that nothing that a run leaves can pass for what the next one begins with.
    alone = [row for job in reversed(work) for row in reversed(rows_of(job))]
    pd.testing.assert_frame_equal(together, pd.DataFrame(alone[::-1]), check_exact=True)


def test_a_run_that_fails_leaves_nothing_loaded(system, loads, monkeypatch):
    names, folder = loads
    work = jobs(system, [None], 3, settings=NOISE, stop_s=1)
    step, whole = Fmu.do_step, run_jobs(work)

    def failing(fmu, t_s, step_s):
        if t_s > 0.5 and fmu.get("seed" if "seed" in fmu.variables else "time") == 2:
            raise HnavValueError("option", "broken")
        step(fmu, t_s, step_s)

    names.clear()
    monkeypatch.setattr(Fmu, "do_step", failing)
    table = run_jobs(work)
    assert [*table[table["failure"] != ""]["seed"]] == [2]
    assert len(names) == 2 * len(set(names)) and not list(folder.iterdir())
    good = whole[whole["seed"] != 2].reset_index(drop=True)
    pd.testing.assert_frame_equal(table[table["failure"] == ""].reset_index(drop=True)[good.columns], good, check_exact=True)


def test_an_fmu_that_can_be_there_once_is_loaded_for_every_run(system, loads):
    with KeptFmus() as fmus:
        for once in (True, False, False):
            fmus.instance(fmu_path("Turntable", 2), "table").description.coSimulation.canBeInstantiatedOnlyOncePerProcess = once
    assert loads[0] == ["table", "table"] and not list(loads[1].iterdir())


def test_a_failing_run_is_a_row_and_the_others_go_on(system, monkeypatch):
    simulate = montecarlo.simulate

    def failing(name, scenario, grade, settings, seed, *rest):
        if seed == 2:
            raise HnavValueError("option", "sensor: broken")
        return simulate(name, scenario, grade, settings, seed, *rest)

    monkeypatch.setattr(montecarlo, "simulate", failing)
    seen = []
    table = run_jobs(jobs(system, [None], 3, stop_s=1), progress=lambda done, total: seen.append((done, total)))
    assert table[table["failure"] != ""][["seed", "failure"]].values.tolist() == [[2, "sensor: broken"]]
    assert sorted(table[table["failure"] == ""]["seed"].unique()) == [1, 3]
    assert seen == [(1, 3), (2, 3), (3, 3)]


def test_a_system_without_truth_or_filter_says_so(system, tmp_path):
    alone = make_system(tmp_path / "alone", {"turntable": "Turntable"}, [])
    assert "has no attitude filter" in rows_of(Job(str(alone), None, 1, stop_s=0.1))[0]["failure"]
    untrue = make_system(tmp_path / "untrue", {"filter": "Hrekf", "sensor": "ImuMagSensor"}, [])
    assert "puts out no truth" in rows_of(Job(str(untrue), None, 1, stop_s=0.1))[0]["failure"]


def test_the_command_prints_the_table_and_writes_parquet(system, tmp_path):
    pytest.importorskip("pyarrow", reason="pyarrow is not installed: no Parquet")
    out = tmp_path / "new" / "runs.parquet"
    done = hnav("montecarlo", system, "--runs", "2", "--stop", "1", "--scenarios", "gamma_off", "--out", str(out))
    assert done.returncode == 0, done.stderr
    assert "2 of 2 runs to" in done.stdout
    assert all(name in done.stdout for name in ("hekf", "hrekf", "ahrs"))
    table = pd.read_parquet(out)
    assert set(table["filter"]) == {"hekf", "hrekf", "ahrs"}
    # gamma is off in both: one filter, two names.
    by_name = table.set_index(["filter", "seed"])["mse_deg2"]
    np.testing.assert_array_equal(by_name["hekf"], by_name["hrekf"])
    (tmp_path / "file").touch()
    with pytest.raises(HnavError, match="cannot write"):
        write_table(table, tmp_path / "file" / "runs.parquet")


RUNS = ("--runs", "4", "--stop", "0.5", *(f"--set={name}={value}" for name, value in NOISE.items()))


@pytest.fixture
def stopped(monkeypatch):
    """Lets so many runs of a command come to an end, and then something else happen to the next."""

    def after(runs: int, happens: BaseException) -> None:
        simulate, done = montecarlo.simulate, []

        def counted(*arguments):
            done.append(1)
            if len(done) > runs:
                raise happens
            return simulate(*arguments)

        monkeypatch.setattr(montecarlo, "simulate", counted)

    yield after
    monkeypatch.undo()


def test_a_stopped_command_goes_on_and_its_table_is_that_of_one_that_was_not(system, tmp_path, stopped, monkeypatch):
    pytest.importorskip("pyarrow", reason="pyarrow is not installed: no Parquet")
    whole, out = tmp_path / "whole.parquet", tmp_path / "out.parquet"
    unfinished = tmp_path / "out.parquet.unfinished"
    assert hnav("montecarlo", system, *RUNS, "--out", whole).returncode == 0
    out.write_bytes(b"old")
    for runs, happens, said in (
        (1, KeyboardInterrupt(), f"interrupted; 1 of 4 runs are in {unfinished}, and the same command goes on from there"),
        (2, OutputError("cannot write /tmp/x: no space left on device"), "cannot write /tmp/x: no space left on device"),
    ):
        with monkeypatch.context():
            stopped(runs, happens)
            done = hnav("montecarlo", system, *RUNS, "--out", out)
        monkeypatch.undo()
        assert done.returncode == (130 if isinstance(happens, KeyboardInterrupt) else 2) and done.stderr == f"hnav: {said}\n"
        assert out.read_bytes() == b"old" and unfinished.exists()
        # As if the power had gone while a record was written.
        unfinished.write_bytes(unfinished.read_bytes() + b"01234567 [3,[")
    other = hnav("montecarlo", system, *RUNS, "--set", "sensor.gyro.period_s=0.02", "--out", out)
    assert other.returncode == 2 and "out.parquet.unfinished was begun with settings = " in other.stderr
    for changed in (["--stop", "0.6"], ["--runs", "5"], ["--first-seed", "2"], ["--scenarios", "gamma_off"]):
        assert "was begun with" in hnav("montecarlo", system, *RUNS, *changed, "--out", out).stderr
    stopped(1, AssertionError("a finished run is not made again"))
    done = hnav("montecarlo", system, *RUNS, "--out", out)
    assert done.returncode == 0, done.stderr
    assert f"3 of 4 runs are finished, in {unfinished}" in done.stdout
    assert out.read_bytes() == whole.read_bytes() and not unfinished.exists()


def test_another_build_of_the_system_is_another_system(system, tmp_path, stopped):
    folder, out = make_turntable(tmp_path / "turntable"), tmp_path / "out.parquet"
    stopped(1, KeyboardInterrupt())
    assert hnav("montecarlo", folder, *RUNS, "--out", out).returncode == 130
    ssd = folder / "SystemStructure.ssd"
    ssd.write_text(ssd.read_text() + "\n")
    assert "was begun with content of the system = " in hnav("montecarlo", folder, *RUNS, "--out", out).stderr


def test_a_worker_that_died_is_not_a_finished_run(system, tmp_path, monkeypatch):
    work = jobs(system, [None], 2, stop_s=0.1)
    monkeypatch.setattr(montecarlo, "_results", lambda left, *_: ((i, rows_of(job), i == 0) for i, job in left))
    with read_system(system) as read, finished_runs(tmp_path / "x", work, read) as kept:
        run_jobs(work, kept=kept)
        assert [number for number, _ in kept.records] == [0]


@pytest.mark.parametrize(
    "options, said",
    [
        (["--runs", "1"], "--runs 1: at least 2 are needed"),
        (["--out", "/dev/null"], "--out /dev/null: is no file"),
        (["--workers", "0", "--runs", "2"], "--workers 0: at least 1 is needed"),
        (["--scenarios", "none"], "has no scenario none"),
        (["--grade", "none"], "has no grade none"),
        (["--scheduler", "nothing", "--runs", "2"], "scheduler nothing"),
    ],
)
def test_what_cannot_be_run_is_said_at_once(system, tmp_path, options, said):
    if "--scheduler" in options:
        pytest.importorskip("distributed", reason="distributed is not installed: no scheduler")
    done = hnav(*["montecarlo", system, "--out", str(tmp_path / "x.parquet"), *options])
    assert done.returncode == 2 and said in done.stderr


def test_the_interval_of_the_mean_covers_it_as_often_as_it_says():
    rng = np.random.default_rng(3)
    covered = [low <= 2.0 <= high for _, low, high in (mean_interval(rng.normal(2.0, 3.0, 12)) for _ in range(4000))]
    # Binomial: 0.95 within four standard deviations of 0.0034.
    assert abs(np.mean(covered) - 0.95) < 4 * 0.0034
    assert mean_interval(np.array([1.0, np.nan]))[0] == 1.0
    assert np.isnan(mean_interval(np.array([1.0]))[1:]).all()


def test_the_interval_of_the_ratio_uses_that_both_saw_the_same_noise():
    common = np.random.default_rng(4).gamma(2.0, 1.0, 200)
    ratio, low, high = ratio_interval(3.6 * common, common)
    assert (ratio, low, high) == pytest.approx((3.6, 3.6, 3.6))
    other = np.random.default_rng(5).permutation(common)
    ratio, low, high = ratio_interval(3.6 * common, other)
    assert low < 3.6 - 0.2 and high > 3.6 + 0.2
    assert ratio_interval(3.6 * common, other) == (ratio, low, high)


def test_the_bounds_of_the_mean_nees_hold_for_chi_square_draws():
    low, high = nees_bounds(200)
    assert 2.4 < low < 3 < high < 3.7
    means = np.random.default_rng(6).chisquare(3, (20000, 200)).mean(axis=1)
    # 0.1 % outside: 20 of 20000, four standard deviations of sqrt(20).
    assert abs(np.sum((means < low) | (means > high)) - 20) < 4 * np.sqrt(20)
