"""The linear errors of the INS over the windows of a run, for InsRun.observability()."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from hnav import earth
from hnav.errors import HnavValueError
from hnav.filters.ins_aids import AIDS, WIDTHS, Aids
from hnav.filters.ins_answers import InsRun, InsSamples
from hnav.filters.observability import RunObservability, Windows, run_observability
from hnav.filters.options import CAR_ACROSS_M_S, Options
from hnav.filters.run_windows import ANGLES, G_M_S2, UNKNOWN_HEADING_RAD, UNKNOWN_TILT_RAD, RowWindows, cross
from hnav.native.arrays import Array
from hnav.native.library import SENSORS
from hnav.rotations import quaternion_exp, quaternion_product, rotated, rotation_error_rad

MEAN_S = 1.0  # an acceleration is averaged over this time, as in the filter for a vibrating sensor
RESTS_PER_S = 10.0  # rate at which rest measures a velocity
PASCAL_PER_M = 12.0  # decrease of the air pressure with height
# Places of the errors.
ROTATION, GYRO, ACCEL, VELOCITY, POSITION = (slice(i, i + 3) for i in (0, 3, 6, 9, 12))
IRON, DIRECTION = slice(15, 18), 18
N = 19
ACCEL_BIASES = tuple(f"accelerometer bias {axis}" for axis in "xyz")


@dataclass(frozen=True)
class Motion:
    """Motion that the flow of the errors depends on; axes as in RowWindows."""

    rows: RowWindows
    """Attitude and windows."""
    velocity: Array
    """m x 3, m/s, at the ends of the windows."""
    force: Array
    """m x 3, m/s2: mean specific force of each window."""
    earth: Array
    """3, rad/s: rate of the Earth."""

    @classmethod
    def of(cls, run: InsRun, samples: InsSamples, options: Options) -> Motion:
        """The motion of a run and its samples."""
        rate, force = (_by_row(values, len(run.t_s), options) for values in (samples.rate_b_rad_s, samples.force_b_m_s2))
        rows = RowWindows.of(run.t_s, _without_jumps(run, rate - run.gyro_bias_rad_s))
        latest = run.accel_bias_m_s2[rows.rows[-1]]
        force_n = np.einsum("kij,kj->ki", rows.matrix, np.nan_to_num(force[rows.rows] - latest))
        mean = rows.summed(force_n * rows.steps_s[:, None]) / rows.length_s[:, None]
        # Noise and an error of the tilt look like a small acceleration.
        count = max(1, min(len(mean), round(MEAN_S / float(np.median(rows.length_s)))))
        smooth = np.stack([np.convolve(axis, np.full(count, 1 / count), "same") for axis in mean.T[:2]])
        horizontal = np.hypot(*smooth) > G_M_S2 * options.ready_tilt_rad
        velocity = np.stack([rows.forward(v) for v in run.velocity_n_m_s[rows.rows[rows.begins[1:] - 1]]])
        latitude = run.place[rows.rows[-1], 0]
        rate_n = rows.forward(earth.RATE_RAD_S * np.array([math.cos(latitude), 0.0, -math.sin(latitude)]))
        return cls(rows, velocity, mean * np.stack([horizontal, horizontal, np.ones_like(horizontal)], axis=1), rate_n)

    def held(self) -> Motion:
        """The same with the body held as at the start, at a steady velocity."""
        steady = np.broadcast_to(self.velocity[0], self.velocity.shape)
        return replace(self, rows=self.rows.held(), velocity=steady, force=np.broadcast_to([0.0, 0.0, -G_M_S2], self.force.shape))


def ins_observability(run: InsRun) -> RunObservability:
    """Raises HnavValueError for a run without an attitude, or without its samples."""
    if run.samples is None:
        raise HnavValueError("no data", "the run does not hold its samples: take that of Ins.run or Ins.smooth", "samples")
    options = run.options or Options("ins")
    motion = Motion.of(run, run.samples, options)
    moving, held = (_windows(moved, run, run.samples.aids, options) for moved in (motion, motion.held()))
    return run_observability(moving, held, (*ANGLES, *motion.rows.gyro_biases(), *ACCEL_BIASES), motion.rows.turned_rad)


def _by_row(values_s: Array, rows: int, options: Options) -> Array:
    """rows x 3: means of the samples of each row of the run, in body axes."""
    every = max(1, len(values_s) // max(1, rows))
    mean = np.nanmean(values_s[: rows * every].reshape(rows, every, 3), axis=1)
    return rotated(np.broadcast_to(options.q_body_sensor, (rows, 4)), mean)


def _without_jumps(run: InsRun, rate: Array) -> Array:
    """n x 4: the attitude, turned about the vertical so that the heading follows the gyroscopes until it is found."""
    q = run.q_nb.copy()
    known = np.flatnonzero(np.isfinite(q).all(axis=1) & np.isfinite(rate).all(axis=1))
    if len(known) < 2:
        return q
    found = np.flatnonzero(run.ready[known, 1])
    half = 0.5 * rate[known[1:]] * np.diff(run.t_s[known])[:, None]
    expected = quaternion_product(q[known[:-1]], quaternion_exp(half))
    jumps = rotation_error_rad(expected, q[known[1:]])[:, 2]
    jumps[found[0] if len(found) else len(jumps) :] = 0.0
    angle = np.append(np.cumsum(jumps[::-1])[::-1], 0.0)
    turn = np.stack([np.cos(0.5 * angle), 0 * angle, 0 * angle, np.sin(0.5 * angle)], axis=1)
    q[known] = quaternion_product(turn, q[known])
    return q


def _sigmas(options: Options) -> Array:
    """Standard deviations of the errors before any sample."""
    given = options.start == "state"
    tilt = options.start_sigma_tilt_rad if given else UNKNOWN_TILT_RAD
    heading = options.start_sigma_heading_rad if given else UNKNOWN_HEADING_RAD
    biases = np.repeat([options.start_sigma_gyro_bias_rad_s, options.start_sigma_accel_bias_m_s2], 3)
    others = np.repeat([options.start_sigma_velocity_m_s, options.start_sigma_position_m, options.start_sigma_iron], 3)
    return np.concatenate([[tilt, tilt, heading], biases, others, [options.field_direction_rad]])


def _windows(motion: Motion, run: InsRun, aids: Aids, options: Options) -> Windows:
    rows, sigma = motion.rows, _sigmas(options)
    m, T = len(rows.t_s), rows.length_s[:, None, None]
    Phi = np.broadcast_to(np.eye(N), (m, N, N)).copy()
    F = np.stack([cross(f) for f in motion.force])
    Phi[:, ROTATION, ROTATION] -= T * cross(motion.earth)
    Phi[:, ROTATION, GYRO] = -rows.turn
    Phi[:, VELOCITY, ROTATION] = -T * F
    Phi[:, VELOCITY, GYRO] = F @ rows.turn_path
    Phi[:, VELOCITY, ACCEL] = -rows.turn
    Phi[:, POSITION, VELOCITY] = T * np.eye(3)
    Phi[:, POSITION, ROTATION] = -0.5 * T**2 * F
    Phi[:, POSITION, ACCEL] = -rows.turn_path
    fades = np.exp(-rows.length_s / options.field_direction_s)
    Phi[:, DIRECTION, DIRECTION] = fades
    Q = np.zeros((m, N, N))
    turning = options.gyro_rate_noise_sqrt_s * rows.turned_rad / rows.length_s
    for part, density in (
        (ROTATION, options.gyro_noise_rad_per_sqrt_s**2 + turning**2), (GYRO, options.gyro_bias_walk_rad_s_per_sqrt_s**2),
        (ACCEL, options.accel_bias_walk_m_s2_per_sqrt_s**2), (VELOCITY, options.accel_noise_m_s_per_sqrt_s**2),
    ):  # fmt: skip
        Q[:, part, part] = (density * rows.length_s)[:, None, None] * np.eye(3)
    Q /= np.outer(sigma, sigma)
    Q[:, DIRECTION, DIRECTION] = 1 - fades**2
    return Windows(rows.t_s, rows.begin_s, Phi * sigma / sigma[:, None], Q, _information(motion, run, aids, options, sigma))


def _information(motion: Motion, run: InsRun, aids: Aids, options: Options, sigma: Array) -> dict[str, Array]:
    """By kind of aid, and of rest and of a car's wheels, which the filter finds itself."""
    rows, m = motion.rows, len(motion.rows.t_s)
    found: dict[str, Array] = {}

    def add(kind: str, window: int, H: Array, variance: Array) -> None:
        known = np.isfinite(variance) & (variance > 0)
        H = (H * sigma)[known]
        found.setdefault(kind, np.zeros((m, N, N)))[window] += H.T @ (H / variance[known, None])

    for kind, window, sigmas in _samples(aids, rows):
        add(kind, window, *_measured(kind, motion, window, sigmas, options))
    still = rows.summed(run.at_rest[rows.rows] * rows.steps_s)
    for window in np.flatnonzero(still > 0).tolist():
        add("rest", window, *_rest(motion, window, still[window], options))
    across_m_s = options.car_across_m_s or (CAR_ACROSS_M_S if options.body == "car" else 0.0)
    if across_m_s > 0:
        for window in range(m):
            add("car", window, _along(motion, window)[1:], np.full(2, across_m_s**2))
    return found


def _samples(aids: Aids, rows: RowWindows) -> list[tuple[str, int, Array]]:
    """Kind, window and sigmas of every aid; those of the magnetometer, and what is later than its first in a window, count once."""
    t_s, _, sensor, value = aids.arrays()
    window = np.searchsorted(rows.t_s, t_s - rows.all_t_s[0])
    inside = (t_s >= rows.all_t_s[rows.rows[0]]) & (window < len(rows.t_s))
    found = []
    for kind in AIDS:
        of_kind = inside & (sensor == SENSORS.index(kind))
        width = WIDTHS[kind]
        for place in np.unique(window[of_kind]):
            samples = value[of_kind & (window == place)]
            sigmas = samples[:, width : width + max(1, width)]
            found.append((kind, int(place), sigmas[0] / math.sqrt(len(sigmas))))
    return found


def _picked(part: slice) -> Array:
    return np.eye(N)[part]


def _along(motion: Motion, window: int) -> Array:
    """3 x N: the velocity in body axes."""
    to_body = motion.rows.matrix[motion.rows.begins[window + 1] - 1].T
    H = np.zeros((3, N))
    H[:, VELOCITY], H[:, ROTATION] = to_body, to_body @ cross(motion.velocity[window])
    return H


Measured = tuple[Array, Array]  # H, and the variance of each row


def _measured(kind: str, motion: Motion, window: int, sigmas: Array, options: Options) -> Measured:
    """What a sample of an aid with these sigmas measures at the end of a window."""
    length_s = motion.rows.length_s[window]
    match kind:
        case "position":
            return _picked(POSITION), sigmas**2 + np.array(options.position_colour_m)[[0, 0, 1]] ** 2
        case "velocity":
            return _picked(VELOCITY), sigmas**2
        case "rest":
            return _picked(VELOCITY), np.broadcast_to(sigmas**2, 3)
        case "pressure":
            return _picked(POSITION)[2:], (sigmas / PASCAL_PER_M) ** 2 + options.pressure_colour_m**2
        case "speed":
            scale = options.start_sigma_speed_scale * np.linalg.norm(motion.velocity[window])
            return _along(motion, window)[:1], sigmas**2 + scale**2
        case "heading":
            return _picked(ROTATION)[2:], sigmas**2 * max(1.0, options.heading_colour_s / length_s)
        case _:
            return _azimuth(motion, window), np.full(1, options.field_noise**2 * max(1.0, options.field_colour_s / length_s))


def _azimuth(motion: Motion, window: int) -> Array:
    """1 x N: that of the field, by heading, iron across the horizontal field, and direction of the field at the place."""
    to_axes = motion.rows.matrix[motion.rows.begins[window + 1] - 1]
    north = motion.rows.forward(np.array([1.0, 0.0, 0.0]))
    H = np.zeros((1, N))
    H[0, 2], H[0, IRON], H[0, DIRECTION] = 1.0, np.array([-north[1], north[0], 0.0]) @ to_axes, -1.0
    return H


def _rest(motion: Motion, window: int, seconds: float, options: Options) -> Measured:
    """No velocity, and no rate about the vertical beside that of the Earth."""
    turned = np.zeros((1, N))
    turned[0, GYRO] = motion.rows.matrix[motion.rows.begins[window + 1] - 1, 2]
    noise = options.rest_rate_noise_rad_per_sqrt_s**2 + options.gyro_noise_rad_per_sqrt_s**2
    variance = np.r_[np.full(3, options.rest_velocity_noise_m_s**2 / (RESTS_PER_S * seconds)), noise / seconds]
    return np.vstack([_picked(VELOCITY), turned]), variance
