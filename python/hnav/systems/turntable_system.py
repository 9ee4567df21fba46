"""The system of the turntable experiment: models/systems/turntable, written from the FMUs, the grades and the scenarios here.

    python -m hnav.systems.turntable_system FOLDER

Turntable -> ImuMagSensor -> Hrekf as HEKF (gamma off), Hrekf as HREKF, Ahrs. A scenario is complete: it sets every
parameter that any scenario sets, so one may follow another. The paper is "Hybrid Robust Extended Kalman Filter for SINS
initial alignment" (Tabriz Journal of Electrical Engineering 54(4), 2024).
"""

from __future__ import annotations

import math
import sys
from pathlib import Path
from xml.sax.saxutils import quoteattr

import fmpy

from hnav.fmi.fmus import fmu_path
from hnav.systems.parameter_sets import BASE_UNITS, unit_elements, value_element, write_parameter_set
from hnav.systems.sensors import GRADES, read_grade

DEG = math.pi / 180
G_M_S2 = 9.80665
STRENGTH_TESLA = 5e-5
COMPONENTS = {"turntable": "Turntable", "sensor": "ImuMagSensor", "hekf": "Hrekf", "hrekf": "Hrekf", "ahrs": "Ahrs"}
DESCRIPTIONS = {
    "turntable": "truth", "sensor": "samples with counters and time stamps", "hekf": "gamma off: the hybrid extended Kalman filter",
    "hrekf": "the hybrid robust extended Kalman filter", "ahrs": "the filter for real sensors",
}  # fmt: skip
FILTERS = ("hekf", "hrekf", "ahrs")
TRUTH = [f"truth.{name}[{i}]" for name, n in (("q", 4), ("rate", 3), ("force", 3), ("field", 3)) for i in range(1, n + 1)]
SAMPLES = [
    name
    for sensor, value in (("gyro", "rate"), ("accel", "force"), ("mag", "field"))
    for name in [f"{sensor}.{value}[{i}]" for i in (1, 2, 3)] + [f"{sensor}.{suffix}" for suffix in ("sample", "t_meas", "valid")]
]
ORIGIN = [1.0, 0.0, 0.0, 0.0]
OFF, RELATIVE = 0, 2  # gamma_mode
PAPER = 1  # adaptation, and preset
FROM_ATTITUDE, GIVEN = 1, 1  # start_mode, reference_mode
EULER, ERKSTEP = 3, 0  # solver
COUNTER = 1  # sampling_mode

# --------------------------------------------------------------------------------------------- scenarios


def rate_of(rho: float) -> float:
    """The rate of mode relative whose 1 - exp(-rate T) is rho at 100 Hz."""
    return -math.log1p(-rho) / 0.01


def table(yaw_deg: float, tilt_deg: float) -> dict:
    """Axes that stand off by an unknown angle, uniform within these; the filters are told the nominal attitude."""
    return {
        "turntable.roll.unknown_rad": tilt_deg * DEG,
        "turntable.pitch.unknown_rad": tilt_deg * DEG,
        "turntable.yaw.unknown_rad": yaw_deg * DEG,
    }


def sensor(
    gyro_deg_s=0.1, accel_g=0.01, mag_field=0.02, bias_deg_s=1 / math.sqrt(3), scale=0.003, misalignment=0.003, bias_walk_rad_s=0.0, drift_deg_s2=0.0,
    hard=0.0, soft=0.0,
) -> dict:  # fmt: skip
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


def faults(outliers: float = 0.0, disturbance: float = 0.0) -> dict:
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


def filters(
    accel=0.01, mag=0.02, quaternion=1e-3, gyro=0.0, bias_walk=1e-3, tilt_rad=2 * math.sqrt(0.1), heading_rad=2 * math.sqrt(0.1),
    bias_rad_s=math.sqrt(1e-3), solver=ERKSTEP, adaptation=0, gamma_mode=RELATIVE, rho=0.015,
) -> dict:  # fmt: skip
    """HEKF and HREKF: standard deviations of a sample at 100 Hz in units of gravity and field; Q by densities; the start."""
    root = math.sqrt(0.01)
    both = {
        "preset": PAPER,
        "gamma_relative_rate_1_s": rate_of(rho),
        "accel_noise_per_sqrt_hz": accel * root,
        "mag_noise_per_sqrt_hz": mag * root,
        "quaternion_noise_per_sqrt_s": quaternion,
        "gyro_noise_rad_per_sqrt_s": gyro,
        "gyro_bias_walk_rad_s_per_sqrt_s": bias_walk,
        "start_mode": FROM_ATTITUDE,
        **{f"start_q_nb[{i}]": q for i, q in enumerate(ORIGIN, start=1)},
        "start_sigma_tilt_rad": tilt_rad,
        "start_sigma_heading_rad": heading_rad,
        "start_sigma_bias_rad_s": bias_rad_s,
        "reference_mode": GIVEN,
        "reference_strength_tesla": STRENGTH_TESLA,
        "reference_dip_rad": 60 * DEG,
        "adaptation": adaptation,
        "adaptation_gain": 0.5,
        "solver": solver,
    }
    modes = {"hekf": OFF, "hrekf": gamma_mode}
    return {f"{name}.{key}": value for name, mode in modes.items() for key, value in ({"gamma_mode": mode} | both).items()}


# P0 = 1e-6 I and R = 1e-2 I: found so that the ratios of the paper's Table 1 come back.
FITTED = dict(accel=0.1, mag=0.1, tilt_rad=2e-3, heading_rad=2e-3, bias_rad_s=1e-3, solver=EULER, adaptation=PAPER)
MATCHED_GYRO_DEG_S, MATCHED_WALK_RAD_S, MATCHED_YAW_DEG, MATCHED_TILT_DEG, MATCHED_BIAS_DEG_S = 0.1, 1e-4, 8.0, 3.0, 0.5
UNIFORM = 1 / math.sqrt(3)  # standard deviation of a uniform distribution by its half width

# Name -> what it is, values.
SCENARIOS: dict[str, tuple[str, dict]] = {
    "nominal": ("Honest P0 and R, Q = 1e-6 I", table(60, 5) | sensor() | faults() | filters()),
    "gyro_drift": (
        "A gyro bias that walks and drifts, scale factor 1 %, while the filters believe in Q = 1e-8 I",
        table(60, 5) | sensor(scale=0.01, bias_walk_rad_s=0.05 * DEG, drift_deg_s2=0.02 * UNIFORM) | faults() | filters(quaternion=1e-4, bias_walk=1e-4),
    ),
    "outliers": ("2 % outliers of half a g and half the field", table(60, 5) | sensor() | faults(outliers=0.02) | filters()),
    "magnetic_disturbance": ("0.3 of the field in an unknown direction from 20 to 30 s", table(60, 5) | sensor() | faults(disturbance=0.3) | filters()),
    "iron_residual": ("Hard iron of 3 % and soft iron of 2 % that a calibration has left", table(60, 5) | sensor(hard=0.03, soft=0.02) | faults() | filters()),
    "matched": (
        "White noise and bias walk exactly as the filters are told, honest P0, gamma off: for tests of consistency",
        table(MATCHED_YAW_DEG, MATCHED_TILT_DEG)
        | sensor(gyro_deg_s=MATCHED_GYRO_DEG_S, bias_deg_s=MATCHED_BIAS_DEG_S, scale=0.0, misalignment=0.0, bias_walk_rad_s=MATCHED_WALK_RAD_S)
        | faults()
        | filters(
            quaternion=0.0, gyro=MATCHED_GYRO_DEG_S * DEG * 0.1, bias_walk=MATCHED_WALK_RAD_S, tilt_rad=MATCHED_TILT_DEG * DEG * UNIFORM,
            heading_rad=MATCHED_YAW_DEG * DEG * UNIFORM, bias_rad_s=MATCHED_BIAS_DEG_S * DEG, gamma_mode=OFF,
        ),
    ),
    "fitted": (
        "The paper's Table 1: P0 = 1e-6 I and rho = 0.015 are fitted to it, Robbins-Monro as printed, Euler",
        table(40, 4.5) | sensor() | faults() | filters(**FITTED),
    ),
    "fitted_rho_half": ("fitted, with rho = 0.5", table(40, 4.5) | sensor() | faults() | filters(**FITTED, rho=0.5)),
    "fitted_honest": (
        "fitted, with an honest P0 and no adaptation",
        table(40, 4.5) | sensor() | faults() | filters(accel=0.1, mag=0.1, solver=EULER),
    ),
}  # fmt: skip


def grade_values(name: str) -> dict:
    """A grade over the nominal scenario: its sensor, and filters told of its noise. What it does not name is without error."""
    grade = read_grade(name)
    values = dict.fromkeys(sensor(), 0.0) | {f"sensor.{key}": value for key, value in grade.parameters().items()}
    noise = grade.filter_parameters(STRENGTH_TESLA)
    bias_sigma = math.hypot(grade.values["gyro.bias_sigma_rad_s"], grade.values["gyro.bias_instability_rad_s"])
    told = noise | {"quaternion_noise_per_sqrt_s": 0.0, "start_sigma_bias_rad_s": bias_sigma}
    return values | {f"{component}.{key}": value for component in ("hekf", "hrekf") for key, value in told.items()}


# --------------------------------------------------------------------------------------------- the structure


def _variables() -> dict[str, dict]:
    """Of each component: FMI variables by name."""
    by_fmu = {
        name: {v.name: v for v in fmpy.read_model_description(str(fmu_path(name, 2))).modelVariables}
        for name in set(COMPONENTS.values())
    }
    return {component: by_fmu[name] for component, name in COMPONENTS.items()}


def parameter_units() -> dict[str, str]:
    """By component.parameter."""
    return {
        f"{c}.{v.name}": v.unit or ""
        for c, variables in _variables().items()
        for v in variables.values()
        if v.causality == "parameter"
    }


def _connector(variable, kind: str) -> str:
    types = {"Real": "Real", "Boolean": "Boolean"}
    element = types.get(variable.type, "Integer")
    unit = f" unit={quoteattr(variable.unit)}" if element == "Real" and variable.unit in BASE_UNITS else ""
    return f'          <ssd:Connector name={quoteattr(variable.name)} kind="{kind}"><ssc:{element}{unit}/></ssd:Connector>\n'


def _component(name: str, variables: dict, parameters: list[str]) -> str:
    lines = [
        f'      <ssd:Component name="{name}" description={quoteattr(DESCRIPTIONS[name])} type="application/x-fmu-sharedlibrary"'
        f' source="resources/{COMPONENTS[name]}.fmu" implementation="CoSimulation">\n        <ssd:Connectors>\n'
    ]
    for v in variables.values():
        if v.name in TRUTH + SAMPLES and v.causality == "input":
            lines.append(_connector(v, "input"))
        elif v.causality == "output":
            lines.append(_connector(v, "output"))
        elif v.name in parameters or v.name == "seed" or (name in FILTERS and v.name == "sampling_mode"):
            lines.append(_connector(v, "parameter"))
    lines.append("        </ssd:Connectors>\n")
    # Bound at the component, because that is where every importer looks; all of one name, because some ask for it.
    nominal = {key.partition(".")[2]: value for key, value in SCENARIOS["nominal"][1].items() if key.startswith(name + ".")}
    if name in FILTERS:
        nominal = {"sampling_mode": COUNTER} | nominal
    lines.append(
        "        <ssd:ParameterBindings>\n          <ssd:ParameterBinding>\n            <ssd:ParameterValues>\n"
        '              <ssv:ParameterSet version="1.0" name="nominal">\n                <ssv:Parameters>\n'
    )
    for key, value in nominal.items():
        element = value_element(value, variables[key].unit or "")
        lines.append(f"                  <ssv:Parameter name={quoteattr(key)}>{element}</ssv:Parameter>\n")
    lines.append(
        "                </ssv:Parameters>\n              </ssv:ParameterSet>\n            </ssd:ParameterValues>\n"
        "          </ssd:ParameterBinding>\n        </ssd:ParameterBindings>\n"
    )
    lines.append("      </ssd:Component>\n")
    return "".join(lines)


def structure() -> str:
    """The text of SystemStructure.ssd."""
    every = _variables()
    bound = {key for _, values in SCENARIOS.values() for key in values} | {key for grade in GRADES for key in grade_values(grade)}
    connections = [("turntable", "sensor", name) for name in TRUTH] + [("sensor", f, name) for f in FILTERS for name in SAMPLES]
    units = {v.unit for variables in every.values() for v in variables.values() if v.unit}
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>\n<ssd:SystemStructureDescription version="1.0" name="turntable"\n'
        '    description="A turntable, its sensors, and three filters side by side"\n'
        '    xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"\n'
        '    xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon"\n'
        '    xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues">\n'
        '  <ssd:System name="turntable">\n    <ssd:Elements>\n'
    ]
    for name, variables in every.items():
        lines.append(_component(name, variables, [key.partition(".")[2] for key in bound if key.startswith(name + ".")]))
    lines.append("    </ssd:Elements>\n    <ssd:Connections>\n")
    for start, end, name in connections:
        lines.append(
            f'      <ssd:Connection startElement="{start}" startConnector={quoteattr(name)} endElement="{end}" endConnector={quoteattr(name)}/>\n'
        )
    lines.append("    </ssd:Connections>\n  </ssd:System>\n  <ssd:Units>\n" + unit_elements(units, "    ") + "  </ssd:Units>\n")
    lines.append('  <ssd:DefaultExperiment startTime="0" stopTime="60"/>\n</ssd:SystemStructureDescription>\n')
    return "".join(lines)


def write_system(folder: Path) -> None:
    """SystemStructure.ssd, scenarios/*.ssv and grades/*.ssv. The FMUs must be built."""
    units = parameter_units()
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "SystemStructure.ssd").write_text(structure())
    for name, (description, values) in SCENARIOS.items():
        write_parameter_set(folder / "scenarios" / f"{name}.ssv", name, values, units, description)
    for name in GRADES:
        write_parameter_set(
            folder / "grades" / f"{name}.ssv",
            name,
            grade_values(name),
            units,
            f"Sensors of the grade {name}, filters told of their noise",
        )


if __name__ == "__main__":
    write_system(Path(sys.argv[1]))
