"""The page about many runs of a system: distributions of their figures, a table, and the worst runs with the command that opens them."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from hnav.errors import HnavValueError
from hnav.reports.page import write_page
from hnav.reports.panels import FILTER_COLOURS, Panel, grid_of, table
from hnav.systems.montecarlo import COMMAND

SHOWN = {
    "rmse_deg": "attitude error, RMS / deg", "final_deg": "attitude error at the end / deg", "nees": "NEES (3 expected)",
    "heading_ready_s": "heading ready / s", "heading_end_deg": "heading error at the end / deg", "position_end_m": "place error at the end / m",
    "position_worst_m": "worst place error since ready / m",
}  # fmt: skip
"""Figures of a run, as far as the table has them, and their titles."""
WORST = 10  # worst runs in the table
POINTS = 400  # most points of a line


@dataclass(frozen=True)
class Runs:
    """A table of runs, and the figures that it has."""

    rows: pd.DataFrame
    """A row for each run that came to its end and filter."""
    figures: list[str]
    t_s: tuple[float, ...] = (0.0, 1.0)
    """The panels have no times."""

    @property
    def groups(self) -> list[tuple[str, pd.DataFrame]]:
        """By scenario and filter."""
        return [(f"{scenario}, {name}", rows) for (scenario, name), rows in self.rows.groupby(["scenario", "filter"], sort=False)]

    def sizes(self, rows: pd.DataFrame, figure: str) -> np.ndarray:
        """The finite values of a figure without their signs, in order."""
        values = np.abs(rows[figure].to_numpy(float))
        return np.sort(values[np.isfinite(values)])


def write_montecarlo_report(source: Path, file: Path) -> list[str]:
    """Writes the page about the table of runs, and returns the names of its panels. Raises HnavError if there is nothing to show."""
    every = pd.read_parquet(source)
    done = every[every["failure"] == ""].copy()
    if done.empty:
        raise HnavValueError("no data", f"{source}: no run came to its end")
    if "mse_deg2" in done:
        done["rmse_deg"] = np.sqrt(done["mse_deg2"])
    seen: Any = Runs(done, [name for name in SHOWN if name in done and done[name].notna().any()])
    failed = every[every["failure"] != ""]
    facts = {
        "runs": str(every.groupby(["scenario", "seed"]).ngroups), "scenarios": ", ".join(map(str, every["scenario"].unique())),
        "filters": ", ".join(map(str, done["filter"].unique())),
    }  # fmt: skip
    warnings = [f"{row.scenario}, seed {row.seed} failed: {row.failure}" for row in failed.head(WORST).itertuples()]
    return write_page(file, source.name, facts, warnings, PANELS, seen)


def _distributions(seen: Runs) -> Any:
    """Share of the runs whose figure is smaller."""
    from hnav.reports.graphs import go

    figure = grid_of(len(seen.figures), 1)
    figure.update_xaxes(range=[0, 1])
    figure.update_xaxes(title_text="share of the runs", row=len(seen.figures))
    for row, name in enumerate(seen.figures, 1):
        for i, (group, rows) in enumerate(seen.groups):
            sizes = seen.sizes(rows, name)
            share = np.linspace(0, 1, min(max(2, len(sizes)), POINTS))
            line = dict(color=FILTER_COLOURS[i % len(FILTER_COLOURS)], width=1.4)
            y = np.quantile(sizes, share) if len(sizes) else np.full(len(share), np.nan)
            shown = dict(name=group, legendgroup=group, showlegend=row == 1, line=line)
            figure.add_trace(go.Scatter(x=share, y=y, mode="lines", **shown), row, 1)
        title, scale = SHOWN[name].replace(" / ", "<br>"), "log" if _spread(seen, name) else "linear"
        figure.update_yaxes(title_text=title, type=scale, row=row, col=1)
    return figure


def _spread(seen: Runs, name: str) -> bool:
    """Whether the values of a figure span so much that a linear axis hides the small ones."""
    sizes = seen.sizes(seen.rows, name)
    return bool(len(sizes) and sizes[0] > 0 and sizes[-1] > 30 * np.median(sizes))


def _table(seen: Runs) -> str:
    heads = ["scenario, filter", "figure", "runs", "median", "95 %", "worst"]
    rows = []
    for group, of in seen.groups:
        for name in seen.figures:
            if len(sizes := seen.sizes(of, name)):
                figures = (np.median(sizes), np.quantile(sizes, 0.95), sizes[-1])
                rows.append([group, SHOWN[name], str(len(sizes)), *(f"{value:.3g}" for value in figures)])
    return table(heads, rows)


def _worst(seen: Runs) -> str:
    """The runs with the largest first figure of their filter."""
    name = seen.figures[0]
    largest = seen.rows.reindex(seen.rows[name].abs().sort_values(ascending=False).index).head(WORST)
    simulate = seen.rows.attrs.get(COMMAND, "hnav simulate SYSTEM")
    rows = []
    for run in largest.to_dict("records"):
        scenario = "" if run["scenario"] == "as bound" else f" --scenario {shlex.quote(str(run['scenario']))}"
        words = f"{simulate}{scenario} --seed {run['seed']} --out seed_{run['seed']} && hnav report seed_{run['seed']}"
        rows.append([f"{run['scenario']}, {run['filter']}", str(run["seed"]), f"{run[name]:.3g}", words])
    return table(["scenario, filter", "seed", SHOWN[name], "to open it"], rows)


def _has_figures(seen: Any) -> bool:
    return bool(seen.figures)


PANELS: tuple[Panel, ...] = (
    Panel("distribution", "Distribution", "Each line: the share of the runs whose figure is smaller.", _distributions, _has_figures),
    Panel("table", "Figures", "Sizes, without their signs.", _table, _has_figures),
    Panel("worst", "Worst runs", "Largest first figure; each command simulates the run again and makes its page.", _worst, _has_figures),
)  # fmt: skip
