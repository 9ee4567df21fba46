"""The page about a run of the navigation filter over a recording."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from hnav.filters.ins_answers import READY, InsRun
from hnav.filters.readiness import sigmas, smallest, why_never
from hnav.io.aids import AidSamples
from hnav.io.recordings import Recording
from hnav.reports.navigation_panels import NAVIGATION_PANELS, View, outages
from hnav.reports.observability_panel import observability_panel
from hnav.reports.page import figures_as_text, write_page
from hnav.reports.recording_view import began


def write_navigation_report(
    run: InsRun, file: str | Path, recording: Recording | None = None, warnings: Sequence[str] = ()
) -> list[str]:
    """Writes one HTML page that needs no network, and returns the names of its panels. Needs Plotly. Raises HnavError if it cannot
    be written.

    recording: the input of the run; the page then shows its GNSS too. warnings: warnings at the head of the page.
    """
    seen = view(run, recording)
    name = recording.name if recording is not None else "navigation"
    about = {
        "filter": "ins", "preset": run.options.preset if run.options else "", "begins": began(float(run.t_s[0])) if len(run.t_s) else "",
        "length": f"{seen.t_s[-1] if len(seen.t_s) else 0:.6g} s", "rows": str(len(run.t_s)), "hindsight": "every row from all samples" if run.smoothed else "",
    }  # fmt: skip
    known = {key: value for key, value in about.items() if value}
    panels = [*NAVIGATION_PANELS, *observability_panel(run.observability)]
    return write_page(file, name, known, warnings, panels, seen, figures_as_text(facts(seen)))


def view(run: InsRun, recording: Recording | None = None) -> View:
    """The run in the form of the panels."""
    begin_s = run.t_s[0] if len(run.t_s) else 0.0
    aids = recording.aids if recording is not None and len(run.t_s) else {}
    within = {kind: one.rows((one.t_s >= begin_s) & (one.t_s <= run.t_s[-1])) for kind, one in aids.items()}
    shown = {kind: AidSamples(one.t_s - begin_s, one.values, one.sigma) for kind, one in within.items() if len(one.t_s)}
    known = np.flatnonzero(np.isfinite(run.place).all(axis=1))
    return View(run, run.t_s - begin_s, shown, run.place[known[0]] if len(known) else np.full(3, np.nan))


def facts(seen: View) -> list[tuple[str, str]]:
    """The figures as text to copy."""
    run, known = seen.run, np.flatnonzero(seen.known)
    if not len(known):
        return [("rows", str(len(run.t_s))), ("estimate", "none: the filter waits for satellites, or for rate and force")]
    last = known[-1]
    moved = np.diff(seen.track_m(run.place[known])[:, :2], axis=0)
    (latitude, longitude), sigma_m = np.degrees(run.place[last, :2]), run.sigma_position_m[last]
    heading, sigma = np.degrees(run.heading_rad[last]) % 360, np.degrees(run.sigma_rotation_rad[last, 2])
    found = [
        ("track", f"{np.hypot(*moved.T).sum() / 1000:.4g} km in {seen.t_s[-1]:.6g} s"),
        ("last place", f"{latitude:.7f}, {longitude:.7f} deg, {run.place[last, 2]:.1f} m"),
        ("its sigma", f"{np.hypot(*sigma_m[:2]):.2f} m horizontal, {sigma_m[2]:.2f} m vertical"),
        ("last heading", f"{heading:.2f} deg, sigma {sigma:.2f} deg"),
    ]
    reached = smallest(sigmas(run.sigma_rotation_rad, run.sigma_velocity_m_s, run.sigma_position_m))
    for name, flags, sigma in zip(READY, run.ready.T, reached):
        rows = np.flatnonzero(flags)
        ready = f"never: {why_never(name, float(sigma), run.options)}"
        if len(rows):
            ready = f"after {seen.t_s[rows[0]]:.3g} s, in {100 * flags.mean():.3g} % of the rows"
        found.append((f"{name} ready", ready))
    if "position" in seen.aids:
        gaps = outages(seen.aids["position"].t_s, float(seen.t_s[-1]))
        longest = max((end - begin for begin, end in gaps), default=0.0)
        times = f"{len(gaps)} time{'s' * (len(gaps) > 1)}, the longest {longest:.4g} s" if gaps else "never"
        found.append(("without positions", times))
    return found
