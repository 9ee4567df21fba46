"""The main panels of the report as PNG, for documents that cannot hold a page: attitude, error, bias, flights.

Drawn by Matplotlib in the look of hnav.reports.plots, for Plotly's own export needs a browser.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from hnav.reports import plots
from hnav.reports.angles import euler_deg, near_turn
from hnav.reports.flights import channels, draw_flight
from hnav.systems.results import Run
from hnav.systems.run_views import Estimate, estimates, truth_q_nb

COLOURS = (plots.VERMILION, plots.BLUE, plots.GREEN, plots.PURPLE, plots.ORANGE, plots.SKY)
WIDTH_PX, ROW_PX, DPI = 1500, 300, 150


def write_pictures(run: Run, folder: Path) -> list[Path]:
    """DIR/attitude.png, error.png, bias.png, AIRCRAFT.png: those that the run has data for. Raises HnavError when they cannot
    be written."""
    pictures: dict[str, plots.Figure] = {}
    if estimates(run):
        pictures |= {"attitude": figure_of(run, draw_attitude), "bias": figure_of(run, draw_bias)}
        if truth_q_nb(run) is not None:
            pictures["error"] = figure_of(run, draw_error)
    flights = channels(run)
    for aircraft in dict.fromkeys(channel.aircraft for channel in flights):
        pictures[aircraft] = draw_flight([channel for channel in flights if channel.aircraft == aircraft])
    files = []
    for name, picture in sorted(pictures.items()):
        files.append(folder / f"{name}.png")
        plots.save(picture, files[-1])
    return files


def figure_of(run: Run, draw: Callable[[plots.Figure, Run], None], width_px: int = WIDTH_PX) -> plots.Figure:
    """A figure that draw fills."""
    with plots.styled():
        figure = plots.figure(width_px, 3 * ROW_PX, DPI)
        draw(figure, run)
        figure.align_ylabels()
        figure.tight_layout()
    return figure


def _coloured(run: Run) -> list[tuple[Estimate, str]]:
    return list(zip(estimates(run), COLOURS * 9))


def draw_attitude(figure: plots.Figure, run: Run) -> None:
    """Roll, pitch and yaw of every filter, truth dashed."""
    rows = figure.subplots(3, 1, sharex=True)
    truth = truth_q_nb(run)
    angles = None if truth is None else euler_deg(truth)
    for estimate, colour in _coloured(run):
        lines = euler_deg(estimate.q_nb)
        lines = lines if angles is None else near_turn(lines, angles)
        for axes, values in zip(rows, lines.T):
            axes.plot(run.t_s, values, color=colour, label=estimate.name)
    for column, (axes, name) in enumerate(zip(rows, ("roll", "pitch", "yaw"))):
        if angles is not None:
            axes.plot(run.t_s, angles[:, column], color=plots.INK, lw=0.9, ls=(0, (4, 2)), label="truth")
        axes.set_ylabel(f"{name} / deg")
    rows[0].set_title("Attitude against truth" if truth is not None else "Attitude")
    plots.legend_above(rows[0])
    _time_axis(rows[-1], run)


def draw_error(figure: plots.Figure, run: Run) -> None:
    """A column for each filter, a row for each navigation axis: error in its band of 3 sigma."""
    filters = _coloured(run)
    grid = figure.subplots(3, len(filters), sharex=True, sharey="row", squeeze=False)
    for column, (estimate, colour) in enumerate(filters):
        error, sigma = estimate.error_deg, np.degrees(estimate.vector("att.sigma", 3))
        for axis, name in enumerate(("north", "east", "down")):
            axes = grid[axis, column]
            axes.fill_between(run.t_s, -3 * sigma[:, axis], 3 * sigma[:, axis], color=colour, alpha=0.16, lw=0)
            axes.plot(run.t_s, error[:, axis], color=colour, lw=1.0)
            if column == 0:
                axes.set_ylabel(f"{name} / deg")
        grid[0, column].set_title(f"{estimate.name}: error, ±3σ")
        _time_axis(grid[-1, column], run)
    for axis in range(3):
        # Bands that begin at half a turn would hide the errors.
        sizes = np.concatenate([np.abs(e.error_deg[:, axis]) for e, _ in filters])
        limit = 1.3 * np.nanquantile(sizes, 0.998) if np.isfinite(sizes).any() else 0.0
        if limit > 0:
            grid[axis, 0].set_ylim(-limit, limit)


def draw_bias(figure: plots.Figure, run: Run) -> None:
    """Gyro bias in body axes with its band of one sigma."""
    rows = figure.subplots(3, 1, sharex=True)
    for estimate, colour in _coloured(run):
        bias, sigma = (np.degrees(estimate.vector(f"bias.{name}", 3)) for name in ("gyro", "gyro_sigma"))
        for axis, axes in enumerate(rows):
            axes.fill_between(
                run.t_s, bias[:, axis] - sigma[:, axis], bias[:, axis] + sigma[:, axis], color=colour, alpha=0.14, lw=0
            )
            axes.plot(run.t_s, bias[:, axis], color=colour, label=f"{estimate.name} ±1σ")
    for axes, name in zip(rows, "xyz"):
        axes.set_ylabel(f"{name} / (deg/s)")
    rows[0].set_title("Gyro bias")
    plots.legend_above(rows[0])
    _time_axis(rows[-1], run)


def _time_axis(axes: plots.Axes, run: Run) -> None:
    axes.set_xlabel("time / s")
    axes.set_xlim(run.t_s[0], run.t_s[-1])
