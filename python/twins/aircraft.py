"""The linear aircraft of hnav.simulation.aircraft again in NumPy, many flights at once, with noise that the caller draws.

    aircraft = read_aircraft("models/aircraft/f4c_lateral.json")
    flight = simulate(aircraft, runs=100, steps=200, seed=1)
    InsErrorFilter(model_of(aircraft)).run(flight.u, flight.z[0])

The continuous model is dx/dt = A x + B u + w in SI units; every channel of the INS measures one state, with white noise
and a first-order Gauss-Markov error. Faults multiply the standard deviation of the white noise for a while.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hnav.filters.linear_model import LinearModel
from hnav.simulation.aircraft import Aircraft, Control


@dataclass(frozen=True)
class Flight:
    u: np.ndarray  # (steps + 1) x m, row k held from step k - 1 to k
    x: np.ndarray  # runs x (steps + 1) x n: truth
    z: np.ndarray  # runs x (steps + 1) x n: measurements
    noise_factor: np.ndarray  # (steps + 1) x n


def model_of(aircraft: Aircraft, euler_colour: bool = False, sampled_noise: bool = True) -> LinearModel:
    """Discrete model. Zero-order hold for A and B; An = exp(-dt/tau), or the paper's Euler 1 - dt/tau.

    sampled_noise: w of variance density times dt on each state, the settings of the comparison table; otherwise the
    exact integral of continuous white noise, which correlates the states (Van Loan 1978).
    """
    dt, eye = aircraft.interval_s, np.eye(len(aircraft.A_1_s))
    ratio = dt / aircraft.ins_error_time_constant_s
    phi = 1 - ratio if euler_colour else np.exp(-ratio)
    Lambda0 = np.diag(aircraft.ins_error_sigma**2)
    Qw = np.diag(aircraft.process_noise**2) * dt
    exact = LinearModel(A=aircraft.A_1_s, B=aircraft.B_1_s, H=eye, Qw=Qw / dt, Qv=eye, P0=eye, interval_s=dt).discrete()
    return LinearModel(
        A=exact.A, B=exact.B, H=eye, An=np.diag(phi), Qw=Qw if sampled_noise else exact.Qw, Qv=np.diag(aircraft.measurement_sigma**2),
        QU=Lambda0 @ np.diag(1 - phi**2), Lambda0=Lambda0, P0=np.diag(aircraft.start_sigma**2),
    )  # fmt: skip


def inputs(aircraft: Aircraft, steps: int) -> np.ndarray:
    """(steps + 1) x m: row k is held from step k - 1 to step k, as InsErrorFilter.run takes it; row 0 is zero."""
    t = np.arange(-1.0, steps) * aircraft.interval_s
    u = np.stack([_wave(c, t) for c in aircraft.controls], axis=1)
    u[0] = 0
    return u


def noise_factors(aircraft: Aircraft, steps: int) -> np.ndarray:
    """(steps + 1) x n: factor on the standard deviation of the white noise."""
    factor = np.ones((steps + 1, len(aircraft.channels)))
    for f in aircraft.faults:
        factor[f.first_step : f.last_step + 1, f.channel] = f.noise_factor
    return factor


def _wave(control: Control, t_s: np.ndarray) -> np.ndarray:
    """The square wave of a control at these times."""
    # At zeros of the sine, rounding must not determine the sign.
    wave: np.ndarray = np.sign(np.round(np.sin(2 * np.pi * t_s / control.period_s + control.phase_rad), 9))
    return control.amplitude * wave


def simulate(aircraft: Aircraft, runs: int, steps: int, seed: int) -> Flight:
    """Truth and measurements of `runs` flights with equal controls. The truth is drawn from the filter's prior."""
    rng = np.random.default_rng(seed)
    size = (runs, len(aircraft.channels))
    return fly(aircraft, steps, lambda source, k: rng.normal(size=size), model_of(aircraft))


def fly(aircraft: Aircraft, steps: int, draw: Callable[[str, int], np.ndarray], model: LinearModel) -> Flight:
    """The flights for given noise. draw(source, k): standard normal numbers, runs x n, of step k and one of the sources
    process, colour (both give the start when k is 0) and measurement.
    """
    m = model.discrete()
    u, factor = inputs(aircraft, steps), noise_factors(aircraft, steps)
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
