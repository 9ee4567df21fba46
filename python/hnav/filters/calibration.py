"""Magnetometer calibration: hard iron, soft iron, scale, misalignment; corrected = matrix (field - offset).

    calibration = calibrate_magnetometer(field, force)      # n x 3 each, of a sensor that was turned about all axes
    corrected = calibration.apply(field)
    hnav.write_sensor("sensor.json", {"mag": calibration.correction})           # hnav filter --sensor sensor.json

The mathematics is that of the C library: an ellipsoid is fitted, gravity gives the rotation that it leaves open, both are
refined together, outliers lose their weight. Sources stand in hnav/calibration.h.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from dataclasses import field as dataclass_field
from typing import Annotated

import numpy as np
import numpy.typing as npt

from hnav.errors import HnavValueError
from hnav.io.sensors import Correction
from hnav.native.arrays import Array, Record, address, named, rows_of_three, shaped
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


@dataclass(frozen=True, eq=False)
class MagnetometerCalibration(Record):
    """The correction of a magnetometer, and figures of its quality."""

    offset: Array
    """3: hard iron, in the unit and axes of the field."""
    matrix: Annotated[Array, shaped(3, 3)]
    """3 x 3, determinant 1: the strength is kept on the mean over all directions."""
    strength: float
    """Strength of the corrected field, in its unit."""
    dip_rad: float
    """Dip of the corrected field, positive when it points down; NaN without force."""
    residual_before: float
    """Scatter of |field|, relative, without outliers."""
    residual_after: float
    """Scatter of |corrected|, relative, without outliers."""
    dip_spread_before_rad: float
    """Robust standard deviation of the angle between field and gravity; NaN without force."""
    dip_spread_after_rad: float
    """The same angle of the corrected field."""
    outlier_fraction: float
    """Share of the used samples that are outliers, 0 to 1."""
    coverage: float
    """1: directions spread evenly over the sphere; 0: all in a plane."""
    condition: float
    """Condition number of the fit of the quadric; 0 when the fit failed before."""
    ambiguity: float
    """Near 1 a second ellipsoid fits as well as the first."""
    axis_ratio: float
    """Longest over shortest axis of the ellipsoid."""
    direction_sigma_rad: float
    """Error of the direction of the corrected field, root mean square over the sphere: nine of ten calibrations have a smaller one. It includes a
    rotation that the fit leaves out; without force the rotation is unknown and not included."""
    samples: int
    """Rows with a field."""
    used_samples: int
    """Of these, rows that saw a new attitude."""
    force_samples: int
    """Of these, rows whose force was taken for gravity."""
    fit: Annotated[str, named(FITS)]
    """One of FITS."""
    offset_axes: int
    """Axes of the offset that are determined: 3, or 2 when the samples lie in a plane."""
    note: str
    """What the calibration leaves out and why, and the part of the sphere without samples."""
    unit: str
    """Unit of offset and strength: one of hnav.units.TESLA_PER."""
    gap_direction: Array = dataclass_field(default_factory=lambda: np.full(3, np.nan))
    """3, of the corrected field: the middle of the largest part of the sphere without a sample."""
    gap_rad: float = math.nan
    """Angle between gap_direction and the nearest sample."""

    def apply(self, field: npt.ArrayLike) -> Array:
        """The corrected field: n x 3 (or 3), in the unit of the calibration. NaN stays NaN."""
        corrected: Array = (np.asarray(field, np.float64) - self.offset) @ self.matrix.T
        return corrected

    @property
    def correction(self) -> Correction:
        """The same for a field in tesla, for a sensor file; without sigmas."""
        return Correction(self.matrix, TESLA_PER[self.unit] * self.offset)


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
    given = len(seen), address(seen), address(force), chosen.struct
    if status := library().hnav_calibrate_magnetometer(*given, found, message, len(message)):
        raise failure(status, message)
    return MagnetometerCalibration.read(found, note=text(message), unit=unit)
