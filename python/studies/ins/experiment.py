"""One start, judged; and the figures of many."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from hnav import earth
from hnav.filters.ins import Ins
from hnav.filters.ins_answers import InsRun
from hnav.native.arrays import Array, BoolArray
from hnav.systems.navigation_views import wrapped
from studies.ins.conditions import CONDITIONS
from studies.ins.flight import FirstReady, first_ready
from studies.ins.motions import AT_REST
from studies.ins.vehicles import Truth, receiver, starts_of, vehicle
from studies.processes import in_order

DURATIONS_S = {
    "car": 150.0, "aircraft": 150.0, "ship": 150.0,
    "straight": 100.0, "take_off": 100.0, "train": 400.0, "quadrotor": 120.0, "hover": 240.0, "walker": 60.0,
    **dict.fromkeys(AT_REST, 600.0),
}  # fmt: skip
KINDS = tuple(DURATIONS_S)
REST_NOISE_M_S = 0.01
"""Stated sigma of the velocity at rest, ten times a second; four times that on a base that sways by four times as much."""
EARLY_S = 5.0
"""After the tilt is found."""
EVERY = 10  # rows of the filter per scored row


@dataclass(frozen=True)
class Start(FirstReady):
    """A start and its outcome; angles in rad."""

    kind: str
    seed: int
    error_end: float
    """Of the heading, at the end."""
    sigma_end: float
    """As stated at the end."""
    position_z2: float
    """Mean of the three squared normalised errors of the position at the end."""
    tilt_z2: tuple[float, float]
    """Mean of the two squared normalised errors of the tilt, EARLY_S after it was found and at the end."""


def judged(kind: str, grade: str, seed: int, magnetometer: bool = False, condition: str = "usual") -> Start:
    """The start of this number, under a condition of CONDITIONS."""
    samples, truth = vehicle(kind, grade, seed, DURATIONS_S[kind], magnetometer)
    met = CONDITIONS[condition]
    samples = met.change(samples, truth, np.random.default_rng([seed, 9]))
    colour_m = receiver(kind).colour_m
    given: dict[str, object] = {"position_colour_m": (colour_m, colour_m), **met.options(truth)}
    if kind in AT_REST:
        latitude, longitude, height = earth.place_of(truth.position_e[0])
        given |= dict(
            start_place="given", start_latitude_rad=latitude, start_longitude_rad=longitude, start_height_m=height,
            rest_velocity_noise_m_s=REST_NOISE_M_S * (4 if kind == "swaying" else 1),
        )  # fmt: skip
    ins = Ins(grade, solver="closed_form", **given)
    run = ins.run(samples.t_s, samples.rate_b_rad_s, samples.force_b_m_s2, samples.aids, every=EVERY)
    rows = np.arange(EVERY - 1, len(samples.t_s), EVERY)
    error = wrapped(run.heading_rad - truth.heading_rad()[rows])
    sigma = run.sigma_rotation_rad[:, 2]
    off = earth.position_of(run.place[-1]) - truth.position_e[rows[-1]]
    off_n = off @ earth.axes_at(run.place[-1])
    found_s = run.t_s[np.argmax(np.isfinite(run.q_nb[:, 0]))]
    return Start(
        *first_ready(run, error, samples.t_s[0]),
        kind,
        seed,
        float(error[-1]),
        float(sigma[-1]),
        float(np.mean((off_n / run.sigma_position_m[-1]) ** 2)) if kind not in AT_REST else np.nan,
        (tilt_z2(run, truth, rows, int(np.searchsorted(run.t_s, found_s + EARLY_S))), tilt_z2(run, truth, rows, len(rows) - 1)),
    )


def tilt_z2(run: InsRun, truth: Truth, rows: npt.NDArray[np.intp], i: int) -> float:
    """Mean of the two squared normalised errors of the tilt in a row of the run; NaN where it has none."""
    if i >= len(rows) or not np.isfinite(run.q_nb[i]).all():
        return np.nan
    return float(np.mean((tilt_errors(run, truth, rows, i) / run.sigma_rotation_rad[i, :2]) ** 2))


def tilt_errors(run: InsRun, truth: Truth, rows: npt.NDArray[np.intp], of: int | BoolArray) -> Array:
    """Errors about north and east, in rad, of some rows of the run that have an attitude."""
    down_e = earth.axes_at(run.place[of])[..., 2]
    shown: Array = Rotation.from_quat(run.q_nb[of], scalar_first=True).apply(truth.attitude_e[rows[of]].inv().apply(down_e))
    return shown[..., [1, 0]]


def experiment(
    kind: str, grade: str, runs: int, seed: int, workers: int, magnetometer: bool = False, condition: str = "usual"
) -> Iterator[Start]:
    """The starts of a seed, in their order."""
    one = partial(judged, kind, grade, magnetometer=magnetometer, condition=condition)
    return in_order(one, starts_of(seed, runs), workers, 8)


@dataclass(frozen=True)
class Figures:
    """Of many starts of one kind; angles in deg."""

    runs: int
    ready: int
    median_s: float
    late_s: float
    """95 % of those that were ready were so by then."""
    false: int
    rms_end: float
    stated_end: float
    heading_z2: float
    """Mean of the squared normalised errors at the end, each at most 100."""
    position_z2: float
    early_tilt_z2: float
    tilt_z2: float


def figures(starts: Sequence[Start]) -> Figures:
    """Of starts of one kind."""
    times = np.array([s.ready_s for s in starts])
    times = times[np.isfinite(times)]
    error, sigma = np.array([s.error_end for s in starts]), np.array([s.sigma_end for s in starts])
    position = np.array([s.position_z2 for s in starts])
    return Figures(
        len(starts),
        len(times),
        float(np.median(times)) if len(times) else np.nan,
        float(np.quantile(times, 0.95)) if len(times) else np.nan,
        sum(s.is_false for s in starts),
        float(np.degrees(np.sqrt(np.nanmean(error**2)))),
        float(np.degrees(np.sqrt(np.nanmean(sigma**2)))),
        float(np.nanmean(np.minimum(error**2 / sigma**2, 100))),
        float(np.nanmean(np.minimum(position, 100))) if np.isfinite(position).any() else np.nan,
        *(float(np.nanmean(np.minimum([s.tilt_z2[i] for s in starts], 100))) for i in range(2)),
    )
