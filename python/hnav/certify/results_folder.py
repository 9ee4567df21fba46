"""The samples and the filter of a finished simulation, from the folder that it left."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import h5py
import numpy as np

from hnav.errors import HnavError
from hnav.filters.options import option_table
from hnav.io.json_file import read_json
from hnav.io.recordings import Recording, RecordingError
from hnav.native.library import PRESETS
from hnav.systems.simulation import ABOUT, SIGNALS


def read_results(folder: Path) -> Recording:
    """signals.h5 of a simulation: t_s and one dataset of three columns, or three of one, for each sensor.

    Sensors are found by the ends of their names: gyro.rate, accel.force, mag.field, each as `component.variable` or with
    [1], [2], [3] behind; a row of NaN is a missing sample. Where a counter stands beside (gyro.sample, ...), the value is
    held between samples, and rows at which the counter stays are missing ones. Raises RecordingError.
    """
    path = folder / SIGNALS
    if not path.is_file():
        raise RecordingError(f"{folder}: no {SIGNALS} in this folder")
    signals: dict[str, np.ndarray] = {}

    def take(name: str, item: h5py.Dataset | h5py.Group) -> None:
        if isinstance(item, h5py.Dataset):
            signals[name.replace("/", ".")] = item[:]

    try:
        with h5py.File(path) as file:
            file.visititems(take)
    except Exception as error:  # HDF5 raises whatever a damaged file makes it stumble over
        raise RecordingError(f"{path}: cannot be read: {(str(error) or type(error).__name__).splitlines()[0]}") from None
    if "t_s" not in signals:
        raise RecordingError(f"{path}: the dataset t_s is missing")
    for name, values in signals.items():
        if values.dtype.kind not in "fiub" or values.ndim == 0 or len(values) != len(signals["t_s"]):
            raise RecordingError(f"{path}: {name} does not hold a number for each of {len(signals['t_s'])} times")
    t_s = signals["t_s"].astype(float)
    if t_s.ndim != 1 or not len(t_s) or not np.isfinite(t_s).all() or (np.diff(t_s) <= 0).any():
        raise RecordingError(f"{path}: the times in t_s do not increase")
    samples = []
    for end in ("gyro.rate", "accel.force", "mag.field"):
        found = _samples(signals, end)
        if found is None:
            raise RecordingError(f"{path}: no dataset ends in {end}, nor in {end}[1] to {end}[3]")
        samples.append(found.astype(float))
    return Recording(folder.name, t_s, *samples)


def _samples(signals: Mapping[str, np.ndarray], end: str) -> np.ndarray | None:
    """n x 3, NaN where no sample came; None if no component has it."""
    for owner in [name[: -len(last)] for last in (end, f"{end}[1]") for name in signals if name.endswith(last)]:
        parts = [signals[name] for i in (1, 2, 3) if (name := f"{owner}{end}[{i}]") in signals and signals[name].ndim == 1]
        values = signals.get(owner + end, np.stack(parts, axis=1) if len(parts) == 3 else None)
        if values is None or values.ndim != 2 or values.shape[1] != 3:
            continue
        counter = signals.get(f"{owner}{end.split('.')[0]}.sample")
        fresh = np.ones(len(values), bool) if counter is None or counter.ndim != 1 else np.diff(counter, prepend=0.0) != 0
        return np.where(fresh[:, None], values, np.nan)
    return None


def filter_of_run(folder: Path, component: str = "hrekf") -> tuple[str, dict[str, str]]:
    """(preset, settings) that the component had in the simulation, from its run.json; preset default where it names none.

    Without its solver: the certificate's reference has the closed form only. Raises RecordingError, also for a folder
    without run.json, which hnav simulate writes last.
    """
    path = folder / ABOUT
    if not path.is_file():
        cure = "simulate again, or name the filter by --preset"
        raise RecordingError(f"{path}: file not found: the simulation is not whole; {cure}")
    said = _parameters(path)
    values = {name[len(component) + 1 :]: value for name, value in said.items() if name.startswith(component + ".")}
    preset = values.pop("preset", PRESETS[0])
    if preset not in PRESETS:
        raise RecordingError(f"{path}: no parameters of a simulation in it: {component}.preset = {preset}")
    settings = {}
    for name, option in option_table("hrekf").items():
        parameter = f"{option.group}.{name}"
        if parameter in values and name != "solver":
            settings[name] = _text(values[parameter])
        elif all(f"{parameter}[{i + 1}]" in values for i in range(option.count)):
            settings[name] = ",".join(_text(values[f"{parameter}[{i + 1}]"]) for i in range(option.count))
    return preset, settings


def _parameters(path: Path) -> dict[str, str | float]:
    """By component.parameter, as run.json has them. Raises RecordingError."""
    try:
        about = read_json(path)
    except HnavError as error:
        raise RecordingError(str(error)) from None
    said = about.get("parameters") if isinstance(about, dict) else None
    if not isinstance(said, dict) or not all(isinstance(value, (str, int, float)) for value in said.values()):
        raise RecordingError(f"{path}: no parameters of a simulation in it")
    return said


def _text(value: str | float) -> str:
    """A choice as it is, a number with all its bits."""
    return value if isinstance(value, str) else repr(value) if isinstance(value, int) else f"{value:.17g}"
