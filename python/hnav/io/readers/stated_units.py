"""Units that stand beside the numbers, not in the names of their columns: {"units": {"gyro": "deg/s"}}, "gyro_unit", a column of units.

They become part of the names, gx (deg/s), so that a unit that is not known is refused as one of a header.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from hnav.io.readers.columns import QUANTITY_OF, column_of
from hnav.io.recordings import CSV_COLUMNS, RecordingError

if TYPE_CHECKING:
    import pandas as pd

UNIT_NAMES = ("unit", "units")
OF_ANOTHER = re.compile(r"(?:.*_)?units?_(.+)|(.+?)[_ .]?units?", re.IGNORECASE)
"""gyro_unit, and units_gyro of a struct in MATLAB, are that of gyro."""
DEEPEST = 8


def units_in(tree: Any) -> dict[str, str]:
    """By gyro, accel, mag and time what a tree says of their units, in mappings; the first that says it counts."""
    found: dict[str, str] = {}
    for name, text in _stated(tree, "", 0):
        if quantity := quantity_named(name):
            found.setdefault(quantity, text)
    return found


def quantity_named(name: str) -> str | None:
    """gyro, accel, mag or time, if the name of a sensor, an axis or a time stands there."""
    for text in (name, f"{name}_x"):
        column = column_of(text, 0)
        if column is not None and column.role in CSV_COLUMNS:
            return QUANTITY_OF[column.role[0]]
    return None


def _stated(tree: Any, name: str, depth: int) -> Iterator[tuple[str, str]]:
    """Names and the texts of their units."""
    if not isinstance(tree, Mapping) or depth > DEEPEST:
        return
    for key, value in tree.items():
        key = str(key)
        if key.lower() in UNIT_NAMES:
            inner = value.items() if isinstance(value, Mapping) else [(name, value)]
            yield from ((str(of), text) for of, one in inner if (text := _text(one)))
        elif (match := OF_ANOTHER.fullmatch(key)) and (text := _text(value)):
            yield match.group(1) or match.group(2), text
        else:
            yield from _stated(value, key, depth + 1)


def _text(value: Any) -> str:
    """A text, or that of a few that are all the same."""
    if isinstance(value, (list, tuple)) and 0 < len(value) <= 3 and all(one == value[0] for one in value):
        value = value[0]
    return str(value) if isinstance(value, str) else ""


def with_units(shown: str, frame: pd.DataFrame, units: Mapping[str, str]) -> pd.DataFrame:
    """The frame, its columns called after their units: by its own columns of units, else by these, by quantity. Raises RecordingError
    for a column of several units."""
    own, renamed = _own_units(shown, frame), {}
    for name in map(str, frame.columns):
        if (column := column_of(name, 0)) is None or column.unit or column.role not in CSV_COLUMNS:
            continue
        quantity = QUANTITY_OF[column.role[0]]
        stated = own.get(name.removesuffix("_value"), own.get("", "") if quantity != "time" else "")
        if stated := stated or units.get(quantity, ""):
            renamed[name] = f"{name} ({stated})"
    return frame.rename(columns=renamed)


def _own_units(shown: str, frame: pd.DataFrame) -> dict[str, str]:
    """What columns of units say, by the names of the columns that they belong to; "" is the whole frame."""
    import pandas

    own: dict[str, str] = {}
    for name in map(str, frame.columns):
        match = OF_ANOTHER.fullmatch(name)
        if (match or name.lower() in UNIT_NAMES) and not pandas.api.types.is_numeric_dtype(frame[name]):
            texts = frame[name].dropna().unique()
            if len(texts) > 1:
                raise RecordingError(
                    f"{shown}: the column {name} holds {texts[0]} and {texts[1]}: write one unit for each sensor"
                )
            own |= {match.group(1) or match.group(2) if match else "": str(text) for text in texts}
    return own
