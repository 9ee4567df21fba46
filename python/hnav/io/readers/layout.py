"""The layout of a text table: line of the header, delimiter, lines of units and of the first row."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import islice

from hnav.io.readers.cells import BLANKS, DELIMITERS, cells_of, decimal_mark, is_number
from hnav.io.readers.columns import columns_of
from hnav.io.readers.instants import is_instant
from hnav.io.readers.unit_names import is_unit
from hnav.io.recordings import RecordingError

HEADER_WITHIN = 1000  # lines without a leading number
COMMENT = "/#% "
NUMBER_FIRST = re.compile(r"\s*[-+]?\d+([.,]\d*)?([eE][-+]?\d+)?\s*([,;\t| ]|$)")


@dataclass(frozen=True)
class Layout:
    """The position of the header of a table, and its delimiter."""

    line: int
    """Line of the header, from 0; -1: there is none."""
    names: list[str]
    delimiter: str
    decimal: str = "."
    units: list[str] = field(default_factory=list)
    """Cells of a line of units under the header, where there is one."""

    @property
    def first_row(self) -> int:
        """The line of the first samples, from 0."""
        return self.line + (2 if self.units else 1)


def layout_of(shown: str, text: str, given: Mapping[str, str], sensor: str | None = None) -> Layout:
    """The header is the line that names most columns, the first of them. Raises RecordingError for cells without end.

    given: names of columns that the caller has assigned, by their roles.
    """
    best, score = Layout(0, [], ","), -1
    lines = [line.rstrip("\n") for line in islice(io.StringIO(text, newline=None), HEADER_WITHIN)]
    for number, line in enumerate(lines):
        if NUMBER_FIRST.match(line):
            continue
        for delimiter in DELIMITERS:
            names = _names(shown, line, delimiter)
            if delimiter == BLANKS and not _fits(names, lines[number + 1 :]):
                continue
            found = _roles_in(names, given, sensor)
            if found > score:
                best, score = Layout(number, names, delimiter), found
        if score > 2:
            break
    if score <= 0 and given:
        best = _without_header(shown, lines, given) or best
    best = replace(best, units=_units_under(shown, best, lines))
    return replace(best, decimal=decimal_mark(best.delimiter, lines[best.first_row :]))


def at_header(shown: str, layout: Layout) -> str:
    """What messages call the place of the header."""
    return f"{shown}, line {layout.line + 1}" if layout.line >= 0 else shown


def rows_of(lines: Iterable[str], layout: Layout) -> Iterator[tuple[int, list[str]]]:
    """Line from 1, and cells, of each row of samples."""
    for number, row in enumerate(cells_of(lines, layout.delimiter)):
        if number >= layout.first_row and row:
            yield number + 1, row


def without_empty_end(cells: list[str]) -> list[str]:
    """A row without the empty cells at its end."""
    filled = len(cells)
    while filled and not cells[filled - 1].strip():
        filled -= 1
    return cells[:filled]


def _names(shown: str, line: str, delimiter: str) -> list[str]:
    return line.lstrip(COMMENT).split() if delimiter == BLANKS else _cells(shown, line.lstrip("/ "), delimiter)


def _cells(shown: str, line: str, delimiter: str) -> list[str]:
    try:
        return next(cells_of([line], delimiter), [])
    except csv.Error:  # a cell without end
        raise RecordingError(f"{shown}: not a text file") from None


def _fits(names: list[str], below: list[str]) -> bool:
    """Whether the line below, perhaps one of units between, has a number or a time for each name; otherwise the header is prose with words
    like names."""
    rows = (line.split() for line in below if line.strip())
    cells = next(rows, [])
    if any(map(is_unit, cells)):
        cells = next(rows, [])
    return len(cells) == len(names) and all(is_number(cell) or is_instant(cell) for cell in cells)


def _roles_in(names: list[str], given: Mapping[str, str], sensor: str | None) -> int:
    try:
        return len(columns_of(names, given, "", sensor))
    except RecordingError as error:
        # A duplicate column is a faulty header; a line without a name that the caller gave is no header.
        return 0 if error.argument == "columns" and given else 3


def _without_header(shown: str, lines: list[str], given: Mapping[str, str]) -> Layout | None:
    """A table of numbers whose columns the caller names by their positions, from 1."""
    if not all(name.lstrip("-").isdigit() for name in given.values()):
        return None
    counts = {delimiter: len(_cells(shown, next(iter(lines), ""), delimiter)) for delimiter in DELIMITERS}
    delimiter = max(counts, key=lambda delimiter: counts[delimiter])
    return Layout(-1, [str(i + 1) for i in range(counts[delimiter])], delimiter)


def _units_under(shown: str, layout: Layout, lines: list[str]) -> list[str]:
    """The cells of the line under the header, where they are words, no more than columns, and one is a unit."""
    if layout.line < 0 or layout.line + 1 >= len(lines):
        return []
    under = lines[layout.line + 1]
    cells = under.split() if layout.delimiter == BLANKS else _cells(shown, under, layout.delimiter)
    words = [cell for cell in cells if cell.strip()]
    if any(map(is_number, words)) or len(without_empty_end(cells)) > len(layout.names):
        return []
    return cells if any(map(is_unit, words)) else []
