"""Two public recordings of commercial IMUs with the device's own attitude beside the raw sensors.

They lie as test data inside a wheel of the package scikit-kinematics (BSD licence), which is fetched by pip, checked
by its hash and read in place; nothing is installed. Neither file says in which frames and units it is written: each
reader below states what was found and the evidence, and brings the recording to SI units, east-north-up and
body-to-navigation.
"""

from __future__ import annotations

import csv
import hashlib
import io
import os
import subprocess
import sys
import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.constants import g as GRAVITY_M_S2
from scipy.spatial.transform import Rotation

from hnav.errors import HnavRuntimeError
from hnav.io.recordings import Recording
from hnav.places import CHECKOUT

PACKAGE, VERSION = "scikit-kinematics", "0.10.4"
WHEEL = "scikit_kinematics-0.10.4-py3-none-any.whl"
WHEEL_SHA256 = "8433f469dd95d0398ca1297f94be419b8873ceb7e510832c7ce3754400d0c7d9"
WHEEL_VARIABLE = "HNAV_DEMO_WHEEL"
PATIENCE_S = 60.0

TESLA_PER_GAUSS = 1e-4
# An arbitrary unit needs some scale: the filter divides by the reference strength, so this one cancels.
TESLA_PER_ARBITRARY_UNIT = 50e-6

# North-west-up axes expressed in east-north-up: north is the second axis, west the negative first.
ENU_FROM_NWU = Rotation.from_euler("z", 90, degrees=True)


class WheelUnavailable(HnavRuntimeError):
    """The wheel with the recordings is not available; the text says how to provide it."""

    def __init__(self, text: str):
        super().__init__("no data", text)

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (str(self),)


@dataclass(frozen=True)
class DeviceRecording:
    """A recording, its frames and units."""

    recording: Recording  # the reference attitude is the device's own estimate, not ground truth
    findings: tuple[str, ...]


# --------------------------------------------------------------------------------------------- the wheel


def find_wheel() -> Path:
    """The wheel's path: HNAV_DEMO_WHEEL, else the cache, else fetched into the cache. Raises WheelUnavailable."""
    given = os.environ.get(WHEEL_VARIABLE)
    if given:
        wheel = Path(given)
        if not wheel.is_file():
            raise WheelUnavailable(f"{WHEEL_VARIABLE}: no file {wheel}")
        check_hash(wheel)
        return wheel
    wheel = cache_folder() / WHEEL
    if not wheel.is_file():
        download(wheel.parent)
    check_hash(wheel)
    return wheel


def cache_folder() -> Path:
    """.cache at the top of a checkout, else the user's cache folder."""
    if (CHECKOUT / "pyproject.toml").is_file():
        return CHECKOUT / ".cache"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "hnav"


def download(folder: Path) -> None:
    """Downloads the wheel into the folder with pip, from its configured index."""
    folder.mkdir(parents=True, exist_ok=True)
    asked = ["--quiet", "--disable-pip-version-check", "--no-deps", "--only-binary=:all:", "--retries=1", "--timeout=10"]
    command = [sys.executable, "-m", "pip", "download", *asked, "--dest", str(folder), f"{PACKAGE}=={VERSION}"]
    try:
        done = subprocess.run(command, capture_output=True, timeout=PATIENCE_S, check=False)
        fetched = done.returncode == 0 and (folder / WHEEL).is_file()
    except subprocess.TimeoutExpired:
        fetched = False
    if not fetched:
        raise WheelUnavailable(
            f"the demo's recordings are in the wheel of {PACKAGE} {VERSION}, which pip could not fetch (no network?): "
            f"get {WHEEL} elsewhere and set {WHEEL_VARIABLE}=path/to/{WHEEL}"
        )


def check_hash(wheel: Path) -> None:
    """Raises WheelUnavailable when the file is not the pinned wheel."""
    found = hashlib.sha256(wheel.read_bytes()).hexdigest()
    if found != WHEEL_SHA256:
        raise WheelUnavailable(
            f"{wheel} is not {PACKAGE} {VERSION}: its sha256 starts with {found[:12]}, expected {WHEEL_SHA256[:12]}; "
            f"delete it or set {WHEEL_VARIABLE}"
        )


# --------------------------------------------------------------------------------------------- the readers


def read_xsens(wheel: Path) -> DeviceRecording:
    """data_xsens.txt: a person walking, 953 rows of an Xsens device at 50 Hz.

    Units   rate rad/s (a least-squares fit to the quaternion's derivative gives 1.00 I within 0.01), force m/s2 (median
            norm 9.76), field arbitrary (norm 0.6 to 1.6: disturbed by a factor of 2.7).
    Frames  the quaternion turns sensor vectors into north-west-up: turned by it, force has the median (0.01, 0.02,
            9.72), and the mean field azimuth is -2 deg from +x; the inverse leaves force scattered over 150 deg.
    Time    the rate of row k is that between the quaternions k-1 and k: median misfit 0.6 deg/s, against 10.8 deg/s
            for k to k+1. Each rate is a mean over the past interval, what gyro_hold=backward is for.
    """
    rows = np.loadtxt(_lines(wheel, "tests/data/data_xsens.txt"), skiprows=5)
    q_enu = _to_enu(Rotation.from_quat(rows[:, [11, 12, 13, 10]]))
    t_s = (rows[:, 0] - rows[0, 0]) / 50.0  # the counter has no gap
    recording = Recording("Xsens, walking", t_s, rows[:, 4:7], rows[:, 1:4], rows[:, 7:10] * TESLA_PER_ARBITRARY_UNIT, q_enu)
    return DeviceRecording(
        recording,
        findings=(
            "device quaternion: sensor to north-west-up, north is magnetic, scalar first",
            "rate rad/s, mean over the past interval; force m/s²",
            "field in arbitrary units, disturbed: its norm changes by a factor of 2.7",
        ),
    )


def read_x_imu(wheel: Path) -> DeviceRecording:
    """data_xio: an x-IMU lying, then worn by somebody who turns seven times, 49 s at 256 Hz.

    Units   rate deg/s (fit to the quaternion's derivative 1.00 I within 0.02), force g (median norm 1.01), field gauss
            by its header (norm 0.10 to 0.46: disturbed).
    Time    256 rows per second of the device's own clock, and its packet numbers have no gap: row k is at k/256 s. The
            quaternion comes after every second row. The first row was left over in the device's buffer (its field is
            0.13 gauss off all that follow) and is dropped. A third of the fields while moving are exact repeats of
            the one before, those of rate and force never: the magnetometer is slower, repeats are no samples.
    Frames  the quaternion is earth to sensor: inverted, force has the median (0.00, -0.03, 0.99) g; not inverted it
            points down. Its earth frame is turned by the register AlgorithmTareQuat (150 deg of heading, 1.8 deg of
            tilt): with the tare undone on the earth side force has the median (0.005, 0.001, 0.991) g, the field of
            the rest phases azimuth 0.1 deg, and the first attitude is level and north: north-west-up.
    """
    folder = "tests/data/data_xio/00033_"
    rows = np.loadtxt(_lines(wheel, folder + "CalInertialAndMag.csv"), delimiter=",", skiprows=1)[1:]
    packets = np.loadtxt(_lines(wheel, folder + "Quaternion.csv"), delimiter=",", skiprows=1)
    registers = {row["Name"]: row["Fixed-point value"] for row in csv.DictReader(_lines(wheel, folder + "Registers.csv"))}

    tare = Rotation.from_quat([float(registers[f"AlgorithmTareQuat{i}"]) for i in (1, 2, 3, 0)])
    # Each quaternion belongs to the inertial row before it.
    row_of_packet = np.searchsorted(rows[:, 0], packets[:, 0]) - 1
    packets, row_of_packet = packets[row_of_packet >= 0], row_of_packet[row_of_packet >= 0]
    q_enu = np.full((len(rows), 4), np.nan)
    q_enu[row_of_packet] = _to_enu(tare * Rotation.from_quat(packets[:, [2, 3, 4, 1]]).inv())

    field_gauss = rows[:, 7:10].copy()
    field_gauss[1:][(np.diff(rows[:, 7:10], axis=0) == 0).all(axis=1)] = np.nan
    t_s, rate, force = np.arange(len(rows)) / 256.0, np.radians(rows[:, 1:4]), rows[:, 4:7] * GRAVITY_M_S2
    recording = Recording("x-IMU, worn", t_s, rate, force, field_gauss * TESLA_PER_GAUSS, q_enu)
    return DeviceRecording(
        recording,
        findings=(
            "device quaternion: north-west-up to sensor, scalar first, at every second row,",
            "turned by the tare of 150 deg in the device's registers (undone here)",
            "rate deg/s, force g, field gauss; a field equal to the one before is no sample",
            "field disturbed: its norm changes by a factor of 4.7",
        ),
    )


def _to_enu(sensor_to_nwu: Rotation) -> np.ndarray:
    """Quaternions n x 4, scalar first, sensor to east-north-up."""
    scalar_last: np.ndarray = (ENU_FROM_NWU * sensor_to_nwu).as_quat()
    return scalar_last[:, [3, 0, 1, 2]]


def _lines(wheel: Path, member: str) -> io.TextIOBase:
    """A text file inside the wheel, whole: the files are small."""
    with zipfile.ZipFile(wheel) as archive:
        return io.StringIO(archive.read(member).decode("utf-8"), newline=None)
