"""hnav live: runs a filter over samples as they arrive; writes estimates as JSON lines, a recording, a page."""

from __future__ import annotations

import math
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from hnav.cli import navigation
from hnav.cli.console import console
from hnav.cli.live_filters import LiveFilter, live_filter
from hnav.cli.parameters import with_groups
from hnav.cli.recordings import Reading, lines_of, warn
from hnav.cli.wanted import INS, Choice, Corrected
from hnav.cli.words import UsageError, with_options
from hnav.filters.options import Options
from hnav.filters.run_files import formats_of
from hnav.io.live_lines import LiveLines
from hnav.io.live_sources import BAUD, Chunk, LiveSource, address_of
from hnav.native.arrays import Array
from hnav.reports.live_page import INTERVAL_S, LOCAL, PORT, LivePage

WAIT_S = 0.1
STALL_S = 2.0  # without a line, after which a source has stalled
GAP_S = 0.1  # between two rows; a longer interval counts as a gap
CHECK_S = 5.0  # of samples that are checked for implausible units, axes and signs
RATE_S = 1.0  # that the displayed sample rates are averaged over
LAST_NOTES = 6
NOTHING = "warning: no line had samples of a gyroscope and an accelerometer"


@with_groups
def command(
    source: Annotated[
        str,
        typer.Argument(
            help="Serial port (/dev/ttyUSB0, COM3), udp://HOST:PORT (listens), tcp://HOST:PORT (connects), mavlink:CONNECTION as of pymavlink, "
            "- for standard input; lines of CSV or JSON"
        ),
    ],
    to: Annotated[
        str | None, typer.Option(metavar="udp://HOST:PORT", help="Send the estimates there instead of to standard output")
    ] = None,
    record: Annotated[
        Path | None, typer.Option(metavar="FILE.csv", help="New file for the samples; hnav filter gives the same numbers of it")
    ] = None,
    page: Annotated[bool, typer.Option("--page", help=f"Serve a page at http://{LOCAL}:{PORT}/")] = False,
    port: Annotated[int, typer.Option(help="Of the page; 0: any that is free")] = PORT,
    host: Annotated[str, typer.Option(help="Of the page: another address lets other machines see it")] = LOCAL,
    baud: Annotated[int, typer.Option(help="Of a serial port")] = BAUD,
    seconds: Annotated[
        float | None, typer.Option(help="End after so long; default: at the end of the source, or by Ctrl-C")
    ] = None,
    *,
    choice: Choice,
    reading: Reading,
) -> None:
    refuse_of_recordings(reading)
    wanted = choice.wanted(reading)
    filter, chosen = wanted.filter, of_frame(wanted.filter, wanted.frame) | {**wanted.settings}
    corrected = wanted.corrected()
    with ExitStack() as opened:
        estimator = live_filter(Options(filter, wanted.preset, **chosen))
        live = Live(LiveLines(reading.wishes(), aids=filter == INS), estimator, corrected, wanted.reading)
        live_source = LiveSource.named(source, baud, aids=filter == INS)
        if to is not None:
            live.estimates.append(opened.enter_context(sent_to(to)))
        elif not (page and sys.stdout.isatty()):
            live.estimates.append(print_lines)
        if page:
            live.page = opened.enter_context(LivePage(source, filter, host, port))
            live.note(f"page: {live.page.url}")
            if host != LOCAL:
                warn([f"warning: --host {host}: whoever reaches this machine can see the page"])
        if record is not None:
            live.outputs.append(opened.enter_context(recorded_to(record, live.lines.columns)))
        opened.enter_context(live_source)
        try:
            with ended_by_signals() as ended:
                run(live, live_source, math.inf if seconds is None else time.monotonic() + seconds, ended)
            warn(estimator.warnings() if live.lines.counts["rows"] else [NOTHING])
        finally:
            live.end()
            live.note(", ".join(f"{name} {n}" for name, n in live.counted(live_source).items()))


def of_frame(filter: str, frame: str | None) -> dict[str, str]:
    """The setting of the navigation frame. Raises UsageError for a frame that the INS does not have."""
    if filter != INS:
        return {"navigation_frame": frame or "ned"}
    navigation.refuse(frame=frame not in (None, "ned"))
    return {}


def refuse_of_recordings(reading: Reading) -> None:
    """Raises UsageError for options of files."""
    if reading.fixes_late_s:
        raise UsageError("--fixes-late is for recordings: live, send the time of validity as t_s")
    if reading.format is not None:
        raise UsageError(f"--format {reading.format}: lines of CSV and JSON are distinguished by themselves: leave it out")


class Live:
    """One session: lines become rows; rows become a recording, estimates and the state of a page."""

    def __init__(self, lines: LiveLines, estimator: LiveFilter, corrected: Corrected | None, reading: Reading):
        self.lines, self._filter, self._corrected, self._reading = lines, estimator, corrected, reading
        self.outputs: list[Callable[[Array], None]] = []
        """Take the rows."""
        self.estimates: list[Callable[[list[str]], None]] = []
        """Take a line of JSON for each row."""
        self.page: LivePage | None = None
        self._notes: list[str] = []
        self._newest: dict[str, Any] = {}
        self._newest_arrived_s, self._last_t_s = math.nan, math.nan
        self._begin: list[Array] | None = []
        self._checking: threading.Thread | None = None
        self._arrivals: list[tuple[float, dict[str, int]]] = []

    def note(self, text: str, warning: bool = False) -> None:
        """Writes a note to stderr and to the page."""
        self._notes = [*self._notes[-LAST_NOTES + 1 :], text]
        if warning or not console.quiet:
            print(f"warning: {text}" if warning else text, file=sys.stderr, flush=True)

    def take(self, rows: Array, arrived_s: float) -> None:
        """Rows that have arrived, the newest at this time of time.monotonic(). Raises HnavError."""
        for text in self.lines.notes:
            self.note(with_options(text))
        self.lines.notes.clear()
        if not len(rows):
            return
        self.lines.counts["gaps"] += int((np.diff(rows[:, 0], prepend=self._last_t_s) > GAP_S).sum())
        self._last_t_s = float(rows[-1, 0])
        for output in self.outputs:
            output(rows)
        recording = self._filter.recording(rows)
        table = self._filter.go_on(recording if self._corrected is None else self._corrected(recording))
        text_lines = json_lines(table) if self.estimates else []
        for estimate in self.estimates:
            estimate(text_lines)
        if self.page is not None:
            self._arrivals.append((arrived_s, self._filter.samples(recording)))
            self._newest, self._newest_arrived_s = self._filter.state(table), arrived_s
        self._check(rows)

    def show(self, source: LiveSource, stalled_s: float) -> None:
        """Sends the newest row to the page."""
        if self.page is None or not self._newest:
            return
        now_s = time.monotonic()
        self._arrivals = [one for one in self._arrivals if one[0] > now_s - RATE_S]
        rates = {name: sum(counts[name] for _, counts in self._arrivals) / RATE_S for name in self._newest["health"]}
        self.page.show({
            **self._newest, "age_ms": 1e3 * (now_s - self._newest_arrived_s), "rates": rates, "counts": self.counted(source),
            "notes": self._notes, "stalled": stalled_s if stalled_s > STALL_S else 0,
        })  # fmt: skip

    def end(self) -> None:
        """Waits for a running check: the interpreter must not end while a thread is inside a C++ library."""
        if self._checking is not None:
            self._checking.join()

    def counted(self, source: LiveSource) -> dict[str, int]:
        """Counts of rows and samples that arrived, were lost or were changed."""
        shown = {"lines": 0, "rows": 0, **self.lines.counts, source.LOSS: source.dropped, "opened": source.connections}
        return {name: n for name, n in shown.items() if n or name in ("lines", "rows")}

    def _check(self, rows: Array) -> None:
        """Reports implausible samples of the first CHECK_S, once."""
        if self._begin is None:
            return
        self._begin.append(rows)
        if rows[-1, 0] - self._begin[0][0, 0] > CHECK_S:
            self._checking = threading.Thread(target=self._say_findings, args=(np.concatenate(self._begin),), daemon=True)
            self._checking.start()
            self._begin = None

    def _say_findings(self, rows: Array) -> None:
        """Checks in a separate thread: a check takes longer than samples may wait."""
        data = self._filter.recording(rows)
        if not len(data.samples("mag")[0]):  # no column of a file stands for a magnetometer that may not be there
            data = replace(data, field_b_tesla=None)
        found = self._filter.findings(self._reading.check(data))
        warn(lines_of([finding for finding in found if finding.level != "note"]))


@contextmanager
def ended_by_signals() -> Iterator[threading.Event]:
    """Set by Ctrl-C and SIGTERM: samples that have arrived are filtered before the end. A second signal interrupts."""
    ended = threading.Event()
    if threading.current_thread() is not threading.main_thread():  # signals are for the main thread alone
        yield ended
        return

    before = {int(number): signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}

    def end(number: int, _: object) -> None:
        ended.set()
        signal.signal(number, before[number])

    try:
        for number in before:
            signal.signal(number, end)
        yield ended
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def run(live: Live, source: LiveSource, until_s: float, ended: threading.Event) -> None:
    """Runs until the source ends, the time is over, or the user stops it. Raises HnavError when the lines are no samples, or
    when the filter fails.
    """
    watch = Watch(live, source)
    shown_s = time.monotonic()
    while (now_s := time.monotonic()) < until_s and not ended.is_set():
        chunks = source.wait(INTERVAL_S if live.page else WAIT_S)
        watch.see(chunks or [])
        live.take(live.lines.take(chunks or [], ending=chunks is None), watch.arrived_s)
        if time.monotonic() - shown_s >= INTERVAL_S:
            live.show(source, now_s - watch.arrived_s)
            shown_s = time.monotonic()
        if chunks is None:
            return
    live.take(live.lines.take(source.wait(0) or [], ending=True), watch.arrived_s)


class Watch:
    """Reports when a source is lost, reopened, stalls and resumes."""

    def __init__(self, live: Live, source: LiveSource):
        self._live, self._source = live, source
        self.arrived_s = time.monotonic()  # of the newest bytes
        self._stalled, self._failure, self._connections, self._dropped = False, "", 0, 0

    def see(self, chunks: Sequence[Chunk]) -> None:
        """Handles the chunks that arrived, possibly none."""
        source, note = self._source, self._live.note
        if source.failure != self._failure:
            self._failure = source.failure
            if self._failure:
                note(f"{source.name}: {self._failure}; trying again", warning=True)
        if source.connections != self._connections:
            note(f"{source.name}: opened{' again' if self._connections else ''}")
        self._connections = source.connections
        if source.dropped and not self._dropped:
            note(f"{source.name}: samples are {source.LOSS}; the count is said at the end", warning=True)
        self._dropped = source.dropped
        if chunks:
            if self._stalled:
                note(f"{source.name}: goes on after {chunks[0].arrived_s - self.arrived_s:.1f} s")
            self.arrived_s, self._stalled = chunks[-1].arrived_s, False
        elif not self._stalled and time.monotonic() - self.arrived_s > STALL_S:
            self._stalled = True
            self._live.lines.counts["stalls"] += 1
            note(f"{source.name}: nothing came for {STALL_S:g} s", warning=True)


# --------------------------------------------------------------------------------------------- what goes out


def json_lines(table: Mapping[str, np.ndarray]) -> list[str]:
    """A line for each row, with the names and digits of the table of hnav filter; null for a missing number."""
    text = ", ".join(f'"{name}": {shape}' for name, shape in formats_of(table).items())
    rows = zip(*(values.tolist() for values in table.values()))
    return ["{" + (text % row).replace(": nan", ": null") + "}" for row in rows]


def print_lines(lines: list[str]) -> None:
    """To standard output, at once."""
    sys.stdout.write("\n".join([*lines, ""]))
    sys.stdout.flush()


@contextmanager
def recorded_to(path: Path, columns: Sequence[str]) -> Iterator[Callable[[Array], None]]:
    """What writes rows of samples into a new table in SI units, at once: written rows are kept, however the session ends."""
    try:
        file = path.open("x", encoding="utf-8")
    except FileExistsError:
        raise UsageError(f"--record {path}: it exists already: name a new file") from None

    def write(rows: Array) -> None:
        """Numbers in full, empty where there is none."""
        text = "\n".join([",".join(map(repr, row)) for row in rows.tolist()])
        file.write(text.replace("nan", "") + "\n")
        file.flush()

    with file:
        file.write(",".join(columns) + "\n")
        yield write


@contextmanager
def sent_to(url: str) -> Iterator[Callable[[list[str]], None]]:
    """What sends lines, each as a datagram."""
    if not url.startswith("udp://"):
        raise UsageError(f"--to {url}: write udp://HOST:PORT")
    host, port = address_of(url)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
        out.connect((host or LOCAL, port))

        def send(lines: list[str]) -> None:
            for line in lines:
                with suppress(ConnectionRefusedError):  # the receiver may start later
                    out.send(line.encode())

        yield send
