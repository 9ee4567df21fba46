"""The command: how many starts, by which filter, and the table of the groups."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.table import Table

from hnav.cli.console import say, show
from hnav.cli.parameters import FilterName, Settings, parse_settings
from studies.command import WORKERS, Seed, Workers, after, titled_table, tracked, write_rows
from studies.readiness.experiment import JUDGED_S, Start, experiment, figures
from studies.readiness.starts import DISTURBANCES, DURATION_S, HIDDEN, MOTIONS


def command(
    starts: Annotated[int, typer.Option(min=1, help="how many starts; groups take turns")] = 1000,
    filter: FilterName = "ahrs",
    settings: Settings = None,
    workers: Workers = WORKERS,
    seed: Seed = 1,
    hidden: Annotated[bool, typer.Option("--hidden", help="fields that are false in a way that no filter can know")] = False,
    every_error: Annotated[
        bool, typer.Option("--every-error", help="sensors with the errors too that the options allow for")
    ] = False,
    place: Annotated[
        bool, typer.Option("--place", help="the filter is given strength and dip of the earth's field, as for a place and a date")
    ] = False,
    csv_file: Annotated[Path | None, typer.Option("--csv", metavar="FILE", help="write a row for each start")] = None,
) -> None:
    """Simulates starts and prints how often, and when, a filter reports `heading ready` while its attitude is wrong."""
    trials = experiment(starts, filter, parse_settings(settings), seed, workers, hidden, every_error, place)
    done = list(tracked(trials, "starts", starts))
    title = (
        f"{filter}, seed {seed}: first instant of heading_ready in {DURATION_S:g} s; wrong: total error above 3 sigma and 5 deg"
    )
    show(table(done, title), width=180)
    if csv_file:
        write_rows(csv_file, map(row_of, done))
        say(str(csv_file))


def table(starts: Sequence[Start], title: str) -> Table:
    """A row for each group, after each disturbance all its motions together, at the end all starts."""
    columns = "starts | wrong | 95 % interval | in true field | ready after: median | 95 % | never | error then: median"
    judged = ", ".join(f"{t_s:g}" for t_s in JUDGED_S)
    out = titled_table(title, "disturbance | motion", f"{columns} | heading z2 at {judged} s")

    def add(disturbance: str, motion: str, group: Sequence[Start], style: str | None = None) -> None:
        if not group:
            return
        f = figures(group)
        out.add_row(
            disturbance, motion, str(f.starts), f"{f.wrong_share:.1%}", f"{f.wrong_low:.1%} to {f.wrong_high:.1%}", f"{f.wrong_in_true_field_share:.1%}",
            after(f.median_s), after(f.late_s), f"{f.never_share:.1%}", "" if np.isnan(f.median_error_deg) else f"{f.median_error_deg:.1f} deg",
            ", ".join(f"{z2:.2g}" for z2 in f.heading_z2), style=style,
        )  # fmt: skip

    for disturbance in DISTURBANCES | HIDDEN:
        for motion in MOTIONS:
            add(disturbance, motion, [s for s in starts if (s.disturbance, s.motion) == (disturbance, motion)])
        add(disturbance, "all", [s for s in starts if s.disturbance == disturbance], "bold")
        out.add_section()
    add("all", "all", starts, "bold")
    return out


def row_of(start: Start) -> dict[str, object]:
    """Of the CSV."""
    values = {name: value for name, value in vars(start).items() if name != "heading_z2"}
    return values | {f"heading_z2_{t_s:g}_s": z2 for t_s, z2 in zip(JUDGED_S, start.heading_z2)} | {"wrong": start.wrong}
