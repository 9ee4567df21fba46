"""Cells of a text that is a table: what parts them, which are numbers, and the mark before decimals."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator

BLANKS = " "
"""The delimiter of cells that are parted by blanks, as many as there are."""
DELIMITERS = (",", ";", "\t", BLANKS)


def cells_of(lines: Iterable[str], delimiter: str) -> Iterator[list[str]]:
    """The cells of each line; quoted ones may hold delimiters and ends of lines. Raises csv.Error for one that is too long."""
    if delimiter == BLANKS:
        return (line.split() for line in lines)
    return csv.reader(lines, delimiter=delimiter, skipinitialspace=True)


def is_number(cell: str) -> bool:
    """Whether a cell is one, with a point or a comma before its decimals."""
    try:
        float(cell.strip().replace(",", "."))
    except ValueError:
        return False
    return True


def decimal_mark(delimiter: str, rows: str) -> str:
    """Of these rows: a comma where semicolons, tabs or blanks part the cells and none has a point."""
    return "," if delimiter != "," and "," in rows and "." not in rows else "."
