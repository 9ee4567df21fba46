"""Samples of named sensors and inputs as a table of text: a column of times, an empty cell where there is no sample."""

from __future__ import annotations

import math
from collections.abc import Container, Mapping, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pandas as pd

from hnav.errors import HnavValueError

Column = npt.NDArray[np.float64]
TIME = ("t_s", "time", "t", "time_s", "timestamp")
# Seconds since 1970 in other units are told by their size: as seconds 1e11 would be the year 5138, as milliseconds 1973.
_CLOCKS = ((1e17, 1e-9), (1e14, 1e-6), (1e11, 1e-3))
_SWITCHES = {"true": 1.0, "false": 0.0, "on": 1.0, "off": 0.0}


def read_sample_table(path: Path | str, wanted: Container[str] | None = None) -> tuple[Column, dict[str, Column]]:
    """Times in seconds, and the other columns by name, NaN where a cell is empty. Lines that begin with # are left out.

    Times are numbers, or dates and times of day (UTC where they do not say otherwise), which become seconds since 1970; clocks that
    count milliseconds, microseconds or nanoseconds since 1970 are told by their size. true, on, false and off are 1 and 0. wanted: the
    columns that have to be numbers, all if it is None; what is no number in another is NaN. Raises HnavValueError that names file,
    column and row.
    """
    path = Path(path)
    try:
        table = pd.read_csv(path, comment="#", skipinitialspace=True, dtype=str, keep_default_na=False)
    except OSError as error:
        raise HnavValueError("file", f"{path}: cannot be read: {error.strerror}") from None
    except (ValueError, pd.errors.ParserError) as error:
        raise HnavValueError("file", f"{path}: no table: {str(error).splitlines()[0]}") from None
    time = next((name for name in TIME if name in table.columns), None)
    if time is None:
        raise HnavValueError(
            "file", f"{path.name} has no column of times: call it t_s; it has {', '.join(map(str, table.columns))}"
        )
    columns = {
        str(name): _numbers(path, str(name), table[name].tolist(), wanted is None or name in wanted)
        for name in table.columns
        if name != time
    }
    t_s = _times(path, time, table[time].tolist())
    late = np.flatnonzero(~np.isfinite(t_s) | (np.diff(t_s, prepend=-math.inf) < 0))
    if len(late):
        raise HnavValueError("file", f"{path.name}: times must not run back or be missing, but {time} does in row {late[0] + 1}")
    return t_s, columns


def _times(path: Path, name: str, cells: list[str]) -> Column:
    """In seconds."""
    if any(mark in cell for cell in cells[:1] for mark in ("-", "/", ":")) and not _is_number(cells[0]):
        dates = pd.to_datetime(pd.Series(cells), utc=True, errors="coerce", format="ISO8601")
        wrong = np.flatnonzero(dates.isna())
        if len(wrong):
            raise HnavValueError(
                "file", f"{path.name}: {name} is no time in row {wrong[0] + 1}: {cells[wrong[0]]}; write 2026-11-22 12:00:00"
            )
        return np.asarray((dates - pd.Timestamp(0, tz="UTC")) / pd.Timedelta(seconds=1), float)
    t = _numbers(path, name, cells, True)
    largest = float(np.nanmax(np.abs(t), initial=0.0))
    return t * next((unit for limit, unit in _CLOCKS if largest > limit), 1.0)


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _numbers(path: Path, name: str, cells: list[str], needed: bool) -> Column:
    """Number by number, as Python reads them: the bits that were written."""
    numbers = np.full(len(cells), math.nan)
    for row, cell in enumerate(cells):
        if cell.strip():
            try:
                switch = _SWITCHES.get(cell.strip().lower())
                numbers[row] = float(cell) if switch is None else switch
            except ValueError:
                if needed:
                    raise HnavValueError("file", f"{path.name}: {name} is no number in row {row + 1}: {cell}") from None
    return numbers


def sample_table(head: Sequence[str], columns: Mapping[str, Column]) -> str:
    """The text of a table, with lines after # at its head; numbers in full, empty cells for NaN."""
    text = pd.DataFrame(dict(columns)).to_csv(index=False)
    return "".join(f"# {line}\n" for line in head) + str(text)
