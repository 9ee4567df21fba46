"""Lines that arrive while a device runs become rows of samples in SI units: CSV with or without a header, JSON objects.

    lines = LiveLines(Wishes(gyro_unit="deg/s"))
    rows = lines.take(source.wait(0.1))     # n x 10: t_s, rate, force, field; NaN where a sample is missing
    lines = LiveLines(Wishes(), aids=True)  # AID_COLUMNS too; satellites also as sentences of NMEA 0183

Columns, units and axes are found as in files (hnav.io.readers). Lines that give no row are counted by reason.
"""

from __future__ import annotations

import json
import math
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from hnav.io.live_sources import Chunk
from hnav.io.readers.aids import along, pressure_factor
from hnav.io.readers.cells import BLANKS, DELIMITERS, is_number
from hnav.io.readers.clock import WITHIN_S, unit_by_size
from hnav.io.readers.columns import Column, columns_of
from hnav.io.readers.layout import Layout
from hnav.io.readers.long_tables import is_sensor, plan_of_long
from hnav.io.readers.nmea import LIVE_COLUMNS, Sentences
from hnav.io.readers.serial_text import of_vectornav
from hnav.io.readers.streams import Wishes, turned
from hnav.io.readers.tables import Table, missing_column, stream_of
from hnav.io.readers.trees import AXES, KINDS, flattened
from hnav.io.recordings import ARRAYS, CSV_COLUMNS, RecordingError
from hnav.native.arrays import Array
from hnav.units import si_per

AID_COLUMNS = ("lat_deg", "lon_deg", "alt_m", "vn", "ve", "vd", "sigma_h", "sigma_v", "sigma_vel", "pressure_pa", "speed_m_s")
"""Columns of aiding samples, after CSV_COLUMNS in a row."""
OVER_GROUND = ("ground_speed", "course_deg")
"""Columns that may replace vn and ve."""
OF_AIDS = frozenset(AID_COLUMNS + OVER_GROUND)
INERTIAL = slice(1, len(CSV_COLUMNS))
WITH_SIGMAS = (
    ("lat_deg", "lon_deg", "alt_m", "sigma_h", "sigma_v"),
    ("vn", "ve", "vd", "sigma_vel"),
    ("pressure_pa",),
    ("speed_m_s",),
)
"""Columns that form one aiding sample."""
SAMPLES = (
    *(tuple(f"{sensor[0]}{axis}" for axis in "xyz") for sensor in ARRAYS),
    *(tuple(name for name in names if not name.startswith("sigma")) for names in WITH_SIGMAS),
)
"""The values of one sample."""
PROBE_LINES, PROBE_S = 50, 1.0
"""Lines, or seconds of lines, that are read before the first row is returned: units are inferred from several lines."""
LONGEST_LINE = 65_536
"""Bytes without an end of line after which the input is not text."""
SET_AHEAD_S = 3600.0
"""Seconds by which a time stamp may advance more than the time of arrival; beyond that the source clock was set."""
FEWEST_COLUMNS = 6
"""Columns that identify a header: the axes of a gyroscope and an accelerometer."""
MOST_UNTIMED = 64
"""Samples without a time of their own that wait for the next row."""
BESIDE_S = 1e-6
"""Delay of a row that repeats the previous time stamp with other sensors."""
SHOWN = "the source"
SHOWN_CHARACTERS = 60
HOW_TO_WRITE = (
    "write t_s,gx,gy,gz,ax,ay,az in a line (empty cells where there is no sample), or JSON such as "
    '{"t": 0.01, "sensor": "gyro", "x": 0.1, "y": 0, "z": 0}; hnav filter reads recorded files of other shapes'
)
SHOWN_SETS = 5
"""Number of clock changes that are reported; later ones are only counted."""


class Line(NamedTuple):
    """Kinds of content of a line."""

    names: tuple[str, ...]
    cells: Sequence[Any]
    arrived_s: float


@dataclass(frozen=True)
class Scheme:
    """How the cells of a line become a row."""

    places: tuple[int, ...]
    """Column of each of the ten numbers of a row; -1: none."""
    factors: tuple[float, ...]
    table: Table
    """Number of lines that determined the plan."""

    def row(self, cells: Sequence[Any]) -> list[float]:
        """Raises ValueError, TypeError or IndexError for a line that is not a sample."""
        return [
            math.nan if place < 0 or cells[place] in ("", None) else float(cells[place]) * factor
            for place, factor in zip(self.places, self.factors)
        ]

    def has(self, sensor: str) -> bool:
        """Whether its lines have the axes of a sensor."""
        return self.places[CSV_COLUMNS.index(f"{sensor[0]}x")] >= 0


class LiveClock:
    """Increasing times for any time stamps: after the source clock was set, time advances by the times of arrival."""

    def __init__(self) -> None:
        self._last_s, self._arrived_s, self._offset_s = math.nan, math.nan, 0.0

    def ahead_s(self, stamp_s: float) -> float:
        """Time in s from the newest row to this stamp; NaN at the first row."""
        return stamp_s + self._offset_s - self._last_s

    def is_strange(self, stamp_s: float, arrived_s: float) -> bool:
        """Whether a time stamp decreases, or advances more than the time of arrival: the clock was set, or this stamp is wrong."""
        ahead_s = self.ahead_s(stamp_s)
        return ahead_s < -WITHIN_S or ahead_s > max(0.0, arrived_s - self._arrived_s) + WITHIN_S

    def take(self, stamp_s: float, arrived_s: float, beside: bool) -> tuple[float, float]:
        """The time of a row, NaN if it is too late to be used; and by how much the clock was set, 0 if it was not. beside: it has
        other sensors than the row before."""
        t_s, set_s = stamp_s + self._offset_s, 0.0
        waited_s = arrived_s - self._arrived_s
        ahead_s = self.ahead_s(stamp_s)
        if ahead_s < -WITHIN_S or ahead_s > waited_s + SET_AHEAD_S:
            set_s = ahead_s
            t_s = self._last_s + max(waited_s, BESIDE_S)
            self._offset_s = t_s - stamp_s
        elif -len(ARRAYS) * BESIDE_S < ahead_s <= 0 and beside:
            t_s = self._last_s + BESIDE_S
        elif ahead_s <= 0:
            return math.nan, 0.0
        self._last_s, self._arrived_s = t_s, arrived_s
        return t_s, set_s


class LiveLines:
    """Decoder of a stream of lines.

    wishes: columns, units, axes, rate_hz, drop_repeats as of hnav.read. aids: with AID_COLUMNS; what aids comes into the next row where its line
    has no time, as a sentence of NMEA, or a time that does not go on from the newest row. Raises RecordingError from take when the lines have no columns of times, a gyroscope and an accelerometer.
    """

    def __init__(self, wishes: Wishes, aids: bool = False):
        self.counts: Counter[str] = Counter()
        """Numbers of lines, of rows, and of ignored lines by reason."""
        self.notes: list[str] = []
        """Assumptions and corrections; the caller prints them and empties the list."""
        self.columns = CSV_COLUMNS + (AID_COLUMNS if aids else ())
        """Of a row."""
        self._roles = self.columns + (OVER_GROUND if aids else ())
        self._sentences = Sentences() if aids else None
        self._untimed: list[list[float]] = []
        self._wishes, self._clock = wishes, LiveClock()
        self._rest, self._connection = b"", 0
        self._names: tuple[str, ...] = ()
        self._delimiter = ","
        self._schemes: dict[tuple[str, ...], Scheme | None] = {}
        self._probe: list[Line] | None = []
        self._before: list[float] = [math.nan] * len(self.columns)
        self._held: tuple[list[float], float] | None = None
        self._samples = [self._places(names) for names in (SAMPLES if aids else SAMPLES[: len(ARRAYS)])]
        self._newest: dict[int, list[float]] = {}
        self._timed = 0
        self._left: list[bytes] = []

    def take(self, chunks: Sequence[Chunk], ending: bool = False) -> Array:
        """The rows of these bytes. ending: the source has ended."""
        lines = [line for chunk in chunks for line in self._lines(chunk)]
        if not lines and not self._probe:
            self._refuse_other_lines(ending)
        if self._probe is not None:
            self._probe += lines
            if not self._probed(ending):
                return np.empty((0, len(self.columns)))
            lines, self._probe = self._probe, None
            self._find_schemes(lines)
        rows = [timed for line in lines if (row := self._row(line)) for timed in self._in_time(row, line.arrived_s)]
        if ending and self._held:
            rows += self._placed(*self._held)
        self.counts["rows"] += len(rows)
        return np.array(rows, float).reshape(-1, len(self.columns))

    def _probed(self, ending: bool) -> bool:
        """Whether enough lines, or enough time, have passed to infer units."""
        tables = [line for line in self._probe or () if line.names != LIVE_COLUMNS]
        known = [line for line in tables if any(is_number(str(cell)) for cell in line.cells)]
        return bool(known) and (ending or len(known) >= PROBE_LINES or time.monotonic() - known[0].arrived_s > PROBE_S)

    # ----------------------------------------------------------------------------------------- text

    def _lines(self, chunk: Chunk) -> list[Line]:
        """The complete lines that may be samples; a partial line waits for the next chunk of the same connection."""
        if chunk.connection != self._connection:
            self.counts["cut off"] += bool(self._rest)
            self._rest, self._connection = b"", chunk.connection
        *whole, self._rest = (self._rest + chunk.data).replace(b"\r", b"\n").split(b"\n")
        if len(self._rest) > LONGEST_LINE:
            self._rest = b""
            self._leave_out(b"a line without end")
        found = []
        for line in whole:
            if line.strip():
                self.counts["lines"] += 1
                found += [Line(*parts, chunk.arrived_s)] if (parts := self._parted(line)) else []
        return found

    def _parted(self, line: bytes) -> tuple[tuple[str, ...], Sequence[Any]] | None:
        """Names and cells; None for a header, which names the columns of the lines after it, and for other content."""
        try:
            text = line.decode().strip()
            if text.startswith("{"):
                values = _by_sensor(dict(flattened(json.loads(text))))
                return tuple(values), tuple(values.values())
            if (sentence := of_vectornav(text)) is not None:
                return tuple(sentence), tuple(sentence.values())
            if self._sentences and (cells := self._sentences.cells(text)) is not None:
                self.counts["other sentences"] += not cells
                return (LIVE_COLUMNS, cells) if cells else None
        except (ValueError, RecursionError, AttributeError):
            self._leave_out(line)
            return None
        if not self._names or not (text[0] in "0123456789.+-" or text.startswith(self._delimiter)):
            return self._begin(text)
        if self._delimiter != ",":  # then it is a decimal one
            text = text.replace(",", ".")
        return self._names, text.split() if self._delimiter == BLANKS else [cell.strip() for cell in text.split(self._delimiter)]

    def _begin(self, text: str) -> tuple[tuple[str, ...], Sequence[Any]] | None:
        """Handles a line without a preceding header, which may itself be a header."""
        parted = {mark: text.split() if mark == BLANKS else [cell.strip() for cell in text.split(mark)] for mark in DELIMITERS}
        of_numbers = [mark for mark, cells in parted.items() if all(map(is_number, filter(None, cells)))]
        if of_numbers:
            delimiter = max(of_numbers, key=lambda mark: len(parted[mark]))
            names = self._names_of_places(len(parted[delimiter]))
        else:
            headers = {**parted, BLANKS: text.lstrip("#% ").split()}
            delimiter = max(headers, key=lambda mark: len(self._columns(headers[mark])))
            names = tuple(headers[delimiter])
            if len(self._columns(names)) < FEWEST_COLUMNS:
                names = ()
        if not names:
            self._leave_out(text.encode())
            return None
        self._names, self._delimiter = names, delimiter
        return self._parted(text.encode()) if of_numbers else None

    def _names_of_places(self, count: int) -> tuple[str, ...]:
        """The columns of numbers without a header: named by their positions, or in the order of CSV_COLUMNS, with or without times."""
        if self._wishes.columns:
            return tuple(str(place + 1) for place in range(count))
        begin = 1 if self._wishes.rate_hz else 0
        of_time = "t"  # its unit is found by the intervals: t_s would state one
        named = next(((of_time, *CSV_COLUMNS[1:end])[begin:] for end in (7, 10) if end - begin == count), ())
        if named:
            self.notes.append(f"no header: taken for {','.join(named)} in SI units")
        return named

    def _refuse_other_lines(self, ending: bool) -> None:
        """Raises RecordingError when the source has ended, or many lines have arrived, without a sample."""
        if self.counts["rows"] or not self._left or not (ending or self.counts["no sample"] >= PROBE_LINES):
            return
        if plan_of_long(b"\n".join(self._left).decode("utf-8", "replace")):
            raise RecordingError(f"{SHOWN}: each line is of one sensor: {HOW_TO_WRITE}")
        if ending:
            shown = repr(self._left[0][:SHOWN_CHARACTERS])[2:-1]
            raise RecordingError(f"{SHOWN}: no line is a sample, the first is {shown}: {HOW_TO_WRITE}")

    def _leave_out(self, line: bytes) -> None:
        self.counts["no sample"] += 1
        if len(self._left) < PROBE_LINES and not self.counts["rows"]:
            self._left.append(line)
        if self.counts["no sample"] == 1:
            shown = repr(line[:SHOWN_CHARACTERS])[2:-1]  # control characters must not reach a terminal
            self.notes.append(f"a line is no sample, the first of those that are counted: {shown}")

    # ----------------------------------------------------------------------------------------- rows

    def _columns(self, names: Sequence[str]) -> dict[str, Column]:
        """The plan for lines of inertial and magnetic samples. Raises RecordingError."""
        found = columns_of(names, self._wishes.columns, SHOWN)
        return {role: column for role, column in found.items() if role in self._roles}

    def _find_schemes(self, lines: Sequence[Line]) -> None:
        """Raises RecordingError when these columns together lack the times or a sensor."""
        for names in dict.fromkeys(line.names for line in lines):
            self._scheme(names, [line for line in lines if line.names == names])
        found = [scheme for scheme in self._schemes.values() if scheme]
        for sensor in ("gyro", "accel"):
            if not any(scheme.has(sensor) for scheme in found):
                empty = Table({}, {}, Layout(-1, [*lines[0].names], ","))
                table = found[0].table if found else empty
                raise RecordingError(missing_column(SHOWN, table, *(f"{sensor[0]}{axis}" for axis in "xyz")))

    def _scheme(self, names: tuple[str, ...], lines: Sequence[Line]) -> Scheme | None:
        """The plan for lines with these names; None where they have no samples. The first line determines units."""
        if names not in self._schemes:
            self._schemes[names] = self._new_scheme(names, lines)
        return self._schemes[names]

    def _new_scheme(self, names: tuple[str, ...], lines: Sequence[Line]) -> Scheme | None:
        columns = self._columns(names)
        if not any(role != "t_s" for role in columns):
            return None
        values = {role: np.array([_number(line.cells, column.place) for line in lines]) for role, column in columns.items()}
        table = Table(columns, values, Layout(-1, [*names], ","))
        places, factors = [-1] * len(self._roles), [1.0] * len(self._roles)
        if self._wishes.rate_hz is None and ("t_s" in columns or not all(column.aids for column in columns.values())):
            places[0], factors[0] = self._time_of(table)
        for role in OF_AIDS & columns.keys():
            column, at = columns[role], self._roles.index(role)
            places[at] = column.place
            factors[at] = column.factor * (pressure_factor(column, values[role]) if role == "pressure_pa" else 1.0)
        for sensor in ARRAYS:
            if any(f"{sensor[0]}{axis}" in columns for axis in "xyz"):
                at = CSV_COLUMNS.index(f"{sensor[0]}x")
                places[at : at + 3], factors[at : at + 3] = zip(*self._axes_of(sensor, table))
        return Scheme(tuple(places), tuple(factors), table)

    def _time_of(self, table: Table) -> tuple[int, float]:
        """Place of the time, and its unit in s. Raises RecordingError."""
        column = table.columns.get("t_s")
        if column is None:
            raise RecordingError(f"{missing_column(SHOWN, table, 't_s')}, or give rate_hz")
        unit = unit_by_size(table.values["t_s"], self._wishes.unit("time", column.unit), table.columns)
        if unit.is_inferred:
            self.notes.append(f"time: {unit}")
        return column.place, si_per("time", unit.name)

    def _axes_of(self, sensor: str, table: Table) -> list[tuple[int, float]]:
        """Of x, y and z: place, and unit with its sign in SI. Raises RecordingError."""
        unit = stream_of(SHOWN, table, sensor, table.values[f"{sensor[0]}x"], self._wishes, None).unit
        if unit.source != "by header":
            self.notes.append(f"{sensor}: {unit}")
        order, signs = turned(self._wishes.axes.get(sensor, "x,y,z"))
        columns = [table.columns[sensor[0] + "xyz"[source]] for source in order]
        return [(column.place, float(sign * column.sign) * si_per(sensor, unit.name)) for column, sign in zip(columns, signs)]

    def _row(self, line: Line) -> list[float] | None:
        """A row with the stamp of its line; None, and counted, for a line without a sample."""
        row = self._numbers(line)
        if row is None:
            self._leave_out(",".join(map(str, line.cells)).encode())
            return None
        if self._wishes.drop_repeats and not self._drop_repeats(row):
            self.counts["repeated"] += 1
            return None
        return row

    def _in_time(self, row: list[float], arrived_s: float) -> list[list[float]]:
        """Rows with times that increase. A row with a strange stamp waits for the next one: when that goes on from the row before, the
        stamp was wrong, and lies between both."""
        if all(map(math.isnan, row[INERTIAL])) and not self._is_next(row[0], arrived_s):
            self._untimed.append(row)
            if len(self._untimed) > MOST_UNTIMED:
                self._untimed.pop(0)
                self.counts["late"] += 1
            return []
        done: list[list[float]] = []
        if self._held:
            (held, held_arrived_s), self._held = self._held, None
            if self._is_next(row[0], arrived_s):
                held[0] = row[0] - 0.5 * self._clock.ahead_s(row[0])
                self.counts["stamps mended"] += 1
            done += self._placed(held, held_arrived_s)
        if self._clock.is_strange(row[0], arrived_s):
            self._held = row, arrived_s
            return done
        return done + self._placed(row, arrived_s)

    def _is_next(self, stamp_s: float, arrived_s: float) -> bool:
        """Whether a stamp of a satellite fix follows the newest row; if it is late or of another clock, the fix joins the
        next row."""
        return self._clock.ahead_s(stamp_s) > 0 and not self._clock.is_strange(stamp_s, arrived_s)

    def _placed(self, row: list[float], arrived_s: float) -> list[list[float]]:
        """The row at its time; None if it is late."""
        beside = all(math.isnan(new) or math.isnan(old) for new, old in zip(row[1:], self._before[1:]))
        t_s, set_s = self._clock.take(row[0], arrived_s, beside)
        if math.isnan(t_s):
            self.counts["late"] += 1
            return []
        if set_s:
            self.counts["clock set"] += 1
            if self.counts["clock set"] <= SHOWN_SETS:
                self.notes.append(f"the clock of the source was set by {set_s:+.6g} s; time goes on from {t_s:.10g} s")
        row[0], self._before = t_s, row
        self._untimed = [one for one in self._untimed if not self._put_into(row, one)]
        return [row]

    def _places(self, names: Sequence[str]) -> list[int]:
        return [self.columns.index(name) for name in names]

    def _put_into(self, row: list[float], untimed: list[float]) -> bool:
        """Moves waiting samples into a row that has none of their kind; returns whether all were moved."""
        left = False
        for places in map(self._places, WITH_SIGMAS):
            if all(math.isnan(untimed[place]) for place in places):
                continue
            if all(math.isnan(row[place]) for place in places):
                for place in places:
                    row[place], untimed[place] = untimed[place], math.nan
            else:
                left = True
        return not left

    def _numbers(self, line: Line) -> list[float] | None:
        """The ten numbers of a row; None for a line without time or sample, or with other content."""
        scheme = self._scheme(line.names, [line])
        if scheme is None or len(line.cells) > len(line.names):
            return None
        try:
            row = scheme.row(line.cells)
        except (ValueError, TypeError, IndexError, OverflowError):
            return None
        row = self._along_the_ground(row)
        is_inertial = not all(map(math.isnan, row[INERTIAL]))
        if self._wishes.rate_hz is not None and is_inertial:
            row[0] = self._timed / self._wishes.rate_hz
            self._timed += 1
        if (math.isnan(row[0]) and is_inertial) or any(map(math.isinf, row)) or all(map(math.isnan, row[1:])):
            return None
        return row

    def _along_the_ground(self, row: list[float]) -> list[float]:
        """With vn and ve in the place of a speed over ground and its course."""
        made, (speed, course_deg) = row[: len(self.columns)], row[len(self.columns) :] or (math.nan, math.nan)
        if speed >= 0 and (speed == 0 or math.isfinite(course_deg)) and math.isnan(made[(at := self.columns.index("vn"))]):
            made[at : at + 2] = along(np.array([speed]), np.radians([course_deg if speed else 0.0]))[0, :2].tolist()
        return made

    def _drop_repeats(self, row: list[float]) -> bool:
        """Empties the samples that repeat their predecessor; returns whether any sample remains."""
        for places in self._samples:
            values = [row[place] for place in places]
            if repr(values) == repr(self._newest.get(places[0])):  # a vertical velocity may be NaN
                for place in places:
                    row[place] = math.nan
            elif not all(map(math.isnan, values)):
                self._newest[places[0]] = values
        return not all(map(math.isnan, row[1:]))


def _by_sensor(values: dict[str, Any]) -> dict[str, Any]:
    """An object of one sensor, named by a text in it, with its axes renamed after the sensor."""
    sensor = next((str(values[kind]) for kind in KINDS if kind in values and is_sensor(str(values[kind]))), "")
    return {f"{sensor}_{name}" if sensor and name.lower() in AXES else name: value for name, value in values.items()}


def _number(cells: Sequence[Any], place: int) -> float:
    try:
        return math.nan if cells[place] in ("", None) else float(cells[place])
    except (ValueError, TypeError, IndexError):
        return math.nan
