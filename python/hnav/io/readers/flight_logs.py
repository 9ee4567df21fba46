"""Logs of flight controllers besides PX4: ArduPilot's dataflash (.bin, .log, by pymavlink) and Betaflight's blackbox as CSV.

ArduPilot: https://ardupilot.org/copter/docs/logmessages.html; TimeUS in us, IMU in rad/s and m/s2, MAG in milligauss. Betaflight's
blackbox_decode and Blackbox Explorer: time in us, gyroADC in deg/s, accSmooth in counts of which acc_1G are 1 g.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from hnav.io.aids import AidSamples
from hnav.io.readers.aids import along, whole
from hnav.io.readers.streams import Raw, Stream, Wishes, cannot_be_read, library
from hnav.io.readers.tables import encoding_of, parse, raw_of
from hnav.io.recordings import ARRAYS, RecordingError

DATAFLASH = b"\xa3\x95"
ARDUPILOT = {"gyro": ("Gyr", "rad/s"), "accel": ("Acc", "m/s2"), "mag": ("Mag", "mG")}
# The first message type that a log has is taken, of its first instance; filtered before raw.
MESSAGES = {"gyro": ("IMU", "GYR", "GYR1"), "accel": ("IMU", "ACC", "ACC1"), "mag": ("MAG",)}
AIDS = ("GPS", "GPA", "BARO")
FIX_3D = 3


def is_ardupilot(path: Path, head: bytes) -> bool:
    return head.startswith(DATAFLASH) or re.match(rb"\s*(FMT|PARM|IMU|MSG), ?\d", head) is not None


def read_ardupilot(path: Path, wishes: Wishes) -> Raw:
    """Raises RecordingError."""
    library("pymavlink", "logs", str(path))
    try:
        rows = _messages(path, {*(name for names in MESSAGES.values() for name in names), *AIDS})
        streams = [stream for sensor in ARRAYS if (stream := _stream(rows, sensor, wishes))]
        aids = _satellites(rows) | _pressure(rows)
    except Exception as error:  # pymavlink raises errors of any type for a damaged file
        raise cannot_be_read(path, error) from None
    missing = [sensor for sensor in ("gyro", "accel") if sensor not in {stream.sensor for stream in streams}]
    if missing and not wishes.only_aids:
        raise RecordingError(f"{path}: has no message IMU, GYR or ACC: log it (LOG_BITMASK, IMU)")
    return Raw("ardupilot", streams, wishes.unit("time", by_format="us"), aids=aids, names=())


def _messages(path: Path, wanted: set[str]) -> dict[str, list[dict[str, Any]]]:
    """The messages of the first instance, by name."""
    from pymavlink import DFReader

    with path.open("rb") as file:
        binary = file.read(2) == DATAFLASH
    log = (DFReader.DFReader_binary if binary else DFReader.DFReader_text)(str(path))
    rows: dict[str, list[dict[str, Any]]] = {}
    while (message := log.recv_match(type=sorted(wanted))) is not None:
        row = message.to_dict()
        if row.get("I", 0) == 0 and "TimeUS" in row:
            rows.setdefault(message.get_type(), []).append(row)
    return rows


def _column(rows: list[dict[str, Any]], name: str) -> np.ndarray:
    return np.array([row.get(name, np.nan) for row in rows], float)


def _stream(rows: dict[str, list[dict[str, Any]]], sensor: str, wishes: Wishes) -> Stream | None:
    prefix, unit = ARDUPILOT[sensor]
    for name in MESSAGES[sensor]:
        if name in rows and prefix + "X" in rows[name][0]:
            values = np.stack([_column(rows[name], prefix + axis) for axis in "XYZ"], axis=1)
            return Stream(sensor, 1e-6 * _column(rows[name], "TimeUS"), values, wishes.unit(sensor, by_format=unit))
    return None


def _satellites(rows: dict[str, list[dict[str, Any]]]) -> dict[str, AidSamples]:
    """GPS has position and velocity, GPA of the same time their accuracy."""
    gps = [row for row in rows.get("GPS", ()) if row.get("Status", 0) >= FIX_3D]
    if not gps:
        return {}
    accuracy = {row["TimeUS"]: row for row in rows.get("GPA", ())}
    stated = [accuracy.get(row["TimeUS"], {}) for row in gps]
    t_s = 1e-6 * _column(gps, "TimeUS")
    undulation = _column(stated, "Und")  # height above sea less that above the ellipsoid; 0 where the receiver does not state it
    above_sea = not (np.isfinite(undulation) & (undulation != 0)).all()
    undulation = np.nan_to_num(undulation)
    place = np.stack([np.radians(_column(gps, "Lat")), np.radians(_column(gps, "Lng")), _column(gps, "Alt") - undulation], axis=1)
    velocity = along(_column(gps, "Spd"), np.radians(_column(gps, "GCrs")))
    velocity[:, 2] = _column(gps, "VZ")
    spread = np.stack([_column(stated, name) for name in ("HAcc", "HAcc", "VAcc")], axis=1)
    rate_spread = np.stack([_column(stated, "SAcc")] * 3, axis=1)
    position = AidSamples(t_s, place, spread, above_sea=above_sea)
    return whole({"position": position, "velocity": AidSamples(t_s, velocity, rate_spread)})


def _pressure(rows: dict[str, list[dict[str, Any]]]) -> dict[str, AidSamples]:
    baro = rows.get("BARO", [])
    if not baro:
        return {}
    read = _column(baro, "Press")[:, None]
    return {"pressure": AidSamples(1e-6 * _column(baro, "TimeUS"), read, np.full_like(read, np.nan))}


# --------------------------------------------------------------------------------------------- Betaflight

BLACKBOX = re.compile(rb'^[^\n]*"?gyroADC\[0\]"?[^\n]*$', re.MULTILINE)
ACC_1G = re.compile(rb'"?acc_1G"?\s*[,:]\s*"?(\d+)')
USUAL_1G = 2048  # of 16 bits at 16 g, as Betaflight sets its chips
RAW_LOG = b"H Product:Blackbox"


def is_betaflight(path: Path, head: bytes) -> bool:
    return BLACKBOX.search(head) is not None or RAW_LOG in head[:200]


def read_betaflight(path: Path, wishes: Wishes) -> Raw:
    """Raises RecordingError."""
    data = path.read_bytes()
    header = BLACKBOX.search(data)
    if header is None:
        raise RecordingError(
            f"{path}: a blackbox as the flight controller writes it: make a CSV by blackbox_decode or Blackbox Explorer"
        )
    header_1g = ACC_1G.search(data[: header.start()])
    count = int(header_1g.group(1)) if header_1g else USUAL_1G
    axes = {
        f"{name}[{i}]": f"{role}{axis}" for name, role in (("gyroADC", "g"), ("accSmooth", "a")) for i, axis in enumerate("xyz")
    }
    names = {"time": "t_s", **axes}
    there = [cell.strip().strip('"') for cell in header.group().decode("utf-8", "replace").split(",")]
    columns = {role: cell for cell in there for name, role in names.items() if cell == name or cell.startswith(f"{name} (")}
    text = data[header.start() :]
    encoding_of(str(path), text)
    table = parse(str(path), text, replace(wishes, columns=columns | dict(wishes.columns)))
    units = {"gyro": "deg/s", "accel": f"1/{count} g", "time": "us"}
    raw = raw_of(str(path), table, wishes, units, "betaflight")
    note = f"accel: {count} counts are 1 g, as {'the log says' if header_1g else 'is usual'}; accel_unit='1/512 g' for another"
    counted = any(stream.sensor == "accel" and stream.unit.source == "by format" for stream in raw.streams)
    return replace(raw, notes=(*raw.notes, note) if counted else raw.notes)
