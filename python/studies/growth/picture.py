"""A picture for each part: a line over the sizes, or bars."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from hnav.reports import plots
from hnav.reports.colours import BLUE

SIZE_PX = (700, 320)


def draw_lines(
    path: Path, x: Sequence[float], panels: Mapping[str, Sequence[float]], name: str, logarithmic: bool = True
) -> None:
    """panels: what is drawn over x, a panel each, by its name. They begin at zero: what is flat looks flat."""
    with plots.styled():
        fig = plots.figure(*SIZE_PX, dpi=100)
        for axes, (label, y) in zip(fig.subplots(1, len(panels), squeeze=False)[0], panels.items()):
            axes.plot(x, y, "o-", color=BLUE)
            if logarithmic:
                axes.set_xscale("log")
            axes.set_ylim(0, 1.25 * max(y))
            axes.set(xlabel=name, ylabel=label)
        fig.tight_layout()
    plots.save(fig, path)


def draw_bars(path: Path, names: Sequence[str], values: Sequence[float], label: str) -> None:
    with plots.styled():
        fig = plots.figure(*SIZE_PX, dpi=100)
        axes = fig.subplots()
        axes.barh(names, values, color=BLUE)
        axes.invert_yaxis()
        axes.set_xlabel(label)
        fig.tight_layout()
    plots.save(fig, path)
