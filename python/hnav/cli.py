"""The command line: hnav filter, hnav score, hnav options."""

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
from hnav.engines import ENGINES, Result, run_recording
from hnav.library import HnavError, option_table, parse_setting, version
from hnav.recordings import RecordingError, find_trials, read_recording
from hnav.scores import Score, score

app = typer.Typer(add_completion=False, no_args_is_help=True, pretty_exceptions_enable=False, help="Hybrid navigation filters.")
console = Console()
progress_console = Console(stderr=True)

FilterName = Annotated[str, typer.Option("--filter", help="aligner (real sensors) or hrekf (the paper's)")]
Engine = Annotated[str, typer.Option(help=", ".join(ENGINES))]
Settings = Annotated[Optional[list[str]], typer.Option("--set", metavar="NAME=VALUE", help="An option of the filter; see hnav options")]
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
    filter: FilterName = "aligner",
    engine: Engine = "c",
    set: Settings = None,
    preset: Preset = "default",
    step: Annotated[Optional[float], typer.Option(metavar="SECONDS", help="Communication step of an FMU; default: from sample to sample")] = None,
    frame: Annotated[str, typer.Option(help="Navigation frame: ned or enu")] = "ned",
    mag_unit: Annotated[str, typer.Option(help="Unit of the field in a CSV: T, uT, G or au (arbitrary)")] = "T",
    smooth: Annotated[bool, typer.Option("--smooth", help="With hindsight: every row from all samples, before and after it (aligner, engine c)")] = False,
):
    """Runs a filter over a recording and writes attitude, bias and sigmas."""
    settings = {"navigation_frame": frame} | parse_settings(set)
    data = read_recording(recording, mag_unit)
    with bar() as progress:
        task = progress.add_task(data.name, total=len(data.t_s))
        result = run_recording(
            data, filter, engine, settings, preset, step, lambda done, total: progress.update(task, completed=done, total=total), smooth
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
    filter: FilterName = "aligner",
    engine: Engine = "c",
    set: Settings = None,
    preset: Preset = "default",
    crop: Annotated[Optional[float], typer.Option(metavar="SECONDS", help="Score the first seconds only")] = None,
    smooth: Annotated[bool, typer.Option("--smooth", help="With hindsight (aligner, engine c), beside offlineVQF")] = False,
    json_file: Annotated[Optional[Path], typer.Option("--json", metavar="FILE", help="Also write the figures there")] = None,
):
    """Scores a filter on all BROAD trials of a folder, beside VQF when the package vqf is installed."""
    settings = parse_settings(set) | {"navigation_frame": "enu"}
    trials = find_trials(folder)
    ours: dict[int, Score] = {}
    theirs: dict[int, Score] = {}
    names, us_ours, us_theirs = {}, [], []
    vqf = vqf_runner(smooth)
    with bar() as progress:
        task = progress.add_task("trials", total=len(trials))
        for number, path in trials.items():
            data = read_recording(path)
            if crop is not None:
                data = data.cropped(crop)
            names[number] = data.name
            result = run_recording(data, filter, engine, settings, preset, smooth=smooth)
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


def vqf_runner(offline: bool):
    """A function recording -> (q_nb in east-north-up, us per sample), or None when vqf is not installed."""
    try:
        from vqf import VQF, offlineVQF
    except ImportError:
        return None

    def run(data):
        rate_hz = 1 / np.median(np.diff(data.t_s))
        arrays = (np.ascontiguousarray(a) for a in (data.rate_b_rad_s, data.force_b_m_s2, data.field_b_tesla))
        begin = time.perf_counter()
        q = (offlineVQF(*arrays, 1 / rate_hz) if offline else VQF(1 / rate_hz).updateBatch(*arrays))["quat9D"]
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
def options_command(filter: FilterName = "aligner"):
    """Prints the options of a filter with unit, default, range and meaning."""
    from hnav.library import Options

    defaults = Options(filter)
    table = Table("option", "default", "unit", "range or choices", "meaning")
    for info in option_table(filter).values():
        value = getattr(defaults, info.name)
        shown = value if info.choices else ",".join(f"{v:g}" for v in np.ravel(value))
        allowed = ", ".join(info.choices) or f"{info.min:g} to {info.max:g}"
        table.add_row(info.name, shown, info.unit, allowed, info.description)
    (console if console.is_terminal else Console(width=200)).print(table)


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
