"""The jump of the paper's filter, in NumPy: the same laws as c_src/attitude/hrekf, with the gain of each correction in sight.

    q' = 1/2 q (x) (0, u) = Xi(q) u,   b' = 0,   u = w - b
    jump: Sigma = (P^-1 - gamma^-2 L'L)^-1,  S = H Sigma H' + R,  K = Sigma H' S^-1,  x += K nu,
          P+ = (I - K H) Sigma (I - K H)' + K R K',  q <- q/|q| with its covariance

Symbols are those of "Hybrid Robust Extended Kalman Filter for SINS initial alignment", TJEE 54(4), 2024,
doi 10.22034/tjee.2023.57843.4683, whose equations (9) to (17) are corrected here.

Navigation frame: north-east-down of magnetic north inside; the options' frame, declination and mounting at the border.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import brentq

from hnav.certify.durations import has_lasted, is_gap, usual_interval
from hnav.filters.options import Options
from hnav.rotations import quaternion_product

Numbers = npt.NDArray[Any]  # real, and complex where a derivative is taken

LARGEST_SHARE = 0.95  # of gamma^2 that lmax(L P L') may take
GRAVITY_N = np.array([0.0, 0.0, -1.0])  # direction of specific force at rest


# --------------------------------------------------------------------------------------------- kinematics


def left_multiplication(p: Numbers) -> Numbers:
    """4 x 4: p (x) q = left_multiplication(p) q."""
    w, x, y, z = p
    return np.array([[w, -x, -y, -z], [x, w, -z, y], [y, z, w, -x], [z, -y, x, w]])


def right_multiplication(p: Numbers) -> Numbers:
    """4 x 4: q (x) p = right_multiplication(p) q."""
    w, x, y, z = p
    return np.array([[w, -x, -y, -z], [x, w, z, -y], [y, -z, w, x], [z, y, -x, w]])


def Xi(q: Numbers) -> Numbers:
    """4 x 3: Xi(q) u = 1/2 q (x) (0, u)."""
    return 0.5 * left_multiplication(q)[:, 1:]


def Omega(u: Numbers) -> Numbers:
    """4 x 4: Omega(u) q = 1/2 q (x) (0, u)."""
    return 0.5 * right_multiplication(np.r_[0, u])


def C_bn(q: Numbers) -> Numbers:
    """3 x 3, navigation to body, quadratic in q."""
    w, x, y, z = q
    return np.array(
        [
            [w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y)],
            [2 * (x * y - w * z), w * w - x * x + y * y - z * z, 2 * (y * z + w * x)],
            [2 * (x * z + w * y), 2 * (y * z - w * x), w * w - x * x - y * y + z * z],
        ]
    )


def measurement(q: Numbers, reference_n: Numbers) -> tuple[Numbers, Numbers]:
    """A navigation vector in body axes, and its 3 x 4 Jacobian; both exact for any q."""
    conjugate, m = np.array([1, -1, -1, -1]), np.r_[0, reference_n]
    turned = quaternion_product(q * conjugate, m)
    # h is quadratic: h(q + e) - h(q) - h(e) = q* (x) m (x) e + e* (x) m (x) q.
    H = left_multiplication(turned) + right_multiplication(quaternion_product(m, q)) * conjugate
    return quaternion_product(turned, q)[1:], H[1:]


def accel_gate(o: Options) -> float:
    """NIS beyond which the noise of force is inflated: as given, or by the noise."""
    if o.accel_gate_nis >= 0:
        return float(o.accel_gate_nis)
    return float(np.clip(0.13 * (0.115 / o.accel_noise_per_sqrt_hz) ** 2, 0.13, 13.9))


# --------------------------------------------------------------------------------------------- the robust law


def inflate(P: Numbers, L: Numbers, interval_s: float, options: Options) -> tuple[Numbers, float]:
    """(Sigma, gamma) of the paper's Algorithm 2; L: the weight, k x n, or its diagonal, 7 of the paper's filter."""
    if options.gamma_mode == "off" or not interval_s > 0:
        return P, np.inf
    if L.ndim == 1:
        L = np.diag(L)
    LP = L @ P
    LPL = LP @ L.T
    eigenvalues = np.linalg.eigvalsh(LPL)
    limit = LARGEST_SHARE / eigenvalues[-1]
    if options.gamma_mode == "fixed":
        theta = options.gamma**-2
    elif options.gamma_mode == "relative":
        theta = (1 - np.exp(-options.gamma_relative_rate_1_s * interval_s)) / eigenvalues[-1]
    else:
        c = (options.gamma_kl_rate_1_s * interval_s) ** 2

        def excess(th: float) -> float:
            z = 1 - th * eigenvalues
            return float(np.sum(0.5 * (1 / z - 1 + np.log(z))) - c)

        theta = brentq(excess, 0, limit, xtol=1e-18, rtol=1e-14) if excess(limit) > 0 else limit
    theta = min(theta, limit)
    return P + LP.T @ np.linalg.solve(np.eye(len(L)) / theta - LPL, LP), theta**-0.5


# --------------------------------------------------------------------------------------------- the filter


@dataclass
class Direction:
    """A vector with a known direction in the navigation frame, measured in body axes."""

    sensor: str
    reference_n: Numbers
    measured_b: Numbers
    variance: float


class Gain(NamedTuple):
    """One correction by these sensors; three rows of H, R and nu for each."""

    sensors: list[str]
    K: Numbers
    H: Numbers
    R: Numbers
    nu: Numbers
    norm: float
    """|q + K nu|, before the return to the unit sphere."""


SETTLING_S, WINDOW_S = 20.0, 10.0  # of the corrected adaptation

LONGEST_GAP_S = 1.0  # after a longer one the attitude is initialised again
CHANGE_MEMORY_S, GAP_TURN_FACTOR = 2.0, 2.5  # of the mean square change of the rate; the share of it that a gap may hide
MEAN_FORCE_S, FAR_COSINE, GRAVITY_M_S2 = 1.0, 0.76, 9.80665  # a mean force 40 deg off the vertical: the attitude is lost


class HrekfEquations:
    """HEKF and HREKF by options; push one instant after the other with event(). Start and flow are those of a subclass."""

    def __init__(self, options: Options):
        self.options = options
        q_body_sensor = np.array(options.q_body_sensor) / np.linalg.norm(options.q_body_sensor)
        self.mounting = C_bn(q_body_sensor).T
        half = 0.5 * options.declination_rad
        to_true_north = np.array([np.cos(half), 0, 0, np.sin(half)])
        enu = np.array([0, np.sqrt(0.5), np.sqrt(0.5), 0])
        self.user_from_internal = quaternion_product(enu, to_true_north) if options.navigation_frame == "enu" else to_true_north
        self.q: Numbers = np.array([1.0, 0, 0, 0])
        self.b: Numbers = np.array(options.start_gyro_bias_rad_s)
        self.P: Numbers = np.diag(np.r_[np.zeros(4), np.full(3, options.start_sigma_bias_rad_s**2)])
        self.Q_b: Numbers = options.gyro_bias_walk_rad_s_per_sqrt_s**2 * np.eye(3)
        self.rate: Numbers | None = None
        self.read_rate: Numbers = np.zeros(3)
        self.spacing_s = self.change_power = 0.0  # usual time between two rates; mean square of their change per second
        self.mean_force_n: Numbers = np.zeros(3)
        self.t = 0.0
        self.forget_attitude()
        self.P_after = self.P
        self.gamma = np.inf
        self.settled_s, self.window_s, self.bias_sum, self.change = np.nan, 0.0, np.zeros(3), 0.0  # of the adaptation
        self.direction, self.swings = 0.0, 0
        self.nis: dict[str, float] = {}
        self.gain: Gain | None = None  # of the last correction

    def forget_attitude(self) -> None:
        """Initialises attitude and magnetic reference from the next samples; the bias and its covariance are kept."""
        o = self.options
        self.started = False
        self.last: dict[str, float] = {}
        self.last_correction = 0.0
        self.information = np.zeros(2)  # tilt, heading: gained since the start
        given = o.reference_mode == "given"
        self.reference: tuple[float, float] | None = (o.reference_strength_tesla, o.reference_dip_rad) if given else None

    # ----------------------------------------------------------------------------------------- outputs

    def rotation_covariance(self) -> Numbers:
        """3 x 3, about the internal navigation axes: theta = 2 vec(dq (x) conj(q))."""
        conjugate = self.q * [1, -1, -1, -1]
        T = np.stack([2 * quaternion_product(e, conjugate)[1:] for e in np.eye(4)], axis=1)
        return np.asarray(T @ self.P[:4, :4] @ T.T)

    # ----------------------------------------------------------------------------------------- flow

    def flow(self, interval_s: float) -> None:
        """The estimate flows over an interval in which the rate is held."""
        raise NotImplementedError

    # ----------------------------------------------------------------------------------------- events

    def event(self, t_s: float, rate: Numbers | None = None, force: Numbers | None = None, field: Numbers | None = None) -> None:
        """All samples of one instant, sensor axes, SI units; None: no sample."""
        rate, force, field = (None if v is None or np.isnan(v).all() else self.mounting @ v for v in (rate, force, field))
        if rate is not None and self.options.gyro_hold != "forward":
            self.hold(t_s, rate)
        if self.started:
            self.flow(t_s - self.t)
            self.pass_gap(t_s, rate, force)
        if self.started:
            self.correct(t_s, force, field)
        else:
            self.collect(t_s, force, field)
        self.t = t_s
        if rate is not None:
            self.spacing_s = usual_interval(t_s - self.last.get("gyro", np.nan), self.spacing_s)
            self.hold(t_s, rate)
        for sensor, value in (("gyro", rate), ("accel", force), ("mag", field)):
            if value is not None:
                self.last[sensor] = t_s

    def hold(self, t_s: float, read: Numbers) -> None:
        """Holds the rate from here on, or over the interval that ends here; updates the mean square change of the rate, but not over a gap."""
        T = t_s - self.last.get("gyro", np.nan)
        between = self.options.gyro_hold == "instant" and self.rate is not None and T > 0
        rate, self.read_rate = 0.5 * (self.read_rate + read) if between else read, read
        if self.rate is not None and T > 0 and not is_gap(T, self.spacing_s):
            square = float((rate - self.rate) @ (rate - self.rate)) / (3 * T * T)
            self.change_power += T / (T + CHANGE_MEMORY_S) * (square - self.change_power)
        self.rate = rate

    def pass_gap(self, t_s: float, rate: Numbers | None, force: Numbers | None) -> None:
        """The possible turn during the gap that ends here: its variance, or after a long gap a new initialisation of the attitude."""
        gap_s = t_s - self.last.get("gyro", np.nan)
        gap = is_gap(gap_s, self.spacing_s)
        if (gap and gap_s > LONGEST_GAP_S) or self.force_is_far(t_s, force):
            self.forget_attitude()
            self.mean_force_n = np.zeros(3)
        elif gap and rate is not None:
            share = (0.5 if self.options.gyro_hold == "forward" else 0.125) * GAP_TURN_FACTOR * gap_s**2
            self.widen(share**2 * self.change_power)

    def force_is_far(self, t_s: float, force: Numbers | None) -> bool:
        """Whether the mean force is far from the vertical although it is as large as gravity."""
        if force is None:
            return False
        T = self.interval("accel", t_s)
        upright = C_bn(self.q / np.linalg.norm(self.q)).T
        self.mean_force_n = self.mean_force_n + T / (MEAN_FORCE_S + T) * (upright @ force - self.mean_force_n)
        size = float(np.linalg.norm(self.mean_force_n))
        return abs(size - GRAVITY_M_S2) < 0.4 * GRAVITY_M_S2 and -self.mean_force_n[2] < FAR_COSINE * size

    def widen(self, variance: float) -> None:
        """Adds a variance to the rotation about every axis, rad^2, and removes the information gained before."""
        self.P[:4, :4] += variance * Xi(self.q) @ Xi(self.q).T
        self.information = np.zeros(2)

    def collect(self, t_s: float, force: Numbers | None, field: Numbers | None) -> None:
        """Starts the filter, at once or from the samples of several instants."""
        raise NotImplementedError

    def interval(self, sensor: str, t_s: float) -> float:
        """The duration that one sample stands for: its variance is density^2 over this."""
        longest: float = self.options.max_interval_s
        return min(t_s - self.last[sensor], longest) if sensor in self.last else 0.0

    def correct(self, t_s: float, force: Numbers | None, field: Numbers | None) -> None:
        o = self.options
        strength, dip = self.reference or (np.nan, np.nan)
        directions = []
        for sensor, value, reference_n, density, scale in (
            ("accel", force, GRAVITY_N, o.accel_noise_per_sqrt_hz, None),
            ("mag", field, np.array([np.cos(dip), 0, np.sin(dip)]), o.mag_noise_per_sqrt_hz, strength),
        ):
            T = 0.0 if value is None else self.interval(sensor, t_s)
            if value is not None and T > 0:
                directions.append(Direction(sensor, reference_n, value / (scale or np.linalg.norm(value)), density**2 / T))
        if directions:
            self.correct_by(t_s, directions)

    def expected(self, directions: list[Direction]) -> tuple[list[Numbers], list[Numbers]]:
        """Predicted measurements (3 each), and their derivatives by the quaternion (3 x 4 each)."""
        pairs = [measurement(self.q, d.reference_n) for d in directions]
        return [h for h, _ in pairs], [H for _, H in pairs]

    def correct_by(self, t_s: float, directions: list[Direction]) -> None:
        o = self.options
        seen, H_q = self.expected(directions)
        H = np.hstack([np.vstack(H_q), np.zeros((3 * len(directions), 3))])
        nu = np.concatenate([d.measured_b - h for d, h in zip(directions, seen)])
        R = np.diag(np.repeat([d.variance for d in directions], 3))

        interval_s = t_s - self.last_correction
        L = np.r_[np.full(4, o.gamma_weight_attitude), np.full(3, o.gamma_weight_bias)]
        Sigma, self.gamma = inflate(self.P, L, interval_s, o)
        before = np.diag(self.rotation_covariance())
        self.gate(directions, H @ Sigma @ H.T + R, nu, R)
        factor = cho_factor(H @ Sigma @ H.T + R)
        K = cho_solve(factor, H @ Sigma).T
        IKH = np.eye(7) - K @ H
        P = IKH @ Sigma @ IKH.T + K @ R @ K.T
        if o.adaptation != "off":
            self.adapt(t_s, H, R, K, nu, interval_s)
        x = np.r_[self.q, self.b] + K @ nu
        norm = float(np.linalg.norm(x[:4]))
        self.gain = Gain([d.sensor for d in directions], K, H, R, nu, norm)
        self.q, self.b = x[:4] / norm, x[4:]
        J = np.eye(7)
        J[:4, :4] = (np.eye(4) - np.outer(self.q, self.q)) / norm
        self.P = J @ P @ J.T
        self.P = 0.5 * (self.P + self.P.T)
        self.P_after = self.P
        self.last_correction = t_s
        self.inform({d.sensor for d in directions}, before, np.diag(self.rotation_covariance()))

    def gate(self, directions: list[Direction], S: Numbers, nu: Numbers, R: Numbers) -> None:
        """Inflates the noise R of directions whose NIS exceeds the gate."""
        o = self.options
        for k, d in enumerate(directions):
            block = slice(3 * k, 3 * k + 3)
            nis = self.nis[d.sensor] = float(nu[block] @ np.linalg.solve(S[block, block], nu[block]))
            limit = accel_gate(o) if d.sensor == "accel" else o.mag_gate_nis
            if limit > 0 and nis > limit and self.ready(d.sensor):
                R[block, block] += S[block, block] * (nis / limit - 1)

    def inform(self, sensors: set[str], before: Numbers, after: Numbers) -> None:
        """Adds the information about tilt (by force) and heading (by field) that a correction gave; variances of the rotation, 3."""
        if "accel" in sensors:
            self.information[0] += max(0, 1 / max(after[:2]) - 1 / max(before[:2]))
        if "mag" in sensors:
            self.information[1] += max(0, 1 / after[2] - 1 / before[2])

    def ready(self, sensor: str) -> bool:
        o, variance = self.options, np.diag(self.rotation_covariance())
        tilt = max(variance[:2]) < o.ready_tilt_rad**2 and self.information[0] > o.ready_tilt_rad**-2
        heading = variance[2] < o.ready_heading_rad**2 and self.information[1] > o.ready_heading_rad**-2
        return bool(tilt if sensor == "accel" else tilt and heading)

    def adapt(self, t_s: float, H: Numbers, R: Numbers, K: Numbers, nu: Numbers, interval_s: float) -> None:
        """Robbins-Monro on the bias walk, as printed or corrected."""
        o = self.options
        if o.adaptation == "paper":
            step = (K @ nu)[4:]
            self.Q_b = (1 - o.adaptation_gain) * self.Q_b + o.adaptation_gain * np.outer(step, step)
            return
        if np.isnan(self.settled_s):
            self.settled_s = t_s + SETTLING_S
        if t_s - interval_s < self.settled_s - 1e-9:
            return
        K0 = self.P @ H.T @ np.linalg.inv(H @ self.P @ H.T + R)
        self.window_s += interval_s
        self.bias_sum += (K0 @ nu)[4:]
        self.change += np.trace(((np.eye(7) - K0 @ H) @ self.P - self.P_after)[4:, 4:])
        if not has_lasted(self.window_s, WINDOW_S):
            return
        level = np.trace(self.Q_b) / 3
        estimate = (self.bias_sum @ self.bias_sum + self.change) / (3 * self.window_s)
        toward = 1.0 if estimate > level else -1.0
        self.swings += toward * self.direction < 0
        alpha = max(o.adaptation_gain, 0.9 / (1 + self.swings))
        mixed = max((1 - alpha) * level + alpha * estimate, 0.05 * level)
        bounds = (o.adaptation_min_rad_s_per_sqrt_s**2, o.adaptation_max_rad_s_per_sqrt_s**2)
        self.Q_b = self.Q_b * (np.clip(mixed, *bounds) / level)
        self.direction, self.window_s, self.bias_sum, self.change = toward, 0.0, np.zeros(3), 0.0
