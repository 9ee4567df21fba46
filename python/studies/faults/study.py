"""The command: which part, by which filter, and the table of each.

    ./run study faults [DIR] --seeds 100 --filter ahrs --part events
    ./run study faults --filter ins --seeds 4 [--kinds car,flight] [--only rate_bias,turns] [--smooth]

Part events: what a few seconds cost a simulated body that is held in a hand (studies.faults.events). Part recordings: BROAD
trials damaged on purpose (studies.faults.recordings); DIR is where the trials lie. Part starts: a false first sample
(studies.faults.first_samples). Without --part all, as far as there is DIR. The filter ins has a table of its own (studies.ins.faults).
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pandas as pd
import typer
from rich.table import Table

from hnav.cli.console import say, show
from hnav.cli.parameters import FilterOrIns, Settings, parse_settings
from hnav.cli.words import UsageError
from hnav.io.readers import read
from hnav.io.readers.broad import find_trial
from studies.command import WORKERS, Seed, Trials, Workers, check_choices, titled_table, tracked
from studies.faults.events import EVENTS
from studies.faults.experiment import CHUNK, TRIALS, damage_of, experiment, options_of
from studies.faults.first_samples import SENSORS, first_samples, verdict
from studies.faults.navigation import fault_table, hindsight_table
from studies.faults.recordings import FAULTS
from studies.ins import faults as navigating

BODIES = (*navigating.KINDS, navigating.FLIGHT)
PARTS = ("starts", "events", "recordings")
SHOWN_SHARE = 0.01  # states of a sensor for less of the time are omitted


def command(
    folder: Trials = None,
    seeds: Annotated[int, typer.Option(min=1, help="Simulated runs of each event, and starts")] = 100,
    filter: FilterOrIns = "ahrs",
    settings: Settings = None,
    part: Annotated[str | None, typer.Option(help=" or ".join(PARTS))] = None,
    workers: Workers = WORKERS,
    kinds: Annotated[str, typer.Option(help="of bodies, for ins; without a folder of the flight without it")] = ",".join(BODIES),
    only: Annotated[str | None, typer.Option(metavar="NAMES", help="of studies.ins.faults.FAULTS, for ins: these")] = None,
    flight: Annotated[Path | None, typer.Option(metavar="FOLDER", envvar="HNAV_FLIGHT", help="the recorded flight")] = None,
    smooth: Annotated[
        bool, typer.Option("--smooth", help="for ins: the smoother beside the filter, of simulated bodies")
    ] = False,
    seed: Seed = 1,
) -> None:
    """Measures how long faults of sensors and time stamps leave an estimate wrong, and whether the filter reports it."""
    if filter == "ins":
        of_bodies, names = kinds.split(","), only.split(",") if only else list(navigating.FAULTS)
        check_choices("--kinds", of_bodies, BODIES)
        check_choices("--only", names, navigating.FAULTS)
        if settings:
            raise UsageError("--set: the bodies of --filter ins have their own options")
        simulated = [kind for kind in of_bodies if kind != navigating.FLIGHT]
        if smooth:
            show(hindsight_table(simulated, names, seeds, seed, workers), width=220)
        else:
            show(fault_table(of_bodies if flight else simulated, names, seeds, seed, workers, flight), width=220)
        return
    check_choices("--part", [part], PARTS)
    if part == "recordings" and folder is None:
        raise UsageError("--part recordings: name the folder of the BROAD trials, or set BROAD_DIR")
    chosen = parse_settings(settings)
    if part in (None, "starts"):
        for sensor in SENSORS:
            starts = first_samples(seeds, sensor, options_of(filter, chosen), workers)
            say(verdict(sensor, list(tracked(starts, f"first {sensor}", seeds))))
    if part in (None, "events"):
        show(event_table(events(seeds, filter, chosen, workers), f"{filter}, {seeds} runs of each event"), width=150)
    if part in (None, "recordings") and folder is not None:
        title = f"{filter}, BROAD trials {', '.join(map(str, TRIALS))}, means over the trials"
        show(recording_table(recordings(folder, filter, chosen), title), width=150)


def events(seeds: int, filter: str, settings: dict[str, str], workers: int) -> pd.DataFrame:
    """A row for each event and seed. Raises HnavError."""
    return pd.concat(tracked(experiment(seeds, filter, settings, workers), "events", len(EVENTS) * math.ceil(seeds / CHUNK)))


def recordings(folder: Path, filter: str, settings: dict[str, str]) -> dict[str, list[dict[str, Any]]]:
    """By fault. Raises HnavError."""
    trials = [read(find_trial(folder, number)) for number in TRIALS]
    found: dict[str, list[dict[str, Any]]] = {}
    for fault in tracked(FAULTS, "faults"):
        found[fault] = [damage_of(trial, fault, i, filter, settings) for i, trial in enumerate(trials)]
    return found


def event_table(found: pd.DataFrame, title: str) -> Table:
    """A row for each event: seconds after its end, and after its begin for the flag."""
    figures = "median | worst | complementary: median | worst | ready and false | worst run | flag down after"
    table = titled_table(f"{title}: seconds until the angle stays within 5 deg", "event | angle", figures)
    for event, runs in found.groupby("event", sort=False):
        times = [_seconds(of(runs[name])) for name in ("settled_s", "peer_settled_s") for of in (np.median, np.max)]
        false = (f"{share:.1%}" for share in (runs.false_share.mean(), runs.false_share.max()))
        angle = "heading" if EVENTS[str(event)].heading else "tilt"
        table.add_row(str(event), angle, *times, *false, _seconds(np.median(runs.noticed_s), 2))
    return table


def recording_table(found: dict[str, list[dict[str, Any]]], title: str) -> Table:
    """A row for each fault."""
    heads = "total RMSE, deg | VQF | beyond 3 sigma, ready: inclination | heading | ready: tilt | heading"
    table = titled_table(title, "fault", heads)
    table.add_column("not ok, share of the time")
    for fault, damages in found.items():
        of_trials = pd.DataFrame(damages)
        shares = np.mean([*of_trials.shares], axis=0)
        cells = [f"{share:.1%}" for share in shares[:2]] + [f"{share:.0%}" for share in shares[2:]]
        said = pd.DataFrame([*of_trials.said]).fillna(0.0).mean().sort_values(ascending=False, kind="stable")
        of_sensors = ", ".join(f"{name} {share:.0%}" for name, share in said.items() if share >= SHOWN_SHARE)
        peer = of_trials.peer_deg.mean(skipna=False)
        table.add_row(fault, f"{of_trials.total_deg.mean():.2f}", "-" if np.isnan(peer) else f"{peer:.2f}", *cells, of_sensors)
    return table


def _seconds(value: float, digits: int = 1) -> str:
    return "-" if np.isnan(value) else "never" if np.isinf(value) else f"{value:.{digits}f}"
