"""hnav report: one HTML page about a simulation, or about a recording and what a filter makes of it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hnav.cli.console import say
from hnav.cli.parameters import FilterName, Preset, Settings, parse_settings
from hnav.cli.words import UsageError
from hnav.io.outputs import refuse_overwriting


def command(
    source: Annotated[
        Path,
        typer.Argument(metavar="SOURCE", help="Folder that hnav simulate wrote, or a recording in the formats of hnav filter"),
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="HTML to write; default: DIR/report.html, or the recording's name with .html beside it"
        ),
    ] = None,
    pictures: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Of a simulation: also draw the main panels as PNG there")
    ] = None,
    filter: FilterName = "ahrs",
    settings: Settings = None,
    preset: Preset = "default",
    frame: Annotated[str, typer.Option(help="Of a recording: navigation frame, ned or enu")] = "ned",
    mag_unit: Annotated[str | None, typer.Option(help="Of a recording whose file does not say: T, uT, G or au")] = None,
    open: Annotated[bool, typer.Option("--open", help="Show it in the browser")] = False,
) -> None:
    if source.is_dir():
        file = out or source / "report.html"
        of_simulation(source, file, pictures)
    else:
        if pictures is not None:
            raise UsageError("--pictures: a recording has none; hnav demo FILE draws one")
        file = out or source.with_suffix(".html")
        of_recording(source, file, filter, {"navigation_frame": frame} | parse_settings(settings), preset, mag_unit)
    if open:
        typer.launch(str(file))


def of_recording(source: Path, file: Path, filter: str, settings: dict[str, str], preset: str, mag_unit: str | None) -> None:
    """The page about a recording."""
    # What a page about a recording needs is not needed for one about a simulation, and takes a while to load.
    from hnav.fmi.engines import run_recording
    from hnav.io.readers import read
    from hnav.reports.recording_page import write_recording_report
    from hnav.reports.recording_run import recording_run

    refuse_overwriting([file], [source])
    data = read(source, mag_unit=mag_unit)
    panels = write_recording_report(recording_run(run_recording(data, filter, "c", settings, preset, gates=True), data), file)
    say(f"{file} ({file.stat().st_size / 1e6:.1f} MB): {', '.join(panels)}")


def of_simulation(folder: Path, file: Path, pictures: Path | None) -> None:
    """The page about a simulation, and pictures of it."""
    from hnav.reports.page import write_report
    from hnav.systems.simulation import ABOUT, CERTIFICATE, SIGNALS, read_run

    inputs = [folder / name for name in (SIGNALS, ABOUT, CERTIFICATE)]
    for output in (file, *(pictures.glob("*.png") if pictures else ())):
        refuse_overwriting([output], inputs)
    run = read_run(folder)
    panels = write_report(run, file)
    say(f"{file} ({file.stat().st_size / 1e6:.1f} MB): {', '.join(panels)}")
    if pictures is not None:
        # Matplotlib takes a while to load.
        from hnav.reports.pictures import write_pictures

        for picture in write_pictures(run, pictures):
            say(str(picture))
