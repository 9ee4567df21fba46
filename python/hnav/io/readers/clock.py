"""Times of rows: their unit if the file does not state it, and corrections of wrong stamps."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from hnav.io.recordings import CSV_COLUMNS, Unit

SINCE_1970 = ((1e17, "ns"), (1e14, "us"), (1e11, "ms"))
"""As seconds 1e11 would be the year 5138, as milliseconds 1973."""
USUAL_INTERVAL_S, USUAL_OF_AIDS_S = (4e-4, 0.11), (9.5e-3, 9.4)
"""Ranges of intervals between samples of inertial sensors, and of all others; each spans less than a factor of 1000, so at most one unit
fits."""
SURELY_NOT_SECONDS = 2.0
MOST_WRONG = 0.02
"""Share of the time stamps that may be wrong; with more, they cannot be corrected."""
FEWEST_WRONG = 3
FEWEST_ROWS = 8  # needed for the usual interval
WITHIN_S = 1.0
"""Stamps that run back by less may only stand in another order; by more, the clock was set back."""
LONGEST_RUN = 50
"""Rows with one stamp: a clock of 1 s at 50 Hz."""
NEIGHBOURS = 3.5
"""Usual intervals between the stamps before and after a wrong one: two, with tolerance for jitter."""
MENDED, ORDERED, DAMAGED = "clock: ", "order: ", "damage: "
"""Beginnings of notes that are warnings: of corrected times, of rows that were sorted by them, of a file that was not read whole."""


def unit_by_size(t: np.ndarray, taken: Unit, roles: Collection[str]) -> Unit:
    """The unit of times by their intervals or their size, where no other than s is stated and these decide; else the unit taken.

    Seconds in a header are accepted unless the year would be beyond 5000. roles: of the other columns.
    """
    if taken.source != "assumed" and (taken.source, taken.name) != ("by header", "s"):
        return taken
    finite = t[np.isfinite(t)]
    steps = np.diff(np.sort(finite))
    steps = steps[steps > 0]
    if not len(steps):
        return taken
    largest = float(np.median(np.abs(finite)))
    usual_s = USUAL_OF_AIDS_S if {*CSV_COLUMNS[1:7]}.isdisjoint(roles) else USUAL_INTERVAL_S
    if taken.source == "assumed" and np.median(steps) > SURELY_NOT_SECONDS:
        for name, factor in (("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)):
            if usual_s[0] <= np.median(steps) * factor <= usual_s[1]:
                return Unit(name, "by its intervals")
    return next((Unit(name, "by its size") for limit, name in SINCE_1970 if largest > limit), taken)


def mended(t_s: np.ndarray) -> tuple[np.ndarray, str] | None:
    """Increasing times, and what was done to them; None where too many are wrong.

    One stamp that does not fit its neighbours lies between them; rows of one stamp are spread to the next; after a clock that was
    set back, time goes on by the usual interval.
    """
    filled, unknown = _filled(t_s)
    if filled is None or len(t_s) < FEWEST_ROWS or (spread := _spread(filled)) is None:
        return None
    t_s = filled
    shared = int((np.diff(t_s) == 0).sum())
    usual_s = float(np.median(np.diff(spread)[np.diff(spread) > 0]))
    single, wrong = _between_neighbours(spread, usual_s)
    back = np.diff(single) <= 0
    if wrong + unknown + back.sum() > max(FEWEST_WRONG, MOST_WRONG * len(t_s)):
        return None
    done = single.copy()
    done[1:] += np.cumsum(np.where(back, usual_s - np.diff(single), 0.0))
    parts = [f"{shared} rows shared a time stamp, they were spread evenly"] if shared else []
    parts += [f"time stamps that do not fit their neighbours were interpolated: {wrong + unknown}"] if wrong + unknown else []
    if back.any():
        first = int(np.argmax(back))
        often = "once," if back.sum() == 1 else f"{back.sum()} times, first"
        parts.append(
            f"the clock was set back {often} by {single[first] - single[first + 1]:.6g} s at {single[first]:.10g} s; time goes on there"
        )
    return (done, MENDED + ", ".join(parts)) if (np.diff(done) > 0).all() else None


def _filled(t_s: np.ndarray) -> tuple[np.ndarray | None, int]:
    """Interpolates times that are missing or not finite; returns also their number."""
    known = np.isfinite(t_s)
    unknown = int((~known).sum())
    if unknown > max(FEWEST_WRONG, MOST_WRONG * len(t_s)) or known.sum() < 3:
        return None, unknown
    rows = np.arange(len(t_s))
    return (t_s if not unknown else np.interp(rows, rows[known], t_s[known])), unknown


def _spread(t_s: np.ndarray) -> np.ndarray | None:
    """Spreads rows with one stamp evenly to the next stamp; None if a run is too long for a coarse clock."""
    begins = np.flatnonzero(np.concatenate([[True], np.diff(t_s) != 0]))
    lengths = np.diff(np.append(begins, len(t_s)))
    if len(begins) < 3 or lengths.max() > LONGEST_RUN:
        return None
    steps = np.diff(t_s[begins])
    usual = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    to_next = np.where((steps > 0) & (steps < NEIGHBOURS * usual), steps, usual)
    to_next = np.append(to_next, usual)
    place = np.arange(len(t_s)) - np.repeat(begins, lengths)
    return np.asarray(t_s + place * np.repeat(to_next / lengths, lengths)) if usual else None


def _between_neighbours(t_s: np.ndarray, usual_s: float) -> tuple[np.ndarray, int]:
    """Single stamps outside the interval of their neighbours, which fit each other."""
    around = t_s[2:] - t_s[:-2]
    outside = (t_s[1:-1] <= t_s[:-2]) | (t_s[1:-1] >= t_s[2:])
    wrong = outside & (around > 0) & (around < NEIGHBOURS * usual_s)
    done = t_s.copy()
    done[1:-1][wrong] = 0.5 * (t_s[:-2] + t_s[2:])[wrong]
    return done, int(wrong.sum())
