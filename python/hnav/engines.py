"""One call that runs a filter over a recording, by the C library or by an FMU.

Every engine gives the estimate just after each sample; they agree bit for bit, Model Exchange to the importer's
tolerance.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from hnav.library import FILTERS, Filter, HnavError, Options, Run
from hnav.recordings import Recording

ENGINES = ("c", "fmi2-cs", "fmi2-me", "fmi3-cs", "fmi3-me")
Progress = Callable[[int, int], None]  # rows done, rows in all


@dataclass
class Result(Run):
    """What a filter made of a recording: the arrays of a Run, by which engine, and at what cost."""

    engine: str = ""
    us_per_sample: float = np.nan
    counts: dict[str, int] = field(default_factory=dict)  # used, gated, late, ... by name


def run_recording(
    recording: Recording,
    filter: str,
    engine: str = "c",
    settings: Mapping[str, str] | None = None,
    preset: str = "default",
    step_s: float | None = None,
    progress: Progress | None = None,
    smooth: bool = False,
) -> Result:
    """settings: option name to value as text. step_s: communication step of an FMU; None: from sample to sample.
    smooth: with hindsight, by the aligner in C.

    Raises HnavError for impossible settings and engines.
    """
    if filter not in FILTERS:
        raise HnavError(2, f"--filter {filter}: choose one of {', '.join(FILTERS)}")
    if engine not in ENGINES:
        raise HnavError(2, f"engine {engine}: choose one of {', '.join(ENGINES)}")
    if step_s is not None and not step_s > 0:
        raise HnavError(2, f"step {step_s:g} must be above 0 seconds")
    if len(recording.t_s) == 0:
        raise HnavError(13, f"{recording.name}: no samples")
    settings = dict(settings or {})
    if smooth and engine != "c":
        raise HnavError(16, f"smoothing needs engine c, not {engine}: an FMU sees no future")
    if engine != "c":
        from hnav.fmus import run_fmu

        return run_fmu(recording, filter, engine, settings, preset=preset, step_s=step_s, progress=progress)
    return _run_library(recording, Options(filter, preset, **settings), progress, smooth)


def _run_library(recording: Recording, options: Options, progress: Progress | None, smooth: bool) -> Result:
    attitude_filter = Filter(options)
    n = len(recording.t_s)
    chunk = n if smooth or progress is None else 20000
    batch = attitude_filter.smooth if smooth else attitude_filter.run
    parts: list[Run] = []
    begin = time.perf_counter()
    for i in range(0, n, chunk):
        rows = slice(i, i + chunk)
        field_rows = None if recording.field_b_tesla is None else recording.field_b_tesla[rows]
        parts.append(batch(recording.t_s[rows], recording.rate_b_rad_s[rows], recording.force_b_m_s2[rows], field_rows))
        if progress:
            progress(min(i + chunk, n), n)
    seconds = time.perf_counter() - begin
    arrays = {name: np.concatenate([getattr(p, name) for p in parts]) for name in vars(parts[0])}
    status = attitude_filter.status()
    counts = {f"{sensor}_used": used for sensor, used in zip(("gyro", "accel", "mag", "heading"), status.used)}
    counts |= {f"{sensor}_gated": gated for sensor, gated in zip(("gyro", "accel", "mag", "heading"), status.gated)}
    for name in ("late", "non_finite", "zero", "corrections", "gamma_raised", "covariance_repaired"):
        counts[name] = getattr(status, name)
    counts["rhs_evals"] = status.solver_rhs_evals
    return Result(**arrays, engine="c", us_per_sample=1e6 * seconds / n, counts=counts)
