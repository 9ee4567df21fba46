"""Reads JSON files; an unreadable file gives a one-line error."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from hnav.errors import HnavValueError


def read_json(path: Path, shown: str = "") -> Any:
    """The content of the file. Raises HnavError that names the file, also for JSON nested too deeply for the parser.

    shown: what messages about its content call it; its path otherwise.
    """
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise HnavValueError("file", f"{path}: cannot be read: {error.strerror}") from None
    except (ValueError, RecursionError) as error:
        raise HnavValueError("file", f"{shown or path}: no JSON: {str(error).splitlines()[0]}") from None
