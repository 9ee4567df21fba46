"""What the filters are given: recordings, prepared once for both sides, and motion that is made here."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

TRIAL_NAME = re.compile(r"(\d\d)_(un)?disturbed_")


@dataclass(frozen=True)
class Samples:
    """Rows of one instant each: n, n x 3, n x 3, n x 3 in SI units; heading (n) in rad, NaN where there is none."""

    t_s: NDArray[Any]
    rate: NDArray[Any]
    force: NDArray[Any]
    field: NDArray[Any]
    heading: NDArray[Any]

    def cut(self, start_s: float, stop_s: float) -> Samples:
        keep = (self.t_s >= start_s) & (self.t_s < stop_s)
        return Samples(*(np.ascontiguousarray(values[keep]) for values in vars(self).values()))


def prepare_trials(folder: Path) -> list[int]:
    """Writes the BROAD trials of BROAD_DIR as arrays into the folder; returns their numbers, none if it is not set."""
    numbers = []
    for path in sorted(Path(os.environ.get("BROAD_DIR", "/nonexistent")).rglob("*")):
        if (match := TRIAL_NAME.match(path.name)) and path.suffix in (".hdf5", ".mat"):
            numbers.append(int(match.group(1)))
            if not (file := folder / f"trial_{numbers[-1]:02d}.npz").is_file():
                np.savez(file, **vars(_read_trial(path)))
    return sorted(set(numbers))


def _read_trial(path: Path) -> Samples:
    """One trial; its field is in microtesla, its reference attitude turns into east-north-up."""
    names = ("imu_gyr", "imu_acc", "imu_mag", "opt_quat")
    if path.suffix == ".hdf5":
        import h5py

        with h5py.File(path) as file:
            data = [np.asarray(file[name], float) for name in names]
            rate_hz = float(file.attrs["sampling_rate"])
    else:
        import scipy.io

        contents = scipy.io.loadmat(path)
        data = [np.asarray(contents[name], float) for name in names]
        rate_hz = float(contents["sampling_rate"].squeeze())
    rate, force, field, q = data
    w, x, y, z = q.T
    east, north = 1 - 2 * (y * y + z * z), 2 * (x * y + w * z)
    return Samples(np.arange(len(rate)) / rate_hz, rate, force, 1e-6 * field, np.arctan2(east, north))


def trial(folder: Path, number: int) -> Samples:
    with np.load(folder / f"trial_{number:02d}.npz") as data:
        return Samples(**{name: np.ascontiguousarray(data[name]) for name in data.files})


def tumbling(duration_s: float, seed: int = 7, rate_hz: float = 100.0, noise: float = 1.0) -> Samples:
    """Made motion in north-east-down: a body that tumbles, rests in between, and meets a false field once."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(duration_s * rate_hz)) / rate_hz
    moving = np.where((t % 20 > 12) & (t % 20 < 16), 0.0, 1.0)[:, None]
    w = moving * np.stack([1.3 * np.sin(1.1 * t), 1.7 * np.cos(0.7 * t), 2.4 * np.sin(0.4 * t)], axis=1)
    turns: list[Rotation] = [Rotation.from_euler("zx", [40, 20], degrees=True)]
    for k in range(len(t) - 1):
        turns.append(turns[-1] * Rotation.from_rotvec(w[k] / rate_hz))
    attitude = Rotation.concatenate(turns)
    false_field = np.where((t > 0.6 * duration_s) & (t < 0.7 * duration_s), 1.5e-5, 0.0)[:, None] * [0.3, 1.0, -0.5]
    acceleration = moving * np.stack([np.sin(3 * t), np.cos(4 * t), 0.5 * np.sin(5 * t)], axis=1)
    force = attitude.apply(acceleration - [0, 0, 9.81], inverse=True) + noise * 0.03 * rng.normal(size=w.shape)
    field = attitude.apply([2e-5, 1e-6, 4.5e-5] + false_field, inverse=True) + noise * 2e-7 * rng.normal(size=w.shape)
    rate = w + [0.01, -0.02, 0.005] + noise * 0.003 * rng.normal(size=w.shape)
    ahead = attitude.apply([1.0, 0, 0])
    return Samples(t, rate, force, np.ascontiguousarray(field), np.arctan2(ahead[:, 1], ahead[:, 0]))


def with_gaps(samples: Samples, seed: int = 5) -> Samples:
    """A tenth of the fields and a twentieth of the forces missing, a third of a second without any rate."""
    rng = np.random.default_rng(seed)
    n = len(samples.t_s)
    rate, force, field = samples.rate.copy(), samples.force.copy(), samples.field.copy()
    field[rng.random(n) < 0.1] = np.nan
    force[rng.random(n) < 0.05] = np.nan
    middle = samples.t_s[n // 2]
    quiet = (samples.t_s > middle) & (samples.t_s < middle + 0.33)
    rate[quiet], force[quiet] = np.nan, np.nan
    return replace(samples, rate=rate, force=force, field=field)
