"""Readers of recordings: what a file is, is found by its content, never by its name.

    hnav.read("walk.zip")               # whatever it is
    hnav.read("log.csv", accel_unit="g", columns={"gx": "rate 1"})

Each family of formats has a module; FORMATS lists them, and the first that recognises a file reads it.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from hnav.io.aids import AidsOfFile
from hnav.io.readers.aids import LEFT_OUT, NO_POSITIONS
from hnav.io.readers.clock import DAMAGED, MENDED, ORDERED
from hnav.io.readers.formats import FORMATS, reader_of
from hnav.io.readers.streams import Raw, Wishes, aids_of, recording_of, refuse_unused_names
from hnav.io.readers.tables import raw_of, table_of
from hnav.io.recordings import ORDER, Recording, RecordingError

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["FORMATS", "from_dataframe", "read", "read_aids"]


def read(
    path: str | Path,
    *,
    format: str | None = None,
    columns: Mapping[str, str] | None = None,
    gyro_unit: str | None = None,
    accel_unit: str | None = None,
    mag_unit: str | None = None,
    time_unit: str | None = None,
    rate_hz: float | None = None,
    axes: Mapping[str, str] | None = None,
    drop_repeats: bool = False,
    fixes_late_s: float = 0.0,
) -> Recording:
    """A recording in SI units: a table in text, a folder or zip of tables, a log of PX4 or ROS, Parquet, a trial of BROAD.

    path: file or folder. format: one of FORMATS, for a content that is not recognised. columns: role (t_s, gx to mz, lat_deg, ...) to
    the name of its column, before which a minus negates; of a bag, imu, mag and gnss to their topics. gyro_unit (rad/s, deg/s, mdeg/s),
    accel_unit (m/s2, g, mg), mag_unit (T, uT, nT, G, mG, au), time_unit (s, ms, us, ns): go before what the file says.
    rate_hz: samples are at equal intervals, whatever their times are. axes: by gyro, accel or mag which axes of the file are
    x, y and z, such as {"mag": "y,x,-z"}. drop_repeats: a sample that equals the previous one of its sensor is dropped; for files
    that repeat the last field until a new one is measured. fixes_late_s: by so much the times of positions and velocities are too
    late, of a logger that stamps them when they arrive; hnav.io.plausible_aids.check_aids measures it.

    Nothing is resampled: sensors of different rates keep their times. Raises RecordingError, a line that says what is wrong,
    where, and what to do.
    """
    if not isinstance(path, (str, os.PathLike)):
        cure = f": {ORDER} takes arrays" if hasattr(path, "shape") else ""
        cure = ": Recording.from_dataframe takes tables of pandas" if hasattr(path, "columns") else cure
        raise RecordingError(f"path is no file or folder but a {type(path).__name__}{cure}", "path")
    path = Path(path)
    wishes = Wishes(columns or {}, gyro_unit, accel_unit, mag_unit, time_unit, rate_hz, axes or {}, drop_repeats, fixes_late_s)
    return recording_of(path.stem, str(path), _raw(path, format, wishes), wishes)


def read_aids(
    path: str | Path,
    *,
    format: str | None = None,
    columns: Mapping[str, str] | None = None,
    time_unit: str | None = None,
    drop_repeats: bool = False,
    fixes_late_s: float = 0.0,
) -> AidsOfFile:
    """Aiding samples of a separate file, by kind: a table, NMEA, a log of PX4 or ROS, a solution of RTKLIB. Arguments as of read.

    In a table with the column received_s, received_s is the arrival and t_s the validity of each row; rows may be in any order.
    Raises RecordingError, for a file without any too.
    """
    path = Path(path)
    wishes = Wishes(columns or {}, time_unit=time_unit, drop_repeats=drop_repeats, fixes_late_s=fixes_late_s, only_aids=True)
    raw = _raw(path, format, wishes)
    refuse_unused_names(str(path), raw, wishes)
    found = AidsOfFile(aids_of(raw, wishes))
    warned = (NO_POSITIONS, MENDED, ORDERED, DAMAGED)
    inferred = (f"times in {raw.time_unit}",) if raw.time_unit.is_inferred else ()
    found.notes = tuple(note if note.startswith(warned) else f"{path.name}: {note}" for note in (*inferred, *raw.notes))
    if not found:
        left_out = next((f"{note}; " for note in raw.notes if note.startswith(tuple(LEFT_OUT.values()))), "")
        raise RecordingError(
            f"{path}: {left_out}no position (lat_deg, lon_deg, alt_m), velocity (vn, ve, vd), pressure (pressure_pa), speed (speed_m_s) "
            "or heading (antenna_heading_deg): name its columns by columns lat_deg=NAME"
        )
    return found


def _raw(path: Path, format: str | None, wishes: Wishes) -> Raw:
    try:
        return reader_of(path, format)(path, wishes)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read: {(error.strerror or str(error)).lower()}") from None


def from_dataframe(
    frame: pd.DataFrame,
    name: str = "table",
    *,
    columns: Mapping[str, str] | None = None,
    gyro_unit: str | None = None,
    accel_unit: str | None = None,
    mag_unit: str | None = None,
    time_unit: str | None = None,
    rate_hz: float | None = None,
    axes: Mapping[str, str] | None = None,
    drop_repeats: bool = False,
    fixes_late_s: float = 0.0,
) -> Recording:
    """A recording from a table of pandas; arguments as of read. Raises RecordingError."""
    wishes = Wishes(columns or {}, gyro_unit, accel_unit, mag_unit, time_unit, rate_hz, axes or {}, drop_repeats, fixes_late_s)
    return recording_of(name, name, raw_of(name, table_of(frame, name, wishes), wishes), wishes)
