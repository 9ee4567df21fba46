"""An estimator for a model of one's own: an FMU for Model Exchange, or functions in Python.

    plan = hnav.Plan("oscillator.fmu").sensor("x0", noise=0.05).state("x0", start_sigma=1.0).state("x1", start_sigma=1.0, noise=0.1)
    run = hnav.Observer(plan).run(t_s, {"x0": y})
    run.x["x1"], run.sigma["x1"], run.nis["x0"], run.ready

FMUs are native code: one runs with all your rights. Observers of different threads run in parallel; one serves one thread at a time.
"""

from __future__ import annotations

import math
import os
import shutil
import warnings
import weakref
import zipfile
from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from hnav.errors import HnavError, HnavRuntimeError, HnavValueError, PlausibilityWarning
from hnav.filters.hybrid_view import NumberedObject
from hnav.filters.observer_plan import Estimated, Input, Plan, Sensor
from hnav.filters.plant import Asked, Plant
from hnav.filters.run_base import RunBase
from hnav.io.archive_room import Room
from hnav.io.model_description import ModelDescription
from hnav.io.outputs import temporary_folder, writing
from hnav.native.arrays import Array, Record, address, doubles, times
from hnav.native.library import enumerators, ffi, library, new, text
from hnav.native.options import OptionSet, complete

BLOCKS = enumerators("hnav_plant_block", "HNAV_")
"""What derivatives a plant may offer: derivatives_by_states, ..., outputs_by_parameters."""


class ObserverOptions(OptionSet):
    """Options of the observer, as attributes; option_rows("observer") has unit, range and meaning of each.

        ObserverOptions(horizon_s=0.2)

    Raises HnavValueError for names (UnknownOptionError) and values that do not exist.
    """

    LIST = "observer"


NAMED = 3  # estimates in the line of a run
Known = Mapping[str, Sensor] | Mapping[str, Input]
_DROPPED, _HELD = 1, 2  # bits of hnav_observer_run_output.failed

# --------------------------------------------------------------------------------------------- results


@dataclass(repr=False)
class ObserverRun(RunBase):
    """Arrays of a run of an observer, one row for each instant, by the names of what is estimated and of the sensors."""

    t_s: Array
    """The instants."""
    x: dict[str, Array]
    """The estimate, in the plant's units."""
    sigma: dict[str, Array]
    """Its standard deviations."""
    covariance: Array
    """n x N x N, in the order of x."""
    innovation: dict[str, Array]
    """By sensor, in its unit: measured minus expected; NaN in rows without a sample, or one that was not used."""
    nis: dict[str, Array]
    """By sensor: normalised square of the innovation, 1 in the mean."""
    log_likelihood: Array
    """Of the samples of a row, given those before; NaN in rows without one."""
    ready: npt.NDArray[np.bool_]
    """As ObserverInfo.ready."""
    parts: npt.NDArray[np.uint8]
    """As ObserverInfo.parts."""
    plant_events: Array
    """Events of the plant that have been, the mean of the parts."""
    proof: dict[str, BlockProof]
    """What became of the derivatives that the plant offers."""
    dropped: int
    """Instants for which the plant had no answer."""
    dropped_because: str
    """What was said of the first of them, or of the first that was held; "" for none."""
    held: int
    """Intervals for the rest of which the plant had no answer: the estimate was held there, with a sigma that grew."""
    plan: Plan
    """That of the observer."""
    smoothed: bool = False
    """x, sigma and covariance are from all samples, before and after a row."""

    def in_one_line(self) -> str:
        """Rows, length, last estimate."""
        last = [f"{name} {self.x[name][-1]:.4g} ± {self.sigma[name][-1]:.2g}" for name in self.x] if len(self.t_s) else []
        named = ", ".join(last[:NAMED]) + (", ..." if len(last) > NAMED else "")
        smoothed = ", smoothed" if self.smoothed else ""
        return f"{self.size_in_words()}{smoothed}, last {named or 'nothing'}, {'ready' if self.ready[-1:].any() else 'not ready'}"

    def columns(self) -> dict[str, np.ndarray]:
        """Those of the table: estimates by name, sigma.NAME, innovation.SENSOR, nis.SENSOR; parts and events of a plant that has events."""
        table = dict(self.x)
        for prefix, rows in (("sigma", self.sigma), ("innovation", self.innovation), ("nis", self.nis)):
            table |= {f"{prefix}.{name}": values for name, values in rows.items()}
        events = {"parts": self.parts.astype(float), "plant_events": self.plant_events} if self.has_events else {}
        return table | events | {"ready": self.ready.astype(float)}

    def dropped_in_words(self) -> list[str]:
        """A line about the instants that the plant had no answer for, if any."""
        if not self.dropped:
            return []
        return [
            f"{self.dropped} of {len(self.t_s)} instants were dropped, and the estimate stayed where it was; the first: {self.dropped_because}; "
            "look at the model there, or begin nearer to the truth"
        ]

    def held_in_words(self) -> list[str]:
        """A line about the intervals that the plant had no answer for, if any."""
        if not self.held:
            return []
        return [
            f"the plant had no answer for the rest of {self.held} intervals: the estimate was held there, its sigma grew, and it was not ready; "
            f"the first: {self.dropped_because}; look at the model there, or give the states their bounds (min, max)"
        ]

    @property
    def has_events(self) -> bool:
        """The plant has had some of its own, or may have."""
        return bool((self.plant_events > 0).any() or (self.parts > 1).any())


@dataclass(frozen=True, eq=False)
class ObserverInfo(Record):
    """Where the observer stands."""

    begun: bool
    """The estimate has begun."""
    ready: bool
    """Every sigma is below its ready_sigma by evidence, and innovations are as large as they are said to be."""
    repeatable: bool
    """The plant answers bit for bit the same; so does the observer."""
    now_s: float
    """Time of what is shown; -inf before the first advance."""
    newest_s: float
    """Of the newest used sample; -inf before the first."""
    late_limit_s: float
    """Older samples are refused."""
    events: int
    """Instants that were used."""
    corrections: int
    """Those with a sensor."""
    late: int
    """Samples that came too late."""
    non_finite: int
    """Samples that were no numbers."""
    dropped: int
    """Instants that led to no estimate."""
    flow_evaluations: int
    """How often the plant's derivatives were asked by the solver."""
    steps: int
    """Of the solver."""
    parts: int
    """Into which the estimate is split: they differ in the events that have been."""
    largest_part: float
    """Weight of the largest, 0 to 1."""
    plant_events: int
    """Events of the plant that changed something, as the largest part has them."""
    splits: int
    """How often the estimate was split."""
    grazing: int
    """Guards hardly crossed or missed, or crossed with another: there points go in place of derivatives."""
    chattering: int
    """Events beyond the fiftieth of an interval: the covariance does not go through them."""
    projected: int
    """Corrections that were put back before a guard."""
    n_indicators: int
    """Of the plant."""
    crosses: bool
    """The plant has events of its own."""
    outliers: int
    """Samples that were rejected as outliers, of all sensors."""
    stuck: int
    """Samples that were rejected because their sensor repeated one value."""
    stamps_left_out: int
    """Samples whose stamp lay far ahead of all others."""
    clock_jumps: int
    """Stamps ran back: a new time base began."""
    held: int
    """Intervals for the rest of which the plant had no answer: the estimate was held there, its covariance grew, and it was not ready."""


@dataclass(frozen=True, eq=False)
class BlockProof(Record):
    """Derivatives that a plant offers, beside differences."""

    offered: bool
    """By the plant."""
    exact: bool
    """Confirmed at five points, and used; otherwise differences are."""
    row: int
    """Of the worst element: the derivative or sensor."""
    column: int
    """What is estimated."""
    stated: float
    """There, by the plant."""
    measured: float
    """There, by differences."""


def contradicted(proof: Mapping[str, BlockProof], plan: Plan) -> list[str]:
    """A sentence for each block of derivatives that differences contradict; differences are used in its place."""
    sentences = []
    for name, block in proof.items():
        if not block.exact:
            of = [*plan.sensors] if name.startswith("outputs") else [f"der({state})" for state in plan.states]
            pair = f"d {of[block.row]} / d {plan.estimated[block.column]}"
            sentences.append(
                f"{name.replace('_', ' ')}: the plant says {pair} = {block.stated:.6g}, differences {block.measured:.6g}; differences are used"
            )
    return sentences


# --------------------------------------------------------------------------------------------- the observer


class Observer(NumberedObject):
    """Estimates what a Plan names.

        Observer(plan, horizon_s=0.2)
        Observer(plan, ObserverOptions(horizon_s=0.2))

    Options of the plan (a file may have some) hold where no others are given. Raises HnavValueError, with the reason, for plans and
    plants that are impossible, HnavRuntimeError for a plant without an answer at its start.
    """

    KIND = "filter"

    def __init__(self, plan: Plan, options: ObserverOptions | None = None, **values: object):
        self.plan = plan
        self._options = complete(ObserverOptions, options, values if options is not None else {**plan.options, **values})
        self._asked: Asked | None = None
        self._held_inputs: set[str] = set()  # that have had a value
        if isinstance(plan.plant, Plant):
            self._create_of_functions(plan.plant)
        else:
            self._open(plan.plant)

    def _open(self, fmu: ModelDescription) -> None:
        if fmu.once and fmu.token in _ONLY_ONES:
            wrong = f"{fmu.path.name} can exist only once in a process, and an observer of it is there: delete that first"
            raise HnavRuntimeError("unsupported", wrong)
        folder = _unpack(fmu, self.plan.text())
        try:
            super().__init__("hnav_observer_open", self._options.struct, str(folder).encode())
        except BaseException as error:
            shutil.rmtree(folder, ignore_errors=True)
            if isinstance(error, HnavError) and str(folder) in str(error):  # what the system's loader says of a binary
                shown = str(error).replace(f"{folder}{os.sep}", "")
                raise HnavRuntimeError(error.status, f"{fmu.path.name}: {shown}; export it again") from None
            raise
        weakref.finalize(self, shutil.rmtree, folder, ignore_errors=True)
        if fmu.once:
            _ONLY_ONES[fmu.token] = self

    def _create_of_functions(self, plant: Plant) -> None:
        plan = self.plan
        asked = self._asked = Asked(
            plant, [sensor.of for sensor in plan.sensors.values()], [*plan.inputs, *plan.unknown_inputs], [*plan.parameters]
        )
        struct = new(
            "hnav_plant", n_states=len(plan.states), n_inputs=len(plan.inputs) + len(plan.unknown_inputs),
            n_unknown_inputs=len(plan.unknown_inputs), n_parameters=len(plan.parameters), n_outputs=len(plan.sensors), **asked.sizes, **asked.functions,
        )  # fmt: skip
        rows = _statistics(plan, plant)
        logarithmic = np.array([known.log for known in plan.parameters.values()], np.uint8)
        known = new("hnav_observer_statistics", **{name: address(row) for name, row in rows.items() if len(row)},
                    logarithmic=address(logarithmic if len(logarithmic) else None))  # fmt: skip
        try:
            super().__init__("hnav_observer_create", self._options.struct, struct, known)
        finally:  # what a function in Python has raised, before the library's error that came of it
            asked.raise_kept()

    def _do(self, function: str, *arguments: Any) -> None:
        try:
            super()._do(function, *arguments)
        finally:
            if self._asked is not None:
                self._asked.raise_kept()

    @property
    def options(self) -> ObserverOptions:
        """A copy of the options that the observer was made with."""
        return copy(self._options)

    @property
    def names(self) -> tuple[str, ...]:
        """Of all that is estimated: states, unknown inputs, parameters; the order of covariance()."""
        return self.plan.estimated

    def push(self, sensor: str, t_s: float, value: float) -> None:
        """A sample of a sensor, in its unit. Raises HnavRuntimeError for one that is late."""
        self._push("hnav_observer_push", "sensor", self.plan.sensors, sensor, t_s, value)

    def push_input(self, input: str, t_s: float, value: float) -> None:
        """A known input has this value, times its factor, from t_s on."""
        self._push("hnav_observer_push_input", "input", self.plan.inputs, input, t_s, value)
        self._held_inputs.add(input)

    def advance(self, t_s: float) -> None:
        """Uses the samples up to t_s and shows the estimate there. Raises HnavRuntimeError where the plant had no answer: those samples
        are dropped, and what a function in Python has raised is raised again."""
        self._call("advance", t_s)

    def estimate(self) -> tuple[dict[str, float], dict[str, float]]:
        """The estimate at the time of the last advance, and its standard deviations, by name."""
        x, sigma = np.empty((2, len(self.names)))
        self._do("hnav_observer_estimate", address(x), address(sigma))
        return dict(zip(self.names, x.tolist())), dict(zip(self.names, sigma.tolist()))

    def covariance(self) -> Array:
        """N x N."""
        return self._numbers("covariance", (len(self.names),) * 2)[0]

    def info(self) -> ObserverInfo:
        """Where the observer stands."""
        return ObserverInfo.read(self._filled_by("hnav_observer_get_info", "hnav_observer_info"))

    def crosses_events(self) -> bool:
        """The plant has events of its own."""
        return self.info().crosses

    def proof(self) -> dict[str, BlockProof]:
        """What became of the derivatives that the plant offers, by block; blocks that it does not offer are left out."""
        found = {}
        for index, name in enumerate(BLOCKS):
            struct = self._filled_by("hnav_observer_proof", "hnav_observer_block_proof", index)
            if struct.offered:
                found[name] = BlockProof.read(struct)
        return found

    def lies(self) -> list[str]:
        """A sentence for each block of derivatives that differences contradict; differences are used in its place."""
        return contradicted(self.proof(), self.plan)

    def run(
        self, t_s: npt.ArrayLike, sensors: Mapping[str, npt.ArrayLike], inputs: Mapping[str, npt.ArrayLike] | None = None, *, smooth: bool = False,
    ) -> ObserverRun:  # fmt: skip
        """Row after row, bit for bit as push and advance (of inputs that are interpolated with the means to the next row): t_s is n, each array n with NaN where there is no sample. Sensors that are
        not given have none; an input of the plan without a sample, here or before, gives a warning. An instant for which the plant has no answer is dropped and counted. smooth: with hindsight, as by the method
        smooth."""
        plan, t = self.plan, times(t_s)
        if among := next((name for name in sensors if name in plan.inputs and name not in plan.sensors), None):
            wrong = f"{among!r} is an input of the plan, no sensor: give it by inputs={{{among!r}: ...}}"
            raise HnavValueError("option", wrong, among)
        n, N, m = len(t), len(self.names), len(plan.sensors)
        seen = _columns(sensors, plan.sensors, n, "sensor")
        held = _columns(inputs or {}, plan.inputs, n, "input")
        self._note_inputs(held, smooth)
        for k, known in enumerate(plan.inputs.values()):
            if known.interpolation == "linear":
                held[:, k] = _means_to_the_next(t, held[:, k])
        shapes = dict(x=(n, N), sigma=(n, N), covariance=(n, N, N), innovation=(n, m), nis=(n, m))
        made: dict[str, Any] = {name: np.empty(shape) for name, shape in shapes.items()}
        made |= {name: np.empty(n) for name in ("log_likelihood", "plant_events")}
        made |= {name: np.empty(n, np.uint8) for name in ("ready", "parts", "failed")}
        given = new("hnav_observer_run_input", t_s=address(t), sensors=address(seen), inputs=address(held if held.size else None))
        wanted = new("hnav_observer_run_output", **{name: address(array) for name, array in made.items()})
        if smooth:
            self._do("hnav_observer_smooth", n, given, wanted)
        else:
            self._do("hnav_observer_run", n, given, wanted, ffi.NULL)
        return self._run_of(t, made, smooth)

    def _run_of(self, t_s: Array, made: dict[str, Any], smooth: bool) -> ObserverRun:
        """From the arrays that the library has filled, by name."""
        plan, failed = self.plan, made.pop("failed")
        made["innovation"] = made["innovation"] / np.array([sensor.factor for sensor in plan.sensors.values()])
        made |= {name: dict(zip(self.names, made[name].T)) for name in ("x", "sigma")}
        made |= {name: dict(zip(plan.sensors, made[name].T)) for name in ("innovation", "nis")}
        made["ready"] = made["ready"].astype(bool)
        made |= {name: int((failed & bit > 0).sum()) for name, bit in (("dropped", _DROPPED), ("held", _HELD))}
        made["proof"] = self.proof()
        because = text(library().hnav_filter_message(self._handle)) if failed.any() else ""
        return ObserverRun(t_s=t_s, **made, dropped_because=because, plan=plan, smoothed=smooth)

    def _note_inputs(self, held: Array, smooth: bool) -> None:
        """Warns of an input that has never had a sample; a smoother begins from the start of the plan."""
        sampled = {name for name, column in zip(self.plan.inputs, held.T) if np.isfinite(column).any()}
        if not smooth:
            sampled = self._held_inputs = self._held_inputs | sampled
        missing = next((name for name in self.plan.inputs if name not in sampled), None)
        if len(held) and missing is not None:
            warnings.warn(
                f"the plan samples {missing}, and no sample of it has come: it stays at its start; "
                f"give inputs={{{missing!r}: ...}} or leave it out of the plan", PlausibilityWarning, stacklevel=4 if smooth else 3,
            )  # fmt: skip

    def smooth(self, *samples: Any, **named: Any) -> ObserverRun:
        """As run, with hindsight: x, sigma and covariance of a row are from all samples, before and after it, through events of the plant
        too (Rauch-Tung-Striebel over all parts of the estimate). From the start of the plan; the observer itself stays where it is.
        innovation, nis, log_likelihood and parts are those of the filter; ready: at this row or a later one.

            Observer(plan).smooth(t_s, {"x0": y})
        """
        return self.run(*samples, **(named | {"smooth": True}))

    def export(
        self, path: Path | str, fmi_version: int = 2, *, period_s: float = 0.01, covariance: bool | None = None
    ) -> list[str]:
        """Writes an FMU, FMI 2 or 3, Co-Simulation and Model Exchange, that estimates what this observer does, with the plant and its
        licences inside; noises, start and options are its parameters. period_s: of its samples, where nothing else marks them.
        covariance: whether all of P is among the outputs, cov[i,j], beside sigmas; None: of up to 16 numbers.
        Answers the platforms that the plant has a binary for and hnav has none, so that the FMU does not run there. Raises HnavValueError
        for a plant of functions in Python, or where no platform is left."""
        from hnav.filters.observer_export import export

        return export(self, path, fmi_version, period_s, covariance)

    def _push(self, function: str, kind: str, among: Known, name: str, t_s: float, value: float) -> None:
        if name not in among:
            raise HnavValueError("out of range", f"the plan has no {kind} {name!r}; it has {', '.join(among) or 'none'}", name)
        known = among[name]
        self._do(function, list(among).index(name), t_s, known.factor * value + known.offset)


# Observers of FMUs that a process can hold once, by token.
_ONLY_ONES: weakref.WeakValueDictionary[str, Observer] = weakref.WeakValueDictionary()


def _columns(given: Mapping[str, npt.ArrayLike], known: Known, n: int, kind: str) -> Array:
    """n x len(known): samples in the plant's units, NaN where none are given."""
    for name in given:
        if name not in known:
            raise HnavValueError("option", f"the plan has no {kind} {name!r}; it has {', '.join(known) or 'none'}", name)
    columns = np.full((n, len(known)), math.nan)
    for index, name in enumerate(known):
        if name in given:
            columns[:, index] = doubles(given[name], (n,), name)
    factors, offsets = (np.array([getattr(one, name) for one in known.values()]) for name in ("factor", "offset"))
    return np.asarray(columns * factors + offsets)


def _means_to_the_next(t_s: Array, values: Array) -> Array:
    """Held from a row to the next it does what a straight line between the samples does, to the second order."""
    known = np.flatnonzero(np.isfinite(values))
    if len(known) < 2:
        return values
    line = np.interp(t_s, t_s[known], values[known])
    means = np.append(0.5 * (line[:-1] + line[1:]), line[-1])
    means[: known[0]] = math.nan
    return means


def _statistics(plan: Plan, plant: Plant) -> dict[str, Array]:
    """The rows of hnav_observer_statistics; a start that is not given is the plant's."""
    own = {**plant.states, **plant.inputs, **plant.parameters}
    known = {**plan.states, **plan.unknown_inputs, **plan.parameters}

    def starts(of: Mapping[str, Estimated] | Mapping[str, Input]) -> list[float]:
        return [own[name] if math.isnan(one.start) else one.start for name, one in of.items()]

    rows = dict(
        start=starts(known), nominal=[k.nominal or 1.0 for k in known.values()], input_start=starts(plan.inputs),
        time_constant_s=[k.time_constant_s for k in plan.unknown_inputs.values()],
        sensor_sigma=[s.noise for s in plan.sensors.values()], gate_nis=[s.gate_nis for s in plan.sensors.values()],
    )  # fmt: skip
    as_given = ("start_sigma", "noise", "ready_sigma", "min", "max")
    rows |= {name: [getattr(k, name) for k in known.values()] for name in as_given}
    return {name: np.array(values, float) for name, values in rows.items()}


def _unpack(fmu: ModelDescription, plan: str) -> Path:
    """What of an FMU is needed at run time, in a folder of its own, and the plan beside it."""
    folder = temporary_folder("hnav_observer_")
    try:
        with writing(f"{folder} (unpacking {fmu.path.name})"), zipfile.ZipFile(fmu.path) as archive:
            needed = (fmu.binary.rsplit("/", 1)[0] + "/", "resources/")
            wanted = [entry for entry in archive.infolist() if entry.filename.startswith(needed)]
            Room("ask its maker for a smaller one").take(wanted, str(fmu.path))
            archive.extractall(folder, wanted)
            (folder / "resources").mkdir(exist_ok=True)
            (folder / "observer.plan").write_text(plan, encoding="utf-8")
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    return folder
