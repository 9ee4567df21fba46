"""The linear errors of an attitude filter over the windows of a run, for Run.observability()."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from hnav.filters.attitude_answers import Run
from hnav.filters.observability import RunObservability, Windows, run_observability
from hnav.filters.options import Options
from hnav.filters.run_windows import ANGLES, G_M_S2, UNKNOWN_HEADING_RAD, UNKNOWN_TILT_RAD, RowWindows, block, cross
from hnav.native.arrays import Array, BoolArray

if TYPE_CHECKING:
    from hnav.io.recordings import Recording

VELOCITY, DECLINATION = slice(6, 8), 8  # places of the AHRS after rotation and gyro bias
ROTATION, BIAS = slice(0, 3), slice(3, 6)


def attitude_observability(run: Run, recording: Recording | None = None) -> RunObservability:
    """recording: the samples of the run, in which the AHRS detects rest. Raises HnavValueError for a run without an attitude."""
    options = run.options or Options("ahrs")
    rows = RowWindows.of(run.t_s, run.q_nb)
    force, field = (rows.seconds(used) for used in _used(run))
    kinds = {"force": force, "field": field}
    if options.filter == "ahrs" and recording is not None:
        kinds["rest"] = rows.seconds(_at_rest(run, recording, options))
    make = _ahrs if options.filter == "ahrs" else _hrekf
    moving, held = (make(moved, kinds, options) for moved in (rows, rows.held()))
    return run_observability(moving, held, (*ANGLES, *rows.gyro_biases()), rows.turned_rad)


def _used(run: Run) -> tuple[BoolArray, BoolArray]:
    """n each: rows in which the force, and the field, corrected."""
    used = np.isfinite(np.stack([run.accel_nis, run.mag_nis], axis=1))
    if run.accepted is not None:
        used &= run.accepted
    if not used.any():  # a run with hindsight, or sample by sample, has no innovations
        used = run.health[:, 1:] == 0
    return used[:, 0], used[:, 1]


def _at_rest(run: Run, recording: Recording, options: Options) -> BoolArray:
    """n: rows that begin a rest: rate and force stay constant for its duration."""
    steady = np.ones(len(run.t_s), bool)
    rows = max(1, min(len(run.t_s), round(options.rest_duration_s / float(np.median(np.diff(run.t_s))))))
    for values, limit in ((recording.rate_b_rad_s, options.rest_rate_rad_s), (recording.force_b_m_s2, options.rest_force_m_s2)):
        known = np.nan_to_num(values)
        mean = np.stack([np.convolve(axis, np.full(rows, 1 / rows), "same") for axis in known.T], axis=1)
        steady &= np.linalg.norm(known - mean, axis=1) < limit
        if values is recording.rate_b_rad_s:
            steady &= np.abs(mean).max(axis=1) < options.rest_mean_rate_rad_s
    return np.asarray(np.convolve(steady, np.ones(rows), "same") > rows - 0.5)


def _start_sigmas(options: Options) -> tuple[float, float]:
    """Sigmas of tilt and heading before any sample: those given at the start, or unknown."""
    tilt = options.start_sigma_tilt_rad if options.start_mode == "attitude" else UNKNOWN_TILT_RAD
    heading = UNKNOWN_HEADING_RAD if options.start_mode == "triad" else options.start_sigma_heading_rad
    return float(tilt), float(heading)


def _noise(rows: RowWindows, sigma: Array, rotation: Array, walk: float) -> Array:
    """m x n x n: rotation is the variance of each window, walk the density of the bias."""
    Q = np.zeros((len(rows.length_s), len(sigma), len(sigma)))
    Q[:, ROTATION, ROTATION] = rotation[:, None, None] * np.eye(3)
    Q[:, BIAS, BIAS] = (walk**2 * rows.length_s)[:, None, None] * np.eye(3)
    return Q / np.outer(sigma, sigma)


def _hrekf(rows: RowWindows, seconds: dict[str, Array], options: Options) -> Windows:
    """Measurements of the directions of force and field by their known directions in navigation axes."""
    tilt, heading = _start_sigmas(options)
    sigma = np.array([tilt, tilt, heading, *np.full(3, options.start_sigma_bias_rad_s)])
    Phi = np.broadcast_to(np.eye(6), (len(rows.length_s), 6, 6)).copy()
    Phi[:, ROTATION, BIAS] = -rows.turn
    variance = (options.gyro_noise_rad_per_sqrt_s**2 + 4 * options.quaternion_noise_per_sqrt_s**2) * rows.length_s
    dip = options.reference_dip_rad
    field = rows.forward(np.array([math.cos(dip), 0.0, math.sin(dip)]))
    information = {}
    for kind, vector, noise in (
        ("force", np.array([0.0, 0.0, -1.0]), options.accel_noise_per_sqrt_hz), ("field", field, options.mag_noise_per_sqrt_hz)
    ):  # fmt: skip
        H = np.hstack([cross(vector), np.zeros((3, 3))]) * sigma
        information[kind] = block(seconds[kind] / noise**2, H.T @ H)
    Q = _noise(rows, sigma, variance, options.gyro_bias_walk_rad_s_per_sqrt_s)
    return Windows(rows.t_s, rows.begin_s, Phi * sigma / sigma[:, None], Q, information)


def _ahrs(rows: RowWindows, seconds: dict[str, Array], options: Options) -> Windows:
    """Measurements of the velocity that the force integrates to, the azimuth of the field, and at rest the mean rate."""
    tilt, heading = _start_sigmas(options)
    sigma = np.array([tilt, tilt, heading, *np.full(3, options.start_sigma_bias_rad_s), *np.full(2, options.start_sigma_velocity_m_s),
                      options.local_declination_rad])  # fmt: skip
    m, T = len(rows.length_s), rows.length_s
    Phi = np.broadcast_to(np.eye(9), (m, 9, 9)).copy()
    Phi[:, ROTATION, BIAS] = -rows.turn
    for axis, (of, sign) in enumerate(((1, -1.0), (0, 1.0))):
        Phi[:, 6 + axis, of] = sign * G_M_S2 * T
        Phi[:, 6 + axis, BIAS] = -sign * G_M_S2 * rows.turn_path[:, of]
    fades = np.exp(-T / options.local_declination_s)
    Phi[:, DECLINATION, DECLINATION] = fades
    variance = options.gyro_noise_rad_per_sqrt_s**2 * T + options.gyro_rate_noise_sqrt_s**2 * rows.turned_rad**2 / T
    Q = _noise(rows, sigma, variance, options.gyro_bias_walk_rad_s_per_sqrt_s)
    Q[:, DECLINATION, DECLINATION] = 1 - fades**2
    azimuth = np.zeros(9)
    azimuth[[2, DECLINATION]] = 1.0, -1.0
    azimuth_noise = options.mag_azimuth_noise_per_sqrt_hz / math.cos(options.reference_dip_rad)
    measured = {
        "force": (np.eye(9)[VELOCITY], options.velocity_noise_m_s_per_sqrt_hz),
        "field": (azimuth[None], azimuth_noise),
        "rest": (np.eye(9)[BIAS], options.rest_bias_noise_rad_s_per_sqrt_hz),
    }
    information = {}
    for kind in seconds:
        H, noise = measured[kind][0] * sigma, measured[kind][1]
        information[kind] = block(seconds[kind] / noise**2, H.T @ H)
    return Windows(rows.t_s, rows.begin_s, Phi * sigma / sigma[:, None], Q, information)
