"""What a run of the paper's filter did, correction by correction: Phi_k, H_k and K_k in navigation axes.

The NumPy reference is fed the same samples as the C library; both must give the same attitude, bias and covariance to
TOLERANCE at every row, so that whatever is proved of the record is proved of the library's run.

Error of x = (q, b) in coordinates that turn little while the body moves, an orthogonal change of basis:
    e = (e_q (x) q*, R_nb e_b)
With e_q = q(t) (x) s the flow of the error has constant coefficients while the rate u is held,
    s' = 1/2 (s (x) (0, u) - (0, u) (x) s) - 1/2 (0, e_b),   e_b' = 0,
so Phi is a turn and its integral (Rodrigues), and the noise Q = integral of Phi(t) Qc Phi(t)' by Gauss and Legendre, exact
to rounding for turns of less than four revolutions in an interval.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from hnav.certify.hrekf import C_bn, HrekfEquations, Numbers, Xi, left_multiplication, right_multiplication
from hnav.errors import HnavRuntimeError
from hnav.filters.attitude import Filter
from hnav.filters.options import Options
from hnav.io.recordings import Recording
from hnav.rotations import quaternion_exp, quaternion_product

TOLERANCE = 1e-9  # reference against C: quaternion, bias in rad/s, covariance relative to its diagonal
CHANNELS = 6  # rows of H: force, field; those of a missing sensor are zero
VECTOR_PART = np.eye(4)[:, 1:]  # (0, v) = VECTOR_PART v
FAR_LIMITS = 10.0  # time_jump_limit_s: the filter leaves out the first row that lies so far ahead
NODES, WEIGHTS = (0.5 * a for a in np.polynomial.legendre.leggauss(24))  # of an interval: from -1/2 to 1/2


@dataclass(frozen=True)
class Correction:
    """Error maps from just after one correction to just after the next; errors in navigation axes."""

    t_s: float
    interval_s: float
    Phi: np.ndarray  # 7 x 7, flow of the error
    H: np.ndarray  # 6 x 7
    K: np.ndarray  # 7 x 6, seen from the corrected attitude
    R: np.ndarray  # 6 x 6, as used: with gates
    Q: np.ndarray  # 7 x 7, noise of the interval
    P: np.ndarray  # 7 x 7, covariance after it
    turn: np.ndarray  # 7 x 7, from navigation axes of the predicted attitude to those of the corrected one

    norm: float  # of q + K nu, before the return to the unit sphere
    nu: np.ndarray  # 6: innovation
    q_minus: np.ndarray  # 4: the predicted attitude
    q: np.ndarray  # 4: the corrected one
    b: np.ndarray  # 3, rad/s: the corrected bias
    gamma: float  # of the robust law; infinite when off
    turns: tuple[tuple[np.ndarray, float], ...]  # of the flow: rate in navigation axes (3, rad/s) and for how long (s)

    @cached_property
    def IKH(self) -> np.ndarray:
        """7 x 7: I - K H."""
        return np.asarray(self.turn - self.K @ self.H)

    @cached_property
    def J(self) -> np.ndarray:
        """7 x 7: the return of q to the unit sphere; in navigation axes q itself is (1, 0, 0, 0)."""
        return np.diag([0.0, *np.full(3, 1 / self.norm), 1, 1, 1])

    @cached_property
    def M(self) -> np.ndarray:
        """7 x 7: the linear error map from just after one correction to just after the next."""
        return np.asarray(self.J @ self.IKH @ self.Phi)


@dataclass(frozen=True)
class GainRecord:
    name: str
    corrections: list[Correction]
    largest_difference: float  # reference against C, over all rows
    restarts: tuple[float, ...] = ()
    """Times (s) at which the filter initialised its attitude again: no error is carried across."""

    def from_time(self, t_s: float) -> GainRecord:
        """Without what was before t_s."""
        later = [c for c in self.corrections if c.t_s >= t_s]
        return replace(self, corrections=later, restarts=tuple(t for t in self.restarts if t >= t_s))

    def with_gain(self, factor: float) -> GainRecord:
        """The same run with every K multiplied; the covariances stay, for they are no part of the certificate."""
        return replace(self, corrections=[replace(c, K=factor * c.K) for c in self.corrections])


def held_turns(rate: np.ndarray, interval_s: float | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """exp([w]x T) and its integral over the interval, m x 3 x 3 each, for rates w (m x 3, rad/s) and T (s, or m of them): Rodrigues."""
    T = np.broadcast_to(interval_s, len(rate))[:, None, None]
    length = np.linalg.norm(rate, axis=1)[:, None, None]
    x, y, z = (rate / np.maximum(length[:, 0], np.finfo(float).tiny)).T
    zero = np.zeros_like(x)
    axis = np.moveaxis(np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]), -1, 0)
    twice = axis @ axis
    angle = length * T
    turn = np.eye(3) + np.sin(angle) * axis + 2 * np.sin(0.5 * angle) ** 2 * twice
    # (1 - cos a) / a and 1 - sin a / a, without loss of digits at small angles.
    across = 0.5 * angle * np.sinc(0.5 * angle / np.pi) ** 2
    along = np.where(angle < 1e-2, angle**2 / 6 * (1 - angle**2 / 20), 1 - np.sinc(angle / np.pi))
    return turn, T * (np.eye(3) + across * axis + along * twice)


def navigation_axes(q: np.ndarray) -> np.ndarray:
    """7 x 7 orthogonal: (e_q, e_b) to (e_q (x) q*, R_nb e_b)."""
    T = np.zeros((7, 7))
    T[:4, :4] = right_multiplication(q * [1, -1, -1, -1])
    T[4:, 4:] = C_bn(q).T
    return T


def body_axes(q: np.ndarray) -> np.ndarray:
    """7 x 7 orthogonal: (s, e_b) to (q (x) s, e_b)."""
    T = np.eye(7)
    T[:4, :4] = left_multiplication(q)
    return T


def body_maps(u: np.ndarray, t_s: np.ndarray) -> np.ndarray:
    """n x 7 x 7: what the error (s, e_b), see above, becomes in each time t_s under the rate u."""
    maps = np.broadcast_to(np.eye(7), (len(t_s), 7, 7)).copy()
    maps[:, 1:4, 1:4], path = held_turns(np.broadcast_to(-u, (len(t_s), 3)), t_s)
    maps[:, 1:4, 4:] = -0.5 * path
    return maps


class WatchedReference(HrekfEquations):
    """The reference, its flow in closed form, that keeps what passed since the last correction."""

    def __init__(self, options: Options):
        super().__init__(options)
        self.forget_flow()

    def forget_flow(self) -> None:
        self.flown_from, self.Phi, self.Q = self.q, np.eye(7), np.zeros((7, 7))
        self.turns: list[tuple[np.ndarray, float]] = []

    def flow(self, interval_s: float) -> None:
        o = self.options
        u = np.zeros(3) if self.rate is None else self.rate - self.b
        noise = np.zeros((7, 7))
        noise[:4, :4] = 0.25 * o.gyro_noise_rad_per_sqrt_s**2 * VECTOR_PART @ VECTOR_PART.T
        noise[:4, :4] += o.quaternion_noise_per_sqrt_s**2 * np.eye(4)
        noise[4:, 4:] = self.Q_b
        self.turns.append((C_bn(self.q).T @ u, interval_s))
        q_next = quaternion_product(self.q, quaternion_exp(0.5 * interval_s * u[None])[0])
        before, after = body_axes(self.q), body_axes(q_next)
        maps = body_maps(u, np.r_[interval_s, interval_s * (0.5 + NODES)])
        Phi = after @ maps[0] @ before.T
        Q = after @ np.einsum("n,nij,jk,nlk->il", interval_s * WEIGHTS, maps[1:], noise, maps[1:]) @ after.T
        self.q, self.P = q_next, Phi @ self.P @ Phi.T + Q
        self.Phi, self.Q = Phi @ self.Phi, Phi @ self.Q @ Phi.T + Q
        self.q_minus = q_next

    def widen(self, variance: float) -> None:
        """A gap is noise of its interval."""
        super().widen(variance)
        self.Q[:4, :4] += variance * Xi(self.q) @ Xi(self.q).T

    def collect(self, t_s: float, force: Numbers | None, field: Numbers | None) -> None:
        """The start is the library's: see start_from."""

    def start_from(self, in_c: Filter, t_s: float) -> None:
        """Takes over attitude, bias and covariance with which the library has just started."""
        self.q, self.b, self.P = self.estimate_of(in_c)
        self.last_correction, self.P_after, self.started = t_s, self.P, True
        self.forget_flow()

    def estimate_of(self, in_c: Filter) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """q (4), bias (3, rad/s) and the covariance of both (7 x 7) of the library, in the reference's axes."""
        q = in_c.get_x()[:4]
        to_internal = np.eye(6)
        to_internal[:3, :3] = C_bn(self.user_from_internal)
        P = to_internal @ in_c.covariance() @ to_internal.T
        # The length of a quaternion that a correction has just left has no error; before one it has its noise.
        G = np.zeros((7, 6))
        G[:4, :3] = 0.5 * right_multiplication(q)[:, 1:]
        G[4:, 3:] = np.eye(3)
        return q, in_c.gyro_bias()[0], G @ P @ G.T

    def correct(self, t_s: float, force: Numbers | None, field: Numbers | None) -> None:
        # A field that comes before any reference becomes the reference; it corrects nothing.
        super().correct(t_s, force, None if self.reference is None else field)

    def know_field(self, in_c: Filter) -> None:
        """The library's magnetic reference, as soon as it has one."""
        known = in_c.field()
        self.reference = (known.strength_tesla, known.dip_rad) if np.isfinite(known.strength_tesla) else None

    def correction(self, t_s: float, interval_s: float) -> Correction:
        """The record of the last correction, in navigation axes."""
        assert self.gain is not None, "there has been a correction"
        sensors, K, H, R, nu, norm = self.gain
        rows = np.concatenate([np.arange(3) + 3 * ("accel", "mag").index(sensor) for sensor in sensors])
        K6, H6, R6, nu6 = np.zeros((7, CHANNELS)), np.zeros((CHANNELS, 7)), np.zeros((CHANNELS, CHANNELS)), np.zeros(CHANNELS)
        K6[:, rows], H6[rows], R6[np.ix_(rows, rows)], nu6[rows] = K, H, R, nu
        first, minus, plus = (navigation_axes(q) for q in (self.flown_from, self.q_minus, self.q))
        # The flow ends and the correction begins at the predicted attitude; the error after it is seen from the corrected one.
        return Correction(t_s, interval_s, minus @ self.Phi @ first.T, H6 @ minus.T, plus @ K6, R6,
                          minus @ self.Q @ minus.T, plus @ self.P @ plus.T, plus @ minus.T, norm, nu6, self.q_minus,
                          self.q, self.b, float(self.gamma), tuple(self.turns))  # fmt: skip


def difference(in_c: Filter, reference: WatchedReference) -> float:
    """Largest difference of quaternion, bias and, relative to its diagonal, covariance across the quaternion."""
    q, b, P = reference.estimate_of(in_c)
    across = np.eye(7)
    across[:4, :4] -= np.outer(q, q)
    scale = np.sqrt(np.maximum(np.diag(P), 1e-300))
    relative = np.abs(P - across @ reference.P @ across) / np.outer(scale, scale)
    return float(max(np.abs(q - reference.q).max(), np.abs(b - reference.b).max(), relative.max()))


class _SideBySide:
    """The library and the reference over the same rows, and what the record keeps of them."""

    def __init__(self, name: str, options: Options):
        self.name, self.options = name, options
        self.in_c, self.reference = Filter(options), WatchedReference(options)
        self.corrections: list[Correction] = []
        self.restarts: list[float] = []
        self.largest, self._last_row_s = 0.0, np.inf

    def row(self, t_s: float, rate: np.ndarray, force: np.ndarray, magnetic: np.ndarray) -> None:
        """NaN: no sample."""
        for push, value in ((self.in_c.push_gyro, rate), (self.in_c.push_accel, force), (self.in_c.push_mag, magnetic)):
            if np.isfinite(value).all():
                push(t_s, value)
        self.in_c.advance(t_s)
        far_ahead, self._last_row_s = 0 < FAR_LIMITS * self.options.time_jump_limit_s < t_s - self._last_row_s, t_s
        if not far_ahead:
            self._follow(t_s, rate, force, magnetic)
            if self.reference.reference is None:
                self.reference.know_field(self.in_c)

    def _follow(self, t_s: float, rate: np.ndarray, force: np.ndarray, magnetic: np.ndarray) -> None:
        """The reference, after the library: they start together and then agree."""
        reference = self.reference
        last_s, was_started, reference.gain = reference.last_correction, reference.started, None
        reference.event(t_s, rate, force, magnetic)
        if was_started and not reference.started:
            self.restarts.append(t_s)
        if reference.started:
            self._compare(t_s)
            if reference.gain is not None:
                self.corrections.append(reference.correction(t_s, t_s - last_s))
                reference.forget_flow()
        elif self.in_c.diagnostics().started:
            reference.start_from(self.in_c, t_s)

    def _compare(self, t_s: float) -> None:
        self.largest = max(self.largest, difference(self.in_c, self.reference))
        if self.largest < TOLERANCE:
            return
        cure = "certify with solver=closed_form, the exact flow"
        if self.options.solver == "closed_form":
            cure = "the library rejected a sample that the reference used (outlier, stuck or saturated sensor): see hnav check"
        raise HnavRuntimeError(
            "solver",
            f"{self.name}: at {t_s:g} s library and reference differ by {self.largest:.1e}, more than {TOLERANCE:g}; {cure}",
        )


def record_gains(recording: Recording, options: Options, progress: Callable[[int, int], None] | None = None) -> GainRecord:
    """Runs both over the recording. Raises HnavError when they differ, or when there was no correction."""
    recording = recording.in_order_of_measurement()
    both = _SideBySide(recording.name, options)
    n = len(recording.t_s)
    field = np.full((n, 3), np.nan) if recording.field_b_tesla is None else recording.field_b_tesla
    for i, t_s in enumerate(recording.t_s.tolist()):
        both.row(t_s, recording.rate_b_rad_s[i], recording.force_b_m_s2[i], field[i])
        if progress and (i % 50 == 49 or i == n - 1):
            progress(i + 1, n)
    if not both.corrections:
        raise HnavRuntimeError("no data", f"{recording.name}: the filter made no correction")
    return GainRecord(recording.name, both.corrections, both.largest, tuple(both.restarts))
