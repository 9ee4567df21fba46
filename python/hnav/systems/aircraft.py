"""Linear aircraft from a model file (models/aircraft), as seen by an INS with time-correlated errors.

    aircraft = read_aircraft("models/aircraft/f4c_lateral.json")
    flight = simulate(aircraft, runs=100, steps=200, seed=1)
    InsErrorFilter(aircraft.model()).run(flight.u, flight.z[0])

The file holds the continuous model dx/dt = A x + B u + w in SI units; every channel of the INS measures one state, with
white noise and a first-order Gauss-Markov error. Faults multiply the standard deviation of the white noise for a while.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.linalg import expm

from hnav.errors import HnavValueError
from hnav.filters.ins_error import LinearModel
from hnav.io.model_files import model_files, read_json

LARGEST = 1e12  # in any unit; beyond lies nothing but overflow
DISPLAY = {("rad", "deg"): 180 / np.pi, ("rad/s", "deg/s"): 180 / np.pi}


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


# --------------------------------------------------------------------------------------------- model files


def models_folder() -> Path:
    return model_files("aircraft")


def read_aircraft(path: str | Path) -> Aircraft:
    """Raises HnavError, with the file's name and the reason, for data that no filter could use."""
    path = Path(path)

    def refuse(reason: str):
        raise HnavValueError("option", f"{path.name}: {reason}")

    data = read_json(path)

    def entry(name: str):
        value = data.get(name) if isinstance(data, dict) else None
        if value is None:
            refuse(f"{name} is missing")
        return value

    def array(name: str, shape: tuple[int, ...]) -> np.ndarray:
        given = entry(name)
        try:
            value = np.array(given, float)
        except (TypeError, ValueError, OverflowError):
            refuse(f"{name} is no array of numbers")
        if value.shape != shape:
            refuse(f"{name} has the shape {value.shape}, expected {shape}")
        if not np.isfinite(value).all():
            refuse(f"{name} is not finite")
        if (np.abs(value) > LARGEST).any():
            refuse(f"{name} holds a number beyond {LARGEST:g}")
        return value

    def sigma(name: str, above: bool = False) -> np.ndarray:
        value = array(name, (n,))
        if (value < 0).any() or (above and (value <= 0).any()):
            refuse(f"{name} must be {'above' if above else 'at least'} 0 in every channel")
        return value

    def objects(name: str, value) -> list[dict]:
        if not isinstance(value, list) or not all(isinstance(v, dict) for v in value):
            refuse(f"{name} is no list of objects")
        return value

    def number(holder: dict, name: str) -> float:
        value = holder[name]
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) <= LARGEST:
            refuse(f"{name} = {str(value)[:40]!r} is no finite number")
        return float(value)

    def text(holder: dict, name: str) -> str:
        if not isinstance(holder[name], str):
            refuse(f"{name} = {str(holder[name])[:40]!r} is no text")
        return holder[name]

    def fault(f: dict) -> Fault:
        if f["channel"] not in names:
            refuse(f"faults: there is no channel {str(f['channel'])[:40]}")
        found = Fault(
            names.index(f["channel"]), number(f, "noise_factor"), int(number(f, "first_step")), int(number(f, "last_step"))
        )
        if found.noise_factor <= 0 or not 0 <= found.first_step <= found.last_step:
            refuse("faults: noise_factor must be above 0, and 0 <= first_step <= last_step")
        return found

    entry("source")
    states, controls = objects("states", entry("states")), objects("inputs", entry("inputs"))
    n, m = len(states), len(controls)
    if not 1 <= n <= 32:
        refuse(f"states: {n} given, 1 to 32 can be used")
    if not 1 <= m <= 32:
        refuse(f"inputs: {m} given, 1 to 32 can be used")
    try:
        channels = tuple(
            Channel(text(s, "name"), text(s, "unit"), text(s, "display_unit"), DISPLAY.get((s["unit"], s["display_unit"]), 1.0))
            for s in states
        )
        inputs = tuple(
            Control(text(c, "name"), *(number(c, k) for k in ("amplitude", "period_s", "phase_rad"))) for c in controls
        )
        names = [c.name for c in channels]
        faults = tuple(fault(f) for f in objects("faults", data.get("faults", [])))
    except KeyError as error:
        refuse(f"{error.args[0]} is missing in states, inputs or faults")
    if any(c.period_s <= 0 for c in inputs):
        refuse("inputs: period_s must be above 0")
    entry("interval_s")
    interval = number(data, "interval_s")
    if interval <= 0:
        refuse("interval_s must be above 0")

    entry("name")
    A = array("A_1_s", (n, n))
    values = np.linalg.eigvals(A)
    unstable = values[values.real > 1e-9]
    if len(unstable):
        refuse(f"A_1_s is unstable: eigenvalue {unstable[0]:.4g} 1/s")
    return Aircraft(
        name=text(data, "name"), channels=channels, controls=inputs, A_1_s=A, B_1_s=array("B_1_s", (n, m)),
        process_noise=sigma("process_noise_per_sqrt_s"), measurement_sigma=sigma("measurement_sigma"),
        ins_error_sigma=sigma("ins_error_sigma"), ins_error_time_constant_s=sigma("ins_error_time_constant_s", above=True),
        start_sigma=sigma("start_sigma"), interval_s=interval, faults=faults,
    )  # fmt: skip
