"""Unpacks archives of systems (.ssp) within limits; files named by a system are searched inside.

An FMU is native code. Running an archive runs its FMUs, but no other file of the machine unless it is allowed.
"""

from __future__ import annotations

import re
import stat
import zipfile
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath, PureWindowsPath

from hnav.errors import HnavError
from hnav.io.archive_room import Room
from hnav.io.outputs import cannot_write
from hnav.systems.structure import refuse

URL = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+:")
CURE = "unpack it and name the folder if you trust it"


def unpack(archive: Path, folder: Path, room: Room) -> None:
    """Unpacks the archive into the folder. Raises HnavError for a file that is no archive, for links, for names that lead
    outside, and for its size.
    """
    try:
        with zipfile.ZipFile(archive) as source:
            entries = source.infolist()
            room.take(entries, str(archive))
            for entry in entries:
                if leads_outside(entry.filename) or stat.S_ISLNK(entry.external_attr >> 16):
                    refuse(f"{archive}: its entry {entry.filename} is a link or lies outside of the archive")
            source.extractall(folder)
    except HnavError:
        raise
    except OSError as error:
        raise cannot_write(f"{folder} (unpacking {archive})", error) from None
    except Exception as error:  # encrypted, unknown compression, damaged: each module behind zipfile raises its own errors
        refuse(f"{archive}: no SSP archive: {(str(error) or type(error).__name__).splitlines()[0]}")


def leads_outside(source: str) -> bool:
    """Whether a path in an archive is absolute or leads upward, by the rules of any operating system."""
    path, windows = PurePosixPath(source), PureWindowsPath(source)
    return path.is_absolute() or bool(windows.drive or windows.root) or ".." in (*path.parts, *windows.parts)


@dataclass(frozen=True)
class SystemFiles:
    """The files of a system: a folder, or an archive with the folder that it was unpacked to."""

    folder: Path
    shown: Path
    archive: bool = False
    allow_outside: bool = False
    room: Room = field(default_factory=lambda: Room(CURE))

    def find(self, source: str, what: str) -> Path:
        """Where a file that the system names would be. Raises HnavError for a path that an archive may not name.

        With allow_outside a source that leads outside is absolute or relative to the folder of the archive.
        """
        if not self.archive:
            return self.folder / source
        if URL.match(source):
            refuse(f"{self.shown}: {what}: {source} is a URL; hnav takes files of the archive only")
        if not leads_outside(source):
            return self.folder / source
        if not self.allow_outside:
            refuse(f"{self.shown}: {what}: {source} lies outside of the archive; --allow-outside takes it, if you trust it")
        return self.shown.resolve().parent / source

    def check_fmu(self, fmu: Path, what: str) -> None:
        """Raises HnavError for an FMU of an archive that exceeds the remaining room."""
        if not self.archive:
            return
        shown = f"{self.shown}: {what}"
        try:
            with zipfile.ZipFile(fmu) as source:
                self.room.take(source.infolist(), shown)
        except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError) as error:
            refuse(f"{shown} is no FMU: {error}")
