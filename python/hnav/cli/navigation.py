"""The commands with --filter ins: run the navigation filter over a recording with satellites; write a table and a page."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

import numpy as np

from hnav.cli.console import bar, load_pages, say, working, written
from hnav.cli.recordings import Z_POINTS_UP, lines_of, read_as, warn, warnings_of, z_points_up
from hnav.cli.wanted import INS, Wanted
from hnav.cli.words import UsageError
from hnav.filters.ins_aids import AIDS
from hnav.filters.ins_answers import READY, InsRun, InsSamples
from hnav.filters.ins_recording import NavigationRun, inertial_rows, interval_of, paired, refuse_other_clock, with_aids
from hnav.filters.options import Options
from hnav.filters.readiness import sigmas, smallest, why_never
from hnav.filters.run_base import RunBase
from hnav.filters.run_files import write_pieces
from hnav.io.aids import AidSamples
from hnav.io.findings import Finding
from hnav.io.outputs import refuse_overwriting
from hnav.io.plausible_aids import check_aids
from hnav.io.readers.aids import NO_POSITIONS
from hnav.io.readers.pieces import LongTable
from hnav.io.recordings import Recording
from hnav.reports.track_files import GPX, TUM, write_gpx, write_tum

R = TypeVar("R", bound=RunBase)
NAME = INS
ROWS = 20_000  # between two steps of the progress bar
LEVELLED = "--set q_body_sensor=0,1,0,0"
PAIRED = "gyroscope and accelerometer come in lines of their own, and live the INS needs both in one: record the samples, and filter the file"
# A finding about recordings for attitude filters only: the INS does not need a magnetometer.
OF_THE_FIELD = "mag"


@dataclass
class Outcome:
    """The results of a run to print, for a run in pieces or as a whole."""

    rows: int = 0
    begin_s: float = np.nan
    ready_s: np.ndarray = field(default_factory=lambda: np.full(len(READY), np.nan))
    reached: np.ndarray = field(default_factory=lambda: np.full(len(READY), np.inf))
    """4: the smallest sigma of each of READY."""
    last: str = "no estimate"
    seconds: float = 0.0

    def add(self, run: InsRun) -> None:
        """The next rows."""
        if not self.rows:
            self.begin_s = float(run.t_s[0])
        of_rows = sigmas(run.sigma_rotation_rad, run.sigma_velocity_m_s, run.sigma_position_m)
        self.reached = np.minimum(self.reached, smallest(of_rows))
        for i, flags in enumerate(run.ready.T):
            if np.isnan(self.ready_s[i]) and flags.any():
                self.ready_s[i] = run.t_s[np.argmax(flags)] - self.begin_s
        self.rows += len(run.t_s)
        if np.isfinite(run.place[-1]).all():
            heading, sigma = np.degrees(run.heading_rad[-1]) % 360, np.degrees(run.sigma_rotation_rad[-1, 2])
            self.last = f"last heading {heading:.1f} deg, sigma {sigma:.2g} deg"


def refuse(**given: object) -> None:
    """Raises UsageError for the first option that belongs to the attitude filters. given: by name, None or False if it was not."""
    reasons = {
        "--engine": "the navigation filter runs in C: leave it out",
        "--step": "the navigation filter takes samples as they come: leave it out",
        "--frame": f"the navigation filter answers north, east, down: leave it out; of a sensor whose z points up give {LEVELLED}",
    }
    for name, value in given.items():
        if value:
            option = f"--{name}"
            raise UsageError(f"{option} with --filter {NAME}: {reasons[option]}")


def refuse_of_ins(**given: object) -> None:
    """Raises UsageError for options without effect on an attitude filter. given: options by name, None if they were not."""
    for name, value in given.items():
        if value is not None:
            raise UsageError(f"--{name} {value}: attitude filters do not read it: add --filter {NAME}, or leave it out")


def navigate(recording: Path, out: Path | None, report: Path | None, wanted: Wanted) -> str:
    """hnav filter --filter ins; what the recording was read as. Raises HnavError or UsageError."""
    refuse_overwriting([out, report], [recording, wanted.gnss, wanted.sensor])
    options, given = Options(INS, wanted.preset, **wanted.settings), wanted.reading.read_aids(wanted.gnss)
    table, made = None, wanted.made_of(recording)
    if out is not None and report is None and not wanted.smooth:
        table = wanted.reading.beside(wanted.gnss).long_table(recording, wanted.corrected())
    if table is not None and out is not None and (run := run_of_pieces(table, options, given)):
        first = with_aids(next(iter(table)), given)
        found = [*of_navigation(table.findings), *check_aids(first)]
        warnings = warnings_of(recording, found, wanted.strict, wanted.force) + level_note(recording, first, options)
        outcome, read = Outcome(), read_as(first)
        write_out(out, runs(table, table.name, table.rows, run.go_on, outcome.add), made, recording.stem)
    else:
        data, found = read_navigation(recording, given, options, wanted)
        warnings = warnings_of(recording, found, wanted.strict, wanted.force)
        notes = [note for note in left_out(data) if not note.startswith(NO_POSITIONS)]
        warnings += [f"note: {recording.name}: {note}" for note in notes] + level_note(recording, data, options)
        run, outcome, read = NavigationRun.over(data, options), Outcome(), read_as(data)
        pieces = (inertial_rows(data, slice(begin, begin + ROWS)) for begin in range(0, len(data.t_s), ROWS))
        of_pieces = runs(pieces, data.name, len(data.t_s), run.go_on, outcome.add)
        parts = [smoothed(data, run, outcome)] if wanted.smooth else list(of_pieces)
        if out is not None:
            write_out(out, parts, made, recording.stem)
        if report is not None:
            load_pages(report)
            from hnav.reports.navigation_page import write_navigation_report

            write_navigation_report(whole(parts), report, data, lines_of(found))
    say(summary(outcome, run, written(out, report)))
    warn([*warnings, *of_run(outcome, run)])
    return read


def write_out(out: Path, parts: Iterable[InsRun], made: list[str], name: str) -> None:
    """The table, or the track, that the suffix asks for. Raises HnavError."""
    suffix = out.suffix.lower()
    if suffix == GPX:
        write_gpx(out, parts, name)
    elif suffix == TUM:
        write_tum(out, parts)
    else:
        write_pieces(out, parts, made)


def read_navigation(
    path: Path, given: Mapping[str, AidSamples], options: Options, wanted: Wanted
) -> tuple[Recording, list[Finding]]:
    """The recording with its aids, corrected, rate and force in the same rows; and what is implausible in it. Raises HnavError or
    UsageError when there is no aid.
    """
    data = with_aids(paired(wanted.reading.beside(wanted.gnss).read(path)), given)
    refuse_unaided(path, data, options)
    data = corrected(data) if (corrected := wanted.corrected()) else data
    return data, [*of_navigation(wanted.reading.check(data)), *check_aids(data)]


def left_out(data: Recording) -> list[str]:
    """What of the file is not used, and why."""
    return [note for note in (data.origin.notes if data.origin else ()) if "left out" in note]


def level_note(path: Path, data: Recording, options: Options) -> list[str]:
    """That the output will be upside down, with the cure."""
    if tuple(options.q_body_sensor) != (1, 0, 0, 0) or not z_points_up(data):
        return []
    return [f"note: {path.name}: {Z_POINTS_UP}: {LEVELLED} has it level"]


def refuse_unaided(path: Path, data: Recording, options: Options) -> None:
    """Raises UsageError for a recording without a position, unless the options give one."""
    if "position" in data.aids or options.start_place == "given":
        return
    notes = left_out(data)
    raise UsageError(
        f"{path}: has no positions (lat_deg, lon_deg, alt_m): give --gnss FILE, or of a body at rest its place by --set start_place=given "
        "--set start_latitude_rad=... --set start_longitude_rad=..." + "".join(f" ({note})" for note in notes[:1])
    )


def run_of_pieces(table: LongTable, options: Options, given: Mapping[str, AidSamples]) -> NavigationRun | None:
    """A run for a long table; None for a table that must be read as a whole."""
    first = next(iter(table))
    if paired(first) is not first or not {*first.aids, *given} & {"position"}:
        return None
    refuse_other_clock(table.name, float(first.t_s[0]), np.inf, given)
    return NavigationRun(options, given, interval_of(first))


def runs(
    pieces: Iterable[Recording], name: str, rows: int, go_on: Callable[[Recording], R], note: Callable[[R], None]
) -> Iterator[R]:
    """Runs piece by piece, with a progress bar of so many rows. note: is shown each part."""
    with bar() as progress:
        task = progress.add_task(name, total=rows)
        for part in map(go_on, pieces):
            note(part)
            yield part
            progress.advance(task, len(part.t_s))


def smoothed(data: Recording, run: NavigationRun, outcome: Outcome) -> InsRun:
    """Runs all rows at once; the run has the aids already."""
    with working(f"{data.name}: forward and back"):
        made = run.go_on(inertial_rows(data), smooth=True)
    outcome.add(made)
    return made


def whole(parts: list[InsRun]) -> InsRun:
    """One run of several."""
    names = [name for name, value in vars(parts[0]).items() if isinstance(value, np.ndarray)]
    arrays = {name: np.concatenate([vars(part)[name] for part in parts]) for name in names}
    samples = InsSamples.joined([part.samples for part in parts if part.samples is not None])
    return InsRun(**arrays, options=parts[0].options, smoothed=parts[0].smoothed, samples=samples)


def of_navigation(found: list[Finding]) -> list[Finding]:
    """Findings without those about the calibration of the magnetometer, which the INS estimates itself."""
    return [finding for finding in found if finding.sensor != OF_THE_FIELD]


def summary(outcome: Outcome, run: NavigationRun, files: str) -> str:
    """One line about rows, time, readiness and findings."""
    counts = ", ".join(f"{name} {n}" for name, n in run.counts.items() if n)
    ready = ", ".join(f"{name} after {t:.3g} s" for name, t in zip(READY, outcome.ready_s) if np.isfinite(t)) or "nothing"
    return f"{outcome.rows} rows to {files}; {run.us_per_sample:.2f} us/sample; {outcome.last}; ready: {ready}; {counts}"


def never(outcome: Outcome, run: NavigationRun, name: str) -> str:
    """Why one of READY was never ready."""
    return why_never(name, float(outcome.reached[READY.index(name)]), run.options)


def of_run(outcome: Outcome, run: NavigationRun) -> list[str]:
    """Warnings, one line each, with the remedy."""
    seen, lines = run.ins.diagnostics(), []
    if not np.isfinite(outcome.ready_s).any():
        phase, cause = run.ins.navigation().phase, "no position of satellites was used"
        if seen.used["position"]:
            cause = "see whether satellites and rows have the same clock"
        tilt = "" if not outcome.rows else f"; the tilt: {never(outcome, run, 'tilt')}"
        lines.append(f"warning: nothing was ever ready, the filter ended {phase.replace('_', ' ')}: {cause}{tilt}")
    elif np.isnan(outcome.ready_s[1]):
        why = f"{never(outcome, run, 'heading')}; it needs curves, or braking and gaining speed, with satellites"
        lines.append(f"warning: the heading was never ready: {why}")
    if seen.late:
        lines.append(f"warning: {seen.late} samples came too late: give a larger --set horizon_s=...")
    lines += [
        f"warning: {name}: {seen.gated[name]} of {seen.used[name]} samples were beyond the gate: see its sigmas, units and clock"
        for name in AIDS
        if seen.gated[name] > 0.5 * seen.used[name] > 0
    ]
    return lines
