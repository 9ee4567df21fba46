"""How much an archive may unpack to: a small file of zeros could fill a disk."""

from __future__ import annotations

import zipfile
from collections.abc import Sequence
from dataclasses import dataclass, field

from hnav.errors import HnavValueError

MOST_BYTES, MOST_ENTRIES = 1 << 30, 10_000  # an archive and the FMUs in it: everything that one run unpacks


@dataclass
class Room:
    """Bytes and entries that may still be unpacked."""

    cure: str
    """The remedy for an archive that needs more."""
    bytes: int = field(default_factory=lambda: MOST_BYTES)
    entries: int = field(default_factory=lambda: MOST_ENTRIES)

    def take(self, entries: Sequence[zipfile.ZipInfo], shown: str) -> None:
        """Raises HnavError before anything is written. zipfile stops each entry at its declared size."""
        self.bytes -= sum(entry.file_size for entry in entries)
        self.entries -= len(entries)
        if self.bytes < 0:
            raise HnavValueError("option", f"{shown}: unpacks to more than {MOST_BYTES / 1e6:.0f} MB; {self.cure}")
        if self.entries < 0:
            raise HnavValueError("option", f"{shown}: has more than {MOST_ENTRIES} entries; {self.cure}")
