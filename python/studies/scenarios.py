"""The filters of the turntable system in its scenarios, in closed co-simulation, and an EKF with a larger Q beside them.

    ./run study scenarios --runs 200 --workers 2

What the scenarios are stands in models/systems/turntable; what the columns are, in `hnav montecarlo --help`. The EKF with a larger
Q (studies.larger_q) sees the same samples: it takes the place of the HEKF in a second run with the same seed.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

import pandas as pd
import typer

from hnav.cli.console import counting, show
from hnav.cli.montecarlo import means_table
from hnav.cli.words import UsageError
from hnav.systems.montecarlo import jobs, run_jobs
from makers.turntable_scenarios import SCENARIOS
from studies.command import WORKERS, Workers, check_choices
from studies.larger_q import NAME, in_turntable

SYSTEM = "turntable"
SHOWN = ("nominal", "gyro_drift", "outliers", "magnetic_disturbance", "iron_residual", "matched")


def measured(chosen: list[str], runs: int, workers: int, stop_s: float | None = None) -> pd.DataFrame:
    """A row for each filter and run, scenario by scenario. Raises UsageError when a run fails."""
    nominal_jobs = jobs(SYSTEM, chosen, runs, stop_s=stop_s)
    larger = [replace(job, settings=in_turntable(str(job.scenario))) for job in nominal_jobs]
    with counting(SYSTEM, len(nominal_jobs) + len(larger)) as progress:
        table = run_jobs([*nominal_jobs, *larger], workers, progress=progress)
    if (failed := table[table["failure"] != ""]).size:
        raise UsageError(f"{failed.iloc[0]['scenario']}, seed {failed.iloc[0]['seed']}: {failed.iloc[0]['failure']}")
    # The filters of the first runs come once more in the second ones, where only the first is another.
    again = table.duplicated(["scenario", "seed", "filter"])
    other = table[again & (table["filter"] == "hekf")].assign(filter=NAME)
    return pd.concat([table[~again], other]).sort_values("scenario", key=lambda names: names.map(chosen.index), kind="stable")


def command(
    runs: Annotated[int, typer.Option(min=2, help="seeds of each scenario")] = 200,
    workers: Workers = WORKERS,
    scenarios: Annotated[str, typer.Option(metavar="A,B,...", help=", ".join(SCENARIOS))] = ",".join(SHOWN),
    stop: Annotated[float | None, typer.Option(help="seconds, instead of the system's 60")] = None,
) -> None:
    """Runs the scenarios with many seeds: errors, and whether the sigmas are right."""
    chosen = scenarios.split(",")
    check_choices("--scenarios", chosen, SCENARIOS)
    show(means_table(measured(chosen, runs, workers, stop)), width=230)
