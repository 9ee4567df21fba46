"""Position, velocity and attitude from inertial sensors and aids, aligned from any heading, by the C library.

    aids = hnav.Aids().velocity(fix_s, velocity_n, 0.1).position(fix_s, latitude_rad, longitude_rad, height_m, 2.0)
    run = hnav.Ins("industrial").run(t_s, rate, force, aids)        # n x 3 arrays in SI units
    run.place, run.velocity_n_m_s, run.heading_rad, run.ready
    run.to_dataframe()

    ins = hnav.Ins("industrial")                                     # or sample by sample
    ins.push_imu(t_s, rate, force)
    ins.push_velocity(fix_s, velocity_n, 0.1)
    ins.push_position(fix_s, latitude_rad, longitude_rad, height_m, 2.0)
    ins.advance(t_s)
    ins.navigation().euler_rad

n is north-east-down at the place of the body, b the body: the axes of the sensor turned by the option q_body_sensor. Quaternions
are Hamilton's, scalar first, body to n. Heights are above the ellipsoid of WGS 84. Filters of different threads run in
parallel; one filter serves one thread at a time.
"""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from hnav.errors import HnavValueError, PlausibilityWarning
from hnav.filters.filter_object import FilterObject, with_arguments_of
from hnav.filters.ins_aids import Aids
from hnav.filters.ins_answers import INS_RUN_ARRAYS, InsRun, InsSamples, Navigation, Observed, unfilled_run
from hnav.filters.options import Options
from hnav.native.arrays import Array, address, doubles, times
from hnav.native.library import ffi, new
from hnav.native.options import complete

if TYPE_CHECKING:
    from hnav.io.recordings import Recording


class Ins(FilterObject):
    """The navigation filter, the same as Filter("ins", ...).

        Ins("industrial", car_across_m_s=0.1)
        Ins(Options("ins", "industrial"))

    options: a preset, with values as of Options("ins", ...), or those. Raises HnavValueError for options that are impossible,
    HnavRuntimeError when there is no memory.
    """

    def __init__(self, options: Options | str = "default", **values: object):
        self._options = Options("ins", options, **values) if isinstance(options, str) else complete(Options, options, values)
        if self._options.filter != "ins":
            raise HnavValueError(
                "option", f"these are options of {self._options.filter}: Ins takes Options('ins', ...)", "options"
            )
        super().__init__("hnav_ins_create", self._options.struct)

    def push_position(
        self, t_s: float, latitude_rad: float, longitude_rad: float, height_m: float, sigma_n_m: npt.ArrayLike
    ) -> None:
        """A place; sigma_n_m: a number, or 3 for north, east, down."""
        self._call("push_position", t_s, latitude_rad, longitude_rad, height_m, address(_three(sigma_n_m)))

    def push_velocity(self, t_s: float, velocity_n_m_s: npt.ArrayLike, sigma_n_m_s: npt.ArrayLike) -> None:
        """Velocity north, east, down (3; down NaN when it is not known); sigma_n_m_s: a number, or 3."""
        velocity = doubles(velocity_n_m_s, (3,), "velocity_n_m_s")
        self._call("push_velocity", t_s, address(velocity), address(_three(sigma_n_m_s)))

    def push_pressure(self, t_s: float, pressure_pa: float, sigma_pa: float) -> None:
        """Pressure of the air."""
        self._call("push_pressure", t_s, pressure_pa, sigma_pa)

    def push_rest(self, t_s: float, sigma_m_s: float) -> None:
        """The body stands; sigma_m_s is the standard deviation of its velocity."""
        self._call("push_rest", t_s, sigma_m_s)

    def run(
        self,
        t_s: npt.ArrayLike,
        rate_b_rad_s: npt.ArrayLike,
        force_b_m_s2: npt.ArrayLike,
        aids: Aids | None = None,
        every: int = 1,
        smooth: bool = False,
        check: bool = True,
    ) -> InsRun:
        """A whole recording, bit for bit as sample by sample.

        t_s: n, not decreasing; rate and force n x 3 in sensor axes, NaN for a missing sample. every: a row of the result for
        each so many rows, the last of them. Aids that came after the last row are not used. A run goes on from where the
        filter stands: reset it before it takes another recording. smooth: with hindsight, as the method smooth does. check: whether samples that
        cannot be in these units give a PlausibilityWarning, which takes up to 20 ms. Raises HnavValueError for arrays of other shapes, HnavRuntimeError naming the row where the filter cannot go on.
        """
        if every < 1:
            raise HnavValueError("option", f"every = {every}: it is at least 1", "every")
        if aids is not None and not isinstance(aids, Aids):
            raise HnavValueError(
                "option", "aids is an object of hnav.Aids; a field goes by Aids().mag(t_s, field_b_tesla, ...)", "aids"
            )
        t = times(t_s)
        rate, force = doubles(rate_b_rad_s, (len(t), 3), "rate_b_rad_s"), doubles(force_b_m_s2, (len(t), 3), "force_b_m_s2")
        valid, received, sensor, value = (aids or Aids()).arrays()
        run = unfilled_run(len(t) // every)
        given = new(
            "hnav_ins_run_input", t_s=address(t), rate_b_rad_s=address(rate), force_b_m_s2=address(force), aids=len(valid),
            aid_t_s=address(valid), aid_received_s=address(received), aid_sensor=ffi.from_buffer("int32_t[]", sensor),
            aid_value=address(value),
        )  # fmt: skip
        wanted = new("hnav_ins_run_output", every=every, **{name: address(getattr(run, name)) for name in INS_RUN_ARRAYS})
        if smooth:
            self._do("hnav_ins_smooth", len(t), given, wanted)
        else:
            self._do("hnav_ins_run", len(t), given, wanted, ffi.NULL)
        run.options, run.smoothed, run.samples = self.options, smooth, InsSamples(rate, force, aids or Aids())
        if check:
            from hnav.io.plausibility import warn_of_meaningless  # it takes longer to load than this module

            warn_of_meaningless(t, rate, force)
            if len(t) and len(valid) and not ((received <= t[-1]) & (valid >= t[0] - self.options.horizon_s)).any():
                shown = f"no aid is of the time of the recording: t_s {t[0]:g} to {t[-1]:g} s, aids {np.min(valid):g} to {np.max(valid):g} s"
                warnings.warn(f"{shown}; give both one clock", PlausibilityWarning, stacklevel=2)
        return run

    @with_arguments_of(run)
    def smooth(self, *samples: Any, **named: Any) -> InsRun:
        """The same with hindsight: every row from all samples, before it and after it, by a filter with the options of this one,
        which stays as it is. It takes the arguments of run.

        Aids act at their times of validity, however late they came. Rows from before the heading was found are navigation too, from
        the first sample on; where nothing later corrects them they are those of run, and so is the last row. Takes some ten times as long
        as run. Raises as run does, and HnavRuntimeError when there is no memory.
        """
        return self.run(*samples, **(named | {"smooth": True}))

    def run_recording(self, recording: Recording, every: int = 1, smooth: bool = False) -> InsRun:
        """A recording with its satellites, pressure and wheels, by a filter with the options of this one, which stays as it is.

        every: as of run. smooth: with hindsight, as by smooth. Late samples are waited for, whatever horizon_s is; where gyroscope
        and accelerometer have times of their own, the force is interpolated. Raises HnavError.
        """
        from hnav.filters.ins_recording import NavigationRun, inertial_rows, paired  # they import this filter

        made = paired(recording)
        return NavigationRun.over(made, self._options).go_on(inertial_rows(made), every, smooth)

    def navigation(self) -> Navigation:
        """The estimate at the time of the last advance."""
        return Navigation.read(self._filled_by("hnav_ins_navigation", "hnav_navigation"))

    def covariance(self) -> Array:
        """15 x 15: of position, velocity (north, east, down), rotation about them, gyro bias, accelerometer bias. Raises
        HnavRuntimeError before there is a tilt."""
        return self._numbers("covariance", (15, 15))[0]

    def observed(self) -> Observed:
        """The information about the heading, by its source."""
        return Observed.read(self._filled_by("hnav_ins_observed", "hnav_observed"))


def _three(sigma: npt.ArrayLike) -> Array:
    return doubles(np.broadcast_to(np.asarray(sigma, float), (3,)), (3,), "sigma")
