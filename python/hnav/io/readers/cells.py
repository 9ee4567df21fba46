"""Cells of a text table: delimiters, numbers, and the decimal mark."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterable, Iterator

BLANKS = " "
"""The delimiter of cells that are separated by any number of blanks."""
DELIMITERS = (",", ";", "\t", "|", BLANKS)
MISSING = frozenset({"", "na", "n/a", "#n/a", "<na>", "nan", "null", "none", "-", "--", "unavailable", "unknown"})
"""Cells without a number, in small letters."""
_MINUS = dict.fromkeys(map(ord, "−–"), "-")
"""Characters that word processors and spreadsheets use for a minus."""
_EXPONENT = r"(?:[eE][-+]?\d+)?"
_DECIMALS = {mark: re.compile(rf"[-+]?[\d{other}]*{mark}\d*{_EXPONENT}") for mark, other in ((",", "."), ("[.]", ","))}
_THOUSANDS = {".": re.compile(r"[-+]?\d{1,3}(,\d{3})+(\.\d*)?"), ",": re.compile(r"[-+]?\d{1,3}(\.\d{3})+(,\d*)?")}


def cells_of(lines: Iterable[str], delimiter: str) -> Iterator[list[str]]:
    """The cells of each line; quoted ones may hold delimiters and ends of lines. Raises csv.Error for a cell that is too long."""
    if delimiter == BLANKS:
        return (line.split() for line in lines)
    return csv.reader(lines, delimiter=delimiter, skipinitialspace=True)


def number_of(cell: str, decimal: str = ".") -> float:
    """Of a cell as people and programs write it, NaN where it says that there is none. Raises ValueError for what is no number.

    A spreadsheet puts an apostrophe before what it takes for a text; 1.234,5 has a mark of thousands.
    """
    text = cell.strip().lstrip("'").translate(_MINUS)
    if text.lower() in MISSING:
        return math.nan
    if _THOUSANDS[decimal].fullmatch(text):
        text = text.replace("," if decimal == "." else ".", "")
    return float(text.replace(decimal, "."))


_NO_FIX = re.compile(
    r"((gps|gnss|fix|type|status) )*(no|not|none|nofix|invalid|false|void)( (gps|gnss|fix|position|solution|valid|available))*"
    r"|time( only)?"
)


def fixes_of(cells: Iterable[object]) -> list[float]:
    """What cells state of a fix: a number, -1 for words such as No fix, infinity for those of a fix; beside words an empty one is no fix."""
    found, words = [], False
    for cell in map(str, cells):
        try:
            found.append(number_of(cell))
        except ValueError:
            words = True
            found.append(-1.0 if _NO_FIX.fullmatch(" ".join(re.findall(r"[a-z\d]+", cell.lower()))) else math.inf)
    return [-1.0 if words and math.isnan(one) else one for one in found]


def is_number(cell: str) -> bool:
    """Whether a cell is a number, with a point or a comma as its decimal mark."""
    try:
        float(cell.strip().replace(",", "."))
    except ValueError:
        return False
    return True


def decimal_mark(delimiter: str, rows: Iterable[str]) -> str:
    """The decimal mark of these rows: a comma if cells have decimals after a comma and none has a point; in 1.234,5 it is the
    last mark."""
    commas = points = False
    for row in cells_of(rows, delimiter):
        for cell in row:
            commas |= _DECIMALS[","].fullmatch(cell.strip()) is not None
            points |= _DECIMALS["[.]"].fullmatch(cell.strip()) is not None
            if "." in cell and _DECIMALS[","].fullmatch(cell.strip()):
                return ","
    return "," if commas and not points else "."
