"""A run as a file: CSV, or Parquet by the suffix.

    write_table("attitude.csv", run, ["recording walk.csv"])
    pandas.read_csv("attitude.csv", comment="#")

Angles are in deg, rates in deg/s, lengths in m; times are written in full: what is read back has their bits. The comments at the head say
what made the file: version, filter, and the options that differ from the preset.
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from hnav import __version__
from hnav.errors import HnavValueError
from hnav.filters.attitude_answers import Run, of_axes
from hnav.filters.filter_answers import HEALTH_SENSORS, SENSOR_STATES
from hnav.filters.ins_answers import PHASES, READY, InsRun
from hnav.filters.options import Options
from hnav.io.outputs import write_files
from hnav.native.arrays import Array

PARQUET = (".parquet", ".pq")
ROWS = 50_000  # rows that are formatted at once
ROW_GROUP = 2**17  # of Parquet
NOTES_OF_NAVIGATION = (
    "lat, lon in deg, alt in m above the ellipsoid; vn, ve, vd in m/s; roll, pitch, heading in deg, heading clockwise from north",
    "sigma_north, east, down in m, sigma_vn, ve, vd in m/s, sigma_about_north, about_east, heading in deg; biases in deg/s and m/s2",
    "protection: bounds of the errors in m and deg, exceeded for less than 1e-3 of the time",
    "q: scalar first, body to north-east-down; ready, at_rest: 1 or 0",
    f"phase: {', '.join(f'{number} {name}' for number, name in enumerate(PHASES))}",
)
"""Of the columns of an InsRun."""

Written = Run | InsRun
Columns = dict[str, np.ndarray]
Tables = list[tuple[Sequence[str], np.ndarray]]  # names of columns, and an array with as many


def columns(run: Written) -> Columns:
    """The columns of the file by name, each n long; numbers, and flags and phases as whole numbers."""
    tables = _of_navigation(run) if isinstance(run, InsRun) else _of_attitude(run)
    return {name: table[:, i] for names, table in tables for i, name in enumerate(names)}


def _of_attitude(run: Run) -> Tables:
    """tilt_deg is the angle between the body's z axis and the vertical. accel_accepted and mag_accepted are 1 where the gate let a
    sample pass as it was, 0 where not, NaN where there was none; all NaN in a run that did not ask for them.
    """
    return [
        (("t_s",), run.t_s[:, None]),
        (("q0", "q1", "q2", "q3"), run.q_nb),
        (("roll_deg", "pitch_deg", "yaw_deg"), np.degrees(run.euler_rad)),
        (("heading_deg", "tilt_deg"), np.degrees(np.stack([run.heading_rad % (2 * np.pi), _tilt_rad(run)], axis=1))),
        (of_axes("bias", "deg_s"), np.degrees(run.gyro_bias_rad_s)),
        (of_axes("sigma", "deg"), np.degrees(run.sigma_rad)),
        (of_axes("sigma_bias", "deg_s"), np.degrees(run.gyro_bias_sigma_rad_s)),
        (("tilt_ready", "heading_ready"), run.ready.astype(np.uint8)),
        (("accel_nis", "mag_nis"), np.stack([run.accel_nis, run.mag_nis], axis=1)),
        (("accel_accepted", "mag_accepted"), _accepted(run)),
        (tuple(f"{sensor}_health" for sensor in HEALTH_SENSORS), run.health),
    ]


def _of_navigation(run: InsRun) -> Tables:
    """Lengths in m, angles in deg."""
    angles = np.degrees(run.euler_rad)
    angles[:, 2] %= 360
    second = np.degrees(run.heading_second[:, 0]) % 360
    return [
        (("t_s",), run.t_s[:, None]),
        (("lat_deg", "lon_deg"), np.degrees(run.place[:, :2])),
        (("alt_m",), run.place[:, 2:]),
        (("vn", "ve", "vd"), run.velocity_n_m_s),
        (("roll", "pitch", "heading"), angles),
        ([f"sigma_{axis}" for axis in ("north", "east", "down")], run.sigma_position_m),
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


def _tilt_rad(run: Run) -> Array:
    """Angle of the body's z axis from the vertical, 0 to pi: 0 for a level body in both navigation frames."""
    w, x, y, z = run.q_nb.T
    tilt: Array = np.arctan2(2 * np.hypot(w, z) * np.hypot(x, y), w * w + z * z - x * x - y * y)
    return tilt


def _accepted(run: Run) -> Array:
    if run.accepted is None:
        return np.full((len(run.t_s), 2), np.nan)
    used = np.isfinite(np.stack([run.accel_nis, run.mag_nis], axis=1))
    return np.where(used, run.accepted.astype(float), np.nan)


def comments(run: Written, more: Sequence[str] = ()) -> list[str]:
    """Lines of the head of the file; more: lines of the caller."""
    notes = NOTES_OF_NAVIGATION if isinstance(run, InsRun) else _notes_of_attitude(run)
    return [f"hnav {__version__}", *more, *option_lines(run.options), *notes]


def _notes_of_attitude(run: Run) -> list[str]:
    frame = "" if run.options is None else f" ({run.options.navigation_frame})"
    return [
        f"q: scalar first, body to navigation{frame}; sigma_x, y, z: about the navigation axes; bias: body axes",
        "heading: clockwise from north; tilt: of body z from the vertical; ready, accepted: 1 or 0",
        f"health: {', '.join(f'{number} {name}' for number, name in enumerate(SENSOR_STATES))}",
    ]


def option_lines(options: Options | None) -> list[str]:
    """Lines of the head about the options of the filter."""
    if options is None:
        return []
    changed = ", ".join(f"{name}={value}" for name, value in options.changed().items()) or "none"
    return [f"filter {options.filter}, preset {options.preset}", f"options that differ from the preset: {changed}"]


def write_table(path: str | Path, run: Written, more: Sequence[str] = ()) -> None:
    """Writes the columns of a run with its comments, whole or not at all. Raises HnavError.

    more: lines for the head. Parquet needs pyarrow, and keeps the comments as metadata of the table under "hnav".
    """
    write_pieces(path, [run], more)


PRECISE = {"t_s": "%r", "lat_deg": "%.12g", "lon_deg": "%.12g"}
"""Columns that keep every digit: %r is the shortest text with the bits of the number."""


def write_pieces(path: str | Path, runs: Iterable[Written], more: Sequence[str] = ()) -> None:
    """Writes a run that comes in pieces, one or more, each the rows after those of the one before: the same file as write_table
    of the whole, if every piece but the last has a multiple of ROW_GROUP rows. What the making of a run raises leaves the old
    file. Raises HnavError."""
    runs = iter(runs)
    first, path = next(runs), Path(path)
    head = [line.replace("\n", " ") for line in comments(first, more)]
    made = (_parquet if path.suffix.lower() in PARQUET else _csv)(path, map(columns, chain([first], runs)), head)
    write_files({path: made})


def formats_of(table: Mapping[str, np.ndarray]) -> dict[str, str]:
    """Format of the numbers of each column."""
    formats = {name: "%d" if values.dtype.kind == "u" else "%.9g" for name, values in table.items()}
    return {name: PRECISE.get(name, text) for name, text in formats.items()}


def _csv(path: Path, pieces: Iterator[Columns], said: Sequence[str]) -> Iterator[bytes]:
    head = [f"# {text}" for text in said]
    for table in pieces:
        if head:
            yield "\n".join([*head, ",".join(table), ""]).encode()
            head = []
        line = ",".join(formats_of(table).values()) + "\n"
        # In parts: as Python objects the numbers take many times their memory.
        for begin in range(0, len(table["t_s"]), ROWS):
            rows = zip(*(values[begin : begin + ROWS].tolist() for values in table.values()))
            yield "".join([line % row for row in rows]).encode()


class _Sink(io.RawIOBase):
    """A buffer of the written bytes, until they are taken."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._size = 0

    def writable(self) -> bool:
        return True

    def write(self, data: Any) -> int:
        self._parts.append(bytes(data))
        self._size += len(self._parts[-1])
        return len(self._parts[-1])

    def tell(self) -> int:
        return self._size

    def taken(self) -> list[bytes]:
        parts, self._parts = self._parts, []
        return parts


def _parquet(path: Path, pieces: Iterator[Columns], said: Sequence[str]) -> Iterator[bytes]:
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise HnavValueError(
            "option", f"{path}: Parquet needs pyarrow: python -m pip install pyarrow (the extra 'logs')"
        ) from None
    sink, writer = _Sink(), None
    for columns_of_piece in pieces:
        table = pyarrow.table(columns_of_piece).replace_schema_metadata({"hnav": "\n".join(said)})
        writer = writer or parquet.ParquetWriter(sink, table.schema)
        writer.write_table(table, row_group_size=ROW_GROUP)
        yield from sink.taken()
    if writer:
        writer.close()
    yield from sink.taken()
