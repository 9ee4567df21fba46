"""Samples of the aids of the navigation filter, from any number of sources, in the order of their arrival."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from hnav.errors import HnavValueError
from hnav.native.arrays import Array, times
from hnav.native.library import SENSORS
from hnav.numbers import floats

AIDS = SENSORS[SENSORS.index("mag") :]
"""Kinds of aid: mag, heading, rest, speed, pressure, velocity, position."""


WIDTHS = {"mag": 3, "heading": 1, "rest": 0, "speed": 1, "pressure": 1, "velocity": 3, "position": 3}
"""Numbers of one sample."""


@dataclass
class Aids:
    """Samples of aids for Ins.run, from any number of sources. Each call adds m samples and answers the same object.

    t_s is the time of validity; received_s, where it differs, the time at which the filter is given the sample: the option
    horizon_s has to be at least their difference. Rows with a NaN are left out, but for a missing vertical velocity. A
    sigma is a number, or one for each row, or one for each row and axis.
    """

    _parts: list[tuple[Array, Array, int, Array]] = field(default_factory=list)
    """What was added, call by call: times of validity and of arrival, sensor, values."""

    def __repr__(self) -> str:
        t, _, sensor, _ = self.arrays()
        counts = [f"{(sensor == place).sum()} {kind}" for place, kind in enumerate(SENSORS) if (sensor == place).any()]
        return f"Aids({', '.join(counts)}; {t.min():.10g} to {t.max():.10g} s)" if counts else "Aids()"

    def position(
        self, t_s: npt.ArrayLike, latitude_rad: npt.ArrayLike, longitude_rad: npt.ArrayLike, height_m: npt.ArrayLike,
        sigma_n_m: npt.ArrayLike, received_s: npt.ArrayLike | None = None,
    ) -> Aids:  # fmt: skip
        """Places: m each; sigma north, east, down."""
        place = np.stack(np.broadcast_arrays(*(times(np.atleast_1d(v)) for v in (latitude_rad, longitude_rad, height_m))), 1)
        for name, values, largest in (("latitude_rad", place[:, 0], np.pi / 2), ("longitude_rad", place[:, 1], 2 * np.pi)):
            if len(values) and np.nanmax(np.abs(values), initial=0.0) > largest:
                shown = f"{name} = {values[np.nanargmax(np.abs(values))]:.6g}: beyond {largest:.4f} rad"
                raise HnavValueError("out of range", f"{shown}; of degrees take np.radians", name)
        return self._add("position", t_s, place, sigma_n_m, received_s)

    def velocity(
        self,
        t_s: npt.ArrayLike,
        velocity_n_m_s: npt.ArrayLike,
        sigma_n_m_s: npt.ArrayLike,
        received_s: npt.ArrayLike | None = None,
    ) -> Aids:
        """Velocities: m x 3, north, east, down, the last NaN where it is not known; sigma likewise."""
        return self._add("velocity", t_s, floats(velocity_n_m_s), sigma_n_m_s, received_s)

    def pressure(
        self, t_s: npt.ArrayLike, pressure_pa: npt.ArrayLike, sigma_pa: npt.ArrayLike, received_s: npt.ArrayLike | None = None
    ) -> Aids:
        """Pressures of the air: m."""
        return self._add("pressure", t_s, floats(pressure_pa), sigma_pa, received_s)

    def speed(
        self, t_s: npt.ArrayLike, speed_m_s: npt.ArrayLike, sigma_m_s: npt.ArrayLike, received_s: npt.ArrayLike | None = None
    ) -> Aids:
        """Speeds along body x: m."""
        return self._add("speed", t_s, floats(speed_m_s), sigma_m_s, received_s)

    def heading(
        self, t_s: npt.ArrayLike, heading_rad: npt.ArrayLike, sigma_rad: npt.ArrayLike, received_s: npt.ArrayLike | None = None
    ) -> Aids:
        """Headings of body x: m."""
        return self._add("heading", t_s, floats(heading_rad), sigma_rad, received_s)

    def mag(self, t_s: npt.ArrayLike, field_b: npt.ArrayLike, received_s: npt.ArrayLike | None = None) -> Aids:
        """Fields of a magnetometer: m x 3, any unit, in sensor axes; those of zero are left out."""
        field = np.atleast_2d(floats(field_b))
        field = np.where((field == 0).all(axis=-1, keepdims=True), np.nan, field)
        return self._add("mag", t_s, field, None, received_s)

    def rest(self, t_s: npt.ArrayLike, sigma_m_s: npt.ArrayLike, received_s: npt.ArrayLike | None = None) -> Aids:
        """Instants at which the body stands: m; sigma of its velocity."""
        return self._add("rest", t_s, np.empty((len(np.atleast_1d(np.asarray(t_s))), 0)), sigma_m_s, received_s)

    def and_those_of(self, others: Sequence[Aids]) -> Aids:
        """A new object with the samples of this one and of others."""
        return Aids([part for aids in (self, *others) for part in aids._parts])

    def arrays(self) -> tuple[Array, Array, npt.NDArray[np.int32], Array]:
        """Times of validity (m), times of arrival (m), places in SENSORS (m), values (m x 6); in the order of arrival."""
        if not self._parts:
            return np.empty(0), np.empty(0), np.empty(0, np.int32), np.empty((0, 6))
        t, received, value = (np.concatenate([part[i] for part in self._parts]) for i in (0, 1, 3))
        sensor = np.concatenate([np.full(len(part[0]), part[2], np.int32) for part in self._parts])
        order = np.argsort(received, kind="stable")
        return t[order], received[order], sensor[order], np.ascontiguousarray(value[order])

    def _add(
        self, sensor: str, t_s: npt.ArrayLike, values: np.ndarray, sigma: npt.ArrayLike | None, received_s: npt.ArrayLike | None
    ) -> Aids:
        t = times(np.atleast_1d(np.asarray(t_s)))
        shape = (len(t), WIDTHS[sensor])
        if values.shape not in (shape, (len(t),) if shape[1] == 1 else shape, shape[1:] if len(t) == 1 else shape):
            raise HnavValueError(
                "size", f"{sensor} has the shape {values.shape}, expected {shape}: one row for each of {len(t)} times", sensor
            )
        read = values.reshape(shape)
        width = 0 if sigma is None else max(1, read.shape[1])
        sigmas = floats(0.0 if sigma is None else sigma)
        sigmas = np.broadcast_to(sigmas[:, None] if sigmas.shape == (len(t),) else sigmas, (len(t), width))
        table = np.zeros((len(t), 6))
        table[:, : read.shape[1]] = read
        table[:, read.shape[1] : read.shape[1] + width] = sigmas
        needed = [0, 1, 3, 4] if sensor == "velocity" else range(read.shape[1] + width)
        received = t if received_s is None else times(np.atleast_1d(np.asarray(received_s)))
        if received.shape != t.shape:
            raise HnavValueError("size", f"received_s has the shape {received.shape}, expected {t.shape}", "received_s")
        whole = np.isfinite(table[:, list(needed)]).all(axis=1) & np.isfinite(t) & np.isfinite(received)
        self._parts.append((t[whole], received[whole], SENSORS.index(sensor), table[whole]))
        return self
