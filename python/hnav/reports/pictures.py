"""The main panels of the report as PNG, for documents that cannot hold a page: attitude, error, bias, flights.

Figures of panels are drawn again by Matplotlib, for Plotly's own export needs a browser: lines, bands and shaded times.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from hnav.reports import plots
from hnav.reports.attitude_panels import attitude_panel, bias_panel, error_panel
from hnav.reports.flight_panels import estimates_of
from hnav.reports.flights import channels
from hnav.reports.graphs import go
from hnav.reports.panels import over_time
from hnav.systems.results import Run

PANELS = (attitude_panel, bias_panel, error_panel)
WIDTH_PX, DPI = 1500, 150
SCREEN_DPI = 100  # of the heights of panels
MARGIN_PX = (75, 15, 45, 60)  # on a screen: left, right, bottom, top
DASHES = {"dash": (0, (4, 2))}
STEPS = {"hv": "steps-post"}


def write_pictures(run: Run, folder: Path) -> list[Path]:
    """DIR/attitude.png, error.png, bias.png, AIRCRAFT.png: those that the run has data for. Raises HnavError when they cannot
    be written."""
    figures = {panel.name: panel.draw(run) for panel in PANELS if panel.applies(run)}
    flights = channels(run)
    for aircraft in dict.fromkeys(channel.aircraft for channel in flights):
        figures[aircraft] = estimates_of([channel for channel in flights if channel.aircraft == aircraft])
    files = []
    for name, figure in sorted(figures.items()):
        files.append(folder / f"{name}.png")
        plots.save(picture_of(figure, run), files[-1])
    return files


def picture_of(figure: Any, run: Run, width_px: int = WIDTH_PX) -> plots.Figure:
    """The figure of a panel, whose traces are lines and bands over time."""
    over_time(figure, run)
    layout, scale = figure.layout, DPI / SCREEN_DPI
    with plots.styled():
        drawn = plots.figure(width_px, round(scale * layout.height), DPI)
        left, right, bottom, top = (scale * px for px in MARGIN_PX)
        across, up = (width_px - left - right) / width_px, 1 - (bottom + top) / (scale * layout.height)
        origin = np.array([left / width_px, bottom / (scale * layout.height)])
        grid: dict[tuple[str, str], plots.Axes] = {}
        for trace in figure.data:
            if (place := (trace.xaxis or "x", trace.yaxis or "y")) not in grid:
                x, y = (layout[f"{name[0]}axis{name[1:]}"] for name in place)
                corner = origin + [across * x.domain[0], up * y.domain[0]]
                grid[place] = drawn.add_axes((*corner, across * np.ptp(x.domain), up * np.ptp(y.domain)))
                _fit(grid[place], x, y)
            _draw(grid[place], trace)
        for shape in layout.shapes:
            grid[shape.xref, shape.yref.split()[0]].axvspan(shape.x0, shape.x1, color=shape.fillcolor, lw=0, zorder=0)
        for title in layout.annotations:
            x, y = origin + [across * title.x, up * title.y]
            drawn.text(x, y, title.text, ha="center", va="bottom", weight="bold")
        handles = [handle for axes in grid.values() for handle in axes.get_legend_handles_labels()[0]]
        drawn.legend(handles=handles, loc="upper right", ncols=6)
    return drawn


def _fit(axes: plots.Axes, x: Any, y: Any) -> None:
    """Ranges, titles and labels as those of Plotly's axes."""
    axes.set_xlim(x.range)
    axes.set_xlabel(x.title.text or "")
    axes.set_ylabel(y.title.text or "")
    if y.range is not None:
        axes.set_ylim(y.range)
    axes.tick_params(labelbottom=x.showticklabels is not False, labelleft=y.showticklabels is not False)


def _draw(axes: plots.Axes, trace: go.Scatter) -> None:
    name = trace.name if trace.showlegend else None
    if trace.fill == "toself":
        red, green, blue, alpha = map(float, re.findall(r"[\d.]+", trace.fillcolor))
        axes.fill(trace.x, trace.y, color=(red / 255, green / 255, blue / 255), alpha=alpha, lw=0, label=name)
    else:
        style: dict[str, Any] = dict(ls=DASHES.get(trace.line.dash, "-"), drawstyle=STEPS.get(trace.line.shape, "default"))
        axes.plot(trace.x, trace.y, color=trace.line.color, lw=trace.line.width, label=name, **style)
