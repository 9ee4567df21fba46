"""Integers of receivers in a table: latitudes in 1e-7 deg, and of NAV-PVT (u-blox) heights in mm and velocities in mm/s, without a unit in
their names. pyubx2 converts the angles alone."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from hnav.io.readers.columns import Column
from hnav.io.recordings import RecordingError

LARGEST_DEG = {"lat_deg": 90.0, "lon_deg": 360.0, "course_deg": 360.0}
PLACES = {"lat_deg", "lon_deg"}
FINER = {
    "lat_deg": "1e7deg",
    "lon_deg": "1e7deg",
    "course_deg": "1e5deg",
    "alt_m": "mm",
    "sigma_h": "mm",
    "sigma_v": "mm",
} | dict.fromkeys(("vn", "ve", "vd", "ground_speed", "sigma_vel"), "mm/s")
"""Units of integers by role."""
HIGHEST_M = 1e4
"""Beside latitudes in 1e-7 deg, a larger height is one in mm: as PX4 and MAVLink have it too."""
OF_NAV_PVT = re.compile(r"(?:.*[^A-Za-z])?(?:(hMSL|[hvs]Acc|vel[NED]|gSpeed)|height)")
"""Names of lengths and velocities, those that only u-blox uses as a group: UBX-21046737, interface description, UBX-NAV-PVT."""
LEAST_NAMED = 3
"""So many whole columns that only u-blox calls so are its integers: hAcc and vAcc alone may be whole meters."""


def with_units_of_integers(
    columns: Mapping[str, Column], values: Mapping[str, np.ndarray]
) -> tuple[Mapping[str, Column], tuple[str, ...]]:
    """The columns with the units of a receiver's integers, and a note. Raises RecordingError for integers beside them of an unknown unit."""
    whole = {role: column for role, column in columns.items() if role in FINER and not column.unit and _is_whole(values[role])}
    certain = _certain(whole, values)
    if not certain:
        return columns, ()
    for role, column in whole.items():
        if role not in (*LARGEST_DEG, *certain):
            name, quantity = column.name.strip(), {"mm": "m", "mm/s": "m/s"}[FINER[role]]
            raise RecordingError(
                f"the column {name} holds whole numbers beside integers of a receiver, in {FINER[role]} or {quantity}: say which, such as "
                f"columns {role}='{name} [{FINER[role]}]'"
            )
    found = {role: replace(column, unit=FINER[role]) for role, column in whole.items() if role in certain}
    units = ", ".join(
        f"{column.name.strip()} in {_shown(column)}" for column in sorted(found.values(), key=lambda column: column.place)
    )
    return {**columns, **found}, (f"integers of a receiver: {units}",)


def _certain(whole: Mapping[str, Column], values: Mapping[str, np.ndarray]) -> set[str]:
    """Roles of the columns that hold integers of a receiver: too large for another unit, or of NAV-PVT."""
    named = {role: match for role, column in whole.items() if (match := OF_NAV_PVT.fullmatch(column.name.strip()))}
    large = {role for role in whole if np.nanmax(np.abs(values[role])) > LARGEST_DEG.get(role, np.inf)}
    if large & PLACES:
        large |= whole.keys() & PLACES  # near the equator and Greenwich too
        if "alt_m" in whole and np.nanmedian(np.abs(values["alt_m"])) > HIGHEST_M:
            large.add("alt_m")
    elif sum(bool(match.group(1)) for match in named.values()) < LEAST_NAMED:
        return set()
    return {*large, *named}


def _shown(column: Column) -> str:
    return {"1e7deg": "1e-7 deg", "1e5deg": "1e-5 deg"}.get(str(column.unit), str(column.unit))


def _is_whole(read: np.ndarray) -> bool:
    """Whether a column holds whole numbers alone, and not only zeros."""
    known = read[np.isfinite(read)]
    return bool(known.any()) and not (known % 1).any()
