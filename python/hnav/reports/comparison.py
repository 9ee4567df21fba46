"""Errors of trajectories against a reference, after the requested alignment of clocks and frames.

    found = compare(read_trajectory("truth.txt"), read_trajectory("estimate.csv"), align=("clock", "world"))
    for figure in found.figures: print(figure)

Absolute and relative pose errors are those of evo (APE, RPE; Sturm et al., IROS 2012), errors of attitude those of BROAD
(hnav.reports.scores), the alignment of places that of Umeyama (IEEE PAMI 13(4), 1991).
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from hnav.earth import axes_at, position_of
from hnav.errors import HnavValueError
from hnav.io.trajectories import Trajectory
from hnav.native.arrays import Array
from hnav.reports.scores import errors_rad
from hnav.rotations import NED_AND_ENU, quaternion_product, rotated, rotation_error_rad

ALIGN = ("clock", "world", "body", "place", "scale")
GRID_S = 0.01
"""Of the speeds that clocks are found by."""
WINDOW_S = 0.1
"""Interval in s of the differences that give speeds: short ones would take corrections of a filter for motion."""
NEIGHBOURS = 5
"""Grid steps on either side of the best one; a parabola through their misfits interpolates the offset."""
LEAST_S = 2.0
"""Of the common time of two clocks."""
TURN_S = 0.5
"""Interval in s of the turns that determine the rotation between two bodies."""
ROUNDS = 30
"""Of alternating between both sides; each makes the residual smaller."""
CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])


@dataclass(frozen=True)
class ErrorFigure:
    """The error of one quantity."""

    name: str
    """Such as heading, or position relative."""
    unit: str
    """deg, m or m/s."""
    values: Array
    """Norms of the error, one for each compared row."""
    t_s: Array
    """Their times, by the clock of the reference."""
    nees: float = np.nan
    """Mean of squared errors over their variances for each axis, from the sigmas without correlations; NaN without sigmas."""

    @property
    def rms(self) -> float:
        """Root mean square."""
        return float(np.sqrt(np.mean(self.values**2)))

    @property
    def median(self) -> float:
        """Median of the errors."""
        return float(np.median(self.values))

    @property
    def worst(self) -> float:
        """The largest."""
        return float(np.max(self.values))


@dataclass(frozen=True)
class Comparison:
    """A trajectory against a reference."""

    reference: Trajectory
    """At the times of the rows that are compared."""
    aligned: Trajectory
    """The other one at those times, aligned; positions in m beside those of the reference."""
    figures: list[ErrorFigure]
    """Of what both have."""
    found: dict[str, str]
    """The alignments and their sizes."""


def compare(
    reference: Trajectory, other: Trajectory, align: Collection[str] = (), delta_s: float = 1.0, begin_s: float = 0.0
) -> Comparison:
    """The rows of other within the time of the reference, which is interpolated.

    align: of ALIGN. clock: a constant offset of the times, by the speeds of both. world: a constant rotation of the navigation axes, such
    as of an unknown heading; body: of the body axes. place: rotation and offset of positions, scale: their scale too. delta_s: relative
    errors are those of motions over so long. begin_s: so much of the begin of other is left out, once it is aligned. Raises HnavValueError for another alignment, and where nothing can be compared.
    """
    if unknown := set(align) - set(ALIGN):
        raise HnavValueError("option", f"align = {unknown.pop()}: choose from {', '.join(ALIGN)}", "align")
    if not 0 < delta_s < np.inf:
        raise HnavValueError("option", f"delta_s = {delta_s:g}: must be above 0 s", "delta_s")
    found: dict[str, str] = {}
    reference, other = in_metres(reference, reference), in_metres(other, reference)
    if "clock" in align:
        offset_s = clock_offset_s(reference, other)
        found["clock"] = f"{offset_s:+.4f} s added to the times of {other.name}"
        other = replace(other, t_s=other.t_s + offset_s)
    rows = (other.t_s >= reference.t_s[0]) & (other.t_s <= reference.t_s[-1])
    mine, true = (one.at(other.t_s[rows]) for one in (other, reference))
    if not any(known(mine, true, name).any() for name in ("q_nb", "position_m")):
        raise HnavValueError(
            "no data", f"{other.name}: no row with an attitude or a place lies within {reference.name}: times from {other.t_s[0]:.10g} to "
            f"{other.t_s[-1]:.10g} s, and from {reference.t_s[0]:.10g} to {reference.t_s[-1]:.10g} s: align clock finds a constant offset"
        )  # fmt: skip
    mine = _with_frames(mine, true, align, found)
    if {"place", "scale"} & set(align):
        mine = _with_places(mine, true, "scale" in align, found)
    kept = mine.t_s >= other.t_s[0] + begin_s
    if not kept.any():
        raise HnavValueError("no data", f"begin_s = {begin_s:g}: {other.name} has no row after it; give less", "begin_s")
    mine, true = mine.rows(kept), true.rows(kept)
    return Comparison(true, mine, [*_absolute(mine, true), *_relative(mine, true, delta_s)], found)


def in_metres(one: Trajectory, reference: Trajectory) -> Trajectory:
    """With latitudes as positions north, east, down of the first place of the reference, and the axes that the reference has."""
    at = reference.place[np.isfinite(reference.place).all(axis=1)][:1]
    if len(at) and np.isfinite(one.place).any():
        off = (position_of(one.place) - position_of(at)) @ axes_at(at)[0]
        one = replace(one, position_m=off)
    if {one.frame, reference.frame} == {"ned", "enu"}:
        sigma = {name: values[:, [1, 0, 2]] for name, values in one.sigma.items()}
        one = replace(one, q_nb=quaternion_product(NED_AND_ENU, one.q_nb), sigma=sigma, frame=reference.frame)
    return one


def known(mine: Trajectory, true: Trajectory, name: str) -> np.ndarray:
    """Rows of which both have a quantity."""
    return np.asarray(np.isfinite(getattr(mine, name)).all(axis=1) & np.isfinite(getattr(true, name)).all(axis=1))


# --------------------------------------------------------------------------------------------- clocks


def clock_offset_s(reference: Trajectory, other: Trajectory) -> float:
    """The offset in s to add to the times of other, at which the angular rates, or else the speeds, of both differ least."""
    from scipy.signal import correlate

    both = [n for n in ("q_nb", "position_m") if all(np.isfinite(getattr(one, n)).any() for one in (reference, other))]
    if not both:
        raise HnavValueError("no data", f"{other.name}: has no attitude and no place that {reference.name} has too", "align")
    (begin_r, speed_r), (begin_o, speed_o) = (_speed(one, both[0]) for one in (reference, other))
    least = round(LEAST_S / GRID_S)
    if min(len(speed_r), len(speed_o)) <= least or min(speed_r.std(), speed_o.std()) == 0:
        raise HnavValueError("no data", f"{other.name}: too short, or too still, to find its clock", "align")
    lags = np.arange(1 - len(speed_o), len(speed_r))
    overlap = np.minimum(np.minimum(lags + len(speed_o), len(speed_r) - lags), min(len(speed_o), len(speed_r)))
    product = correlate(speed_r - speed_r.mean(), speed_o - speed_o.mean(), mode="full", method="fft")
    likely = np.where(overlap >= least, product / np.sqrt(np.maximum(overlap, 1)), -np.inf)
    lag = int(lags[np.argmax(likely)])
    rows = np.arange(max(0, lag) + NEIGHBOURS, min(len(speed_r), len(speed_o) + lag) - NEIGHBOURS)
    # By whole steps: between them an interpolation would smooth the noise, and seem to fit better.
    shifts = np.arange(-NEIGHBOURS, NEIGHBOURS + 1)
    misfits = [np.mean((speed_r[rows] - speed_o[rows - lag - shift]) ** 2) for shift in shifts]
    curvature, slope, _ = np.polyfit(shifts, misfits, 2)
    fine = float(np.clip(-0.5 * slope / curvature, -1, 1)) if curvature > 0 else 0.0
    return float(begin_r - begin_o + (lag + fine) * GRID_S)


def _speed(one: Trajectory, name: str) -> tuple[float, Array]:
    """Begin, and the speed on a grid: rad/s or m/s."""
    values = getattr(one, name)
    rows = np.isfinite(values).all(axis=1)
    t_s = one.t_s[rows]
    step = round(WINDOW_S / GRID_S)
    at_s = np.arange(t_s[0], t_s[-1], GRID_S)
    if len(at_s) <= step:
        return float(t_s[0]), np.zeros(1)
    on_grid = getattr(one.rows(rows).at(at_s), name)
    before, after = on_grid[:-step], on_grid[step:]
    moved = rotation_error_rad(before, after) if name == "q_nb" else after - before
    return float(t_s[0]), np.nan_to_num(np.linalg.norm(moved, axis=1)) / WINDOW_S


# --------------------------------------------------------------------------------------------- frames


def mean_quaternion(q: Array) -> Array:
    """The rotation nearest to all of n x 4, Markley et al., J. Guidance 30(4), 2007."""
    _, vectors = np.linalg.eigh(q.T @ q)
    mean = vectors[:, -1]
    return np.asarray(mean if mean[0] >= 0 else -mean)


def _with_frames(mine: Trajectory, true: Trajectory, align: Collection[str], found: dict[str, str]) -> Trajectory:
    rows = known(mine, true, "q_nb")
    if not {"world", "body"} & set(align) or not rows.any():
        return mine
    q, p = true.q_nb[rows], mine.q_nb[rows]
    left = right = np.array([1.0, 0, 0, 0])
    if {"world", "body"} <= set(align):
        right = _body_between(true.t_s[rows], q, p)
    for _ in range(ROUNDS if {"world", "body"} <= set(align) else 1):
        if "world" in align:
            left = mean_quaternion(quaternion_product(q, quaternion_product(p, right) * CONJUGATE))
        if "body" in align:
            right = mean_quaternion(quaternion_product(quaternion_product(left, p) * CONJUGATE, q))
    for name, turn in (("world", left), ("body", right)):
        if name in align:
            vector = np.degrees(rotation_error_rad(np.array([[1.0, 0, 0, 0]]), turn[None]))[0]
            angles = ", ".join(f"{v:.3f}" for v in vector)
            found[name] = f"axes of {mine.name} turned by {np.linalg.norm(vector):.3f} deg, rotation vector ({angles}) deg"
    return replace(mine, q_nb=quaternion_product(quaternion_product(left, mine.q_nb), right))


def _body_between(t_s: Array, q: Array, p: Array) -> Array:
    """Of the rotation of p's body axes that makes its turns those of q: turns over TURN_S as vectors, by Wahba's problem."""
    step = max(1, round(TURN_S / max(float(np.median(np.diff(t_s))), 1e-6)))
    turns = [rotation_error_rad(one[:-step] * CONJUGATE, one[step:] * CONJUGATE) for one in (q, p)]
    u, _, vt = np.linalg.svd(turns[0].T @ turns[1])
    matrix = u @ np.diag([1, 1, np.sign(np.linalg.det(u @ vt))]) @ vt  # turns of q = matrix turns of p
    from scipy.spatial.transform import Rotation  # takes longer to load than a comparison

    return np.asarray(Rotation.from_matrix(matrix.T).as_quat()[[3, 0, 1, 2]])


def umeyama(true: Array, mine: Array, with_scale: bool) -> tuple[Array, Array, float]:
    """Rotation (3 x 3), offset (3) and scale that take mine (n x 3) nearest to true."""
    mean_true, mean_mine = true.mean(axis=0), mine.mean(axis=0)
    u, d, vt = np.linalg.svd((true - mean_true).T @ (mine - mean_mine) / len(true))
    signs = np.array([1, 1, np.sign(np.linalg.det(u) * np.linalg.det(vt))])
    turn = u @ np.diag(signs) @ vt
    scale = float((d * signs).sum() / ((mine - mean_mine) ** 2).sum(axis=1).mean()) if with_scale else 1.0
    return turn, mean_true - scale * turn @ mean_mine, scale


def _with_places(mine: Trajectory, true: Trajectory, with_scale: bool, found: dict[str, str]) -> Trajectory:
    rows = known(mine, true, "position_m")
    if rows.sum() < 3:
        raise HnavValueError("no data", f"{mine.name}: has fewer than 3 places within {true.name}", "align")
    turn, offset, scale = umeyama(true.position_m[rows], mine.position_m[rows], with_scale)
    angle = np.degrees(np.arccos(np.clip(0.5 * (np.trace(turn) - 1), -1, 1)))
    moved = ", ".join(f"{v:.4g}" for v in offset)
    found["place"] = f"turned by {angle:.3f} deg, moved by ({moved}) m" + (f", scaled by {scale:.6g}" if with_scale else "")
    return replace(mine, position_m=scale * mine.position_m @ turn.T + offset)


# --------------------------------------------------------------------------------------------- errors


def _absolute(mine: Trajectory, true: Trajectory) -> list[ErrorFigure]:
    figures = []
    if (rows := known(mine, true, "q_nb")).any():
        q, reference = mine.q_nb[rows], true.q_nb[rows]
        stated = (_nees(rotation_error_rad(q, reference), mine, "attitude", rows), np.nan, np.nan)
        sizes = zip(("attitude", "heading", "inclination"), errors_rad(q, reference), stated)
        figures += [ErrorFigure(name, "deg", np.degrees(size), mine.t_s[rows], nees) for name, size, nees in sizes]
    for name, array, unit in (("velocity", "velocity_n_m_s", "m/s"), ("position", "position_m", "m")):
        if (rows := known(mine, true, array)).any():
            error = (getattr(mine, array) - getattr(true, array))[rows]
            figures.append(ErrorFigure(name, unit, np.linalg.norm(error, axis=1), mine.t_s[rows], _nees(error, mine, name, rows)))
    return figures


def _nees(error: Array, mine: Trajectory, name: str, rows: np.ndarray) -> float:
    if name not in mine.sigma:
        return np.nan
    sigma = mine.sigma[name][rows]
    stated = np.isfinite(sigma).all(axis=1) & (sigma > 0).all(axis=1)
    return float(np.mean((error[stated] / sigma[stated]) ** 2)) if stated.any() else np.nan


def _relative(mine: Trajectory, true: Trajectory, delta_s: float) -> list[ErrorFigure]:
    """Of motions over delta_s, one after the other, each seen from the body at its begin."""
    figures = []
    name = f"relative, {delta_s:g} s"
    turns, ways = known(mine, true, "q_nb"), known(mine, true, "position_m")
    if turns.any():
        i, j = _pairs(mine.t_s, turns, delta_s)
        of_true, of_mine = (quaternion_product(one.q_nb[i] * CONJUGATE, one.q_nb[j]) for one in (true, mine))
        size = np.linalg.norm(rotation_error_rad(of_mine, of_true), axis=1)
        figures += [ErrorFigure(f"attitude {name}", "deg", np.degrees(size), mine.t_s[j])] if len(i) else []
    if (turns & ways).any():
        i, j = _pairs(mine.t_s, turns & ways, delta_s)
        of_true, of_mine = (rotated(one.q_nb[i] * CONJUGATE, one.position_m[j] - one.position_m[i]) for one in (true, mine))
        size = np.linalg.norm(of_mine - of_true, axis=1)
        figures += [ErrorFigure(f"position {name}", "m", size, mine.t_s[j])] if len(i) else []
    return figures


def _pairs(t_s: Array, rows: np.ndarray, delta_s: float) -> tuple[np.ndarray, np.ndarray]:
    """Rows of begins and ends."""
    places = np.flatnonzero(rows)
    chosen = [0]
    while True:
        following = int(np.searchsorted(t_s[places], t_s[places[chosen[-1]]] + delta_s * (1 - 1e-9)))
        if following >= len(places):
            break
        chosen.append(max(following, chosen[-1] + 1))
    picked = places[chosen]
    return picked[:-1], picked[1:]
