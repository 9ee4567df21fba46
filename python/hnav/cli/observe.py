"""hnav observe: an estimator made of an FMU: its variables, a first plan, and estimates from a table of samples."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from hnav import __version__
from hnav.cli.console import bar, say, written
from hnav.cli.parameters import page_option
from hnav.cli.wanted import SMOOTHED
from hnav.cli.watched import watched
from hnav.cli.words import UsageError
from hnav.errors import HnavError, HnavValueError
from hnav.filters.observer import Observer, ObserverRun
from hnav.filters.observer_findings import findings
from hnav.filters.observer_offsets import offsets
from hnav.filters.observer_plan import Plan, plant_of_file, read_plan
from hnav.filters.plant import Plant
from hnav.io.model_description import ModelDescription, Variable, read_model_description
from hnav.io.outputs import refuse_overwriting, write_files
from hnav.io.sample_table import read_sample_table, sample_table
from hnav.native.arrays import Array

SHOWN = 12  # variables of a kind
GOOD_NIS = (0.8, 1.25)  # in the mean of many samples
GOOD_AHEAD = (0.5, 2.0)  # mean NIS of predictions over ten samples: half or twice the stated variance; chosen
BY_CHANCE = 0.01  # probability that the mean NIS of a right model is outside, on either side
CORRELATED = 0.2  # correlation of an innovation with one of the next five; that of white noise is smaller
INCOMPLETE = 1  # exit code: the plant failed somewhere
WHERE_IT_CRASHES = "ask its maker; if it crashes when it is freed, set never_freed = true under [plant]"

WithCovariance = Annotated[
    bool | None,
    typer.Option(
        "--covariance/--sigmas",
        help="All of P among the outputs of --export, or sigmas alone",
        show_default="of up to 16 numbers",
    ),
]


def command(
    fmu: Annotated[
        Path,
        typer.Argument(
            help="FMU for Model Exchange, FMI 2 or 3, or a file of Python with an hnav.Plant. Either runs with all your rights"
        ),
    ],
    plan: Annotated[
        Path | None,
        typer.Option(metavar="FILE.toml", help="What is estimated and by which sensors; without it a first one is printed"),
    ] = None,
    data: Annotated[
        Path | None,
        typer.Option(metavar="FILE.csv", help="Samples: a column t_s, and one for each sensor and input; an empty cell is none"),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE.csv", help="Estimates to write, one row for each row of the samples")
    ] = None,
    report: Annotated[Path | None, page_option("Page to write: estimates, innovations, derivatives")] = None,
    prove: Annotated[bool, typer.Option("--prove", help="Check each block of derivatives against differences")] = False,
    tune: Annotated[
        bool, typer.Option("--tune", help="Print the noises of sensors and states that make the samples of --data most likely")
    ] = False,
    smooth: Annotated[
        bool, typer.Option("--smooth", help="Estimates with hindsight: every row from all samples, before and after it")
    ] = False,
    check: Annotated[
        bool, typer.Option("--check", help="Print how well the samples of --data determine each state and parameter")
    ] = False,
    export: Annotated[
        Path | None, typer.Option(metavar="FILE.fmu", help="FMU to write that estimates by this plan, with the plant inside")
    ] = None,
    fmi: Annotated[int, typer.Option(metavar="2|3", help="Version of FMI of --export")] = 2,
    period_s: Annotated[
        float, typer.Option("--period", metavar="S", help="Sampling period of --export, where counters do not mark samples")
    ] = 0.01,
    covariance: WithCovariance = None,
) -> None:
    refuse(fmu, plan, data, tune or check, smooth, [out, report], export)
    refuse_overwriting([out, report, export], [fmu, plan, data])
    if fmu.suffix != ".py":
        watched(fmu.name, WHERE_IT_CRASHES)
    with faults_of(fmu):
        if plan is None:
            return describe_plant(fmu, prove)
        observer = observer_of(plan, fmu)
        for sentence in observer.lies():
            say(sentence)
        if prove:
            print_proof(observer)
        if export is not None:
            write_fmu(observer, export, fmi, period_s, covariance)
        elif data is None and not prove:
            say(f"{fmu.name} and {plan.name} fit: {', '.join(observer.names)} by {', '.join(observer.plan.sensors)}")
        if data is not None:
            use_samples(observer, data, check, tune, smooth, out, report)


@contextmanager
def faults_of(plant: Path) -> Iterator[None]:
    """Raises UsageError that names the line of a plant in Python that has raised something."""
    try:
        yield
    except Exception as error:
        lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if Path(frame.filename) == plant]
        if isinstance(error, SyntaxError) and error.filename == str(plant):
            lines = [error.lineno]
        if plant.suffix != ".py" or not lines or isinstance(error, HnavError):
            raise
        raise UsageError(f"{plant}, line {lines[-1]}: {type(error).__name__}: {error}") from None


def observer_of(plan: Path, fmu: Path) -> Observer:
    """Raises HnavValueError that names the file of the plan."""
    known = read_plan(plan, fmu)
    try:
        return Observer(known)
    except HnavValueError as error:
        raise HnavValueError(error.status, f"{plan.name}: {error}", error.argument) from None


def use_samples(
    observer: Observer, data: Path, check: bool, tune: bool, smooth: bool, out: Path | None, report: Path | None
) -> None:
    """Writes all outputs for a table of samples. Exits with INCOMPLETE if the plant failed somewhere."""
    if check:
        print_observability(observer, data)
    if tune:
        print_noises(observer, data)
    if out is not None or report is not None:
        run = observe(observer, data, smooth, out, report)
        if run.dropped or run.held:
            raise typer.Exit(INCOMPLETE)


def refuse(
    fmu: Path, plan: Path | None, data: Path | None, examined: bool, smooth: bool, files: list[Path | None], export: Path | None
) -> None:
    """Raises UsageError for incompatible options; examined: by --check or --tune, files: of estimates."""
    estimated = any(file is not None for file in files)
    if smooth and not estimated:
        raise UsageError("--smooth belongs to --out or --report, which write the estimates")
    if (data is not None) != (examined or estimated):
        raise UsageError("--data belongs to --out, --report, --check or --tune: samples in, estimates or noises out")
    if plan is None and (data is not None or export is not None):
        raise UsageError(f"a plan is missing: hnav observe {fmu} prints one to start with, then give --plan FILE.toml")


def write_fmu(observer: Observer, path: Path, version: int, period_s: float, covariance: bool | None) -> None:
    """Writes the observer as an FMU; prints the platforms that it does not support."""
    lost = observer.export(path, version, period_s=period_s, covariance=covariance)
    say(f"{path}: FMI {version}, Co-Simulation and Model Exchange; {observer.plan.plant.name} and its licences are inside")  # type: ignore[union-attr]
    plan, first = observer.plan, observer.names[0]
    fed = ", ".join(f"{name}.value" for name in [*plan.sensors, *plan.inputs][:SHOWN])
    answers = f"parameters start.{first}, start_sigma.{first}; outputs est.{first}, sigma.{first}"
    say(f"inputs {fed}, a sample each {period_s:g} s; {answers}")
    if lost:
        say(f"it does not run on {', '.join(lost)}, where the plant does: hnav has no binary for that")


Samples = tuple[Array, dict[str, Array], dict[str, Array], dict[str, Array]]


def samples_of(plan: Plan, data: Path) -> Samples:
    """Times, and columns: of sensors, of inputs, all."""
    inputs = {name: known.column for name, known in plan.inputs.items()}
    t_s, columns = read_sample_table(data, {*plan.sensors, *inputs.values()})
    if not any(name in columns for name in plan.sensors):
        raise UsageError(
            f"{data.name} has no column of a sensor: the plan names {', '.join(plan.sensors)}, it has {', '.join(columns)}; call a sensor as "
            "its column, and say of what variable it is: of"
        )
    sensors = {name: column for name, column in columns.items() if name in plan.sensors}
    return t_s, sensors, {name: columns[column] for name, column in inputs.items() if column in columns}, columns


def observe(observer: Observer, data: Path, smooth: bool, out: Path | None, report: Path | None) -> ObserverRun:
    """Estimates from a table, into a table and a page."""
    plan = observer.plan
    t_s, sensors, inputs, columns = samples_of(plan, data)
    wanted = {*plan.sensors, *(known.column for known in plan.inputs.values())}
    run = observer.run(t_s, sensors, inputs, smooth=smooth)
    found = findings(run, plan)
    if out is not None:
        made = plan.plant.name if isinstance(plan.plant, ModelDescription) else "functions"
        lines = [f"hnav {__version__}", f"observer of {made}", f"samples {data}", *([SMOOTHED] if smooth else [])]
        write_files({out: sample_table(lines, {"t_s": run.t_s, **run.columns()})})
    if report is not None:
        # Plotly takes a while to load.
        from hnav.reports.observer_page import report_observer

        report_observer(run, report, data.name, found)
    unused = [name for name in columns if name not in wanted]
    missing = sorted(wanted - {*columns})
    if unused:
        say(f"not in the plan, and not used: {', '.join(unused)}")
    if missing:
        say(f"in the plan, but not in {data.name}: {', '.join(missing)}")
    info = unmodelled_events(observer)
    advice = offset_sentences(run, plan, lambda changed: Observer(changed, observer.options).run(t_s, sensors, inputs))
    for line in [*summary(run), *advice, *info]:
        say(line)
    for one in found[:SHOWN]:
        say(one.sentence(t_s[0]))
    if len(found) > SHOWN:
        say(f"and {len(found) - SHOWN} more, on the page of --report")
    say(f"{len(t_s)} rows to {written(out, report)}")
    return run


def summary(run: ObserverRun) -> list[str]:
    """Results of the run, a line for each sensor and each estimate."""
    lines = [f"{name} = {run.x[name][-1]:.6g} +- {run.sigma[name][-1]:.2g} at the end" for name in run.x] if len(run.t_s) else []
    lines += innovations(run) + unrelated(run)
    if run.has_events:
        unclear = f"in {int((run.parts > 1).sum())} of {len(run.t_s)} rows one may have been or not"
        lines.append(f"{run.plant_events[-1]:.0f} events of the plant; {unclear}")
    return lines + run.dropped_in_words() + run.held_in_words()


def innovations(run: ObserverRun) -> list[str]:
    """A line for each sensor that compares its innovations with their stated sigma."""
    lines = []
    for name, nis in run.nis.items():
        used = nis[np.isfinite(nis)]
        if len(used) == 0:
            lines.append(f"{name}: no sample was used")
            continue
        mean = float(used.mean())
        verdict = "as large as stated"
        if mean > GOOD_NIS[1]:
            verdict = "larger than stated: more noise of the states, or of the sensor, or another model"
        elif mean < GOOD_NIS[0]:
            verdict = "smaller than stated: less noise of the states or of the sensor; far below 1, as beside a plant without noise, it is not ready"
        lines.append(f"{name}: {len(used)} samples, mean NIS {mean:.2f}: innovations are {verdict}")
    return lines


def unrelated(run: ObserverRun) -> list[str]:
    """A line for each sensor whose expected value has no uncertainty but the sensor's noise."""
    lines = []
    for name, nis in run.nis.items():
        of_noise = (run.innovation[name] / run.plan.sensors[name].noise) ** 2
        used = np.isfinite(nis) & (of_noise > 0)  # an innovation of 0 shows nothing
        if used.any() and np.allclose(nis[used], of_noise[used], rtol=1e-9, atol=0):
            lines.append(f"{name} depends on nothing that is estimated: its samples change no estimate; see its equation")
    return lines


def unmodelled_events(observer: Observer) -> list[str]:
    """Notes on events through which the covariance is not propagated."""
    beyond = observer.info().chattering
    cure = "sigma does not go through them; smooth the plant there"
    return [f"{beyond} events came beyond the fiftieth of an interval: {cure}"] if beyond else []


def offset_sentences(run: ObserverRun, plan: Plan, follow: Callable[[Plan], ObserverRun]) -> list[str]:
    """A line for each sensor with an offset; follow: a run of a changed plan."""
    lines = []
    for name, offset in offsets(run, plan, follow).items():
        more = plan.sensors[name].own_offset - offset
        reads = f"{name} reads {abs(more):.3g} {'more' if more > 0 else 'less'} than expected in the median"
        lines.append(f"{reads}: offset = {offset:.3g} in its table takes it away")
    return lines


def print_observability(observer: Observer, data: Path) -> None:
    """Prints how well the samples determine each estimate."""
    from hnav.filters.observer_observability import observability

    t_s, sensors, inputs, _ = samples_of(observer.plan, data)
    for line in observability(observer.plan, t_s, sensors, inputs, observer.options).sentences():
        say(line)


def print_noises(observer: Observer, data: Path) -> None:
    """Prints the most likely noises, as lines for the plan, with notes on them."""
    from hnav.filters.observer_tuning import AHEAD, tune

    t_s, sensors, inputs, _ = samples_of(observer.plan, data)
    with bar() as progress:
        # The number of trials is not known in advance.
        task = progress.add_task("trials", total=None)
        tuned = tune(observer.plan, t_s, sensors, inputs, observer.options, lambda _: progress.update(task, advance=1))
    before, after = tuned.log_likelihood
    say(f"log-likelihood of the samples {before:.1f}, with the noises below {after:.1f}:")
    plan = tuned.plan
    for name, sensor in plan.sensors.items():
        offset = f"\noffset = {sensor.own_offset:.4g}" if name in tuned.offsets else ""
        say(f'[sensor."{name}"]\nnoise = {sensor.noise:.4g}{offset}')
    for table, known in (("state", plan.states), ("unknown_input", plan.unknown_inputs), ("parameter", plan.parameters)):
        for name, noisy in known.items():
            if noisy.noise > 0:
                say(f'[{table}."{name}"]\nnoise = {noisy.noise:.4g}')
    for name in tuned.undetermined:
        say(f"the samples do not determine the noise of {name}: half or twice of it is about as likely")
    for name, nis in tuned.ahead_nis.items():
        verdict = verdict_of(nis, tuned.predictions[name], tuned.correlation[name], tuned.mean_nis[name])
        say(f"{name}, predicted over {AHEAD} samples: {verdict}")


def verdict_of(ahead_nis: float, predictions: int, correlation: float, mean_nis: float) -> str:
    """Whether the model of a sensor holds: its predictions and its innovations are as large as stated, and its innovations are white.

    The limits of ahead_nis, a mean over so many predictions, are those of GOOD_AHEAD and of chance (chi-square).
    """
    from scipy.stats import chi2

    if ahead_nis != ahead_nis:
        return "too few samples to say whether the model holds"
    white = f"innovations correlated by {correlation:.2f} and with a mean NIS of {mean_nis:.2f}"
    by_chance = chi2.ppf((BY_CHANCE, 1 - BY_CHANCE), predictions) / predictions
    smallest, largest = np.multiply(GOOD_AHEAD, by_chance)
    sized = GOOD_NIS[0] < mean_nis < GOOD_NIS[1] and smallest < ahead_nis < largest
    wrong = abs(correlation) > CORRELATED or not sized
    return f"mean NIS {ahead_nis:.2f}, {white}: {'the model is wrong, not only its noise' if wrong else 'the model holds'}"


# --------------------------------------------------------------------------------------------- what there is


def describe_plant(file: Path, prove: bool) -> None:
    """Prints the variables of a plant and a first plan."""
    plant = plant_of_file(file)
    if isinstance(plant, Plant):
        print_functions(plant, file.name)
    else:
        print_model(read_model_description(plant), prove)


def remark(line: str) -> None:
    """Prints a line beside the first plan as a comment of TOML, so that the whole output is a plan."""
    say(f"# {line}")


def print_functions(plant: Plant, name: str) -> None:
    """Prints the functions of a plant in Python and a first plan."""
    plan = Plan(plant)
    for sensor in plant.sensors:
        plan.sensor(sensor, noise=0.01)
    for state, start in plant.states.items():
        plan.state(state, start_sigma=0.1 * (abs(start) or 1.0), noise=0.01 * (abs(start) or 1.0))
    for input in plant.inputs:
        plan.input(input)
    remark(f"{name}: functions in Python, {len(plant.states)} state{'s' * (len(plant.states) > 1)}")
    for kind, names in (("parameters that may be estimated", plant.parameters), ("inputs", plant.inputs)):
        remark(f"{kind}: {', '.join(names) or 'none'}")
    print_plan(plan, name)


def print_model(fmu: ModelDescription, prove: bool) -> None:
    """Prints the variables of an FMU, the check of its derivatives, and a first plan."""
    print_variables(fmu)
    plan = first_plan(fmu)
    observer = Observer(plan)
    for sentence in observer.lies():
        remark(sentence)
    if prove:
        print_proof(observer, remark)
    print_plan(plan, fmu.path.name)


def print_plan(plan: Plan, fmu: str) -> None:
    remark("A plan to start with; put what you know of your sensors, of the start and of what disturbs the states:")
    for line in ("", *text_of(plan, fmu)):
        say(line)


def print_variables(fmu: ModelDescription) -> None:
    """States, candidates for sensors, inputs and parameters."""
    real = [v for v in fmu.variables.values() if v.is_real]
    parameters = [v for v in real if v.causality == "parameter"]
    fixed = [v for v in parameters if v.variability == "fixed"]
    remark(f"{fmu.path.name}: {fmu.name}, FMI {fmu.fmi}, {len(fmu.states)} state{'s' * (len(fmu.states) > 1)}")
    if fmu.step_s:
        steps = "the time between samples has to be a multiple of its own step"
        remark(f"Co-Simulation only: sigma points pass through its steps; {steps}")
    remark(f"states: {listed([state for state, _ in fmu.states])}")
    remark(f"sensors may be: {listed(candidates(fmu))}")
    remark(f"inputs: {listed([v for v in real if v.causality == 'input'])}")
    remark(f"parameters that may be estimated: {listed([v for v in parameters if v.variability == 'tunable'])}")
    if fixed:
        remark(f"fixed, to be estimated only when exported as tunable: {listed(fixed)}")


def print_proof(observer: Observer, write: Callable[[str], None] = say) -> None:
    """A line for each block of derivatives that the plant provides."""
    found = observer.proof()
    if not found:
        write("it offers no derivatives: differences are used")
    for name, block in found.items():
        verdict = "right" if block.exact else "wrong, differences are used"
        write(f"{name.replace('_', ' ')}: {verdict} (worst: stated {block.stated:.9g}, differences {block.measured:.9g})")


def candidates(fmu: ModelDescription) -> list[Variable]:
    """Outputs, then states that are not outputs."""
    outputs = [v for v in fmu.variables.values() if v.is_real and v.causality == "output"]
    return outputs + [state for state, _ in fmu.states if state not in outputs]


def listed(variables: list[Variable]) -> str:
    names = [f"{v.name} [{v.unit}]" if v.unit else v.name for v in variables[:SHOWN]]
    more = [f"and {len(variables) - SHOWN} more"] if len(variables) > SHOWN else []
    return ", ".join([*names, *more]) or "none"


def first_plan(fmu: ModelDescription) -> Plan:
    """The first candidate for a sensor, and a tenth of each state as its unknown part."""
    plan, sensor = Plan(fmu.path), candidates(fmu)[0]
    plan.sensor(sensor.name, noise=0.01 * size_of(sensor))
    for state, _ in fmu.states:
        plan.state(state.name, start_sigma=0.1 * size_of(state), noise=0.01 * size_of(state))
    for variable in fmu.variables.values():
        if variable.is_real and variable.causality == "input":
            plan.input(variable.name)
    return plan


def size_of(variable: Variable) -> float:
    return abs(variable.start) if abs(variable.start) > 0 else 1.0


def text_of(plan: Plan, fmu: str) -> list[str]:
    """A plan as TOML."""
    lines = ["[plant]", f'fmu = "{fmu}"']
    for name, sensor in plan.sensors.items():
        lines += ["", f'[sensor."{name}"]', f"noise = {sensor.noise:g}"]
    for name in plan.inputs:
        lines += ["", f'[input."{name}"]']
    for name, known in plan.states.items():
        lines += ["", f'[state."{name}"]', f"start_sigma = {known.start_sigma:g}", f"noise = {known.noise:g}"]
    return lines
