"""Attitude in real time: samples come in over UDP, the attitude goes out over UDP.

    python realtime.py 5005 5006

listens on port 5005 of this machine and sends to port 5006. One sample in a datagram, as text: its time in s and nine numbers,
the rate in rad/s, the specific force in m/s2 and the field in T, in sensor axes; nan where there is no new field. One answer
for each sample after the start, which takes two samples of the field: time, quaternion (scalar first, body to north-east-down), heading
and its sigma in deg, and 1 when the heading is ready.

A serial port instead: pip install pyserial, and read lines by `serial.Serial("/dev/ttyUSB0", 115200)` in the place of recv.
"""

from __future__ import annotations

import math
import socket
import sys

from hnav import Filter, HnavError

FIELDS = 10


def numbers(datagram: bytes) -> list[float] | None:
    """The ten numbers of a sample; None for anything else, which a network may bring."""
    try:
        values = [float(word) for word in datagram.decode("ascii").replace(",", " ").split()]
    except (UnicodeDecodeError, ValueError):
        return None
    return values if len(values) == FIELDS else None


def take(filter: Filter, values: list[float]) -> str:
    """The filter uses one sample; the line to send. Raises HnavError before the first attitude, and for what it cannot use."""
    t_s, rate, force, field = values[0], values[1:4], values[4:7], values[7:10]
    filter.push_imu(t_s, rate, force)
    if not any(math.isnan(value) for value in field):
        filter.push_mag(t_s, field)
    filter.advance(t_s)
    attitude = filter.attitude()
    heading_deg, sigma_deg = math.degrees(attitude.heading_rad) % 360, math.degrees(attitude.sigma_rad[2])
    return f"{t_s:.6f} {' '.join(f'{q:.9f}' for q in attitude.q_nb)} {heading_deg:.3f} {sigma_deg:.3f} {attitude.heading_ready:d}"


def serve(incoming: socket.socket, to: tuple[str, int], samples: int | None = None) -> Filter:
    """Answers every sample, or so many of them."""
    filter = Filter("ahrs")
    while samples is None or samples > 0:
        values = numbers(incoming.recv(4096))
        if values is None:
            continue
        try:
            incoming.sendto(take(filter, values).encode("ascii"), to)
        except HnavError as problem:  # a late sample, NaN, no attitude yet: the filter goes on with the next one
            print(problem, file=sys.stderr)
        samples = None if samples is None else samples - 1
    return filter


if __name__ == "__main__":
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as here:
        here.bind(("127.0.0.1", int(sys.argv[1])))
        serve(here, ("127.0.0.1", int(sys.argv[2])))
