"""The noise of sensors at rest: known noise is found within the stated bounds, and what the length cannot show is said."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import recorded
from command_line import hnav
from hnav import HnavError, read
from hnav.filters.noise import ENTRIES, TERMS, noise_of, still_parts
from hnav.io.sensors import ENTRIES as OF_FILES
from hnav.io.sensors import Correction, read_grade, write_sensor
from studies.noise import DEG, GRADES, at_rest, bounds

pytest.importorskip("allantools", reason="allantools is not installed")


def test_known_noise_lies_within_the_stated_bounds():
    """10 recordings of 10 min of each of three grades, three axes: of 270 bounds 95 % hold. ./run study noise does 200 of each."""
    found = {grade: bounds(grade, 10, 600.0) for grade in GRADES}
    held = {name: np.mean([of[name][0] for of in found.values()]) for name in TERMS}
    stated = {name: np.mean([of[name][1] for of in found.values()]) for name in TERMS}
    assert min(held.values()) > 0.92 and np.mean(list(held.values())) >= 0.95, held
    assert stated["white"] == 1 and stated["instability"] > 0.7 and stated["walk"] < 0.5
    assert max(abs(of["white"][2] - 1) for of in found.values()) < 0.05


def test_a_longer_recording_shows_more():
    short, night = (noise_of([at_rest(1, "wandering", length_s, 20.0)])["gyro"] for length_s in (120.0, 6 * 3600.0))
    assert not short.terms["walk"].is_measured.any() and night.terms["walk"].is_measured.all()
    for name, true in zip(TERMS, GRADES["wandering"]):
        assert ((night.terms[name].high - night.terms[name].low) < (short.terms[name].high - short.terms[name].low)).all()
        assert ((night.terms[name].low <= 1.1 * true) & (true <= 1.1 * night.terms[name].high)).all(), name


def test_still_parts_are_those_in_which_nothing_moves():
    whole = at_rest(3, "consumer", 300.0)
    t_s = whole.t_s
    moved = ((t_s > 60) & (t_s < 90)) | ((t_s > 200) & (t_s < 205))
    turning = (t_s > 240)[:, None] * [0, 0, 0.1]
    rate = whole.rate_b_rad_s + moved[:, None] * np.sin(3 * t_s)[:, None] + turning
    parts = still_parts(replace(whole, rate_b_rad_s=rate))
    spans = [(t[0], t[-1]) for t, _ in parts["gyro"]]
    np.testing.assert_allclose(spans, [(0, 60), (90, 200), (205, 240)], atol=1.0)
    assert [len(t) for t, _ in parts["accel"]] == [len(t) for t, _ in parts["gyro"]]
    with pytest.raises(HnavError, match="no part of 20 s in which the body is still"):
        noise_of([replace(whole, rate_b_rad_s=rate + np.sin(3 * t_s)[:, None])])
    # Parts and recordings of one device count together.
    joined = noise_of([replace(whole, rate_b_rad_s=rate), at_rest(4, "consumer", 100.0)])["gyro"]
    assert joined.length_s == pytest.approx(60 + 110 + 35 + 100, abs=3)


def test_the_command_writes_a_sensor_file_that_is_one(tmp_path):
    recording = replace(
        at_rest(5, "consumer", 300.0),
        field_b_tesla=[2e-5, 0, 4e-5] + np.random.default_rng(1).normal(scale=5e-7, size=(30000, 3)),
    )
    path = recorded.house(tmp_path, recording)
    out, page = tmp_path / "sensor.json", tmp_path / "noise.html"
    write_sensor(out, {"mag": Correction(2 * np.eye(3), np.zeros(3))}, "mine")
    done = hnav("noise", path, "--gyro-unit", "rad/s", "--out", out, "--report", page)
    assert done.returncode == 0, done.stderr
    assert "random walk" in done.stdout and "too short for the" in done.stdout and page.stat().st_size > 1e6
    stated = json.loads(out.read_text())
    assert (
        stated["gyro"]["noise"]["value"] == pytest.approx(7e-3, rel=0.05) and stated["gyro"]["noise"]["unit"] == "deg/s/sqrt(Hz)"
    )
    assert stated["gyro"]["period"] == {"value": 10.0, "unit": "ms"} and "random_walk" not in stated["gyro"]
    assert stated["mag"]["noise"]["value"] == pytest.approx(50, rel=0.05)
    assert read_grade(out).corrections["mag"].matrix[0, 0] == 2 and stated["name"] == "mine"
    # Every entry and unit is one of the format, and means the same there.
    for sensor, entries in ENTRIES.items():
        for entry, unit, _ in entries.values():
            assert unit in OF_FILES[sensor][entry][1], (sensor, entry)
    moving = hnav("noise", recorded.house(tmp_path, replace(recording, rate_b_rad_s=np.sin(recording.t_s)[:, None] * np.ones(3))))
    assert moving.returncode == 2 and "leave it lying longer" in moving.stderr


def test_a_trial_has_still_parts_from_which_the_noise_of_its_chip_comes(broad_trials):
    """The ICM of the sets: the datasheet has 0.015 deg/s/sqrt(Hz) at most."""
    found = noise_of([read(path) for path in list(broad_trials.values())[:3]])
    density = found["gyro"].terms["white"].value / DEG
    assert ((density > 1e-3) & (density < 2e-2)).all(), density
