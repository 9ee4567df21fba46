"""A file of records that only grows: whenever the program ends, each record in it is whole or recognisably not.

A line holds the CRC-32 of its JSON in eight hexadecimal digits, a space, and the JSON. The first line states what the
records belong to; records of another kind are never mixed in.
"""

from __future__ import annotations

import json
import os
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

from hnav.errors import HnavValueError
from hnav.io.outputs import BINARY, lock, writing

SHOWN_CHARACTERS = 60  # of a value in a message


class RecordFile:
    """The records of a file, and the file open for more. Use as a context manager.

    path: made with its folder when it is missing. head: what the records are of. Raises HnavError for a file with
    another head, one that another process is adding to, and any other kind of file; OutputError when it cannot be written.
    """

    def __init__(self, path: Path, head: Mapping[str, Any]):
        self.path = path
        self._is_needless = False
        self.records: list[Any] = []
        """As JSON gives them back, in the order in which they came."""
        with writing(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            self._descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND | BINARY, 0o666)
            try:
                self._lock()
                self._size = self._read(_line(head))
                # What a record that is not whole has left.
                os.ftruncate(self._descriptor, self._size)
                if self._size == 0:
                    self._append(_line(head))
            except BaseException:
                os.close(self._descriptor)
                raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        """A file without records is removed."""
        os.close(self._descriptor)  # Windows removes no open file
        if self._is_needless or not self.records:
            with writing(self.path):
                self.path.unlink(missing_ok=True)

    def add(self, record: Any) -> Any:
        """Adds a record, which is on the disk when this returns; answers it as it will be read. Raises OutputError."""
        line = _line(record)
        with writing(self.path):
            self._append(line)
        self.records.append(_record(line))
        return self.records[-1]

    def remove(self) -> None:
        """The file is no longer needed: it is removed at the end of the context."""
        self._is_needless = True

    def _lock(self) -> None:
        try:
            lock(self._descriptor)
        except BlockingIOError:
            raise HnavValueError(
                "option", f"{self.path}: another process is adding to it; let it end, or name another file"
            ) from None
        except OSError:
            pass  # not every file system has locks

    def _read(self, head: bytes) -> int:
        """Takes in the records; returns where the last whole one ends. Raises HnavError for another head."""
        with open(self.path, "rb") as file:
            lines = file.read().splitlines(keepends=True)
        if not lines or (head.startswith(b"".join(lines)) and lines != [head]):
            return 0
        stored = _record(lines[0])
        if not isinstance(stored, dict):
            raise HnavValueError("option", f"{self.path}: is something else; remove it, or name another file")
        if len(lines) == 1 and lines != [head]:  # nothing would be lost
            return 0
        _refuse_another(self.path, stored, _record(head))
        end = len(lines[0])
        for line in lines[1:]:
            record = _record(line)
            if record is None:
                break
            self.records.append(record)
            end += len(line)
        return end

    def _append(self, line: bytes) -> None:
        """All of it or, on a full disk, nothing."""
        try:
            written = 0
            while written < len(line):
                written += os.write(self._descriptor, line[written:])
            os.fsync(self._descriptor)
        except BaseException:
            os.ftruncate(self._descriptor, self._size)
            raise
        self._size += len(line)


def _line(record: Any) -> bytes:
    text = json.dumps(record, separators=(",", ":"), default=lambda number: number.item()).encode()
    return b"%08x %s\n" % (zlib.crc32(text), text)


def _record(line: bytes) -> Any:
    """The record of the line; None when the line is damaged."""
    checksum, _, text = line.rstrip(b"\n").partition(b" ")
    if not line.endswith(b"\n") or checksum != b"%08x" % zlib.crc32(text):
        return None
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return None


def _refuse_another(path: Path, stored: dict[str, Any], head: dict[str, Any]) -> None:
    """Raises HnavError that names what differs."""
    for name in (*head, *stored):
        if name not in stored or name not in head or stored[name] != head[name]:
            was, now = (str(side.get(name, "not given"))[:SHOWN_CHARACTERS] for side in (stored, head))
            raise HnavValueError(
                "option", f"{path} was begun with {name} = {was}, now it is {now}: give the same, name another file, or remove it"
            )
