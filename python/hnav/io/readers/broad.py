"""Trials of BROAD, HDF5 and MAT.

BROAD: D. Laidig, M. Caruso, A. Cereatti, T. Seel, "BROAD - A Benchmark for Robust Inertial Orientation Estimation",
Data 6(7):72, 2021, doi 10.3390/data6070072. Its reference attitude is optical, sensor to east-north-up.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from hnav.io.mat_file import read_mat
from hnav.io.readers.records import HDF5_MAGIC, is_hdf5, read_mat_variables
from hnav.io.readers.streams import Raw, Stream, Wishes, cannot_be_read
from hnav.io.recordings import RecordingError

TRIAL_NAME = re.compile(r"(\d\d)_(un)?disturbed_")


def find_trials(folder: str | Path) -> dict[int, Path]:
    """Trial number to file, for all BROAD trials below the folder; HDF5 is preferred to MAT, which has the same numbers."""
    if not Path(folder).is_dir():
        raise RecordingError(f"{folder}: no such folder")
    found: dict[int, Path] = {}
    for pattern in ("*.mat", "*.hdf5"):
        for path in sorted(Path(folder).rglob(pattern)):
            if match := TRIAL_NAME.match(path.name):
                found[int(match.group(1))] = path
    if not found:
        raise RecordingError(f"{folder}: no BROAD trials (NN_undisturbed_*.hdf5, NN_disturbed_*.mat)")
    return dict(sorted(found.items()))


def is_disturbed(name: str) -> bool:
    """Whether a BROAD trial of this name was recorded in a disturbed field."""
    match = TRIAL_NAME.match(name)
    return match is not None and match.group(2) is None


def find_trial(folder: str | Path, number: int) -> Path:
    """The file of one BROAD trial below the folder. Raises RecordingError."""
    trials = find_trials(folder)
    if number not in trials:
        raise RecordingError(f"{folder}: no BROAD trial {number:02d}")
    return trials[number]


def is_broad(path: Path, head: bytes) -> bool:
    return head.startswith((HDF5_MAGIC, b"MATLAB 5.0")) or path.suffix in (".hdf5", ".mat")


def read_broad(path: Path, wishes: Wishes) -> Raw:
    """One trial. Its field is in microtesla, and its rows are at equal intervals."""
    contents = _contents(path)
    if contents is None:
        return read_mat_variables(path, wishes)
    data, rate_hz = contents
    if not 0 < rate_hz < np.inf:
        raise RecordingError(f"{path}: not a BROAD trial: sampling_rate = {rate_hz:g} Hz")
    n = np.shape(data["imu_gyr"])[0] if np.ndim(data["imu_gyr"]) else 0

    def array(name: str, *shape: int) -> np.ndarray:
        value = np.asarray(data[name])
        if value.dtype.kind not in "biuf":
            raise RecordingError(f"{path}: not a BROAD trial: {name} holds no real numbers")
        if value.shape != (n, *shape) or n == 0:
            raise RecordingError(f"{path}: not a BROAD trial: {name} has the shape {value.shape}, expected {(n or 'n', *shape)}")
        return np.ascontiguousarray(value, float)

    with np.errstate(over="ignore"):  # a rate near zero is refused below
        t_s = np.arange(n) / rate_hz
    if not np.isfinite(t_s).all() or (np.diff(t_s) <= 0).any():
        raise RecordingError(f"{path}: not a BROAD trial: sampling_rate = {rate_hz:g} Hz")
    data["movement"] = np.ravel(data["movement"])
    units = {"gyro": "rad/s", "accel": "m/s2", "mag": "uT"}
    names = {"gyro": "imu_gyr", "accel": "imu_acc", "mag": "imu_mag"}
    streams = [Stream(s, t_s, array(names[s], 3), wishes.unit(s, by_format=units[s])) for s in units]
    extra = {"reference_q_nb": array("opt_quat", 4), "movement": array("movement").astype(bool)}
    return Raw("broad", streams, wishes.unit("time", by_format="s"), extra=extra, names=())


def _contents(path: Path) -> tuple[dict[str, Any], float] | None:
    """The arrays of a trial, and its rate in Hz; None for a file of other variables. Raises RecordingError."""
    names = ("imu_gyr", "imu_acc", "imu_mag", "opt_quat", "movement")
    try:
        if is_hdf5(path) or path.suffix == ".hdf5":
            import h5py

            with h5py.File(path) as trial:
                if len(trial) and not set(names) & set(trial):
                    return None
                return {name: trial[name][:] for name in names}, float(trial.attrs["sampling_rate"])
        contents = read_mat(path, (*names, "sampling_rate"))
        if not contents:
            return None
        return {name: contents[name] for name in names}, float(contents["sampling_rate"])
    except KeyError as error:
        raise RecordingError(f"{path}: not a BROAD trial: {error.args[0]}") from None
    except Exception as error:  # the readers of both formats raise errors of any type for a damaged file
        raise cannot_be_read(path, error) from None
