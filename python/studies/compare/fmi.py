"""Every FMU, FMI 2.0 and 3.0: Co-Simulation over recordings and made signals, Model Exchange by fmpy's CVODE."""

from __future__ import annotations

import ctypes as C
from collections.abc import Callable, Iterator

import numpy as np

from studies.compare.attitude import HEADING_EVERY, HEADING_SIGMA_RAD, MOUNTED, Arrays, Scenario
from studies.compare.fmu import Fmu, Values
from studies.compare.inputs import Samples, trial, tumbling, with_gaps
from studies.compare.side import Side
from studies.compare.simulation import CONSUMER, DELIVERY, FAULTS, TUMBLING

VERSIONS = (2, 3)
SENSORS = {"gyro": ("gyro.rate", "rate"), "accel": ("accel.force", "force"), "mag": ("mag.field", "field")}
COUNTED = {"sampling_mode": "counter"}
EXCHANGED_S = 20.0
TRUTH = [f"truth.{name}[{i}]" for name, n in (("q", 4), ("rate", 3), ("force", 3), ("field", 3)) for i in range(1, n + 1)]
READINGS = [f"{value}[{i}]" for value, _ in SENSORS.values() for i in (1, 2, 3)] + [
    f"{sensor}.{what}" for sensor in SENSORS for what in ("sample", "t_meas", "valid")
]


def open_fmu(side: Side, name: str, version: int, exchange: bool = False, **parameters) -> Fmu:
    fmu = Fmu(side.fmu(name, version), side.names, exchange)
    fmu.set(parameters)
    return fmu


class Recorder:
    """All outputs of an FMU, row after row."""

    def __init__(self, fmu: Fmu):
        self._fmu, self._values, self._rows = fmu, Values(fmu, fmu.of_causality("output")), []

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
    if heading:
        fmu.set({"aid.valid": True})
    fmu.initialise(float(samples.t_s[0]))
    delivery, recorder, points = Delivery(fmu, samples, heading), Recorder(fmu), communication_points(samples.t_s)
    recorder.note()
    for k in range(len(samples.t_s)):
        delivery.deliver(k)
        fmu.fmu.doStep(points[k], points[k + 1] - points[k])
        recorder.note()
    return recorder.columns()


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


def closed(run: Callable[..., Arrays], fmu: Fmu, *arguments, **options) -> Arrays:
    with fmu:
        return run(fmu, *arguments, **options)


# --------------------------------------------------------------------------------------------- Model Exchange


def exchange(fmu: Fmu, points: list[float], before_event: Callable[[int], None]) -> Arrays:
    """From point to point by CVODE, events of the FMU's own in between; notes states and derivatives too."""
    fmu.initialise(points[0])
    f, nx, recorder = fmu.fmu, fmu.states(), Recorder(fmu)
    solver = fmu.solver(points[0]) if nx else None
    states, derivatives, along = [], [], []
    for k in range(len(points) - 1):
        before_event(k)
        next_s, now = fmu.update_discrete_states(), points[k]
        recorder.note()
        while True:
            end = min(points[k + 1], next_s)
            f.enterContinuousTimeMode()
            if nx:
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


def _vector(call, n: int) -> np.ndarray:
    values = (C.c_double * n)()
    call(values, n)
    return np.array(values)


def exchange_samples(fmu: Fmu, samples: Samples) -> Arrays:
    delivery = Delivery(fmu, samples)
    return exchange(fmu, communication_points(samples.t_s), delivery.deliver)


def exchange_alone(fmu: Fmu, stop_s: float = 10.0, step_s: float = 0.04) -> Arrays:
    """Without inputs."""
    return exchange(fmu, (step_s * np.arange(round(stop_s / step_s) + 1)).tolist(), lambda k: None)


# --------------------------------------------------------------------------------------------- everything else


def alone(
    fmu: Fmu, stop_s: float = 20.0, step_s: float = 0.01, inputs: dict[str, Callable[[float], float]] | None = None
) -> Arrays:
    """Co-Simulation with inputs that are functions of time."""
    fmu.initialise(0.0)
    inputs = inputs or {}
    values, recorder = Values(fmu, inputs), Recorder(fmu)
    recorder.note()
    for k in range(round(stop_s / step_s)):
        values.set(np.array([signal(k * step_s) for signal in inputs.values()]))
        fmu.fmu.doStep(k * step_s, (k + 1) * step_s - k * step_s)
        recorder.note()
    return recorder.columns()


def chain(
    side: Side, version: int, table: dict, sensor: dict, filter: dict, stop_s: float = 15.0, step_s: float = 0.005
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
        about, found = fmu.description, {}
        for v in about.modelVariables:
            choices = [item.name for item in (v.declaredType.items or [])] if v.declaredType else []
            said = [v.type, v.causality, v.variability, v.initial, v.unit, v.start, v.min, v.max, v.nominal, *choices]
            found[fmu.canonical(v.name)] = np.array([str(s) for s in said])
        for interface in filter(None, (about.coSimulation, about.modelExchange)):
            can = [f"{name}={value}" for name in dir(interface) if isinstance(value := getattr(interface, name), bool)]
            found[f"!{type(interface).__name__}"] = np.array(can)
        return found


# --------------------------------------------------------------------------------------------- the list


def scenarios(trials: list[int]) -> Iterator[tuple[str, Scenario]]:
    for version in VERSIONS:
        yield from _descriptions(version)
        for name in ("Ahrs", "Hrekf"):
            yield from _attitude(version, name, trials)
        yield from _others(version)


ALL = (
    "Ahrs", "Hrekf", "Turntable", "ImuMagSensor", "AircraftInsLateral", "AircraftInsLongitudinal", "InsErrorFilterLateral",
    "InsErrorFilterLongitudinal",
)  # fmt: skip


def _descriptions(version: int) -> Iterator[tuple[str, Scenario]]:
    for name in ALL:
        yield f"fmi{version}/description/{name}", lambda side, n=name: describe(side, n, version)


SETTINGS = {
    "closed_form": {"solver": "closed_form"}, "kl": {"gamma_mode": "kl"}, "euler": {"solver": "euler", "gamma_mode": "fixed"},
    "relative_adams": {"solver": "adams", "gamma_mode": "relative"}, "frames": MOUNTED, "forward": {"gyro_hold": "forward"},
    "start_mean": {"start_samples": 5}, "horizon": {"horizon_s": 0.05},
}  # fmt: skip


def _attitude(version: int, name: str, trials: list[int]) -> Iterator[tuple[str, Scenario]]:
    def opened(side: Side, exchange: bool = False, **parameters) -> Fmu:
        return open_fmu(side, name, version, exchange, **COUNTED, **parameters)

    for number in trials:
        yield (
            f"fmi{version}/cs/{name}/trial/{number:02d}",
            lambda side, n=number: closed(follow, opened(side, navigation_frame="enu"), trial(side.inputs, n)),
        )
    settings = dict(SETTINGS)
    if name == "Hrekf":
        settings |= {"paper": {"preset": "paper"}, "adapting": {"adaptation": "corrected", "gamma_mode": "kl"}}
    for label, chosen in settings.items():
        yield (
            f"fmi{version}/cs/{name}/made/{label}",
            lambda side, s=chosen: closed(follow, opened(side, **s), with_gaps(tumbling(20)), heading=True),
        )
    yield f"fmi{version}/cs/{name}/commands_and_states", lambda side: closed(commands_and_states, opened(side), tumbling(10))
    yield f"fmi{version}/cs/{name}/grid", lambda side: closed(on_a_grid, opened(side), with_gaps(tumbling(20)))
    yield (
        f"fmi{version}/cs/{name}/periodic",
        lambda side: closed(follow, open_fmu(side, name, version, sampling_mode="periodic"), tumbling(20)),
    )
    for number in [n for n in (7, 31) if n in trials]:
        yield (
            f"fmi{version}/me/{name}/trial/{number:02d}",
            lambda side, n=number: closed(
                exchange_samples, opened(side, exchange=True), trial(side.inputs, n).cut(0, EXCHANGED_S)
            ),
        )
    yield (
        f"fmi{version}/me/{name}/made",
        lambda side: closed(exchange_samples, opened(side, exchange=True), with_gaps(tumbling(8))),
    )


def _others(version: int) -> Iterator[tuple[str, Scenario]]:
    cs, me = f"fmi{version}/cs", f"fmi{version}/me"
    yield f"{cs}/chain/default", lambda side: chain(side, version, {}, {}, {})
    late = {"horizon_s": 0.3, "queue_capacity": 256}
    yield f"{cs}/chain/faults", lambda side: chain(side, version, TUMBLING, CONSUMER | DELIVERY | FAULTS, late)
    yield f"{cs}/Turntable", lambda side: closed(alone, open_fmu(side, "Turntable", version, **TUMBLING))
    yield f"{me}/Turntable", lambda side: closed(exchange_alone, open_fmu(side, "Turntable", version, True, **TUMBLING))
    for axis, channels, controls in (
        ("Lateral", ("beta", "p", "r", "phi"), ("aileron", "rudder")), ("Longitudinal", ("u", "w", "q", "theta"), ("elevator",))
    ):  # fmt: skip
        plant, filter = f"AircraftIns{axis}", f"InsErrorFilter{axis}"
        yield (
            f"{cs}/{plant}",
            lambda side, p=plant, c=controls: closed(
                alone, open_fmu(side, p, version, seed=4), 60, 0.05, {f"command.{n}": lambda t: 0.01 * np.sin(t) for n in c}
            ),
        )
        yield f"{me}/{plant}", lambda side, p=plant: closed(exchange_alone, open_fmu(side, p, version, True, seed=4))
        for form in ("mdkf", "amdkf", "differenced", "augmented", "plain"):
            parameters = {"form": form} | ({"noise_scaling": "none"} if form in ("mdkf", "amdkf") else {})
            yield (
                f"{cs}/{filter}/{form}",
                lambda side, f=filter, c=channels, u=controls, p=parameters: closed(
                    alone, open_fmu(side, f, version, **p), 60, 0.1, _measurements(c, u)
                ),
            )
        yield f"{me}/{filter}", lambda side, f=filter: closed(exchange_alone, open_fmu(side, f, version, True))


def _measurements(channels: tuple[str, ...], controls: tuple[str, ...]) -> dict[str, Callable[[float], float]]:
    """Signals of a flight that nobody flew; the second channel is missing for a while."""
    signals = {
        f"z.{name}": lambda t, i=i: 0.05 * np.sin((1 + i) * t) + 0.01 * np.cos(37 * t + i) for i, name in enumerate(channels)
    }
    signals |= {f"u.{name}": lambda t: 0.02 * np.sign(np.sin(t)) for name in controls}
    return signals | {f"present.{channels[1]}": lambda t: not 20 < t < 25}
