"""Xsens: text exports of MT Manager and the DOT; binary files are refused with the remedy.

Of MT Manager: comment lines that begin with //; then tab-parted columns: PacketCounter (16 bits), SampleTimeFine (0.1 ms, 32 bits),
Acc_X.. in m/s2, Gyr_X.. in rad/s, Mag_X.. in an arbitrary unit that is 1 at Xsens. Of a DOT: the same columns, parted by commas,
SampleTimeFine in us and Gyr_X.. in deg/s (user manual, 4.2).
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from hnav.io.readers.streams import BY_RATE, Raw, Wishes
from hnav.io.readers.tables import Table, parse, raw_of
from hnav.io.recordings import RecordingError, Unit

UNITS = {"gyro": "rad/s", "accel": "m/s2", "mag": "au"}
UNITS_OF_DOT = {**UNITS, "gyro": "deg/s"}
HEAD_BYTES = 1 << 16
FINE_S, FINE_OF_DOT_S = 1e-4, 1e-6
# Between samples: a DOT gives 1 to 120 a second, and no tracker of MT Manager so few as five.
LEAST_TICKS_OF_DOT = 2000
COUNTERS = {"SampleTimeFine": 2**32, "PacketCounter": 2**16}
EXPORT = "export text from MT Manager (File, Export; in the export settings choose acceleration, rate of turn and magnetic field)"


def is_xsens_text(path: Path, head: bytes) -> bool:
    return b"\0" not in head and re.search(rb"^(PacketCounter|SampleTimeFine)\b", head, re.MULTILINE) is not None


def is_xsens_binary(path: Path, head: bytes) -> bool:
    return path.suffix.lower() in (".mtb", ".mvnx", ".mvn") or head.startswith(b"\xfa\xff") or b"<mvnx" in head


def refuse_binary(path: Path, wishes: Wishes) -> Raw:
    """Raises RecordingError that says how to get text."""
    with path.open("rb") as file:
        is_mvnx = b"<mvnx" in file.read(4096) or path.suffix.lower() in (".mvnx", ".mvn")
    if is_mvnx:
        raise RecordingError(
            f"{path}: a file of Xsens MVN, which holds a model of the body: record the trackers with MT Manager and {EXPORT}"
        )
    raise RecordingError(f"{path}: binary data of Xsens: {EXPORT}, and give hnav the .txt")


def read_xsens_text(path: Path, wishes: Wishes) -> Raw:
    """Times by SampleTimeFine, else by PacketCounter and the update rate of the comments; lost packets are gaps. A rate that the caller
    gives is that of the packets. Raises RecordingError."""
    data = path.read_bytes()
    text = data[:HEAD_BYTES].decode("utf-8-sig", "replace")
    fine = _counted(path, data, text, "SampleTimeFine", wishes)
    dot = fine is not None and float(np.median(np.diff(fine.values["t_s"]))) > LEAST_TICKS_OF_DOT
    units = UNITS_OF_DOT if dot else UNITS
    table = fine
    tick_s: float | None = FINE_OF_DOT_S if dot else FINE_S
    if table is None or wishes.rate_hz is not None:
        table = _counted(path, data, text, "PacketCounter", wishes)
        tick_s = _packet_s(text) if wishes.rate_hz is None else 1 / wishes.rate_hz
    if table is None or tick_s is None:
        return raw_of(str(path), parse(str(path), data, wishes), wishes, units, "xsens-text")
    made = replace(table, values={**table.values, "t_s": tick_s * table.values["t_s"]}, instants=True)
    raw = raw_of(str(path), made, replace(wishes, rate_hz=None), units, "xsens-text")
    return replace(raw, time_unit=BY_RATE if wishes.rate_hz else Unit("s", f"by {table.columns['t_s'].name}"))


def _counted(path: Path, data: bytes, text: str, counter: str, wishes: Wishes) -> Table | None:
    """The table with one of COUNTERS, counted on beyond its turns, as t_s; None where it has no such column. Raises RecordingError."""
    if not re.search(rf"^(?:.*[\t,;])?{counter}\b", text, re.MULTILINE) or "t_s" in wishes.columns:
        return None
    table = parse(str(path), data, replace(wishes, columns={"t_s": counter, **wishes.columns}))
    ticks = table.values["t_s"]
    if not np.isfinite(ticks).all() or not np.diff(ticks).any() or (ticks % 1).any():
        return None  # an empty column, or some other time under this name
    passed = np.diff(ticks, prepend=ticks[:1]) % COUNTERS[counter]
    return replace(table, values={**table.values, "t_s": np.cumsum(passed)})


def _packet_s(text: str) -> float | None:
    """By the comment "// Update Rate: 100.0Hz"."""
    match = re.search(r"^//\s*Update Rate:\s*([\d.]+)\s*Hz", text, re.MULTILINE)
    try:
        rate_hz = float(match.group(1)) if match else 0.0
    except ValueError:
        return None
    return 1 / rate_hz if rate_hz > 0 else None
