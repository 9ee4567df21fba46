"""The picture of the benchmark: how far each filter is from the truth, and what a sample costs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.ticker import NullFormatter

from hnav.reports import colours, plots
from studies.bench.contenders import Contender

GREY, DARK_GREY, LIGHT_BLUE = "#C9CDD2", "#8E959D", "#8FC3E3"
OUT_OF_SCALE = 4.0  # times the median of all bars
GAP = 0.55  # of a row, between those that use later samples and the others


def draw_benchmark(lines: Sequence[Any], entered: Sequence[Contender], times: bool = True) -> plots.Figure:
    """One row a filter, best first: mean total error in deg, undisturbed and disturbed trials apart, beside the time per
    sample in microseconds on a logarithmic axis. hnav's filters in blue, others' in grey; those that use later samples
    are set apart by a line, times that are mostly Python's have hollow points. times=False leaves the times out."""
    ours = {contender.name for contender in entered if contender.ours}
    looped = {contender.name for contender in entered if contender.looped}
    causal, hindsight = _ranked(lines, entered, offline=False), _ranked(lines, entered, offline=True)
    ranked = [*causal, *hindsight]
    gap = GAP if causal and hindsight else 0.0
    place = np.arange(len(ranked)) + gap * (np.arange(len(ranked)) >= len(causal))
    with plots.styled():
        fig = plots.figure(1400 if times else 1000, 190 + 62 * len(ranked), dpi=130)
        panels = list(fig.subplots(1, 2, sharey=True, width_ratios=[1.75, 1.0]) if times else [fig.subplots()])
        errors = panels[0]
        _draw_errors(errors, ranked, place, ours)
        if times:
            _draw_times(panels[1], ranked, place, ours, looped)
        errors.set_yticks(place, [line.filter.replace(":solver=", ", ").replace("_", " ") for line in ranked])
        for label, line in zip(errors.get_yticklabels(), ranked):
            label.set(fontweight="bold" if line.filter in ours else "normal", color=colours.INK)
        if gap:
            _draw_divide(panels, len(causal) - 0.5 + gap / 2)
        errors.set_ylim(place[-1] + 0.6, -0.6)
        for axes in panels:
            axes.grid(False, axis="y")
            axes.tick_params(axis="y", length=0)
            axes.spines["left"].set_visible(False)
        fig.tight_layout(w_pad=2.5)
    return fig


def _ranked(lines: Sequence[Any], entered: Sequence[Contender], offline: bool) -> list[Any]:
    """The lines of those that use later samples, or do not, best first."""
    names = {contender.name for contender in entered if contender.offline is offline}
    return sorted((line for line in lines if line.filter in names), key=lambda line: line.total_deg)


def _draw_divide(panels: Sequence[plots.Axes], y: float) -> None:
    for axes in panels:
        axes.axhline(y, color=colours.FAINT, lw=0.8, ls=(0, (1, 2)))
    panels[0].annotate("with hindsight", (1.0, y), xycoords=("axes fraction", "data"), xytext=(-4, -3), textcoords="offset points",
                    ha="right", va="top", fontsize=8, color=colours.FAINT, style="italic")  # fmt: skip


def _draw_errors(axes: plots.Axes, lines: Sequence[Any], place: np.ndarray, ours: set[str]) -> None:
    undisturbed, disturbed = ([getattr(line, name) for line in lines] for name in ("undisturbed_deg", "disturbed_deg"))
    # One filter that fails must not squeeze the others: the axis ends where a bar would be out of scale, its figure says the rest.
    end = min(np.nanmax([undisturbed, disturbed]), OUT_OF_SCALE * np.nanmedian([undisturbed, disturbed]))
    for values, offset, blue, grey, inside in (
        (undisturbed, -0.19, LIGHT_BLUE, GREY, "#444444"), (disturbed, 0.19, colours.BLUE, DARK_GREY, "white"),
    ):  # fmt: skip
        filled = [blue if line.filter in ours else grey for line in lines]
        axes.barh(place + offset, values, height=0.36, color=filled, zorder=2)
        for y, value in zip(place + offset, values):
            if value > end:
                axes.text(1.1 * end, y, f"{value:.2f} »", ha="right", va="center", fontsize=8, color=inside)
            elif not np.isnan(value):
                axes.text(value + 0.012 * end, y, f"{value:.2f}", va="center", fontsize=8, color="#444444")
    # The legend is grey: it distinguishes light and dark, not the filters.
    axes.barh([0], [0], color=GREY, label="undisturbed field")
    axes.barh([0], [0], color=DARK_GREY, label="disturbed field")
    axes.set_xlim(0, 1.11 * end)
    axes.set_xlabel("total error / deg (RMS, mean over trials)")
    axes.set_title("Error against optical truth")
    plots.legend_above(axes)


def _draw_times(axes: plots.Axes, lines: Sequence[Any], place: np.ndarray, ours: set[str], looped: set[str]) -> None:
    times_us = np.array([line.us_per_sample for line in lines])
    low, high = 10 ** np.floor(np.log10(np.nanmin(times_us))), 10 ** np.ceil(np.log10(np.nanmax(times_us)) + 0.15)
    for y, time_us, line in zip(place, times_us, lines):
        if np.isnan(time_us):
            continue
        colour = colours.BLUE if line.filter in ours else DARK_GREY
        axes.plot([low, time_us], [y, y], color=colour, lw=1.6, alpha=0.55, solid_capstyle="butt", zorder=2)
        face = "white" if line.filter in looped else colour
        axes.plot(time_us, y, "o", color=colour, markerfacecolor=face, ms=7, mew=1.6, zorder=3)
        axes.annotate(f"{time_us:.2f}" if time_us < 10 else f"{time_us:.0f}", (time_us, y), xytext=(7, 0), textcoords="offset points",
                      va="center", fontsize=8, color="#444444")  # fmt: skip
    if any(line.filter in looped for line in lines):
        axes.plot([], [], "o", color=DARK_GREY, markerfacecolor="white", ms=7, mew=1.6, label="mostly Python's own time")
        plots.legend_above(axes)
    axes.set_xscale("log")
    axes.set_xlim(low, high)
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("time per IMU sample / µs (median)")
    axes.set_title("Cost")
