"""Where samples come from while a device runs: a serial port, UDP, TCP, standard input, MAVLink.

    with LiveSource.named("udp://127.0.0.1:5005") as source:
        while (chunks := source.wait(0.1)) is not None: ...

A thread reads; a queue of bounded length holds what has not been taken. A full queue holds the thread back: a pipe, a serial port and TCP
then hold their sender back, and of UDP the kernel drops datagrams and counts them.
"""

from __future__ import annotations

import math
import os
import queue
import socket
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Any
from urllib.parse import parse_qs, urlsplit

from hnav.errors import HnavValueError
from hnav.io.readers.streams import library
from hnav.io.recordings import CSV_COLUMNS

RETRY_S = 0.5
"""Seconds between two attempts to reopen a source."""
POLL_S = 0.1
"""Longest time in s until a reading thread notices that it must end."""
BLOCK_BYTES = 65_536
RECEIVE_BYTES = 1 << 22
"""Requested size of the kernel's datagram queue."""
RXQ_OVFL = 40
"""SO_RXQ_OVFL of Linux: the kernel adds the count of dropped datagrams to each one; the module socket does not name it."""
BAUD = 115_200
KINDS = "a serial port (/dev/ttyUSB0, COM3), udp://HOST:PORT, tcp://HOST:PORT, mavlink:CONNECTION, or - for standard input"


@dataclass(frozen=True)
class Chunk:
    """Bytes as received."""

    arrived_s: float
    """By time.monotonic()."""
    data: bytes
    connection: int
    """Number of the connection; a line does not continue from one connection to the next."""


class LiveSource:
    """Base of all sources. A subclass defines chunks(), which opens it, yields bytes, and raises OSError when it is lost."""

    ENDS = False
    """Whether the source ends with its data."""
    LOSS = "dropped by the system"
    """Description of the dropped count."""
    WAITING = 64
    """Chunks in the queue, of up to BLOCK_BYTES."""

    def __init__(self, name: str):
        self.name, self.connections, self.failure = name, 0, ""
        self.dropped = 0
        """Datagrams that the kernel dropped; for MAVLink, messages missing by their sequence numbers."""
        self._queue: queue.Queue[Chunk | None] = queue.Queue(self.WAITING)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    @staticmethod
    def named(text: str, baud: int = BAUD, aids: bool = False) -> LiveSource:
        """The source of a name given by a user. aids: also satellite messages of MAVLink. Raises HnavError for an unknown
        name or a missing package."""
        kind, rest = text.partition(":")[0].lower(), text.partition(":")[2]
        if text == "-":
            return _Input(text)
        if kind in ("udp", "tcp"):
            return (_Udp if kind == "udp" else _Tcp)(text, *address_of(text))
        if kind == "mavlink" and rest:
            return _Mavlink(text, rest, baud, aids)
        if "://" in text and kind not in ("serial", "socket", "rfc2217", "loop"):
            raise HnavValueError("option", f"{text}: is no source: give {KINDS}")
        if os.path.isfile(text):
            raise HnavValueError("option", f"{text}: is a file: hnav filter reads it, and hnav live - < FILE its lines")
        return _Serial(text, text.removeprefix("serial://"), baud)

    def __enter__(self) -> LiveSource:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        with suppress(queue.Empty):  # a thread that waits for space must end too
            while True:
                self._queue.get_nowait()
        if not isinstance(self, _Input):  # standard input is read without a time limit
            self._thread.join(timeout=2.0)

    def wait(self, timeout_s: float) -> list[Chunk] | None:
        """All received chunks, after waiting for the first; empty after the time limit, None at the end of the source."""
        found = []
        with suppress(queue.Empty):
            found.append(self._queue.get(timeout_s > 0, timeout_s))
            found += [self._queue.get_nowait() for _ in range(self._queue.qsize())]
        chunks = [chunk for chunk in found if chunk is not None]
        if len(chunks) == len(found):
            return chunks
        if chunks:
            self._queue.put(None)
        return chunks or None

    def chunks(self) -> Iterator[bytes]:
        """Opens the source and yields its data. Raises OSError."""
        raise NotImplementedError

    @property
    def ending(self) -> bool:
        """Whether the thread is to end."""
        return self._ended.is_set()

    def _run(self) -> None:
        while not self.ending:
            try:
                for data in self.chunks():
                    self._put(Chunk(time.monotonic(), data, self.connections))
                    if self.ending:
                        return
                self.failure = "" if self.ENDS else "closed by the other side"
            except OSError as error:
                self.failure = (error.strerror or str(error)).lower()
            if self.ENDS:
                break
            self._ended.wait(RETRY_S)
        self._put(None)

    def _put(self, chunk: Chunk | None) -> None:
        while not self.ending:
            with suppress(queue.Full):
                self._queue.put(chunk, timeout=POLL_S)
                return

    def _opened(self) -> None:
        self.connections += 1
        self.failure = ""


class _Input(LiveSource):
    ENDS = True

    def chunks(self) -> Iterator[bytes]:
        self._opened()
        while data := os.read(sys.stdin.fileno(), BLOCK_BYTES):
            yield data


class _Udp(LiveSource):
    WAITING = 20_000  # datagrams of one second at 20 kHz

    def __init__(self, name: str, host: str, port: int):
        super().__init__(name)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BYTES)
        if sys.platform == "linux":
            self._socket.setsockopt(socket.SOL_SOCKET, RXQ_OVFL, 1)
        self._socket.settimeout(POLL_S)
        try:
            self._socket.bind((host or "127.0.0.1", port))
        except OSError as error:
            self._socket.close()
            raise HnavValueError("option", f"{name}: cannot be listened to: {(error.strerror or str(error)).lower()}") from None
        self.port = int(self._socket.getsockname()[1])

    def chunks(self) -> Iterator[bytes]:
        self._opened()
        with self._socket:
            while not self.ending:
                with suppress(TimeoutError):
                    yield self._received()

    def _received(self) -> bytes:
        """A datagram; its end is the end of a line."""
        if sys.platform != "linux":
            return self._socket.recv(BLOCK_BYTES) + b"\n"
        data, more, *_ = self._socket.recvmsg(BLOCK_BYTES, socket.CMSG_SPACE(4))
        for level, kind, said in more:
            if (level, kind) == (socket.SOL_SOCKET, RXQ_OVFL):
                self.dropped = int.from_bytes(said[:4], sys.byteorder)
        return data + b"\n"


class _Tcp(LiveSource):
    def __init__(self, name: str, host: str, port: int):
        super().__init__(name)
        self._address = (host or "127.0.0.1", port)

    def chunks(self) -> Iterator[bytes]:
        with socket.create_connection(self._address, timeout=2.0) as connection:
            self._opened()
            connection.settimeout(POLL_S)
            while not self.ending:
                with suppress(TimeoutError):
                    if not (data := connection.recv(BLOCK_BYTES)):
                        return
                    yield data


class _Serial(LiveSource):
    def __init__(self, name: str, device: str, baud: int):
        super().__init__(name)
        self._serial = library("serial", "live", name)
        parts = urlsplit(device)
        rate = parse_qs(parts.query).get("baud", [str(baud)])[0]
        if not rate.isdigit():
            raise HnavValueError("option", f"{name}: baud={rate} is no number")
        self._device, self._baud = device.partition("?")[0], int(rate)
        if not parts.scheme and os.path.isfile(self._device):
            raise HnavValueError("option", f"{name}: is a file: hnav filter reads it; to play it as lines: hnav live - < {name}")
        if os.name == "posix" and not parts.scheme and not os.path.exists(self._device):
            raise HnavValueError("option", f"{name}: is no source: give {KINDS}")

    def chunks(self) -> Iterator[bytes]:
        with self._serial.serial_for_url(self._device, self._baud, timeout=POLL_S) as port:
            self._opened()
            while not self.ending:
                if data := port.read(max(1, port.in_waiting)):
                    yield data


class _Mavlink(LiveSource):
    LOSS = "lost on the way"

    def __init__(self, name: str, connection: str, baud: int, aids: bool):
        super().__init__(name)
        self._mavutil = library("pymavlink.mavutil", "logs", name)
        self._connection, self._baud = connection, baud
        self._types = [*MAVLINK, *([SATELLITES] if aids else [])]

    def chunks(self) -> Iterator[bytes]:
        try:
            link = self._mavutil.mavlink_connection(self._connection, baud=self._baud, autoreconnect=False)
        except OSError:
            raise
        except Exception as error:  # pymavlink raises errors of any type for an invalid connection text
            raise OSError(f"{type(error).__name__}: {error}") from None
        try:
            self._opened()
            yield MAVLINK_HEADER
            while not self.ending:
                message = link.recv_match(type=self._types, blocking=True, timeout=POLL_S)
                self.dropped = link.mav_loss
                if message is not None:
                    yield (fix_line if message.get_type() == SATELLITES else mavlink_line)(message)
        finally:
            link.close()


# --------------------------------------------------------------------------------------------- MAVLink

MAVLINK_COLUMNS = (*CSV_COLUMNS, "pressure_pa", "lat_deg", "lon_deg", "alt_m", "vn", "ve", "sigma_h", "sigma_v", "sigma_vel")
MAVLINK_HEADER = ",".join(MAVLINK_COLUMNS).encode() + b"\n"
MAVLINK = {
    "HIGHRES_IMU": ("time_usec", 1e-6, 1.0, 1.0, 1e-4),
    "SCALED_IMU": ("time_boot_ms", 1e-3, 1e-3, 9.80665e-3, 1e-7),
}
"""Per message: its time field, and its units of time, rate, force and field in s, rad/s, m/s2 and T (MAVLink, common.xml)."""
UPDATED = {"gyro": 0x38, "acc": 0x07, "mag": 0x1C0}
UPDATED_PRESSURE = 0x200
"""Bits of fields_updated in HIGHRES_IMU."""
SATELLITES = "GPS_RAW_INT"
LEAST_FIX = 3
"""GPS_FIX_TYPE: three dimensions."""
UNKNOWN = 65535
"""Units of a speed over ground and of a course."""


def mavlink_line(message: Any) -> bytes:
    """The line of a table, empty if the message has no new sample."""
    time_field, *per = MAVLINK[message.get_type()]
    new = getattr(message, "fields_updated", 0) or math.inf
    cells = [repr(getattr(message, str(time_field)) * float(per[0]))]
    for (sensor, bits), factor in zip(UPDATED.items(), per[1:]):
        values = [getattr(message, f"{axis}{sensor}") * float(factor) for axis in "xyz"]
        there = new == math.inf or int(new) & bits == bits
        empty = not there or (sensor == "mag" and not any(values))
        cells += ["" if empty else repr(float(value)) for value in values]
    pressure_hpa = getattr(message, "abs_pressure", 0.0)
    there = pressure_hpa > 0 and (new == math.inf or int(new) & UPDATED_PRESSURE)
    return _line([*cells, repr(100.0 * pressure_hpa) if there else ""])


def fix_line(message: Any) -> bytes:
    """The line of a GPS_RAW_INT, empty without a fix. Its time is omitted, because it is of another clock than that of the
    sensors."""
    if message.fix_type < LEAST_FIX:
        return b""
    ellipsoid_mm = getattr(message, "alt_ellipsoid", 0)
    place = [1e-7 * message.lat, 1e-7 * message.lon, 1e-3 * (ellipsoid_mm or message.alt)]
    speed_m_s, course_rad = 1e-2 * message.vel, math.radians(1e-2 * message.cog)
    known = UNKNOWN not in (message.vel, message.cog)
    velocity = [speed_m_s * math.cos(course_rad), speed_m_s * math.sin(course_rad)] if known else ["", ""]
    sigmas = [1e-3 * mm if (mm := getattr(message, name, 0)) else "" for name in ("h_acc", "v_acc", "vel_acc")]
    empty = [""] * (len(CSV_COLUMNS) + 1)
    return _line([*empty, *(cell if cell == "" else repr(float(cell)) for cell in (*place, *velocity, *sigmas))])


def _line(cells: list[str]) -> bytes:
    return ",".join([*cells, *[""] * (len(MAVLINK_COLUMNS) - len(cells))]).encode() + b"\n"


def address_of(text: str) -> tuple[str, int]:
    """Host, perhaps empty, and port of udp://HOST:PORT. Raises HnavValueError."""
    try:
        parts = urlsplit(text)
        host, port = parts.hostname or "", parts.port
    except ValueError:
        port = None
    if port is None:
        raise HnavValueError("option", f"{text}: write {text.partition(':')[0]}://HOST:PORT, such as udp://127.0.0.1:5005")
    return host, port
