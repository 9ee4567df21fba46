"""Whether the observer's sigmas are right: a sample of the study."""

import numpy as np
import pytest

from command_line import answered
from studies import observer_events
from studies.observer import main, normalised, results


def test_the_mean_error_of_a_few_runs_is_as_told(monkeypatch):
    monkeypatch.delenv("HNAV_PLANTS", raising=False)
    (result,) = results(5)
    # Of 900 corrections whose errors hang together for some ten of them.
    assert 0.7 < result.nees < 1.4 and 0.85 < result.nis < 1.15
    assert result.us_per_sample > 0


def test_plants_with_events_are_as_good_as_particles(monkeypatch):
    monkeypatch.delenv("HNAV_PLANTS", raising=False)
    monkeypatch.setattr(observer_events, "PARTICLES", 300)
    monkeypatch.setattr(observer_events, "SUBSTEPS", 50)
    all_cases = list(observer_events.cases())
    assert [case.name for case in all_cases] == ["ball, functions in Python", "pendulum with a stop", "relay with hysteresis"]
    for case in all_cases:
        result = observer_events.measured(case, 2, 0)
        assert 0.3 < result.nees < 3 and result.rms < 2 * result.rms_particles
        assert 1 < result.parts < 2


def test_errors_are_normalised_by_their_covariance():
    error = np.array([[3.0, 0.0], [0.0, 2.0]])
    assert normalised(error, np.array([np.diag([9.0, 1.0]), np.diag([1.0, 2.0])])) == pytest.approx([0.5, 1])


def test_the_table_has_a_row_for_each_plant(monkeypatch):
    monkeypatch.delenv("HNAV_PLANTS", raising=False)
    monkeypatch.setattr(observer_events, "PARTICLES", 10)
    monkeypatch.setattr(observer_events, "SUBSTEPS", 10)
    told = answered(main, "--runs", "1")
    assert told.returncode == 0 and "functions in Python" in told.stdout and "pendulum with a stop" in told.stdout
