"""hnav's filters beside those of others, on the same recordings, as they are and made harder (see studies.stress).

    rows = [row for row in benchmark(recordings, contenders(["ahrs"], ["vqf"]), ["BROAD", "CROP"])]
    for line in summary(rows): ...

Scores are those of hnav.reports.scores. Times are medians over trials and repeats of the time per sample; within a trial
everybody runs in turn, so that whatever else the machine does hits all alike. What is timed is one call on whole
arrays; hnav's fills an attitude for each sample and nothing else (its sigmas cost as much again), VQF's what it always
fills. imufusion has no such call and is fed by a Python loop, ahrs is Python itself: their times are marked.
"""

from __future__ import annotations

import csv
import math
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from hnav.errors import HnavValueError
from hnav.fmi.engines import run_recording
from hnav.io.recordings import TRIAL_NAME, Recording
from hnav.native.library import FILTERS, Filter, Options, parse_setting
from hnav.renamed import now_called
from hnav.reports.scores import nees, score
from studies.peers import PEERS, find_peer, run_peer
from studies.stress import nominal_rate_hz, variants

LAST_UNDISTURBED_TRIAL = 23
SMOOTH = "-smooth"
# Peers in pure Python take minutes for what the others do in seconds; they run when they are named.
DEFAULT_PEERS = tuple(name for name, peer in PEERS.items() if peer.package != "ahrs")
DEFAULT_FILTERS = (*FILTERS, "ahrs:solver=closed_form", f"ahrs{SMOOTH}")


@dataclass(frozen=True)
class Estimate:
    """What a contender makes of a recording."""

    q_nb: np.ndarray  # n x 4, body to east-north-up
    sigma_rad: np.ndarray | None  # n x 3, if it states any
    us_per_sample: float | None  # if this very run may serve as a timing


@dataclass(frozen=True)
class Contender:
    """One filter in the benchmark. time_us gives the time per sample of one run, NaN where it would mean nothing."""

    name: str
    ours: bool
    offline: bool  # sees the future
    estimate: Callable[[Recording, float], Estimate]  # recording, its nominal rate in Hz
    time_us: Callable[[Recording, float], float]
    looped: bool = False  # its time is mostly Python's


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


@dataclass(frozen=True)
class Line:
    """Means over the trials of one filter in one set; NaN without trials."""

    set: str
    filter: str
    total_deg: float
    heading_deg: float
    inclination_deg: float
    undisturbed_deg: float
    disturbed_deg: float
    nees_per_axis: float
    us_per_sample: float
    trials: int
    failures: int


# --------------------------------------------------------------------------------------------- contenders


def contenders(filters: Sequence[str], peers: Sequence[str]) -> tuple[list[Contender], list[str]]:
    """Those that can run, and a line for each peer whose package is missing. Raises HnavError for unknown names.

    A filter is NAME, NAME-smooth for its smoother, or either with options: NAME:option=value:option=value.
    """
    ready, missing = [own_contender(name) for name in filters], []
    for name in peers:
        peer = find_peer(name)
        if peer.installed():
            ready.append(_peer_contender(name))
        else:
            missing.append(f"{name} is not beside them: the package {peer.package} is not installed (pip install {peer.package})")
    return ready, missing


def own_contender(name: str) -> Contender:
    """A filter of hnav by name. Raises HnavError for unknown filters and options."""
    head, *pairs = name.split(":")
    smooth = head.endswith(SMOOTH)
    filter = head.removesuffix(SMOOTH)
    if filter not in FILTERS:
        raise HnavValueError("option", f"filter {name}{now_called(filter, 'filter')}: choose from {', '.join(DEFAULT_FILTERS)}")
    settings = {"navigation_frame": "enu"} | dict(parse_setting(pair) for pair in pairs)
    Options(filter, **settings)  # an impossible setting is told before the first run

    def estimate(recording: Recording, rate_hz: float) -> Estimate:
        result = run_recording(recording, filter, settings=settings, smooth=smooth)
        return Estimate(result.q_nb, result.sigma_rad, None)

    def time_us(recording: Recording, rate_hz: float) -> float:
        if recording.field_t_s is not None and not smooth:
            return math.nan  # samples pushed one by one from Python: its time, not the filter's
        attitude_filter = Filter(Options(filter, **settings))
        batch = attitude_filter.smooth if smooth else attitude_filter.run
        samples = (recording.t_s, recording.rate_b_rad_s, recording.force_b_m_s2, recording.field_b_tesla)
        begin = time.perf_counter()
        batch(*samples, only=("q_nb",))
        return 1e6 * (time.perf_counter() - begin) / len(recording.t_s)

    return Contender(name, True, smooth, estimate, time_us)


def _peer_contender(name: str) -> Contender:
    def estimate(recording: Recording, rate_hz: float) -> Estimate:
        q_nb, us = run_peer(name, recording, rate_hz)
        return Estimate(q_nb, None, us)

    def time_us(recording: Recording, rate_hz: float) -> float:
        return run_peer(name, recording, rate_hz)[1]

    return Contender(name, False, PEERS[name].offline, estimate, time_us, PEERS[name].looped)


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
    result = score(estimate.q_nb, recording.reference_q_nb, recording.movement)
    scored = recording.movement & np.isfinite(recording.reference_q_nb).all(axis=1)
    missing = int(np.sum(scored & ~np.isfinite(estimate.q_nb).all(axis=1)))
    if missing == scored.sum():
        return _failed(set_name, name, recording, "no estimate in the scored phase")
    stated = math.nan
    if estimate.sigma_rad is not None:
        stated = nees(estimate.q_nb, estimate.sigma_rad, recording.reference_q_nb, recording.movement).nees_per_axis
    return Row(set_name, name, recording.name, is_disturbed(recording.name), *result, stated, us_per_sample, missing, "")


def _failed(set_name: str, name: str, recording: Recording, reason: str) -> Row:
    nothing = math.nan
    return Row(
        set_name, name, recording.name, is_disturbed(recording.name), nothing, nothing, nothing, nothing, nothing, 0, reason
    )


def is_disturbed(name: str) -> bool:
    """Whether a BROAD trial of this name was recorded in a disturbed field."""
    match = TRIAL_NAME.match(name)
    return bool(match) and int(match.group(1)) > LAST_UNDISTURBED_TRIAL


# --------------------------------------------------------------------------------------------- results


def summary(rows: Iterable[Row]) -> list[Line]:
    """One line for each set and filter, in the order of the rows; plain means over the trials that did not fail."""
    groups: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        groups.setdefault((row.set, row.filter), []).append(row)
    return [_line(set_name, name, group) for (set_name, name), group in groups.items()]


def _line(set_name: str, name: str, rows: list[Row]) -> Line:
    good = [row for row in rows if not row.failure]

    def mean(column: str, keep: Callable[[Row], bool] = lambda row: True, middle=np.mean) -> float:
        values = [value for row in good if keep(row) and not math.isnan(value := getattr(row, column))]
        return float(middle(values)) if values else math.nan

    return Line(
        set_name, name, mean("total_deg"), mean("heading_deg"), mean("inclination_deg"),
        mean("total_deg", lambda row: not row.disturbed), mean("total_deg", lambda row: row.disturbed),
        mean("nees_per_axis"), mean("us_per_sample", middle=np.median), len(good), len(rows) - len(good),
    )  # fmt: skip


def write_csv(path: Path, rows: Iterable[Row]) -> None:
    """One row for each set, filter and trial; empty cells where there is no figure. Raises OSError."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(field.name for field in fields(Row))
        for row in rows:
            writer.writerow(_cell(value) for value in vars(row).values())


def _cell(value) -> str:
    if isinstance(value, bool):
        return str(int(value))
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.6g}"
    return str(value)
