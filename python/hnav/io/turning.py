"""How a vector turns with the rates: dv/dt = -s (Q w) x (v - b), fitted over the 48 ways Q to name and sign three axes.

The field of a body that turns does so; a wrong unit of the rates is in s, wrong axes are another Q. Both sides are taken over the
same intervals between samples of v, then averaged over half a second: a fit of what is slow, where noise is small.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np

KNOT_S = 0.04  # averaging time of v
SMOOTH_S = 0.4
LONGEST_STEP_S = 0.5
MOVING_RAD_S = 0.1  # rms of the turning of v, below which noise and disturbances are as large
ENOUGH = 30
STAY_S, STAY_STEP_S, PARTS = 10.0, 0.02, 10
LARGEST_GRID = 10  # points for each sample: more are gaps
STAYS, STAYS_BETTER, STAYED = 0.95, 0.06, (0.9, 1.2)
AS_GOOD = 0.02  # correlations that differ by less count as equal
LEVI_CIVITA = np.zeros((3, 3, 3))
for _i, _j, _k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    LEVI_CIVITA[_i, _j, _k], LEVI_CIVITA[_i, _k, _j] = 1.0, -1.0

WAYS = np.array([np.diag(signs)[:, list(order)] for order in permutations(range(3)) for signs in product((1.0, -1.0), repeat=3)])
"""48 x 3 x 3: all signed permutations."""
IDENTITY = int(np.argmax([np.trace(way) for way in WAYS]))
HANDED = np.linalg.det(WAYS).round()


@dataclass(frozen=True)
class Way:
    """One assignment of the axes of the rates."""

    matrix: np.ndarray
    """3 x 3: Q."""
    correlation: float
    handed: float
    """1, or -1 for axes that a mirror shows."""


@dataclass(frozen=True)
class Fit:
    """Agreement of the rotation of v with the rates."""

    correlations: np.ndarray
    """48: of each of WAYS; 0 where v would turn against the rates."""
    scales: np.ndarray
    """48: s."""

    @property
    def as_it_is(self) -> float:
        """Correlation with the axes as they are."""
        return float(self.correlations[IDENTITY])

    @property
    def scale(self) -> float:
        """Of the rates as they are: below 1 they are too fast."""
        return float(self.scales[IDENTITY])


Samples = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Stay:
    """How much of the force stays where it is, seen from axes that the rates hold still: gravity does, accelerations average out.

    That holds for bodies that accelerate too much for a fit.
    """

    shares: np.ndarray
    """48: of the force with its axes named by each of WAYS; 1 where these are right."""

    @property
    def as_it_is(self) -> float:
        """With the axes as they are."""
        return float(self.shares[IDENTITY])

    @property
    def best(self) -> Way:
        """The way with which most stays, without a mirror: a way and its negative are alike."""
        i = int(np.argmax(np.where(HANDED > 0, self.shares, -1)))
        return Way(WAYS[i], float(self.shares[i]), 1.0)

    @property
    def decides(self) -> bool:
        """Whether wrong axes could be detected: when the body hardly turns, gravity stays with any axes."""
        others = [share for way, handed, share in zip(WAYS, HANDED, self.shares) if handed > 0 and np.trace(way) < 3]
        return bool(max(others) < STAYS)

    @property
    def off(self) -> bool:
        """Whether gravity stays with other axes and not with these."""
        return self.as_it_is < min(STAYS, self.best.correlation - STAYS_BETTER) and STAYED[0] < self.best.correlation < STAYED[1]


def stay_of(gyro: Samples, force: Samples, time_factor: float) -> Stay | None:
    """How much of the force stays over STAY_S, as a mean over the recording; None where it is shorter."""
    (gyro_s, rate), (force_s, values) = (gyro[0] * time_factor, gyro[1]), (force[0] * time_factor, force[1])
    if (held := held_force((gyro_s, rate), (force_s, values))) is None:
        return None
    edges_s, impulses = held
    size = STAY_S * float(np.median(np.linalg.norm(values, axis=1)))
    if size <= 0:
        return None
    return Stay(np.linalg.norm(np.einsum("kabc,wbc->wka", impulses.sum(axis=1), WAYS), axis=2).mean(axis=1) / size)


def held_force(gyro: Samples, force: Samples) -> tuple[np.ndarray, np.ndarray] | None:
    """Integral of the force over parts of windows of STAY_S, seen from axes that the rates hold still from its begin on.

    Edges of the parts in s, k x (PARTS + 1), and k x PARTS x 3 x 3 x 3: [a, b, c] is the integral in m/s of C_ab f_c, of which any way to
    name the axes of the force is a sum. None for a shorter recording.
    """
    from scipy.spatial.transform import Rotation  # takes longer to load than --help may

    (gyro_s, rate), (force_s, values) = gyro, force
    steps, length_s = round(STAY_S / STAY_STEP_S), float(gyro_s[-1] - gyro_s[0])
    count = int(length_s / STAY_S)
    if count == 0 or count * steps > LARGEST_GRID * len(gyro_s):
        return None
    grid_s = gyro_s[0] + STAY_STEP_S * np.arange(count * steps + 1)
    turns = Rotation.from_rotvec(integral_over(gyro_s, rate, grid_s)).as_matrix().reshape(count, steps, 3, 3)
    middle_s = grid_s[:-1] + 0.5 * STAY_STEP_S
    held = np.stack([np.interp(middle_s, force_s, column) for column in values.T], axis=1).reshape(count, steps, 3)
    attitude, impulses = np.broadcast_to(np.eye(3), (count, 3, 3)), np.zeros((count, PARTS, 3, 3, 3))
    for i in range(steps):
        impulses[:, i * PARTS // steps] += STAY_STEP_S * attitude[:, :, :, None] * held[:, i, None, None, :]
        attitude = attitude @ turns[:, i]
    edges_s = grid_s[:: steps // PARTS]
    return edges_s[np.arange(count)[:, None] * PARTS + np.arange(PARTS + 1)], impulses


def fit_of(gyro: Samples, vector: Samples, time_factor: float, offset: bool) -> Fit | None:
    """The fit; None where v hardly turns. offset: whether v may have a constant part b, such as hard iron."""
    t_s, values = _knots(vector[0] * time_factor, vector[1])
    if len(t_s) < ENOUGH:
        return None
    steps_s = np.diff(t_s)
    angle = integral_over(gyro[0] * time_factor, gyro[1], t_s)
    inside = (t_s[:-1] >= gyro[0][0] * time_factor) & (t_s[1:] <= gyro[0][-1] * time_factor)
    use = inside & (steps_s > 0) & (steps_s < LONGEST_STEP_S)
    if use.sum() < ENOUGH:
        return None
    steps_s = steps_s[use]
    rate = angle[use] / steps_s[:, None]
    middle = 0.5 * (values[1:] + values[:-1])[use]
    length = max(1, round(SMOOTH_S / float(np.median(steps_s))))
    turning = _smooth((np.diff(values, axis=0)[use] / steps_s[:, None]), length)
    size = float(np.median(np.linalg.norm(middle, axis=1)))
    if not np.sqrt((turning**2).sum(axis=1).mean()) > MOVING_RAD_S * size > 0:
        return None
    products = _smooth((rate[:, :, None] * middle[:, None, :]).reshape(-1, 9), length).reshape(-1, 3, 3)
    return _solve(turning / size, products / size, _smooth(rate, length) if offset else None)


def _solve(turning: np.ndarray, products: np.ndarray, rate: np.ndarray | None) -> Fit:
    """turning: n x 3; products: n x 3 x 3, rate_d v_c; rate: n x 3 where v may have a constant part.

    Every way is a linear combination of the same columns: their Gram matrix is made once.
    """
    columns = np.hstack([turning, products.reshape(-1, 9), *([] if rate is None else [rate])])
    gram = columns.T @ columns
    total = float(np.trace(gram[:3, :3]))
    correlations, scales = np.zeros(len(WAYS)), np.zeros(len(WAYS))
    for i, way in enumerate(WAYS):
        crossed = -np.einsum("abc,bd->adc", LEVI_CIVITA, way)  # a: of dv/dt, d: of the rate, c: of v
        design = np.zeros((3, len(gram) - 3, 1 if rate is None else 4))
        design[:, :9, 0] = crossed.reshape(3, 9)
        if rate is not None:
            design[:, 9:, 1:] = crossed
        normal = np.einsum("aki,kl,alj->ij", design, gram[3:, 3:], design, optimize=True)
        normal += 1e-9 * np.trace(normal) * np.eye(len(normal))  # a body that turns about one axis leaves b open
        right = np.einsum("aki,ka->i", design, gram[3:, :3])
        solution = np.linalg.solve(normal, right) if np.trace(normal) > 0 else np.zeros(len(right))
        scales[i] = solution[0]
        if solution[0] > 0 and total > 0:
            correlations[i] = np.sqrt(max(0.0, float(right @ solution) / total))
    return Fit(correlations, scales)


def best_fit(fit: Fit) -> Way:
    """The way with the highest correlation; of those as good, one without a mirror, and with the fewest changes."""
    good = np.flatnonzero(fit.correlations >= fit.correlations.max() - AS_GOOD)
    best = max(good, key=lambda i: (HANDED[i], np.trace(WAYS[i]), np.abs(WAYS[i]).trace()))
    return Way(WAYS[best], float(fit.correlations[best]), float(HANDED[best]))


def fixed_axes(way: np.ndarray, sensor: str, live: Mapping[str, Samples], hemisphere: str | None) -> np.ndarray:
    """The matrix that mends the axes of field or force where rates turned by way would fit: it, or its negative, by the dip."""
    turned = way.T * np.linalg.det(way).round()
    if "accel" in live and "mag" in live:
        (accel_s, force), (mag_s, field) = live["accel"], live["mag"]
        force = force[np.clip(np.searchsorted(accel_s, mag_s), 0, len(accel_s) - 1)]
        force, field = (force @ turned.T, field) if sensor == "accel" else (force, field @ turned.T)
        dip = float(np.median(-(force * field).sum(axis=1)))
        wanted = -1.0 if hemisphere == "south" else 1.0
        return np.asarray(turned if dip * wanted >= 0 else -turned)
    return np.asarray(turned if (turned < 0).sum() <= 1 else -turned)


def axes_text(matrix: np.ndarray) -> str:
    """As hnav.read takes it: y,x,-z."""
    return ",".join(("-" if row.min() < 0 else "") + "xyz"[int(np.abs(row).argmax())] for row in matrix)


def _knots(t_s: np.ndarray, values: np.ndarray) -> Samples:
    """Means over KNOT_S."""
    interval_s = float(np.median(np.diff(t_s))) if len(t_s) > 1 else KNOT_S
    count = max(1, round(KNOT_S / interval_s)) if interval_s > 0 else 1
    whole = len(t_s) // count * count
    return t_s[:whole].reshape(-1, count).mean(axis=1), values[:whole].reshape(-1, count, 3).mean(axis=1)


def integral_over(t_s: np.ndarray, values: np.ndarray, knots_s: np.ndarray) -> np.ndarray:
    """Of columns, over each interval of knots."""
    return np.diff(integral(t_s, values, knots_s), axis=0)


def integral(t_s: np.ndarray, values: np.ndarray, at_s: np.ndarray) -> np.ndarray:
    """Of columns from the first time on, by the trapezoid, at other times; beyond the last it stays."""
    steps = np.diff(t_s)[:, None] * 0.5 * (values[1:] + values[:-1])
    total = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(steps, axis=0)])
    return np.stack([np.interp(at_s, t_s, column) for column in total.T], axis=1)


def _smooth(values: np.ndarray, length: int) -> np.ndarray:
    """Moving means, one row for each whole window."""
    length = min(length, len(values))
    sums = np.cumsum(np.concatenate([np.zeros((1, values.shape[1])), values]), axis=0)
    return np.asarray((sums[length:] - sums[:-length]) / length)
