"""The random numbers of the simulated aircraft again in NumPy: a function of seed, stream and sample."""

from __future__ import annotations

import numpy as np

from hnav.native.arrays import Array

# Streams of c_src/simulation/aircraft_flight.hpp, by the names that twins.aircraft.fly gives to sources.
STREAMS = {"process": 1000, "measurement": 1001, "colour": 1002, "gravity": 1003}


def normal_numbers(seed: int, stream: int, count: int) -> Array:
    """The first numbers of a stream of c_src/simulation/random.hpp: Philox, then Box and Muller."""
    words = np.random.Philox(key=[seed, stream]).random_raw(count + count % 2)
    pairs = (words >> np.uint64(11)).reshape(-1, 2) * 2.0**-53
    radius, angle = np.sqrt(-2 * np.log(1 - pairs[:, 0])), 2 * np.pi * pairs[:, 1]
    numbers: Array = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1).ravel()[:count]
    return numbers
