"""What is wrong in each case, the flights, and the tables."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
import typer
from rich.table import Table

from hnav.cli.console import show
from hnav.cli.words import UsageError
from hnav.simulation.aircraft import Aircraft, Fault
from hnav.systems.aircraft import models_folder, read_aircraft
from studies.command import Seed, titled_table
from studies.ins_error_faults.peers import PEERS, Result, run_oracle, run_peer
from studies.ins_error_table import FAULT, STEPS, run_filter
from twins.aircraft import Flight, fly, model_of


@dataclass(frozen=True)
class Case:
    """Where the truth differs from the file of the aircraft."""

    faults: tuple[Fault, ...] | None = None  # None: none
    outliers: float = 0  # probability that a sample of a channel has OUTLIER times the noise
    time_constant_s: float | None = None  # of the coloured errors
    sine_s: float | None = None  # the coloured errors are sines of this period, of the same root mean square
    process: float = 1  # on the standard deviation of w
    jump: int | None = None  # the channel whose error jumps by JUMP sigma of its white noise, and stays there


OUTLIER, JUMP = 20.0, 10.0


def cases_of(plane: Aircraft) -> dict[str, Case]:
    everywhere = tuple(Fault(i, 6.0, FAULT.start, FAULT.stop - 1) for i in range(len(plane.channels)))
    jumps = {f"error of {c.name} jumps": Case(jump=i) for i, c in enumerate(plane.channels)}
    return {
        "the paper's fault": Case(plane.faults),
        "all channels x6": Case(everywhere),
        "5 % outliers": Case(outliers=0.05),
        "tau 10 s, not 60, and fault": Case(plane.faults, time_constant_s=10),
        "colour is an 8 s sine, and fault": Case(plane.faults, sine_s=8),
        "process noise x3, and fault": Case(plane.faults, process=3),
        "process noise x3": Case(process=3),
        "process noise / 3": Case(process=1 / 3),
        "nothing wrong": Case(),
        **jumps,
    }


def fly_case(plane: Aircraft, case: Case, runs: int, seed: int) -> tuple[Flight, np.ndarray]:
    """The flights, and which samples have healthy noise (runs x (steps + 1) x n)."""
    rng = np.random.default_rng(seed)
    n = len(plane.channels)
    true = replace(plane, faults=case.faults or ())
    if case.time_constant_s is not None:
        true = replace(true, ins_error_time_constant_s=np.full(n, case.time_constant_s))
    if case.sine_s is not None:
        true = replace(true, ins_error_sigma=np.zeros(n))
    outlier = rng.random((STEPS + 1, runs, n)) < case.outliers

    def draw(source: str, k: int) -> np.ndarray:
        numbers = rng.normal(size=(runs, n))
        if source == "process" and k > 0:
            numbers *= case.process
        if source == "measurement":
            numbers *= np.where(outlier[k], OUTLIER, 1.0)
        return numbers

    flight = fly(true, STEPS, draw, model_of(true))
    if case.sine_s is not None:
        t_s = plane.interval_s * np.arange(STEPS + 1)[:, None]
        phase = rng.uniform(0, 2 * np.pi, (runs, 1, n))
        flight.z[:] += np.sqrt(2) * plane.ins_error_sigma * np.sin(2 * np.pi * t_s / case.sine_s + phase)
    if case.jump is not None:
        flight.z[:, FAULT.start :, case.jump] += JUMP * plane.measurement_sigma[case.jump]
    return flight, (flight.noise_factor == 1) & ~outlier.swapaxes(0, 1)


# --------------------------------------------------------------------------------------------- scores


OURS = "joint"
FILTERS: dict[str, dict[str, Any]] = {
    OURS: dict(noise_scaling="joint"),
    "HMM": dict(noise_scaling="hmm"),
    "gated": dict(noise_scaling="gated_match"),
    "none": dict(noise_scaling="none"),
    "AMDKF": dict(form="amdkf", window=20),
}
ORDER = (OURS, "HMM", "gated", *PEERS, "none", "AMDKF")
RECOVERS = 30  # samples after a fault that do not count as healthy: no filter can be sure at once
ENDING = (OURS, "HMM")  # whose alarms end is shown
INTERVAL_S = 0.1  # of the aircraft
WIDTH = 170
Scores = dict[str, dict[str, float]]


def judge(case: Case, result: Result, oracle: Result, healthy: np.ndarray) -> dict[str, float]:
    """One filter in one case: ratio of its RMS error to that of the oracle from 8 to 15 s, mean over the channels, and NEES/n
    there; shares of samples of healthy channels whose noise is called faulty, of those without a jump whose error is said to have
    jumped, and of those classified as increased process noise; ends_s: median time from the end of a fault to that of its alarm,
    NaN without a fault."""
    ratio = result.rmse(FAULT).mean(axis=0) / oracle.rmse(FAULT).mean(axis=0)
    counted = healthy.copy()
    if case.faults:
        counted[:, FAULT.stop : FAULT.stop + RECOVERS] = False
    steady = np.ones(healthy.shape, bool)
    if case.jump is not None:
        steady[:, FAULT.start :, case.jump] = False
    return {
        "ratio": float(ratio.mean()),
        "nees": float(np.nanmean(result.nees[:, FAULT]) / healthy.shape[2]),
        "noise_alarms": float((result.fault_probability > 0.5)[counted].mean()),
        "bias_alarms": float(np.mean(np.broadcast_to(result.bias_fault_probability, steady.shape)[steady] > 0.5)),
        "process_alarms": float(np.mean(np.asarray(result.process_fault_probability) > 0.5)),
        "ends_s": ends_s(case, result),
    }


def ends_s(case: Case, result: Result) -> float:
    """Median over flights and faulty channels."""
    rows = [result.fault_probability[:, FAULT.stop :, fault.channel] <= 0.5 for fault in case.faults or ()]
    steps = [np.where(row.any(axis=1), row.argmax(axis=1), row.shape[1]) for row in rows]
    return float(np.median(steps) * INTERVAL_S) if steps else np.nan


def scores_of(plane: Aircraft, case: Case, runs: int, seed: int) -> Scores:
    """By filter, in the order of the tables."""
    flight, healthy = fly_case(plane, case, runs, seed)
    results = {name: run_filter(plane, flight, setting) for name, setting in FILTERS.items()}
    results |= {name: run_peer(kind, plane, flight) for name, kind in PEERS.items()}
    oracle = run_oracle(plane, flight)
    return {name: judge(case, results[name], oracle, healthy) for name in ORDER}


def command(
    runs: Annotated[int, typer.Option(min=2, help="flights in each case")] = 120,
    seed: Seed = 1,
    only: Annotated[str, typer.Option(help="only the case of this name")] = "",
) -> None:
    """Filters against every kind of fault: errors over those of an oracle, NEES, false alarms."""
    plane = read_aircraft(models_folder() / "f4c_longitudinal.json")
    cases = cases_of(plane)
    if only and only not in cases:
        raise UsageError(f"no case {only!r}; there are: {', '.join(cases)}")
    chosen = {only: cases[only]} if only else cases
    scores = {name: scores_of(plane, case, runs, seed) for name, case in chosen.items()}
    show(errors_table(scores, runs), WIDTH)
    show(consistency_table(scores), WIDTH)
    show(alarms_table(scores), WIDTH)


def errors_table(scores: dict[str, Scores], runs: int) -> Table:
    title = f"RMS error over the oracle's, 8 to 15 s, mean of four channels, {runs} flights a case"
    table = titled_table(title, "case", " | ".join((*ORDER, "joint over best other")))
    for name, row in scores.items():
        best = min(score["ratio"] for other, score in row.items() if other != OURS)
        table.add_row(name, *(f"{row[f]['ratio']:.3f}" for f in ORDER), f"{row[OURS]['ratio'] / best:.3f}")
    return table


def consistency_table(scores: dict[str, Scores]) -> Table:
    table = titled_table("NEES/n, 8 to 15 s (1 is consistent)", "case", " | ".join(ORDER))
    for name, row in scores.items():
        table.add_row(name, *(f"{row[f]['nees']:.2f}" for f in ORDER))
    return table


def alarms_table(scores: dict[str, Scores]) -> Table:
    title = "Percent of healthy samples called faulty (matching, VB: factor above 4); joint also: bias, process"
    heads = (*ORDER[:-2], "joint: bias", "joint: process", *(f"{f} ends, s" for f in ENDING))
    table = titled_table(title, "case", " | ".join(heads))
    for name, row in scores.items():
        shares = (*(row[f]["noise_alarms"] for f in ORDER[:-2]), row[OURS]["bias_alarms"], row[OURS]["process_alarms"])
        ends = (row[f]["ends_s"] for f in ENDING)
        table.add_row(name, *(f"{100 * share:.1f}" for share in shares), *("-" if np.isnan(s) else f"{s:.2f}" for s in ends))
    return table
