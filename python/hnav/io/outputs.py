"""Writes every output of every command atomically: a file is the old one or the new one, never a part.

    write_files({folder / "signals.h5": image, folder / "run.json": text}, make_folders=True)

Content is written under a temporary name beside its target (.NAME.xxxxxxxx.part) until it is whole and on the disk.
"""

from __future__ import annotations

import errno
import os
import secrets
import stat
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from hnav.errors import HnavRuntimeError, HnavValueError

BINARY = getattr(os, "O_BINARY", 0)
"""Of os.open: on Windows it would otherwise write line ends of its own."""
PART = ".part"
STEM_CHARACTERS = 40  # characters of the target's name in the temporary name, whose length is limited


class OutputError(HnavRuntimeError):
    """A file cannot be written: the disk is full, or rights are missing. The content is not at fault."""

    def __init__(self, text: str):
        super().__init__("file", text)

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (str(self),)


def cannot_write(path: Path | str, error: OSError) -> OutputError:
    """The one-line error for a file that cannot be written."""
    reason = error.strerror or str(error) or type(error).__name__
    return OutputError(f"cannot write {path}: {reason[:1].lower()}{reason[1:]}")


@contextmanager
def writing(path: Path | str) -> Iterator[None]:
    """Converts errors of the disk into OutputError with the name of the file."""
    try:
        yield
    except OSError as error:
        raise cannot_write(path, error) from None


def write_files(
    contents: Mapping[Path, bytes | str | Iterable[bytes]], make_folders: bool = False, gone: Iterable[Path] = ()
) -> None:
    """Writes whole files; text as UTF-8; pieces as they come. Raises OutputError, and whatever the making of a piece does; then,
    and after an interrupt, the old files are what they were.

    Of several files the last is the mark that all are whole: every one is complete beside its target before the old mark
    goes, and the new mark comes last. A process that is killed in between leaves the new files without a mark.

    gone: files that describe the old ones; they are removed once every new one is complete.
    """
    with ExitStack() as unfinished:
        parts: dict[Path, Path | None] = {}
        for path, content in contents.items():
            with writing(path):
                if make_folders:
                    path.parent.mkdir(parents=True, exist_ok=True)
                content = content.encode() if isinstance(content, str) else content
                pieces = [content] if isinstance(content, bytes) else content
                parts[path] = unfinished.enter_context(_written_beside(_target(path), pieces))
        *_, mark = contents
        if len(parts) > 1:
            with writing(mark):
                _target(mark).unlink(missing_ok=True)
                _settle(_target(mark).parent)
        for path in gone:
            with writing(path):
                path.unlink(missing_ok=True)
        for path, part in parts.items():
            if part is not None:
                with writing(path):
                    os.replace(part, _target(path))
                    _settle(part.parent)


def temporary_folder(prefix: str) -> Path:
    """A new folder to unpack into; the caller removes it. Raises OutputError."""
    with writing("a temporary folder"):
        return Path(tempfile.mkdtemp(prefix=prefix))


def refuse_overwriting(outputs: Iterable[Path | None], inputs: Iterable[Path | None]) -> None:
    """Raises HnavError for an output that is an input, by whatever name or link, and for two outputs that are one file."""
    read, seen = {_identity(path) for path in inputs if path is not None} - {None}, dict[object, Path]()
    for output in (path for path in outputs if path is not None):
        if (identity := _identity(output)) is None:
            continue
        if identity in read:
            raise HnavValueError("option", f"{output} is read by this command, which would overwrite it: name another file")
        if other := seen.get(identity):
            raise HnavValueError("option", f"{other} and {output} are one file: name two")
        seen[identity] = output


def _identity(path: Path) -> object:
    """An identity of a regular file, equal under all of its names; None for a pipe or a folder."""
    try:
        found = path.stat()
    except OSError:
        return _target(path)
    return (found.st_dev, found.st_ino) if stat.S_ISREG(found.st_mode) else None


def _target(path: Path) -> Path:
    """The target of a link, so that the link remains. A pipe in /dev/fd has no other name."""
    return path if path.exists() and not path.is_file() else Path(os.path.realpath(path))


@contextmanager
def _written_beside(target: Path, pieces: Iterable[bytes]) -> Iterator[Path | None]:
    """The path of a complete file that may take the target's place, and is gone at the end if it did not. None: what is no
    file, such as a pipe, has no place to take and was written to."""
    if target.exists() and not target.is_file():
        with target.open("wb") as file:
            file.writelines(pieces)
        yield None
        return
    if target.exists() and not os.access(target, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    stem = f".{target.name[:STEM_CHARACTERS]}."
    _remove_left_over(target.parent, stem)
    part = target.with_name(f"{stem}{secrets.token_hex(4)}{PART}")
    descriptor = os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL | BINARY, 0o666)
    try:
        with os.fdopen(descriptor, "wb") as file:
            # The lock is held until this process ends: a file with a free lock is abandoned and may be removed.
            with suppress(OSError):
                lock(descriptor)
            if target.exists():
                part.chmod(target.stat().st_mode & 0o7777)
            file.writelines(pieces)
            file.flush()
            os.fsync(descriptor)
            if sys.platform == "win32":
                file.close()  # an open file cannot be renamed
            yield part
    finally:
        part.unlink(missing_ok=True)


def lock(descriptor: int) -> None:
    """Locks an open file until it is closed or the process ends. Raises BlockingIOError when another process holds the lock,
    another OSError where the file system has no locks.

    Windows has no such locks, but a file that a process has open cannot be removed there.
    """
    if sys.platform != "win32":
        import fcntl

        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)


def _remove_left_over(folder: Path, stem: str) -> None:
    """Temporary files that killed processes have left of earlier attempts."""
    for part in folder.iterdir():
        if part.name.startswith(stem) and part.name.endswith(PART):
            with suppress(OSError):
                with part.open("rb") as file:
                    lock(file.fileno())
                part.unlink()


def _settle(folder: Path) -> None:
    """Writes the folder to the disk: after a loss of power names could otherwise return in another order."""
    if sys.platform == "win32":
        return  # a folder cannot be opened
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        # Not every file system can synchronise a folder.
        if error.errno not in (errno.EINVAL, errno.ENOTSUP):
            raise
    finally:
        os.close(descriptor)
