"""Magnetic declination by the World Magnetic Model, for the option declination_rad.

    declination = hnav.declination_rad(np.radians(48.1), np.radians(11.6), 500.0, 2026.5)
    hnav.Ins("consumer", declination_rad=declination)

The model is that of the package pygeomag (the extra 'wmm'); each of its issues serves for five years.
"""

from __future__ import annotations

from math import degrees, radians

from hnav.errors import HnavRuntimeError, HnavValueError

FIRST_YEAR, LAST_YEAR = 2015.0, 2030.0
"""Years for which there is an issue of the model."""
WEAK_NT = 2000.0
"""Horizontal field below which its azimuth means nothing."""


def declination_rad(latitude_rad: float, longitude_rad: float, height_m: float, year: float) -> float:
    """True minus magnetic heading, east positive, at a place and a time.

    height_m: above the ellipsoid. year: decimal, 2026.5 is in the midst of 2026. Raises HnavValueError for a year without an issue of
    the model, a latitude beyond the poles and a place near a magnetic pole, HnavRuntimeError without pygeomag.
    """
    try:
        from pygeomag import GeoMag
    except ModuleNotFoundError:
        raise HnavRuntimeError(
            "unsupported", "the declination needs pygeomag: python -m pip install pygeomag (the extra 'wmm')"
        ) from None
    if not FIRST_YEAR <= year <= LAST_YEAR:
        raise HnavValueError("option", f"year = {year:g}: the magnetic model serves from {FIRST_YEAR:g} to {LAST_YEAR:g}", "year")
    if not abs(latitude_rad) <= radians(90):
        raise HnavValueError("option", f"latitude_rad = {latitude_rad:g}: must be in rad, -pi/2 to pi/2", "latitude_rad")
    issue = min(int(year), int(LAST_YEAR) - 1) // 5 * 5
    field = GeoMag(base_year=issue).calculate(degrees(latitude_rad), degrees(longitude_rad), height_m / 1000, year)
    if field.h < WEAK_NT:
        raise HnavValueError("option", f"the field has {field.h:.0f} nT along the horizontal here: no compass points anywhere")
    return radians(field.d)
