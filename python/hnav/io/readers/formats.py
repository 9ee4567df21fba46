"""The list of formats. Each is recognised by the first bytes of a file or by the members of a folder."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from hnav.io.readers.broad import is_broad, read_broad
from hnav.io.readers.flight_logs import is_ardupilot, is_betaflight, read_ardupilot, read_betaflight
from hnav.io.readers.kitti import is_kitti, read_kitti
from hnav.io.readers.long_tables import is_long_table, read_long_table
from hnav.io.readers.nmea import is_nmea, read_nmea
from hnav.io.readers.packed import ZIP_MAGIC, read_folder, tables_in, unpacked, unpacker_of, unzipped, what_it_is
from hnav.io.readers.phones import is_phone_export, read_phone
from hnav.io.readers.receivers import is_gpx, is_ubx, read_gpx, read_ubx
from hnav.io.readers.records import is_json, is_npz, read_json, read_npz
from hnav.io.readers.robots import is_bag, is_euroc, is_ulog, read_bag, read_euroc, read_ulog
from hnav.io.readers.rostopic import is_rostopic, read_rostopic
from hnav.io.readers.rtklib import is_pos, read_pos
from hnav.io.readers.serial_text import is_serial_text, read_serial_text
from hnav.io.readers.streams import Raw, Wishes
from hnav.io.readers.tables import UTF_16, read_parquet, read_table, without_zeros
from hnav.io.readers.xsens import is_xsens_binary, is_xsens_text, read_xsens_text, refuse_binary
from hnav.io.recordings import RecordingError

HEAD_BYTES = 1 << 15
Reader = Callable[[Path, Wishes], Raw]


@dataclass(frozen=True)
class Format:
    """A format: how it is recognised and read."""

    about: str
    recognises: Callable[[Path, bytes], bool]
    """By path and first bytes; a folder has none."""
    read: Reader


def is_text(path: Path, head: bytes) -> bool:
    return bool(head) and not what_it_is(head) and (b"\0" not in without_zeros(head) or head[:2] in UTF_16)


FORMATS = {
    "broad": Format("BROAD trial, or variables of any names (.hdf5, .mat)", is_broad, read_broad),
    "npz": Format("arrays of NumPy (.npz, .npy)", is_npz, read_npz),
    "ardupilot": Format("dataflash log of ArduPilot (.bin, .log)", is_ardupilot, read_ardupilot),
    "ulog": Format("log of PX4 (.ulg)", is_ulog, read_ulog),
    "rosbag": Format("bag of ROS 1 or 2 (.bag, .mcap, .db3 or their folder)", is_bag, read_bag),
    "parquet": Format("Parquet, Feather", lambda path, head: head.startswith((b"PAR1", b"ARROW1")), read_parquet),
    "euroc": Format("EuRoC (data.csv, or a folder of the set)", is_euroc, read_euroc),
    "kitti": Format("raw sequence of KITTI (folder with oxts)", is_kitti, read_kitti),
    "rostopic": Format("messages of ROS 1 as text, by rostopic echo -p", is_rostopic, read_rostopic),
    "phone": Format("export of Sensor Logger or phyphox (folder or zip)", is_phone_export, read_phone),
    "xsens": Format("binary data of Xsens: says how to get text", is_xsens_binary, refuse_binary),
    "xsens-text": Format("text exported by MT Manager of Xsens, or from a DOT", is_xsens_text, read_xsens_text),
    "ubx": Format("messages of a u-blox receiver (UBX)", is_ubx, read_ubx),
    "gpx": Format("track of satellites (.gpx)", is_gpx, read_gpx),
    "rtklib": Format("solutions of RTKLIB (.pos)", is_pos, read_pos),
    "json": Format("JSON: records, columns, Sensor Logger, Movesense", is_json, read_json),
    "betaflight": Format("blackbox of Betaflight as CSV", is_betaflight, read_betaflight),
    "nmea": Format("sentences of a receiver of satellites (NMEA 0183)", is_nmea, read_nmea),
    "serial": Format("what a sketch prints: names with numbers", is_serial_text, read_serial_text),
    "long": Format("table with a row for each sample of one sensor", is_long_table, read_long_table),
    "table": Format("CSV, TSV, or text with semicolons or blanks", is_text, read_table),
}
"""By name, in the order in which they are tried."""


def reader_of(path: Path, format: str | None) -> Reader:
    """The reader of the file. Raises RecordingError for a missing file and for an unsupported format."""
    if format is not None and format not in FORMATS:
        raise RecordingError(f"format = {format}: choose one of {', '.join(FORMATS)}", "format")
    if not path.exists():
        raise RecordingError(f"{path}: no such file")
    head = b""
    if path.is_file():
        with path.open("rb") as file:
            head = file.read(HEAD_BYTES)
        if not head:
            raise RecordingError(f"{path}: the file is empty")
    if packed := unpacker_of(path, head):
        return lambda path, wishes: unpacked(path, packed, lambda inner: reader_of(inner, format)(inner, wishes))
    if format is not None:
        return FORMATS[format].read
    for known in FORMATS.values():
        if known.recognises(path, head):
            return known.read
    if path.is_dir() and (files := tables_in(path)):
        return lambda path, wishes: read_folder(path, files, lambda file: reader_of(file, None)(file, wishes), wishes)
    if head.startswith(ZIP_MAGIC):
        return lambda path, wishes: unzipped(path, lambda inner: reader_of(inner, None)(inner, wishes))
    if path.is_dir():
        raise RecordingError(f"{path}: the folder holds no file: give the file of the recording, or the folder that it is in")
    raise RecordingError(f"{path}: {what_it_is(head)}no supported format ({', '.join(FORMATS)})")
