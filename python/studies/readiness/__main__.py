"""The command: how many starts, by which filter, and the table of the groups."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.table import Table

from hnav.cli.console import bar, say, show
from hnav.cli.parameters import FilterName, Settings, parse_settings
from hnav.io.outputs import write_files
from studies.command import WORKERS, Seed, Workers, after, study
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
    csv_file: Annotated[Path | None, typer.Option("--csv", metavar="FILE", help="write a row for each start")] = None,
) -> None:
    """Simulates starts and tells how often a filter says `heading ready` while its attitude is wrong, and when."""
    done: list[Start] = []
    with bar() as progress:
        task = progress.add_task("starts", total=starts)
        for start in experiment(starts, filter, parse_settings(settings), seed, workers, hidden, every_error):
            done.append(start)
            progress.advance(task)
    title = (
        f"{filter}, seed {seed}: first instant of heading_ready in {DURATION_S:g} s; wrong: total error above 3 sigma and 5 deg"
    )
    show(table(done, title), width=180)
    if csv_file:
        write_csv(csv_file, done)
        say(str(csv_file))


def table(starts: Sequence[Start], title: str) -> Table:
    """A row for each group, after each disturbance all its motions together, at the end all starts."""
    out = Table(title=title, title_justify="left")
    for column in ("disturbance", "motion"):
        out.add_column(column, no_wrap=True)
    for column in (
        "starts",
        "wrong",
        "95 % interval",
        "in true field",
        "ready after: median",
        "95 %",
        "never",
        "error then: median",
        "heading z2 at " + ", ".join(f"{t_s:g}" for t_s in JUDGED_S) + " s",
    ):
        out.add_column(column, justify="right")

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


def write_csv(path: Path, starts: Sequence[Start]) -> None:
    """One row a start; empty cells where the filter never became ready. Raises OutputError."""
    names = [field.name for field in fields(Start) if field.name != "heading_z2"]
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow([*names, *(f"heading_z2_{t_s:g}_s" for t_s in JUDGED_S), "wrong"])
    for start in starts:
        values = (*(getattr(start, name) for name in names), *start.heading_z2)
        writer.writerow(
            [
                *("" if isinstance(v, float) and np.isnan(v) else f"{v:.6g}" if isinstance(v, float) else v for v in values),
                int(start.wrong),
            ]
        )
    write_files({path: file.getvalue()})


main = study("readiness", command)

if __name__ == "__main__":
    main()
