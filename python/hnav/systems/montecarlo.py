"""Many simulations of a system with one seed each, on this machine or a Dask cluster, and the statistics of their spread.

Run i of every scenario has the seed first_seed + i, so scenarios meet the same draws and any number of workers gives
the same numbers. A run that fails is a row with its reason. Finished runs are kept as they come, and a command that was
killed goes on from there. hnav.systems.statistics explains their spread.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import importlib.util
import io
import shlex
import threading
import uuid
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from hnav import __version__
from hnav.errors import HnavError
from hnav.io.outputs import OutputError, write_files
from hnav.io.record_file import RecordFile
from hnav.systems.navigation_views import navigators
from hnav.systems.pool import results
from hnav.systems.run_views import Estimate, estimates
from hnav.systems.simulation import LoadedSystem, Run, simulate
from hnav.systems.ssp_reader import system_files
from hnav.systems.statistics import finite_mean
from hnav.systems.structure import System, refuse

# Only signals that the figures need are recorded, so that 200 runs fit in memory.
RECORDED = (
    "*.truth.latitude", "*.truth.longitude", "*.truth.height", "*.truth.euler[3]", "*.nav.*", "*.att.heading",
    "*.truth.q[?]", "*.att.q[?]", "*.att.sigma[?]", "*.cov.P*", "*.align.*", "*.nis.accel", "*.nis.mag", "*.count.accel_used", "*.count.mag_used",
)  # fmt: skip
NEES_AT_S = (10.0, 30.0, 60.0)
COMMAND = "simulate"
"""Key of the table's attrs: the command that repeats a run, without scenario and seed."""


@dataclass(frozen=True)
class Job:
    """One run, small enough to send to a worker."""

    system: str
    scenario: str | None
    seed: int
    grade: str | None = None
    settings: Mapping[str, str] = field(default_factory=dict)
    step_s: float | None = None
    stop_s: float | None = None
    allow_outside: bool = False


def jobs(system: str, scenarios: Sequence[str | None], runs: int, first_seed: int = 1, **options: Any) -> list[Job]:
    """Scenario by scenario, seed by seed. Raises HnavError for fewer than two runs, which have no spread."""
    if runs < 2:
        refuse(f"runs = {runs}: at least 2 are needed for an interval", "runs")
    return [Job(system, scenario, first_seed + i, **options) for scenario in scenarios for i in range(runs)]


Row = dict[str, Any]


class _Kept:
    """A system that stays loaded for a command, in one thread. It is unloaded when the command ends, after the run in
    progress.
    """

    def __init__(self, job: Job):
        self.system = LoadedSystem(job.system, job.allow_outside)
        self.in_use = threading.Lock()
        self.ended = False

    def go_if_ended(self) -> None:
        """Closes the system once: the lock stays locked."""
        if self.ended and self.in_use.acquire(blocking=False):
            self.system.__exit__()


# Systems loaded by this process, by command, thread and system: a worker loads once, not once for each run.
_kept: dict[tuple[str, int, str, bool], _Kept] = {}


def unload(command: str) -> None:
    """Closes the systems of this command."""
    for place in [place for place in list(_kept) if place[0] == command]:
        kept = _kept.pop(place)
        kept.ended = True
        kept.go_if_ended()


def rows_of(job: Job, command: str | None = None) -> list[Row]:
    """One row for each filter of one run; a run that fails gives one row with `failure` and no figures.

    command: what is loaded stays so for its next run in this thread, until unload(command).
    """
    if command is None:
        return _rows_of(job, job.system)
    place = command, threading.get_ident(), job.system, job.allow_outside
    try:
        kept = _kept[place] if place in _kept else _kept.setdefault(place, _Kept(job))
    except OutputError:
        raise
    except HnavError as error:
        return [_failed(job, str(error))]
    with kept.in_use:
        rows = _rows_of(job, kept.system)
    if rows[0]["failure"]:  # the state of an FMU after a failure is undefined
        _kept.pop(place, None)
        kept.ended = True
    kept.go_if_ended()
    return rows


def _rows_of(job: Job, system: str | LoadedSystem) -> list[Row]:
    key = _key(job)
    try:
        run = simulate(
            system, job.scenario, job.grade, job.settings, job.seed, job.step_s, job.stop_s, RECORDED, None, job.allow_outside
        )
        if run.about["failure"]:
            return [_failed(job, run.about["failure"])]
        found = {e.name: _figures(e, run) for e in estimates(run)} | {n.name: n.figures for n in navigators(run)}
        if not found:
            lacks = "has no attitude filter (att.q), and no filter that navigates (nav.latitude) beside a true place"
            refuse(f"system {run.about['system']} {lacks}: there is nothing to compare")
        return [key | {"filter": name, "failure": ""} | figures for name, figures in found.items()]
    except OutputError:  # a full disk is not a result of the run
        raise
    except HnavError as error:
        return [_failed(job, str(error))]


def _key(job: Job) -> Row:
    return {"scenario": job.scenario or "as bound", "seed": job.seed}


def _failed(job: Job, reason: str) -> Row:
    return _key(job) | {"filter": "", "failure": reason}


def _figures(estimate: Estimate, run: Run) -> dict[str, float]:
    """Mean squared errors rather than their roots: the paper's Table 1 compares means over runs of squares."""
    error, nees = estimate.error_rad, estimate.nees
    if error is None:
        refuse("the system puts out no truth (truth.q): there is nothing to compare with")
    degrees = np.degrees(error)
    found = {f"mse_{axis}_deg2": finite_mean(degrees[:, i] ** 2) for i, axis in enumerate(("north", "east", "down"))}
    found |= {"mse_deg2": finite_mean(np.sum(degrees**2, axis=1)), "final_deg": float(np.linalg.norm(degrees[-1]))}
    found["nees"] = np.nan if nees is None else finite_mean(nees)
    for t_s in NEES_AT_S:
        # The last row not after the time; none in a shorter run.
        row = int(np.searchsorted(run.t_s, t_s * (1 + 1e-12), side="right")) - 1
        found[f"nees_{t_s:g}s"] = np.nan if nees is None or run.t_s[-1] < t_s * (1 - 1e-12) else float(nees[row])
    for sensor, name in (("accel", "force"), ("mag", "field")):
        found[f"nis_{name}"] = finite_mean(run[f"{estimate.name}.nis.{sensor}"][estimate.sampled(sensor)])
    return found | {
        "tilt_ready_s": estimate.ready_s("align.tilt_ready"),
        "heading_ready_s": estimate.ready_s("align.heading_ready"),
    }


def finished_runs(file: Path, work: Sequence[Job], system: System) -> RecordFile:
    """The runs of this work that are finished, in a file that grows with each. Raises HnavError for runs of other work.

    system: the system of the jobs, read; another build of its FMUs is another system.
    """
    content = hashlib.sha256()
    for path in (*system_files(work[0].system), *(component.fmu for component in system.components.values())):
        content.update(path.read_bytes())
    versions = {name: importlib.metadata.version(name) for name in ("numpy", "fmpy")} | {"hnav": __version__}
    of_jobs = [vars(job) | {"settings": dict(job.settings)} for job in work]
    shared = {name: _one_or_all([job[name] for job in of_jobs]) for name in of_jobs[0]}
    of_all = {"kind": "runs of hnav montecarlo", **shared, "content of the system": content.hexdigest(), **versions}
    return RecordFile(file, of_all)


def _one_or_all(values: Sequence[Any]) -> Any:
    """The common value of all runs, otherwise the values of each run."""
    return values[0] if all(value == values[0] for value in values) else list(values)


def run_jobs(
    work: Sequence[Job], workers: int = 1, scheduler: str | None = None, progress: Callable[[int, int], None] | None = None,
    kept: RecordFile | None = None,
) -> pd.DataFrame:  # fmt: skip
    """A row for each filter and run, in the order of the jobs whatever finishes first.

    workers: processes on this machine; 1 needs no Dask. scheduler: address of a Dask cluster instead. kept: the runs that
    are finished, to which those that finish are added. Raises HnavError if Dask is missing or the scheduler does not
    answer, and OutputError when a disk is full.
    """
    found: dict[int, list[Row]] = {} if kept is None else dict(kept.records)
    left = [(i, job) for i, job in enumerate(work) if i not in found]
    if progress and found:
        progress(len(found), len(work))
    for i, rows, finished in _results(left, workers, scheduler):
        found[i] = kept.add([i, rows])[1] if kept is not None and finished else rows
        if progress:
            progress(len(found), len(work))
    table = pd.DataFrame([row for i in sorted(found) for row in found[i]])
    table.attrs[COMMAND] = simulate_command(work[0])
    return table


def simulate_command(job: Job) -> str:
    """The hnav simulate command common to all runs."""
    given = {"--grade": job.grade, "--step": job.step_s, "--stop": job.stop_s}
    words = [word for option, value in given.items() if value is not None for word in (option, str(value))]
    words += [word for name, value in job.settings.items() for word in ("--set", f"{name}={value}")]
    return shlex.join(["hnav", "simulate", job.system, *words, *(["--allow-outside"] if job.allow_outside else [])])


def _results(work: Sequence[tuple[int, Job]], workers: int, scheduler: str | None) -> Iterator[tuple[int, list[Row], bool]]:
    """Number of the job, its rows and whether it ended normally, in order of completion."""
    command = uuid.uuid4().hex

    def failed(job: Job, reason: str) -> list[Row]:
        return [_failed(job, reason)]

    return results(work, partial(rows_of, command=command), failed, workers, scheduler, partial(unload, command))


def need_parquet() -> None:
    """Raises HnavError before the runs when Parquet cannot be written."""
    if importlib.util.find_spec("pyarrow") is None:
        refuse("Parquet needs pyarrow: python -m pip install pyarrow (the extra 'montecarlo')")


def write_table(table: pd.DataFrame, file: Path) -> None:
    """Parquet, a row for each filter and run. Raises HnavError if it cannot be written."""
    need_parquet()
    content = io.BytesIO()
    table.to_parquet(content, index=False)
    write_files({file: content.getvalue()}, make_folders=True)
