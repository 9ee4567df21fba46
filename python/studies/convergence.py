"""How soon filters find the attitude from a wrong start: the paper's claim, beside filters of the literature.

    ./run study convergence [--seeds 200] [--picture FILE]

A body turns to and fro about all axes (studies.robust); the noise of gyroscope, force and field is as stated, at 50 Hz. The start is off by a given
heading error, and the filter claims a heading sigma for it. Counted is the time from which the error stays below 3 deg for a second, within
20 s.
The AHRS has its own options for the start and its default noise, which is a hand's; the others have the true noise. INS is not in the table:
at rest without a magnetometer nothing but the turn of the Earth corrects its heading.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import typer
from rich.table import Table
from scipy.spatial.transform import Rotation

from hnav.cli.console import say, show
from hnav.filters.attitude import Filter
from hnav.filters.options import Options
from hnav.reports.plots import figure, save
from studies.command import WORKERS, Workers, study
from studies.peers import PEERS, Told
from studies.processes import in_order
from studies.robust import DIRECTION_NOISE, FIELD_N, GYRO_NOISE, TOLD, WALK, Run, Scenario, errors_of, simulate

ERRORS_DEG = (5.0, 20.0, 45.0, 90.0, 135.0, 170.0, 179.0)
CLAIMS_DEG = (5.0, 30.0, 100.0)
LIMIT_DEG, HOLD_S, DURATION_S, RATE_HZ = 3.0, 1.0, 20.0, 50.0
TILT_RAD, BIAS_RAD_S = 0.05, 0.02  # stated standard deviations of the start
HREKF: dict[str, dict[str, Any]] = {
    "HEKF": {},
    "HREKF, kl": {"gamma_mode": "kl", "gamma_kl_rate_1_s": 0.75},
    "HREKF, relative 1.5": {"gamma_mode": "relative", "gamma_relative_rate_1_s": 1.5},
    "HREKF, relative 15": {"gamma_mode": "relative", "gamma_relative_rate_1_s": 15.0},
}
FILTERS = (*HREKF, "AHRS", *PEERS)


class Times(NamedTuple):
    """Of one filter, start error and claim, over the seeds: seconds until the error is below the limit, infinite for never."""

    filter: str
    error_deg: float
    claim_deg: float
    seconds: np.ndarray

    @property
    def never(self) -> float:
        """Share of the runs that do not converge."""
        return float(np.mean(np.isinf(self.seconds)))


def settles(error_deg: np.ndarray) -> float:
    """Seconds until the error stays below the limit for HOLD_S; a sample without an estimate is above."""
    hold = round(HOLD_S * RATE_HZ)
    below = np.lib.stride_tricks.sliding_window_view(error_deg < LIMIT_DEG, hold).all(axis=1)
    return float(np.argmax(below) / RATE_HZ) if below.any() else np.inf


def start_of(run: Run, seed: int, error_deg: float) -> Rotation:
    """The true attitude, tilted by TILT_RAD and turned about the vertical by error_deg."""
    tilt = TILT_RAD * np.random.default_rng(20_000 + seed).normal(size=2)
    return Rotation.from_rotvec([0, 0, np.radians(error_deg)]) * Rotation.from_rotvec([*tilt, 0]) * run.attitude[0]


def options_of(name: str, start: Rotation, claim_deg: float) -> Options:
    begin = {
        "start_mode": "attitude", "start_q_nb": start.as_quat()[[3, 0, 1, 2]].tolist(), "solver": "closed_form",
        "start_sigma_tilt_rad": TILT_RAD, "start_sigma_heading_rad": np.radians(claim_deg),
    }  # fmt: skip
    return Options("ahrs", **begin) if name == "AHRS" else Options("hrekf", **TOLD | HREKF[name] | begin)


def ours(name: str, runs: Sequence[Run], starts: Sequence[Rotation], claim_deg: float) -> list[np.ndarray]:
    """Attitude error of each run, deg."""
    errors = []
    for run, start in zip(runs, starts):
        q = Filter(options_of(name, start, claim_deg)).run(run.t_s, run.rate, run.force, run.field).q_nb
        lacks = np.isnan(q[:, 0])
        seen = Rotation.from_quat(np.where(lacks[:, None], [1.0, 0, 0, 0], q)[:, [1, 2, 3, 0]])
        errors.append(np.where(lacks, np.nan, np.degrees((seen * run.attitude.inv()).magnitude())))
    return errors


def theirs(name: str, runs: Sequence[Run], starts: Sequence[Rotation], claim_deg: float) -> list[np.ndarray]:
    told = Told(GYRO_NOISE, WALK, DIRECTION_NOISE, FIELD_N / 5e-5, TILT_RAD, np.radians(claim_deg), BIAS_RAD_S)
    return list(errors_of(PEERS[name], runs, starts, told))


def converge(case: tuple[str, float, float], seeds: int) -> Times:
    name, error_deg, claim_deg = case
    runs = [simulate(Scenario(), seed, DURATION_S, RATE_HZ) for seed in range(seeds)]
    starts = [start_of(run, seed, error_deg) for seed, run in enumerate(runs)]
    errors = (theirs if name in PEERS else ours)(name, runs, starts, claim_deg)
    return Times(name, error_deg, claim_deg, np.array([settles(e) for e in errors]))


def times_table(found: Sequence[Times], claim_deg: float, seeds: int) -> Table:
    title = f"claimed sigma {claim_deg:g} deg: median s until the error is below {LIMIT_DEG:g} deg, worst, share that never is; {seeds} seeds"
    table = Table("", *(f"{error:g} deg" for error in ERRORS_DEG), title=title)
    for name in FILTERS:
        cells = []
        for error in ERRORS_DEG:
            times = next(t for t in found if (t.filter, t.error_deg, t.claim_deg) == (name, error, claim_deg))
            middle, worst = np.median(times.seconds), times.seconds.max()
            cells.append(f"{shown(middle)}, {shown(worst)}" + (f", {100 * times.never:.0f} %" if times.never else ""))
        table.add_row(name, *cells)
    return table


def shown(seconds: float) -> str:
    return "-" if np.isinf(seconds) else f"{seconds:.2f}"


def draw(found: Sequence[Times]) -> Any:
    """Median time over the start's heading error, a panel for each claim; a filter whose median never converges ends its line."""
    picture = figure(1100, 440)
    picture.set_layout_engine("constrained")
    axes = picture.subplots(1, len(CLAIMS_DEG), sharey=True)
    for ax, claim in zip(axes, CLAIMS_DEG):
        for name in FILTERS:
            rows = [t for t in found if t.filter == name and t.claim_deg == claim]
            middle = np.array([np.median(t.seconds) for t in rows])
            style = "--" if name in PEERS else "-"
            ax.plot(
                [t.error_deg for t in rows],
                np.where(np.isinf(middle), np.nan, np.maximum(middle, 1 / RATE_HZ)),
                style,
                marker=".",
                label=name,
            )
        ax.set(title=f"claimed {claim:g} deg", xlabel="heading error of the start, deg", yscale="log")
        ax.grid(alpha=0.3)
    axes[0].set_ylabel(f"median s until below {LIMIT_DEG:g} deg")
    picture.legend(*axes[-1].get_legend_handles_labels(), loc="outside lower center", ncols=len(FILTERS), fontsize=7)
    return picture


def command(
    seeds: Annotated[int, typer.Option(min=2, help="of each figure")] = 200,
    workers: Workers = WORKERS,
    picture: Annotated[Path | None, typer.Option(metavar="FILE", help="Draw the medians")] = None,
) -> None:
    """Time to 3 deg over the heading error of the start and the stated sigma."""
    cases = [(name, error, claim) for claim in CLAIMS_DEG for name in FILTERS for error in ERRORS_DEG]
    found = list(in_order(partial(converge, seeds=seeds), cases, workers))
    for claim in CLAIMS_DEG:
        show(times_table(found, claim, seeds), width=170)
    if picture:
        save(draw(found), picture)
        say(str(picture))


main = study("convergence", command)

if __name__ == "__main__":
    main()
