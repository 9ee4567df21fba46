"""The paper's filter once more, in NumPy: slow, written to be read, and the oracle of the C library.

    q' = 1/2 q (x) (0, u) = Xi(q) u,   b' = 0,   u = w - b
    P' = A P + P A' + Q(q),   A = [[Omega(u), -Xi(q)], [0, 0]]

Its jump, gates and gaps are those of hnav.certify.hrekf; here are the flow, the start and the misprints. literal="kinematics"
takes (9) as printed, multiplied from the wrong side: a level body that only yaws does not show it, a tilted one does. literal="all"
adds (11), the discrete matrix I + dt A put into the continuous covariance equation, and (16) with wrong signs in four rows.
    python -m twins.hrekf        prints what that costs
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from hnav.certify.hrekf import Direction, HrekfEquations, Numbers, Omega, Xi
from hnav.filters.attitude import Filter
from hnav.filters.options import Options
from hnav.rotations import quaternion_product
from twins.first_samples import AgreeingSamples, triad

# --------------------------------------------------------------------------------------------- as printed


def printed_A(u: Numbers, q: Numbers) -> Numbers:
    """Equation (9): 1/2 (0, u) (x) q, the wrong side."""
    A = np.zeros((7, 7))
    A[:4, :4] = 0.5 * quaternion_product(np.r_[0, u], np.eye(4)).T
    A[:4, 4:] = -0.5 * quaternion_product(np.eye(4)[1:], q).T
    return A


def printed_measurement(q: Numbers, north: float, down: float) -> tuple[Numbers, Numbers]:
    """Equation (16) with rows 2, 4, 5 and 6 as printed, and their own Jacobian (complex step)."""

    def h(p: Numbers) -> Numbers:
        a, b, c, d = p
        return np.array([
            -2 * (b * d - a * c),
            -2 * (c * d - a * b),
            -a * a + b * b + c * c - d * d,
            north * (a * a + b * b + c * c - d * d) + 2 * down * (b * d - a * c),
            2 * north * (b * d - a * c) + 2 * down * (c * d + a * b),
            2 * north * (b * d + a * c) + down * (a * a + b * b - c * c + d * d),
        ])  # fmt: skip

    H = np.stack([h(q + 1e-30j * e).imag / 1e-30 for e in np.eye(4)], axis=1)
    return h(q), H


# --------------------------------------------------------------------------------------------- the filter


class ReferenceFilter(HrekfEquations):
    """HEKF and HREKF by options, as corrected or literally as printed; push one instant after the other with event()."""

    def __init__(self, options: Options, literal: str = ""):
        if literal not in ("", "kinematics", "all"):
            raise ValueError(f"literal = {literal}: choose kinematics or all")
        self.literal = literal
        super().__init__(options)

    def forget_attitude(self) -> None:
        super().forget_attitude()
        self.first = AgreeingSamples(self.options.start_samples)

    @property
    def q_nb(self) -> Numbers:
        """4: the attitude, body to the options' navigation frame."""
        return quaternion_product(self.user_from_internal, self.q)

    def flow(self, interval_s: float) -> None:
        """The estimate flows over an interval in which the rate is held."""
        if self.literal:
            self.printed_flow(interval_s)
            return
        o = self.options
        u = np.zeros(3) if self.rate is None else self.rate - self.b

        def slope(_: float, y: Numbers) -> Numbers:
            q, P = y[:4], y[4:].reshape(7, 7)
            A, Q = np.zeros((7, 7)), np.zeros((7, 7))
            A[:4, :4], A[:4, 4:] = Omega(u), -Xi(q)
            Q[:4, :4] = o.gyro_noise_rad_per_sqrt_s**2 * Xi(q) @ Xi(q).T + o.quaternion_noise_per_sqrt_s**2 * np.eye(4)
            Q[4:, 4:] = self.Q_b
            slopes: Numbers = np.r_[Omega(u) @ q, (A @ P + P @ A.T + Q).ravel()]
            return slopes

        y = solve_ivp(slope, (0, interval_s), np.r_[self.q, self.P.ravel()], method="DOP853", rtol=1e-12, atol=1e-15).y[:, -1]
        self.q, self.P = y[:4], y[4:].reshape(7, 7)

    def printed_flow(self, interval_s: float) -> None:
        """Two Euler steps; (11) is the discrete matrix inside the continuous equation, with its wrong element (4,1)."""
        o = self.options
        Q = np.zeros((7, 7))
        Q[:4, :4] = o.gyro_noise_rad_per_sqrt_s**2 / 4 * np.eye(4) + o.quaternion_noise_per_sqrt_s**2 * np.eye(4)
        Q[4:, 4:] = self.Q_b
        dt = interval_s / 2
        for _ in range(2):
            u = np.zeros(3) if self.rate is None else self.rate - self.b
            A = printed_A(u, self.q)
            F = A
            if self.literal == "all":
                F = np.eye(7) + dt * A
                F[3, 0] = dt / 2 * u[0]
            self.P = self.P + dt * (F @ self.P + self.P @ F.T + Q)
            self.q = self.q + dt * A[:4, :4] @ self.q

    def pass_gap(self, t_s: float, rate: Numbers | None, force: Numbers | None) -> None:
        """The printed equations have no rule for gaps."""
        if not self.literal:
            super().pass_gap(t_s, rate, force)

    def collect(self, t_s: float, force: Numbers | None, field: Numbers | None) -> None:
        """TRIAD on the means of the first samples that agree; the paper's start x0 = 0 is no quaternion."""
        o = self.options
        self.first.add(t_s, np.zeros(3) if self.rate is None else self.rate - self.b, force, field)
        f, m = self.first.means()
        if f is None or m is None:
            return
        R_bn = triad(f, m)
        if R_bn is None:
            self.first.forget()
            return
        self.q = Rotation.from_matrix(R_bn).as_quat(canonical=True, scalar_first=True)
        if self.reference is None:
            north, _, vertical = R_bn @ m
            self.reference = (
                float(np.linalg.norm(m)),
                float(np.arctan2(vertical, north)),
            )  # its azimuth is north by construction
        theta = R_bn.T @ np.diag([o.start_sigma_tilt_rad**2] * 2 + [o.start_sigma_heading_rad**2]) @ R_bn
        biases = self.P[4:, 4:]
        self.P = np.zeros((7, 7))
        self.P[:4, :4], self.P[4:, 4:] = Xi(self.q) @ theta @ Xi(self.q).T, biases
        self.last_correction = t_s
        self.P_after = self.P
        self.started = True

    def expected(self, directions: list[Direction]) -> tuple[list[Numbers], list[Numbers]]:
        if self.literal != "all" or self.reference is None:
            return super().expected(directions)
        h, H = printed_measurement(self.q, np.cos(self.reference[1]), np.sin(self.reference[1]))
        place = {"accel": slice(0, 3), "mag": slice(3, 6)}
        return [h[place[d.sensor]] for d in directions], [H[place[d.sensor]] for d in directions]


def run_reference(
    t_s: Numbers, rate: Numbers, force: Numbers, field: Numbers, options: Options, literal: str = ""
) -> tuple[Numbers, Numbers, Numbers]:
    """(q_nb n x 4, gyro bias n x 3, rotation sigma about the internal axes n x 3); NaN before the start."""
    f = ReferenceFilter(options, literal)
    n = len(t_s)
    q, b, sigma = np.full((n, 4), np.nan), np.full((n, 3), np.nan), np.full((n, 3), np.nan)
    for k in range(n):
        f.event(t_s[k], rate[k], force[k], field[k])
        if f.started:
            q[k], b[k] = f.q_nb, f.b
            sigma[k] = np.sqrt(np.maximum(0, np.diag(f.rotation_covariance())))
    return q, b, sigma


# --------------------------------------------------------------------------------------------- what the errata cost


def tilted_turns(tilt_deg: float, duration_s: float, seed: int = 3) -> tuple[Numbers, Numbers, Numbers, Numbers, Numbers]:
    """(t_s, rate, force, field, bias): a body pitched and rolled by tilt_deg that yaws to and fro by 60 deg; 50 Hz."""
    t = np.arange(0, duration_s, 0.02)
    bias = np.radians([1.0, -1.5, 0.5])
    angles = np.stack([60 * np.sin(0.3 * t), np.full_like(t, tilt_deg), np.full_like(t, tilt_deg)], axis=1)
    attitude = Rotation.from_euler("ZYX", angles, degrees=True)
    turned = (attitude[:-1].inv() * attitude[1:]).as_rotvec() / 0.02
    noise = 1e-3 * np.random.default_rng(seed).normal(size=(len(t), 3))
    rate = np.vstack([turned, turned[-1]]) + bias + noise
    force = attitude.apply([0, 0, -9.81], inverse=True)
    field = attitude.apply([2e-5, 0, 4.5e-5], inverse=True)
    return t, rate, force, field, bias


def bias_error_deg_s(tilt_deg: float, literal: str, duration_s: float = 40.0) -> float:
    """Largest component of the gyro bias error at the end; infinity when the equations diverge before."""
    t, rate, force, field, bias = tilted_turns(tilt_deg, duration_s)
    options = Options(
        "hrekf", "paper", gamma_mode="off", start_sigma_bias_rad_s=0.05, start_sigma_tilt_rad=0.1, start_sigma_heading_rad=0.1
    )
    if not literal:
        estimate = Filter(options).run(t, rate, force, field).gyro_bias_rad_s[-1]
        return float(np.degrees(np.abs(estimate - bias)).max())
    f = ReferenceFilter(options, literal)
    with np.errstate(all="ignore"):
        for k in range(len(t)):
            f.event(t[k], rate[k], force[k], field[k])
            if not np.isfinite(f.P).all() or not np.isfinite(f.b).all():
                return np.inf
    return float(np.degrees(np.abs(f.b - bias)).max())


if __name__ == "__main__":
    print("gyro bias error in deg/s after 40 s of yawing to and fro, with the equations as printed and corrected")
    print("tilt / deg     (9) printed     all printed     corrected")
    for tilt in (0.0, 20.0):
        print(f"{tilt:10.0f}", *(f"{bias_error_deg_s(tilt, literal):15.2f}" for literal in ("kinematics", "all", "")))
