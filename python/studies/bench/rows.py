"""Every contender on every variant of every recording: one row each, and means over the trials."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from hnav.io.readers.broad import is_disturbed
from hnav.io.recordings import Recording
from hnav.reports.scores import errors_rad, nees, score
from hnav.rotations import rotation_error_rad
from studies.bench.contenders import Contender, Estimate
from studies.bench.motions import MOTION, kind_of
from studies.bench.stress import nominal_rate_hz, variants


@dataclass(frozen=True)
class Row:
    """One filter on one trial of one set; RMS errors in deg over the scored phase."""

    set: str
    filter: str
    trial: str
    disturbed: bool
    total_deg: float
    heading_deg: float
    inclination_deg: float
    nees_per_axis: float  # NaN for filters that state no sigma
    us_per_sample: float  # median over repeats
    missing: int  # scored samples without an estimate
    failure: str  # "" or why there are no figures
    # NaN for filters that state no sigma and no readiness
    tilt_z2: float = math.nan  # mean square of the tilt error over its variance
    tilt_ready: float = math.nan  # share of the scored phase
    tilt_wrong: float = math.nan  # share in which tilt is ready and more than 3 deg off
    heading_ready: float = math.nan
    heading_wrong: float = math.nan  # heading is ready and more than 10 deg off


HONESTY = ("tilt_z2", "tilt_ready", "tilt_wrong", "heading_ready", "heading_wrong")
WRONG_TILT_DEG, WRONG_HEADING_DEG = 3.0, 10.0


# --------------------------------------------------------------------------------------------- running


def benchmark(
    recordings: Sequence[Recording], entered: Sequence[Contender], sets: Sequence[str], repeats: int = 1, seed: int = 5
) -> Iterator[list[Row]]:
    """The rows of one variant after the other: one row a contender. A failure is a row too, with its reason."""
    rate_hz = {recording.name: nominal_rate_hz(recording) for recording in recordings}
    for set_name in sets:
        for variant in variants(set_name, recordings, seed):
            nominal = next(rate_hz[name] for name in (variant.name, variant.name.split(" #")[0]) if name in rate_hz)
            yield run_trial(set_name, variant, nominal, entered, repeats)


def benchmark_motions(recordings: Sequence[Recording], entered: Sequence[Contender], repeats: int = 1) -> Iterator[list[Row]]:
    """The same of the set MOTION, where each kind of motion is a set of its own."""
    for recording in recordings:
        yield run_trial(f"{MOTION} {kind_of(recording)}", recording, nominal_rate_hz(recording), entered, repeats)


def run_trial(set_name: str, recording: Recording, rate_hz: float, entered: Sequence[Contender], repeats: int = 1) -> list[Row]:
    """Every contender on one recording."""
    estimates: dict[str, Estimate] = {}
    times_us: dict[str, list[float]] = {contender.name: [] for contender in entered}
    failures: dict[str, str] = {}
    for repeat in range(repeats):
        for contender in entered:
            if contender.name in failures:
                continue
            try:
                if repeat == 0:
                    estimates[contender.name] = contender.estimate(recording, rate_hz)
                us = estimates[contender.name].us_per_sample if repeat == 0 else None
                times_us[contender.name].append(contender.time_us(recording, rate_hz) if us is None else us)
            except Exception as error:  # packages of others raise what they like; one failure must not cost the rest
                failures[contender.name] = str(error).partition("\n")[0] or type(error).__name__
    return [
        _failed(set_name, contender.name, recording, failures[contender.name])
        if contender.name in failures
        else _scored(set_name, contender.name, recording, estimates[contender.name], float(np.median(times_us[contender.name])))
        for contender in entered
    ]


def _scored(set_name: str, name: str, recording: Recording, estimate: Estimate, us_per_sample: float) -> Row:
    truth, movement = recording.needed("reference_q_nb"), recording.needed("movement")
    result = score(estimate.q_nb, truth, movement)
    scored = movement & np.isfinite(truth).all(axis=1)
    missing = int(np.sum(scored & ~np.isfinite(estimate.q_nb).all(axis=1)))
    if missing == scored.sum():
        return _failed(set_name, name, recording, "no estimate in the scored phase")
    stated = math.nan
    if estimate.sigma_rad is not None:
        stated = nees(estimate.q_nb, estimate.sigma_rad, truth, movement)
    honest = _honesty(estimate, truth, scored)
    return Row(set_name, name, recording.name, is_disturbed(recording.name), *result, stated, us_per_sample, missing, "", *honest)


def _honesty(estimate: Estimate, truth: np.ndarray, scored: np.ndarray) -> tuple[float, ...]:
    """The figures of HONESTY over the rows that are scored and have an estimate."""
    if estimate.sigma_rad is None or estimate.ready is None:
        return ()
    rows = scored & np.isfinite(estimate.q_nb).all(axis=1)
    q_nb, sigma, ready = estimate.q_nb[rows], estimate.sigma_rad[rows], estimate.ready[rows]
    error = rotation_error_rad(q_nb, truth[rows])
    _, heading, tilt = np.degrees(errors_rad(q_nb, truth[rows]))
    z2 = np.mean((error[:, :2] ** 2).sum(axis=1) / (sigma[:, :2] ** 2).sum(axis=1))
    off = np.stack([tilt > WRONG_TILT_DEG, np.minimum(heading, 360 - heading) > WRONG_HEADING_DEG], 1)
    (tilt_ready, heading_ready), (tilt_wrong, heading_wrong) = ready.mean(axis=0), (ready & off).mean(axis=0)
    return float(z2), float(tilt_ready), float(tilt_wrong), float(heading_ready), float(heading_wrong)


def _failed(set_name: str, name: str, recording: Recording, reason: str) -> Row:
    nan = math.nan
    return Row(set_name, name, recording.name, is_disturbed(recording.name), nan, nan, nan, nan, nan, 0, reason)


# --------------------------------------------------------------------------------------------- results


def summary(rows: Iterable[Row]) -> list[Any]:
    """A line with the names of a row for each set and filter, in the order of the rows: plain means over the trials that did not
    fail, the median of the time, undisturbed_deg and disturbed_deg of such trials alone, and how many trials and failures; NaN
    without trials."""
    table = pd.DataFrame(map(vars, rows))
    table["undisturbed_deg"] = table.total_deg.where(~table.disturbed)
    table["disturbed_deg"] = table.total_deg.where(table.disturbed)
    table["failures"], table["trials"] = table.failure != "", table.failure == ""
    groups = table.groupby(["set", "filter"], sort=False)
    lines = groups.mean(numeric_only=True).drop(columns=["disturbed", "missing"])
    lines = lines.assign(us_per_sample=groups.us_per_sample.median(), **groups[["failures", "trials"]].sum())
    return list(lines.reset_index().itertuples())
