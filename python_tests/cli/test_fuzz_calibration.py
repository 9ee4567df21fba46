"""Sensor files that others wrote, as hnav filter reads them: whole, or refused in one line that names the file."""

import copy
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from command_line import hnav
from fuzzing import DEEP, bounded, damaged, json_values, with_another_value
from hnav.errors import HnavError
from hnav.filters.calibration import calibrate_magnetometer
from hnav.io.sensors import read_grade, write_sensor


@pytest.fixture(scope="module")
def good(tmp_path_factory) -> dict:
    rng = np.random.default_rng(1)
    directions = rng.normal(size=(500, 3))
    field = directions / np.linalg.norm(directions, axis=1)[:, None] * 5e-5 + [1e-6, 0, 0]
    path = tmp_path_factory.mktemp("good") / "good.json"
    found = calibrate_magnetometer(field)
    write_sensor(path, {"mag": found.correction, "gyro": {"noise": {"value": 7, "unit": "mdeg/s/sqrt(Hz)"}}})
    np.testing.assert_array_equal(read_grade(path).corrections["mag"].offset, found.offset)
    return json.loads(path.read_text())


def read_or_one_line(path) -> None:
    try:
        found = read_grade(path)
    except HnavError as error:
        assert "some.json" in str(error) and "\n" not in str(error)
    else:
        assert all(np.isfinite(one.apply(np.array([1e-5, 0, 0]))).all() for one in found.corrections.values())
        assert np.isfinite(list(found.values.values())).all()


@bounded
@given(data=st.data())
def test_a_calibration_with_any_value_in_any_place_is_read_or_refused(good, tmp_path_factory, data):
    path = tmp_path_factory.mktemp("any") / "some.json"
    other = with_another_value(copy.deepcopy(good), data) if data.draw(st.booleans()) else data.draw(json_values)
    path.write_text(json.dumps(other))
    read_or_one_line(path)


@bounded
@given(seed=st.integers(0, 2**32))
def test_a_damaged_calibration_is_read_or_refused(good, tmp_path_factory, seed):
    path = tmp_path_factory.mktemp("damaged") / "some.json"
    path.write_bytes(damaged(json.dumps(good).encode(), seed))
    read_or_one_line(path)


@pytest.mark.parametrize("text", [DEEP, "{}", "", "\xff", '{"name": "x", "mag": {"calibration": {}}}'])
def test_a_calibration_that_is_none_is_one_line_of_the_command(tmp_path, text):
    recording, path = tmp_path / "x.csv", tmp_path / "some.json"
    recording.write_text("t_s,gx,gy,gz,ax,ay,az,mx,my,mz\n0,0,0,0,0,0,-9.81,1,0,1\n0.01,0,0,0,0,0,-9.81,1,0,1\n")
    path.write_text(text, encoding="latin-1")
    done = hnav("filter", recording, "--sensor", path, "--out", tmp_path / "out.csv")
    assert done.returncode == 2 and "some.json" in done.stderr and len(done.stderr.splitlines()) == 1, done.stderr
    assert not (tmp_path / "out.csv").exists()
