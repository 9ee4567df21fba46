"""Sentences of GNSS receivers in NMEA 0183: GGA (place), RMC (date and velocity), GST (sigmas).

Times are those of the receiver, in s since 1970 by the date of RMC, else since midnight. Where a logger wrote its own time
in s before every sentence, that is the time of all of it.

Not by pynmeagps, which takes eight times as long and refuses sentences without a checksum.
"""

from __future__ import annotations

import datetime
import re
from functools import reduce
from operator import xor
from pathlib import Path

import numpy as np

from hnav.io.aids import AidSamples
from hnav.io.readers.aids import along, whole
from hnav.io.readers.streams import Raw, Wishes, alone
from hnav.io.recordings import RecordingError

SENTENCE = re.compile(r"^([\d.]*)[,;\s]*\$G?[A-Z]?([A-Z]{3}),([^*\r\n]*)(?:\*([0-9A-Fa-f]{2}))?", re.MULTILINE)
RANGE_ERROR_M = 2.0
"""Sigma in m per unit of dilution of precision, used without a GST sentence."""
DAY_S = 86400.0
KNOT_M_S = 1852 / 3600


def is_nmea(path: Path, head: bytes) -> bool:
    return b"\0" not in head and re.search(rb"^[\d.,;\s]*\$G[A-Z](GGA|RMC),", head, re.MULTILINE) is not None


def read_nmea(path: Path, wishes: Wishes) -> Raw:
    """Positions and velocities. Raises RecordingError for a file without a fix, and when inertial samples are required."""
    alone(path, wishes)
    log = Sentences()
    for match in SENTENCE.finditer(path.read_bytes().decode("ascii", "replace")):
        if _is_whole(match):
            log.take(match)
    if not (aids := log.aids()):
        raise RecordingError(f"{path}: no sentence GGA or RMC with a fix: look whether the receiver saw satellites")
    return Raw("nmea", [], wishes.unit("time", by_format="s"), aids=aids, names=())


def _is_whole(match: re.Match[str]) -> bool:
    """Whether the checksum, if there is one, is right."""
    text, checksum = match.group(0), match.group(4)
    return checksum is None or has_checksum(text[text.index("$") + 1 : text.rindex("*")], checksum)


def has_checksum(body: str, checksum: str) -> bool:
    """Whether the hexadecimal digits behind * are those of what stands between it and $."""
    return reduce(xor, map(ord, body), 0) == int(checksum, 16)


LIVE_COLUMNS = ("t_s", "lat_deg", "lon_deg", "alt_m", "vn", "ve", "sigma_h", "sigma_v")


class Sentences:
    """Decodes sentences in order, of a file or as they arrive."""

    def __init__(self) -> None:
        self._midnight_s: float | None = None
        self._last_s = 0.0
        self._above_sea = False  # a GGA without the height of the geoid
        self._sigmas: dict[float, tuple[float, float]] = {}
        self._places: list[tuple[float, ...]] = []  # time, logger's time, latitude, longitude, height, sigma h, sigma v
        self._velocities: list[tuple[float, ...]] = []  # time, logger's time, speed, course

    def take(self, match: re.Match[str]) -> None:
        """A whole sentence, as SENTENCE finds it."""
        logged, kind, cells = match.group(1), match.group(2), match.group(3).split(",")
        try:
            logged_s = float(logged) if logged else np.nan
            if kind == "GGA" and cells[5] not in ("", "0"):
                height = _number(cells[8]) + (_number(cells[10]) if cells[10] else 0.0)
                self._above_sea = self._above_sea or not cells[10]
                spread = RANGE_ERROR_M * _number(cells[7])
                t_s, latitude, longitude = self._time(cells[0]), _angle(cells[1], cells[2]), _angle(cells[3], cells[4])
                self._places.append((t_s, logged_s, latitude, longitude, height, spread, 1.5 * spread))
            elif kind == "RMC" and cells[1] == "A":
                speed, t_s = _number(cells[6]), self._time(cells[0])
                self._velocities.append((t_s, logged_s, speed * KNOT_M_S, np.radians(_number(cells[7]) if speed else 0.0)))
                self._date(cells[8])
            elif kind == "GST":
                horizontal, vertical = np.hypot(_number(cells[5]), _number(cells[6])) / np.sqrt(2), _number(cells[7])
                self._sigmas[self._time(cells[0])] = float(horizontal), vertical
        except (ValueError, IndexError):
            pass  # cut off, or without a number: no sample

    def aids(self) -> dict[str, AidSamples]:
        """All samples so far."""
        found = {}
        if self._places:
            table = np.array(self._places)
            sigma = np.array([(h, h, v) for h, v in (self._sigmas.get(row[0], (row[5], row[6])) for row in self._places)])
            found["position"] = AidSamples(self._times(table), table[:, 2:5], sigma, above_sea=self._above_sea)
        if self._velocities:
            table = np.array(self._velocities)
            velocity = along(table[:, 2], table[:, 3])
            found["velocity"] = AidSamples(self._times(table), velocity, np.full_like(velocity, np.nan))
        return {kind: one for kind, one in whole(found).items() if len(one.t_s)}

    def cells(self, text: str) -> list[str | float] | None:
        """Under LIVE_COLUMNS; empty where it has neither place nor velocity, None for what is no whole sentence. The time is what a
        logger wrote before it; sigmas are by the newest GST."""
        match = SENTENCE.match(text)
        if match is None or not _is_whole(match):
            return None
        self.take(match)
        found = self._newest()
        return [match.group(1), *(found.get(name, "") for name in LIVE_COLUMNS[1:])] if found else []

    def _newest(self) -> dict[str, float]:
        """Samples since the last call, by column names."""
        self._sigmas = {self._places[-1][0] if self._places else t_s: sigma for t_s, sigma in [*self._sigmas.items()][-1:]}
        found, values = self.aids(), dict[str, float]()
        self._places.clear()
        self._velocities.clear()
        if one := found.get("position"):
            values = dict(zip(("lat_deg", "lon_deg"), np.degrees(one.values[-1, :2]).tolist()))
            values |= {"alt_m": float(one.values[-1, 2])}
            values |= {"sigma_h": float(one.sigma[-1, 0]), "sigma_v": float(one.sigma[-1, 2])}
        if one := found.get("velocity"):
            values |= dict(zip(("vn", "ve"), one.values[-1].tolist()))
        return values

    def _times(self, table: np.ndarray) -> np.ndarray:
        logged_s = table[:, 1]
        if np.isfinite(logged_s).all():
            return np.asarray(logged_s)
        return np.asarray(table[:, 0] + (self._midnight_s or 0.0))

    def _time(self, cell: str) -> float:
        """Since the midnight before the first fix: a clock that falls back by most of a day has passed another."""
        hours, minutes, seconds = int(cell[:2]), int(cell[2:4]), float(cell[4:])
        t_s = 3600 * hours + 60 * minutes + seconds
        t_s += DAY_S * round((self._last_s - t_s) / DAY_S) if self._last_s - t_s > DAY_S / 2 else 0.0
        self._last_s = t_s
        return t_s

    def _date(self, cell: str) -> None:
        """ddmmyy of the first RMC."""
        if self._midnight_s is None and len(cell) == 6:
            year = 2000 + int(cell[4:]) if int(cell[4:]) < 80 else 1900 + int(cell[4:])
            day = datetime.datetime(year, int(cell[2:4]), int(cell[:2]), tzinfo=datetime.UTC)
            self._midnight_s = day.timestamp() - DAY_S * np.floor(self._last_s / DAY_S)


def _number(cell: str) -> float:
    return float(cell) if cell else np.nan


def _angle(cell: str, side: str) -> float:
    """ddmm.mmmm or dddmm.mmmm, in rad; south and west are negative."""
    point = cell.index(".") if "." in cell else len(cell)
    degrees = int(cell[: point - 2]) + float(cell[point - 2 :]) / 60
    return float(np.radians(-degrees if side in "SW" and side else degrees))
