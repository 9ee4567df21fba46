"""The paper's experiment as a recording: a level turntable that yaws to and fro, with sensors of known faults.

Yaw is a triangle of +-60 deg and 10 deg/s whose corners are rounded over 0.4 s; roll and pitch are zero. Figures of the
sensors: one draw of gyro bias, scale and misalignment for each seed, white noise for each sample. The kinematics are
exact: the rate of a row is the turn until the next row over its interval, what a filter with the forward hold expects.
Source: "Hybrid Robust Extended Kalman Filter for SINS initial alignment", TJEE 54(4), 2024,
doi 10.22034/tjee.2023.57843.4683, section 5; dip, noise and faults are assumptions, the paper does not give them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from hnav.io.recordings import Recording
from hnav.rotations import NED_AND_ENU, quaternion_product

INTERVAL_S = 0.01
GRAVITY_M_S2 = 9.80665
FIELD_TESLA = 5e-5
DIP_RAD = np.radians(54.0)


@dataclass(frozen=True)
class Experiment:
    recording: Recording
    settings: dict[str, str]  # options that give a filter the start, wrong by the start errors, and the field
    q_nb: np.ndarray  # n x 4: the truth, north-east-down
    gyro_bias_rad_s: np.ndarray  # 3: the truth


@dataclass(frozen=True)
class Turntable:
    """Amplitudes and standard deviations; all in the units of their names."""

    amplitude_deg: float = 60.0
    period_s: float = 24.0
    rounding_s: float = 0.4
    gyro_noise_deg_s: float = 0.1  # of a sample
    gyro_bias_deg_s: float = 1.0  # uniform within +- this, each axis
    gyro_scale: float = 0.003  # of the yaw rate; also what of it the level axes see
    accel_noise: float = 0.01  # of a sample, in g
    mag_noise: float = 0.02  # of a sample, in field strengths
    start_yaw_deg: float = 10.0  # uniform within +- this
    start_tilt_deg: float = 2.0

    def yaw_rad(self, t_s: np.ndarray) -> np.ndarray:
        """Triangle averaged over a window of rounding_s."""
        window = np.linspace(-0.5, 0.5, 41) * self.rounding_s
        turn = 2 * np.pi * (t_s[:, None] + window) / self.period_s
        return np.asarray(np.radians(self.amplitude_deg) * (2 / np.pi * np.arcsin(np.sin(turn))).mean(axis=1))

    def run(self, duration_s: float, seed: int) -> Experiment:
        """Samples every 10 ms from 0 to duration_s."""
        rng = np.random.default_rng(seed)
        n = round(duration_s / INTERVAL_S) + 1
        t_s = np.arange(n) * INTERVAL_S
        yaw = self.yaw_rad(np.append(t_s, n * INTERVAL_S))
        yaw_rate = np.diff(yaw) / INTERVAL_S
        attitude = Rotation.from_euler("z", yaw[:-1, None])
        bias = np.radians(self.gyro_bias_deg_s) * rng.uniform(-1, 1, 3)
        response = np.array([0, 0, 1]) + self.gyro_scale * rng.normal(size=3)
        rate = yaw_rate[:, None] * response + bias + np.radians(self.gyro_noise_deg_s) * rng.normal(size=(n, 3))
        force = attitude.apply([0, 0, -1], inverse=True) + self.accel_noise * rng.normal(size=(n, 3))
        field_n = [np.cos(DIP_RAD), 0, np.sin(DIP_RAD)]
        field = attitude.apply(field_n, inverse=True) + self.mag_noise * rng.normal(size=(n, 3))
        q_nb = attitude.as_quat()[:, [3, 0, 1, 2]]

        angles_deg = np.array([self.start_yaw_deg, self.start_tilt_deg, self.start_tilt_deg]) * rng.uniform(-1, 1, 3)
        start = Rotation.from_euler("ZYX", angles_deg + [np.degrees(yaw[0]), 0, 0], degrees=True).as_quat()[[3, 0, 1, 2]]
        settings = {
            "start_mode": "attitude",
            "start_q_nb": ",".join(f"{c:.17g}" for c in start),
            "reference_mode": "given",
            "reference_strength_tesla": f"{FIELD_TESLA:.17g}",
            "reference_dip_rad": f"{DIP_RAD:.17g}",
        }
        q_enu = quaternion_product(NED_AND_ENU, q_nb)
        recording = Recording(f"turntable, seed {seed}", t_s, rate, GRAVITY_M_S2 * force, FIELD_TESLA * field, q_enu)
        return Experiment(recording, settings, q_nb, bias)
