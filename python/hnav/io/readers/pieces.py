"""Long tables of text in pieces: consecutive recordings that together equal the recording of hnav.read, bit for bit.

    if (table := long_table("day.csv")) is not None:
        for piece in table: ...            # Recordings of PIECE rows, the last of fewer

A table is read once before the first piece is returned, so that its errors are reported at once. Files that are not text
tables, are short, or have samples out of order or twice, are left to hnav.read, which reads them or reports the error.
"""

from __future__ import annotations

import codecs
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hnav.io.findings import Finding
from hnav.io.plausibility import check
from hnav.io.readers.formats import reader_of
from hnav.io.readers.streams import Wishes, recording_of
from hnav.io.readers.tables import (
    ENCODINGS,
    HEAD_CHARACTERS,
    NOT_DIGESTED,
    fault_of,
    frames_of,
    plan_of,
    raw_of,
    read_table,
    refuse_devices,
    table_by,
)
from hnav.io.recordings import ARRAYS, Recording, RecordingError

if TYPE_CHECKING:
    import pandas as pd

# A power of two: vector instructions then treat the elements of the pieces as in the whole array, bit for bit.
PIECE = 2**17
SHORTEST_ROW = 14  # characters of seven numbers
BLOCK_BYTES = 2**20
# Findings that apply to a recording only if they apply to each of its pieces.
OF_THE_WHOLE = ("no_samples", "all_zero", "constant", "ends_early", "absent", "not_testable")


class _NotPlain(Exception):
    """A table that must be read as a whole."""


def long_table(
    path: str | Path,
    hemisphere: str | None = None,
    corrected: Callable[[Recording], Recording] | None = None,
    format: str | None = None,
    **options: Any,
) -> LongTable | None:
    """The pieces of a table; None for a file that hnav.read must read as a whole.

    hemisphere: as of Recording.check. corrected: the correction of each piece, row by row. format, options: as of hnav.read. Raises
    HnavError for impossible ones.
    """
    path, wishes = Path(path), Wishes(**{name: value for name, value in options.items() if value is not None})
    try:
        if path.is_file() and path.stat().st_size >= SHORTEST_ROW * PIECE and not wishes.drop_repeats:
            return LongTable(path, wishes, hemisphere, corrected) if reader_of(path, format) is read_table else None
    except (OSError, RecordingError, _NotPlain):
        pass  # hnav.read says what it is
    return None


class LongTable:
    """The pieces of a table. Iterate as often as you like: each time the file is read again."""

    def __init__(self, path: Path, wishes: Wishes, hemisphere: str | None, corrected: Callable[[Recording], Recording] | None):
        """Reads the table once. Raises _NotPlain, and the errors of the readers for a faulty file or argument."""
        self._path, self._wishes, self._corrected = path, wishes, corrected
        encoding = _encoding(path)
        with path.open(encoding=encoding, newline="") as file:
            self._plan = plan_of(str(path), file.read(HEAD_CHARACTERS), encoding, wishes)
        with ExitStack() as files:
            refuse_devices(str(path), lambda: files.enter_context(path.open(encoding=self._plan.encoding)), self._plan)
        self._wishes = self._with_units()
        self.name, self.rows = path.stem, 0
        self.findings: list[Finding] = []
        """As Recording.check: of all pieces, the first of each kind."""
        found: dict[tuple[str | None, ...], list[Finding]] = {}
        newest: dict[str, tuple[float, np.ndarray]] = {}  # of each sensor the last sample and its time
        last_s, pieces, empty_at_end = -np.inf, 0, False
        for frame in self._frames():
            empty_at_end = empty_at_end or bool(frame.iloc[:, -1].isna().any())
            piece = self._recording(frame, self.rows)
            if not last_s < piece.t_s[0]:
                raise _NotPlain
            for one in check(_behind(newest, piece), hemisphere):
                found.setdefault((one.level, one.code, one.sensor, one.argument, one.value), []).append(one)
            for sensor in ARRAYS:
                t_s, values = piece.samples(sensor)
                newest |= {sensor: (t_s[-1], values[-1])} if len(t_s) else {}
            self.rows += len(piece.t_s)
            last_s, pieces = piece.t_s[-1], pieces + 1
        if pieces < 2 or (empty_at_end and self._fault()):
            raise _NotPlain
        self.findings = [every[0] for every in found.values() if len(every) == pieces or every[0].code not in OF_THE_WHOLE]

    def __iter__(self) -> Iterator[Recording]:
        """Raises RecordingError when the file has changed."""
        rows = 0
        try:
            for frame in self._frames():
                piece = self._recording(frame, rows)
                rows += len(piece.t_s)
                yield piece
        except (OSError, _NotPlain):
            rows = -1
        if rows != self.rows:
            raise RecordingError(f"{self._path}: it changed while it was read")

    def _frames(self) -> Iterator[pd.DataFrame]:
        with self._path.open("rb") as file:
            try:
                yield from frames_of(file, self._plan, PIECE)
            except NOT_DIGESTED:
                raise _NotPlain from None

    def _with_units(self) -> Wishes:
        """Units that the header does not state are inferred from the first rows and apply to all."""
        frame = next(self._frames(), None)
        if frame is None:
            raise _NotPlain
        raw = raw_of(str(self._path), table_by(str(self._path), frame, self._plan), self._wishes)
        units = {"time": raw.time_unit, **{stream.sensor: stream.unit for stream in raw.streams}}
        said: dict[str, Any] = {f"{name}_unit": unit.name for name, unit in units.items() if unit.is_inferred}
        return replace(self._wishes, **said)

    def _recording(self, frame: pd.DataFrame, before: int) -> Recording:
        """before: rows of the pieces before this one."""
        shown = str(self._path)
        try:
            made = recording_of(self.name, shown, raw_of(shown, table_by(shown, frame, self._plan), self._wishes), self._wishes)
        except RecordingError:
            raise _NotPlain from None
        if made.origin is None or made.origin.notes or len(made.t_s) != len(frame):
            raise _NotPlain
        if self._wishes.rate_hz is not None:
            made = replace(made, t_s=np.arange(before, before + len(made.t_s)) / self._wishes.rate_hz)
        return self._corrected(made) if self._corrected else made

    def _fault(self) -> str | None:
        with self._path.open(encoding=self._plan.encoding) as file:
            return fault_of(str(self._path), file, self._plan)


def _encoding(path: Path) -> str:
    """The encoding of the whole file, by encoding_of. Raises _NotPlain."""
    decoders = {name: codecs.getincrementaldecoder(name)() for name in ENCODINGS}
    with path.open("rb") as file:
        while block := file.read(BLOCK_BYTES):
            for name in [name for name, decoder in decoders.items() if b"\0" in block or not _decodes(decoder, block)]:
                del decoders[name]
    for name, decoder in decoders.items():
        if _decodes(decoder, b"", final=True):
            return name
    raise _NotPlain


def _decodes(decoder: codecs.IncrementalDecoder, block: bytes, final: bool = False) -> bool:
    try:
        decoder.decode(block, final)
        return True
    except UnicodeDecodeError:
        return False


def _behind(newest: Mapping[str, tuple[float, np.ndarray]], piece: Recording) -> Recording:
    """A piece behind the last samples of the sensors before it, so that a gap between the two is seen."""
    times = np.unique([t_s for t_s, _ in newest.values()])
    arrays: dict[str, Any] = {"t_s": np.concatenate([times, piece.t_s])}
    for sensor, name in ARRAYS.items():
        if (values := getattr(piece, name)) is not None:
            before = np.full((len(times), 3), np.nan)
            if sensor in newest:
                before[times == newest[sensor][0]] = newest[sensor][1]
            arrays[name] = np.concatenate([before, values])
    return replace(piece, **arrays)
