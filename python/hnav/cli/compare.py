"""hnav compare: errors of attitudes and positions against a reference, after the requested alignment of clocks and frames; or
of a filter on all trials of a folder.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.table import Table

from hnav.cli.completion import among
from hnav.cli.console import load_pages, say, show, working
from hnav.cli.parameters import Engine, Preset, Settings, Smooth, Strict, page_option, parse_settings
from hnav.cli.recordings import Reading
from hnav.cli.wanted import Wanted
from hnav.cli.words import UsageError
from hnav.filters.options import FILTERS
from hnav.io.outputs import refuse_overwriting, write_files
from hnav.io.trajectories import read_trajectory
from hnav.reports.comparison import ALIGN, Comparison, compare


def command(
    reference: Annotated[
        Path,
        typer.Argument(
            help="Reference: a table, a recording with a reference, TUM, EuRoC, KITTI; with --filter a folder of BROAD trials"
        ),
    ],
    others: Annotated[
        list[Path] | None, typer.Argument(help="One or more files to compare with it, such as tables of hnav filter")
    ] = None,
    align: Annotated[
        str,
        typer.Option(
            metavar="WHAT,...",
            help="clock: a constant offset of times; world, body: constant rotations; place: rotation and offset of positions; scale: "
            "their scale too",
            autocompletion=among(*ALIGN),
        ),
    ] = "",
    delta: Annotated[float, typer.Option(metavar="SECONDS", help="Interval of the relative errors")] = 1.0,
    begin: Annotated[float, typer.Option("--from", metavar="SECONDS", help="Leave out the first seconds of each file")] = 0.0,
    report: Annotated[Path | None, page_option("Page that overlays all files")] = None,
    json_file: Annotated[Path | None, typer.Option("--json", metavar="FILE", help="Also write the figures there")] = None,
    filter: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Of a folder: ahrs or hrekf, over all of its trials", autocompletion=among(*FILTERS)),
    ] = None,
    engine: Engine = "c",
    settings: Settings = None,
    preset: Preset = "default",
    crop: Annotated[float | None, typer.Option(metavar="SECONDS", help="With --filter: the first seconds of each trial")] = None,
    smooth: Smooth = False,
    strict: Strict = False,
) -> None:
    if filter is not None:
        if others or report is not None or align or begin:
            raise UsageError(f"--filter {filter}: of the trials of a folder: leave other files, --report, --align and --from out")
        from hnav.cli.trials import compare_trials

        wanted = Wanted(Reading(), filter, engine, parse_settings(settings), preset, strict=strict, smooth=smooth)
        compare_trials(reference, wanted, crop, json_file)
        return
    if settings or crop is not None or smooth or strict or (engine, preset) != ("c", "default"):
        raise UsageError(
            "--engine, --set, --preset, --crop, --smooth and --strict are of --filter NAME, over the trials of a folder"
        )
    if not others:
        raise UsageError(f"{reference}: name a file to compare with it; of a folder of BROAD trials give --filter ahrs")
    compare_files(reference, others, align, delta, begin, report, json_file)


def compare_files(
    reference: Path, others: list[Path], align: str, delta: float, begin: float, report: Path | None, json_file: Path | None
) -> None:
    """Prints the errors of each file. Raises HnavError."""
    refuse_overwriting([report, json_file], [reference, *others])
    load_pages(report)
    with working(f"{len(others)} against {reference.name}"):
        true, wanted = read_trajectory(reference), [part for part in align.split(",") if part]
        found = [compare(true, read_trajectory(other), wanted, delta, begin) for other in others]
    show(figures_table(found))
    for one in found:
        for name, result in one.found.items():
            say(f"{one.aligned.name}: {name}: {result}")
    if json_file:
        write_files({json_file: json.dumps(figures_of(found), indent=1) + "\n"})
    if report is not None:
        from hnav.reports.comparison_page import write_comparison

        write_comparison(found, report)
        say(str(report))


def figures_of(found: list[Comparison]) -> dict[str, dict[str, object]]:
    """Figures by file and quantity; unknown numbers are null."""
    return {
        one.aligned.name: {
            **{
                figure.name: {"unit": figure.unit, "rows": len(figure.values), "rms": figure.rms, "median": figure.median,
                              "worst": figure.worst, "nees": figure.nees if np.isfinite(figure.nees) else None}
                for figure in one.figures
            },
            "aligned": one.found,
        }
        for one in found
    }  # fmt: skip


def figures_table(found: list[Comparison]) -> Table:
    """A row for each file and quantity."""
    heads = ("file", "error", "rms", "median", "worst", "NEES / axis")
    table = Table(*heads, title=f"against {found[0].reference.name}", title_justify="left")
    for one in found:
        for figure in one.figures:
            sizes = (f"{value:.4g} {figure.unit}" for value in (figure.rms, figure.median, figure.worst))
            table.add_row(one.aligned.name, figure.name, *sizes, f"{figure.nees:.2f}" if np.isfinite(figure.nees) else "-")
        table.add_section()
    return table
