"""Spellings of times: calendar dates and times of day.

2026-01-31T12:00:00.01Z, 31.01.2026 12:00:00,010, 01/31/2026 12:00:00.010 PM, 31-Jan-2026 12:00:00.010, 12:00:00:010, 00:01.5
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

from hnav.io.recordings import RecordingError

if TYPE_CHECKING:
    import pandas as pd

CLOCK = r"(?<![\d:])(?:(\d{1,2}):)?(\d{1,2}):(\d{2})(?:[.,:](\d{1,9}))?(?:\s*([AaPp])\.?[Mm]\b)?"
"""Hours, minutes, seconds, decimals, and whether it is before or after noon; without hours a spreadsheet shows minutes."""
DATE = re.compile(r"\d{1,4}[-/.](?:\d{1,2}|[A-Za-z]{3})[-/.]\d{1,4}")
HOUR_S, DAY_S, MONTHS = 3600.0, 86400.0, 12
EXAMPLES = "2026-01-31 12:00:00.01, 31.01.2026 12:00:00.01 or 12:00:00.01"


def is_instant(cell: str) -> bool:
    """Whether a cell has the time of a clock, or a date."""
    return re.search(CLOCK, cell) is not None or DATE.search(cell) is not None


def seconds_of(at: str, name: str, cells: np.ndarray) -> np.ndarray:
    """Instants in s since 1970 in UTC, or times of day since the first midnight. Raises RecordingError."""
    import pandas as pd

    texts = pd.Series(cells)
    try:
        instants = pd.to_datetime(texts, utc=True, format="ISO8601")
        return (instants - pd.Timestamp(0, tz="UTC")).dt.total_seconds().to_numpy()
    except (ValueError, OverflowError, TypeError):
        pass
    try:
        return _by_clock(texts.astype(str))
    except (ValueError, OverflowError, TypeError):
        raise RecordingError(f"{at}, column {name.strip()}: the times are neither numbers nor like {EXAMPLES}") from None


def _by_clock(texts: pd.Series[str]) -> np.ndarray:
    """Of a clock, whose midnight is passed, and of the date before it, if there is one. Raises ValueError."""
    import pandas as pd

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
