"""A filter over simulated starts: when it says "heading ready", how wrong it is at that instant, and the tables."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pandas as pd
import typer
from rich.table import Table
from scipy import stats

from hnav.cli.console import show
from hnav.cli.parameters import FilterName, Settings, parse_settings
from hnav.filters.options import Options
from hnav.fmi.engines import run_recording
from hnav.reports.scores import errors_rad
from studies.command import WORKERS, Seed, Workers, after, titled_table, tracked, write_rows
from studies.processes import in_order
from studies.readiness.starts import DISTURBANCES, DURATION_S, HIDDEN, MOTIONS, simulated_start

WRONG_FLOOR_DEG, WRONG_SIGMAS = 5.0, 3.0
JUDGED_S = (5.0, 20.0, 60.0)  # since the first sample, when the sigma of heading is compared with its error
CHUNK = 16  # starts that a worker takes at a time


@dataclass(frozen=True)
class Start:
    """How one start went; NaN where the filter never became ready."""

    index: int
    motion: str
    disturbance: str
    field_true_s: float  # from when on the field was the earth's alone
    ready_s: float  # since the first sample
    error_deg: float  # true total error at that instant
    heading_error_deg: float
    sigma_deg: float  # stated then: root sum of squares of the three sigmas
    heading_z2: tuple[float, ...] = (np.nan,) * len(JUDGED_S)  # squared error of heading over its variance, at JUDGED_S

    @property
    def ready(self) -> bool:
        return bool(np.isfinite(self.ready_s))

    @property
    def wrong(self) -> bool:
        return self.ready and self.error_deg > max(WRONG_SIGMAS * self.sigma_deg, WRONG_FLOOR_DEG)

    @property
    def wrong_in_true_field(self) -> bool:
        """Wrong although the field was true by then. A steady false field cannot be distinguished from a true one."""
        return self.wrong and self.ready_s >= self.field_true_s


def judge(index: int, filter: str, settings: dict[str, str], seed: int = 1, place: bool = False, **made: bool) -> Start:
    """Runs a filter over start `index` and looks at the first instant of heading_ready. place: the filter is given strength and dip
    of the earth's field; made: as of simulated_start. Raises HnavError."""
    simulated = simulated_start(index, seed, **made)
    recording, motion, disturbance, field_true_s, _, earth = simulated
    given = field_settings(earth) if place else {}
    result = run_recording(recording, filter, settings={"gyro_hold": "backward", **given, **settings, "navigation_frame": "enu"})
    truth = recording.needed("reference_q_nb")
    rows = np.minimum(np.searchsorted(result.t_s, result.t_s[0] + np.array(JUDGED_S)), len(result.t_s) - 1)
    z2 = tuple((errors_rad(result.q_nb[rows], truth[rows])[1] / result.sigma_rad[rows, 2]) ** 2)
    heading_ready = result.ready[:, 1]
    if not heading_ready.any():
        return Start(index, motion, disturbance, field_true_s, np.nan, np.nan, np.nan, np.nan, z2)
    i = int(np.argmax(heading_ready))
    total, heading, _ = (np.degrees(e[0]) for e in errors_rad(result.q_nb[i : i + 1], truth[i : i + 1]))
    sigma = np.degrees(np.linalg.norm(result.sigma_rad[i]))
    ready_s = float(result.t_s[i] - result.t_s[0])
    return Start(index, motion, disturbance, field_true_s, ready_s, float(total), float(heading), float(sigma), z2)


def field_settings(earth_tesla: np.ndarray) -> dict[str, str]:
    """Options that give a filter this field, in east-north-up."""
    _, north, up = earth_tesla
    strength, dip = float(np.linalg.norm(earth_tesla)), float(np.arctan2(-up, north))
    return {"reference_mode": "given", "reference_strength_tesla": repr(strength), "reference_dip_rad": repr(dip)}


def experiment(
    starts: int, filter: str, settings: dict[str, str], seed: int = 1, workers: int = 1, **how: bool
) -> Iterator[Start]:
    """One start after the other, in order; the same whatever the number of workers. how: as of judge. Raises HnavError."""
    Options(filter, **{"gyro_hold": "backward", **settings})
    run = partial(judge, filter=filter, settings=settings, seed=seed, **how)
    yield from in_order(run, range(starts), workers, CHUNK)


def figures(starts: Sequence[Start]) -> dict[str, Any]:
    """Of a group of starts. Shares are of all of them, ready or not: wrong_share with its 95 % Wilson interval; times (late_s: 95
    % were ready by then) and errors of those that became ready; heading_z2: means at JUDGED_S, 1 when the sigma of heading is
    right."""
    wrong = sum(start.wrong for start in starts)
    low, high = stats.binomtest(wrong, len(starts)).proportion_ci(method="wilson")
    ready = pd.DataFrame(map(vars, starts)).dropna(subset="ready_s")
    return {
        "starts": len(starts), "wrong_share": wrong / len(starts), "wrong_low": low, "wrong_high": high,
        "wrong_in_true_field_share": sum(start.wrong_in_true_field for start in starts) / len(starts),
        "median_s": ready.ready_s.median(), "late_s": ready.ready_s.quantile(0.95), "never_share": 1 - len(ready) / len(starts),
        "median_error_deg": ready.error_deg.median(), "heading_z2": np.mean([start.heading_z2 for start in starts], axis=0),
    }  # fmt: skip


# --------------------------------------------------------------------------------------------- the command


def command(
    starts: Annotated[int, typer.Option(min=1, help="how many starts; groups take turns")] = 1000,
    filter: FilterName = "ahrs",
    settings: Settings = None,
    workers: Workers = WORKERS,
    seed: Seed = 1,
    hidden: Annotated[bool, typer.Option("--hidden", help="fields that are false in a way that no filter can know")] = False,
    every_error: Annotated[
        bool, typer.Option("--every-error", help="sensors with the errors too that the options allow for")
    ] = False,
    place: Annotated[
        bool, typer.Option("--place", help="the filter is given strength and dip of the earth's field, as for a place and a date")
    ] = False,
    csv_file: Annotated[Path | None, typer.Option("--csv", metavar="FILE", help="write a row for each start")] = None,
) -> None:
    """Simulates starts and prints how often, and when, a filter reports `heading ready` while its attitude is wrong."""
    how = dict(hidden=hidden, every_error=every_error, place=place)
    done = list(tracked(experiment(starts, filter, parse_settings(settings), seed, workers, **how), "starts", starts))
    wrong = "wrong: total error above 3 sigma and 5 deg"
    show(table(done, f"{filter}, seed {seed}: first instant of heading_ready in {DURATION_S:g} s; {wrong}"), width=180)
    write_rows(csv_file, map(row_of, done))


def table(starts: Sequence[Start], title: str) -> Table:
    """A row for each group, after each disturbance all its motions together, at the end all starts."""
    columns = "starts | wrong | 95 % interval | in true field | ready after: median | 95 % | never | error then: median"
    judged = ", ".join(f"{t_s:g}" for t_s in JUDGED_S)
    out = titled_table(title, "disturbance | motion", f"{columns} | heading z2 at {judged} s")

    def add(disturbance: str, motion: str, group: Sequence[Start], style: str | None = None) -> None:
        if not group:
            return
        f = figures(group)
        template = "{starts} | {wrong_share:.1%} | {wrong_low:.1%} to {wrong_high:.1%} | {wrong_in_true_field_share:.1%}"
        shares = template.format(**f)
        error = "" if np.isnan(f["median_error_deg"]) else f"{f['median_error_deg']:.1f} deg"
        z2 = ", ".join(f"{z2:.2g}" for z2 in f["heading_z2"])
        times = after(f["median_s"]), after(f["late_s"]), f"{f['never_share']:.1%}"
        out.add_row(disturbance, motion, *shares.split(" | "), *times, error, z2, style=style)

    for disturbance in DISTURBANCES | HIDDEN:
        for motion in MOTIONS:
            add(disturbance, motion, [s for s in starts if (s.disturbance, s.motion) == (disturbance, motion)])
        add(disturbance, "all", [s for s in starts if s.disturbance == disturbance], "bold")
        out.add_section()
    add("all", "all", starts, "bold")
    return out


def row_of(start: Start) -> dict[str, object]:
    """Of the CSV."""
    values = {name: value for name, value in vars(start).items() if name != "heading_z2"}
    return values | {f"heading_z2_{t_s:g}_s": z2 for t_s, z2 in zip(JUDGED_S, start.heading_z2)} | {"wrong": start.wrong}
