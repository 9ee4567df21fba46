"""The turntable experiment as data: components, connections, scenarios, and what a sensor grade sets.

Turntable -> ImuMagSensor -> Hrekf as HEKF (gamma off), Hrekf as HREKF, Ahrs. A scenario is complete: it sets every
parameter that any scenario sets, so one may follow another. The paper is "Hybrid Robust Extended Kalman Filter for SINS
initial alignment" (Tabriz Journal of Electrical Engineering 54(4), 2024).
"""

from __future__ import annotations

import math
from functools import partial
from typing import Any

from hnav.filters.options import Options, option_table
from hnav.fmi.fmus import parameter_values
from hnav.io.sensors import DEG, read_grade
from hnav.systems.structure import Value
from hnav.units import G_M_S2

STRENGTH_TESLA = 5e-5
COMPONENTS = {"turntable": "Turntable", "sensor": "ImuMagSensor", "hekf": "Hrekf", "hrekf": "Hrekf", "ahrs": "Ahrs"}
FILTERS = ("hekf", "hrekf", "ahrs")
TRUTH = [f"truth.{name}[{i}]" for name, n in (("q", 4), ("rate", 3), ("force", 3), ("field", 3)) for i in range(1, n + 1)]
SAMPLES = [
    name
    for sensor, value in (("gyro", "rate"), ("accel", "force"), ("mag", "field"))
    for name in [f"{sensor}.{value}[{i}]" for i in (1, 2, 3)] + [f"{sensor}.{suffix}" for suffix in ("sample", "t_meas", "valid")]
]
ORIGIN = [1.0, 0.0, 0.0, 0.0]

# --------------------------------------------------------------------------------------------- scenarios


def rate_of(rho: float) -> float:
    """The rate of mode relative whose 1 - exp(-rate T) is rho at 100 Hz."""
    return -math.log1p(-rho) / 0.01


Values = dict[str, Value]


def table(yaw_deg: float, tilt_deg: float) -> Values:
    """Axes that stand off by an unknown angle, uniform within these; the filters start at the nominal attitude."""
    return {
        "turntable.roll.unknown_rad": tilt_deg * DEG,
        "turntable.pitch.unknown_rad": tilt_deg * DEG,
        "turntable.yaw.unknown_rad": yaw_deg * DEG,
    }


def sensor(
    gyro_deg_s: float = 0.1, accel_g: float = 0.01, mag_field: float = 0.02, bias_deg_s: float = 1 / math.sqrt(3),
    scale: float = 0.003, misalignment: float = 0.003, bias_walk_rad_s: float = 0.0, drift_deg_s2: float = 0.0,
    hard: float = 0.0, soft: float = 0.0,
) -> Values:  # fmt: skip
    """The paper's sensors at 100 Hz: standard deviations of one sample in deg/s, g and units of the field; spreads drawn
    from the seed. The uniform spreads of the experiment became normal ones of equal variance."""
    root = math.sqrt(0.01)  # density = sigma of a sample x sqrt(interval)
    return {
        "sensor.gyro.noise_deg_per_sqrt_h": gyro_deg_s * root * 60,
        "sensor.gyro.bias_sigma_rad_s": bias_deg_s * DEG,
        "sensor.gyro.scale_factor_sigma": scale,
        "sensor.gyro.misalignment_sigma_rad": misalignment,
        "sensor.gyro.random_walk_deg_per_h_per_sqrt_h": bias_walk_rad_s / DEG * 3600 * 60,
        "sensor.gyro.drift_sigma_rad_s2": drift_deg_s2 * DEG,
        "sensor.accel.noise_ug_per_sqrt_hz": accel_g * root * 1e6,
        "sensor.mag.noise_nt_per_sqrt_hz": mag_field * root * STRENGTH_TESLA * 1e9,
        "sensor.mag.hard_iron_sigma_tesla": hard * STRENGTH_TESLA,
        "sensor.mag.soft_iron_sigma": soft,
    }


def faults(outliers: float = 0.0, disturbance: float = 0.0) -> Values:
    """outliers: probability, 0.5 g and half the field large, during the whole run; disturbance: in units of the field, 20 to 30 s."""
    return {
        "sensor.fault.outliers.start_s": 0.0,
        "sensor.fault.outliers.stop_s": 1e6 if outliers else 0.0,
        "sensor.fault.outliers.probability": outliers,
        "sensor.fault.outliers.accel_sigma_m_s2": 0.5 * G_M_S2,
        "sensor.fault.outliers.mag_sigma_tesla": 0.5 * STRENGTH_TESLA,
        "sensor.fault.mag_disturbance.start_s": 20.0,
        "sensor.fault.mag_disturbance.stop_s": 30.0,
        "sensor.fault.mag_disturbance.strength_tesla": disturbance * STRENGTH_TESLA,
    }


def paper() -> dict[str, Any]:
    """The values of the paper's preset, one by one: with the preset itself, a value that equals its start value, such as
    gamma_mode = off, would be ignored."""
    given, default = Options("hrekf", "paper"), Options("hrekf")
    return {name: getattr(given, name) for name in option_table("hrekf") if getattr(given, name) != getattr(default, name)}


def hrekf_parameters(values: dict[str, Any]) -> Values:
    return parameter_values(option_table("hrekf"), values)


def filters(
    accel: float = 0.01, mag: float = 0.02, quaternion: float = 1e-3, gyro: float = 0.0, bias_walk: float = 1e-3,
    tilt_rad: float = 2 * math.sqrt(0.1), heading_rad: float = 2 * math.sqrt(0.1), bias_rad_s: float = math.sqrt(1e-3),
    solver: str = "erkstep", adaptation: str = "off", gamma_mode: str = "relative", rho: float = 0.015,
) -> Values:  # fmt: skip
    """HEKF and HREKF: standard deviations of a sample at 100 Hz in units of gravity and field; Q by densities; the start."""
    root = math.sqrt(0.01)
    both = {
        **paper(),
        "gamma_relative_rate_1_s": rate_of(rho),
        "accel_noise_per_sqrt_hz": accel * root,
        "mag_noise_per_sqrt_hz": mag * root,
        "quaternion_noise_per_sqrt_s": quaternion,
        "gyro_noise_rad_per_sqrt_s": gyro,
        "gyro_bias_walk_rad_s_per_sqrt_s": bias_walk,
        "start_mode": "attitude",
        "start_q_nb": ORIGIN,
        "start_sigma_tilt_rad": tilt_rad,
        "start_sigma_heading_rad": heading_rad,
        "start_sigma_bias_rad_s": bias_rad_s,
        "reference_mode": "given",
        "reference_strength_tesla": STRENGTH_TESLA,
        "reference_dip_rad": 60 * DEG,
        "adaptation": adaptation,
        "adaptation_gain": 0.5,
        "solver": solver,
    }
    modes = {"hekf": {"gamma_mode": "off"}, "hrekf": {"gamma_mode": gamma_mode}}
    return {f"{name}.{key}": value for name, mode in modes.items() for key, value in hrekf_parameters(both | mode).items()}


# P0 = 1e-6 I and R = 1e-2 I: found so that the ratios of the paper's Table 1 come back.
fitted = partial(
    filters, accel=0.1, mag=0.1, tilt_rad=2e-3, heading_rad=2e-3, bias_rad_s=1e-3, solver="euler", adaptation="paper"
)
MATCHED_GYRO_DEG_S, MATCHED_WALK_RAD_S, MATCHED_YAW_DEG, MATCHED_TILT_DEG, MATCHED_BIAS_DEG_S = 0.1, 1e-4, 8.0, 3.0, 0.5
UNIFORM = 1 / math.sqrt(3)  # standard deviation of a uniform distribution by its half width

# Name -> what it is, values.
SCENARIOS: dict[str, tuple[str, Values]] = {
    "nominal": ("Honest P0 and R, Q = 1e-6 I", table(60, 5) | sensor() | faults() | filters()),
    "gyro_drift": (
        "A gyro bias that walks and drifts, scale factor 1 %, while the filters assume Q = 1e-8 I",
        table(60, 5) | sensor(scale=0.01, bias_walk_rad_s=0.05 * DEG, drift_deg_s2=0.02 * UNIFORM) | faults() | filters(quaternion=1e-4, bias_walk=1e-4),
    ),
    "outliers": ("2 % outliers of half a g and half the field", table(60, 5) | sensor() | faults(outliers=0.02) | filters()),
    "magnetic_disturbance": ("0.3 of the field in an unknown direction from 20 to 30 s", table(60, 5) | sensor() | faults(disturbance=0.3) | filters()),
    "iron_residual": ("Hard iron of 3 % and soft iron of 2 % that a calibration has left", table(60, 5) | sensor(hard=0.03, soft=0.02) | faults() | filters()),
    "matched": (
        "White noise and bias walk exactly as the filters assume, honest P0, gamma off: for tests of consistency",
        table(MATCHED_YAW_DEG, MATCHED_TILT_DEG)
        | sensor(gyro_deg_s=MATCHED_GYRO_DEG_S, bias_deg_s=MATCHED_BIAS_DEG_S, scale=0.0, misalignment=0.0, bias_walk_rad_s=MATCHED_WALK_RAD_S)
        | faults()
        | filters(
            quaternion=0.0, gyro=MATCHED_GYRO_DEG_S * DEG * 0.1, bias_walk=MATCHED_WALK_RAD_S, tilt_rad=MATCHED_TILT_DEG * DEG * UNIFORM,
            heading_rad=MATCHED_YAW_DEG * DEG * UNIFORM, bias_rad_s=MATCHED_BIAS_DEG_S * DEG, gamma_mode="off",
        ),
    ),
    "fitted": (
        "The paper's Table 1: P0 = 1e-6 I and rho = 0.015 are fitted to it, Robbins-Monro as printed, Euler",
        table(40, 4.5) | sensor() | faults() | fitted(),
    ),
    "fitted_rho_half": ("fitted, with rho = 0.5", table(40, 4.5) | sensor() | faults() | fitted(rho=0.5)),
    "fitted_honest": (
        "fitted, with an honest P0 and no adaptation",
        table(40, 4.5) | sensor() | faults() | filters(accel=0.1, mag=0.1, solver="euler"),
    ),
}  # fmt: skip


def grade_values(name: str) -> Values:
    """A grade over the nominal scenario: its sensor, and filters that assume its noise. What it does not name is without error."""
    grade = read_grade(name)
    values: Values = dict.fromkeys(sensor(), 0.0)
    values |= {f"sensor.{key}": value for key, value in grade.parameters().items()}
    noise = grade.filter_parameters(STRENGTH_TESLA)
    bias_sigma = math.hypot(grade.values["gyro.bias_sigma_rad_s"], grade.values["gyro.bias_instability_rad_s"])
    assumed = noise | {"quaternion_noise_per_sqrt_s": 0.0, "start_sigma_bias_rad_s": bias_sigma}
    return values | {
        f"{component}.{key}": value for component in ("hekf", "hrekf") for key, value in hrekf_parameters(assumed).items()
    }
