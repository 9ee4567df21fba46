"""Recordings of several named tables, each with its own times: messages of a log, variables of a file, records by sensor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from hnav.io.aids import AidSamples
from hnav.io.readers.aids import LEFT_OUT, aids_and_notes
from hnav.io.readers.columns import QUANTITY_OF, column_of
from hnav.io.readers.stated_units import with_units
from hnav.io.readers.streams import Raw, Stream, Wishes
from hnav.io.readers.tables import SeveralDevices, Table, raw_of, say_places, stream_of, table_of, times_of
from hnav.io.recordings import ARRAYS, CSV_COLUMNS, RecordingError, Unit

if TYPE_CHECKING:
    import pandas as pd

SHOWN = 20


def raw_of_frames(
    shown: str,
    frames: Mapping[str, pd.DataFrame],
    wishes: Wishes,
    format: str,
    by_format: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
) -> Raw:
    """Like raw_of_tables, for data frames. units: stated outside the tables, by quantity. Raises RecordingError."""
    frames = {name: frame for name, frame in frames.items() if len(frame)}
    tables = {name: table for name, frame in frames.items() if (table := _table(shown, name, frame, wishes, units or {}))}
    return raw_of_tables(shown, tables, {name: list(frame.columns) for name, frame in frames.items()}, wishes, format, by_format)


def raw_of_tables(
    shown: str,
    tables: Mapping[str, Table],
    there: Mapping[str, Sequence[object]],
    wishes: Wishes,
    format: str,
    by_format: Mapping[str, str] | None = None,
) -> Raw:
    """One table with all sensors, else the best table of each sensor, by its columns or its name. there: the names of the
    columns of every table, also of those without a sensor. Raises RecordingError."""
    by_format = by_format or {}
    both = {"gx", "ax"}
    whole = max(tables.values(), key=lambda table: (both <= table.columns.keys(), len(table.columns)), default=None)
    if whole is not None and (len(there) == 1 or both <= whole.columns.keys()) and not wishes.only_aids:
        raw = raw_of(shown, whole, wishes, by_format, format)
        return raw if len(tables) == 1 else _with_more(raw, shown, tables, wishes, by_format)
    raw = _with_more(Raw(format, [], Unit("s", "by format")), shown, tables, wishes, by_format)
    if not wishes.only_aids:
        _refuse_missing(shown, there, {stream.sensor for stream in raw.streams})
    return raw


def _refuse_missing(shown: str, tables: Mapping[str, Sequence[object]], found: set[str]) -> None:
    """Raises RecordingError, with the existing tables and columns, if the gyroscope or the accelerometer is missing."""
    if missing := [sensor for sensor in ("gyro", "accel") if sensor not in found]:
        there = ", ".join(f"{name} ({', '.join(map(str, names[:8]))})" for name, names in list(tables.items())[:SHOWN])
        cure = say_places(next(iter(tables.values()))) if len(tables) == 1 and len(missing) == 2 else ""
        raise RecordingError(
            f"{shown}: no samples of the {' and the '.join(missing)}; it holds {there or 'no table'}: {cure or CURE}"
        )


CURE = "save one table with the columns t_s, gx, gy, gz, ax, ay, az, mx, my, mz, and a line of these names"


def _table(shown: str, name: str, frame: pd.DataFrame, wishes: Wishes, units: Mapping[str, str]) -> Table | None:
    """The table, if it has a recognised column; its axes may be called x, y and z if its name is that of a sensor."""
    if sensor_named(name) is not None:
        # accelerometer: x, y, z and accel_x, accel_y, accel_z are both usual.
        plain = {column: f"{name}_{column}" for column in frame.columns if str(column).lower() in ("x", "y", "z")}
        frame = frame.rename(columns=plain)
    frame = with_units(shown, frame, units)
    try:
        return table_of(frame, shown, wishes)
    except SeveralDevices:
        raise
    except RecordingError:
        if wishes.columns and not wishes.only_aids:
            raise
        return None


def sensor_named(name: str) -> str | None:
    """The sensor that a table of this name holds."""
    column = column_of(f"{name}_x", 0)
    return QUANTITY_OF[column.role[0]] if column is not None and column.role in CSV_COLUMNS[1:] else None


def _with_more(raw: Raw, shown: str, tables: Mapping[str, Table], wishes: Wishes, by_format: Mapping[str, str]) -> Raw:
    """Adds the missing sensors and aids, each from the table whose name or columns fit best, of such with most of its samples."""
    streams, notes, unit = list(raw.streams), list(raw.notes), raw.time_unit
    for sensor in ARRAYS:
        having = {name: table for name, table in tables.items() if sensor[0] + "x" in table.columns}
        if not having or sensor in {stream.sensor for stream in streams}:
            continue
        role = f"{sensor[0]}x"
        name = min(having, key=lambda name: (having[name].columns[role].rank, -np.isfinite(having[name].values[role]).sum()))
        stream, unit, more = sensor_stream(shown, having[name], sensor, wishes, by_format)
        streams.append(stream)
        others = ", ".join(other for other in having if other != name)
        notes += [*more, *([f"{sensor}: {name}, not {others}"] if others else [])]
    return _with_aids(replace(raw, streams=streams, notes=tuple(notes), time_unit=unit), shown, tables, wishes, by_format)


def _with_aids(raw: Raw, shown: str, tables: Mapping[str, Table], wishes: Wishes, by_format: Mapping[str, str]) -> Raw:
    """Adds the missing kinds of aids, of the first table that has samples, and notes on what was left out of kinds that none has."""
    aids, notes = {kind: one for kind, one in raw.aids.items() if len(one.t_s)}, list(raw.notes)
    for table in tables.values():
        found, more = _aids(shown, table, wishes, by_format)
        aids = {kind: one for kind, one in found.items() if len(one.t_s)} | aids
        notes += more
    there = tuple(LEFT_OUT[kind] for kind in LEFT_OUT.keys() & aids.keys())
    return replace(raw, aids=aids, notes=tuple(dict.fromkeys(note for note in notes if not note.startswith(there))))


def sensor_stream(
    shown: str, table: Table, sensor: str, wishes: Wishes, by_format: Mapping[str, str]
) -> tuple[Stream, Unit, tuple[str, ...]]:
    """The samples of a sensor without empty rows, the unit of their times, and notes on those. Raises RecordingError."""
    table = table.of_sensor(sensor)
    t_s, unit, mended = times_of(shown, table, wishes, by_format)
    stream = stream_of(shown, table, sensor, t_s, wishes, by_format.get(sensor))
    present = ~np.isnan(stream.values).any(axis=1)
    return replace(stream, t_s=t_s[present], values=stream.values[present]), unit, mended


def _aids(shown: str, table: Table, wishes: Wishes, by_format: Mapping[str, str]) -> tuple[dict[str, AidSamples], list[str]]:
    """Samples of what aids, and notes on what was left out; satellites without a time do not invalidate the rest."""
    if not any(column.aids for column in table.columns.values()):
        return {}, []
    try:
        t_s, _, mended = times_of(shown, table, replace(wishes, only_aids=True), by_format)
        aids, notes = aids_and_notes(table.columns, table.values, t_s)
        return aids, [*mended, *notes]
    except RecordingError as error:
        return {}, [f"left out: {error}"]


def numbers(column: Any) -> Any:
    """A column of texts converted to numbers if all are numbers; another unchanged."""
    import pandas

    if pandas.api.types.is_numeric_dtype(column):
        return column
    converted = pandas.to_numeric(column, errors="coerce")
    return converted if converted.notna().sum() == column.notna().sum() else column
