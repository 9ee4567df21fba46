"""The study of the calibration's stated error: a short sample of it, and its figures."""

import numpy as np
import pandas as pd
import pytest

from command_line import answered
from studies.calibration import COVERAGES, answer, attitudes, row
from studies.command import main_of

main = main_of("calibration")

SHORT = [(c, noise, outliers) for c in COVERAGES for noise, outliers in ((0.002, 0.0), (0.005, 0.2), (0.02, 0.05))]


def test_nine_of_ten_errors_are_below_the_stated_one_and_no_note_is_empty():
    answers = [found for case in SHORT for seed in range(500, 508) if (found := answer(*case, seed)) is not None]
    assert len(answers) > 80
    found = pd.DataFrame(answers)
    covered = found.error_deg <= found.stated_deg
    assert covered.mean() >= 0.9
    assert found.error_deg.max() < 3 and found.note.all()
    # Where the rotation was given up its error is stated too: it is the larger part.
    assert covered[found.gave_up].mean() >= 0.7


def test_one_axis_and_little_tilt_are_refused():
    assert not any(answer(c, 0.005, 0.0, seed) for c in ("yaw only", "tilt 10 deg") for seed in range(6))


@pytest.mark.parametrize("coverage", COVERAGES)
def test_attitudes_have_the_tilt_that_they_are_called_by(coverage):
    down = attitudes(coverage, np.random.default_rng(1)).apply([0, 0, 1.0], inverse=True)
    tilt_deg = np.degrees(np.arctan2(np.linalg.norm(down[:, :2], axis=1), down[:, 2]))
    largest = {"every attitude": 180, "yaw only": 0, "one pole": 90, "tilt 60 deg": 76, "tilt 10 deg": 14.2}
    assert tilt_deg.max() <= largest.get(coverage, 60) + 1e-6
    assert tilt_deg.max() >= 0.5 * largest.get(coverage, 45)


def test_a_row_says_shares_and_root_mean_squares():
    found = [dict(error_deg=0.3, stated_deg=0.4, gave_up=False), None, dict(error_deg=0.4, stated_deg=0.3, gave_up=True)]
    assert row(found) == ("2 of 3", "1", "0.35", "0.40", "0.35", "50%")
    assert row([None, None])[0] == "0 of 2"


def test_the_command_prints_the_table():
    done = answered(main, "--recordings", 1)
    assert done.returncode == 0, done.stderr
    assert "covered" in done.stdout and "empty note: 0" in done.stdout
