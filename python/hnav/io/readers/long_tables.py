"""Long tables: a row for each sample of one sensor, which a cell of it names, or for each axis of one.

time,sensor,x,y,z                          1706700000.01,gyroscope,0.1,0.2,0.3
timestamp_ms;type;v0;v1;v2;unit            10;ACC;0;0;1;g          (a header need not be there)
time,variable,value                        0.01,gyro_x,0.1
# UncalGyro,utcTimeMillis,UncalGyroXRadPerSec,...      (GnssLogger, GetSensorData: remarks with a header for the rows of each sensor)
"""

from __future__ import annotations

import csv
import io
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hnav.io.readers.cells import DELIMITERS, MISSING, cells_of, decimal_mark, is_number, number_of
from hnav.io.readers.columns import Column, column_of, columns_of
from hnav.io.readers.frames import raw_of_frames
from hnav.io.readers.instants import is_instant
from hnav.io.readers.stated_units import UNIT_NAMES
from hnav.io.readers.streams import CUT_OFF, Raw, Wishes
from hnav.io.readers.tables import encoding_of, without_zeros
from hnav.io.readers.unit_names import is_unit
from hnav.io.recordings import CSV_COLUMNS, RecordingError

if TYPE_CHECKING:
    import pandas as pd

PROBE_ROWS = 200
LEAST_SHARE = 0.4  # share of the first rows that name a known sensor: others may be of a barometer, satellites, a battery
SHOWN_CHARACTERS = 40
SENSORS = CSV_COLUMNS[1:]
REMARKS = ("#", "%", "/")
AXIS_BEHIND = re.compile(r"(?:.*[^a-z])?(?:v|val|value|axis|data)?([xyz0-3])")
Row = tuple[int, list[str]]
"""Its line, from 1, and its cells."""


@dataclass(frozen=True)
class Plan:
    """Positions of the cells in a row of a long table."""

    delimiter: str
    decimal: str
    kind: int
    """Position of the sensor name."""
    time: int | None
    values: tuple[int, ...]
    """Positions of x, y and z; or the position of the axis that the name states."""
    unit: int | None
    header: Sequence[str]
    """Empty if there is none."""
    headers: Mapping[str, Sequence[str]] = field(default_factory=dict)
    """Of the rows of one name each, as remarks state them."""

    def places(self, name: str, row: Sequence[str], names: Sequence[str]) -> dict[str, int]:
        """Positions of the cells of rows of this name, by the header that the remarks state for rows of this length, else by these names of the values."""
        if len(header := self.headers.get(name, ())) == len(row):
            return {text: place for place, text in enumerate(header) if place != self.kind and column_of(text, 0)}
        time = {} if self.time is None else {self.header[self.time].strip() if self.header else "time": self.time}
        return dict(zip(names, self.values)) | time


def is_long_table(path: Path, head: bytes) -> bool:
    return b"\0" not in head[:1024] and plan_of_long(head.decode("utf-8", "replace")) is not None


def read_long_table(path: Path, wishes: Wishes) -> Raw:
    """Each sensor as a table of its own. Raises RecordingError that names a line."""
    shown, data = str(path), without_zeros(path.read_bytes())
    text = data.decode(encoding_of(shown, data))
    if (plan := plan_of_long(text)) is None:
        raise RecordingError(f"{shown}: no column names sensors, such as gyroscope, in its rows")
    rows, notes = _rows_by_name(shown, text, plan)
    if len(plan.values) == 1:
        frames = _joined(shown, rows, plan)
    else:
        frames = {_bare(name): _frame(shown, name, own, plan, "xyz") for name, own in rows.items()}
    raw = raw_of_frames(shown, frames, wishes, "long")
    return replace(raw, notes=(*raw.notes, *notes))


# --------------------------------------------------------------------------------------------- the plan


def plan_of_long(text: str) -> Plan | None:
    """The plan by the first rows; None for a text that is not a long table."""
    head = [line for line in text[: PROBE_ROWS * 200].splitlines()[:PROBE_ROWS] if line.strip()]
    lines = [line for line in head if line[0] not in REMARKS]
    remarks = [line.lstrip("#%/ ") for line in head if line[0] in REMARKS]
    for delimiter in DELIMITERS:
        try:
            rows = [[cell.strip() for cell in row] for row in cells_of(lines, delimiter) if row]
        except csv.Error:
            return None
        if len(rows) > 1 and (plan := _plan_of_rows(rows, delimiter, lines)) is not None:
            return replace(plan, headers=_headers(cells_of(remarks, delimiter), plan.kind))
    return None


def _headers(remarks: Iterator[list[str]], kind: int) -> dict[str, list[str]]:
    """By the name of their rows, remarks that name columns of samples."""
    headers = ([cell.strip() for cell in cells if cell.strip()] for cells in remarks if len(cells) > kind)
    return {header[kind]: header for header in headers if {*_known(header)} - {"t_s"}}


def _plan_of_rows(rows: Sequence[Sequence[str]], delimiter: str, lines: Sequence[str]) -> Plan | None:
    kind = max(range(max(map(len, rows))), key=lambda place: sum(map(bool, _sensors(rows, place))))
    sensors = _sensors(rows, kind)
    samples = [row for row, sensor in zip(rows, sensors) if sensor]
    header = [] if sensors[0] or any(map(is_number, rows[0])) else rows[0]
    # In a table with columns of sensors, such cells have another meaning.
    if not _are_sensors(sensors) or {"gx", "ax"} <= _known(header).keys():
        return None
    return _plan_of_samples(samples, Plan(delimiter, decimal_mark(delimiter, lines), kind, None, (), None, header))


def _plan_of_samples(samples: Sequence[Sequence[str]], plan: Plan) -> Plan | None:
    """Adds the positions of times, values and units to the plan."""
    header, kind = plan.header, plan.kind
    places = [place for place in range(Counter(map(len, samples)).most_common(1)[0][0]) if place != kind]
    numeric = [place for place in places if _are_numbers(samples, place)]
    time = _place_of_time(header, samples, numeric, kind)
    values = _places_of_values(header, _without_counters(samples, [place for place in numeric if place != time], kind), kind)
    of_axes = column_of(samples[0][kind], 0) is not None
    if len(values) != (1 if of_axes else 3) or (of_axes and time is None):
        return None
    unit = next((place for place in places if place not in (time, *numeric) and _is_of_units(header, samples, place)), None)
    return replace(plan, time=time, values=values, unit=unit)


def _are_sensors(sensors: Sequence[str]) -> bool:
    """Whether enough cells of a column name sensors; single letters, which may be flags or units, must name both."""
    found = [sensor.lower() for sensor in sensors if sensor]
    single = all(len(sensor) == 1 for sensor in found)
    return len(found) >= max(2, LEAST_SHARE * len(sensors)) and (not single or {"g", "a"} <= {*found})


def _sensors(rows: Sequence[Sequence[str]], place: int) -> list[str]:
    """The names of sensors in a column, empty if there are none."""
    return [row[place] if place < len(row) and is_sensor(row[place]) else "" for row in rows]


def is_sensor(name: str) -> bool:
    """Whether a cell names a sensor, or an axis of one."""
    if not name or is_number(name):
        return False
    column = column_of(name, 0) or column_of(f"{_bare(name)}_x", 0)
    return column is not None and column.role in SENSORS


def _bare(name: str) -> str:
    """Without a unit in brackets."""
    return name.partition("(")[0].strip()


def _known(header: Sequence[str]) -> dict[str, Column]:
    try:
        return columns_of(header, {}, "")
    except RecordingError:
        return {}


def _are_numbers(rows: Sequence[Sequence[str]], place: int) -> bool:
    cells = [row[place] for row in rows if place < len(row) and row[place].lower() not in MISSING]
    return bool(cells) and sum(map(is_number, cells)) > 0.9 * len(cells)


def _is_of_units(header: Sequence[str], rows: Sequence[Sequence[str]], place: int) -> bool:
    called = place < len(header) and header[place].lower() in UNIT_NAMES
    return called or all(place < len(row) and is_unit(row[place]) for row in rows)


def _place_of_time(header: Sequence[str], rows: Sequence[Sequence[str]], numeric: Sequence[int], kind: int) -> int | None:
    """By the header; without one instants, or the first number if more than one or three numbers remain."""
    if (column := _known(header).get("t_s")) is not None:
        return column.place
    for place in range(len(rows[0])):
        if place != kind and all(place < len(row) and is_instant(row[place]) for row in rows):
            return place
    return numeric[0] if len(numeric) > 1 and len(numeric) != 3 else None


def _without_counters(rows: Sequence[Sequence[str]], numeric: Sequence[int], kind: int) -> list[int]:
    """These positions without those whose numbers increase in the rows of each sensor, as a second time does, if three remain."""
    of_sensors = [[row for row in rows if row[kind] == name] for name in {row[kind] for row in rows}]

    def increases(place: int) -> bool:
        cells = ([number_of(row[place]) for row in own if place < len(row) and is_number(row[place])] for own in of_sensors)
        return all(len(numbers) > 2 and (np.diff(numbers) > 0).all() for numbers in cells)

    kept = [place for place in numeric if not increases(place)]
    return kept if len(kept) >= len("xyz") else list(numeric)


def _places_of_values(header: Sequence[str], numeric: Sequence[int], kind: int) -> tuple[int, ...]:
    """x, y and z by the ends of their names; otherwise the first three numbers, or the only one, after the name of the sensor."""
    ends = {place: AXIS_BEHIND.fullmatch(header[place].strip().lower()) for place in numeric if place < len(header)}
    for axes in ("xyz", "012", "123"):
        found = [next((place for place, end in ends.items() if end and end.group(1) == axis), None) for axis in axes]
        if None not in found:
            return tuple(place for place in found if place is not None)
    behind = [place for place in numeric if place > kind] or list(numeric)
    return tuple(behind[:3]) if len(behind) >= 3 else tuple(behind[:1])


# --------------------------------------------------------------------------------------------- the rows


def _rows_by_name(shown: str, text: str, plan: Plan) -> tuple[dict[str, list[Row]], list[str]]:
    """The rows of each sensor by its name, and the numbers of ignored rows. Raises RecordingError for a row that is too short."""
    found: dict[str, list[Row]] = {}
    other = dict.fromkeys(["", plan.header[plan.kind].strip() if plan.header else ""])
    needed: dict[str, int] = {}
    cut = None
    for line, row in enumerate(_cells(shown, text, plan.delimiter), 1):
        if cut is not None:
            raise cut
        name = _name_of(row, plan)
        if name not in needed and name not in other:
            if name in plan.headers or is_sensor(name):
                needed[name] = 1 + max(plan.kind, *plan.places(name, row, "xyz").values())
            else:
                other[name] = None
        if name in other:
            continue
        if len(row) < needed[name]:
            cut = RecordingError(f"{shown}, line {line}: {len(row)} cells, where the rows of {name} have {needed[name]} or more")
            continue
        found.setdefault(name, []).append((line, row))
    left = [name for name in other if name][bool(plan.header) :]
    notes = [CUT_OFF] if cut is not None else []
    return found, notes + ([f"rows of {', '.join(left[:8])} are left out"] if left else [])


def _name_of(row: Sequence[str], plan: Plan) -> str:
    """Of the sensor; a remark has none."""
    return row[plan.kind].strip() if plan.kind < len(row) and row[0].strip()[:1] not in REMARKS else ""


def _cells(shown: str, text: str, delimiter: str) -> Iterator[list[str]]:
    try:
        yield from cells_of(io.StringIO(text, newline=None), delimiter)
    except csv.Error:
        raise RecordingError(f"{shown}: not a text file") from None


def _frame(shown: str, sensor: str, rows: Sequence[Row], plan: Plan, names: Sequence[str]) -> pd.DataFrame:
    """Values under these names, times, and units, which may also stand in brackets after the name of the sensor. Raises
    RecordingError for a cell without a number."""
    import pandas

    columns: dict[str, object] = {}
    for name, place in plan.places(sensor, rows[0][1], names).items():
        instants = place == plan.time and is_instant(rows[0][1][place])
        columns[name] = [row[place] for _, row in rows] if instants else _numbers(shown, rows, place, plan)
    if plan.unit is not None:
        columns["unit"] = [row[plan.unit].strip() if plan.unit < len(row) else None for _, row in rows]
    elif len(names) > 1 and (unit := sensor.partition("(")[2].rstrip(") ")):
        columns["unit"] = len(rows) * [unit]
    return pandas.DataFrame(columns)


def _numbers(shown: str, rows: Sequence[Row], place: int, plan: Plan) -> np.ndarray:
    try:
        return np.array([row[place] for _, row in rows], float)
    except ValueError:
        pass
    numbers = np.empty(len(rows))
    for i, (line, row) in enumerate(rows):
        try:
            numbers[i] = number_of(row[place], plan.decimal)
        except ValueError:
            raise RecordingError(f"{shown}, line {line}: {row[place].strip()[:SHOWN_CHARACTERS]!r} is not a number") from None
    return numbers


def _joined(shown: str, rows: dict[str, list[Row]], plan: Plan) -> dict[str, pd.DataFrame]:
    """Axes of one sensor side by side, at their common times."""
    joined: dict[str, pd.DataFrame] = {}
    for name, of_axis in rows.items():
        role = str(getattr(column_of(name, 0), "role", ""))
        frame = _frame(shown, name, of_axis, plan, [name])
        time = frame.columns[1]
        if role[0] in joined:
            same = len(frame) == len(joined[role[0]]) and frame[time].equals(joined[role[0]][time])
            one = joined[role[0]]
            joined[role[0]] = one.assign(**{name: frame[name]}) if same else one.merge(frame[[name, time]], on=time)
        else:
            joined[role[0]] = frame
    return joined
