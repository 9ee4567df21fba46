"""A run as files that other programs open: TUM (t x y z qx qy qz qw, for evo), and of a navigation GPX (for maps)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from hnav import __version__
from hnav.earth import axes_at, position_of
from hnav.filters.attitude_answers import Run
from hnav.filters.ins_answers import InsRun
from hnav.io.outputs import write_files
from hnav.native.arrays import Array

TUM, GPX = ".tum", ".gpx"
POINT_S = 0.2
"""Interval in s between points of a GPX track: maps need no more."""
CLOCK_S = 1e8
"""Times in s above this count from 1970; others have no date and are left out."""


def write_tum(path: Path, runs: Iterable[Run | InsRun]) -> None:
    """A line for each row with an attitude, of one run in pieces. Positions are metres north, east, down of the first place; of an attitude
    filter they are 0. Raises OutputError."""
    write_files({path: _tum(runs)})


def _tum(runs: Iterable[Run | InsRun]) -> Iterator[bytes]:
    begin: Array | None = None
    for run in runs:
        known = np.isfinite(run.q_nb).all(axis=1)
        position = np.zeros((len(run.t_s), 3))
        if isinstance(run, InsRun):
            known &= np.isfinite(run.place).all(axis=1)
            begin = run.place[known][:1] if begin is None and known.any() else begin
            if begin is not None:
                position = (position_of(run.place) - position_of(begin)) @ axes_at(begin)[0]
        rows = np.column_stack([position, run.q_nb[:, [1, 2, 3, 0]]])[known]
        lines = (f"{t!r} {' '.join(f'{v:.9g}' for v in row)}\n" for t, row in zip(run.t_s[known].tolist(), rows.tolist()))
        yield "".join(lines).encode()


def write_gpx(path: Path, runs: Iterable[InsRun], name: str) -> None:
    """The track of one run in pieces. Heights are above the ellipsoid. Raises OutputError."""
    write_files({path: _gpx(runs, name)})


def _gpx(runs: Iterable[InsRun], name: str) -> Iterator[bytes]:
    from xml.sax.saxutils import escape

    head = f'<?xml version="1.0" encoding="UTF-8"?>\n<gpx version="1.1" creator="hnav {__version__}" xmlns="http://www.topografix.com/GPX/1/1">'
    yield f"{head}<trk><name>{escape(name)}</name><trkseg>\n".encode()
    last_s = -np.inf
    for run in runs:
        for t_s, (latitude, longitude, height) in zip(run.t_s.tolist(), run.place.tolist()):
            if not np.isfinite(latitude) or t_s < last_s + POINT_S * (1 - 1e-9):
                continue
            last_s = t_s
            time = f"<time>{datetime.fromtimestamp(t_s, UTC).isoformat().replace('+00:00', 'Z')}</time>" if t_s > CLOCK_S else ""
            at = f'lat="{np.degrees(latitude):.9f}" lon="{np.degrees(longitude):.9f}"'
            yield f"<trkpt {at}><ele>{height:.3f}</ele>{time}</trkpt>\n".encode()
    yield b"</trkseg></trk></gpx>\n"
