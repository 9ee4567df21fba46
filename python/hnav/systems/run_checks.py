"""Checks the files of a finished simulation before they are used."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from hnav.systems.structure import refuse


def _is_text(value: object) -> bool:
    return isinstance(value, str)


def _is_number(value: object) -> bool:
    # Integers beyond the range of float are refused.
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e300 and math.isfinite(value)


def _is_count(value: object) -> bool:
    return _is_number(value) and isinstance(value, int)


def _is_value(value: object) -> bool:
    return isinstance(value, bool) or _is_text(value) or _is_number(value)


def _all(is_right: Callable[[object], bool]) -> Callable[[object], bool]:
    return lambda value: isinstance(value, Mapping) and all(is_right(part) for part in value.values())


def _or_none(is_right: Callable[[object], bool]) -> Callable[[object], bool]:
    return lambda value: value is None or is_right(value)


# Entry of run.json -> its description and its check.
ENTRIES: dict[str, tuple[str, Callable[[object], bool]]] = {
    **dict.fromkeys(("system", "description", "failure"), ("a text", _is_text)),
    **dict.fromkeys(("scenario", "grade"), ("a text or null", _or_none(_is_text))),
    "seed": ("a whole number or null", _or_none(_is_count)),
    **dict.fromkeys(("start_s", "stop_s", "step_s"), ("a number", _is_number)),
    "parameters": ("an object of values", _all(_is_value)),
    "components": ("an object of objects", _all(_all(_is_text))),
    "wall_s": ("an object of numbers", _all(_is_number)),
    "lost": ("an object of whole numbers", _all(_is_count)),
    "versions": ("an object of texts", _all(_is_text)),
}


def check_about(about: Any, file: Path) -> None:
    """run.json. Raises HnavError that names the missing or invalid entry."""
    if not isinstance(about, dict):
        refuse(f"{file}: cannot be read: no object; hnav simulate writes it")
    for name, (kind, is_right) in ENTRIES.items():
        if name not in about or not is_right(about[name]):
            refuse(f"{file}: cannot be read: {name} is not {kind}; hnav simulate writes it")
    if "hnav" not in about["versions"]:
        refuse(f"{file}: cannot be read: versions names no hnav; hnav simulate writes it")


def check_certificate(found: Any, file: Path) -> None:
    """certificate.json: a verdict and its reason; the figures are not checked. Raises HnavError."""
    if not isinstance(found, dict) or not isinstance(found.get("certified"), bool) or not isinstance(found.get("reason"), str):
        refuse(f"{file}: cannot be read: certified and reason are not there; hnav certify writes it")


def check_signals(t_s: Any, columns: Mapping[str, Any], file: Path) -> None:
    """Increasing times, and numbers for each. Raises HnavError that names the dataset."""
    for name, values in {"t_s": t_s, **columns}.items():
        if not isinstance(values, np.ndarray) or values.dtype.kind not in "fiub" or values.ndim != 1:
            refuse(f"{file}: cannot be read: {name} is no column of numbers; hnav simulate writes it")
        if len(values) != len(t_s) or len(t_s) == 0:
            refuse(f"{file}: cannot be read: {name} has {len(values)} values for {len(t_s)} times; hnav simulate writes it")
    if not np.isfinite(t_s).all() or (np.diff(t_s) <= 0).any():
        refuse(f"{file}: cannot be read: the times in t_s do not increase; hnav simulate writes it")
