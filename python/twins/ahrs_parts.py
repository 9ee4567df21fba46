"""Separate parts of the AHRS in NumPy: the duration of a sample, the first attitude, rest, the noise of the
motion and of the place, and the choice of the reference field.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from hnav.certify.durations import has_lasted, has_passed, is_gap, is_within, usual_interval
from hnav.filters.options import Options
from hnav.native.arrays import Array
from twins.first_samples import G_M_S2, AgreeingSamples, triad
from twins.ins import rotation_of, turned

ANY_HEADING = math.pi**2 / 3
"""Variance of an unknown heading."""


def exp(phi: Array) -> Array:
    """3 x 3: the rotation by a rotation vector."""
    return turned(phi)[0]


def about_down(angle: float) -> Array:
    """3 x 3: the rotation that turns north towards east."""
    return exp(np.array([0, 0, angle]))


def wrap(angle: float) -> float:
    """Wraps an angle to half a turn on either side."""
    return math.remainder(angle, 2 * math.pi)


def azimuth(vector_n: Array) -> float:
    """Azimuth of a vector, from north to east."""
    return math.atan2(vector_n[1], vector_n[0])


def toward(mean: Array, value: Array, T: float, constant_s: float) -> Array:
    """Updates a running mean with this time constant by a sample of T seconds."""
    return mean + T / (constant_s + T) * (value - mean)


def intensities_of(field_n: Array) -> Array:
    """2: horizontal and vertical intensity."""
    return np.array([math.hypot(field_n[0], field_n[1]), field_n[2]])


def level(force_b: Array, heading_rad: float) -> Array:
    """3 x 3, body to navigation: tilt from the force, heading given."""
    up = force_b / np.linalg.norm(force_b)
    roll, pitch = math.atan2(-up[1], -up[2]), math.atan2(up[0], math.hypot(up[1], up[2]))
    R_bn: Array = about_down(heading_rad) @ exp(np.array([0, pitch, 0])) @ exp(np.array([roll, 0, 0]))
    return R_bn


class SampleTimes:
    """The duration that a sample of one sensor stands for, by the time stamps."""

    def __init__(self, max_interval_s: float):
        self.max_interval_s, self.last_s, self.usual_s = max_interval_s, math.nan, 0.0

    def is_gap(self, t_s: float) -> bool:
        return is_gap(t_s - self.last_s, self.usual_s)

    def interval(self, t_s: float) -> float:
        """The time since the last sample, or the usual time after a gap; the first sample stands for none."""
        since_s = t_s - self.last_s
        return min(self.usual_s if self.is_gap(t_s) else since_s, self.max_interval_s) if since_s > 0 else 0.0

    def note(self, t_s: float) -> None:
        self.usual_s = usual_interval(t_s - self.last_s, self.usual_s)
        self.last_s = t_s


class FirstSamples:
    """Gathers samples until an attitude follows from them."""

    def __init__(self, options: Options):
        self.o, self.samples, self.aid = options, AgreeingSamples(options.start_samples), (math.nan, math.nan)

    def add(
        self, t_s: float, rate: Array, force: Array | None, field: Array | None, heading: tuple[float, float] | None
    ) -> tuple[Array, float] | None:
        """An attitude, 3 x 3 from body to navigation, and the sigma of its heading; None: more samples are needed."""
        o, self.aid = self.o, heading or self.aid
        self.samples.add(t_s, rate, force, field)
        force, field = self.samples.means()
        if o.start_mode == "attitude":
            return rotation_of(o.start_q_nb), o.start_sigma_heading_rad
        if force is None:
            return None
        if o.start_mode == "heading":
            return level(force, o.start_heading_rad), o.start_sigma_heading_rad
        if not math.isnan(self.aid[0]):
            return level(force, self.aid[0]), self.aid[1]
        if field is None:
            return (
                (level(force, 0), math.sqrt(ANY_HEADING))
                if has_lasted(t_s - self.samples.first_s, o.start_field_wait_s)
                else None
            )
        R_bn = triad(force, field)
        if R_bn is None:
            self.samples.forget()  # parallel: wait for better ones
            return None
        return R_bn, o.start_sigma_heading_rad


class MotionNoise:
    """Density of the motion noise, of a velocity of zero: 1.1 times the root mean square of the motion."""

    def __init__(self, max_density: float):
        self.max2, self.mean_force, self.velocity = max_density**2, np.zeros(2), np.zeros(2)
        self.power = self.max2 / 1.1**2

    def now(self) -> float:
        return float(self.velocity @ self.velocity) / 2

    def note(self, force_n: Array, T: float) -> None:
        self.mean_force = toward(self.mean_force, force_n[:2], T, 3.0)
        self.velocity = self.velocity + T * (force_n[:2] - self.mean_force) - T / (1 + T) * self.velocity
        self.power += T / (10 + T) * (self.now() - self.power)

    def density2(self, at_rest: bool) -> float:
        return min(self.max2, max((0.02 if at_rest else 0.05) ** 2, 1.1**2 * max(self.power, self.now())))


class FieldNoise:
    """The share of the field variation of a usual room that is present, from the intensities, which do not depend on the heading."""

    ROOM, AT_FIRST = 0.012, 0.006

    def __init__(self) -> None:
        self.last: Array | None = None
        self.slow, self.slow2, self.white2 = np.zeros(2), self.AT_FIRST**2, 0.0
        self.scale2 = self.slow2 / self.ROOM**2

    def note(self, intensities: Array, innovations: Array, known2: float, turning: float, T: float) -> None:
        """known2: variance that tilt and latency explain. turning: the share of the time for which the body turned."""
        if self.last is not None:
            step = intensities - self.last
            self.white2 += T / (5 + T) * (min(float(step @ step) / 4, 0.05**2) - self.white2)
        self.last = intensities
        self.slow = toward(self.slow, np.clip(innovations, -0.05, 0.05), T, 1.0)
        now2 = max(0.0, float(self.slow @ self.slow) / 2 - known2)
        weighted_s = T * (3 if now2 > self.slow2 else turning)
        self.slow2 += weighted_s / (20 + weighted_s) * (now2 - self.slow2)
        self.scale2 = float(np.clip((self.slow2 - self.white2 * T / 2) / self.ROOM**2, 0.01, 1))


class RestDetector:
    """Rest is a rate and a force that stay near their running means for a while, at a mean rate that can be a bias."""

    def __init__(self, options: Options, force: Array):
        self.o, self.mean_rate, self.mean_force = options, np.zeros(3), force
        self.quiet_s, self.still_s, self.force_still = 0.0, 0.0, False
        self.slow_rate, self.wander2, self.wander_now2 = np.zeros(3), 0.0, 0.0

    def note_rate(self, rate: Array, T: float) -> None:
        o = self.o
        self.mean_rate = toward(self.mean_rate, rate, T, o.rest_filter_s)
        near = np.linalg.norm(rate - self.mean_rate) <= o.rest_rate_rad_s and self.force_still
        quiet = near and np.max(abs(self.mean_rate)) <= o.rest_mean_rate_rad_s
        self.quiet_s = self.quiet_s + T if quiet else 0.0
        self.still_s = self.still_s + T if quiet else 0.0

    def note_force(self, force: Array, T: float) -> None:
        self.mean_force = toward(self.mean_force, force, T, self.o.rest_filter_s)
        self.force_still = bool(np.linalg.norm(force - self.mean_force) <= self.o.rest_force_m_s2)

    def at_rest(self) -> bool:
        return has_passed(self.still_s, self.o.rest_duration_s)

    def note_wander(self, T: float) -> None:
        """Difference of the mean rate from its own slow mean: a turn of the body, not the bias."""
        away = self.mean_rate - self.slow_rate
        self.slow_rate = toward(self.slow_rate, self.mean_rate, T, 4.0)
        self.wander_now2 = float(away @ away) / 3
        self.wander2 += T / (4 + T) * (self.wander_now2 - self.wander2)


class StillField:
    """Whether the field is constant in body axes: a vehicle in a smooth bend is as quiet as one at rest."""

    def __init__(self) -> None:
        self.first, self.mean, self.turn = np.zeros(3), np.zeros(3), np.zeros(3)
        self.noise2, self.limit2, self.still_s = 0.0, 0.0, 0.0

    def note(self, field_b: Array, rate: Array, T: float) -> bool:
        """field_b, rate: means over T, body axes."""
        if not self.still_s > 0:
            self.mean = field_b
        self.still_s += T
        away = field_b - self.mean
        self.mean = toward(self.mean, field_b, T, min(self.still_s, 0.5))
        self.noise2 += T / (2 + T) * (float(away @ away) / 3 - self.noise2)
        if self.still_s <= 0.5:
            self.first = self.mean
        else:
            self.turn = self.turn + T * rate
        turned = self.mean - self.first
        self.limit2 = 0.004**2 + 16 * self.noise2 * T / 0.5
        return bool(turned @ turned <= self.limit2)

    def excludes_turn(self) -> bool:
        """Whether the turn that the gyroscope shows would have changed the field clearly."""
        shown = np.cross(self.turn, self.mean)
        return bool(shown @ shown > 3**2 * self.limit2)


LASTING_DENSITY2 = {
    body: 2 * speed_m_s**2 * duration_s
    for body, speed_m_s, duration_s in (
        ("walker", 1.2, 10), ("car", 12, 10), ("ship", 1, 10), ("quadrotor", 2, 5), ("aircraft", 30, 10),
    )
}  # fmt: skip
"""2 sigma^2 tau of a velocity that changes by sigma and stays for tau, (m/s)^2/Hz."""
VERTICAL2 = {"quadrotor": 4.0}
"""(m/s)^2, mean square of a vertical velocity, at least."""


class LastingMotion:
    """Lasting velocities: the integral of the force over some seconds beyond what the tilt of the horizon explains."""

    SCALES_S = (2.0, 5.0, 12.5)

    def __init__(self, power2: float):
        self.power = np.array([power2, 0, 0])
        self.now, self.velocity, self.lasting = np.zeros(3), np.zeros((3, 2)), np.zeros((3, 2))
        self.before, self.down, self.down2 = np.zeros(2), 0.0, power2
        self.down_mean, self.down_noted_s = 0.0, 0.0
        self.mean_force, self.mean_share, self.rest_force = np.zeros(3), 0.0, 0.0
        self.force, self.force_s = np.zeros(3), 0.0
        self.counted2 = 0.0

    def note(self, gathered: Array, force2: float, T: float) -> None:
        """Force times time in navigation axes over T, force2: variance of the horizontal force by errors of horizon and bias."""
        for j, W in enumerate(self.SCALES_S):
            self.velocity[j] += gathered[:2] - T / (W + T) * self.velocity[j]
            self.lasting[j] += T / (0.5 * W + T) * (self.velocity[j] - self.lasting[j])
            self.now[j] = max(0.0, float(self.lasting[j] @ self.lasting[j]) / 2 - 7.5 * force2 * W**2)
            self.power[j] += T / (max(5.0, W) + T) * (self.now[j] - self.power[j])
        self.down += gathered[2] + G_M_S2 * T - T / (2 + T) * self.down
        self.down2 += T / (30 + T) * (self.down**2 - self.down2)
        self.down_noted_s = min(30.0, self.down_noted_s + T)
        self.down_mean += T / self.down_noted_s * (self.down - self.down_mean)
        share = T / (5 + T)
        self.mean_share += share * (1 - self.mean_share)
        self.mean_force = self.mean_force + share * (gathered / T - self.mean_force)
        self.force, self.force_s = self.force + gathered, self.force_s + T

    def settle(self, force: float, T: float) -> None:
        """At rest the lasting velocity is zero; force: its length now."""
        self.rest_force += (T / (5.0 + T) if self.rest_force > 0 else 1.0) * (force - self.rest_force)
        self.power, self.counted2 = self.power * math.exp(-T / 0.5), 0.0

    def uncount(self) -> float:
        """Square of the velocity that no longer counts as noise, which has not ended for that."""
        counted2 = float(max(np.max(self.power), np.max(self.now)))
        released2, self.counted2 = max(0.0, self.counted2 - counted2), counted2
        return released2

    def vertical_error2(self) -> float:
        """(m/s^2)^2, of the accelerometer: by the length of the force at the last rest, and by the mean of the vertical velocity."""
        by_rest, mean2 = self.rest_force - G_M_S2 if self.rest_force > 0 else 0.0, self.down_mean**2
        left2 = max(0.0, self.down2 - mean2) * 4 / self.down_noted_s if self.down_noted_s > 0 else mean2
        return max(by_rest**2, (mean2 - 4 * left2) / 4)

    def unstated_tilt2(self, stated2: float) -> float:
        """rad^2, of the horizon by an accelerometer that is worse than stated; stated2: variance of its bias, (m/s^2)^2."""
        return max(0.0, self.vertical_error2() - 4 * (stated2 + 0.02**2)) / G_M_S2**2

    def may_accelerate(self) -> bool:
        """The length of the mean force differs from that at rest, or from gravity before any rest."""
        if not self.mean_share > 0:
            return False
        expected = self.rest_force if self.rest_force > 0 else G_M_S2
        return bool(abs(np.linalg.norm(self.mean_force) / self.mean_share - expected) > 0.4)

    def density2(self) -> float:
        return float(np.max(2 * np.array(self.SCALES_S) * np.maximum(self.power, self.now)))

    def wrong_horizon(self, least_vertical2: float) -> float:
        """Logarithm of the ratio of likelihoods that the horizon is wrong and that the body accelerates.

        least_vertical2: mean square of the vertical velocity, at least, (m/s)^2.
        """
        if not has_lasted(self.force_s, 3):
            return 0.0
        f = self.force / self.force_s
        by_down, by_length = f[2] + G_M_S2, float(np.linalg.norm(f)) - G_M_S2
        # What goes far may climb by one part in seven.
        vertical2 = max(self.down2 + 0.01 + 0.02 * float(max(self.power[1], self.now[1])), least_vertical2)
        variance = vertical2 / self.force_s**2 + 0.0025
        ratio = float(by_down**2 - by_length**2) / (2 * variance)
        if ratio > 0.5 and not has_passed(self.force_s, 20) and by_length**2 < 9 * variance:
            return ratio
        self.force, self.force_s = np.zeros(3), 0.0
        return 0.0

    def turn(self, velocity: Array, north_rad: float, east_rad: float) -> None:
        """After the horizon was turned about north and east: corrects the integral of the force."""
        self.before = velocity.copy()
        for j, W in enumerate(self.SCALES_S):
            change = G_M_S2 * W * np.array([-east_rad, north_rad])
            self.velocity[j] += change
            self.lasting[j] += change


class TurningForce:
    """The force towards the axis about which a hand turns looks like a bias of the accelerometer."""

    def __init__(self) -> None:
        self.rate2, self.noted_s = 0.0, 0.0

    def note(self, rate_power: float, T: float) -> None:
        """rate_power: integral of the squared rate over T, rad^2/s."""
        if not T > 0:  # a second correction at one instant
            return
        self.noted_s = min(1.0, self.noted_s + T)
        self.rate2 += (rate_power - T * self.rate2) / self.noted_s

    def withheld(self, sigma: float) -> float:
        """Share of a correction that a bias with this sigma, m/s^2, is not given: the axis is 0.1 m away."""
        force2 = (0.1 * self.rate2) ** 2
        return force2 / (force2 + sigma**2)


class TiltExcess:
    """Corrections of the tilt that are not white: the excess of the square of their fading sum over its variance."""

    MEMORY_S = 12.5

    def __init__(self) -> None:
        self.corrected, self.expected, self.variance = np.zeros(2), 0.0, 0.0

    def note(self, correction: Array, taken: float, T: float) -> None:
        """correction: about north and east; taken: out of the variance of one axis."""
        kept = self.MEMORY_S / (self.MEMORY_S + T)
        self.corrected = kept * self.corrected + correction
        self.expected = kept**2 * self.expected + max(0.0, taken)
        self.variance = max(kept * self.variance, float(self.corrected @ self.corrected) / 2 - self.expected)


@dataclass
class StepEvidence:
    """Of steps of the gyro bias, 3, and iron in body axes, 3."""

    information: Array = field(default_factory=lambda: np.zeros((6, 6)))
    total: Array = field(default_factory=lambda: np.zeros(6))
    excess: float = 0.0

    def add(self, stepped: Array, weighted: Array, innovation: Array) -> None:
        """Of rows: weighted by the inverse of their covariance."""
        self.information = self.information + stepped.T @ weighted
        self.total = self.total + weighted.T @ innovation

    def __add__(self, more: StepEvidence) -> StepEvidence:
        return StepEvidence(self.information + more.information, self.total + more.total, self.excess + more.excess)


class BiasSteps:
    """Whether the gyro bias has stepped at the begin of a window: likelihood ratio of the innovations (c_src/attitude/ahrs/bias_steps.hpp)."""

    STEP_RAD_S, SHARE, LIMIT, LASTS_S, LOOK_S, WINDOW_S = 0.01, 5e-4, 40.0, 3.0, 0.25, 20.0
    POSSIBLE, SUSPECTED_LIMIT, LEAST_TILT_RAD, LEAST_HEADING_RAD, OUTLIER_NIS = 24.0, 100.0, 0.0175, 0.04, 0.1

    def __init__(self, errors: int, bias: slice, iron_sigma: float, iron: Array | None = None):
        self.iron_sigma = iron_sigma
        self.response = np.zeros((errors, 6))
        """Of the error to unit steps, and to unit iron since the start of the attitude."""
        self.response[bias, :3] = np.eye(3)
        if iron is not None:
            self.response[:, 3:] = iron
        self.evidence, self.rejected, self.hidden = StepEvidence(), StepEvidence(), StepEvidence()
        self.since_s = self.rate_power = self.unseen_s = self.likely_s = 0.0
        self.suspected_tilt2 = self.suspected_heading2 = 0.0

    def reject(self, stepped: Array, S: Array, innovation: Array) -> None:
        """A rejected field with the innovation covariance S."""
        self.rejected.add(stepped, np.asarray(np.linalg.solve(S, stepped), dtype=np.float64), innovation)
        self.rejected.excess += float(innovation @ np.linalg.solve(S, innovation)) - self.OUTLIER_NIS

    def heading_variance_by_iron(self, heading: int) -> float:
        """Iron is a consider state: it corrects nothing. heading: its row."""
        return self.iron_sigma**2 * float(np.sum(self.response[heading, 3:] ** 2))

    def unmodelled2(self) -> float:
        """Variance of errors that are proportional to the rate, and no step."""
        return self.SHARE**2 * self.rate_power / self.since_s + 1e-10

    def with_step(self, of: StepEvidence, step2: float | None = None) -> tuple[Array, Array, float]:
        """Step and iron, 6, their covariance, and twice the logarithm of the likelihood ratio. step2: variance of a step."""
        step2 = self.STEP_RAD_S**2 + self.unmodelled2() if step2 is None else step2
        prior2 = np.repeat([step2, self.iron_sigma**2], 3)
        posterior = of.information + np.diag(1 / prior2)
        covariance = np.asarray(np.linalg.inv(posterior), dtype=np.float64)
        mean = covariance @ of.total
        return mean, covariance, float(of.total @ mean - math.log(np.linalg.det(posterior) * np.prod(prior2)) - of.excess)

    def twice_log_ratio(self, of: StepEvidence) -> float:
        """Of the likelihoods with and without a step."""
        return self.with_step(of)[2] - self.with_step(of, self.unmodelled2())[2]

    def look(self, T: float, power: float, rotation: slice) -> bool:
        """T seconds later. rotation: rows of the response. True: a step has been likely for long enough."""
        self.since_s, self.rate_power, self.unseen_s = self.since_s + T, self.rate_power + power, self.unseen_s + T
        if is_within(self.unseen_s, self.LOOK_S):
            return False
        everything = self.evidence + self.rejected
        if self.with_step(everything)[2] > self.with_step(self.evidence)[2]:
            self.evidence, self.rejected = everything, StepEvidence()
        ratio = self.twice_log_ratio(self.evidence)
        self.likely_s = self.likely_s + self.unseen_s if ratio > self.LIMIT else 0.0
        self.unseen_s = self.suspected_tilt2 = self.suspected_heading2 = 0.0
        both = self.evidence + self.hidden
        hides = self.hidden.information[0, 0] > 0 and self.twice_log_ratio(both) > self.SUSPECTED_LIMIT
        if hides or ratio > self.POSSIBLE:
            turn2 = (self.response[rotation, :3] @ self.with_step(both)[0][:3]) ** 2
            tilt2, heading2 = float(turn2[0] + turn2[1]), float(turn2[2])
            self.suspected_tilt2 = tilt2 if tilt2 > self.LEAST_TILT_RAD**2 else 0.0
            self.suspected_heading2 = heading2 if heading2 > self.LEAST_HEADING_RAD**2 else 0.0
        return has_lasted(self.likely_s, self.LASTS_S)

    def is_over(self) -> bool:
        return (
            has_lasted(self.since_s, self.WINDOW_S)
            and not self.likely_s > 0
            and not self.suspected_tilt2 + self.suspected_heading2 > 0
        )

    def found(self) -> tuple[Array, Array]:
        """The step, 3, and its covariance, 3 x 3."""
        mean, covariance, _ = self.with_step(self.evidence)
        return mean[:3], covariance[:3, :3]


class VehicleTilt:
    """The tilt if the body were a vehicle, for readiness and stated variances: covariance of one axis, and its horizon relative to that
    of the filter."""

    def __init__(self, vehicle: bool) -> None:
        self.P = np.array([[0.065, 0.0], [0.0, 400.0]]) * vehicle  # of tilt and velocity; 0: no vehicle, it turned faster
        self.tilt, self.velocity = np.zeros(2), np.zeros(2)  # tilt: by what it adds to the velocity
        self.rate2, self.stood = 0.0, False

    def square(self) -> float:
        return float(self.P[0, 0] + self.tilt @ self.tilt)

    def follow(self, tilt2: float, velocity2: float) -> None:
        """While a speed is given, the horizon of the filter is that of a vehicle."""
        self.P, self.stood = np.diag([tilt2, velocity2]), False
        self.tilt, self.velocity = np.zeros(2), np.zeros(2)

    def is_level(self, level: Array) -> bool:
        """Of a force at rest: its horizontal part in units of gravity."""
        away = level + self.tilt
        return bool(away @ away < 9 * (self.P[0, 0] + 1e-4))

    def note(self, gathered: Array, correction: Array, turned2: float, turn2: float, rest_density2: float, T: float) -> None:
        """correction: of the filter about north and east; turned2: integral of the squared rate over T; turn2: variance of the rotation by
        noise; rest_density2: of the velocity at rest, 0 in motion."""
        self.rate2 += (turned2 - self.rate2 * T) / (2 + T)
        if self.rate2 > 0.5**2:
            self.P[:] = 0.0
            self.tilt[:] = 0.0
            return
        stands = rest_density2 > 0
        if stands and not self.stood:
            self.velocity[:] = 0.0
            self.P = np.diag([self.P[0, 0], 0.01])
        self.stood = stands
        self.velocity += gathered + G_M_S2 * T * self.tilt
        self.tilt += (correction[1], -correction[0])
        flow = np.array([[1.0, 0.0], [G_M_S2 * T, 1.0]])
        P = flow @ self.P @ flow.T + np.diag([turn2, 0.0])
        gain = P[1] / (P[1, 1] + (rest_density2 if stands else LASTING_DENSITY2["car"]) / T)
        self.P = P - np.outer(gain, P[1])
        self.tilt -= gain[0] * self.velocity
        self.velocity -= gain[1] * self.velocity


class GivenSpeed:
    """A speed along body x, and for how long it still holds."""

    def __init__(self) -> None:
        self.m_s = self.sigma_m_s = self.left_s = 0.0

    def is_fresh(self) -> bool:
        return self.left_s > 0

    def moves(self) -> bool:
        """A body at rest has no such speed."""
        return self.is_fresh() and abs(self.m_s) > 3 * self.sigma_m_s + 0.2


class MagneticReference:
    """Choice of the reference field: a gate on the two intensities, and evidence for and against the reference, in seconds."""

    def __init__(self, options: Options):
        self.o, self.candidate = options, np.zeros(3)
        self.served_s = self.rejected_s = self.evidence_s = self.heading_trust_s = 0.0
        self.candidate_evidence_s = self.candidate_age_s = 0.0
        self.inflating, self.changes = False, 0

    def weigh(self, field_n: Array, reference: Array, turning: bool, T: float) -> None:
        """A second counts fully while the body turns, since a magnet that moves with it is then visible."""
        o, seen_s = self.o, T * (1 if turning else self.o.still_weight)
        if np.linalg.norm(intensities_of(field_n) - reference) < o.mag_gate:
            self.evidence_s += seen_s
            self.heading_trust_s += seen_s
        away = np.linalg.norm(intensities_of(field_n) - intensities_of(self.candidate))
        if self.candidate_age_s > 0 and away < o.candidate_radius * self.candidate_unit():
            self.candidate_evidence_s += seen_s
            self.candidate_age_s += T
            weight = max(T / o.candidate_mean_s, T / self.candidate_age_s)
            self.candidate = self.candidate + weight * (field_n - self.candidate)
        else:
            self.candidate, self.candidate_evidence_s, self.candidate_age_s = field_n, 0.0, T
        if np.linalg.norm(intensities_of(self.candidate) - reference) <= o.mag_gate:
            self.candidate_evidence_s = 0.0  # it agrees with the reference: no alternative

    def candidate_unit(self) -> float:
        """A reference learnt inside a shield or beside a magnet has the wrong strength as its unit: then the strength of the candidate."""
        strength = float(np.linalg.norm(self.candidate))
        return strength if strength >= 4 or 0 < strength <= 0.25 else 1.0

    def candidate_wins(self) -> bool:
        return bool(
            has_passed(self.candidate_evidence_s, max(self.o.candidate_first_s, self.o.candidate_share * self.evidence_s))
        )

    def distrust(self, heading_variance: float) -> float:
        """Share of the candidate's azimuth that is attributed to the heading when the candidate becomes the reference."""
        angle = abs(azimuth(self.candidate))
        small = angle <= self.o.turn_sigmas * math.sqrt(heading_variance) or angle <= self.o.turn_min_rad
        return 0.0 if small else 1 - min(1.0, self.heading_trust_s / self.o.trust_s)

    def take_candidate(self) -> None:
        self.evidence_s, self.served_s, self.rejected_s, self.inflating = self.candidate_evidence_s, 0.0, 0.0, False
        self.changes += 1

    def judge(self, deviation: float, T: float) -> str:
        """The gate: a field far from the reference is rejected for a limited time, then used with more noise."""
        if deviation <= self.o.mag_gate:
            self.inflating, self.rejected_s, self.served_s = False, max(0.0, self.rejected_s - T), self.served_s + T
            return "accept"
        if is_within(self.rejected_s, min(self.o.mag_gate_max_s, self.o.mag_gate_share * self.served_s)):
            self.rejected_s += T
            return "reject"
        if self.inflating:
            return "inflate"
        self.inflating, self.served_s, self.rejected_s = True, 0.0, 0.0
        return "begin inflating"
