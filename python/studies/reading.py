"""Time to read a recording against its size, for each reader of text and of records: it grows with the size, and no faster.

./run study reading [--largest 50]
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import numpy as np
import typer
from rich.table import Table

from hnav.cli.console import show
from hnav.io.readers import read, read_aids

NAMES = [f"{kind}{axis}" for kind in "gam" for axis in "xyz"]
LONG = tuple(zip((0, 3, 6), ("gyroscope", "accelerometer", "magnetometer")))
Line = Callable[[int, list[float]], str]


def rows(count: int) -> Iterator[list[float]]:
    """Samples at 100 Hz: what they hold does not matter here, but that they differ."""
    values = np.random.default_rng(1).normal(size=(1000, 9)).round(6).tolist()
    return (values[k % 1000] for k in range(count))


def record(k: int, row: list[float]) -> str:
    return json.dumps({"t": k / 100, **dict(zip(NAMES, row))})


def sentence(k: int, row: list[float]) -> str:
    """GGA of NMEA at 10 Hz."""
    s = k // 10
    return f"$GPGGA,{s // 3600 % 24:02d}{s // 60 % 60:02d}{s % 60:02d}.{k % 10}0,4530.{k % 10000:04d},N,00700.0000,E,1,08,1.5,400.0,M,48.0,M,,"


FORMATS: dict[str, tuple[str, str, str, Line]] = {
    "table": (",".join(["t_s", *NAMES]) + "\n", "\n", "\n", lambda k, row: ",".join([str(k / 100), *map(str, row)])),
    "JSON": ("[", ",", "]", record),
    "JSON lines": ("", "\n", "\n", record),
    "long": (
        "time,sensor,x,y,z\n",
        "\n",
        "\n",
        lambda k, row: "\n".join(f"{k / 100},{name},{','.join(map(str, row[i : i + 3]))}" for i, name in LONG),
    ),
    "serial": ("", "\n", "\n", lambda k, row: ",".join([f"ms:{10 * k}", *(f"{name}:{v}" for name, v in zip(NAMES, row))])),
    "NMEA": ("", "\n", "\n", sentence),
}
"""By format what stands before, between and after the rows, and a row."""


def seconds_for(file: Path, format: str, megabytes: float) -> tuple[float, float]:
    """Size in MB and seconds of processor time."""
    before, between, after, line = FORMATS[format]
    count = int(1e6 * megabytes / (len(line(10_000, next(rows(1)))) + len(between)))
    file.write_text(before + between.join(line(k, row) for k, row in enumerate(rows(count))) + after)
    begin = time.process_time()
    (read_aids if format == "NMEA" else read)(file)
    return file.stat().st_size / 1e6, time.process_time() - begin


def command(largest: Annotated[float, typer.Option(help="Size of the largest file in MB")] = 50.0) -> None:
    table = Table("format", "MB", "s", "s / MB", title="time to read a file")
    with TemporaryDirectory() as folder:
        for format in FORMATS:
            for part in (0.125, 0.5, 1.0):
                size, seconds = seconds_for(Path(folder) / "recording.txt", format, part * largest)
                table.add_row(format, f"{size:.3g}", f"{seconds:.2f}", f"{seconds / size:.3f}")
    show(table)
