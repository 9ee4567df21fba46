"""The command line: hnav filter, score, options, bench, calibrate, simulate, report, montecarlo, certify."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from hnav import __version__
from hnav.errors import HnavError
from hnav.filters.calibration import MagnetometerCalibration, calibrate_magnetometer, read_calibration, write_calibration
from hnav.fmi.engines import ENGINES, Result, run_recording
from hnav.io.recordings import TESLA_PER, RecordingError, find_trials, read_recording
from hnav.native.library import option_table, parse_setting, version
from hnav.reports.scores import Score, nees, score
from studies.bench import (
    DEFAULT_FILTERS,
    DEFAULT_PEERS,
    LAST_UNDISTURBED_TRIAL,
    Contender,
    Line,
    Row,
    benchmark,
    contenders,
    summary,
)
from studies.bench import write_csv as write_rows
from studies.peers import PEERS, run_peer
from studies.stress import SETS, variant_count

app = typer.Typer(add_completion=False, no_args_is_help=True, pretty_exceptions_enable=False, help="Hybrid navigation filters.")
console = Console()
progress_console = Console(stderr=True)

FilterName = Annotated[str, typer.Option("--filter", help="ahrs (real sensors) or hrekf (the paper's)")]
Engine = Annotated[str, typer.Option(help=", ".join(ENGINES))]
Settings = Annotated[
    list[str] | None, typer.Option("--set", metavar="NAME=VALUE", help="An option of the filter; see hnav options")
]
MagUnit = Annotated[str, typer.Option(help="Unit of the field in a CSV: T, uT, G or au (arbitrary)")]
Preset = Annotated[str, typer.Option(help="default or paper")]

CSV_HEADER = (
    "t_s,q0,q1,q2,q3,roll_deg,pitch_deg,yaw_deg,bias_x_deg_s,bias_y_deg_s,bias_z_deg_s,"
    "sigma_x_deg,sigma_y_deg,sigma_z_deg,sigma_bias_x_deg_s,sigma_bias_y_deg_s,sigma_bias_z_deg_s"
)


class UsageError(Exception):
    """What the user typed cannot be done; the text says why."""


def parse_settings(pairs: list[str] | None) -> dict[str, str]:
    return dict(parse_setting(pair) for pair in pairs or [])


def bar() -> Progress:
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    return Progress(*columns, console=progress_console, transient=True)


@app.command("filter")
def filter_command(
    recording: Annotated[
        Path, typer.Argument(help="BROAD trial (.hdf5, .mat) or CSV with the columns t_s,gx,gy,gz,ax,ay,az,mx,my,mz")
    ],
    out: Annotated[Path, typer.Option(help="CSV to write, one row for each IMU sample")],
    filter: FilterName = "ahrs",
    engine: Engine = "c",
    set: Settings = None,
    preset: Preset = "default",
    step: Annotated[
        float | None, typer.Option(metavar="SECONDS", help="Communication step of an FMU; default: from sample to sample")
    ] = None,
    frame: Annotated[str, typer.Option(help="Navigation frame: ned or enu")] = "ned",
    mag_unit: MagUnit = "T",
    smooth: Annotated[
        bool, typer.Option("--smooth", help="With hindsight: every row from all samples, before and after it (ahrs, engine c)")
    ] = False,
    calibration: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Correct the field first: a file by hnav calibrate")
    ] = None,
):
    """Runs a filter over a recording and writes attitude, bias and sigmas."""
    settings = {"navigation_frame": frame} | parse_settings(set)
    data = read_recording(recording, mag_unit)
    if calibration is not None:
        data = read_calibration(calibration).apply_to(data)
    with bar() as progress:
        task = progress.add_task(data.name, total=len(data.t_s))
        result = run_recording(
            data,
            filter,
            engine,
            settings,
            preset,
            step,
            lambda done, total: progress.update(task, completed=done, total=total),
            smooth,
        )
    write_csv(out, result)
    counts = ", ".join(f"{name} {n}" for name, n in result.counts.items() if n)
    console.print(
        f"{len(result.t_s)} rows to {out}; {result.us_per_sample:.2f} us/sample by {engine}; {counts}",
        highlight=False,
        soft_wrap=True,
    )


def write_csv(path: Path, result: Result) -> None:
    table = np.column_stack([
        result.t_s, result.q_nb, np.degrees(result.euler_rad), np.degrees(result.gyro_bias_rad_s),
        np.degrees(result.sigma_rad), np.degrees(result.gyro_bias_sigma_rad_s),
    ])  # fmt: skip
    try:
        np.savetxt(path, table, fmt="%.9g", delimiter=",", header=CSV_HEADER, comments="")
    except OSError as error:
        raise UsageError(f"{path}: cannot be written: {error.strerror}") from None


@app.command("score")
def score_command(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder with BROAD trials")],
    filter: FilterName = "ahrs",
    engine: Engine = "c",
    set: Settings = None,
    preset: Preset = "default",
    crop: Annotated[float | None, typer.Option(metavar="SECONDS", help="Score the first seconds only")] = None,
    smooth: Annotated[bool, typer.Option("--smooth", help="With hindsight (ahrs, engine c), beside offlineVQF")] = False,
    json_file: Annotated[Path | None, typer.Option("--json", metavar="FILE", help="Also write the figures there")] = None,
):
    """Scores a filter on all BROAD trials of a folder, beside VQF when the package vqf is installed."""
    settings = parse_settings(set) | {"navigation_frame": "enu"}
    trials = find_trials(folder)
    ours: dict[int, Score] = {}
    theirs: dict[int, Score] = {}
    consistency: dict[int, float] = {}
    names, us_ours, us_theirs = {}, [], []
    peer = "offlinevqf" if smooth else "vqf"
    vqf = PEERS[peer].installed()
    with bar() as progress:
        task = progress.add_task("trials", total=len(trials))
        for number, path in trials.items():
            data = read_recording(path)
            if crop is not None:
                data = data.cropped(crop)
            names[number] = data.name
            result = run_recording(data, filter, engine, settings, preset, smooth=smooth)
            ours[number] = score(result.q_nb, data.reference_q_nb, data.movement)
            consistency[number] = nees(result.q_nb, result.sigma_rad, data.reference_q_nb, data.movement).nees_per_axis
            us_ours.append(result.us_per_sample)
            if vqf:
                q, us = run_peer(peer, data)
                theirs[number] = score(q, data.reference_q_nb, data.movement)
                us_theirs.append(us)
            progress.advance(task)
    print_scores(names, ours, theirs, consistency, f"{filter} ({engine})")
    console.print(
        f"median time per sample: {filter} {np.median(us_ours):.2f} us" + (f", VQF {np.median(us_theirs):.2f} us" if vqf else "")
    )
    if not vqf:
        console.print("VQF is not beside it: the package vqf is not installed (pip install vqf)")
    if json_file:
        figures = {
            "filter": filter,
            "engine": engine,
            "settings": settings,
            "preset": preset,
            "us_per_sample": float(np.median(us_ours)),
        }
        figures["trials"] = {str(n): {"name": names[n], **ours[n]._asdict(), "nees_per_axis": consistency[n]} for n in trials}
        figures["mean"] = mean(ours)._asdict()
        if vqf:
            figures["vqf_mean"] = mean(theirs)._asdict()
        try:
            json_file.write_text(json.dumps(figures, indent=1) + "\n")
        except OSError as error:
            raise UsageError(f"{json_file}: cannot be written: {error.strerror}") from None


def mean(scores: dict[int, Score], keep=lambda number: True) -> Score:
    kept = [s for number, s in scores.items() if keep(number)]
    return Score(*np.mean(kept, axis=0).tolist()) if kept else Score(np.nan, np.nan, np.nan)


def print_scores(
    names: dict[int, str], ours: dict[int, Score], theirs: dict[int, Score], consistency: dict[int, float], title: str
) -> None:
    """Per trial and mean; RMSE in deg as total / heading / inclination. NEES/3 is from the sigmas, without correlations."""
    table = Table("trial", f"{title}: total", "heading", "inclination", "NEES/3", title="RMSE in deg over the movement phase")
    if theirs:
        for column in ("VQF: total", "heading", "inclination"):
            table.add_column(column)

    def cells(s: Score | tuple[float]) -> list[str]:
        return ["-" if np.isnan(v) else f"{v:.2f}" for v in s]

    for number in names:
        table.add_row(
            names[number], *cells(ours[number]), *cells((consistency[number],)), *(cells(theirs[number]) if theirs else [])
        )
    table.add_section()
    groups = {
        "mean": lambda n: True,
        "undisturbed": lambda n: n <= LAST_UNDISTURBED_TRIAL,
        "disturbed": lambda n: n > LAST_UNDISTURBED_TRIAL,
    }
    for name, keep in groups.items():
        stated = [v for number, v in consistency.items() if keep(number)]
        middle = cells((np.mean(stated) if stated else np.nan,))
        table.add_row(name, *cells(mean(ours, keep)), *middle, *(cells(mean(theirs, keep)) if theirs else []))
    (console if console.is_terminal else Console(width=140)).print(table)


@app.command("options")
def options_command(filter: FilterName = "ahrs"):
    """Prints the options of a filter with unit, default, range and meaning."""
    from hnav.native.library import Options

    defaults = Options(filter)
    table = Table("option", "default", "unit", "range or choices", "meaning")
    for info in option_table(filter).values():
        value = getattr(defaults, info.name)
        shown = value if info.choices else ",".join(f"{v:g}" for v in np.ravel(value))
        allowed = ", ".join(info.choices) or f"{info.min:g} to {info.max:g}"
        table.add_row(info.name, shown, info.unit, allowed, info.description)
    (console if console.is_terminal else Console(width=200)).print(table)


@app.command("bench")
def bench_command(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder with BROAD trials")],
    filters: Annotated[
        str, typer.Option(help="Filters of hnav: NAME, NAME-smooth, NAME:option=value; separated by commas")
    ] = ",".join(DEFAULT_FILTERS),
    peers: Annotated[str, typer.Option(help=f"Filters by others: {', '.join(PEERS)}; all, or none")] = ",".join(DEFAULT_PEERS),
    sets: Annotated[str, typer.Option(help="The trials as they are, and made harder: python -m pydoc studies.stress")] = ",".join(
        SETS
    ),
    csv_file: Annotated[
        Path | None, typer.Option("--csv", metavar="FILE", help="Write a row for each set, filter and trial")
    ] = None,
    picture: Annotated[Path | None, typer.Option(metavar="FILE", help="Draw error and time of the set BROAD")] = None,
    repeat: Annotated[int, typer.Option(min=1, help="Runs for the time per sample")] = 1,
):
    """Compares filters, ours and others', on all BROAD trials of a folder, as they are and made harder."""
    names = split(sets)
    if not names:
        raise UsageError(f"--sets names none: choose from {', '.join(SETS)}")
    for name in names:
        if name not in SETS:
            raise UsageError(f"set {name}: choose from {', '.join(SETS)}")
    if picture and "BROAD" not in names:
        raise UsageError("--picture shows the set BROAD: name it in --sets")
    entered, missing = contenders(split(filters), list(PEERS) if peers == "all" else [] if peers == "none" else split(peers))
    if not entered:
        raise UsageError("no filter to run: name some in --filters or --peers")
    recordings = [read_recording(path) for path in find_trials(folder).values()]
    rows: list[Row] = []
    with bar() as progress:
        task = progress.add_task("trials", total=sum(variant_count(name, len(recordings)) for name in names))
        for done in benchmark(recordings, entered, names, repeat):
            rows += done
            progress.update(task, advance=1, description=f"{done[0].set:7}")
    print_benchmark(summary(rows), {contender.name for contender in entered if contender.ours})
    for text in missing:
        console.print(text, highlight=False, soft_wrap=True)
    for row in rows:
        if row.failure:
            console.print(
                f"failed: {row.set}, {row.filter}, {row.trial}: {row.failure}", highlight=False, soft_wrap=True, markup=False
            )
        elif row.missing:
            console.print(
                f"{row.set}, {row.filter}, {row.trial}: {row.missing} scored samples without an estimate",
                highlight=False,
                soft_wrap=True,
            )
    write_benchmark(rows, entered, csv_file, picture)


def split(names: str) -> list[str]:
    return [name.strip() for name in names.split(",") if name.strip()]


def print_benchmark(lines: list[Line], ours: set[str]) -> None:
    """A section for each set; the best of each column in bold, ours in colour."""
    table = Table(title="RMSE in deg over the scored phase, plain mean over trials; time per IMU sample, median")
    for column in (
        "set",
        "filter",
        "total",
        "heading",
        "inclination",
        "undisturbed",
        "disturbed",
        "NEES/3",
        "us/sample",
        "trials",
    ):
        table.add_column(column, justify="left" if column in ("set", "filter") else "right", no_wrap=True)
    errors = ("total_deg", "heading_deg", "inclination_deg", "undisturbed_deg", "disturbed_deg")
    for set_name in dict.fromkeys(line.set for line in lines):
        group = [line for line in lines if line.set == set_name]
        best = {
            name: min((getattr(line, name) for line in group if not np.isnan(getattr(line, name))), default=np.nan)
            for name in (*errors, "us_per_sample")
        }

        def cell(line: Line, name: str, best: dict[str, float] = best) -> str:
            value = getattr(line, name)
            text = "-" if np.isnan(value) else f"{value:.2f}"
            return f"[bold]{text}[/bold]" if value == best.get(name) else text

        for i, line in enumerate(group):
            trials = f"{line.trials}" + (f", {line.failures} failed" if line.failures else "")
            cells = [cell(line, name) for name in (*errors, "nees_per_axis", "us_per_sample")]
            table.add_row(set_name if i == 0 else "", line.filter, *cells, trials, style="cyan" if line.filter in ours else None)
        table.add_section()
    (console if console.is_terminal else Console(width=140)).print(table)


def write_benchmark(rows: list[Row], entered: list[Contender], csv_file: Path | None, picture: Path | None) -> None:
    for path, write in (
        (csv_file, lambda path: write_rows(path, rows)),
        (picture, lambda path: draw_picture(path, rows, entered)),
    ):
        if path:
            try:
                write(path)
            except OSError as error:
                raise UsageError(f"{path}: cannot be written: {error.strerror}") from None
            console.print(f"{path}", highlight=False, soft_wrap=True)


def draw_picture(path: Path, rows: list[Row], entered: list[Contender]) -> None:
    from hnav.reports.plots import save
    from studies.bench_picture import draw_benchmark

    lines = [line for line in summary(rows) if line.set == "BROAD" and line.trials]
    if not lines:
        raise UsageError("--picture: no filter finished a trial")
    save(draw_benchmark(lines, entered), path)


@app.command("calibrate")
def calibrate_command(
    recording: Annotated[
        Path, typer.Argument(help="Recording of the sensor being turned about all axes, in the formats of hnav filter")
    ],
    out: Annotated[
        Path | None, typer.Option(metavar="FILE.json", help="Write the calibration there, for hnav filter --calibration")
    ] = None,
    picture: Annotated[Path | None, typer.Option(metavar="FILE.png", help="Draw the field before and after")] = None,
    allow_hard_iron_only: Annotated[
        bool, typer.Option("--allow-hard-iron-only", help="Where the motion is too poor, answer with the offset alone")
    ] = False,
    mag_unit: MagUnit = "T",
):
    """Calibrates a magnetometer: hard iron, soft iron, scale and misalignment, by an ellipsoid and gravity."""
    data = read_recording(recording, mag_unit)
    if data.field_b_tesla is None:
        raise UsageError(f"{recording}: has no magnetometer")
    unit = mag_unit if recording.suffix == ".csv" else "uT"  # the unit in the file is the one to answer in
    field = data.field_b_tesla / TESLA_PER[unit]
    try:
        found = calibrate_magnetometer(field, data.force_b_m_s2, unit, allow_hard_iron_only=allow_hard_iron_only)
    except HnavError as error:
        if error.status != "ill-conditioned":
            raise
        hint = "" if allow_hard_iron_only else "; --allow-hard-iron-only answers with the offset alone where that is determined"
        raise UsageError(f"{recording}: {error}{hint}") from None
    if out is not None:
        write_calibration(out, found)
    if picture is not None:
        from hnav.reports.calibration_picture import draw_calibration
        from hnav.reports.plots import save

        try:
            save(draw_calibration(field, found, data.name), picture)
        except (OSError, ValueError) as error:  # ValueError: an ending that is no picture format
            raise UsageError(f"{picture}: cannot be written: {getattr(error, 'strerror', None) or error}") from None
    print_calibration(found, data.name)


def print_calibration(found: MagnetometerCalibration, name: str) -> None:
    unit = "" if found.unit == "au" else f" {found.unit}"

    def change(before: float, after: float, unit: str) -> str:
        return "-" if np.isnan(before) else f"{before:.2f} -> {after:.2f} {unit}"

    table = Table("", "value", "meaning", title=f"{name}: {found.fit}", show_header=False)
    rows = [
        ("offset", ", ".join(f"{v:.5g}" for v in found.offset) + unit, "hard iron"),
        ("matrix", "\n".join("  ".join(f"{v: .5f}" for v in row) for row in found.matrix), "corrected = matrix (field - offset)"),
        ("strength", f"{found.strength:.5g}{unit}", "of the corrected field"),
        ("dip", "-" if np.isnan(found.dip_rad) else f"{np.degrees(found.dip_rad):.2f} deg", "below the horizon"),
        ("residual", change(100 * found.residual_before, 100 * found.residual_after, "%"), "scatter of the length, outliers left out"),
        ("dip spread", change(np.degrees(found.dip_spread_before_rad), np.degrees(found.dip_spread_after_rad), "deg"), "robust standard deviation"),
        ("uncertainty", "-" if np.isnan(found.direction_sigma_rad) else f"{np.degrees(found.direction_sigma_rad):.2f} deg", "of the corrected direction, over the whole sphere"),
        ("outliers", f"{100 * found.outlier_fraction:.1f} %", f"of {found.used_samples} attitudes in {found.samples} samples; {found.force_samples} with gravity"),
        ("coverage", f"{found.coverage:.2f}", "1: all directions alike, 0: in a plane"),
        ("condition", f"{found.condition:.0f}, ambiguity {found.ambiguity:.3f}", "full fit up to 1000 and 0.1"),
        ("axis ratio", f"{found.axis_ratio:.3f}" if found.fit != "hard iron only" else "-", "longest over shortest axis of the ellipsoid"),
    ]  # fmt: skip
    for row in rows:
        table.add_row(*row)
    (console if console.is_terminal else Console(width=140)).print(table)
    if found.note:
        axes = "" if found.offset_axes == 3 else ", in the plane of the field alone"
        console.print(f"hard iron only{axes}: {found.note}", highlight=False, soft_wrap=True)


@app.command("simulate")
def simulate_command(
    system: Annotated[str, typer.Argument(help="Name of a built system, an .ssp file, or a folder with SystemStructure.ssd")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for signals.h5 and run.json")] = Path("simulation_out"),
    scenario: Annotated[str | None, typer.Option(help="A scenario of the system")] = None,
    grade: Annotated[str | None, typer.Option(help="A sensor grade of the system")] = None,
    set: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="COMPONENT.PARAMETER=VALUE", help="A parameter, after grade and scenario"),
    ] = None,
    seed: Annotated[int | None, typer.Option(help="Seed of every component that has one")] = None,
    step: Annotated[float | None, typer.Option(metavar="SECONDS", help="Communication step; default: the system's")] = None,
    stop: Annotated[float | None, typer.Option(metavar="SECONDS", help="End of the run; default: the system's")] = None,
):
    """Runs a system of FMUs in closed co-simulation."""
    from hnav.systems.simulation import simulate, write_run

    with bar() as progress:
        task = progress.add_task(system, total=None)
        run = simulate(system, scenario, grade, set or [], seed, step, stop,
                       progress=lambda done, total: progress.update(task, completed=done, total=total))  # fmt: skip
    write_run(run, out)
    wall = ", ".join(f"{name} {1e6 * seconds / max(1, len(run.t_s) - 1):.1f}" for name, seconds in run.about["wall_s"].items())
    text = f"{len(run.t_s)} points to {run.t_s[-1]:g} s, step {run.about['step_s']:g} s, {len(run.columns)} signals to {out}; us/step: {wall}"
    console.print(text, highlight=False, soft_wrap=True)
    for name, lost in run.about["lost"].items():
        if lost:
            console.print(
                f"{name} lost {lost} samples between the communication points: take a finer --step",
                highlight=False,
                soft_wrap=True,
            )
    if run.about["failure"]:
        raise UsageError(f"{run.about['failure']}; the samples until then are in {out}")


@app.command("report")
def report_command(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder that hnav simulate wrote")],
    out: Annotated[Path | None, typer.Option(metavar="FILE", help="HTML to write; default: DIR/report.html")] = None,
    pictures: Annotated[Path | None, typer.Option(metavar="DIR", help="Also draw the main panels as PNG there")] = None,
    open: Annotated[bool, typer.Option("--open", help="Show it in the browser")] = False,
):
    """One self-contained HTML page about a simulation."""
    from hnav.reports.page import write_report
    from hnav.systems.simulation import read_run

    run, file = read_run(folder), out or folder / "report.html"
    panels = write_report(run, file)
    console.print(f"{file} ({file.stat().st_size / 1e6:.1f} MB): {', '.join(panels)}", highlight=False, soft_wrap=True)
    if pictures is not None:
        from hnav.reports.pictures import write_pictures

        for picture in write_pictures(run, pictures):
            console.print(str(picture), highlight=False, soft_wrap=True)
    if open:
        typer.launch(str(file))


@app.command("montecarlo")
def montecarlo_command(
    system: Annotated[str, typer.Argument(help="Name of a built system, an .ssp file, or a folder with SystemStructure.ssd")],
    out: Annotated[Path, typer.Option(metavar="FILE", help="Parquet, a row for each filter and run")],
    runs: Annotated[int, typer.Option(help="Runs of each scenario")] = 200,
    scenarios: Annotated[str | None, typer.Option(metavar="A,B,...", help="Scenarios; default: the system as it is")] = None,
    grade: Annotated[str | None, typer.Option(help="A sensor grade of the system")] = None,
    set: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="COMPONENT.PARAMETER=VALUE", help="A parameter, after grade and scenario"),
    ] = None,
    first_seed: Annotated[int, typer.Option(help="Seed of the first run; the others follow")] = 1,
    step: Annotated[float | None, typer.Option(metavar="SECONDS", help="Communication step; default: the system's")] = None,
    stop: Annotated[float | None, typer.Option(metavar="SECONDS", help="End of each run; default: the system's")] = None,
    workers: Annotated[int, typer.Option(help="Processes on this machine")] = 1,
    scheduler: Annotated[str | None, typer.Option(metavar="ADDRESS", help="A Dask scheduler instead")] = None,
):
    """Many runs of a system, and their table with 95 % confidence intervals."""
    from hnav.systems.montecarlo import jobs, run_jobs, write_table
    from hnav.systems.structure import read_system, system_path

    named = scenarios.split(",") if scenarios else [None]
    # What is wrong with all runs is said at once, not once for each.
    for scenario in named:
        with read_system(system_path(system)) as read:
            read.choose(grade, scenario)
            read.seed(first_seed)
    work = jobs(system, named, runs, first_seed, grade=grade, settings=tuple(set or ()), step_s=step, stop_s=stop)
    with bar() as progress:
        task = progress.add_task(system, total=len(work))
        table = run_jobs(work, workers, scheduler, lambda done, total: progress.update(task, completed=done))
    write_table(table, out)
    print_montecarlo(table)
    failed = table[table["failure"] != ""]
    for row in failed.itertuples():
        console.print(f"failed: {row.scenario}, seed {row.seed}: {row.failure}", highlight=False, soft_wrap=True)
    console.print(f"{len(work) - len(failed)} of {len(work)} runs to {out}", highlight=False, soft_wrap=True)
    if len(failed) == len(work):
        raise UsageError(f"no run came to its end; the first said: {failed.iloc[0]['failure']}")


def print_montecarlo(runs) -> None:
    """A line for each scenario and filter: means over the runs with their intervals, NEES at times beside its bounds.

    first / this: mean squared error about down of the scenario's first filter over that of this one, above 1 a win.
    """
    from hnav.systems.montecarlo import mean_interval, nees_bounds, ratio_interval

    good = runs[runs["failure"] == ""]
    if good.empty:
        return
    times = [name for name in good.columns if name.startswith("nees_") and good[name].notna().any()]
    heads = ["scenario", "filter", "runs", "MSE / deg2", "MSE down / deg2", "first / this", "mean NEES"]
    table = Table(
        *heads, *(f"at {name[5:-1]} s" for name in times), "99.9 %", "ready / s", title="means over the runs [95 % interval]"
    )
    for scenario, of_scenario in good.groupby("scenario", sort=False):
        first = None
        for name, rows in of_scenario.groupby("filter", sort=False):
            first = rows if first is None else first
            paired = first.merge(rows, on="seed", suffixes=("_first", ""))
            ratio = ratio_interval(paired["mse_down_deg2_first"], paired["mse_down_deg2"])
            low, high = nees_bounds(len(rows))
            ready = rows["heading_ready_s"].dropna()
            table.add_row(
                str(scenario), str(name), str(len(rows)), _interval(mean_interval(rows["mse_deg2"])), _interval(mean_interval(rows["mse_down_deg2"])),
                "1" if rows is first else _interval(ratio), _interval(mean_interval(rows["nees"])), *(f"{rows[t].mean():.3g}" for t in times),
                f"{low:.2f} to {high:.2f}", f"{ready.median():.3g} ({len(ready)})" if len(ready) else "never",
            )  # fmt: skip
    (console if console.is_terminal else Console(width=200)).print(table)


def _interval(found: tuple[float, float, float]) -> str:
    return "{:.3g} [{:.3g}, {:.3g}]".format(*found)


@app.command("certify")
def certify_command(
    recording: Annotated[
        Path | None,
        typer.Argument(
            metavar="[RECORDING]", help="Recording in the formats of hnav filter, or a folder of results with signals.h5"
        ),
    ] = None,
    experiment: Annotated[str | None, typer.Option(help="turntable: the paper's experiment instead of a recording")] = None,
    filter: FilterName = "hrekf",
    set: Settings = None,
    preset: Annotated[
        str | None, typer.Option(help="default or paper; without it a folder is certified with the filter that was simulated")
    ] = None,
    begin: Annotated[
        float, typer.Option("--from", metavar="SECONDS", help="Leave out the corrections before, while the gains settle")
    ] = 15.0,
    duration: Annotated[
        float | None, typer.Option(metavar="SECONDS", help="Use the first seconds only; the experiment lasts 40 s")
    ] = None,
    seed: Annotated[int, typer.Option(help="Of the experiment and of the starts on the boundary")] = 5,
    gain_factor: Annotated[
        float, typer.Option(help="Certify the gains multiplied by this: a wrong sequence must be refused")
    ] = 1.0,
    out: Annotated[Path | None, typer.Option(metavar="FILE.json", help="Write the figures there")] = None,
    picture: Annotated[Path | None, typer.Option(metavar="FILE.png", help="Draw Lyapunov value and decay")] = None,
    mag_unit: MagUnit = "T",
):
    """Certifies the stability of a run: decay, region of attraction, noise floor, dwell; or says why it cannot."""
    from hnav.certify.run import certify_run, print_certificate, write_certificate

    if (recording is None) == (experiment is None):
        raise UsageError("name a recording or --experiment turntable, one of them")
    with bar() as progress:
        tasks: dict[str, int] = {}

        def show(what: str, done: int, of: int) -> None:
            task = tasks.setdefault(what, len(tasks))
            if task == len(progress.tasks):
                progress.add_task(what, total=of)
            progress.update(progress.task_ids[task], completed=done)

        found = certify_run(
            recording, experiment, filter, preset, parse_settings(set), begin, duration, seed, gain_factor, mag_unit, show
        )
    try:
        if out is not None:
            write_certificate(out, found)
        if picture is not None:
            from hnav.certify.picture import draw_certificate
            from hnav.reports.plots import save

            save(draw_certificate(found), picture)
    except (OSError, ValueError) as error:  # ValueError: an ending that is no picture format
        path = getattr(error, "filename", None) or picture
        raise UsageError(f"{path}: cannot be written: {getattr(error, 'strerror', None) or error}") from None
    print_certificate(found, console if console.is_terminal else Console(width=140))


def show_version(wanted: bool) -> None:
    if wanted:
        console.print(f"hnav {__version__}, library {version()}", highlight=False)
        raise typer.Exit()


@app.callback()
def root(
    version: Annotated[bool, typer.Option("--version", callback=show_version, is_eager=True, help="Show the version")] = False,
):
    pass


def main() -> None:
    """One line on stderr and exit code 2 for everything that the user can mend."""
    try:
        app()
    except (UsageError, HnavError, RecordingError) as error:
        print(f"hnav: {error}", file=sys.stderr)
        sys.exit(2)


if __name__ == "__main__":
    main()
