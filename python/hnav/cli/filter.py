"""hnav filter: a recording through a filter into a CSV of attitude, bias and sigmas."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from hnav.cli.console import bar, say
from hnav.cli.parameters import Engine, FilterName, MagUnit, Preset, Settings, Smooth, parse_settings
from hnav.cli.words import UsageError
from hnav.filters.attitude import HEALTH_SENSORS
from hnav.filters.calibration import read_calibration
from hnav.filters.health import Finding, findings
from hnav.fmi.engines import run_recording
from hnav.fmi.results import Result
from hnav.io.outputs import refuse_overwriting, write_files
from hnav.io.readers import read
from hnav.renamed import new_name

CSV_HEADER = (
    "t_s,q0,q1,q2,q3,roll_deg,pitch_deg,yaw_deg,bias_x_deg_s,bias_y_deg_s,bias_z_deg_s,"
    "sigma_x_deg,sigma_y_deg,sigma_z_deg,sigma_bias_x_deg_s,sigma_bias_y_deg_s,sigma_bias_z_deg_s,"
    + ",".join(f"{sensor}_health" for sensor in HEALTH_SENSORS)
)

WARNED_S = 1.0  # a sensor that was not ok for longer
RANGES = {"gyro": "gyro_range_rad_s", "accel": "accel_range_m_s2", "mag": "mag_range_tesla"}
OUTLIERS = {"gyro": "outlier_rate_rad_s", "accel": "outlier_force_m_s2"}


def command(
    recording: Annotated[
        Path, typer.Argument(help="BROAD trial (.hdf5, .mat) or CSV with the columns t_s,gx,gy,gz,ax,ay,az,mx,my,mz")
    ],
    out: Annotated[Path, typer.Option(help="CSV to write, one row for each IMU sample")],
    filter: FilterName = "ahrs",
    engine: Engine = "c",
    settings: Settings = None,
    preset: Preset = "default",
    step: Annotated[
        float | None, typer.Option(metavar="SECONDS", help="Communication step of an FMU; default: from sample to sample")
    ] = None,
    frame: Annotated[str, typer.Option(help="Navigation frame: ned or enu")] = "ned",
    mag_unit: MagUnit = "T",
    smooth: Smooth = False,
    calibration: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Correct the field first: a file by hnav calibrate")
    ] = None,
) -> None:
    if new := new_name(str(recording), "filter"):
        raise UsageError(f"{recording}: a recording is wanted here; the filter of this name is now called {new}: --filter {new}")
    chosen = {"navigation_frame": frame} | parse_settings(settings)
    refuse_overwriting([out], [recording, calibration])
    data = read(recording, mag_unit=mag_unit)
    if calibration is not None:
        data = read_calibration(calibration).apply_to(data)
    with bar() as progress:
        task = progress.add_task(data.name, total=len(data.t_s))

        def show(done: int, total: int) -> None:
            progress.update(task, completed=done, total=total)

        result = run_recording(data, filter, engine, chosen, preset, step, show, smooth)
    write_csv(out, result)
    counts = ", ".join(f"{name} {n}" for name, n in result.counts.items() if n)
    say(f"{len(result.t_s)} rows to {out}; {result.us_per_sample:.2f} us/sample by {engine}; {counts}")
    for warning in warnings(result):
        say(warning)


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


def cure(finding: Finding) -> str:
    """What to do about a sensor in this state."""
    return {
        "late": "give --set horizon_s=..., a little above the latest delay",
        "outlier": f"look at cable and supply; if the body moves so, give a larger --set {OUTLIERS.get(finding.sensor, '')}=...",
        "stuck": "look at cable and driver; a body that lies still does not count",
        "saturated": f"give --set {RANGES[finding.sensor]}=..., or use a sensor with a wider range",
        "missing": "look for rows without its samples",
    }[finding.state]


def write_csv(path: Path, result: Result) -> None:
    table = np.column_stack([
        result.t_s, result.q_nb, np.degrees(result.euler_rad), np.degrees(result.gyro_bias_rad_s),
        np.degrees(result.sigma_rad), np.degrees(result.gyro_bias_sigma_rad_s), result.health,
    ])  # fmt: skip
    text = io.StringIO()
    np.savetxt(text, table, fmt="%.9g", delimiter=",", header=CSV_HEADER, comments="")
    write_files({path: text.getvalue()})
