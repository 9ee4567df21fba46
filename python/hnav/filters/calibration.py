"""Magnetometer calibration: hard iron, soft iron, scale, misalignment; corrected = matrix (field - offset).

    calibration = calibrate_magnetometer(field, force)      # n x 3 each, of a sensor that was turned about all axes
    corrected = calibration.apply(field)
    write_calibration("sensor.json", calibration)           # hnav filter --calibration sensor.json

The mathematics is that of the C library: an ellipsoid is fitted, gravity gives the rotation that it leaves open, both are
refined together, outliers lose their weight. Sources stand in hnav/calibration.h.
"""

from __future__ import annotations

import json
import math
from dataclasses import MISSING, Field, asdict, dataclass, fields, replace
from dataclasses import field as dataclass_field
from pathlib import Path
from typing import Annotated, Any, ClassVar, Protocol, TypeVar

import numpy as np
import numpy.typing as npt

from hnav.errors import HnavRuntimeError, HnavValueError
from hnav.io.json_file import read_json
from hnav.io.outputs import write_files
from hnav.native.arrays import Array, Named, Record, Shaped, address, rows_of_three
from hnav.native.library import failure, library, message_buffer, new, text
from hnav.native.options import OptionSet
from hnav.units import TESLA_PER

FITS = ("full", "without rotation", "hard iron only")
"""What a calibration corrects: everything; without the rotation between the axes of field and force; the offset alone."""


class MagnetometerOptions(OptionSet):
    """Options of the calibration, as attributes; option_rows("magnetometer") has unit, range and meaning of each.

        MagnetometerOptions(allow_hard_iron_only=1)

    Raises HnavValueError for names (UnknownOptionError) and values that do not exist.
    """

    LIST = "magnetometer"


class Magnetic(Protocol):
    """A recording: a dataclass with a name and a field."""

    @property
    def name(self) -> str:
        """What messages call it."""

    @property
    def field_b_tesla(self) -> Array | None:
        """n x 3, tesla; None without a magnetometer."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]


M = TypeVar("M", bound=Magnetic)


@dataclass(frozen=True, eq=False)
class MagnetometerCalibration(Record):
    """What the fit found, and what to judge it by."""

    offset: Array
    """3: hard iron, in the unit and axes of the field."""
    matrix: Annotated[Array, Shaped(3, 3)]
    """3 x 3, determinant 1: the strength is kept on the mean over all directions."""
    strength: float
    """Of the corrected field, in its unit."""
    dip_rad: float
    """Of the field, positive when it points down; NaN without force."""
    residual_before: float
    """Scatter of |field|, relative, without outliers."""
    residual_after: float
    """Scatter of |corrected|, likewise."""
    dip_spread_before_rad: float
    """Robust standard deviation of the angle to gravity; NaN without force."""
    dip_spread_after_rad: float
    """The same of the corrected field."""
    outlier_fraction: float
    """Of the used samples, 0 to 1."""
    coverage: float
    """1: directions spread evenly over the sphere; 0: all in a plane."""
    condition: float
    """Of the quadric; 0 when the fit did not come that far."""
    ambiguity: float
    """Near 1 another ellipsoid fits as well."""
    axis_ratio: float
    """Longest over shortest axis of the ellipsoid."""
    direction_sigma_rad: float
    """Error of the corrected direction, root mean square over the whole sphere, that nine of ten calibrations stay below. A
    rotation that was given up is in it; without force none is known, and none is in it."""
    samples: int
    """Rows with a field."""
    used_samples: int
    """Of these, rows that saw a new attitude."""
    force_samples: int
    """Of these, rows whose force was taken for gravity."""
    fit: Annotated[str, Named(FITS)]
    """One of FITS."""
    offset_axes: int
    """3, or 2 when the samples lie in a plane."""
    note: str
    """What the answer leaves out and why, and what of the sphere the samples leave out."""
    unit: str
    """Of offset and strength: one of hnav.units.TESLA_PER."""
    gap_direction: Array = dataclass_field(default_factory=lambda: np.full(3, np.nan))
    """3, of the corrected field: the middle of the largest part of the sphere without a sample; NaN in files before 0.2.0."""
    gap_rad: float = math.nan
    """How far from it the nearest sample is."""

    def apply(self, field: npt.ArrayLike) -> Array:
        """The corrected field: n x 3 (or 3), in the unit of the calibration. NaN stays NaN."""
        corrected: Array = (np.asarray(field, np.float64) - self.offset) @ self.matrix.T
        return corrected

    def apply_to(self, recording: M) -> M:
        """The recording with its field corrected. Raises HnavRuntimeError when it has none."""
        if recording.field_b_tesla is None:
            raise HnavRuntimeError("no data", f"{recording.name}: has no magnetometer to calibrate")
        tesla = TESLA_PER[self.unit]
        return replace(recording, field_b_tesla=tesla * self.apply(recording.field_b_tesla / tesla))


def calibrate_magnetometer(
    field: npt.ArrayLike, force_b_m_s2: npt.ArrayLike | None = None, unit: str = "T", **options: object
) -> MagnetometerCalibration:
    """Calibrates from field (n x 3, any unit) and specific force (n x 3, m/s2, of the same instants, or None).

    A row of NaN is a missing sample. unit: what the field is in, one of hnav.units.TESLA_PER. options: those of
    MagnetometerOptions, such as robust=0 or allow_hard_iron_only=1.

    Raises HnavValueError for impossible options and arrays, and with the status "ill-conditioned" when the data do not
    determine the answer: it says what is missing.
    """
    if unit not in TESLA_PER:
        raise HnavValueError("option", f"unit = {unit}: choose one of {', '.join(TESLA_PER)}", "unit")
    seen = rows_of_three(field, "field")
    force = None if force_b_m_s2 is None else rows_of_three(force_b_m_s2, "force_b_m_s2")
    if force is not None and force.shape != seen.shape:
        raise HnavValueError("size", f"force_b_m_s2 has the shape {force.shape}, field {seen.shape}", "force_b_m_s2")
    chosen = MagnetometerOptions(**options)
    found, message = new("hnav_magnetometer_calibration"), message_buffer()
    status = library().hnav_calibrate_magnetometer(
        len(seen), address(seen), address(force), chosen.struct, found, message, len(message)
    )
    if status:
        raise failure(status, message)
    return MagnetometerCalibration.read(found, note=text(message), unit=unit)


# --------------------------------------------------------------------------------------------- files

KIND = "magnetometer calibration"
WORDS = {"fit": FITS, "unit": tuple(TESLA_PER)}
SHAPES = {"offset": (3,), "matrix": (3, 3), "gap_direction": (3,)}


def write_calibration(path: str | Path, calibration: MagnetometerCalibration) -> None:
    """As JSON with the names of the fields; what is not known (NaN) becomes null. Raises OutputError; then the old file stays."""
    values: dict[str, Any] = {"hnav": KIND}
    for name, value in asdict(calibration).items():
        plain = value.tolist() if isinstance(value, np.ndarray) else value
        values[name] = None if isinstance(plain, float) and math.isnan(plain) else plain
    write_files({Path(path): json.dumps(values, indent=1) + "\n"})


def read_calibration(path: str | Path) -> MagnetometerCalibration:
    """What write_calibration wrote. Raises HnavValueError naming the file and what is wrong with it."""
    values = read_json(Path(path))
    if not isinstance(values, dict) or values.get("hnav") != KIND:
        raise HnavValueError("file", f"{path}: not a magnetometer calibration by hnav calibrate")
    read = {}
    for field in fields(MagnetometerCalibration):
        if field.name not in values:
            if field.default is not MISSING or field.default_factory is not MISSING:
                continue  # files of older versions have none
            raise HnavValueError("file", f"{path}: {field.name} is missing")
        try:
            read[field.name] = _entry(field.name, values[field.name])
        except (TypeError, ValueError, OverflowError):
            raise HnavValueError("file", f"{path}: {field.name} is not {_wanted(field.name)}") from None
    return MagnetometerCalibration(**read)


def _entry(name: str, value: Any) -> Any:
    """A field of a calibration from what the file has for it. Raises TypeError, ValueError or OverflowError."""
    if name in WORDS or name == "note":
        if not isinstance(value, str) or value not in WORDS.get(name, (value,)):
            raise ValueError
        return value
    if name in SHAPES:
        numbers = np.array(value, float)
        if numbers.shape != SHAPES[name] or not np.isfinite(numbers).all():
            raise ValueError
        return numbers
    # Only what is null was not known.
    number = math.nan if value is None else value
    if isinstance(number, bool) or not isinstance(number, int | float) or math.isinf(float(number)):
        raise TypeError
    return number


def _wanted(name: str) -> str:
    """What a field of a calibration has to be, in words."""
    if name in WORDS:
        return f"one of {', '.join(WORDS[name])}"
    return (
        f"{' x '.join(map(str, SHAPES[name]))} finite numbers" if name in SHAPES else "a text" if name == "note" else "a number"
    )
