"""Acceleration and gravity in columns of their own, as phones compute them, are the specific force together."""

import json

import numpy as np
import pandas as pd
import pytest

from hnav.io.readers import read
from motion import tilted_motion

G = 9.80665
OF_IOS = "negated because iOS gives the opposite of the force"
SHAPES = {  # names of rates, acceleration and gravity, unit of the last two, sign, note
    "OxIOD": ("rotation_rate_{}(radians/s)", "user_acc_{}(G)", "gravity_{}(G)", G, -1, OF_IOS),
    "MotionSense": ("rotationRate.{}", "userAcceleration.{}", "gravity.{}", G, -1, OF_IOS),
    "SensorLog": ("motionRotationRate{}(rad/s)", "motionUserAcceleration{}(G)", "motionGravity{}(G)", G, -1, OF_IOS),
    "Android": ("gyro_{}", "linear_acceleration_{}", "gravity_{}", 1.0, 1, "gravity_x"),
    "of two units": ("gyro_{}", "linear_acc_{} (m/s2)", "gravity_{} (g)", (1.0, G), 1, "gravity_x (g)"),
}


@pytest.fixture(scope="module")
def motion():
    return tilted_motion(1).recording


def parts(motion, shape):
    rates, rest, gravity, unit, sign, _ = SHAPES[shape]
    whole = motion.force_b_m_s2
    down = G * whole / np.linalg.norm(whole, axis=1)[:, None]
    of_rest, of_gravity = unit if isinstance(unit, tuple) else (unit, unit)
    axes = "XYZ" if shape == "SensorLog" else "xyz"
    names = ["t", *(name.format(axis) for name in (rates, gravity, rest) for axis in axes)]
    return pd.DataFrame(
        np.column_stack([motion.t_s, motion.rate_b_rad_s, sign * down / of_gravity, sign * (whole - down) / of_rest]),
        columns=names,
    )


@pytest.mark.parametrize("shape", SHAPES)
def test_acceleration_and_gravity_are_summed_to_the_force_and_a_note_says_so(tmp_path, motion, shape):
    parts(motion, shape).to_csv(tmp_path / "walk.csv", index=False)
    recording = read(tmp_path / "walk.csv")
    np.testing.assert_allclose(recording.force_b_m_s2, motion.force_b_m_s2, rtol=1e-9, atol=1e-9)
    (note,) = (note for note in recording.origin.notes if note.startswith("accel: sum of"))
    assert note.endswith(SHAPES[shape][-1])


def test_records_of_a_phone_hold_both_parts_too(tmp_path, motion):
    frame = parts(motion, "MotionSense").to_numpy().tolist()
    names = ("rotationRate", "gravity", "userAcceleration")
    records = [
        {"timestamp": row[0]} | {name: dict(zip("xyz", row[3 * i + 1 :])) for i, name in enumerate(names)} for row in frame
    ]
    (tmp_path / "walk.json").write_text(json.dumps(records))
    np.testing.assert_allclose(read(tmp_path / "walk.json").force_b_m_s2, motion.force_b_m_s2, rtol=1e-9, atol=1e-9)


def test_a_whole_force_is_not_added_to_the_gravity_beside_it(tmp_path, motion):
    frame = parts(motion, "Android")
    frame[["acc_x", "acc_y", "acc_z"]] = motion.force_b_m_s2
    frame.to_csv(tmp_path / "walk.csv", index=False)
    recording = read(tmp_path / "walk.csv")
    np.testing.assert_allclose(recording.force_b_m_s2, motion.force_b_m_s2, rtol=1e-9)
    assert not any("sum of" in note for note in recording.origin.notes)


def test_without_gravity_an_acceleration_is_no_force(tmp_path, motion):
    frame = parts(motion, "OxIOD")
    frame.drop(columns=[name for name in frame if "gravity" in name]).to_csv(tmp_path / "walk.csv", index=False)
    assert "gravity_removed" in {finding.code for finding in read(tmp_path / "walk.csv").check()}


@pytest.mark.parametrize(("platform", "sign"), [("android", 1), ("ios", -1)])
def test_gravity_in_records_of_its_own_is_added_with_the_sign_of_the_phone(tmp_path, motion, platform, sign):
    """Sensor Logger as JSON."""
    down = motion.force_b_m_s2 + [0.5, 0, 0]
    by_sensor = {"Accelerometer": sign * (motion.force_b_m_s2 - down), "Gravity": sign * down, "Gyroscope": motion.rate_b_rad_s}
    records = [{"sensor": "Metadata", "platform": platform, "standardisation": "false"}]
    for sensor, rows in by_sensor.items():
        records += [{"sensor": sensor, "seconds_elapsed": t} | dict(zip("xyz", row)) for t, row in zip(motion.t_s, rows.tolist())]
    (tmp_path / "walk.json").write_text(json.dumps(records))
    recording = read(tmp_path / "walk.json")
    np.testing.assert_allclose(recording.force_b_m_s2, motion.force_b_m_s2, atol=1e-9)
    note = "accel: sum of accelerometer and gravity" + (f", {OF_IOS}" if sign < 0 else "")
    assert note in recording.origin.notes


@pytest.mark.parametrize("platform, sign", [("ios", -1), ("android", 1)])
def test_records_of_sensor_logger_are_summed_by_their_platform(tmp_path, motion, platform, sign):
    gravity = np.broadcast_to([0.0, 0.0, G], motion.force_b_m_s2.shape)
    rest = 0.1 * (motion.force_b_m_s2 - gravity)
    named = {"Gyroscope": motion.rate_b_rad_s, "Accelerometer": sign * rest, "Gravity": sign * gravity}
    records = [{"sensor": "Metadata", "platform": platform, "standardisation": "false"}]
    for name, values in named.items():
        rows = zip(motion.t_s.tolist(), values.tolist())
        records += [{"sensor": name, "seconds_elapsed": t, "time": int(1e9 * t), **dict(zip("xyz", row))} for t, row in rows]
    (tmp_path / "walk.json").write_text(json.dumps(records))
    np.testing.assert_allclose(read(tmp_path / "walk.json").force_b_m_s2, rest + gravity, rtol=1e-9, atol=1e-9)
