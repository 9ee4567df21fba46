"""Stability certificate of a recorded run: Theorem 1 of the paper in a form that can hold, and can fail.

As printed the theorem asks the flow to contract; quaternion kinematics never do, and its dwell condition points the
wrong way (printed_theorem). Here flow and jump are taken together, from just after one correction to just after the
next. The error is that of a second estimate with the same gains and samples: with p = q_other (x) q_recorded*, a unit
quaternion, in navigation axes,

    e = (d, e_b),   d = -vec p,   e_b = b_recorded - b_other,   c = |1 - p| = 2 sin(angle / 4)
    flow    d' = -1/2 e_b + ...,     after it  d- = Phi_d e + s      |s| <= 1/2 T c |e_b|     the flow is bilinear
    seen    h_recorded - h_other = H d- + r                          |r| = c |H d-|           h is quadratic
    jump    e+ = J (I - K H) (d-, e_b) - J K r + (n, 0)              |n| <= f(c) |d-|         the return to the sphere

with J = blkdiag(I/|q + K nu|, I); f is derived at sphere_bound. While c <= rho every bound is a multiple of a linear form
of z = (e, r, s, n), so the S-procedure gives: if P > 0 and tau >= 0 exist with, for every correction k,

    X_k = blkdiag(e^{-2 sigma T} P, 0) + sum_i tau_i (E_i'E_i - C_i'C_i) - B'PB >= 0,    B = [M, -JK, J(I-KH)_d, E_d],  M = J(I-KH) Phi

then V = e'Pe falls by e^{-2 sigma T} at every correction once e is in {V <= level} (Yakubovich 1971; Boyd et al., Linear
Matrix Inequalities in System and Control Theory, 1994, section 2.6.3). The solver is never trusted: X_k is computed
anew for every correction and its smallest eigenvalue looked at; corrections that fail join the constraints (cutting
planes). Only what passed on all of them is reported.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

from hnav.boundary_starts import BoundaryStarts, fall_from_boundary
from hnav.gain_record import CHANNELS, Correction, GainRecord
from hnav.library import HnavError

N = 6
ATTITUDE, BIAS = slice(0, 3), slice(3, 6)
FIRST_VERTICES, NEW_VERTICES, PASSES = 25, 12, 8
LEAST_MARGIN = 1e-6  # asked of the solver, whose answers are good to 1e-8, so that the check finds X >= 0
SHARE_OF_RATE = 0.25  # of the linear rate that is kept when the region is sought: the rest pays for the remainders
LONGEST_HOLD_S = 100.0
LARGEST_RADIUS, LEAST_RADIUS = 1.0, 1e-4  # of c: 120 and 0.01 deg
Progress = Callable[[str, int, int], None]  # what, done, of


@dataclass(frozen=True)
class PrintedTheorem:
    """What the theorem asks as printed. d > 0: its block (1,1) is (e^-d - 1) P, negative for every P > 0. d < 0: below."""

    smallest_d: float  # |d| at least, for d < 0: ln(1 + 2 |K| sqrt(eta))
    needed_flow_rate_1_s: float  # contraction that the flow must then have, more than |d|/T
    flow_rate_1_s: float  # what it has
    holds: bool


@dataclass
class Certificate:
    """Figures of a record; NaN where the search did not come so far."""

    name: str
    corrections: int
    interval_s: float  # median
    largest_difference: float  # of library and reference, see gain_record
    certified: bool = False
    reason: str = ""
    spectral_rate_1_s: float = np.nan  # of the slowest single M: no certificate can exceed it
    rate_1_s: float = np.nan  # of |e| near zero: linear part, one P for all corrections
    region_rate_1_s: float = np.nan  # of |e| inside the region, remainders included
    region_deg: float = np.nan  # largest attitude error inside the region
    region_bias_deg_s: float = np.nan  # largest bias error inside
    sure_deg: float = np.nan  # every attitude error below this is inside, if the bias error is zero
    noise_floor_deg: float = np.nan  # bound on the rms attitude error that noise sustains
    noise_share: float = np.nan  # bound on E V over the level of the region; above 1 noise may leave it
    longest_interval_s: float = np.nan  # T_max: with these gains the linear part is certified up to it
    smallest_eigenvalue: float = np.nan  # of all X_k at the radius reported
    tau: tuple[float, ...] = ()
    P: np.ndarray | None = None
    level: float = np.nan
    vertices: int = 0
    solves: int = 0
    seconds: float = np.nan
    free_rate_1_s: np.ndarray = field(default_factory=lambda: np.empty(0))  # see free_rates
    t_s: np.ndarray = field(default_factory=lambda: np.empty(0))
    starts: BoundaryStarts | None = None
    printed: PrintedTheorem | None = None
    attenuation: float = np.nan  # error energy over disturbance energy; needs the truth
    gamma_squared: float = np.nan  # largest in the record: what the attenuation must stay below; infinite without gamma

    def figures(self) -> dict:
        """Plain numbers for JSON and reports; what is not known is None."""
        known = {k: v for k, v in vars(self).items() if k not in ("P", "t_s", "free_rate_1_s", "starts", "printed", "tau")}
        known |= {"tau": list(self.tau), "P": None if self.P is None else self.P.tolist()}
        known |= {"dwell_ratio": self.longest_interval_s / self.interval_s}
        known |= {f"free_rate_{name}_1_s": float(f(self.free_rate_1_s)) for name, f in (("min", np.min), ("median", np.median)) if len(self.free_rate_1_s)}
        for name in ("starts", "printed"):
            part = getattr(self, name)
            known[name] = None if part is None else {k: v for k, v in vars(part).items() if not isinstance(v, np.ndarray)}
        return {k: None if isinstance(v, float) and not np.isfinite(v) else v for k, v in known.items()}


# --------------------------------------------------------------------------------------------- what needs no solver


def free_rates(record: GainRecord) -> np.ndarray:
    """1/s, one for each correction but the first: -ln |L_k^-1 M_k L_{k-1}| / T with P_k = L_k L_k'.

    The rate at which e'P_k^-1 e falls, P_k the filter's own covariance; it needs one P for each correction, so it
    proves less than a common P, and costs next to nothing. Along q the covariance is zero: six coordinates.
    """
    L = np.linalg.cholesky(np.stack([c.P[1:, 1:] for c in record.corrections]))
    M = np.stack([c.M[1:, 1:] for c in record.corrections])
    factor = np.linalg.norm(np.linalg.solve(L[1:], M[1:] @ L[:-1]), 2, axis=(1, 2))
    return -np.log(factor) / np.array([c.interval_s for c in record.corrections[1:]])


def printed_theorem(record: GainRecord) -> PrintedTheorem:
    """For d < 0 the printed inequality is e^|d| - 1 = g with g P >= P K K' P + eta I. Some P does exactly when
    g >= 2 |K| sqrt(eta): along the first singular vector of K, g x >= |K|^2 + eta x^2. eta = 8 bounds the remainder of h
    for any two unit quaternions, |h(e)|^2 = 2 |e|^4 <= 8 |e|^2. The flow's error matrix has no eigenvalue off the imaginary axis."""
    gain = max(np.linalg.norm(c.K, 2) for c in record.corrections)
    d = np.log1p(2 * gain * np.sqrt(8.0))
    T = np.median([c.interval_s for c in record.corrections])
    flow = -max(np.linalg.eigvals(flow_matrix(c.turns[-1][0])).real.max() for c in record.corrections[:: max(1, len(record.corrections) // 50)])
    return PrintedTheorem(float(d), float(d / T), 0.0 if abs(flow) < 1e-12 else float(flow), bool(flow > d / T))


def flow_matrix(rate_n: np.ndarray) -> np.ndarray:
    """6 x 6, of the error in navigation axes: d' = -1/2 e_b, e_b' = rate_n x e_b."""
    A = np.zeros((N, N))
    A[ATTITUDE, BIAS] = -0.5 * np.eye(3)
    x, y, z = rate_n
    A[BIAS, BIAS] = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
    return A


def sphere_bound(c: Correction, rho: float) -> float:
    """f with |n| <= f |d-| while |1 - p| <= rho; infinite where the bound breaks down.

    d+ = a_d / |a|, a = q_other + K nu_other in axes of the corrected attitude. Its length differs from that of the
    recorded one by little, for K nu is nearly across q: with s = 2 sqrt(2) rho >= |nu_other - nu|, K_0 the row of K along q,
        | |a|^2 - norm^2 | <= 2 |K_0| s + 2 rho |K| (|nu| + s) + |K|^2 s (2 |nu| + s)
    The corrected axes differ from the predicted ones by the quaternion turn, which carries 1 - p_0 = |d| tan(angle/4) into d.
    """
    seen, innovation = 2 * np.sqrt(2) * rho, np.linalg.norm(c.nu)
    gain, along = np.linalg.norm(c.K[:4], 2), np.linalg.norm(c.turn[:4, 0] @ c.K[:4])
    squares = 2 * along * seen + 2 * rho * gain * (innovation + seen) + gain**2 * seen * (2 * innovation + seen)
    shortest = c.norm**2 - squares
    if not shortest > 0:
        return np.inf
    difference = squares / (c.norm + np.sqrt(shortest))
    carried = np.linalg.norm(c.turn[1:4, 0]) * 0.5 * rho / np.sqrt(1 - 0.25 * rho**2)
    raw = 1 + gain * np.linalg.norm(c.H[:, :4], 2) * (1 + rho) + carried
    return carried / c.norm + raw * difference / (c.norm * np.sqrt(shortest))


# --------------------------------------------------------------------------------------------- the inequality


class SampledDataInequality:
    """X_k for all corrections of a record, in scaled errors (d, scale e_b); affine in P and tau.

    rho = 0: the linear part alone, e^{-2 sigma T} P - M'PM.
    """

    def __init__(self, record: GainRecord, scale: float):
        c = record.corrections
        self.record, self.D = record, np.diag([1.0] * 3 + [scale] * 3)
        inverse = np.diag(1 / np.diag(self.D))
        self.T = np.array([x.interval_s for x in c])
        self.M = np.stack([self.D @ x.M[1:, 1:] @ inverse for x in c])
        self.JK = np.stack([self.D @ (x.J @ x.K)[1:] for x in c])
        self.JIKH = np.stack([self.D @ (x.J @ x.IKH)[1:, 1:] for x in c])
        self.predicted = np.stack([np.hstack([x.Phi[1:4, 1:] @ inverse, np.zeros((3, CHANNELS)), np.eye(3), np.zeros((3, 3))]) for x in c])
        self.H = np.stack([x.H[:, 1:4] for x in c])
        self.bias = np.eye(N, N + CHANNELS + 6)[BIAS] / scale
        self.solves = 0
        self.vertices = list(range(0, len(c), max(1, len(c) // FIRST_VERTICES)))

    def with_interval(self, interval_s: float) -> np.ndarray:
        """M of all corrections if each came interval_s after the one before, its gain unchanged."""
        Phi = expm(np.stack([flow_matrix(c.turns[-1][0]) for c in self.record.corrections]) * interval_s)
        return self.JIKH @ Phi @ np.diag(1 / np.diag(self.D))

    def terms(self, k: np.ndarray, rho: float) -> tuple[np.ndarray, list[np.ndarray]]:
        """B (m x 6 x 18) and, for each remainder, E'E - C'C (m x 18 x 18), of the corrections k.

        Remainders in units of their bounds, z = bound z', keep the numbers of the inequality alike.
        """
        m, rows = len(k), N + CHANNELS + 6
        to_d = np.broadcast_to(np.eye(N)[:, ATTITUDE], (m, N, 3))
        B = np.concatenate([self.M[k], -self.JK[k], self.JIKH[k][:, :, ATTITUDE], to_d], axis=2)
        unit = np.ones((m, 1, rows))
        forms = []
        for first, size, bound, C in (
            (N, CHANNELS, np.full(m, rho), self.H[k] @ self.predicted[k]),
            (N + CHANNELS, 3, 0.5 * self.T[k] * rho, np.broadcast_to(self.bias, (m, 3, rows))),
            (N + CHANNELS + 3, 3, self.sphere[k], self.predicted[k]),
        ):
            unit[:, 0, first : first + size] = bound[:, None]
            forms.append((np.diag((np.arange(rows) >= first) & (np.arange(rows) < first + size)).astype(float), C))
        return B * unit, [E - np.swapaxes(C * unit, 1, 2) @ (C * unit) for E, C in forms]

    def X(self, k: np.ndarray, P: np.ndarray, tau: np.ndarray, sigma: float, rho: float, M: np.ndarray | None = None) -> np.ndarray:
        """m x 6 x 6 when rho is 0, else m x 18 x 18."""
        if rho == 0:
            return self._part_of_P(k, P, sigma, (self.M if M is None else M)[k])
        B, forms = self.terms(k, rho)
        return self._part_of_P(k, P, sigma, B) + sum(t * F for t, F in zip(tau, forms))

    def _part_of_P(self, k: np.ndarray, P: np.ndarray, sigma: float, B: np.ndarray) -> np.ndarray:
        X = -np.swapaxes(B, 1, 2) @ P @ B
        X[:, :N, :N] += np.exp(-2 * sigma * self.T[k])[:, None, None] * P
        return X

    def solve(self, sigma: float, rho: float, M: np.ndarray | None = None):
        """(P, tau, smallest eigenvalue) that holds for every correction, or None. Adds cutting planes until it does."""
        if rho > 0:
            self.sphere = np.array([sphere_bound(c, rho) for c in self.record.corrections])
            if not np.isfinite(self.sphere).all():
                return None
        margin = max(LEAST_MARGIN, 1e-3 * (1 - np.exp(-2 * sigma * self.T.min())))
        every = np.arange(len(self.T))
        for _ in range(PASSES):
            found = self._solve_at_vertices(sigma, rho, M, margin)
            if found is None:
                return None
            P, tau = found
            smallest = np.linalg.eigvalsh(self.X(every, P, tau, sigma, rho, M))[:, 0]
            failing = np.flatnonzero(smallest < 0)
            if len(failing) == 0 and np.linalg.eigvalsh(P)[0] > 0 and (tau >= 0).all():
                return P, tau, float(smallest.min())
            worst = failing[np.argsort(smallest[failing])][:NEW_VERTICES]
            if len(worst) == 0 or set(worst) <= set(self.vertices):
                return None  # the solver's answer is not good enough at its own constraints
            self.vertices = sorted({*self.vertices, *worst.tolist()})
        return None

    def _solve_at_vertices(self, sigma: float, rho: float, M, margin: float):
        """The smallest trace of P >= I over the vertices; None when the solver finds none."""
        import cvxpy as cp

        self.solves += 1
        k = np.array(self.vertices)
        B, forms = ((self.M if M is None else M)[k], []) if rho == 0 else self.terms(k, rho)
        basis = np.array([np.eye(1, N * N, i * N + j).reshape(N, N) for i, j in zip(*np.triu_indices(N))])
        basis = np.maximum(basis, np.swapaxes(basis, 1, 2))
        p, tau = cp.Variable(len(basis)), cp.Variable(3, nonneg=True)
        columns = [self._part_of_P(k, b, sigma, B) for b in basis] + forms
        F = np.stack(columns, axis=-1)  # vertices x rows x rows x unknowns
        unknowns = cp.hstack([p, tau]) if rho > 0 else p
        rows = F.shape[1]
        constraints = [cp.reshape(basis.reshape(-1, N * N).T @ p, (N, N), order="C") - np.eye(N) >> 0]
        constraints += [cp.reshape(f.reshape(rows * rows, -1) @ unknowns, (rows, rows), order="C") - margin * np.eye(rows) >> 0 for f in F]
        problem = cp.Problem(cp.Minimize(np.einsum("bii->b", basis) @ p), constraints)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of inaccurate solutions: what comes out is checked in any case
                # The smallest trace is wanted roughly, the constraints well.
                problem.solve(solver=cp.CLARABEL, tol_gap_abs=1e-3, tol_gap_rel=1e-3, tol_feas=1e-8)
        except cp.SolverError:
            return None
        if problem.status not in (cp.OPTIMAL, cp.OPTIMAL_INACCURATE):
            return None
        return np.tensordot(p.value, basis, 1), np.zeros(3) if rho == 0 else np.maximum(tau.value, 0)


def largest(holds: Callable[[float], object | None], low: float, high: float, probes: int, geometric: bool = True, best=None):
    """(value, what holds answered there): the largest for which it answers, by bisection; best if it never does."""
    for _ in range(probes):
        middle = np.sqrt(low * high) if geometric else 0.5 * (low + high)
        answer = holds(middle)
        if answer is None:
            high = middle
        else:
            low, best = middle, (middle, answer)
    return best


# --------------------------------------------------------------------------------------------- the certificate

PROBES = {"decay rate": 8, "region": 7, "longest interval": 9}  # of the region more when it is small


def certify(record: GainRecord, progress: Progress | None = None, starts: int = 100, seed: int = 1) -> Certificate:
    """Decay, region, noise floor, dwell and verdict of a record; starts: simulated errors on the boundary of the region.

    Raises HnavError when cvxpy or its solver Clarabel is not installed, and for records of fewer than two corrections.
    """
    try:
        import clarabel  # noqa: F401
        import cvxpy  # noqa: F401
    except ImportError as error:
        raise HnavError(16, f"the certificate needs the package {error.name}: pip install 'hnav[certify]'") from None
    if len(record.corrections) < 2:
        raise HnavError(12, f"{record.name}: {len(record.corrections)} corrections; a certificate needs two or more")
    begin = time.perf_counter()
    T = np.array([c.interval_s for c in record.corrections])
    found = Certificate(record.name, len(T), float(np.median(T)), record.largest_difference)
    found.t_s = np.array([c.t_s for c in record.corrections])
    found.free_rate_1_s = free_rates(record)
    found.gamma_squared = max(c.gamma for c in record.corrections) ** 2
    found.printed = printed_theorem(record)
    inequality = SampledDataInequality(record, bias_scale(record))
    found.reason = _search(found, inequality, progress or (lambda *_: None), starts, seed)
    found.certified = not found.reason
    found.vertices, found.solves = len(inequality.vertices), inequality.solves
    found.seconds = time.perf_counter() - begin
    return found


def bias_scale(record: GainRecord) -> float:
    """s: how much attitude error goes with a bias error, from the filter's own sigmas at the median."""
    ratios = [np.trace(c.P[1:4, 1:4]) / np.trace(c.P[4:, 4:]) for c in record.corrections]
    return float(np.sqrt(np.median(ratios)))


def largest_below(holds: Callable[[float], object | None], high: float, least: float, probes: int):
    """As largest, between the halves of high: what holds is mostly found in few probes, and the dear ones are those that fail."""
    while high > least:
        answer = holds(high / 2)
        if answer is not None:
            return largest(holds, high / 2, high, probes, best=(high / 2, answer))
        high /= 2
    return None


def _search(found: Certificate, inequality: SampledDataInequality, progress: Progress, starts: int, seed: int) -> str:
    """Fills in the figures one after the other; returns why there is no certificate, empty if there is one."""
    record = inequality.record
    radius = np.array([np.abs(np.linalg.eigvals(c.M[1:, 1:])).max() for c in record.corrections])
    rates = -np.log(radius) / inequality.T
    found.spectral_rate_1_s = float(rates.min())
    if not found.spectral_rate_1_s > 0:
        k = int(np.argmin(rates))
        return f"the error grows at the correction at {found.t_s[k]:g} s: spectral radius of (I - KH) Phi is {radius[k]:.6f}"

    def counted(stage: str, holds):
        done = [0]

        def probe(value: float):
            answer = holds(value)
            done[0] += 1
            progress(stage, min(done[0], PROBES[stage]), PROBES[stage])
            return answer

        return probe

    rate = largest(counted("decay rate", lambda s: inequality.solve(s, 0.0)), 1e-3 * found.spectral_rate_1_s,
                   found.spectral_rate_1_s * (1 + 1e-9), PROBES["decay rate"], geometric=False)  # fmt: skip
    if rate is None:
        return f"no common P for the linear part, although every single correction contracts (slowest {found.spectral_rate_1_s:.3g} 1/s)"
    found.rate_1_s = rate[0]

    sigma = found.region_rate_1_s = SHARE_OF_RATE * found.rate_1_s
    region = largest_below(counted("region", lambda rho: inequality.solve(sigma, rho)), LARGEST_RADIUS, LEAST_RADIUS, 5)
    if region is None:
        return "no region: the quadratic remainders destroy the decrease for attitude errors of any size that was tried"
    rho, (P, tau, found.smallest_eigenvalue) = region
    found.P, found.tau = inequality.D @ P @ inequality.D, tuple(float(t) for t in tau)
    _measure_region(found, inequality, rho)

    longest = largest(counted("longest interval", lambda t: inequality.solve(0.0, 0.0, inequality.with_interval(t))), found.interval_s,
                      LONGEST_HOLD_S, PROBES["longest interval"])  # fmt: skip
    found.longest_interval_s = longest[0] if longest else np.nan
    if starts:
        found.starts = fall_from_boundary(record, found.P, found.level, sigma, starts, seed, lambda done, of: progress("starts", done, of))
        if found.starts.worst_ratio > 1 + 1e-9:
            return f"a simulated start on the boundary exceeds the bound by {found.starts.worst_ratio - 1:.1e}"
    if not found.noise_share < 1:
        return f"noise may leave the region: E V is bounded by {found.noise_share:.3g} times its level only"
    return ""


def _measure_region(found: Certificate, inequality: SampledDataInequality, rho: float) -> None:
    """Level, size and noise of {e'Pe <= level}, chosen so that c <= rho also while the error flows."""
    P_inverse = np.linalg.inv(found.P)
    attitude, bias = (np.sqrt(np.linalg.eigvalsh(P_inverse[part, part])[-1]) for part in (ATTITUDE, BIAS))

    def farthest(size: float) -> float:
        """c before the next correction: |d| = sin(angle / 2), and a bias error adds at most T/2 |e_b|."""
        return 2 * np.sin(0.5 * np.arcsin(size * attitude)) + 0.5 * inequality.T.max() * size * bias

    size = brentq(lambda x: farthest(x) - rho, 0, min(1, rho) / attitude)
    found.level = float(size**2)
    found.region_deg = float(np.degrees(2 * np.arcsin(size * attitude)))
    found.region_bias_deg_s = float(np.degrees(size * bias))
    found.sure_deg = float(np.degrees(2 * np.arcsin(min(1, size / np.sqrt(np.linalg.eigvalsh(found.P[ATTITUDE, ATTITUDE])[-1])))))
    floor = 0.0
    for c in inequality.record.corrections:
        G, F = (c.J @ c.K)[1:], (c.J @ c.IKH)[1:]
        injected = np.trace(found.P @ (G @ c.R @ G.T + F @ c.Q @ F.T))
        floor = max(floor, injected / -np.expm1(-2 * found.region_rate_1_s * c.interval_s))
    found.noise_share = float(floor / found.level)
    found.noise_floor_deg = float(np.degrees(2 * np.sqrt(floor) * attitude))
