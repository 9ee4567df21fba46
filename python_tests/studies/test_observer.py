"""Whether the observer's sigmas are right: a sample of the study."""

import numpy as np
import pytest

from checkout import TOP
from command_line import answered
from hnav.systems.statistics import normalised_squares
from studies.command import main_of
from studies.observer import bounds, cost, events, laws, size, tank
from studies.observer.smooth import results
from studies.observer.study import PARTS

main = main_of("observer")


def rows_of(part):
    """Of its last table."""
    return PARTS[part][-1].table(1).row_count


def test_the_mean_error_of_a_few_runs_is_as_stated(monkeypatch):
    monkeypatch.delenv("HNAV_PLANTS", raising=False)
    (result,) = results(5)
    # Of 900 corrections whose errors hang together for some ten of them.
    assert 0.7 < result["nees"] < 1.4 and 0.85 < result["nis"] < 1.15
    assert result["us_per_sample"] > 0


needs_library = pytest.mark.skipif(not (TOP / "build/c_src/libhnav.so").is_file(), reason="no build: ./run build")


def test_plants_with_events_are_as_good_as_particles(monkeypatch):
    monkeypatch.delenv("HNAV_PLANTS", raising=False)
    monkeypatch.setattr(events, "PARTICLES", 300)
    monkeypatch.setattr(events, "SUBSTEPS", 50)
    all_cases = list(events.cases())
    assert [case.name for case in all_cases] == ["ball, functions in Python", "pendulum with a stop", "relay with hysteresis"]
    for case in all_cases:
        result = events.measured(case, 2, 0)
        assert 0.3 < result["nees"] < 3 and result["ratio"] < 2
        assert 1 < result["parts"] < 2


def test_errors_are_normalised_by_their_covariance():
    error = np.array([[3.0, 0.0], [0.0, 2.0]])
    assert normalised_squares(error, np.array([np.diag([9.0, 1.0]), np.diag([1.0, 2.0])])) == pytest.approx([1, 2])


def test_the_table_has_a_row_for_each_plant(monkeypatch):
    monkeypatch.delenv("HNAV_PLANTS", raising=False)
    monkeypatch.setattr(events, "PARTICLES", 10)
    monkeypatch.setattr(events, "SUBSTEPS", 10)
    answer = answered(main, "--runs", "1", "--part", "errors")
    assert answer.returncode == 0 and "functions in Python" in answer.stdout and "pendulum with a stop" in answer.stdout


@pytest.mark.slow
def test_figures_beside_what_they_have_to_be(monkeypatch):
    monkeypatch.setattr(laws, "RUNS", 1)
    found = list(laws.results())
    assert len(found) == 13 and all(set(laws.KINDS) < set(law) for law in found)
    kalman, mean, *sigmas = ([law[kind] for kind in laws.KINDS if np.isfinite(law[kind])] for law in found[:7])
    assert max(kalman) < 1e-5 and np.abs(mean).max() < 0.1
    assert np.concatenate([*sigmas[:2], *sigmas[3:]]) == pytest.approx(1, abs=0.03)
    monkeypatch.setattr(laws, "results", lambda: iter(found[:1]))
    assert rows_of("laws") == 1


@needs_library
def test_a_bounce_costs_more_than_none():
    *_, free, bouncing, bounce = cost.results(1)
    assert bouncing["least_us"] > free["least_us"]
    assert bounce["least_us"] == pytest.approx(bouncing["least_us"] - free["least_us"])


@needs_library
def test_costs_are_printed(monkeypatch):
    monkeypatch.setattr(cost, "has_valgrind", lambda: False)
    assert rows_of("cost") == 4


def test_many_states_are_measured(monkeypatch):
    (result,) = size.results((6,), 4)
    assert result["states"] == 6 and 0.6 < result["nees"] < 1.5
    assert result["ms_per_sample"] > 0 and 0 <= result["memory_mb"] < 50
    monkeypatch.setattr(size, "results", lambda: iter([result]))
    assert rows_of("size") == 1


def test_only_a_bound_keeps_a_positive_parameter_positive(monkeypatch):
    bounded, free, unscented = bounds.results(10)
    assert bounded["negative"] == 0 < min(free["negative"], unscented["negative"])
    assert bounded["rms"] < free["rms"] == pytest.approx(unscented["rms"], rel=0.05)
    monkeypatch.setattr(bounds, "results", lambda: [bounded])
    assert rows_of("bounds") == 1


def test_a_part_that_is_none_is_refused():
    answer = answered(main, "--part", "speed")
    assert answer.returncode == 2 and "choose from errors, hindsight, laws, tank, bounds, size, cost" in answer.stderr


def test_a_tank_is_printed(monkeypatch):
    (result,) = tank.results(1)[1:]
    assert [result[name] for name in ("plan", "runs", "found", "held", "dropped")] == ["min = 0", 1, 1, 0, 0]
    monkeypatch.setattr(tank, "results", lambda: [result])
    assert rows_of("tank") == 1
