"""Panels of the report about flights with coloured INS errors: the figures of the paper (Figs 1 to 8) and what they do not
show, innovations, noise scales and fault probabilities against the true fault."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go

from hnav.reports.flights import Channel, channels, colour, is_flight
from hnav.reports.panels import band, dots, grid_of, line, panel
from hnav.reports.plots import INK
from hnav.systems.simulation import Run

FAULT_COLOUR = "#F3E9DC"


def _shade(figure: go.Figure, flight: list[Channel]) -> go.Figure:
    """The time of the fault in each row of axes; Plotly shades no axes without lines, so this comes last."""
    for row, channel in enumerate(flight, 1):
        for begin, end in channel.fault_windows():
            figure.add_vrect(begin, end, fillcolor=FAULT_COLOUR, line_width=0, layer="below", row=row, col="all")
    return figure


def _label(channel: Channel, unit: str | None = None) -> str:
    unit = channel.unit if unit is None else unit
    return f"{channel.title}" + (f" / {unit}" if unit else "")


@panel("flight", "Estimates and their errors", "Left the estimates against the truth, right estimate minus truth with ±3 sigma of the last filter. "
       "Shaded: more noise in this channel.", is_flight)  # fmt: skip
def draw_flight(run: Run) -> go.Figure:
    flight = channels(run)
    figure = grid_of(len(flight), 2, ["estimate", "error"])
    for row, channel in enumerate(flight, 1):
        first = row == 1
        for track in channel.tracks:
            figure.add_trace(line(track.t_s, track.estimate, colour(track.filter), track.filter, first), row, 1)
            figure.add_trace(line(track.t_s, track.error, colour(track.filter), track.filter, False), row, 2)
        figure.add_trace(line(channel.t_s, channel.truth, INK, "truth", first, width=1.8), row, 1)
        best = channel.tracks[-1]
        figure.add_trace(
            band(best.t_s, -3 * best.sigma, 3 * best.sigma, colour(best.filter), f"±3 sigma of {best.filter}", first), row, 2
        )
        figure.update_yaxes(title_text=_label(channel), row=row, col=1)
    return _shade(figure, flight)


@panel("flight-innovations", "Innovations", "What each sample brought that was not foreseen. Filters that difference measurements have "
       "innovations of their own kind.", is_flight)  # fmt: skip
def draw_innovations(run: Run) -> go.Figure:
    flight = channels(run)
    labels = [track.filter for track in flight[0].tracks]
    figure = grid_of(len(flight), len(labels), labels)
    for row, channel in enumerate(flight, 1):
        for column, track in enumerate(channel.tracks, 1):
            figure.add_trace(dots(track.t_s, track.innovation, colour(track.filter), track.filter, False), row, column)
        figure.update_yaxes(title_text=_label(channel), row=row, col=1)
    return _shade(figure, flight)


@panel("flight-faults", "Noise scale and fault probability", "What each filter takes for the factor on the variance of the white noise, and how sure it is "
       "that there is a fault. Shaded: the truth.", is_flight)  # fmt: skip
def draw_faults(run: Run) -> go.Figure:
    flight = channels(run)
    figure = grid_of(len(flight), 2, ["noise scale (variance)", "fault probability"])
    for row, channel in enumerate(flight, 1):
        for track in channel.tracks:
            figure.add_trace(
                line(track.t_s, np.maximum(track.noise_scale, 1e-3), colour(track.filter), track.filter, row == 1, shape="hv"),
                row,
                1,
            )
            figure.add_trace(
                line(track.t_s, track.fault_probability, colour(track.filter), track.filter, False, shape="hv"), row, 2
            )
        figure.update_yaxes(title_text=channel.title, type="log", row=row, col=1)
        figure.update_yaxes(range=[-0.04, 1.06], row=row, col=2)
    return _shade(figure, flight)


@panel("flight-table", "Root mean square errors", "Of this one flight, where the channel has no more noise than usual and where it has. One flight says "
       "little about coloured errors, which hardly change in it: ./run study ins_error_table flies a thousand.", is_flight)  # fmt: skip
def draw_table(run: Run) -> go.Figure:
    flight = channels(run)
    labels = [track.filter for track in flight[0].tracks]
    columns = [[channel.title for channel in flight], [channel.unit for channel in flight]]
    for faulty in (False, True):
        for i in range(len(labels)):
            values = (channel.rmse(channel.tracks[i], faulty) for channel in flight)
            columns.append(["–" if np.isnan(value) else f"{value:.3g}" for value in values])
    heads = ["state", "unit", *(f"{label}, healthy" for label in labels), *(f"{label}, fault" for label in labels)]
    figure = go.Figure(
        go.Table(
            header=dict(values=heads, align="left", fill_color="#F0F0F0"), cells=dict(values=columns, align="left", height=30)
        )
    )
    figure.update_layout(height=150 + 34 * len(flight))
    return figure
