"""One start, judged; and the figures of many."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd
from scipy.spatial.transform import Rotation

from hnav import earth
from hnav.filters.ins import Ins
from hnav.filters.ins_answers import InsRun
from hnav.native.arrays import Array, BoolArray
from hnav.systems.navigation_views import wrapped
from studies.ins.conditions import CONDITIONS
from studies.ins.flight import first_ready
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
EARLY_S = 5.0  # after the tilt is found
EVERY = 10  # rows of the filter per scored row
LARGEST = 100.0  # of one squared normalised error in a mean


def judged(kind: str, grade: str, seed: int, magnetometer: bool = False, condition: str = "usual") -> dict[str, Any]:
    """The start of this number, under a condition of CONDITIONS: as of first_ready; error_end, sigma_end of the heading at the
    end, rad; position_z2, tilt_z2: means of the squared normalised errors at the end; early_tilt_z2: EARLY_S after the tilt was
    found."""
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
    off = earth.position_of(run.place[-1]) - truth.position_e[rows[-1]]
    off_n = off @ earth.axes_at(run.place[-1])
    found_s = run.t_s[np.argmax(np.isfinite(run.q_nb[:, 0]))]
    early = int(np.searchsorted(run.t_s, found_s + EARLY_S))
    return first_ready(run, error, samples.t_s[0]) | {
        "error_end": error[-1],
        "sigma_end": run.sigma_rotation_rad[-1, 2],
        "position_z2": np.mean((off_n / run.sigma_position_m[-1]) ** 2) if kind not in AT_REST else np.nan,
        "early_tilt_z2": tilt_z2(run, truth, rows, early),
        "tilt_z2": tilt_z2(run, truth, rows, len(rows) - 1),
    }


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
) -> Iterator[dict[str, Any]]:
    """The starts of a seed, in their order."""
    one = partial(judged, kind, grade, magnetometer=magnetometer, condition=condition)
    return in_order(one, starts_of(seed, runs), workers, 8)


def figures(starts: Iterable[dict[str, Any]]) -> dict[str, Any]:
    """Of starts of one kind: counts, root mean squares of the heading's error and sigma at the end in deg, late_s by which 95 %
    of those that were ready were so, and means of squared normalised errors, each at most LARGEST."""
    table = pd.DataFrame(starts)
    times = table.ready_s.dropna()
    rms_end, stated_end = np.degrees(np.sqrt(np.mean(table[["error_end", "sigma_end"]] ** 2, axis=0)))
    squares = table.filter(like="z2").assign(heading_z2=table.error_end**2 / table.sigma_end**2)
    return {
        "runs": len(table), "ready": len(times), "median_s": times.median(), "late_s": times.quantile(0.95), "false": table.is_false.sum(),
        "rms_end": rms_end, "stated_end": stated_end, **squares.clip(upper=LARGEST).mean(),
    }  # fmt: skip
