"""Runs a recording through the FMU of a filter: Co-Simulation by steps, Model Exchange by fmpy's CVODE.

fmpy's simulate_fmu looks inputs up by a linear search in every step and adds a step at every change of a discrete input,
which is quadratic for a recording; so the loop is ours. All real inputs go in by one call and all real outputs come out
by one, in buffers that are made once.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Protocol

import numpy as np

from hnav.filters.attitude_answers import Run, empty_run
from hnav.filters.attitude_recording import Progress, Speeds, speeds_of
from hnav.filters.filter_answers import HEALTH_SENSORS
from hnav.filters.options import Options, option_table
from hnav.fmi.fmus import Fmu, fmu_path, parameter_values
from hnav.fmi.points import check_points
from hnav.io.recordings import Recording
from hnav.rotations import euler_rad

# The FMU of each filter.
MODELS = {"hrekf": "Hrekf", "ahrs": "Ahrs"}
SENSORS = {"gyro": "gyro.rate", "accel": "accel.force", "mag": "mag.field"}
COUNTS = (
    "gyro_used", "accel_used", "mag_used", "accel_gated", "mag_gated", "late", "non_finite", "zero", "missed",
    "corrections", "gamma_raised", "covariance_repaired",
)  # fmt: skip
# Outputs that are read after each sample, and their columns in the table.
OUTPUTS = (("post.q", 4), ("post.bias", 3), ("post.sigma", 6))
Q, BIAS, SIGMA, BIAS_SIGMA, NIS = slice(0, 4), slice(4, 7), slice(7, 10), slice(10, 13), slice(13, 15)
FLAGS = ("align.tilt_ready", "align.heading_ready", "gate.accel_ok", "gate.mag_ok")
READY, GATES = slice(0, 2), slice(2, 4)
HEALTH = tuple(f"health.{sensor}.state" for sensor in HEALTH_SENSORS)
PROGRESS_POINTS = 500


def filter_parameters(filter: str, settings: Mapping[str, str], preset: str) -> dict[str, float | int | str]:
    """Settings as the parameters of the filter's FMU, choices by name. Raises HnavError.

    All options are written, those of the preset too: an option at its start value does not override the parameter preset.
    """
    options = Options(filter, preset, **settings)
    table = option_table(filter)
    return {"sampling_mode": "counter"} | parameter_values(table, {name: getattr(options, name) for name in table})


def run_fmu(
    recording: Recording,
    filter: str,
    engine: str,
    settings: Mapping[str, str],
    preset: str = "default",
    step_s: float | None = None,
    progress: Progress | None = None,
) -> Run:
    """engine: fmi2-cs, fmi2-me, fmi3-cs or fmi3-me. Samples are marked by their counters and stamped with their times.

    step_s None: a communication point at every sample. Otherwise a grid of that step, and a sample is delivered at the
    first point at or after its time; of several samples between two points a sensor delivers the newest, and the rows
    of the others are NaN.
    """
    version, kind = engine.split("-")
    with Fmu(fmu_path(MODELS[filter], int(version[3:])), model_exchange=kind == "me") as fmu:
        for name, value in filter_parameters(filter, settings, preset).items():
            fmu.set(name, value)
        fmu.initialise(float(recording.t_s[0]))
        points, rows = communication_points(recording.t_s, step_s)
        speeds = speeds_of(recording, Options(filter, preset, **settings))
        samples, estimates = _Samples(fmu, recording, speeds), _Estimates(fmu, len(recording.t_s))
        loop: _Loop = _ModelExchangeLoop(fmu, points) if kind == "me" else _CoSimulationLoop(fmu, points)
        begin = time.perf_counter()
        delivered = -1
        for k, row in enumerate(rows):
            fresh = row > delivered
            if fresh:
                samples.deliver(row)
            loop.process(k)
            if fresh:
                estimates.note(row)
                delivered = row
            loop.go_on(k)
            if progress and k % PROGRESS_POINTS == 0:
                progress(int(row), len(recording.t_s))
        seconds = time.perf_counter() - begin
        if progress:
            progress(len(recording.t_s), len(recording.t_s))
        counts = {name: int(fmu.get(f"count.{name}")) for name in COUNTS} | {"rhs_evals": int(fmu.get("solver.rhs_evals"))}
    run = estimates.run(recording, samples.present)
    run.options, run.us_per_sample, run.counts = Options(filter, preset, **settings), 1e6 * seconds / len(rows), counts
    return run


def communication_points(t_s: np.ndarray, step_s: float | None) -> tuple[np.ndarray, np.ndarray]:
    """Times of the points, and for each the row of the newest sample that is not later."""
    if step_s is None:
        last_step = t_s[-1] - t_s[-2] if len(t_s) > 1 else 0.01
        return np.append(t_s, t_s[-1] + last_step), np.arange(len(t_s))
    check_points((t_s[-1] - t_s[0]) / step_s, 0, step_s, float(np.abs(t_s).max()))
    # k step + start in one rounding, and an end beyond the last sample.
    points = t_s[0] + step_s * np.arange(int(np.ceil((t_s[-1] - t_s[0]) / step_s)) + 2)
    rows = np.searchsorted(t_s, points[:-1] * (1 + 1e-15), side="right") - 1
    return points, rows


# --------------------------------------------------------------------------------------------- inputs and outputs


class _Samples:
    """Sets the samples of a recording as inputs of an FMU; a sensor's counter increases with each new sample."""

    def __init__(self, fmu: Fmu, recording: Recording, speeds: Speeds | None):
        arrays = [recording.rate_b_rad_s, recording.force_b_m_s2]
        if recording.field_b_tesla is not None:
            arrays.append(recording.field_b_tesla)
        sensors = list(SENSORS)[: len(arrays)]
        names = [f"{SENSORS[s]}[{i}]" for s in sensors for i in (1, 2, 3)]
        if speeds is not None:
            fmu.set("wheel.valid", True)
            sensors.append("wheel")
            names += ["wheel.speed", "wheel.sigma"]
            arrays.append(np.stack([speeds.m_s, np.where(np.isnan(speeds.m_s), np.nan, speeds.sigma_m_s)], axis=1))
        self._fresh = np.stack([~np.isnan(a).all(axis=1) for a in arrays], axis=1)  # n x sensors
        self.present = self._fresh if speeds is None else self._fresh[:, :-1]  # without the speed
        names += [f"{s}.t_meas" for s in sensors]
        self._set_inputs, self._inputs = fmu.block("Set", "real", names)
        self._set_counters, self._counters = fmu.block("Set", "integer", [f"{s}.sample" for s in sensors])
        self._values = np.concatenate([*arrays, np.repeat(recording.t_s[:, None], len(sensors), axis=1)], axis=1)

    def deliver(self, row: int) -> None:
        self._inputs[:] = self._values[row]
        np.add(self._counters, self._fresh[row], out=self._counters)
        self._set_inputs()
        self._set_counters()


class _Estimates:
    """Outputs of an FMU just after each of n samples."""

    def __init__(self, fmu: Fmu, n: int):
        names = [f"{name}[{i}]" for name, size in OUTPUTS for i in range(1, size + 1)] + ["nis.accel", "nis.mag"]
        self._table = np.full((n, len(names)), np.nan)
        self._flags = np.zeros((n, len(FLAGS)), bool)
        self._health = empty_run(np.empty(n)).health
        parts = (("real", names, self._table), ("boolean", FLAGS, self._flags), ("enumeration", HEALTH, self._health))
        self._parts = [(*fmu.block("Get", kind, of_kind), columns) for kind, of_kind, columns in parts]

    def note(self, row: int) -> None:
        for get, values, columns in self._parts:
            get()
            columns[row] = values

    def run(self, recording: Recording, present: np.ndarray) -> Run:
        """Sets rows before the start to NaN, and NIS where no sample was used."""
        table = self._table
        started = np.isfinite(table[:, 0]) & (table[:, SIGMA.start] < np.pi)  # sigma is pi before the start
        table[~started] = np.nan
        nis = table[:, NIS].copy()
        nis[nis == 0] = np.nan
        for column in range(present.shape[1] - 1):  # force and, if there is one, field
            nis[~present[:, column + 1], column] = np.nan
        return Run(
            t_s=recording.t_s, q_nb=table[:, Q], euler_rad=euler_rad(table[:, Q]), sigma_rad=table[:, SIGMA],
            gyro_bias_rad_s=table[:, BIAS], gyro_bias_sigma_rad_s=table[:, BIAS_SIGMA], accel_nis=nis[:, 0], mag_nis=nis[:, 1],
            ready=self._flags[:, READY], accepted=self._flags[:, GATES] & np.isfinite(nis), health=self._health,
        )  # fmt: skip


# --------------------------------------------------------------------------------------------- both interfaces


class _Loop(Protocol):
    def process(self, k: int) -> None:
        """Processes the inputs that were set at point k."""

    def go_on(self, k: int) -> None:
        """Steps to point k + 1."""


class _CoSimulationLoop:
    """Inputs at a point, then the step that processes them."""

    def __init__(self, fmu: Fmu, points: np.ndarray):
        self._fmu, self._points = fmu, points

    def process(self, k: int) -> None:
        t = float(self._points[k])
        self._fmu.do_step(t, float(self._points[k + 1]) - t)

    def go_on(self, k: int) -> None:
        pass


class _ModelExchangeLoop:
    """Inputs in event mode, the event, then fmpy's CVODE to the next point."""

    def __init__(self, fmu: Fmu, points: np.ndarray):
        self._fmu, self._points = fmu, points
        self._solver = fmu.solver(float(points[0]))

    def process(self, k: int) -> None:
        self._fmu.update_discrete_states()

    def go_on(self, k: int) -> None:
        f, t, end = self._fmu.fmu, float(self._points[k]), float(self._points[k + 1])
        self._fmu.call(f.enterContinuousTimeMode)
        self._solver.reset(t)
        self._fmu.call(self._solver.step, t, end)
        self._fmu.call(f.setTime, end)
        self._fmu.call(f.completedIntegratorStep)
        self._fmu.call(f.enterEventMode)
