"""The rows of a table in which sensors stand in rows of their own: a row stamped by its measurement may stand behind later ones.

Each kind of row, by the cells that it fills, must be in order by itself, or all rows at equal intervals: a clock that was set back shows in
all kinds, and is no order of arrival. Rows of one stamp that fill different cells are one instant.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hnav.io.readers.clock import FEWEST_ROWS, ORDERED, WITHIN_S

MOST_COLUMNS = 62
"""Columns whose filled cells fit in an integer."""
Values = Mapping[str, np.ndarray]


def by_time(values: Values) -> tuple[Values, tuple[str, ...]]:
    """The rows by their times t_s, and a note on those that stood elsewhere; unchanged where that is not certain.

    values: columns by role, n each, NaN for an empty cell.
    """
    t = values.get("t_s")
    if t is None or len(t) < 2 or not np.isfinite(t).all() or (np.diff(t) > 0).all():
        return values, ()
    if only_unordered(t) or (single := _without_copies(values)) is None:
        return _ordered(values)
    ordered, notes = _ordered(single)
    return ordered, (f"{ORDERED}{len(t) - len(single['t_s'])} rows came twice, and were used once", *notes)


def _ordered(values: Values) -> tuple[Values, tuple[str, ...]]:
    """The rows by their times, and the note; unchanged where that is not certain."""
    t = values["t_s"]
    others = {role: column for role, column in values.items() if role != "t_s"}
    if (np.diff(t) > 0).all() or not 0 < len(others) <= MOST_COLUMNS:
        return values, ()
    filled = np.stack([np.isfinite(column) for column in others.values()], axis=1)
    kinds = np.unique(filled @ (1 << np.arange(filled.shape[1])), return_inverse=True)[1]
    of_kind = np.lexsort((np.arange(len(t)), kinds))
    back = np.diff(t[of_kind]) < 0
    in_order = kinds.max() > 0 and not back[np.diff(kinds[of_kind]) == 0].any()
    if not (in_order or only_unordered(t)):
        return values, ()
    moved = int((t < np.maximum.accumulate(t)).sum())
    order = np.argsort(t, kind="stable")
    ordered = _joined({role: column[order] for role, column in values.items()}, filled[order])
    rows = "a row stood" if moved == 1 else f"{moved} rows stood"
    return ordered, (f"{ORDERED}{rows} behind later ones, and were put in the order of the time stamps",) if moved else ()


def only_unordered(t_s: np.ndarray) -> bool:
    """Whether rows at equal intervals, some of them lost, only stand in another order: where a clock was set back, stamps lie closer."""
    steps = np.diff(np.sort(t_s))
    return bool(np.diff(t_s).min() > -WITHIN_S and steps.min() > 0.5 * np.median(steps))


def _without_copies(values: Values) -> Values | None:
    """The rows without those that repeat an earlier one in every cell, if they then only stand in another order; as a link delivers
    that sends packets again. None otherwise, and where each copy follows its row at once."""
    import pandas as pd

    copies = pd.DataFrame(values).duplicated().to_numpy()
    kept = {role: column[~copies] for role, column in values.items()}
    steps, t = np.diff(values["t_s"]), kept["t_s"]
    at_once = (steps >= 0).all() and np.array_equal(copies[1:], steps == 0)
    if at_once or len(t) < max(FEWEST_ROWS, copies.sum() + 1) or not (copies.any() and only_unordered(t)):
        return None
    return kept


def _joined(values: Values, filled: np.ndarray) -> Values:
    """Rows in order, those of one stamp as one, as far as they fill different cells."""
    t = values["t_s"]
    stamp = np.cumsum(np.diff(t, prepend=t[0]) > 0)
    begins = np.flatnonzero(np.diff(stamp, prepend=-1))
    before = np.cumsum(filled, axis=0) - filled
    place = np.where(filled, before - before[begins][stamp], 0).max(axis=1)  # how many of its stamp have filled one of its cells
    order = np.lexsort((np.arange(len(t)), place, stamp))
    first = np.flatnonzero((np.diff(stamp[order], prepend=-1) != 0) | (np.diff(place[order], prepend=-1) != 0))
    if (np.add.reduceat(filled[order].astype(int), first, axis=0) > 1).any():
        return values
    joined = {"t_s": t[order][first]}
    for i, (role, column) in enumerate((role, column) for role, column in values.items() if role != "t_s"):
        there = np.add.reduceat(filled[order, i].astype(int), first) > 0
        sums = np.add.reduceat(np.where(filled[order, i], column[order], 0.0), first)
        joined[role] = np.where(there, sums, np.nan)
    return {role: joined[role] for role in values}
