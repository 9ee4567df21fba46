"""Linear aircraft as seen by an INS with time-correlated errors, flown by the C library.

    plant = AircraftPlant(aircraft, seed=1)             # hnav.systems.aircraft.read_aircraft reads one from a file
    flight = plant.run(201)
    InsErrorFilter(plant.filter_model()).run(flight.u, flight.z)

    dx/dt = A x + B u + w                    u held from sample to sample
    z(k) = x(k) + v(k) + lambda(k)           k = 0, 1, ... at the times k interval_s

lambda is the sum of two first-order Gauss-Markov errors, of the accelerometers and of the gravity model. Units are the
model's. Noise is a function of seed, source and sample: equal seeds fly equal flights.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from hnav.filters.linear_model import LinearModel
from hnav.native.arrays import Array, address, doubles
from hnav.native.library import StatefulObject, ffi, new
from hnav.native.options import OptionSet


@dataclass(frozen=True)
class Channel:
    """A state, as the INS measures it."""

    name: str
    """Of the state."""
    unit: str
    """Of the numbers of the model."""
    display_unit: str
    """Of pictures and tables."""
    display_factor: float
    """Display unit for each unit."""


@dataclass(frozen=True)
class Control:
    """Square wave: amplitude times the sign of sin(2 pi t / period_s + phase_rad)."""

    name: str
    """Of the control."""
    amplitude: float
    """In the unit of the control."""
    period_s: float
    """Of the sine whose sign it has."""
    phase_rad: float
    """Of that sine."""


@dataclass(frozen=True)
class Fault:
    """A fault: increased white noise of a channel over some samples."""

    channel: int
    """Its index."""
    noise_factor: float
    """On the standard deviation."""
    first_step: int
    """Of the samples at fault."""
    last_step: int
    """Included."""


@dataclass(frozen=True)
class Aircraft:
    """A linear aircraft of n channels and m controls, its INS and its faults, in units of its own."""

    name: str
    """Of the aircraft and its axis."""
    channels: tuple[Channel, ...]
    """n."""
    controls: tuple[Control, ...]
    """m."""
    A_1_s: Array
    """n x n, in 1/s times the units of the channels."""
    B_1_s: Array
    """n x m."""
    process_noise: Array
    """n: standard deviations for the root of a second."""
    measurement_sigma: Array
    """n: of the white noise of a sample."""
    ins_error_sigma: Array
    """n: of the coloured error, stationary."""
    ins_error_time_constant_s: Array
    """n."""
    start_sigma: Array
    """n: of the state at the first sample."""
    interval_s: float
    """Between samples."""
    faults: tuple[Fault, ...]
    """Of the sensors."""


# --------------------------------------------------------------------------------------------- flown


@dataclass
class PlantFlight:
    """Row k is sample k of the run."""

    x: Array
    """n x nx: truth."""
    lam: Array
    """n x nx: coloured error, both parts."""
    z: Array
    """n x nx: measurement."""
    u: Array
    """n x nu: controls that were held up to the sample; zero at sample 0."""
    noise_factor: Array
    """n x nx: on the standard deviation of the white noise; 1 without fault."""


class AircraftOptions(OptionSet):
    """Seed and kinds of noise of the plant, as attributes."""

    LIST = "aircraft"


class AircraftPlant(StatefulObject):
    """An aircraft that flies: truth and measurements, sample after sample.

    aircraft: what flies. seed: of all noise. euler_colour: lambda by 1 - dt/tau, as the paper prints, instead of exactly.
    exact_process_noise: w integrated over the interval, which correlates the states (Van Loan 1978), instead of independent
    noise of variance density times interval. gravity_sigma, gravity_time_constant_s: nx each, a second coloured error.
    controls: with the aircraft's square waves. faults: with the aircraft's faults.

    Raises HnavValueError, naming the entry, for an aircraft that cannot fly: an A that grows, numbers out of range.
    """

    KIND = "aircraft"

    def __init__(
        self,
        aircraft: Aircraft,
        seed: int = 0,
        euler_colour: bool = False,
        exact_process_noise: bool = False,
        gravity_sigma: npt.ArrayLike | None = None,
        gravity_time_constant_s: npt.ArrayLike | None = None,
        controls: bool = True,
        faults: bool = True,
    ):
        self.nx, self.nu = len(aircraft.channels), len(aircraft.controls)
        chosen = dict(seed=seed, euler_colour=euler_colour, exact_process_noise=exact_process_noise)
        options = AircraftOptions(**chosen)
        kept = _struct_arrays(aircraft)
        model = new("hnav_aircraft_model", nx=self.nx, nu=self.nu, interval_s=aircraft.interval_s,
                    **{name: address(array) for name, array in kept.items()})  # fmt: skip
        waves, windows = _waves(aircraft), _windows(aircraft)
        model.commands = waves if controls else ffi.NULL
        model.faults = windows if faults else ffi.NULL
        errors = [_error(aircraft.ins_error_sigma, aircraft.ins_error_time_constant_s, self.nx, "ins_error")]
        if gravity_sigma is not None:
            time_constant_s = np.full(self.nx, np.nan) if gravity_time_constant_s is None else gravity_time_constant_s
            errors.append(_error(gravity_sigma, time_constant_s, self.nx, "gravity"))
        for member, (sigma, time_constant_s) in zip((model.accelerometer_error, model.gravity_error), errors):
            member.sigma, member.time_constant_s = address(sigma), address(time_constant_s)
        super().__init__("hnav_aircraft_create", options.struct, model)

    def run(self, n: int, command: npt.ArrayLike | None = None) -> PlantFlight:
        """n samples from the present one on; command: n x nu, row k held from sample k to k + 1, added to the square waves.

        Raises HnavValueError for commands that are not finite.
        """
        held = None if command is None else doubles(command, (n, self.nu), "command")
        nx, nu = (n, self.nx), (n, self.nu)
        flight = PlantFlight(x=np.empty(nx), lam=np.empty(nx), z=np.empty(nx), u=np.empty(nu), noise_factor=np.empty(nx))
        rows = {"lambda" if name == "lam" else name: address(array) for name, array in vars(flight).items()}
        self._call("run", n, address(held), new("hnav_aircraft_sample", **rows))
        return flight

    def filter_model(self) -> LinearModel:
        """The discrete model that a filter of this aircraft needs; its lambda is the accelerometer error alone."""
        m = new("hnav_ins_error_model")
        self._call("filter_model", m)

        def copied(name: str, *shape: int) -> Array:
            numbers = ffi.buffer(getattr(m, name), int(np.prod(shape)) * ffi.sizeof("double"))
            return np.frombuffer(numbers).reshape(shape).copy()

        def square(name: str) -> Array:
            return copied(name, self.nx, self.nx)

        return LinearModel(
            A=square("A"), B=copied("B", self.nx, self.nu), H=square("H"), An=square("An"), Qw=square("Qw"), Qv=square("Qv"),
            QU=square("QU"), Lambda0=square("Lambda0"), x0=copied("x0", self.nx), P0=square("P0"),
        )  # fmt: skip


def _struct_arrays(aircraft: Aircraft) -> dict[str, Array]:
    """By the names of hnav_aircraft_model."""
    n, m = len(aircraft.channels), len(aircraft.controls)
    return dict(
        A_1_s=doubles(aircraft.A_1_s, (n, n), "A_1_s"), B_1_s=doubles(aircraft.B_1_s, (n, m), "B_1_s"),
        process_noise_per_sqrt_s=doubles(aircraft.process_noise, (n,), "process_noise"),
        measurement_sigma=doubles(aircraft.measurement_sigma, (n,), "measurement_sigma"),
        start_sigma=doubles(aircraft.start_sigma, (n,), "start_sigma"),
    )  # fmt: skip


def _error(sigma: npt.ArrayLike, time_constant_s: npt.ArrayLike, n: int, name: str) -> tuple[Array, Array]:
    return doubles(sigma, (n,), f"{name}_sigma"), doubles(time_constant_s, (n,), f"{name}_time_constant_s")


def _waves(aircraft: Aircraft) -> Any:
    waves = ffi.new("hnav_square_wave[]", len(aircraft.controls))
    for wave, control in zip(waves, aircraft.controls):
        wave.amplitude, wave.period_s, wave.phase_rad = control.amplitude, control.period_s, control.phase_rad
    return waves


def _windows(aircraft: Aircraft) -> Any:
    windows = ffi.new("hnav_noise_fault[]", len(aircraft.channels))
    for window in windows:
        window.stop_s, window.factor = 0.0, 1.0
    for fault in aircraft.faults:
        window = windows[fault.channel]
        window.start_s, window.stop_s = fault.first_step * aircraft.interval_s, fault.last_step * aircraft.interval_s
        window.factor = fault.noise_factor
    return windows
