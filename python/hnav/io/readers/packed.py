"""Files that are packed (.gz, .bz2, .xz), folders of which one file is a recording, and what a file that is none is."""

from __future__ import annotations

import bz2
import gzip
import lzma
import tempfile
import zlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from hnav.io.readers.streams import Raw
from hnav.io.recordings import RecordingError

UNPACKERS: dict[bytes, Callable[..., Any]] = {b"\x1f\x8b": gzip.open, b"BZh": bz2.open, b"\xfd7zXZ\0": lzma.open}
LARGEST_BYTES = 1 << 32
BLOCK_BYTES = 1 << 20
MOST_FILES = 50
KNOWN = (
    (b"\xd0\xcf\x11\xe0", "a workbook of Excel (.xls): save it as CSV; "), (b"%PDF", "a PDF: "), (b"\x89PNG", "a picture: "),
    (b"\xff\xd8\xff", "a picture: "), (b"\xfd\x09", "telemetry of MAVLink: give the log of the vehicle itself (.bin); "),
)  # fmt: skip


def unpacker_of(path: Path, head: bytes) -> Callable[..., Any] | None:
    """What opens a packed file."""
    return next((opened for magic, opened in UNPACKERS.items() if head.startswith(magic)), None)


def unpacked(path: Path, opened: Callable[..., Any], read: Callable[[Path], Raw]) -> Raw:
    """What is in a packed file; of one that was cut off, what can be unpacked. Raises RecordingError."""
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


def read_only_one(folder: Path, files: list[Path], read: Callable[[Path], Raw]) -> Raw:
    """The one of the files that is a recording. Raises RecordingError where none is, or several are."""
    found: dict[str, Raw] = {}
    for file in files:
        try:
            found[file.name] = read(file)
        except RecordingError:
            continue
    if len(found) > 1:
        raise RecordingError(f"{folder}: {', '.join(found)} are recordings: give one of them")
    if not found:
        raise RecordingError(
            f"{folder}: none of {', '.join(file.name for file in files[:8])} is a recording: give the file itself"
        )
    name, raw = next(iter(found.items()))
    return replace(raw, notes=(*raw.notes, f"read {name}"))


def what_it_is(path: Path, head: bytes) -> str:
    """Of files that people give, and that are no recording."""
    return next((text for magic, text in KNOWN if head.startswith(magic)), "")
