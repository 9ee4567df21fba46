"""The command: which filters, on which sets, and where the rows and the picture go."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.table import Table

from hnav.cli.console import bar, say, show
from hnav.cli.words import UsageError
from hnav.io.readers import read
from hnav.io.readers.broad import find_trials
from studies.bench.contenders import DEFAULT_FILTERS, DEFAULT_PEERS, Contender, contenders
from studies.bench.motions import MOTION, motions
from studies.bench.peers import PEERS
from studies.bench.picture import draw_benchmark
from studies.bench.rows import HONESTY, WRONG_HEADING_DEG, WRONG_TILT_DEG, Row, benchmark, benchmark_motions, summary
from studies.bench.stress import SETS, variant_count
from studies.command import Trials, check_choices, draw_into, write_rows

ERRORS = ("total_deg", "heading_deg", "inclination_deg", "undisturbed_deg", "disturbed_deg")
DRAWN = "BROAD"


def command(
    folder: Trials = None,
    filters: Annotated[
        str,
        typer.Option(
            help="Filters of hnav: NAME, NAME-smooth, NAME:option=value; body=own, sensor=own, speed=own: what each was recorded on and with; separated by commas"
        ),
    ] = ",".join(DEFAULT_FILTERS),
    peers: Annotated[str, typer.Option(help=f"Filters by others: {', '.join(PEERS)}; all, or none")] = ",".join(DEFAULT_PEERS),
    sets: Annotated[
        str, typer.Option(help="The trials as they are, and made harder: python -m pydoc studies.bench.stress")
    ] = ",".join(SETS),
    seeds: Annotated[
        str, typer.Option(metavar="FIRST-LAST", help=f"Simulated recordings of each kind in the set {MOTION}")
    ] = "0-7",
    csv_file: Annotated[
        Path | None, typer.Option("--csv", metavar="FILE", help="Write a row for each set, filter and trial")
    ] = None,
    picture: Annotated[Path | None, typer.Option(metavar="FILE", help=f"Draw error and time of the set {DRAWN}")] = None,
    repeat: Annotated[int, typer.Option(min=1, help="Runs for the time per sample")] = 1,
) -> None:
    names = split(sets)
    check_sets(names, picture)
    entered, missing = contenders(split(filters), list(PEERS) if peers == "all" else [] if peers == "none" else split(peers))
    if not entered:
        raise UsageError("no filter to run: name some in --filters or --peers")
    rows = run(names, folder, seeds, entered, repeat)
    lines, ours = summary(rows), {contender.name for contender in entered if contender.ours}
    show(benchmark_table(lines, ours))
    if stated := [line for line in lines if not np.isnan(line.tilt_z2)]:
        show(honesty_table(stated))
    for text in [*missing, *findings(rows)]:
        say(text)
    write_rows(csv_file, map(vars, rows))
    draw_into(picture, partial(drawn, entered=entered), rows)


def run(names: Sequence[str], folder: Path | None, seeds: str, entered: Sequence[Contender], repeat: int) -> list[Row]:
    """The rows of all sets, with a bar. Raises UsageError where a set has no folder or no seeds."""
    recorded = [name for name in names if name != MOTION]
    recordings = [read(path) for path in find_trials(named_folder(folder)).values()] if recorded else []
    simulated = motions(parse_seeds(seeds)) if MOTION in names else []
    rows: list[Row] = []
    with bar() as progress:
        task = progress.add_task("trials", total=sum(variant_count(name, len(recordings)) for name in recorded) + len(simulated))
        for done in chain(benchmark(recordings, entered, recorded, repeat), benchmark_motions(simulated, entered, repeat)):
            rows += done
            progress.update(task, advance=1, description=f"{done[0].set:7}")
    return rows


def split(names: str) -> list[str]:
    return [name.strip() for name in names.split(",") if name.strip()]


def check_sets(names: Sequence[str], picture: Path | None) -> None:
    if not names:
        raise UsageError(f"--sets names none: choose from {', '.join(SETS)}")
    check_choices("set", names, (*SETS, MOTION))
    if picture and DRAWN not in names:
        raise UsageError(f"--picture shows the set {DRAWN}: name it in --sets")


def named_folder(folder: Path | None) -> Path:
    if folder is None:
        raise UsageError(f"no folder with BROAD trials: name it as DIR or in BROAD_DIR; only --sets {MOTION} needs none")
    return folder


def parse_seeds(seeds: str) -> range:
    first, _, last = seeds.partition("-")
    if not (first.isdecimal() and last.isdecimal() and int(first) <= int(last)):
        raise UsageError(f"--seeds {seeds}: expected FIRST-LAST, as 0-7")
    return range(int(first), int(last) + 1)


def findings(rows: Sequence[Row]) -> list[str]:
    """What went wrong, a line each."""
    failed = [f"failed: {row.set}, {row.filter}, {row.trial}: {row.failure}" for row in rows if row.failure]
    gaps = [row for row in rows if row.missing and not row.failure]
    return failed + [f"{row.set}, {row.filter}, {row.trial}: {row.missing} scored samples without an estimate" for row in gaps]


def benchmark_table(lines: Sequence[Any], ours: set[str]) -> Table:
    """A section for each set; the best of each column in bold, ours in colour."""
    table = Table(title="RMSE in deg over the scored phase, plain mean over trials; time per IMU sample, median")
    heads = ("set", "filter", "total", "heading", "inclination", "undisturbed", "disturbed", "NEES/3", "us/sample", "trials")
    for head in heads:
        table.add_column(head, justify="left" if head in ("set", "filter") else "right", no_wrap=True)
    for name in dict.fromkeys(line.set for line in lines):
        group = [line for line in lines if line.set == name]
        for i, line in enumerate(group):
            trials = f"{line.trials}" + (f", {line.failures} failed" if line.failures else "")
            style = "cyan" if line.filter in ours else None
            table.add_row(name if i == 0 else "", line.filter, *_cells(line, group), trials, style=style)
        table.add_section()
    return table


def honesty_table(lines: Sequence[Any]) -> Table:
    """Whether sigma and readiness of the tilt and the heading are true."""
    off = f"{WRONG_TILT_DEG:g} deg of tilt, {WRONG_HEADING_DEG:g} deg of heading"
    table = Table(title=f"z2: mean (error / sigma)^2; shares of the time: ready, and ready while off by more than {off}")
    for head in ("set", "filter", "tilt z2", "tilt ready", "and off", "heading ready", "and off"):
        table.add_column(head, justify="left" if head in ("set", "filter") else "right", no_wrap=True)
    for line in lines:
        table.add_row(line.set, line.filter, f"{line.tilt_z2:.2f}", *(f"{getattr(line, name):.3f}" for name in HONESTY[1:]))
    return table


def _cells(line: Any, group: Sequence[Any]) -> list[str]:
    """The figures of a line, with the best of the group in bold."""
    cells = []
    for name in (*ERRORS, "nees_per_axis", "us_per_sample"):
        value = getattr(line, name)
        text = "-" if np.isnan(value) else f"{value:.2f}"
        rivals = [getattr(other, name) for other in group]
        best = name != "nees_per_axis" and not np.isnan(value) and value == np.nanmin(rivals)
        cells.append(f"[bold]{text}[/bold]" if best else text)
    return cells


def drawn(rows: Sequence[Row], entered: Sequence[Contender]) -> Any:
    lines = [line for line in summary(rows) if line.set == DRAWN and line.trials]
    if not lines:
        raise UsageError("--picture: no filter finished a trial")
    return draw_benchmark(lines, entered)
