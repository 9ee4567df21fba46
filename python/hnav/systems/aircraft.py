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
from scipy.linalg import expm

from hnav.filters.ins_error import LinearModel


@dataclass(frozen=True)
class Channel:
    name: str
    unit: str  # of the file's numbers
    display_unit: str
    display_factor: float


@dataclass(frozen=True)
class Control:
    """Square wave: amplitude times the sign of sin(2 pi t / period_s + phase_rad)."""

    name: str
    amplitude: float
    period_s: float
    phase_rad: float

    def at(self, t_s: np.ndarray) -> np.ndarray:
        # Rounding must not decide the sign where the sine is zero.
        return self.amplitude * np.sign(np.round(np.sin(2 * np.pi * t_s / self.period_s + self.phase_rad), 9))


@dataclass(frozen=True)
class Fault:
    channel: int
    noise_factor: float  # on the standard deviation
    first_step: int
    last_step: int  # included


@dataclass(frozen=True)
class Aircraft:
    name: str
    channels: tuple[Channel, ...]
    controls: tuple[Control, ...]
    A_1_s: np.ndarray  # n x n
    B_1_s: np.ndarray  # n x m
    process_noise: np.ndarray  # n, per sqrt(s)
    measurement_sigma: np.ndarray  # n
    ins_error_sigma: np.ndarray  # n, stationary
    ins_error_time_constant_s: np.ndarray  # n
    start_sigma: np.ndarray  # n
    interval_s: float
    faults: tuple[Fault, ...]

    def model(self, euler_colour: bool = False, sampled_noise: bool = True) -> LinearModel:
        """Discrete model. Zero-order hold for A and B; An = exp(-dt/tau), or the paper's Euler 1 - dt/tau.

        sampled_noise: w of variance density times dt on each state, the settings of the comparison table; otherwise the
        exact integral of continuous white noise, which correlates the states (Van Loan 1978).
        """
        dt, n, m = self.interval_s, len(self.A_1_s), self.B_1_s.shape[1]
        ratio = dt / self.ins_error_time_constant_s
        phi = 1 - ratio if euler_colour else np.exp(-ratio)
        Lambda0 = np.diag(self.ins_error_sigma**2)
        held = expm(np.block([[self.A_1_s, self.B_1_s], [np.zeros((m, n + m))]]) * dt)
        Qw = np.diag(self.process_noise**2) * dt
        if not sampled_noise:
            exact = LinearModel(A=self.A_1_s, H=np.eye(n), Qw=Qw / dt, Qv=np.eye(n), P0=np.eye(n), interval_s=dt)
            Qw = exact.discrete().Qw
        return LinearModel(
            A=held[:n, :n], B=held[:n, n:], H=np.eye(n), An=np.diag(phi), Qw=Qw, Qv=np.diag(self.measurement_sigma**2),
            QU=Lambda0 @ np.diag(1 - phi**2), Lambda0=Lambda0, P0=np.diag(self.start_sigma**2),
        )  # fmt: skip

    def inputs(self, steps: int) -> np.ndarray:
        """(steps + 1) x m: row k is held from step k - 1 to step k, as InsErrorFilter.run takes it; row 0 is zero."""
        t = (np.arange(steps + 1) - 1) * self.interval_s
        u = np.stack([c.at(t) for c in self.controls], axis=1)
        u[0] = 0
        return u

    def noise_factors(self, steps: int) -> np.ndarray:
        """(steps + 1) x n: factor on the standard deviation of the white noise."""
        factor = np.ones((steps + 1, len(self.channels)))
        for f in self.faults:
            factor[f.first_step : f.last_step + 1, f.channel] = f.noise_factor
        return factor


@dataclass(frozen=True)
class Flight:
    u: np.ndarray  # (steps + 1) x m, row k held from step k - 1 to k
    x: np.ndarray  # runs x (steps + 1) x n: truth
    z: np.ndarray  # runs x (steps + 1) x n: measurements
    noise_factor: np.ndarray  # (steps + 1) x n


def simulate(aircraft: Aircraft, runs: int, steps: int, seed: int) -> Flight:
    """Truth and measurements of `runs` flights with equal controls. The truth starts where the filter's prior says."""
    rng = np.random.default_rng(seed)
    size = (runs, len(aircraft.channels))
    return fly(aircraft, steps, lambda source, k: rng.normal(size=size), aircraft.model())


def fly(aircraft: Aircraft, steps: int, draw: Callable[[str, int], np.ndarray], model: LinearModel) -> Flight:
    """The flights that noise makes. draw(source, k): standard normal numbers, runs x n, of step k and one of the sources
    process, colour (both make the start when k is 0) and measurement."""
    m = model.discrete()
    u, factor = aircraft.inputs(steps), aircraft.noise_factors(steps)
    diagonal = np.count_nonzero(m.Qw - np.diag(np.diag(m.Qw))) == 0
    w_factor = np.diag(np.sqrt(np.diag(m.Qw))) if diagonal else np.linalg.cholesky(m.Qw)
    U_sigma, v_sigma = (np.sqrt(np.diag(Q)) for Q in (m.QU, m.Qv))
    x, z = [], []
    for k in range(steps + 1):
        n_process, n_colour = draw("process", k), draw("colour", k)
        if k == 0:
            state, error = n_process * aircraft.start_sigma, n_colour * aircraft.ins_error_sigma
        else:
            state = state @ m.A.T + m.B @ u[k] + n_process @ w_factor.T
            error = error @ m.An.T + n_colour * U_sigma
        x.append(state)
        z.append(state @ m.H.T + error + draw("measurement", k) * v_sigma * factor[k])
    return Flight(u, np.stack(x, axis=1), np.stack(z, axis=1), factor)
