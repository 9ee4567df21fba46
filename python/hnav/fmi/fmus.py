"""The FMUs over a recording, driven by fmpy's FMU classes and, for Model Exchange, fmpy's CVODE.

simulate_fmu looks inputs up by a linear search in every step and adds a step at every change of a discrete input, which
is quadratic for a recording; so the loop is ours. All real inputs go in by one call and all real outputs come out by
one, in buffers that are made once.
"""

from __future__ import annotations

import ctypes as C
import os
import shutil
import threading
import time
from collections.abc import Mapping
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Model, FMU2Slave, defaultCallbacks, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.fmi3 import FMU3Model, FMU3Slave
from fmpy.sundials import CVodeSolver

from hnav.errors import HnavValueError
from hnav.filters.rotations import euler_rad
from hnav.fmi.engines import Progress, Result
from hnav.io.recordings import Recording
from hnav.native.library import FILTERS, PRESETS, option_table
from hnav.places import CHECKOUT, PACKAGE
from hnav.renamed import now_called

MODEL_EXCHANGE_RTOL = 1e-8
# fmpy moves the working directory, which all threads share, while it loads a library.
_LOADING = threading.Lock()
SENSORS = {"gyro": "gyro.rate", "accel": "accel.force", "mag": "mag.field"}
COUNTS = (
    "gyro_used", "accel_used", "mag_used", "accel_gated", "mag_gated", "late", "non_finite", "zero", "missed",
    "corrections", "gamma_raised", "covariance_repaired",
)  # fmt: skip


def fmu_path(name: str, fmi_version: int) -> Path:
    """HNAV_FMUS/fmiN/NAME.fmu, else the one in this package (wheel), else the build of the checkout."""
    folders = [Path(os.environ["HNAV_FMUS"])] if "HNAV_FMUS" in os.environ else [PACKAGE / "fmus", CHECKOUT / "build" / "fmus"]
    for folder in folders:
        path = folder / f"fmi{fmi_version}" / f"{name}.fmu"
        if path.is_file():
            return path
    if new := now_called(name, "fmu"):
        raise HnavValueError("option", f"there is no FMU {name}{new}")
    raise HnavValueError(
        "option", f"{name}.fmu for FMI {fmi_version} is not built: ./run fmus makes it, or set HNAV_FMUS to its folder"
    )


class Fmu:
    """One instance of an FMU, FMI 2 or 3, Co-Simulation or Model Exchange, with the calls both versions share.

    Use as a context manager: the instance and the unpacked archive go when it ends. Errors are HnavError with the
    FMU's own message.
    """

    def __init__(self, path: Path, model_exchange: bool = False, name: str = "instance"):
        self.description = fmpy.read_model_description(str(path), validate=False)
        self.fmi3 = self.description.fmiVersion.startswith("3")
        self.model_exchange = model_exchange
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.messages: list[str] = []
        self._folder = fmpy.extract(str(path))
        kinds = {(False, False): FMU2Slave, (False, True): FMU2Model, (True, False): FMU3Slave, (True, True): FMU3Model}
        interface = self.description.modelExchange if model_exchange else self.description.coSimulation
        arguments = dict(
            guid=self.description.guid, unzipDirectory=self._folder, modelIdentifier=interface.modelIdentifier, instanceName=name
        )
        with _LOADING:
            self.fmu = kinds[self.fmi3, model_exchange](**arguments)
        self._instantiate()

    def _instantiate(self) -> None:
        try:
            if self.fmi3:
                self.fmu.instantiate(logMessage=lambda environment, status, category, text: self.messages.append(text.decode()))
            else:
                self._callbacks = fmi2CallbackFunctions()
                log = lambda environment, name, status, category, text: self.messages.append(text.decode())  # noqa: E731
                self._callbacks.logger = fmi2CallbackLoggerTYPE(log)
                self._callbacks.allocateMemory = defaultCallbacks.allocateMemory
                self._callbacks.freeMemory = defaultCallbacks.freeMemory
                self.fmu.instantiate(callbacks=self._callbacks)
        except Exception:
            raise HnavValueError("option", self.messages[-1] if self.messages else "the FMU cannot be instantiated") from None

    def __enter__(self) -> Fmu:
        return self

    def __exit__(self, *_) -> None:
        self.fmu.freeInstance()
        shutil.rmtree(self._folder, ignore_errors=True)

    def call(self, method, *arguments):
        """A method of fmpy's FMU class; a refusal becomes an HnavError with the FMU's message."""
        try:
            return method(*arguments)
        except FMICallException as error:
            raise HnavValueError("option", self.messages[-1] if self.messages else str(error)) from None

    def references(self, names) -> C.Array:
        try:
            numbers = [self.variables[name].valueReference for name in names]
        except KeyError as error:
            raise HnavValueError(
                "option", f"the FMU has no variable {error.args[0]}{now_called(error.args[0], 'option', 'variable')}"
            ) from None
        return (C.c_uint32 * len(numbers))(*numbers)

    def set(self, name: str, value) -> None:
        """One variable, by the type it has."""
        variable = self.variables.get(name)
        if variable is None:
            raise HnavValueError("option", f"the FMU has no variable {name}{now_called(name, 'option', 'variable')}")
        kind = variable.type
        if not self.fmi3:
            setter = {"Real": self.fmu.setReal, "Boolean": self.fmu.setBoolean, "String": self.fmu.setString}.get(
                kind, self.fmu.setInteger
            )
        else:
            setter = {
                "Float64": self.fmu.setFloat64,
                "Boolean": self.fmu.setBoolean,
                "Int32": self.fmu.setInt32,
                "String": self.fmu.setString,
            }.get(kind, self.fmu.setInt64)
        self.call(setter, [variable.valueReference], [value])

    def get(self, name: str):
        """One variable; numbers as Python numbers."""
        variable = self.variables[name]
        if not self.fmi3:
            getter = {"Real": self.fmu.getReal, "Boolean": self.fmu.getBoolean}.get(variable.type, self.fmu.getInteger)
        else:
            getter = {"Float64": self.fmu.getFloat64, "Boolean": self.fmu.getBoolean, "Int32": self.fmu.getInt32}.get(
                variable.type, self.fmu.getInt64
            )
        return self.call(getter, [variable.valueReference])[0]

    # Many variables of one type at once: references and values are ctypes arrays that the caller keeps.
    def set_reals(self, references, values) -> None:
        n, f = len(references), self.fmu
        self.call(f.fmi3SetFloat64, f.component, references, n, values, n) if self.fmi3 else self.call(
            f.fmi2SetReal, f.component, references, n, values
        )

    def get_reals(self, references, values) -> None:
        n, f = len(references), self.fmu
        self.call(f.fmi3GetFloat64, f.component, references, n, values, n) if self.fmi3 else self.call(
            f.fmi2GetReal, f.component, references, n, values
        )

    def get_booleans(self, references, values) -> None:
        """values: c_bool in FMI 3, c_int32 in FMI 2."""
        n, f = len(references), self.fmu
        self.call(f.fmi3GetBoolean, f.component, references, n, values, n) if self.fmi3 else self.call(
            f.fmi2GetBoolean, f.component, references, n, values
        )

    def set_booleans(self, references, values) -> None:
        n, f = len(references), self.fmu
        self.call(f.fmi3SetBoolean, f.component, references, n, values, n) if self.fmi3 else self.call(
            f.fmi2SetBoolean, f.component, references, n, values
        )

    def get_integers(self, references, values) -> None:
        n, f = len(references), self.fmu
        self.call(f.fmi3GetInt32, f.component, references, n, values, n) if self.fmi3 else self.call(
            f.fmi2GetInteger, f.component, references, n, values
        )

    def set_integers(self, references, values) -> None:
        n, f = len(references), self.fmu
        self.call(f.fmi3SetInt32, f.component, references, n, values, n) if self.fmi3 else self.call(
            f.fmi2SetInteger, f.component, references, n, values
        )

    def initialise(self, start_s: float = 0.0, stop_s: float | None = None) -> None:
        """Parameters set before this take effect here."""
        f = self.fmu
        if self.fmi3:
            self.call(lambda: f.enterInitializationMode(startTime=start_s, stopTime=stop_s))
        else:
            self.call(lambda: f.setupExperiment(startTime=start_s, stopTime=stop_s))
            self.call(f.enterInitializationMode)
        self.call(f.exitInitializationMode)

    def update_discrete_states(self):
        """In event mode: (next event time or None)."""
        if self.fmi3:
            more, stop, nominals, values, defined, next_s = self.call(self.fmu.updateDiscreteStates)
        else:
            more, stop, nominals, values, defined, next_s = self.call(self.fmu.newDiscreteStates)
        return next_s if defined else None

    def do_step(self, t_s: float, step_s: float) -> None:
        self.call(self.fmu.doStep, t_s, step_s)

    def solver(self, start_s: float, rtol: float = MODEL_EXCHANGE_RTOL) -> CVodeSolver:
        """fmpy's CVODE over this Model Exchange instance."""
        f = self.fmu
        nx = sum(v.derivative is not None for v in self.description.modelVariables)
        return CVodeSolver(
            nx=nx, nz=0, get_x=f.getContinuousStates, set_x=f.setContinuousStates,
            get_dx=f.getContinuousStateDerivatives if self.fmi3 else f.getDerivatives, get_z=f.getEventIndicators,
            get_nominals=f.getNominalsOfContinuousStates, set_time=f.setTime, input=None, startTime=start_s,
            relativeTolerance=rtol, maxNumSteps=100000,
        )  # fmt: skip


# The FMU of each filter.
MODELS = {"hrekf": "Hrekf", "ahrs": "Ahrs"}


def parameter_values(filter: str, settings: Mapping[str, str], preset: str) -> dict[str, float | int]:
    """Settings as the FMU's parameters: arrays become name[1] ... name[n]. Raises HnavError."""
    table = option_table(filter)
    if preset not in FILTERS[filter]:
        raise HnavValueError("option", f"preset = {preset}: {filter} has {', '.join(FILTERS[filter])}")
    values: dict[str, float | int] = {"preset": PRESETS.index(preset), "sampling_mode": 1}
    for name, text in settings.items():
        if name not in table:
            raise HnavValueError(
                "option",
                f"{filter} has no option {name}{now_called(name, 'option')}; `hnav options --filter {filter}` lists them",
            )
        try:
            value = table[name].parse(str(text))
        except ValueError as error:
            raise HnavValueError("option", str(error)) from None
        if isinstance(value, list):
            values |= {f"{name}[{i}]": v for i, v in enumerate(value, start=1)}
        else:
            values[name] = value
    return values


def run_fmu(
    recording: Recording,
    filter: str,
    engine: str,
    settings: Mapping[str, str],
    preset: str = "default",
    step_s: float | None = None,
    progress: Progress | None = None,
) -> Result:
    """engine: fmi2-cs, fmi2-me, fmi3-cs or fmi3-me. Samples are marked by their counters and stamped with their times.

    step_s None: a communication point at every sample. Otherwise a grid of that step, and a sample is delivered at the
    first point at or after its time; of several samples between two points a sensor delivers the newest, and the rows
    of the others are NaN.
    """
    version, kind = engine.split("-")
    with Fmu(fmu_path(MODELS[filter], int(version[3:])), model_exchange=kind == "me") as fmu:
        for name, value in parameter_values(filter, settings, preset).items():
            fmu.set(name, value)
        t_s = recording.t_s
        fmu.initialise(float(t_s[0]))
        points, rows = _communication_points(t_s, step_s)
        loop = _ModelExchangeLoop if kind == "me" else _CoSimulationLoop
        return _run(fmu, recording, engine, points, rows, loop(fmu, points), progress)


def _communication_points(t_s: np.ndarray, step_s: float | None) -> tuple[np.ndarray, np.ndarray]:
    """Times of the points, and for each the row of the newest sample that is not later."""
    if step_s is None:
        last_step = t_s[-1] - t_s[-2] if len(t_s) > 1 else 0.01
        return np.append(t_s, t_s[-1] + last_step), np.arange(len(t_s))
    # k step + start in one rounding, and an end beyond the last sample.
    points = t_s[0] + step_s * np.arange(int(np.ceil((t_s[-1] - t_s[0]) / step_s)) + 2)
    rows = np.searchsorted(t_s, points[:-1] * (1 + 1e-15), side="right") - 1
    return points, rows


class _CoSimulationLoop:
    """Inputs at a point, then the step that processes them."""

    def __init__(self, fmu: Fmu, points: np.ndarray):
        self.fmu, self.points = fmu, points

    def process(self, k: int) -> None:
        t = float(self.points[k])
        self.fmu.do_step(t, float(self.points[k + 1]) - t)

    def go_on(self, k: int) -> None:
        pass


class _ModelExchangeLoop:
    """Inputs in event mode, the event, then fmpy's CVODE to the next point."""

    def __init__(self, fmu: Fmu, points: np.ndarray):
        self.fmu, self.points = fmu, points
        self.solver = fmu.solver(float(points[0]))

    def process(self, k: int) -> None:
        self.fmu.update_discrete_states()

    def go_on(self, k: int) -> None:
        f, t, end = self.fmu.fmu, float(self.points[k]), float(self.points[k + 1])
        self.fmu.call(f.enterContinuousTimeMode)
        self.solver.reset(t)
        self.fmu.call(self.solver.step, t, end)
        self.fmu.call(f.setTime, end)
        self.fmu.call(f.completedIntegratorStep)
        self.fmu.call(f.enterEventMode)


def _run(fmu: Fmu, recording: Recording, engine: str, points, rows, loop, progress: Progress | None) -> Result:
    """Delivers each sample once and reads the estimate just after it."""
    names = [f"post.q[{i}]" for i in range(1, 5)] + [f"post.bias[{i}]" for i in range(1, 4)]
    names += [f"post.sigma[{i}]" for i in range(1, 7)] + ["nis.accel", "nis.mag"]
    output_references, outputs = fmu.references(names), (C.c_double * len(names))()
    ready_references, ready_now = (
        fmu.references(["align.tilt_ready", "align.heading_ready"]),
        ((C.c_bool if fmu.fmi3 else C.c_int32) * 2)(),
    )

    sensors = ["gyro", "accel"] + (["mag"] if recording.field_b_tesla is not None else [])
    samples = [recording.rate_b_rad_s, recording.force_b_m_s2, recording.field_b_tesla][: len(sensors)]
    present = np.stack([~np.isnan(s).all(axis=1) for s in samples], axis=1)
    input_names = [f"{SENSORS[s]}[{i}]" for s in sensors for i in (1, 2, 3)] + [f"{s}.t_meas" for s in sensors]
    input_references, inputs = fmu.references(input_names), (C.c_double * len(input_names))()
    counter_references, counters = fmu.references(f"{s}.sample" for s in sensors), (C.c_int32 * len(sensors))()
    values = np.concatenate([*samples, np.repeat(recording.t_s[:, None], len(sensors), axis=1)], axis=1)
    # ctypes arrays and NumPy see the same memory.
    input_view, counter_view = np.frombuffer(inputs), np.frombuffer(counters, np.int32)

    n = len(recording.t_s)
    estimates = np.full((n, len(names)), np.nan)
    ready = np.zeros((n, 2), bool)
    output_view = np.frombuffer(outputs)
    begin = time.perf_counter()
    delivered = -1
    for k, row in enumerate(rows):
        if row > delivered:
            input_view[:] = values[row]
            counter_view += present[row]
            fmu.set_reals(input_references, inputs)
            fmu.set_integers(counter_references, counters)
        loop.process(k)
        if row > delivered:
            fmu.get_reals(output_references, outputs)
            fmu.get_booleans(ready_references, ready_now)
            estimates[row] = output_view
            ready[row] = ready_now
            delivered = row
        loop.go_on(k)
        if progress and k % 500 == 0:
            progress(int(row), n)
    seconds = time.perf_counter() - begin
    if progress:
        progress(n, n)

    counts = {name: int(fmu.get(f"count.{name}")) for name in COUNTS} | {"rhs_evals": int(fmu.get("solver.rhs_evals"))}
    started = np.isfinite(estimates[:, 0]) & (estimates[:, 7] < np.pi)  # sigma is pi before the start
    estimates[~started] = np.nan
    nis = estimates[:, 13:15].copy()
    nis[nis == 0] = np.nan
    nis[~present[:, 1], 0] = np.nan
    if len(sensors) == 3:
        nis[~present[:, 2], 1] = np.nan
    q_nb = estimates[:, :4]
    return Result(
        t_s=recording.t_s, q_nb=q_nb, euler_rad=euler_rad(q_nb), sigma_rad=estimates[:, 7:10],
        gyro_bias_rad_s=estimates[:, 4:7], gyro_bias_sigma_rad_s=estimates[:, 10:13], accel_nis=nis[:, 0], mag_nis=nis[:, 1], ready=ready,
        engine=engine, us_per_sample=1e6 * seconds / len(rows), counts=counts,
    )  # fmt: skip
