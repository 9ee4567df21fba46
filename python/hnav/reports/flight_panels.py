"""Panels of the report about flights with coloured INS errors: the figures of the paper (Figs 1 to 8) and what they do not
show, innovations, noise scales and fault probabilities against the true fault."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hnav.reports.colours import INK
from hnav.reports.flights import Channel, channels, colour, is_flight
from hnav.reports.graphs import go
from hnav.reports.panels import band, dots, grid_of, line, panel, table
from hnav.systems.results import Run

FAULT_COLOUR = "#F3E9DC"
PROBABILITY = [-0.04, 1.06]  # axis


def _rows(flight: list[Channel], titles: list[str], draw_row: Callable[[go.Figure, int, Channel], None]) -> go.Figure:
    """Axes for each state in a row of its own; the time of its fault is shaded."""
    figure = grid_of(len(flight), len(titles), titles)
    for row, channel in enumerate(flight, 1):
        draw_row(figure, row, channel)
    # Plotly shades no axes without lines, so this comes last.
    for row, channel in enumerate(flight, 1):
        for begin, end in channel.fault_windows():
            figure.add_vrect(begin, end, fillcolor=FAULT_COLOUR, line_width=0, layer="below", row=row, col="all")
    return figure


def _label(channel: Channel) -> str:
    return f"{channel.title}" + (f" / {channel.unit}" if channel.unit else "")


@panel("flight", "Estimates and their errors", "Left the estimates against the truth, then estimate minus truth with ±3 sigma of the last filter, "
       "right its probability of a noise fault. Shaded: more noise in this channel.", is_flight)  # fmt: skip
def flight_panel(run: Run) -> go.Figure:
    return estimates_of(channels(run))


def estimates_of(flight: list[Channel]) -> go.Figure:
    """A row for each state: truth and estimates, errors with three sigma of the last filter, and its fault probability."""

    def draw_row(figure: go.Figure, row: int, channel: Channel) -> None:
        first = row == 1
        for track in channel.tracks:
            figure.add_trace(line(track.t_s, track.estimate, colour(track.filter), track.filter, first), row, 1)
            figure.add_trace(line(track.t_s, track.error, colour(track.filter), track.filter, False), row, 2)
        figure.add_trace(line(channel.t_s, channel.truth, INK, "truth", first, width=1.8), row, 1)
        best = channel.tracks[-1]
        around = band(best.t_s, -3 * best.sigma, 3 * best.sigma, colour(best.filter), f"±3 sigma of {best.filter}", first)
        figure.add_trace(around, row, 2)
        shade, probability = colour(best.filter), best.fault_probability
        figure.add_trace(line(best.t_s, probability, shade, best.filter, False, shape="hv"), row, 3)
        figure.update_yaxes(range=PROBABILITY, row=row, col=3)
        figure.update_yaxes(title_text=_label(channel), row=row, col=1)

    return _rows(flight, ["estimate", "error", "fault probability"], draw_row)


@panel("flight-innovations", "Innovations", "What each sample brought that was not foreseen. Filters that difference measurements have "
       "innovations of their own kind.", is_flight)  # fmt: skip
def innovations_panel(run: Run) -> go.Figure:
    def draw_row(figure: go.Figure, row: int, channel: Channel) -> None:
        for column, track in enumerate(channel.tracks, 1):
            figure.add_trace(dots(track.t_s, track.innovation, colour(track.filter), track.filter, False), row, column)
        figure.update_yaxes(title_text=_label(channel), row=row, col=1)

    flight = channels(run)
    return _rows(flight, [track.filter for track in flight[0].tracks], draw_row)


@panel("flight-faults", "Noise scale and fault probabilities", "Factor on the variance of the white noise in each filter, and the probabilities "
       "of a noise fault, of a jump of the coloured error, and, dashed and equal for all states, of increased process noise. "
       "Shaded: the truth.", is_flight)  # fmt: skip
def faults_panel(run: Run) -> go.Figure:
    def draw_row(figure: go.Figure, row: int, channel: Channel) -> None:
        for track in channel.tracks:
            name, shade = track.filter, colour(track.filter)
            scale, probability = np.maximum(track.noise_scale, 1e-3), track.fault_probability
            figure.add_trace(line(track.t_s, scale, shade, name, row == 1, shape="hv"), row, 1)
            figure.add_trace(line(track.t_s, probability, shade, name, False, shape="hv"), row, 2)
            figure.add_trace(line(track.t_s, track.bias_fault_probability, shade, name, False, shape="hv"), row, 3)
            livelier = track.process_fault_probability
            figure.add_trace(line(track.t_s, livelier, shade, name, False, shape="hv", dash="dash"), row, 3)
        figure.update_yaxes(title_text=channel.title, type="log", row=row, col=1)
        for column in (2, 3):
            figure.update_yaxes(range=PROBABILITY, row=row, col=column)

    return _rows(channels(run), ["noise scale (variance)", "noise fault", "error jumped, process livelier"], draw_row)


@panel("flight-table", "Root mean square errors", "Of this one flight, where the channel has no more noise than usual and where it has. One flight says "
       "little about coloured errors, which hardly change in it: ./run study ins_error_table flies a thousand.", is_flight)  # fmt: skip
def table_panel(run: Run) -> str:
    flight = channels(run)
    labels = [track.filter for track in flight[0].tracks]

    def cells(channel: Channel, faulty: bool) -> list[str]:
        values = (channel.rmse(track, faulty) for track in channel.tracks)
        return ["–" if np.isnan(value) else f"{value:.3g}" for value in values]

    rows = [[channel.title, channel.unit, *cells(channel, False), *cells(channel, True)] for channel in flight]
    return table(["state", "unit", *(f"{label}, healthy" for label in labels), *(f"{label}, fault" for label in labels)], rows)


FLIGHT_PANELS = (flight_panel, innovations_panel, faults_panel, table_panel)
