"""Many jobs at once: processes of this machine, or those of a Dask cluster."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from itertools import islice
from typing import Any, TypeVar

from hnav.io.outputs import OutputError
from hnav.systems.structure import refuse

Job = TypeVar("Job")
Answer = TypeVar("Answer")


AHEAD = 4
"""Jobs per worker submitted at a time: with all jobs at once the memory of the cluster would grow with their number."""


UNWATCHED = {"distributed.worker.profile.enabled": False, "distributed.admin.low-level-log-length": 100}
"""Settings for local workers, because the records of Dask's status page grow with the number of jobs."""


def no_end() -> None:
    """End function of work that leaves nothing in its process."""


def results(
    work: Sequence[tuple[int, Job]], call: Callable[[Job], Answer], failed: Callable[[Job, str], Answer], workers: int = 1,
    scheduler: str | None = None, end: Callable[[], None] = no_end,
) -> Iterator[tuple[int, Answer, bool]]:  # fmt: skip
    """Number of the job, its answer and whether it ended by itself, in order of completion.

    workers: processes on this machine; 1 needs no Dask. scheduler: address of a Dask cluster instead. failed: the answer of a job whose
    worker died. end: called in every process when all is done. Raises HnavError if Dask is missing or the scheduler does not answer, and
    OutputError when a disk is full.
    """
    if workers < 1:
        refuse(f"workers = {workers}: at least 1 is needed", "workers")
    if not work or (workers == 1 and scheduler is None):
        try:
            yield from ((i, call(job), True) for i, job in work)
        finally:
            end()
        return
    with _client(workers, scheduler) as client, _ending(client, end):
        from distributed import as_completed

        futures: dict[Any, tuple[int, Job]] = {}
        finished_ones, left = as_completed(), iter(work)

        def submit(count: int) -> None:
            for i, job in islice(left, count):
                # Keys by number, because equal jobs are separate runs.
                future = client.submit(call, job, key=f"run-{i}-{id(work)}", pure=False)
                futures[future] = i, job
                finished_ones.add(future)

        submit(AHEAD * max(1, sum(client.ncores().values())))
        for future in finished_ones:
            i, job = futures.pop(future)
            submit(1)
            try:
                answer, finished = future.result(), True
            except OutputError:
                raise
            except Exception as error:  # a crashed worker loses only its own run
                answer, finished = failed(job, f"{type(error).__name__}: {error}"), False
            yield i, answer, finished


@contextmanager
def _ending(client: Any, end: Callable[[], None]) -> Iterator[None]:
    """Clears the data of this command from workers that continue to run."""
    try:
        yield
    finally:
        client.run(end, on_error="ignore")


@contextmanager
def _client(workers: int, scheduler: str | None) -> Iterator[Any]:
    """Dask's client of a cluster of this machine or of the one at the address. Raises HnavError."""
    try:
        import dask
        from distributed import Client, LocalCluster
    except ImportError:
        refuse("many workers need Dask: python -m pip install distributed (the extra 'montecarlo')")
    with ExitStack() as closed:
        closed.enter_context(dask.config.set(UNWATCHED))
        try:
            # The status page is for this machine only, at a free port. A failure in a run becomes a row; the messages of
            # stopping workers are not useful.
            where = scheduler or closed.enter_context(
                LocalCluster(
                    n_workers=workers, threads_per_worker=1, dashboard_address="127.0.0.1:0", silence_logs=logging.CRITICAL
                )
            )
            client = closed.enter_context(Client(where, timeout="10s"))
        except (OSError, TimeoutError, ValueError) as error:
            refuse(f"scheduler {scheduler or 'of this machine'}: {error}")
        yield client
