"""Attitude and heading by the C library: the AHRS for real sensors, and the HREKF of the paper.

    run = hnav.Filter("ahrs", navigation_frame="enu").run(t_s, rate, force, field)      # n x 3 arrays in SI units
    run.q_nb                                # n x 4, scalar first, body to navigation
    run.to_dataframe()

    filter = hnav.Filter("ahrs")            # or sample by sample
    filter.push_imu(t_s, rate, force)
    filter.push_mag(t_s, field)
    filter.advance(t_s)
    filter.attitude().heading_rad

Conventions, for all that is here: n is the navigation frame, north-east-down unless the option navigation_frame says enu;
b is the body frame, the axes of the sensor turned by the option q_body_sensor. Quaternions are Hamilton's, scalar first;
q_nb turns body vectors into navigation axes. force is specific force: a sensor at rest with its z axis down reads
(0, 0, -9.81) m/s2. Times in s, rates in rad/s, forces in m/s2, fields in tesla, angles in rad. Filters of different threads
run in parallel; one filter serves one thread at a time.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np
import numpy.typing as npt

from hnav.errors import HnavRuntimeError, HnavValueError
from hnav.filters.attitude_answers import RUN_COLUMNS, Field, Posterior, Run, empty_run
from hnav.filters.filter_object import FilterObject, with_arguments_of
from hnav.filters.options import Options
from hnav.native.arrays import Array, address, doubles, times
from hnav.native.library import ffi, new
from hnav.native.options import complete

if TYPE_CHECKING:
    from hnav.filters.ins import Ins
    from hnav.io.recordings import Recording

SPEED_SIGMA_M_S = 0.1
"""Standard deviation of a speed that states none. Chosen: usual wheels."""


class Filter(FilterObject):
    """An attitude filter: a hybrid system whose estimate flows between samples and jumps at each of them.

        Filter("ahrs", navigation_frame="enu", preset="default")
        Filter(Options("ahrs"))
        Filter("ins", "industrial")                 # an Ins

    options: the name of a filter, with preset and values as of its Options, or Options; without it the AHRS. Raises HnavValueError for options that
    are impossible, HnavRuntimeError when there is no memory.
    """

    @overload
    def __new__(cls, options: Literal["ins"], preset: str | None = None, **values: object) -> Ins: ...  # type: ignore[misc]
    @overload
    def __new__(cls, options: Options | str = "ahrs", preset: str | None = None, **values: object) -> Filter: ...

    def __new__(cls, options: Options | str = "ahrs", preset: str | None = None, **values: object) -> Any:
        if (options if isinstance(options, str) else options.filter) != "ins":
            return super().__new__(cls)
        from hnav.filters.ins import Ins  # a filter of another kind, so that this one is not initialised

        return Ins((preset or "default") if isinstance(options, str) else options, **values)

    def __init__(self, options: Options | str = "ahrs", preset: str | None = None, **values: object):
        if isinstance(options, str):
            self._options = Options(options, preset or "default", **values)
        elif preset is None:
            self._options = complete(Options, options, values)
        else:
            raise HnavValueError("option", "Options are complete: a preset belongs to Options(...)", "preset")
        super().__init__(f"hnav_{self._options.filter}_create", self._options.struct)

    # ----------------------------------------------------------------------------------------- samples

    def push_gyro(self, t_s: float, rate_b_rad_s: npt.ArrayLike) -> None:
        """A sample of the gyroscope: rate_b_rad_s is 3, in sensor axes.

        Raises HnavValueError for numbers that are not finite, HnavRuntimeError for late samples and a full queue.
        """
        self._push("gyro", t_s, rate_b_rad_s, "rate_b_rad_s")

    def push_accel(self, t_s: float, force_b_m_s2: npt.ArrayLike) -> None:
        """A sample of the accelerometer: force_b_m_s2 is 3, in sensor axes; errors as of push_gyro, and for a zero vector."""
        self._push("accel", t_s, force_b_m_s2, "force_b_m_s2")

    def run(
        self,
        t_s: npt.ArrayLike,
        rate_b_rad_s: npt.ArrayLike | None = None,
        force_b_m_s2: npt.ArrayLike | None = None,
        field_b_tesla: npt.ArrayLike | None = None,
        only: tuple[str, ...] = (),
        smooth: bool = False,
        check: bool = True,
        speed_m_s: npt.ArrayLike | None = None,
        speed_sigma_m_s: npt.ArrayLike = SPEED_SIGMA_M_S,
    ) -> Run:
        """A whole recording: push and advance of row after row, bit for bit.

        t_s: n, not decreasing; the others n x 3 in sensor axes, or None. A row of NaN is a missing sample. speed_m_s: n, of the AHRS,
        as by push_speed, NaN where there is none; speed_sigma_m_s: n, or one for all.
        only: names of the arrays of Run to fill, all if empty; sigmas cost as much as the filter itself. smooth: with hindsight, as by
        the method smooth. check: whether samples that cannot be in these units give a PlausibilityWarning, which takes up to 20 ms.

        A run continues from the present state of the filter: reset it before another recording. Raises HnavValueError for
        arrays of other shapes, HnavRuntimeError naming the row where the filter cannot go on.
        """
        samples = rate_b_rad_s, force_b_m_s2, field_b_tesla
        try:
            return self._batch("smooth" if smooth else "run", t_s, samples, only, _speeds(t_s, speed_m_s, speed_sigma_m_s))
        except HnavValueError:
            check = False  # arrays of other shapes
            raise
        finally:
            if check:  # also after an error, which a wrong unit may have caused
                from hnav.io.plausibility import warn_of_meaningless  # it takes longer to load than this module

                warn_of_meaningless(times(t_s), *samples)

    @with_arguments_of(run)
    def smooth(self, *samples: Any, **named: Any) -> Run:
        """As run, with hindsight: every row from all samples, before and after it. The filter is reset before and after.

        Takes five times as long as run. Raises HnavRuntimeError for the HREKF, which has no smoother, and for recordings
        that the filter cannot start on.
        """
        return self.run(*samples, **(named | {"smooth": True}))

    def run_recording(self, recording: Recording, smooth: bool = False) -> Run:
        """A whole recording by a filter with the options of this one, which does not change. It waits for fields that arrive
        late, whatever horizon_s is. smooth: with hindsight, as by smooth. Raises HnavError."""
        from hnav.filters.attitude_recording import run_recording  # it imports this filter

        return run_recording(recording, self.options, smooth=smooth)

    def realign(self) -> None:
        """Forgets the attitude and starts again with the next samples; keeps the gyro bias and the counters."""
        self._call("realign")

    # ----------------------------------------------------------------------------------------- estimate

    def posterior(self) -> Posterior:
        """The estimate just after the newest used sample. Raises HnavRuntimeError while there is none."""
        return Posterior.read(self._filled("hnav_posterior", "posterior"))

    def gyro_calibration(self) -> tuple[Array, Array]:
        """Scale and misalignment S, rate = (I - S) reading - bias, and the sigma of each element: 3 x 3; zero in the HREKF."""
        matrix, sigma = self._numbers("gyro_calibration", (3, 3), (3, 3))
        return matrix, sigma

    def covariance(self) -> Array:
        """6 x 6: rotation about the navigation axes in rad, gyro bias in rad/s. Raises HnavRuntimeError before the start."""
        return self._numbers("covariance", (6, 6))[0]

    def field(self) -> Field:
        """Reference field, latency of the magnetometer, and the verdict on the last sample."""
        return Field.read(self._filled("hnav_field", "field"))

    # ----------------------------------------------------------------------------------------- calls of the library

    def _push(self, sensor: str, t_s: float, value: npt.ArrayLike, name: str) -> None:
        self._call(f"push_{sensor}", t_s, address(doubles(value, (3,), name)))

    def _batch(
        self,
        call: str,
        t_s: npt.ArrayLike,
        samples: tuple[npt.ArrayLike | None, ...],
        only: tuple[str, ...],
        speeds: dict[str, Array],
    ) -> Run:
        t = times(t_s)
        given: dict[str, Array | None] = {"t_s": t, **speeds}
        for name, values in zip(("rate_b_rad_s", "force_b_m_s2", "field_b_tesla"), samples):
            given[name] = None if values is None else doubles(values, (*t.shape, 3), name)
        run, wanted = _empty(t, only, call == "run")
        read = new("hnav_run_input", **{name: address(values) for name, values in given.items()})
        written = new("hnav_run_output", **{name: address(getattr(run, name)) for name in wanted})
        try:
            self._call(call, len(t), read, written, *([ffi.NULL] if call == "run" else []))
        except HnavRuntimeError as error:
            if error.status in ("late sample", "time backwards") and str(error).startswith("row 0:"):
                begins = f"t_s begins at {t[0]:g} s, before the time of this filter: reset() it first"
                raise HnavRuntimeError(error.status, f"{begins} ({error})") from None
            if error.status == "late sample":
                raise HnavRuntimeError(error.status, f"{error}: t_s runs back, sort the rows by it") from None
            raise
        run.options = self.options
        return run


def _speeds(t_s: npt.ArrayLike, speed_m_s: npt.ArrayLike | None, sigma_m_s: npt.ArrayLike) -> dict[str, Array]:
    if speed_m_s is None:
        return {}
    shape = times(t_s).shape
    sigma = np.broadcast_to(np.asarray(sigma_m_s, float), shape) if np.ndim(sigma_m_s) == 0 else sigma_m_s
    return {"speed_m_s": doubles(speed_m_s, shape, "speed_m_s"), "speed_sigma_m_s": doubles(sigma, shape, "speed_sigma_m_s")}


def _empty(t_s: Array, only: tuple[str, ...], with_gates: bool) -> tuple[Run, list[str]]:
    """An empty run, and the names of the arrays that the library is to fill."""
    known = [*RUN_COLUMNS, *(["accepted"] if with_gates else [])]
    if unknown := set(only) - set(known):
        raise HnavValueError("option", f"only = {unknown.pop()}: choose from {', '.join(known)}", "only")
    run, wanted = empty_run(t_s), list(only) or known
    if "accepted" in wanted:
        run.accepted = np.zeros((len(t_s), 2), bool)
    return run, wanted
