"""The observer's smoother beside its filter: errors over what they are said to be, and how much smaller they are."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from hnav.filters.observer import Observer, ObserverRun
from hnav.filters.plant import Plant
from hnav.native.arrays import Array
from hnav.systems.statistics import normalised_squares
from studies.observer import events, smooth


@dataclass(frozen=True)
class HindsightResult:
    """Of all runs of one plant, of the filter and of the smoother."""

    plant: str
    nees: tuple[float, float]
    rms: tuple[float, float]
    """Of the errors of one state."""


def both(observer: Observer, t_s: Array, y: dict[str, Array]) -> tuple[ObserverRun, ObserverRun]:
    """Of the filter and of the smoother."""
    return observer.run(t_s, y), observer.smooth(t_s, y)


def oscillators(runs: int) -> Iterator[tuple[Array, tuple[ObserverRun, ObserverRun]]]:
    """Truth and estimates of a van der Pol oscillator, after the start."""
    for seed in range(runs):
        rng = np.random.default_rng(seed)
        start = np.array([2.0, 0.0]) + rng.standard_normal(2)
        truth, y = smooth.van_der_pol(rng)
        observer = Observer(smooth.oscillator(smooth.in_python(), start))
        yield truth, both(observer, 0.05 * np.arange(1.0, len(y) + 1), {"x0": y})


def of_case(case: events.Case, runs: int) -> Iterator[tuple[Array, tuple[ObserverRun, ObserverRun]]]:
    """The same of a plant with events."""
    for seed in range(runs):
        truth, y = events.truth_and_samples(case, np.random.default_rng(seed))
        observer = Observer(events.plan_of(case), start_mode="given")
        yield truth, both(observer, case.interval_s * np.arange(1.0, len(y) + 1), {next(iter(case.start)): y})


def measured(
    name: str, runs: Iterator[tuple[Array, tuple[ObserverRun, ObserverRun]]], worst: int, settled: int
) -> HindsightResult:
    """worst: the state whose error is shown; settled: samples that a start far off is given."""
    nees: tuple[list[float], list[float]] = ([], [])
    errors: tuple[list[Array], list[Array]] = ([], [])
    for truth, made in runs:
        for kept, squares, run in zip(errors, nees, made):
            error = (truth - np.column_stack([*run.x.values()]))[settled:]
            kept.append(error[:, worst])
            squares.append(float(np.mean(normalised_squares(error, run.covariance[settled:]))) / error.shape[1])
    rms = [float(np.sqrt(np.mean(np.square(kept)))) for kept in errors]
    return HindsightResult(name, (float(np.mean(nees[0])), float(np.mean(nees[1]))), (rms[0], rms[1]))


def results(runs: int) -> Iterator[HindsightResult]:
    """Of all plants as functions."""
    yield measured("van der Pol oscillator", oscillators(runs), 1, smooth.SETTLED)
    for case in events.cases():
        if isinstance(case.plant, Plant):
            yield measured(case.name, of_case(case, runs), case.worst, 0)
