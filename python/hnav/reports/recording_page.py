"""The page about a recording: estimates of a filter, figures to copy, and the panels that apply."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hnav.filters.run_summary import rows, summary
from hnav.reports.observability_panel import observability_panel
from hnav.reports.page import PANELS, figures_as_text, folded, write_page
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
    t_s = run.recording.t_s
    facts = {
        "filter": run.filter, "frame": "-".join(run.axes), "begins": began(float(t_s[0])), "length": f"{t_s[-1] - t_s[0]:.6g} s",
        "rows": str(len(t_s)),
    }  # fmt: skip
    panels = {panel.name: panel for panel in (*PANELS, strength_panel)}
    shown = [*(panels[name] for name in SHOWN), *observability_panel(lambda: run.result.observability(run.recording))]
    figures = figures_as_text([*rows(summary(run.result)), *_against(run), *rates(run)])
    # What differs from the preset.
    changed = {} if run.result.options is None else run.result.options.changed()
    options = folded(f"{len(changed)} option{'s' * (len(changed) > 1)} set", changed)
    return write_page(file, run.recording.name, facts, run.findings, shown, view(run), figures, options)


def _against(run: RecordingRun) -> list[tuple[str, str]]:
    """Root mean squares against the reference, if there is one."""
    if run.reference_q_nb is None:
        return []
    found = errors(estimates(view(run))[0])
    if not np.isfinite(found.rmse_deg):
        return []
    return [(f"RMS against {run.reference}", f"{found.rmse_deg:.3g} deg in all, heading {found.heading_rmse_deg:.3g} deg")]
