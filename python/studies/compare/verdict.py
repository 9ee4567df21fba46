"""Two answers to one question: equal to the last bit, or which columns moved, in how many rows, by how much, and in sigmas."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from studies.compare.worker import FAILURE

Columns = Mapping[str, NDArray[Any]]
PER_DEG = {"lat_deg": 111_195.0, "lon_deg": 111_195.0, "nav.latitude": 6.371e6, "nav.longitude": 6.371e6}
"""Metres of one unit of a place, whose sigma is in metres; of a longitude at the equator."""
# A column, and where its sigma stands.
SIGMAS = [
    (re.compile(column), sigma)
    for column, sigma in {
        r"(.*\.)?att\.euler\[(\d)\]": r"\g<1>att.sigma[\2]", r"(.*\.)?att\.heading": r"\g<1>att.sigma[3]",
        r"(.*\.)?(bias\.\w+)\[(\d)\]": r"\g<1>\2_sigma[\3]", r"(.*\.)?nav\.latitude": r"\g<1>nav.sigma_position[1]",
        r"(.*\.)?nav\.longitude": r"\g<1>nav.sigma_position[2]", r"(.*\.)?nav\.height": r"\g<1>nav.sigma_position[3]",
        r"(.*\.)?nav\.velocity\[(\d)\]": r"\g<1>nav.sigma_velocity[\2]", r"(.*\.)?est(?:imate)?\.(\w+)": r"\g<1>sigma.\2",
        r"(.*\.)?post\.(\w+)": r"\g<1>post_sigma.\2", r"roll_deg": "sigma_x_deg", r"(?:pitch|tilt)_deg": "sigma_y_deg",
        r"(?:yaw|heading)_deg": "sigma_z_deg", r"bias_(\w)_deg_s": r"sigma_bias_\1_deg_s", "lat_deg": "sigma_north",
        "lon_deg": "sigma_east", "alt_m": "sigma_down", r"(v[ned])": r"sigma_\1", "roll": "sigma_about_north",
        "pitch": "sigma_about_east", "heading": "sigma_heading", r"(\w+)": r"sigma.\1",
    }.items()
]  # fmt: skip


@dataclass(frozen=True)
class Moved:
    """A column whose values differ between the revisions."""

    column: str
    rows: int
    of: int
    largest: float
    sigmas: float | None = None
    """The largest difference in units of the sigma that the old revision states in that row; None without one."""

    def __str__(self) -> str:
        within = "" if self.sigmas is None else f" ({self.sigmas:.2g} sigma)"
        return f"{self.column}: {self.rows} of {self.of} rows, at most {self.largest:.3g}{within}"


@dataclass(frozen=True)
class Verdict:
    """The result of one scenario."""

    scenario: str
    verdict: str  # equal, moved or failed
    numbers: int = 0
    moved: list[Moved] = field(default_factory=list)
    only_old: list[str] = field(default_factory=list)
    only_new: list[str] = field(default_factory=list)
    failure: str = ""


def judged(scenario: str, old: Columns, new: Columns) -> Verdict:
    """Columns of one side only are listed and do not count as moved; a failure of either side makes the verdict "failed"."""
    failures = {side: str(answers[FAILURE]) for side, answers in (("old", old), ("new", new)) if FAILURE in answers}
    if failures:
        return _failed(scenario, failures)
    moved = [found for name in old if name in new and (found := _moved(name, old, new))]
    return Verdict(
        scenario, "moved" if moved else "equal", sum(values.size for values in old.values()), moved,
        [name for name in old if name not in new], [name for name in new if name not in old],
    )  # fmt: skip


def _failed(scenario: str, failures: dict[str, str]) -> Verdict:
    """Both sides that refuse with the same words are equal."""
    first, *others = failures.values()
    if others == [first] and first.startswith("refused"):
        return Verdict(scenario, "equal", failure=_end(first))
    return Verdict(scenario, "failed", failure="; ".join(f"{side}: {_end(text)}" for side, text in failures.items()))


def _end(trace: str) -> str:
    """The last lines of a traceback: where and why."""
    return " ".join(line.strip() for line in trace.strip().splitlines()[-4:])


def _moved(name: str, old: Columns, new: Columns) -> Moved | None:
    before, after = old[name], new[name]
    if before.shape != after.shape:
        return Moved(name, max(len(before), len(after)), len(before), np.inf)
    unequal = _unequal(before, after)
    if not unequal.any():
        return None
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        size = np.abs(after.astype(float) - before.astype(float))
        if name.endswith("_deg") or name in ("roll", "heading"):
            size = np.minimum(size, np.abs(360 - size))
        size = np.where(unequal, np.nan_to_num(size, nan=np.inf), 0.0)
        sigma = sigma_of(name, old)
        in_sigmas = size / np.abs(sigma) if sigma is not None and sigma.shape == size.shape else np.array([np.nan])
    most = float(np.nanmax(in_sigmas)) if np.isfinite(in_sigmas).any() else None
    return Moved(name, int(np.count_nonzero(unequal)), unequal.size, float(size.max()), most)


def sigma_of(name: str, columns: Columns) -> NDArray[Any] | None:
    """What is stated of a column, in its unit."""
    for pattern, template in SIGMAS:
        if (found := pattern.fullmatch(name)) and (column := found.expand(template)) in columns:
            per = next((metres for place, metres in PER_DEG.items() if name.endswith(place)), 1.0)
            return np.asarray(columns[column], float) / per
    return None


def _unequal(before: NDArray[Any], after: NDArray[Any]) -> NDArray[Any]:
    """Equal bit for bit; all NaN are equal."""
    if before.dtype.kind != "f" or after.dtype != before.dtype:
        return np.asarray((before != after) & ~((before != before) & (after != after)))
    bits = np.dtype(f"u{before.dtype.itemsize}")
    same = np.ascontiguousarray(before).view(bits) == np.ascontiguousarray(after).view(bits)
    return np.asarray(~(same.reshape(before.shape) | (np.isnan(before) & np.isnan(after))))
