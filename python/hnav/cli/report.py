"""hnav report: one HTML page about a simulation, and pictures of it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hnav.cli.console import say
from hnav.io.outputs import refuse_overwriting
from hnav.reports.page import write_report
from hnav.systems.simulation import ABOUT, CERTIFICATE, SIGNALS, read_run


def command(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder that hnav simulate wrote")],
    out: Annotated[Path | None, typer.Option(metavar="FILE", help="HTML to write; default: DIR/report.html")] = None,
    pictures: Annotated[Path | None, typer.Option(metavar="DIR", help="Also draw the main panels as PNG there")] = None,
    open: Annotated[bool, typer.Option("--open", help="Show it in the browser")] = False,
) -> None:
    file, inputs = out or folder / "report.html", [folder / name for name in (SIGNALS, ABOUT, CERTIFICATE)]
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
    if open:
        typer.launch(str(file))
