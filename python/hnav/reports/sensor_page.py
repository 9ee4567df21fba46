"""The page about the calibration of accelerometer and gyroscope: figures, and the attitudes at rest on two halves of the sphere."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hnav.filters.sensor_calibration import ATTITUDES, SensorCalibration, advice, distinct, largest_gap, rests_of, unit_vectors
from hnav.io.recordings import Recording
from hnav.native.arrays import Array
from hnav.reports.colours import BLUE, FAINT, VERMILION
from hnav.reports.page import write_page
from hnav.reports.panels import Panel, grid_of, table


@dataclass(frozen=True)
class View:
    """Rests, and the figures, if there are any."""

    directions: Array
    """n x 3: unit vectors of the force in body axes."""
    rows: Sequence[Sequence[str]] = ()


def write_sensor_report(name: str, found: SensorCalibration, rows: Sequence[Sequence[str]], file: Path) -> None:
    """Writes one HTML page that needs no network. Needs Plotly. rows: sensor, figure, x, y, z, unit. Raises HnavError."""
    facts = {"rests": str(len(found.directions)), "chi2": f"{found.chi2:.2f}"}
    _write(name, View(found.directions, rows), facts, [f"note: for more, {advice(found.missing)}"], file)


def write_refusal(recording: Recording, reason: str, file: Path) -> None:
    """Writes the page of an insufficient recording: its attitudes, and the direction of the largest gap. Raises HnavError."""
    try:
        directions = unit_vectors(rests_of(recording).force)
    except ValueError:  # not even two rests
        directions = np.empty((0, 3))
    _write(recording.name, View(directions), {"rests": str(len(directions))}, [reason], file)


def _write(name: str, seen: View, facts: dict[str, str], said: list[str], file: Path) -> None:
    attitudes = {"attitudes": f"{len(distinct(seen.directions))}, {ATTITUDES} or more are needed"}
    write_page(file, f"Calibration by {name}", facts | attitudes, said, PANELS, seen)


def _attitudes(seen: View) -> Any:
    from hnav.reports.graphs import go

    figure = grid_of(1, 2, ["z up", "z down"], row_px=380)
    ring = np.linspace(0, 2 * np.pi, 73)
    missing = largest_gap(seen.directions)[0][None] if len(seen.directions) else np.empty((0, 3))
    for column, sign in enumerate((1, -1), 1):
        for radius in (1.0, np.sqrt(0.5)):
            figure.add_trace(go.Scatter(x=radius * np.cos(ring), y=radius * np.sin(ring), mode="lines", line=dict(color=FAINT, width=1),
                                        showlegend=False, hoverinfo="skip"), 1, column)  # fmt: skip
        for name, points, colour, symbol in (
            ("rest", seen.directions, BLUE, "circle"),
            ("missing most", missing, VERMILION, "x"),
        ):
            shown = points[sign * points[:, 2] >= 0]
            scale = 1 / np.sqrt(1 + np.abs(shown[:, 2]))
            figure.add_trace(go.Scatter(x=scale * shown[:, 0], y=scale * shown[:, 1], mode="markers", name=name, legendgroup=name,
                                        showlegend=column == 1, marker=dict(color=colour, size=11, symbol=symbol)), 1, column)  # fmt: skip
        side = "" if column == 1 else str(column)
        square = dict(range=[-1.1, 1.1], constrain="domain", row=1, col=column)
        figure.update_xaxes(title_text="x", matches=None, **square)
        figure.update_yaxes(title_text="y" if column == 1 else "", scaleanchor=f"x{side}", **square)
    return figure


PANELS: tuple[Panel, ...] = (
    Panel("figures", "Figures", "corrected = matrix (reading - offset); ± is one sigma.",
             lambda seen: table(["sensor", "figure", "x", "y", "z", "unit"], seen.rows), lambda seen: bool(seen.rows)),
    Panel("attitudes", "Attitudes at rest", "Which body axis points up, on two halves of the sphere; areas are true, the outer ring is level. "
             "The cross is the direction that is farthest from all rests.", _attitudes),
)  # fmt: skip
