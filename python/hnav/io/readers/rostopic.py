"""Messages of ROS 1 as text, by rostopic echo -p /TOPIC: a line of field names, then a line for each message; times in ns.

Header stamps are times of measurement; %time, the arrival, counts where a driver sets none.
"""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path

import numpy as np

from hnav.io.readers.robots import FIX_FIELDS, ROS_UNITS, fix_samples
from hnav.io.readers.streams import Raw, Wishes, alone, cannot_be_read
from hnav.io.readers.tables import parse, raw_of

TIME, STAMP = "%time", "field.header.stamp"
VARIANCES = tuple(f"field.position_covariance{i}" for i in (4, 0, 8))
"""North, east, up, of a matrix in east, north, up."""
KIND = "field.position_covariance_type"
FIX_NEEDED = (TIME, STAMP, *(f"field.{name}" for name in FIX_FIELDS), *VARIANCES, KIND)


def is_rostopic(path: Path, head: bytes) -> bool:
    return head.startswith(b"%time,field.") and STAMP.encode() in head.split(b"\n", 1)[0]


def read_rostopic(path: Path, wishes: Wishes) -> Raw:
    """Imu or MagneticField as a table, or positions of NavSatFix. Raises RecordingError."""
    data = path.read_bytes()
    names = data.split(b"\n", 1)[0].decode("utf-8", "replace").strip().split(",")
    if {f"field.{name}" for name in FIX_FIELDS} <= {*names}:
        alone(path, wishes)
        return _fixes(path, data, names, wishes)
    time = STAMP if _has_stamps(data, names.index(STAMP)) else TIME
    table = parse(str(path), data, replace(wishes, columns={"t_s": time, **wishes.columns}))
    return raw_of(str(path), table, wishes, {**ROS_UNITS, "time": "ns"}, "rostopic")


def _has_stamps(data: bytes, place: int) -> bool:
    """Whether the first message has one."""
    first = data.split(b"\n", 2)[1:2]
    cells = first[0].split(b",") if first else []
    return len(cells) > place and cells[place].strip() not in (b"", b"0")


def _fixes(path: Path, data: bytes, names: list[str], wishes: Wishes) -> Raw:
    import pandas

    try:
        frame = pandas.read_csv(io.BytesIO(data))
        known = {name: pandas.to_numeric(frame[name]).to_numpy() for name in names if name in FIX_NEEDED}
    except (ValueError, KeyError) as error:
        raise cannot_be_read(path, error) from None
    stamp = known[STAMP] if (known[STAMP] > 0).all() else known[TIME]
    place = np.stack([known[f"field.{name}"] for name in FIX_FIELDS[:3]], axis=1)
    nothing = np.full(len(frame), np.nan)
    variance = np.stack([known.get(name, nothing) for name in VARIANCES], axis=1)
    kind = known.get(KIND, np.ones(len(frame)))
    aids = fix_samples(1e-9 * stamp, place, variance, kind, known[f"field.{FIX_FIELDS[3]}"])
    return Raw("rostopic", [], wishes.unit("time", by_format="ns"), aids=aids, names=())
