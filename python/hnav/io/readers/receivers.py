"""Files of GNSS receivers and their apps besides NMEA: UBX (by pyubx2) and GPX."""

from __future__ import annotations

import datetime
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from hnav.io.aids import AidSamples
from hnav.io.readers.aids import whole
from hnav.io.readers.streams import Raw, Wishes, alone, cannot_be_read, library
from hnav.io.recordings import RecordingError

SYNC = b"\xb5\x62"
FIX_3D = 3
IN_MM = ("height", "hAcc", "vAcc", "velN", "velE", "velD", "sAcc")
"""Fields of NAV-PVT in mm and mm/s."""


def is_ubx(path: Path, head: bytes) -> bool:
    return SYNC in head and (path.suffix.lower() == ".ubx" or head.startswith(SYNC))


def read_ubx(path: Path, wishes: Wishes) -> Raw:
    """Positions and velocities of NAV-PVT, times by GPS week and UTC. Raises RecordingError."""
    alone(path, wishes)
    pyubx2 = library("pyubx2", "logs", str(path))
    rows = []
    try:
        with path.open("rb") as stream:
            for _, message in pyubx2.UBXReader(stream, protfilter=2, quitonerror=0):
                if message is not None and message.identity == "NAV-PVT" and message.fixType >= FIX_3D:
                    in_mm = [getattr(message, name) * 1e-3 for name in IN_MM]
                    rows.append((_utc_s(message), message.lat, message.lon, *in_mm))
    except Exception as error:  # pyubx2 raises errors of any type for a damaged file
        raise cannot_be_read(path, error) from None
    if not rows:
        raise RecordingError(f"{path}: no message NAV-PVT with a fix: switch it on in the receiver, or log NMEA")
    table = np.array(rows)
    t_s, place = table[:, 0], np.column_stack([np.radians(table[:, 1:3]), table[:, 3]])
    velocity = AidSamples(t_s, table[:, 6:9], np.repeat(table[:, 9:], 3, axis=1))
    aids = {"position": AidSamples(t_s, place, table[:, [4, 4, 5]]), "velocity": velocity}
    return Raw("ubx", [], wishes.unit("time", by_format="s"), aids=aids, names=())


def _utc_s(message: object) -> float:
    year, month, day, hour, minute, second = (
        int(getattr(message, name)) for name in ("year", "month", "day", "hour", "min", "second")
    )
    whole = datetime.datetime(year, month, day, hour, minute, min(second, 59), tzinfo=datetime.UTC).timestamp()
    return whole + int(getattr(message, "nano")) * 1e-9  # noqa: B009


def is_gpx(path: Path, head: bytes) -> bool:
    return b"<gpx" in head


def read_gpx(path: Path, wishes: Wishes) -> Raw:
    """Points of tracks with times. Raises RecordingError."""
    alone(path, wishes)
    rows = []
    try:
        if b"<!ENTITY" in path.read_bytes()[:65536]:
            raise RecordingError(f"{path}: no GPX: it defines entities")
        for _, element in ElementTree.iterparse(path):
            if element.tag.rpartition("}")[2] == "trkpt":
                fields = {child.tag.rpartition("}")[2]: (child.text or "").strip() for child in element}
                if "time" in fields:
                    t_s = datetime.datetime.fromisoformat(fields["time"].replace("Z", "+00:00")).timestamp()
                    degrees = [float(element.get(name, "nan")) for name in ("lat", "lon")]
                    rows.append((t_s, *degrees, *(float(fields.get(name) or "nan") for name in ("ele", "geoidheight"))))
                element.clear()
    except (ElementTree.ParseError, ValueError) as error:
        if not rows:
            raise RecordingError(f"{path}: no GPX: {str(error).splitlines()[0]}") from None
    if not rows:
        raise RecordingError(f"{path}: no point of a track with a time")
    table = np.array(rows)
    above_sea = not np.isfinite(table[:, 4]).all()
    place = np.column_stack([np.radians(table[:, 1:3]), table[:, 3] + np.nan_to_num(table[:, 4])])
    one = AidSamples(table[:, 0], place, np.full((len(table), 3), np.nan), above_sea=above_sea)
    return Raw("gpx", [], wishes.unit("time", by_format="s"), aids=whole({"position": one}), names=())
