"""Panels of a navigation filter: track, heights, speeds, heading, phases and sigmas."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hnav.earth import axes_at, position_of
from hnav.filters.ins_answers import PHASES, READY, InsRun
from hnav.io.aids import AidSamples
from hnav.native.arrays import Array, BoolArray, stretches
from hnav.reports.colours import AXIS_COLOURS, BLUE, FAINT, GREEN, INK, ORANGE, PURPLE, SKY, VERMILION
from hnav.reports.graphs import go
from hnav.reports.panels import (
    CIRCLE_AXIS,
    Panel,
    band,
    bars,
    blocks,
    circle_line,
    dots,
    extremes,
    grid_of,
    lay_out_bars,
    line,
    seen_from_above,
    small,
    span,
    translucent,
)

OUTAGE_INTERVALS, OUTAGE_S = 3.0, 2.0  # an outage lasts at least this many usual intervals, and this long
CIRCLE_POINTS = 500
BAR_PX = 30
PHASE_COLOURS = dict(zip(PHASES, (FAINT, ORANGE, SKY, GREEN)))
READY_COLOURS = dict(zip(READY, (PURPLE, BLUE, GREEN, SKY)))


@dataclass(frozen=True)
class View:
    """A run with its recording; times count from the first row."""

    run: InsRun
    t_s: Array
    aids: dict[str, AidSamples]
    """Their times likewise."""
    origin: Array
    """3: latitude, longitude, height from which the track counts."""

    @property
    def known(self) -> BoolArray:
        """Rows with a place."""
        return np.asarray(np.isfinite(self.run.place).all(axis=1))

    def track_m(self, places: Array) -> Array:
        """m x 3: north, east and down of places, from the origin."""
        return np.asarray((position_of(places) - position_of(self.origin)) @ axes_at(self.origin))


def outages(t_s: Array, end_s: float) -> list[tuple[float, float]]:
    """Begin and end of the times without a fix, from 0 to the end of the run."""
    steps = np.diff(t_s)
    limit = max(OUTAGE_S, OUTAGE_INTERVALS * float(np.median(steps)) if len(steps) else OUTAGE_S)
    edges = np.concatenate([[0.0], t_s, [end_s]])
    return [(float(edges[i]), float(edges[i + 1])) for i in np.flatnonzero(np.diff(edges) > limit).tolist()]


def within(spans: Sequence[tuple[float, float]], t_s: Array) -> BoolArray:
    """Which times lie inside a span."""
    inside = np.zeros(len(t_s), bool)
    for begin, end in spans:
        inside |= (t_s > begin) & (t_s < end)
    return inside


def _track(seen: View) -> go.Figure:
    run = seen.run
    places = np.where(seen.known[:, None], run.place, np.nan)
    north, east, _ = seen.track_m(places).T
    rows = np.union1d(extremes(north), extremes(east))
    figure = go.Figure()
    if (fixes := seen.aids.get("position")) is not None:
        at = seen.track_m(fixes.values)[blocks(len(fixes.t_s))]
        figure.add_trace(go.Scatter(x=small(at[:, 1]), y=small(at[:, 0]), mode="markers", name="satellites",
                                    marker=dict(color=INK, size=3, opacity=0.5)))  # fmt: skip
    figure.add_trace(go.Scatter(x=small(east[rows]), y=small(north[rows]), mode="lines", name="estimate", line=dict(color=BLUE, width=1.8),
                                customdata=small(seen.t_s[rows]),
                                hovertemplate="%{customdata:.2f} s<br>%{y:.2f} m north<br>%{x:.2f} m east<extra></extra>"))  # fmt: skip
    gaps = [] if fixes is None else outages(fixes.t_s, float(seen.t_s[-1]))
    away = within(gaps, seen.t_s)[rows] & np.isfinite(north[rows])
    if away.any():
        figure.add_trace(go.Scatter(x=small(np.where(away, east[rows], np.nan)), y=small(np.where(away, north[rows], np.nan)), mode="lines",
                                    name="without satellites", line=dict(color=VERMILION, width=3)))  # fmt: skip
    ends = np.flatnonzero(seen.known)[[0, -1]]
    # Ends of the track that are far enough apart have a label each.
    names = ["begin", "end"] if np.hypot(np.ptp(north[ends]), np.ptp(east[ends])) > 30 else ["begin, end", ""]
    figure.add_trace(go.Scatter(x=small(east[ends]), y=small(north[ends]), mode="markers+text", name="begin and end", text=names,
                                textposition="top right", marker=dict(color=ORANGE, size=9, symbol=["circle", "square"])))  # fmt: skip
    seen_from_above(figure)
    return figure


def _heights(seen: View) -> go.Figure:
    run, figure = seen.run, grid_of(2, 1)
    height, sigma = run.place[:, 2], run.sigma_position_m[:, 2]
    speed = np.hypot(*run.velocity_n_m_s[:, :2].T)
    spread = np.hypot(*run.sigma_velocity_m_s[:, :2].T)
    figure.add_trace(band(seen.t_s, height - 3 * sigma, height + 3 * sigma, BLUE, "±3σ", True), 1, 1)
    figure.add_trace(line(seen.t_s, height, BLUE, "estimate", True), 1, 1)
    figure.add_trace(band(seen.t_s, np.maximum(speed - 3 * spread, 0), speed + 3 * spread, BLUE, "±3σ", False), 2, 1)
    figure.add_trace(line(seen.t_s, speed, BLUE, "estimate", False), 2, 1)
    if (fixes := seen.aids.get("position")) is not None:
        figure.add_trace(dots(fixes.t_s, fixes.values[:, 2], INK, "satellites", True), 1, 1)
        figure.update_yaxes(range=span([height[run.ready[:, 3]], fixes.values[:, 2]]), row=1)
    if (fixes := seen.aids.get("velocity")) is not None:
        stated = np.hypot(*fixes.values[:, :2].T)
        figure.add_trace(dots(fixes.t_s, stated, INK, "satellites", False), 2, 1)
        figure.update_yaxes(range=span([speed[run.ready[:, 2]], stated, np.zeros(1)]), row=2)
    figure.update_yaxes(title_text="height / m", row=1)
    figure.update_yaxes(title_text="speed / (m/s)", row=2)
    return figure


def _heading(seen: View) -> go.Figure:
    run = seen.run
    heading, sigma = np.degrees(run.heading_rad) % 360, np.degrees(run.sigma_rotation_rad[:, 2])
    figure = go.Figure()
    x, y = map(small, circle_band(seen.t_s, heading, np.minimum(3 * sigma, 180)))
    filled = dict(fill="toself", fillcolor=translucent(BLUE, 0.18))
    figure.add_trace(go.Scatter(x=x, y=y, mode="none", name="±3σ", hoverinfo="skip", **filled))
    figure.add_trace(circle_line(seen.t_s, heading, BLUE, "heading", True))
    share = run.heading_second[:, 1]
    second = np.flatnonzero(share > 0.01)
    if len(second):
        second = second[blocks(len(second))]
        figure.add_trace(go.Scatter(x=small(seen.t_s[second]), y=small(np.degrees(run.heading_second[second, 0]) % 360), mode="markers", name="second possible heading",
                                    marker=dict(color=VERMILION, size=small(2 + 6 * np.sqrt(share[second])), opacity=0.6)))  # fmt: skip
    if (fixes := seen.aids.get("velocity")) is not None:
        moving = np.hypot(*fixes.values[:, :2].T) > 2.0
        course = np.degrees(np.arctan2(fixes.values[moving, 1], fixes.values[moving, 0])) % 360
        figure.add_trace(dots(fixes.t_s[moving], course, INK, "course by satellites", True))
    figure.update_yaxes(CIRCLE_AXIS, title_text="heading / deg")
    figure.update_xaxes(title_text="time / s")
    figure.update_layout(height=380)
    return figure


def circle_band(t_s: Array, heading_deg: Array, width_deg: Array) -> tuple[Array, Array]:
    """Outlines of heading ± width on the axis 0 to 360, on both sides of north; NaN between them."""
    known = np.flatnonzero(np.isfinite(heading_deg) & np.isfinite(width_deg))
    if len(known) < 2:
        return np.empty(0), np.empty(0)
    rows = known[np.unique(np.append(blocks(len(known), CIRCLE_POINTS), len(known) - 1))]
    parts = np.split(rows, np.flatnonzero(np.abs(np.diff(heading_deg[rows])) > 180) + 1)
    x, y = [np.empty(0)], [np.empty(0)]
    gap = np.array([np.nan])
    for part in parts:
        for turn in (-360.0, 0.0, 360.0):
            low, high = (np.clip(heading_deg[part] + turn + side * width_deg[part], 0, 360) for side in (-1, 1))
            if len(part) > 1 and (high > low).any():
                x += [t_s[part], t_s[part][::-1], gap]
                y += [high, low[::-1], gap]
    return np.concatenate(x), np.concatenate(y)


def _known(seen: View) -> go.Figure:
    """Bars: phases, what is ready, rest, and where satellites are missing."""
    run, figure = seen.run, go.Figure()
    names = ["phase", *(f"{name} ready" for name in READY), "at rest"]
    for number, phase in enumerate(PHASES):
        _bars(figure, "phase", phase.replace("_", " "), PHASE_COLOURS[phase], spans_of(seen.t_s, run.phase == number))
    for i, name in enumerate(READY):
        _bars(figure, f"{name} ready", "ready", READY_COLOURS[name], spans_of(seen.t_s, run.ready[:, i]))
    _bars(figure, "at rest", "at rest", FAINT, spans_of(seen.t_s, run.at_rest))
    for kind in ("position", "velocity"):
        if kind in seen.aids:
            names.append(f"no {kind}")
            _bars(figure, f"no {kind}", "no fix", VERMILION, outages(seen.aids[kind].t_s, float(seen.t_s[-1])))
    lay_out_bars(figure, names, 110 + BAR_PX * len(names))
    figure.update_layout(showlegend=False)
    return figure


def spans_of(t_s: Array, flags: BoolArray) -> list[tuple[float, float]]:
    """Begin and end of the times in which rows are marked; the end is the next row's time."""
    ends = np.append(t_s, t_s[-1:])
    return [(float(t_s[begin]), float(ends[end])) for begin, end in stretches(flags)]


def _bars(figure: go.Figure, row: str, text: str, colour: str, spans: Sequence[tuple[float, float]]) -> None:
    """A row without spans is shown too."""
    begins, ends = np.array(spans or [(0.0, 0.0)]).T
    drawn = bars(row, text, colour, begins, ends, 1)
    drawn.text = text if spans else ""
    figure.add_trace(drawn)


def _sigmas(seen: View) -> go.Figure:
    run, figure = seen.run, grid_of(3, 1)
    rows = (
        ("position / m", run.sigma_position_m, 1.0),
        ("velocity / (m/s)", run.sigma_velocity_m_s, 1.0),
        ("rotation / deg", run.sigma_rotation_rad, 180 / np.pi),
    )
    for row, (title, sigma, factor) in enumerate(rows, 1):
        for axis, (name, colour) in enumerate(zip(("north", "east", "down"), AXIS_COLOURS)):
            figure.add_trace(line(seen.t_s, factor * sigma[:, axis], colour, name, row == 1), row, 1)
        figure.update_yaxes(title_text=title, type="log", dtick=1, row=row)
    return figure


def _biases(seen: View) -> go.Figure:
    run, figure = seen.run, grid_of(2, 1)
    rows = {"gyroscope / (deg/s)": np.degrees(run.gyro_bias_rad_s), "accelerometer / (m/s²)": run.accel_bias_m_s2}
    for row, (title, bias) in enumerate(rows.items(), 1):
        for axis, (name, colour) in enumerate(zip("xyz", AXIS_COLOURS)):
            figure.add_trace(line(seen.t_s, bias[:, axis], colour, name, row == 1), row, 1)
        figure.update_yaxes(title_text=title, row=row)
    return figure


def _is_somewhere(seen: View) -> bool:
    return bool(seen.known.any())


# In the order of the page.
NAVIGATION_PANELS = (
    Panel("track", "Track", "From above, in metres from the first estimate.", _track, _is_somewhere),
    Panel("known", "What is known when", "Phases of the filter, what was ready, when the body stood, and times without satellites.", _known,
           lambda seen: len(seen.t_s) > 0),
    Panel("heading", "Heading", "Of body x, on the circle: the band of ±3σ goes on at 0 deg where it ends at 360. The course is that of the velocity, not of the "
           "body: wind and sideslip lie between.", _heading, _is_somewhere),
    Panel("heights", "Height and speed", "Over ground, with ±3σ; a band that starts wider than the axis is cut off.", _heights, _is_somewhere),
    Panel("sigma", "Standard deviations", "As the filter states them: of position, velocity, and rotation about north, east and down, the last of which is "
           "heading.", _sigmas, _is_somewhere),
    Panel("bias", "Biases", "Of the inertial sensor, body axes, as estimated.", _biases, _is_somewhere),
)  # fmt: skip
