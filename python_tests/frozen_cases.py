"""Short cases whose answers by revision d7bc172 are kept in frozen_answers.npz, without the code that runs them.

test_frozen_answers.py runs them with this library; its docstring has the command that stores the answers of a case again after a
change of its mathematics.
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


# --------------------------------------------------------------------------------------------- navigation and observer


@dataclass(frozen=True)
class Drive:
    """Rows of an inertial sensor; fixes (n, of which three are vectors) and fields beside them."""

    t_s: np.ndarray
    rate: np.ndarray
    force: np.ndarray
    fix_s: np.ndarray
    place: np.ndarray
    velocity: np.ndarray
    pressure_pa: np.ndarray
    speed_m_s: np.ndarray


def drive() -> Drive:
    """Forty seconds of a car at 50 Hz on a flat Earth: it stands, gains speed, and goes through curves; fixes of 2 Hz, one far off."""
    rng, interval_s = np.random.default_rng(23), 1 / 50
    t = 5.0 + interval_s * np.arange(2000)
    speed = 12 * np.clip((t - 11) / 6, 0, 1) + np.where(t > 17, np.sin(0.7 * (t - 17)), 0)
    turn = np.where(t > 18, 0.25 * np.sin(0.4 * (t - 18)), 0)
    heading = 0.8 + np.cumsum(turn) * interval_s
    rate = np.stack([0 * t, 0 * t, turn], axis=1) + [0.002, -0.001, 0.0015] + 0.001 * rng.normal(size=(len(t), 3))
    force = np.stack([np.gradient(speed, t), speed * turn, 0 * t - 9.80665], axis=1) + 0.02 * rng.normal(size=(len(t), 3))
    v = np.stack([speed * np.cos(heading), speed * np.sin(heading), 0 * t], axis=1)
    d = np.cumsum(v, axis=0) * interval_s + 0.4 * rng.normal(size=v.shape)
    fixes = np.arange(24, len(t), 25)
    d[fixes[50]] += [60, -40, 10]
    place = np.stack([0.8 + d[:, 0] / 6.37e6, 0.2 + d[:, 1] / (6.38e6 * np.cos(0.8)), 400 - d[:, 2]], axis=1)
    rate[500], force[700:710], rate[900:905] = np.nan, np.nan, np.nan
    measured = v + 0.08 * rng.normal(size=v.shape)
    pressure = 96600 + 3 * rng.normal(size=len(t))
    return Drive(
        t,
        rate,
        force,
        t[fixes],
        place[fixes],
        measured[fixes],
        pressure[fixes],
        speed[fixes] + 0.05 * rng.normal(size=len(fixes)),
    )


CLOSED = {"solver": "closed_form"}
REST = {"start_place": "given", "start_latitude_rad": 0.8, "start_longitude_rad": 0.2, "start_height_m": 400.0}
# Preset, kinds of aids, options.
SATELLITES = ("position", "velocity")
NAVIGATION = {
    "ins": ("industrial", SATELLITES, CLOSED),
    "ins erkstep": ("industrial", SATELLITES, {}),
    "ins consumer": ("consumer", (*SATELLITES, "pressure", "speed"), CLOSED),
    "ins positions": ("tactical", ("position",), CLOSED | {"horizon_s": 0.5}),
    "ins at rest": ("navigation", (), CLOSED | REST | {"rest_velocity_noise_m_s": 0.01}),
    "ins smoothed": ("industrial", SATELLITES, CLOSED),
}
NAVIGATED = (
    "place",
    "velocity_n_m_s",
    "euler_rad",
    "gyro_bias_rad_s",
    "sigma_position_m",
    "sigma_velocity_m_s",
    "sigma_rotation_rad",
    "phase",
)
EVERY_FIX = slice(30, None, 87)
AT_REST = 300  # rows before it gains speed

PLANTS = {
    "observer pendulum": {
        "derivatives": lambda t, x, u, p: (x[1], -9.81 * np.sin(x[0]) - p[0] * x[1] + u[0]), "outputs": lambda t, x, u, p: x[0],
        "states": {"angle": 0.5, "rate": 0.0}, "sensors": ["angle"], "inputs": {"torque": 0.0}, "parameters": {"friction": 0.1},
    },
    "observer ball": {
        "derivatives": lambda t, x, u, p: (x[1], -9.81), "outputs": lambda t, x, u, p: x[0], "states": {"h": 1.0, "v": 0.0},
        "sensors": ["h"], "indicators": lambda t, x, u, p: x[0],
        "event": lambda t, x, u, p: (0.0, -0.7 * x[1]) if x[0] <= 0 and x[1] < 0 else x,
    },
    "observer tank": {
        "derivatives": lambda t, x, u, p: 0.1 - 0.15 * max(x[0], 0.0) ** 0.5, "outputs": lambda t, x, u, p: x[0],
        "states": {"level": 1.0}, "sensors": ["level"],
    },
    "observer relay": {
        "derivatives": lambda t, x, u, p, q: (3 if q[0] else -3) - x, "outputs": lambda t, x, u, p, q: x[0], "states": {"T": 0.0},
        "sensors": ["T"], "discrete": {"on": 1.0}, "indicators": lambda t, x, u, p, q: 1 - x[0] if q[0] else x[0] + 1,
        "event": lambda t, x, u, p, q: (x, [1 - q[0]] if (x[0] >= 1 if q[0] else x[0] <= -1) else q),
    },
}  # fmt: skip
# Noise of the sensor, start, its sigma and noise of each state, sigma and noise of each parameter.
OBSERVED = {
    "observer pendulum": (0.02, {"angle": (0.3, 0.5, 0.0), "rate": (0.0, 0.5, 0.05)}, {"friction": (0.05, 0.01)}),
    "observer ball": (0.02, {"h": (1.0, 0.05, 0.0), "v": (0.0, 0.3, 0.02)}, {}),
    "observer tank": (0.01, {"level": (1.5, 0.5, 0.01)}, {}),
    "observer relay": (0.1, {"T": (0.0, 0.3, 0.1)}, {}),
}
GATE_NIS, INSTANT_S = 10.8, 0.05


def observed_samples(case: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, samples of the sensor and of the input: a signal of about the plant's shape, some missing, one far off."""
    rng = np.random.default_rng(24)
    # A ball comes to rest by ever shorter bounces; it is looked at before.
    t = INSTANT_S * np.arange(1, 41 if case == "observer ball" else 121)
    signal = {
        "observer pendulum": 0.5 * np.exp(-0.05 * t) * np.cos(3.1 * t),
        "observer ball": np.abs(np.exp(-0.35 * t) * np.cos(3.2 * t)),
        "observer tank": 0.45 + 0.55 * np.exp(-0.12 * t),
        "observer relay": np.abs((t / 0.7) % 4 - 2) - 1,
    }[case] + OBSERVED[case][0] * rng.normal(size=len(t))
    signal[rng.random(len(t)) < 0.1] = np.nan
    signal[2 * len(t) // 3] += 1.0
    return t, signal, 0.3 * np.sin(t)
