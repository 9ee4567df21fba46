"""hnav calibrate --sensor: accelerometer, gyroscope and magnetometer of one recording into a sensor file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from rich.table import Table

from hnav.cli.console import load_pages, say, show, working, written
from hnav.cli.recordings import warn
from hnav.errors import HnavError
from hnav.filters.calibration import calibrate_magnetometer
from hnav.filters.sensor_calibration import SensorCalibration, calibrate_sensors
from hnav.io.recordings import Recording
from hnav.io.sensors import Correction, write_sensor
from hnav.units import G_M_S2

SHOWN = {"accel": ("mg", 1e-3 * G_M_S2), "gyro": ("deg/s", np.pi / 180), "mag": ("uT", 1e-6)}
"""Units of the offsets, in SI."""


def calibrate_whole(data: Recording, sensor: Path, report: Path | None, gravity_m_s2: float) -> None:
    """Writes the sensor file, keeping other entries of an existing one, and the page. Raises HnavError; the page then shows
    what is missing.
    """
    load_pages(report)
    try:
        with working(f"{data.name}: rests and turns"):
            found = calibrate_sensors(data, gravity_m_s2)
    except HnavError as error:
        if report is not None and error.status == "ill-conditioned":
            from hnav.reports.sensor_page import write_refusal

            write_refusal(data, str(error), report)
            say(str(report))
        raise
    made = {"accel": found.accel, "gyro": found.gyro} | field_of(data, found)
    write_sensor(sensor, made, data.name)
    if report is not None:
        from hnav.reports.sensor_page import write_sensor_report

        write_sensor_report(data.name, found, rows_of(made), report)
    show(figures_table(data.name, made))
    gap = f"largest gap between their directions {np.degrees(found.missing_rad):.0f} deg"
    say(f"{len(found.directions)} rests, {gap}; {written(sensor, report)}")


def field_of(data: Recording, found: SensorCalibration) -> dict[str, Correction]:
    """The magnetometer, aligned by the calibrated force; empty, with a warning, if it cannot be calibrated."""
    if data.field_b_tesla is None:
        return {}
    try:
        iron = calibrate_magnetometer(data.field_b_tesla, found.accel.apply(data.force_b_m_s2))
    except HnavError as error:
        warn([f"warning: the magnetometer is left out: {error}"])
        return {}
    say(f"magnetometer: {iron.fit}; {iron.note}")
    return {"mag": iron.correction}


def rows_of(made: dict[str, Correction]) -> list[list[str]]:
    """Sensor, figure, x, y, z with their sigmas, unit."""
    rows = []
    for sensor, one in made.items():
        unit, si = SHOWN[sensor]
        scale, spread = np.diag(one.matrix) - 1, np.diag(one.sigma_matrix)
        rows.append([sensor, "offset", *_cells(one.offset / si, one.sigma_offset / si), unit])
        rows.append([sensor, "scale", *_cells(100 * scale, 100 * spread), "%"])
        above = ([0, 0, 1], [1, 2, 2])
        for name, places in (("axes xy, xz, yz", above), ("axes yx, zx, zy", above[::-1])):
            angle, sigma = (np.degrees(array[places]) for array in (one.matrix, one.sigma_matrix))
            if angle.any():
                rows.append([sensor, name, *_cells(angle, sigma), "deg"])
    return rows


def _cells(values: np.ndarray, sigmas: np.ndarray) -> list[str]:
    return [f"{v:.4g} ± {s:.2g}" if np.isfinite(s) and s > 0 else f"{v:.4g}" for v, s in zip(values, sigmas)]


def figures_table(name: str, made: dict[str, Correction]) -> Table:
    """A row for each figure, with one sigma."""
    title = f"{name}: corrected = matrix (reading - offset)"
    table = Table("sensor", "figure", "x", "y", "z", "unit", title=title, title_justify="left")
    for row in rows_of(made):
        table.add_row(*row)
    return table
