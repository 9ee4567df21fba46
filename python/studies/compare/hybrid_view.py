"""The hybrid view of the attitude filters: flow by a Runge-Kutta of our own, jumps at the samples."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from studies.compare.attitude import Reader, open_filter
from studies.compare.native import Object
from studies.compare.scenario import Arrays, Named, Settings, Source, given, made
from studies.compare.side import Side


class Flow:
    """A filter that is integrated from outside; x is the state between its events."""

    def __init__(self, target: Object):
        self._target, self._pointer = target, target.library.pointer
        nx = target.library.ffi.new("int32_t *")
        target.call("nx", nx)
        self.nx, self.x = nx[0], np.zeros(nx[0])
        self._stage, self._out, self._seed = (np.zeros(self.nx) for _ in range(3))
        self._time_pointer = target.library.ffi.new("double *")

    def read(self, call: str) -> np.ndarray:
        return self._target.array(call, self.nx)

    def derivative(self, t_s: float, x: np.ndarray) -> np.ndarray:
        self._stage[:] = x
        self._target.call("derivative", t_s, self._pointer(self._stage), self._pointer(self._out))
        return self._out.copy()

    def derivative_along(self, t_s: float, seed: np.ndarray) -> np.ndarray:
        self._seed[:] = seed
        pointers = [self._pointer(values) for values in (self.x, self._seed, self._out)]
        self._target.call("derivative_along", t_s, *pointers)
        return self._out.copy()

    def step(self, t_s: float, end_s: float) -> None:
        """One classical Runge-Kutta step."""
        h = end_s - t_s
        a = self.derivative(t_s, self.x)
        b = self.derivative(t_s + h / 2, self.x + h / 2 * a)
        c = self.derivative(t_s + h / 2, self.x + h / 2 * b)
        d = self.derivative(end_s, self.x + h * c)
        self.x = self.x + h / 6 * (a + 2 * b + 2 * c + d)

    def next_event_s(self) -> float:
        self._target.call("next_event_s", self._time_pointer)
        return float(self._time_pointer[0])

    def jump(self, t_s: float) -> int:
        after = np.zeros(self.nx)
        status = self._target.status("jump", t_s, self._pointer(self.x), self._pointer(after))
        if status == 0:
            self.x = after
        return status


def flow_and_jump(side: Side, filter: str, source: Source, **settings: Any) -> Arrays:
    samples = source(side)
    target = open_filter(side, filter, **settings)
    flow, reader, rng = Flow(target), Reader(target), np.random.default_rng(3)
    flow.x, log, pointer = flow.read("get_x"), reader.log, target.library.pointer
    now = float(samples.t_s[0])
    for i, t_s in enumerate(samples.t_s.tolist()):
        for sensor, values in (("gyro", samples.rate), ("accel", samples.force), ("mag", samples.field)):
            target.call(f"push_{sensor}", t_s, pointer(values[i]))
        log.add("next_event_s", flow.next_event_s())
        if t_s > now:
            flow.step(now, t_s)
        log.add("x_minus", flow.x.copy())
        log.add("jump.status", flow.jump(t_s))
        log.add("x_plus", flow.x.copy())
        log.add("x", flow.read("get_x"))
        log.add("nominal_x", flow.read("nominal_x"))
        log.add("derivative", flow.derivative(t_s, flow.x))
        log.add("derivative_along", flow.derivative_along(t_s, rng.normal(size=flow.nx)))
        log.add("show.status", target.status("show", t_s, pointer(flow.x)))
        reader.note()
        now = t_s
    return log.columns()


def scenarios() -> Iterator[Named]:
    chosen: dict[str, dict[str, Settings]] = {
        "hrekf": {
            "default": {"gyro_hold": "forward"}, "kl": {"gamma_mode": "kl", "gyro_hold": "forward"},
            "adapting": {"adaptation": "corrected", "gamma_mode": "fixed", "gyro_hold": "forward"},
        },
        "ahrs": {"default": {}, "relative": {"gamma_mode": "relative", "start_sigma_heading_rad": 0.5}},
    }  # fmt: skip
    for filter, settings in chosen.items():
        for label, values in settings.items():
            yield f"c/{filter}/hybrid_view/{label}", given(flow_and_jump, filter, made(8, gaps=False), **values)
