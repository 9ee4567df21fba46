"""Does a filter say "heading ready" only when it is? Seeded starts of consumer-grade sensors with exact truth.

    python -m studies.readiness --starts 1000 [--filter ahrs] [--workers 2] [--csv FILE]

A start is wrong when, at the first instant of heading_ready, the true total error exceeds both 3 sigma (root sum of
squares of the three stated sigmas) and 5 deg. Every start has random sensors, a random attitude and a random field; the
groups are a kind of motion and a kind of magnetic disturbance, each equally often. Start i depends on the seed and i
alone, not on how many there are nor who computes them.

What the simulation holds: attitude from angles that are sums of sines (roll, pitch, yaw, on a random mounting), so truth
is exact; a gyro that integrates over its interval, as real ones do (gyro_hold = backward), with white noise and a
constant bias; specific force with motion accelerations; a field measured some milliseconds before its time stamp.
"""

from __future__ import annotations

import csv
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path
from typing import Annotated, NamedTuple, NoReturn

import numpy as np
import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table
from scipy import stats
from scipy.spatial.transform import Rotation

from hnav.errors import HnavError
from hnav.fmi.engines import run_recording
from hnav.io.recordings import Recording
from hnav.native.library import FILTERS, Options, parse_setting
from hnav.reports.scores import errors_rad

RATE_HZ = 100.0
DURATION_S = 60.0
GRAVITY_M_S2 = 9.81
WRONG_FLOOR_DEG, WRONG_SIGMAS = 5.0, 3.0
CHUNK = 16  # starts that a worker takes at a time


# --------------------------------------------------------------------------------------------- truth

Range = tuple[float, float]


class Wave(NamedTuple):
    """A sum of sines: amplitude, rad/s and phase of each (k)."""

    amplitude: np.ndarray
    pulsation_rad_s: np.ndarray
    phase_rad: np.ndarray

    def __call__(self, t_s: np.ndarray) -> np.ndarray:
        return np.sin(np.multiply.outer(t_s, self.pulsation_rad_s) + self.phase_rad) @ self.amplitude


def draw_wave(rng: np.random.Generator, amplitude: Range, frequency_hz: Range, terms: int = 3) -> Wave:
    """The terms share the amplitude and have frequencies of their own."""
    share = rng.dirichlet(np.ones(terms))
    return Wave(rng.uniform(*amplitude) * share, 2 * np.pi * rng.uniform(*frequency_hz, terms), rng.uniform(0, 2 * np.pi, terms))


class Kind(NamedTuple):
    """A way of moving: amplitudes and frequencies of roll and pitch, of yaw, and of the acceleration on each axis."""

    tilt_deg: Range
    tilt_hz: Range
    yaw_deg: Range
    yaw_hz: Range
    level_m_s2: Range
    vertical_m_s2: Range
    shake_hz: Range


MOTIONS = {
    "rest": Kind((0, 0), (1, 1), (0, 0), (1, 1), (0, 0), (0, 0), (1, 1)),
    "hand-held": Kind((10, 40), (0.2, 0.8), (10, 60), (0.1, 0.6), (0.3, 1.5), (0.3, 1.5), (0.5, 2.0)),
    "walking": Kind((5, 15), (0.8, 2.0), (20, 120), (0.03, 0.2), (0.5, 1.5), (1.5, 4.0), (1.5, 2.2)),
    "fast turning": Kind((30, 80), (0.3, 0.8), (90, 240), (0.3, 0.8), (0.5, 3.0), (0.5, 3.0), (0.5, 2.0)),
}


@dataclass(frozen=True)
class Motion:
    """Attitude and acceleration at any time; it begins at begin_s and grows to its size within a second."""

    begin_s: float
    mounting: Rotation
    yaw_rad: float
    angles_rad: tuple[Wave, Wave, Wave]  # yaw, pitch, roll
    acceleration_m_s2: tuple[Wave, Wave, Wave]  # east, north, up

    def size(self, t_s: np.ndarray) -> np.ndarray:
        x = np.clip(t_s - self.begin_s, 0, 1)
        return x * x * (3 - 2 * x)

    def attitude(self, t_s: np.ndarray) -> Rotation:
        """Body to east-north-up."""
        angles = np.stack([wave(t_s) for wave in self.angles_rad], axis=1) * self.size(t_s)[:, None]
        return Rotation.from_euler("ZYX", angles + [self.yaw_rad, 0, 0]) * self.mounting

    def acceleration(self, t_s: np.ndarray) -> np.ndarray:
        """n x 3, in east-north-up."""
        return np.stack([wave(t_s) for wave in self.acceleration_m_s2], axis=1) * self.size(t_s)[:, None]


def draw_motion(rng: np.random.Generator, kind: Kind) -> Motion:
    """Half of the starts move from the first sample on, the others rest for up to 5 s."""
    tilt = [draw_wave(rng, tuple(np.radians(kind.tilt_deg)), kind.tilt_hz) for _ in range(2)]
    yaw = draw_wave(rng, tuple(np.radians(kind.yaw_deg)), kind.yaw_hz)
    level = [draw_wave(rng, kind.level_m_s2, kind.shake_hz) for _ in range(2)]
    vertical = draw_wave(rng, kind.vertical_m_s2, kind.shake_hz)
    begin_s = -1.0 if rng.random() < 0.5 else rng.uniform(0, 5)
    return Motion(begin_s, Rotation.random(rng=rng), rng.uniform(-np.pi, np.pi), (yaw, *tilt), (*level, vertical))


# --------------------------------------------------------------------------------------------- the field


class Field(NamedTuple):
    """The field in east-north-up, n x 3 in tesla, at times (n), and from when on it is the earth's alone."""

    at: Callable[[np.ndarray], np.ndarray]
    true_from_s: float


def draw_earth_field(rng: np.random.Generator) -> np.ndarray:
    """25 to 65 uT, dip up to 75 deg on either hemisphere, along magnetic north, in tesla."""
    strength, dip = rng.uniform(25e-6, 65e-6), rng.choice([-1, 1]) * np.radians(rng.uniform(0, 75))
    return strength * np.array([0, np.cos(dip), -np.sin(dip)])


def undisturbed(rng: np.random.Generator, earth: np.ndarray) -> Field:
    return Field(lambda t_s: np.tile(earth, (len(t_s), 1)), 0.0)


def false_at_first(rng: np.random.Generator, earth: np.ndarray) -> Field:
    """Turned by 30 to 90 deg about any axis and scaled by 0.6 to 1.5 for the first 2 to 15 s; gone within a second."""
    end_s, scale = rng.uniform(2, 15), rng.uniform(0.6, 1.5)
    axis = rng.normal(size=3)
    turn = Rotation.from_rotvec(np.radians(rng.uniform(30, 90)) * axis / np.linalg.norm(axis))
    false = scale * turn.apply(earth)
    return Field(lambda t_s: earth + np.clip(end_s + 1 - t_s, 0, 1)[:, None] * (false - earth), end_s + 1)


def passing(rng: np.random.Generator, earth: np.ndarray) -> Field:
    """10 to 60 uT in any direction that come and go within seconds (a bell), at some time of the first 20 s."""
    peak = rng.normal(size=3)
    peak *= rng.uniform(10e-6, 60e-6) / np.linalg.norm(peak)
    middle_s, width_s = rng.uniform(0, 20), rng.uniform(0.3, 3)
    return Field(lambda t_s: earth + np.exp(-0.5 * ((t_s - middle_s) / width_s) ** 2)[:, None] * peak, middle_s + 3 * width_s)


DISTURBANCES = {"none": undisturbed, "false at first": false_at_first, "passing": passing}
GROUPS = [(motion, disturbance) for disturbance in DISTURBANCES for motion in MOTIONS]


# --------------------------------------------------------------------------------------------- sensors


class Sensors(NamedTuple):
    """Errors of one set of consumer-grade sensors; noise as the standard deviation of a sample."""

    gyro_noise_rad_s: float
    gyro_bias_rad_s: np.ndarray
    accel_noise_m_s2: float
    mag_noise_tesla: float
    mag_latency_s: float


def draw_sensors(rng: np.random.Generator) -> Sensors:
    """0.005 to 0.02 deg/s/rtHz, bias to 1 deg/s per axis; 100 to 400 ug/rtHz; 0.2 to 1 uT; field 0 to 15 ms old."""
    per_sample = np.sqrt(RATE_HZ)
    return Sensors(
        gyro_noise_rad_s=np.radians(rng.uniform(0.005, 0.02)) * per_sample,
        gyro_bias_rad_s=np.radians(rng.uniform(-1, 1, 3)),
        accel_noise_m_s2=rng.uniform(100e-6, 400e-6) * GRAVITY_M_S2 * per_sample,
        mag_noise_tesla=rng.uniform(0.2e-6, 1e-6),
        mag_latency_s=rng.uniform(0, 0.015),
    )


class Simulated(NamedTuple):
    """The samples of a start with the true attitude as reference, its group, and the truth about field and sensors."""

    recording: Recording
    motion: str
    disturbance: str
    field_true_s: float
    sensors: Sensors


def simulated_start(index: int, seed: int = 1, duration_s: float = DURATION_S) -> Simulated:
    """Start `index`; groups take turns."""
    rng = np.random.default_rng([seed, index])
    motion_name, disturbance = GROUPS[index % len(GROUPS)]
    motion, sensors = draw_motion(rng, MOTIONS[motion_name]), draw_sensors(rng)
    field = DISTURBANCES[disturbance](rng, draw_earth_field(rng))
    t_s = np.arange(0, duration_s, 1 / RATE_HZ)
    attitude = motion.attitude(t_s)
    turned_rad = (motion.attitude(t_s - 1 / RATE_HZ).inv() * attitude).as_rotvec()
    force = attitude.apply(motion.acceleration(t_s) + [0, 0, GRAVITY_M_S2], inverse=True)
    measured_s = t_s - sensors.mag_latency_s
    magnetic = motion.attitude(measured_s).apply(field.at(measured_s), inverse=True)
    shape = (len(t_s), 3)
    recording = Recording(
        name=f"start {index}: {motion_name}, {disturbance}",
        t_s=t_s,
        rate_b_rad_s=turned_rad * RATE_HZ + sensors.gyro_bias_rad_s + sensors.gyro_noise_rad_s * rng.normal(size=shape),
        force_b_m_s2=force + sensors.accel_noise_m_s2 * rng.normal(size=shape),
        field_b_tesla=magnetic + sensors.mag_noise_tesla * rng.normal(size=shape),
        reference_q_nb=attitude.as_quat()[:, [3, 0, 1, 2]],
        movement=np.ones(len(t_s), bool),
    )
    return Simulated(recording, motion_name, disturbance, field.true_from_s, sensors)


# --------------------------------------------------------------------------------------------- the experiment


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

    @property
    def ready(self) -> bool:
        return bool(np.isfinite(self.ready_s))

    @property
    def wrong(self) -> bool:
        return self.ready and self.error_deg > max(WRONG_SIGMAS * self.sigma_deg, WRONG_FLOOR_DEG)

    @property
    def wrong_in_true_field(self) -> bool:
        """Wrong although the field was true by then. One that is false and steady looks like a true one."""
        return self.wrong and self.ready_s >= self.field_true_s


def judge(index: int, filter: str, settings: dict[str, str], seed: int = 1) -> Start:
    """Runs a filter over start `index` and looks at the first instant of heading_ready. Raises HnavError."""
    recording, motion, disturbance, field_true_s, _ = simulated_start(index, seed)
    result = run_recording(recording, filter, settings={"gyro_hold": "backward", **settings, "navigation_frame": "enu"})
    heading_ready = result.ready[:, 1]
    if not heading_ready.any():
        return Start(index, motion, disturbance, field_true_s, np.nan, np.nan, np.nan, np.nan)
    i = int(np.argmax(heading_ready))
    total, heading, _ = (np.degrees(e[0]) for e in errors_rad(result.q_nb[i : i + 1], recording.reference_q_nb[i : i + 1]))
    sigma = np.degrees(np.linalg.norm(result.sigma_rad[i]))
    ready_s = float(result.t_s[i] - result.t_s[0])
    return Start(index, motion, disturbance, field_true_s, ready_s, float(total), float(heading), float(sigma))


def experiment(starts: int, filter: str, settings: dict[str, str], seed: int = 1, workers: int = 1) -> Iterator[Start]:
    """One start after the other, in order; the same whatever the number of workers. Raises HnavError."""
    Options(filter, **{"gyro_hold": "backward", **settings})
    run = partial(judge, filter=filter, settings=settings, seed=seed)
    if workers == 1:
        yield from map(run, range(starts))
        return
    with ProcessPoolExecutor(workers) as pool:
        yield from pool.map(run, range(starts), chunksize=CHUNK)


class Figures(NamedTuple):
    """What a group of starts came to. Times are of the starts that became ready."""

    starts: int
    wrong_share: float
    wrong_low: float  # 95 % Wilson interval of the share
    wrong_high: float
    wrong_in_true_field_share: float
    median_s: float
    late_s: float  # 95 % were ready by then
    never_share: float
    median_error_deg: float


def figures(starts: Sequence[Start]) -> Figures:
    """The share of wrong starts is of all starts, ready or not."""
    ready = [start for start in starts if start.ready]
    wrong = sum(start.wrong for start in starts)
    low, high = stats.binomtest(wrong, len(starts)).proportion_ci(method="wilson")
    times, errors = [start.ready_s for start in ready] or [np.nan], [start.error_deg for start in ready] or [np.nan]
    in_true_field = sum(start.wrong_in_true_field for start in starts) / len(starts)
    return Figures(len(starts), wrong / len(starts), low, high, in_true_field, float(np.median(times)), float(np.percentile(times, 95)),
                   1 - len(ready) / len(starts), float(np.median(errors)))  # fmt: skip


# --------------------------------------------------------------------------------------------- the command

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
console = Console(highlight=False)


def table(starts: Sequence[Start], title: str) -> Table:
    """A row for each group, after each disturbance all its motions together, at the end all starts."""
    out = Table(title=title, title_justify="left")
    for column in ("disturbance", "motion"):
        out.add_column(column, no_wrap=True)
    for column in (
        "starts",
        "wrong",
        "95 % interval",
        "in true field",
        "ready after: median",
        "95 %",
        "never",
        "error then: median",
    ):
        out.add_column(column, justify="right")

    def add(disturbance: str, motion: str, group: Sequence[Start], style: str | None = None) -> None:
        if not group:
            return
        f = figures(group)
        out.add_row(
            disturbance, motion, str(f.starts), f"{f.wrong_share:.1%}", f"{f.wrong_low:.1%} to {f.wrong_high:.1%}", f"{f.wrong_in_true_field_share:.1%}",
            f"{f.median_s:.1f} s", f"{f.late_s:.1f} s", f"{f.never_share:.1%}", f"{f.median_error_deg:.1f} deg", style=style,
        )  # fmt: skip

    for disturbance in DISTURBANCES:
        for motion in MOTIONS:
            add(disturbance, motion, [s for s in starts if (s.disturbance, s.motion) == (disturbance, motion)])
        add(disturbance, "all", [s for s in starts if s.disturbance == disturbance], "bold")
        out.add_section()
    add("all", "all", starts, "bold")
    return out


def write_csv(path: Path, starts: Sequence[Start]) -> None:
    """One row a start; empty cells where the filter never became ready. Raises OSError."""
    names = [field.name for field in fields(Start)]
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([*names, "wrong"])
        for start in starts:
            values = (getattr(start, name) for name in names)
            writer.writerow(
                [
                    *("" if isinstance(v, float) and np.isnan(v) else f"{v:.6g}" if isinstance(v, float) else v for v in values),
                    int(start.wrong),
                ]
            )


def fail(text: str) -> NoReturn:
    """One line on stderr, exit code 2."""
    typer.echo(f"readiness: {text}", err=True)
    raise typer.Exit(2)


@app.command()
def readiness(
    starts: Annotated[int, typer.Option(help="how many starts; groups take turns")] = 1000,
    filter: Annotated[str, typer.Option(help=", ".join(FILTERS))] = "ahrs",
    settings: Annotated[list[str] | None, typer.Option("--set", metavar="NAME=VALUE", help="filter option")] = None,
    workers: Annotated[int, typer.Option(help="processes")] = min(2, os.cpu_count() or 1),
    seed: Annotated[int, typer.Option(help="of the random numbers")] = 1,
    csv_file: Annotated[Path | None, typer.Option("--csv", metavar="FILE", help="write a row for each start")] = None,
) -> None:
    """Simulates starts and tells how often a filter says `heading ready` while its attitude is wrong, and when."""
    for name, value, least in (("--starts", starts, 1), ("--workers", workers, 1), ("--seed", seed, 0)):
        if value < least:
            fail(f"{name} {value}: must be {least} or more")
    done: list[Start] = []
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    try:
        with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
            task = progress.add_task("starts", total=starts)
            for start in experiment(starts, filter, dict(parse_setting(text) for text in settings or []), seed, workers):
                done.append(start)
                progress.advance(task)
    except HnavError as error:
        fail(str(error))
    title = (
        f"{filter}, seed {seed}: first instant of heading_ready in {DURATION_S:g} s; wrong: total error above 3 sigma and 5 deg"
    )
    (console if console.is_terminal else Console(width=150, highlight=False)).print(table(done, title))
    if csv_file:
        try:
            write_csv(csv_file, done)
        except OSError as error:
            fail(f"{csv_file}: cannot be written: {error.strerror}")
        console.print(f"{csv_file}")


if __name__ == "__main__":
    app()
