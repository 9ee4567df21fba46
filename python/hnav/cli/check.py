"""hnav check: format and units of a recording, and its implausible properties."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hnav.cli.console import say
from hnav.cli.parameters import with_groups
from hnav.cli.recordings import Reading, lines_of
from hnav.cli.wanted import Choice
from hnav.cli.words import with_options
from hnav.filters.ins_recording import with_aids
from hnav.filters.options import Options
from hnav.io.plausibility import LEVELS, NOTED
from hnav.io.plausible_aids import check_aids
from hnav.io.readers.aids import NO_POSITIONS

IMPLAUSIBLE = 1  # exit code


@with_groups
def command(
    recording: Annotated[Path, typer.Argument(help="Recording in the formats of hnav filter")],
    *,
    choice: Choice,
    reading: Reading,
    gnss: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Satellites, pressure or wheels in a file of their own, as of hnav filter")
    ] = None,
) -> None:
    wanted = choice.wanted(reading)
    reading, corrected = wanted.reading, wanted.corrected()
    frame = {"navigation_frame": wanted.frame} if wanted.frame else {}
    Options(wanted.filter, wanted.preset, **{**frame, **wanted.settings})  # refuses what hnav filter refuses
    data = with_aids(reading.beside(gnss).read(recording), reading.read_aids(gnss))
    data = data if corrected is None else corrected(data)
    say(repr(data))
    for note in data.origin.notes if data.origin else ():
        if not note.startswith((*NOTED, NO_POSITIONS)):  # those are among the findings
            say(with_options(note))
    findings = sorted([*reading.check(data), *check_aids(data)], key=lambda finding: LEVELS.index(finding.level))
    for line in lines_of(findings):
        say(line)
    if any(finding.level != "note" for finding in findings):
        raise typer.Exit(IMPLAUSIBLE)
    say("plausible")
