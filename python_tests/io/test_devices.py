"""Files of devices and apps are read correctly, or refused with a remedy; none is read wrongly without an error."""

import bz2
import lzma

import h5py
import numpy as np
import pytest

import devices
import recorded
from hnav import Recording, read
from hnav.io.readers import read_aids
from hnav.io.recordings import RecordingError
from motion import tilted_motion

NO_FIELD = ("kitti", "mpu6050", "rostopic", "betaflight", "betaflight, decoded", "betaflight, units")
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


@pytest.mark.parametrize("suffix, pack", [("bz2", bz2.compress), ("xz", lzma.compress)])
def test_packed_files_are_those_that_were_packed(tmp_path, motion, suffix, pack):
    plain = recorded.x_io(tmp_path, motion)
    packed = tmp_path / f"x_io.csv.{suffix}"
    packed.write_bytes(pack(plain.read_bytes()))
    np.testing.assert_array_equal(read(packed).rate_b_rad_s, read(plain).rate_b_rad_s)


def test_files_of_matlab_7_3_are_read_by_the_names_of_their_variables(tmp_path, motion):
    """As MATLAB writes them: HDF5 behind a block of 512 bytes, matrices transposed, structs as groups."""
    path = tmp_path / "log.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in zip(("imu/gyr", "imu/acc", "imu/mag"), devices.vectors(motion)):
            file[name] = values.T
        file["imu/t"] = motion.t_s[None]
    head = path.read_bytes()
    path.write_bytes(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(512) + head[512:])
    found = read(path)
    np.testing.assert_array_equal(found.t_s, motion.t_s)
    np.testing.assert_allclose(found.rate_b_rad_s, motion.rate_b_rad_s)
    np.testing.assert_allclose(found.field_b_tesla, motion.field_b_tesla)


BEGIN_S = 1707566400.0  # 2024-02-10 12:00 UTC


def test_messages_of_a_u_blox_receiver(tmp_path):
    pyubx2 = pytest.importorskip("pyubx2")
    path = tmp_path / "log.ubx"

    def fix(k: int, **said: object) -> bytes:
        accuracies = {
            "fixType": 3,
            "lat": 45.5,
            "lon": 7.0 + 1e-5 * k,
            "height": 400_000,
            "hAcc": 1500,
            "vAcc": 2500,
            "velN": 1000,
            "velE": -500,
        }
        date = {"year": 2024, "month": 2, "day": 10, "hour": 12, "min": 0, "second": k // 4, "nano": 250_000_000 * (k % 4)}
        return pyubx2.UBXMessage("NAV", "NAV-PVT", 0, **date, **accuracies | {"velD": 100, "sAcc": 200} | said).serialize()

    path.write_bytes(b"".join([fix(0), fix(1), fix(2, fixType=0), b"$GNGGA,garbage\r\n", fix(3)]) + fix(4)[:50])
    aids = read_aids(path)
    np.testing.assert_allclose(aids["position"].t_s, BEGIN_S + np.array([0, 0.25, 0.75]))
    np.testing.assert_allclose(np.degrees(aids["position"].values[:, :2]), [[45.5, 7], [45.5, 7.00001], [45.5, 7.00003]])
    np.testing.assert_allclose(aids["position"].values[:, 2], 400)
    np.testing.assert_allclose(aids["position"].sigma, [[1.5, 1.5, 2.5]] * 3)
    np.testing.assert_allclose(aids["velocity"].values, [[1, -0.5, 0.1]] * 3)
    with pytest.raises(RecordingError, match="satellites alone.*--gnss"):
        read(path)
    path.write_bytes(fix(0, fixType=0))
    with pytest.raises(RecordingError, match="no message NAV-PVT with a fix"):
        read_aids(path)


def test_tracks_of_gpx(tmp_path):
    path = tmp_path / "ride.gpx"
    points = "".join(
        f'<trkpt lat="45.5" lon="{7 + 1e-5 * k}"><ele>{400 + k}</ele><time>2024-02-10T12:00:{k:02d}.500Z</time></trkpt>'
        for k in range(3)
    )
    head = '<?xml version="1.0"?><gpx xmlns="http://www.topografix.com/GPX/1/1"><trk><trkseg>'
    path.write_text(f"{head}{points}<trkpt lat='1' lon='2'/></trkseg></trk></gpx>")
    place = read_aids(path)["position"]
    np.testing.assert_allclose(place.t_s, BEGIN_S + np.array([0.5, 1.5, 2.5]))
    np.testing.assert_allclose(np.degrees(place.values[:, :2]), [[45.5, 7], [45.5, 7.00001], [45.5, 7.00002]])
    np.testing.assert_allclose(place.values[:, 2], [400, 401, 402])
    path.write_text(head + points)  # cut off
    assert len(read_aids(path)["position"].t_s) == 3
    path.write_text('<!DOCTYPE gpx [<!ENTITY a "b">]>' + head + points)
    with pytest.raises(RecordingError, match="it defines entities"):
        read_aids(path)


@pytest.mark.parametrize("shape", [recorded.xsens, recorded.dot])
@pytest.mark.parametrize("rate_hz", [None, 100.0])
def test_packets_that_xsens_has_lost_are_a_gap(tmp_path, motion, shape, rate_hz):
    """By the counter, also where the caller states the rate: the rows behind the loss were put right behind those before it."""
    path = shape(tmp_path, motion)
    lines = path.read_text().splitlines()
    path.write_text("\n".join(lines[:300] + lines[340:]) + "\n")
    recording = read(path, rate_hz=rate_hz)
    steps_s = np.diff(recording.t_s)
    assert len(recording.t_s) == len(motion.t_s) - 40
    np.testing.assert_allclose(steps_s.max(), 0.41, atol=1e-6)
    np.testing.assert_allclose(np.delete(steps_s, steps_s.argmax()), 0.01, atol=1e-6)
    np.testing.assert_allclose(recording.rate_b_rad_s[-1], motion.rate_b_rad_s[-1], rtol=1e-6)
    assert {one.code for one in recording.check() if one.level != "note"} == {"gaps"}
