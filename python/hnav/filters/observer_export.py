"""An observer as an FMU: the plant inside, its estimates outside.

The binary is the same for every plant, that of the FMU Observer which is built with the others; what differs is text, written here
from one table.
"""

from __future__ import annotations

import io
import math
import zipfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from decimal import Decimal
from itertools import combinations_with_replacement, product
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hnav.errors import HnavError, HnavValueError
from hnav.io.fmu_files import fmu_path
from hnav.io.fmu_writing import About, Row, model_description, number, page, terminals
from hnav.io.model_description import ModelDescription, Unit
from hnav.io.outputs import write_files, writing
from hnav.native.options import option_rows

if TYPE_CHECKING:
    from hnav.filters.observer import Observer

IDENTIFIER = "Observer"
PLANT = "resources/plant/"
_INF, _NAN = float("inf"), float("nan")
LARGEST_COVARIANCE = 16  # numbers that are estimated: of more, what they have in common has rows on request
_OWN_OPTIONS = ("start_time_s",)  # given by the importer
_SECOND = Unit(1.0, 0.0, (0, 0, 1, 0, 0, 0, 0, 0))
_PLATFORMS = {"linux64": "x86_64-linux", "win64": "x86_64-windows", "darwin64": "x86_64-darwin"}  # FMI 2's names, and FMI 3's
_MODES = {
    "periodic": "Inputs are a sample at the first communication point at or after each period, stamped with its time",
    "counter": "Inputs are a sample when their counter has changed, stamped with their t_meas",
    "held": "As periodic, and within a longer communication step the held inputs are a sample again at each period, as if they were constant and without noise",
    "auto": "As periodic, where a longer communication step has one sample of each sensor and loses none; from the first change of a sensor's counter on as counter",
}
_EVENTS = {
    "plant_events": "Events of the plant that changed something, as the largest part has them",
    "splits": "How often the estimate was split",
    "grazing": "Guards hardly crossed or missed, or crossed with another: points in place of derivatives",
    "chattering": "Events beyond the fiftieth of an interval: the covariance does not go through them",
    "projected": "Corrections that were put back before a guard",
}
_COUNTS = {
    "events": "Instants that were used",
    "corrections": "Those with a sensor",
    "late": "Samples refused as too old",
    "non_finite": "Samples refused as not finite",
    "dropped": "Instants for which the plant had no answer",
    "held": "Intervals for the rest of which it had none: the estimate was held there, its covariance grew",
    "missed": "Samples that a coarse communication step lost",
}


MOST = 64  # numbers that an exported observer estimates


def export(observer: Observer, path: Path | str, fmi_version: int, period_s: float, covariance: bool | None = None) -> list[str]:
    """Writes the FMU and returns the platforms of the plant on which it does not run. Raises HnavValueError with the remedy.

    covariance: whether P is an output; None: if the plan estimates at most LARGEST_COVARIANCE numbers.
    """
    fmu = plant_of(observer)
    if fmi_version not in (2, 3):
        raise HnavValueError("option", f"fmi_version is {fmi_version}: it must be 2 or 3", "fmi_version")
    if not 1e-6 <= period_s <= 1e6:
        raise HnavValueError("option", f"period_s is {period_s:g}: it must lie in [1e-6, 1e6]", "period_s")
    if len(observer.names) > MOST:
        raise HnavValueError(
            "option", f"the plan estimates {len(observer.names)} numbers, an exported observer at most {MOST}: leave parameters out, or reduce the model",
            "plan",
        )  # fmt: skip
    with writing(path), zipfile.ZipFile(fmu_path(IDENTIFIER, fmi_version)) as shell, zipfile.ZipFile(fmu.path) as plant:
        here, there = _platforms(shell), _platforms(plant)
        if not here & there:
            raise HnavValueError(
                "option", f"{fmu.path.name} has binaries for {', '.join(sorted(there))}, the observer for {', '.join(sorted(here))}: export the "
                "plant for one of these", "fmu"
            )  # fmt: skip
        contents = {name: text.encode() for name, text in texts(observer, fmi_version, period_s, covariance).items()}
        contents |= _taken(shell, ("documentation/licenses/", "terminalsAndIcons/icon", "model.png"), here & there)
        inside = _taken(plant, ("resources/", "documentation/licenses/", "licenses/"), here & there)
        contents |= {PLANT + name: content for name, content in inside.items()}
    write_files({Path(path): _archive(contents)})
    return sorted(there - here)


def plant_of(observer: Observer) -> ModelDescription:
    """Raises HnavValueError for a plant that is no FMU."""
    if not isinstance(observer.plan.plant, ModelDescription):
        wrong = "a plant of functions in Python cannot be put into an FMU: export the model itself for Model Exchange"
        raise HnavValueError("option", wrong, "plan")
    return observer.plan.plant


def texts(observer: Observer, fmi_version: int, period_s: float, covariance: bool | None = None) -> dict[str, str]:
    """All that depends on the plant, by path in the archive."""
    fmu, rows = plant_of(observer), table(observer, period_s, covariance)
    title = f"Observer of {fmu.name}"
    about = About(
        title, IDENTIFIER, f"Estimates the states of {fmu.name}, which is inside, from its sensors", period_s, 1000 * period_s,
        _serialises(observer), fmu.once, observer.crosses_events() and fmu.step_done, offers_exchange=not fmu.step_s,
    )  # fmt: skip
    made = {
        "modelDescription.xml": model_description(about, rows, {"s": _SECOND} | fmu.units, fmi_version),
        "documentation/index.html": page(title, _about(observer), rows),
        "resources/variables.txt": _variables(observer, rows),
        f"{PLANT}observer.plan": observer.plan.text(f"binaries/*/{fmu.identifier}.*"),
    }
    return made | ({"terminalsAndIcons/terminalsAndIcons.xml": terminals(rows)} if fmi_version == 3 else {})


def _platform(name: str) -> str | None:
    """Of a binary in an archive; None for other files."""
    folder, _, rest = name.removeprefix("binaries/").partition("/")
    return _PLATFORMS.get(folder, folder) if name.startswith("binaries/") and rest else None


def _platforms(archive: zipfile.ZipFile) -> set[str]:
    return {platform for name in archive.namelist() if (platform := _platform(name.removeprefix("./")))}


def _taken(archive: zipfile.ZipFile, beginnings: tuple[str, ...], platforms: set[str]) -> dict[str, bytes]:
    """Content by path: of these folders, and binaries for these platforms."""
    entries = {name.removeprefix("./"): name for name in archive.namelist() if not name.endswith("/")}
    wanted = (name for name in entries if name.startswith(beginnings) or _platform(name) in platforms)
    return {name: archive.read(entries[name]) for name in wanted}


def _archive(contents: dict[str, bytes]) -> Iterator[bytes]:
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(contents):
            # Equal content, equal bytes, whatever the day.
            archive.writestr(zipfile.ZipInfo(name), contents[name], zipfile.ZIP_DEFLATED)
    yield made.getvalue()


def _serialises(observer: Observer) -> bool:
    """Whether its state can be written down, which is the plant's to allow."""
    try:
        observer.save()
    except HnavError:
        return False
    return True


# --------------------------------------------------------------------------------------------- the table


def table(observer: Observer, period_s: float, covariance: bool | None = None) -> list[Row]:
    """The variables, in the order of their value references. Raises HnavValueError where two have one name."""
    rows = [
        Row("time", 0, "time", "Simulation time", causality="independent", variability="continuous", unit="s"),
        *_inputs(observer), *_parameters(observer, period_s), *_outputs(observer, covariance), *_health(observer),
    ]  # fmt: skip
    if not plant_of(observer).step_s:
        rows = _with_states(observer, [*rows, *_indicators(observer)])
    for name, count in Counter(row.name for row in rows).items():
        if count > 1:
            raise HnavValueError("option", f"two variables of the FMU would be called {name}: rename one in the plant", name)
    return rows


def _unit(observer: Observer, name: str) -> str:
    return plant_of(observer).variables[name].unit


def _sampled(kind: str, index: int, name: str) -> list[Row]:
    return [
        Row(f"{kind}_sample", index, f"{name}.sample", "Sample counter: a change marks a new sample (sampling_mode auto or counter)", "integer",
            "input"),
        Row(f"{kind}_t_meas", index, f"{name}.t_meas", "Time at which the sample was measured (sampling_mode auto or counter)",
            causality="input", unit="s"),
    ]  # fmt: skip


def _first_known(*values: float) -> float:
    """The first that is not NaN."""
    return next(value for value in values if value == value)


def _inputs(observer: Observer) -> Iterator[Row]:
    fmu, plan = plant_of(observer), observer.plan
    for k, (name, sensor) in enumerate(plan.sensors.items()):
        start = fmu.variables[sensor.of].start
        yield Row("sensor_value", k, f"{name}.value", "Sample of this variable of the plant", causality="input",
                  unit=_unit(observer, sensor.of), start=_first_known(start, 0.0))  # fmt: skip
        yield from _sampled("sensor", k, name)
        yield Row("sensor_valid", k, f"{name}.valid", "False: the sample is not used", "boolean", "input", start=1)
    for k, (name, told) in enumerate(plan.inputs.items()):
        known = _first_known(told.start, fmu.variables[name].start, 0.0)
        yield Row("input_value", k, f"{name}.value", "Input of the plant, held from sample to sample", causality="input",
                  unit=_unit(observer, name), start=known)  # fmt: skip
        yield from _sampled("input", k, name)
    yield Row("reset", 0, "reset", "Rising edge: back to the state after initialization", "boolean", "input")


def _parameter(
    role: str, index: int, name: str, text: str, start: float, unit: str = "", min: float = 0.0, **more: object
) -> Row:
    made = Row(role, index, name, text, causality="parameter", variability="fixed", unit=unit, start=start, min=min)
    return replace(made, **more)  # type: ignore[arg-type]


def _parameters(observer: Observer, period_s: float) -> Iterator[Row]:
    plan, (starts, _) = observer.plan, observer.estimate()
    modes: dict[str, Any] = dict(type="enumeration", choices=tuple(_MODES.items()), max=3.0)
    yield _parameter("sampling_mode", 0, "sampling_mode", "What makes held inputs a sample", 3, **modes)
    for kind, names in (("sensor", plan.sensors), ("input", plan.inputs)):
        for k, name in enumerate(names):
            text = "Sampling period (sampling_mode auto, periodic or held); 0: never"
            yield _parameter(f"{kind}_period", k, f"{name}.period", text, period_s, "s", max=1e6)
    known = {**plan.states, **plan.unknown_inputs, **plan.parameters}
    for k, (name, told) in enumerate(known.items()):
        unit = _unit(observer, name)
        density = f"{unit}/sqrt(s)" if unit else "1/sqrt(s)"
        # Before bounds cut it, which the FMU does too; that of the estimate they have cut.
        start = _first_known(told.start, plan.set_values.get(name, _NAN), plant_of(observer).variables[name].start, starts[name])
        yield _parameter("start", k, f"start.{name}", "Estimate at the start", start, unit, min=-_INF)
        text = "Its standard deviation"
        yield _parameter("start_sigma", k, f"start_sigma.{name}", text, told.start_sigma, unit, is_difference=True)
        yield _parameter("noise", k, f"noise.{name}", "White noise that drives it", told.noise, density)
    for k, (name, sensor) in enumerate(plan.sensors.items()):
        noise = abs(sensor.factor) * sensor.noise
        unit, text = _unit(observer, sensor.of), "Standard deviation of a sample"
        yield _parameter("sensor_sigma", k, f"{name}.noise", text, noise, unit, is_difference=True)
        text = "NIS beyond which a sample is used with more noise, once ready; 0: never"
        yield _parameter("gate_nis", k, f"{name}.gate_nis", text, sensor.gate_nis)
        offset, text = sensor.factor * sensor.own_offset, "Added to a sample"
        yield _parameter("sensor_offset", k, f"{name}.offset", text, offset, unit, min=-_INF, is_difference=True)
    yield from _options(observer)


def _options(observer: Observer) -> Iterator[Row]:
    """Options of the library, GROUP.NAME."""
    values = observer.options.as_dict()
    for k, info in enumerate(option_rows("observer").values()):
        if info.name in _OWN_OPTIONS:
            continue
        value = info.choices.index(values[info.attribute]) if info.choices else float(values[info.attribute])
        kind = "enumeration" if info.choices else "integer" if info.is_integer else "real"
        choices = tuple(zip(info.choices, info.choice_descriptions))
        yield _parameter("option", k, f"{info.group}.{info.name}", info.description, value, info.unit, info.min, max=info.max, type=kind,
                         choices=choices)  # fmt: skip


def _outputs(observer: Observer, covariance: bool | None) -> Iterator[Row]:
    yield Row("post_t", 0, "post.t", "Time of the newest used sample; the start time before the first", unit="s")
    for prefix, role, text in (
        ("post", "post", "Estimate just after the newest used sample: the same bits whatever the steps"),
        ("post_sigma", "post_sigma", "Its standard deviation"),
        ("est", "estimate", "Estimate now"),
        ("sigma", "sigma", "Its standard deviation now"),
    ):
        flows = role in ("estimate", "sigma")
        for k, name in enumerate(observer.names):
            yield Row(role, k, f"{prefix}.{name}", text, unit=_unit(observer, name), is_difference="sigma" in role,
                      variability="continuous" if flows else "discrete")  # fmt: skip
    N = len(observer.names)
    for i in range(N if covariance or (covariance is None and N <= LARGEST_COVARIANCE) else 0):
        for j in range(i, N):
            text = f"Covariance of {observer.names[i]} and {observer.names[j]}"
            yield Row("covariance", i * N + j, f"cov[{i + 1},{j + 1}]", text, variability="continuous")
    for k, (name, sensor) in enumerate(observer.plan.sensors.items()):
        unit = _unit(observer, sensor.of)
        yield Row("innovation", k, f"innov.{name}", "Innovation of its newest used sample: measured minus expected", unit=unit,
                  is_difference=True)  # fmt: skip
        yield Row("innovation_sigma", k, f"innov_sigma.{name}", "Standard deviation that was expected of it", unit=unit,
                  is_difference=True)  # fmt: skip
        yield Row("nis", k, f"nis.{name}", "Its normalised square: 1 in the mean")
        yield Row("mean_nis", k, f"mean_nis.{name}", "Mean over about the last 50")
        yield Row("sensor_used", k, f"count.{name}.used", "Samples used", "integer")
        yield Row("sensor_inflated", k, f"count.{name}.inflated", "Samples that the gate used with more noise", "integer")


def _health(observer: Observer) -> Iterator[Row]:
    stated = "Every sigma is below its limit by evidence, and innovations are as large as stated"
    yield Row("ready", 0, "ready", stated, "boolean")
    yield Row("begun", 0, "begun", "The estimate has begun", "boolean")
    yield Row("repeatable", 0, "repeatable", "The plant answers bit for bit the same to the same question", "boolean")
    yield from (Row(role, 0, f"count.{role}", text, "integer") for role, text in _COUNTS.items())
    if observer.crosses_events():
        yield Row("parts", 0, "parts", "Into which the estimate is split: they differ in the events that have been", "integer")
        yield Row("largest_part", 0, "largest_part", "Weight of the largest, 0 to 1")
        yield from (Row(role, 0, f"count.{role}", text, "integer") for role, text in _EVENTS.items())


def _indicators(observer: Observer) -> Iterator[Row]:
    for k in range(observer.info().n_indicators):
        text = "Event indicator of the plant; 1 before the estimate has begun"
        yield Row("indicator", k, f"indicator[{k + 1}]", text, causality="local", variability="continuous", depends_on=None,
                  is_indicator=True)  # fmt: skip


@dataclass(frozen=True)
class _Flowing:
    """Rows of the states of Model Exchange: moving estimates x, their transition S since the last sample by rows, the upper triangle of
    the noise Q that entered since, and the time since. x' = f(x, t), S' = A S, Q' = A Q + Q A' + noise, A = df/dx at x and t."""

    first: int
    moving: int
    N: int

    def transition(self, i: int, j: int) -> int:
        return self.first + self.moving + i * self.N + j

    def noise(self, i: int, j: int) -> int:
        i, j = min(i, j), max(i, j)
        return self.transition(self.moving, 0) + i * self.N - i * (i - 1) // 2 + j - i

    def states(self, observer: Observer) -> Iterator[tuple[str, str, str]]:
        """Name, text and unit of each."""
        for name in observer.names[: self.moving]:
            yield f"state.{name}", "Estimate", _unit(observer, name)
        for i, j in product(range(self.moving), range(self.N)):
            yield f"state.S[{i + 1},{j + 1}]", "Transition since the last sample", ""
        for i, j in combinations_with_replacement(range(self.N), 2):
            yield f"state.Q[{i + 1},{j + 1}]", "Noise that entered since, scaled", ""
        yield "state.clock", "Time since", "s"

    def slopes(self) -> Iterator[set[int]]:
        """The states on which the derivative of each depends."""
        clock = self.noise(self.N - 1, self.N - 1) + 1
        here, moving, every = {*range(self.first, self.first + self.moving), clock}, range(self.moving), range(self.N)
        yield from (here for _ in moving)
        columns = [here | {self.transition(k, j) for k in moving} for j in every]
        for _ in moving:
            yield from columns
        for i, j in combinations_with_replacement(every, 2):
            yield here | {self.noise(k, with_k) for k in every for with_k in (i, j)}
        yield set()

    def under(self, row: Row) -> tuple[int, ...] | None:
        """The states on which an output depends."""
        if row.is_indicator:
            return None
        if row.role == "estimate":
            return (self.first + row.index,) if row.index < self.moving else ()
        if row.role not in ("sigma", "covariance"):
            return ()
        i, j = (row.index, row.index) if row.role == "sigma" else divmod(row.index, self.N)
        moved = {self.transition(k, with_k) for k in (i, j) if k < self.moving for with_k in range(self.N)}
        return tuple(sorted(moved | {self.noise(i, j)}))


def _with_states(observer: Observer, rows: list[Row]) -> list[Row]:
    """The rows, what flows in Model Exchange behind them, and on which of it outputs and derivatives depend. None is left open: PyFMI takes
    that for no dependency; and none names more than there is, because 6273 derivatives of 6273 states are read for minutes."""
    plan, first = observer.plan, len(rows)
    flowing = _Flowing(first, len(plan.states) + len(plan.unknown_inputs), len(observer.names))
    state = list(flowing.states(observer))
    made = [replace(row, depends_on=flowing.under(row)) for row in rows]
    kind: dict[str, Any] = dict(causality="local", variability="continuous")
    made += [Row("state", k, name, text, unit=unit, is_state=True, **kind) for k, (name, text, unit) in enumerate(state)]
    return made + [
        Row("derivative", k, f"der({name})", text, derivative_of=first + k, depends_on=tuple(sorted(on_states)), **kind)
        for k, ((name, text, _), on_states) in enumerate(zip(state, flowing.slopes(), strict=True))
    ]


# --------------------------------------------------------------------------------------------- texts


def _variables(observer: Observer, rows: list[Row]) -> str:
    """The table as the binary reads it: fmu/observer/variables.hpp."""
    plan, nx = observer.plan, sum(row.is_state for row in rows)
    sizes = [len(of) for of in (plan.states, plan.unknown_inputs, plan.parameters, plan.inputs, plan.sensors)]
    lines = ["hnav_observer_variables 2", f"sizes {' '.join(map(str, [*sizes, nx]))}"]
    numbers = [" ".join(map(_in_any_locale, (row.start, row.min, row.max))) for row in rows]
    lines += [f"{row.role} {row.index} {of_row} {row.name}" for row, of_row in zip(rows, numbers)]
    return "\n".join([*lines, "end", ""])


def _in_any_locale(value: float) -> str:
    """The number without a decimal point: strtod of a process expects that of its locale."""
    if not math.isfinite(value):
        return repr(float(value))
    sign, digits, exponent = Decimal(repr(float(value))).as_tuple()
    return f"{'-' * sign}{''.join(map(str, digits))}e{exponent}"


def _about(observer: Observer) -> list[str]:
    fmu, plan = plant_of(observer), observer.plan
    flow = (
        "Between them sigma points pass through the plant's own steps: it offers Co-Simulation only, and so does its observer."
        if fmu.step_s
        else "Between them SUNDIALS integrates the states and their transition matrix; in Model Exchange the importer does, and these and the "
        "noise that enters are continuous states."
    )
    options = ", ".join(f"{name} = {number(v) if isinstance(v, float) else v}" for name, v in observer.options.changed().items())
    return [
        f"Estimates {', '.join(observer.names)} of {fmu.name} from samples of {', '.join(plan.sensors)}"
        + (f", knowing {', '.join(plan.inputs)}" if plan.inputs else "")
        + ". The plant is inside, under resources/plant, with its own licences; whoever passes this FMU on needs the right to pass the plant on.",
        f"Inputs are samples: sampling_mode says what makes one. {flow} At a sample an extended Kalman filter corrects them. Values are in the "
        "plant's units.",
        *(
            ["There the plant's events are the importer's, on one estimate: in Co-Simulation it splits where an event may have been or not."]
            if observer.crosses_events()
            else []
        ),
        *([f"Options that differ from their defaults: {options}."] if options else []),
        *(f"{sentence[:1].upper()}{sentence[1:]}." for sentence in observer.lies()),
    ]  # fmt: skip
