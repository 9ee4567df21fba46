"""The result of a filter over a recording, from any engine."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from hnav.filters.attitude_answers import Run


@dataclass(repr=False)
class Result(Run):
    """The arrays of a Run, by which engine, and at what cost."""

    engine: str = ""
    us_per_sample: float = np.nan
    counts: dict[str, int] = field(default_factory=dict)  # used, gated, late, ... by name
