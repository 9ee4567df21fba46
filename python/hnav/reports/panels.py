"""What panels of the report are made of, drawn by Plotly: lines, dots, bands and axes that share time.

Colours as in hnav.reports.plots: truth in ink, the filters in colours that people with any kind of colour vision can tell
apart, named in every legend as well.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from hnav.reports.plots import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION
from hnav.systems.run_views import estimates
from hnav.systems.simulation import Run

FILTER_COLOURS = (VERMILION, BLUE, GREEN, PURPLE, ORANGE, SKY)
# A browser stays quick with this many points a line; the files hold all.
POINTS = 1500
ROW_PX = 190


@dataclass(frozen=True)
class Panel:
    """title, note (how to read it) and lines (what the run says) stand above the figure that draw makes of a run for which
    applies is true."""

    name: str
    title: str
    note: str
    applies: Callable[[Run], bool]
    draw: Callable[[Run], go.Figure]
    lines: Callable[[Run], Sequence[str]]


def no_lines(run: Run) -> Sequence[str]:
    """Of a panel whose figure says all."""
    return ()


def panel(
    name: str, title: str, note: str, applies: Callable[[Run], bool], lines: Callable[[Run], Sequence[str]] = no_lines
) -> Callable[[Callable[[Run], go.Figure]], Panel]:
    """Decorator: the panel whose figure the function below draws."""
    return lambda draw: Panel(name, title, note, applies, draw, lines)


def colour_of(run: Run, name: str) -> str:
    return FILTER_COLOURS[[e.name for e in estimates(run)].index(name) % len(FILTER_COLOURS)]


def thinned(n: int) -> slice:
    """Every k-th of n rows, so that no line has more than POINTS."""
    return slice(None, None, max(1, -(-n // POINTS)))


def translucent(colour: str, alpha: float) -> str:
    return f"rgba({int(colour[1:3], 16)},{int(colour[3:5], 16)},{int(colour[5:7], 16)},{alpha})"


def grid_of(rows: int, columns: int, titles: list[str] | None = None, row_px: int = ROW_PX, **options: Any) -> go.Figure:
    """Empty axes that share time, with the titles above the columns."""
    titles = None if titles is None else titles + [""] * (rows * columns - len(titles))
    spacing = dict(vertical_spacing=0.12 / rows, horizontal_spacing=0.06)
    figure = make_subplots(rows, columns, shared_xaxes=True, subplot_titles=titles, **spacing, **options)
    figure.update_layout(height=120 + row_px * rows)
    figure.update_xaxes(title_text="time / s", row=rows)
    return figure


def band(t_s: np.ndarray, low: np.ndarray, high: np.ndarray, colour: str, name: str, shown: bool) -> go.Scatter:
    """A filled area between two lines, as one closed outline; rows that are not finite are left out."""
    known = np.isfinite(low) & np.isfinite(high)
    outline = np.concatenate([high[known], low[known][::-1]])
    return go.Scatter(x=np.concatenate([t_s[known], t_s[known][::-1]]), y=outline, fill="toself", mode="none", name=name, legendgroup=name,
                      fillcolor=translucent(colour, 0.18), showlegend=shown, hoverinfo="skip")  # fmt: skip


def line(t_s: np.ndarray, values: np.ndarray, colour: str, name: str, shown: bool, **style: Any) -> go.Scatter:
    rows = thinned(len(t_s))
    return go.Scatter(x=t_s[rows], y=values[rows], mode="lines", name=name, legendgroup=name, showlegend=shown,
                      line=dict(color=colour, width=1.4) | style)  # fmt: skip


def dots(t_s: np.ndarray, values: np.ndarray, colour: str, name: str, shown: bool) -> go.Scatter:
    rows = thinned(len(t_s))
    return go.Scatter(x=t_s[rows], y=values[rows], mode="markers", name=name, legendgroup=name, showlegend=shown,
                      marker=dict(color=colour, size=2.6, opacity=0.55))  # fmt: skip
