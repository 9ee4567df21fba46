"""hnav filter: a recording through a filter, into a table of attitude, bias, sigmas and what the filter says, and a page."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hnav.cli.console import bar, say
from hnav.cli.parameters import Engine, FilterName, Preset, Settings, Smooth, Strict, parse_settings
from hnav.cli.recordings import Reading, lines_of, warn, warnings_of, with_reading
from hnav.cli.words import UsageError
from hnav.filters.calibration import read_calibration
from hnav.filters.health import Finding, findings
from hnav.filters.run_files import write_table
from hnav.fmi.engines import run_recording
from hnav.fmi.results import Result
from hnav.io.outputs import refuse_overwriting
from hnav.io.recordings import Recording
from hnav.renamed import new_name

WARNED_S = 1.0  # a sensor that was not ok for longer
RANGES = {"gyro": "gyro_range_rad_s", "accel": "accel_range_m_s2", "mag": "mag_range_tesla"}
OUTLIERS = {"gyro": "outlier_rate_rad_s", "accel": "outlier_force_m_s2"}


@with_reading
def command(
    recording: Annotated[
        Path,
        typer.Argument(help="File or folder: CSV, phone export, PX4 log, ROS bag, Parquet, BROAD; recognised by its content"),
    ],
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Table to write, one row for each row of the recording: .csv or .parquet")
    ] = None,
    report: Annotated[
        Path | None, typer.Option(metavar="FILE.html", help="Page to write: figures, panels, a body that turns")
    ] = None,
    filter: FilterName = "ahrs",
    engine: Engine = "c",
    settings: Settings = None,
    preset: Preset = "default",
    step: Annotated[
        float | None, typer.Option(metavar="SECONDS", help="Communication step of an FMU; default: from sample to sample")
    ] = None,
    frame: Annotated[str, typer.Option(help="Navigation frame: ned or enu")] = "ned",
    *,
    reading: Reading,
    strict: Strict = False,
    smooth: Smooth = False,
    calibration: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Correct the field first: a file by hnav calibrate")
    ] = None,
) -> None:
    if new := new_name(str(recording), "filter"):
        raise UsageError(f"{recording}: a recording is wanted here; the filter of this name is now called {new}: --filter {new}")
    chosen = {"navigation_frame": frame} | parse_settings(settings)
    if out is None and report is None:
        raise UsageError("name what to write: --out FILE.csv (or .parquet), --report FILE.html, or both")
    refuse_overwriting([out, report], [recording, calibration])
    data = reading.read(recording)
    if calibration is not None:
        data = read_calibration(calibration).apply_to(data)
    found = reading.check(data)
    doubts = warnings_of(recording, found, strict)
    result = filtered(data, filter, engine, chosen, preset, step, smooth)
    if out is not None:
        write_table(out, result, made_of(recording, engine, smooth, calibration))
    if report is not None:
        write_page(report, result, data, lines_of(found))
    say(summary(result, engine, " and ".join(str(file) for file in (out, report) if file is not None)))
    for warning in [*warnings(result), *infeasible_gamma(result)]:
        say(warning)
    warn(doubts)


def filtered(
    data: Recording, filter: str, engine: str, settings: dict[str, str], preset: str, step: float | None, smooth: bool
) -> Result:
    """The run, with a progress bar."""
    with bar() as progress:
        task = progress.add_task(data.name, total=len(data.t_s))

        def show(done: int, total: int) -> None:
            progress.update(task, completed=done, total=total)

        return run_recording(data, filter, engine, settings, preset, step, show, smooth, gates=True)


def write_page(file: Path, result: Result, data: Recording, doubts: list[str]) -> list[str]:
    """Returns the names of its panels."""
    # Plotly takes a while to load.
    from hnav.reports.recording_page import write_recording_report
    from hnav.reports.recording_run import recording_run

    return write_recording_report(recording_run(result, data, doubts), file)


def summary(result: Result, engine: str, written: str) -> str:
    """What was done, in a line."""
    counts = ", ".join(f"{name} {n}" for name, n in result.counts.items() if n)
    return f"{len(result.t_s)} rows to {written}; {result.us_per_sample:.2f} us/sample by {engine}; {counts}"


def made_of(recording: Path, engine: str, smooth: bool, calibration: Path | None) -> list[str]:
    """What a table's head says of its making, besides filter and options."""
    lines = [f"recording {recording}", f"engine {engine}"]
    lines += ["smoothed: every row from all samples, before and after it"] if smooth else []
    return lines + ([f"field corrected by {calibration}"] if calibration else [])


def warnings(result: Result) -> list[str]:
    """A line for each sensor that was not ok for more than WARNED_S in all, with the cure of what lasted longest."""
    found = findings(result.t_s, result.health)
    lines = []
    for sensor in dict.fromkeys(finding.sensor for finding in found):
        own = [finding for finding in found if finding.sensor == sensor]
        if sum(finding.lasted_s for finding in own) > WARNED_S:
            states = ", ".join(f"{finding.state} for {finding.lasted_s:.1f} s" for finding in own)
            lines.append(f"{sensor} {states}: {cure(own[0])}")
    return lines


def infeasible_gamma(result: Result) -> list[str]:
    """A line when the gamma that was asked was infeasible at most corrections: then the limit acts, not what was asked."""
    raised, corrections = (result.counts.get(name, 0) for name in ("gamma_raised", "corrections"))
    if not raised > 0.5 * corrections > 0:
        return []
    return [
        f"gamma was infeasible at {raised} of {corrections} corrections and raised to the limit, where the filter trusts its samples "
        "alone: give a larger --set gamma=..., or --set gamma_mode=relative"
    ]


def cure(finding: Finding) -> str:
    """What to do about a sensor in this state."""
    return {
        "late": "give --set horizon_s=..., a little above the latest delay",
        "outlier": f"look at cable and supply; if the body moves so, give a larger --set {OUTLIERS.get(finding.sensor, '')}=...",
        "stuck": "look at cable and driver; a body that lies still does not count",
        "saturated": f"give --set {RANGES[finding.sensor]}=..., or use a sensor with a wider range",
        "missing": "look for rows without its samples",
    }[finding.state]
