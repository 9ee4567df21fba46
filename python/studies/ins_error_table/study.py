"""The command: tables of one comparison, or the score of many random settings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, NamedTuple

import numpy as np
import typer
from rich.table import Table

from hnav.cli.console import say, show
from hnav.simulation.aircraft import Aircraft
from hnav.systems.aircraft import models_folder, read_aircraft
from studies.command import Seed
from studies.ins_error_table.comparison import (
    AFTER,
    BEFORE,
    FAULT,
    FILTERS,
    FITTED,
    ORACLE,
    OURS,
    OURS_LATE,
    PAIRS,
    PAPER,
    PAPER_NOW,
    PAPER_RATIOS,
    Result,
    alarms,
    compare,
    in_display_units,
    rmse_ratio,
    scaled,
    wins,
)
from twins.aircraft import Flight

AXES = ("f4c_longitudinal", "f4c_lateral")
NAMES = (*FILTERS, ORACLE)
WIDTH = 200


class Flown(NamedTuple):
    """An aircraft, its flights, and what each filter made of them."""

    plane: Aircraft
    flight: Flight
    results: dict[str, Result]


def command(
    runs: Annotated[int, typer.Option(min=2, help="flights for each aircraft and setting")] = 1000,
    seed: Seed = 1,
    settings: Annotated[int, typer.Option(help="compare over so many random settings instead")] = 0,
    fitted: Annotated[
        bool, typer.Option(help="noise that was searched for so that the order is the paper's on all channels")
    ] = False,
) -> None:
    """Monte Carlo comparison in the form of the paper's Table 1."""
    planes = [read_aircraft(models_folder() / f"{axis}.json") for axis in AXES]
    if fitted:
        planes = [scaled(plane, *FITTED[axis]) for axis, plane in zip(AXES, planes)]
    if settings > 0:
        print_settings(planes, settings, runs, seed)
        return
    both = [Flown(plane, *compare(plane, runs, seed + i)) for i, plane in enumerate(planes)]
    show(error_table(both, runs), WIDTH)
    show(consistency_table(both), WIDTH)
    for text in [*wins_of(both), *alarms_of(both)]:
        say(text)


def error_table(both: Sequence[Flown], runs: int) -> Table:
    table = Table(title=f"RMSE in the fault window, k = 80..150, {runs} runs, mean and 95 % interval")
    table.add_column("filter")
    for flown in both:
        for c in flown.plane.channels:
            table.add_column(f"{c.name} {c.display_unit}", justify="right")
    for name in NAMES:
        cells = []
        for flown in both:
            rmse = in_display_units(flown.plane, flown.results[name].rmse(FAULT))
            cells += [f"{m:.4f} ±{1.96 * s / np.sqrt(runs):.4f}" for m, s in zip(rmse.mean(0), rmse.std(0))]
        table.add_row(name, *cells)
    measured = np.concatenate([rmse_ratio(flown.results) for flown in both])
    for name, ratios in (("AMDKF/MDKF", measured), ("AMDKF/MDKF in the paper", np.concatenate(PAPER_RATIOS))):
        table.add_row(name, *(f"{ratio:.2f}" for ratio in ratios))
    return table


def consistency_table(both: Sequence[Flown]) -> Table:
    table = Table(title="NEES/n (1 is consistent) and RMSE against the oracle: mean and worst over the 8 channels")
    for column in ("filter", "NEES/n before, lon lat", "NEES/n in fault, lon lat", "in fault", "worst", "after", "worst"):
        table.add_column(column, justify="left" if column == "filter" else "right")
    for name in NAMES:
        nees = [" ".join(f"{np.mean(f.results[name].nees[:, s]) / 4:.2f}" for f in both) for s in (BEFORE, FAULT)]
        ratios = [
            np.concatenate([f.results[name].rmse(s).mean(0) / f.results[ORACLE].rmse(s).mean(0) for f in both])
            for s in (FAULT, AFTER)
        ]
        table.add_row(name, *nees, *(f"{f(ratio):.3f}" for ratio in ratios for f in (np.mean, np.max)))
    return table


def wins_of(both: Sequence[Flown]) -> list[str]:
    texts = []
    for ours, theirs in PAIRS:
        better = np.concatenate([wins(flown.results, ours, theirs) for flown in both])
        texts.append(f"{ours} better than {theirs} in the fault on {better.sum()} of 8 channels")
    excess = [float(np.nanmean(flown.results[PAPER].noise_scale[:, BEFORE])) for flown in both]
    of_healthy = f"mean noise scale of healthy channels before the fault, lon {excess[0]:.3f}, lat {excess[1]:.3f}"
    return [*texts, f"{PAPER}: {of_healthy} (1 would be unbiased)"]


def alarms_of(both: Sequence[Flown]) -> list[str]:
    texts = []
    for plane, flight, results in both:
        found = alarms(plane, flight, results[OURS])
        of_faults = "".join(
            f"; {name} found within 10 steps in {100 * share:.1f} % of runs, median {delay:.0f} steps"
            for name, share, delay in zip(found.names, found.within_10, found.median_delay)
        )
        false = ", ".join(f"{c.name} {rate:.2f}" for c, rate in zip(plane.channels, found.false_per_1000))
        texts.append(f"{plane.name}: false alarms per 1000 healthy samples {false}{of_faults}")
    return texts


def random_setting(plane: Aircraft, rng: np.random.Generator, interval_s: float, tau_s: float) -> Aircraft:
    """Noise levels a factor of 0.2 to 5 around the file's, by channel."""
    factors = [np.exp(rng.uniform(np.log(0.2), np.log(5), len(plane.channels))) for _ in range(3)]
    return scaled(plane, factors, interval_s, tau_s)


def print_settings(planes: Sequence[Aircraft], settings: int, runs: int, seed: int) -> None:
    """How often each pair is won, over random settings."""
    rng = np.random.default_rng(seed)
    won: dict[tuple[str, str], list[np.ndarray]] = {pair: [] for pair in PAIRS}
    for k in range(settings):
        interval_s = np.exp(rng.uniform(np.log(0.02), np.log(0.2)))
        tau_s = np.exp(rng.uniform(np.log(5), np.log(300)))
        parts = []
        for i, plane in enumerate(planes):
            setting = random_setting(plane, rng, interval_s, tau_s)
            parts.append(compare(setting, runs, seed + 1000 + 2 * k + i, (PAPER, PAPER_NOW, OURS, OURS_LATE))[1])
        for pair, rows in won.items():
            rows.append(np.concatenate([wins(results, *pair) for results in parts]))
    names = [c.name for plane in planes for c in plane.channels]
    for (ours, theirs), rows in won.items():
        share = ", ".join(f"{name} {count}" for name, count in zip(names, np.sum(rows, axis=0)))
        all_of_them = np.all(rows, axis=1).sum()
        say(f"{ours} better than {theirs} on all 8 channels in {all_of_them} of {settings} settings; by channel: {share}")
