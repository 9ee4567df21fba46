"""The table of old and new names. A name that has not changed yet is known by its old one on both sides."""

from __future__ import annotations

import csv
from collections.abc import Container
from pathlib import Path

# By its place: the old side has a package hnav of its own.
TABLE = Path(__file__).resolve().parents[2] / "hnav" / "renamed.csv"


class Names:
    """hnav/renamed.csv: rows of kind, old name, new name."""

    def __init__(self, path: Path = TABLE):
        with path.open(newline="") as file:
            rows = [(row["kind"], row["old"], row["new"]) for row in csv.DictReader(file)]
        self._new = {(kind, old): new for kind, old, new in rows}
        self._old: dict[tuple[str, str], list[str]] = {}
        for kind, old, new in rows:
            self._old.setdefault((kind, new), []).append(old)

    def canonical(self, kind: str, name: str) -> str:
        """The new name of what has one, by whichever name it is called."""
        return self._new.get((kind, name), name)

    def candidates(self, kind: str, name: str) -> list[str]:
        """The name itself, then the others of the same thing."""
        new = self.canonical(kind, name)
        return list(dict.fromkeys([name, new, *self._old.get((kind, new), [])]))

    def find(self, kind: str, name: str, known: Container[str]) -> str:
        """The name by which this thing is known here. Raises KeyError."""
        for candidate in self.candidates(kind, name):
            if candidate in known:
                return candidate
        raise KeyError(f"there is no {kind} {name}")
