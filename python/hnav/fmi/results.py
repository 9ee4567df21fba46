"""What a filter made of a recording, whoever ran it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from hnav.filters.attitude_answers import Run

Progress = Callable[[int, int], None]  # rows done, rows in all


@dataclass(repr=False)
class Result(Run):
    """The arrays of a Run, by which engine, and at what cost."""

    engine: str = ""
    us_per_sample: float = np.nan
    counts: dict[str, int] = field(default_factory=dict)  # used, gated, late, ... by name
