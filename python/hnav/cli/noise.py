"""hnav noise: the noise of a sensor from recordings at rest, as figures of a datasheet."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.table import Table

from hnav.cli.console import load_pages, say, show, working, written
from hnav.cli.parameters import page_option, with_groups
from hnav.cli.recordings import Reading
from hnav.filters.noise import ENTRIES, SensorNoise, figures, noise_of
from hnav.io.outputs import refuse_overwriting
from hnav.io.sensors import write_sensor


@with_groups
def command(
    recordings: Annotated[
        list[Path],
        typer.Argument(help="Recordings of one device that lies still, some minutes to a night, in the formats of hnav filter"),
    ],
    out: Annotated[
        Path | None, typer.Option(metavar="FILE.json", help="Sensor file to write the figures into, in units of datasheets")
    ] = None,
    report: Annotated[Path | None, page_option("Page with the Allan deviation of each axis")] = None,
    name: Annotated[str | None, typer.Option(help="Of the sensor, in a new file; default: that of the recording")] = None,
    *,
    reading: Reading,
) -> None:
    refuse_overwriting([out, report], recordings)
    load_pages(report)
    with working(f"{len(recordings)} recordings"):
        found = noise_of([reading.read(path) for path in recordings])
    called = name or recordings[0].stem
    show(figures_table(found, called))
    for line in untold(found):
        say(line)
    if out is not None:
        write_sensor(out, figures(found), called, "Allan deviation of recordings at rest, by hnav noise.")
    if report is not None:
        from hnav.reports.noise_page import write_noise_report

        write_noise_report(found, called, report)
    if files := written(out, report):
        say(files)


def figures_table(found: dict[str, SensorNoise], title: str) -> Table:
    """A row for each sensor and figure, its axes side by side; < if the recordings give an upper limit only."""
    table = Table("sensor", "figure", "x", "y", "z", "95 % of x", "unit", title=title, title_justify="left")
    for sensor, noise in found.items():
        for term, (entry, unit, si) in ENTRIES[sensor].items():
            of = noise.terms[term]
            axes = [f"{of.value[i] / si:.3g}" if of.is_measured[i] else f"< {of.high[i] / si:.3g}" for i in range(3)]
            table.add_row(sensor, entry.replace("_", " "), *axes, f"{of.low[0] / si:.3g} to {of.high[0] / si:.3g}", unit)
        table.add_section()
    return table


def untold(found: dict[str, SensorNoise]) -> list[str]:
    """Notes on figures for which the recordings are too short."""
    lines = []
    for sensor, noise in found.items():
        missing = [entry.replace("_", " ") for term, (entry, _, _) in ENTRIES[sensor].items() if np.isnan(noise.terms[term].mean)]
        still = f"{sensor}: {noise.length_s:.4g} s at rest at {noise.rate_hz:.4g} Hz, tau to {noise.tau_s[-1]:.3g} s"
        short = f": too short for the {' and '.join(missing)} of each axis, of which < is an upper limit" if missing else ""
        lines.append(still + short)
    return lines
