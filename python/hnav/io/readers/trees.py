"""Values in values, as in JSON, MATLAB structs and NumPy archives, read as named tables.

Records ([{"t": 0, "gx": 1}, ...], also a line each), columns ({"t": [...], "gx": [...]}), tables split into names and rows, and records
of several sensors, of which each says its sensor (Sensor Logger: "sensor"; its push: "name", "values") or stands under its name, with
several samples for each time (Movesense: "ArrayAcc"). Everything in time that grows with the file.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from hnav.io.readers.columns import column_of
from hnav.io.readers.frames import numbers

if TYPE_CHECKING:
    import pandas as pd

DEEPEST = 8
KINDS = ("sensor", "name", "type", "topic", "sensorName", "sensor_name")
"""Keys that name the sensor of a record."""
AXES = "xyz"
MOST_COLUMNS = 32  # of a matrix of sensors
MOST_TABLES = 200


def frames_of_tree(tree: Any) -> dict[str, pd.DataFrame]:
    """The tables of a tree, by the names that lead to them."""
    import pandas

    found: dict[str, pd.DataFrame] = {}
    for name, columns in _tables(tree, "", 0):
        if len(found) < MOST_TABLES and columns:
            key = name or "table"
            while key in found:
                key += "'"
            found[key] = pandas.DataFrame({column: numbers(pandas.Series(values)) for column, values in columns.items()})
    return found


def _tables(tree: Any, name: str, depth: int) -> Iterator[tuple[str, dict[str, Any]]]:
    if depth > DEEPEST:
        return
    if isinstance(tree, Mapping):
        yield from _of_mapping(_of_pandas(tree), name, depth)
    elif isinstance(tree, (list, np.ndarray)) and len(tree) and isinstance(tree[0], Mapping):
        yield from _of_records([row for row in tree if isinstance(row, Mapping)], name, depth)


def _of_pandas(tree: Mapping[str, Any]) -> Mapping[str, Any]:
    """{"gx": {"0": 1.0, "1": 2.0}, ...}, as to_json of pandas writes a table, or rows by their numbers: as columns."""
    values = list(tree.values())
    if len(values) < 2 or not all(isinstance(value, Mapping) and value.keys() == values[0].keys() for value in values):
        return tree
    if all(map(_is_index, values[0])):
        return {column: list(rows.values()) for column, rows in tree.items()}
    if all(map(_is_index, tree)):
        return {column: [row[column] for row in values] for column in values[0]}
    return tree


def _is_index(key: object) -> bool:
    return str(key).isdigit()


def _of_mapping(tree: Mapping[str, Any], name: str, depth: int) -> Iterator[tuple[str, dict[str, Any]]]:
    """Its columns as one table for each length, and what is deeper."""
    if isinstance(tree.get("columns"), list) and isinstance(tree.get("data"), list):  # as pandas splits a table
        rows = [row for row in tree["data"] if isinstance(row, list) and len(row) == len(tree["columns"])]
        yield name, {str(column): [row[i] for row in rows] for i, column in enumerate(tree["columns"])}
        return
    by_length: dict[int, dict[str, Any]] = {}
    for key, value in _leaves(tree, ""):
        for column, values in _columns_of(key, value):
            by_length.setdefault(len(values), {})[column] = values
    yield from ((name, columns) for length, columns in by_length.items() if length > 1)
    for key, value in _deeper(tree, name, 0):
        yield from _tables(value, key, depth + 1)


def _leaves(tree: Mapping[str, Any], before: str, depth: int = 0) -> Iterator[tuple[str, Any]]:
    """Lists and arrays of numbers or texts, by the names that lead to them."""
    for key, value in tree.items():
        name = f"{before}_{key}" if before else str(key)
        if isinstance(value, Mapping) and depth < DEEPEST:
            yield from _leaves(value, name, depth + 1)
        elif isinstance(value, (list, np.ndarray)) and len(value) and not isinstance(value[0], Mapping):
            yield name, value


def _deeper(tree: Mapping[str, Any], before: str, depth: int) -> Iterator[tuple[str, Any]]:
    """Lists of records, by the names that lead to them."""
    for key, value in tree.items():
        if isinstance(value, Mapping) and depth < DEEPEST:
            yield from _deeper(value, str(key), depth + 1)
        elif isinstance(value, (list, np.ndarray)) and len(value) and isinstance(value[0], Mapping):
            yield (before if str(key) in ("data", "samples", "payload", "values", "records") else str(key)), value


def _columns_of(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    """A vector is a column; n x 3 or 3 x n of a sensor are three; other matrices have their columns numbered."""
    try:
        matrix = np.asarray(value)
    except ValueError:  # rows of several lengths
        return
    if matrix.ndim == 2 and min(matrix.shape) == 1:
        matrix = matrix.ravel()
    if matrix.ndim == 1 and _holds_cells(matrix):
        yield name, matrix
    elif matrix.ndim == 2 and matrix.dtype.kind in "fiu":
        yield from _columns_of_matrix(name, matrix)


def _holds_cells(vector: np.ndarray) -> bool:
    """Numbers or texts; for mixed values the first few decide."""
    return vector.dtype.kind in "fiubU" or (
        vector.dtype == object and not any(isinstance(v, (list, dict, np.ndarray)) for v in vector[:3])
    )


def _columns_of_matrix(name: str, matrix: np.ndarray) -> Iterator[tuple[str, Any]]:
    if matrix.shape[0] < matrix.shape[1] and matrix.shape[0] <= MOST_COLUMNS:
        matrix = matrix.T
    count = matrix.shape[1]
    named = count == 3 and column_of(f"{name}_x", 0) is not None
    if count <= MOST_COLUMNS:
        yield from ((f"{name}_{AXES[i] if named else i + 1}", matrix[:, i]) for i in range(count))


def _of_records(records: Sequence[Mapping[str, Any]], name: str, depth: int) -> Iterator[tuple[str, dict[str, Any]]]:
    kind = next((key for key in KINDS if isinstance(records[0].get(key), str)), None)
    groups: dict[str, list[dict[str, Any]]] = {}
    for record in records:
        for group, row in _rows(record, name, depth):
            said = str(record.get(kind)) if kind else ""
            groups.setdefault(said or group, []).append(row)
    for group, rows in groups.items():
        columns = dict.fromkeys(column for row in rows for column in row if column != kind)
        if len(columns) <= 2000:
            yield group, {column: [row.get(column) for row in rows] for column in columns}


def _rows(record: Mapping[str, Any], name: str, depth: int) -> Iterator[tuple[str, dict[str, Any]]]:
    """A record as one row; or, where it holds lists of vectors, as a row for each, at equal steps to the next record's time."""
    flat: dict[str, Any] = {}
    batches: dict[str, Sequence[Any]] = {}
    for key, value in flattened(record, "", depth):
        if isinstance(value, list):
            batches[key] = value
        else:
            flat[key] = value
    if not batches:
        yield name, flat
        return
    last = {key.rsplit("_", 1)[-1]: value for key, value in flat.items()}
    time = {f"{BATCH}{key}": value for key, value in last.items() if (column := column_of(key, 0)) and column.role == "t_s"}
    for key, batch in batches.items():
        sensor = key.rsplit("_", 1)[-1].removeprefix("Array")
        for place, vector in enumerate(batch):
            row = dict(flattened(vector, "", depth + 1)) if isinstance(vector, Mapping) else dict(zip(AXES, vector))
            yield sensor, {**time, PLACE: place, LENGTH: len(batch), **row}


BATCH, PLACE, LENGTH = "batch_", "place in batch", "batch length"


def flattened(record: Mapping[str, Any], before: str = "", depth: int = 0) -> Iterator[tuple[str, Any]]:
    """Names and values of a record in records; three numbers are its axes."""
    for key, value in record.items():
        name = "_".join(filter(None, [before, "" if str(key) == "values" else str(key)]))
        if isinstance(value, Mapping) and depth < DEEPEST:
            yield from flattened(value, "" if str(key) in ("values", "data", "payload") else name, depth + 1)
        elif isinstance(value, list) and len(value) == 3 and not isinstance(value[0], (list, Mapping)):
            yield from (("_".join(filter(None, [name, axis])), one) for axis, one in zip(AXES, value))
        elif isinstance(value, list):
            if value and isinstance(value[0], (list, Mapping)):
                yield name, value
        else:
            yield name, value


def unbatched(frame: pd.DataFrame) -> pd.DataFrame:
    """Samples that share a record's time, the newest at that time, at equal steps since the record before."""
    if PLACE not in frame:
        return frame
    time = next((str(column) for column in frame if str(column).startswith(BATCH)), None)
    if time is None:
        return frame.drop(columns=[PLACE, LENGTH])
    stamps = frame[time].to_numpy(float)
    begins = np.flatnonzero(frame[PLACE].to_numpy() == 0)
    steps = np.diff(stamps[begins])
    usual = float(np.median(steps)) if len(steps) else 0.0
    length = frame[LENGTH].to_numpy()
    late = (frame[PLACE].to_numpy() / np.maximum(length, 1)) * usual
    return frame.drop(columns=[time, PLACE, LENGTH]).assign(**{time.removeprefix(BATCH): stamps + late})
