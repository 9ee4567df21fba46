"""Text that sketches print to a serial port: names with numbers, on one line or several, perhaps after the time of a terminal.

Acceleration X: 0.52, Y: 0.04, Z: 9.85 m/s^2      (Adafruit MPU6050; Rotation X: ... rad/s)
Accl:   x= 0.10 |   y= 0.02 |   z= 9.81           (Adafruit BNO055)
12:34:56.789 -> gx:0.1,gy:0.2,gz:0.3,ax:0,ay:0,az:1
Acc (mg) [ 12.3, -4.5, 998.1 ], Gyr (DPS) [ 0.1, 0.2, 0.3 ]      (SparkFun ICM-20948)
[1234] w=(0.1, 0.2, 0.3) deg/s, a=(0, 0, 9.8) m/s2
a/g:    -236    -156    16452   -20     80      -15   (i2cdevlib: counts)
$VNIMU,+0.2310,-0.1052,+0.4301,+0.213,-0.054,-9.801,+0.000123,-0.000456,+0.001002,+25.0,+101.3*5C      (VectorNav; also VNMAR, VNYMR, VNQMR)
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from hnav.io.readers.columns import column_of
from hnav.io.readers.frames import raw_of_frames
from hnav.io.readers.nmea import has_checksum
from hnav.io.readers.streams import Raw, Wishes
from hnav.io.readers.tables import encoding_of
from hnav.io.recordings import RecordingError

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
PAIR = re.compile(rf"([A-Za-z][\w /.()\[\]-]{{0,40}}?)\s*[:=]\s*({NUMBER})(?![\d.:])")
STAMP = re.compile(r"^\s*\[?(?:(\d{4}-\d\d-\d\d)[ T])?(\d{1,2}:\d\d:\d\d(?:[.,]\d+)?)\]?\s*(?:->|[:,>|\t ])\s*")
PREFIX = re.compile(r"^\s*([A-Za-z]\w{1,20})\s*[:\t ]\s*(?=[xX]\s*[:=])")
COUNTS = re.compile(rf"^\s*(?:a/g|a/g/m)\s*:\s*((?:{NUMBER}[\s,]*){{6,9}})$")
VECTORNAV = re.compile(r"\s*(?:(\d+\.?\d*)[,;\s]+)?\$(VN(IMU|MAR|YMR|QMR),[-+\d.,]+)\*([0-9A-Fa-f]{2})")
BEFORE = {"IMU": 0, "MAR": 0, "YMR": 3, "QMR": 4}
"""Numbers of an attitude before those of the sensors."""
OF_VECTORNAV = [f"{role}{axis} ({unit})" for role, unit in (("m", "G"), ("a", "m/s2"), ("g", "rad/s")) for axis in "xyz"]
UNIT = r"(?:rad|deg|°|m|g|uT|µT|dps)[^\s,|;:=\])]*(?:\s*\^?s[^\s,|;:=\])]*)?"
TRIPLE = re.compile(
    rf"([A-Za-z][\w ]{{0,30}}?)\s*(?:\(([^()]{{1,10}})\))?\s*(?:[:=]\s*[\[(<]?|[\[(<])\s*({NUMBER})\s*[,;\t ]\s*({NUMBER})\s*[,;\t ]\s*"
    rf"({NUMBER})(?![\d.:])(?:\s*[\])>])?(?:\s*({UNIT})(?=[\s,;|\])]|$))?"
)
"""A name, a unit in brackets, three numbers, and a unit behind them."""
UNIT_BEHIND = re.compile(rf"[\d.]\s*({UNIT})\s*$")
COUNTER = re.compile(r"^\s*\[(\d+(?:\.\d*)?)\]\s*")
"""millis() before a line."""
HEAD_LINES, LEAST_SHARE = 60, 0.3
NOT_SENSORS = ("orient", "euler", "rot", "quat", "linear", "gravity", "temp", "calib")
CLOCK = "time (s)"  # of the terminal
DAY_S = 86400.0


def is_serial_text(path: Path, head: bytes) -> bool:
    """Whether a good part of the first lines names numbers of a sensor."""
    if b"\0" in head:
        return False
    lines = [line for line in head.decode("utf-8", "replace").splitlines()[:HEAD_LINES] if line.strip()]
    hits = sum(1 for line in lines if _pairs(line)[1])
    return hits >= 2 and hits >= LEAST_SHARE * len(lines)


def read_serial_text(path: Path, wishes: Wishes) -> Raw:
    """Raises RecordingError for lines without times, without a given rate."""
    import pandas

    data = path.read_bytes()
    frame = pandas.DataFrame([*_rows(data.decode(encoding_of(str(path), data), "replace"))])
    frame = frame.dropna(axis=1, thresh=max(2, len(frame) // 4))
    known = {name: column.role for name in frame.columns if (column := column_of(name, 0)) is not None}
    if "t_s" not in known.values() and wishes.rate_hz is None:
        cure = "give rate_hz, how many are written in a second; or print millis() as t_ms in each"
        raise RecordingError(f"{path}: the lines have no times: {cure}")
    frame = frame.dropna(subset=[*known])
    return raw_of_frames(str(path), {"lines": frame.reset_index(drop=True)}, wishes, "serial")


def _rows(text: str) -> Iterator[dict[str, float]]:
    """Groups lines until a name repeats."""
    row: dict[str, float] = {}
    last_s, days = -np.inf, 0
    for line in text.splitlines():
        stamp = STAMP.match(line)
        pairs, _ = _pairs(line)
        if not pairs:
            continue
        if row.keys() & pairs.keys():
            yield row
            row = {}
        if stamp is not None and CLOCK not in row:
            hours, minutes, seconds = stamp.group(2).replace(",", ".").split(":")
            clock_s = 3600 * int(hours) + 60 * int(minutes) + float(seconds)
            days += clock_s < last_s - DAY_S / 2
            last_s = clock_s
            row[CLOCK] = clock_s + days * DAY_S
        row |= pairs
    if row:
        yield row


def _pairs(line: str) -> tuple[dict[str, float], bool]:
    """Numbers by the names of columns that they would have, and whether one of these is more than a time."""
    stamp = STAMP.match(line)
    body = line[stamp.end() :] if stamp else line
    if (sentence := of_vectornav(body)) is not None:
        return sentence, bool(sentence)
    if counted := COUNTS.match(body):
        numbers = [float(text) for text in re.findall(NUMBER, counted.group(1))]
        return {f"{'agm'[i // 3]}{'xyz'[i % 3]} (LSB)": number for i, number in enumerate(numbers)}, True
    unit = behind.group(1) if (behind := UNIT_BEHIND.search(body)) else ""
    counter = COUNTER.match(body)
    found = {"time": float(counter.group(1))} if counter else {}
    found |= _triples(body, unit) | _named_numbers(TRIPLE.sub("", body), PREFIX.match(body), unit)
    roles = {name: column.role for name in found if (column := column_of(name, 0)) is not None}
    return {name: found[name] for name in roles}, any(role != "t_s" for role in roles.values())


def of_vectornav(line: str) -> dict[str, float] | None:
    """Field, force and rate of a sentence, by names of columns, and the time that a logger wrote before it; empty where the checksum is
    wrong, None for another line."""
    if (sentence := VECTORNAV.match(line)) is None:
        return None
    logged, body, kind, checksum = sentence.groups()
    numbers = body.split(",")[1 + BEFORE[kind] :]
    if not has_checksum(body, checksum) or len(numbers) < len(OF_VECTORNAV):
        return {}
    time = {"time": float(logged)} if logged else {}
    return time | dict(zip(OF_VECTORNAV, map(float, numbers)))


def _with_unit(name: str, unit: str) -> str:
    return f"{name} ({unit})" if unit else name


def _triples(body: str, unit: str) -> dict[str, float]:
    """G: 0.1, 0.2, 0.3 deg/s"""
    found: dict[str, float] = {}
    for name, before, *three, behind in TRIPLE.findall(body):
        if not name.lower().startswith(NOT_SENSORS):
            stated = before or behind or unit
            found |= {_with_unit(f"{name.strip()} {axis}", stated): float(number) for axis, number in zip("xyz", three)}
    return found


def _named_numbers(body: str, prefix: re.Match[str] | None, unit: str) -> dict[str, float]:
    """Accel X: 0.1, Y: 0.2; axes that stand alone belong to the sensor before them."""
    sensor = prefix.group(1) if prefix else ""
    found: dict[str, float] = {}
    for name, number in PAIR.findall(body):
        name = name.strip(" |,\t")
        if prefix or (len(name) == 1 and sensor):
            name = f"{sensor} {name[-1]}"
        elif len(name.split()) > 1:
            sensor = " ".join(name.split()[:-1])
        if sensor.lower().startswith(NOT_SENSORS) and not _is_rate(sensor, unit):
            continue
        name = re.sub(r"(?i)^rotation", "gyro", name)
        found[_with_unit(name, unit) if name[-1:] in "xyzXYZ" else name] = float(number)
    return found


def _is_rate(sensor: str, unit: str) -> bool:
    """Adafruit calls rates Rotation; angles are called so too."""
    return sensor.lower().startswith("rotation") and ("/s" in unit or "dps" in unit)
