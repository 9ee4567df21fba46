"""Samples of satellites, pressure, wheels and headings out of the columns of a table."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace

import numpy as np

from hnav.io.aids import AIDS, AidSamples
from hnav.io.readers.aid_columns import ABOVE_SEA, LEAST_OF_A_FIX
from hnav.io.readers.columns import Column
from hnav.io.readers.receiver_integers import with_units_of_integers
from hnav.units import S_PER

PLACE = ("lat_deg", "lon_deg", "alt_m")
# Smallest medians that are read as Pa and as hPa where the column name states no unit; smaller ones are kPa.
SMALLEST_PA, SMALLEST_HPA = 2000.0, 200.0

SIGMAS = ("sigma_n", "sigma_e", "sigma_v")
"""Of a place."""
OF_FIXES = {*PLACE, "vn", "ve", "vd", "ground_speed", "course_deg"}
"""Roles whose values a row without a fix has not measured."""

NO_POSITIONS = "positions were left out: "
"""Beginning of a note that is a warning."""
LEFT_OUT = {"position": NO_POSITIONS, "velocity": "velocities were left out: "}
"""Beginnings of notes on kinds without a column that they need."""


def aids_in(columns: Mapping[str, Column], values: Mapping[str, np.ndarray], t_s: np.ndarray) -> dict[str, AidSamples]:
    """By kind, those that the table has; rows with an empty cell, or without a fix (0, 0), are no samples.

    columns, values: of the table, by role; t_s: of its rows.
    """
    given = _given(columns, values, len(t_s))
    received_s = None
    if column := columns.get("received_s"):
        received_s = values["received_s"] * S_PER[column.unit or "s"]
    found = {
        "position": _position(given),
        "velocity": _velocity(given),
        "pressure": _pressure(given, columns),
        "speed": given.get("speed_m_s", np.empty(0))[:, None] if "speed_m_s" in given else None,
        "heading": np.radians(given["antenna_heading_deg"])[:, None] if "antenna_heading_deg" in given else None,
    }
    if "sigma_heading_deg" in given:
        given["sigma_heading_rad"] = np.radians(given["sigma_heading_deg"])
    sigmas = {"position": SIGMAS, "velocity": 3 * ("sigma_vel",), "heading": ("sigma_heading_rad",)}
    nothing = np.full(len(t_s), np.nan)
    samples = {}
    for kind, read in found.items():
        if read is not None:
            sigma = np.stack([given.get(name, nothing) for name in sigmas.get(kind, ("",))], axis=1)
            above_sea = kind == "position" and ABOVE_SEA.search(columns["alt_m"].name) is not None
            samples[kind] = AidSamples(t_s, read, np.broadcast_to(sigma, read.shape), received_s, above_sea)
    return whole(samples)


def _given(columns: Mapping[str, Column], values: Mapping[str, np.ndarray], rows: int) -> dict[str, np.ndarray]:
    """Values of aiding columns by role, in the first units of their quantities; NaN where they are those of a fix that a row has not. With
    SIGMAS where these, a horizontal one or variances are known."""
    given = {role: column.factor * values[role] for role, column in columns.items() if column.aids and role != "received_s"}
    lost = without_fix(values, rows)
    for role in OF_FIXES & given.keys():
        given[role] = np.where(lost, np.nan, given[role])
    if not given.keys() & {"sigma_h", *SIGMAS}:
        known = given.get("variance_type", np.ones(rows)) > 0
        variances = [given.get(f"variance_{axis}", np.full(rows, np.nan)) for axis in "neu"]
        given |= {name: np.sqrt(np.where(known & (of_axis > 0), of_axis, np.nan)) for name, of_axis in zip(SIGMAS, variances)}
    if "sigma_h" in given:
        given = {"sigma_n": given["sigma_h"], "sigma_e": given["sigma_h"], **given}
    return given


def without_fix(values: Mapping[str, np.ndarray], rows: int) -> np.ndarray:
    """The rows that state that there is no fix. A type that is never above 1 is a flag."""
    stated = []
    for role in LEAST_OF_A_FIX.keys() & values.keys():
        largest = float(values[role].max(initial=1, where=~np.isnan(values[role])))
        stated.append(values[role] < min(LEAST_OF_A_FIX[role], largest))
    lost: np.ndarray = np.logical_or.reduce([np.zeros(rows, bool), *stated])
    return lost


def aids_and_notes(
    columns: Mapping[str, Column], values: Mapping[str, np.ndarray], t_s: np.ndarray
) -> tuple[dict[str, AidSamples], list[str]]:
    """As aids_in, of columns whose integers may be those of a receiver, and notes on these and on what was left out. Raises RecordingError
    for a unit that is not certain."""
    columns, notes = with_units_of_integers(columns, values)
    found = aids_in(columns, values, t_s)
    if (count := int(without_fix(values, len(t_s)).sum())) and found.keys() & {"position", "velocity"}:
        notes = (*notes, f"rows without a fix, whose positions and velocities were left out: {count}")
    return found, [*notes, *lonely(columns)]


def lonely(roles: Collection[str]) -> Iterator[str]:
    """Notes on columns that are no samples because another one is missing. roles: of all columns of the table."""
    place, missing = ([role for role in PLACE if (role in roles) == there] for there in (True, False))
    if missing and place not in ([], ["alt_m"]):
        yield f"{NO_POSITIONS}{', '.join(place)} without {', '.join(missing)}"
    if "sigma_vel" in roles and not {"vn", "ve"} <= {*roles} and not {"ground_speed", "course_deg"} <= {*roles}:
        yield "sigma_vel was left out: there are no velocities"
    if "vn" in roles and "ve" in roles:
        return
    if "course_deg" in roles and "speed_m_s" in roles:
        yield "course_deg was left out: speed_m_s is along body x; with a course a speed over ground is called ground_speed"
    elif ("course_deg" in roles) != ("ground_speed" in roles):
        there, other = ("course_deg", "ground_speed") if "course_deg" in roles else ("ground_speed", "course_deg")
        yield f"{LEFT_OUT['velocity']}{there} without {other}"


def whole(found: Mapping[str, AidSamples], known: np.ndarray | bool = True) -> dict[str, AidSamples]:
    """By kind, the known rows that hold a sample; a sigma that is not above 0 is none."""
    kept = {}
    for kind, one in found.items():
        needed = 2 if kind == "velocity" else len(AIDS[kind])
        rows = np.isfinite(one.values[:, :needed]).all(axis=1) & np.isfinite(one.arrived_s) & np.isfinite(one.t_s) & known
        if kind == "position":
            rows &= (one.values[:, :2] != 0).any(axis=1)
        kept[kind] = replace(one, sigma=np.where(one.sigma > 0, one.sigma, np.nan)).rows(rows)
    return kept


def _position(given: Mapping[str, np.ndarray]) -> np.ndarray | None:
    if not all(role in given for role in PLACE):
        return None
    return np.stack([np.radians(given["lat_deg"]), np.radians(given["lon_deg"]), given["alt_m"]], axis=1)


def _velocity(given: Mapping[str, np.ndarray]) -> np.ndarray | None:
    """The velocity components, else speed over ground and course; a negative speed marks a missing sample."""
    if "vn" in given and "ve" in given:
        return np.stack([given["vn"], given["ve"], given.get("vd", np.full(len(given["vn"]), np.nan))], axis=1)
    if "ground_speed" not in given or "course_deg" not in given:
        return None
    speed = np.where(given["ground_speed"] >= 0, given["ground_speed"], np.nan)
    return along(speed, np.radians(np.where(speed == 0, 0.0, given["course_deg"])))


def along(speed_m_s: np.ndarray, course_rad: np.ndarray) -> np.ndarray:
    """m x 3: the velocity of a speed over ground, its vertical part not known."""
    return np.stack([speed_m_s * np.cos(course_rad), speed_m_s * np.sin(course_rad), np.full(len(speed_m_s), np.nan)], axis=1)


def _pressure(given: Mapping[str, np.ndarray], columns: Mapping[str, Column]) -> np.ndarray | None:
    if "pressure_pa" not in given:
        return None
    return pressure_factor(columns["pressure_pa"], given["pressure_pa"]) * given["pressure_pa"][:, None]


def pressure_factor(column: Column, read: np.ndarray) -> float:
    """The factor to pascal for pressures without a stated unit, by their size; 1 where the name states the unit."""
    if column.unit is not None or not np.isfinite(read).any():
        return 1.0
    typical = float(np.nanmedian(read))
    return 1.0 if typical >= SMALLEST_PA else 100.0 if typical >= SMALLEST_HPA else 1000.0
