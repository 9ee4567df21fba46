"""Trial of a certificate on the nonlinear equations: errors that begin on the boundary of the certified region.

Each start is a second estimate beside the recorded one, corrected by the same gains and the same samples; their
difference obeys the nonlinear error equations exactly, without noise:
    flow   q' = 1/2 q (x) (0, w - b)          jump   x + K (y - h(q)), q <- q/|q|
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from hnav.certify.gain_record import Correction, GainRecord
from hnav.certify.hrekf import C_bn
from hnav.rotations import quaternion_exp, quaternion_product, rotated


@dataclass(frozen=True)
class BoundaryStarts:
    starts: int
    worst_ratio: float  # largest V(k) e^{2 sigma T} / V(k-1) at a correction; the certificate says at most 1
    V: np.ndarray  # starts x (corrections + 1), over the level
    final_share: float  # largest V at the end, over the level


Starts = tuple[np.ndarray, np.ndarray]  # unit quaternions (count x 4) and bias errors (count x 3)


def random_directions(count: int, rng: np.random.Generator) -> np.ndarray:
    """count x 6, uniform on the ellipsoid of any P."""
    return rng.normal(size=(6, count)).T


def boundary(P: np.ndarray, level: float, directions: np.ndarray) -> Starts:
    """(q, b) with e'Pe = level, e = (-vec q, b), along each direction (count x 6, in units of P^-1/2).

    The length is found by bisection, because q stays on the sphere.
    """
    count = len(directions)
    direction = np.linalg.solve(np.linalg.cholesky(P).T, directions.T).T
    direction *= np.sqrt(level / np.einsum("ki,ij,kj->k", direction, P, direction))[:, None]
    low, high = np.zeros(count), np.minimum(2, 0.5 * np.pi / np.linalg.norm(direction[:, :3], axis=1))

    def at(length: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        q = quaternion_exp(-length[:, None] * direction[:, :3])
        return q, length[:, None] * direction[:, 3:]

    for _ in range(60):
        middle = 0.5 * (low + high)
        q, b = at(middle)
        e = np.hstack([-q[:, 1:], b])
        inside = np.einsum("ki,ij,kj->k", e, P, e) <= level
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    return at(low)


def flow(c: Correction, q: np.ndarray, e_b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Relative attitude p = q_other (x) q_recorded* and bias error, in navigation axes, over the interval before c.

    The other estimate turns by u + e_b where the recorded one turns by u, so p is multiplied from the right by
    exp((u + e_b) T/2) exp(-u T/2), both in navigation axes: exact while the rate is held.
    """
    for rate_n, interval_s in c.turns:
        half = 0.5 * interval_s
        back = quaternion_exp(np.broadcast_to(-half * rate_n, e_b.shape))
        q = quaternion_product(q, quaternion_product(quaternion_exp(half * (rate_n + e_b)), back))
        e_b = Rotation.from_rotvec(interval_s * rate_n).apply(e_b)
    return q, e_b


def difference_of_measurements(c: Correction, q: np.ndarray) -> np.ndarray:
    """n x 6: h of the recorded attitude minus h of the attitude that differs from it by q (n x 4)."""
    to_body = C_bn(c.q_minus)
    conjugate = q * [1, -1, -1, -1]
    differences = []
    for rows in (slice(0, 3), slice(3, 6)):
        # Along q itself h grows as 2 h, so the first column of H identifies the vector that the sensor measures; zero if it is missing.
        vector_n = to_body.T @ (0.5 * c.H[rows, 0])
        turned = rotated(conjugate, vector_n)
        differences.append((vector_n - turned) @ to_body.T)
    return np.hstack(differences)


def fall_from_boundary(
    record: GainRecord,
    P: np.ndarray,
    after: np.ndarray,
    level: float,
    sigma: float,
    directions: np.ndarray,
    progress: Callable[[int, int], None] | None = None,
) -> BoundaryStarts:
    """Simulates over the whole record, in navigation axes: there the recorded attitude is (1, 0, 0, 0) at all times.

    directions: of the starts, as of boundary. P: places x 6 x 6, the first at the beginning; after: which of them holds after each correction.
    """
    q, e_b = boundary(P[0], level, directions)
    starts = len(directions)
    identity = np.array([1.0, 0, 0, 0])
    V = np.empty((starts, len(record.corrections) + 1))
    V[:, 0] = 1.0
    worst = 0.0
    for k, c in enumerate(record.corrections):
        q_minus, b_minus = flow(c, q, e_b)
        e_q = identity - q_minus
        seen = difference_of_measurements(c, q_minus)
        e = np.hstack([e_q, b_minus]) @ c.turn.T - seen @ c.K.T
        a = identity * c.norm - e[:, :4]
        q = a / np.linalg.norm(a, axis=1, keepdims=True)
        e_b = e[:, 4:]
        whole = np.hstack([-q[:, 1:], e_b])
        V[:, k + 1] = np.einsum("ki,ij,kj->k", whole, P[after[k]], whole) / level
        alive = V[:, k] > 1e-20
        if alive.any():
            worst = max(worst, float((V[alive, k + 1] / V[alive, k]).max() * np.exp(2 * sigma * c.interval_s)))
        if progress and (k % 50 == 49 or k == len(record.corrections) - 1):
            progress(k + 1, len(record.corrections))
    return BoundaryStarts(starts, worst, V, float(np.max(V[:, -1])))
