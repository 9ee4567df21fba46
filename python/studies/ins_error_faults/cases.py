"""What is wrong in each case, and the flights."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hnav.simulation.aircraft import Aircraft, Fault
from studies.ins_error_table.comparison import FAULT, STEPS
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
