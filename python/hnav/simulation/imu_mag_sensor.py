"""Gyroscope, accelerometer and magnetometer by their datasheets.

    table, sensor = Turntable(), ImuMagSensor(gyro_noise_deg_per_sqrt_h=0.3, seed=1)
    for t_s in times:
        sensor.sample(t_s, table.at(t_s))
        sensor.advance(t_s)
        sensor.reading("gyro").value

Each sensor samples truth at its period from start_s on. A sample that is due is taken at the next communication point and
stamped with the time of that point; it is delivered its latency later. Noise is a function of seed, sensor and sample:
neither communication steps nor the other sensors change it. What the errors are stands in hnav/simulation.h.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from typing import Any

from hnav.errors import HnavValueError
from hnav.native.arrays import Array, Record
from hnav.native.library import SENSORS, StatefulObject, continued, ffi
from hnav.native.options import OptionSet, complete
from hnav.simulation.turntable import Truth

KINDS = SENSORS[:3]
"""gyro, accel, mag."""


@dataclass(frozen=True, eq=False)
class Reading(Record):
    """The newest delivered sample of a sensor."""

    value: Array
    """3, sensor axes: rad/s, m/s2 or tesla."""
    t_meas_s: float
    """Time of sampling in s."""
    count: int
    """Samples delivered so far; 0: none, the rest is zero."""
    missed: int
    """Samples lost because communication points were too far apart."""
    dropped: int
    """Samples that were taken and are never delivered."""


class ImuMagSensorOptions(OptionSet):
    """Options of the sensors, as attributes: gyro_..., accel_..., mag_... of each, fault_..., and the seed.

        ImuMagSensorOptions(gyro_period_s=0.005, accel_noise_ug_per_sqrt_hz=100, seed=3)

    Raises HnavValueError for names (UnknownOptionError) and values that do not exist.
    """

    LIST = "imu_mag_sensor"


class ImuMagSensor(StatefulObject):
    """Sensors of 100 Hz without any error by default; the first sample is due at start_s.

        ImuMagSensor(seed=3)
        ImuMagSensor(ImuMagSensorOptions(seed=3), start_s=1.0)

    Raises HnavValueError for options that are impossible. Sensors are copied and pickled with their state.
    """

    KIND = "imu_mag_sensor"

    def __init__(self, options: ImuMagSensorOptions | None = None, start_s: float = 0.0, **values: object):
        self._options = complete(ImuMagSensorOptions, options, values)
        self._start_s = start_s
        super().__init__("hnav_imu_mag_sensor_create", self._options.struct, start_s)

    @property
    def options(self) -> ImuMagSensorOptions:
        """A copy of the options that the sensors were made with."""
        return copy(self._options)

    def __reduce__(self) -> tuple[Any, ...]:
        return continued, (ImuMagSensor, (self._options, self._start_s), self.save())

    def sample(self, t_s: float, truth: Truth) -> None:
        """A communication point: the sensors that are due sample truth, stamped t_s; twice at one time takes nothing twice.

        Raises HnavValueError, and takes nothing, for numbers that are not finite and for a truth that is no attitude.
        """
        self._call("sample", t_s, truth.struct("hnav_truth"))

    def advance(self, t_s: float) -> None:
        """Delivers what has arrived by t_s."""
        self._call("advance", t_s)

    def next_event_s(self) -> float:
        """Time in s at which the next sample is due or delivered."""
        time = ffi.new("double *")
        self._call("next_event_s", time)
        return float(time[0])

    def reading(self, sensor: str) -> Reading:
        """The newest delivered sample of "gyro", "accel" or "mag"."""
        return Reading.read(self._filled("hnav_reading", "reading", _number(sensor)))

    def noise_psd(self, sensor: str) -> float:
        """Two-sided spectral density of the white noise: rad2/s, m2/s3 or T2 s."""
        density = ffi.new("double *")
        self._call("noise_psd", _number(sensor), density)
        return float(density[0])


def _number(sensor: str) -> int:
    if sensor not in KINDS:
        raise HnavValueError("option", f"sensor = {sensor}: choose one of {', '.join(KINDS)}", "sensor")
    return KINDS.index(sensor)
