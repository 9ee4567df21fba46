"""Tables: CSV, TSV, text with semicolons or blanks, whatever their columns are called; and data frames.

Errors name line and column.
"""

from __future__ import annotations

import csv
import io
import re
import warnings
from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from hnav.io.aids import AidSamples
from hnav.io.readers.aids import NO_POSITIONS, aids_and_notes
from hnav.io.readers.cells import BLANKS, MISSING, decimal_mark, fixes_of, number_of
from hnav.io.readers.clock import mended, unit_by_size
from hnav.io.readers.columns import (
    DAY,
    FRACTION,
    GRAVITY,
    OWN_TIMES,
    QUANTITY_OF,
    Column,
    column_of,
    columns_of,
    sensor_like,
    with_unit,
)
from hnav.io.readers.instants import is_day_of, is_instant, seconds_of, with_day
from hnav.io.readers.layout import Layout, at_header, layout_of, rows_of, without_empty_end
from hnav.io.readers.row_order import by_time, only_unordered
from hnav.io.readers.streams import BY_RATE, CUT_OFF, Raw, Stream, Wishes, alone, cannot_be_read, library
from hnav.io.readers.unit_names import unknown_unit, words_in
from hnav.io.recordings import ARRAYS, CSV_COLUMNS, RecordingError, Unit
from hnav.units import si_per

if TYPE_CHECKING:
    import pandas as pd

HEAD_CHARACTERS = 100_000  # the header, and the first rows
SHOWN_CHARACTERS, SHOWN_COLUMNS, MOST_NAMES = 40, 20, 12
EARTH_UT = (18.0, 80.0)
OFF_ONE_G = 0.02  # gravity in g has the length 1
LEAST_SHARE_OF_GRAVITY = 0.5  # of the median length of a force, that of one with gravity
NEGATED = ", negated because iOS gives the opposite of the force"
SHUFFLED = 0.25  # share of time stamps that run back, of which half do in rows without any order
MOST_REMARKS, FEWEST_REMARKS, FEWEST_ROWS = 0.01, 3, 8
"""Share and number of lines that may be remarks of a logger, not rows, and the rows that must stand beside them."""
MARKS = "; where decimals have commas too, part the cells by semicolons"
DEVICE = re.compile(
    r"(device|sensor|imu|node|serial|mac|module)[ _-]?(name|id|no|nr|number|address)?|tag[ _-]?(id|no|nr|number|address)",
    re.IGNORECASE,
)
"""Names of columns that distinguish rows of several devices."""
OF_TIME = re.compile(r"time|stamp|clock|date|sec|(?<![a-z])[mun]s(?![a-z])", re.IGNORECASE)
OF_ROWS = re.compile(rf".*(count|packet|index|seq|number).*|(.*[^a-z])?(id|no|nr|row)|{DEVICE.pattern}", re.IGNORECASE)
"""Names of columns of times, and of those that number or name rows: neither is of a sensor."""
MOST_DEVICES = 20
"""More are no names."""
ENCODINGS = ("utf-8-sig", "cp1252")
UTF_16 = (b"\xff\xfe", b"\xfe\xff")
DATE_AND_CLOCK = re.compile(r"(?<=\d[-/.]\d\d[-/.]\d\d) (?=\d\d:\d\d:[\d.]+[ \t]+[-+.\d])")
"""The blank within an instant of a table whose cells are parted by blanks."""
NEEDED_OF_HOUSE = CSV_COLUMNS[:7]
NOT_DIGESTED = (ValueError, OverflowError, Warning)
"""What frames_of may end with."""


class SeveralDevices(RecordingError):
    """A table has rows of several devices."""


@dataclass(frozen=True)
class Plan:
    """The plan for reading a text, by its first lines."""

    encoding: str
    layout: Layout
    columns: Mapping[str, Column]
    instants: bool
    """The times are instants of a calendar."""

    @property
    def used(self) -> list[int]:
        """Places of the columns that are read."""
        return sorted({column.place for column in self.columns.values()})

    def kind(self, place: int) -> type:
        """The type of the cells of a column."""
        return str if place in self.texts else float

    @property
    def texts(self) -> set[int]:
        """Places of the columns whose cells may be no numbers."""
        times = [*self.times, *([self.columns[DAY]] if DAY in self.columns else [])] if self.instants else []
        return {column.place for column in (*times, *(column for column in self.columns.values() if column.of_fix))}

    @property
    def times(self) -> list[Column]:
        """The columns of times."""
        return [self.columns[role] for role in ("t_s", *OWN_TIMES.values()) if role in self.columns]


@dataclass(frozen=True)
class Table:
    """The columns of a file that hold times and samples."""

    columns: Mapping[str, Column]
    values: Mapping[str, np.ndarray]
    """By role; t_s in the unit of the file, NaN for empty cells."""
    layout: Layout
    instants: bool = False
    """The times were instants of a calendar, and are in s now."""
    notes: tuple[str, ...] = ()
    """What was left out."""

    def of_sensor(self, sensor: str) -> Table:
        """The rows of a sensor, where it has times of its own; else all."""
        if (role := OWN_TIMES[sensor]) not in self.columns:
            return self
        kept = np.isfinite(self.values[role])
        values = {name: column[kept] for name, column in self.values.items()}
        return replace(self, columns={**self.columns, "t_s": self.columns[role]}, values={**values, "t_s": values[role]})


def read_table(path: Path, wishes: Wishes) -> Raw:
    """One table with all sensors. Raises RecordingError."""
    table = parse(str(path), path.read_bytes(), wishes)
    return raw_of(str(path), table, wishes)


def raw_of(shown: str, table: Table, wishes: Wishes, by_format: Mapping[str, str] | None = None, name: str = "") -> Raw:
    """The streams of a table whose rows hold all sensors. Raises RecordingError."""
    house = set(NEEDED_OF_HOUSE) <= {column.name.strip() for column in table.columns.values()}
    by_format = by_format or {}
    if wishes.rate_hz is None and not wishes.only_aids:  # which go by intervals, and by the arrival of aids
        values, moved = by_time(table.values)
        table = replace(table, values=values, notes=(*table.notes, *moved))
    timed = table.of_sensor("gyro")
    t_s, time_unit, notes = times_of(shown, timed, wishes, by_format)
    aids, more = _aids_of(shown, timed, t_s, wishes)
    notes = (*notes, *more)
    if wishes.only_aids:
        return Raw(name or "table", [], time_unit, notes, aids=aids)
    streams: list[Stream] = []
    for sensor in ARRAYS:
        if not _has(shown, table, sensor, wishes):
            continue
        own = table.of_sensor(sensor)
        if own is not table:
            t_s, _, mended_times = times_of(shown, own, wishes, by_format)
            notes = (*notes, *(note for note in mended_times if note not in notes))
        streams.append(stream_of(shown, own, sensor, t_s, wishes, by_format.get(sensor)))
    return Raw(name or ("csv" if house else "table"), streams, time_unit, (*table.notes, *notes), aids=aids)


def _aids_of(shown: str, table: Table, t_s: np.ndarray, wishes: Wishes) -> tuple[dict[str, AidSamples], list[str]]:
    """Its aids, and notes on them; those of an uncertain unit do not refuse the inertial samples. Raises RecordingError."""
    try:
        return aids_and_notes(table.columns, table.values, t_s)
    except RecordingError as error:
        if wishes.only_aids:
            raise RecordingError(f"{at_header(shown, table.layout)}: {error}", "columns") from None
        return {}, [f"{NO_POSITIONS}{error}"]


def _has(shown: str, table: Table, sensor: str, wishes: Wishes) -> bool:
    """Whether the table has columns of the sensor. Raises RecordingError where it must."""
    roles = [sensor[0] + axis for axis in "xyz"]
    there = any(role in table.columns for role in roles)
    if there or sensor == "mag":
        return there
    is_inertial = any(role in table.columns for role in NEEDED_OF_HOUSE[1:]) or {"gyro", "accel"} & {*_unread(table).values()}
    if any(column.aids for column in table.columns.values()) and not is_inertial:
        alone(shown, wishes)
    raise RecordingError(missing_column(shown, table, *roles))


def stream_of(shown: str, table: Table, sensor: str, t_s: np.ndarray, wishes: Wishes, by_format: str | None) -> Stream:
    """The samples of a sensor of the table. Raises RecordingError when an axis is missing."""
    roles = [sensor[0] + axis for axis in "xyz"]
    if missing := [role for role in roles if role not in table.columns]:
        raise RecordingError(missing_column(shown, table, *missing))
    columns = [table.columns[role] for role in roles]
    values = np.stack([column.sign * table.values[column.role] for column in columns], axis=1)
    by_header = next((column.unit for column in columns if column.unit), None)
    if getattr(wishes, f"{sensor}_unit") is None:
        _refuse_strange_unit(shown, table, sensor, columns)
    unit = wishes.unit(sensor, by_header, by_format)
    values = values * _per_axis(sensor, columns, unit)
    if sensor == "mag" and unit.source == "assumed" and _are_microteslas(values):
        unit = Unit("uT", "by its strength")
    if sensor == "accel" and set(GRAVITY) <= table.columns.keys():
        return _with_gravity_of_table(shown, table, Stream(sensor, t_s, values, unit))
    return Stream(sensor, t_s, values, unit)


def _with_gravity_of_table(shown: str, table: Table, rest: Stream) -> Stream:
    """The whole force of a table with an acceleration without gravity, and gravity beside it, as iOS and Android compute them. Raises
    RecordingError."""
    columns = [table.columns[role] for role in GRAVITY]
    _refuse_strange_unit(shown, table, "accel", columns)
    gravity, unit = np.stack([table.values[role] for role in GRAVITY], axis=1), rest.unit
    if unit.source == "assumed" and columns[0].unit is None and abs(_strength(gravity) - 1) < OFF_ONE_G:
        unit = Unit("g", "by its strength")
    gravity *= [si_per("accel", column.unit or unit.name) / si_per("accel", unit.name) for column in columns]
    mine = table.columns["ax"].name.strip()
    of_apple = unit.name == "g" and "user" in words_in(mine)
    if not lacks_gravity(rest.values, gravity):
        return rest
    return with_gravity(replace(rest, unit=unit), gravity, f"{mine} and {columns[0].name.strip()}", of_apple)


def with_gravity(rest: Stream, gravity: np.ndarray, names: str, negated: bool) -> Stream:
    """The whole force of accelerations without the gravity beside them. names: of both, for the note."""
    note = f"accel: sum of {names}" + (NEGATED if negated else "")
    return replace(rest, values=(-1.0 if negated else 1.0) * (rest.values + gravity), notes=(note,))


def lacks_gravity(force: np.ndarray, gravity: np.ndarray) -> bool:
    """Whether forces are so small that gravity beside them is no part of them."""
    return _strength(force) < LEAST_SHARE_OF_GRAVITY * _strength(gravity)


def _strength(vectors: np.ndarray) -> float:
    """Their median length."""
    lengths = np.linalg.norm(vectors[np.isfinite(vectors).all(axis=1)], axis=1)
    return float(np.median(lengths)) if len(lengths) else np.nan


def _per_axis(sensor: str, columns: Sequence[Column], unit: Unit) -> Sequence[float]:
    """Factors to the unit of the first axis for axes whose names state other ones."""
    if unit.source != "by header":
        return [1.0] * len(columns)
    return [si_per(sensor, column.unit or unit.name) / si_per(sensor, unit.name) for column in columns]


def _refuse_strange_unit(shown: str, table: Table, sensor: str, columns: Sequence[Column]) -> None:
    """Raises RecordingError for a unit of the header that is not understood."""
    for column in columns:
        if column.strange:
            raise RecordingError(f"{at_header(shown, table.layout)}: {unknown_unit(sensor, column.name.strip(), column.strange)}")


def _are_microteslas(field: np.ndarray) -> bool:
    """Whether numbers of an unsaid unit are as large as the field of the Earth in uT; in another unit nothing on Earth is."""
    return EARTH_UT[0] < _strength(field) < EARTH_UT[1]


def times_of(shown: str, table: Table, wishes: Wishes, by_format: Mapping[str, str]) -> tuple[np.ndarray, Unit, tuple[str, ...]]:
    """The times of the rows in s, their unit, and notes about corrections. Raises RecordingError for unusable times."""
    n = len(next(iter(table.values.values())))
    if wishes.rate_hz is not None:
        return np.arange(n) / wishes.rate_hz, BY_RATE, ()
    column = table.columns.get("t_s")
    if column is None:
        raise RecordingError(f"{missing_column(shown, table, 't_s')}, or give rate_hz")
    stated = table.values["t_s"]
    unit = Unit("s", "by header")
    if not table.instants:
        if wishes.time_unit is None:
            _refuse_strange_unit(shown, table, "time", [column])
        unit = unit_by_size(stated, wishes.unit("time", column.unit, by_format.get("time")), table.columns)
    t_s = stated * si_per("time", unit.name)
    if wishes.only_aids and np.isfinite(t_s).all():  # each goes by the time at which it arrived
        return t_s, unit, ()
    if _can_be_ordered(table, t_s):
        return t_s, unit, ()
    if done := mended(t_s):
        return done[0], unit, (done[1],)
    raise RecordingError(_fault_of_times(shown, table, t_s))


def _can_be_ordered(table: Table, t_s: np.ndarray) -> bool:
    """Whether times increase, or do when rows that came twice or late are put in order."""
    back = ~np.isfinite(t_s) | (np.diff(t_s, prepend=-np.inf) <= 0)
    if not back.any():
        return True
    return bool(np.isfinite(t_s).all()) and (_stands_twice(table, np.flatnonzero(back) - 1) or only_unordered(t_s))


def _fault_of_times(shown: str, table: Table, t_s: np.ndarray) -> str:
    """The first time that is none, or does not increase."""
    first, name = table.layout.first_row + 1, table.columns["t_s"].name.strip()
    if len(bad := np.flatnonzero(~np.isfinite(t_s))):
        return f"{shown}, line {bad[0] + first}, column {name}: a time is missing or not finite"
    i, shuffled = int(np.flatnonzero(np.diff(t_s) <= 0)[0]), (np.diff(t_s) < 0).mean() > SHUFFLED
    cure = f'sort the rows by it, in pandas sort_values("{name}")' if shuffled else "for samples at equal intervals give rate_hz"
    return f"{shown}, line {i + first + 1}, column {name}: time {t_s[i + 1]:.10g} does not increase after {t_s[i]:.10g}; {cure}"


def missing_column(shown: str, table: Table, *roles: str) -> str:
    """What to say of columns that were not found: those that the file has, and a line to copy that names them in order."""
    names = [name.strip() for name in table.layout.names]
    at = f"{at_header(shown, table.layout)}: the column {roles[0]} is missing; the file has {_listed(names, SHOWN_COLUMNS)}"
    free = _unread(table)
    if len(roles) == len("xyz") and table.columns and not free:
        return f"{at}, and nothing of the {QUANTITY_OF[roles[0][0]]}: record gyroscope and accelerometer together"
    proposed = _proposed(free, roles) or ["NAME"]
    quoted = [f'"{name}"' if " " in name else name for name in proposed]
    line = " ".join(f"columns {role}={name}" for role, name in zip(roles, quoted))
    return f"{at}: say which it is, such as {line}"


def _listed(names: Sequence[str], most: int) -> str:
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")


def _unread(table: Table) -> dict[str, str | None]:
    """Names of the columns without a role, and the sensor that each may be of."""
    units = dict(enumerate(table.layout.units))
    return {name: sensor_like(name, units.get(place, "")) for place, name in _without_role(table.layout.names, table.columns)}


def _proposed(free: Mapping[str, str | None], roles: Sequence[str]) -> Sequence[str]:
    """Which of the columns without a role may have these, in their order."""
    if roles == ("t_s",):
        return [name for name in free if OF_TIME.search(name)]
    sensor = QUANTITY_OF[roles[0][0]]
    wanted = {sensor} if sensor in free.values() else {None}
    named = [name for name, like in free.items() if like in wanted and not OF_TIME.search(name) and not OF_ROWS.fullmatch(name)]
    by_axis = [next((name for name in named if re.search(rf"(?<![a-z]){role[1]}(?![a-z])", name.lower())), "") for role in roles]
    return by_axis if all(by_axis) else named


def say_places(names: Sequence[object], known: Sequence[str] = CSV_COLUMNS) -> str:
    """How to name columns that are only numbered: t_s=1,gx=2 ...; six or nine are without times. Of fewer, or named ones, nothing.
    known: the names that they may have, in order."""
    if len(names) < 6 or not all(str(name)[-1:].isdigit() for name in names):
        return ""
    untimed = len(names) in (6, 9)
    roles = known[untimed : len(names) + untimed]
    places = ",".join(f"{role}={place}" for place, role in enumerate(roles, 1)) + (" rate_hz=100" if untimed else "")
    return f"say their places, such as columns {places}"


def _stands_twice(table: Table, rows: np.ndarray) -> bool:
    """Whether the rows after these only repeat them: a logger that wrote rows twice has lost nothing."""
    if not 0 < len(rows) < len(table.values["t_s"]) - 1:
        return False
    return all(np.array_equal(values[rows], values[rows + 1], equal_nan=True) for values in table.values.values())


# --------------------------------------------------------------------------------------------- text


def parse(shown: str, data: bytes, wishes: Wishes, sensor: str | None = None) -> Table:
    """The columns of a text. sensor: the only one whose samples it holds. Raises RecordingError that names line and column."""
    data = without_zeros(data)
    encoding = encoding_of(shown, data)
    text = data.decode(encoding)
    if DATE_AND_CLOCK.search(text[:HEAD_CHARACTERS]):
        text = DATE_AND_CLOCK.sub("T", text)
        data = text.encode(encoding)
    plan = plan_of(shown, text[:HEAD_CHARACTERS], encoding, wishes, sensor)
    notes: tuple[str, ...] = ()
    if end := _end_of_whole_lines(shown, text, plan):
        text, notes = text[:end], (CUT_OFF,)
        data = text.encode(encoding)
    try:
        frame, more = _read(shown, text, io.BytesIO(data), plan)
    except RecordingError as error:
        if wishes.only_aids or not any(column.aids for column in plan.columns.values()):
            raise
        # Faulty aiding columns do not refuse the inertial samples.
        plan = replace(plan, columns={role: column for role, column in plan.columns.items() if not column.aids})
        notes = (*notes, f"satellites, pressure and wheels were left out: {error}")
        frame, more = _read(shown, text, io.BytesIO(data), plan)
    if frame.empty:
        raise RecordingError(f"{shown}: no rows after the header")
    refuse_devices(shown, lambda: io.StringIO(text, newline=None), plan)
    return replace(table_by(shown, frame, plan), notes=(*notes, *more, *_not_read(plan, sensor)))


def _not_read(plan: Plan, sensor: str | None) -> Iterator[str]:
    """Notes on columns that are not read: those that a sensor also has, and all."""
    left = _without_role(plan.layout.names, plan.columns)
    roles = {name: column.role for place, name in left if (column := column_of(name, place, sensor))}
    for role in (f"{sensor[0]}x" for sensor in ARRAYS if f"{sensor[0]}x" in plan.columns):
        if others := [name for name, its in roles.items() if its == role]:
            yield f"{QUANTITY_OF[role[0]]}: {plan.columns[role].name.strip()}, not {', '.join(others)} (choose by columns {role}=NAME)"
    if left:
        yield f"columns not read: {_listed([name for _, name in left], MOST_NAMES)}"


def _without_role(names: Sequence[str], columns: Mapping[str, Column]) -> list[tuple[int, str]]:
    """Place and name of the named columns that are not read."""
    read = {column.place for column in columns.values()}
    return [(place, name.strip()) for place, name in enumerate(names) if place not in read and name.strip()]


def refuse_devices(shown: str, lines: Callable[[], Iterable[str]], plan: Plan) -> None:
    """For the lines of a whole text, as _refuse_devices. Raises RecordingError."""

    def cells(place: int) -> Iterator[str]:
        return (row[place] for _, row in rows_of(lines(), plan.layout) if place < len(row))

    _refuse_devices(at_header(shown, plan.layout), plan.layout.names, plan.columns, cells)


def _refuse_devices(
    at: str, names: Sequence[str], columns: Mapping[str, Column], cells: Callable[[int], Iterable[object]]
) -> None:
    """Raises RecordingError for the rows of several devices in one table, which would be read as samples of one.

    cells: of the column at a place.
    """
    for place, name in _without_role(names, columns):
        if DEVICE.fullmatch(name):
            devices = dict.fromkeys(text for cell in cells(place) if (text := str(cell).strip()) and text.lower() not in MISSING)
            if 1 < len(devices) <= MOST_DEVICES:
                raise SeveralDevices(
                    f"{at}: rows of {len(devices)} devices by the column {name} ({', '.join(devices)}): "
                    "a recording is of one device, keep the rows of one"
                )


def without_zeros(data: bytes) -> bytes:
    """A text without the zeros that a file system leaves behind what was written, as at a loss of power."""
    return data if data[:2] in UTF_16 else data.rstrip(b"\0")


def plan_of(shown: str, head: str, encoding: str, wishes: Wishes, sensor: str | None = None) -> Plan:
    """How to read a text that begins so. Raises RecordingError when no header is found, or one with a fault."""
    layout = layout_of(shown, head, wishes.columns, sensor)
    at = at_header(shown, layout)
    columns = columns_of(layout.names, wishes.columns, at, sensor)
    if not columns:
        names = ("t_s", "lat_deg", "lon_deg", "alt_m", "vn", "ve", "vd") if wishes.only_aids else CSV_COLUMNS
        cure = say_places(layout_of(shown, head, {"t_s": "1"}).names, names)
        raise RecordingError(
            f"{at}: no header; the first line must name the columns {','.join(names)}, or others like them"
            + (f"; of a table of numbers alone {cure}" if cure else "")
        )
    for role, column in columns.items():
        if column.unit is None and column.place < len(layout.units):
            columns[role] = with_unit(column, layout.units[column.place])
    first_time = _first_cell(head, layout, columns["t_s"].place) if "t_s" in columns else ""
    if DAY in columns and not is_day_of(first_time, _first_cell(head, layout, columns[DAY].place)):
        del columns[DAY]
    plan = Plan(encoding, layout, columns, is_instant(first_time))
    # The fast reader ignores cells beyond the header, such as row names without a column name.
    first = next(rows_of(io.StringIO(head, newline=None), layout), (0, []))
    if len(without_empty_end(first[1])) > len(layout.names) and (fault := fault_of(shown, io.StringIO(head, newline=None), plan)):
        raise RecordingError(fault)
    return plan


def table_by(shown: str, frame: pd.DataFrame, plan: Plan) -> Table:
    """The table that rows are, read by its plan. Raises RecordingError for times that are none."""
    values = {
        role: np.array(fixes_of(frame[column.place])) if column.of_fix else frame[column.place].to_numpy()
        for role, column in plan.columns.items()
    }
    for column in plan.times if plan.instants else ():
        cells = with_day(frame[column.place], frame[plan.columns[DAY].place]) if DAY in plan.columns else frame[column.place]
        values[column.role] = seconds_of(at_header(shown, plan.layout), column.name, cells.to_numpy())
    values.pop(DAY, None)
    return Table(plan.columns, _with_fraction(values), plan.layout, plan.instants)


def encoding_of(shown: str, data: bytes) -> str:
    """The encoding of a file. Raises RecordingError."""
    if not data.strip():
        raise RecordingError(f"{shown}: the file is empty")
    encodings = ("utf-16",) if data[:2] in UTF_16 else ENCODINGS
    if b"\0" not in data or len(encodings) == 1:
        for encoding in encodings:
            try:
                data.decode(encoding)
                return encoding
            except UnicodeDecodeError:
                continue
    raise RecordingError(f"{shown}: not a text file")


def _read(shown: str, text: str, stream: io.BytesIO, plan: Plan) -> tuple[pd.DataFrame, tuple[str, ...]]:
    """The used columns, and what was left out."""
    try:
        (frame,) = frames_of(stream, plan)
        remarks: set[int] = set()
    except NOT_DIGESTED:
        remarks = _remarks(shown, text, plan)
        if fault := fault_of(shown, io.StringIO(text, newline=None), plan, remarks):
            raise RecordingError(fault) from None
        frame = _read_slowly(shown, text, plan, remarks)
    else:
        # A short line looks like one with empty cells at its end.
        if len(frame) and frame.iloc[:, -1].isna().any() and (fault := fault_of(shown, io.StringIO(text, newline=None), plan)):
            raise RecordingError(fault)
    if not remarks:
        return frame, ()
    left = "a line without a number was" if len(remarks) == 1 else f"{len(remarks)} lines without a number were"
    return frame, (f"{left} left out, the first of them line {min(remarks)}",)


def _remarks(shown: str, text: str, plan: Plan) -> set[int]:
    """Lines, from 1, without a number where the columns that are read have theirs: remarks of a logger, the header once more. None
    where they are too many for remarks."""
    found, rows = set(), 0
    try:
        for line, row in rows_of(io.StringIO(text, newline=None), plan.layout):
            rows += 1
            cells = [row[place] for place in plan.used if place < len(row) and row[place].strip()]
            if cells and not any(_is_read(cell, plan.layout.decimal) for cell in cells):
                found.add(line)
    except csv.Error:
        raise RecordingError(f"{shown}: not a text file") from None
    few = len(found) <= max(FEWEST_REMARKS, MOST_REMARKS * rows) and rows - len(found) >= FEWEST_ROWS
    return found if few else set()


def _is_read(cell: str, decimal: str) -> bool:
    try:
        number_of(cell, decimal)
    except ValueError:
        return is_instant(cell)
    return True


def frames_of(stream: BinaryIO, plan: Plan, rows: int | None = None) -> Iterator[pd.DataFrame]:
    """The used columns by their places; of a text that the fast reader does not digest, one of NOT_DIGESTED.

    rows: in each frame but the last; None: one frame with all.
    """
    import pandas

    names = [str(place) for place in range(len(plan.layout.names))]
    separator = r"\s+" if plan.layout.delimiter == BLANKS else plan.layout.delimiter
    read = _strictly(
        lambda: pandas.read_csv(
            stream, encoding=plan.encoding, sep=separator, skiprows=plan.layout.first_row, header=None, names=names,
            usecols=[str(place) for place in plan.used], dtype={str(place): plan.kind(place) for place in plan.used},
            na_values=sorted(MISSING),
            skipinitialspace=True, decimal=plan.layout.decimal, index_col=False, chunksize=rows,
        )
    )  # fmt: skip
    if rows is None:
        read.columns = pandas.Index(plan.used)
        yield read
        return
    while True:
        try:
            frame = _strictly(read.get_chunk)
        except StopIteration:
            return
        frame.columns = pandas.Index(plan.used)
        yield frame


def _end_of_whole_lines(shown: str, text: str, plan: Plan) -> int:
    """The end of the last complete line of a file that was truncated within a line, as at a loss of power; 0: not truncated."""
    end = max(text.rfind("\n"), text.rfind("\r")) + 1
    if end in (0, len(text)) or not text[end:].strip("\0 \t"):
        return 0
    layout = plan.layout
    alone = Layout(-1, layout.names, layout.delimiter, layout.decimal)
    return end if fault_of(shown, [text[end:]], replace(plan, layout=alone)) else 0


def _strictly(call: Callable[[], Any]) -> Any:
    """Turns warnings of the fast reader into errors."""
    import pandas

    with warnings.catch_warnings():
        warnings.simplefilter("error", pandas.errors.ParserWarning)
        return call()


def _read_slowly(shown: str, text: str, plan: Plan, remarks: Container[int]) -> pd.DataFrame:
    """Reads lines that end in a delimiter, and other lines of numbers that the fast reader refuses."""
    import pandas

    rows = rows_of(io.StringIO(text, newline=None), plan.layout)
    try:
        cells = [[row[place] if place < len(row) else "" for place in plan.used] for line, row in rows if line not in remarks]
        frame = pandas.DataFrame(cells, columns=plan.used, dtype=object)
        for place in plan.used:
            if plan.kind(place) is float:
                frame[place] = [number_of(cell, plan.layout.decimal) for cell in frame[place]]
        return frame
    except (ValueError, csv.Error):
        raise RecordingError(f"{shown}: cannot be read as a table") from None


def _first_cell(text: str, layout: Layout, place: int) -> str:
    """The first cell of a column that is not empty."""
    rows = rows_of(io.StringIO(text[:HEAD_CHARACTERS], newline=None), layout)
    return next((row[place] for _, row in rows if place < len(row) and row[place].strip()), "")


def fault_of(shown: str, lines: Iterable[str], plan: Plan, remarks: Container[int] = ()) -> str | None:
    """The first fault of a table that the fast reader did not digest, found line by line. remarks: lines that are no rows."""
    layout, used = plan.layout, {column.place: column for column in plan.columns.values()}
    for place in plan.texts:
        used.pop(place, None)
    try:
        for line, row in rows_of(lines, layout):
            if line in remarks:
                continue
            # Behind the last column that is read cells may be missing, as remarks of LabVIEW are.
            if len(without_empty_end(row)) > len(layout.names) or len(row) <= max(used, default=0):
                cure = MARKS if layout.delimiter == "," and len(row) > len(layout.names) else ""
                return f"{shown}, line {line}: {len(row)} cells, the header has {len(layout.names)} columns{cure}"
            for place, column in used.items():
                try:
                    number_of(row[place], layout.decimal)
                except ValueError:
                    # A quoted cell may hold anything: its beginning, on one line.
                    return f"{shown}, line {line}, column {column.name.strip()}: {row[place].strip()[:SHOWN_CHARACTERS]!r} is not a number"
    except csv.Error:
        return f"{shown}: not a text file"
    return None


# --------------------------------------------------------------------------------------------- data frames


def table_of(frame: pd.DataFrame, shown: str, wishes: Wishes) -> Table:
    """The columns of a data frame, or of its index, that hold times and samples. Raises RecordingError."""
    import pandas

    if not isinstance(frame, pandas.DataFrame):
        cure = ": write pandas.DataFrame(array, columns=['t_s', 'gx', ...])"
        raise RecordingError(f"{shown}: a {type(frame).__name__}, and no DataFrame of pandas{cure}")
    frame = _with_index(frame)
    names = ["_".join(map(str, name)).strip("_") if isinstance(name, tuple) else str(name) for name in frame.columns]
    layout = Layout(-1, names, ",", ".")
    columns = columns_of(names, wishes.columns, shown)
    if not columns:
        raise RecordingError(
            f"{shown}: no column of a sensor among {', '.join(names[:12]) or 'none'}; {say_places(names) or 'say which by columns gx=NAME'}"
        )
    if frame.empty:
        raise RecordingError(f"{shown}: no rows")
    _refuse_devices(shown, names, columns, lambda place: frame.iloc[:, place].unique())
    values, instants = _values_of(shown, frame, columns, wishes)
    return Table({role: columns[role] for role in values}, _with_fraction(values), layout, instants)


def _values_of(
    shown: str, frame: pd.DataFrame, columns: Mapping[str, Column], wishes: Wishes
) -> tuple[dict[str, np.ndarray], bool]:
    """The numbers of each role, and whether the times were instants. Raises RecordingError."""
    values, instants = {}, False
    day = frame.iloc[:, columns[DAY].place] if DAY in columns else None
    for role, column in columns.items():
        series = frame.iloc[:, column.place]
        if role == DAY:
            continue
        if (numbers := _numbers(series)) is not None:
            values[role] = numbers
        elif column.of_fix:
            values[role] = np.array(fixes_of(series))
        elif role in ("t_s", *OWN_TIMES.values()):
            cells = series if day is None or not is_day_of(str(series.iloc[0]), str(day.iloc[0])) else with_day(series, day)
            values[role], instants = seconds_of(shown, column.name, cells.to_numpy()), True
        elif wishes.only_aids or not column.aids:
            raise RecordingError(f"{shown}: the column {column.name} holds no numbers")
    return values, instants


def _with_fraction(values: Mapping[str, np.ndarray]) -> Mapping[str, np.ndarray]:
    """Times with the nanoseconds beside their whole seconds; columns that each have the whole time remain as they are."""
    others = {role: column for role, column in values.items() if role != FRACTION}
    if FRACTION not in values or (values["t_s"] % 1).any() or not ((values[FRACTION] >= 0) & (values[FRACTION] < 1e9)).all():
        return others
    return {**others, "t_s": values["t_s"] + 1e-9 * values[FRACTION]}


def _with_index(frame: pd.DataFrame) -> pd.DataFrame:
    """Its index is a column, or several, where it has a name, or holds instants or numbers with decimals."""
    import pandas

    timed = isinstance(frame.index, (pandas.DatetimeIndex, pandas.TimedeltaIndex)) or frame.index.dtype.kind == "f"
    if "t_s" in frame.columns or not (any(frame.index.names) or timed):
        return frame
    return frame.reset_index(names=None if frame.index.nlevels > 1 else str(frame.index.name or "time"))


def _numbers(series: pd.Series[Any]) -> np.ndarray | None:
    """Spans of time in s; None for what is no number, as instants."""
    if series.dtype.kind == "m":
        return np.asarray(series.dt.total_seconds(), float)
    if series.dtype.kind == "M":
        return None
    try:
        return np.asarray(series.to_numpy(dtype=float, na_value=np.nan), float)
    except (TypeError, ValueError):
        pass
    try:
        texts = [str(cell) for cell in series]
        mark = decimal_mark("	", texts)
        return np.array([number_of(text, mark) for text in texts])
    except (TypeError, ValueError):
        return None


def read_parquet(path: Path, wishes: Wishes) -> Raw:
    """One table with all sensors, in Parquet or Feather, by pyarrow. Raises RecordingError."""
    with path.open("rb") as file:
        kind = "feather" if file.read(6) == b"ARROW1" else "parquet"
    reader = library(f"pyarrow.{kind}", "logs", str(path))
    try:
        frame = reader.read_table(path).to_pandas()
    except Exception as error:  # pyarrow raises errors of any type for a damaged file
        raise cannot_be_read(path, error) from None
    return raw_of(str(path), table_of(frame, str(path), wishes), wishes, name="parquet")
