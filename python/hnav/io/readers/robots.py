"""Logs of robots: PX4 (.ulg, by pyulog) and bags of ROS 1 and 2 (.bag, .db3, .mcap, by rosbags), EuRoC's folders."""

from __future__ import annotations

import io
from collections.abc import Collection, Iterator
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

import numpy as np

from hnav.io.aids import AidSamples
from hnav.io.readers.aids import SMALLEST_PA, whole
from hnav.io.readers.clock import DAMAGED
from hnav.io.readers.streams import Raw, Stream, Wishes, cannot_be_read, library
from hnav.io.readers.tables import parse, raw_of
from hnav.io.recordings import ARRAYS, RecordingError

ULOG_MAGIC = b"ULog\x01\x12\x35"
BAG_MAGIC = b"#ROSBAG V"
MCAP_MAGIC = b"\x89MCAP0\r\n"
SQLITE_MAGIC = b"SQLite format 3\0"
ROS_UNITS = {"gyro": "rad/s", "accel": "m/s2", "mag": "T"}
IMU, MAG, FIX = "sensor_msgs/msg/Imu", "sensor_msgs/msg/MagneticField", "sensor_msgs/msg/NavSatFix"
WORDS = {IMU: "imu", MAG: "mag", FIX: "gnss"}
TOPICS = tuple(WORDS.values())
IMU_FIELDS = {"gyro": "angular_velocity", "accel": "linear_acceleration"}

# --------------------------------------------------------------------------------------------- PX4


def is_ulog(path: Path, head: bytes) -> bool:
    return head.startswith(ULOG_MAGIC)


# By sensor: topic, its fields, their unit; the first that a log has is taken.
ULOG_TOPICS = {
    "gyro": (("sensor_combined", "gyro_rad[{}]", "rad/s"), ("sensor_gyro", "xyz", "rad/s")),
    "accel": (("sensor_combined", "accelerometer_m_s2[{}]", "m/s2"), ("sensor_accel", "xyz", "m/s2")),
    "mag": (("vehicle_magnetometer", "magnetometer_ga[{}]", "G"), ("sensor_combined", "magnetometer_ga[{}]", "G"), ("sensor_mag", "xyz", "G")),
}  # fmt: skip


def read_ulog(path: Path, wishes: Wishes) -> Raw:
    """The first instance of each topic. Raises RecordingError."""
    pyulog = library("pyulog", "logs", str(path))
    wanted = sorted({topic for topics in ULOG_TOPICS.values() for topic, _, _ in topics} | {*ULOG_GNSS, *ULOG_PRESSURE})
    try:
        with redirect_stdout(io.StringIO()):  # the parser prints that a file is corrupt
            log = pyulog.ULog(str(path), wanted)
        topics = {data.name: data.data for data in sorted(log.data_list, key=lambda data: -data.multi_id)}
        streams = [stream for sensor in ARRAYS if (stream := _ulog_stream(topics, sensor, wishes))]
        aids = _ulog_satellites(topics) | _ulog_pressure(topics)
    except Exception as error:  # the parser raises errors of any type for a damaged file
        raise cannot_be_read(path, error) from None
    for sensor in ("gyro", "accel"):
        if sensor not in {stream.sensor for stream in streams} and not wishes.only_aids:
            raise RecordingError(
                f"{path}: has no topic {' or '.join(topic for topic, _, _ in ULOG_TOPICS[sensor])}: log it (SDLOG_PROFILE)"
            )
    return Raw("ulog", streams, wishes.unit("time", by_format="us"), _ulog_damage(path, log, wanted), aids=aids, names=())


# Kinds of messages: https://docs.px4.io/main/en/dev_log/ulog_file_format.html
ULOG_KINDS = frozenset(b"BFIMPQARDLCSO")
ULOG_HEADER_BYTES, ULOG_MESSAGE_BYTES = 16, 3


def _ulog_damage(path: Path, log: Any, wanted: Collection[str]) -> tuple[str, ...]:
    """A note on a log that is damaged or cut off: where, and of which topics there are samples."""
    data = path.read_bytes()
    at = ULOG_HEADER_BYTES
    while at + ULOG_MESSAGE_BYTES <= len(data) and data[at + 2] in ULOG_KINDS:
        at += ULOG_MESSAGE_BYTES + int.from_bytes(data[at : at + 2], "little")
    if at == len(data) and not log.file_corruption:
        return ()
    if at >= len(data) - 2 and not log.file_corruption:
        begun = "the log was cut off within its last message, and what followed is lost"
    else:
        begun = f"the log is damaged{f' at byte {at} of {len(data)}' if at < len(data) - 2 else ''}, and messages are lost"
    counts = {topic.name: len(topic.data["timestamp"]) for topic in log.data_list}
    read = ", ".join(f"{name} {count}" for name, count in counts.items())
    without = ", ".join(name for name in wanted if name in log.message_formats and name not in counts)
    return (f"{DAMAGED}{begun}; samples were read of {read}" + (f", and none of {without}" if without else ""),)


def _ulog_us(data: dict[str, Any]) -> np.ndarray:
    """Times of measurement, if the log states them."""
    sampled = data.get("timestamp_sample")
    return np.asarray(data["timestamp"] if sampled is None or not (sampled > 0).all() else sampled, float)


def _ulog_stream(topics: dict[str, Any], sensor: str, wishes: Wishes) -> Stream | None:
    for topic, fields, unit in ULOG_TOPICS[sensor]:
        data = topics.get(topic)
        names = list(fields) if fields == "xyz" else [fields.format(i) for i in range(3)]
        if data is None or not set(names) <= set(data):
            continue
        us = np.asarray(data["timestamp"], float) if topic == "sensor_combined" else _ulog_us(data)
        values = np.stack([np.asarray(data[name], float) for name in names], axis=1)
        relative = data.get("accelerometer_timestamp_relative")
        present = np.ones(len(us), bool)
        if sensor == "accel" and topic == "sensor_combined" and relative is not None:
            present = relative != np.iinfo(np.int32).max  # no sample of it in this message
            us = us + relative
        return Stream(sensor, us[present] * 1e-6, values[present], wishes.unit(sensor, by_format=unit))
    return None


ULOG_GNSS = ("vehicle_gps_position", "sensor_gps")
ULOG_PRESSURE = {"vehicle_air_data": "baro_pressure_pa", "sensor_baro": "pressure"}
ULOG_PLACES = (("latitude_deg", "longitude_deg", "altitude_ellipsoid_m", 1.0, 1.0), ("lat", "lon", "alt_ellipsoid", 1e-7, 1e-3))
FIX_3D = 3


def _ulog_satellites(topics: dict[str, Any]) -> dict[str, AidSamples]:
    """Positions and velocities of fixes with a height."""
    data = next((topics[name] for name in ULOG_GNSS if name in topics), None)
    names = next((names for names in ULOG_PLACES if data is not None and set(names[:3]) <= set(data)), None)
    if data is None or names is None:
        return {}
    latitude, longitude, height, per_deg, per_m = names
    place = np.stack([np.radians(data[latitude] * per_deg), np.radians(data[longitude] * per_deg), data[height] * per_m], axis=1)
    velocity = np.stack([np.asarray(data[f"vel_{axis}_m_s"], float) for axis in "ned"], axis=1)
    velocity[~np.asarray(data.get("vel_ned_valid", np.ones(len(velocity))), bool)] = np.nan
    t_s = 1e-6 * _ulog_us(data)
    spread = np.stack([data["eph"], data["eph"], data["epv"]], axis=1).astype(float)
    rate_spread = np.repeat(np.asarray(data["s_variance_m_s"], float)[:, None], 3, axis=1)
    known = np.asarray(data["fix_type"]) >= FIX_3D
    position, velocities = (
        AidSamples(t_s, values, np.where(np.isfinite(sigma), sigma, np.nan))
        for values, sigma in ((place, spread), (velocity, rate_spread))
    )
    return whole({"position": position, "velocity": velocities}, known)


def _ulog_pressure(topics: dict[str, Any]) -> dict[str, AidSamples]:
    """In Pa; logs of long ago have mbar."""
    for topic, name in ULOG_PRESSURE.items():
        if topic in topics and name in topics[topic]:
            read = np.asarray(topics[topic][name], float)[:, None]
            read = read if np.median(read) > SMALLEST_PA else 100 * read
            return whole({"pressure": AidSamples(1e-6 * _ulog_us(topics[topic]), read, np.full_like(read, np.nan))})
    return {}


# --------------------------------------------------------------------------------------------- ROS


def is_bag(path: Path, head: bytes) -> bool:
    return (path / "metadata.yaml").is_file() or head.startswith((BAG_MAGIC, MCAP_MAGIC, SQLITE_MAGIC))


def read_bag(path: Path, wishes: Wishes) -> Raw:
    """The topics with most messages of Imu and MagneticField, or those that columns names; of Imu the first that measures, where gyroscope
    and accelerometer have topics of their own, as of a RealSense. Raises RecordingError."""
    library("rosbags", "logs", str(path))
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    bag = path.parent if path.suffix in (".db3", ".mcap") and (path.parent / "metadata.yaml").is_file() else path
    try:
        with AnyReader([bag], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
            return _read_topics(path, reader, wishes)
    except RecordingError:
        raise
    except Exception as error:  # the parser raises errors of any type for a damaged file
        raise cannot_be_read(path, error) from None


def _read_topics(path: Path, reader: Any, wishes: Wishes) -> Raw:
    """Raises RecordingError for a bag without an inertial sensor."""
    imus, mags, fixes = (_topics(path, reader, kind, wishes.columns.get(word)) for kind, word in WORDS.items())
    aids, time_unit = _fixes(reader, fixes[0]) if fixes else {}, wishes.unit("time", by_format="s")
    if wishes.only_aids:
        return Raw("rosbag", [], time_unit, _not_taken(FIX, fixes), aids=aids, names=TOPICS)
    if not imus:
        raise RecordingError(f"{path}: has no topic of {IMU}; its topics: {', '.join(sorted(reader.topics)[:8]) or 'none'}")
    taken = {sensor: _measuring(reader, imus, name) for sensor, name in IMU_FIELDS.items()}
    found = {sensor: _vectors(reader, taken[sensor], name) for sensor, name in IMU_FIELDS.items()}
    found |= {"mag": _vectors(reader, mags[0], "magnetic_field")} if mags else {}
    streams = [Stream(sensor, *samples, wishes.unit(sensor, by_format=ROS_UNITS[sensor])) for sensor, samples in found.items()]
    apart = tuple(f"{sensor}: {topic}" for sensor, topic in taken.items()) if len({*taken.values()}) > 1 else ()
    notes = (*(apart or _not_taken(IMU, imus)), *_not_taken(MAG, mags), *_not_taken(FIX, fixes))
    return Raw("rosbag", streams, time_unit, notes, aids=aids, names=TOPICS)


def _topics(path: Path, reader: Any, kind: str, wanted: str | None) -> list[str]:
    """The names of the topics of this kind, those with most messages first; only the wanted one, if there is one."""
    counts = {name: topic.msgcount for name, topic in reader.topics.items() if topic.msgtype == kind}
    if wanted is None:
        return sorted(counts, key=lambda name: (-counts[name], name))
    if wanted not in counts:
        raise RecordingError(
            f"columns = {wanted}: {path} has no such topic of {kind}, but {', '.join(counts) or 'none'}", "columns"
        )
    return [wanted]


def _not_taken(kind: str, topics: list[str]) -> tuple[str, ...]:
    """A note on all but the first topic."""
    word, others = WORDS[kind], ", ".join(sorted(topics[1:]))
    return (f"{word}: {topics[0]}, not {others} (choose by columns {word}=TOPIC)",) if others else ()


def _measuring(reader: Any, topics: list[str], name: str) -> str:
    """The first topic in which a vector is not zero; the first of all where there is none."""
    return next((topic for topic in topics if any(any(row[1:]) for row in _all_vectors(reader, topic, name))), topics[0])


def _vectors(reader: Any, topic: str, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Times in s (n) and vectors (n x 3)."""
    table = np.array([*_all_vectors(reader, topic, name)], float).reshape(-1, 4)
    return table[:, 0], np.ascontiguousarray(table[:, 1:])


def _all_vectors(reader: Any, topic: str, name: str) -> Iterator[tuple[float, ...]]:
    """Time and vector of the messages that have one: a covariance of -1 in an Imu says that there is none."""
    for t_s, message in _messages(reader, topic):
        if name not in IMU_FIELDS.values() or getattr(message, f"{name}_covariance")[0] != -1:
            vector = getattr(message, name)
            yield t_s, vector.x, vector.y, vector.z


def _messages(reader: Any, topic: str) -> Iterator[tuple[float, Any]]:
    """With their times in s."""
    for connection, arrived_ns, data in reader.messages(connections=[c for c in reader.connections if c.topic == topic]):
        message = reader.deserialize(data, connection.msgtype)
        stamp = message.header.stamp
        ns = stamp.sec * 1_000_000_000 + stamp.nanosec or arrived_ns  # a driver that sets no stamp
        yield ns * 1e-9, message


def _fixes(reader: Any, topic: str) -> dict[str, AidSamples]:
    """Positions of NavSatFix."""
    rows = [
        (t_s, m.latitude, m.longitude, m.altitude, *np.asarray(m.position_covariance, float)[[4, 0, 8]], m.position_covariance_type, m.status.status)
        for t_s, m in _messages(reader, topic)
    ]  # fmt: skip
    t = np.array(rows, float).reshape(-1, 9)
    return fix_samples(t[:, 0], t[:, 1:4], t[:, 4:7], t[:, 7], t[:, 8])


FIX_FIELDS = ("latitude", "longitude", "altitude", "status.status")
"""Of NavSatFix."""


def fix_samples(
    t_s: np.ndarray, place: np.ndarray, variance: np.ndarray, kind: np.ndarray, status: np.ndarray
) -> dict[str, AidSamples]:
    """Positions of n messages NavSatFix. place: n x 3, in deg and m; variance: n x 3, in m2, north, east, up; kind: 0 where it is unknown;
    status: below 0 without a fix."""
    known = (kind[:, None] > 0) & (variance > 0).all(axis=1, keepdims=True)
    one = AidSamples(t_s, place * [np.pi / 180, np.pi / 180, 1.0], np.sqrt(np.where(known, variance, np.nan)))
    return whole({"position": one}, status >= 0)


# --------------------------------------------------------------------------------------------- EuRoC


def is_euroc(path: Path, head: bytes) -> bool:
    """data.csv itself, or a folder of the set."""
    return head.startswith(b"#timestamp [ns],w_RS_S_x") or _euroc_file(path) is not None


def read_euroc(path: Path, wishes: Wishes) -> Raw:
    """imu0/data.csv: rad/s, m/s2, ns. Raises RecordingError."""
    file = _euroc_file(path) or path
    return raw_of(str(file), parse(str(file), file.read_bytes(), wishes), wishes, name="euroc")


def _euroc_file(path: Path) -> Path | None:
    candidates = (path / inner / "data.csv" for inner in ("mav0/imu0", "imu0", "."))
    return next((file for file in candidates if file.is_file()), None)
