"""The samples and the filter of a finished simulation, from the folder that it left."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import h5py
import numpy as np

from hnav.filters.attitude import option_table
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
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read: {str(error).splitlines()[0]}") from None
    if "t_s" not in signals:
        raise RecordingError(f"{path}: the dataset t_s is missing")
    samples = []
    for end in ("gyro.rate", "accel.force", "mag.field"):
        found = _samples(signals, end)
        if found is None:
            raise RecordingError(f"{path}: no dataset ends in {end}, nor in {end}[1] to {end}[3]")
        samples.append(found.astype(float))
    return Recording(folder.name, signals["t_s"], *samples)


def _samples(signals: Mapping[str, np.ndarray], end: str) -> np.ndarray | None:
    """n x 3, NaN where no sample came; None if no component has it."""
    for owner in [name[: -len(last)] for last in (end, f"{end}[1]") for name in signals if name.endswith(last)]:
        parts = [signals[name] for i in (1, 2, 3) if (name := f"{owner}{end}[{i}]") in signals]
        values = signals.get(owner + end, np.stack(parts, axis=1) if len(parts) == 3 else None)
        if values is None or values.ndim != 2 or values.shape[1] != 3:
            continue
        counter = signals.get(f"{owner}{end.split('.')[0]}.sample")
        fresh = np.ones(len(values), bool) if counter is None else np.diff(counter, prepend=0.0) != 0
        return np.where(fresh[:, None], values, np.nan)
    return None


def filter_of_run(folder: Path, component: str = "hrekf") -> tuple[str, dict[str, str]]:
    """(preset, settings) that the component had in the simulation, from its run.json; ("default", {}) where it says nothing.

    Without its solver: the certificate's reference knows the closed form only. Raises RecordingError.
    """
    path = folder / ABOUT
    try:
        said = json.loads(path.read_text())["parameters"] if path.is_file() else {}
        values = {name[len(component) + 1 :]: value for name, value in said.items() if name.startswith(component + ".")}
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        raise RecordingError(f"{path}: no parameters of a simulation in it") from None
    preset = values.pop("preset", PRESETS[0])
    if preset not in PRESETS:
        raise RecordingError(f"{path}: no parameters of a simulation in it: {component}.preset = {preset}")
    settings = {}
    for name, option in option_table("hrekf").items():
        if name in values and name != "solver":
            settings[name] = _text(values[name])
        elif f"{name}[1]" in values:
            settings[name] = ",".join(_text(values[f"{name}[{i + 1}]"]) for i in range(option.count))
    return preset, settings


def _text(value: str | float) -> str:
    """A choice as it is, a number with all its bits."""
    return value if isinstance(value, str) else f"{value:.17g}"
