"""The inequality of the certificate: what one correction does to the error, its nonlinear rest bounded without a gap.

The error is that of a second estimate with the same gains and samples. With p = q_other (x) q_recorded*, a unit
quaternion of the angle theta, in navigation axes,

    e = (d, e_b),   d = -vec p,   e_b = b_recorded - b_other,   c = |1 - p| = 2 sin(theta / 4) <= rho

From just after one correction to just after the next, u = K_v w being what the correction takes off d (K_v: vector rows):

    flow     d- = Phi_d e + s           |s| <= 1/2 T c |e_b|: the flow is bilinear
    seen     w = H d- + r               w_i = Q y_i for both sensors i, y_i = H_i d-
    jump     e+ = J ((turn d-, e_b-) - K w + (n + m, 0)),    J = blkdiag(I/|q + K nu|, I)

Q is the turn by theta / 2 about d itself (a turned vector moves along a chord): it keeps lengths and angles, and as y_i is
across d, y_i'Q y_j + y_j'Q y_i = 2 cos(theta / 2) y_i'y_j = (2 - c^2) y_i'y_j. In terms of r = w - y that is

    r_i'r_j + y_i'r_j + r_i'y_j = 0                   for (i, j) = (1, 1), (2, 2), (1, 2), multipliers of either sign
    sum D_ij (rho^2 y_i'y_j - r_i'r_j) >= 0           for every D >= 0, 2 x 2

The return to the unit sphere lengthens d by what the correction shortens q: n = d' d'u / |q + K nu|^2, d' being d- in corrected
axes. It pushes along d only and undoes at most the share |d|^2 of u, so n'n <= alpha n'u, which a bound on |n| would
not know. All that is smaller is m, |m| <= beta |d-|; alpha and beta are derived at return_to_sphere. What m adds to V is
bounded by |a + m|^2 <= (1 + beta) |a|^2 + (1 + 1/beta) |m|^2 and P_dd <= kappa I.

With z = (e, r, s, n) the rest is quadratic forms F_i(z) >= 0 (or = 0), so the S-procedure gives: if P > 0, kappa and
multipliers tau exist with, for every correction k,

    X_k = blkdiag(e^{-2 sigma T} P, 0) - sum_i tau_i F_i - kappa (beta + beta^2) / |q + K nu|^2 C'C - (1 + beta) B'PB >= 0,
    e+ = B z + (m, 0) / |q + K nu|,    d- = C z

then V = e'Pe falls by e^{-2 sigma T} at every correction while c <= rho (Yakubovich 1971; Boyd et al., Linear Matrix
Inequalities in System and Control Theory, 1994, section 2.6.3). rho = 0 is the linear part, M = J (I - K H) Phi:
X_k = e^{-2 sigma T} P - M'PM. Where sensors are missing at corrections, the first P is that of the place in the window
before the correction, the second that of the place after it (windows.py), and each place has multipliers of its own.

The result of the solver is verified: X_k is computed for every correction and its smallest eigenvalue checked; corrections
that fail join the constraints (cutting planes).
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from functools import lru_cache

import numpy as np

from hnav.certify.gain_record import GainRecord, held_turns
from hnav.certify.semidefinite import BASIS, Blocks, CorrectionBlocks, DenseBlocks, N, smallest
from hnav.certify.windows import windows_of

ATTITUDE, BIAS = slice(0, 3), slice(3, 6)
FORCE, FIELD = slice(0, 3), slice(3, 6)  # rows of H
R, S, ALONG = slice(6, 12), slice(12, 15), slice(15, 18)  # of z, after e: r, s, n
Z = 18
MULTIPLIERS = 9  # tau: of D (11, 22, 12), of the equalities (11, 22, 12), of s and n; last kappa
FIRST_VERTICES, NEW_VERTICES, PASSES = 10, 4, 16
ACTIVE = 2.0  # times the margin: a constraint whose smallest eigenvalue is below
CHECKED_AT_ONCE = 1000  # corrections, so that long records fit into memory
LEAST_MARGIN = 1e-6  # asked of the solver, whose answers are good to 1e-7, so that the check finds X >= 0


def flow_matrix(rate_n: np.ndarray) -> np.ndarray:
    """6 x 6, of the error in navigation axes: d' = -1/2 e_b, e_b' = rate_n x e_b."""
    A = np.zeros((N, N))
    A[ATTITUDE, BIAS] = -0.5 * np.eye(3)
    x, y, z = rate_n
    A[BIAS, BIAS] = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
    return A


def flow_maps(rate_n: np.ndarray, interval_s: float) -> np.ndarray:
    """m x 6 x 6: exp(flow_matrix T) for every rate (m x 3)."""
    maps = np.zeros((len(rate_n), N, N))
    maps[:, ATTITUDE, ATTITUDE] = np.eye(3)
    maps[:, BIAS, BIAS], path = held_turns(rate_n, interval_s)
    maps[:, ATTITUDE, BIAS] = -0.5 * path
    return maps


Bounds = tuple[np.ndarray, np.ndarray]  # alpha and beta, one for each correction


def return_to_sphere(record: GainRecord, rho: float) -> Bounds:
    """alpha and beta, one for each correction: n'n <= alpha n'u, |m| <= beta |d-| while c <= rho. beta is infinite where
    the bound breaks down.

    In corrected axes the second estimate before its return is a = turn p + K nu + K w, and the recorded one has the length
    norm = |turn 1 + K nu|. With d' = -vec(turn p) = turn_vv d- + turn_v0 (1 - p_0), u = K_v w and v = d' - u = -vec a,

        |a|^2 = norm^2 (1 + x),    norm^2 x = -2 d'u + xi,    |xi| <= 2 |K nu| |K w| + |K w|^2 + 2 c |K nu| + 2 |K_0 w|
        d+ = v / |a| = v (1 - x/2 + eta) / norm,    |eta| <= 3/8 x^2 / (1 - |x|)^{5/2}    (Taylor)
           = (turn_vv d- - u + n + m) / norm,       n = d' d'u / norm^2
        m = turn_v0 (1 - p_0) - u d'u / norm^2 + v (eta - xi / (2 norm^2))

    |w| = |H d-|, for Q keeps lengths; |d-| <= delta = sin(theta/2) at c = rho; 1 - p_0 = |d-| tan(theta/4).
    """
    quarter = np.arcsin(0.5 * rho)
    delta, tangent = np.sin(2 * quarter), np.tan(quarter)
    c = record.corrections
    K, H = np.stack([x.K[:4] for x in c]), np.linalg.norm(np.stack([x.H[:, 1:4] for x in c]), 2, axis=(1, 2))
    gain, vector_gain = np.linalg.norm(K, 2, axis=(1, 2)), np.linalg.norm(K[:, 1:], 2, axis=(1, 2))
    k_nu = np.linalg.norm(K @ np.stack([x.nu for x in c])[:, :, None], axis=(1, 2))
    carried = tangent * np.linalg.norm(np.stack([x.turn[1:4, 0] for x in c]), axis=1)
    squared = np.array([x.norm for x in c]) ** 2
    # turn_vv is a block of an orthogonal matrix: it lengthens nothing.
    d, u, k_w = (1 + carried) * delta, vector_gain * H, gain * H * delta
    xi = 2 * k_nu * k_w + k_w**2 + 2 * rho * k_nu + 2 * np.linalg.norm(K[:, 0], axis=1) * H * delta
    x = (2 * d * u * delta + xi) / squared
    with np.errstate(divide="ignore", invalid="ignore"):
        eta = np.where(x < 1, 0.375 * x**2 / (1 - x) ** 2.5, np.inf)
    beta = carried + u * d * u * delta / squared + (1 + carried + u) * (eta + xi / (2 * squared))
    return d**2 / squared, beta


# P and tau of every place in a window, and the smallest eigenvalue of all X_k.
Solution = tuple[np.ndarray, np.ndarray, float]


def symmetric(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """m x Z x Z: the quadratic forms a'b of linear forms a, b (m x rows x Z)."""
    product = np.swapaxes(a, 1, 2) @ b
    return np.asarray(0.5 * (product + np.swapaxes(product, 1, 2)))


def multipliers_hold(tau: np.ndarray) -> bool:
    """Whether those of inequalities, and kappa, have the sign that the S-procedure asks for."""
    D = tau[[0, 2, 2, 1]].reshape(2, 2)
    return bool(np.linalg.eigvalsh(D)[0] >= 0 and (tau[6:] >= 0).all())


def multipliers_bound(P: np.ndarray, tau: np.ndarray) -> bool:
    """Whether those of every place hold, and kappa bounds the attitude block of its P."""
    bounded = np.linalg.eigvalsh(P[:, ATTITUDE, ATTITUDE])[:, -1] <= tau[:, -1]
    return bool(bounded.all()) and all(multipliers_hold(t) for t in tau)


def with_signs(tau: np.ndarray) -> np.ndarray:
    """The nearest multipliers that hold: those of the solver may miss their signs by its tolerance."""
    values, vectors = np.linalg.eigh(tau[[0, 2, 2, 1]].reshape(2, 2))
    D = (vectors * (np.maximum(values, 0) + 1e-15)) @ vectors.T
    return np.concatenate([[D[0, 0], D[1, 1], D[0, 1]], tau[3:6], np.maximum(tau[6:], 0)])


def _deepest(least: np.ndarray, most: int) -> np.ndarray:
    """Where the smallest eigenvalues have local minima below 0, the smallest first: neighbours constrain alike."""
    around = np.r_[np.inf, least, np.inf]
    at = np.flatnonzero((least < 0) & (least <= around[:-2]) & (least < around[2:]))
    return at[np.argsort(least[at])][:most]


class SampledDataInequality:
    """X_k for all corrections of a record, in scaled errors (d, scale e_b); affine in P (places x 6 x 6) and in tau and
    kappa (places x 9).
    """

    def __init__(self, record: GainRecord, scale: float):
        c = record.corrections
        self.record, self.D, self.scale = record, np.diag([1.0] * 3 + [scale] * 3), scale
        self.to_e = np.diag(1 / np.diag(self.D))
        self.T = np.array([x.interval_s for x in c])
        self.Phi = np.stack([x.Phi[1:, 1:] for x in c]) @ self.to_e
        self.JK = np.stack([self.D @ (x.J @ x.K)[1:] for x in c])
        self.JIKH = np.stack([self.D @ (x.J @ x.IKH)[1:, 1:] for x in c])
        self.H = np.stack([x.H[:, 1:4] for x in c])
        self.K_v = np.stack([x.K[1:4] for x in c])
        self.norm = np.array([x.norm for x in c])
        self.windows = windows_of(record)
        self.before, self.after = self.windows.before, self.windows.after
        self.bounds: Callable[[float], Bounds] = lru_cache(maxsize=1)(lambda rho: return_to_sphere(record, rho))
        self.programs: list[int] = []  # corrections in each that was solved, here and in copies with other intervals
        self.forget_vertices()

    def forget_vertices(self) -> None:
        """Back to a few, evenly spread: those that another question added only cost time."""
        spread = range(0, len(self.T), max(1, len(self.T) // FIRST_VERTICES))
        self.vertices = sorted({*spread, *self._first_of_each_step(np.zeros(len(self.T)))})

    def _first_of_each_step(self, order: np.ndarray) -> list[int]:
        """Of the corrections that lead from one place to another, the first in the order; for each such pair of places."""
        k = np.argsort(order, kind="stable")
        _, first = np.unique(self.before[k] * self.windows.places + self.after[k], return_index=True)
        found: list[int] = k[first].tolist()
        return found

    @property
    def M(self) -> np.ndarray:
        """m x 6 x 6: the linear error map of every correction."""
        return self.JIKH @ self.Phi

    def with_interval(self, interval_s: float) -> SampledDataInequality:
        """Each correction interval_s after the one before, its gain unchanged and the rate held that it had just before."""
        changed = copy.copy(self)
        changed.T = np.full(len(self.T), interval_s)
        changed.Phi = flow_maps(np.stack([c.turns[-1][0] for c in self.record.corrections]), interval_s) @ self.to_e
        changed.vertices = list(self.vertices)
        return changed

    def and_interval(self, interval_s: float) -> SampledDataInequality:
        """The corrections as they are and, behind them, all of them interval_s apart: what holds here allows any mixture."""
        other, both = self.with_interval(interval_s), copy.copy(self)
        for name in ("T", "Phi", "JK", "JIKH", "H", "K_v", "norm", "before", "after"):
            setattr(both, name, np.concatenate([getattr(self, name), getattr(other, name)]))

        def twice(rho: float) -> Bounds:
            alpha, beta = self.bounds(rho)
            return np.tile(alpha, 2), np.tile(beta, 2)

        both.bounds = twice
        both.vertices = self.vertices + [k + len(self.T) for k in self.vertices]
        return both

    def used(self, k: np.ndarray) -> np.ndarray:
        """m x Z: which elements of z there are. A sensor that is missing at the correction leaves no remainder r."""
        found = np.ones((len(k), Z), bool)
        found[:, R] = np.repeat(np.stack([np.any(self.H[k][:, rows], axis=(1, 2)) for rows in (FORCE, FIELD)], axis=1), 3, axis=1)
        return found

    def terms(self, k: np.ndarray, rho: float) -> tuple[np.ndarray, list[np.ndarray]]:
        """B (m x 6 x Z), times sqrt(1 + beta), and the forms F_i (m x Z x Z) of the corrections k; the last is that of kappa.

        Remainders in units of their bounds, z = bound z', keep the numbers of the inequality alike.
        """
        m = len(k)
        alpha, beta = (bound[k] for bound in self.bounds(rho))
        most_u = np.linalg.norm(self.K_v[k], axis=(1, 2)) * np.linalg.norm(self.H[k], axis=(1, 2)) + 1e-12  # of |u| / |d-|
        unit_s, unit_n = (unit[:, None, None] for unit in (0.5 * rho * self.T[k], alpha * most_u))
        e, r, s, n = (np.broadcast_to(np.eye(Z)[part], (m, len(np.eye(Z)[part]), Z)) for part in (slice(0, N), R, S, ALONG))

        d_minus = self.Phi[k][:, ATTITUDE] @ e + unit_s * s
        y = self.H[k] @ d_minus
        r = self.used(k)[:, R][:, :, None] * r
        u = self.K_v[k] @ (y + rho * r)
        after = self.JIKH[k] @ np.concatenate([d_minus, self.Phi[k][:, BIAS] @ e], axis=1) - self.JK[k] @ (rho * r)
        lengthened = unit_n * n / self.norm[k][:, None, None]
        B = after + np.concatenate([lengthened, np.zeros((m, 3, Z))], axis=1)
        B = np.sqrt(1 + beta)[:, None, None] * B

        pairs = [(y[:, i], y[:, j], r[:, i], r[:, j]) for i, j in ((FORCE, FORCE), (FIELD, FIELD), (FORCE, FIELD))]
        shorter = [symmetric(y_i, y_j) - symmetric(r_i, r_j) for y_i, y_j, r_i, r_j in pairs]
        turned = [rho * symmetric(r_i, r_j) + symmetric(y_i, r_j) + symmetric(r_i, y_j) for y_i, y_j, r_i, r_j in pairs]
        e_b = e[:, BIAS] / self.scale
        return B, [
            *shorter[:2], 2 * shorter[2], *turned[:2], 2 * turned[2],
            symmetric(e_b, e_b) - symmetric(s, s),
            (alpha[:, None, None] / unit_n) * symmetric(n, u) - symmetric(n, n),
            ((beta + beta**2) / self.norm[k] ** 2)[:, None, None] * symmetric(d_minus, d_minus),
        ]  # fmt: skip

    def X(self, k: np.ndarray, P: np.ndarray, tau: np.ndarray, sigma: float, rho: float) -> np.ndarray:
        """m x 6 x 6 when rho is 0, else m x Z x Z."""
        if rho == 0:
            return self._part_of_P(k, P[self.before[k]], P[self.after[k]], sigma, self.M[k])
        B, forms = self.terms(k, rho)
        X: np.ndarray = self._part_of_P(k, P[self.before[k]], P[self.after[k]], sigma, B)
        for i, F in enumerate(forms):
            X -= tau[self.after[k], i][:, None, None] * F
        absent = np.where(self.used(k), 0.0, 1.0)
        return X + absent[:, :, None] * np.eye(Z)

    def _part_of_P(self, k: np.ndarray, before: np.ndarray, after: np.ndarray, sigma: float, B: np.ndarray) -> np.ndarray:
        X: np.ndarray = -np.swapaxes(B, 1, 2) @ after @ B
        X[:, :N, :N] += np.exp(-2 * sigma * self.T[k])[:, None, None] * before
        return X

    def smallest_eigenvalues(self, P: np.ndarray, tau: np.ndarray, sigma: float, rho: float) -> np.ndarray:
        """Of X_k, for every correction."""
        every = np.arange(len(self.T))
        parts = [every[i : i + CHECKED_AT_ONCE] for i in range(0, len(every), CHECKED_AT_ONCE)]
        return np.concatenate([np.linalg.eigvalsh(self.X(k, P, tau, sigma, rho))[:, 0] for k in parts])

    def solve(self, sigma: float, rho: float) -> Solution | None:
        """(P, tau, smallest eigenvalue) that holds for every correction, or None. Adds cutting planes until it does."""
        if rho > 0 and not np.isfinite(self.bounds(rho)[1]).all():
            return None
        margin = max(LEAST_MARGIN, 1e-3 * (1 - np.exp(-2 * sigma * self.T.min())))
        for _ in range(PASSES):
            found = self.solve_at_vertices(sigma, rho, margin)
            if found is None:
                return None
            P, tau = found
            least = self.smallest_eigenvalues(P, tau, sigma, rho)
            failing = np.flatnonzero(least < 0)
            if len(failing) == 0 and np.linalg.eigvalsh(P).min() > 0 and (rho == 0 or multipliers_bound(P, tau)):
                # The next question is alike: the corrections that were nearest to failing are where to begin with it, all whose
                # constraint is active and not too few, for the solver breaks down at programs that leave P almost free.
                nearest = sorted(self.vertices, key=lambda k: least[k])
                active = sum(least[k] < ACTIVE * margin for k in nearest)
                self.vertices = sorted({*nearest[: max(active, FIRST_VERTICES)], *self._first_of_each_step(least)})
                return P, tau, float(least.min())
            worst = {*_deepest(least, NEW_VERTICES).tolist()}
            worst |= {k for k in self._first_of_each_step(least) if least[k] < 0}
            if worst <= set(self.vertices):
                return None  # the solver's answer is not good enough at its own constraints
            self.vertices = sorted({*self.vertices, *worst})
        return None

    def solve_at_vertices(self, sigma: float, rho: float, margin: float) -> tuple[np.ndarray, np.ndarray] | None:
        """The smallest sum of traces of P >= I over the vertices; None when the solver finds none."""
        k = np.array(self.vertices)
        self.programs.append(len(k))
        B, forms = (self.M[k], []) if rho == 0 else self.terms(k, rho)
        places, elements, count, z = self.windows.places, BASIS.shape[1], len(forms), B.shape[2]
        P_at = np.arange(places * elements).reshape(places, elements)
        tau_at = places * elements + np.arange(places * count).reshape(places, count)
        before, after = self.before[k], self.after[k]
        # An element of z that is missing has a 1 on the diagonal of its block.
        constant = np.where(self.used(k)[:, :z], margin, margin - 1)[:, :, None] * np.eye(z)
        F = np.stack(forms, axis=1) if forms else np.zeros((len(k), 0, z, z))
        unknowns = np.concatenate([P_at[before], P_at[after], tau_at[after]], axis=1)
        blocks = [CorrectionBlocks(np.exp(-2 * sigma * self.T[k]), B, F, unknowns, constant), *_blocks_of_places(P_at, tau_at)]
        cost = np.zeros(places * (elements + count))
        cost[P_at] = BASIS[:: N + 1].sum(axis=0)
        x = smallest(cost, blocks)
        if x is None:
            return None
        tau = np.zeros((places, MULTIPLIERS)) if rho == 0 else np.stack([with_signs(t) for t in x[tau_at]])
        return (x[P_at] @ BASIS.T).reshape(places, N, N), tau


def _blocks_of_places(P_at: np.ndarray, tau_at: np.ndarray) -> list[Blocks]:
    """P >= I and, where there are multipliers, their signs and kappa I >= P_dd."""

    def at_each(F: np.ndarray, unknowns: np.ndarray, least: float) -> DenseBlocks:
        places, n = len(unknowns), len(F)
        return DenseBlocks(np.broadcast_to(F, (places, *F.shape)), unknowns, np.broadcast_to(least * np.eye(n), (places, n, n)))

    of_P = BASIS.reshape(N, N, -1)
    found: list[Blocks] = [at_each(of_P, P_at, 1.0)]
    if tau_at.shape[1]:
        D, positive = np.zeros((2, 2, MULTIPLIERS)), np.zeros((2, 2, MULTIPLIERS))
        D[[0, 1, 0, 1], [0, 1, 1, 0], [0, 1, 2, 2]] = 1
        positive[[0, 1], [0, 1], [-3, -2]] = 1
        kappa = np.concatenate([-of_P[ATTITUDE, ATTITUDE], np.eye(3)[:, :, None]], axis=-1)
        found += [at_each(D, tau_at, 0.0), at_each(positive, tau_at, 0.0)]
        found += [at_each(kappa, np.concatenate([P_at, tau_at[:, -1:]], axis=1), LEAST_MARGIN)]
    return found
