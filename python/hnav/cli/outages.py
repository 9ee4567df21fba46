"""hnav filter --filter ins --truth FILE: errors against a truth once the filter is ready, NEES, and errors at the end of outages."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from rich.table import Table

from hnav.cli.console import say, show, working
from hnav.cli.navigation import read_navigation
from hnav.cli.recordings import warn, warnings_of
from hnav.cli.wanted import INS, Wanted
from hnav.cli.words import UsageError
from hnav.filters.options import Options
from hnav.io.trajectories import Trajectory, read_truth
from hnav.reports.navigation_scores import NavigationScore, Outage, navigation_score


def print_errors(recording: Path, wanted: Wanted, warned: bool) -> None:
    """Prints both tables, by wanted.truth. warned: of the recording, already. Raises HnavError or UsageError."""
    assert wanted.truth is not None, "the caller checks this"
    lengths = lengths_of(wanted.outages)
    options, true = Options(INS, wanted.preset, **wanted.settings), read_truth(wanted.truth)
    data, found = read_navigation(recording, wanted.reading.read_aids(wanted.gnss), options, wanted)
    warnings = warnings_of(recording, found, wanted.strict, wanted.force)
    with working(f"{data.name}: {len(lengths)} lengths of outages"):
        score = navigation_score(data, true, options, lengths, wanted.smooth)
    show(figures_table(score, f"{data.name} ({options.preset}{', with hindsight' if wanted.smooth else ''})"))
    if lengths:
        show(outages_table(score.outages))
    for line in said(score, true):
        say(line)
    warn([] if warned else warnings)


def lengths_of(text: str | None) -> list[float]:
    """The lengths of --outages in s. Raises UsageError."""
    try:
        lengths = [float(part) for part in text.split(",")] if text else []
    except ValueError:
        lengths = [np.nan]
    if not all(0 < length < np.inf for length in lengths):
        raise UsageError(f"--outages {text}: write lengths in s, such as 10,30,60")
    return lengths


def said(found: NavigationScore, truth: Trajectory) -> list[str]:
    """Notes below the tables."""
    ready = "heading was never ready" if np.isnan(found.ready_s) else f"heading ready after {found.ready_s:.3g} s"
    false = ", and was off by more than 3 sigma and 5 deg" if found.is_false else ""
    lines = [f"{ready}{false}; compared from {found.begin_s:.3g} s on, NEES from the sigmas without correlations"]
    if truth.angles in ("deg", "rad"):
        lines.append(f"roll, pitch and heading of the truth taken for {truth.angles}")
    return lines


def figures_table(found: NavigationScore, title: str) -> Table:
    """A row for each quantity whose truth is known."""
    table = Table("error", "rms", "worst", "NEES / axis", title=title, title_justify="left")
    for figure in found.figures:
        table.add_row(figure.name, f"{figure.rms:.3g} {figure.unit}", f"{figure.worst:.3g} {figure.unit}", f"{figure.nees:.2f}")
    return table


def outages_table(outages: list[Outage]) -> Table:
    """A row for each length."""
    heads = "without satellites, times, horizontal median, rms, worst, stated rms, vertical rms, heading rms, within 3 sigma"
    table = Table(*heads.split(", "), title="Position at the end of outages", title_justify="left")
    for one in outages:
        if not len(one.horizontal_m):
            table.add_row(f"{one.length_s:g} s", "0", *7 * ["-"])
            continue
        within = 100 * np.mean(one.horizontal_m <= 3 * one.sigma_m)
        heading = np.degrees(_rms(one.heading_rad))
        table.add_row(
            f"{one.length_s:g} s", str(len(one.horizontal_m)), f"{np.median(one.horizontal_m):.3g} m", f"{_rms(one.horizontal_m):.3g} m",
            f"{np.max(one.horizontal_m):.3g} m", f"{_rms(one.sigma_m):.3g} m", f"{_rms(one.vertical_m):.3g} m",
            "-" if np.isnan(heading) else f"{heading:.3g} deg", f"{within:.0f} %",
        )  # fmt: skip
    return table


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
