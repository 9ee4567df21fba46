"""hnav report: one HTML page about a simulation, about many of them, or about a recording and its estimate."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hnav.cli.console import load_pages, say
from hnav.cli.filter import filter_one
from hnav.cli.parameters import Force, Gnss, Smooth, Strict, page_option, with_groups
from hnav.cli.recordings import Reading
from hnav.cli.wanted import Choice
from hnav.cli.words import UsageError
from hnav.errors import HnavError
from hnav.io.outputs import refuse_overwriting
from hnav.io.readers.formats import reader_of

KEYS = {"scenario", "seed", "filter", "failure"}
"""Columns of every table of hnav montecarlo."""


@with_groups
def command(
    source: Annotated[
        Path,
        typer.Argument(
            metavar="SOURCE",
            help="Folder that hnav simulate wrote, table that hnav montecarlo wrote, or a recording in the formats of hnav filter",
        ),
    ],
    out: Annotated[
        Path | None, page_option("Page to write; default: DIR/report.html, or the recording's name with .html beside it")
    ] = None,
    pictures: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Of a simulation: also draw the main panels as PNG there")
    ] = None,
    *,
    choice: Choice,
    reading: Reading,
    strict: Strict = False,
    force: Force = False,
    smooth: Smooth = False,
    gnss: Gnss = None,
    open: Annotated[bool, typer.Option("--open", help="Show it in the browser")] = False,
) -> None:
    if is_simulation(source):
        file = out or source / "report.html"
        of_simulation(source, file, pictures)
    elif is_montecarlo(source):
        file = out or beside(source, ".html")
        of_montecarlo(source, file)
    else:
        if pictures is not None:
            raise UsageError("--pictures: of a simulation only; of a recording, Run.plot draws one in Python")
        file = out or beside(source, ".html")
        filter_one(source, None, file, choice.wanted(reading, strict=strict, force=force, smooth=smooth, gnss=gnss))
    if open:
        typer.launch(str(file))


def beside(source: Path, suffix: str) -> Path:
    """The file beside a file or folder with its name and another suffix, also for `.` and `..`."""
    return (source if source.name not in ("", "..") else source.resolve()).with_suffix(suffix)


def is_simulation(source: Path) -> bool:
    """Whether it is a folder of a simulation, complete or not; a folder that is not a recording counts as one."""
    if not source.is_dir() or (source / "run.json").exists() or (source / "signals.h5").exists():
        return source.is_dir()
    try:
        reader_of(source, None)
    except HnavError:
        return True
    return False


def is_montecarlo(source: Path) -> bool:
    """Whether it is a table of runs."""
    try:
        with source.open("rb") as file:
            if file.read(4) != b"PAR1":
                return False
        import pyarrow.parquet  # takes a while to load
    except (OSError, ImportError):
        return False
    return set(pyarrow.parquet.read_schema(source).names) >= KEYS


def of_montecarlo(source: Path, file: Path) -> None:
    """The page about a table of runs."""
    load_pages(file)
    from hnav.reports.montecarlo_page import write_montecarlo_report

    refuse_overwriting([file], [source])
    say_page(file, write_montecarlo_report(source, file))


def say_page(file: Path, panels: list[str]) -> None:
    """Prints the path of the page and its panels."""
    say(f"{file} ({file.stat().st_size / 1e6:.1f} MB): {', '.join(panels)}")


def of_simulation(folder: Path, file: Path, pictures: Path | None) -> None:
    """The page about a simulation, and pictures of it."""
    from hnav.reports.page import write_report
    from hnav.systems.simulation import ABOUT, CERTIFICATE, SIGNALS, read_run

    inputs = [folder / name for name in (SIGNALS, ABOUT, CERTIFICATE)]
    for output in (file, *(pictures.glob("*.png") if pictures else ())):
        refuse_overwriting([output], inputs)
    run = read_run(folder)
    say_page(file, write_report(run, file))
    if pictures is not None:
        # Matplotlib takes a while to load.
        from hnav.reports.pictures import write_pictures

        for picture in write_pictures(run, pictures):
            say(str(picture))
