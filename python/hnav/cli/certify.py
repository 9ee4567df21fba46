"""hnav certify: the stability certificate of a run as a table, a file and a picture."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer
from rich.progress import Progress, TaskID
from rich.table import Table

from hnav.certify.run import Thinning, certify_run, write_certificate
from hnav.certify.summary import certificate_rows
from hnav.cli.console import bar, say, show
from hnav.cli.parameters import FilterName, MagUnit, Settings, parse_settings
from hnav.cli.words import UsageError
from hnav.io.outputs import refuse_overwriting
from hnav.systems.simulation import ABOUT, SIGNALS


def shown_in(bars: Progress) -> Callable[[str, int, int], None]:
    """A progress bar for each stage, started at the first report of the stage."""
    tasks: dict[str, TaskID] = {}

    def note(what: str, done: int, of: int) -> None:
        if what not in tasks:
            tasks[what] = bars.add_task(what, total=of)
        bars.update(tasks[what], completed=done)

    return note


def command(
    recording: Annotated[
        Path | None,
        typer.Argument(
            metavar="[RECORDING]", help="Recording in the formats of hnav filter, or a folder of results with signals.h5"
        ),
    ] = None,
    experiment: Annotated[str | None, typer.Option(help="turntable: the paper's experiment instead of a recording")] = None,
    filter: FilterName = "hrekf",
    settings: Settings = None,
    preset: Annotated[
        str | None, typer.Option(help="default or paper; without it a folder is certified with the filter that was simulated")
    ] = None,
    begin: Annotated[
        float, typer.Option("--from", metavar="SECONDS", help="Leave out the corrections before, while the gains settle")
    ] = 15.0,
    duration: Annotated[
        float | None, typer.Option(metavar="SECONDS", help="Use the first seconds only; the experiment lasts 40 s")
    ] = None,
    seed: Annotated[int, typer.Option(help="Of the experiment and of the starts on the boundary")] = 5,
    gain_factor: Annotated[
        float, typer.Option(help="Certify the gains multiplied by this: a wrong sequence must be refused")
    ] = 1.0,
    force_every: Annotated[int, typer.Option(metavar="N", help="Keep every Nth sample of the force only")] = 1,
    field_every: Annotated[int, typer.Option(metavar="N", help="Keep every Nth sample of the field only")] = 1,
    lost: Annotated[float, typer.Option(metavar="SHARE", help="Lose this share of the samples of force and field")] = 0.0,
    out: Annotated[Path | None, typer.Option(metavar="FILE.json", help="Write the figures there")] = None,
    picture: Annotated[Path | None, typer.Option(metavar="FILE.png", help="Draw Lyapunov value and decay")] = None,
    mag_unit: MagUnit = None,
) -> None:
    if (recording is None) == (experiment is None):
        raise UsageError("name a recording or --experiment turntable, one of them")
    if filter != "hrekf":
        raise UsageError(f"--filter {filter}: the certificate is of hrekf, whose gains the theorem is about")
    if recording is not None:
        refuse_overwriting([out, picture], [recording, recording / SIGNALS, recording / ABOUT])
    with bar() as progress:
        found = certify_run(
            recording, experiment, preset=preset, settings=parse_settings(settings), begin_s=begin, duration_s=duration,
            seed=seed, gain_factor=gain_factor, mag_unit=mag_unit, thinning=Thinning(force_every, field_every, lost),
            progress=shown_in(progress), announce=lambda seconds: say(f"the search takes about {seconds:.2g} s on this machine"),
        )  # fmt: skip
    if out is not None:
        write_certificate(out, found)
    if picture is not None:
        # Matplotlib takes a while to load.
        from hnav.reports.certificate_picture import draw_certificate
        from hnav.reports.plots import save

        save(draw_certificate(found), picture)
    table = Table("", "value", "meaning", title=found.name, show_header=False)
    for row in certificate_rows(found):
        table.add_row(*row)
    show(table)
    say("certified" if found.certified else f"not certified: {found.reason}")
