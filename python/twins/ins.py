"""The navigation filter once it navigates, again in NumPy: attitude and velocity given, satellites, forward hold, closed form.

    twin = InsReference(options, t_s, place, rate, force, since_s)  # options: Options with start "state"
    twin.advance(t_s, rate, force)                              # a sample of the inertial sensor; or with the satellites of that instant
    twin.advance(t_s, rate, force, velocity_n, place)
    twin.advance(t_s, rate, force, field_b=field)               # with the field of a magnetometer

Without rest, gates (but for the memory of the field), steps, and what needs the start from any heading: of that c_src/ins is the only
description.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from hnav import earth
from hnav.certify.durations import has_lasted, has_passed
from hnav.filters.options import Options
from hnav.native.arrays import Array

D, V, PHI, GYRO, ACCEL = (slice(i, i + 3) for i in range(0, 15, 3))
AXES, LATENCY, COLOUR, OFFSET, SPEED_SCALE, MOUNT = slice(15, 24), 26, slice(27, 30), 30, 31, slice(32, 34)
ANTENNA, IRON, STRENGTH, DIRECTION = slice(34, 37), slice(37, 40), 40, 41
ERRORS = 42
EYE = np.eye(3)
ACCELERATES_S = 16.0
SLOW_GROWS_S = 10.0
SHARP = 0.1
IRON_WALK = 1e-3
STRENGTH_BY_PLACE = 0.1
ANY_DIRECTION = 1.0
VIBRATION_S = 2.0
"""Memory of the power between neighbouring samples."""
FELT_S = 10.0
"""Memory of the power of the force that moves the body."""
SMALL_M_S2, LONGEST_S, SHORTEST_AGE_S = 0.1, 1.0, 0.1
"""Vibration is averaged away to so little, within so long at the most."""


def cross_matrix(x: Array) -> Array:
    """3 x 3: its product with y is x cross y."""
    a, b, c = x.tolist()
    return np.array([[0, -c, b], [c, 0, -a], [-b, a, 0]])


def cross(x: Array, y: Array) -> Array:
    """NumPy's takes ten times as long for three numbers."""
    (a, b, c), (d, e, f) = x.tolist(), y.tolist()
    return np.array([b * f - c * e, c * d - a * f, a * e - b * d])


def rotation_of(q: Sequence[float]) -> Array:
    """3 x 3 of a quaternion of any length."""
    return np.asarray(Rotation.from_quat(q, scalar_first=True).as_matrix())


def turned(x: Array) -> tuple[Array, Array, Array]:
    """A held rate that turns by x: the rotation, its mean over the interval, and the mean weighted by the time left (3 x 3 each)."""
    n, X = math.sqrt(x @ x), cross_matrix(x)
    if n < 1e-3:
        terms = [1 - n**2 / 6, 0.5 - n**2 / 24, 1 / 6 - n**2 / 120, 1 / 24 - n**2 / 720]
    else:
        sin, cos = math.sin(n), math.cos(n)
        terms = [sin / n, (1 - cos) / n**2, (n - sin) / n**3, (n**2 / 2 - 1 + cos) / n**4]
    (a, b, c, d), X2 = terms, X @ X
    return EYE + a * X + b * X2, EYE + b * X + c * X2, 0.5 * EYE + c * X + d * X2


class SlowNoise:
    """What means over a short time show of the noise of rate and force; c_src/signals/slow_noise.hpp."""

    MEAN_S, MEMORY_S, ENOUGH = 0.05, 5.0, 10

    def __init__(self) -> None:
        self.sum, self.variance = np.zeros((2, 3)), np.zeros(2)
        self.count, self.length_s = 0, 0.0
        self.means: list[Array] = []  # the last two
        self.number = 0

    def note(self, rate: Array, force: Array, T: float) -> None:
        """A sample, so long after the last one."""
        self.sum, self.count, self.length_s = self.sum + [rate, force], self.count + 1, self.length_s + T
        if self.length_s < self.MEAN_S - 0.5 * T:
            return
        mean = self.sum / self.count
        if self.number >= 2:
            share = max(self.length_s / (self.MEMORY_S + self.length_s), 1 / (self.number - 1))
            change2 = np.sum((mean - 2 * self.means[1] + self.means[0]) ** 2, axis=1)
            self.variance = self.variance + share * (self.count * change2 / 18 - self.variance)
        self.means = [*self.means[-1:], mean]
        self.number += 1
        self.sum, self.count, self.length_s = np.zeros((2, 3)), 0, 0.0

    def at_most(self, between: Array) -> Array:
        """The smaller one of it and the variances between neighbouring samples."""
        return between if self.number < self.ENOUGH else np.minimum(between, self.variance)


class Consistency:
    """What an aid's noise is by the differences of its successive normalised innovations, and the time for which it lasts by their means;
    c_src/estimation/consistency.hpp."""

    MEMORY, LARGEST, AT_ONCE, SLOW_S, LONGEST_S = 20.0, 25.0, 2.0, 30.0, 20.0
    WINDOW_S, FAR, MOST, COLOUR_SLOW_S = 2.0, 10.0, 4.0, 40.0
    GROSS = 4.0
    """Ratio of variances above which the noise is treated as larger than stated."""

    def __init__(self, colour_s: float) -> None:
        self.noise, self.successive, self.stated, self.colour_s = 1.0, 1.0, 0.0, colour_s
        self.last: tuple[Array, float] | None = None
        self.sum, self.sum_variance = np.zeros(3), 0.0

    def weight(self, t_s: float) -> float:
        """Factor on the stated variance of a sample at t_s."""
        return self.noise * (max(1.0, self.colour_s / (t_s - self.last[1])) if self.last else 1.0)

    def restate(self, variance: float) -> None:
        """The estimate is a variance: if a larger one is stated than before, its ratio to the stated one falls."""
        if variance > self.stated > 0:
            self.noise = max(1.0, self.noise * self.stated / variance)
        self.stated = variance

    def note(self, r: Array, variance: Array, t_s: float) -> None:
        """Updates the consistency with an innovation within its gate."""
        since_s = min(t_s - self.last[1], self.LONGEST_S) if self.last else self.LONGEST_S
        y = r / np.sqrt(variance)
        y = y * min(1.0, self.FAR / max(1e-9, float(np.sqrt(np.mean(y**2)))))
        if self.last is not None:
            before = self.last[0]
            change2 = min(0.5 * float(np.mean((r - before) ** 2 / variance)), self.LARGEST)
            self.successive += (change2 - self.successive) / self.MEMORY
            if self.successive > self.AT_ONCE:
                self.noise *= self.successive
                self.sum = self.sum / np.sqrt(self.successive)
                self.successive = 1.0
            else:
                self.noise = max(1.0, self.noise * float(np.exp(since_s / self.SLOW_S * (self.successive - 1))))
        kept = self.WINDOW_S / (self.WINDOW_S + since_s)
        self.sum = kept * self.sum + y
        self.sum_variance = kept**2 * self.sum_variance + 1
        if self.last is not None and self.colour_s > 0 and since_s < self.WINDOW_S:
            bias = min(float(np.mean(self.sum**2)) / self.sum_variance, self.MOST)
            longer = self.colour_s * float(np.exp(since_s / self.COLOUR_SLOW_S * (bias - 1)))
            self.colour_s = max(since_s, min(longer, self.WINDOW_S))
        self.last = r, t_s


class InsReference:
    """d, v, R: displacement from the anchor, velocity and attitude in its axes T; P: 42 x 42, of the errors."""

    SIGMA_M, SIGMA_M_S = 1.5, 0.1
    """Of GNSS, each axis, unless stated otherwise."""
    VERTICAL_LATE_S = 0.06
    """Sigma of the delay that receivers add to the vertical."""

    def __init__(self, options: Options, t_s: float, place: Array, rate: Array, force: Array, since_s: float):
        """At the first fix: place is latitude and longitude in rad, and height; rate and force 2 x 3, of the first sample and of the one at
        the fix, which is since_s later."""
        self.o = o = options
        self.anchor_e, self.T = earth.position_of(place), earth.axes_at(place)
        self.earth_rate = self.T.T @ [0, 0, earth.RATE_RAD_S]
        self.R = rotation_of(o.start_q_nb)
        self.antenna = np.array(o.antenna_b_m, float)
        self.d, self.v = -self.R @ self.antenna, np.array(o.start_velocity_n_m_s, float)
        self.gyro_bias, self.accel_bias, self.colour = (np.zeros(3) for _ in range(3))
        self.latency, self.gyro_axes = 0.0, np.zeros((3, 3))
        self.turned_b = np.zeros(3)
        self.velocity_fit, self.position_fit = Consistency(0.3), Consistency(0.0)
        self.iron, self.strength, self.direction, self.field_unit, self.field_s = np.zeros(3), 1.0, 0.0, 0.0, -np.inf
        self.memory_field, self.memory_R, self.memory_s, self.refused_s = np.zeros(3), np.zeros((3, 3)), np.nan, np.nan
        self.P = self.first_covariance()
        self.t_s = self.corrected_s = self.velocity_s = t_s
        self.rate, self.force = np.array(rate[1], float), np.array(force[1], float)
        self.interval_s = 0.0
        self.before = np.array(rate[0], float), np.array(force[0], float)  # held before these
        self.vibration_rate2 = self.vibration_force2 = self.felt2 = self.false2 = self.by_errors2 = 0.0
        self.slow_noise = SlowNoise()
        self.slow_noise.note(self.rate, self.force, since_s)
        self.felt: Array | None = None
        self.recent, self.recent2 = np.zeros(3), 0.0
        self.put_gravity()
        self.clear_window()

    def first_covariance(self) -> Array:
        """The start: of the first fix its own sigma and a wide one."""
        o, P = self.o, np.zeros((ERRORS, ERRORS))
        self.slow = self.slow_before = self.slow_sigma(self.SIGMA_M)
        colour = self.slow**2
        P[D, D] = np.diag(self.SIGMA_M**2 + o.start_sigma_position_m**2 + colour)
        P[COLOUR, COLOUR] = np.diag(colour)
        P[D, COLOUR] = P[COLOUR, D] = -np.diag(colour)
        P[ANTENNA, ANTENNA] = o.start_sigma_antenna_m**2 * np.eye(3)
        P[D, D] += P[ANTENNA, ANTENNA]
        P[D, ANTENNA] = -(o.start_sigma_antenna_m**2) * self.R
        P[ANTENNA, D] = P[D, ANTENNA].T
        P[V, V] = np.diag(o.start_sigma_velocity_m_s**2 * np.array([1, 1, 0.04]))
        P[PHI, PHI] = np.diag([o.start_sigma_tilt_rad**2, o.start_sigma_tilt_rad**2, o.start_sigma_heading_rad**2])
        P[GYRO, GYRO] = o.start_sigma_gyro_bias_rad_s**2 * np.eye(3)
        P[ACCEL, ACCEL] = o.start_sigma_accel_bias_m_s2**2 * np.eye(3)
        P[AXES, AXES] = np.diag(np.where(EYE, o.start_sigma_gyro_scale, o.start_sigma_gyro_misalignment_rad).ravel() ** 2)
        P[LATENCY, LATENCY], P[SPEED_SCALE, SPEED_SCALE] = o.start_sigma_latency_s**2, o.start_sigma_speed_scale**2
        P[MOUNT, MOUNT] = o.start_sigma_mounting_rad**2 * np.eye(2)
        return P

    def put_gravity(self) -> None:
        """The position of the body."""
        self.gravity, self.gravity_at = self.T.T @ earth.gravity_at(self.anchor_e + self.T @ self.d), self.d.copy()

    def gravity_near(self, d: Array) -> Array:
        """Not far from there."""
        strength = np.linalg.norm(self.gravity)
        down, off = self.gravity / strength, d - self.gravity_at
        near: Array = self.gravity - strength / earth.EQUATOR_M * (off - 3 * (down @ off) * down)
        return near

    def clear_window(self) -> None:
        """What has been gathered since the last correction: how errors of start, biases and axes have become those of phi, v, d."""
        self.A, self.B, self.C, self.D = (np.zeros((3, 3)) for _ in range(4))
        self.by_rate, self.accelerated2 = np.zeros((3, 3, 3)), 0.0
        self.F, self.S, self.turned2, self.length_s = np.zeros(3), np.zeros(3), 0.0, 0.0

    # ----------------------------------------------------------------------------------------- between events

    def turn_rate(self) -> Array:
        """The rate without bias and the error of the axes."""
        rate = self.rate - self.gyro_bias
        return rate - self.gyro_axes @ rate

    def flow(self, T: float) -> Array:
        """Under the held rate and force; answers the rotation in the middle."""
        w, f, W, before = self.turn_rate(), self.force - self.accel_bias, self.earth_rate, self.R
        turn, mean, twice = turned(w * T)
        by_force, g = before @ mean @ f * T, self.gravity_near(self.d)
        a = g - 2 * cross(W, self.v)
        slope = self.gravity_near(self.d + T * self.v) - g
        gained = by_force + a * T - 0.5 * T * cross(W, by_force) - T * cross(W, by_force + a * T) + 0.5 * T * slope
        self.d = self.d + self.v * T + before @ twice @ f * T**2 + 0.5 * T**2 * a
        self.v = self.v + gained
        self.R = turned(-W * T)[0] @ before @ turn
        half: Array = turned(-0.5 * W * T)[0] @ before @ turned(0.5 * w * T)[0]
        return half

    def gather(self, T: float, R: Array) -> None:
        """Accumulates the last interval, at its middle."""
        rate, raw = self.turn_rate(), R @ (self.force - self.accel_bias)
        if not self.length_s > 0:
            self.by_errors2 = self.force_by_errors2(R)
        self.feel(raw, T)
        force = self.moving_force(raw, self.o.correction_interval_s)
        self.recent = self.recent + T / (self.age_s() + T) * (raw + self.gravity - self.recent)
        self.recent2 += T / (FELT_S + T) * (float(self.recent[:2] @ self.recent[:2]) - self.recent2)
        X = cross_matrix(force)
        self.D = self.D + T * self.A + 0.5 * T**2 * R
        turned = X @ (self.A + 0.5 * T * R)
        self.C = self.C + T * self.B + 0.5 * T**2 * turned
        self.B = self.B + T * turned
        self.A = self.A + T * R
        self.by_rate = self.by_rate + T * rate[:, None, None] * R
        acceleration = np.asarray(self.felt) + self.gravity
        self.accelerated2 += T * float(acceleration @ acceleration)
        self.S = self.S + T * self.F + 0.5 * T**2 * force
        self.F = self.F + T * force
        self.turned2 += T * float(rate @ rate)
        self.length_s += T

    def note_vibration(self, T: float, rate: Array, force: Array) -> None:
        """Second differences of neighbouring samples: six times the variance of white noise, on three axes each."""
        share = T / (VIBRATION_S + T)
        w, f = rate - 2 * self.rate + self.before[0], force - 2 * self.force + self.before[1]
        self.vibration_rate2 += share * (float(w @ w) / 18 - self.vibration_rate2)
        self.vibration_force2 += share * (float(f @ f) / 18 - self.vibration_force2)
        self.before = self.rate, self.force
        self.slow_noise.note(rate, force, T)

    def noise2(self, share: float = 1.0) -> tuple[float, float]:
        """Variances of rate and force per sample and axis, at low frequencies; share: of those between neighbouring samples."""
        rate2, force2 = self.slow_noise.at_most(share * np.array([self.vibration_rate2, self.vibration_force2])).tolist()
        return rate2, force2

    def felt_over_s(self) -> float:
        """Time over which vibration is averaged away to something small."""
        return min(LONGEST_S, self.noise2()[1] * self.interval_s / (2 * SMALL_M_S2**2))

    def force_by_errors2(self, R: Array) -> float:
        """Variance of the horizontal force that errors of tilt and accelerometer bias put into T."""
        errors = np.zeros((2, ERRORS))
        errors[:, PHI] = cross_matrix(np.array([0, 0, np.linalg.norm(self.gravity)]))[:2]
        errors[:, ACCEL] = -R[:2]
        return float(np.trace(errors @ self.P @ errors.T))

    def feel(self, force: Array, T: float) -> None:
        """The force without vibration, its mean square along the horizontal, and the share of errors of tilt and accelerometer bias."""
        felt = force if self.felt is None else self.felt
        self.felt = felt + T / (self.felt_over_s() + T) * (force - felt)
        self.felt2 += T / (FELT_S + T) * (float(self.felt[:2] @ self.felt[:2]) - self.felt2)
        self.false2 += T / (FELT_S + T) * (self.by_errors2 - self.false2)

    def moving_force(self, raw: Array, over_s: float) -> Array:
        """The part of a force, a mean over so long, by which errors of the attitude become those of the velocity."""
        noise2 = 2 * self.noise2()[1] * self.interval_s
        if self.felt is None or not noise2 > 0:
            return raw
        moved2 = max(0.0, self.felt2 - self.false2 - noise2 / (2 * self.felt_over_s() + self.interval_s))
        steady = self.felt * np.array([moved2 / self.felt2, moved2 / self.felt2, 1])
        moving: Array = steady + moved2 / (moved2 + noise2 / over_s) * (raw - steady)
        return moving

    def age_s(self) -> float:
        """Averaging time of the recent acceleration."""
        return max(SHORTEST_AGE_S, 0.5 * self.latency)

    def missed(self, taken_back_per_s: float = 0.0) -> tuple[Array, Array]:
        """What a late velocity misses: acceleration of the motion, and velocity that noise has added (regression dilution)."""
        noise2_s = 2 * self.noise2()[1] * self.interval_s
        noise2 = noise2_s / (2 * self.age_s())
        moved2 = max(0.0, self.recent2 - self.false2 - noise2)
        all2 = moved2 + self.false2 + noise2
        if not all2 > 0:
            return self.recent, np.zeros(3)
        return moved2 / all2 * self.recent, noise2_s / all2 / (1 + self.age_s() * taken_back_per_s) * self.recent

    def transition(self) -> Array:
        """42 x 42, over the window."""
        T, M, W = self.length_s, np.eye(ERRORS), cross_matrix(self.earth_rate)
        M[D, V], M[D, PHI], M[D, GYRO], M[D, ACCEL] = T * np.eye(3), -cross_matrix(self.S), self.C, -self.D
        M[V, D] = T * np.linalg.norm(self.gravity) / earth.EQUATOR_M * np.diag([-1, -1, 2])
        M[V, V] = np.eye(3) - 2 * T * W
        M[V, PHI], M[V, GYRO], M[V, ACCEL] = -cross_matrix(self.F), self.B, -self.A
        M[PHI, PHI] = np.eye(3) - T * W
        M[PHI, GYRO], M[PHI, AXES] = -self.A, -self.by_rate.transpose(1, 2, 0).reshape(3, 9)
        return M

    def propagate(self) -> None:
        """The covariance over the window."""
        o, T = self.o, self.length_s
        if not T > 0:
            return
        heading = self.P[8, 8]
        M = self.transition()
        P = M @ self.P @ M.T
        kept, grown = self.colour_of()
        P[COLOUR] *= kept[:, None]
        P[:, COLOUR] *= kept
        P[COLOUR, COLOUR] += np.diag(grown)
        P[OFFSET, OFFSET] += 2 * o.pressure_colour_m**2 * T / o.pressure_colour_s
        if self.field_unit > 0:
            stays = np.exp(-T / o.field_direction_s)
            P[DIRECTION] *= stays
            P[:, DIRECTION] *= stays
            P[DIRECTION, DIRECTION] += o.field_direction_rad**2 * (1 - stays**2)
            P[IRON, IRON] += IRON_WALK**2 * T * np.eye(3)
            P[STRENGTH, STRENGTH] += IRON_WALK**2 * T
        (rate2, force2), one = self.noise2(o.vibration_share), np.eye(3)
        accel = max(o.accel_noise_m_s_per_sqrt_s**2, self.interval_s * force2) * T
        accel += ACCELERATES_S * o.accel_scale**2 * self.accelerated2
        gyro = max(o.gyro_noise_rad_per_sqrt_s**2, self.interval_s * rate2) * T
        P[V, V] += accel * one
        P[D, D] += accel * T**2 / 3 * one
        P[D, V] += accel * T / 2 * one
        P[V, D] += accel * T / 2 * one
        P[PHI, PHI] += (gyro + o.gyro_rate_noise_sqrt_s**2 * self.turned2) * one
        P[GYRO, GYRO] += o.gyro_bias_walk_rad_s_per_sqrt_s**2 * T * one
        P[ACCEL, ACCEL] += o.accel_bias_walk_m_s2_per_sqrt_s**2 * T * one
        lost = max(0.0, P[8, 8] - heading)
        (a, c), (_, b) = P[6:8, 6:8]
        kept, swapped = np.exp(-0.5 * lost), -0.5 * np.expm1(-2 * lost)
        P[6:8] *= kept
        P[:, 6:8] *= kept
        both = np.array([[a + swapped * (b - a), (1 - 2 * swapped) * c], [(1 - 2 * swapped) * c, b + swapped * (a - b)]])
        P[6:8, 6:8] = both
        self.P = P

    def slow_sigma(self, stated_m: float) -> Array:
        """Variance of the slow error of a fix that states this sigma: north, east, down."""
        usual = self.usual_colour()
        return np.where(usual > 0, np.where(stated_m < SHARP * usual, stated_m, np.maximum(usual, stated_m)), 0)

    def usual_colour(self) -> Array:
        """The option, north, east, down."""
        return np.array([self.o.position_colour_m[0]] * 2 + [self.o.position_colour_m[1]])

    def colour_of(self) -> tuple[Array, Array]:
        """The slow error of the satellites over an interval: the share that stays, and the variance that is added."""
        beyond = np.array([np.hypot(*self.colour[:2])] * 2 + [abs(self.colour[2])]) / 3
        fades, before = np.exp(-self.length_s / self.o.position_colour_s), self.slow_before
        less = np.minimum(1, np.divide(self.slow, before, out=np.ones(3), where=before > 0))
        more = np.maximum(0, self.slow**2 - before**2)
        jumped = beyond > before
        return np.where(jumped, 1, fades * less), np.where(jumped, beyond, less * before) ** 2 * (1 - fades**2) + more

    # ----------------------------------------------------------------------------------------- at events

    def advance(
        self, t_s: float, rate: Array, force: Array, velocity_n: Array | None = None, place: Array | None = None,
        field_b: Array | None = None, sigma_m: float = SIGMA_M,
    ) -> None:  # fmt: skip
        """A sample, from its time on, with the measurements of satellites and magnetometer at that time. sigma_m: of the place, each axis."""
        T = t_s - self.t_s
        self.gather(T, self.flow(T))
        self.put_gravity()
        self.note_vibration(T, np.array(rate, float), np.array(force, float))
        self.rate, self.force, self.t_s = np.array(rate, float), np.array(force, float), t_s
        half_s = 0.5 * self.interval_s
        if not has_lasted(t_s - self.field_s + half_s, self.o.correction_interval_s):
            field_b = None
        given = velocity_n is not None or field_b is not None
        if given or has_lasted(t_s - self.corrected_s + half_s, self.o.correction_interval_s):
            self.correct(velocity_n, place, field_b, sigma_m)
        self.interval_s = self.interval_s + 0.1 * (T - self.interval_s) if self.interval_s > 0 else T

    def correct(self, velocity_n: Array | None, place: Array | None, field_b: Array | None, sigma_m: float) -> None:
        """All corrections of one event."""
        if place is not None:
            least = (1.0 if self.position_fit.noise > Consistency.GROSS else SHARP) * self.usual_colour()
            most = np.exp(self.length_s / SLOW_GROWS_S) * np.maximum(self.slow_before, least)
            self.slow = np.minimum(self.slow_sigma(sigma_m * self.position_fit.noise**0.5), most)
        kept, _ = self.colour_of()
        self.propagate()
        if self.position_fit.noise > Consistency.GROSS:
            more = np.minimum(self.slow, self.usual_colour()) ** 2 - self.slow_before**2
            self.P[D, D] += np.diag(np.broadcast_to(np.maximum(0.0, more), 3))
        self.slow_before = self.slow
        if self.length_s > 0:
            self.colour = kept * self.colour
            self.direction *= np.exp(-self.length_s / self.o.field_direction_s)
        if field_b is not None and not self.field_unit > 0:
            self.begin_field(field_b)
        self.clear_window()
        if velocity_n is not None and place is not None:
            known2 = np.diag(self.P[V, V])[:2].max()
            gain = known2 / (known2 + self.SIGMA_M_S**2 * self.velocity_fit.weight(self.t_s))
            tau, (a, noise_m_s) = self.latency, self.missed(gain / (self.t_s - self.velocity_s))
            R, w = self.R, self.turn_rate()
            swing = R @ cross(w, self.antenna)
            a_antenna = a + R @ cross(w, cross(w, self.antenna))
            H, noise = self.late(a_antenna)
            H[:, V], H[:, PHI], H[:, ACCEL] = np.eye(3), tau * cross_matrix(a - self.gravity) - cross_matrix(swing), tau * R
            H[:, GYRO], H[:, ANTENNA] = R @ cross_matrix(self.antenna), R @ cross_matrix(w)
            self.velocity_fit.restate(self.SIGMA_M_S**2)
            z = self.T.T @ earth.axes_at(place) @ velocity_n
            self.use(H, z - (self.v + swing - tau * a_antenna - noise_m_s), self.SIGMA_M_S**2 + noise, self.velocity_fit)
            self.velocity_s = self.t_s
            tau, (a, _) = self.latency, self.missed()
            H, noise = self.late(self.v - tau * a)
            H[:, D], H[:, COLOUR], H[:, V] = np.eye(3), np.eye(3), -tau * np.eye(3)
            lever = self.R @ self.antenna
            H[:, PHI], H[:, ANTENNA] = -cross_matrix(lever), self.R
            self.position_fit.restate(sigma_m**2)
            z = self.T.T @ (earth.position_of(place) - self.anchor_e)
            self.use(
                H, z - (self.d + lever + self.colour - tau * (self.v - 0.5 * tau * a)), sigma_m**2 + noise, self.position_fit
            )
        if field_b is not None:
            self.correct_field(field_b)
        self.turn_errors()
        self.put_gravity()
        self.corrected_s = self.t_s

    def turn_errors(self) -> None:
        """What no sample observes apart stays together: biases stay in T, but by a corrected heading the tilt turns with the body."""
        heading = np.array([0, 0, self.R[2] @ self.turned_b])
        level_b = self.turned_b - self.R.T @ heading
        for rows, angle in ((PHI, heading), (GYRO, -self.turned_b), (ACCEL, -level_b)):
            turn = turned(angle)[0]
            self.P[rows] = turn @ self.P[rows]
            self.P[:, rows] = self.P[:, rows] @ turn.T
        self.turned_b = np.zeros(3)

    def late(self, change: Array) -> tuple[Array, Array]:
        """Rows with what the latency does to what changes so fast, and the noise of the vertical, which is late by itself."""
        H = np.zeros((3, ERRORS))
        H[:2, LATENCY] = -change[:2]
        return H, np.array([0.0, 0.0, (self.VERTICAL_LATE_S**2 + self.P[LATENCY, LATENCY]) * change[2] ** 2])

    def begin_field(self, field_b: Array) -> None:
        """The first sample sets the unit of the field."""
        self.field_unit = 1 / max(float(np.linalg.norm((self.R @ field_b)[:2])), 0.1 * float(np.linalg.norm(field_b)))
        self.P[IRON, IRON] = self.o.start_sigma_iron**2 * np.eye(3)
        self.P[STRENGTH, STRENGTH] = self.o.start_sigma_iron**2 + STRENGTH_BY_PLACE**2
        self.P[DIRECTION, DIRECTION] = self.o.field_direction_rad**2

    def remembers_field(self, field_b: Array) -> bool:
        """Whether the field, in axes held by the gyroscopes, agrees with the mean of the recent fields."""
        o, R, measured = self.o, self.R, self.R @ (self.field_unit * field_b)
        since_s, refused = self.t_s - self.memory_s, np.isfinite(self.refused_s)
        if np.isnan(since_s) or (not refused and has_passed(since_s, o.field_colour_s)):
            self.memory_field, self.memory_R, self.memory_s = measured, R, self.t_s
            return True
        before, by_turn = self.memory_field, R - self.memory_R
        strength = max(1 / float(np.linalg.norm(before)), self.strength)
        iron = self.iron + (strength - self.strength) / self.P[STRENGTH, STRENGTH] * self.P[IRON, STRENGTH]
        fits = by_turn @ np.hstack([np.eye(3), -iron[:, None] / strength])
        drift = (since_s + o.field_colour_s) * strength * cross_matrix(before) @ R
        soft = strength**2 * float(before @ before) * float(np.sum(by_turn**2)) / 3
        noise = o.field_noise**2 * (max(1.0, strength * float(np.linalg.norm(before[:2]))) ** 2 + soft)
        S = (
            fits @ self.P[IRON.start : DIRECTION, IRON.start : DIRECTION] @ fits.T
            + drift @ self.P[GYRO, GYRO] @ drift.T
            + noise * np.eye(3)
        )
        change = strength * (measured - before) - by_turn @ iron
        limit = min(3.0, o.gate_nis) if refused else o.gate_nis
        if o.gate_nis > 0 and change @ np.linalg.solve(S, change) > limit:
            return False
        share = since_s / (since_s + o.field_colour_s)
        self.memory_field = before + share * (measured - before)
        self.memory_R, self.memory_s = self.memory_R + share * by_turn, self.t_s
        return True

    def widen_iron(self) -> None:
        """A field that has differed for long is a new one."""
        if not has_passed(self.t_s - self.refused_s, self.o.gate_longest_s):
            return
        self.P[IRON, IRON] += self.o.start_sigma_iron**2 * np.eye(3)
        self.P[STRENGTH, STRENGTH] += self.o.start_sigma_iron**2
        self.P[DIRECTION, DIRECTION] += ANY_DIRECTION**2
        self.refused_s = self.memory_s = np.nan

    def correct_field(self, field_b: Array) -> None:
        """strength m - R iron = north, along the horizontal."""
        self.widen_iron()
        if not self.remembers_field(field_b):
            self.refused_s = self.t_s if np.isnan(self.refused_s) else self.refused_s
            self.field_s = self.t_s
            return
        self.refused_s = np.nan
        o, measured, iron = self.o, self.R @ (self.field_unit * field_b), self.R @ self.iron
        points = o.declination_rad + self.direction
        N = earth.axes_at(earth.place_of(self.anchor_e + self.T @ self.d))
        north = (self.T.T @ N @ [np.cos(points), np.sin(points), 0])[:2]
        across = np.array([-north[1], north[0]])
        H = np.zeros((2, ERRORS))
        H[:, IRON], H[:, STRENGTH], H[:, 8], H[:, DIRECTION] = -self.R[:2], measured[:2], across, -across
        left = self.strength * measured[2] - iron[2]
        noise = o.field_noise**2 + max(self.P[6, 6], self.P[7, 7]) * left**2
        slow = max(1.0, o.field_colour_s / (self.t_s - self.field_s))
        self.field_s = self.t_s
        self.use(H, north + iron[:2] - self.strength * measured[:2], noise * slow)

    def use(self, H: Array, r: Array, variance: float | Array, fit: Consistency | None = None) -> None:
        """One measurement; variance: of each value, or of all; fit: consistency of the GNSS channel, which estimates its noise."""
        S = H @ self.P @ H.T + (fit.weight(self.t_s) if fit else 1.0) * np.diag(np.broadcast_to(variance, len(r)))
        K = np.linalg.solve(S, H @ self.P).T
        error = K @ r
        self.P = self.P - K @ H @ self.P
        self.P = 0.5 * (self.P + self.P.T)
        if fit:
            fit.note(r, np.diag(S), self.t_s)
        self.turned_b = self.turned_b + self.R.T @ error[PHI]
        self.d, self.v, self.R = self.d + error[D], self.v + error[V], turned(error[PHI])[0] @ self.R
        self.memory_field, self.memory_R = turned(error[PHI])[0] @ self.memory_field, turned(error[PHI])[0] @ self.memory_R
        self.gyro_bias, self.accel_bias = self.gyro_bias + error[GYRO], self.accel_bias + error[ACCEL]
        self.gyro_axes, self.latency = self.gyro_axes + error[AXES].reshape(3, 3), self.latency + error[LATENCY]
        self.colour, self.iron = self.colour + error[COLOUR], self.iron + error[IRON]
        self.antenna = self.antenna + error[ANTENNA]
        self.strength, self.direction = self.strength + float(error[STRENGTH]), self.direction + float(error[DIRECTION])
