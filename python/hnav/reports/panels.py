"""Elements of the panels, drawn by Plotly: lines, dots, bands and axes that share time.

Colours as in hnav.reports.colours: truth in ink, the filters in colours that people with any kind of colour vision can distinguish
apart, named in every legend as well.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np

from hnav.reports.colours import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION
from hnav.reports.graphs import go, make_subplots
from hnav.systems.results import Run
from hnav.systems.run_views import estimates

FILTER_COLOURS = (VERMILION, BLUE, GREEN, PURPLE, ORANGE, SKY)
# A browser stays quick with twice this many points a line, and no screen shows more; the files hold all.
POINTS = 600
BAND_POINTS, DOT_EXTREMES = 400, 80
ROW_PX = 190
CIRCLE_AXIS = dict(range=[0, 360], dtick=90)


@dataclass(frozen=True)
class Panel:
    """A panel: title, note (how to read it) and lines (results of the run) above the output of draw, a figure or HTML. It is
    shown for what applies is true of: a run, or what else the page is about."""

    name: str
    title: str
    note: str
    draw: Callable[[Any], go.Figure | str]
    applies: Callable[[Any], bool] = lambda _: True
    lines: Callable[[Any], Sequence[str]] = lambda _: ()


def panel(name: str, title: str, note: str, *more: Callable[[Any], Any]) -> Callable[[Callable[[Any], go.Figure | str]], Panel]:
    """Decorator: the panel that shows what the function below draws. more: applies and lines."""
    return lambda draw: Panel(name, title, note, draw, *more)


def colour_of(run: Run, name: str) -> str:
    return FILTER_COLOURS[[e.name for e in estimates(run)].index(name) % len(FILTER_COLOURS)]


def blocks(n: int, points: int = POINTS) -> np.ndarray:
    """First rows of at most `points` blocks side by side that hold all n rows."""
    return np.arange(0, n, max(1, -(-n // points)))


def extremes(values: np.ndarray, points: int = POINTS) -> np.ndarray:
    """Rows that stand for n values: of each block its smallest and its largest, so that no peak is lost, and both ends.

    A block without a finite value gives one row, where a line breaks.
    """
    n = len(values)
    starts = blocks(n, points)
    if len(starts) == n:
        return np.arange(n)
    width = starts[1]
    padded = np.full(len(starts) * width, np.nan)
    padded[:n] = values
    table = padded.reshape(len(starts), width)
    known = np.isfinite(table)
    low, high = (np.argmin(np.where(known, sign * table, np.inf), axis=1) for sign in (1, -1))
    return np.unique([*(starts + low), *(starts + high), 0, n - 1])


def small(values: np.ndarray) -> np.ndarray:
    """Numbers rounded to seven digits, more than a screen can show."""
    return values.astype(np.float32)


def span(values: Sequence[np.ndarray]) -> list[float] | None:
    """The range of an axis that shows all these values; None when there is none."""
    known = np.concatenate(values)
    known = known[np.isfinite(known)]
    if not len(known):
        return None
    low, high = float(known.min()), float(known.max())
    room = 0.06 * (high - low) or max(1e-6, 0.01 * abs(high))
    return [low - room, high + room]


def translucent(colour: str, alpha: float) -> str:
    return f"rgba({int(colour[1:3], 16)},{int(colour[3:5], 16)},{int(colour[5:7], 16)},{alpha})"


def grid_of(rows: int, columns: int, titles: list[str] | None = None, row_px: int = ROW_PX, **options: Any) -> go.Figure:
    """Empty axes that share time, with the titles above the columns."""
    titles = None if titles is None else titles + [""] * (rows * columns - len(titles))
    spacing = dict(vertical_spacing=0.12 / rows, horizontal_spacing=0.06 if columns < 4 else 0.04)
    figure = make_subplots(rows, columns, shared_xaxes=True, subplot_titles=titles, **spacing, **options)
    figure.update_layout(height=120 + row_px * rows)
    figure.update_xaxes(title_text="time / s", row=rows)
    return figure


def over_time(figure: go.Figure, run: Any) -> None:
    """The axes of time begin and end with the run; markers would make them begin before. cursor.js links those named in meta."""
    axes = list(figure.select_xaxes(lambda a: (a.title.text or "").startswith("time") or a.matches))
    for axis in axes:
        axis.range = [run.t_s[0], run.t_s[-1]]
    if axes:
        figure.update_layout(meta={"time": [axis.plotly_name for axis in axes]})


def band(t_s: np.ndarray, low: np.ndarray, high: np.ndarray, colour: str, name: str, shown: bool) -> go.Scatter:
    """A filled area between two lines, as one closed outline; rows that are not finite are left out.

    Of many rows the widest of each block is drawn.
    """
    known = np.isfinite(low) & np.isfinite(high)
    t_s, low, high = t_s[known], low[known], high[known]
    if len(t_s) > BAND_POINTS:
        starts = blocks(len(t_s), BAND_POINTS)
        ends = t_s[-1:]
        t_s = np.concatenate([t_s[starts], ends])
        low, high = (np.append(of.reduceat(edge, starts), edge[-1]) for of, edge in ((np.minimum, low), (np.maximum, high)))
    outline = small(np.concatenate([high, low[::-1]]))
    return go.Scatter(x=small(np.concatenate([t_s, t_s[::-1]])), y=outline, fill="toself", mode="none", name=name, legendgroup=name,
                      fillcolor=translucent(colour, 0.18), showlegend=shown, hoverinfo="skip")  # fmt: skip


def line(t_s: np.ndarray, values: np.ndarray, colour: str, name: str, shown: bool, **style: Any) -> go.Scatter:
    rows = extremes(values)
    return go.Scatter(x=small(t_s[rows]), y=small(values[rows]), mode="lines", name=name, legendgroup=name, showlegend=shown,
                      line=dict(color=colour, width=1.4) | style)  # fmt: skip


def circle_line(t_s: np.ndarray, angle_deg: np.ndarray, colour: str, name: str, shown: bool) -> go.Scatter:
    """A line of angles from 0 to 360 deg, interrupted where it passes 0 so that it does not cross the whole axis."""
    rows = np.union1d(*(extremes(of(np.radians(angle_deg))) for of in (np.sin, np.cos)))
    t_s, angle_deg = t_s[rows], angle_deg[rows] % 360
    jumps = np.flatnonzero(np.abs(np.diff(angle_deg)) > 180) + 1
    return go.Scatter(x=small(np.insert(t_s, jumps, np.nan)), y=small(np.insert(angle_deg, jumps, np.nan)), mode="lines", name=name,
                      legendgroup=name, showlegend=shown, line=dict(color=colour, width=1.4))  # fmt: skip


def dots(t_s: np.ndarray, values: np.ndarray, colour: str, name: str, shown: bool) -> go.Scatter:
    """Of many samples every k-th, so that the dots lie as densely as the samples do, and the largest ones."""
    n = len(values)
    rows = np.arange(n) if n <= POINTS else np.union1d(blocks(n), extremes(values, DOT_EXTREMES))
    return go.Scatter(x=small(t_s[rows]), y=small(values[rows]), mode="markers", name=name, legendgroup=name, showlegend=shown,
                      marker=dict(color=colour, size=2.6, opacity=0.55))  # fmt: skip


def bars(row: str, text: str, colour: str, begins: np.ndarray, ends: np.ndarray, decimals: int, **style: Any) -> go.Bar:
    """Bars over time on a row of its own, each with its text; the pointer shows begin and end with so many decimals."""
    shown = f"{text}, %{{base:.{decimals}f}} to %{{customdata:.{decimals}f}} s<extra>{row}</extra>"
    return go.Bar(base=begins, x=ends - begins, y=[row] * len(begins), orientation="h", marker=dict(color=colour, line=dict(width=0)),
                  text=text, textposition="inside", insidetextanchor="start", textangle=0, customdata=ends, hovertemplate=shown,
                  **style)  # fmt: skip


def lay_out_bars(figure: go.Figure, rows: Sequence[str], height: float) -> None:
    """The axes of bars: these rows from top to bottom."""
    figure.update_yaxes(categoryorder="array", categoryarray=rows[::-1], showgrid=False)
    figure.update_xaxes(title_text="time / s")
    figure.update_layout(barmode="overlay", bargap=0.25, height=height, uniformtext=dict(minsize=10, mode="hide"))


def seen_from_above(figure: go.Figure, right: str = "east / m", up: str = "north / m") -> None:
    """Makes a figure of places in m a map: equal scales, a scale bar, and a dot on each trace whose customdata are times (cursor.js)."""
    figure.update_xaxes(title_text=right, constrain="domain")
    figure.update_yaxes(title_text=up, scaleanchor="x", scaleratio=1)
    figure.update_layout(height=560, meta={"map": True})


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table of texts as HTML, the first column to the left."""
    head = "".join(f"<th>{escape(name)}</th>" for name in heads)
    body = "".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows)
    return f'<div class="scroll"><table class="words"><tr>{head}</tr>{body}</table></div>'
