"""Short cases whose answers by revision b991a70 are kept in frozen_answers.npz, and nothing that answers them.

test_frozen_answers.py answers them by this library, and says how the answers of a case are kept anew after a change of its
mathematics.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

ROWS = slice(4, None, 23)  # of a run, what is kept
STEPS = slice(1, None, 13)


# --------------------------------------------------------------------------------------------- attitude


@dataclass(frozen=True)
class Motion:
    t_s: np.ndarray
    rate: np.ndarray
    force: np.ndarray
    field: np.ndarray


def motion() -> Motion:
    """Six seconds at 50 Hz: a body that turns about all axes and stands for a while, fields and forces with gaps."""
    rng = np.random.default_rng(20)
    t = np.arange(300) / 50
    w = np.where((t > 2.5) & (t < 3.5), 0.0, 1.0)[:, None] * np.stack([np.sin(2 * t), 1.5 * np.cos(t), np.sin(3 * t)], axis=1)
    attitude = Rotation.from_euler("zyx", [50, 10, 20], degrees=True)
    force, field = np.empty((len(t), 3)), np.empty((len(t), 3))
    for k in range(len(t)):
        force[k] = attitude.apply([0, 0, -9.81], inverse=True) + 0.02 * rng.normal(size=3)
        field[k] = attitude.apply([2e-5, 1e-6, 4.4e-5], inverse=True) + 2e-7 * rng.normal(size=3)
        attitude = attitude * Rotation.from_rotvec(w[k] / 50)
    field[rng.random(len(t)) < 0.1] = np.nan
    force[rng.random(len(t)) < 0.05] = np.nan
    return Motion(t, w + [0.01, -0.02, 0.005] + 0.003 * rng.normal(size=w.shape), force, field)


FRAMES = {"navigation_frame": "enu", "declination_rad": 0.1, "q_body_sensor": [0.8, 0.1, -0.3, 0.2]}
SHARP = {"gyro_noise_rad_per_sqrt_s": 1e-3, "accel_noise_per_sqrt_hz": 5e-4, "mag_noise_per_sqrt_hz": 5e-4}
# Filter, preset, options.
ATTITUDE = {
    "ahrs": ("ahrs", "default", {}),
    "ahrs closed form": ("ahrs", "default", {"solver": "closed_form"}),
    "ahrs kl": ("ahrs", "default", {"gamma_mode": "kl", "start_sigma_heading_rad": 0.5}),
    "ahrs frames": ("ahrs", "default", FRAMES),
    "ahrs forward": ("ahrs", "default", {"gyro_hold": "forward", "start_samples": 3}),
    "hekf": ("hrekf", "default", {}),
    "hekf adams": ("hrekf", "default", {"solver": "adams"}),
    "hekf closed form": ("hrekf", "default", {"solver": "closed_form"}),
    "hekf euler": ("hrekf", "default", {"solver": "euler"}),
    "hrekf fixed": ("hrekf", "default", {"gamma_mode": "fixed", "gamma": 0.3}),
    "hrekf relative": ("hrekf", "default", {"gamma_mode": "relative"}),
    "hrekf kl": ("hrekf", "default", {"gamma_mode": "kl"}),
    "hrekf kl closed form": ("hrekf", "default", {"gamma_mode": "kl", "solver": "closed_form"}),
    "hrekf adapting": ("hrekf", "default", {"gamma_mode": "kl", "adaptation": "corrected"} | SHARP),
    "hrekf gates": ("hrekf", "default", {"accel_gate_nis": 3.0, "mag_gate_nis": 3.0} | SHARP),
    "hrekf frames": ("hrekf", "default", {"gamma_mode": "relative", "gyro_hold": "backward"} | FRAMES),
    "paper": ("hrekf", "paper", {}),
}
SMOOTHED = {"smoother": {}, "smoother closed form": {"solver": "closed_form"}}
OUTPUTS = ("q_nb", "gyro_bias_rad_s", "sigma_rad", "gyro_bias_sigma_rad_s", "accel_nis", "mag_nis", "ready")


# --------------------------------------------------------------------------------------------- coloured INS errors


def ins_model() -> dict[str, np.ndarray]:
    """Three states, two channels with coloured errors, by the names of LinearModel."""
    return {
        "A": np.array([[0.95, 0.1, 0.0], [-0.1, 0.95, 0.05], [0.0, 0.02, 0.9]]),
        "B": np.array([[0.1], [0.3], [0.0]]),
        "H": np.array([[1.0, 0.0, 0.5], [0.0, 1.0, -0.2]]),
        "An": np.array([[0.98, 0.01], [0.0, 0.97]]),
        "Qw": np.array([[0.02, 0.005, 0.0], [0.005, 0.03, 0.0], [0.0, 0.0, 0.01]]),
        "Qv": np.diag([0.1, 0.2]),
        "QU": np.array([[0.02, 0.004], [0.004, 0.03]]),
        "P0": np.diag([1.0, 2.0, 0.5]),
    }


def ins_signals() -> tuple[np.ndarray, np.ndarray]:
    """u (120 x 1) and z (120 x 2): a channel that is noisy for a while, measurements that are missing."""
    rng = np.random.default_rng(21)
    k = np.arange(120)
    u = np.sign(np.sin(0.3 * k + 0.1))[:, None]
    z = np.stack([np.sin(0.3 * k), np.cos(0.2 * k)], axis=1) + 0.3 * rng.normal(size=(120, 2))
    z[50:70, 1] += 3 * rng.normal(size=20)
    z[rng.random(z.shape) < 0.05] = np.nan
    return u, z


INS_ERROR = {
    **{form: {"form": form, "noise_scaling": "none"} for form in ("mdkf", "amdkf", "differenced", "augmented", "plain")},
    **{scaling: {"noise_scaling": scaling} for scaling in ("paper_match", "gated_match", "hmm")},
    "lag": {"lag": 1, "noise_scaling": "hmm"},
    "standard form": {"form": "differenced", "joseph": 0, "noise_scaling": "hmm"},
}
INS_OUTPUTS = ("x", "sigma", "innovation", "nis", "noise_scale", "fault_probability", "compensated")


# --------------------------------------------------------------------------------------------- calibration and sensors


def turned_magnetometer() -> tuple[np.ndarray, np.ndarray]:
    """field (in tesla) and force of a distorted sensor that is turned about all axes, with a few outliers."""
    rng = np.random.default_rng(22)
    attitude = Rotation.from_euler("zyx", rng.uniform(-np.pi, np.pi, (300, 3)))
    distortion = np.array([[1.1, 0.04, -0.02], [0.03, 0.95, 0.05], [0.01, -0.03, 1.02]])
    field = attitude.apply([2e-5, 1e-6, 4.4e-5], inverse=True) @ distortion.T + [1.2e-5, -3e-5, 8e-6]
    field += 2e-7 * rng.normal(size=field.shape)
    field[::30] += 4e-6
    force = attitude.apply([0, 0, -9.81], inverse=True) + 0.05 * rng.normal(size=field.shape)
    return field, force


CALIBRATION = {"calibration": {}, "calibration plain": {"robust": 0}}
CALIBRATED = ("offset", "matrix", "strength", "residual_after", "condition", "axis_ratio", "outlier_fraction")

# Parameters of the turntable and the sensor on it, 100 Hz for two seconds.
TABLE = {"roll.angle_rad": 0.4, "pitch.angle_rad": -0.3, "yaw.rate_rad_s": 1.0, "yaw.unknown_rad": 1.0, "seed": 3}
SENSOR = {
    "seed": 4, "gyro.noise_deg_per_sqrt_h": 0.5, "gyro.bias_instability_rad_s": 1e-4, "gyro.bias_sigma_rad_s": 0.01,
    "gyro.random_walk_deg_per_h_per_sqrt_h": 5.0, "gyro.dropout": 0.05, "gyro.resolution_rad_s": 1e-3,
    "accel.noise_ug_per_sqrt_hz": 300.0, "accel.latency_s": 0.02, "accel.scale_factor_sigma": 0.01,
    "mag.period_s": 0.05, "mag.noise_nt_per_sqrt_hz": 100.0, "mag.hard_iron_sigma_tesla": 1e-6, "mag.soft_iron_sigma": 0.01,
    "fault.outliers.start_s": 0.5, "fault.outliers.stop_s": 1.0, "fault.outliers.probability": 0.2,
    "fault.outliers.gyro_sigma_rad_s": 1.0, "fault.bias_jump.start_s": 1.2, "fault.bias_jump.stop_s": 1.6,
    "fault.bias_jump.accel_m_s2[1]": 0.5, "fault.noise_increase.start_s": 1.5, "fault.noise_increase.stop_s": 2.0,
    "fault.noise_increase.mag_factor": 4.0,
}  # fmt: skip
SENSOR_OUTPUTS = [f"{name}[{i}]" for name in ("gyro.rate", "accel.force", "mag.field") for i in (1, 2, 3)] + [
    f"{name}.t_meas" for name in ("gyro", "accel", "mag")
]
SENSOR_STEP_S, SENSOR_STOP_S = 0.01, 2.0
