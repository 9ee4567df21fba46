"""Certificates of the paper's experiment: the cost of the search, and certificates of damaged recordings.

    ./run study certificate [--part time|damaged]

time: processor seconds of the search, beside the time that it announces. damaged: lost rows, gaps, random loss and jitter of a run of 25 s,
with the corrections after 15 s; each that is certified is attacked by starts on the boundary of its region: 200 random ones, and six
rounds that move the worst of them (ascent). V over its bound must not exceed 1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Annotated

import numpy as np
import typer
from rich.table import Table

from hnav.certify.boundary_starts import fall_from_boundary, random_directions
from hnav.certify.certificate import Certificate, certify
from hnav.certify.gain_record import GainRecord, record_gains
from hnav.certify.run import Thinning
from hnav.certify.windows import windows_of
from hnav.cli.console import show
from hnav.errors import HnavError
from hnav.filters.options import Options
from hnav.io.recordings import Recording
from hnav.systems.turntable_recording import INTERVAL_S, Turntable
from studies.bench.stress import with_rows
from studies.command import check_choices, titled_table, tracked

SEED, BEGIN_S, DURATION_S = 5, 15.0, 25.0
PARTS = ("time", "damaged")
STARTS, ROUNDS, KEPT, STEP = 200, 6, 20, 0.3  # of the ascent: the worst that are kept, and how far others begin beside them
# Name, seconds of the experiment, what is left of its samples, and processor seconds of version 0.1 where it was measured.
COSTS: tuple[tuple[str, float, Thinning, str], ...] = (
    ("one rate", 25.0, Thinning(), "64"),
    ("windows of five", 19.0, Thinning(field_every=5), "317"),
    ("field at 10 Hz", 25.0, Thinning(field_every=10), "more than 400"),
    ("1 % lost", 25.0, Thinning(lost=0.01), "-"),
    ("4 Hz", 40.0, Thinning(25, 25), "-"),
)
MIDDLE = round(20.0 / INTERVAL_S)  # the row where the damage begins


def without(rows: Callable[[int], np.ndarray]) -> Callable[[Recording], Recording]:
    """Without some rows, counted among n."""

    def damaged(data: Recording) -> Recording:
        return with_rows(data, np.delete(np.arange(len(data.t_s)), rows(len(data.t_s))))

    return damaged


def gap(seconds: float) -> Callable[[Recording], Recording]:
    return without(lambda n: np.arange(MIDDLE, MIDDLE + round(seconds / INTERVAL_S)))


def jittered(data: Recording) -> Recording:
    """Stamps that are late by up to half an interval."""
    return replace(data, t_s=data.t_s + 0.5 * INTERVAL_S * np.random.default_rng(2).random(len(data.t_s)))


DAMAGES: dict[str, Callable[[Recording], Recording]] = {
    "none": lambda data: data,
    **{f"{count} row{'s' * (count > 1)} lost": gap(count * INTERVAL_S) for count in (1, 2, 5, 35)},
    "30 % of the rows lost": without(lambda n: np.flatnonzero(np.random.default_rng(1).random(n) < 0.3)),
    "jitter": jittered,
    "gap of 0.9 s": gap(0.9),
    "gap of 3 s": gap(3.0),
    "gap of 10 s": gap(10.0),
    "gap of 3 s, before it": lambda data: data.cropped(MIDDLE * INTERVAL_S),
    "gap of 3 s, after it": gap(3.0),
    "gap of 10 s, after it": gap(10.0),
}
AFTER_S = 15.0  # from the new start to the first correction that is certified, as from the first one


def recorded(data: Recording, settings: dict[str, str]) -> GainRecord:
    options = Options("hrekf", "paper", **{"solver": "closed_form"} | settings | {"gamma_mode": "off"})
    return record_gains(data, options).from_time(float(data.t_s[0]) + BEGIN_S)


def attack(found: Certificate, record: GainRecord, seed: int = SEED) -> float:
    """The largest V over its bound: random starts, then starts beside the worst of them, each round nearer."""
    assert found.P is not None, "there is a region"
    rng = np.random.default_rng(seed)
    directions, after, T = random_directions(STARTS, rng), windows_of(record).after, [c.interval_s for c in record.corrections]
    worst = 0.0
    for turn in range(ROUNDS + 1):
        fall = fall_from_boundary(record, found.P, after, found.level, found.region_rate_1_s, directions)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratios = np.where(fall.V[:, :-1] > 1e-20, fall.V[:, 1:] / fall.V[:, :-1], 0.0) * np.exp(
                2 * found.region_rate_1_s * np.array(T)
            )
        each = ratios.max(axis=1)
        worst = max(worst, float(each.max()))
        best = directions[np.argsort(each)[-KEPT:]]
        best = best / np.linalg.norm(best, axis=1, keepdims=True)
        beside = np.repeat(best, STARTS // KEPT - 1, axis=0)
        directions = np.vstack([best, beside + STEP * 0.5**turn * rng.normal(size=beside.shape)])
    return worst


def damaged(name: str) -> tuple[str, ...]:
    """Cells: corrections, longest interval, verdict, region, attack."""
    after = "after it" in name
    made = Turntable().run(DURATION_S + (10.0 if "10 s" in name else 0.0) + (AFTER_S if after else 0.0), SEED)
    try:
        record = recorded(DAMAGES[name](made.recording), made.settings)
        record = record.from_time(record.restarts[-1] + AFTER_S) if after else record
        found = certify(record, starts=0)
    except HnavError as error:
        return name, "-", "-", f"refused: {error}", "-", "-"
    longest = max(c.interval_s for c in record.corrections)
    verdict = "certified" if found.certified else f"not certified: {found.reason}"
    tried = "-" if found.P is None else f"{attack(found, record):.4f}"
    return name, str(found.corrections), f"{longest:.3g}", verdict, "-" if found.P is None else f"{found.region_deg:.1f}", tried


def timed(name: str, duration_s: float, thinning: Thinning, before: str) -> tuple[str, ...]:
    """Cells: corrections, longest window, programs, seconds announced, passed and of the processor, and those before."""
    made = Turntable().run(duration_s, SEED)
    record = recorded(thinning.of(made.recording, SEED), made.settings)
    announced: list[float] = []
    found = certify(record, starts=100, announce=announced.append)
    verdict = "certified" if found.certified else found.reason
    counts = (str(found.corrections), str(found.longest_window), str(found.solves))
    return name, *counts, *(f"{seconds:.3g}" for seconds in (announced[0], found.seconds, found.processor_s)), before, verdict


def command(
    part: Annotated[str | None, typer.Option(help="time or damaged; without it both")] = None,
    only: Annotated[str | None, typer.Option(metavar="NAME", help="One case of the part")] = None,
) -> None:
    """Cost of the search, and certificates of damaged recordings."""
    check_choices("--part", [part], PARTS)
    check_choices("--only", [only], [*DAMAGES, *(cost[0] for cost in COSTS)])
    if part != "damaged":
        show(_time_table(only), width=150)
    if part != "time":
        show(_damage_table(only), width=190)


def _time_table(only: str | None) -> Table:
    table = titled_table(
        "the search for a certificate", "samples", "corrections | longest window | programs | announced, s | passed, s | processor, s | version 0.1, s | verdict"
    )  # fmt: skip
    for cost in tracked([cost for cost in COSTS if only in (None, cost[0])], "time"):
        table.add_row(*timed(*cost))
    return table


def _damage_table(only: str | None) -> Table:
    table = titled_table("recordings with damage", "damage", "corrections | longest interval, s")
    for head in ("verdict", "region, deg", f"attack by {STARTS} starts, {ROUNDS} rounds of ascent"):
        table.add_column(head)
    for name in tracked([name for name in DAMAGES if only in (None, name)], "damage"):
        table.add_row(*damaged(name))
    return table
