"""Where the model files lie: aircraft, grades of sensors, systems."""

from __future__ import annotations

from pathlib import Path


def model_files(kind: str) -> Path:
    """models/KIND of this package (wheel), else of the checkout."""
    here = Path(__file__).resolve().parent
    packaged = here / "models" / kind
    return packaged if packaged.is_dir() else here.parents[1] / "models" / kind
