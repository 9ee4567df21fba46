"""What rostopic echo -p writes: inertial messages and fixes of satellites."""

import numpy as np
import pytest

from hnav.io.readers import read, read_aids
from hnav.io.recordings import RecordingError

FIX = ["%time", "field.header.seq", "field.header.stamp", "field.header.frame_id", "field.status.status", "field.status.service",
       "field.latitude", "field.longitude", "field.altitude", *(f"field.position_covariance{i}" for i in range(9)),
       "field.position_covariance_type"]  # fmt: skip
IMU = ["%time", "field.header.seq", "field.header.stamp", "field.header.frame_id",
       *(f"field.{kind}.{axis}" for kind in ("angular_velocity", "linear_acceleration") for axis in "xyz")]  # fmt: skip
SECOND = 10**9
BEGIN = 1767261600 * SECOND


def written(path, names, rows):
    path.write_text("\n".join([",".join(names), *(",".join(map(str, row)) for row in rows)]) + "\n")
    return path


def fix(i, status=0, kind=2, stamp=True):
    covariance = [4.0, 0, 0, 0, 9.0, 0, 0, 0, 25.0]
    measured = BEGIN + i * SECOND
    return [
        measured + SECOND // 10,
        i,
        measured if stamp else 0,
        "gps",
        status,
        1,
        48 + 1e-5 * i,
        11.5,
        500 + i,
        *covariance,
        kind,
    ]


def test_fixes_have_their_header_stamps_sigmas_and_status(tmp_path):
    path = written(tmp_path / "fix.csv", FIX, [fix(0), fix(1, status=-1), fix(2, kind=0)])
    position = read_aids(path)["position"]
    np.testing.assert_array_equal(position.t_s, [BEGIN / SECOND, BEGIN / SECOND + 2])
    np.testing.assert_allclose(
        position.values, [[*np.radians([48, 11.5]), 500], [*np.radians([48.00002, 11.5]), 502]], rtol=1e-15
    )
    np.testing.assert_array_equal(position.sigma, [[3, 2, 5], [np.nan] * 3])


def test_without_header_stamps_the_arrival_counts(tmp_path):
    position = read_aids(written(tmp_path / "fix.csv", FIX, [fix(i, stamp=False) for i in range(3)]))["position"]
    np.testing.assert_allclose(position.t_s, BEGIN / SECOND + np.arange(3) + 0.1, rtol=1e-15)


@pytest.mark.parametrize("stamped, late_s", [(True, 0.0), (False, 0.003)])
def test_inertial_messages_go_by_the_stamp_and_have_their_units(tmp_path, stamped, late_s):
    times = [BEGIN + 10_000_000 * i for i in range(100)]
    rows = [[t + 3_000_000, i, t if stamped else 0, "imu", 0.1, 0, 0, 0, 0, 9.8] for i, t in enumerate(times)]
    data = read(written(tmp_path / "imu.csv", IMU, rows))
    np.testing.assert_allclose(data.t_s, np.array(times) * 1e-9 + late_s, rtol=0, atol=1e-6)
    assert [str(data.origin.units[one]) for one in ("gyro", "accel")] == ["rad/s by format", "m/s2 by format"]


def test_columns_are_given_by_their_names_in_the_file(tmp_path):
    rows = [[BEGIN + 10_000_000 * i, i, 0, "imu", 0.1, 0.2, 0.3, 0, 0, 9.8] for i in range(100)]
    swapped = {"gx": "field.angular_velocity.y", "gy": "field.angular_velocity.x", "gz": "field.angular_velocity.z"}
    data = read(written(tmp_path / "imu.csv", IMU, rows), columns=swapped)
    np.testing.assert_array_equal(data.rate_b_rad_s[0], [0.2, 0.1, 0.3])


def test_fixes_alone_are_no_recording_and_one_without_a_latitude_is_none(tmp_path):
    path = written(tmp_path / "fix.csv", FIX, [fix(0)])
    with pytest.raises(RecordingError, match="holds satellites alone.*--gnss"):
        read(path)
    without = ["none" if cell == 48 + 1e-5 else cell for cell in fix(1)]
    position = read_aids(written(tmp_path / "spoilt.csv", FIX, [fix(0), without, fix(2)]))["position"]
    np.testing.assert_array_equal(position.t_s, [BEGIN / SECOND, BEGIN / SECOND + 2])
