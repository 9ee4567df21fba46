"""Where a body truly was, as a table: t_s, lat_deg, lon_deg, alt_m, vn, ve, vd, and roll, pitch, heading or q0 to q3."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hnav.errors import HnavValueError
from hnav.io.readers.aid_columns import PER, ROLES, aid_column
from hnav.io.sample_table import read_sample_table
from hnav.rotations import continuous_quaternion, quaternion_of_euler

ANGLES = {"roll": "roll", "pitch": "pitch", "heading": "heading", "yaw": "heading"}
QUATERNION = ("q0", "q1", "q2", "q3")
LONGEST_STEP_S = 1.5
"""Between two rows that are farther apart nothing is known."""


@dataclass(frozen=True)
class Truth:
    """Rows of n; NaN where a table has none."""

    t_s: np.ndarray
    """n."""
    place: np.ndarray
    """n x 3: latitude, longitude in rad, height in m."""
    velocity_n_m_s: np.ndarray
    """n x 3."""
    q_nb: np.ndarray
    """n x 4: body to north-east-down, scalar first."""
    angles: str
    """deg or rad: what roll, pitch and heading were taken for; quaternion, or none."""

    def at(self, t_s: np.ndarray) -> Truth:
        """At other times, between the rows."""
        known = np.isfinite(self.place).all(axis=1)
        before = np.clip(np.searchsorted(self.t_s, t_s, side="right") - 1, 0, len(self.t_s) - 1)
        after = np.clip(np.searchsorted(self.t_s, t_s), 0, len(self.t_s) - 1)
        unknown = (self.t_s[after] - self.t_s[before] > LONGEST_STEP_S) | (t_s < self.t_s[0]) | (t_s > self.t_s[-1])

        def between(values: np.ndarray) -> np.ndarray:
            rows = np.isfinite(values).all(axis=1)
            if not rows.any():
                return np.full((len(t_s), values.shape[1]), np.nan)
            made = np.stack([np.interp(t_s, self.t_s[rows], column) for column in values[rows].T], axis=1)
            return np.asarray(np.where(unknown[:, None], np.nan, made))

        # Across the date line a longitude goes on.
        place = self.place.copy()
        place[known, 1] = np.unwrap(place[known, 1])
        q = between(continuous_quaternion(self.q_nb))
        return Truth(t_s, between(place), between(self.velocity_n_m_s), q / np.linalg.norm(q, axis=1, keepdims=True), self.angles)


def read_truth(path: str | Path) -> Truth:
    """A table of text. Angles are in deg or rad by their names (roll_deg), else in rad if no heading is beyond a turn of them.
    Raises HnavValueError that names what is missing."""
    path = Path(path)
    t_s, columns = read_sample_table(path)
    found = {}
    for name, values in columns.items():
        aid = aid_column(name)
        if aid is not None and aid.role not in found:
            found[aid.role] = aid.sign * values * (PER[ROLES[aid.role]][aid.unit] if aid.unit else 1.0)
    nothing = np.full(len(t_s), np.nan)
    if missing := [role for role in ("lat_deg", "lon_deg", "alt_m") if role not in found]:
        raise HnavValueError(
            "file",
            f"{path.name} has no column {missing[0]}; a truth has t_s, lat_deg, lon_deg, alt_m, vn, ve, vd, roll, pitch, heading",
        )
    place = np.stack([np.radians(found["lat_deg"]), np.radians(found["lon_deg"]), found["alt_m"]], axis=1)
    velocity = np.stack([found.get(role, nothing) for role in ("vn", "ve", "vd")], axis=1)
    q_nb, angles = _attitude(columns, len(t_s))
    return Truth(t_s, place, velocity, q_nb, angles)


def _attitude(columns: dict[str, np.ndarray], n: int) -> tuple[np.ndarray, str]:
    if all(name in columns for name in QUATERNION):
        return np.stack([columns[name] for name in QUATERNION], axis=1), "quaternion"
    found, unit = {}, ""
    for name, values in columns.items():
        if match := re.fullmatch(r"(roll|pitch|heading|yaw)(?:[_ \[(]*(deg|rad)[\])]?)?", name.strip(), re.IGNORECASE):
            found[ANGLES[match.group(1).lower()]], unit = values, unit or (match.group(2) or "").lower()
    if len(found) < 3:
        return np.full((n, 4), np.nan), "none"
    unit = unit or ("rad" if np.nanmax(np.abs(found["heading"]), initial=0.0) <= 2 * np.pi + 0.01 else "deg")
    euler = np.stack([found[name] for name in ("roll", "pitch", "heading")], axis=1)
    return quaternion_of_euler(np.radians(euler) if unit == "deg" else euler), unit
