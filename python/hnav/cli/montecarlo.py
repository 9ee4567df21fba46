"""hnav montecarlo: many runs of a system, their rows in a file, and a table of means with their intervals."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import pandas as pd
import typer
from rich.table import Table

from hnav.cli.console import counting, say, show
from hnav.cli.parameters import Scheduler, Workers, with_groups
from hnav.cli.system_options import Setup, SystemName
from hnav.cli.words import Interrupted, UsageError
from hnav.io.outputs import refuse_overwriting
from hnav.io.record_file import RecordFile
from hnav.systems.montecarlo import Job, finished_runs, jobs, need_parquet, run_jobs, write_table
from hnav.systems.ssp_reader import read_system, system_files, system_path
from hnav.systems.statistics import mean_interval, nees_bounds, ratio_interval


@with_groups
def command(
    system: SystemName,
    out: Annotated[Path, typer.Option(metavar="FILE", help="Parquet, a row for each filter and run")],
    runs: Annotated[int, typer.Option(help="Runs of each scenario")] = 200,
    scenarios: Annotated[
        str | None, typer.Option(metavar="A,B,...", help="Scenarios (hnav systems NAME lists them); default: the system as it is")
    ] = None,
    first_seed: Annotated[int, typer.Option(help="Seed of the first run; the others follow")] = 1,
    *,
    setup: Setup,
    workers: Workers = 1,
    scheduler: Scheduler = None,
) -> None:
    named: list[str | None] = list(scenarios.split(",")) if scenarios else [None]
    chosen = setup.arguments()
    unfinished = out.with_name(f"{out.name}.unfinished")
    if out.exists() and not out.is_file():
        raise UsageError(f"--out {out}: is no file; finished runs are kept beside it until all are there")
    refuse_overwriting([out, unfinished], system_files(system))
    need_parquet()
    # An error of all runs is reported at once, not once for each run.
    for scenario in named:
        with read_system(system_path(system), setup.allow_outside) as read:
            read.choose(chosen["grade"], scenario)
            read.seed(first_seed)
    work = jobs(system, named, runs, first_seed, **chosen)
    with read_system(system_path(system), setup.allow_outside) as read, finished_runs(unfinished, work, read) as kept:
        table = run_and_keep(work, kept, workers, scheduler)
        write_table(table, out)
        if len(kept.records) == len(work):
            kept.remove()
    failed = table[table["failure"] != ""]
    if len(failed) < len(table):
        finished = table[table["failure"] == ""]
        for make_table, column in ((means_table, "mse_deg2"), (navigation_table, "position_end_m")):
            if column in finished:
                show(make_table(finished[finished[column].notna()]), width=200)
    for row in failed.itertuples():
        say(f"failed: {row.scenario}, seed {row.seed}: {row.failure}")
    say(f"{len(work) - len(failed)} of {len(work)} runs to {out}")
    if len(failed) == len(work):
        raise UsageError(f"no run came to its end; the first said: {failed.iloc[0]['failure']}")


def run_and_keep(work: Sequence[Job], kept: RecordFile, workers: int, scheduler: str | None) -> pd.DataFrame:
    """The rows of all runs. Raises Interrupted when the user interrupts them; those that are finished stay in the file."""
    if kept.records:
        say(f"{len(kept.records)} of {len(work)} runs are finished, in {kept.path}")
    with counting(work[0].system, len(work)) as progress:
        try:
            return run_jobs(work, workers, scheduler, progress, kept)
        except KeyboardInterrupt:
            outcome = f"interrupted; {len(kept.records)} of {len(work)} runs are in {kept.path}"
            raise Interrupted(f"{outcome}, and the same command goes on from there") from None


def means_table(runs: pd.DataFrame) -> Table:
    """A line for each scenario and filter: means over the runs with their intervals, NEES at times beside its bounds.

    first / this: mean squared error about down of the scenario's first filter over that of this one, above 1 a win.
    """
    times = [name for name in runs.columns if name.startswith("nees_") and runs[name].notna().any()]
    heads = ["scenario", "filter", "runs", "MSE / deg2", "MSE down / deg2", "first / this", "mean NEES"]
    heads += [*(f"at {name[5:-1]} s" for name in times), "99.9 %", "ready / s"]
    table = Table(*heads, title="means over the runs [95 % interval]")
    for scenario, of_scenario in runs.groupby("scenario", sort=False):
        first = None
        for name, rows in of_scenario.groupby("filter", sort=False):
            first = rows if first is None else first
            paired = first.merge(rows, on="seed", suffixes=("_first", ""))
            ratio = ratio_interval(paired["mse_down_deg2_first"].to_numpy(), paired["mse_down_deg2"].to_numpy())
            low, high = nees_bounds(len(rows))
            ready = rows["heading_ready_s"].dropna()
            means = [_interval(mean_interval(rows[column].to_numpy())) for column in ("mse_deg2", "mse_down_deg2", "nees")]
            table.add_row(
                str(scenario), str(name), str(len(rows)), *means[:2], "1" if rows is first else _interval(ratio), means[2],
                *(f"{rows[t].mean():.3g}" for t in times), f"{low:.2f} to {high:.2f}",
                f"{ready.median():.3g} ({len(ready)})" if len(ready) else "never",
            )  # fmt: skip
    return table


def navigation_table(runs: pd.DataFrame) -> Table:
    """A line for each scenario and filter that navigates. z2: mean of squared errors over their variance, 1 when sigmas are right; each at
    most 100, that of a place a mean of three."""
    heads = ["scenario", "filter", "runs", "heading ready", "median", "false", "heading at the end, rms", "stated", "z2"]
    heads += ["place at the end, rms", "z2", "farthest off since ready: median", "worst", "within 3 sigma"]
    table = Table(*heads, title="filters that navigate")
    for (scenario, name), rows in runs.groupby(["scenario", "filter"], sort=False):
        ready = rows["heading_ready_s"].dropna()
        table.add_row(
            str(scenario), str(name), str(len(rows)), str(len(ready)), f"{ready.median():.3g} s" if len(ready) else "never",
            f"{rows['false_ready'].sum():.0f}", f"{_rms(rows['heading_end_deg']):.3g} deg", f"{_rms(rows['heading_end_sigma_deg']):.3g} deg",
            f"{rows['heading_z2'].clip(upper=100).mean():.2f}", f"{_rms(rows['position_end_m']):.3g} m",
            f"{rows['position_z2'].clip(upper=100).mean():.2f}", *(_since_ready(rows) if len(ready) else ("", "", "")),
        )  # fmt: skip
    return table


def _since_ready(rows: pd.DataFrame) -> tuple[str, str, str]:
    worst = rows["position_worst_m"]
    return f"{worst.median():.3g} m", f"{worst.max():.3g} m", f"{rows['position_within_3_sigma'].mean():.1%}"


def _rms(values: pd.Series[float]) -> float:
    return float((values**2).mean() ** 0.5)


def _interval(found: tuple[float, float, float]) -> str:
    return "{:.3g} [{:.3g}, {:.3g}]".format(*found)
