"""The command line: hnav filter, hnav score, hnav options, hnav calibrate."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Annotated, Optional

import numpy as np
import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from hnav import __version__
from hnav.calibration import MagnetometerCalibration, calibrate_magnetometer, read_calibration, write_calibration
from hnav.engines import ENGINES, Result, run_recording
from hnav.library import HnavError, option_table, parse_setting, version
from hnav.recordings import TESLA_PER, RecordingError, find_trials, read_recording
from hnav.scores import Score, score

app = typer.Typer(add_completion=False, no_args_is_help=True, pretty_exceptions_enable=False, help="Hybrid navigation filters.")
console = Console()
progress_console = Console(stderr=True)

FilterName = Annotated[str, typer.Option("--filter", help="hrekf")]
Engine = Annotated[str, typer.Option(help=", ".join(ENGINES))]
Settings = Annotated[Optional[list[str]], typer.Option("--set", metavar="NAME=VALUE", help="An option of the filter; see hnav options")]
MagUnit = Annotated[str, typer.Option(help="Unit of the field in a CSV: T, uT, G or au (arbitrary)")]
Preset = Annotated[str, typer.Option(help="default or paper")]

CSV_HEADER = (
    "t_s,q0,q1,q2,q3,roll_deg,pitch_deg,yaw_deg,bias_x_deg_s,bias_y_deg_s,bias_z_deg_s,"
    "sigma_x_deg,sigma_y_deg,sigma_z_deg,sigma_bias_x_deg_s,sigma_bias_y_deg_s,sigma_bias_z_deg_s"
)
LAST_UNDISTURBED_TRIAL = 23


class UsageError(Exception):
    """What the user typed cannot be done; the text says why."""


def parse_settings(pairs: list[str] | None) -> dict[str, str]:
    return dict(parse_setting(pair) for pair in pairs or [])


def bar() -> Progress:
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    return Progress(*columns, console=progress_console, transient=True)


@app.command("filter")
def filter_command(
    recording: Annotated[Path, typer.Argument(help="BROAD trial (.hdf5, .mat) or CSV with the columns t_s,gx,gy,gz,ax,ay,az,mx,my,mz")],
    out: Annotated[Path, typer.Option(help="CSV to write, one row for each IMU sample")],
    filter: FilterName = "hrekf",
    engine: Engine = "c",
    set: Settings = None,
    preset: Preset = "default",
    step: Annotated[Optional[float], typer.Option(metavar="SECONDS", help="Communication step of an FMU; default: from sample to sample")] = None,
    frame: Annotated[str, typer.Option(help="Navigation frame: ned or enu")] = "ned",
    mag_unit: MagUnit = "T",
    calibration: Annotated[Optional[Path], typer.Option(metavar="FILE", help="Correct the field first: a file by hnav calibrate")] = None,
):
    """Runs a filter over a recording and writes attitude, bias and sigmas."""
    settings = {"navigation_frame": frame} | parse_settings(set)
    data = read_recording(recording, mag_unit)
    if calibration is not None:
        data = read_calibration(calibration).apply_to(data)
    with bar() as progress:
        task = progress.add_task(data.name, total=len(data.t_s))
        result = run_recording(
            data, filter, engine, settings, preset, step, lambda done, total: progress.update(task, completed=done, total=total)
        )
    write_csv(out, result)
    counts = ", ".join(f"{name} {n}" for name, n in result.counts.items() if n)
    console.print(f"{len(result.t_s)} rows to {out}; {result.us_per_sample:.2f} us/sample by {engine}; {counts}", highlight=False, soft_wrap=True)


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
    filter: FilterName = "hrekf",
    engine: Engine = "c",
    set: Settings = None,
    preset: Preset = "default",
    crop: Annotated[Optional[float], typer.Option(metavar="SECONDS", help="Score the first seconds only")] = None,
    json_file: Annotated[Optional[Path], typer.Option("--json", metavar="FILE", help="Also write the figures there")] = None,
):
    """Scores a filter on all BROAD trials of a folder, beside VQF when the package vqf is installed."""
    settings = parse_settings(set) | {"navigation_frame": "enu"}
    trials = find_trials(folder)
    ours: dict[int, Score] = {}
    theirs: dict[int, Score] = {}
    names, us_ours, us_theirs = {}, [], []
    vqf = vqf_runner()
    with bar() as progress:
        task = progress.add_task("trials", total=len(trials))
        for number, path in trials.items():
            data = read_recording(path)
            if crop is not None:
                data = data.cropped(crop)
            names[number] = data.name
            result = run_recording(data, filter, engine, settings, preset)
            ours[number] = score(result.q_nb, data.reference_q_nb, data.movement)
            us_ours.append(result.us_per_sample)
            if vqf:
                q, us = vqf(data)
                theirs[number] = score(q, data.reference_q_nb, data.movement)
                us_theirs.append(us)
            progress.advance(task)
    print_scores(names, ours, theirs, f"{filter} ({engine})")
    console.print(f"median time per sample: {filter} {np.median(us_ours):.2f} us" + (f", VQF {np.median(us_theirs):.2f} us" if vqf else ""))
    if not vqf:
        console.print("VQF is not beside it: the package vqf is not installed (pip install vqf)")
    if json_file:
        figures = {"filter": filter, "engine": engine, "settings": settings, "preset": preset, "us_per_sample": float(np.median(us_ours))}
        figures["trials"] = {str(n): {"name": names[n], **ours[n]._asdict()} for n in trials}
        figures["mean"] = mean(ours)._asdict()
        if vqf:
            figures["vqf_mean"] = mean(theirs)._asdict()
        try:
            json_file.write_text(json.dumps(figures, indent=1) + "\n")
        except OSError as error:
            raise UsageError(f"{json_file}: cannot be written: {error.strerror}") from None


def vqf_runner():
    """A function recording -> (q_nb in east-north-up, us per sample), or None when vqf is not installed."""
    try:
        from vqf import VQF
    except ImportError:
        return None

    def run(data):
        rate_hz = 1 / np.median(np.diff(data.t_s))
        arrays = (np.ascontiguousarray(a) for a in (data.rate_b_rad_s, data.force_b_m_s2, data.field_b_tesla))
        begin = time.perf_counter()
        q = VQF(1 / rate_hz).updateBatch(*arrays)["quat9D"]
        return q, 1e6 * (time.perf_counter() - begin) / len(data.t_s)

    return run


def mean(scores: dict[int, Score], keep=lambda number: True) -> Score:
    kept = [s for number, s in scores.items() if keep(number)]
    return Score(*np.mean(kept, axis=0).tolist()) if kept else Score(np.nan, np.nan, np.nan)


def print_scores(names: dict[int, str], ours: dict[int, Score], theirs: dict[int, Score], title: str) -> None:
    """Per trial and mean; RMSE in deg as total / heading / inclination."""
    table = Table("trial", f"{title}: total", "heading", "inclination", title="RMSE in deg over the movement phase")
    if theirs:
        for column in ("VQF: total", "heading", "inclination"):
            table.add_column(column)

    def cells(s: Score) -> list[str]:
        return ["-" if np.isnan(v) else f"{v:.2f}" for v in s]

    for number in names:
        table.add_row(names[number], *cells(ours[number]), *(cells(theirs[number]) if theirs else []))
    table.add_section()
    groups = {"mean": lambda n: True, "undisturbed": lambda n: n <= LAST_UNDISTURBED_TRIAL, "disturbed": lambda n: n > LAST_UNDISTURBED_TRIAL}
    for name, keep in groups.items():
        table.add_row(name, *cells(mean(ours, keep)), *(cells(mean(theirs, keep)) if theirs else []))
    (console if console.is_terminal else Console(width=140)).print(table)


@app.command("options")
def options_command():
    """Prints the options of the filter with unit, default, range and meaning."""
    from hnav.library import Options

    defaults = Options()
    table = Table("option", "default", "unit", "range or choices", "meaning")
    for info in option_table().values():
        value = getattr(defaults, info.name)
        shown = value if info.choices else ",".join(f"{v:g}" for v in np.ravel(value))
        allowed = ", ".join(info.choices) or f"{info.min:g} to {info.max:g}"
        table.add_row(info.name, shown, info.unit, allowed, info.description)
    (console if console.is_terminal else Console(width=200)).print(table)


@app.command("calibrate")
def calibrate_command(
    recording: Annotated[Path, typer.Argument(help="Recording of the sensor being turned about all axes, in the formats of hnav filter")],
    out: Annotated[Optional[Path], typer.Option(metavar="FILE.json", help="Write the calibration there, for hnav filter --calibration")] = None,
    picture: Annotated[Optional[Path], typer.Option(metavar="FILE.png", help="Draw the field before and after")] = None,
    allow_hard_iron_only: Annotated[bool, typer.Option("--allow-hard-iron-only", help="Where the motion is too poor, answer with the offset alone")] = False,
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
        from hnav.calibration_picture import draw_calibration
        from hnav.plots import save

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


def show_version(wanted: bool) -> None:
    if wanted:
        console.print(f"hnav {__version__}, library {version()}", highlight=False)
        raise typer.Exit()


@app.callback()
def root(version: Annotated[bool, typer.Option("--version", callback=show_version, is_eager=True, help="Show the version")] = False):
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
