"""Simulated flights of an aircraft whose INS has coloured errors: the estimates of each filter for each state.

    for channel in channels(read_run(DIR)): ...

A flight is a run of `hnav simulate` with components with outputs truth.NAME and fault.NAME of each state (AircraftIns*), and
components that estimate the same states (InsErrorFilter*).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hnav.native.arrays import stretches
from hnav.reports.colours import BLUE, FAINT, INK, ORANGE, PURPLE, VERMILION
from hnav.systems.results import Run

COLOURS = {"mdkf": FAINT, "amdkf": VERMILION, "augmented": BLUE, "differenced": PURPLE, "plain": ORANGE}
DISPLAY = {"rad": ("deg", np.degrees(1)), "rad/s": ("deg/s", np.degrees(1))}
# Of the axes of the body, as models/aircraft names them.
WORDS = {
    "u": "forward velocity", "w": "downward velocity", "q": "pitch rate", "theta": "pitch",
    "v": "side velocity", "p": "roll rate", "r": "yaw rate", "phi": "roll", "psi": "yaw", "beta": "sideslip",
}  # fmt: skip
# Smallest number of samples for the mean error of a stretch.
FEWEST = 10


@dataclass(frozen=True)
class Track:
    """Estimates of a state at the times of their samples; arrays of n, in the channel's unit."""

    filter: str
    t_s: np.ndarray
    estimate: np.ndarray
    error: np.ndarray
    sigma: np.ndarray
    innovation: np.ndarray
    noise_scale: np.ndarray
    fault_probability: np.ndarray
    bias_fault_probability: np.ndarray
    process_fault_probability: np.ndarray


@dataclass(frozen=True)
class Channel:
    """A state of an aircraft: truth, measurement and fault at the samples t_s, and the tracks of all its filters."""

    aircraft: str
    name: str
    unit: str
    t_s: np.ndarray
    truth: np.ndarray
    measurement: np.ndarray
    fault: np.ndarray  # bool
    tracks: tuple[Track, ...]

    @property
    def title(self) -> str:
        return f"{WORDS.get(self.name, self.name)} {self.name}"

    def fault_windows(self) -> list[tuple[float, float]]:
        """First and last time of each stretch of samples with more noise."""
        return [(self.t_s[i], self.t_s[j - 1]) for i, j in stretches(self.fault)]

    def rmse(self, track: Track, faulty: bool) -> float:
        """Root mean square error of the samples with, or without, more noise in this channel; NaN for too few."""
        fault = self.fault[_held(self.t_s, track.t_s)]
        used = track.error[fault == faulty]
        return float(np.sqrt(np.mean(used**2))) if len(used) >= FEWEST else np.nan


def _states(run: Run, component: str, quantity: str) -> list[str]:
    prefix = f"{component}.{quantity}."
    return [name[len(prefix) :] for name in run.columns if name.startswith(prefix)]


def is_flight(run: Run) -> bool:
    return bool(channels(run))


def channels(run: Run) -> list[Channel]:
    """All states of all aircraft of a run; empty when there is no aircraft or no filter for it."""
    filters = {c: set(_states(run, c, "estimate")) for c in run.components}
    found = []
    for aircraft in run.components:
        states = _states(run, aircraft, "truth")
        if not states or not run.has(aircraft, *(f"fault.{name}" for name in states)):
            continue
        own = [c for c, names in filters.items() if names == set(states)]
        found += [_channel(run, aircraft, name, own) for name in states if own]
    return found


def _channel(run: Run, aircraft: str, name: str, filters: list[str]) -> Channel:
    unit, factor = DISPLAY.get(run.units[f"{aircraft}.truth.{name}"], (run.units[f"{aircraft}.truth.{name}"], 1.0))
    truth = factor * run[f"{aircraft}.truth.{name}"]
    tracks = tuple(_track(run, c, aircraft, name, factor, truth) for c in filters)
    fault = run[f"{aircraft}.fault.{name}"] > 0.5
    return Channel(aircraft, name, unit, run.t_s, truth, factor * run[f"{aircraft}.z.{name}"], fault, tracks)


def _track(run: Run, component: str, aircraft: str, name: str, factor: float, truth: np.ndarray) -> Track:
    # Some forms estimate one sample late, and a communication point may have no sample: post.t is the time of a row's estimate.
    t_s = run[f"{component}.post.t"]
    rows = np.flatnonzero(np.diff(t_s, prepend=-np.inf) > 0)

    def column(quantity: str, factor: float = 1.0) -> np.ndarray:
        return factor * run[f"{component}.{quantity}.{name}"][rows]

    estimate = column("estimate", factor)
    # aircraft_longitudinal and amdkf_longitudinal: the part in common says nothing.
    suffix = aircraft[aircraft.rfind("_") :] if "_" in aircraft else ""
    label = component.removesuffix(suffix) if suffix else component
    error = estimate - truth[_held(run.t_s, t_s[rows])]
    return Track(
        label, t_s[rows], estimate, error, column("sigma", factor), column("innov", factor), column("noise_scale"),
        column("fault_probability"), column("bias_fault_probability"), run[f"{component}.process_fault_probability"][rows],
    )  # fmt: skip


def _held(t_s: np.ndarray, at_s: np.ndarray) -> np.ndarray:
    """Rows of t_s that hold at the times at_s, against rounding."""
    return np.clip(np.searchsorted(t_s, at_s + 1e-9) - 1, 0, None)


def colour(filter: str) -> str:
    return COLOURS.get(filter, INK)
