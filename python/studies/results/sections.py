"""The measurements of docs/results, which sections.toml lists: their commands, and what they say."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import NamedTuple

TRIALS, FLIGHT = "DIR", "FLIGHT"
FOLDERS = {TRIALS: "BROAD_DIR", FLIGHT: "HNAV_FLIGHT"}
"""Words of a command that stand for a folder, and the variable of the environment that names it."""


class Section(NamedTuple):
    """A measurement. command: as it is typed behind ./run; quick: within two minutes on two cores."""

    title: str
    says: str
    command: str
    quick: bool

    @property
    def needs(self) -> list[str]:
        """Variables of the environment."""
        return [FOLDERS[word] for word in self.command.split() if word in FOLDERS]


_LISTED = tomllib.loads(Path(__file__).with_name("sections.toml").read_text(encoding="utf-8"))
SECTIONS = {name: Section(**fields) for name, fields in _LISTED.items()}
