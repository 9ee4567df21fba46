"""One start, judged; and the figures of many."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from hnav import earth
from hnav.filters.ins_answers import InsRun
from hnav.native.arrays import Array
from hnav.systems.navigation_views import wrapped
from studies.ins.conditions import CONDITIONS
from studies.ins.flight import first_ready
from studies.ins.motions import AT_REST
from studies.ins.vehicles import Truth, filter_of, starts_of, vehicle
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


class Errors(NamedTuple):
    """Estimate minus truth in the rows of a run, NaN where there is no estimate; axes: north, east, down at the estimated place."""

    position_m: Array  # n x 3
    velocity_m_s: Array  # n x 3
    tilt_rad: Array  # n x 2: about north and east
    heading_rad: Array  # n


def errors_of(run: InsRun, truth: Truth, every: int = 1) -> Errors:
    """every: as of Ins.run, of the times of the truth."""
    at = truth.in_rows(slice(every - 1, None, every))
    known = np.isfinite(run.q_nb[:, :1])
    place = np.where(known, run.place, 0.0)
    axes = earth.axes_at(place)
    off = np.einsum("nij,ni->nj", axes, earth.position_of(place) - at.position_e)
    fast = run.velocity_n_m_s - np.einsum("nij,ni->nj", axes, at.velocity_e)
    down_b = at.attitude_e.inv().apply(axes[:, :, 2])
    down = Rotation.from_quat(np.where(known, run.q_nb, [1, 0, 0, 0]), scalar_first=True).apply(down_b)
    off, fast, tilt = (np.where(known, values, np.nan) for values in (off, fast, down[:, [1, 0]] * [-1, 1]))
    return Errors(off, fast, tilt, wrapped(run.heading_rad - at.heading_rad()))


def judged(kind: str, grade: str, seed: int, magnetometer: bool = False, condition: str = "usual") -> dict[str, Any]:
    """The start of this number, under a condition of CONDITIONS: as of first_ready; error_end, sigma_end of the heading at the
    end, rad; position_z2, tilt_z2: means of the squared normalised errors at the end; early_tilt_z2: EARLY_S after the tilt was
    found."""
    samples, truth = vehicle(kind, grade, seed, DURATIONS_S[kind], magnetometer)
    met = CONDITIONS[condition]
    samples = met.change(samples, truth, np.random.default_rng([seed, 9]))
    given = met.options(truth)
    if kind in AT_REST:
        latitude, longitude, height = earth.place_of(truth.position_e[0])
        given |= dict(
            start_place="given", start_latitude_rad=latitude, start_longitude_rad=longitude, start_height_m=height,
            rest_velocity_noise_m_s=REST_NOISE_M_S * (4 if kind == "swaying" else 1),
        )  # fmt: skip
    run = filter_of(kind, grade, **given).run(*samples.arrays(), every=EVERY)
    error = errors_of(run, truth, EVERY)
    position_z2 = np.mean((error.position_m / run.sigma_position_m) ** 2, axis=1)
    tilt_z2 = np.mean((error.tilt_rad / run.sigma_rotation_rad[:, :2]) ** 2, axis=1)
    found_s = run.t_s[np.argmax(np.isfinite(run.q_nb[:, 0]))]
    early = int(np.searchsorted(run.t_s, found_s + EARLY_S))
    return first_ready(run, error.heading_rad, samples.t_s[0]) | {
        "error_end": error.heading_rad[-1],
        "sigma_end": run.sigma_rotation_rad[-1, 2],
        "position_z2": position_z2[-1] if kind not in AT_REST else np.nan,
        "early_tilt_z2": tilt_z2[early] if early < len(tilt_z2) else np.nan,
        "tilt_z2": tilt_z2[-1],
    }


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
