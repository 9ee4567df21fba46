"""A car, an aircraft, a ship, a body at rest or one on a given way over the turning Earth, with exact truth and what ideal inertial
sensors in it read.

    drive = Vehicle(kind="car", seed=3, mean_over_s=0.01).run(np.arange(15001) / 100)
    drive.rate_b_rad_s, drive.heading_rad

How it moves is drawn from the seed: levels of speed, turn and bank, each held for a random time, with soft edges. Attitudes turn body
vectors into north-east-down axes of true north; quaternions are Hamilton's, scalar first.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from hnav.errors import HnavValueError
from hnav.native.arrays import Array, address, times
from hnav.native.library import LibraryObject, new
from hnav.native.options import OptionSet, complete
from hnav.rotations import euler_rad
from hnav.simulation.way import Way

STATES = 4


class VehicleOptions(OptionSet):
    """Options of the vehicle, as attributes: its kind, place and heading at the start, and the seed.

        VehicleOptions(kind="aircraft", latitude_rad=1.5, seed=3)

    Raises HnavValueError for names (UnknownOptionError) and values that do not exist.
    """

    LIST = "vehicle"


@dataclass(frozen=True, eq=False)
class Drive:
    """The motion of a vehicle at n instants."""

    t_s: Array
    """n."""
    place: Array
    """n x 3: latitude, longitude in rad, height above the ellipsoid in m."""
    velocity_n_m_s: Array
    """n x 3: north, east, down."""
    q_nb: Array
    """n x 4: body to north-east-down of true north."""
    rate_b_rad_s: Array
    """n x 3: against inertial axes; of option mean_over_s the mean over so long before the instant."""
    force_b_m_s2: Array
    """n x 3: specific force, likewise."""
    field_b_tesla: Array
    """n x 3: magnetic field."""

    @property
    def heading_rad(self) -> Array:
        """n: of body x, clockwise from north."""
        return np.asarray(euler_rad(self.q_nb)[:, 2])


class Vehicle(LibraryObject):
    """A car that starts at 45 degrees north, with any heading, by default; its motion begins at start_s.

        Vehicle(kind="ship", seed=3)
        Vehicle(VehicleOptions(kind="ship", seed=3), start_s=1.0)

    way: the points that it passes, for the kind way, which then need not be said; where they give its start, so they do for the vehicle.
    Raises HnavValueError for options and ways that are impossible. It has no state: copies are equal.
    """

    KIND = "vehicle"

    def __init__(self, options: VehicleOptions | None = None, start_s: float = 0.0, way: Way | None = None, **values: object):
        if way is not None and options is None:
            values = {"kind": "way", **way.start, **values}
        self._options = complete(VehicleOptions, options, values)
        self._start_s, self._way = start_s, way
        given = (self._options.struct, start_s)
        if way is None:
            super().__init__("hnav_vehicle_create", *given)
        else:
            super().__init__("hnav_vehicle_create_along", *given, way.points(), len(way.t_s))

    @property
    def options(self) -> VehicleOptions:
        """A copy of the options that the vehicle was made with."""
        return copy(self._options)

    def __reduce__(self) -> tuple[Any, ...]:
        return Vehicle, (self._options, self._start_s, self._way)

    def run(self, t_s: npt.ArrayLike) -> Drive:
        """Truth at these times (n, increasing). Raises HnavValueError for times before the start and times that are not finite."""
        t_s = times(t_s)
        if np.any(np.diff(t_s) < 0):
            raise HnavValueError("option", "t_s must increase", "t_s")
        x, at = np.empty(STATES), self._start_s
        self._call("start", address(x))
        truths = []
        for now in t_s:
            self._call("carry", at, address(x), now)
            truths.append(new("hnav_vehicle_truth"))
            self._call("at", now, address(x), truths[-1])
            at = now

        def rows(name: str) -> Array:
            return np.array([list(getattr(truth, name)) for truth in truths])

        place = np.array([[truth.latitude_rad, truth.longitude_rad, truth.height_m] for truth in truths])
        return Drive(t_s, place, *map(rows, ("velocity_n_m_s", "q_nb", "rate_b_rad_s", "force_b_m_s2", "field_b_tesla")))
