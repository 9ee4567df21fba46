"""hnav filter: a recording through a filter, into a table of attitude, bias, sigmas and status, and a page.

--filter ins is in hnav.cli.navigation.
"""

from __future__ import annotations

import glob
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from hnav.cli import navigation
from hnav.cli.console import counting, say, written
from hnav.cli.parameters import Engine, Force, Gnss, Scheduler, Smooth, Strict, Workers, page_option, with_groups
from hnav.cli.recordings import Z_POINTS_UP, Reading, lines_of, read_as, warn, warnings_of, z_points_up
from hnav.cli.wanted import Choice, Wanted
from hnav.cli.words import UsageError
from hnav.filters.attitude_answers import Run
from hnav.filters.attitude_recording import LibraryRun
from hnav.filters.health import Finding, Tally, findings
from hnav.filters.options import Options, option_table
from hnav.filters.run_files import PARQUET, write_pieces, write_table
from hnav.fmi.engines import run_recording
from hnav.io.outputs import refuse_overwriting
from hnav.io.readers.pieces import LongTable
from hnav.io.recordings import Recording
from hnav.reports.track_files import GPX, TUM, write_tum

FORMS = (".csv", *PARQUET, TUM, GPX)
"""Of tables; without a suffix, as of a pipe, CSV."""
Z_UP = ("phone", "phyphox", "sensor-logger", "sensor-logger-json")
"""Formats of devices whose z axis points up at rest."""
WARNED_S = 1.0  # a sensor that was faulty for longer gives a warning
RANGES = {"gyro": "gyro_range_rad_s", "accel": "accel_range_m_s2", "mag": "mag_range_tesla"}
OUTLIERS = {"gyro": "outlier_rate_rad_s", "accel": "outlier_force_m_s2"}


@with_groups
def command(
    recordings: Annotated[
        list[str],
        typer.Argument(
            metavar="RECORDING...",
            help="File or folder: CSV, phone export, PX4 log, ROS bag, Parquet, BROAD; recognised by its content. Of several, or of a pattern "
            "in quotation marks, --out names the folder for their tables",
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE|DIR", help="Table to write, one row for each row of the recording: .csv, .parquet, .tum; of ins .gpx"
        ),
    ] = None,
    report: Annotated[Path | None, page_option("Page to write: figures, panels, a body that turns")] = None,
    engine: Engine = "c",
    step: Annotated[
        float | None, typer.Option(metavar="SECONDS", help="Communication step of an FMU; default: from sample to sample")
    ] = None,
    *,
    choice: Choice,
    reading: Reading,
    strict: Strict = False,
    force: Force = False,
    smooth: Smooth = False,
    gnss: Gnss = None,
    truth: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Of --filter ins: print its errors, by a CSV of t_s, lat_deg, lon_deg, alt_m, vn, ve, vd, roll, pitch, heading or q0 to q3",
        ),
    ] = None,
    outages: Annotated[
        str | None,
        typer.Option(metavar="SECONDS,...", help="With --truth: artificial outages of the satellites, such as 10,30,60"),
    ] = None,
    workers: Workers = 1,
    scheduler: Scheduler = None,
) -> None:
    wanted = choice.wanted(
        reading, engine=engine, step=step, strict=strict, force=force, smooth=smooth, gnss=gnss, truth=truth, outages=outages
    )
    paths = expanded(recordings)
    if len(paths) == 1 and recordings == [str(paths[0])]:
        filter_one(paths[0], out, report, wanted)
        return
    if out is None or report is not None:
        raise UsageError("of several recordings give --out DIR, a folder for their tables and an index page, and no --report")
    if out.suffix.lower() in FORMS and not out.is_dir():
        raise UsageError(f"--out {out}: of several recordings it is a folder, for tables in CSV and an index page: name one")
    from hnav.cli.many import filter_many  # Dask takes a while to load

    filter_many(paths, out, wanted, workers, scheduler)


def expanded(recordings: list[str]) -> list[Path]:
    """Files and folders, with patterns expanded. Raises UsageError for a pattern that matches nothing."""
    paths: list[Path] = []
    for text in recordings:
        if Path(text).exists() or not any(mark in text for mark in "*?["):
            paths.append(Path(text))
        elif found := sorted(glob.glob(text, recursive=True)):
            paths += map(Path, found)
        else:
            raise UsageError(f"{text}: no file matches it")
    return list(dict.fromkeys(paths))


def filter_one(recording: Path, out: Path | None, report: Path | None, wanted: Wanted) -> str:
    """Filters one recording into its table and its page; returns how it was read. Raises HnavError or UsageError."""
    check_names(recording, out, report, wanted)
    filter, reading, preset = wanted.filter, wanted.reading, wanted.preset
    option_table(filter)  # refuses what is no filter
    if filter == navigation.NAME:
        navigation.refuse(engine=wanted.engine != "c", step=wanted.step, frame=wanted.frame not in (None, "ned"))
        return navigate(recording, out, report, wanted)
    if out is not None and out.suffix.lower() == GPX:
        cure = f"add --filter {navigation.NAME}, or write .csv, .parquet or .tum"
        raise UsageError(f"--out {out}: attitude filters have no track: {cure}")
    navigation.refuse_of_ins(gnss=wanted.gnss, truth=wanted.truth, outages=wanted.outages)
    engine, step, smooth = wanted.engine, wanted.step, wanted.smooth
    corrected, made = wanted.corrected(), wanted.made_of(recording)
    whole = report or smooth or engine != "c" or step  # a page, smoothing, and an FMU need all rows at once
    table = None if whole else reading.long_table(recording, corrected)
    if table is not None and out is not None:
        warnings = warnings_of(recording, table.findings, wanted.strict, wanted.force)
        first = next(iter(table))
        chosen, note = with_frame(wanted.frame, wanted.settings, first)
        outcome, read = filter_pieces(table, out, Options(filter, preset, **chosen), made), read_as(first)
    else:
        data = reading.read(recording)
        data = data if corrected is None else corrected(data)
        found = reading.check(data)
        warnings = warnings_of(recording, found, wanted.strict, wanted.force)
        chosen, note = with_frame(wanted.frame, wanted.settings, data)
        result = filtered(data, filter, engine, chosen, preset, step, smooth)
        if out is not None:
            write_tum(out, [result]) if out.suffix.lower() == TUM else write_table(out, result, made)
        if report is not None:
            write_page(report, result, data, lines_of(found))
        outcome = Outcome(len(result.t_s), result.us_per_sample, result.counts, findings(result.t_s, result.health))
        read = read_as(data)
    print_outcome(outcome, engine, out, report, note)
    warn(warnings)
    return read


def with_frame(frame: str | None, settings: Mapping[str, str], data: Recording) -> tuple[dict[str, str], list[str]]:
    """The settings with the navigation frame, and a note on a frame that the user did not choose."""
    if frame is not None or "navigation_frame" in settings:
        return {"navigation_frame": frame or "ned", **settings}, []
    if data.origin is not None and data.origin.format in Z_UP:
        note = ["attitude to east, north, up, as telephones have it; --frame ned for the other"]
        return {**settings, "navigation_frame": "enu"}, note
    mounted = "q_body_sensor" in settings  # as stated, it may well be level
    note = [f"{Z_POINTS_UP}: --frame enu has it level"] if z_points_up(data) and not mounted else []
    return {**settings, "navigation_frame": "ned"}, note


def navigate(recording: Path, out: Path | None, report: Path | None, wanted: Wanted) -> str:
    """Output of --filter ins; returns how the recording was read, "" if nothing is written. Raises HnavError or UsageError."""
    if wanted.outages is not None and wanted.truth is None:
        raise UsageError(f"--outages {wanted.outages}: errors are against a truth: add --truth FILE")
    read = navigation.navigate(recording, out, report, wanted) if out is not None or report is not None else ""
    if wanted.truth is not None:
        from hnav.cli.outages import print_errors  # scores take a while to load

        print_errors(recording, wanted, warned=read != "")
    return read


def check_names(recording: Path, out: Path | None, report: Path | None, wanted: Wanted) -> None:
    """Raises HnavError or UsageError for files that are not to be read or written."""
    if out is None and report is None and wanted.truth is None:
        raise UsageError("name what to write: --out FILE.csv (or .parquet), --report FILE.html, or both")
    if out is not None and out.suffix and out.suffix.lower() not in FORMS:
        raise UsageError(f"--out {out}: the forms are {', '.join(FORMS)}")
    refuse_overwriting([out, report], [recording, wanted.sensor, wanted.truth])


@dataclass(frozen=True)
class Outcome:
    """The results of a run to print, for a run in pieces or as a whole."""

    rows: int
    us_per_sample: float
    counts: Mapping[str, int]
    findings: list[Finding]


def filter_pieces(table: LongTable, out: Path, options: Options, made: list[str]) -> Outcome:
    """Filters a long table in pieces, with a progress bar: memory does not grow with its length. The file equals that of a
    whole run.
    """
    run, tally = LibraryRun(options), Tally()
    parts = navigation.runs(table, table.name, table.rows, run.go_on, lambda part: tally.add(part.t_s, part.health))
    write_tum(out, parts) if out.suffix.lower() == TUM else write_pieces(out, parts, made)
    return Outcome(table.rows, run.us_per_sample, run.counts, tally.findings())


def print_outcome(outcome: Outcome, engine: str, out: Path | None, report: Path | None, note: list[str]) -> None:
    """Rows, time and counts in one line, and what the user may change."""
    counts = ", ".join(f"{name} {n}" for name, n in outcome.counts.items() if n)
    say(f"{outcome.rows} rows to {written(out, report)}; {outcome.us_per_sample:.2f} us/sample by {engine}; {counts}")
    for line in [*warnings(outcome.findings), *mostly_gated(outcome.counts), *infeasible_gamma(outcome.counts), *note]:
        say(line)


def filtered(
    data: Recording, filter: str, engine: str, settings: dict[str, str], preset: str, step: float | None, smooth: bool
) -> Run:
    """Runs the filter with a progress bar."""
    with counting(data.name, len(data.t_s)) as show:
        return run_recording(data, filter, engine, settings, preset, step, show, smooth)


def write_page(file: Path, result: Run, data: Recording, warnings: list[str]) -> list[str]:
    """Writes the page; returns the names of its panels."""
    # Plotly takes a while to load.
    from hnav.reports.recording_page import write_recording_report
    from hnav.reports.recording_run import recording_run

    return write_recording_report(recording_run(result, data, warnings), file)


def warnings(found: list[Finding]) -> list[str]:
    """A line for each sensor that was faulty for more than WARNED_S in all, with the remedy for its longest fault."""
    lines = []
    for sensor in dict.fromkeys(finding.sensor for finding in found):
        own = [finding for finding in found if finding.sensor == sensor]
        if sum(finding.lasted_s for finding in own) > WARNED_S:
            states = ", ".join(f"{finding.state} for {finding.lasted_s:.1f} s" for finding in own)
            lines.append(f"{sensor} {states}: {cure(own[0])}")
    return lines


def mostly_gated(counts: Mapping[str, int]) -> list[str]:
    """A warning when the field was rejected or down-weighted at most samples: the heading then follows the gyroscope."""
    used, gated = (counts.get(f"mag_{name}", 0) for name in ("used", "gated"))
    if not gated > 0.5 * used > 0:
        return []
    return [
        f"warning: {gated} of {used} samples of the field did not fit, so the heading follows the gyroscope: hnav calibrate removes iron "
        "of the device; look for iron and currents near it"
    ]


def infeasible_gamma(counts: Mapping[str, int]) -> list[str]:
    """A warning when the requested gamma was infeasible at most corrections: then the limit applies instead."""
    raised, corrections = (counts.get(name, 0) for name in ("gamma_raised", "corrections"))
    if not raised > 0.5 * corrections > 0:
        return []
    return [
        f"gamma was infeasible at {raised} of {corrections} corrections and raised to the limit, where the filter trusts its samples "
        "alone: give a larger --set gamma=..., or --set gamma_mode=relative"
    ]


def cure(finding: Finding) -> str:
    """The remedy for a sensor in this state."""
    return {
        "late": "give --set horizon_s=..., a little above the latest delay",
        "outlier": f"look at cable and supply; if the body moves so, give a larger --set {OUTLIERS.get(finding.sensor, '')}=...",
        "stuck": "look at cable and driver; a body that lies still does not count",
        "saturated": f"give --set {RANGES[finding.sensor]}=..., or use a sensor with a wider range",
        "missing": "look for rows without its samples; of an FMU at a --step longer than their interval, take a shorter one",
    }[finding.state]
