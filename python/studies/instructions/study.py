"""Builds the driver for each side and runs it under callgrind."""

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
from studies.counting import ROWS, counted, has_valgrind, write_samples
from studies.processes import said_by

WORK = CHECKOUT / ".cache" / "instructions"
TOLERANCE = 0.02  # of the old count; above it the study fails
# Filter, call, outputs, choices.
CASES = {
    "ahrs closed form, q": ("ahrs", "run", "q", "solver=closed_form"),
    "ahrs closed form, q and sigma": ("ahrs", "run", "sigma", "solver=closed_form"),
    "ahrs ERKStep, q": ("ahrs", "run", "q"),
    "ahrs ERKStep, q and sigma": ("ahrs", "run", "sigma"),
    "smoother closed form": ("ahrs", "smooth", "q", "solver=closed_form"),
    "smoother ERKStep": ("ahrs", "smooth", "q"),
    **{
        f"hrekf {label} gamma {mode}": ("hrekf", "run", "q", f"solver={solver}", f"gamma_mode={mode}")
        for label, solver in (("closed form", "closed_form"), ("ERKStep", "erkstep"))
        for mode in ("off", "fixed", "relative", "kl")
    },
}


def driver_of(checkout: Path, label: str) -> Path:
    """A checkout's own driver, linked with its library."""
    folder, program = checkout / "build/c_src", WORK / f"driver_{label}"
    WORK.mkdir(parents=True, exist_ok=True)
    source = checkout / "python/studies/instructions/driver.c"
    command: list[str | Path] = ["cc", "-O2", "-DSIZED", "-o", program, source, "-I", checkout / "c_src/include"]
    said_by([*command, "-L", folder, "-lhnav", f"-Wl,-rpath,{folder}"])
    return program


def count(program: Path, samples: Path, rows: int, case: tuple[str, ...]) -> int:
    """Instructions of the one call, divided by the rows."""
    return round(counted(f"hnav_filter_{case[1]}", [program, samples, str(rows), *case]) / rows)


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
    drivers = {label: driver_of(checkout, label) for label, checkout in sides.items()}
    say(f"{'instructions for each sample':<34}{'old':>9}{'new':>9}{'ratio':>9}")
    worst = 0.0
    with ThreadPoolExecutor(2) as pool:
        for name, case in CASES.items():
            if not fnmatch(name, only):
                continue
            before, after = pool.map(lambda program, case=case: count(program, samples, rows, case), drivers.values())
            worst = max(worst, after / before)
            say(f"{name:<34}{before:>9}{after:>9}{after / before:>9.3f}")
    if worst > 1 + TOLERANCE:
        raise typer.Exit(1)
