"""What a column is, by its name: gx, GyroX, acc_x_g, "Gyroscope X (deg/s)", angular_velocity.x, w_RS_S_x [rad s^-1], magnetometer_ga[0]."""

from __future__ import annotations

import functools
import itertools
import re
import unicodedata
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from hnav.io.readers.aid_columns import ABOVE_ELLIPSOID, ABOVE_SEA, LEAST_OF_A_FIX, PER, ROLES, aid_column, aid_unit
from hnav.io.readers.unit_names import BEHIND_BRACKETS, is_counts, may_be_unit, only_sensor_of, spelled_unit, words_in, words_of
from hnav.io.recordings import ARRAYS, CSV_COLUMNS, RecordingError

WHOLE = CSV_COLUMNS[:7]
"""Roles of a table with all samples that a filter needs."""

STEMS = {
    "gyro": "g w pqr gyr gyro gyros gyroscope omega rate gy gyroadc angularvelocity angularrate angvel rotationrate turnrate gyrorotation wrs gyrorate "
    "gyroskop drehrate winkelgeschwindigkeit giroscopio vitesseangulaire velocitaangolare velocidadangular",
    "accel": "a ac acc acce accl accel accsmooth accelerometer acceleration f force specificforce ars totalacceleration accelerometeracceleration gforce "
    "beschleunigung beschl aceleracion accelerazione",
    "mag": "m mag magadc magn magnet magnetometer magnetic magneticfield field b h magnetfeld champmagnetique campomagnetico",
}
SENSOR_OF = {stem: sensor for sensor, stems in STEMS.items() for stem in stems.split()}
# Words of columns that are not raw readings of a sensor.
NOT_READ = words_of(
    "free bias sigma std cov covariance var delta vel quat quaternion euler ref truth gps abs absolute norm "
    "increment inc heading location angle sum error noise scale stddev"
)
FILLERS = words_of(
    "imu sensor sensors raw cal calibrated uncalibrated uncal data body s value phone device watch xsens message msg ln wr"
)
WORSE = {"raw": 1, "uncalibrated": 1, "uncal": 1, "wr": 1, "motion": 1, "linear": 2, "lin": 2, "user": 4, "total": -1}
"""Added to the rank by words of a name. wr: of wide range, beside one of low noise (Shimmer); motion: of a filter of iOS, beside the
readings; total: with gravity, beside one without (Sensor Logger)."""
BY_UNIT_ALONE = 3
"""The rank of a column that only its unit identifies."""

LONGEST_NAME = 150
"""Longest name in characters: the search for words takes time that grows with the cube of the length."""

QUANTITY_OF = {"t": "time", "g": "gyro", "a": "accel", "m": "mag", "d": "accel"}
"""By the first letter of a role."""
GRAVITY = ("dx", "dy", "dz")
"""Roles of gravity beside an acceleration without it."""

OF_APPLE = ["accelerometer", "acceleration"]
"""accelerometerAccelerationX of SensorLog: Apple's accelerometers measure the negative specific force."""
OF_GF = (["gf"], ["g", "f"])
DESCRIBED = FILLERS - {"raw"} | words_of("left right front back body frame axis x y z hand foot leg arm head chest")
"""Texts in brackets after a name that are no units."""

TIME_STEMS = words_of(
    "t time utime timestamp timestamps ts itow datetime date clock epoch elapsed stamp loggingtime sampletime zeit zeitstempel temps tiempo tempo"
)
TIME_FILLERS = words_of(
    "sample sensor log logging rtc unix system startup boot reboot offset in gps i tow elapsed utc relative since start header of app recording cal sync formatted decimal"
)

CLOCKS = words_of("rtc unix tow elapsed utc startup boot reboot")
"""Of these fillers one alone may be a column of times."""

MINUTES, SECONDS = words_of("min minute minutes"), words_of("sec secs second seconds")

OWN_TIMES = {"gyro": "t_g", "accel": "t_a", "mag": "t_m"}
"""Roles of the times of one sensor, in a table whose sensors have their own."""
FRACTION = "t_ns"
"""Role of the nanoseconds of times whose whole seconds have a column of their own."""
DAY = "t_day"
"""Role of the date of times of a clock."""
OF_A_DATE = 2
"""The rank of a date alone."""
OF_A_SENSOR = 3
"""The rank of times named after a sensor."""


@dataclass(frozen=True)
class Column:
    """The content of a column."""

    role: str
    """One of CSV_COLUMNS, or of the ROLES of aiding samples."""
    name: str
    """The name in the file."""
    place: int
    unit: str | None = None
    rank: int = 0
    """Among columns of one role, the lowest rank is taken."""
    sign: float = 1.0
    strange: str = ""
    """The unit name in the file, if it is unknown."""

    @property
    def aids(self) -> bool:
        """Whether it is of an aiding sensor, so that others can do without it."""
        return self.role in ROLES

    @property
    def of_fix(self) -> bool:
        """Whether its cells may be words, such as 3D."""
        return self.role in LEAST_OF_A_FIX

    @property
    def factor(self) -> float:
        """For aiding samples: factor to the first unit of the quantity, with the sign."""
        return self.sign * (PER[ROLES[self.role]][self.unit] if self.unit else 1.0)


def with_unit(column: Column, text: str) -> Column:
    """This column with the unit named by a text, if it names one."""
    if column.aids:
        return replace(column, unit=aid_unit(ROLES[column.role], text))
    quantity = QUANTITY_OF[column.role[0]]
    spelled = spelled_unit(quantity, text)
    strange = not spelled and (is_counts(text) if quantity == "time" else may_be_unit(text))  # of times UTC and unix are no units
    return replace(column, unit=spelled, strange=text.strip() if strange else "")


def column_of(name: str, place: int, sensor: str | None = None) -> Column | None:
    """The content of a column with this name; sensor: of a file with samples of one sensor, whose axes may be called x, y, z."""
    return None if len(name.strip()) > LONGEST_NAME else _column_of(name, place, sensor)


@functools.lru_cache(maxsize=4096)  # serial text repeats the names in each line
def _column_of(name: str, place: int, sensor: str | None) -> Column | None:
    text = name.strip().strip('"').lstrip("#% ")
    if text in CSV_COLUMNS:
        return Column(text, name, place, "s" if text == "t_s" else None, rank=-5)
    bare, unit, index = _split(text)
    bare = _without_accents(bare)
    tokens = words_in(bare)
    found = _time_column(tokens, unit, name, place) or _sensor_column(tokens, unit, index, name, place, sensor)
    if found is None and (aid := aid_column(name)):
        datum = 0 if aid.role != "alt_m" else -2 if ABOVE_ELLIPSOID.search(name) else 2 if ABOVE_SEA.search(name) else 0
        return Column(aid.role, name, place, aid.unit, rank=datum + (0 if aid.unit else 1), sign=aid.sign)
    return found


def _without_accents(text: str) -> str:
    return "".join(letter for letter in unicodedata.normalize("NFKD", text) if not unicodedata.combining(letter))


def _split(text: str) -> tuple[str, str, str | None]:
    """Name, unit in brackets, and the axis for which an index in brackets stands."""
    if match := re.fullmatch(r"(.*?)\[([012])\]\s*(?:[\(\[](.*)[\)\]])?\s*", text):
        return match.group(1), match.group(3) or "", "xyz"[int(match.group(2))]
    if match := BEHIND_BRACKETS.fullmatch(text):
        return match.group(1), match.group(2), None
    if match := re.fullmatch(r"(.*\S)\s+in\s+(\S.*)", text):
        return match.group(1), match.group(2), None
    return text, "", None


def _time_column(tokens: list[str], unit: str, name: str, place: int) -> Column | None:
    rest, stated = _without_unit(tokens)
    found = spelled_unit("time", unit) or stated
    named = [token for token in rest if token not in TIME_FILLERS]
    of_sensor = len(named) > 1 and len(named[0]) > 2 and named[0] in SENSOR_OF
    named = named[1:] if of_sensor else named
    is_time = named or found or not CLOCKS.isdisjoint(rest)  # a column "sensor" or "log" names none
    abscissa = named == ["x"] and found is not None  # X[s] of Delsys
    if not (is_time and (abscissa or TIME_STEMS.issuperset(named))):
        return None
    rank = OF_A_SENSOR if of_sensor else _rank_of_time(tokens, named, found)
    return Column("t_s", name, place, found, rank, strange=unit if is_counts(unit) else "")


def _rank_of_time(tokens: list[str], named: list[str], unit: str | None) -> int:
    """A date alone is not used as the time beside another column of times, nor is UTC beside the clock of a logger, as time_utc_usec of PX4."""
    return OF_A_DATE if named == ["date"] else 0 if unit and "utc" not in tokens else 1


def _without_unit(tokens: list[str]) -> tuple[list[str], str | None]:
    """The words of t_ms, millis and seconds_elapsed without the unit, and the unit. Hours and minutes alone are parts of an instant."""
    spelled = spelled_unit("time", tokens[-1]) if tokens else None
    if spelled and tokens != ["s"] and not (len(tokens) == 1 and spelled in ("h", "min")):
        return tokens[:-1], spelled
    if len(tokens) > 1 and tokens[1] in TIME_FILLERS and (spelled := spelled_unit("time", tokens[0])):
        return tokens[1:], spelled
    return tokens, None


def _sensor_column(tokens: list[str], unit: str, axis: str | None, name: str, place: int, sensor: str | None) -> Column | None:
    tokens, including = _without_gravity_said(tokens)
    before, axis, after = (tokens, axis, []) if axis else _words_around_axis(tokens, sensor)
    if axis is None or NOT_READ & {*before, *after}:
        return None
    behind, (after, counts) = "".join(after), _without_counts(after)
    named, letters = _without_gravity(_bare(before))
    found, stated = _sensor_of(named, sensor)
    rank = sum(WORSE.get(token, 0) for token in tokens) if found else BY_UNIT_ALONE
    found = found or only_sensor_of(unit)
    if found not in letters:
        return None
    spelled = _spelled(str(found), unit, behind, "".join(after), stated)
    if after and not spelled and not sensor:
        return None
    strange = _strange_unit([] if spelled else [unit, *counts])
    # "Linear" means without gravity on a phone, but with gravity in ROS.
    rank += -including - 6 * (named in OF_GF)
    sign = -1.0 if before == OF_APPLE else 1.0
    return Column(letters[found] + axis, name, place, spelled, rank, sign, strange)


def _without_gravity(named: list[str]) -> tuple[list[str], dict[str | None, str]]:
    """The words that name a sensor, and the first letter of the roles of each sensor that they may name: gravity is of one."""
    if "gravity" not in named:
        return named, {sensor: sensor[0] for sensor in ARRAYS}
    return [token for token in named if token not in ("gravity", "motion")] or ["acc"], {"accel": GRAVITY[0][0]}


def _spelled(quantity: str, *texts: str) -> str | None:
    """The first unit that one of the texts names."""
    return next(filter(None, (spelled_unit(quantity, text) for text in texts if text)), None)


def _words_around_axis(tokens: list[str], sensor: str | None) -> tuple[list[str], str | None, list[str]]:
    """As _around_axis; the words of X_acc stand behind its axis."""
    before, axis, after = _around_axis(tokens)
    return (before, axis, after) if before or sensor else (after, axis, [])


def _without_counts(words: list[str]) -> tuple[list[str], list[str]]:
    """The remaining words after an axis, and those that mean counts of a chip."""
    words = [word for word in words if word not in FILLERS]
    return [word for word in words if not is_counts(word)], [word for word in words if is_counts(word)]


def _strange_unit(texts: list[str]) -> str:
    """The first text that may be an unknown unit; empty if there is none."""
    return next((text for text in texts if may_be_unit(text) and text.lower() not in DESCRIBED), "")


def _without_gravity_said(tokens: list[str]) -> tuple[list[str], bool]:
    """accelerationIncludingGravity of browsers is the specific force; it is preferred to their acceleration."""
    said = tokens[1:3] == ["including", "gravity"]
    return ([tokens[0], *tokens[3:]] if said else tokens), said


def _bare(tokens: list[str]) -> list[str]:
    """The words that may name a sensor: imu0_gyro is gyro."""
    unnumbered = (token.rstrip("0123456789") if len(token) > 2 else token for token in tokens)
    return [token for token in unnumbered if token and token not in FILLERS and token not in ("linear", "lin")]


def _around_axis(tokens: list[str]) -> tuple[list[str], str | None, list[str]]:
    """The words before the last axis name (also at the end of a word, as in gx), the axis, and the words after it."""
    for i in reversed(range(len(tokens))):
        stem, axis = tokens[i][:-1], tokens[i][-1]
        if axis in "xyz" and (not stem or stem in SENSOR_OF or stem == "gf"):
            return [*tokens[:i], *filter(None, [stem])], axis, tokens[i + 1 :]
    return [], None, tokens


def _sensor_of(tokens: list[str], sensor: str | None) -> tuple[str | None, str]:
    """The sensor, and the words after its name that are a unit."""
    if not tokens:
        return sensor, ""
    if tokens in OF_GF:
        return "accel", "g"
    for begin in range(len(tokens)):
        for end in range(len(tokens), begin, -1):
            stem, stated = "".join(tokens[begin:end]), "".join(tokens[end:])
            found = SENSOR_OF.get(stem) if begin == 0 or len(stem) > 2 else None  # left_arm_gyro_x
            if found and (not stated or spelled_unit(found, stated)):
                return found, stated
    return None, ""


def sensor_like(name: str, unit: str) -> str | None:
    """The sensor of which a column without a role may be an axis, by its unit, which may stand in the name too, or by its words."""
    bare, stated, index = _split(name)
    before, axis, _ = _around_axis(words_in(bare))
    return only_sensor_of(unit or stated) or (_sensor_of(_bare(before), None)[0] if index or axis else None)


def columns_of(names: Sequence[str], given: Mapping[str, str], shown: str, sensor: str | None = None) -> dict[str, Column]:
    """The column of each role that is found. given: role to name, before which a minus negates. Raises RecordingError.

    shown: what messages call the place of the names.
    """
    found = _all_candidates(names, sensor)
    chosen: dict[str, Column] = {}
    for role, candidates in found.items():
        best = min(candidates, key=lambda column: column.rank)
        twins = [column for column in candidates if column.rank == best.rank]
        if len(twins) > 1 and role not in given and role != "t_s" and role not in ROLES:
            raise _ambiguous(shown, role, *twins[:2])
        chosen[role] = twins[0]
    times = found.get("t_s", [])
    chosen |= {} if "t_s" in given else _own_times(chosen, times) | _fraction(chosen, times) | _day(chosen, times)
    for role, name in given.items():
        if role in CSV_COLUMNS or role in ROLES:
            chosen[role] = _named(names, role, name, shown)
    return chosen


def _ambiguous(shown: str, role: str, one: Column, other: Column) -> RecordingError:
    name, twin = one.name.strip(), other.name.strip()
    if name == twin:
        places = f"{one.place + 1} or {role}={other.place + 1}"
        return RecordingError(f"{shown}: a column appears twice: {name}: choose by its place, columns {role}={places}", "columns")
    return RecordingError(f"{shown}: {name} and {twin} may both be {role}: choose by columns {role}=NAME", "columns")


def _own_times(chosen: Mapping[str, Column], times: Sequence[Column]) -> dict[str, Column]:
    """The column of times before each sensor, if several have the same name or are named after sensors."""
    if (first := chosen.get("t_s")) is None:
        return {}
    found = {}
    alike = [c for c in times if c.rank == first.rank and (c.rank == OF_A_SENSOR or c.name.strip() == first.name.strip())]
    for sensor, role in OWN_TIMES.items():
        if len(alike) > 1 and (samples := chosen.get(f"{sensor[0]}x")):
            before = [column for column in alike if column.place < samples.place]
            found[role] = replace((before or alike)[-1 if before else 0], role=role)
    return found


def _fraction(chosen: Mapping[str, Column], times: Sequence[Column]) -> dict[str, Column]:
    """The nanoseconds beside whole seconds: header.stamp.secs and header.stamp.nsecs, sec and nanosec of ROS."""
    whole = chosen.get("t_s")
    if whole is None or whole.unit != "s":
        return {}

    def bare(column: Column) -> list[str]:
        return _without_unit(re.findall("[a-z]+", column.name.lower()))[0]

    found = [column for column in times if column.unit == "ns" and bare(column) == bare(whole)]
    return {FRACTION: replace(found[0], role=FRACTION)} if found else {}


def _day(chosen: Mapping[str, Column], times: Sequence[Column]) -> dict[str, Column]:
    """A column of dates beside that of the times: it counts where these are of a clock."""
    dates = [column for column in times if column.rank == OF_A_DATE]
    return {DAY: replace(dates[0], role=DAY)} if dates and chosen["t_s"].rank < OF_A_DATE else {}


def _all_candidates(names: Sequence[str], sensor: str | None) -> dict[str, list[Column]]:
    """The candidate columns of each role, by the names as they are, without what all begin with, or of a group that is whole by itself."""
    found = _candidates(names, _with_axes(names), sensor)
    if not found.keys() >= set(WHOLE) and (short := _without_common_beginning(names)) != names:
        found = max(found, _candidates(names, short, sensor), key=len)
    if not found.keys() >= set(WHOLE):
        groups = (_candidates(names, group, sensor) for group in _groups(names))
        found = next((group for group in groups if group.keys() >= set(WHOLE)), found)
    return found


def _candidates(names: Sequence[str], read: Sequence[str], sensor: str | None) -> dict[str, list[Column]]:
    """The candidate columns of each role. read: the parsed names."""
    found: dict[str, list[Column]] = {}
    for place, (name, text) in enumerate(zip(names, read)):
        if name.strip() and (column := column_of(text, place, sensor)):
            found.setdefault(column.role, []).append(replace(column, name=name))
    if not MINUTES.isdisjoint(name.strip().lower() for name in read):  # beside them, sec is a part of an instant
        found["t_s"] = [column for column in found.get("t_s", []) if column.name.strip().lower() not in SECONDS]
    if {"lat_deg", "lon_deg"} <= found.keys() and all(ABOVE_SEA.search(column.name) for column in found.get("alt_m", [])):
        found["alt_m"] = [*_of_satellites(names, read, "alt_m"), *found.get("alt_m", [])]
    if {"lat_deg", "lon_deg", "ground_speed"} <= found.keys() and "course_deg" not in found:
        found["course_deg"] = _of_satellites(names, read, "course_deg")
    return {role: columns for role, columns in found.items() if columns}


def _of_satellites(names: Sequence[str], read: Sequence[str], role: str) -> list[Column]:
    """Columns of this role beside a place, whose names are too common elsewhere: a height, above the ellipsoid where another is above the
    sea, and the track of gpsd."""
    columns = ((place, column_of(f"gps {text}", place)) for place, text in enumerate(read))
    return [replace(column, name=names[place]) for place, column in columns if column and column.role == role]


def _with_axes(names: Sequence[str]) -> Sequence[str]:
    """gyro_1, gyro_2 and gyro_3 of MATLAB, or gyro0 to gyro2, as gyro_x, gyro_y and gyro_z."""
    numbered: dict[tuple[str, str], dict[int, int]] = {}
    for place, name in enumerate(names):
        if match := re.fullmatch(r"(.*[A-Za-z])[ _.]?([0-3])(\W.*)?", name.strip()):
            numbered.setdefault((match.group(1), match.group(3) or ""), {})[int(match.group(2))] = place
    read = list(names)
    for (stem, unit), places in numbered.items():
        if sorted(places) in ([0, 1, 2], [1, 2, 3]):
            for axis, number in zip("xyz", sorted(places)):
                read[places[number]] = f"{stem}_{axis}{unit}"
    return read


def _without_common_beginning(names: Sequence[str]) -> Sequence[str]:
    """Shimmer_ab12_Gyro_X and the others without the device, which all of them begin with."""
    filled = [name for name in names if name.strip()]
    if len(filled) < len(WHOLE):
        return names
    # A prefix of the first and the last name in alphabetical order is a prefix of all.
    common = itertools.takewhile(lambda pair: pair[0] == pair[1], zip(min(filled), max(filled)))
    words = re.match(r".*[_./ ]", "".join(letter for letter, _ in common))
    return [name.removeprefix(words.group()) for name in names] if words else names


def _groups(names: Sequence[str]) -> Iterator[Sequence[str]]:
    """By the word that names begin with: those without it, the others empty. synced_time and synced_gyro_x beside raw_gyro_1 of RoNIN."""
    words = [match.group() if (match := _FIRST_WORD.match(name)) else "" for name in names]
    for word, count in Counter(words).items():
        if word and len(WHOLE) <= count < len(names):
            yield [name.removeprefix(word) if one == word else "" for name, one in zip(names, words)]


_FIRST_WORD = re.compile(r"[A-Za-z]+\d*[_./ ]")
_UNIT_BEHIND = re.compile(r"(.*\S)\s*\[([^\[\]]+)\]")
"""What the caller adds to a name: vn="speed N [km/h]"."""


def _with_unit_given(column: Column, text: str, shown: str) -> Column:
    """The column in a unit that the caller states behind its name. Raises RecordingError."""
    quantity = ROLES[column.role] if column.aids else QUANTITY_OF[column.role[0]]
    unit = aid_unit(quantity, text) if column.aids else spelled_unit(quantity, text)
    if unit is None:
        raise RecordingError(f"columns {column.role}={column.name.strip()} [{text}]: {shown} cannot have this unit", "columns")
    return replace(column, unit=unit, strange="")


def _unit_in(name: str, role: str) -> str | None:
    """The unit of a role that any name states in brackets or by its last words: Tacho [km/h], Hoehe_ft, RotX_dps."""

    def spelled(text: str) -> str | None:
        return aid_unit(ROLES[role], text) if role in ROLES else spelled_unit(QUANTITY_OF[role[0]], text)

    words = words_in(name)
    endings = ("".join(words[-count:]) for count in (3, 2, 1) if len(words) > count)
    return next(filter(None, map(spelled, (_split(name)[1], *(text for text in endings if len(text) > 1 or text in "gm")))), None)


def _named(names: Sequence[str], role: str, name: str, shown: str) -> Column:
    """The column that the caller has assigned. Raises RecordingError."""
    stripped = [n.strip().strip('"').lstrip("#% ") for n in names]
    for text, sign in ((name.strip(), 1.0), (name.strip().lstrip("-"), -1.0)):
        for i, known in enumerate(stripped):
            if text == known or text == names[i].strip():
                column = column_of(known, i)
                same = column is not None and (column.role == role if role in ROLES else column.role[0] == role[0])
                return Column(role, names[i], i, column.unit if same and column else _unit_in(known, role), sign=sign)
    if behind := _UNIT_BEHIND.fullmatch(name.strip()):
        return _with_unit_given(_named(names, role, behind.group(1), shown), behind.group(2), shown)
    if (place := name.strip().lstrip("-")).isdigit() and 1 <= int(place) <= len(names):
        minus = name.strip().removesuffix(place)
        return _named(names, role, f"{minus}{stripped[int(place) - 1]}", shown)
    raise RecordingError(f"columns {role}={name}: {shown} has no such column, but {', '.join(stripped[:12])}", "columns")
