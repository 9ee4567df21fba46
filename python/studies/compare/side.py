"""One of the two revisions that are compared: where its parts are."""

from __future__ import annotations

import importlib
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from types import ModuleType

from studies.compare.names import Names
from studies.compare.native import Library


@dataclass
class Side:
    """A checkout with its build. inputs: the folder of the recordings that both sides read."""

    folder: Path
    inputs: Path
    names: Names = field(default_factory=Names)

    @cached_property
    def library(self) -> Library:
        return Library(self.folder / "build/c_src/libhnav.so", self.folder / "c_src/include", self.names)

    def module(self, name: str) -> ModuleType:
        """A module of this side's Python. Raises ModuleNotFoundError."""
        for candidate in self.names.candidates("module", name):
            try:
                return importlib.import_module(candidate)
            except ModuleNotFoundError as error:
                if not candidate.startswith(str(error.name)):
                    raise
        raise ModuleNotFoundError(f"{self.folder} has no module {name}")

    def fmu(self, name: str, version: int) -> Path:
        """Raises FileNotFoundError."""
        folder = self.folder / f"build/fmus/fmi{version}"
        for candidate in self.names.candidates("fmu", name):
            if (folder / f"{candidate}.fmu").is_file():
                return folder / f"{candidate}.fmu"
        raise FileNotFoundError(f"{folder} holds no {name}.fmu")
