"""Samples of named sensors and inputs as a table of text: a column of times, an empty cell where there is no sample."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Container, Mapping, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pandas as pd

from hnav.errors import HnavValueError
from hnav.io.readers.cells import BLANKS, DELIMITERS, MISSING, cells_of, decimal_mark, is_number
from hnav.io.readers.clock import SINCE_1970
from hnav.io.readers.instants import EXAMPLES, is_day_of, is_instant, seconds_of
from hnav.io.readers.tables import encoding_of
from hnav.io.recordings import RecordingError

Column = npt.NDArray[np.float64]
TIME = ("t", "time", "timestamp", "datetime", "date")  # T is a temperature
# Behind the name of the times, as time_ms, time [s] or t (min).
_UNITS = {"s": 1.0, "sec": 1.0, "seconds": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0}
_TIME = re.compile(rf"(t|(?i:{'|'.join(TIME[1:])}))(?:[\s_\[(/]+({'|'.join(_UNITS)})\s*[\])]?)?")
_SWITCHES = {"true": 1.0, "false": 0.0, "on": 1.0, "off": 0.0}


def read_sample_table(path: Path | str, wanted: Container[str] | None = None) -> tuple[Column, dict[str, Column]]:
    """Times in seconds, and the other columns by name, NaN where a cell is empty or says that there is none (NA, null, unknown, -).

    Cells are parted by commas, semicolons, tabs or blanks; where it is not commas, decimals may have them. Lines that begin with # are
    left out, except the header. Times are numbers, or instants as in recordings: dates and times of day (UTC where they do not say otherwise)
    become seconds since 1970, times of day alone since midnight; clocks that count milliseconds, microseconds or nanoseconds since 1970 are recognised by their size. true, on,
    false and off are 1 and 0. wanted: the columns that have to be numbers, all if it is None; what is no number in another is NaN. Raises
    HnavValueError that names file, column and row.
    """
    path = Path(path)
    names, rows = _table(path)
    cells = {name: list(column) for name, column in zip(names, zip(*rows))} if rows else {name: [] for name in names}
    time, of_time = _cells_of_time(path, cells)
    columns = {name: _numbers(path, name, cells[name], wanted is None or name in wanted) for name in names if name != time}
    t_s = _times(path, time, of_time)
    late = np.flatnonzero(~np.isfinite(t_s) | (np.diff(t_s, prepend=-math.inf) < 0))
    if len(late):
        raise HnavValueError("file", f"{path.name}: times must not run back or be missing, but {time} does in row {late[0] + 1}")
    return t_s, columns


def _table(path: Path) -> tuple[list[str], list[list[str]]]:
    """The names of the columns, and the rows, as long as these."""
    lines = _lines(path)
    delimiter = _delimiter(lines[0])
    names, *rows = _parted(path, lines, delimiter)
    while names and not names[-1]:
        names.pop()
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise HnavValueError("file", f"{path.name} has two columns {twice}: call one otherwise")
    if decimal_mark(delimiter, lines[1:]) == ",":
        rows = [[cell.replace(",", ".") for cell in row] for row in rows]
    for number, row in enumerate(rows, 1):
        if any(row[len(names) :]):
            raise HnavValueError("file", f"{path.name}: row {number} has {len(row)} cells, the header {len(names)}")
    return names, [(row + [""] * len(names))[: len(names)] for row in rows]


def _lines(path: Path) -> list[str]:
    """The header, and those of the rows."""
    try:
        data = path.read_bytes()
        text = data.decode(encoding_of(str(path), data))
    except OSError as error:
        raise HnavValueError("file", f"{path}: cannot be read: {error.strerror}") from None
    except RecordingError as error:
        raise HnavValueError("file", f"{path}: no table: {str(error).removeprefix(f'{path}: ')}") from None
    lines = [line for line in text.splitlines() if line.strip()]
    rows = [line for line in lines if not line.lstrip().startswith("#")]
    if not rows:
        raise HnavValueError("file", f"{path}: no table: all of its lines are comments")
    if all(map(is_number, _parted(path, rows[:1], _delimiter(rows[0]))[0])):
        # As numpy.savetxt writes it.
        rows = [*[line.lstrip("# ") for line in lines if line.lstrip().startswith("#")][-1:], *rows]
    return rows


def _cells_of_time(path: Path, cells: dict[str, list[str]]) -> tuple[str, list[str]]:
    """The name of the column of times, and what is in it; before a time of day its date, where that has a column."""
    names = {match[1].lower(): name for name in reversed(cells) if (match := _TIME.fullmatch(name))}
    kind = next((kind for kind in TIME if kind in names), None)
    if kind is None:
        raise HnavValueError("file", f"{path.name} has no column of times: call it t_s; it has {', '.join(cells)}")
    of_time = cells[names[kind]]
    days = cells[names["date"]] if kind != "date" and "date" in names else []
    if days and is_day_of(of_time[0], days[0]):
        of_time = [f"{day} {clock}" for day, clock in zip(days, of_time)]
    return names[kind], of_time


def _delimiter(header: str) -> str:
    return max((mark for mark in DELIMITERS if mark != BLANKS and mark in header), key=header.count, default=BLANKS)


def _parted(path: Path, lines: Sequence[str], delimiter: str) -> list[list[str]]:
    try:
        return [[cell.strip() for cell in row] for row in cells_of(lines, delimiter)]
    except csv.Error:
        raise HnavValueError("file", f"{path.name}: no table: a cell does not end; is there a quotation mark too many?") from None


def _times(path: Path, name: str, cells: list[str]) -> Column:
    """In seconds."""
    if cells and is_instant(cells[0]) and not is_number(cells[0]):
        try:
            return seconds_of(path.name, name, np.array(cells))
        except RecordingError as error:
            wrong = next((f"row {row}: {cell}" for row, cell in enumerate(cells, 1) if not is_instant(cell)), "")
            shown = f"{path.name}: {name} is no time in {wrong}; write {EXAMPLES}" if wrong else str(error)
            raise HnavValueError("file", shown) from None
    t = _numbers(path, name, cells, True)
    match = _TIME.fullmatch(name)
    unit = _UNITS[match[2]] if match and match[2] else 1.0
    largest = float(np.nanmax(np.abs(t), initial=0.0)) * unit
    # The stated unit of a clock since 1970 may be wrong: the size of its values decides.
    return t * unit * next((_UNITS[name] for limit, name in SINCE_1970 if largest > limit), 1.0)


def _numbers(path: Path, name: str, cells: list[str], needed: bool) -> Column:
    """Number by number, as Python reads them: the bits that were written."""
    numbers = np.full(len(cells), math.nan)
    for row, cell in enumerate(cells):
        if cell.lower() not in MISSING:
            try:
                switch = _SWITCHES.get(cell.lower())
                numbers[row] = float(cell) if switch is None else switch
            except ValueError:
                if needed:
                    raise HnavValueError("file", f"{path.name}: {name} is no number in row {row + 1}: {cell}") from None
    return numbers


def sample_table(head: Sequence[str], columns: Mapping[str, Column]) -> str:
    """The text of a table, with lines after # at its head; numbers in full, empty cells for NaN."""
    text = pd.DataFrame(dict(columns)).to_csv(index=False)
    return "".join(f"# {line}\n" for line in head) + str(text)
