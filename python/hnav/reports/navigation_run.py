"""Panels of the report about a simulation with a navigation filter: those of a recording, and errors against the truth."""

from __future__ import annotations

import numpy as np

from hnav.filters.ins_answers import READY, InsRun
from hnav.io.aids import AidSamples
from hnav.native.arrays import Array
from hnav.reports.colours import BLUE, VERMILION
from hnav.reports.graphs import go
from hnav.reports.navigation_panels import NAVIGATION_PANELS, View
from hnav.reports.panels import Panel, band, grid_of, line, panel
from hnav.systems.navigation_views import PLACE, Navigator, navigators
from hnav.systems.results import Run


def has_navigators(run: Run) -> bool:
    """Whether there is one beside a true place."""
    return bool(navigators(run))


def view_of(run: Run) -> View:
    """The first navigation filter, in the form of the panels of a recording."""
    seen = navigators(run)[0]
    name = seen.name

    def shown(variable: str, size: int) -> Array:
        return np.where(seen.known[:, None], run.vector(name, variable, size), np.nan)

    place = np.where(seen.known[:, None], np.column_stack([run[f"{name}.nav.{part}"] for part in PLACE]), np.nan)
    of_place = np.flatnonzero(seen.known)
    result = InsRun(
        t_s=run.t_s, place=place, velocity_n_m_s=shown("nav.velocity", 3), q_nb=shown("att.q", 4),
        sigma_position_m=shown("nav.sigma_position", 3), sigma_velocity_m_s=shown("nav.sigma_velocity", 3),
        sigma_rotation_rad=shown("att.sigma", 3), gyro_bias_rad_s=shown("bias.gyro", 3), accel_bias_m_s2=shown("bias.accel", 3),
        heading_second=np.column_stack([run[f"{name}.align.heading_second{end}"] for end in ("", "_share")]),
        protection_m=shown("nav.protection", 2), protection_heading_rad=run[f"{name}.att.heading_protection"],
        phase=run[f"{name}.align.phase"].astype(np.uint8), at_rest=run[f"{name}.rest.detected"] > 0.5,
        ready=np.column_stack([run[f"{name}.align.{what}_ready"] > 0.5 for what in READY]),
    )  # fmt: skip
    return View(result, run.t_s - run.t_s[0], _fixes(run), place[of_place[0]] if len(of_place) else np.full(3, np.nan))


def _fixes(run: Run) -> dict[str, AidSamples]:
    """Positions and velocities of the satellites, where the run holds them."""
    kinds = {
        "position": ("gnss", [f"gnss.{part}" for part in PLACE]),
        "velocity": ("gnssvel", [f"gnssvel.velocity[{i}]" for i in (1, 2, 3)]),
    }
    found = {}
    for kind, (group, names) in kinds.items():
        source = next((c for c in run.components if run.has(c, *names, f"{group}.sample", f"{group}.t_meas")), None)
        if source is None:
            continue
        fresh = np.diff(run[f"{source}.{group}.sample"], prepend=0.0) != 0
        values = np.column_stack([run[f"{source}.{name}"] for name in names])[fresh]
        sigma = run.vector(source, f"{group}.sigma", 3)[fresh]
        found[kind] = AidSamples(run[f"{source}.{group}.t_meas"][fresh] - run.t_s[0], values, sigma)
    return found


def _on_run(of_view: Panel) -> Panel:
    """A panel of a recording, for a simulation."""
    return Panel(
        f"navigation-{of_view.name}", of_view.title, of_view.note, lambda run: of_view.draw(view_of(run)),
        lambda run: has_navigators(run) and of_view.applies(view_of(run)),
    )  # fmt: skip


@panel("navigation-errors", "Errors", "Estimate minus truth, with ±3σ as the filter states it. Wider bands than the axis are cut off.", has_navigators)  # fmt: skip
def errors_panel(run: Run) -> go.Figure:
    figure, filters = grid_of(4, 1), navigators(run)
    for seen, colour in zip(filters, (BLUE, VERMILION)):
        heading, sigma = np.degrees(seen.heading_off_rad), np.degrees(seen.heading_sigma_rad)
        rows = [(seen.off_m[:, i], seen.sigma_m[:, i]) for i in range(3)] + [(heading, sigma)]
        for row, (off, spread) in enumerate(rows, 1):
            figure.add_trace(band(run.t_s, -3 * spread, 3 * spread, colour, f"±3σ of {seen.name}", row == 1), row, 1)
            figure.add_trace(line(run.t_s, off, colour, seen.name, row == 1), row, 1)
    titles = ("north / m", "east / m", "down / m", "heading / deg")
    for row, (title, limit) in enumerate(zip(titles, _limits(filters)), 1):
        figure.update_yaxes(title_text=title, range=[-limit, limit], row=row)
    return figure


def _limits(filters: list[Navigator]) -> Array:
    """4: half range of an axis: the errors once the heading is ready, with their bands."""
    off = [np.column_stack([seen.off_m, np.degrees(seen.heading_off_rad)]) for seen in filters]
    sigma = [np.column_stack([seen.sigma_m, np.degrees(seen.heading_sigma_rad)]) for seen in filters]
    largest = [
        np.nanmax(np.maximum(np.abs(o), 3.3 * s)[seen.ready_row or -1 :], axis=0, initial=1e-3)
        for seen, o, s in zip(filters, off, sigma)
    ]
    return np.asarray(np.max(largest, axis=0))


def summary_rows(run: Run) -> list[tuple[str, str]]:
    """The figures of each filter that navigates, as a name and a value."""
    rows = []
    for seen in navigators(run):
        found = seen.figures
        ready = f"after {seen.ready_s:.3g} s" if np.isfinite(seen.ready_s) else "never"
        at_end = f"{found['heading_end_deg']:.3g} deg off, sigma {found['heading_end_sigma_deg']:.3g} deg"
        rows += [
            (f"{seen.name}: heading ready", ready + (", falsely" if seen.is_false else "")),
            (f"{seen.name}: heading at the end", at_end),
            (f"{seen.name}: place at the end", f"{found['position_end_m']:.3g} m off"),
        ]
        if np.isfinite(found["position_worst_m"]):
            worst, within = found["position_worst_m"], found["position_within_3_sigma"]
            rows.append((f"{seen.name}: place since then", f"{worst:.3g} m off at most, {within:.1%} within 3 sigma"))
    return rows


NAVIGATION_RUN_PANELS = (errors_panel, *map(_on_run, NAVIGATION_PANELS))
