"""Solutions of RTKLIB (.pos): latitude, longitude, height, or a baseline east, north, up from the base; with their quality and sigmas.

%  GPST                  latitude(deg) longitude(deg)  height(m)   Q  ns   sdn(m)   sde(m)   sdu(m)  sdne(m) ...
2021/05/01 00:00:00.000   35.681234567  139.767890123    45.1234   1   9   0.0101   0.0090   0.0210   0.0012 ...

Of GPST, UTC or JST, as calendar or as week and seconds; degrees with decimals, or with minutes and seconds (manual of RTKLIB 2.4.2, B.1).
Receivers of Emlid write the same rows without a header.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from hnav.earth import axes_at, place_of, position_of
from hnav.io.aids import AidSamples
from hnav.io.readers.aids import whole
from hnav.io.readers.streams import Raw, Wishes, alone
from hnav.io.recordings import RecordingError

HEADER = re.compile(r"^%[ \t,;]*(GPST|UTC|JST)[ \t,;]+(.*\bQ[ \t,;]+ns\b.*)$", re.MULTILINE)
ROW = re.compile(
    r"\d{4}/\d\d/\d\d[ \t,;]+\d\d:\d\d:\d\d\.\d+(?:[ \t,;]+-?\d+\.\d+){3}[ \t,;]+[1-6][ \t,;]+\d+(?:[ \t,;]+-?\d+\.\d+){8}\s"
)
USUAL = "latitude(deg) longitude(deg) height(m) Q ns sdn(m) sde(m) sdu(m) sdne(m) sdeu(m) sdun(m) age(s) ratio"
BASE = re.compile(r"^% ref pos\s*:\s*([-\d. \t,;]+)$", re.MULTILINE)
PARTS = re.compile(r"[ \t,;]+")
QUALITIES = ("none", "fix", "float", "sbas", "dgps", "single", "ppp")
GPS_EPOCH_S, WEEK_S, JAPAN_S = 315964800.0, 604800.0, 9 * 3600.0
LEAP_SECONDS_SINCE = np.array([1136073600, 1230768000, 1341100800, 1435708800, 1483228800])
"""UTC of the 14th to the 18th leap second of GPS time (IERS Bulletin C)."""
LEAPS_BEFORE = 13


def is_pos(path: Path, head: bytes) -> bool:
    text = head.decode("ascii", "replace")
    return HEADER.search(text) is not None or ROW.match(text) is not None


def read_pos(path: Path, wishes: Wishes) -> Raw:
    """Positions, and velocities where there are. Raises RecordingError."""
    alone(path, wishes)
    text = path.read_bytes().decode("ascii", "replace")
    match = HEADER.search(text)
    system, names = (match.group(1), PARTS.split(match.group(2).strip())) if match else ("GPST", USUAL.split())
    per_angle = 3 if "d'" in names[0] else 1
    rows = [PARTS.split(line.strip()) for line in text.splitlines() if line[:1].isdigit()]
    cut = sum(len(row) < len(names) + 2 * per_angle for row in rows)
    rows = [row for row in rows if len(row) >= len(names) + 2 * per_angle]
    if not rows:
        raise RecordingError(f"{path}: no row of a solution: look at the log of RTKLIB")
    try:
        place, behind = _places(path, text, names, per_angle, [row[2:] for row in rows])
        t_s = _utc_s(system, rows)
        columns = {name.partition("(")[0]: column for name, column in zip(names[3:], np.array(behind, float).T)}
    except RecordingError:
        raise
    except (ValueError, IndexError):
        raise RecordingError(f"{path}: a row is no solution of RTKLIB: look for lines that are not numbers") from None
    aids = _aids_of(t_s, place, columns, above_sea="/geodetic" in text)
    notes = tuple(_notes(system, columns["Q"].astype(int), cut))
    return Raw("rtklib", [], wishes.unit("time", by_format="s"), notes, aids=whole(aids, columns["Q"] > 0), names=())


def _aids_of(t_s: np.ndarray, place: np.ndarray, columns: dict[str, np.ndarray], above_sea: bool) -> dict[str, AidSamples]:
    aids = {"position": AidSamples(t_s, place, _stack(columns, "sdn", "sde", "sdu"), above_sea=above_sea)}
    if "vn" in columns:
        velocity = _stack(columns, "vn", "ve", "vu") * [1, 1, -1]
        aids["velocity"] = AidSamples(t_s, velocity, _stack(columns, "sdvn", "sdve", "sdvu"))
    return aids


def _notes(system: str, quality: np.ndarray, cut: int) -> Iterator[str]:
    counts = zip(QUALITIES, np.bincount(quality, minlength=len(QUALITIES)))
    yield f"positions by quality: {', '.join(f'{name} {count}' for name, count in counts if count)}"
    if system != "UTC":
        yield f"times of {system} were converted to UTC"
    if cut:
        yield f"rows that were cut off: {cut}"


def _stack(columns: dict[str, np.ndarray], *names: str) -> np.ndarray:
    """n x 3; NaN for columns that the file has not."""
    nothing = np.full_like(columns["Q"], np.nan)
    return np.stack([columns.get(name, nothing) for name in names], axis=1)


def _utc_s(system: str, rows: Sequence[Sequence[str]]) -> np.ndarray:
    """Since 1970."""
    import pandas

    if "/" in rows[0][0]:
        instants = pandas.to_datetime([f"{row[0]} {row[1]}" for row in rows], format="%Y/%m/%d %H:%M:%S.%f")
        t_s = np.asarray((instants - pandas.Timestamp(0)).total_seconds(), float)
    else:
        week, seconds = np.array([row[:2] for row in rows], float).reshape(-1, 2).T
        t_s = GPS_EPOCH_S + WEEK_S * week + seconds
    if system == "JST":
        return t_s - JAPAN_S
    return t_s - (LEAPS_BEFORE + np.searchsorted(LEAP_SECONDS_SINCE, t_s, side="right") if system == "GPST" else 0)


def _places(
    path: Path, text: str, names: Sequence[str], per_angle: int, rows: Sequence[Sequence[str]]
) -> tuple[np.ndarray, list[Sequence[str]]]:
    """n x 3: latitude and longitude in rad, height; and the cells behind them. Raises RecordingError for other coordinates."""
    if names[0].startswith("latitude"):
        count = 2 * per_angle + 1
        return np.array([_geodetic(row[:count]) for row in rows]).reshape(-1, 3), [row[count:] for row in rows]
    cure = "choose Lat/Lon/Height in the options of RTKLIB (Output, Solution Format)"
    if not names[0].startswith("e-baseline"):
        raise RecordingError(f"{path}: holds {', '.join(names[:3])}: {cure}")
    if (base := BASE.search(text)) is None:
        raise RecordingError(f"{path}: holds a baseline, and not the place of its base (% ref pos): {cure}")
    place = np.array(_geodetic(PARTS.split(base.group(1).strip())))
    east, north, up = np.array([row[:3] for row in rows], float).reshape(-1, 3).T
    moved = np.stack([north, east, -up], axis=1) @ axes_at(place).T
    return place_of(position_of(place) + moved), [row[3:] for row in rows]


def _geodetic(cells: Sequence[str]) -> tuple[float, float, float]:
    """Of two angles in degrees, or each in degrees, minutes and seconds, and a height."""
    size = len(cells) // 2
    angles = []
    for parts in (cells[:size], cells[size : 2 * size]):
        degrees = sum(abs(float(part)) / 60**power for power, part in enumerate(parts))
        angles.append(float(np.radians(-degrees if parts[0].startswith("-") else degrees)))
    return angles[0], angles[1], float(cells[2 * size])
