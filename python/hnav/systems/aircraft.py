"""Linear aircraft as seen by an INS with time-correlated errors; hnav.systems.aircraft_file reads them.

    aircraft = read_aircraft("models/aircraft/f4c_lateral.json")
    flight = simulate(aircraft, runs=100, steps=200, seed=1)
    InsErrorFilter(aircraft.model()).run(flight.u, flight.z[0])

The continuous model is dx/dt = A x + B u + w in SI units; every channel of the INS measures one state, with white noise
and a first-order Gauss-Markov error. Faults multiply the standard deviation of the white noise for a while.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hnav.filters.linear_model import LinearModel
from hnav.simulation.aircraft import Aircraft


@dataclass(frozen=True)
class Flight:
    u: np.ndarray  # (steps + 1) x m, row k held from step k - 1 to k
    x: np.ndarray  # runs x (steps + 1) x n: truth
    z: np.ndarray  # runs x (steps + 1) x n: measurements
    noise_factor: np.ndarray  # (steps + 1) x n


def simulate(aircraft: Aircraft, runs: int, steps: int, seed: int) -> Flight:
    """Truth and measurements of `runs` flights with equal controls. The truth is drawn from the filter's prior."""
    rng = np.random.default_rng(seed)
    size = (runs, len(aircraft.channels))
    return fly(aircraft, steps, lambda source, k: rng.normal(size=size), aircraft.model())


def fly(aircraft: Aircraft, steps: int, draw: Callable[[str, int], np.ndarray], model: LinearModel) -> Flight:
    """The flights for given noise. draw(source, k): standard normal numbers, runs x n, of step k and one of the sources
    process, colour (both give the start when k is 0) and measurement.
    """
    m = model.discrete()
    u, factor = aircraft.inputs(steps), aircraft.noise_factors(steps)
    diagonal = np.count_nonzero(m.Qw - np.diag(np.diag(m.Qw))) == 0
    w_factor = np.diag(np.sqrt(np.diag(m.Qw))) if diagonal else np.linalg.cholesky(m.Qw)
    U_sigma, v_sigma = (np.sqrt(np.diag(m.matrix(name))) for name in ("QU", "Qv"))
    B, An = m.matrix("B"), m.matrix("An")
    x, z = [], []
    for k in range(steps + 1):
        n_process, n_colour = draw("process", k), draw("colour", k)
        if k == 0:
            state, error = n_process * aircraft.start_sigma, n_colour * aircraft.ins_error_sigma
        else:
            state = state @ m.A.T + B @ u[k] + n_process @ w_factor.T
            error = error @ An.T + n_colour * U_sigma
        x.append(state)
        z.append(state @ m.H.T + error + draw("measurement", k) * v_sigma * factor[k])
    return Flight(u, np.stack(x, axis=1), np.stack(z, axis=1), factor)
