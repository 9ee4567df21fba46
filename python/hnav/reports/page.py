"""One self-contained HTML page: what was run, figures, and the panels that apply; here that of a simulation.

plotly.js stands inside the page, so that it opens without a network, today and in ten years.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from hnav import __version__
from hnav.io.outputs import write_files
from hnav.reports.attitude_panels import ATTITUDE_PANELS, timing_panel
from hnav.reports.body_panel import body_panel
from hnav.reports.certificate_panel import certificate_panel
from hnav.reports.flight_panels import FLIGHT_PANELS
from hnav.reports.graphs import get_plotlyjs, go
from hnav.reports.health_panel import health_panel
from hnav.reports.navigation_run import NAVIGATION_RUN_PANELS, summary_rows
from hnav.reports.panels import Panel, colour_of, over_time
from hnav.reports.plain_page import document, heading_of, text_of
from hnav.systems.results import Run
from hnav.systems.run_views import Estimate, estimates, figures

# In the order of the page; computing times are last.
PANELS: tuple[Panel, ...] = (
    body_panel,
    *ATTITUDE_PANELS,
    health_panel,
    certificate_panel,
    *FLIGHT_PANELS,
    *NAVIGATION_RUN_PANELS,
    timing_panel,
)
SCRIPTS = ("screen.js", "page.js", "cursor.js")
FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif"
# Colours with a counterpart for dark screens in page.js. The legend is at the bottom, the toolbar at the top.
LAYOUT = dict(
    template="none", font=dict(family=FONT, size=12, color="#333333"), margin=dict(l=64, r=18, t=36, b=44), paper_bgcolor="rgba(0,0,0,0)",
    plot_bgcolor="rgba(0,0,0,0)", modebar=dict(bgcolor="rgba(255,255,255,0.9)", color="#B8B8B8", activecolor="#0072B2"),
    legend=dict(orientation="h", yref="container", yanchor="bottom", y=0.0, xanchor="left", x=0.0, font=dict(size=12), itemsizing="constant"),
)  # fmt: skip
AXIS = dict(
    gridcolor="#E8E8E8", zerolinecolor="#D0D0D0", linecolor="#B0B0B0", ticks="outside", ticklen=3, tickcolor="#B0B0B0", automargin=True,
)  # fmt: skip
COLUMN_REM = 18
CONFIG = {
    "displaylogo": False, "responsive": True, "modeBarButtonsToRemove": ["select2d", "lasso2d", "autoScale2d"],
    # A button of Plotly's would upload the recording.
    "showSendToCloud": False, "plotlyServerURL": "",
}  # fmt: skip


def write_report(run: Run, file: Path, panels: Sequence[Panel] = PANELS) -> list[str]:
    """Writes the page and returns the names of the panels in it. Raises HnavError if the file cannot be written.

    panels: those that have something to draw of the run are shown.
    """
    title = run.about["system"] + (f" · {run.about['scenario']}" if run.about["scenario"] else "")
    return write_panels(file, title, header(run), summary(run), run, panels)


def write_page(
    file: str | Path, title: str, facts: Mapping[str, str], warnings: Sequence[str], panels: Sequence[Panel], seen: Any, figures: str = "", more: str = ""
) -> list[str]:  # fmt: skip
    """Writes one HTML page with the panels that have something to draw of what is seen, and returns their names.

    facts, warnings, more: as of heading_of; figures: HTML above the panels. Raises HnavError if it cannot be written.
    """
    return write_panels(file, title, heading_of(title, {**facts, "hnav": __version__}, warnings, more), figures, seen, panels)


def write_panels(file: str | Path, title: str, head: str, figures: str, seen: Any, panels: Sequence[Panel]) -> list[str]:
    """The same with its head as HTML. seen: what the panels draw, with times t_s where they have an axis of time."""
    shown = [panel for panel in panels if panel.applies(seen)]
    links = "".join(f'<a href="#{panel.name}">{escape(panel.title)}</a>' for panel in shown)
    main = "\n".join([f"<nav>{links}</nav><main>", figures, *(section(panel, seen) for panel in shown), "</main>"])
    text = document(title, f"{head}\n{main}", text_of(*SCRIPTS), get_plotlyjs())
    write_files({Path(file): text}, make_folders=True)
    return [panel.name for panel in shown]


def folded(summary: str, rows: Mapping[str, object]) -> str:
    """A table of names and values that a click opens; empty without rows."""
    cells = "".join(f"<tr><td>{escape(name)}</td><td>{escape(str(value))}</td></tr>" for name, value in rows.items())
    return f"<details><summary>{summary}</summary><table>{cells}</table></details>" if rows else ""


def figures_as_text(found: Sequence[tuple[str, str]]) -> str:
    """Names and values as text that one click marks, for a copy."""
    width = max(len(name) for name, _ in found)
    lines = "\n".join(f"{name:<{width}}  {value}" for name, value in found)
    note = '<p class="note">A click on the text marks all of it.</p>'
    return f'<section id="summary"><h2>Figures</h2>{note}<div class="scroll"><pre class="figures">{escape(lines)}</pre></div></section>'


def header(run: Run) -> str:
    about = run.about
    facts = {
        "scenario": about["scenario"], "grade": about["grade"], "seed": about["seed"], "length": f"{run.t_s[-1] - run.t_s[0]:g} s",
        "step": f"{1e3 * about['step_s']:g} ms", "hnav": about["versions"]["hnav"],
    }  # fmt: skip
    warnings = [about["failure"]] if about["failure"] else []
    warnings += [f"{name} lost {n} samples between the communication points" for name, n in about["lost"].items() if n]
    chosen = {name: f"{value:g}" if isinstance(value, float) else value for name, value in about["parameters"].items()}
    known = {name: str(value) for name, value in facts.items() if value is not None}
    return heading_of(about["system"], known, warnings, folded(f"{len(chosen)} parameters set", chosen), about["description"])


def summary(run: Run) -> str:
    """A row for each filter, lines for an INS; "" without filters."""
    filters = estimates(run)
    if not filters:
        rows = summary_rows(run)
        return figures_as_text(rows) if rows else ""
    heads = "filter, RMSE, heading RMSE, error at the end, mean NEES (3), NIS force, NIS field, tilt ready, heading ready"
    head = "".join(f"<th>{name}</th>" for name in heads.split(", "))
    table = f'<table class="figures"><tr>{head}</tr>{"".join(_row(e) for e in filters)}</table>'
    return f'<section id="summary"><h2>Summary</h2><div class="scroll">{table}</div></section>'


def _row(estimate: Estimate) -> str:
    found = figures(estimate)
    cells = [_number(value, "deg") for value in (found.rmse_deg, found.heading_rmse_deg, found.final_deg)] + [_number(found.nees)]
    cells += [f"{_number(mean)} ({expected})" for mean, expected in found.nis.values()]
    cells += [_number(t, "s") if np.isfinite(t) else "never" for t in (found.tilt_ready_s, found.heading_ready_s)]
    swatch = f'<i style="background:{colour_of(estimate.run, estimate.name)}"></i>'
    return f"<tr><td>{swatch}{escape(estimate.name)}</td>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>"


def _number(value: float, unit: str = "") -> str:
    return f"{value:.3g} {unit}".strip() if np.isfinite(value) else "–"


def section(panel: Panel, run: Any) -> str:
    """Heading, note, lines and what the panel draws."""
    said = "".join(f"<li>{escape(line)}</li>" for line in panel.lines(run))
    head = f'<h2>{escape(panel.title)}</h2><p class="note">{escape(panel.note)}</p>{f"<ul>{said}</ul>" if said else ""}'
    drawn = panel.draw(run)
    shown = drawn if isinstance(drawn, str) else plot(f"plot-{panel.name}", drawn, run)
    return f'<section id="{panel.name}">{head}{shown}</section>'


def plot(name: str, figure: go.Figure, run: Any) -> str:
    """A figure as data that page.js gives to Plotly. Axes side by side keep a width at which they can be read."""
    figure.update_layout(LAYOUT)
    figure.update_xaxes(AXIS)
    figure.update_yaxes(AXIS)
    # Titles of columns look like the headings of the panels and do not move.
    figure.update_annotations(font=dict(size=12, color="#333333"))
    # Titles of columns stand below the toolbar.
    figure.update_layout(height=figure.layout.height or 450, margin=dict(t=56 if figure.layout.annotations else 36))
    over_time(figure, run)
    columns = len({tuple(axis.domain) for axis in figure.select_xaxes() if axis.domain}) or 1
    data = figure.to_json()[:-1] + f',"config":{json.dumps(CONFIG)}}}'
    width = f' style="min-width: {COLUMN_REM * columns}rem"' if columns > 1 else ""
    # Text in the data must not close the script element.
    held = data.replace("</", r"<\/")
    held = f'<script type="application/json" id="data-{name}">{held}</script>'
    return f'<div class="scroll"><div id="{name}" class="plotly-graph-div"{width}></div></div>{held}'
