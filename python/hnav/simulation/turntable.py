"""A turntable of three axes in closed form: the motion of a body on it, and the readings of error-free sensors at its centre.

    table = Turntable(yaw_motion="sine", yaw_amplitude_rad=1.0)
    table.at(2.5).rate_b_rad_s

Yaw is the outermost axis, roll the innermost. The body turns about its centre: specific force is gravity alone. The rate is
right-continuous where a motion has corners. Attitudes turn body vectors into north-east-down axes of true north; quaternions
are Hamilton's, scalar first.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from hnav.native.arrays import Array, Record, address, doubles
from hnav.native.library import LibraryObject, ffi
from hnav.native.options import OptionSet, complete


@dataclass(frozen=True, eq=False)
class Truth(Record):
    """Motion of the body at an instant, and readings of error-free sensors at its centre."""

    t_s: float
    """The instant."""
    q_nb: Array
    """4: body to north-east-down of true north."""
    euler_rad: Array
    """3: roll, pitch, yaw; rotation order z y x."""
    rate_b_rad_s: Array
    """3: of the body against the navigation frame."""
    force_b_m_s2: Array
    """3: specific force."""
    field_b_tesla: Array
    """3."""


class TurntableOptions(OptionSet):
    """Options of the turntable, as attributes: roll_..., pitch_..., yaw_... of each axis, and the place.

        TurntableOptions(yaw_motion="triangle", yaw_rate_rad_s=0.2)

    Raises HnavValueError for names (UnknownOptionError) and values that do not exist.
    """

    LIST = "turntable"


class Turntable(LibraryObject):
    """The experiment of the HREKF's paper by default: yaw to and fro between +-60 deg at 10 deg/s, level.

        Turntable(yaw_motion="sine")
        Turntable(TurntableOptions(yaw_motion="sine"))

    Raises HnavValueError for options that are impossible. It has no state: copies are equal.
    """

    KIND = "turntable"

    def __init__(self, options: TurntableOptions | None = None, **values: object):
        self._options = complete(TurntableOptions, options, values)
        super().__init__("hnav_turntable_create", self._options.struct)

    @property
    def options(self) -> TurntableOptions:
        """A copy of the options that the turntable was made with."""
        return copy(self._options)

    def __reduce__(self) -> tuple[Any, ...]:
        return Turntable, (self._options,)

    def at(self, t_s: float) -> Truth:
        """The motion at t_s. Raises HnavValueError for times that are not finite."""
        return Truth.read(self._filled("hnav_truth", "at", t_s))

    def in_piece(self, piece_s: float, t_s: float) -> Truth:
        """The truth at t_s if the motion that holds at piece_s went on without a corner, for integrators that step across."""
        return Truth.read(self._filled("hnav_truth", "in_piece", piece_s, t_s))

    def next_corner_s(self, t_s: float) -> float:
        """The next corner after t_s, where a rate jumps; infinite if there is none."""
        corner = ffi.new("double *")
        self._call("next_corner_s", t_s, corner)
        return float(corner[0])

    def seen_from(self, q_nb: npt.ArrayLike) -> tuple[Array, Array]:
        """Specific force in m/s2 and field in tesla, 3 each, as a body in attitude q_nb (4, any length but zero) reads them."""
        force, field = np.empty(3), np.empty(3)
        self._call("seen_from", address(doubles(q_nb, (4,), "q_nb")), address(force), address(field))
        return force, field
