"""Corrections in windows, for sensors of several rates and for lost samples: a window ends when every sensor was seen.

A correction by force alone cannot contract the heading error, so one V = e'Pe that falls at every correction asks too
much of a field at a tenth of the rate. The window is what has to contract: the product of its M. For that each place in
the window has a P of its own, one for the corrections since the window began and the sensors seen in them, and V
passes from one to the next:

    e_k' P_j e_k <= e^{-2 sigma T} e_{k-1}' P_i e_{k-1},   i before and j after correction k, 0 at the ends of windows

Taken over a window that is M_w'P_0 M_w <= e^{-2 sigma T_w} P_0, and such P_j exist whenever it holds, so nothing is lost
to the product; but the remainders of each correction meet the P that holds there. Windows may come in any order and
length. Where all sensors are seen at once every window is one correction, and there is one P.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hnav.certify.gain_record import GainRecord
from hnav.errors import HnavRuntimeError

MOST_PLACES = 150  # in windows: the semidefinite programs grow with them


@dataclass(frozen=True)
class Windows:
    """For each of m corrections which P holds before and after it; 0: at the end of a window."""

    before: np.ndarray
    after: np.ndarray
    places: int  # how many P

    @property
    def longest(self) -> int:
        """Corrections in the longest window that ended."""
        return int(np.diff(self.ends(), prepend=-1).max(initial=0))

    @property
    def unfinished(self) -> int:
        """Corrections after the last window that ended."""
        return len(self.after) - 1 - int(self.ends().max(initial=-1))

    def ends(self) -> np.ndarray:
        """The last correction of every window that ended."""
        return np.flatnonzero(self.after == 0)

    def begins(self) -> np.ndarray:
        """The first correction of every window that ended."""
        return np.asarray(np.r_[0, self.ends()[:-1] + 1])

    def products(self, M: np.ndarray) -> np.ndarray:
        """windows x 6 x 6: the error map of every window that ended. M: m x 6 x 6, of the corrections."""
        found, product = [], np.eye(M.shape[-1])
        for map, after in zip(M, self.after):
            product = map @ product
            if after == 0:
                found.append(product)
                product = np.eye(M.shape[-1])
        return np.stack(found)


def windows_of(record: GainRecord) -> Windows:
    """The shortest windows in which every sensor is seen that corrects anywhere in the record.

    Raises HnavError for windows of more than MOST_PLACES corrections.
    """
    seen = [frozenset(s for s in (0, 3) if np.any(c.H[s : s + 3])) for c in record.corrections]
    every = frozenset().union(*seen)
    place_of: dict[tuple[int, frozenset[int]], int] = {}
    before, after = [], []
    place, count, so_far = 0, 0, frozenset[int]()
    for c, sensors in zip(record.corrections, seen):
        before.append(place)
        count, so_far = count + 1, so_far | sensors
        if so_far == every:
            place, count, so_far = 0, 0, frozenset()
        else:
            place = place_of.setdefault((count, so_far), len(place_of) + 1)
        if len(place_of) > MOST_PLACES:
            missing = "the field" if 3 not in so_far else "the force"
            raise HnavRuntimeError(
                "no data",
                f"{record.name}: {missing} is not seen in {count} corrections before {c.t_s:g} s; certify a part without the gap",
            )
        after.append(place)
    return Windows(np.array(before), np.array(after), len(place_of) + 1)
