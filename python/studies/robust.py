"""Accuracy of the robust law and the adaptation of the HREKF, beside an EKF with the stated noise and one with a larger Q.

    ./run study robust [--seeds 20] [--part scenarios|measurements|start|rates|adaptation]

A body turns to and fro about all axes; gyroscope, force and field have white noise and the gyroscope a bias that walks. A filter
has the stated noise, and in each scenario one thing differs from it: of the gyroscope (scenarios) or of force and field (measurements,
beside filters of the literature, studies.peers). Errors are root mean squares of the whole attitude over
5 to 40 s and all seeds, deg.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any

import numpy as np
import typer
from rich.table import Table
from scipy.spatial.transform import Rotation

from hnav.cli.console import say, show
from hnav.filters.attitude import Filter
from hnav.filters.options import Options
from hnav.rotations import rotation_error_rad
from studies import larger_q
from studies.command import check_choices
from studies.ins.motions import turned_on
from studies.peers import PEERS, Assumed, Peer, swap

GYRO_NOISE, WALK, DIRECTION_NOISE = 1e-3, 1e-4, 5e-3  # rad/sqrt(s), rad/s/sqrt(s), 1/sqrt(Hz)
FIELD_N = 5e-5 * np.array([np.cos(1.1), 0, np.sin(1.1)])
SETTLED_S, END_S, ADAPTED_S = 5.0, 40.0, 120.0


@dataclass(frozen=True)
class Scenario:
    """Deviation from the stated noise."""

    noise_factor: float = 1.0  # of the gyroscope's white noise
    walk: float = WALK
    ramp_rad_s2: float = 0.0  # of the bias, each axis
    scale: float = 0.0  # of the gyroscope
    outliers: float = 0.0  # share of the samples of force and field that are off by half their length in each axis
    heavy_tails: bool = False  # noise of force and field: Student's t with 3 degrees of freedom, of the same variance
    acceleration_m_s2: float = 0.0  # amplitude of a horizontal acceleration of 4 s
    iron: float = 0.0  # hard iron on each axis, in field strengths


AS_ASSUMED = "as assumed"
SCENARIOS = {
    AS_ASSUMED: Scenario(),
    "gyro noise x 10": Scenario(noise_factor=10),
    "bias walk x 100": Scenario(walk=100 * WALK),
    "bias ramp": Scenario(ramp_rad_s2=2e-3),
    "gyro scale 1 %": Scenario(scale=0.01),
}
MEASUREMENTS = {
    AS_ASSUMED: Scenario(),
    "2 % outliers": Scenario(outliers=0.02),
    "10 % outliers": Scenario(outliers=0.1),
    "heavy tails": Scenario(heavy_tails=True),
    "acceleration 1 m/s2": Scenario(acceleration_m_s2=1.0),
    "iron 5 %": Scenario(iron=0.05),
    "bias walk x 100": SCENARIOS["bias walk x 100"],
}
ASSUMED: dict[str, Any] = {
    "gyro_noise_rad_per_sqrt_s": GYRO_NOISE,
    "gyro_bias_walk_rad_s_per_sqrt_s": WALK,
    "accel_noise_per_sqrt_hz": DIRECTION_NOISE,
    "mag_noise_per_sqrt_hz": DIRECTION_NOISE,
    "accel_gate_nis": 0,
    "mag_gate_nis": 0,
    "solver": "closed_form",
    "gamma_mode": "off",
    "reference_mode": "given",
    "reference_strength_tesla": 5e-5,
    "reference_dip_rad": 1.1,
    "start_mode": "attitude",
    "start_sigma_tilt_rad": 0.05,
    "start_sigma_heading_rad": 0.05,
    "start_sigma_bias_rad_s": 0.02,
}
FILTERS: dict[str, dict[str, Any]] = {
    "EKF as assumed": {},
    "HREKF, relative 1.5": {"gamma_mode": "relative", "gamma_relative_rate_1_s": 1.5},
    "HREKF, kl 0.75": {"gamma_mode": "kl", "gamma_kl_rate_1_s": 0.75},
    larger_q.NAME: larger_q.larger_q(WALK),
}
STARTS = FILTERS | {"HREKF, relative 15": {"gamma_mode": "relative", "gamma_relative_rate_1_s": 15.0}}
GATES = {"accel_gate_nis": 14.0, "mag_gate_nis": 14.0}  # chi-square of three degrees of freedom at 99.7 %
CLAIMS = (100.0, 10.0, 1.0, 0.1, 0.01)


@dataclass(frozen=True)
class Run:
    t_s: np.ndarray
    rate: np.ndarray  # n x 3, as the gyroscope says it
    force: np.ndarray
    field: np.ndarray
    attitude: Rotation  # n: the truth, body to north-east-down
    bias: np.ndarray  # n x 3


def simulate(scenario: Scenario, seed: int, duration_s: float = END_S, rate_hz: float = 100.0) -> Run:
    rng = np.random.default_rng(seed)
    n, T = round(duration_s * rate_hz) + 1, 1 / rate_hz
    t = np.arange(n) * T
    phase = rng.uniform(0, 2 * np.pi, (2, 3))
    true = 0.6 * np.sin(0.7 * t[:, None] + phase[0]) + 0.3 * np.sin(0.31 * t[:, None] + phase[1])
    attitude = turned_on(Rotation.random(random_state=seed), Rotation.from_rotvec(true[:-1] * T))
    start = 0.02 * rng.normal(size=3)
    bias = start + np.cumsum(scenario.walk * np.sqrt(T) * rng.normal(size=(n, 3)), axis=0) + scenario.ramp_rad_s2 * t[:, None]
    rate = (1 + scenario.scale) * true + bias + scenario.noise_factor * GYRO_NOISE / np.sqrt(T) * rng.normal(size=(n, 3))
    noise = DIRECTION_NOISE / np.sqrt(T) * rng.normal(size=(2, n, 3))
    if scenario.heavy_tails:
        noise = DIRECTION_NOISE / np.sqrt(T) * rng.standard_t(3, size=(2, n, 3)) / np.sqrt(3)
    if scenario.outliers:
        noise += 0.5 * rng.normal(size=(2, n, 3)) * (rng.random((2, n, 1)) < scenario.outliers)
    up = np.stack([scenario.acceleration_m_s2 / 9.80665 * np.sin(2 * np.pi / 4 * t), np.zeros(n), -np.ones(n)], axis=1)
    force = 9.80665 * (attitude.apply(up, inverse=True) + noise[0])
    field = attitude.apply(FIELD_N, inverse=True) + 5e-5 * (noise[1] + scenario.iron)
    return Run(t, rate, force, field, attitude, bias)


def attitude_error_deg(q_nb: np.ndarray, truth: Rotation) -> np.ndarray:
    """Of the whole attitude; NaN where there is none."""
    return np.asarray(np.degrees(np.linalg.norm(rotation_error_rad(q_nb, truth.as_quat(scalar_first=True)), axis=1)))


def estimate(run: Run, settings: Mapping[str, Any], wrong_rad: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Error of the attitude in deg (n), squared error of the bias (n), and the bias walk at the end. wrong_rad: the start's error."""
    q = (Rotation.from_rotvec(wrong_rad) * run.attitude[0]).as_quat()[[3, 0, 1, 2]]
    target = Filter(Options("hrekf", **ASSUMED | {"start_q_nb": q.tolist()} | dict(settings)))
    found = target.run(run.t_s, run.rate, run.force, run.field)
    walk = target.diagnostics().adapted_bias_walk_rad_s_per_sqrt_s
    return attitude_error_deg(found.q_nb, run.attitude), np.sum((found.gyro_bias_rad_s - run.bias) ** 2, axis=1), walk


def start_error(seed: int) -> np.ndarray:
    """3, with the stated sigma of .05 rad."""
    return np.asarray(0.05 * np.random.default_rng(10_000 + seed).normal(size=3))


Settings = Mapping[str, Any]


def settled_rms(scenario: Scenario, filters: Collection[Settings], seeds: int, rate_hz: float = 100.0) -> list[float]:
    """Of each filter, on the same runs."""
    squares = []
    for seed in range(seeds):
        run = simulate(scenario, seed, rate_hz=rate_hz)
        errors = [estimate(run, settings, start_error(seed))[0] for settings in filters]
        squares.append([np.mean(error[run.t_s >= SETTLED_S] ** 2) for error in errors])
    return [float(np.sqrt(np.mean(of_filter))) for of_filter in zip(*squares)]


@cache
def as_stated(seeds: int) -> dict[str, float]:
    """Of every filter by its name, at 100 Hz: what three of the tables show."""
    return dict(zip(STARTS, settled_rms(SCENARIOS[AS_ASSUMED], STARTS.values(), seeds)))


def scenarios_table(seeds: int) -> Table:
    table = Table("", *FILTERS, title=f"error after {SETTLED_S:g} s, deg, {seeds} seeds")
    table.add_row(AS_ASSUMED, *(f"{as_stated(seeds)[name]:.2f}" for name in FILTERS))
    for name, scenario in SCENARIOS.items():
        if name != AS_ASSUMED:
            table.add_row(name, *(f"{error:.2f}" for error in settled_rms(scenario, FILTERS.values(), seeds)))
    return table


def peers_rms(scenario: Scenario, seeds: int, rate_hz: float = 100.0) -> list[float]:
    """Of the filters of the literature, on the runs of settled_rms."""
    runs = [simulate(scenario, seed, rate_hz=rate_hz) for seed in range(seeds)]
    starts = [Rotation.from_rotvec(start_error(seed)) * run.attitude[0] for seed, run in enumerate(runs)]
    assumed = Assumed(GYRO_NOISE, WALK, DIRECTION_NOISE, FIELD_N / 5e-5, 0.05, 0.05, 0.02)
    settled = runs[0].t_s >= SETTLED_S
    return [float(np.sqrt(np.mean(np.square(errors_of(peer, runs, starts, assumed)[:, settled])))) for peer in PEERS.values()]


def errors_of(peer: Peer, runs: Sequence[Run], starts: Sequence[Rotation], assumed: Assumed) -> np.ndarray:
    """Attitude error of a filter of the literature, seeds x n, deg."""
    rate = np.stack([run.rate for run in runs])
    y = np.stack([np.hstack([run.force / 9.80665, run.field / 5e-5]) for run in runs])
    R = peer(rate, y, runs[0].t_s[1] - runs[0].t_s[0], Rotation.concatenate(starts), assumed)
    true = np.stack([run.attitude.as_matrix() for run in runs])
    angle = Rotation.from_matrix((swap(R) @ true).reshape(-1, 3, 3)).magnitude()
    return np.asarray(np.degrees(angle).reshape(len(runs), -1))


def measurements_table(seeds: int) -> Table:
    gated = {f"{name}, gates 14": settings | GATES for name, settings in FILTERS.items() if name != larger_q.NAME}
    ours = FILTERS | gated
    title = f"error after {SETTLED_S:g} s, deg, {seeds} seeds; gates 14: of force and field, NIS of three"
    table = Table("", *ours, *PEERS, title=title)
    for name, scenario in MEASUREMENTS.items():
        errors = settled_rms(scenario, ours.values(), seeds) + peers_rms(scenario, seeds)
        table.add_row(name, *(f"{error:.2f}" for error in errors))
    return table


def seconds_to(limit_deg: float, filters: Collection[Settings], seeds: int) -> list[float]:
    """Of each filter the median time until the error first is below the limit, begun 90 deg off in heading with 5 deg claimed."""
    claimed = {"start_sigma_heading_rad": np.radians(5), "start_sigma_tilt_rad": np.radians(5)}
    times = []
    for seed in range(seeds):
        run = simulate(Scenario(), seed)
        errors = [estimate(run, dict(settings) | claimed, np.array([0, 0, np.pi / 2]))[0] for settings in filters]
        near = [np.flatnonzero(error < limit_deg) for error in errors]
        times.append([run.t_s[rows[0]] if len(rows) else END_S for rows in near])
    return [float(np.median(of_filter)) for of_filter in zip(*times)]


def start_table(seeds: int) -> Table:
    title = f"begun 90 deg off in heading with 5 deg claimed, {seeds} seeds"
    table = Table("", "s to 3 deg", "error as assumed, deg", title=title)
    for name, seconds in zip(STARTS, seconds_to(3.0, STARTS.values(), seeds)):
        table.add_row(name, f"{seconds:.2f}", f"{as_stated(seeds)[name]:.2f}")
    return table


def rates_table(seeds: int, rates_hz: tuple[float, ...] = (25.0, 100.0, 400.0)) -> Table:
    table = Table("", *(f"{rate:g} Hz" for rate in rates_hz), title=f"error as assumed, deg, {seeds} seeds")
    columns = [
        [as_stated(seeds)[name] for name in FILTERS] if rate == 100 else settled_rms(Scenario(), FILTERS.values(), seeds, rate)
        for rate in rates_hz
    ]
    for name, errors in zip(FILTERS, zip(*columns)):
        table.add_row(name, *(f"{error:.2f}" for error in errors))
    return table


def adapted(claim: float, seeds: int, rate_hz: float = 50.0) -> tuple[float, ...]:
    """Over seeds: the walk found over the true one (median, a tenth, nine tenths), and the bias error over the untouched
    filter's: rms over the last twenty seconds, and the largest over windows of ten. claim: the stated walk over the true one."""
    walks, squares = [], []
    for seed in range(seeds):
        run = simulate(Scenario(), seed, ADAPTED_S, rate_hz)
        assumed = {"gyro_bias_walk_rad_s_per_sqrt_s": claim * WALK}
        both = [estimate(run, assumed | {"adaptation": mode}, start_error(seed)) for mode in ("off", "corrected")]
        walks.append(both[1][2] / WALK)
        squares.append([bias for _, bias, _ in both])
    mean = np.mean(squares, axis=0)
    window = round(10 * rate_hz)
    tens = mean[:, : len(mean[0]) // window * window].reshape(2, -1, window).mean(axis=2)
    last = mean[:, -2 * window :].mean(axis=1)
    ratios = np.sqrt(last[1] / last[0]), np.sqrt((tens[1] / tens[0]).max())
    return *map(float, np.quantile(walks, [0.5, 0.1, 0.9])), *map(float, ratios)


def adaptation_table(seeds: int) -> Table:
    table = Table("assumed over true walk", "found over true", "of ten", "bias error", "worst ten seconds",
                  title=f"adaptation=corrected after {ADAPTED_S:g} s, {seeds} seeds; bias errors over those of the untouched filter")  # fmt: skip
    for claim in CLAIMS:
        median, low, high, *ratios = (f"{value:.2f}" for value in adapted(claim, seeds))
        table.add_row(f"{claim:g}", median, f"{low} to {high}", *ratios)
    return table


PARTS = {
    "scenarios": scenarios_table, "measurements": measurements_table, "start": start_table, "rates": rates_table,
    "adaptation": adaptation_table,
}  # fmt: skip


def command(
    seeds: Annotated[int, typer.Option(min=1, help="of each figure")] = 20,
    part: Annotated[str | None, typer.Option(help=", ".join(PARTS) + "; all without it")] = None,
) -> None:
    """Measures the robust law and the adaptation beside EKFs."""
    check_choices("--part", [part], PARTS)
    for name, table in PARTS.items():
        if part in (None, name):
            show(table(seeds), width=250)
    say(
        "The robust law is more accurate than an untuned EKF and recovers faster from an over-confident start; for a model that stays wrong "
        "an EKF with a larger Q is the most accurate, for a right model the EKF with the stated noise."
    )
