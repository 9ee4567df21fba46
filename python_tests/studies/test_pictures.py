"""The pictures of README and docs."""

import numpy as np
import pytest

from command_line import answered
from hnav.io.readers import read
from studies.command import main_of
from studies.pictures import circle, hybrid, overview

main = main_of("pictures")


def test_the_picture_of_the_readme_is_made_by_a_command(broad_trials, tmp_path):
    if overview.TRIAL not in broad_trials:
        pytest.skip(f"BROAD_DIR has no trial {overview.TRIAL:02d}")
    folder = broad_trials[overview.TRIAL].parent
    picture = tmp_path / "overview.png"
    done = answered(main, "overview", "--broad", folder, "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert picture.stat().st_size < 200_000


def test_a_folder_without_trials_gets_one_line(tmp_path):
    done = answered(main, "overview", "--broad", tmp_path, "--out", tmp_path)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1 and "BROAD" in done.stderr


def test_sigma_grows_between_samples_and_falls_at_them(broad_trials):
    recording = read(next(iter(broad_trials.values())))
    zoom = hybrid.look_between(recording, 10.0, 0.05, {"navigation_frame": "enu"})
    sum_of_squares = (zoom.sigma_rad**2).sum(axis=1)
    at_jump = np.zeros(len(zoom.t_s) - 1, bool)
    at_jump[zoom.after_jump[1:] - 1] = True
    assert (np.diff(sum_of_squares)[at_jump] < 0).all()
    assert (np.diff(sum_of_squares)[~at_jump] > 0).all()


def test_the_heading_on_the_circle_is_found():
    alpha = np.linspace(-np.pi, np.pi, 720, endpoint=False)
    peaks = [circle.density(alpha, m, S) for m, S in circle.posteriors()]
    assert np.allclose(peaks[0], 1 / (2 * np.pi))
    assert all(np.isclose(p.sum() * (alpha[1] - alpha[0]), 1) for p in peaks)
    assert abs(np.remainder(alpha[peaks[-1].argmax()] - circle.HEADING_RAD + np.pi, 2 * np.pi) - np.pi) < np.radians(20)
    assert peaks[-1].max() > 2 * peaks[1].max()
