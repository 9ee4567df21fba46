"""The page about an observer's run: estimates with bands, innovations, and the check of its derivatives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hnav.filters.observer import ObserverRun, contradicted
from hnav.filters.observer_findings import Finding, findings, moment
from hnav.io.model_description import ModelDescription
from hnav.native.arrays import Array
from hnav.reports.colours import BLUE, GREEN, INK, ORANGE, VERMILION
from hnav.reports.page import write_page
from hnav.reports.panels import Panel, band, dots, grid_of, line, table

if TYPE_CHECKING:
    from hnav.reports.graphs import go

WINDOW = 50  # samples of a running mean, as in the findings of the observer
MOST_MARKS = 100  # of each kind: a browser draws more too slowly
USUAL_MEAN = (0.47, 1.79)  # where 99.9 % of such means of NIS lie


@dataclass(frozen=True)
class View:
    """A run with its plan and samples; times count from the first row, so that clocks since 1970 can be drawn."""

    run: ObserverRun
    t_s: Array
    units: dict[str, str]
    """Of estimates and sensors; a name without one is left out."""
    sensors: dict[str, float]
    """Their sigmas."""
    found: list[Finding]
    """The findings."""

    def label(self, name: str) -> str:
        return f"{name} / {self.units[name]}" if self.units.get(name) else name


def report_observer(run: ObserverRun, file: str | Path, samples: str = "", found: list[Finding] | None = None) -> None:
    """Writes one HTML page that needs no network. Needs Plotly. Raises HnavError if it cannot be written.

    samples: what they are called in the title; found: intervals that stand out, None: those of the run.
    """
    seen = view(run, findings(run, run.plan) if found is None else found)
    model = run.plan.plant.name if isinstance(run.plan.plant, ModelDescription) else "observer"
    facts = {
        "estimated": ", ".join(run.x), "sensors": ", ".join(run.nis), "length": f"{seen.t_s[-1] if len(seen.t_s) else 0:.6g} s",
        "rows": str(len(seen.t_s)), **({"hindsight": "every row from all samples"} if run.smoothed else {}),
    }  # fmt: skip
    warnings = contradicted(run.proof, run.plan) + run.dropped_in_words() + run.held_in_words()
    write_page(file, f"{model} · {samples}" if samples else model, facts, warnings, PANELS, seen)


def view(run: ObserverRun, found: list[Finding]) -> View:
    """The run in the form of the panels."""
    plan = run.plan
    fmu = plan.plant if isinstance(plan.plant, ModelDescription) else None
    variables = {name: name for name in run.x} | {name: sensor.of for name, sensor in plan.sensors.items()}
    units = {name: fmu.variables[of].unit for name, of in variables.items()} if fmu is not None else {}
    sigmas = {name: abs(sensor.factor) * sensor.noise for name, sensor in plan.sensors.items()}
    return View(run, run.t_s - run.t_s[0] if len(run.t_s) else run.t_s, units, sigmas, found)


def _rows(seen: View, names: list[str], draw: Callable[[go.Figure, int, str], None]) -> go.Figure:
    figure = grid_of(len(names), 1)
    for row, name in enumerate(names, 1):
        draw(figure, row, name)
        figure.update_yaxes(title_text=seen.label(name), row=row, col=1)
    _mark(figure, seen)
    return figure


def _mark(figure: go.Figure, seen: View) -> None:
    """Findings as bands of time, events of the plant as lines."""
    if len(seen.t_s) == 0:
        return
    for one in seen.found[:MOST_MARKS]:
        start, end = one.start_s - seen.run.t_s[0], one.end_s - seen.run.t_s[0]
        figure.add_vrect(x0=start, x1=end, fillcolor=ORANGE, opacity=0.12, line_width=0, layer="below")
    happened = np.flatnonzero(np.diff(np.round(seen.run.plant_events)) > 0) + 1
    for t_s in seen.t_s[happened[:MOST_MARKS]]:
        figure.add_vline(x=float(t_s), line_width=0.6, line_dash="dot", line_color=INK, layer="below")


def _estimates(seen: View) -> go.Figure:
    def draw(figure: go.Figure, row: int, name: str) -> None:
        x, sigma = seen.run.x[name], seen.run.sigma[name]
        figure.add_trace(band(seen.t_s, x - 3 * sigma, x + 3 * sigma, BLUE, "±3 sigma", row == 1), row, 1)
        figure.add_trace(line(seen.t_s, x, BLUE, "estimate", row == 1), row, 1)

    return _rows(seen, list(seen.run.x), draw)


def _innovations(seen: View) -> go.Figure:
    def draw(figure: go.Figure, row: int, name: str) -> None:
        innovation, nis = seen.run.innovation[name], seen.run.nis[name]
        used = np.isfinite(nis) & (nis > 0)
        sigma = np.abs(innovation[used]) / np.sqrt(nis[used])
        figure.add_trace(band(seen.t_s[used], -3 * sigma, 3 * sigma, GREEN, "±3 sigma as expected", row == 1), row, 1)
        figure.add_trace(dots(seen.t_s[used], innovation[used], INK, "measured minus expected", row == 1), row, 1)
        if used.any():
            edge = _shown_to(sigma, innovation[used])
            figure.update_yaxes(range=(-edge, edge), row=row, col=1)

    return _rows(seen, list(seen.run.nis), draw)


def _shown_to(sigma: Array, innovation: Array) -> float:
    """Axis limit of the innovations: the wide initial band would flatten the others."""
    return float(max(1.3 * np.quantile(3 * sigma, 0.9), 1.1 * np.quantile(np.abs(innovation), 0.998))) or 1.0


def _nis(seen: View) -> go.Figure:
    def draw(figure: go.Figure, row: int, name: str) -> None:
        used = np.isfinite(seen.run.nis[name])
        t_s, nis = seen.t_s[used], seen.run.nis[name][used]
        low, high = (np.full(len(t_s), edge) for edge in USUAL_MEAN)
        figure.add_trace(band(t_s, low, high, GREEN, "99.9 % of such means", row == 1), row, 1)
        figure.add_trace(line(t_s, _running_mean(nis), VERMILION, f"mean NIS of {WINDOW} samples", row == 1), row, 1)
        figure.update_yaxes(rangemode="tozero", row=row, col=1)

    return _rows(seen, list(seen.run.nis), draw)


def _running_mean(values: Array) -> Array:
    """Of the last WINDOW values, of fewer at the beginning."""
    sums = np.concatenate([[0.0], np.cumsum(values)])
    ends = np.arange(1, len(values) + 1)
    starts = np.maximum(ends - WINDOW, 0)
    return np.asarray((sums[ends] - sums[starts]) / (ends - starts))


def _findings(seen: View) -> str:
    origin = seen.run.t_s[0]
    return table(
        ["what stood out", "from", "to"],
        [[one.what.rstrip(","), moment(one.start_s, origin), moment(one.end_s, origin)] for one in seen.found],
    )


def _events(seen: View) -> go.Figure:
    figure = grid_of(2, 1)
    figure.add_trace(line(seen.t_s, seen.run.plant_events, BLUE, "events of the plant", True), 1, 1)
    figure.add_trace(line(seen.t_s, seen.run.parts.astype(float), VERMILION, "parts of the estimate", True), 2, 1)
    for row, title in ((1, "events"), (2, "parts")):
        figure.update_yaxes(title_text=title, rangemode="tozero", row=row, col=1)
    return figure


def _end(seen: View) -> str:
    run = seen.run
    rows = [[name, f"{run.x[name][-1]:.6g}", f"{run.sigma[name][-1]:.2g}", seen.units.get(name, "")] for name in run.x]
    return table(["", "at the end", "sigma", "unit"], rows)


def _sensors(seen: View) -> str:
    rows = []
    for name, nis in seen.run.nis.items():
        used = nis[np.isfinite(nis)]
        mean = f"{used.mean():.2f}" if len(used) else "–"
        rows.append([name, f"{seen.sensors[name]:.3g}", seen.units.get(name, ""), str(len(used)), mean])
    return table(["sensor", "stated sigma", "unit", "samples", "mean NIS"], rows)


def _proof(seen: View) -> str:
    rows = [
        [name.replace("_", " "), "right" if block.exact else "wrong: differences are used", f"{block.stated:.6g}", f"{block.measured:.6g}"]
        for name, block in seen.run.proof.items()
    ]  # fmt: skip
    return table(["derivatives", "", "worst element, by the plant", "by differences"], rows)


def _has_rows(seen: View) -> bool:
    return len(seen.t_s) > 0


# In the order of the page.
PANELS = (
    Panel("end", "At the end", "What was estimated last, with its standard deviation.", _end, _has_rows),
    Panel("estimates", "Estimates", "Each with three standard deviations.", _estimates, _has_rows),
    Panel("findings", "What stood out", "Unknown inputs and parameters beyond 3 sigma of their usual value, samples beyond their gate, "
           "innovations larger than stated: the bands of time in the figures.", _findings, lambda seen: bool(seen.found)),
    Panel("events", "Events of the plant", "How many there have been, and how many ways there may have been: the dotted lines in the "
           "figures.", _events, lambda seen: bool((seen.run.plant_events > 0).any() or (seen.run.parts > 1).any())),
    Panel("innovations", "Innovations", "What each sample brought that was not foreseen: 99.7 % of them lie in the band.", _innovations,
           _has_rows),
    Panel("nis", "Normalised innovations", "1 where the noises are as stated. Above the band: more noise than stated, or a wrong model; below: "
           "less.", _nis, _has_rows),
    Panel("sensors", "Sensors", "Their stated noise, and their innovations.", _sensors),
    Panel("proof", "Derivatives", "Those that the plant offers, compared with differences at five points.", _proof,
           lambda seen: bool(seen.run.proof)),
)  # fmt: skip
