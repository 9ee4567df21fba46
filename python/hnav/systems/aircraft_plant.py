"""The simulated aircraft of the C library; simulation.h (section aircraft with an INS) is the reference.

    plant = AircraftPlant(read_aircraft("models/aircraft/f4c_longitudinal.json"), seed=1)
    flight = plant.run(201)
    InsErrorFilter(plant.filter_model()).run(flight.u, flight.z)

Its noise is a function of seed, source and sample; `normal_numbers` draws the same numbers in NumPy.
"""

from __future__ import annotations

import ctypes as C
from dataclasses import dataclass
from functools import cache

import numpy as np

from hnav.filters.ins_error import LinearModel, _Model
from hnav.native.library import LibraryObject, Options, _doubles, library
from hnav.systems.aircraft import Aircraft

# Streams of c_src/simulation/aircraft_flight.hpp, by the names that hnav.systems.aircraft.fly gives to sources.
STREAMS = {"process": 1000, "measurement": 1001, "colour": 1002, "gravity": 1003}


class _GaussMarkov(C.Structure):
    _fields_ = [("sigma", C.c_void_p), ("time_constant_s", C.c_void_p)]


class _AircraftModel(C.Structure):
    _fields_ = [
        ("nx", C.c_int32), ("nu", C.c_int32), ("interval_s", C.c_double),
        *((n, C.c_void_p) for n in ("A_1_s", "B_1_s", "process_noise_per_sqrt_s", "measurement_sigma")),
        ("accelerometer_error", _GaussMarkov), ("gravity_error", _GaussMarkov),
        *((n, C.c_void_p) for n in ("start", "start_sigma", "commands", "faults")),
    ]  # fmt: skip


ARRAYS = ("x", "lam", "z", "u", "noise_factor")


class _Sample(C.Structure):
    _fields_ = [("k", C.c_uint64), ("t_s", C.c_double), *((n, C.c_void_p) for n in ARRAYS)]


@cache
def _library() -> C.CDLL:
    lib = library()
    p = C.c_void_p
    lib.hnav_aircraft_message.restype = C.c_char_p
    for name, arguments in {
        "create": [p, p, p, p, C.c_size_t], "destroy": [p], "reset": [p], "message": [p], "step": [p, p],
        "get_sample": [p, p], "run": [p, C.c_size_t, p, p], "filter_model": [p, p], "state_size": [p, p],
        "save": [p, p, C.c_size_t], "load": [p, p, C.c_size_t],
    }.items():  # fmt: skip
        getattr(lib, f"hnav_aircraft_{name}").argtypes = arguments
    return lib


@dataclass
class PlantFlight:
    """Row k is sample k of the run."""

    x: np.ndarray  # n x nx, truth
    lam: np.ndarray  # n x nx, coloured error
    z: np.ndarray  # n x nx, measurement
    u: np.ndarray  # n x nu, held up to the sample
    noise_factor: np.ndarray  # n x nx, on the standard deviation of the white noise


class AircraftPlant(LibraryObject):
    """Every method is the C function of that name and raises HnavError with its message.

    gravity_sigma, gravity_time_constant_s: nx each, a second coloured error; controls: with the file's square waves;
    faults: with the file's faults.
    """

    KIND = "aircraft"

    def __init__(
        self,
        aircraft: Aircraft,
        seed: int = 0,
        euler_colour: bool = False,
        exact_process_noise: bool = False,
        gravity_sigma: np.ndarray | None = None,
        gravity_time_constant_s: np.ndarray | None = None,
        controls: bool = True,
        faults: bool = True,
    ):
        lib = _library()
        self.nx, self.nu = len(aircraft.channels), len(aircraft.controls)
        options = Options("aircraft", seed=seed, euler_colour=euler_colour, exact_process_noise=exact_process_noise)
        windows = np.tile([0.0, 0.0, 1.0], (self.nx, 1))
        for fault in aircraft.faults:
            windows[fault.channel] = (
                fault.first_step * aircraft.interval_s,
                fault.last_step * aircraft.interval_s,
                fault.noise_factor,
            )
        waves = np.array([[c.amplitude, c.period_s, c.phase_rad] for c in aircraft.controls])
        n = (self.nx,)
        arrays = dict(
            A_1_s=_doubles(aircraft.A_1_s, n * 2, "A_1_s"), B_1_s=_doubles(aircraft.B_1_s, (self.nx, self.nu), "B_1_s"),
            process_noise_per_sqrt_s=_doubles(aircraft.process_noise, n, "process_noise"),
            measurement_sigma=_doubles(aircraft.measurement_sigma, n, "measurement_sigma"),
            start_sigma=_doubles(aircraft.start_sigma, n, "start_sigma"),
        )  # fmt: skip
        if controls:
            arrays["commands"] = waves
        if faults:
            arrays["faults"] = windows
        errors = [
            _doubles(aircraft.ins_error_sigma, n, "ins_error_sigma"),
            _doubles(aircraft.ins_error_time_constant_s, n, "ins_error_time_constant_s"),
        ]
        if gravity_sigma is not None:
            errors.append(_doubles(gravity_sigma, n, "gravity_sigma"))
            errors.append(
                _doubles(
                    np.full(n, np.nan) if gravity_time_constant_s is None else gravity_time_constant_s,
                    n,
                    "gravity_time_constant_s",
                )
            )
        pointers = [array.ctypes.data for array in errors]
        model = _AircraftModel(
            nx=self.nx, nu=self.nu, interval_s=aircraft.interval_s, accelerometer_error=_GaussMarkov(*pointers[:2]),
            gravity_error=_GaussMarkov(*pointers[2:]), **{name: array.ctypes.data for name, array in arrays.items()},
        )  # fmt: skip
        super().__init__(lib, lib.hnav_aircraft_create, C.byref(options.struct), C.byref(model))

    def run(self, n: int, command: np.ndarray | None = None) -> PlantFlight:
        """n samples from the present one on; command: n x nu, row k held from sample k to k + 1."""
        if command is not None:
            command = _doubles(command, (n, self.nu), "command")
        flight = PlantFlight(**{name: np.empty((n, self.nu if name == "u" else self.nx)) for name in ARRAYS})
        output = _Sample(0, 0.0, *(getattr(flight, name).ctypes.data for name in ARRAYS))
        self._call("run", n, None if command is None else command.ctypes.data, C.byref(output))
        return flight

    def filter_model(self) -> LinearModel:
        """The discrete model that a filter of this aircraft needs."""
        m = _Model()
        self._call("filter_model", C.byref(m))

        def copied(address: int, *shape: int) -> np.ndarray:
            return np.ctypeslib.as_array(C.cast(address, C.POINTER(C.c_double)), shape).copy()

        square = {
            name: copied(getattr(m, name), self.nx, self.nx) for name in ("A", "H", "An", "Qw", "Qv", "QU", "Lambda0", "P0")
        }
        return LinearModel(**square, B=copied(m.B, self.nx, self.nu), x0=copied(m.x0, self.nx))

    def reset(self) -> None:
        self._call("reset")


def normal_numbers(seed: int, stream: int, count: int) -> np.ndarray:
    """The first numbers of a stream of c_src/simulation/random.hpp: Philox, then Box and Muller."""
    words = np.random.Philox(key=[seed, stream]).random_raw(count + count % 2)
    pairs = (words >> np.uint64(11)).reshape(-1, 2) * 2.0**-53
    radius, angle = np.sqrt(-2 * np.log(1 - pairs[:, 0])), 2 * np.pi * pairs[:, 1]
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1).ravel()[:count]
