"""Time and instructions of a sample of the navigation filter: 37 errors, 10 numbers that flow, 100 Hz, five fixes a second.

    ./run study ins_speed

A simulated car from its start on, any heading, industrial sensors. CPU time is that of the thread, rounds of the integrators interleave;
instructions are counted where valgrind is.
"""

from __future__ import annotations

import statistics
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
import typer
from rich.table import Table

from hnav.cli.console import say, show
from hnav.places import CHECKOUT
from studies.command import titled_table
from studies.counting import compile_program, counted, has_valgrind, times_ns
from studies.ins.vehicles import vehicle

WORK = CHECKOUT / ".cache" / "ins_speed"
ROUNDS = 10
SOLVERS = {"closed form": 2, "ERKStep": 0}  # as hnav_solver numbers them


class Drive(NamedTuple):
    """What the program is given: file, samples of rate and force, fixes."""

    file: Path
    rows: int
    aids: int


def write_drive(file: Path, seconds: float) -> Drive:
    samples, _ = vehicle("car", "industrial", 7, seconds)
    valid, _, sensor, value = samples.aids.arrays()
    arrays = (samples.t_s, samples.rate_b_rad_s, samples.force_b_m_s2, valid, sensor, value)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(b"".join(np.ascontiguousarray(a, float).tobytes() for a in arrays))
    return Drive(file, len(samples.t_s), len(valid))


def built(program: Path) -> Path:
    """The program, linked with the library of this checkout."""
    return compile_program([Path(__file__).with_suffix(".cpp")], program, CHECKOUT)


def words(program: Path, drive: Drive, solver: int, every: int, runs: int) -> list[str]:
    return [str(word) for word in (program, *drive, solver, every, runs)]


def table_of(program: Path, drive: Drive) -> Table:
    """A row for each integrator and choice of answers."""
    answers = {"the last estimate": drive.rows, "every estimate, with its sigmas": 1}
    cases = {(gives, label): (solver, every) for gives, every in answers.items() for label, solver in SOLVERS.items()}
    times: dict[tuple[str, str], list[float]] = {case: [] for case in cases}
    for _ in range(ROUNDS):
        for case, (solver, every) in cases.items():
            times[case] += times_ns(words(program, drive, solver, every, 1))
    table = titled_table("", "gives | integrator", "instructions | us of CPU, least | median")
    for (gives, label), (solver, every) in cases.items():
        count = counted("timed_run", words(program, drive, solver, every, 1)) / drive.rows if has_valgrind() else None
        us = [time / 1e3 for time in times[gives, label]]
        table.add_row(gives, label, "-" if count is None else f"{count:.0f}", f"{min(us):.2f}", f"{statistics.median(us):.2f}")
    return table


def command(seconds: Annotated[float, typer.Option(min=60, help="Of the drive, from its start on")] = 150.0) -> None:
    """Instructions and CPU time of a sample of the navigation filter, by the closed form and by ERKStep."""
    drive = write_drive(WORK / "drive.bin", seconds)
    show(table_of(built(WORK / "timing"), drive))
    say(f"of a sample of rate and force, over {drive.rows} of them and {drive.aids} fixes")
