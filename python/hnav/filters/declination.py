"""The magnetic field of a place and a date by the World Magnetic Model: strength, dip and declination.

    hnav.Filter("ahrs", place_and_date=(np.radians(48.1), np.radians(11.6), 500.0, 2026.5))       # true headings
    hnav.Ins("consumer", declination_rad=hnav.declination_rad(np.radians(48.1), np.radians(11.6), 500.0, 2026.5))

The model is that of the package pygeomag (the extra 'wmm'); each of its issues serves for five years.
"""

from __future__ import annotations

from math import degrees, radians
from typing import Any

from hnav.errors import HnavRuntimeError, HnavValueError

FIRST_YEAR, LAST_YEAR = 2015.0, 2030.0
"""First and last year of the issues of the model."""
WEAK_NT = 2000.0
"""Horizontal field below which its azimuth is useless."""


def declination_rad(latitude_rad: float, longitude_rad: float, height_m: float, year: float) -> float:
    """True minus magnetic heading, east positive, at a place and a time.

    height_m: above the ellipsoid. year: decimal, 2026.5 is in the midst of 2026. Raises HnavValueError for a year without an issue of
    the model, a latitude beyond the poles and a place near a magnetic pole, HnavRuntimeError without pygeomag.
    """
    return radians(_modelled(latitude_rad, longitude_rad, height_m, year).d)


def field_of_place(latitude_rad: float, longitude_rad: float, height_m: float, year: float) -> dict[str, object]:
    """Options of the AHRS and the HREKF: the reference field, and the declination. Arguments and errors as of declination_rad."""
    field = _modelled(latitude_rad, longitude_rad, height_m, year)
    return {
        "reference_mode": "given",
        "reference_strength_tesla": field.f * 1e-9,
        "reference_dip_rad": radians(field.i),
        "declination_rad": radians(field.d),
    }


def _modelled(latitude_rad: float, longitude_rad: float, height_m: float, year: float) -> Any:
    """The field as pygeomag states it: nT and degrees."""
    try:
        from pygeomag import GeoMag
    except ModuleNotFoundError:
        raise HnavRuntimeError(
            "unsupported", "the field of a place needs pygeomag: python -m pip install pygeomag (the extra 'wmm')"
        ) from None
    if not FIRST_YEAR <= year <= LAST_YEAR:
        raise HnavValueError("option", f"year = {year:g}: the magnetic model covers {FIRST_YEAR:g} to {LAST_YEAR:g}", "year")
    if not abs(latitude_rad) <= radians(90):
        raise HnavValueError("option", f"latitude_rad = {latitude_rad:g}: must be in rad, -pi/2 to pi/2", "latitude_rad")
    issue = min(int(year), int(LAST_YEAR) - 1) // 5 * 5
    field = GeoMag(base_year=issue).calculate(degrees(latitude_rad), degrees(longitude_rad), height_m / 1000, year)
    if field.h < WEAK_NT:
        raise HnavValueError("option", f"the field has {field.h:.0f} nT along the horizontal here: no compass points anywhere")
    return field
