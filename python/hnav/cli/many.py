"""hnav filter of many recordings: a table and a row of results for each, and an index page; an interrupted call can be continued."""

from __future__ import annotations

import contextlib
import hashlib
import io
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from html import escape
from pathlib import Path

import pandas as pd

from hnav import __version__
from hnav.cli.console import bar, say
from hnav.cli.filter import filter_one
from hnav.cli.wanted import Wanted
from hnav.cli.words import Interrupted, UsageError, in_one_line
from hnav.errors import HnavError
from hnav.io.outputs import OutputError, refuse_overwriting, write_files
from hnav.io.record_file import RecordFile
from hnav.reports.plain_page import plain_page
from hnav.systems.pool import results

UNFINISHED = "filtered.unfinished"
COLUMNS = ("recording", "read as", "table", "answer", "warnings", "failure")
Row = dict[str, str]


@dataclass(frozen=True)
class Job:
    """One recording, and the table made from it."""

    recording: Path
    table: Path


def filter_many(recordings: Sequence[Path], folder: Path, wanted: Wanted, workers: int, scheduler: str | None) -> None:
    """Writes tables, index.csv and index.html into the folder. Raises HnavError or UsageError, also when no recording could
    be filtered, and Interrupted when the user stopped it; the same call then continues.
    """
    work = [Job(path, folder / name) for path, name in zip(recordings, table_names(recordings))]
    refuse_overwriting([job.table for job in work], recordings)
    seen = hashlib.sha256(repr([(str(p), p.stat().st_size, p.stat().st_mtime_ns) for p in recordings if p.exists()]).encode())
    head = {"kind": "recordings of hnav filter", "hnav": __version__, "asked": repr(wanted), "recordings": seen.hexdigest()}
    with RecordFile(folder / UNFINISHED, head) as kept:
        rows = _rows(work, wanted, workers, scheduler, kept)
        write_index(folder, [rows[i] for i in range(len(work))])
        kept.remove()
    failed = [row for row in rows.values() if row["failure"]]
    for row in failed:
        say(f"failed: {row['failure']}")
    say(f"{len(work) - len(failed)} of {len(work)} recordings to {folder}; {folder / 'index.html'}")
    if len(failed) == len(work):
        raise UsageError(f"no recording could be filtered; the first: {failed[0]['failure']}")


def _rows(work: Sequence[Job], wanted: Wanted, workers: int, scheduler: str | None, kept: RecordFile) -> dict[int, Row]:
    """By number of the job."""
    rows: dict[int, Row] = {i: row for i, row in kept.records if row["failure"] or work[i].table.exists()}
    left = [(i, job) for i, job in enumerate(work) if i not in rows]
    with bar() as progress:
        task = progress.add_task("recordings", total=len(work), completed=len(rows))
        try:
            for i, row, finished in results(left, partial(row_of, wanted=wanted), _failed, workers, scheduler):
                rows[i] = kept.add([i, row])[1] if finished else row
                progress.advance(task)
        except KeyboardInterrupt:
            done = f"{len(rows)} of {len(work)} are done"
            raise Interrupted(f"interrupted; {done}, and the same command goes on from there") from None
    return rows


def table_names(recordings: Sequence[Path]) -> list[str]:
    """Names of the tables: those of the recordings, with as many parent folders as distinguish them."""
    names, depth = [path.stem for path in recordings], 1
    while len(set(names)) < len(names) and depth < max(len(path.parts) for path in recordings):
        depth += 1
        often = Counter(names)
        longer = ["_".join([*path.parts[-depth:-1], path.stem]) for path in recordings]
        names = [full if often[name] > 1 else name for full, name in zip(longer, names)]
    often = Counter(names)
    return [f"{name}_{i}.csv" if often[name] > 1 else f"{name}.csv" for i, name in enumerate(names)]


def row_of(job: Job, wanted: Wanted) -> Row:
    """The results of hnav filter for one recording. Raises OutputError when the disk is full."""
    answer, warnings, read, failure = io.StringIO(), io.StringIO(), "", ""
    with contextlib.redirect_stdout(answer), contextlib.redirect_stderr(warnings):
        try:
            read = filter_one(job.recording, job.table, None, wanted)
        except OutputError:
            raise
        except (UsageError, HnavError, OSError, MemoryError) as error:
            failure = in_one_line(error)
    lines = [" · ".join(text.getvalue().split("\n")).strip(" ·") for text in (answer, warnings)]
    return dict(zip(COLUMNS, (str(job.recording), read, job.table.name if not failure else "", *lines, failure)))


def _failed(job: Job, reason: str) -> Row:
    return dict(zip(COLUMNS, (str(job.recording), "", "", "", "", f"{job.recording}: {reason}")))


def write_index(folder: Path, rows: Sequence[Row]) -> None:
    """A row for each recording, as a table and as a page."""
    failed = sum(bool(row["failure"]) for row in rows)

    def cells(row: Row) -> str:
        link = f'<a href="{escape(row["table"], quote=True)}">{escape(row["table"])}</a>'
        wrong = escape(row["failure"] or row["warnings"])
        warning = f'<p class="warning">{wrong}</p>' if wrong else ""
        recording, read, answer = (escape(row[name]) for name in ("recording", "read as", "answer"))
        return f"<tr><td>{recording}</td><td>{read}</td><td>{link}</td><td>{answer}{warning}</td></tr>"

    heads = "".join(f"<th>{head}</th>" for head in ("recording", "read as", "table", "answer"))
    rows_of_page = f"<tr>{heads}</tr>{''.join(map(cells, rows))}"
    page = plain_page(
        folder.name, {"recordings": len(rows), "failed": failed},
        f'<section><div class="scroll"><table class="words stacked">{rows_of_page}</table></div></section>',
    )  # fmt: skip
    table = pd.DataFrame(list(rows), columns=list(COLUMNS)).to_csv(index=False)
    write_files({folder / "index.csv": table, folder / "index.html": page})
