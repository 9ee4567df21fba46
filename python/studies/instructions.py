"""Instructions for each IMU sample with a field, counted by valgrind: they do not depend on what else the machine does.

    ./run study instructions                 of this checkout and of revision d7bc172, and the ratio
    ./run study instructions --only 'hrekf*' some of them

The first 20000 rows (70 s, 286 Hz) of BROAD trial 07 in one call of hnav_filter_run or hnav_filter_smooth, by the program of
studies.speed without the peers.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from fnmatch import fnmatch
from pathlib import Path
from typing import Annotated

import typer

from hnav.cli.console import say
from hnav.cli.words import UsageError
from hnav.places import CHECKOUT
from studies.command import Checkout, Rows
from studies.compare.revision import REVISION, built
from studies.counting import ROWS, has_valgrind, write_samples
from studies.speed.study import built_alone, instructions

WORK = CHECKOUT / ".cache" / "instructions"
TOLERANCE = 0.02  # of the old count; above it the study fails
# Names of studies/speed/own.cpp.
CASES = {
    "ahrs closed form, q": "ahrs:q:closed_form",
    "ahrs closed form, q and sigma": "ahrs:sigma:closed_form",
    "ahrs ERKStep, q": "ahrs:q",
    "ahrs ERKStep, q and sigma": "ahrs:sigma",
    "smoother closed form": "ahrs-smooth:q:closed_form",
    "smoother ERKStep": "ahrs-smooth:q",
    **{
        f"hrekf {label} gamma {mode}": f"hrekf:q{solver}:gamma={mode}"
        for label, solver in (("closed form", ":closed_form"), ("ERKStep", ""))
        for mode in ("off", "fixed", "relative", "kl")
    },
}


def command(
    only: Annotated[str, typer.Option(metavar="PATTERN", help="Cases whose names match, * and ? allowed")] = "*",
    rows: Rows = ROWS,
    old: Annotated[Path | None, typer.Option(metavar="FOLDER", help=f"A checkout with its build instead of {REVISION}")] = None,
    new: Checkout = CHECKOUT,
) -> None:
    """Instructions for each IMU sample, of two revisions."""
    if not has_valgrind():
        raise UsageError("valgrind is not here (apt-get install valgrind)")
    samples = WORK / "samples.bin"
    write_samples(samples, rows)
    sides = {"old": old.resolve() if old else built(REVISION), "new": new.resolve()}
    programs = [built_alone(checkout, WORK / label) for label, checkout in sides.items()]
    say(f"{'instructions for each sample':<34}{'old':>9}{'new':>9}{'ratio':>9}")
    worst = 0.0
    with ThreadPoolExecutor(2) as pool:
        for name, case in CASES.items():
            if not fnmatch(name, only):
                continue
            before, after = pool.map(lambda program, case=case: round(instructions(program, samples, rows, case)), programs)
            worst = max(worst, after / before)
            say(f"{name:<34}{before:>9}{after:>9}{after / before:>9.3f}")
    if worst > 1 + TOLERANCE:
        raise typer.Exit(1)
