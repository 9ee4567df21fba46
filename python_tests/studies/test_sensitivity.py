"""The sensitivity of the score to each parameter."""

import numpy as np
import pytest

from command_line import answered
from hnav.fmi.engines import run_recording
from hnav.reports.scores import score
from studies.command import main_of
from studies.sensitivity import mean_error_deg, tuned_options

main = main_of("sensitivity")


@pytest.fixture(scope="module")
def trials(broad_trials):
    from hnav.io.readers import read

    return [read(path) for path in list(broad_trials.values())[:2]]


@pytest.mark.parametrize("filter", ["ahrs", "hrekf"])
def test_parameters_are_numbers_that_a_factor_can_move(filter):
    parameters = tuned_options(filter)
    assert len(parameters) > 10 and "start_q_nb" not in parameters and "queue_capacity" not in parameters
    assert all(np.isfinite(value) and value != 0 for value in parameters.values())


def test_the_error_with_the_defaults_is_that_of_the_score(trials):
    settings = {"navigation_frame": "enu", "gyro_hold": "backward", "solver": "closed_form"}
    totals = [score(run_recording(r, "ahrs", settings=settings).q_nb, r.reference_q_nb, r.movement).total for r in trials]
    assert mean_error_deg(trials, "ahrs") == pytest.approx(np.mean(totals), abs=1e-12)


def test_a_folder_without_trials_is_one_line_and_exit_code_2(tmp_path):
    done = answered(main, tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith("study sensitivity: ") and done.stderr.count("\n") == 1
