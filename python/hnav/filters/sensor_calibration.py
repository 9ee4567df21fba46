"""Calibration of accelerometer and gyroscope from one recording of a sensor that was laid down in many attitudes.

    found = calibrate_sensors(hnav.read("rests.csv"))
    found.accel.offset, found.accel.sigma_offset          # m/s2
    found.gyro.apply(rates)

The calibrated force has the same length in every rest; the calibrated rate, integrated between two rests, turns gravity from the one into
gravity of the other (Tedaldi, Pretto, Menegatti, ICRA 2014). Both sensors are fitted together by least squares, weighted by the covariance
of all measurements, so that every figure has its sigma. Body axes are those of the accelerometer: x is its x axis, y lies in the plane of its
x and y axes. The model is corrected = matrix (reading - offset), the matrix of the accelerometer upper triangular.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hnav.errors import HnavValueError
from hnav.filters.noise import still_stretches
from hnav.io.recordings import Recording
from hnav.io.sensors import Correction
from hnav.native.arrays import Array
from hnav.rotations import quaternion_product, rotated
from hnav.units import G_M_S2

LEAST_REST_S = 1.0
"""Shortest rest that is used: the mean of one second of a consumer chip gives gravity to 0.01 deg."""
LONGEST_TURN_S = 30.0
"""Longest turn between two rests that is used: the gyroscope bias wanders in longer ones."""
LONGEST_GAP_S = 0.1
"""Longest interval between two rates of a turn."""
BLOCK_S = 0.25
"""Means over this time are treated as independent: over shorter times the noise of chips, and of a trembling table, is coloured."""
ATTITUDES, APART_RAD = 9, np.radians(20)
"""Fewest attitudes, and the angle between them: the accelerometer has nine parameters, and each attitude gives one equation."""
LIMITS = {"accel offset": 0.05, "accel matrix": 0.005, "gyro matrix": 0.01}
"""Sigmas above which a calibration is refused, in m/s2 and as a scale; the factory's trim of a consumer chip is as good."""
SURE = 0.95
"""Probability below which a spread of the bias is treated as noise."""
UPPER = np.triu_indices(3)
PARAMETERS = 21
ROUNDS = 2
"""Rounds of weighted least squares, each with the weights of the previous solution: errors of some percent change the weights by as much."""
SCALES = np.array([0.1] * 3 + [0.01] * 6 + [0.01] * 3 + [0.01] * 9)
"""Usual errors of the parameters, by which the solver scales them."""


@dataclass(frozen=True)
class Rests:
    """The n rests of a recording and the turns between them."""

    t_s: Array
    """n x 2: begin and end of each rest."""
    force: Array
    """n x 3: mean specific force of each rest, m/s2."""
    rate: Array
    """n x 3: mean rate of each rest, rad/s."""
    force_variance: Array
    """n x 3: variance of the mean force."""
    rate_variance: Array
    """n x 3: variance of the mean rate."""
    after: np.ndarray
    """m: the rest after which each turn begins; turns that cannot be used are left out."""
    steps_s: Array
    """m x L: durations of the intervals of each turn, L a power of two, 0 after its end."""
    turn_rate: Array
    """m x L x 3: mean rates of those intervals."""
    rate_density: Array
    """3: white noise of the gyroscope, (rad/s)^2/Hz."""
    wander: Array
    """3: variance of the bias change from rest to rest, (rad/s)^2."""


@dataclass(frozen=True)
class SensorCalibration:
    """The corrections of accelerometer and gyroscope, and figures of their quality."""

    accel: Correction
    """Correction of the force; its matrix is upper triangular."""
    gyro: Correction
    """Correction of the rate."""
    covariance: Array
    """21 x 21: accelerometer offset and upper triangle, gyroscope offset and matrix by rows."""
    directions: Array
    """n x 3: specific force of the rests, unit vectors in body axes."""
    missing: Array
    """3: the direction that is farthest from all of them."""
    missing_rad: float
    """Angle between that direction and the nearest rest."""
    chi2: float
    """Mean square of the weighted residuals, 1 when the noise of the rests explains them; sigmas hold what is above."""

    @property
    def parameters(self) -> Array:
        """21, in the order of covariance."""
        return np.concatenate([self.accel.offset, self.accel.matrix[UPPER], self.gyro.offset, self.gyro.matrix.ravel()])


def calibrate_sensors(recording: Recording, gravity_m_s2: float = G_M_S2) -> SensorCalibration:
    """Raises HnavValueError with the status "ill-conditioned" where rests and turns do not determine it: the text names what to add.

    gravity_m_s2: of the place; the scale of the accelerometer is relative to it.
    """
    from scipy.optimize import least_squares

    rests = rests_of(recording)
    refuse_few(recording.name, unit_vectors(rests.force))
    parameters = np.concatenate([np.zeros(3), np.eye(3)[UPPER], rests.rate.mean(axis=0), np.eye(3).ravel()])
    for _ in range(ROUNDS):
        root: Array = np.linalg.cholesky(covariance_of(rests, parameters)).astype(float)

        def weighted(p: Array, root: Array = root) -> Array:
            return np.asarray(np.linalg.solve(root, residuals(rests, p, gravity_m_s2)), float)

        fitted = least_squares(weighted, parameters, x_scale=SCALES, method="lm")
        parameters = fitted.x
    chi2 = float(2 * fitted.cost / max(1, len(fitted.fun) - PARAMETERS))
    scaled = fitted.jac * SCALES
    if np.linalg.matrix_rank(scaled) < PARAMETERS:
        raise _ill(recording.name, "the turns do not determine the gyroscope: turn it about each axis between rests, both ways")
    covariance = np.linalg.inv(scaled.T @ scaled) * np.outer(SCALES, SCALES) * max(1.0, chi2)
    accel, gyro = corrections(parameters, covariance)
    directions = unit_vectors(accel.apply(rests.force))
    missing, missing_rad = largest_gap(directions)
    _refuse_uncertain(recording.name, accel, gyro, missing)
    return SensorCalibration(accel, gyro, covariance, directions, missing, missing_rad, chi2)


# --------------------------------------------------------------------------------------------- what is measured


def rests_of(recording: Recording) -> Rests:
    """Raises HnavValueError when there are fewer than two."""
    from scipy.stats import chi2

    found = still_stretches(recording, LEAST_REST_S)
    gyro, accel = recording.samples("gyro"), recording.samples("accel")
    means, variances = zip(*(_block_means(*samples, found) for samples in (gyro, accel)))
    if len(found) < 2:
        raise _ill(
            recording.name, f"{len(found)} rests of {LEAST_REST_S:g} s were found: lay the sensor down, and do not touch it"
        )
    t_s = np.array(found)
    per_block = variances[0].mean(axis=0)
    counts = np.maximum(1, np.diff(t_s, axis=1) // BLOCK_S)
    white = per_block / counts
    spread, expected = means[0].var(axis=0, ddof=1), white.mean(axis=0)
    limit = chi2.ppf(SURE, len(found) - 1) / (len(found) - 1)
    wander = np.where(spread > limit * expected, spread - expected, 0.0)  # where it is no chance of the noise
    turns = {i: turn for i in range(len(found) - 1) if (turn := _turn(*gyro, found[i][1], found[i + 1][0])) is not None}
    if not turns:
        raise _ill(recording.name, f"no turn between two rests is shorter than {LONGEST_TURN_S:g} s and without a gap")
    length = 1 << (max(len(steps) for steps, _ in turns.values()) - 1).bit_length()
    steps_s, turn_rate = np.zeros((len(turns), length)), np.zeros((len(turns), length, 3))
    for row, (steps, rate) in enumerate(turns.values()):
        steps_s[row, : len(steps)], turn_rate[row, : len(steps)] = steps, rate
    force_variance = variances[1].mean(axis=0) / counts
    noise = (force_variance, white + wander, np.array([*turns]), steps_s, turn_rate, per_block * BLOCK_S, wander)
    return Rests(t_s, means[1], means[0], *noise)


def _block_means(t_s: Array, values: Array, spans: Sequence[tuple[float, float]]) -> tuple[Array, Array]:
    """Mean (n x 3) of each span, and variance of that mean from its blocks (n x 3)."""
    means, variances = [], []
    for begin_s, end_s in spans:
        rows = (t_s >= begin_s) & (t_s < end_s)
        block = ((t_s[rows] - begin_s) / BLOCK_S).astype(int)
        count = np.bincount(block)
        used = count > 0
        blocks = np.stack([np.bincount(block, axis)[used] / count[used] for axis in values[rows].T], axis=1)
        means.append(values[rows].mean(axis=0))
        variances.append(blocks.var(axis=0, ddof=1))
    return np.reshape(means, (-1, 3)), np.reshape(variances, (-1, 3))


def _turn(t_s: Array, rate: Array, begin_s: float, end_s: float) -> tuple[Array, Array] | None:
    """Durations and mean rates of the intervals between two rests; None where it is too long or has a gap."""
    first, last = np.searchsorted(t_s, [begin_s, end_s])
    rows = slice(max(0, first - 1), last + 1)  # one sample of the rest on either side
    steps = np.diff(t_s[rows])
    if end_s - begin_s > LONGEST_TURN_S or not len(steps) or np.max(steps) > LONGEST_GAP_S:
        return None
    return steps, 0.5 * (rate[rows][1:] + rate[rows][:-1])


# --------------------------------------------------------------------------------------------- the equations


def corrections(parameters: Array, covariance: Array) -> tuple[Correction, Correction]:
    """Corrections of accelerometer and gyroscope, with their sigmas."""
    sigma = np.sqrt(np.diag(covariance))
    made = []
    for values in (parameters, sigma):
        upper = np.zeros((3, 3))
        upper[UPPER] = values[3:9]
        made.append((values[:3], upper, values[9:12], values[12:].reshape(3, 3)))
    (offset_a, matrix_a, offset_g, matrix_g), (sigma_a, spread_a, sigma_g, spread_g) = made
    return Correction(matrix_a, offset_a, spread_a, sigma_a), Correction(matrix_g, offset_g, spread_g, sigma_g)


def residuals(rests: Rests, parameters: Array, gravity_m_s2: float) -> Array:
    """n of the length of the force in m/s2, 3 n of the rate at rest in rad/s, two for each turn: gravity across its expected direction."""
    accel, gyro = corrections(parameters, np.eye(PARAMETERS))
    force = accel.apply(rests.force)
    direction = unit_vectors(force)
    expected = np.einsum("mij,mj->mi", turns_of(rests.steps_s, gyro.apply(rests.turn_rate)), direction[rests.after])
    across = np.einsum("mij,mj->mi", tangents(direction[rests.after + 1]), expected)
    return np.concatenate([np.linalg.norm(force, axis=1) - gravity_m_s2, (rests.rate - gyro.offset).ravel(), across.ravel()])


def covariance_of(rests: Rests, parameters: Array) -> Array:
    """Sigmas of the residuals, by the noise of the means at rest and of the rates of the turns."""
    n, m = len(rests.force), len(rests.after)
    accel, gyro = corrections(parameters, np.eye(PARAMETERS))
    force = accel.apply(rests.force)
    direction, length = unit_vectors(force), np.linalg.norm(force, axis=1)
    by_force = np.zeros((4 * n + 2 * m, 3 * n))
    found = np.zeros((4 * n + 2 * m, 4 * n + 2 * m))
    for i in range(n):
        by_force[i, 3 * i : 3 * i + 3] = direction[i] @ accel.matrix
    found[n : 4 * n, n : 4 * n] = np.diag(rests.rate_variance.ravel())
    turns, sides = turns_of(rests.steps_s, gyro.apply(rests.turn_rate)), tangents(direction[rests.after + 1])
    for k, (i, back, across, duration_s) in enumerate(zip(rests.after, turns, sides, rests.steps_s.sum(axis=1))):
        rows = slice(4 * n + 2 * k, 4 * n + 2 * k + 2)
        by_force[rows, 3 * i : 3 * i + 3] = across @ back @ _of_direction(direction[i], length[i]) @ accel.matrix
        by_force[rows, 3 * i + 3 : 3 * i + 6] = -across @ _of_direction(direction[i + 1], length[i + 1]) @ accel.matrix
        turned = gyro.matrix @ np.diag(rests.rate_density * duration_s + rests.wander * duration_s**2) @ gyro.matrix.T
        cross = across @ np.cross(np.eye(3), back @ direction[i])
        found[rows, rows] += cross @ turned @ cross.T
    return np.asarray(found + (by_force * rests.force_variance.ravel()) @ by_force.T)


def turns_of(steps_s: Array, rate: Array) -> Array:
    """m x 3 x 3: body axes of the begin of each turn to those of its end. steps_s: m x L, rate: m x L x 3; L a power of two, so that
    neighbours are joined in pairs until one rotation of each turn is left."""
    turn = (steps_s[..., None] * rate).reshape(-1, 3)
    angle = np.linalg.norm(turn, axis=1)[:, None]
    q = np.concatenate([np.cos(0.5 * angle), 0.5 * np.sinc(angle / (2 * np.pi)) * turn], axis=1)
    while len(q) > len(steps_s):
        q = quaternion_product(q[::2], q[1::2])
    return rotated(np.repeat(q, 3, axis=0), np.tile(np.eye(3), (len(q), 1))).reshape(-1, 3, 3)


def _of_direction(direction: Array, length: float) -> Array:
    """3 x 3: derivative of the direction of a vector by the vector."""
    return np.asarray((np.eye(3) - np.outer(direction, direction)) / length)


def tangents(directions: Array) -> Array:
    """n x 2 x 3: unit vectors across each of n directions."""
    first = unit_vectors(np.cross(directions, np.eye(3)[np.argmin(np.abs(directions), axis=1)]))
    return np.stack([first, np.cross(directions, first)], axis=1)


def unit_vectors(vectors: Array) -> Array:
    """n x 3."""
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1)[:, None])


# --------------------------------------------------------------------------------------------- attitudes


def refuse_few(name: str, directions: Array) -> None:
    """Raises HnavValueError for fewer than ATTITUDES that are APART_RAD apart."""
    apart = distinct(directions)
    if len(apart) < ATTITUDES:
        raise _ill(name, f"{len(apart)} attitudes at rest, {ATTITUDES} are needed: {advice(largest_gap(directions)[0])}")


def distinct(directions: Array) -> Array:
    """Those of which each is APART_RAD or more from all others that are kept."""
    kept: list[Array] = []
    for one in directions:
        if all(one @ other < np.cos(APART_RAD) for other in kept):
            kept.append(one)
    return np.array(kept)


def largest_gap(directions: Array) -> tuple[Array, float]:
    """The direction of a lattice that is farthest from all of these, and how far."""
    k = np.arange(500)
    z, turn = 1 - (2 * k + 1) / 500, k * np.pi * (3 - np.sqrt(5))
    lattice = np.stack([np.sqrt(1 - z**2) * np.cos(turn), np.sqrt(1 - z**2) * np.sin(turn), z], axis=1)
    nearest = np.arccos(np.clip(lattice @ directions.T, -1, 1)).min(axis=1)
    return lattice[np.argmax(nearest)], float(nearest.max())


def advice(missing: Array) -> str:
    """How to lay the sensor so that its force points there."""
    axes = [f"{'-' if value < 0 else '+'}{name}" for name, value in zip("xyz", missing) if abs(value) > 1 / 3]
    said = ", ".join(f"{value + 0.0:.1f}" for value in missing)
    return f"lay it with {'the middle of ' if len(axes) > 1 else ''}{' and '.join(axes)} up, ({said}) in its axes"


def _refuse_uncertain(name: str, accel: Correction, gyro: Correction, missing: Array) -> None:
    """Raises HnavValueError where a sigma is above its limit."""
    if max(accel.sigma_offset.max() / LIMITS["accel offset"], accel.sigma_matrix.max() / LIMITS["accel matrix"]) > 1:
        raise _ill(name, f"the rests do not determine the accelerometer: more attitudes, such as: {advice(missing)}")
    if gyro.sigma_matrix.max() > LIMITS["gyro matrix"]:
        axis = "xyz"[int(np.argmax(gyro.sigma_matrix.max(axis=0)))]
        cure = f"turn it about its {axis} axis by 90 deg and more between rests, both ways"
        raise _ill(name, f"the turns do not determine the gyroscope: {cure}")


def _ill(name: str, text: str) -> HnavValueError:
    return HnavValueError("ill-conditioned", f"{name}: {text}")
