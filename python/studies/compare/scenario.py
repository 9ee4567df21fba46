"""A question that both sides answer: a name, and a function that answers it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from studies.compare.inputs import Samples, trial, tumbling, with_gaps
from studies.compare.side import Side

Arrays = dict[str, NDArray[Any]]
Scenario = Callable[[Side], Arrays]
Source = Callable[[Side], Samples]
Named = tuple[str, Scenario]
Settings = dict[str, Any]  # options or parameters by name


def given(function: Callable[..., Arrays], *arguments: Any, **settings: Any) -> Scenario:
    """The function with all but its first argument, the side."""
    return lambda side: function(side, *arguments, **settings)


def of_trial(number: int, start_s: float = 0.0, stop_s: float = np.inf) -> Source:
    """Rows of a BROAD trial."""
    return lambda side: trial(side.inputs, number).cut(start_s, stop_s)


def made(duration_s: float, gaps: bool = True, field: bool = True) -> Source:
    """Motion that is made here, with gaps in its samples, or without a field."""

    def samples(_: Side) -> Samples:
        whole = tumbling(duration_s)
        if not field:
            whole = replace(whole, field=np.full_like(whole.field, np.nan))
        return with_gaps(whole) if gaps and field else whole

    return samples
