"""The calls that the AHRS, the HREKF and the INS share."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from copy import copy
from typing import Any, ParamSpec, TypeVar

import numpy.typing as npt

from hnav.errors import HnavValueError
from hnav.filters.filter_answers import Attitude, Diagnostics, Health, Innovation
from hnav.filters.hybrid_view import HybridView
from hnav.filters.options import Options
from hnav.native.arrays import Array, address, doubles
from hnav.native.library import SENSORS, continued

Arguments = ParamSpec("Arguments")
Made = TypeVar("Made")


def with_arguments_of(run: Callable[Arguments, Made]) -> Callable[[Callable[..., Made]], Callable[Arguments, Made]]:
    """A method with the arguments of another one, in its signature too: they are stated once."""

    def shown(method: Callable[..., Made]) -> Callable[Arguments, Made]:
        known = inspect.signature(run)
        kept = [one for name, one in known.parameters.items() if name != method.__name__]
        method.__signature__ = known.replace(parameters=kept)  # type: ignore[attr-defined]
        return method

    return shown


class FilterObject(HybridView):
    """A filter: a hybrid system whose estimate flows between samples and jumps at each of them.

    Samples are pushed with their times of validity, which may come in any order within one instant and between two calls of advance,
    and up to the option horizon_s late. Every call that fails leaves the estimate as it was. Filters are copied and pickled
    with their state.
    """

    KIND = "filter"
    _options: Options
    """The options that the filter was made with."""

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self._options!r})"

    def __reduce__(self) -> tuple[Any, ...]:
        return continued, (type(self), (copy(self._options),), self.save())

    @property
    def options(self) -> Options:
        """A copy of the options that the filter was made with."""
        return copy(self._options)

    # ----------------------------------------------------------------------------------------- samples

    def push_mag(self, t_s: float, field_b_tesla: npt.ArrayLike) -> None:
        """A sample of the magnetometer: field_b_tesla is 3, in sensor axes, of the INS in any unit.

        Raises HnavValueError for numbers that are not finite and for a zero vector, HnavRuntimeError for late samples, a full queue,
        and a sensor that the filter has no use for; the other push calls likewise.
        """
        self._call("push_mag", t_s, address(doubles(field_b_tesla, (3,), "field_b_tesla")))

    def push_imu(self, t_s: float, rate_b_rad_s: npt.ArrayLike, force_b_m_s2: npt.ArrayLike) -> None:
        """Rate and force of one instant, both or neither: 3 each, in sensor axes."""
        rate, force = doubles(rate_b_rad_s, (3,), "rate_b_rad_s"), doubles(force_b_m_s2, (3,), "force_b_m_s2")
        self._call("push_imu", t_s, address(rate), address(force))

    def push_heading(self, t_s: float, heading_rad: float, sigma_rad: float) -> None:
        """Heading of body x, clockwise from north, by another source; sigma_rad is its standard deviation, above 0. Of the INS the
        option declination_rad is added."""
        self._call("push_heading", t_s, heading_rad, sigma_rad)

    def push_speed(self, t_s: float, speed_m_s: float, sigma_m_s: float) -> None:
        """Speed along body x; sigma_m_s is its standard deviation, above 0. INS: of wheels, used once the heading is found. AHRS: by GNSS,
        wheels or airspeed, of a body that moves where body x points; its accelerations then do not tilt the horizon."""
        self._call("push_speed", t_s, speed_m_s, sigma_m_s)

    def advance(self, t_s: float) -> None:
        """Uses the samples up to t_s and shows the estimate at t_s.

        Between samples and after the newest one a copy of the estimate is predicted to t_s; what is stored stays as it is,
        so the same samples give the same bits whatever times are asked for. Raises HnavRuntimeError for a time before that
        of the last advance, and when samples led to no usable estimate: those were dropped, the others used.
        """
        self._call("advance", t_s)

    # ----------------------------------------------------------------------------------------- estimate

    def attitude(self) -> Attitude:
        """Attitude and heading at the time of the last advance. Raises HnavRuntimeError while there is none."""
        return Attitude.read(self._filled("hnav_attitude", "attitude"))

    def rate(self) -> Array:
        """3, rad/s, body axes: the newest rate without the bias; zero before the first sample."""
        return self._numbers("rate", 3)[0]

    def gyro_bias(self) -> tuple[Array, Array]:
        """Bias of the gyroscope and its standard deviations: 3 each, rad/s, body axes."""
        bias, sigma = self._numbers("gyro_bias", 3, 3)
        return bias, sigma

    def innovation(self, sensor: str) -> Innovation:
        """The innovation of the last used sample of a sensor, by its name in SENSORS; the gyroscope has none.

        Raises HnavValueError for other sensors, HnavRuntimeError when none of its samples has been used yet.
        """
        if sensor not in SENSORS:
            raise HnavValueError("option", f"sensor = {sensor}: choose one of {', '.join(SENSORS[1:])}", "sensor")
        return Innovation.read(self._filled("hnav_innovation", "innovation", SENSORS.index(sensor)))

    def diagnostics(self) -> Diagnostics:
        """Counts of samples and corrections, and figures of the last correction."""
        return Diagnostics.read(self._filled("hnav_diagnostics", "diagnostics"))

    def health(self) -> Health:
        """The state of each sensor, and how often the estimate and the time base started again."""
        return Health.read(self._filled("hnav_health", "health"))
