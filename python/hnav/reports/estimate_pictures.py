"""Pictures of the estimates of the INS and of observers over time, with three sigma."""

from __future__ import annotations

import numpy as np

from hnav.earth import axes_at, position_of
from hnav.filters.ins_answers import InsRun
from hnav.filters.observer import ObserverRun
from hnav.native.arrays import Array
from hnav.reports import colours, plots

WIDTH_PX, ROW_PX = 850, 190


def draw_navigation(run: InsRun) -> plots.Figure:
    """The track north and east of the first position, height, speed and heading; faint where they are not ready."""
    t_s, known = _from_zero(run.t_s), np.flatnonzero(np.isfinite(run.place).all(axis=1))
    origin = run.place[known[0]] if len(known) else np.zeros(3)
    way = (position_of(run.place) - position_of(origin)) @ axes_at(origin)
    heading = np.degrees(np.unwrap(np.where(np.isfinite(run.heading_rad), run.heading_rad, 0.0)))
    heading[~np.isfinite(run.heading_rad)] = np.nan
    rows = {
        "north / m": (way[:, 0], run.sigma_position_m[:, 0], 3),
        "east / m": (way[:, 1], run.sigma_position_m[:, 1], 3),
        "height / m": (run.place[:, 2], run.sigma_position_m[:, 2], 3),
        "speed / (m/s)": (np.hypot(*run.velocity_n_m_s[:, :2].T), np.hypot(*run.sigma_velocity_m_s[:, :2].T), 2),
        "heading / deg": (heading, np.degrees(run.sigma_rotation_rad[:, 2]), 1),
    }
    with plots.styled():
        figure = plots.figure(WIDTH_PX, ROW_PX * len(rows) + 60)
        grid = figure.subplots(len(rows), 1, sharex=True)
        for axes, (name, (values, sigma, flag)) in zip(grid, rows.items()):
            _draw(axes, t_s, values, sigma, run.ready[:, flag])
            axes.set_ylabel(name)
        grid[0].set_title(run.in_one_line(), fontsize=9)
        _finish(figure, grid)
    return figure


def draw_observer(run: ObserverRun) -> plots.Figure:
    """Each estimate, then the innovations of each sensor in the sigma that they were expected to have."""
    t_s = _from_zero(run.t_s)
    with plots.styled():
        count = len(run.x) + len(run.innovation)
        figure = plots.figure(WIDTH_PX, ROW_PX * count + 60)
        grid = figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]
        for axes, name in zip(grid, run.x):
            _draw(axes, t_s, run.x[name], run.sigma[name], run.ready)
            axes.set_ylabel(name)
        for axes, name in zip(grid[len(run.x) :], run.innovation):
            innovation, nis = run.innovation[name], run.nis[name]
            axes.plot(t_s, np.sign(innovation) * np.sqrt(nis), ".", ms=2, color=colours.INK)
            for limit in (-3, 3):
                axes.axhline(limit, color=colours.GREEN, lw=0.8)
            axes.set_ylabel(f"{name} / sigma")
        grid[0].set_title(run.in_one_line(), fontsize=9)
        _finish(figure, grid)
    return figure


def _from_zero(t_s: Array) -> Array:
    return t_s - t_s[0] if len(t_s) else t_s


def _draw(axes: plots.Axes, t_s: Array, values: Array, sigma: Array, ready: np.ndarray) -> None:
    """An estimate in its band; faint where it is not ready. The axis shows what is ready, if anything is."""
    axes.fill_between(t_s, values - 3 * sigma, values + 3 * sigma, color=colours.BLUE, alpha=0.15, lw=0)
    axes.plot(t_s, values, color=colours.BLUE, alpha=0.35, lw=1)
    axes.plot(t_s, np.where(ready, values, np.nan), color=colours.BLUE)
    if (seen := ready & np.isfinite(values + sigma)).any():
        low, high = np.min((values - 3 * sigma)[seen]), np.max((values + 3 * sigma)[seen])
        axes.set_ylim(low - 0.1 * (high - low), high + 0.1 * (high - low))


def _finish(figure: plots.Figure, grid: np.ndarray) -> None:
    grid[-1].set_xlabel("time / s")
    figure.align_ylabels()
    figure.tight_layout(h_pad=0.8)
