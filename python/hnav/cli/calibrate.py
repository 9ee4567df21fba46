"""hnav calibrate: a magnetometer from a recording while it is turned; with --sensor all sensors, from one with rests in many attitudes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.table import Table

from hnav.cli.console import say, show
from hnav.cli.parameters import Strict, page_option, with_groups
from hnav.cli.recordings import Reading, warn, warnings_of
from hnav.cli.words import UsageError, finding_line
from hnav.errors import HnavError
from hnav.filters.calibration import MagnetometerCalibration, calibrate_magnetometer
from hnav.io.findings import Finding
from hnav.io.outputs import refuse_overwriting
from hnav.io.recordings import Recording
from hnav.io.sensors import write_sensor
from hnav.units import G_M_S2, TESLA_PER

UNCALIBRATED = ("strength", "sign")  # findings that an uncalibrated magnetometer may cause


@with_groups
def command(
    recording: Annotated[
        Path, typer.Argument(help="Recording of the sensor being turned about all axes, in the formats of hnav filter")
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.json", help="Write the magnetometer's calibration into this sensor file, for hnav filter --sensor"
        ),
    ] = None,
    picture: Annotated[Path | None, typer.Option(metavar="FILE.png", help="Draw the field before and after")] = None,
    allow_hard_iron_only: Annotated[
        bool, typer.Option("--allow-hard-iron-only", help="Where the motion is too poor, answer with the offset alone")
    ] = False,
    sensor: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.json",
            help="Calibrate accelerometer and gyroscope too, from rests in nine or more attitudes, into this file",
        ),
    ] = None,
    report: Annotated[Path | None, page_option("With --sensor: page of figures and attitudes, and which one is missing")] = None,
    gravity: Annotated[float, typer.Option(metavar="M/S2", help="With --sensor: of the place")] = G_M_S2,
    *,
    reading: Reading,
    strict: Strict = False,
) -> None:
    refuse_overwriting([out, picture, sensor, report], [recording])
    data = reading.read(recording)
    if sensor is None:
        if report is not None:
            raise UsageError(f"--report {report}: is of --sensor FILE.json; of a magnetometer alone there is --picture")
        found = [finding for finding in reading.check(data) if matters(finding)]
        if wrong := [finding_line(finding) for finding in found if finding.code == "axes" and finding.certain]:
            raise UsageError(f"{recording}: {wrong[0]}: a calibration would take this for soft iron")
        warnings = warnings_of(recording, found, strict)
        calibrate_field(recording, data, out, picture, allow_hard_iron_only)
        warn(warnings)
        return
    if out is not None or picture is not None or allow_hard_iron_only:
        raise UsageError("--sensor: the file takes the magnetometer too: leave --out, --picture and --allow-hard-iron-only out")
    from hnav.cli.sensor_calibration import calibrate_whole

    warned = warnings_of(recording, [finding for finding in reading.check(data) if finding.code not in UNCALIBRATED], strict)
    calibrate_whole(data, sensor, report, gravity)
    warn(warned)


def calibrate_field(recording: Path, data: Recording, out: Path | None, picture: Path | None, allow_hard_iron_only: bool) -> None:
    """The magnetometer alone. Raises HnavError or UsageError."""
    if data.field_b_tesla is None:
        raise UsageError(f"{recording}: has no magnetometer")
    unit = data.mag_unit()  # results are in the unit of the file
    field = data.field_b_tesla / TESLA_PER[unit]
    try:
        found = calibrate_magnetometer(field, data.force_b_m_s2, unit, allow_hard_iron_only=allow_hard_iron_only)
    except HnavError as error:
        if error.status != "ill-conditioned":
            raise
        hint = "; a recording of rests in many attitudes is for --sensor FILE.json"
        if not allow_hard_iron_only:
            hint += ", and --allow-hard-iron-only answers with the offset alone where that is determined"
        raise UsageError(f"{recording}: {error}{hint}") from None
    if out is not None:
        write_sensor(out, {"mag": found.correction}, data.name)
    if picture is not None:
        # Loading Matplotlib takes longer than all other work here.
        from hnav.reports.calibration_picture import draw_calibration
        from hnav.reports.plots import save

        save(draw_calibration(field, found, data.name), picture)
    show(calibration_table(found, data.name))
    where = ", in the plane of the field alone" if found.offset_axes < 3 else ""
    say(f"{found.fit}{where}: {found.note}" if found.fit == "hard iron only" else found.note)


def matters(finding: Finding) -> bool:
    """Whether a finding is about samples that a calibration uses: force and field, which may have hard iron; not rates."""
    return finding.sensor in ("accel", "mag") and finding.code not in UNCALIBRATED


def calibration_table(found: MagnetometerCalibration, name: str) -> Table:
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
        ("uncertainty", "-" if np.isnan(found.direction_sigma_rad) else f"{np.degrees(found.direction_sigma_rad):.2f} deg", "error of the corrected direction over the whole sphere; nine of ten calibrations err less"),
        ("outliers", f"{100 * found.outlier_fraction:.1f} %", f"of {found.used_samples} attitudes in {found.samples} samples; {found.force_samples} with gravity"),
        ("coverage", f"{found.coverage:.2f}", "1: all directions alike, 0: in a plane"),
        ("largest gap", f"{np.degrees(found.gap_rad):.0f} deg", f"around ({', '.join(f'{v:.2f}' for v in found.gap_direction)}): no sample of the corrected field points there"),
        ("condition", f"{found.condition:.0f}, ambiguity {found.ambiguity:.3f}", "full fit up to 1000 and 0.1"),
        ("axis ratio", f"{found.axis_ratio:.3f}" if found.fit != "hard iron only" else "-", "longest over shortest axis of the ellipsoid"),
    ]  # fmt: skip
    for row in rows:
        table.add_row(*row)
    return table
