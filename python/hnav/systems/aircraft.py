"""Reads aircraft from model files (models/aircraft); refuses unusable ones with the reason."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from hnav.io.model_files import ModelFile, model_files
from hnav.simulation.aircraft import Aircraft, Channel, Control, Fault

LARGEST = 1e12  # in any unit; larger numbers would overflow
MOST = 32  # states, and inputs
DISPLAY = {("rad", "deg"): 180 / np.pi, ("rad/s", "deg/s"): 180 / np.pi}


def models_folder() -> Path:
    return model_files("aircraft")


def read_aircraft(path: str | Path) -> Aircraft:
    """Raises HnavError, with the file's name and the reason, for unusable data."""
    file = _AircraftFile(Path(path))
    file.entry("source")
    states, controls = file.objects("states"), file.objects("inputs")
    n, m = len(states), len(controls)
    for name, count in (("states", n), ("inputs", m)):
        if not 1 <= count <= MOST:
            file.refuse(f"{name}: {count} given, 1 to {MOST} can be used")
    try:
        channels = tuple(file.channel(state) for state in states)
        inputs = tuple(file.control(control) for control in controls)
        faults = tuple(file.fault(fault, [c.name for c in channels]) for fault in file.objects("faults", []))
    except KeyError as error:
        file.refuse(f"{error.args[0]} is missing in states, inputs or faults")
    file.entry("interval_s")
    interval_s = file.number(file.data, "interval_s")
    if interval_s <= 0:
        file.refuse("interval_s must be above 0")
    file.entry("name")
    return Aircraft(
        name=file.text(file.data, "name"), channels=channels, controls=inputs, A_1_s=file.stable("A_1_s", n),
        B_1_s=file.array("B_1_s", (n, m)), process_noise=file.sigma("process_noise_per_sqrt_s", n),
        measurement_sigma=file.sigma("measurement_sigma", n), ins_error_sigma=file.sigma("ins_error_sigma", n),
        ins_error_time_constant_s=file.sigma("ins_error_time_constant_s", n, above=True),
        start_sigma=file.sigma("start_sigma", n), interval_s=interval_s, faults=faults,
    )  # fmt: skip


class _AircraftFile(ModelFile):
    """Entries of the expected type. KeyError: an object in a list lacks an entry."""

    def objects(self, name: str, default: list[dict[str, Any]] | None = None) -> list[dict[str, Any]]:
        value = self.entry(name) if default is None else self.data.get(name, default)
        if not isinstance(value, list) or not all(isinstance(v, dict) for v in value):
            self.refuse(f"{name} is no list of objects")
        return value

    def number(self, holder: dict[str, Any], name: str) -> float:
        value = holder[name]
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) <= LARGEST:
            self.refuse(f"{name} = {str(value)[:40]!r} is no finite number")
        return float(value)

    def text(self, holder: dict[str, Any], name: str) -> str:
        value = holder[name]
        if not isinstance(value, str):
            self.refuse(f"{name} = {str(value)[:40]!r} is no text")
        return value

    def array(self, name: str, shape: tuple[int, ...]) -> np.ndarray:
        given = self.entry(name)
        try:
            value = np.array(given, float)
        except (TypeError, ValueError, OverflowError):
            self.refuse(f"{name} is no array of numbers")
        if value.shape != shape:
            self.refuse(f"{name} has the shape {value.shape}, expected {shape}")
        if not np.isfinite(value).all():
            self.refuse(f"{name} is not finite")
        if (np.abs(value) > LARGEST).any():
            self.refuse(f"{name} holds a number beyond {LARGEST:g}")
        return value

    def sigma(self, name: str, n: int, above: bool = False) -> np.ndarray:
        value = self.array(name, (n,))
        if (value < 0).any() or (above and (value <= 0).any()):
            self.refuse(f"{name} must be {'above' if above else 'at least'} 0 in every channel")
        return value

    def stable(self, name: str, n: int) -> np.ndarray:
        """n x n, without an eigenvalue in the right half-plane."""
        A = self.array(name, (n, n))
        values = np.linalg.eigvals(A)
        unstable = values[values.real > 1e-9]
        if len(unstable):
            self.refuse(f"{name} is unstable: eigenvalue {unstable[0]:.4g} 1/s")
        return A

    def channel(self, state: dict[str, Any]) -> Channel:
        name, unit, shown = (self.text(state, key) for key in ("name", "unit", "display_unit"))
        return Channel(name, unit, shown, DISPLAY.get((unit, shown), 1.0))

    def control(self, control: dict[str, Any]) -> Control:
        name = self.text(control, "name")
        amplitude, period_s, phase_rad = (self.number(control, key) for key in ("amplitude", "period_s", "phase_rad"))
        if period_s <= 0:
            self.refuse("inputs: period_s must be above 0")
        return Control(name, amplitude, period_s, phase_rad)

    def fault(self, fault: dict[str, Any], channels: list[str]) -> Fault:
        if fault["channel"] not in channels:
            self.refuse(f"faults: there is no channel {str(fault['channel'])[:40]}")
        first, last = (int(self.number(fault, key)) for key in ("first_step", "last_step"))
        found = Fault(channels.index(fault["channel"]), self.number(fault, "noise_factor"), first, last)
        if found.noise_factor <= 0 or not 0 <= found.first_step <= found.last_step:
            self.refuse("faults: noise_factor must be above 0, and 0 <= first_step <= last_step")
        return found
