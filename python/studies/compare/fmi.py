"""Every FMU, FMI 2.0 and 3.0: Co-Simulation over recordings and made signals, Model Exchange by fmpy's CVODE."""

from __future__ import annotations

import ctypes as C
import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from studies.compare.attitude import HEADING_EVERY, HEADING_SIGMA_RAD, MOUNTED
from studies.compare.fmu import Fmu, Values
from studies.compare.inputs import Samples
from studies.compare.scenario import Arrays, Named, Settings, Source, given, made, of_trial
from studies.compare.side import Side
from studies.compare.simulation import CONSUMER, DELIVERY, FAULTS, TUMBLING

VERSIONS = (2, 3)
SENSORS = {"gyro": ("gyro.rate", "rate"), "accel": ("accel.force", "force"), "mag": ("mag.field", "field")}
COUNTED: Settings = {"sampling_mode": "counter"}
EXCHANGED, EXCHANGED_S = (7, 31), 20.0  # trials
Signal = Callable[[float], float]
TRUTH = [f"truth.{name}[{i}]" for name, n in (("q", 4), ("rate", 3), ("force", 3), ("field", 3)) for i in range(1, n + 1)]
READINGS = [f"{value}[{i}]" for value, _ in SENSORS.values() for i in (1, 2, 3)] + [
    f"{sensor}.{what}" for sensor in SENSORS for what in ("sample", "t_meas", "valid")
]


def open_fmu(side: Side, name: str, version: int, exchange: bool = False, **parameters: Any) -> Fmu:
    fmu = Fmu(side.fmu(name, version), side.names, exchange)
    fmu.set(parameters)
    return fmu


class Recorder:
    """All outputs of an FMU, row after row."""

    def __init__(self, fmu: Fmu):
        self._fmu, self._values, self._rows = fmu, Values(fmu, fmu.of_causality("output")), list[NDArray[Any]]()

    def note(self) -> None:
        self._rows.append(self._values.get())

    def columns(self) -> Arrays:
        table = np.array(self._rows)
        return {self._fmu.canonical(name): np.ascontiguousarray(table[:, i]) for i, name in enumerate(self._values.names)}


# --------------------------------------------------------------------------------------------- attitude filters


class Delivery:
    """Rows of samples into the inputs of an attitude filter, marked by counters and stamped with their times."""

    def __init__(self, fmu: Fmu, samples: Samples, heading: bool = False):
        names = [f"{value}[{i}]" for value, _ in SENSORS.values() for i in (1, 2, 3)]
        names += [f"{sensor}.t_meas" for sensor in SENSORS] + [f"{sensor}.sample" for sensor in SENSORS]
        vectors = [getattr(samples, field) for _, field in SENSORS.values()]
        times = np.repeat(samples.t_s[:, None], 3, axis=1)
        counts = np.stack([np.cumsum(np.isfinite(v).all(axis=1)) for v in vectors], axis=1)
        self._table = np.nan_to_num(np.concatenate([*vectors, times, counts], axis=1))
        if heading:
            names += ["aid.heading", "aid.heading_sigma", "aid.t_meas", "aid.sample"]
            sigma = np.full_like(samples.t_s, HEADING_SIGMA_RAD)
            counts = (np.arange(len(samples.t_s)) + HEADING_EVERY // 2) // HEADING_EVERY
            self._table = np.column_stack([self._table, samples.heading, sigma, samples.t_s, counts])
        self._values = Values(fmu, names)

    def deliver(self, row: int) -> None:
        self._values.set(self._table[row])


def communication_points(t_s: np.ndarray) -> list[float]:
    """At every sample, and one more."""
    return [*t_s.tolist(), 2 * t_s[-1] - t_s[-2]]


def follow(fmu: Fmu, samples: Samples, heading: bool = False) -> Arrays:
    """A communication point at every sample."""
    fmu.initialise(float(samples.t_s[0]))
    delivery, recorder, points = Delivery(fmu, samples, heading), Recorder(fmu), communication_points(samples.t_s)
    recorder.note()
    for k in range(len(samples.t_s)):
        delivery.deliver(k)
        fmu.fmu.doStep(points[k], points[k + 1] - points[k])
        recorder.note()
    return recorder.columns()


def follow_with_heading(fmu: Fmu, samples: Samples) -> Arrays:
    fmu.set({"aid.valid": True})
    return follow(fmu, samples, heading=True)


def on_a_grid(fmu: Fmu, samples: Samples, step_s: float = 0.0125) -> Arrays:
    """A step that does not fit the samples: some are missed, some come twice."""
    fmu.initialise(float(samples.t_s[0]))
    delivery, recorder = Delivery(fmu, samples), Recorder(fmu)
    points = samples.t_s[0] + step_s * np.arange(int((samples.t_s[-1] - samples.t_s[0]) / step_s))
    rows = np.searchsorted(samples.t_s, points * (1 + 1e-15), side="right") - 1
    for k in range(len(points) - 1):
        delivery.deliver(int(rows[k]))
        fmu.fmu.doStep(float(points[k]), float(points[k + 1] - points[k]))
        recorder.note()
    return recorder.columns()


def commands_and_states(fmu: Fmu, samples: Samples) -> Arrays:
    """realign and reset by their edges; now and then two rows are done again from a state that was kept or serialised."""
    fmu.initialise(float(samples.t_s[0]))
    delivery, recorder, points, f = Delivery(fmu, samples), Recorder(fmu), communication_points(samples.t_s), fmu.fmu

    def two_rows(first: int) -> None:
        for k in (first, first + 1):
            delivery.deliver(k)
            f.doStep(points[k], points[k + 1] - points[k])
            recorder.note()

    for first in range(0, len(samples.t_s) - 1, 2):
        fmu.set({"realign": first in range(300, 310), "reset": first in range(600, 606)})
        if first % 50 == 20:
            states = [f.getFMUState()]
            two_rows(first)
            if first % 100 == 20:
                states.append(f.deserializeFMUState(f.serializeFMUState(states[0])))
            f.setFMUState(states[-1])
            recorder.note()
            for state in states:
                f.freeFMUState(state)
        two_rows(first)
    return recorder.columns()


def of_filter(side: Side, run: Callable[..., Arrays], name: str, version: int, source: Source, **parameters: Any) -> Arrays:
    """An attitude filter that takes samples by counter and time stamp, unless the parameters say otherwise."""
    exchanged = run is exchange_samples
    with open_fmu(side, name, version, exchanged, **COUNTED | parameters) as fmu:
        return run(fmu, source(side))


# --------------------------------------------------------------------------------------------- Model Exchange


def exchange(fmu: Fmu, points: list[float], before_event: Callable[[int], None]) -> Arrays:
    """From point to point by CVODE, events of the FMU's own in between; notes states and derivatives too."""
    fmu.initialise(points[0])
    f, nx, recorder = fmu.fmu, fmu.states(), Recorder(fmu)
    solver = fmu.solver(points[0]) if nx else None
    states, derivatives, along = ([] for _ in range(3))
    for k in range(len(points) - 1):
        before_event(k)
        next_s, now = fmu.update_discrete_states(), points[k]
        recorder.note()
        while True:
            end = min(points[k + 1], next_s)
            f.enterContinuousTimeMode()
            if solver:
                states.append(_vector(f.getContinuousStates, nx))
                derivatives.append(_vector(f.getContinuousStateDerivatives if fmu.fmi3 else f.getDerivatives, nx))
                if k % 50 == 0:
                    along.append(fmu.directional_derivatives())
                solver.reset(now)
                if end > now:
                    solver.step(now, end)
            f.setTime(end)
            f.completedIntegratorStep()
            recorder.note()
            f.enterEventMode()
            if end == points[k + 1]:
                break
            next_s, now = fmu.update_discrete_states(), end
    found = {"states": np.array(states), "derivatives": np.array(derivatives), "along": np.array(along)}
    return recorder.columns() | (found if nx else {})


def _vector(call: Callable[..., None], n: int) -> NDArray[Any]:
    values = (C.c_double * n)()
    call(values, n)
    return np.array(values)


def exchange_samples(fmu: Fmu, samples: Samples) -> Arrays:
    delivery = Delivery(fmu, samples)
    return exchange(fmu, communication_points(samples.t_s), delivery.deliver)


def exchange_alone(side: Side, name: str, version: int, **parameters: Any) -> Arrays:
    """Without inputs, 10 s."""
    with open_fmu(side, name, version, exchange=True, **parameters) as fmu:
        return exchange(fmu, (0.04 * np.arange(251)).tolist(), lambda k: None)


# --------------------------------------------------------------------------------------------- everything else


def alone(
    side: Side, name: str, version: int, stop_s: float, step_s: float, inputs: dict[str, Signal], **parameters: Any
) -> Arrays:
    """Co-Simulation with inputs that are functions of time."""
    with open_fmu(side, name, version, **parameters) as fmu:
        fmu.initialise(0.0)
        values, recorder = Values(fmu, inputs), Recorder(fmu)
        recorder.note()
        for k in range(round(stop_s / step_s)):
            values.set(np.array([signal(k * step_s) for signal in inputs.values()]))
            fmu.fmu.doStep(k * step_s, (k + 1) * step_s - k * step_s)
            recorder.note()
        return recorder.columns()


def chain(
    side: Side, version: int, table: Settings, sensor: Settings, filter: Settings, stop_s: float = 15.0, step_s: float = 0.005
) -> Arrays:
    """Turntable, sensor and both filters, each given at a point what the others showed there."""
    filter = COUNTED | filter
    names = {
        "turntable": ("Turntable", table),
        "sensor": ("ImuMagSensor", sensor),
        "ahrs": ("Ahrs", filter),
        "hrekf": ("Hrekf", filter),
    }
    parts = {name: open_fmu(side, fmu, version, **parameters) for name, (fmu, parameters) in names.items()}
    try:
        for fmu in parts.values():
            fmu.initialise(0.0)
        wires = [(Values(parts["turntable"], TRUTH), [Values(parts["sensor"], TRUTH)])]
        wires.append((Values(parts["sensor"], READINGS), [Values(parts[name], READINGS) for name in ("ahrs", "hrekf")]))
        recorders = {name: Recorder(fmu) for name, fmu in parts.items()}
        for k in range(round(stop_s / step_s)):
            shown = [source.get() for source, _ in wires]
            for row, (_, targets) in zip(shown, wires):
                for target in targets:
                    target.set(row)
            for name, fmu in parts.items():
                fmu.fmu.doStep(k * step_s, (k + 1) * step_s - k * step_s)
                recorders[name].note()
        return {f"{name}.{key}": values for name, recorder in recorders.items() for key, values in recorder.columns().items()}
    finally:
        for fmu in parts.values():
            fmu.__exit__()


def describe(side: Side, name: str, version: int) -> Arrays:
    """What the model description says of each variable, and of what the FMU can do."""
    with open_fmu(side, name, version) as fmu:
        about, found = fmu.description, Arrays()
        for v in about.modelVariables:
            choices = [item.name for item in (v.declaredType.items or [])] if v.declaredType else []
            said = [v.type, v.causality, v.variability, v.initial, v.unit, v.start, v.min, v.max, v.nominal, *choices]
            found[fmu.canonical(v.name)] = np.array([str(s) for s in said])
        for interface in filter(None, (about.coSimulation, about.modelExchange)):
            can = [f"{name}={value}" for name in dir(interface) if isinstance(value := getattr(interface, name), bool)]
            found[f"!{type(interface).__name__}"] = np.array(can)
        return found


# --------------------------------------------------------------------------------------------- the list


def scenarios(trials: list[int]) -> Iterator[Named]:
    for version in VERSIONS:
        for name in ALL:
            yield f"fmi{version}/description/{name}", given(describe, name, version)
        for name in ("Ahrs", "Hrekf"):
            yield from _attitude(version, name, trials)
        yield from _simulated(version)
        for axis in AXES:
            yield from _aircraft(version, axis)


ALL = (
    "Ahrs", "Hrekf", "Turntable", "ImuMagSensor", "AircraftInsLateral", "AircraftInsLongitudinal", "InsErrorFilterLateral",
    "InsErrorFilterLongitudinal",
)  # fmt: skip
SETTINGS: dict[str, Settings] = {
    "closed_form": {"solver": "closed_form"}, "kl": {"gamma_mode": "kl"}, "euler": {"solver": "euler", "gamma_mode": "fixed"},
    "relative_adams": {"solver": "adams", "gamma_mode": "relative"}, "frames": MOUNTED, "forward": {"gyro_hold": "forward"},
    "start_mean": {"start_samples": 5}, "horizon": {"horizon_s": 0.05},
}  # fmt: skip
OF_HREKF: dict[str, Settings] = {"paper": {"preset": "paper"}, "adapting": {"adaptation": "corrected", "gamma_mode": "kl"}}


def _attitude(version: int, name: str, trials: list[int]) -> Iterator[Named]:
    cs, me = f"fmi{version}/cs/{name}", f"fmi{version}/me/{name}"
    for number in trials:
        source = of_trial(number)
        yield f"{cs}/trial/{number:02d}", given(of_filter, follow, name, version, source, navigation_frame="enu")
    for label, settings in (SETTINGS | (OF_HREKF if name == "Hrekf" else {})).items():
        yield f"{cs}/made/{label}", given(of_filter, follow_with_heading, name, version, made(20), **settings)
    yield f"{cs}/commands_and_states", given(of_filter, commands_and_states, name, version, made(10))
    yield f"{cs}/grid", given(of_filter, on_a_grid, name, version, made(20))
    yield f"{cs}/periodic", given(of_filter, follow, name, version, made(20, gaps=False), sampling_mode="periodic")
    for number in [n for n in EXCHANGED if n in trials]:
        yield f"{me}/trial/{number:02d}", given(of_filter, exchange_samples, name, version, of_trial(number, 0, EXCHANGED_S))
    yield f"{me}/made", given(of_filter, exchange_samples, name, version, made(8))


def _simulated(version: int) -> Iterator[Named]:
    late = {"horizon_s": 0.3, "queue_capacity": 256}
    yield f"fmi{version}/cs/chain/default", given(chain, version, {}, {}, {})
    yield f"fmi{version}/cs/chain/faults", given(chain, version, TUMBLING, CONSUMER | DELIVERY | FAULTS, late)
    yield f"fmi{version}/cs/Turntable", given(alone, "Turntable", version, 20, 0.01, {}, **TUMBLING)
    yield f"fmi{version}/me/Turntable", given(exchange_alone, "Turntable", version, **TUMBLING)


AXES = {"Lateral": (("beta", "p", "r", "phi"), ("aileron", "rudder")), "Longitudinal": (("u", "w", "q", "theta"), ("elevator",))}


def _aircraft(version: int, axis: str) -> Iterator[Named]:
    channels, controls = AXES[axis]
    plant, filter = f"AircraftIns{axis}", f"InsErrorFilter{axis}"
    commands: dict[str, Signal] = {f"command.{name}": lambda t: 0.01 * math.sin(t) for name in controls}
    yield f"fmi{version}/cs/{plant}", given(alone, plant, version, 60, 0.05, commands, seed=4)
    yield f"fmi{version}/me/{plant}", given(exchange_alone, plant, version, seed=4)
    measured = _measurements(channels, controls)
    for form in ("mdkf", "amdkf", "differenced", "augmented", "plain"):
        parameters = {"form": form} | {"noise_scaling": "none" if form in ("mdkf", "amdkf") else "hmm"}
        yield f"fmi{version}/cs/{filter}/{form}", given(alone, filter, version, 60, 0.1, measured, **parameters)
    yield f"fmi{version}/me/{filter}", given(exchange_alone, filter, version)


def _measurements(channels: tuple[str, ...], controls: tuple[str, ...]) -> dict[str, Signal]:
    """Signals of a flight that nobody flew; the second channel is missing for a while."""

    def measured(i: int) -> Signal:
        return lambda t: 0.05 * math.sin((1 + i) * t) + 0.01 * math.cos(37 * t + i)

    signals = {f"z.{name}": measured(i) for i, name in enumerate(channels)}
    signals |= {f"u.{name}": lambda t: math.copysign(0.02, math.sin(t)) for name in controls}
    return signals | {f"present.{channels[1]}": lambda t: not 20 < t < 25}
