"""What drives the filters in simulations, by the C API: turntable, sensors with faults, aircraft with an INS."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from studies.compare.ins_error import aircraft_data
from studies.compare.native import Log, Object, Options
from studies.compare.scenario import Arrays, Named, Settings, given
from studies.compare.side import Side

SENSORS = (0, 1, 2)  # gyroscope, accelerometer, magnetometer
TUMBLING: Settings = {
    "roll.motion": "sine", "roll.amplitude_rad": 0.7, "roll.period_s": 3.0, "pitch.motion": "step", "pitch.start_s": 2.0,
    "pitch.amplitude_rad": 0.5, "pitch.rate_rad_s": 0.3, "yaw.motion": "triangle", "yaw.amplitude_rad": 1.0,
    "yaw.rate_rad_s": 0.5, "roll.unknown_rad": 0.1, "pitch.unknown_rad": 0.1, "yaw.unknown_rad": 1.0,
    "declination_rad": 0.05, "seed": 17,
}  # fmt: skip


def open_table(side: Side, **settings: Any) -> Object:
    return Object(side.library, "turntable", "hnav_turntable_create", Options(side.library, "turntable", **settings).struct)


def turntable(side: Side, **settings: Any) -> Arrays:
    table, library = open_table(side, **settings), side.library
    log, truth, corner = Log(library), library.argument("hnav_turntable_at", 2), library.ffi.new("double *")
    rng = np.random.default_rng(4)
    q, force, field = (np.zeros(n) for n in (4, 3, 3))
    for t_s in np.sort(rng.uniform(0, 30, 1500)).tolist():
        log.add("at.status", table.status("at", t_s, truth))
        log.struct("at", truth)
        log.add("next_corner.status", table.status("next_corner_s", t_s, corner))
        log.add("next_corner_s", corner[0])
        log.add("in_piece.status", table.status("in_piece", t_s, t_s + 0.1, truth))
        log.struct("in_piece", truth)
        q[:] = rng.normal(size=4)
        log.add("seen_from.status", table.status("seen_from", *map(library.pointer, (q, force, field))))
        log.add("seen_force", force.copy())
        log.add("seen_field", field.copy())
    return log.columns()


# --------------------------------------------------------------------------------------------- sensors

CONSUMER: Settings = {
    "gyro.noise_deg_per_sqrt_h": 0.5, "gyro.bias_instability_rad_s": 1e-4, "gyro.random_walk_deg_per_h_per_sqrt_h": 5.0,
    "gyro.bias_rad_s": [0.01, -0.02, 0.005], "gyro.bias_sigma_rad_s": 0.01, "gyro.drift_rad_s2": [1e-5, 0, -1e-5],
    "gyro.drift_sigma_rad_s2": 1e-5, "gyro.scale_factor": [0.01, 0, -0.01], "gyro.scale_factor_sigma": 0.01,
    "gyro.misalignment_rad": [0.01, 0, 0.005, 0, -0.01, 0.002], "gyro.misalignment_sigma_rad": 0.005,
    "gyro.g_sensitivity_deg_per_h_per_g": 20.0, "gyro.range_rad_s": 0.6, "gyro.resolution_rad_s": 1e-3,
    "accel.noise_ug_per_sqrt_hz": 300.0, "accel.bias_instability_m_s2": 1e-3, "accel.random_walk_ug_per_sqrt_h": 50.0,
    "accel.bias_m_s2": [0.05, 0, -0.03], "accel.bias_sigma_m_s2": 0.05, "accel.drift_sigma_m_s3": 1e-4,
    "accel.scale_factor_sigma": 0.01, "accel.misalignment_sigma_rad": 0.005, "accel.range_m_s2": 9.0,
    "accel.resolution_m_s2": 0.01, "mag.noise_nt_per_sqrt_hz": 100.0, "mag.bias_instability_tesla": 1e-8,
    "mag.random_walk_nt_per_sqrt_h": 100.0, "mag.bias_sigma_tesla": 1e-6, "mag.drift_sigma_tesla_s": 1e-9,
    "mag.scale_factor_sigma": 0.01, "mag.misalignment_sigma_rad": 0.005, "mag.hard_iron_tesla": [2e-6, 0, -1e-6],
    "mag.hard_iron_sigma_tesla": 1e-6, "mag.soft_iron": [0.02, 0, 0.01, 0, -0.01, 0, 0, 0.01, 0.03], "mag.soft_iron_sigma": 0.01,
    "mag.range_tesla": 5e-5, "mag.resolution_tesla": 1e-7, "seed": 5,
}  # fmt: skip
DELIVERY: Settings = {
    "gyro.latency_s": 0.004, "gyro.jitter_s": 0.002, "gyro.dropout": 0.05, "gyro.period_s": 0.01, "accel.period_s": 0.013,
    "accel.latency_s": 0.02, "accel.jitter_s": 0.004, "accel.dropout": 0.1, "mag.period_s": 0.05, "mag.latency_s": 0.2,
    "mag.dropout": 0.2, "seed": 6, "gyro.noise_deg_per_sqrt_h": 0.5,
}  # fmt: skip
FAULTS: Settings = {
    "fault.mag_disturbance.start_s": 2.0, "fault.mag_disturbance.stop_s": 4.0,
    "fault.mag_disturbance.field_n_tesla": [1e-5, 0, 5e-6], "fault.mag_disturbance.strength_tesla": 2e-5,
    "fault.outliers.start_s": 1.0, "fault.outliers.stop_s": 8.0, "fault.outliers.probability": 0.1,
    "fault.outliers.gyro_sigma_rad_s": 1.0, "fault.outliers.accel_sigma_m_s2": 5.0, "fault.outliers.mag_sigma_tesla": 2e-5,
    "fault.stuck.start_s": 5.0, "fault.stuck.stop_s": 6.0, "fault.stuck.sensor": "accel", "fault.stuck.axis": 2,
    "fault.bias_jump.start_s": 3.0, "fault.bias_jump.stop_s": 7.0, "fault.bias_jump.gyro_rad_s": [0.1, 0, -0.1],
    "fault.bias_jump.accel_m_s2": [0.5, 0, 0], "fault.bias_jump.mag_tesla": [0, 1e-6, 0],
    "fault.noise_increase.start_s": 4.0, "fault.noise_increase.stop_s": 9.0, "fault.noise_increase.gyro_factor": 5.0,
    "fault.noise_increase.accel_factor": 3.0, "fault.noise_increase.mag_factor": 4.0,
}  # fmt: skip
SENSOR_SETTINGS: dict[str, Settings] = {
    "exact": {},
    "consumer": CONSUMER,
    "delivery": DELIVERY,
    "faults": CONSUMER | DELIVERY | FAULTS,
}


def open_sensor(side: Side, **settings: Any) -> Object:
    options = Options(side.library, "imu_mag_sensor", **settings)
    return Object(side.library, "imu_mag_sensor", "hnav_imu_mag_sensor_create", options.struct, 0.1)


def sensor(side: Side, **settings: Any) -> Arrays:
    """On the tumbling table for 10 s at uneven steps; saved and loaded at 3 s, reset at 7 s."""
    table, target, library = open_table(side, **TUMBLING), open_sensor(side, **settings), side.library
    truth = library.argument("hnav_turntable_at", 2)
    reading, number = library.argument("hnav_imu_mag_sensor_reading", 2), library.ffi.new("double *")
    log, rng = Log(library), np.random.default_rng(8)
    times = np.cumsum(rng.choice([0.001, 0.01, 0.01, 0.01, 0.02], 1000))
    for k, t_s in enumerate(times.tolist()):
        if k == 300:
            state = target.save()
            target = open_sensor(side, **settings)
            target.load(state)
        if k == 700:
            target.call("reset")
        table.call("at", t_s, truth)
        log.add("sample.status", target.status("sample", t_s, truth))
        log.add("advance.status", target.status("advance", t_s))
        log.add("next_event.status", target.status("next_event_s", number))
        log.add("next_event_s", number[0])
        for kind in SENSORS:
            log.add(f"reading.{kind}.status", target.status("reading", kind, reading))
            log.struct(f"reading.{kind}", reading)
            log.add(f"noise_psd.{kind}.status", target.status("noise_psd", kind, number))
            log.add(f"noise_psd.{kind}", number[0])
    return log.columns()


# --------------------------------------------------------------------------------------------- aircraft


def aircraft_fields(axis: str) -> dict[str, Any]:
    """The fields of hnav_aircraft_model of an F-4C, with a gravity error and faults."""
    data = aircraft_data(axis)
    A, B = np.array(data["A_1_s"]), np.array(data["B_1_s"])
    n, m = B.shape
    sigma = np.array(data["ins_error_sigma"])
    waves = [{"amplitude": c["amplitude"], "period_s": c["period_s"], "phase_rad": c["phase_rad"]} for c in data["inputs"]]
    return {
        "nx": n, "nu": m, "interval_s": data["interval_s"], "A_1_s": A, "B_1_s": B,
        "process_noise_per_sqrt_s": np.array(data["process_noise_per_sqrt_s"]),
        "measurement_sigma": np.array(data["measurement_sigma"]),
        "accelerometer_error": {"sigma": sigma, "time_constant_s": np.array(data["ins_error_time_constant_s"], float)},
        "gravity_error": {"sigma": 0.3 * sigma, "time_constant_s": np.full(n, 200.0)},
        "start": 0.01 * np.arange(n), "start_sigma": np.array(data["start_sigma"]), "commands": waves,
        "faults": [{"start_s": 4.0, "stop_s": 6.0, "factor": 1.0 + 2 * i} for i in range(n)],
    }  # fmt: skip


def open_aircraft(side: Side, axis: str, **settings: Any) -> Object:
    library = side.library
    options = Options(library, "aircraft", **settings)
    model = library.argument("hnav_aircraft_create", 2)
    library.assign(model, aircraft_fields(axis))
    return Object(library, "aircraft", "hnav_aircraft_create", options.struct, model)


def aircraft(side: Side, axis: str, **settings: Any) -> Arrays:
    """200 samples in one call, then sample by sample with commands; saved and loaded on the way, then the same flight
    from its beginning."""
    target, library, data = open_aircraft(side, axis, **settings), side.library, aircraft_data(axis)
    n, m = len(data["A_1_s"]), len(data["inputs"])
    widths = {"x": n, "lambda": n, "z": n, "u": m, "noise_factor": n}
    rows: Arrays = {name: np.zeros((200, width)) for name, width in widths.items()}
    sample = library.argument("hnav_aircraft_get_sample", 1)
    library.assign(sample, rows)
    found: Arrays = {"run.status": np.array([target.status("run", 200, library.ffi.NULL, sample)])}
    found |= {f"run.{name}": values for name, values in rows.items()}
    row: Arrays = {name: np.zeros(width) for name, width in widths.items()}
    log, rng = Log(library), np.random.default_rng(9)
    library.assign(sample, row)
    for k in range(150):
        if k == 50:
            state = target.save()
            target = open_aircraft(side, axis, **settings)
            target.load(state)
        if k == 100:
            target.call("reset")
        log.add("step.status", target.status("step", library.pointer(0.01 * rng.normal(size=m))))
        log.add("get_sample.status", target.status("get_sample", sample))
        log.struct("sample", sample)
        for name, values in row.items():
            log.add(name, values.copy())
    return found | log.columns() | _filter_model(target, n, m)


def _filter_model(target: Object, n: int, m: int) -> Arrays:
    library = target.library
    model = library.argument("hnav_aircraft_filter_model", 1)
    status = target.status("filter_model", model)
    shapes = {"A": n * n, "B": n * m, "H": n * n, "An": n * n, "Qw": n * n, "Qv": n * n, "QU": n * n, "P0": n * n}
    matrices = {name: np.array(library.ffi.unpack(getattr(model, name), size)) for name, size in shapes.items()}
    return {"filter_model.status": np.array([status])} | {f"filter_model.{name}": values for name, values in matrices.items()}


# --------------------------------------------------------------------------------------------- the list


def scenarios() -> Iterator[Named]:
    tables: dict[str, Settings] = {"default": {}, "tumbling": TUMBLING, "seed": TUMBLING | {"seed": 3}}
    for name, settings in tables.items():
        yield f"c/turntable/{name}", given(turntable, **settings)
    for name, settings in SENSOR_SETTINGS.items():
        for seed in (0, 5):
            yield f"c/imu_mag_sensor/{name}/{seed}", given(sensor, **settings | {"seed": seed})
    flights: dict[str, Settings] = {"default": {}, "euler": {"euler_colour": 1}, "exact": {"exact_process_noise": 1, "seed": 12}}
    for axis in ("lateral", "longitudinal"):
        for name, settings in flights.items():
            yield f"c/aircraft/{axis}/{name}", given(aircraft, axis, **settings)
