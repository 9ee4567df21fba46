"""The page about a comparison: overlaid trajectories, their errors, and a table."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from hnav.io.trajectories import Trajectory
from hnav.native.arrays import Array
from hnav.reports.angles import euler_deg, near_turn
from hnav.reports.colours import INK
from hnav.reports.comparison import Comparison
from hnav.reports.page import write_page
from hnav.reports.panels import CIRCLE_AXIS, FILTER_COLOURS, Panel, circle_line, grid_of, line, seen_from_above, table

LAPS_DEG = 720.0  # a yaw that turns further, as that of a vehicle on laps, is drawn from 0 to 360 deg


@dataclass(frozen=True)
class View:
    """Comparisons with one reference; times from the first row that is compared."""

    compared: Sequence[Comparison]
    t_s: Array
    """Of the longest."""

    @property
    def coloured(self) -> Iterable[tuple[Comparison, str]]:
        """Each with its colour."""
        return ((one, FILTER_COLOURS[i % len(FILTER_COLOURS)]) for i, one in enumerate(self.compared))

    def quantities(self) -> list[tuple[str, str]]:
        """Names and units of the errors."""
        return list(dict.fromkeys((figure.name, figure.unit) for one in self.compared for figure in one.figures))


def write_comparison(compared: Sequence[Comparison], file: Path) -> None:
    """Writes one HTML page that needs no network. Needs Plotly. Raises HnavError if it cannot be written."""
    begin_s, end_s = (pick(float(one.aligned.t_s[row]) for one in compared) for pick, row in ((min, 0), (max, -1)))
    seen: Any = View([_since(one, begin_s) for one in compared], np.array([0.0, end_s - begin_s]))
    reference = compared[0].reference.name
    facts = {"reference": reference, "length": f"{seen.t_s[-1]:.6g} s"}
    notes = [f"note: {one.aligned.name}: {name}: {text}" for one in compared for name, text in one.found.items()]
    write_page(file, f"{', '.join(one.aligned.name for one in compared)} against {reference}", facts, notes, PANELS, seen)


def _since(one: Comparison, begin_s: float) -> Comparison:
    moved = [replace(part, t_s=part.t_s - begin_s) for part in (one.reference, one.aligned)]
    return Comparison(moved[0], moved[1], [replace(figure, t_s=figure.t_s - begin_s) for figure in one.figures], one.found)


def _attitude(seen: View) -> Any:
    figure = grid_of(3, 1)
    reference = max((one.reference for one in seen.compared), key=lambda one: len(one.t_s))
    true = euler_deg(reference.q_nb)
    on_circle = np.ptp(true[:, 2]) > LAPS_DEG
    for row, name in enumerate(("roll", "pitch", "yaw")):
        drawn: Callable[..., Any] = circle_line if on_circle and name == "yaw" else line
        figure.add_trace(drawn(reference.t_s, true[:, row], INK, reference.name, row == 0), row + 1, 1)
        for one, colour in seen.coloured:
            own = near_turn(euler_deg(one.aligned.q_nb)[:, row], euler_deg(one.reference.q_nb)[:, row])
            figure.add_trace(drawn(one.aligned.t_s, own, colour, one.aligned.name, row == 0), row + 1, 1)
        figure.update_yaxes(title_text=f"{name} / deg", row=row + 1, col=1)
    if on_circle:
        figure.update_yaxes(CIRCLE_AXIS, row=3, col=1)
    return figure


def _errors(seen: View) -> Any:
    names = seen.quantities()
    figure = grid_of(len(names), 1)
    for row, (name, unit) in enumerate(names, 1):
        for one, colour in seen.coloured:
            for of in one.figures:
                if of.name == name:
                    figure.add_trace(line(of.t_s, of.values, colour, one.aligned.name, row == 1), row, 1)
        figure.update_yaxes(title_text=f"{name.replace(' relative, ', '<br>over ')} / {unit}", rangemode="tozero", row=row, col=1)
    return figure


def _track(seen: View) -> Any:
    """Seen from above: the first axis up where it is north, to the right where it is east."""
    from hnav.reports.graphs import go

    figure = go.Figure()
    north_first = np.isfinite(seen.compared[0].reference.place).any()

    def draw(one: Trajectory, colour: str) -> None:
        rows = np.unique(np.linspace(0, len(one.t_s) - 1, 2000).astype(int))
        x, y = one.position_m[rows, :2].T[:: -1 if north_first else 1]
        figure.add_trace(go.Scatter(x=x, y=y, mode="lines", name=one.name, line=dict(color=colour, width=1.4),
                                    customdata=one.t_s[rows].astype(np.float32)))  # fmt: skip

    draw(seen.compared[0].reference, INK)
    for one, colour in seen.coloured:
        draw(one.aligned, colour)
    seen_from_above(figure, *(("east / m", "north / m") if north_first else ("x / m", "y / m")))
    return figure


def _has(seen: View, array: str) -> bool:
    """Whether a compared run has a quantity."""
    return any(np.isfinite(getattr(one.aligned, array)).all(axis=1).any() for one in seen.compared)


def _table(seen: View) -> str:
    rows = [
        [one.aligned.name, figure.name, *(f"{value:.4g}\N{NO-BREAK SPACE}{figure.unit}" for value in (figure.rms, figure.median, figure.worst)),
         f"{figure.nees:.2f}" if np.isfinite(figure.nees) else "-", str(len(figure.values))]
        for one in seen.compared for figure in one.figures
    ]  # fmt: skip
    return table(["file", "error", "rms", "median", "worst", "NEES / axis", "rows"], rows)


PANELS: tuple[Panel, ...] = (
    Panel("figures", "Figures", "NEES of an axis is 1 when errors are as large as the sigmas say.", _table),
    Panel("attitude", "Attitude", "The reference in ink.", _attitude, lambda seen: _has(seen, "q_nb")),
    Panel("track", "Track", "From above.", _track, lambda seen: _has(seen, "position_m")),
    Panel("errors", "Errors", "Sizes over time; relative errors stand at the end of their motion.", _errors),
)
