"""Why an estimate was never ready: the smallest sigma that it reached, and the limit of the option."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hnav.filters.options import Options
from hnav.native.arrays import Array


@dataclass(frozen=True)
class Limit:
    """Below which sigma a quantity may be ready."""

    option: str
    """Of the filter, in SI units."""
    unit: str
    """In messages."""
    per_si: float = 1.0
    """From SI units to that unit."""


LIMITS = {
    "tilt": Limit("ready_tilt_rad", "deg", float(np.degrees(1))),
    "heading": Limit("ready_heading_rad", "deg", float(np.degrees(1))),
    "velocity": Limit("ready_velocity_m_s", "m/s"),
    "position": Limit("ready_position_m", "m"),
}


def sigmas(rotation_rad: Array, velocity_m_s: Array | None = None, position_m: Array | None = None) -> Array:
    """n x 2 or n x 4: what is compared with LIMITS, in their order. Each n x 3: about north, east, down; north, east, down."""
    columns = [rotation_rad[:, :2].max(axis=1), rotation_rad[:, 2]]
    if velocity_m_s is not None and position_m is not None:
        columns += [velocity_m_s.max(axis=1), position_m[:, :2].max(axis=1)]
    return np.stack(columns, axis=1)


def smallest(of: Array) -> Array:
    """The smallest number of each column; inf of a column of NaN."""
    return np.asarray(np.where(np.isfinite(of), of, np.inf).min(axis=0, initial=np.inf))


def why_never(name: str, reached: float, options: Options | None) -> str:
    """Why this one of LIMITS was never ready, behind a colon. reached: its smallest sigma, in SI units; options: of the filter."""
    limit = LIMITS[name]
    if not np.isfinite(reached):
        return "there was no estimate"
    said = f"its sigma reached {reached * limit.per_si:.3g} {limit.unit}"
    if options is None:
        return said
    wanted = getattr(options, limit.option)
    below = f"{wanted * limit.per_si:.3g} {limit.unit}"
    if reached >= wanted:
        return f"{said}, and has to be below {below} ({limit.option})"
    return f"{said}, which is below {below} ({limit.option}), but not for long enough, or without samples that determine it"
