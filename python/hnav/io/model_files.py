"""Where the model files lie (aircraft, grades of sensors, systems), and how their JSON is read."""

from __future__ import annotations

import json
from pathlib import Path

from hnav.errors import HnavValueError
from hnav.places import CHECKOUT, PACKAGE


def model_files(kind: str) -> Path:
    """models/KIND of this package (wheel), else of the checkout."""
    packaged = PACKAGE / "models" / kind
    return packaged if packaged.is_dir() else CHECKOUT / "models" / kind


def read_json(path: Path):
    """What a JSON file holds. Raises HnavError, with the file's name and the reason, when that cannot be told."""
    try:
        return json.loads(path.read_text())
    except OSError as error:
        raise HnavValueError("option", f"{path}: {error.strerror}") from None
    except (ValueError, RecursionError) as error:  # no JSON, no text, or nested without end
        raise HnavValueError("option", f"{path.name}: no JSON: {str(error).splitlines()[0]}") from None
