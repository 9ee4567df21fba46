"""Whether the observer's sigmas are right: a sample of the study."""

import numpy as np
import pytest

from command_line import answered
from studies.observer import main, normalised, results


def test_the_mean_error_of_a_few_runs_is_as_told(monkeypatch):
    monkeypatch.delenv("HNAV_PLANTS", raising=False)
    (result,) = results(5)
    # Of 900 corrections whose errors hang together for some ten of them.
    assert 0.7 < result.nees < 1.4 and 0.85 < result.nis < 1.15
    assert result.us_per_sample > 0


def test_errors_are_normalised_by_their_covariance():
    error = np.array([[3.0, 0.0], [0.0, 2.0]])
    assert normalised(error, np.array([np.diag([9.0, 1.0]), np.diag([1.0, 2.0])])) == pytest.approx([0.5, 1])


def test_the_table_has_a_row_for_each_plant(monkeypatch):
    monkeypatch.delenv("HNAV_PLANTS", raising=False)
    told = answered(main, "--runs", "1")
    assert told.returncode == 0 and "functions in Python" in told.stdout
