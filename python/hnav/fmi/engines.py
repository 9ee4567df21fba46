"""One call that runs a filter over a recording, by the C library or by an FMU.

Every engine gives the estimate just after each sample; they agree bit for bit, Model Exchange to the importer's
tolerance.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hnav.errors import HnavRuntimeError, HnavValueError
from hnav.filters import attitude_recording
from hnav.filters.attitude_answers import Run
from hnav.filters.attitude_recording import Progress
from hnav.filters.options import FILTERS, Options
from hnav.io.recordings import Recording

ENGINES = ("c", "fmi2-cs", "fmi2-me", "fmi3-cs", "fmi3-me")


def run_recording(
    recording: Recording,
    filter: str,
    engine: str = "c",
    settings: Mapping[str, str] | None = None,
    preset: str = "default",
    step_s: float | None = None,
    progress: Progress | None = None,
    smooth: bool = False,
) -> Run:
    """settings: option name to value as text. step_s: communication step of an FMU; None: from sample to sample.
    smooth: with hindsight, by the AHRS in C. Smoothing and late fields leave Run.accepted out.

    Raises HnavError for impossible settings and engines.
    """
    _check(recording, filter, engine, step_s, smooth)
    settings = dict(settings or {})
    if engine != "c":
        from hnav.fmi.fmu_run import run_fmu  # fmpy takes a while to load

        return run_fmu(recording, filter, engine, settings, preset=preset, step_s=step_s, progress=progress)
    return attitude_recording.run_recording(recording, Options(filter, preset, **settings), progress, smooth)


def _check(recording: Recording, filter: str, engine: str, step_s: float | None, smooth: bool) -> None:
    """Raises HnavError for an unsupported combination of options."""
    for name, value, known in (("filter", filter, FILTERS), ("engine", engine, ENGINES)):
        if value not in known:
            raise HnavValueError("option", f"{name} = {value}: choose one of {', '.join(known)}", name)
    if step_s is not None and not 0 < step_s < np.inf:
        raise HnavValueError("option", f"step_s = {step_s:g}: must be above 0 seconds", "step_s")
    if len(recording.t_s) == 0:
        raise HnavValueError("size", f"{recording.name}: no samples")
    if smooth and engine != "c":
        raise HnavRuntimeError("unsupported", f"engine = {engine}: smoothing needs engine c, for an FMU sees no future", "engine")
    if recording.field_t_s is not None and engine != "c":
        raise HnavRuntimeError("unsupported", f"engine = {engine}: late samples need engine c", "engine")
