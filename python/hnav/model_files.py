"""Where the model files lie (aircraft, grades of sensors, systems), and how their JSON is read."""

from __future__ import annotations

import json
from pathlib import Path

from hnav.library import HnavError


def model_files(kind: str) -> Path:
    """models/KIND of this package (wheel), else of the checkout."""
    here = Path(__file__).resolve().parent
    packaged = here / "models" / kind
    return packaged if packaged.is_dir() else here.parents[1] / "models" / kind


def read_json(path: Path):
    """What a JSON file holds. Raises HnavError, with the file's name and the reason, when that cannot be told."""
    try:
        return json.loads(path.read_text())
    except OSError as error:
        raise HnavError(2, f"{path}: {error.strerror}") from None
    except (ValueError, RecursionError) as error:  # no JSON, no text, or nested without end
        raise HnavError(2, f"{path.name}: no JSON: {str(error).splitlines()[0]}") from None
