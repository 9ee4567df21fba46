"""What devices and apps write is read as it was measured, or refused in a sentence that helps; nothing is read wrong in silence."""

import numpy as np
import pytest

import devices
from hnav import Recording, read
from motion import tilted_motion

NO_FIELD = ("mpu6050", "rostopic", "betaflight", "betaflight, decoded")
NEEDS = {"ardupilot": "pymavlink", "ardupilot text": "pymavlink"}


@pytest.fixture(scope="module")
def motion() -> Recording:
    return tilted_motion(12).recording


@pytest.mark.parametrize("shape", devices.SHAPES)
def test_every_shape_is_read_as_it_was_measured(tmp_path, motion, shape):
    if shape in NEEDS:
        pytest.importorskip(NEEDS[shape])
    recording = read(devices.SHAPES[shape](tmp_path, motion))
    for sensor in ("gyro", "accel", "mag"):
        t_s, values = recording.samples(sensor)
        if sensor == "mag" and shape in NO_FIELD:
            assert recording.field_b_tesla is None
            continue
        expected_s, expected = motion.samples(sensor)
        expected_s, expected = expected_s[: len(t_s)], expected[: len(t_s)]
        np.testing.assert_allclose(
            t_s - t_s[0], expected_s - expected_s[0], rtol=0, atol=1.1e-3 if shape == "movesense" else 2e-6
        )
        np.testing.assert_allclose(values, expected, rtol=1e-6, atol=2e-6 * np.abs(expected).max())
        assert len(t_s) >= len(motion.t_s) - 4
    assert not [str(finding) for finding in recording.check() if finding.level != "note"]
