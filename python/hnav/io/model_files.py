"""Locations of the model files (aircraft, grades of sensors, systems), and checks of their JSON."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NoReturn

from hnav.errors import HnavValueError
from hnav.io.json_file import read_json
from hnav.places import CHECKOUT, PACKAGE


def model_files(kind: str) -> Path:
    """models/KIND of this package (wheel), else of the checkout."""
    packaged = PACKAGE / "models" / kind
    return packaged if packaged.is_dir() else CHECKOUT / "models" / kind


class ModelFile:
    """The object in a JSON file. Raises HnavError with the file's name and the reason."""

    def __init__(self, path: Path):
        self.path = path
        self.data: Any = read_json(path, path.name)

    def refuse(self, reason: str) -> NoReturn:
        raise HnavValueError("option", f"{self.path.name}: {reason}") from None

    def entry(self, name: str) -> Any:
        value = self.data.get(name) if isinstance(self.data, dict) else None
        if value is None:
            self.refuse(f"{name} is missing")
        return value
