"""The one date that all of a release carries: two releases of a commit are the same bytes.

SOURCE_DATE_EPOCH holds it in seconds since 1970; ./run release sets it to the date of the commit.
"""

from __future__ import annotations

import os
import sys
from datetime import UTC, datetime

# What the clock of a zip archive begins with.
EARLIEST = 315532800


def seconds() -> int:
    """Since 1970. Exits when it is not given, or before 1980, which no zip archive can say."""
    given = os.environ.get("SOURCE_DATE_EPOCH", "")
    if not given.isdecimal() or int(given) < EARLIEST:
        sys.exit(f"SOURCE_DATE_EPOCH is '{given}'; it has to be seconds since 1970, {EARLIEST} or more: git log -1 --format=%ct")
    return int(given)


def date() -> datetime:
    return datetime.fromtimestamp(seconds(), UTC)


def of_zip() -> tuple[int, int, int, int, int, int]:
    """As zipfile.ZipInfo takes it."""
    d = date()
    return d.year, d.month, d.day, d.hour, d.minute, d.second
