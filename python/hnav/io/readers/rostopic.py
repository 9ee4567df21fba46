"""Messages of ROS 1 as text, by rostopic echo -p /TOPIC: a line of field names, then a line for each message; times in ns.

Header stamps are times of measurement; %time, the arrival, counts where a driver sets none.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from hnav.io.readers.robots import FIX_FIELDS, ROS_UNITS
from hnav.io.readers.streams import Raw, Wishes, alone
from hnav.io.readers.tables import parse, raw_of

TIME, STAMP = "%time", "header.stamp"
PREFIX = "field."
"""Of all names of the message."""


def is_rostopic(path: Path, head: bytes) -> bool:
    return head.startswith(b"%time,field.") and (PREFIX + STAMP).encode() in head.split(b"\n", 1)[0]


def read_rostopic(path: Path, wishes: Wishes) -> Raw:
    """Imu or MagneticField, or positions of NavSatFix, as a table. Raises RecordingError."""
    header, *rows = path.read_bytes().split(b"\n", 1)
    header = header.replace(PREFIX.encode(), b"")
    data, names = b"\n".join([header, *rows]), header.decode("utf-8", "replace").strip().split(",")
    if {*FIX_FIELDS} <= {*names}:
        alone(path, wishes)
    time = STAMP if _has_stamps(data, names.index(STAMP)) else TIME
    given = {role: name.removeprefix(PREFIX) for role, name in wishes.columns.items()}
    table = parse(str(path), data, replace(wishes, columns={"t_s": time, **given}))
    return raw_of(str(path), table, wishes, {**ROS_UNITS, "time": "ns"}, "rostopic")


def _has_stamps(data: bytes, place: int) -> bool:
    """Whether the first message has one."""
    first = data.split(b"\n", 2)[1:2]
    cells = first[0].split(b",") if first else []
    return len(cells) > place and cells[place].strip() not in (b"", b"0")
