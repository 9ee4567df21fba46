"""What is measured: each function answers one row of its table for each size that it is given."""

from __future__ import annotations

import resource
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hnav.cli.words import UsageError
from hnav.filters.attitude import Filter
from hnav.systems.montecarlo import Job, jobs, rows_of, run_jobs
from studies.counting import cost_of_hnav
from studies.long import Motion, memory_mb

HEADER = "t_s,gx,gy,gz,ax,ay,az,mx,my,mz\n"
INTERVAL_S = 0.01
BLOCK_ROWS = 10  # that a filter gets at a time beside others
HORIZON_S = 1.0
SYSTEM, SCENARIO = "turntable", "nominal"


def of_rows(sizes: Sequence[int]) -> Iterator[dict[str, float]]:
    """`hnav filter` on a file, and the largest memory of its process. Raises UsageError when the command fails."""
    with tempfile.TemporaryDirectory() as folder:
        source, out = Path(folder) / "long.csv", Path(folder) / "out.csv"
        for rows in sizes:
            write_rows(source, rows)
            cost = cost_of_hnav("filter", source, "--out", out)
            yield {"rows": rows, "cpu_s": cost.cpu_s, "memory_mb": cost.memory_bytes / 2**20}


def write_rows(path: Path, rows: int) -> None:
    """A table of a body that turns about all axes, 100 Hz."""
    motion = Motion()
    samples = np.column_stack([motion.rate, motion.force, motion.field])
    period = [",".join(f"{value:.9g}" for value in row) for row in samples[:rows].tolist()]
    with path.open("w", encoding="ascii") as file:
        file.write(HEADER)
        for first in range(0, rows, len(period)):
            count = min(len(period), rows - first)
            file.writelines(f"{(first + k) * INTERVAL_S:.2f},{period[k]}\n" for k in range(count))


def of_filters(sizes: Sequence[int], samples: int) -> Iterator[dict[str, float]]:
    """Filters that take turns. samples: of all filters together, that each size is measured with."""
    motion = Motion()
    for count in sizes:
        before_mb = memory_mb()
        filters = [Filter("ahrs", solver="closed_form") for _ in range(count)]
        rounds = max(2, samples // (count * BLOCK_ROWS))
        seconds = []
        for k in range(rounds):
            rows = np.arange(k * BLOCK_ROWS, (k + 1) * BLOCK_ROWS)
            rate, force, field = (values[rows % len(motion.rate)] for values in (motion.rate, motion.force, motion.field))
            begin = time.thread_time()
            for one in filters:
                one.run(rows * INTERVAL_S, rate, force, field, only=("q_nb",))
            seconds.append(time.thread_time() - begin)
        # The first round finds the attitude and touches the memory.
        us = 1e6 * float(np.sum(seconds[1:])) / ((rounds - 1) * count * BLOCK_ROWS)
        yield {"filters": count, "us_per_sample": us, "kb_per_filter": 1024 * (memory_mb() - before_mb) / count}


def of_age(ages_s: Sequence[float], rows: int = 6000) -> Iterator[dict[str, float]]:
    """Fields that come late, one in ten rows. The extra time of a late field over one in time: the filter restores an earlier
    state and propagates again."""
    motion = Motion()
    in_time = _seconds_with(motion, 0, rows)
    for late_s in ages_s:
        us = 1e6 * (_seconds_with(motion, round(late_s / INTERVAL_S), rows) - in_time)
        yield {"late_s": late_s, "us_per_late_sample": us, "us_per_row": us / round(late_s / INTERVAL_S)}


def _seconds_with(motion: Motion, behind: int, rows: int) -> float:
    """Of the processor, for a field and the next advance, each tenth row and that many rows late: median."""
    one = Filter("ahrs", solver="closed_form", horizon_s=HORIZON_S, queue_capacity=1024)
    found = []
    for k in range(rows):
        t_s, row = k * INTERVAL_S, k % len(motion.rate)
        one.push_gyro(t_s, motion.rate[row])
        one.push_accel(t_s, motion.force[row])
        begin = time.thread_time()
        if k % 10 == 0 and k >= behind:
            one.push_mag(t_s - behind * INTERVAL_S, motion.field[(k - behind) % len(motion.rate)])
        one.advance(t_s)
        if k % 10 == 0 and k >= rows // 4:
            found.append(time.thread_time() - begin)
    return float(np.median(found))


def of_workers(runs: int, workers: Sequence[int], stop_s: float | None = None) -> Iterator[dict[str, Any]]:
    """Runs of the turntable system, by the time of the processors: runs_per_s with a processor for each worker. First FMUs loaded
    for each run, then once for each worker. Raises UsageError when a run fails."""
    work = jobs(SYSTEM, [SCENARIO], 3 * runs, stop_s=stop_s)
    rows_of(work[0])  # modules
    begin = time.thread_time()
    for job in work[:runs]:
        if failure := rows_of(job)[0]["failure"]:
            raise UsageError(f"seed {job.seed}: {failure}")
    rate = runs / (time.thread_time() - begin)
    yield {"how": "loaded for each run", "runs_per_s": rate, "per_worker": rate}
    for count in workers:
        # The difference leaves out what it takes to begin.
        rate = 2 * runs / (_processor_s(work, count) - _processor_s(work[:runs], count))
        yield {"how": f"loaded once, {count} worker{'s' if count > 1 else ''}", "runs_per_s": count * rate, "per_worker": rate}


def _processor_s(work: Sequence[Job], workers: int) -> float:
    """Of this process and its workers, which end with the runs."""

    def used() -> float:
        children = resource.getrusage(resource.RUSAGE_CHILDREN)
        return time.process_time() + children.ru_utime + children.ru_stime

    begin = used()
    run_jobs(work, workers)
    return used() - begin
