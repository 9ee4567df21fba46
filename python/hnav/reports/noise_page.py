"""The page about the noise of a sensor: the Allan deviation of each axis, with its confidence and what was fitted."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from hnav.filters.noise import ENTRIES, SensorNoise
from hnav.reports.colours import BLUE, GREEN, VERMILION
from hnav.reports.page import AXIS, write_page
from hnav.reports.panels import Panel, grid_of, table, translucent

TITLES = {"gyro": "Gyroscope", "accel": "Accelerometer", "mag": "Magnetometer"}
UNITS = {"gyro": ("deg/h", np.pi / 180 / 3600), "accel": ("ug", 9.80665e-6), "mag": ("nT", 1e-9)}
"""Of the deviation."""


def write_noise_report(found: Mapping[str, SensorNoise], name: str, file: Path) -> None:
    """Writes one HTML page that needs no network. Needs Plotly. Raises HnavError if it cannot be written."""
    facts = {TITLES[sensor].lower(): f"{one.length_s:.4g} s at rest, {one.rate_hz:.4g} Hz" for sensor, one in found.items()}
    panels = [FIGURES, *(_panel(sensor) for sensor in found)]
    write_page(file, f"Noise of {name}", facts, [], panels, found)


def _panel(sensor: str) -> Panel:
    note = "Overlapping Allan deviation (dots, with the bounds of 95 % by their degrees of freedom) and what was fitted (lines)."
    return Panel(sensor, TITLES[sensor], note, lambda found: _allan(found[sensor], sensor))


def _allan(noise: SensorNoise, sensor: str) -> Any:
    from scipy.stats import chi2

    from hnav.reports.graphs import go

    figure = grid_of(1, 1, row_px=330)
    unit, si = UNITS[sensor]
    for axis, colour in enumerate((VERMILION, BLUE, GREEN)):
        deviation, degrees = noise.deviation[:, axis] / si, np.maximum(noise.degrees[:, axis], 1)
        ends = [deviation * np.sqrt(degrees / chi2.ppf(p, degrees)) for p in (0.025, 0.975)]
        outline = go.Scatter(x=[*noise.tau_s, *noise.tau_s[::-1]], y=[*ends[0], *ends[1][::-1]], fill="toself", mode="none",
                             fillcolor=translucent(colour, 0.14), showlegend=False, hoverinfo="skip")  # fmt: skip
        figure.add_trace(outline)
        name = "xyz"[axis]
        figure.add_trace(go.Scatter(x=noise.tau_s, y=deviation, mode="markers", name=name, marker=dict(color=colour, size=5)))
        fitted = noise.fitted()[:, axis] / si
        figure.add_trace(go.Scatter(x=noise.tau_s, y=fitted, mode="lines", line=dict(color=colour, width=1.2), showlegend=False))
    decades = dict(type="log", dtick=1, minor=dict(dtick="D1", showgrid=True, gridcolor=AXIS["gridcolor"]))
    figure.update_xaxes(decades, title_text="tau / s")
    figure.update_yaxes(decades, title_text=f"Allan deviation / ({unit})")
    return figure


def _table(found: Mapping[str, SensorNoise]) -> str:
    rows = []
    for sensor, noise in found.items():
        for term, (entry, unit, si) in ENTRIES[sensor].items():
            of = noise.terms[term]
            cells = [
                f"{of.value[i] / si:.3g} ({of.low[i] / si:.3g} to {of.high[i] / si:.3g})"
                if of.is_measured[i]
                else f"< {of.high[i] / si:.3g}"
                for i in range(3)
            ]
            rows.append([TITLES[sensor], entry.replace("_", " "), *cells, unit])
    return table(["sensor", "figure", "x", "y", "z", "unit"], rows)


FIGURES = Panel("figures", "Figures", "In brackets 95 %; < is an upper limit, where the length gives no more.", _table)
