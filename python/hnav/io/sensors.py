"""Sensor files and grades of sensors (models/sensors): figures of datasheets and calibrations, read, checked for units, written.

    grade = hnav.read_grade("sensor.json")                      # or one of GRADES: hnav.read_grade("industrial")
    grade.apply_to(recording)                                   # corrected by the calibrations of the file
    grade.parameters()                                          # of the FMU ImuMagSensor, by name
    grade.options("ahrs")                                       # options of a filter: noise; of the AHRS start sigmas and ranges too
    hnav.write_sensor("sensor.json", {"mag": calibration.correction})

A file holds "version": 1, "name", and, for gyro, accel and mag, entries {"value": number, "unit": text} (models/sensors/README.md). Other
units than those below are refused with one line that names file, entry and unit.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from hnav.io.model_files import ModelFile, model_files
from hnav.io.outputs import write_files
from hnav.io.recordings import ARRAYS, Recording
from hnav.units import G_M_S2

GRADES = ("consumer", "industrial", "tactical")
VERSION = 1
"""Of the format; a file without a version has this one."""
TEXTS = ("name", "source", "assumed")
"""The name is required; the others state the source of the figures."""

DEG = math.pi / 180

# Factors from each unit to the one of the parameter.
TIME = {"s": 1.0, "ms": 1e-3, "us": 1e-6}
RATIO = {"1": 1.0, "%": 1e-2, "ppm": 1e-6}
ANGLE = {"rad": 1.0, "mrad": 1e-3, "deg": DEG}
RATE = {"rad/s": 1.0, "deg/s": DEG, "mdeg/s": 1e-3 * DEG, "deg/h": DEG / 3600}
RATE_NOISE = {
    "deg/sqrt(h)": 1.0,
    "deg/s/sqrt(Hz)": 60.0,
    "mdeg/s/sqrt(Hz)": 0.06,
    "deg/h/sqrt(Hz)": 1 / 60,
    "rad/s/sqrt(Hz)": 60 / DEG,
}
RATE_WALK = {"deg/h/sqrt(h)": 1.0, "deg/s/sqrt(s)": 3600 * 60.0, "rad/s/sqrt(s)": 3600 * 60 / DEG}
G_SENSITIVITY = {"deg/h/g": 1.0, "deg/s/g": 3600.0, "rad/s/(m/s2)": 3600 / DEG * G_M_S2}
FORCE = {"m/s2": 1.0, "g": G_M_S2, "mg": 1e-3 * G_M_S2, "ug": 1e-6 * G_M_S2}
FORCE_NOISE = {"ug/sqrt(Hz)": 1.0, "mg/sqrt(Hz)": 1e3, "m/s2/sqrt(Hz)": 1e6 / G_M_S2, "m/s/sqrt(h)": 1e6 / G_M_S2 / 60}
FORCE_WALK = {"ug/sqrt(h)": 1.0, "mg/sqrt(h)": 1e3, "m/s2/sqrt(s)": 1e6 / G_M_S2 * 60}
FIELD = {"T": 1.0, "uT": 1e-6, "nT": 1e-9, "mG": 1e-7, "G": 1e-4}
FIELD_NOISE = {"nT/sqrt(Hz)": 1.0, "uT/sqrt(Hz)": 1e3, "T/sqrt(Hz)": 1e9}
FIELD_WALK = {"nT/sqrt(h)": 1.0, "uT/sqrt(h)": 1e3, "T/sqrt(s)": 1e9 * 60}

_ALL = {
    "period": ("period_s", TIME),
    "latency": ("latency_s", TIME),
    "jitter": ("jitter_s", TIME),
    "dropout": ("dropout", RATIO),
    "scale_factor": ("scale_factor_sigma", RATIO),
    "misalignment": ("misalignment_sigma_rad", ANGLE),
}
# Of each sensor: entry of the file -> parameter of the FMU and the units it may have.
ENTRIES: dict[str, dict[str, tuple[str, dict[str, float]]]] = {
    "gyro": _ALL | {
        "noise": ("noise_deg_per_sqrt_h", RATE_NOISE),
        "bias_instability": ("bias_instability_rad_s", RATE),
        "random_walk": ("random_walk_deg_per_h_per_sqrt_h", RATE_WALK),
        "turn_on_bias": ("bias_sigma_rad_s", RATE),
        "g_sensitivity": ("g_sensitivity_deg_per_h_per_g", G_SENSITIVITY),
        "range": ("range_rad_s", RATE),
        "resolution": ("resolution_rad_s", RATE),
    },
    "accel": _ALL | {
        "noise": ("noise_ug_per_sqrt_hz", FORCE_NOISE),
        "bias_instability": ("bias_instability_m_s2", FORCE),
        "random_walk": ("random_walk_ug_per_sqrt_h", FORCE_WALK),
        "turn_on_bias": ("bias_sigma_m_s2", FORCE),
        "range": ("range_m_s2", FORCE),
        "resolution": ("resolution_m_s2", FORCE),
    },
    "mag": _ALL | {
        "noise": ("noise_nt_per_sqrt_hz", FIELD_NOISE),
        "bias_instability": ("bias_instability_tesla", FIELD),
        "random_walk": ("random_walk_nt_per_sqrt_h", FIELD_WALK),
        "turn_on_bias": ("bias_sigma_tesla", FIELD),
        "hard_iron": ("hard_iron_sigma_tesla", FIELD),
        "soft_iron": ("soft_iron_sigma", RATIO),
        "range": ("range_tesla", FIELD),
        "resolution": ("resolution_tesla", FIELD),
    },
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Correction:
    """Of three axes: corrected = matrix (reading - offset), with standard deviations where they are known, else NaN."""

    matrix: np.ndarray
    """3 x 3."""
    offset: np.ndarray
    """3, SI."""
    sigma_matrix: np.ndarray = field(default_factory=lambda: np.full((3, 3), np.nan))
    """3 x 3."""
    sigma_offset: np.ndarray = field(default_factory=lambda: np.full(3, np.nan))
    """3."""

    def apply(self, readings: np.ndarray) -> np.ndarray:
        """n x 3, SI; NaN stays NaN."""
        return np.asarray((readings - self.offset) @ self.matrix.T)

    def entry(self, unit: str) -> dict[str, Any]:
        """What a sensor file holds of it."""
        values = {name: np.where(np.isfinite(array), array, 0).tolist() for name, array in vars(self).items()}
        return {"unit": unit, **values}


@dataclass(frozen=True)
class Grade:
    """values: by the names of the parameters of ImuMagSensor, in their units; corrections: by sensor, of a calibrated one."""

    name: str
    values: dict[str, float]
    corrections: Mapping[str, Correction] = field(default_factory=dict)

    def apply_to(self, recording: Recording) -> Recording:
        """The recording with its samples corrected."""
        read = {sensor: getattr(recording, ARRAYS[sensor]) for sensor in self.corrections}
        corrected: dict[str, Any] = {
            ARRAYS[sensor]: self.corrections[sensor].apply(values) for sensor, values in read.items() if values is not None
        }
        return replace(recording, **corrected)

    def parameters(self) -> dict[str, float]:
        return dict(self.values)

    def filter_parameters(self, strength_tesla: float = 5e-5) -> dict[str, float]:
        """Noise of Hrekf for this grade.

        The bias instability of the gyro is modelled as a random walk: an instability B that is flat up to 1000 s
        moves as far in that time as a walk of B / sqrt(1000 s).
        """
        v = self.values
        floor = v.get("gyro.bias_instability_rad_s", 0.0) / math.sqrt(1000)
        walk = v.get("gyro.random_walk_deg_per_h_per_sqrt_h", 0.0) * DEG / 3600 / 60
        return {
            "gyro_noise_rad_per_sqrt_s": v.get("gyro.noise_deg_per_sqrt_h", 0.0) * DEG / 60,
            "gyro_bias_walk_rad_s_per_sqrt_s": math.hypot(walk, floor),
            "accel_noise_per_sqrt_hz": v.get("accel.noise_ug_per_sqrt_hz", 0.0) * 1e-6,
            "mag_noise_per_sqrt_hz": v.get("mag.noise_nt_per_sqrt_hz", 0.0) * 1e-9 / strength_tesla,
        }

    def options(self, filter: str) -> dict[str, object]:
        """Options of "ahrs", "hrekf" or "ins"; options without a figure keep their defaults. So do the bias random walks of the INS: temperature
        changes a bias by more than the random walk at rest."""
        found = self.filter_parameters()
        if filter == "ahrs":  # it estimates the noise of force and field
            found = {name: value for name, value in found.items() if name.startswith("gyro")}
        elif filter == "ins":
            density = self.values.get("accel.noise_ug_per_sqrt_hz", 0.0) * 1e-6 * G_M_S2
            found = {"gyro_noise_rad_per_sqrt_s": found["gyro_noise_rad_per_sqrt_s"], "accel_noise_m_s_per_sqrt_s": density}
        for option, names in START_AND_RANGE.get(filter, {}).items():
            # Without the spread of the bias from start to start, the instability alone is no bound on the bias.
            found[option] = math.hypot(*(self.values.get(name, 0.0) for name in names)) if names[0] in self.values else 0.0
        return {name: value for name, value in found.items() if value > 0}


_GYRO_BIAS = ("gyro.bias_sigma_rad_s", "gyro.bias_instability_rad_s")
_BOTH = {
    "start_sigma_gyro_scale": ("gyro.scale_factor_sigma",),
    "start_sigma_gyro_misalignment_rad": ("gyro.misalignment_sigma_rad",),
    "start_sigma_accel_bias_m_s2": ("accel.bias_sigma_m_s2", "accel.bias_instability_m_s2"),
    "gyro_range_rad_s": ("gyro.range_rad_s",),
    "accel_range_m_s2": ("accel.range_m_s2",),
}
START_AND_RANGE: dict[str, dict[str, tuple[str, ...]]] = {
    "ahrs": _BOTH | {
        "start_sigma_bias_rad_s": _GYRO_BIAS,
        "mag_range_tesla": ("mag.range_tesla",),
    },
    "ins": _BOTH | {
        "start_sigma_gyro_bias_rad_s": _GYRO_BIAS,
        "accel_scale": ("accel.scale_factor_sigma", "accel.misalignment_sigma_rad"),
    },
}  # fmt: skip
"""Option of a filter: the figures whose root sum of squares it is; without the first of them there is none."""


CALIBRATION = "calibration"
"""Entry of a sensor that hnav calibrate writes."""
SHAPES: dict[str, tuple[int, ...]] = {"matrix": (3, 3), "offset": (3,), "sigma_matrix": (3, 3), "sigma_offset": (3,)}
SI = {"gyro": "rad/s", "accel": "m/s2", "mag": "T"}


def models_folder() -> Path:
    return model_files("sensors")


def read_grade(name_or_path: str | Path) -> Grade:
    """A grade of GRADES, or a file. Raises HnavError that names file, entry and unit."""
    path = models_folder() / f"{name_or_path}.json" if str(name_or_path) in GRADES else Path(name_or_path)
    file = ModelFile(path)
    if not isinstance(file.data, dict):
        file.refuse("no object of sensors")
    if (version := file.data.get("version", VERSION)) != VERSION:
        file.refuse(f"version = {version}: this hnav reads version {VERSION}")
    for text in TEXTS:
        if not isinstance(file.data.get(text, "-"), str):
            file.refuse(f"{text} is no text")
    if not file.data.get("name"):
        file.refuse("name is missing")
    unknown = sorted(set(file.data) - {"version", *TEXTS} - set(ENTRIES))
    if unknown:
        file.refuse(f"there is no sensor {unknown[0]}; there are {', '.join(ENTRIES)}")
    values, corrections = {}, {}
    for sensor in ENTRIES:
        given = file.data.get(sensor, {})
        if not isinstance(given, dict):
            file.refuse(f"{sensor} is no object of entries")
        for key, entry in given.items():
            if key == CALIBRATION:
                corrections[sensor] = _correction(file, sensor, entry)
                continue
            parameter, value = _parameter(file, sensor, key, entry)
            values[f"{sensor}.{parameter}"] = value
    return Grade(file.data["name"], values, corrections)


def write_sensor(
    path: str | Path, sensors: Mapping[str, Correction | Mapping[str, Any]], name: str = "", source: str = "hnav calibrate."
) -> None:
    """Writes calibrations, or entries by their names, of gyro, accel and mag into a sensor file; what else an existing one holds stays.

    name: of a new file, which is otherwise that of the file. source: added to that of an existing file. Raises HnavError for an existing file
    that is no sensor file, and OutputError; then the old file stays.
    """
    path, source = Path(path), source.strip()
    data: dict[str, Any] = {"version": VERSION, "name": name or path.stem, "source": source}
    if path.exists():
        read_grade(path)
        data |= ModelFile(path).data
        data["source"] = data["source"] if source in data["source"] else f"{data['source']} {source}"
    for sensor, given in sensors.items():
        entries = {CALIBRATION: given.entry(SI[sensor])} if isinstance(given, Correction) else given
        data[sensor] = data.get(sensor, {}) | dict(entries)
    write_files({path: json.dumps(data, indent=1) + "\n"})


def _correction(file: ModelFile, sensor: str, entry: Any) -> Correction:
    """Of an entry calibration."""
    if not isinstance(entry, dict) or set(entry) != {"unit", *SHAPES} or entry["unit"] != SI[sensor]:
        file.refuse(f"{sensor}.{CALIBRATION} must have {', '.join(SHAPES)}, and the unit {SI[sensor]}")
    arrays = {}
    for name, shape in SHAPES.items():
        try:
            arrays[name] = np.array(entry[name], float)
        except (TypeError, ValueError, OverflowError):
            arrays[name] = np.empty(0)
        if arrays[name].shape != shape or not np.isfinite(arrays[name]).all():
            file.refuse(f"{sensor}.{CALIBRATION}.{name} is not {' x '.join(map(str, shape))} finite numbers")
    return Correction(**arrays)


def _parameter(file: ModelFile, sensor: str, key: str, entry: Any) -> tuple[str, float]:
    """Name and value, in its unit, of the parameter that an entry of a sensor sets."""
    entries = ENTRIES[sensor]
    if key not in entries:
        file.refuse(f"{sensor}.{key} is unknown; there are {', '.join(entries)}")
    if not isinstance(entry, dict) or set(entry) != {"value", "unit"}:
        file.refuse(f"{sensor}.{key} must have value and unit")
    parameter, units = entries[key]
    value, unit = entry["value"], entry["unit"]
    if not isinstance(unit, str) or unit not in units:
        file.refuse(f"{sensor}.{key}: unit {unit} is not one of {', '.join(units)}")
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 <= value <= sys.float_info.max:
        file.refuse(f"{sensor}.{key} = {value} {unit} must be a number of at least 0")
    return parameter, value * units[unit]
