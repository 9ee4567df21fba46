"""Exports of telephones and of small sensors: a folder or a zip with a CSV for each sensor, each at its own rate.

Sensor Logger writes time (ns since 1970), seconds_elapsed, z, y, x: rad/s, m/s2, microtesla. Of Android, Accelerometer.csv is
without gravity and TotalAcceleration.csv with it; of iOS, gravity is in Gravity.csv, and both have the opposite sign unless the
app standardises its axes (Metadata.csv). phyphox writes "Time (s)","Gyroscope x (rad/s)",... MetaBase writes a sensor's name
among others in that of the file, and "epoch (ms)","x-axis (deg/s)",...
"""

from __future__ import annotations

import csv
import io
import zipfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from hnav.io.aids import AidSamples
from hnav.io.readers.aid_columns import ABOVE_ELLIPSOID
from hnav.io.readers.frames import raw_of_tables, sensor_stream
from hnav.io.readers.packed import NO_ZIP, ZIP_MAGIC, members_of
from hnav.io.readers.streams import Raw, Stream, Wishes
from hnav.io.readers.tables import NEGATED, Table, parse, with_gravity
from hnav.io.recordings import RecordingError

# Names of the files of a sensor in these apps, best first; small letters, without blanks.
FILES = {
    "gyro": ("gyroscope", "gyro", "gyroscopeuncalibrated"),
    "accel": ("totalacceleration", "accelerometeruncalibrated", "accelerometer", "acceleration", "acc", "accel",
              "linearaccelerometer", "linearacceleration"),
    "mag": ("magnetometer", "magneticfield", "mag", "magnetometeruncalibrated"),
}  # fmt: skip
# In a longer file name, only these words identify the sensor.
WITHIN = {"gyro": "gyroscope", "accel": "accelerometer", "mag": "magnetometer"}
AID_FILES = (("location", "gps"), ("barometer", "pressure"))
UNITS = {"gyro": "rad/s", "accel": "m/s2", "mag": "uT"}  # of both apps


def is_phone_export(path: Path, head: bytes) -> bool:
    """Whether a folder, or a zip, holds a CSV of a gyroscope and of an accelerometer."""
    try:
        names = [p.name for p in path.glob("*.csv")] if path.is_dir() else _members(path) if head.startswith(ZIP_MAGIC) else []
    except NO_ZIP:
        return False
    return {_sensor_of(name) for name in names} >= {"gyro", "accel"}


def _members(path: Path) -> list[str]:
    with zipfile.ZipFile(path) as archive:
        return [name for name in archive.namelist() if name.lower().endswith(".csv")]


def read_phone(path: Path, wishes: Wishes) -> Raw:
    """The best file of each sensor. Raises RecordingError."""
    files = _files(path)
    tables = {stem: data for stem, data in files.items() if _sensor_of(stem)}
    if not tables:
        inside = ", ".join(sorted(files)[:8]) or "no CSV"
        raise RecordingError(f"{path}: holds no Gyroscope.csv, Accelerometer.csv or Magnetometer.csv, but {inside}")
    chosen = {sensor: stem for sensor in FILES if (stem := _best(path, sensor, tables))}
    read = {stem: _parsed(path, stem, files, wishes, sensor) for sensor, stem in chosen.items()}
    aiding, left_out = _aiding(path, files, wishes)
    there = {f"{stem}.csv": table.layout.names for stem, table in read.items()}
    raw = raw_of_tables(str(path), {**read, **aiding}, there, wishes, _app(read), UNITS)
    streams = []
    for stream in raw.streams:
        if stream.sensor == "accel":
            stream = _whole_force(path, chosen["accel"], stream, files, wishes)
        streams.append(stream)
    return replace(raw, streams=streams, notes=(*raw.notes, *left_out), aids=_above_sea(raw, aiding))


def _app(tables: Mapping[str, Table]) -> str:
    """The app that writes such files."""
    if any("seconds_elapsed" in name for table in tables.values() for name in table.layout.names):
        return "sensor-logger"
    return "phyphox" if any(stem in names for names in FILES.values() for stem in tables) else "folder"


def _above_sea(raw: Raw, aiding: Mapping[str, Table]) -> dict[str, AidSamples]:
    """Of phyphox heights are corrected by the geoid, where their name does not state the ellipsoid: https://phyphox.org/wiki"""
    heights = [table.columns["alt_m"].name for table in aiding.values() if "alt_m" in table.columns]
    corrected = raw.format == "phyphox" and not any(map(ABOVE_ELLIPSOID.search, heights))
    return {kind: replace(one, above_sea=True) if corrected and kind == "position" else one for kind, one in raw.aids.items()}


def _aiding(path: Path, files: Mapping[str, bytes], wishes: Wishes) -> tuple[dict[str, Table], list[str]]:
    """Tables of satellites and barometer, and notes on unreadable ones, which do not refuse the rest."""
    found, left_out = {}, []
    for names in AID_FILES:
        if stem := next((name for name in names if name in files), None):
            try:
                found[stem] = parse(f"{path}, {stem}.csv", files[stem], replace(wishes, only_aids=True))
            except RecordingError as error:
                left_out.append(f"left out: {error}")
    return found, left_out


def _whole_force(path: Path, stem: str, stream: Stream, files: Mapping[str, bytes], wishes: Wishes) -> Stream:
    """Samples of iOS in the convention of Android, and notes on the conversion."""
    rows = csv.DictReader(io.StringIO(files.get("metadata", b"").decode("utf-8-sig", "replace")))
    negated = negates(next(rows, {}))
    if stem == "accelerometeruncalibrated" and negated:
        note = f"accel: {NEGATED.removeprefix(', ')}"
        return replace(stream, values=-stream.values, unit=wishes.unit("accel", by_format="g"), notes=(note,))
    if stem == "accelerometer" and "gravity" in files:
        gravity, *_ = sensor_stream(
            f"{path}, gravity.csv", _parsed(path, "gravity", files, wishes, "accel"), "accel", wishes, UNITS
        )
        return joined_with_gravity(stream, gravity, negated)
    return stream


def joined_with_gravity(rest: Stream, gravity: Stream, negated: bool) -> Stream:
    """The whole force of an app that writes gravity and the remainder separately."""
    common, mine, its = np.intersect1d(rest.t_s, gravity.t_s, return_indices=True)
    if len(common) < 0.9 * len(rest.t_s):
        return rest
    joined = replace(rest, t_s=common, values=rest.values[mine])
    return with_gravity(joined, gravity.values[its], "accelerometer and gravity", negated)


def negates(metadata: Mapping[Any, Any]) -> bool:
    """Whether the metadata of Sensor Logger name iOS and axes that were not standardised."""
    row = {str(key).strip().lower(): str(value).strip().lower() for key, value in metadata.items()}
    return row.get("platform") == "ios" and row.get("standardisation", "false") != "true"


def _parsed(path: Path, stem: str, files: Mapping[str, bytes], wishes: Wishes, sensor: str | None = None) -> Table:
    return parse(f"{path}, {stem}.csv", files[stem], wishes, sensor or _sensor_of(stem))


def _sensor_of(name: str) -> str | None:
    stem = _stem(name)
    if exact := next((sensor for sensor, names in FILES.items() if stem in names), None):
        return exact
    within = [sensor for sensor, word in WITHIN.items() if word in stem]
    return within[0] if len(within) == 1 else None


def _best(path: Path, sensor: str, tables: Mapping[str, bytes]) -> str | None:
    """The file of a sensor. Raises RecordingError when two may be it."""
    if exact := next((name for name in FILES[sensor] if name in tables), None):
        return exact
    longer = [stem for stem in tables if _sensor_of(stem) == sensor]
    if len(longer) > 1:
        raise RecordingError(f"{path}: {longer[0]}.csv and {longer[1]}.csv may both be the {sensor}: leave one of them out")
    return next(iter(longer), None)


def _stem(name: str) -> str:
    return "".join(c for c in Path(name).name.removesuffix(".csv").lower() if c.isalnum())


def _files(path: Path) -> dict[str, bytes]:
    """Every CSV of a folder or zip by its name in small letters. Raises RecordingError."""
    if path.is_dir():
        return {_stem(p.name): p.read_bytes() for p in sorted(path.glob("*.csv"))}
    return {_stem(name): content for name, content in members_of(path, ".csv")}
