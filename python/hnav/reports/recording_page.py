"""The page about a recording: estimates of a filter, figures to copy, and the panels that apply."""

from __future__ import annotations

from html import escape
from pathlib import Path

import numpy as np

from hnav import __version__
from hnav.filters.run_summary import rows, summary
from hnav.io.outputs import write_files
from hnav.reports.observability_panel import observability_panel
from hnav.reports.page import PANELS, document, figures_as_text, heading_of
from hnav.reports.recording_run import RecordingRun
from hnav.reports.recording_view import began, rates, view
from hnav.reports.strength_panel import strength_panel
from hnav.systems.run_views import estimates
from hnav.systems.run_views import figures as errors

# In the order of the page.
SHOWN = ("body", "attitude", "error", "states", "bias", "strength", "nis", "health", "field")


def write_recording_report(run: RecordingRun, file: Path) -> list[str]:
    """Writes one HTML page about an attitude filter's run beside its recording, which needs no network. Returns the names of its
    panels."""
    seen = view(run)
    panels = {panel.name: panel for panel in (*PANELS, strength_panel)}
    shown = [panels[name] for name in SHOWN if panels[name].applies(seen)]
    shown += observability_panel(lambda: run.result.observability(run.recording))
    text = document(f"hnav · {run.recording.name}", _header(run), _figures(run), seen, shown)
    write_files({file: text}, make_folders=True)
    return [panel.name for panel in shown]


def _header(run: RecordingRun) -> str:
    t_s = run.recording.t_s
    facts = {
        "filter": run.filter, "frame": "-".join(run.axes), "begins": began(float(t_s[0])), "length": f"{t_s[-1] - t_s[0]:.6g} s",
        "rows": str(len(t_s)), "hnav": __version__,
    }  # fmt: skip
    return heading_of(run.recording.name, facts, run.findings, _options(run))


def _options(run: RecordingRun) -> str:
    """What differs from the preset, folded away."""
    changed = {} if run.result.options is None else run.result.options.changed()
    if not changed:
        return ""
    cells = "".join(f"<tr><td>{escape(name)}</td><td>{escape(str(value))}</td></tr>" for name, value in changed.items())
    head = f"{len(changed)} option{'s' * (len(changed) > 1)} set"
    return f"<details><summary>{head}</summary><table>{cells}</table></details>"


def _figures(run: RecordingRun) -> str:
    """The figures as text that one click marks, for a copy."""
    found = [*rows(summary(run.result)), *_against(run), *rates(run)]
    return figures_as_text(found)


def _against(run: RecordingRun) -> list[tuple[str, str]]:
    """Root mean squares against the reference, if there is one."""
    if run.reference_q_nb is None:
        return []
    found = errors(estimates(view(run))[0])
    if not np.isfinite(found.rmse_deg):
        return []
    return [(f"RMS against {run.reference}", f"{found.rmse_deg:.3g} deg in all, heading {found.heading_rmse_deg:.3g} deg")]
