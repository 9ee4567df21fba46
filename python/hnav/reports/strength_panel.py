"""The panel of the report about the measured field in navigation axes: a clean field keeps strength and dip."""

from __future__ import annotations

import numpy as np

from hnav.reports.colours import BLUE, INK
from hnav.reports.graphs import go
from hnav.reports.panels import grid_of, line, panel
from hnav.reports.recording_view import FIELD_N, SENSOR
from hnav.systems.results import Run

MICROTESLA = 1e6


def _strength_and_dip(run: Run) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, strength in microtesla and dip in deg of the samples with an attitude."""
    field = run.vector(SENSOR, FIELD_N, 3)
    known = np.isfinite(field).all(axis=1)
    north, east, down = field[known].T
    horizontal = np.hypot(north, east)
    return run.t_s[known], MICROTESLA * np.hypot(horizontal, down), np.degrees(np.arctan2(down, horizontal))


def applies(run: Run) -> bool:
    """Whether there are fields with an attitude."""
    return run.has(SENSOR, f"{FIELD_N}[1]") and bool(np.isfinite(run.vector(SENSOR, FIELD_N, 3)).all(axis=1).any())


def lines(run: Run) -> list[str]:
    """The spread of strength and dip."""
    _, strength, dip = _strength_and_dip(run)
    return [
        f"strength: median {np.median(strength):.2f} µT, {_spread(strength, 'µT')}",
        f"dip: median {np.median(dip):.2f} deg, {_spread(dip, 'deg')}",
    ]


def _spread(values: np.ndarray, unit: str) -> str:
    low, high = np.quantile(values, [0.05, 0.95])
    return f"9 of 10 samples from {low:.2f} to {high:.2f} {unit}"


@panel("strength", "Field strength and dip", "Of each sample of the magnetometer, turned by the estimated attitude. In a clean field both are flat, "
       "whatever the body does; steps are iron nearby, a wave with the motion is iron on the body: hnav calibrate.", applies, lines)  # fmt: skip
def strength_panel(run: Run) -> go.Figure:
    t_s, strength, dip = _strength_and_dip(run)
    figure = grid_of(2, 1)
    for row, (values, name) in enumerate(((strength, "strength / µT"), (dip, "dip / deg")), start=1):
        figure.add_trace(line(t_s, values, BLUE, "measured", row == 1), row, 1)
        ends = np.full(2, np.median(values))
        figure.add_trace(line(run.t_s[[0, -1]], ends, INK, "median", row == 1, dash="dash", width=1), row, 1)
        figure.update_yaxes(title_text=name, row=row)
    return figure
