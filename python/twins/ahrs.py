"""The AHRS once more, in NumPy: slow, written to be read beside docs/filters.md, and the oracle of the C library.

    twin = AhrsReference(Options("ahrs"))
    twin.event(t_s, rate, force, field, heading, speed)    # the samples of one instant, None where there is none
    twin.R_bn, twin.rotation_covariance(), twin.tilt_ready(), twin.heading_ready()

    between events:  R' = R [u]x,  G' = R,  u = y - b - S y + coning
    theta(T) = theta - G db - L dS,  L = int R (x) y'         the error in navigation axes: no steps, integrals of R
    v(T)     = v + g int (-theta_E, theta_N) - int R da - swept dl
    P(T)     = Phi P Phi' + Q, every correction_interval_s; then
    velocity 0 = v + noise,  rest  mean rate = b,  field  M = mean field,  heading aid = atan2(E, N) of body x,
    speed      v = speed x body x + noise, in the place of 0 = v

Axes: north-east-down of magnetic north, and those of the sensors; samples in order. What happens to samples that are late, share a
stamp or come from a sensor at fault, when a clock is set, realign and the smoother: of that c_src is the only description.
"""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from hnav.certify.durations import has_lasted, has_passed, is_within
from hnav.certify.hrekf import inflate
from hnav.filters.options import Options
from hnav.native.arrays import Array
from twins.ahrs_parts import (
    ANY_HEADING,
    LASTING_DENSITY2,
    VERTICAL2,
    BiasSteps,
    FieldNoise,
    FirstSamples,
    GivenSpeed,
    LastingMotion,
    MagneticReference,
    MotionNoise,
    RestDetector,
    SampleTimes,
    StillField,
    TiltExcess,
    TurningForce,
    VehicleTilt,
    about_down,
    azimuth,
    exp,
    intensities_of,
    wrap,
)
from twins.first_samples import G_M_S2
from twins.ins import EYE, cross, cross_matrix, turned

V, FORCE_BIAS, CALIBRATION, PHI, BIAS, M = slice(0, 2), slice(2, 5), slice(6, 15), slice(15, 18), slice(18, 21), slice(21, 23)
FORCE_LATENCY, HEADING, LATENCY, DECLINATION, ERRORS = 5, 17, 23, 24, 25
CONSIDERED = 17
"""Errors before this one are considered when a field or a heading corrects, but not corrected: no magnet may tilt the horizon."""
ONE, EYE2 = np.eye(ERRORS), np.eye(2)
UNSTATED_INSTANT = 0.125
"""Squared intervals: a rate may be a reading of its instant, as probably as not."""


def turned_on(measured_b: Array, turn: Array, share: float) -> tuple[Array, Array]:
    """A vector constant in navigation axes, measured a share of a turn ago, in the present body axes, and its derivative by the share."""
    turning = cross(turn, measured_b)
    again = cross(turn, turning)
    return measured_b - share * turning + 0.5 * share**2 * again, turning - share * again


def tilt_of(covariance: Array) -> Array:
    """2: variances of the rotation about north and east."""
    return covariance.diagonal()[PHI][:2]


class AhrsReference:
    """The state and its events. P is the covariance just after the last correction, E that of the present one.

    Of 25 errors: velocity (north, east), bias and latency of the accelerometer, calibration S of the gyroscope row by row, rotation
    theta about the navigation axes, gyro bias, reference field M (horizontal and down, in units of its strength), latency of the
    magnetometer, declination of the field here.
    """

    def __init__(self, options: Options):
        o: Any = SimpleNamespace(**options.as_dict())  # reading an option of the library takes a call
        self.o = o
        self.started = self.lost = self.confirmed = False
        self.R_bn, self.bias, self.S = np.eye(3), np.array(o.start_gyro_bias_rad_s, float), np.zeros((3, 3))
        self.velocity, self.force_bias, self.force_latency = np.zeros(2), np.zeros(3), float(o.start_accel_latency)
        self.strength, self.latency, self.declination = o.reference_strength_tesla, 0.0, 0.0
        self.M = np.array([math.cos(o.reference_dip_rad), math.sin(o.reference_dip_rad)])
        self.has_reference = self.given = o.reference_mode == "given"
        self.M_given = self.M
        self.foreign2 = 0.0  # share of the declination's variance from a field that is not the given one, rad^2
        self.rate: Array | None = None
        self.read_rate = np.zeros(3)  # the last sample of the rate
        self.coning, self.force_turn, self.rate_change2, self.wrong_hold = np.zeros(3), np.zeros(3), 0.0, 0.03
        self.rest, self.rested, self.still_field = RestDetector(o, np.zeros(3)), False, StillField()
        self.lasting_density2 = LASTING_DENSITY2.get(o.body, 0.0)  # 0: the body is not given
        self.swell_density2 = 0.4 if o.body == "ship" else 0.0
        self.begin_motion()
        self.field, self.field_noise = MagneticReference(o), FieldNoise()
        self.information = np.zeros(2)  # of tilt and heading, 1/rad^2
        self.undisturbed_s = self.azimuth_rejected_s = self.reference_variance = self.contradicted_s = 0.0
        self.level_force, self.level_s, self.times_lost, self.aided = np.zeros(3), 0.0, 0, False
        self.first = FirstSamples(o)
        self.gyro, self.accel, self.mag = (SampleTimes(o.max_interval_s) for _ in range(3))
        self.t_s = self.corrected_s = math.nan
        self.verdict = "accept"  # on the last field
        self.nis: dict[str, float] = {}  # of the last correction by each sensor
        self.turning_force = TurningForce()
        self.P, self.steps = self.first_covariance(o.start_sigma_heading_rad), BiasSteps(ERRORS, BIAS, o.residual_iron)
        self.clear_window()

    def begin_motion(self) -> None:
        """No kind of body is given."""
        self.motion = MotionNoise(self.o.velocity_noise_m_s_per_sqrt_hz)
        self.tilt_excess, self.vehicle_tilt, self.speed = TiltExcess(), VehicleTilt(self.o.body == "any"), GivenSpeed()
        self.lasting = LastingMotion((self.o.velocity_noise_m_s_per_sqrt_hz / 1.1) ** 2)

    def first_covariance(self, sigma_heading: float) -> Array:
        o, sigma = self.o, np.zeros(ERRORS)
        sigma[V], sigma[M], sigma[LATENCY] = o.start_sigma_velocity_m_s, o.start_sigma_reference, o.start_sigma_latency_s
        sigma[CALIBRATION] = np.where(EYE, o.start_sigma_gyro_scale, o.start_sigma_gyro_misalignment_rad).ravel()
        sigma[PHI] = o.start_sigma_tilt_rad, o.start_sigma_tilt_rad, sigma_heading
        sigma[BIAS], sigma[FORCE_BIAS] = o.start_sigma_bias_rad_s, o.start_sigma_accel_bias_m_s2
        sigma[FORCE_LATENCY] = o.start_sigma_accel_latency
        sigma[DECLINATION] = o.local_declination_rad * FieldNoise.AT_FIRST / FieldNoise.ROOM
        return np.diag(sigma**2)

    def clear_window(self) -> None:
        """Sums accumulated between two corrections."""
        self.window_s = self.rate_power = self.gap_rotation = 0.0
        self.G, self.L = np.zeros((3, 3)), np.zeros((3, 9))
        self.force_s = self.force_gap_s = self.velocity_down = self.field_s = 0.0
        self.swept_velocity, self.field_sum, self.turn_sum, self.fields = np.zeros(2), np.zeros(3), np.zeros(3), 0

    # ----------------------------------------------------------------------------------------- time

    def event(
        self, t_s: float, rate: Array | None = None, force: Array | None = None, field: Array | None = None,
        heading: tuple[float, float] | None = None, speed: tuple[float, float] | None = None,
    ) -> None:  # fmt: skip
        """The samples of one instant: 3 each in SI units; heading and its sigma in rad, speed and its sigma in m/s."""
        backward = self.o.gyro_hold != "forward"
        gap_too_long = self.started and self.gap_variance(t_s, rate is not None) > 1
        if rate is not None and backward:
            self.hold_backward(t_s, rate, gap_too_long)
        if self.started and gap_too_long:
            self.pass_gap(t_s)
        elif self.started:
            self.flow(t_s - self.t_s)
        if rate is not None and not backward:
            self.hold(t_s, rate)
        self.aided |= heading is not None
        if not self.started:
            self.start(t_s, force, field, heading)
        else:
            self.gather(t_s, rate, force, field)
            half_s = 0.5 * self.gyro.interval(t_s) if rate is not None else 0
            if any((heading, speed)) or has_lasted(t_s - self.corrected_s + half_s, self.o.correction_interval_s):
                self.correct(t_s, rate is not None, heading, speed)
        for times, sample in ((self.gyro, rate), (self.accel, force), (self.mag, field)):
            if sample is not None:
                times.note(t_s)
        self.t_s = t_s

    # ----------------------------------------------------------------------------------------- start

    def start(self, t_s: float, force: Array | None, field: Array | None, heading: tuple[float, float] | None) -> None:
        """With the first attitude that follows from the samples."""
        found = self.first.add(t_s, self.turn_rate() + self.coning, force, field, heading)
        if found is None:
            return
        self.R_bn, sigma_heading = found
        self.P, self.steps = self.first_covariance(sigma_heading), BiasSteps(ERRORS, BIAS, self.o.residual_iron)
        if self.o.start_mode == "attitude":
            self.vehicle_tilt.P[0, 0] = min(self.vehicle_tilt.P[0, 0], self.o.start_sigma_tilt_rad**2)
        field = self.first.samples.means()[1]
        if not self.has_reference and field is not None:
            self.put_reference(field)
        if self.o.start_mode == "triad" and math.isnan(self.first.aid[0]) and field is not None:
            largest = math.sqrt(ANY_HEADING / self.P[15, 15])
            self.add_error(15, float(np.clip(self.M[1] / self.M[0], -largest, largest)), HEADING)
        if self.given and field is not None:
            self.start_in_foreign_field(intensities_of(self.R_bn @ field) / self.strength)
        self.rest, self.corrected_s, self.started = RestDetector(self.o, self.first.samples.mean[0]), t_s, True

    def put_reference(self, field_b: Array) -> None:
        """Makes the present field the reference: its azimuth is north, its strength the unit of fields, its dip as wrong as the horizon."""
        self.strength = float(np.linalg.norm(field_b))
        self.M = intensities_of(self.R_bn @ field_b) / self.strength
        self.has_reference = True
        self.add_error(16, self.M[1], 21)
        self.add_error(16, -self.M[0], 22)

    def add_error(self, source: int, factor: float, to: int) -> None:
        """One error is larger by a multiple of another."""
        T = ONE.copy()
        T[to, source] = factor
        self.P = T @ self.P @ T.T

    # ----------------------------------------------------------------------------------------- flow

    def turn_rate(self) -> Array:
        """The rate without its errors; zero before the first sample."""
        return np.zeros(3) if self.rate is None else self.rate - self.bias - self.S @ self.rate

    def hold(self, t_s: float, read: Array, gap_too_long: bool = False) -> None:
        """The rate of an interval; coning: if its axis turns, the mean rate misses a rotation (Miller 1983)."""
        T, self.coning = t_s - self.gyro.last_s, np.zeros(3)
        between = self.o.gyro_hold == "instant" and self.rate is not None and T > 0 and not gap_too_long
        rate, self.read_rate = 0.5 * (self.read_rate + read) if between else read, read
        if self.rate is not None and T > 0 and not self.gyro.is_gap(t_s):
            change2 = float(np.sum((rate - self.rate) ** 2)) / (3 * T**2)
            self.rate_change2 += T / (2 + T) * (change2 - self.rate_change2)
            if self.o.gyro_hold != "forward":
                self.coning = T / 12 * cross(self.rate, rate)
        self.rate = rate

    def hold_backward(self, t_s: float, rate: Array, gap_too_long: bool) -> None:
        """The rate of the interval before its sample; parts of it crossed by events of other sensors are turned again."""
        went_on_s, before = self.t_s - self.gyro.last_s, self.turn_rate() + self.coning
        self.hold(t_s, rate, gap_too_long)
        if self.started and went_on_s > 0 and not gap_too_long:
            now = self.turn_rate() + self.coning
            after = 0.5 * (now + before) if self.o.gyro_hold == "backward" and self.gyro.is_gap(t_s) else now
            self.R_bn = self.R_bn @ exp(-before * went_on_s) @ exp(after * went_on_s)

    def flow(self, T: float) -> None:
        """Attitude and the integrals that the transition needs, under the held rate."""
        u = self.turn_rate() + self.coning
        turn, mean, _ = turned(u * T)
        dG: Array = self.R_bn @ mean * T
        self.G = self.G + dG
        if self.rate is not None:
            self.L = self.L + np.outer(dG, self.rate).reshape(3, 9)
        self.R_bn = self.R_bn @ turn
        self.rate_power += float(u @ u) * T
        self.force_turn = self.force_turn + u * T
        self.window_s += T

    def gap_variance(self, t_s: float, ended: bool) -> float:
        """Variance of the rotation about an axis while samples of the rate are missing."""
        gap_s = t_s - self.gyro.last_s
        share = (0.125 if ended else 0.5) * self.o.gap_turn_factor * gap_s**2
        return share**2 * self.rate_change2 if self.gyro.is_gap(t_s) else 0.0

    # ----------------------------------------------------------------------------------------- samples gathered in navigation axes

    def gather(self, t_s: float, rate: Array | None, force: Array | None, field: Array | None) -> None:
        if rate is not None:
            self.rest.note_rate(rate, self.gyro.interval(t_s))
        if force is not None:
            self.gather_force(t_s, force)
        if field is not None and self.has_reference:
            self.gather_field(t_s, field)
        elif field is not None:
            self.find_heading(field)

    def gather_force(self, t_s: float, force: Array) -> None:
        """A sample is the mean of its interval (latency of half of it) or instantaneous: the latency is estimated."""
        since_s, T = t_s - self.accel.last_s, self.accel.interval(t_s)
        turn = self.force_turn * (T / since_s) if since_s > 0 else np.zeros(3)
        self.force_turn = np.zeros(3)
        now_b, swept_b = turned_on(force - self.force_bias, turn, self.force_latency)
        force_n, swept_n = self.R_bn @ now_b, self.R_bn @ swept_b
        self.swept_velocity = self.swept_velocity + swept_n[:2] * T
        self.velocity = self.velocity + force_n[:2] * T
        self.velocity_down += force_n[2] * T
        self.force_s += T
        self.force_gap_s += max(0.0, since_s - T) if since_s > 0 else 0.0
        self.motion.note(force_n, T)
        self.rest.note_force(force, T)

    def gather_field(self, t_s: float, field: Array) -> None:
        u = self.turn_rate() + self.coning
        self.field_sum = self.field_sum + self.R_bn @ turned_on(field / self.strength, u, self.latency)[0]
        self.turn_sum = self.turn_sum + self.R_bn @ u
        self.fields += 1
        self.field_s += self.mag.interval(t_s)

    def find_heading(self, field_b: Array) -> None:
        """The first field after a start without one: its azimuth is north."""
        field_n = self.R_bn @ field_b
        if not math.hypot(field_n[0], field_n[1]) > 1e-3 * np.linalg.norm(field_n):
            return
        from_north, variance = azimuth(field_n), self.P[HEADING, HEADING]
        if from_north**2 > variance or variance > 1:
            self.turn_heading(-from_north)
            self.P[HEADING, HEADING] += self.o.start_sigma_heading_rad**2
        self.put_reference(field_b)

    def turn_heading(self, angle: float) -> None:
        """With all that is kept in navigation axes."""
        about = about_down(angle)
        self.R_bn, self.velocity, self.field.candidate = (
            about @ self.R_bn,
            about[:2, :2] @ self.velocity,
            about @ self.field.candidate,
        )
        self.motion.velocity, self.motion.mean_force = (
            about[:2, :2] @ self.motion.velocity,
            about[:2, :2] @ self.motion.mean_force,
        )
        lasting = self.lasting
        lasting.before, lasting.velocity = about[:2, :2] @ lasting.before, lasting.velocity @ about[:2, :2].T
        lasting.lasting, lasting.force = lasting.lasting @ about[:2, :2].T, about @ lasting.force
        lasting.mean_force = about @ lasting.mean_force
        self.tilt_excess.corrected = about[:2, :2] @ self.tilt_excess.corrected
        vehicle = self.vehicle_tilt
        vehicle.tilt, vehicle.velocity = about[:2, :2] @ vehicle.tilt, about[:2, :2] @ vehicle.velocity

    # ----------------------------------------------------------------------------------------- covariance

    def transition(self) -> Array:
        """25 x 25, over the window."""
        Phi, half = ONE.copy(), 0.5 * G_M_S2 * self.force_s
        Phi[PHI, BIAS], Phi[PHI, CALIBRATION] = -self.G, -self.L
        # v_N -= g T theta_E and v_E += g T theta_N, with the mean of theta before and after.
        Phi[0] -= half * (ONE[16] + Phi[16])
        Phi[1] += half * (ONE[15] + Phi[15])
        if self.window_s > 0:
            Phi[V, FORCE_BIAS] -= self.force_s / self.window_s * self.G[:2]
        Phi[V, FORCE_LATENCY] -= self.swept_velocity
        return Phi

    def rotation_noise(self) -> float:
        o = self.o
        white = o.gyro_noise_rad_per_sqrt_s**2 * self.window_s + o.gyro_rate_noise_sqrt_s**2 * self.rate_power
        return float(white + self.gap_rotation)

    def propagated(self) -> Array:
        """P(T) = Phi P Phi' + Q; the declination is that of the place, and a body that moves comes to other places."""
        o, T, Phi, scale2 = self.o, self.window_s, self.transition(), self.field_noise.scale2
        P = Phi @ self.P @ Phi.T
        P[V, V] += ((o.gap_acceleration_m_s2 * self.force_gap_s) ** 2 + 0.002**2 * self.force_s) * EYE2
        P[PHI, PHI] += self.rotation_noise() * EYE
        P[BIAS, BIAS] += o.gyro_bias_walk_rad_s_per_sqrt_s**2 * T * EYE
        P[M, M] += o.reference_walk_per_sqrt_s**2 * scale2 * T * EYE2
        if not self.rest.at_rest():
            kept = math.exp(-T / o.local_declination_s)
            self.declination *= kept
            self.steps.response[DECLINATION] *= kept
            P[DECLINATION] *= kept
            P[:, DECLINATION] *= kept
            P[DECLINATION, DECLINATION] += (1 - kept**2) * (self.foreign2 + scale2 * o.local_declination_rad**2)
        return P

    # ----------------------------------------------------------------------------------------- corrections

    def correct(self, t_s: float, has_rate: bool, heading: tuple[float, float] | None, speed: tuple[float, float] | None) -> None:
        """All corrections of one instant; they enter the state together at the end."""
        self.gap_rotation += self.gap_variance(t_s, has_rate)
        self.steps.response = self.transition() @ self.steps.response
        self.E, self.error = self.propagated(), np.zeros(ERRORS)
        if self.force_s > 0 and self.lasting_density2 == 0 and not self.is_tilt_found():
            # The error of the start may exceed its sigma. What a bias of the accelerometer cancels is not seen by the corrections.
            self.E, _ = inflate(self.E, self.angle_to_force(), self.window_s, self.o)
        self.travel()
        rests = not self.lost and not self.speed.moves() and self.is_at_rest()
        if self.lost:
            self.find_attitude()
        elif self.force_s > 0:
            self.correct_by_force(rests)
        if not self.lost:
            if rests:
                self.correct_by_rest()
            if self.field_s > 0:
                self.correct_by_field()
            self.correct_by_aids(heading, speed)
            self.admit_steps()
        self.note_vehicle(rests)
        self.rested = rests
        self.apply(self.error)
        self.lasting.turn(self.velocity, self.error[15], self.error[16])
        self.P, self.corrected_s = self.E, t_s
        self.clear_window()

    def learn(
        self,
        H: Array,
        innovation: Array,
        noise: Array,
        considered: int = 0,
        is_evidence: bool = True,
        stepped: Array | None = None,
        withheld: float = 0.0,
    ) -> None:
        """Rows H of a sensor; errors before `considered` are not corrected (Schmidt): P is that of the gain actually used.

        is_evidence: for or against a step of the gyro bias; stepped: response of the rows to steps and iron, if not by H alone;
        withheld: share of the correction that the accelerometer's bias is not given."""
        PHt, stepped = self.E @ H.T, H @ self.steps.response if stepped is None else stepped
        solved = np.linalg.solve(H @ PHt + noise, np.column_stack([innovation, stepped, PHt.T]))
        by_innovation, by_step = solved[:, 0], solved[:, 1:7]
        self.error[considered:] += PHt[considered:] @ by_innovation
        self.error[FORCE_BIAS] -= withheld * PHt[FORCE_BIAS] @ by_innovation
        if is_evidence:
            self.steps.evidence.add(stepped, np.asarray(by_step, dtype=np.float64), innovation)
        self.steps.response[considered:] -= PHt[considered:] @ by_step
        self.steps.response[V.stop : PHI.start] = 0  # errors of sensors do not respond within a window
        change = PHt @ solved[:, 7:]
        change[:considered, :considered] = 0
        change[FORCE_BIAS, FORCE_BIAS] *= 1 - withheld**2
        self.E = self.E - 0.5 * (change + change.T)

    def new_steps(self) -> BiasSteps:
        return BiasSteps(ERRORS, BIAS, self.o.residual_iron, self.steps.response[:, 3:])

    def admit_steps(self) -> None:
        """A likely step of the gyro bias is added to the estimate, and to that of the errors its covariance and half of its square."""
        steps = self.steps
        if steps.look(self.window_s, self.rate_power, PHI):
            (mean, covariance), response = steps.found(), steps.response[:, :3]
            moved = response @ mean
            self.error += moved
            self.E = self.E + response @ covariance @ response.T + 0.5 * np.outer(moved, moved)
            self.steps = self.new_steps()
        elif steps.is_over():
            self.steps = self.new_steps()

    def correct_by_force(self, rests: bool) -> None:
        self.note_motion()
        if self.lasting_density2 > 0 and rests and not self.rested:
            self.forget_velocity(self.o.start_sigma_velocity_m_s**2 * EYE2)
        if not self.level_again() and (rests or not self.speed.is_fresh()):
            self.correct_by_velocity(rests)

    def correct_by_aids(self, heading: tuple[float, float] | None, speed: tuple[float, float] | None) -> None:
        if heading is not None:
            self.correct_by_heading(*heading)
        if speed is not None:
            self.correct_by_speed(*speed)

    def apply(self, error: Array) -> None:
        if self.speed.is_fresh():
            turned_n = exp(error[PHI]) @ np.append(self.velocity, self.speed.m_s * self.R_bn[2, 0])
            self.velocity = turned_n[:2]
        self.R_bn = exp(error[PHI]) @ self.R_bn
        self.bias, self.S = self.bias + error[BIAS], self.S + error[CALIBRATION].reshape(3, 3)
        self.velocity, self.force_bias = self.velocity + error[V], self.force_bias + error[FORCE_BIAS]
        self.force_latency = float(np.clip(self.force_latency + error[FORCE_LATENCY], -4, 4))
        self.declination = wrap(self.declination + error[DECLINATION])
        self.M = self.M + error[M]
        self.M[0] = max(0.0, self.M[0])
        self.latency = float(np.clip(self.latency + error[LATENCY], -1, 1))

    def note_motion(self) -> None:
        """Motion noise from the force; after a shock the velocity may have changed."""
        gathered = np.append(self.velocity - self.lasting.before, self.velocity_down)
        if np.linalg.norm(gathered) < 100 * self.force_s:
            self.lasting.note(gathered, self.explained_force2(), self.force_s)
            released2 = self.lasting.uncount()
            self.E[V, V] += (0.0 if self.speed.is_fresh() else released2) * EYE2
            return
        self.E[V, V] += float(gathered @ gathered) * EYE2
        self.velocity = self.lasting.before.copy()
        self.lasting.force, self.lasting.force_s = np.zeros(3), 0.0

    def angle_to_force(self) -> Array:
        """2 x ERRORS: the angle between the horizon and the mean force, about north and east, by the errors, rad."""
        L = np.eye(ERRORS)[PHI][:2]
        if self.window_s > 0:
            L[:, FORCE_BIAS] = np.array([-self.G[1], self.G[0]]) / (G_M_S2 * self.window_s)
        return L

    def explained_force2(self) -> float:
        """(m/s^2)^2, of the horizontal force of one axis by errors of the horizon and of the accelerometer's bias."""
        L = self.angle_to_force()
        return max(0.0, G_M_S2**2 * float(np.trace(L @ self.E @ L.T)) / 2)

    def level_again(self) -> bool:
        """Turns the horizon to the mean force if that is gravity and the horizon differs from it."""
        if not (self.o.lost_ratio > 0 and self.lasting.wrong_horizon(VERTICAL2.get(self.o.body, 0.0)) > self.o.lost_ratio):
            return False
        self.turn_up(self.lasting.force)
        self.forget_rotation(0.1**2, self.E[HEADING, HEADING] + 0.2**2)
        self.error, self.velocity = np.zeros(ERRORS), np.zeros(2)
        self.begin_motion()
        self.information, self.times_lost = np.zeros(2), self.times_lost + 1
        return True

    def correct_by_velocity(self, rests: bool) -> None:
        """0 = v + noise: the velocity of a body is bounded."""
        before = tilt_of(self.E).copy()
        lasting2 = max(self.lasting.density2(), 0.0 if rests else self.lasting_density2)
        H, noise = ONE[V], (self.motion.density2(rests) + lasting2) / self.force_s * EYE2
        S = self.E[V, V] + noise
        self.nis["accel"] = float(self.velocity @ np.linalg.solve(S, self.velocity))
        is_evidence = not (self.vehicle_tilt.P[0, 0] > 0 or self.o.body in ("car", "aircraft"))
        if is_evidence and lasting2 > self.swell_density2:
            self.note_hidden_step(S, (lasting2 - self.swell_density2) / self.force_s)
        self.turning_force.note(self.rate_power, self.window_s)
        withheld = self.turning_force.withheld(self.o.start_sigma_accel_bias_m_s2)
        self.learn(H, -self.velocity, noise, is_evidence=is_evidence, withheld=withheld)
        after = tilt_of(self.E)
        self.information[0] += max(0.0, 1 / max(after) - 1 / max(before))
        self.tilt_excess.note(self.error[15:17], float(np.mean(before - after)), self.force_s)
        self.judge_hold()

    def note_hidden_step(self, S: Array, hiding2: float) -> None:
        """Evidence of a step of the gyro bias that the noise of lasting velocities hides; hiding2: its variance in S."""
        stepped = self.steps.response[V]
        more = np.asarray(np.linalg.solve(S - hiding2 * EYE2, stepped) - np.linalg.solve(S, stepped), dtype=np.float64)
        self.steps.hidden.add(stepped, more, -self.velocity)

    def judge_hold(self) -> None:
        """A rate that acts one interval off looks like a latency of the force: the likelihood of the estimated latency."""
        if not (self.gyro.usual_s > 0 and self.accel.usual_s > 0):
            return
        prior, interval = self.o.start_sigma_accel_latency**2, self.gyro.usual_s / self.accel.usual_s
        learnt = max(0.0, prior - self.E[FORCE_LATENCY, FORCE_LATENCY]) / (2 * prior**2)
        off = (self.force_latency - self.o.start_accel_latency) * interval / prior
        self.wrong_hold = 1 / (1 + 0.97 / (0.03 * math.cosh(off) * math.exp(-(interval**2) * learnt)))

    def is_at_rest(self) -> bool:
        """Neither the field nor the bias contradicts the rest that rate and force indicate."""
        if not self.is_field_still() and self.lasting_density2 > 0:
            self.rest.still_s = 0.0
            return False
        if not self.rest.at_rest():
            return False
        self.rest.note_wander(self.window_s)
        from_bias = self.rest.mean_rate - self.bias
        if from_bias @ np.linalg.solve(self.E[BIAS, BIAS], from_bias) <= 16:
            return True
        if self.still_field.excludes_turn():  # the bias has stepped
            drifted = self.R_bn @ self.still_field.turn
            self.E[BIAS, BIAS] += np.diag(from_bias**2)
            self.E[PHI, PHI] += np.diag(drifted**2)
            self.still_field, self.steps = StillField(), self.new_steps()
            return True
        self.rest.still_s = 0.0  # the rate is a turn of the body
        return False

    def is_field_still(self) -> bool:
        if not self.rest.quiet_s > self.window_s:
            self.still_field = StillField()
        if not (self.rest.quiet_s > 0 and self.fields > 0):
            return True
        rate = self.rest.mean_rate - self.bias
        if self.still_field.note(self.R_bn.T @ self.field_sum / self.fields, rate, self.field_s):
            return True
        self.still_field = StillField()
        return False

    def is_vehicle_at_rest(self, rests: bool) -> bool:
        """The field has been constant in body axes for 2 s, and the force is vertical."""
        if not rests or not (self.still_field.still_s > 2 or math.isnan(self.mag.last_s)):
            return False
        return self.vehicle_tilt.is_level((self.R_bn @ self.rest.mean_force)[:2] / G_M_S2)

    def note_vehicle(self, rests: bool) -> None:
        if self.lost or not self.vehicle_tilt.P[0, 0] > 0:
            return
        rest_density2 = self.motion.density2(True) if self.is_vehicle_at_rest(rests) else 0.0
        turn2 = self.o.gyro_noise_rad_per_sqrt_s**2 * self.window_s + self.o.gyro_rate_noise_sqrt_s**2 * self.rate_power
        gathered = self.velocity - self.lasting.before
        self.vehicle_tilt.note(gathered, self.error[PHI][:2], self.rate_power, turn2, rest_density2, self.window_s)

    def forget_velocity(self, covariance: Array) -> None:
        """A vehicle that keeps its velocity is as quiet as a vehicle at rest: the velocity is that from here on."""
        self.velocity, self.error[V] = np.zeros(2), 0.0
        self.E[V], self.E[:, V], self.steps.response[V] = 0.0, 0.0, 0.0
        self.E[V, V] = covariance

    def travel(self) -> None:
        """The velocity along body x turns with the heading, so its error does with the drift of the gyroscope."""
        if not self.speed.is_fresh():
            return
        self.speed.left_s -= self.window_s
        if not self.speed.is_fresh():
            self.forget_velocity(self.o.start_sigma_velocity_m_s**2 * EYE2)
            return
        across, Phi = np.array([-self.velocity[1], self.velocity[0]]), ONE.copy()
        Phi[V, BIAS] = np.outer(across, self.G[2])
        self.E, self.steps.response = Phi @ self.E @ Phi.T, Phi @ self.steps.response
        noise = np.zeros(ERRORS)
        noise[V], noise[HEADING] = -across, 1
        Q = self.rotation_noise() * np.outer(noise, noise)
        Q[HEADING, HEADING] = 0.0  # it is in E
        self.E += Q

    def correct_by_speed(self, m_s: float, sigma_m_s: float) -> None:
        """v = speed x body x: in the error v_true = exp(theta) v + error a velocity in body axes has no row of the heading."""
        o, speed, ahead = self.o, self.speed, self.R_bn[:2, 0]
        begins, since_s = not speed.is_fresh(), o.max_speed_age_s - speed.left_s
        speed.m_s, speed.sigma_m_s, speed.left_s = m_s, max(1e-3, sigma_m_s), o.max_speed_age_s
        across = np.array([-ahead[1], ahead[0]])
        noise = speed.sigma_m_s**2 * EYE2 + (o.speed_slip_rad * m_s) ** 2 * np.outer(across, across)
        vehicle = self.vehicle_tilt
        if begins:
            self.forget_velocity(noise)
            self.velocity = m_s * ahead
            if vehicle.P[0, 0] > 0:  # a lasting acceleration may have tilted the horizon
                square = vehicle.square()
                self.E[PHI, PHI] += square * np.diag([1, 1, 0.0 if self.aided else (self.M[1] / self.M[0]) ** 2])
                self.E[M, M] += square * EYE2
        else:
            before = tilt_of(self.E).copy()
            innovation, S = m_s * ahead - self.velocity - self.error[V], self.E[V, V] + noise
            self.nis["speed"] = nis = float(innovation @ np.linalg.solve(S, innovation))
            if nis > 13.8 and self.tilt_ready():
                noise = noise + S * (nis / 13.8 - 1)
            self.learn(ONE[V], innovation, noise)
            after = tilt_of(self.E)
            self.information[0] += max(0.0, 1 / max(after) - 1 / max(before))
            self.tilt_excess.note(self.error[15:17], float(np.mean(before - after)), since_s)
        if vehicle.P[0, 0] > 0:
            vehicle.follow(max(tilt_of(self.E)), self.E[0, 0])

    def correct_by_rest(self) -> None:
        """Mean rate = b."""
        innovation = self.rest.mean_rate - self.bias - self.error[BIAS]
        self.lasting.settle(float(np.linalg.norm(self.rest.mean_force)), self.window_s)
        density2 = self.o.rest_bias_noise_rad_s_per_sqrt_hz**2 + max(self.rest.wander2, self.rest.wander_now2)
        self.learn(ONE[BIAS], innovation, density2 / self.window_s * EYE)

    def correct_by_heading(self, heading_rad: float, sigma_rad: float) -> None:
        """An aid measures the heading of body x, which is undefined when x points up or down."""
        x = self.R_bn[:, 0]
        across2 = x[0] ** 2 + x[1] ** 2
        if not across2 > 1e-4:
            return
        H = np.zeros((1, ERRORS))
        H[0, PHI] = -x[2] * x[0] / across2, -x[2] * x[1] / across2, 1
        innovation = wrap(heading_rad - azimuth(x)) - H @ self.error
        S, noise, before = float((H @ self.E @ H.T)[0, 0]) + sigma_rad**2, sigma_rad**2, self.E[HEADING, HEADING]
        self.nis["heading"] = nis = float(innovation[0] ** 2) / S
        if 0 < self.o.heading_gate_nis < nis and self.heading_ready():
            noise += S * (nis / self.o.heading_gate_nis - 1)
        self.learn(H, innovation, np.array([[noise]]), CONSIDERED)
        self.information[1] += max(0.0, 1 / self.E[HEADING, HEADING] - 1 / before)
        self.reference_variance, self.confirmed = 0.0, True

    # ----------------------------------------------------------------------------------------- the field

    def correct_by_field(self) -> None:
        """r = (H - h, -H (psi - d), Z - z) = theta x M - dM - (u x M) dl - (0, H, 0) dd: polar, exact for any error of heading."""
        T, turning = self.field_s, self.rate_power / (self.o.turning_rad_s**2 * self.window_s)
        mean = self.field_sum / self.fields
        self.field.weigh(mean, self.M, turning > 1, T)
        if self.of_place(intensities_of(self.field.candidate)) and self.field.candidate_wins():
            mean = self.change_reference(mean)
        (h, z), (horizontal, down) = intensities_of(mean), self.M
        residual = np.array([horizontal - h, -horizontal * wrap(azimuth(mean) - self.declination), down - z])
        deviation, noise = math.hypot(residual[0], residual[2]), self.field_variances()
        azimuth_away = self.azimuth_deviation(residual[1], noise[1])
        away = max(deviation, azimuth_away)
        H = self.field_rows()
        self.verdict = self.field.judge(away, T)
        if self.verdict == "begin inflating":
            self.contradicted_s = 60.0
            self.forget_reference(self.o.start_sigma_reference)
            self.error[M] = 0
        foreign = self.take_foreign_field(np.array([h, z]))
        if foreign:
            noise[[0, 2]] = 100.0**2
        self.note_contradiction(deviation / horizontal)
        away2 = (residual[1] / horizontal) ** 2
        variance = self.E[HEADING, HEADING]
        if 0.5**2 < away2 < 9 * variance:  # no measurement of the drift that the heading correlates with
            self.E[HEADING], self.E[:, HEADING] = 0, 0
            self.E[HEADING, HEADING] = max(variance, min(ANY_HEADING, variance + away2))
        innovation = residual - H @ self.error
        HPHt = H @ self.E @ H.T
        self.nis["mag"] = float(innovation @ np.linalg.solve(HPHt + np.diag(noise), innovation))
        self.confirm_heading(not foreign and azimuth_away > self.o.mag_gate)
        known2 = sum(max(0.0, HPHt[k, k] - self.E[i, i]) for k, i in ((0, 21), (2, 22)))
        self.learn_field(H, innovation, noise, away, foreign)
        still = self.rest.at_rest()
        if not foreign:
            self.learn_field_noise(np.array([h, z]), innovation[[0, 2]], known2, 0.0 if still else min(1.0, turning))

    def learn_field(self, H: Array, innovation: Array, noise: Array, away: float, foreign: bool) -> None:
        """As correction and as evidence. noise: variances; away: deviation, in units of the strength."""
        stepped, accepted = H @ self.steps.response, self.verdict == "accept"
        stepped[:, 3:] -= self.R_bn  # iron adds to the mean field
        shows_drift, before = bool(self.confirmed and not foreign and self.is_tilt_found()), self.E[HEADING, HEADING]
        if shows_drift and not accepted:
            self.steps.reject(stepped, H @ self.E @ H.T + np.diag(noise), innovation)
        if self.verdict != "reject":
            inflation = 1 if accepted else (away / self.o.mag_gate) ** 2
            self.learn(H, innovation, inflation * np.diag(noise), CONSIDERED, shows_drift and accepted, stepped)
            self.information[1] += 0 if foreign else max(0.0, 1 / self.E[HEADING, HEADING] - 1 / before)

    def of_place(self, intensities: Array) -> bool:
        """Whether strength and dip agree with the given ones. Without a given field: True."""
        (h, z), (north, down), o = intensities, self.M_given, self.o
        dip = math.atan2(north * z - down * h, north * h + down * z)
        near = abs(math.hypot(h, z) - 1) <= o.reference_strength_tolerance and abs(dip) <= o.reference_dip_tolerance_rad
        return not self.given or near

    def azimuth_variance(self, intensities: Array) -> float:
        """Variance of the azimuth of a field that differs from the given one, rad^2: the disturbance is as large across as in each intensity."""
        across2 = float(np.sum((intensities - self.M_given) ** 2)) / 2
        return min(ANY_HEADING, across2 / (float(intensities[0]) ** 2 + across2 / ANY_HEADING))

    def take_foreign_field(self, intensities: Array) -> bool:
        """Whether the field differs from the given one: its declination then has the variance of its azimuth, and changes from place to place."""
        if self.of_place(intensities):
            if self.foreign2 > 0:
                self.E[DECLINATION], self.E[:, DECLINATION] = 0, 0
                self.E[DECLINATION, DECLINATION] = self.field_noise.scale2 * self.o.local_declination_rad**2
                self.declination = self.foreign2 = self.error[DECLINATION] = 0.0
            return False
        variance, before = self.azimuth_variance(intensities), self.foreign2
        if self.field.candidate_age_s <= self.field_s:
            before = 0.0
        self.E[DECLINATION, DECLINATION] += max(0.0, variance - before)
        self.foreign2 = max(variance, before)
        return True

    def start_in_foreign_field(self, intensities: Array) -> None:
        """The heading of the start is wrong by the declination of that field."""
        if not self.of_place(intensities):
            self.foreign2 = self.azimuth_variance(intensities)
            for i, j in ((HEADING, HEADING), (DECLINATION, DECLINATION), (HEADING, DECLINATION), (DECLINATION, HEADING)):
                self.P[i, j] += self.foreign2

    def field_rows(self) -> Array:
        """3 x 25."""
        M_n = np.array([self.M[0], 0, self.M[1]])
        H = np.zeros((3, ERRORS))
        H[:, PHI], H[:, LATENCY] = -cross_matrix(M_n), -cross(self.turn_sum / self.fields, M_n)
        H[0, 21], H[2, 22], H[1, DECLINATION] = -1, -1, -self.M[0]
        return H

    def field_variances(self) -> Array:
        """3: of horizontal intensity, azimuth and vertical intensity of the mean field."""
        o, noise = self.o, self.field_noise
        density2 = (
            np.array([o.mag_intensity_noise_per_sqrt_hz, o.mag_azimuth_noise_per_sqrt_hz, o.mag_intensity_noise_per_sqrt_hz]) ** 2
        )
        factor = o.mag_rest_factor if self.rest.at_rest() else 1
        variances: Array = (density2 * noise.scale2 + noise.white2 * self.field_s) * factor / self.field_s
        return variances

    def azimuth_deviation(self, residual: float, noise: float) -> float:
        """While the heading is known, an azimuth far from it is evidence against the field, in units of the gate of the intensity."""
        o, variance = self.o, self.E[HEADING, HEADING]
        if not o.mag_azimuth_gate_sigmas > 0 or variance > o.ready_heading_rad**2:
            return 0.0
        return float(o.mag_gate * abs(residual) / (o.mag_azimuth_gate_sigmas * math.sqrt(self.M[0] ** 2 * variance + noise)))

    def change_reference(self, mean: Array) -> Array:
        """The candidate becomes the reference; heading and mean field turn by the share that is attributed to the heading."""
        field, distrust = self.field, self.field.distrust(self.E[HEADING, HEADING])
        unit = field.candidate_unit()
        self.strength, field.candidate, mean = self.strength * unit, field.candidate / unit, mean / unit
        self.M = intensities_of(field.candidate)
        self.forget_reference(self.o.mag_gate)
        if distrust > 0:
            angle = -distrust * azimuth(field.candidate)
            self.turn_heading(angle)
            turn = ONE.copy()
            turn[V, V] = turn[PHI.start : HEADING, PHI.start : HEADING] = about_down(angle)[:2, :2]
            self.E, self.steps.response = turn @ self.E @ turn.T, turn @ self.steps.response
            mean = about_down(angle) @ mean
            self.E[HEADING, HEADING] += distrust * self.o.turn_sigma_rad**2
            self.information[1], self.confirmed = 0.0, False
            field.heading_trust_s *= 1 - distrust
        field.take_candidate()
        self.undisturbed_s, self.contradicted_s = 0.0, 60.0
        return mean

    def forget_reference(self, sigma: float) -> None:
        self.E[M], self.E[:, M] = 0, 0
        self.E[M, M] = sigma**2 * EYE2

    def note_contradiction(self, apart_rad: float) -> None:
        """A field that contradicts a reference of a few seconds may be the true one; increases the output variance, and changes no gain."""
        T = self.field_s
        if self.verdict == "accept":
            lasted_s = min(self.contradicted_s, 10.0)
            self.reference_variance *= 1 - T / lasted_s if lasted_s > T else 0
            self.contradicted_s = max(0.0, self.contradicted_s - T)
        else:
            untrusted = max(0.0, 1 - self.field.heading_trust_s / 8)
            self.reference_variance = min(ANY_HEADING, self.reference_variance + untrusted * 2 * T * min(1.0, apart_rad) ** 2)
            self.contradicted_s += T

    def confirm_heading(self, azimuth_is_far: bool) -> None:
        """Whether no field has contradicted the reference for the required time, three times as long after an earlier change."""
        T = self.field_s
        self.azimuth_rejected_s = float(np.clip(self.azimuth_rejected_s + (T if azimuth_is_far else -T), 0, 10))
        self.undisturbed_s = self.undisturbed_s + T if self.verdict == "accept" else max(0.0, self.undisturbed_s - 3 * T)
        needed_s = self.o.ready_undisturbed_s * (3 if self.field.changes > 0 else 1)
        self.confirmed |= has_lasted(self.undisturbed_s, needed_s) and has_lasted(
            self.field.heading_trust_s, self.o.ready_evidence_s
        )

    def learn_field_noise(self, intensities: Array, innovations: Array, known2: float, turning: float) -> None:
        """A smaller noise of the place is evidence that its declination is small; a larger one removes evidence."""
        sigma2, before = self.o.local_declination_rad**2, self.field_noise.scale2
        self.field_noise.note(intensities, innovations, known2, turning, self.field_s)
        now = self.field_noise.scale2
        if now > before:
            self.E[DECLINATION, DECLINATION] += (now - before) * sigma2
        elif now < before:
            noise = np.array([[sigma2 * now * before / (before - now)]])
            small = np.array([-self.declination - self.error[DECLINATION]])
            self.learn(ONE[[DECLINATION]], small, noise, CONSIDERED, is_evidence=False)

    # ----------------------------------------------------------------------------------------- an attitude that is lost

    def lose_attitude(self, heading_sigma: float) -> None:
        """The attitude is lost by a gap in which the body may have turned to anywhere; the errors of the sensors stay."""
        self.forget_rotation(1.0, min(ANY_HEADING, self.E[HEADING, HEADING] + heading_sigma**2))
        self.error, self.velocity, self.level_force, self.level_s = np.zeros(ERRORS), np.zeros(2), np.zeros(3), 0.0
        self.begin_motion()
        self.information = np.zeros(2)
        self.times_lost += not self.lost
        self.lost = True

    def forget_rotation(self, tilt_variance: float, heading_variance: float) -> None:
        self.steps = self.new_steps()
        for rows in (V, PHI):
            self.E[rows], self.E[:, rows] = 0, 0
        self.E[V, V] = self.o.start_sigma_velocity_m_s**2 * EYE2
        self.E[PHI, PHI] = np.diag([tilt_variance, tilt_variance, heading_variance])

    def pass_gap(self, t_s: float) -> None:
        """The attitude is kept: the clock may have jumped without any rotation of the body."""
        self.E, self.error = self.P.copy(), np.zeros(ERRORS)
        walked = self.o.gyro_bias_walk_rad_s_per_sqrt_s**2 * (t_s - self.gyro.last_s)
        for i in range(18, 21):
            self.E[i, i] = max(self.E[i, i], min(self.o.start_sigma_bias_rad_s**2, self.E[i, i] + walked))
        self.lose_attitude(math.pi)
        self.P, self.corrected_s = self.E, t_s
        self.clear_window()
        for times in (self.gyro, self.accel, self.mag):
            times.last_s = times.last_s if math.isnan(times.last_s) else t_s

    def find_attitude(self) -> None:
        """Averages the force in navigation axes until it is gravity: that becomes the vertical, if it is far from the present one."""
        gathered = np.r_[self.velocity, self.velocity_down]
        self.velocity, self.level_force = np.zeros(2), self.level_force + gathered
        self.level_s += self.force_s
        violent = not np.linalg.norm(gathered) < 2 * G_M_S2 * self.force_s
        if not violent and is_within(self.level_s, 0.3):
            return
        up = self.level_force / self.level_s if self.level_s > 0 else np.zeros(3)
        self.level_force, self.level_s = np.zeros(3), 0.0
        if violent or not abs(np.linalg.norm(up) - G_M_S2) < 0.4 * G_M_S2:
            return
        if math.atan2(np.linalg.norm(cross(up, np.array([0, 0, -1.0]))), -up[2]) > 0.35:
            self.turn_up(up)
        self.forget_rotation(0.2**2, self.E[HEADING, HEADING])
        self.lost = False

    def turn_up(self, up: Array) -> None:
        """A direction in navigation axes becomes the vertical. The samples gathered since the last correction turn with it."""
        axis = cross(up, np.array([0, 0, -1.0]))
        angle = math.atan2(np.linalg.norm(axis), -up[2])
        axis = axis / np.linalg.norm(axis) if np.linalg.norm(axis) > 0 else np.array([1.0, 0, 0])
        turn = exp(axis * angle)
        self.R_bn, self.field_sum, self.turn_sum = turn @ self.R_bn, turn @ self.field_sum, turn @ self.turn_sum

    # ----------------------------------------------------------------------------------------- outputs

    @property
    def q_nb(self) -> Array:
        """4: scalar first."""
        R_bn = self.R_bn @ exp(self.turn_rate() * self.o.output_latency_s)
        return np.asarray(Rotation.from_matrix(R_bn).as_quat(canonical=True, scalar_first=True))

    def rotation_covariance(self) -> Array:
        """3 x 3, about the navigation axes, now: with the added variances of tilt and heading and of the rate's interval."""
        Phi = self.transition()[PHI]
        covariance: Array = Phi @ self.P @ Phi.T + self.rotation_noise() * EYE
        even = 0.5  # probability that an unknown body is a vehicle, and that a suspected step of the gyro bias has happened
        tilt = self.tilt_excess.variance + self.unstated_tilt2() + even * self.steps.suspected_tilt2
        tilt += even * max(0.0, self.vehicle_tilt.square() - max(tilt_of(self.P)))
        heading = self.steps.heading_variance_by_iron(HEADING) + self.all_reference_variance() + self.unstated_heading2()
        heading += even * (self.steps.suspected_heading2 + self.tilted_field_variance())
        covariance += np.diag([tilt, tilt, heading])
        by_hold = self.hold_error()
        return covariance + np.outer(by_hold, by_hold)

    def hold_error(self) -> Array:
        """rad, about the navigation axes: what a rate turns the attitude by in the time by which it may be early or late."""
        error: Array = self.R_bn @ self.turn_rate() * math.sqrt(self.wrong_hold + UNSTATED_INSTANT) * self.gyro.usual_s
        return error

    def all_reference_variance(self) -> float:
        """rad^2. The earth's field has 22 to 67 uT: of a reference beyond that a part of at least the difference is false."""
        variance, strength = self.reference_variance, self.strength * float(np.linalg.norm(self.M))
        false_part = max(20e-6 - strength, strength - 70e-6)
        if false_part > 0 and self.has_reference and self.o.reference_mode != "given" and not self.aided:
            variance += (false_part / (self.strength * self.M[0])) ** 2
        return min(ANY_HEADING, variance)

    def by_horizon(self, tilt2: float) -> float:
        """rad^2, of the heading by a field whose horizontal part is found with a horizon of this variance."""
        if self.aided or not self.has_reference:
            return 0.0
        return float(min(ANY_HEADING, tilt2 * (self.M[1] / self.M[0]) ** 2))

    def tilted_field_variance(self) -> float:
        """The same with the horizon of a vehicle."""
        return self.by_horizon(self.vehicle_tilt.square()) if self.vehicle_tilt.P[0, 0] > 0 else 0.0

    def unstated_tilt2(self) -> float:
        """rad^2, by an accelerometer that is worse than stated."""
        return min(ANY_HEADING, self.lasting.unstated_tilt2(self.o.start_sigma_accel_bias_m_s2**2))

    def unstated_heading2(self) -> float:
        """rad^2, of the heading by it."""
        return self.unstated_tilt2() + self.by_horizon(self.unstated_tilt2())

    def tilt_ready(self) -> bool:
        """A small sigma, also with the velocities of a vehicle, with as much information from samples, and no lasting acceleration."""
        added = self.tilt_excess.variance + self.unstated_tilt2() + max(self.hold_error()[:2] ** 2)
        limit = self.o.ready_tilt_rad
        small = self.is_tilt_within(added, limit) and max(self.vehicle_tilt.square(), self.steps.suspected_tilt2) < limit**2
        steady = self.speed.is_fresh() or not self.lasting.may_accelerate()
        return bool(small) and steady

    def is_tilt_found(self) -> bool:
        """Its covariance is no longer inflated."""
        return self.is_tilt_within(0.0, np.radians(2))

    def is_tilt_within(self, added: float, limit_rad: float) -> bool:
        """added: variance beside that of P, rad^2."""
        small = max(tilt_of(self.P)) + added < limit_rad**2
        return bool(small and self.information[0] > 1 / limit_rad**2)

    def heading_ready(self) -> bool:
        """The same, of a field that nothing has contradicted for long enough."""
        limit2, variance = self.o.ready_heading_rad**2, self.P[HEADING, HEADING] + self.all_reference_variance()
        variance += self.steps.heading_variance_by_iron(HEADING) + self.unstated_heading2() + self.tilted_field_variance()
        variance += self.hold_error()[2] ** 2
        earned = variance < limit2 and self.information[1] > 1 / limit2
        known = self.confirmed and not has_passed(self.azimuth_rejected_s, 2)
        return bool(known and earned and self.steps.suspected_heading2 < limit2)
