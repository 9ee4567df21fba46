"""hnav demo: runs the AHRS on your recording, or on two recordings of devices and on simulated sensors in closed loop.

The recordings hold the device's own attitude (see hnav.io.device_recordings), an estimate too. In the closed loop, FMUs of a
turntable, sensors and three filters are stepped from their SSP system; the truth is known, and the page shows the median
run. No filter is tuned for the demo.
"""

from __future__ import annotations

import os
import re
import sys
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from hnav.cli.console import console, say, working
from hnav.cli.filter import write_page
from hnav.cli.parameters import Force, Settings, Strict, parse_settings, with_groups
from hnav.cli.recordings import Reading, lines_of, warn, warnings_of
from hnav.filters.attitude_answers import Run as AttitudeRun
from hnav.filters.run_summary import rows, summary
from hnav.fmi.engines import run_recording
from hnav.io.device_recordings import DeviceRecording, WheelUnavailable, find_wheel, read_x_imu, read_xsens
from hnav.io.outputs import refuse_overwriting
from hnav.io.recordings import Recording
from hnav.systems.run_views import estimates, figures
from hnav.systems.simulation import Run, simulate, write_run

SYSTEM, RECOMMENDED = "turntable", "ahrs"
SEEDS = range(1, 6)
# Scenarios of the system; the page shows the last.
SCENARIOS = {"nominal": "in a true field", "magnetic_disturbance": "with 0.3 of the field false for 10 s"}


@with_groups
def command(
    recording: Annotated[
        Path | None,
        typer.Argument(help="Your file, as hnav filter takes it; without it two recordings of devices, and the closed loop"),
    ] = None,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the pages")] = Path("demo_out"),
    settings: Settings = None,
    *,
    reading: Reading,
    strict: Strict = False,
    force: Force = False,
    open: Annotated[
        bool | None, typer.Option("--open/--no-open", help="Show the last page in the browser; default: where there is a screen")
    ] = None,
) -> None:
    chosen = parse_settings(settings)
    if recording is not None:
        data = reading.read(recording)
        found = reading.check(data)
        warnings = warnings_of(recording, found, strict, force)
        page = show_own(recording, data, chosen, lines_of(found), out)
        warn(warnings)
    else:
        show_devices(chosen, out)
        page = show_closed_loop(out)
    if has_screen() if open is None else open:
        typer.launch(str(page))


def has_screen() -> bool:
    """Whether output goes to a terminal on a machine with a screen."""
    display = sys.platform in ("darwin", "win32") or any(os.environ.get(s) for s in ("DISPLAY", "WAYLAND_DISPLAY"))
    return console.is_terminal and display


def show_own(file: Path, data: Recording, settings: dict[str, str], warnings: list[str], out: Path) -> Path:
    """Results and page of the AHRS for the user's file."""
    page = out / f"{file.stem}.html"
    refuse_overwriting([page], [file])
    result = run_ahrs(data, settings)
    write_page(page, result, data, warnings)
    say(repr(data))
    said = rows(summary(result))
    width = max(len(name) for name, _ in said)
    for name, value in said:
        say(f"  {name:<{width}}  {value}")
    say(f"page: {page}")
    return page


def run_ahrs(data: Recording, settings: dict[str, str]) -> AttitudeRun:
    with working(data.name):
        return run_recording(data, RECOMMENDED, "c", settings)


# --------------------------------------------------------------------------------------------- recordings of devices


def show_devices(settings: dict[str, str], out: Path) -> None:
    """Two recordings of worn devices, with the devices' own attitude."""
    try:
        wheel = find_wheel()
    except WheelUnavailable as reason:
        say(f"Two recordings of devices are left out: {reason}")
        return
    say("Two devices, worn where iron bends the field; the AHRS beside the device's own attitude, which is an estimate too:")
    for found in (read_xsens(wheel), read_x_imu(wheel)):
        show_device(found, settings, out)


def show_device(found: DeviceRecording, settings: dict[str, str], out: Path) -> None:
    from hnav.reports.recording_page import write_recording_report  # Plotly, which --help does without
    from hnav.reports.recording_run import RecordingRun, compare

    data = found.recording
    result = run_ahrs(data, settings)
    run = RecordingRun(data, result, "device", RECOMMENDED, found.findings)
    page = out / f"{'_'.join(re.findall(r'[a-z]+', data.name.lower()))}.html"
    write_recording_report(run, page)
    reference = run.reference_q_nb
    assert reference is not None
    against, of_run = compare(data.t_s, result.q_nb, reference), summary(result)
    tilt, heading = (np.sqrt(np.nanmean(series**2)) for series in (against.inclination_deg, against.heading_deg))
    apart = f"heading {heading:.1f} deg besides a constant {against.heading_offset_deg:.1f} deg"
    say(f"  {data.name}, {of_run.length_s:.0f} s: RMS from the device's: tilt {tilt:.1f} deg, {apart}")
    ready = [f"{name} {'never' if np.isnan(s) else f'after {s:.1f} s'}" for name, s in zip(("tilt", "heading"), of_run.ready_s)]
    say(f"    ready: {', '.join(ready)}; the gate let {100 * of_run.accepted_share[1]:.0f} % of the field pass; page: {page}")


# --------------------------------------------------------------------------------------------- closed loop


def show_closed_loop(out: Path) -> Path:
    """Filters against the truth over some seeds, and the page of the median run."""
    from hnav.reports.page import write_report

    say(
        f"Turntable, sensors and filters as FMUs in closed loop, 60 s, {len(SEEDS)} seeds: RMS error in deg, median (least to most):"
    )
    for scenario, text in SCENARIOS.items():
        with working(f"{len(SEEDS)} runs of {scenario}"):
            runs = [simulate(SYSTEM, scenario, seed=seed) for seed in SEEDS]
        errors = {name: [rmse_deg(run, name) for run in runs] for name in recommended_first(runs[0])}
        said = (f"{name} {np.median(values):.2f} ({min(values):.2f} to {max(values):.2f})" for name, values in errors.items())
        say(f"  {text}: {', '.join(said)}")
    say("  hekf and hrekf, the paper's, have the noise of these sensors as options; ahrs has its defaults")
    middle = int(np.argsort(errors[RECOMMENDED])[len(SEEDS) // 2])
    run, folder = runs[middle], out / SYSTEM
    write_run(run, folder)
    page = folder / "report.html"
    components = {name: run.about["components"][name] for name in sorted(run.components, key=lambda name: name != RECOMMENDED)}
    write_report(replace(run, about=run.about | {"components": components}), page)
    say(f"  page of the last line's run in the middle, seed {SEEDS[middle]}: {page}")
    return page


def recommended_first(run: Run) -> list[str]:
    return sorted((estimate.name for estimate in estimates(run)), key=lambda name: name != RECOMMENDED)


def rmse_deg(run: Run, name: str) -> float:
    """Over the whole run, from the start of the filter."""
    return next(figures(estimate).rmse_deg for estimate in estimates(run) if estimate.name == name)
