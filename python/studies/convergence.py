"""How soon filters find the attitude from a wrong start: the paper's claim, beside filters of the literature.

    ./run study convergence [--seeds 200] [--picture FILE]

A body turns to and fro about all axes (studies.robust); the noise of gyroscope, force and field is as stated, at 50 Hz. The start is off by a given
heading error, and the filter claims a heading sigma for it. Counted is the time from which the error stays below 3 deg for a second, within
20 s.
The AHRS has its own options for the start and its default noise, which is a hand's; the others have the true noise.

The INS has a table of its own: at rest without a magnetometer nothing but the rate of the Earth corrects its heading, so its sensors are of
navigation grade, and it has 600 s.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache, partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.table import Table
from scipy.spatial.transform import Rotation

from hnav.cli.console import show
from hnav.filters.attitude import Filter
from hnav.filters.ins import Ins
from hnav.filters.options import Options
from hnav.reports.colours import FAINT, INK, SKY
from hnav.reports.plots import figure
from studies.command import WORKERS, Workers, draw_into
from studies.peers import PEERS, Assumed
from studies.processes import in_order
from studies.robust import (
    ASSUMED,
    DIRECTION_NOISE,
    FIELD_N,
    GYRO_NOISE,
    WALK,
    Run,
    Scenario,
    attitude_error_deg,
    errors_of,
    simulate,
)

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
AT_REST = "INS at rest"
REST_S, REST_HZ, LATITUDE_RAD = 600.0, 10.0, np.radians(45.0)
COLOURS = {"UKF": INK, AT_REST: FAINT, "multiplicative EKF": SKY}  # the others have those of the default cycle
Case = tuple[str, float, float]  # filter, heading error of the start and claimed sigma, deg
LEVEL_RAD = 0.01  # stated standard deviation of the INS's tilt at the start
EARTH_RAD_S, G_M_S2 = 7.292115e-5, 9.80620  # at that latitude


def settles(error_deg: np.ndarray, rate_hz: float = RATE_HZ) -> float:
    """Seconds until the error stays below the limit for HOLD_S; a sample without an estimate is above."""
    hold = round(HOLD_S * rate_hz)
    below = np.lib.stride_tricks.sliding_window_view(error_deg < LIMIT_DEG, hold).all(axis=1)
    return float(np.argmax(below) / rate_hz) if below.any() else np.inf


def start_of(run: Run, seed: int, error_deg: float) -> Rotation:
    """The true attitude, tilted by TILT_RAD and turned about the vertical by error_deg."""
    tilt = TILT_RAD * np.random.default_rng(20_000 + seed).normal(size=2)
    return Rotation.from_rotvec([0, 0, np.radians(error_deg)]) * Rotation.from_rotvec([*tilt, 0]) * run.attitude[0]


def options_of(law: dict[str, Any] | None, start: Rotation, claim_rad: float) -> Options:
    """Begun there with this claimed sigma of the heading. law: options of the HREKF beside the noise as it is; None: the AHRS."""
    begin = {
        "start_mode": "attitude", "start_q_nb": start.as_quat(scalar_first=True).tolist(), "solver": "closed_form",
        "start_sigma_tilt_rad": TILT_RAD, "start_sigma_heading_rad": claim_rad,
    }  # fmt: skip
    return Options("ahrs", **begin) if law is None else Options("hrekf", **ASSUMED | law | begin)


def ours(name: str, runs: Sequence[Run], starts: Sequence[Rotation], claim_deg: float) -> list[np.ndarray]:
    """Attitude error of each run, deg."""
    filters = (Filter(options_of(HREKF.get(name), start, np.radians(claim_deg))) for start in starts)
    return [attitude_error_deg(made.run(r.t_s, r.rate, r.force, r.field).q_nb, r.attitude) for made, r in zip(filters, runs)]


def theirs(name: str, runs: Sequence[Run], starts: Sequence[Rotation], claim_deg: float) -> list[np.ndarray]:
    assumed = Assumed(GYRO_NOISE, WALK, DIRECTION_NOISE, FIELD_N / 5e-5, TILT_RAD, np.radians(claim_deg), BIAS_RAD_S)
    return list(errors_of(PEERS[name], runs, starts, assumed))


@cache
def runs_of(seeds: int) -> tuple[Run, ...]:
    """The same for every filter and start."""
    return tuple(simulate(Scenario(), seed, DURATION_S, RATE_HZ) for seed in range(seeds))


def at_rest(seed: int, error_deg: float, claim_deg: float) -> np.ndarray:
    """Attitude error of the INS in deg, from a start with this heading error; biases and noise as the preset states them."""
    rng, made = np.random.default_rng(30_000 + seed), Options("ins", "navigation")
    t = np.arange(0, REST_S, 1 / REST_HZ)
    attitude = Rotation.from_euler("ZYX", [rng.uniform(-np.pi, np.pi), *rng.uniform(-0.2, 0.2, 2)])
    earth = EARTH_RAD_S * np.array([np.cos(LATITUDE_RAD), 0, -np.sin(LATITUDE_RAD)])
    white = np.sqrt(REST_HZ) * rng.normal(size=(2, len(t), 3))
    rate = attitude.inv().apply(earth) + made.start_sigma_gyro_bias_rad_s * rng.normal(size=3)
    rate = rate + made.gyro_noise_rad_per_sqrt_s * white[0]
    gravity = attitude.inv().apply([0, 0, -G_M_S2]) + made.start_sigma_accel_bias_m_s2 * rng.normal(size=3)
    force = gravity + made.accel_noise_m_s_per_sqrt_s * white[1]
    tilted = Rotation.from_rotvec([*(LEVEL_RAD * rng.normal(size=2)), 0]) * attitude
    start = Rotation.from_rotvec([0, 0, np.radians(error_deg)]) * tilted
    options = Options(
        "ins", "navigation", start="state", start_q_nb=start.as_quat(scalar_first=True).tolist(), start_sigma_tilt_rad=LEVEL_RAD,
        start_sigma_heading_rad=np.radians(claim_deg), start_sigma_velocity_m_s=0.1, start_place="given", start_latitude_rad=LATITUDE_RAD,
    )  # fmt: skip
    return attitude_error_deg(Ins(options).run(t, rate, force, check=False).q_nb, attitude)


def converge(case: Case, seeds: int) -> np.ndarray:
    """Of one filter, start error and claim, over the seeds: seconds until the error is below the limit, infinite for never."""
    name, error_deg, claim_deg = case
    if name == AT_REST:
        return np.array([settles(at_rest(seed, error_deg, claim_deg), REST_HZ) for seed in range(seeds)])
    runs = runs_of(seeds)
    starts = [start_of(run, seed, error_deg) for seed, run in enumerate(runs)]
    errors = (theirs if name in PEERS else ours)(name, runs, starts, claim_deg)
    return np.array([settles(e) for e in errors])


def cell(seconds: np.ndarray) -> str:
    """Median, worst, and the share of the runs that never converges."""
    never = 100 * np.mean(np.isinf(seconds))
    return f"{shown(float(np.median(seconds)))}, {shown(seconds.max())}" + (f", {never:.0f} %" if never else "")


def times_table(found: Mapping[Case, np.ndarray], rows: Mapping[str, tuple[str, float]], title: str) -> Table:
    """rows: filter and claim by the name of a row."""
    table = Table("", *(f"{error:g} deg" for error in ERRORS_DEG), title=title)
    for name, (filter, claim) in rows.items():
        table.add_row(name, *(cell(found[filter, error, claim]) for error in ERRORS_DEG))
    return table


def shown(seconds: float) -> str:
    return "-" if np.isinf(seconds) else f"{seconds:.2f}"


def draw(found: Mapping[Case, np.ndarray]) -> Any:
    """Median time over the start's heading error, a panel for each claim; a filter whose median never converges ends its line."""
    picture = figure(720, 1080)
    picture.set_layout_engine("constrained")
    axes = picture.subplots(len(CLAIMS_DEG), 1, sharex=True, sharey=True)
    for ax, claim in zip(axes, CLAIMS_DEG):
        for name in (*FILTERS, AT_REST):
            errors = [error for filter, error, claimed in found if (filter, claimed) == (name, claim)]
            middle = np.array([np.median(found[name, error, claim]) for error in errors])
            seconds = np.where(np.isinf(middle), np.nan, np.maximum(middle, 1 / RATE_HZ))
            style = "--" if name in PEERS else ":" if name == AT_REST else "-"
            ax.plot(errors, seconds, style, marker=".", label=name, linewidth=2, color=COLOURS.get(name))
        ax.set_title(f"claimed {claim:g} deg: median s until below {LIMIT_DEG:g} deg", fontsize=14)
        ax.set_yscale("log")
        ax.tick_params(labelsize=13)
        ax.grid(alpha=0.3)
    axes[-1].set_xlabel("heading error of the start, deg", fontsize=14)
    picture.legend(*axes[-1].get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=13)
    return picture


def command(
    seeds: Annotated[int, typer.Option(min=2, help="of each figure")] = 200,
    workers: Workers = WORKERS,
    picture: Annotated[Path | None, typer.Option(metavar="FILE", help="Draw the medians")] = None,
) -> None:
    """Time to 3 deg over the heading error of the start and the stated sigma."""
    cases = [(name, error, claim) for claim in CLAIMS_DEG for name in (*FILTERS, AT_REST) for error in ERRORS_DEG]
    found = dict(zip(cases, in_order(partial(converge, seeds=seeds), cases, workers)))
    for claim in CLAIMS_DEG:
        title = f"claimed sigma {claim:g} deg: median s until the error is below {LIMIT_DEG:g} deg, worst, share that never is; {seeds} seeds"
        show(times_table(found, {name: (name, claim) for name in FILTERS}, title), width=170)
    title = f"INS at rest, navigation grade: the same by the claimed sigma, within {REST_S:g} s; {seeds} seeds"
    show(times_table(found, {f"claimed {claim:g} deg": (AT_REST, claim) for claim in CLAIMS_DEG}, title), width=170)
    draw_into(picture, draw, found)
