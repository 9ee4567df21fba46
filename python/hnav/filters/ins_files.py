"""A run of the navigation filter as a file: CSV, or Parquet by the suffix. Angles in deg, rates in deg/s, lengths in m."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import chain
from pathlib import Path

import numpy as np

from hnav import __version__
from hnav.filters.ins_answers import PHASES, READY, InsRun
from hnav.filters.run_files import option_lines, write_columns

AXES = ("north", "east", "down")


def columns(run: InsRun) -> dict[str, np.ndarray]:
    """The columns of the file by name, each n long; flags and phases are whole numbers."""
    angles = np.degrees(run.euler_rad)
    angles[:, 2] %= 360
    second = np.degrees(run.heading_second[:, 0]) % 360
    tables: list[tuple[Sequence[str], np.ndarray]] = [
        (("t_s",), run.t_s[:, None]),
        (("lat_deg", "lon_deg"), np.degrees(run.place[:, :2])),
        (("alt_m",), run.place[:, 2:]),
        (("vn", "ve", "vd"), run.velocity_n_m_s),
        (("roll", "pitch", "heading"), angles),
        ([f"sigma_{axis}" for axis in AXES], run.sigma_position_m),
        (("sigma_vn", "sigma_ve", "sigma_vd"), run.sigma_velocity_m_s),
        (("sigma_about_north", "sigma_about_east", "sigma_heading"), np.degrees(run.sigma_rotation_rad)),
        ([f"{name}_ready" for name in READY], run.ready.astype(np.uint8)),
        (("phase",), run.phase[:, None]),
        (("at_rest",), run.at_rest[:, None].astype(np.uint8)),
        (("heading_second",), second[:, None]),
        (("heading_second_share",), run.heading_second[:, 1:]),
        (("protection_horizontal", "protection_vertical"), run.protection_m),
        (("protection_heading",), np.degrees(run.protection_heading_rad)[:, None]),
        ([f"gyro_bias_{axis}" for axis in "xyz"], np.degrees(run.gyro_bias_rad_s)),
        ([f"accel_bias_{axis}" for axis in "xyz"], run.accel_bias_m_s2),
        (("q0", "q1", "q2", "q3"), run.q_nb),
    ]
    return {name: table[:, i] for names, table in tables for i, name in enumerate(names)}


def comments(run: InsRun, more: Sequence[str] = ()) -> list[str]:
    """Lines of the head of the file; more: lines of the caller."""
    return [
        f"hnav {__version__}",
        *more,
        *option_lines(run.options),
        "lat, lon in deg, alt in m above the ellipsoid; vn, ve, vd in m/s; roll, pitch, heading in deg, heading clockwise from north",
        "sigma_north, east, down in m, sigma_vn, ve, vd in m/s, sigma_about_north, about_east, heading in deg; biases in deg/s and m/s2",
        "protection: bounds of the errors in m and deg, exceeded for less than 1e-3 of the time",
        "q: scalar first, body to north-east-down; ready, at_rest: 1 or 0",
        f"phase: {', '.join(f'{number} {name}' for number, name in enumerate(PHASES))}",
    ]


def write_navigation(path: str | Path, runs: Iterable[InsRun], more: Sequence[str] = ()) -> None:
    """Writes a run that comes in one or more pieces, each the rows after those of the one before; whole or not at all.

    more: lines for the head. Raises HnavError.
    """
    runs = iter(runs)
    first = next(runs)
    write_columns(path, map(columns, chain([first], runs)), comments(first, more))
