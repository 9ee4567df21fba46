"""The panel of the page about a run that shows which errors its samples determine, and from when on."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hnav.errors import HnavValueError
from hnav.filters.observability import SEEN, RunObservability
from hnav.reports.colours import AXIS_COLOURS, INK
from hnav.reports.graphs import go
from hnav.reports.panels import Panel, grid_of, line

DASHES = ("solid", "dash", "dot")  # angles, gyro bias, accelerometer bias: three each
FLOOR = 1e-4


def observability_panel(find: Callable[[], RunObservability]) -> list[Panel]:
    """The panel; none where the run has no attitude, or not its samples."""
    try:
        found = find()
    except HnavValueError:
        return []
    note = (
        "Standard deviation of each error that the samples leave, over that without samples, by the linear errors of the filter: 100 % is "
        f"not observable, below {100 * np.sqrt(SEEN):.0f} % it is determined. Noise as in the options."
    )
    return [
        Panel("observability", "What the samples determine", note, lambda _: _drawn(found), lines=lambda _: found.sentences())
    ]


def _drawn(found: RunObservability) -> go.Figure:
    figure = grid_of(1, 1, row_px=300)
    for i, (name, remaining) in enumerate(found.remaining.items()):
        shown = 100 * np.maximum(remaining, FLOOR)
        style = dict(dash=DASHES[i // 3 % len(DASHES)])
        figure.add_trace(line(found.t_s, shown, AXIS_COLOURS[i % 3], name, True, **style), 1, 1)
    ends = found.t_s[[0, -1]]
    figure.add_trace(line(ends, np.full(2, 100 * np.sqrt(SEEN)), INK, "determined below", True, dash="dash", width=1), 1, 1)
    figure.update_yaxes(title_text="sigma left / %", type="log", dtick=1)
    return figure
