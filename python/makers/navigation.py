"""The files of the systems navigation and gyrocompass: models/systems, written from their FMUs and the presets of the Ins.

python -m makers.navigation FOLDER

Vehicle -> ImuMagSensor, Gnss, Baro, Wheel -> Ins, and a body at rest -> ImuMagSensor -> Ins, which finds north by the rate of the Earth.
The heading at the start is any. The inertial sensors have the noise and the biases that the preset of the Ins states.
"""

from __future__ import annotations

import sys
from pathlib import Path

from hnav.filters.options import CAR_ACROSS_M_S, INS_PRESETS, Options
from hnav.io.sensors import DEG
from hnav.units import G_M_S2
from makers.system_files import NOMINAL, Definition, Values

PERIOD_S = 0.01
ROOT_HOUR = 60.0
"""Root seconds."""
GRADE = "industrial"
STAMP_ERROR_S = 0.05
HEIGHT_M = 50.0
OUTLIERS = 0.01
MARKS = ("sample", "t_meas", "valid")
INERTIAL = [
    name
    for sensor, value in (("gyro", "rate"), ("accel", "force"))
    for name in [*(f"{sensor}.{value}[{i}]" for i in (1, 2, 3)), *(f"{sensor}.{mark}" for mark in MARKS)]
]
READ_BY_SENSOR = [
    f"truth.{name}[{i}]" for name, n in (("q", 4), ("rate", 3), ("force", 3), ("field", 3)) for i in range(1, n + 1)
]
OF_BODY = [
    "truth.latitude",
    *(f"truth.{name}[{i}]" for name, n in (("velocity", 3), ("q", 4), ("rate", 3)) for i in range(1, n + 1)),
]
# OMSimulator assigns a name that begins with a component name to that component: no component has the name of a group of
# variables.
READ = {"gnss_receiver": [*OF_BODY, "truth.longitude", "truth.height"], "barometer": ["truth.height"], "wheel_sensor": OF_BODY}
STATED = {
    "gnss_receiver": [
        *("gnss.latitude", "gnss.longitude", "gnss.height"), *(f"gnssvel.velocity[{i}]" for i in (1, 2, 3)),
        *(f"{name}.sigma[{i}]" for name in ("gnss", "gnssvel") for i in (1, 2, 3)),
        *(f"{name}.{mark}" for name in ("gnss", "gnssvel") for mark in MARKS),
    ],
    "barometer": ["baro.pressure", "baro.sigma", *(f"baro.{mark}" for mark in MARKS)],
    "wheel_sensor": ["wheel.speed", "wheel.sigma", *(f"wheel.{mark}" for mark in MARKS)],
}  # fmt: skip
INERTIAL_WIRES = [*(("vehicle", "sensor", name) for name in READ_BY_SENSOR), *(("sensor", "ins", name) for name in INERTIAL)]
COMPONENTS = {
    "vehicle": ("Vehicle", "truth"),
    "sensor": ("ImuMagSensor", "samples of rate and force with counters and time stamps"),
    "gnss_receiver": ("Gnss", "fixes of satellites"),
    "barometer": ("Baro", "pressure of the air"),
    "wheel_sensor": ("Wheel", "speed by wheels"),
    "ins": ("Ins", "position, velocity and attitude, from any heading"),
}
# Part of every scenario instead of a binding beside it: fmpy reads a scenario alone.
ALWAYS: Values = {"vehicle.mean_over_s": PERIOD_S, "ins.sampling_mode": "counter"}


def grade_values(name: str) -> Values:
    """A preset of the Ins, and the inertial sensors for it."""
    stated = Options("ins", name)
    return {
        "sensor.gyro.noise_deg_per_sqrt_h": stated.gyro_noise_rad_per_sqrt_s / DEG * ROOT_HOUR,
        "sensor.gyro.random_walk_deg_per_h_per_sqrt_h": stated.gyro_bias_walk_rad_s_per_sqrt_s / DEG * 3600 * ROOT_HOUR,
        "sensor.gyro.bias_sigma_rad_s": stated.start_sigma_gyro_bias_rad_s,
        "sensor.gyro.scale_factor_sigma": stated.start_sigma_gyro_scale,
        "sensor.gyro.misalignment_sigma_rad": stated.start_sigma_gyro_misalignment_rad,
        "sensor.accel.noise_ug_per_sqrt_hz": stated.accel_noise_m_s_per_sqrt_s / G_M_S2 * 1e6,
        "sensor.accel.random_walk_ug_per_sqrt_h": stated.accel_bias_walk_m_s2_per_sqrt_s / G_M_S2 * 1e6 * ROOT_HOUR,
        "sensor.accel.bias_sigma_m_s2": stated.start_sigma_accel_bias_m_s2,
        "ins.preset": name,
    }


def _grades() -> dict[str, tuple[str, Values]]:
    return {
        name: (f"Inertial sensors of the grade {name}, and the filter with its preset", grade_values(name))
        for name in INS_PRESETS
    }


# --------------------------------------------------------------------------------------------- navigation


def _drive(
    kind: str = "car",
    latitude_deg: float = 45.0,
    longitude_deg: float = 0.0,
    heading_deg: float = 0.0,
    unknown_deg: float = 180.0,
) -> Values:
    """Parameters of motion and place; only a car has wheels."""
    on_wheels = kind == "car"
    return {
        "vehicle.motion.kind": kind,
        "vehicle.place.latitude_rad": latitude_deg * DEG,
        "vehicle.place.longitude_rad": longitude_deg * DEG,
        "vehicle.motion.heading_rad": heading_deg * DEG,
        "vehicle.motion.heading_unknown_rad": unknown_deg * DEG,
        "wheel_sensor.wheel.dropout": 0.0 if on_wheels else 1.0,
        "ins.aiding.car_across_m_s": CAR_ACROSS_M_S if on_wheels else 0.0,
    }


def _satellites(
    outage_s: float = 0.0, jump_m: float = 0.0, jump_s: tuple[float, float] = (90.0, 100.0), latency_s: float = PERIOD_S
) -> Values:
    """A fix arrives with the inertial sample of the same time stamp. Scenarios: an open sky with an outage from 80 s on,
    positions with an offset to the north, late fixes.
    """
    return {
        "gnss_receiver.gnss.stamp_error_s": STAMP_ERROR_S,
        "gnss_receiver.gnss.outlier_probability": OUTLIERS,
        "gnss_receiver.gnss.outage_start_s": 80.0,
        "gnss_receiver.gnss.outage_length_s": outage_s,
        "gnss_receiver.gnss.jump_start_s": jump_s[0],
        "gnss_receiver.gnss.jump_stop_s": jump_s[1],
        "gnss_receiver.gnss.jump_n_m[1]": jump_m,
        "gnss_receiver.gnss.latency_s": latency_s,
        "ins.timing.horizon_s": 0.3 if latency_s > PERIOD_S else 0.0,
    }


def _scenario(text: str, drive: Values, satellites: Values) -> tuple[str, Values]:
    return text, ALWAYS | drive | satellites | grade_values(GRADE)


NAVIGATION = Definition(
    name="navigation",
    description="A vehicle over the turning Earth, its sensors, and the navigation filter, which starts with any heading",
    components=COMPONENTS,
    connections=[
        *INERTIAL_WIRES,
        *(("vehicle", sensor, name) for sensor, names in READ.items() for name in names),
        *((sensor, "ins", name) for sensor, names in STATED.items() for name in names),
    ],
    scenarios={
        NOMINAL: _scenario("A car in a town, with satellites, wheels and pressure", _drive(), _satellites()),
        "outage_30": _scenario("The car without satellites from 80 to 110 s", _drive(), _satellites(outage_s=30.0)),
        "outage_60": _scenario("The car without satellites from 80 to 140 s", _drive(), _satellites(outage_s=60.0)),
        "jump": _scenario("The car, and positions 100 m off from 90 to 100 s", _drive(), _satellites(jump_m=100.0)),
        "late_200ms": _scenario("The car, and fixes that come 200 ms late", _drive(), _satellites(latency_s=0.2)),
        "ship": _scenario("A ship in a swell, with satellites and pressure", _drive("ship"), _satellites()),
        "aircraft_turn": _scenario(
            "An aircraft that banks into its turns, climbs and sinks, with satellites and pressure", _drive("aircraft"), _satellites()
        ),
        "pole": _scenario(
            "The aircraft by the north pole, which it starts towards from 2 km",
            _drive("aircraft", latitude_deg=89.98, unknown_deg=10.0), _satellites(),
        ),
        "date_line": _scenario(
            "The aircraft over the date line, which it starts towards from 1 km",
            _drive("aircraft", longitude_deg=179.99, heading_deg=90.0, unknown_deg=10.0), _satellites(),
        ),
    },
    grades=_grades(),
    bound_always={},
    stop_s=150,
)  # fmt: skip

# --------------------------------------------------------------------------------------------- gyrocompass


def _at_rest(latitude_deg: float = 45.0, sway: float = 1.0, vibration_m_s2: float = 0.0, grade: str = "navigation") -> Values:
    return (
        ALWAYS
        | {
            "vehicle.motion.kind": "rest",
            "vehicle.place.latitude_rad": latitude_deg * DEG,
            "vehicle.place.height_m": HEIGHT_M,
            "vehicle.motion.sway": sway,
            "vehicle.motion.vibration_m_s2": vibration_m_s2,
            "ins.start.start_place": "given",
            "ins.start.start_latitude_rad": latitude_deg * DEG,
            "ins.start.start_height_m": HEIGHT_M,
            "ins.rest.rest_velocity_noise_m_s": 0.01,
        }
        | grade_values(grade)
    )


GYROCOMPASS = Definition(
    name="gyrocompass",
    description="A body at rest whose place is given, and the navigation filter, which finds north by the rate of the Earth",
    components={name: COMPONENTS[name] for name in ("vehicle", "sensor", "ins")},
    connections=INERTIAL_WIRES,
    scenarios={
        NOMINAL: ("Navigation grade, a base that sways by millimetres", _at_rest()),
        "still": ("The same on a base that does not sway", _at_rest(sway=0.0)),
        "swaying": ("The same on a base that sways by a centimetre", _at_rest(sway=4.0)),
        "vibration": ("The same on a base that sways and vibrates as beside an engine that idles", _at_rest(vibration_m_s2=0.2)),
        "latitude_80": ("The same ten degrees from the pole, where the Earth turns heading away from north by less", _at_rest(80.0)),
        "tactical": ("Tactical grade: its bias is as large as the rate of the Earth that shows north, and the heading is not called ready", _at_rest(grade="tactical")),
    },
    grades=_grades(),
    bound_always={},
    stop_s=400,
)  # fmt: skip
SYSTEMS = (NAVIGATION, GYROCOMPASS)

if __name__ == "__main__":
    for system in SYSTEMS:
        system.write(Path(sys.argv[1]) / system.name)
