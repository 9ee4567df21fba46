"""The command: which pictures, from what, and where they go."""

from __future__ import annotations

import io
import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer
from PIL import Image

from hnav.cli.console import say
from hnav.cli.words import UsageError
from hnav.io.outputs import writing
from hnav.io.readers import read
from hnav.io.readers.broad import find_trials
from hnav.places import CHECKOUT
from hnav.reports import plots
from hnav.reports.attitude_panels import error_panel
from hnav.reports.flight_panels import estimates_of
from hnav.reports.flights import channels
from hnav.reports.pictures import picture_of
from hnav.systems.simulation import simulate
from studies.bench.contenders import DEFAULT_FILTERS, DEFAULT_PEERS, contenders
from studies.bench.picture import draw_benchmark
from studies.bench.rows import benchmark, summary
from studies.command import check_choices
from studies.pictures.circle import draw_circle
from studies.pictures.hybrid import draw_hybrid
from studies.pictures.overview import draw_overview
from studies.pictures.page import draw_page

# Typical runs, not the best: of the first 11 flights the one whose ratio of errors, augmented to amdkf, is in the middle,
# and of the first 9 turntables the one whose error is.
AIRCRAFT, AIRCRAFT_SEED = "aircraft_longitudinal", 3
TURNTABLE_SCENARIO, TURNTABLE_SEED = "magnetic_disturbance", 7
Picture = plots.Figure | Image.Image


def draw_bench(broad: Path) -> plots.Figure:
    """Errors of all filters on the trials as they are; times are left to the table, for they are the machine's."""
    entered, _ = contenders(DEFAULT_FILTERS, DEFAULT_PEERS)
    recordings = [read(path) for path in find_trials(broad).values()]
    rows = [row for rows in benchmark(recordings, entered, ["BROAD"]) for row in rows]
    return draw_benchmark([line for line in summary(rows) if line.trials], entered, times=False)


def draw_report() -> plots.Figure:
    """The errors of the turntable's filters in their bands, the field false for a while."""
    run = simulate("turntable", scenario=TURNTABLE_SCENARIO, seed=TURNTABLE_SEED)
    recommended_first = {**run.about, "components": sorted(run.components, key=lambda name: name != "ahrs")}
    run = replace(run, about=recommended_first)
    return picture_of(error_panel.draw(run), run, width_px=1000)


def draw_aircraft() -> plots.Figure:
    """A flight with a fault: the first channel with it and the first without."""
    run = simulate("aircraft", seed=AIRCRAFT_SEED)
    flight = [channel for channel in channels(run) if channel.aircraft == AIRCRAFT]
    faulty, healthy = ([c for c in flight if c.fault.any() == fault] for fault in (True, False))
    return picture_of(estimates_of([faulty[0], healthy[0]]), run)


FROM_RECORDINGS: dict[str, Callable[[Path], Picture]]
FROM_RECORDINGS = {"overview": draw_overview, "page": draw_page, "hybrid": draw_hybrid, "bench": draw_bench}
FROM_SYSTEMS: dict[str, Callable[[], Picture]] = {"report": draw_report, "aircraft": draw_aircraft, "circle": draw_circle}
NAMES = (*FROM_RECORDINGS, *FROM_SYSTEMS)


def command(
    names: Annotated[list[str] | None, typer.Argument(metavar="[NAME]...", help=", ".join(NAMES))] = None,
    broad: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder with the trials of the BROAD data set; default: BROAD_DIR")
    ] = None,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the PNG files")] = CHECKOUT / "docs" / "images",
) -> None:
    """Draws the pictures of README and docs."""
    check_choices("there is no picture", names or (), NAMES)
    folder = broad or (Path(os.environ["BROAD_DIR"]) if os.environ.get("BROAD_DIR") else None)
    for name in names or NAMES:
        if name in FROM_SYSTEMS:
            save_small(FROM_SYSTEMS[name](), out / f"{name}.png")
        elif folder is not None:
            save_small(FROM_RECORDINGS[name](folder), out / f"{name}.png")
        elif names:
            raise UsageError(f"{name} is drawn from recordings: set BROAD_DIR, or name their folder by --broad")
        else:
            say(f"{name} is left out: BROAD_DIR is not set")


def save_small(picture: Picture, path: Path) -> None:
    """Writes a PNG with a palette of 256 colours: a third of the size, and no eye sees the difference."""
    if isinstance(picture, plots.Figure):
        full = io.BytesIO()
        picture.savefig(full, format="png")
        picture = Image.open(full)
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        picture.convert("RGB").quantize(256, dither=Image.Dither.NONE).save(path, optimize=True)
    say(f"{path} ({path.stat().st_size / 1000:.0f} kB)")
