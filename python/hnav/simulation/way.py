"""A way through points: the positions of a vehicle of the kind way over time.

    way = Way(t_s=[0, 10, 20, 25], north_m=[0, 100, 100, 100], east_m=[0, 0, 80, 80])      # stands at the end
    drive = Vehicle(way=way, mean_over_s=0.01).run(np.arange(2501) / 100)
    drive = Vehicle(way=read_way("drive.csv")).run(...)

The points are met at their times, and velocity and acceleration are continuous. The body points where it goes and does not bank;
where a point comes twice it stands. Before the first point and after the last it goes straight on.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from hnav.errors import HnavValueError
from hnav.io.sample_table import read_sample_table
from hnav.native.arrays import Array
from hnav.native.library import ffi, library, new

FMU_POINTS = 32
"""Number of points that Vehicle.fmu has parameters for."""
_LEVEL = ("north_m", "east_m", "up_m")
_PLACES = ("lat_deg", "lon_deg", "alt_m")


@dataclass(frozen=True, eq=False)
class Way:
    """Points of n; north and east along the level of the start, up above the height of the start."""

    t_s: Array
    """n: since the motion began."""
    north_m: Array
    """n."""
    east_m: Array
    """n."""
    up_m: Array
    """n."""
    start: Mapping[str, float]
    """latitude_rad, longitude_rad and height_m of the start, where the points give it; else empty."""

    def __init__(
        self,
        t_s: npt.ArrayLike,
        north_m: npt.ArrayLike,
        east_m: npt.ArrayLike,
        up_m: npt.ArrayLike = 0.0,
        start: Mapping[str, float] | None = None,
    ):
        """Raises HnavValueError for arrays that are not of one length."""
        given = {"t_s": t_s, "north_m": north_m, "east_m": east_m, "up_m": up_m}
        n = np.size(np.asarray(t_s, float))
        for name, values in given.items():
            column = np.asarray(values, float)
            if column.ndim == 0 and name == "up_m":
                column = np.full(n, float(column))
            if column.shape != (n,):
                raise HnavValueError("option", f"{name}: {column.shape} numbers for {n} points of the way", name)
            object.__setattr__(self, name, column)
        object.__setattr__(self, "start", dict(start or {}))

    @classmethod
    def by_speed(cls, speed_m_s: float, north_m: npt.ArrayLike, east_m: npt.ArrayLike, up_m: npt.ArrayLike = 0.0) -> Way:
        """Times by a speed from point to point along straight lines. Raises HnavValueError for a speed that is not above 0."""
        if not speed_m_s > 0:
            raise HnavValueError("option", f"speed_m_s = {speed_m_s:g}: must be above 0", "speed_m_s")
        way = cls(np.zeros(np.size(north_m)), north_m, east_m, up_m)
        length = np.linalg.norm(np.diff(np.stack([way.north_m, way.east_m, way.up_m]), axis=1), axis=0)
        return cls(np.append(0.0, np.cumsum(length)) / speed_m_s, way.north_m, way.east_m, way.up_m)

    @classmethod
    def through(cls, t_s: npt.ArrayLike, place: npt.ArrayLike) -> Way:
        """Through places (n x 3: latitude, longitude in rad, height above the ellipsoid in m), the first of which is the start."""
        place = np.atleast_2d(np.asarray(place, float))
        if place.ndim != 2 or place.shape[1] != 3 or not len(place):
            raise HnavValueError("option", f"place: {place.shape}, must be n x 3", "place")
        start, point, seen = place[0].tolist(), new("hnav_way_point"), []
        for i, here in enumerate(place.tolist(), 1):
            if library().hnav_way_point_at(start, here, point):
                raise HnavValueError("option", f"place: point {i} is not finite, or on the other side of the globe", "place")
            seen.append((point.north_m, point.east_m, point.up_m))
        north, east, up = np.array(seen).T
        return cls(t_s, north, east, up, dict(zip(("latitude_rad", "longitude_rad", "height_m"), start)))

    def points(self) -> object:
        """For the library: an array of hnav_way_point."""
        made = ffi.new("hnav_way_point[]", max(1, len(self.t_s)))
        for point, values in zip(made, np.column_stack([self.t_s, self.north_m, self.east_m, self.up_m]).tolist()):
            point.t_s, point.north_m, point.east_m, point.up_m = values
        return made

    def parameters(self) -> dict[str, float]:
        """Values of the parameters of Vehicle.fmu. Raises HnavValueError for more points than it takes."""
        n = len(self.t_s)
        if n > FMU_POINTS:
            raise HnavValueError("option", f"the way has {n} points; Vehicle.fmu takes {FMU_POINTS}")
        rows = {
            f"way.{name}[{i}]": float(value)
            for name in ("t_s", "north_m", "east_m", "up_m")
            for i, value in enumerate(getattr(self, name), 1)
        }
        return {f"place.{name}": value for name, value in self.start.items()} | {"way.points": n} | rows


def read_way(path: str | Path) -> Way:
    """A table of text: t_s and north_m, east_m, perhaps up_m; or t_s and lat_deg, lon_deg, perhaps alt_m, whose first row is the start.
    Times count from the first row. Raises HnavValueError that names what is missing."""
    path = Path(path)
    t_s, columns = read_sample_table(path)
    nothing = np.zeros(len(t_s))
    found = next((names for names in (_LEVEL, _PLACES) if all(name in columns for name in names[:2])), None)
    if found is None:
        raise HnavValueError(
            "file", f"{path.name}: a way has t_s and north_m, east_m or lat_deg, lon_deg; it has {', '.join(columns)}"
        )
    first, second, up = (columns.get(name, nothing) for name in found)
    if missing := np.flatnonzero(~np.isfinite(first + second + up)).tolist():
        raise HnavValueError("file", f"{path.name}: row {missing[0] + 1} is no point: a number is missing")
    since = t_s - t_s[0] if len(t_s) else t_s
    if found is _LEVEL:
        return Way(since, first, second, up)
    return Way.through(since, np.column_stack([np.radians(first), np.radians(second), up]))
