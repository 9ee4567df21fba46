"""A filter run over a recording, in the form of a simulation for the panels: the signals by the names of the FMUs' variables.

The recording is a component `sensor`, its reference attitude a component `reference`, and the filter goes by its name. Times
count from the first row.
"""

from __future__ import annotations

import datetime

import numpy as np

from hnav import __version__
from hnav.filters.filter_answers import HEALTH_SENSORS
from hnav.filters.run_summary import NIS_DIMENSIONS
from hnav.reports.recording_run import RecordingRun
from hnav.rotations import quaternion_product, rotated
from hnav.systems.results import Run
from hnav.systems.run_views import TRUTH_ATTITUDE

SENSOR, REFERENCE = "sensor", "reference"
FIELD_N = "field.n"  # of the component sensor: the measured field in navigation axes, down positive
EPOCH_S = (1e8, 1e10)  # times within are taken for seconds since 1970


def view(run: RecordingRun) -> Run:
    """The run in the form of the panels."""
    result, t_s = run.result, run.recording.t_s - run.recording.t_s[0]
    columns = {f"{run.filter}.{name}": values for name, values in _filter_columns(run).items()}
    components: dict[str, dict[str, str]] = {run.filter: {}}
    if run.recording.field_b_tesla is not None:
        components[SENSOR] = {}
        columns |= _indexed(f"{SENSOR}.mag.field", run.recording.field_b_tesla)
        columns |= _indexed(f"{SENSOR}.{FIELD_N}", field_n(run))
    reference = run.reference_q_nb
    if reference is not None:
        components[REFERENCE] = {}
        columns |= _indexed(f"{REFERENCE}.{TRUTH_ATTITUDE}", reference)
    about = {
        "system": run.recording.name, "components": components, "parameters": {}, "lost": {}, "failure": "", "wall_s": {},
        "versions": {"hnav": __version__}, "frame": run.frame, "axes": run.axes, "truth": run.reference,
        "innovation_dimensions": dict(zip(("accel", "mag"), NIS_DIMENSIONS[run.filter])),
    }  # fmt: skip
    assert len(result.t_s) == len(t_s), "the result is that of the recording"
    return Run(t_s, columns, {}, about)


def _indexed(name: str, values: np.ndarray) -> dict[str, np.ndarray]:
    return {f"{name}[{i + 1}]": values[:, i] for i in range(values.shape[1])}


def _filter_columns(run: RecordingRun) -> dict[str, np.ndarray]:
    result = run.result
    columns = {
        **_indexed("att.q", result.q_nb), **_indexed("att.sigma", result.sigma_rad), **_indexed("bias.gyro", result.gyro_bias_rad_s),
        **_indexed("bias.gyro_sigma", result.gyro_bias_sigma_rad_s), "align.started": np.isfinite(result.q_nb[:, 0]).astype(float),
        "align.tilt_ready": result.ready[:, 0].astype(float), "align.heading_ready": result.ready[:, 1].astype(float),
    }  # fmt: skip
    for column, (sensor, nis) in enumerate((("accel", result.accel_nis), ("mag", result.mag_nis))):
        used = np.isfinite(nis)
        columns |= {f"nis.{sensor}": nis, f"count.{sensor}_used": np.cumsum(used).astype(float)}
        if result.accepted is not None and used.any():
            # The values of the last sample are held; before the first sample there are none.
            columns[f"gate.{sensor}_ok"] = ((~used | result.accepted[:, column]) & (np.cumsum(used) > 0)).astype(float)
    return columns | {f"health.{sensor}.state": result.health[:, i] for i, sensor in enumerate(HEALTH_SENSORS)}


def field_n(run: RecordingRun) -> np.ndarray:
    """The measured field, n x 3 in tesla: two horizontal components and the one downwards; NaN without attitude or field."""
    field = run.recording.needed("field_b_tesla")
    q_ns, options = run.result.q_nb, run.result.options
    if options is not None:
        q_ns = quaternion_product(q_ns, np.broadcast_to(options.q_body_sensor, q_ns.shape))
    turned = rotated(q_ns, field)
    turned[:, 2] *= 1 if run.frame == "ned" else -1
    return turned


def rates(run: RecordingRun) -> list[tuple[str, str]]:
    """Name, rate and number of samples of each sensor; empty without a recording."""
    found = []
    for sensor in HEALTH_SENSORS:
        at_s, _ = run.recording.samples(sensor)
        if len(at_s) > 1 and at_s[-1] > at_s[0]:
            said = f"{1 / np.median(np.diff(at_s)):.4g} Hz, {len(at_s)} samples, longest gap {np.diff(at_s).max():.3g} s"
            unit = run.recording.origin.units.get(sensor) if run.recording.origin else None
            found.append((sensor, f"{said}, read as {unit}" if unit else said))
    return found


def began(first_s: float) -> str:
    """When a recording began, where its times can be read as instants; else its first time as a number."""
    if not EPOCH_S[0] < first_s < EPOCH_S[1]:
        return f"{round(first_s, 3):.10g} s"
    return datetime.datetime.fromtimestamp(first_s, datetime.UTC).strftime("%Y-%m-%d %H:%M:%S UTC")
