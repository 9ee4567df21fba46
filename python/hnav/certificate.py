"""Stability certificate of a recorded run: Theorem 1 of the paper in a form that can hold, and can fail.

As printed the theorem asks the flow to contract; quaternion kinematics never do, and its dwell condition points the
wrong way (printed_theorem). Here flow and jump are taken together, from just after one correction to just after the
next. With e = x_true - x, in navigation axes, and remainders that are exact for these equations,

    e(k) = M e(k-1) + J K r + J (I - K H) E_q' s + E_q' n,     M = J (I - K H) Phi
    |r| <= sqrt(2) |e_q-|^2                    h is quadratic: h(q + e) = h(q) + H e + h(e)
    |s| <= 1/2 T |e_q| |e_b|                   the flow is bilinear: e_q' = ... + 1/2 e_q (x) (0, e_b)
    |n| <= (2/sqrt(3)) (-ln(1-d) - d)          the return to the unit sphere, of |d| before it; Taylor, integral form

While |e_q| <= rho each bound is a multiple of a linear form of z = (e, r, s, n), so the S-procedure gives: if P >= I and
tau >= 0 exist with, for every correction k,

    X_k = blkdiag(e^{-2 sigma T} P, 0) + sum_i tau_i (E_i'E_i - c_i^2 C_i'C_i) - B'PB >= 0,     B = [M, JK, J(I-KH)E_q', E_q']

then V = e'Pe falls by e^{-2 sigma T} at every correction as long as e starts in {V <= level} (Yakubovich 1971; Boyd et al.,
Linear Matrix Inequalities in System and Control Theory, 1994, section 2.6.3). The solver is never trusted: X_k is
computed anew for every correction and its smallest eigenvalue looked at; corrections that fail join the constraints
(cutting planes). Only what passed on all of them is reported.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import expm

from hnav.boundary_starts import BoundaryStarts, fall_from_boundary
from hnav.gain_record import CHANNELS, GainRecord
from hnav.library import HnavError

N = 7
FIRST_VERTICES, NEW_VERTICES, PASSES = 25, 12, 8
SHARE_OF_RATE = 0.25  # of the linear rate that is kept when the region is sought: the rest pays for the remainders
LONGEST_HOLD_S = 100.0
LARGEST_RADIUS = 1.0  # of |e_q|; beyond it the return to the sphere has no bound
E_Q, E_B = np.eye(N)[:4], np.eye(N)[4:]
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
    gamma_squared: float = np.nan  # what the attenuation must stay below; infinite without gamma

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
    """7 x 7, of the error in navigation axes: e_q' = -1/2 (0, e_b), e_b' = rate_n x e_b."""
    A = np.zeros((N, N))
    A[1:4, 4:] = -0.5 * np.eye(3)
    x, y, z = rate_n
    A[4:, 4:] = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
    return A


def sphere_bound(d: float) -> float:
    """c with |n| <= c |d|^2 for |d| <= d < 1. The second derivative of q/|q| on a pair d, d is at most 2/sqrt(3) |d|^2/|q|^2."""
    return 2 / np.sqrt(3) * (0.5 if d < 1e-4 else (-np.log1p(-d) - d) / d**2)


# --------------------------------------------------------------------------------------------- the inequality


class SampledDataInequality:
    """X_k for all corrections of a record, in scaled errors (e_q, scale e_b); affine in P and tau.

    rho = 0: the linear part alone, e^{-2 sigma T} P - M'PM.
    """

    def __init__(self, record: GainRecord, scale: float):
        c = record.corrections
        self.record, self.D = record, np.diag([1.0] * 4 + [scale] * 3)
        inverse = np.diag(1 / np.diag(self.D))
        self.T = np.array([x.interval_s for x in c])
        self.M = np.stack([self.D @ x.M @ inverse for x in c])
        self.JK = np.stack([self.D @ x.J @ x.K for x in c])
        self.JIKH = np.stack([self.D @ x.J @ x.IKH @ E_Q.T for x in c])
        self.predicted = np.stack([E_Q @ x.Phi @ inverse for x in c])
        self.raw = np.stack([E_Q @ np.hstack([x.IKH @ x.Phi @ inverse, x.K, x.IKH @ E_Q.T]) for x in c])
        self.norm = np.array([x.norm for x in c])
        self.gain = np.array([np.linalg.norm(x.K[:4], 2) for x in c])
        self.bias = E_B @ inverse
        self.solves = 0
        step = max(1, len(c) // FIRST_VERTICES)
        self.vertices = list(range(0, len(c), step))

    def replace_flow(self, interval_s: float) -> np.ndarray:
        """M of all corrections if each came interval_s after the one before, its gain unchanged."""
        inverse = np.diag(1 / np.diag(self.D))
        Phi = expm(np.stack([flow_matrix(c.turns[-1][0]) for c in self.record.corrections]) * interval_s)
        return np.stack([self.D @ c.J @ c.IKH for c in self.record.corrections]) @ Phi @ inverse

    def terms(self, k: np.ndarray, rho: float) -> tuple[np.ndarray, list[np.ndarray]]:
        """B (m x 7 x 21) and, for each remainder, E'E - c^2 C'C (m x 21 x 21), of the corrections k."""
        m, rows = len(k), N + CHANNELS + 8
        B = np.concatenate([self.M[k], self.JK[k], self.JIKH[k], np.broadcast_to(E_Q.T, (m, N, 4))], axis=2)
        # |e_q + K (...)| before the return to the sphere: |e_q| (1 + |K| (|H| + sqrt(2) rho)), |H_q| <= 2 sqrt(2).
        d = rho * (1 + self.gain[k] * np.sqrt(2) * (2 + rho)) / self.norm[k]
        sphere = np.array([sphere_bound(x) if x < 1 else np.inf for x in d]) * d / self.norm[k]
        forms = []
        for first, size, c, C in (
            (N, CHANNELS, np.full(m, np.sqrt(2) * rho), self._padded(self.predicted[k], rows, also=N + CHANNELS)),
            (N + CHANNELS, 4, 0.5 * self.T[k] * rho, self._padded(np.broadcast_to(self.bias, (m, 3, N)), rows)),
            (N + CHANNELS + 4, 4, sphere, self._padded(self.raw[k], rows)),
        ):
            E = np.eye(rows)[first : first + size]
            forms.append(E.T @ E - (c**2)[:, None, None] * (np.swapaxes(C, 1, 2) @ C))
        return B, forms

    @staticmethod
    def _padded(C: np.ndarray, rows: int, also: int | None = None) -> np.ndarray:
        """C over the whole of z; also: where a 4 x 4 identity joins it, for e_q- = E_q Phi e + s."""
        whole = np.zeros((len(C), C.shape[1], rows))
        whole[:, :, : C.shape[2]] = C
        if also is not None:
            whole[:, :, also : also + 4] = np.eye(4)
        return whole

    def X(self, k: np.ndarray, P: np.ndarray, tau: np.ndarray, sigma: float, rho: float, M: np.ndarray | None = None) -> np.ndarray:
        """m x 7 x 7 when rho is 0, else m x 21 x 21."""
        decay = np.exp(-2 * sigma * self.T[k])[:, None, None]
        if rho == 0:
            M_k = (self.M if M is None else M)[k]
            return decay * P - np.swapaxes(M_k, 1, 2) @ P @ M_k
        B, forms = self.terms(k, rho)
        X = -np.swapaxes(B, 1, 2) @ P @ B + sum(t * F for t, F in zip(tau, forms))
        X[:, :N, :N] += decay * P
        return X

    def solve(self, sigma: float, rho: float, M: np.ndarray | None = None):
        """(P, tau, smallest eigenvalue) that holds for every correction, or None. Adds cutting planes until it does."""
        margin = 1e-3 * (1 - np.exp(-2 * sigma * self.T.min()))
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
        upper = np.triu_indices(N)
        basis = np.zeros((len(upper[0]), N, N))
        basis[np.arange(len(upper[0])), upper[0], upper[1]] = basis[np.arange(len(upper[0])), upper[1], upper[0]] = 1
        p, tau = cp.Variable(len(basis)), cp.Variable(3, nonneg=True)
        k = np.array(self.vertices)
        none = np.zeros(3)
        columns = [self.X(k, b, none, sigma, rho, M) for b in basis]
        if rho > 0:
            columns += self.terms(k, rho)[1]
        F = np.stack(columns, axis=-1)  # vertices x rows x rows x unknowns
        unknowns = cp.hstack([p, tau]) if rho > 0 else p
        rows = F.shape[1]
        constraints = [cp.reshape(basis.reshape(-1, N * N).T @ p, (N, N), order="C") - np.eye(N) >> 0]
        constraints += [cp.reshape(f.reshape(rows * rows, -1) @ unknowns, (rows, rows), order="C") - margin * np.eye(rows) >> 0 for f in F]
        problem = cp.Problem(cp.Minimize(np.einsum("bii->b", basis) @ p), constraints)
        try:
            problem.solve(solver=cp.CLARABEL)
        except cp.SolverError:
            return None
        if problem.status not in (cp.OPTIMAL, cp.OPTIMAL_INACCURATE):
            return None
        return np.tensordot(p.value, basis, 1), np.zeros(3) if rho == 0 else np.maximum(tau.value, 0)


def largest(holds: Callable[[float], object | None], low: float, high: float, probes: int, geometric: bool = True):
    """(value, what holds answered there): the largest for which it answers, by bisection; None if it never does."""
    best = None
    for _ in range(probes):
        middle = np.sqrt(low * high) if geometric else 0.5 * (low + high)
        answer = holds(middle)
        if answer is None:
            high = middle
        else:
            low, best = middle, (middle, answer)
    return best


# --------------------------------------------------------------------------------------------- the certificate

PROBES = {"decay rate": 10, "region": 9, "longest interval": 10}


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


def _search(found: Certificate, inequality: SampledDataInequality, progress: Progress, starts: int, seed: int) -> str:
    """Fills in the figures one after the other; returns why there is no certificate, empty if there is one."""
    record = inequality.record
    radius = np.array([np.abs(np.linalg.eigvals(c.M)).max() for c in record.corrections])
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
            progress(stage, done[0], PROBES[stage])
            return answer

        return probe

    rate = largest(counted("decay rate", lambda s: inequality.solve(s, 0.0)), 1e-3 * found.spectral_rate_1_s,
                   found.spectral_rate_1_s * (1 + 1e-9), PROBES["decay rate"], geometric=False)  # fmt: skip
    if rate is None:
        return f"no common P for the linear part, although every single correction contracts (slowest {found.spectral_rate_1_s:.3g} 1/s)"
    found.rate_1_s = rate[0]

    sigma = found.region_rate_1_s = SHARE_OF_RATE * found.rate_1_s
    region = largest(counted("region", lambda rho: inequality.solve(sigma, rho)), 1e-4, LARGEST_RADIUS, PROBES["region"])
    if region is None:
        return "no region: the quadratic remainders destroy the decrease for attitude errors of any size that was tried"
    rho, (P, tau, found.smallest_eigenvalue) = region
    found.P, found.tau = inequality.D @ P @ inequality.D, tuple(float(t) for t in tau)
    _measure_region(found, inequality, rho)

    longest = largest(counted("longest interval", lambda t: inequality.solve(1e-6, 0.0, inequality.replace_flow(t))), found.interval_s,
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
    """Level, size and noise of {e'Pe <= level}, chosen so that |e_q| <= rho also while the error flows."""
    P_inverse = np.linalg.inv(found.P)
    attitude, bias = (np.sqrt(np.linalg.eigvalsh(block)[-1]) for block in (P_inverse[:4, :4], P_inverse[4:, 4:]))
    # Until the next correction a bias error adds at most T/2 |q| |e_b|, |q| <= 1 + rho.
    found.level = float((rho / (attitude + 0.5 * inequality.T.max() * (1 + rho) * bias)) ** 2)
    size = np.sqrt(found.level)
    # Two unit quaternions turned by theta against each other are 2 sin(theta/4) apart.
    angle_deg = lambda chord: float(np.degrees(4 * np.arcsin(min(1.0, chord / 2))))  # noqa: E731
    found.region_deg = angle_deg(size * attitude)
    found.region_bias_deg_s = float(np.degrees(size * bias))
    found.sure_deg = angle_deg(size / np.sqrt(np.linalg.eigvalsh(found.P[:4, :4])[-1]))
    floor = 0.0
    for c in inequality.record.corrections:
        G, F = c.J @ c.K, c.J @ c.IKH
        injected = np.trace(found.P @ (G @ c.R @ G.T + F @ c.Q @ F.T))
        floor = max(floor, injected / -np.expm1(-2 * found.region_rate_1_s * c.interval_s))
    found.noise_share = float(floor / found.level)
    found.noise_floor_deg = float(np.degrees(2 * np.sqrt(floor) * attitude))
