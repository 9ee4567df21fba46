"""hnav check: what a recording was taken for, and what is not plausible in it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hnav.cli.console import say
from hnav.cli.parameters import (
    AccelUnit,
    Axes,
    Columns,
    DropRepeats,
    Format,
    GyroUnit,
    Hemisphere,
    MagUnit,
    Rate,
    TimeUnit,
)
from hnav.cli.recordings import lines_of, read_told
from hnav.cli.words import with_options

IMPLAUSIBLE = 1  # exit code


def command(
    recording: Annotated[Path, typer.Argument(help="Recording in the formats of hnav filter")],
    format: Format = None,
    columns: Columns = None,
    gyro_unit: GyroUnit = None,
    accel_unit: AccelUnit = None,
    mag_unit: MagUnit = None,
    time_unit: TimeUnit = None,
    rate_hz: Rate = None,
    axes: Axes = None,
    drop_repeats: DropRepeats = False,
    hemisphere: Hemisphere = None,
) -> None:
    options = {
        "format": format, "columns": columns, "gyro_unit": gyro_unit, "accel_unit": accel_unit, "mag_unit": mag_unit,
        "time_unit": time_unit, "rate_hz": rate_hz, "axes": axes, "drop_repeats": drop_repeats,
    }  # fmt: skip
    data = read_told(recording, options)
    say(repr(data))
    for note in data.origin.notes if data.origin else ():
        say(with_options(note))
    findings = data.check(hemisphere)
    for line in lines_of(findings):
        say(line)
    if any(finding.level != "note" for finding in findings):
        raise typer.Exit(IMPLAUSIBLE)
    say("plausible")
