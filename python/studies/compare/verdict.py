"""Two answers to one question: equal to the last bit, or where they differ most."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

HERE = Path(__file__).resolve().parent
# A scenario that raises leaves its traceback under this name.
FAILURE = "!failure"


@dataclass(frozen=True)
class Difference:
    value: str  # the array's name
    text: str


@dataclass(frozen=True)
class Declared:
    """A difference that is meant: scenario and value are patterns of * and ?."""

    scenario: str
    value: str
    reason: str


def declared_exceptions(path: Path = HERE / "exceptions.csv") -> list[Declared]:
    with path.open(newline="") as file:
        return [Declared(**row) for row in csv.DictReader(file)]


def reason_for(name: str, difference: Difference, declared: list[Declared]) -> str | None:
    """Why this difference is meant; None if nobody said so."""
    for row in declared:
        if fnmatch(name, row.scenario) and fnmatch(difference.value, row.value):
            return row.reason
    return None


def differences(old: dict[str, NDArray[Any]], new: dict[str, NDArray[Any]], tolerance: float = 0.0) -> list[Difference]:
    """What the new side answers otherwise, and what it no longer answers; what it answers beyond is its own affair.

    tolerance 0: bit for bit, where any NaN is any other. Above: absolute and relative to the larger of the two.
    """
    if failures := [(side, answers) for side, answers in (("old", old), ("new", new)) if FAILURE in answers]:
        return [Difference(FAILURE, f"the {side} side failed: {_end(str(answers[FAILURE]))}") for side, answers in failures]
    found = []
    for name, before in old.items():
        if name not in new:
            found.append(Difference(name, "the new side has no such value"))
        elif text := _difference(before, new[name], tolerance):
            found.append(Difference(name, text))
    return found


def _end(trace: str) -> str:
    """Of a traceback: where and why."""
    return " ".join(line.strip() for line in trace.strip().splitlines()[-4:])


def _difference(before: NDArray[Any], after: NDArray[Any], tolerance: float) -> str:
    """ "" when they are equal."""
    if before.shape != after.shape:
        return f"shape {after.shape}, was {before.shape}"
    if before.dtype.kind in "SU" or after.dtype.kind in "SU":
        pairs = zip(np.ravel(before).astype(str).tolist(), np.ravel(after).astype(str).tolist())
        return next((f"{now!r}, was {once!r}" for once, now in pairs if once != now), "")
    unequal = _unequal(before, after, tolerance)
    if not unequal.any():
        return ""
    with np.errstate(invalid="ignore", over="ignore"):
        size = np.abs(after.astype(float) - before.astype(float))
    size = np.where(unequal, np.nan_to_num(size, nan=np.inf), -1.0)
    where = np.unravel_index(np.argmax(size), size.shape)
    first = np.argwhere(unequal)[0].tolist()
    return (
        f"{np.count_nonzero(unequal)} of {unequal.size} differ, first at {first}; most, by {size[where]:.3g}, "
        f"at {[int(i) for i in where]}: {after[where]!r}, was {before[where]!r}"
    )


def _unequal(before: NDArray[Any], after: NDArray[Any], tolerance: float) -> NDArray[Any]:
    if before.dtype.kind != "f" or after.dtype.kind != "f":
        return np.asarray(before != after)
    both_nan = np.isnan(before) & np.isnan(after)
    if tolerance == 0 and before.dtype == after.dtype:
        bits = np.dtype(f"u{before.dtype.itemsize}")
        same = np.ascontiguousarray(before).view(bits) == np.ascontiguousarray(after).view(bits)
        return np.asarray(~(same.reshape(before.shape) | both_nan))
    with np.errstate(invalid="ignore"):
        near = np.abs(before - after) <= tolerance * np.maximum(1.0, np.maximum(np.abs(before), np.abs(after)))
    return np.asarray(~((before == after) | near | both_nan))
