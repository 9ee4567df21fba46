"""hnav navigation-score: errors of the navigation filter against a truth, their NEES, and errors at the end of outages."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.table import Table

from hnav.cli.console import say, show, working
from hnav.cli.navigation import aids_given, of_navigation, options_of, read_navigation
from hnav.cli.parameters import Gnss, Preset, Settings, Smooth, Strict, parse_settings
from hnav.cli.recordings import Reading, warn, warnings_of, with_reading
from hnav.cli.words import UsageError
from hnav.io.outputs import refuse_overwriting, write_files
from hnav.io.plausibility import check_aids
from hnav.io.truth import Truth, read_truth
from hnav.reports.navigation_scores import NavigationScore, Outage, navigation_score


@with_reading
def command(
    recording: Annotated[Path, typer.Argument(help="Recording in the formats of hnav filter, with satellites")],
    truth: Annotated[
        Path,
        typer.Option(metavar="FILE", help="CSV of t_s, lat_deg, lon_deg, alt_m, vn, ve, vd, roll, pitch, heading or q0 to q3"),
    ],
    outages: Annotated[
        str | None, typer.Option(metavar="SECONDS,...", help="Lengths of artificial outages of the satellites, such as 10,30,60")
    ] = None,
    gnss: Gnss = None,
    settings: Settings = None,
    preset: Preset = "default",
    *,
    reading: Reading,
    strict: Strict = False,
    smooth: Smooth = False,
    json_file: Annotated[Path | None, typer.Option("--json", metavar="FILE", help="Also write the figures there")] = None,
) -> None:
    lengths = lengths_of(outages)
    refuse_overwriting([json_file], [recording, truth, gnss])
    options, true = options_of(preset, parse_settings(settings)), read_truth(truth)
    data = read_navigation(recording, aids_given(gnss, reading), options, reading)
    doubts = warnings_of(recording, [*of_navigation(reading.check(data)), *check_aids(data)], strict)
    with working(f"{data.name}: {len(lengths)} lengths of outages"):
        found = navigation_score(data, true, options, lengths, smooth)
    show(figures_table(found, f"{data.name} ({options.preset}{', with hindsight' if smooth else ''})"))
    if lengths:
        show(outages_table(found.outages))
    for line in said(found, true):
        say(line)
    warn(doubts)
    if json_file:
        write_files({json_file: json.dumps(asdict(found), indent=1, default=lambda array: array.tolist()) + "\n"})


def lengths_of(text: str | None) -> list[float]:
    """Of --outages. Raises UsageError."""
    try:
        lengths = [float(part) for part in text.split(",")] if text else []
    except ValueError:
        lengths = [np.nan]
    if not all(0 < length < np.inf for length in lengths):
        raise UsageError(f"--outages {text}: write lengths in s, such as 10,30,60")
    return lengths


def said(found: NavigationScore, truth: Truth) -> list[str]:
    """What stands below the tables."""
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
    heads = (
        "without satellites",
        "times",
        "horizontal median",
        "rms",
        "worst",
        "stated rms",
        "vertical rms",
        "heading rms",
        "within 3 sigma",
    )
    table = Table(*heads, title="Position at the end of outages", title_justify="left")
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
