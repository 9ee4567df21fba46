"""Magnetometer calibration: hard iron, soft iron, scale, misalignment; corrected = matrix (field - offset).

    calibration = calibrate_magnetometer(field, force)      # n x 3 each, of a sensor that was turned about all axes
    corrected = calibration.apply(field)
    write_calibration("sensor.json", calibration)           # hnav filter --calibration sensor.json

The mathematics is that of the C library; hnav.h, section calibration, is the reference.
"""

from __future__ import annotations

import ctypes as C
import json
import math
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path

import numpy as np

from hnav.errors import HnavRuntimeError, HnavValueError, error_of
from hnav.io.recordings import TESLA_PER, Recording
from hnav.native.library import STATUS, Options, library

FITS = ("full", "without rotation", "hard iron only")


class _Calibration(C.Structure):
    _fields_ = [
        ("offset", C.c_double * 3), ("matrix", C.c_double * 9), ("strength", C.c_double), ("dip_rad", C.c_double),
        ("residual_before", C.c_double), ("residual_after", C.c_double), ("dip_spread_before_rad", C.c_double),
        ("dip_spread_after_rad", C.c_double), ("outlier_fraction", C.c_double), ("coverage", C.c_double),
        ("condition", C.c_double), ("ambiguity", C.c_double), ("axis_ratio", C.c_double), ("direction_sigma_rad", C.c_double), ("samples", C.c_uint64), ("used_samples", C.c_uint64),
        ("force_samples", C.c_uint64), ("fit", C.c_int32), ("offset_axes", C.c_int32),
    ]  # fmt: skip


@dataclass(frozen=True)
class MagnetometerCalibration:
    """What the fit found, and what to judge it by; the fields are those of hnav_magnetometer_calibration."""

    offset: np.ndarray  # 3, in the unit and axes of the field
    matrix: np.ndarray  # 3 x 3, determinant 1: the strength is kept
    strength: float  # of the corrected field, in its unit
    dip_rad: float  # positive down; NaN without force
    residual_before: float  # scatter of |field|, relative, without outliers
    residual_after: float  # of |corrected|
    dip_spread_before_rad: float  # robust standard deviation of the angle to gravity; NaN without force
    dip_spread_after_rad: float
    outlier_fraction: float
    coverage: float  # 1: directions spread evenly over the sphere; 0: all in a plane
    condition: float  # of the quadric; 0 when the fit did not come that far
    ambiguity: float  # near 1 another ellipsoid fits as well
    axis_ratio: float  # longest over shortest axis of the ellipsoid
    direction_sigma_rad: float  # standard error of the corrected direction, rms over the whole sphere
    samples: int
    used_samples: int  # those that saw a new attitude
    force_samples: int  # those whose force was taken for gravity
    fit: str  # one of FITS
    offset_axes: int  # 3, or 2 when the samples lie in a plane
    note: str = ""  # why it is hard iron only
    unit: str = "T"  # of offset and strength: one of recordings.TESLA_PER

    def apply(self, field) -> np.ndarray:
        """The corrected field: n x 3 (or 3), in the unit of the calibration. NaN stays NaN."""
        return (np.asarray(field, float) - self.offset) @ self.matrix.T

    def apply_to(self, recording: Recording) -> Recording:
        """The recording, whose field is in tesla, with its field corrected. Raises HnavError when it has none."""
        if recording.field_b_tesla is None:
            raise HnavRuntimeError("no data", f"{recording.name}: has no magnetometer to calibrate")
        tesla = TESLA_PER[self.unit]
        return replace(recording, field_b_tesla=tesla * self.apply(recording.field_b_tesla / tesla))


def calibrate_magnetometer(field, force_b_m_s2=None, unit: str = "T", **options) -> MagnetometerCalibration:
    """Calibrates from field (n x 3, any unit) and force (n x 3 of the same instants, or None); NaN rows are missing.

    options: fields of hnav_magnetometer_options, such as robust=0 or allow_hard_iron_only=1. unit: T, uT, G or au, says
    what the field is in. Raises HnavError: "ill-conditioned" when the data do not determine the answer, with what to do.
    """
    if unit not in TESLA_PER:
        raise HnavValueError("option", f"unit = {unit}: choose one of {', '.join(TESLA_PER)}")
    lib = library()
    lib.hnav_calibrate_magnetometer.argtypes = [C.c_size_t, *[C.c_void_p] * 5, C.c_size_t]
    chosen = Options("magnetometer", **options)
    arrays = [_rows(field, "field")]
    arrays.append(None if force_b_m_s2 is None else _rows(force_b_m_s2, "force_b_m_s2"))
    if arrays[1] is not None and arrays[1].shape != arrays[0].shape:
        raise HnavValueError("size", f"force_b_m_s2 has the shape {arrays[1].shape}, field {arrays[0].shape}")
    found, message = _Calibration(), C.create_string_buffer(320)
    pointers = (None if a is None else a.ctypes.data for a in arrays)
    status = lib.hnav_calibrate_magnetometer(len(arrays[0]), *pointers, C.byref(chosen.struct), C.byref(found), message, len(message))
    if status:
        raise error_of(STATUS[status], message.value.decode())
    values = {name: getattr(found, name) for name, _ in _Calibration._fields_}
    values |= {"offset": np.array(found.offset), "matrix": np.array(found.matrix).reshape(3, 3), "fit": FITS[found.fit]}
    return MagnetometerCalibration(**values, note=message.value.decode(), unit=unit)


def _rows(values, name: str) -> np.ndarray:
    array = np.ascontiguousarray(values, float)
    if array.ndim != 2 or array.shape[1] != 3:
        raise HnavValueError("size", f"{name} has the shape {array.shape}, expected (n, 3)")
    return array


# --------------------------------------------------------------------------------------------- files


def write_calibration(path: str | Path, calibration: MagnetometerCalibration) -> None:
    """As JSON with the names of the fields; what is not known (NaN) becomes null. Raises HnavError."""
    values = {"hnav": "magnetometer calibration"}
    for name, value in asdict(calibration).items():
        plain = value.tolist() if isinstance(value, np.ndarray) else value
        values[name] = None if isinstance(plain, float) and math.isnan(plain) else plain
    try:
        Path(path).write_text(json.dumps(values, indent=1) + "\n")
    except OSError as error:
        raise HnavValueError("out of range", f"{path}: cannot be written: {error.strerror}") from None


def read_calibration(path: str | Path) -> MagnetometerCalibration:
    """What write_calibration wrote. Raises HnavError naming the file and what is wrong with it."""
    try:
        values = json.loads(Path(path).read_text())
    except OSError as error:
        raise HnavValueError("out of range", f"{path}: cannot be read: {error.strerror}") from None
    except ValueError:
        raise HnavValueError("out of range", f"{path}: not a JSON file") from None
    if not isinstance(values, dict) or values.pop("hnav", None) != "magnetometer calibration":
        raise HnavValueError("out of range", f"{path}: not a magnetometer calibration by hnav calibrate")
    for field in fields(MagnetometerCalibration):
        if field.name not in values:
            raise HnavValueError("out of range", f"{path}: {field.name} is missing")
        if values[field.name] is None:
            values[field.name] = math.nan
    for name, shape in {"offset": (3,), "matrix": (3, 3)}.items():
        try:
            values[name] = np.array(values[name], float)
        except (TypeError, ValueError):
            values[name] = np.empty(0)
        if values[name].shape != shape or not np.isfinite(values[name]).all():
            raise HnavValueError("out of range", f"{path}: {name} is not {' x '.join(map(str, shape))} finite numbers")
    if values["unit"] not in TESLA_PER:
        raise HnavValueError("out of range", f"{path}: unit = {values['unit']}: choose one of {', '.join(TESLA_PER)}")
    return MagnetometerCalibration(**{field.name: values[field.name] for field in fields(MagnetometerCalibration)})
