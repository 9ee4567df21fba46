"""Errors of a navigation run against the truth, and their growth during outages of the satellites.

An outage begins where the filter navigates, and every so often after it: from there a copy of the filter goes on without
satellites, pressure and wheels as they are, and its position at the end is compared with the truth. NEES as in hnav.reports.scores,
from the sigmas without correlations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hnav.earth import axes_at, position_of
from hnav.errors import HnavValueError
from hnav.filters.ins_answers import PHASES, InsRun
from hnav.filters.ins_recording import NavigationRun, inertial_rows, paired
from hnav.filters.options import Options
from hnav.io.recordings import Recording
from hnav.io.trajectories import Trajectory
from hnav.native.arrays import Array
from hnav.reports.comparison import ErrorFigure
from hnav.rotations import rotation_error_rad
from hnav.systems.navigation_views import FALSE_RAD

MOST_OUTAGES = 40
SATELLITES = ("position", "velocity")


@dataclass(frozen=True)
class Errors:
    """Of the rows that are compared: estimate minus truth, n x 3 each, NaN where the truth is not known; and their sigmas."""

    t_s: Array
    """n."""
    position_m: Array
    """North, east, down."""
    velocity_m_s: Array
    """North, east, down."""
    rotation_rad: Array
    """About north, east, down; the third is heading."""
    sigma_position_m: Array
    """As stated."""
    sigma_velocity_m_s: Array
    """As stated."""
    sigma_rotation_rad: Array
    """As stated."""


@dataclass(frozen=True)
class Outage:
    """Outages of one length; errors at the end of each."""

    length_s: float
    """Without satellites."""
    horizontal_m: Array
    """Of each."""
    vertical_m: Array
    """Of each, with its sign: down."""
    heading_rad: Array
    """Of each."""
    sigma_m: Array
    """Horizontal, as stated at the end."""


@dataclass(frozen=True)
class NavigationScore:
    """Scores of a filter on a recording with truth."""

    ready_s: float
    """From the first row to the first heading_ready; NaN: never."""
    is_false: bool
    """Whether a ready heading had an error above three sigmas and 5 deg."""
    begin_s: float
    """From the first row: rows from there on are compared."""
    figures: list[ErrorFigure]
    """Tilt, heading, velocity and position."""
    outages: list[Outage]
    """In the order asked for."""


def navigation_score(
    recording: Recording, truth: Trajectory, options: Options, outages_s: Sequence[float] = (), smooth: bool = False
) -> NavigationScore:
    """The recording through the filter. Rows count from the first heading_ready on, from the first of the phase navigating where
    there is none; smooth: of the run with hindsight, but from where the filter is ready. Raises HnavValueError when nothing can be compared."""
    data = paired(recording)
    run = judged = NavigationRun.over(data, options).go_on(inertial_rows(data))
    if smooth:
        judged = NavigationRun.over(data, options).go_on(inertial_rows(data), smooth=True)
    navigating = run.phase == PHASES.index("navigating")
    if not navigating.any():
        raise HnavValueError(
            "no data",
            f"{recording.name}: the filter never navigates, so there is nothing to compare: leave --truth out to see why",
        )
    ready = np.flatnonzero(run.ready[:, 1])
    first = int(ready[0]) if len(ready) else int(np.argmax(navigating))
    errors = errors_of(judged, truth, slice(first, None))
    if not np.isfinite(errors.position_m).any():
        raise HnavValueError(
            "no data", f"{recording.name}: no row from {run.t_s[first]:.10g} to {run.t_s[-1]:.10g} s lies within the truth, "
            f"{truth.t_s[0]:.10g} to {truth.t_s[-1]:.10g} s: give both the same clock"
        )  # fmt: skip
    heading, sigma = errors.rotation_rad[0, 2], errors.sigma_rotation_rad[0, 2]
    begin_s = float(run.t_s[first] - run.t_s[0])
    return NavigationScore(
        begin_s if len(ready) else np.nan, bool(len(ready) and abs(heading) > max(3 * sigma, FALSE_RAD)), begin_s, figures_of(errors),
        [outages_of(data, truth, options, first, length_s) for length_s in outages_s],
    )  # fmt: skip


def errors_of(run: InsRun, truth: Trajectory, rows: slice) -> Errors:
    """Estimate minus truth of some rows."""
    at = truth.at(run.t_s[rows])
    off = np.einsum("nij,ni->nj", axes_at(at.place), position_of(run.place[rows]) - position_of(at.place))
    return Errors(
        at.t_s, off, run.velocity_n_m_s[rows] - at.velocity_n_m_s, rotation_error_rad(run.q_nb[rows], at.q_nb),
        run.sigma_position_m[rows], run.sigma_velocity_m_s[rows], run.sigma_rotation_rad[rows],
    )  # fmt: skip


def figures_of(errors: Errors) -> list[ErrorFigure]:
    """Those whose truth is known."""
    degrees = 180 / np.pi
    figures = [
        ("tilt", "deg", degrees * errors.rotation_rad[:, :2], degrees * errors.sigma_rotation_rad[:, :2]),
        ("heading", "deg", degrees * errors.rotation_rad[:, 2:], degrees * errors.sigma_rotation_rad[:, 2:]),
        ("velocity, horizontal", "m/s", errors.velocity_m_s[:, :2], errors.sigma_velocity_m_s[:, :2]),
        ("velocity, vertical", "m/s", errors.velocity_m_s[:, 2:], errors.sigma_velocity_m_s[:, 2:]),
        ("position, horizontal", "m", errors.position_m[:, :2], errors.sigma_position_m[:, :2]),
        ("position, vertical", "m", errors.position_m[:, 2:], errors.sigma_position_m[:, 2:]),
    ]
    return [_figure(errors.t_s, *one) for one in figures if np.isfinite(one[2]).all(axis=1).any()]


def _figure(t_s: Array, name: str, unit: str, error: Array, sigma: Array) -> ErrorFigure:
    known = np.isfinite(error).all(axis=1) & np.isfinite(sigma).all(axis=1)
    nees = float(np.mean((error[known] / sigma[known]) ** 2))
    return ErrorFigure(name, unit, np.linalg.norm(error[known], axis=1), t_s[known], nees)


def outages_of(data: Recording, truth: Trajectory, options: Options, first: int, length_s: float) -> Outage:
    """Errors at the ends of outages, from the row `first` on: side by side, of at most MOST_OUTAGES."""
    last_s = min(float(data.t_s[-1]), float(truth.t_s[-1])) - length_s
    room = last_s - float(data.t_s[first])
    count = int(np.clip(room // length_s, 1, MOST_OUTAGES)) if room >= 0 else 0
    begins = np.linspace(data.t_s[first], last_s, count) if count > 1 else np.full(count, data.t_s[first])
    run = NavigationRun.over(data, options)
    ends, at = [], 0
    for begin_s in begins:
        row = int(np.searchsorted(data.t_s, begin_s, side="right"))
        if row > at:
            run.go_on(inertial_rows(data, slice(at, row)))
            at = row
        alone = run.without(SATELLITES)
        upto = int(np.searchsorted(data.t_s, data.t_s[row - 1] + length_s, side="right"))
        if upto > row:
            ends.append(errors_of(alone.go_on(inertial_rows(data, slice(row, upto))), truth, slice(-1, None)))
    known = [end for end in ends if np.isfinite(end.position_m).all()]
    position, rotation, sigma = (np.array([getattr(end, name)[0] for end in known]).reshape(-1, 3) for name in
                                 ("position_m", "rotation_rad", "sigma_position_m"))  # fmt: skip
    return Outage(length_s, np.hypot(*position[:, :2].T), position[:, 2], rotation[:, 2], np.hypot(*sigma[:, :2].T))
