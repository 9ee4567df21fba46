"""Packed files (.gz, .bz2, .xz, .zip), folders of tables, and the recognition of files that are not recordings."""

from __future__ import annotations

import bz2
import contextlib
import functools
import gzip
import lzma
import re
import tempfile
import zipfile
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from hnav.io.readers.columns import column_of
from hnav.io.readers.frames import raw_of_tables, sensor_named
from hnav.io.readers.streams import Raw, Wishes
from hnav.io.readers.tables import Table, parse
from hnav.io.recordings import CSV_COLUMNS, RecordingError

UNPACKERS: dict[bytes, Callable[..., Any]] = {b"\x1f\x8b": gzip.open, b"BZh": bz2.open, b"\xfd7zXZ\0": lzma.open}
LARGEST_BYTES = 1 << 32
ZIP_MAGIC = b"PK\x03\x04"
NO_ZIP = (zipfile.BadZipFile, EOFError, NotImplementedError, RuntimeError, OSError, zlib.error)
BLOCK_BYTES = 1 << 20
MOST_FILES = 500
AXES = CSV_COLUMNS[1:]
KNOWN = (
    (ZIP_MAGIC, "a zip; "),
    (b"\xd0\xcf\x11\xe0", "a workbook of Excel (.xls): save it as CSV; "), (b"%PDF", "a PDF: "), (b"\x89PNG", "a picture: "),
    (b"\xff\xd8\xff", "a picture: "), (b"\x80\x04", "a pickle, which may run any code: save .csv, .npz or .parquet; "),
    (b"\x80\x05", "a pickle, which may run any code: save .csv, .npz or .parquet; "), (b"File created on ", "a file of VBOX: export CSV from VBOX Test Suite; "),
    # A heartbeat in versions 2 and 1; of .tlog behind a time in us.
    (rb"([\0-\x0f].{7})?(\xfd.\0.|\xfe\x09)", "telemetry of MAVLink, in which most samples are missing: give the log of the vehicle itself (.ulg, .bin); "),
)  # fmt: skip
"""Patterns of first bytes."""


def unpacker_of(path: Path, head: bytes) -> Callable[..., Any] | None:
    """The function that opens a packed file."""
    return next((opened for magic, opened in UNPACKERS.items() if head.startswith(magic)), None)


def unpacked(path: Path, opened: Callable[..., Any], read: Callable[[Path], Raw]) -> Raw:
    """The content of a packed file; of a truncated file, the part that can be unpacked. Raises RecordingError."""
    with tempfile.TemporaryDirectory(prefix="hnav_") as folder:
        inner = Path(folder) / (path.stem or "recording")
        note = _unpack(path, opened, inner)
        try:
            raw = read(inner)
        except RecordingError as error:
            raise RecordingError(str(error).replace(str(inner), str(path)), error.argument) from None
    return replace(raw, notes=(*raw.notes, *note))


def _unpack(path: Path, opened: Callable[..., Any], inner: Path) -> tuple[str, ...]:
    size = 0
    try:
        with opened(path, "rb") as source, inner.open("wb") as target:
            while block := source.read(BLOCK_BYTES):
                size += len(block)
                if size > LARGEST_BYTES:
                    raise RecordingError(f"{path}: holds more than {LARGEST_BYTES >> 30} GB: unpack it, and give the file")
                target.write(block)
    except (EOFError, OSError, zlib.error, lzma.LZMAError) as error:
        if not size:
            raise RecordingError(f"{path}: cannot be unpacked: {' '.join(str(error).split()) or type(error).__name__}") from None
        return ("the packed file was cut off or is damaged: what stands before is read",)
    return ()


def tables_in(folder: Path) -> list[Path]:
    """Files of a folder that may be a recording."""
    return sorted(file for file in folder.iterdir() if file.is_file() and not file.name.startswith("."))[:MOST_FILES]


def unzipped(path: Path, read: Callable[[Path], Raw]) -> Raw:
    """What is in a zip, as in a folder; a single file as that file. Raises RecordingError."""
    with tempfile.TemporaryDirectory(prefix="hnav_") as name:
        folder = Path(name)
        for member, content in members_of(path):
            (folder / Path(member).name).write_bytes(content)
        files = tables_in(folder)
        try:
            return read(files[0] if len(files) == 1 else folder)
        except RecordingError as error:
            raise RecordingError(str(error).replace(str(folder), str(path)), error.argument) from None


def members_of(path: Path, ending: str = "") -> Iterator[tuple[str, bytes]]:
    """Names and contents of the files in a zip whose names end so. Raises RecordingError."""
    try:
        with zipfile.ZipFile(path) as archive:
            members = [member for member in archive.infolist() if not member.is_dir() and "__MACOSX" not in member.filename]
            if any(member.filename.startswith("xl/") for member in members):
                raise RecordingError(f"{path}: a workbook of Excel (.xlsx): save it as CSV")
            members = [member for member in members if member.filename.lower().endswith(ending)]
            if sum(member.file_size for member in members) > LARGEST_BYTES:
                raise RecordingError(f"{path}: holds more than {LARGEST_BYTES >> 30} GB: unpack it, and give the folder")
            yield from ((member.filename, archive.read(member)) for member in members)
    except NO_ZIP as error:
        raise RecordingError(f"{path}: the zip cannot be read: {' '.join(str(error).split()) or type(error).__name__}") from None


def read_folder(folder: Path, files: list[Path], read: Callable[[Path], Raw], wishes: Wishes) -> Raw:
    """The one of the files that is a recording, with the sensors of its other tables; else each sensor of the table that has it. Raises
    RecordingError where several are recordings, or none has the sensors."""
    found: dict[str, Raw] = {}
    tables: dict[str, Table] = {}
    for file in files:
        with contextlib.suppress(RecordingError):
            tables[file.stem] = _table_of(file, wishes)
        with contextlib.suppress(RecordingError):
            found[file.name] = read(file)
    if len(found) > 1:
        raise RecordingError(f"{folder}: {', '.join(found)} are recordings: give one of them")
    if not tables and not found:
        raise RecordingError(
            f"{folder}: none of {', '.join(file.name for file in files[:8])} is a recording: give the file itself"
        )
    only = next(iter(found), "")
    if only and (len(tables) == 1 or Path(only).stem not in tables):
        return replace(found[only], notes=(*found[only].notes, f"read {only}"))
    there = {name: [column.strip() for column in table.layout.names] for name, table in tables.items()}
    raw = raw_of_tables(str(folder), side_by_side(tables), there, wishes, "folder")
    return replace(raw, notes=(*raw.notes, f"read {', '.join(name for name, one in tables.items() if len(one.columns) > 1)}"))


def _table_of(file: Path, wishes: Wishes) -> Table:
    """Of a sensor, where the name of the file is one, or of an axis of it, as gyro_x.csv. Raises RecordingError."""
    data, axis = file.read_bytes(), column_of(file.stem, 0)
    table = parse(str(file), data, wishes, sensor_named(file.stem))
    if axis is None or axis.role not in AXES or table.columns.keys() != {"t_s"}:
        return table
    names = [name for place, name in enumerate(table.layout.names) if place != table.columns["t_s"].place and name.strip()]
    return parse(str(file), data, replace(wishes, columns={**wishes.columns, axis.role: names[0]})) if len(names) == 1 else table


def side_by_side(tables: Mapping[str, Table]) -> dict[str, Table]:
    """With tables of one axis put together to that of their sensor, at the times that all three have."""
    axes = {role: name for name, table in tables.items() for role in table.columns if len(table.columns) == 2 and role in AXES}
    joined = dict(tables)
    for roles in (AXES[:3], AXES[3:6], AXES[6:]):
        if not axes.keys() >= {*roles}:
            continue
        parts = [tables[axes[role]] for role in roles]
        times = functools.reduce(np.intersect1d, (part.values["t_s"] for part in parts))
        columns, values = {"t_s": parts[0].columns["t_s"]}, {"t_s": times}
        for role, part in zip(roles, parts):
            columns[role] = part.columns[role]
            order = np.argsort(part.values["t_s"], kind="stable")
            values[role] = part.values[role][order[np.searchsorted(part.values["t_s"], times, sorter=order)]]
            del joined[axes[role]]
        joined[axes[roles[0]]] = replace(parts[0], columns=columns, values=values)
    return joined


def what_it_is(head: bytes) -> str:
    """Of files that people give, and that are no recording."""
    return next((text for begin, text in KNOWN if re.match(begin, head, re.DOTALL)), "")
