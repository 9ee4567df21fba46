"""The observer's smoother beside its filter: errors over what they are said to be, and how much smaller they are."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from hnav.filters.observer import Observer, ObserverRun
from hnav.filters.plant import Plant
from hnav.native.arrays import Array
from hnav.systems.statistics import normalised_squares
from studies.observer import events, smooth


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
) -> dict[str, Any]:
    """nees, rms: of filter and smoother. worst: the state whose error is shown; settled: samples that a start far off is
    given."""
    nees, errors = [], []
    for truth, made in runs:
        of_both = [(truth - np.column_stack([*run.x.values()]))[settled:] for run in made]
        errors.append([error[:, worst] for error in of_both])
        squares = (normalised_squares(error, run.covariance[settled:]) for error, run in zip(of_both, made))
        nees.append([np.mean(square) / len(truth[0]) for square in squares])
    rms = np.sqrt(np.mean(np.square(errors), axis=(0, 2)))
    return {"plant": name, "nees": np.mean(nees, axis=0), "rms": rms, "ratio": rms[1] / rms[0]}


def results(runs: int) -> Iterator[dict[str, Any]]:
    """Of all plants as functions."""
    yield measured("van der Pol oscillator", oscillators(runs), 1, smooth.SETTLED)
    for case in events.cases():
        if isinstance(case.plant, Plant):
            yield measured(case.name, of_case(case, runs), case.worst, 0)
