"""hnav demo: the paper's experiment in closed co-simulation, and an attitude filter's FMU over real recordings.

The experiment: FMUs of turntable, sensors and three filters, stepped by fmpy from their SSP system, and a report of the run.
The recordings: two that hold the device's own attitude (see hnav.io.device_recordings), or the user's own, with the
default preset and nothing tuned; how far filter and device are apart, what the filter says about itself, and one picture.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.table import Table

from hnav.cli.console import console, say, working
from hnav.cli.parameters import MagUnit, Settings, parse_settings
from hnav.cli.words import UsageError
from hnav.fmi.engines import ENGINES, run_recording
from hnav.io.device_recordings import PACKAGE, VERSION, find_wheel, read_x_imu, read_xsens
from hnav.io.outputs import refuse_overwriting
from hnav.io.readers import read
from hnav.io.recordings import Recording, RecordingError
from hnav.reports import plots
from hnav.reports.page import write_report
from hnav.reports.recording_picture import draw_recordings
from hnav.reports.recording_run import RecordingRun, figures
from hnav.systems.simulation import simulate, write_run

SYSTEM = "turntable"
PARTS = ("all", "experiment", "recordings")


def command(
    recording: Annotated[
        Path | None, typer.Argument(help="CSV or BROAD file; without it the experiment and two recordings of devices")
    ] = None,
    part: Annotated[str, typer.Option(help=", ".join(PARTS))] = "all",
    filter: Annotated[str, typer.Option(help="hrekf or ahrs")] = "hrekf",
    engine: Annotated[str, typer.Option(help=", ".join(ENGINES))] = "fmi3-cs",
    settings: Settings = None,
    mag_unit: MagUnit = None,
    out: Annotated[Path, typer.Option(help="Folder for report and picture")] = Path("demo_out"),
) -> None:
    if part not in PARTS:
        raise UsageError(f"--part {part}: choose one of {', '.join(PARTS)}")
    chosen = parse_settings(settings)
    if "navigation_frame" in chosen:
        raise UsageError("--set navigation_frame: the demo works in east-north-up; hnav filter has the others")
    if recording is None and part != "recordings":
        show_experiment(out)
    if recording is None and part == "experiment":
        return
    file = out / "demo.png"
    refuse_overwriting([file], [recording])
    runs = [own_run(recording, mag_unit, filter, engine, chosen)] if recording else device_runs(filter, engine, chosen)
    console.print()
    console.print(summary(runs, chosen))
    for note in notes(runs):
        console.print(note, highlight=False)
    plots.save(draw_recordings(runs), file)
    say(f"picture: {file}")


def show_experiment(out: Path) -> None:
    """One run of the turntable in closed co-simulation, with its report."""
    console.print("[bold]the paper's experiment[/bold]  FMUs of turntable, sensors and three filters in closed co-simulation, "
                  "yaw to and fro by 60 deg", soft_wrap=True, highlight=False)  # fmt: skip
    with working("60 s at 100 Hz"):
        run = simulate(SYSTEM, seed=1)
    folder = out / SYSTEM
    write_run(run, folder)
    write_report(run, folder / "report.html")
    say(f"  {len(run.t_s)} points of {len(run.columns)} signals in {sum(run.about['wall_s'].values()):.1f} s")
    say(f"  report: {folder / 'report.html'}")


def device_runs(filter: str, engine: str, settings: dict[str, str]) -> list[RecordingRun]:
    """The two device recordings; prints what is known about each."""
    wheel = find_wheel()
    runs = []
    for found in (read_xsens(wheel), read_x_imu(wheel)):
        console.print(f"[bold]{found.recording.name}[/bold]  {PACKAGE} {VERSION}, {found.source}", highlight=False)
        for finding in found.findings:
            console.print(f"  {finding}", highlight=False)
        runs.append(run_engine(found.recording, "device", filter, engine, settings))
    return runs


def own_run(file: Path, mag_unit: str | None, filter: str, engine: str, settings: dict[str, str]) -> RecordingRun:
    """The user's file, against the optical reference if it holds one."""
    recording = read(file, mag_unit=mag_unit)
    if len(recording.t_s) < 2:
        raise RecordingError(f"{file}: one row is no recording")
    return run_engine(recording, "" if recording.reference_q_nb is None else "optics", filter, engine, settings)


def run_engine(recording: Recording, reference: str, filter: str, engine: str, settings: dict[str, str]) -> RecordingRun:
    """The filter over the recording, in east-north-up as the references are.

    Raises HnavError for impossible settings, UsageError when the recording does not let the filter start.
    """
    with working(f"{recording.name} by {engine}"):
        result = run_recording(recording, filter, engine, settings={**settings, "navigation_frame": "enu"})
    if not np.isfinite(result.q_nb[-1]).all():
        raise UsageError(f"{recording.name}: the filter did not start: it needs force and field (or --set start_mode=heading)")
    return RecordingRun(recording, result, reference, filter)


def summary(runs: list[RecordingRun], settings: dict[str, str]) -> Table:
    """The figures of all runs, one column each."""
    chosen = ["default preset", *(f"{name}={value}" for name, value in settings.items())]
    table = Table(title=f"{runs[0].filter}, engine {runs[0].result.engine}, {', '.join(chosen)}", title_justify="left")
    table.add_column("", no_wrap=True)
    for run in runs:
        table.add_column(run.recording.name, justify="right", no_wrap=True)
    columns = [figures(run) for run in runs]
    for name in columns[0]:
        table.add_row(name, *(column[name] for column in columns))
    return table


def notes(runs: list[RecordingRun]) -> list[str]:
    """How to read the table."""
    device = "The device's attitude is an estimate too, no ground truth; both recordings are magnetically disturbed."
    nis = (
        "NIS has the expected mean when the noise is as parametrised; the default preset leaves room for accelerations and "
        "disturbed fields, so quiet recordings lie below."
    )
    return [device, nis] if any(run.reference == "device" for run in runs) else [nis]
