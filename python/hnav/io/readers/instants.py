"""Spellings of times: calendar dates, times of day, and spans with their unit, as durations of MATLAB.

2026-01-31T12:00:00.01Z, 31.01.2026 12:00:00,010, 01/31/2026 12:00:00.010 PM, 31-Jan-2026 12:00:00.010, 12:00:00:010, 00:01.5, 1.5 sec
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import numpy as np

from hnav.io.readers.unit_names import spelled_unit
from hnav.io.recordings import RecordingError
from hnav.units import S_PER

if TYPE_CHECKING:
    import pandas as pd

CLOCK = r"(?<![\d:])(?:(\d{1,2}):)?(\d{1,2}):(\d{2})(?:[.,:](\d{1,9}))?(?:\s*([AaPp])\.?[Mm]\b)?"
"""Hours, minutes, seconds, decimals, and whether it is before or after noon; without hours a spreadsheet shows minutes."""
SPAN = r"^\s*([-+]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][-+]?\d+)?)\s*([A-Za-zµμ]+)\s*$"
DATE = re.compile(r"\d{1,4}[-/.](?:\d{1,2}|[A-Za-z]{3})[-/.]\d{1,4}")
HOUR_S, DAY_S, MONTHS = 3600.0, 86400.0, 12
EXAMPLES = "2026-01-31 12:00:00.01, 31.01.2026 12:00:00.01, 12:00:00.01 or 1.5 sec"


def is_instant(cell: str) -> bool:
    """Whether a cell has the time of a clock, a date, or a span with its unit."""
    span = re.match(SPAN, cell)
    return re.search(CLOCK, cell) is not None or DATE.search(cell) is not None or bool(span and spelled_unit("time", span[2]))


def is_day_of(time: str, day: str) -> bool:
    """Whether a time is one of a clock, without a date, and the cell beside it is a date."""
    return re.search(CLOCK, time) is not None and DATE.search(time) is None and DATE.search(day) is not None


def with_day(times: pd.Series[Any], days: pd.Series[Any]) -> pd.Series[Any]:
    """The instants of times of a clock; none where one of both is missing. A day may have a midnight behind it."""
    return days.astype("string").str.extract(rf"({DATE.pattern})")[0] + " " + times.astype("string")


def seconds_of(at: str, name: str, cells: np.ndarray) -> np.ndarray:
    """Instants in s since 1970 in UTC, times of day since the first midnight, or spans in s. Raises RecordingError."""
    import pandas as pd

    for read in (_by_calendar, _by_clock, _by_unit):
        try:
            return read(pd.Series(cells))
        except (ValueError, OverflowError, TypeError):
            pass
    raise RecordingError(f"{at}, column {name.strip()}: the times are neither numbers nor like {EXAMPLES}")


def _by_calendar(cells: pd.Series[Any]) -> np.ndarray:
    import pandas as pd

    instants = pd.to_datetime(cells, utc=True, format="ISO8601")
    return np.asarray((instants - pd.Timestamp(0, tz="UTC")).dt.total_seconds(), float)


def _by_unit(cells: pd.Series[Any]) -> np.ndarray:
    """Spans, 1.5 sec. Raises ValueError."""
    import pandas as pd

    parts = cells.astype(str).str.extract(SPAN)
    seconds = {text: S_PER.get(spelled_unit("time", str(text)) or "") for text in parts[1].unique()}
    if None in seconds.values():
        raise ValueError("no unit of a time")
    return np.asarray(pd.to_numeric(parts[0].str.replace(",", ".")) * parts[1].map(seconds), float)


def _by_clock(cells: pd.Series[Any]) -> np.ndarray:
    """Of a clock, whose midnight is passed, and of the date before it, if there is one. Raises ValueError."""
    import pandas as pd

    texts = cells.astype(str)
    parts = texts.str.extract(CLOCK)
    hours, minutes, seconds = (pd.to_numeric(parts[i]).to_numpy(float) for i in range(3))
    decimals = pd.to_numeric("0." + parts[3].fillna("0")).to_numpy(float)
    if np.isnan(minutes).any():
        raise ValueError("no time of a clock")
    noon = parts[4].str.lower()
    hours = np.where(noon.notna(), hours % 12 + 12 * (noon == "p"), hours)
    clock_s = HOUR_S * np.nan_to_num(hours) + 60 * minutes + seconds + decimals
    dates = texts.str.extract(rf"^\s*(\S.*?)?[\s,T]*{CLOCK}")[0]
    if dates.notna().all():
        days = dict(zip(dates.unique(), _days(dates.unique())))
        return np.asarray(clock_s + DAY_S * dates.map(days).to_numpy(float))
    again_s = HOUR_S if np.isnan(hours).all() else DAY_S
    return np.asarray(clock_s + again_s * np.cumsum(np.diff(clock_s, prepend=clock_s[:1]) < -again_s / 2))


def _days(dates: np.ndarray) -> np.ndarray:
    """A date as seconds since 1970. Separated by points the day is first; by slashes the month, unless it exceeds 12."""
    import pandas as pd

    first = re.match(r"\d{1,2}(?=\D)", str(dates[0]))
    day_first = first is not None and ("." in str(dates[0]) or int(first.group()) > MONTHS)
    days = pd.to_datetime(pd.Series(dates), dayfirst=day_first)
    return (days - pd.Timestamp(0)).dt.days.to_numpy(float)
