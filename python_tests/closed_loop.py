"""A short co-simulation loop for tests: Turntable, ImuMagSensor and filters; outputs are passed on between steps."""

from __future__ import annotations

import ctypes as C
from collections.abc import Mapping
from contextlib import ExitStack

import numpy as np

from hnav.fmi.fmus import Fmu, fmu_path
from makers.turntable_scenarios import COMPONENTS, SAMPLES, TRUTH

REALS = [name for name in SAMPLES if not name.endswith(("sample", "valid"))]
COUNTERS = [name for name in SAMPLES if name.endswith("sample")]
ORDER = ("turntable", "sensor")


class ClosedLoop:
    """Components of the turntable system, FMI 2, started with parameters named component.parameter; stack closes them."""

    def __init__(self, stack: ExitStack, parameters: Mapping[str, object], filters=("hekf", "hrekf", "ahrs"), seed: int = 0):
        self.filters = filters
        self.fmus = {name: stack.enter_context(Fmu(fmu_path(COMPONENTS[name], 2), name=name)) for name in (*ORDER, *filters)}
        for name in filters:
            self.fmus[name].set("sampling_mode", 1)
        for name in ORDER:
            self.fmus[name].set("seed", seed)
        for name, value in parameters.items():
            component, _, parameter = name.partition(".")
            if component in self.fmus:
                self.fmus[component].set(parameter, value)
        for fmu in self.fmus.values():
            fmu.initialise()

        table, sensor = self.fmus["turntable"], self.fmus["sensor"]
        self.truth, self.reals, self.counters = (
            (C.c_double * len(TRUTH))(),
            (C.c_double * len(REALS))(),
            (C.c_int32 * len(COUNTERS))(),
        )
        self.truth_from, self.truth_to = table.references(TRUTH), sensor.references(TRUTH)
        self.reals_from, self.counters_from = sensor.references(REALS), sensor.references(COUNTERS)
        self.reals_to = {name: self.fmus[name].references(REALS) for name in filters}
        self.counters_to = {name: self.fmus[name].references(COUNTERS) for name in filters}

    def step(self, t_s: float, step_s: float) -> None:
        """From t_s on: each FMU gets the outputs of the others at t_s, then all step."""
        table, sensor = self.fmus["turntable"], self.fmus["sensor"]
        table.crossing("Get", "real", self.truth_from, self.truth)()
        sensor.crossing("Get", "real", self.reals_from, self.reals)()
        f = sensor.fmu
        sensor.call(f.fmi2GetInteger, f.component, self.counters_from, len(COUNTERS), self.counters)
        sensor.crossing("Set", "real", self.truth_to, self.truth)()
        for name in self.filters:
            self.fmus[name].crossing("Set", "real", self.reals_to[name], self.reals)()
            self.fmus[name].crossing("Set", "integer", self.counters_to[name], self.counters)()
        for fmu in self.fmus.values():
            fmu.do_step(t_s, step_s)

    def run(self, stop_s: float, outputs: Mapping[str, list[str]], step_s: float = 0.01) -> dict[str, np.ndarray]:
        """Per component the real outputs after each step, rows x names; "time" is the end of each step."""
        steps = round(stop_s / step_s)
        places = {name: self.fmus[name].references(names) for name, names in outputs.items()}
        values = {name: (C.c_double * len(names))() for name, names in outputs.items()}
        rows = {name: np.empty((steps, len(names))) for name, names in outputs.items()}
        for k in range(steps):
            self.step(k * step_s, (k + 1) * step_s - k * step_s)
            for name in outputs:
                self.fmus[name].crossing("Get", "real", places[name], values[name])()
                rows[name][k] = values[name]
        return rows | {"time": step_s * np.arange(1, steps + 1)}


def closed_run(
    parameters: Mapping[str, object], stop_s: float, outputs: Mapping[str, list[str]], step_s: float = 0.01, **options
) -> dict[str, np.ndarray]:
    with ExitStack() as stack:
        return ClosedLoop(stack, parameters, **options).run(stop_s, outputs, step_s)
