"""A filter over events and over damaged recordings: how long it is wrong, and what it says meanwhile."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from hnav.filters.attitude import Filter
from hnav.filters.attitude_answers import Run
from hnav.filters.health import findings
from hnav.filters.options import Options
from hnav.io.recordings import Recording
from hnav.reports.scores import errors_rad, score
from studies.bench.peers import PEERS, run_peer
from studies.faults.events import BEFORE_S, EVENTS, Samples, simulated
from studies.faults.recordings import FAULTS
from studies.processes import in_order
from studies.readiness.starts import RATE_HZ

TIME_CONSTANT_S = 3.0


def tilt_errors_rad(t_s: np.ndarray, rate: np.ndarray, force: np.ndarray, up_b: np.ndarray) -> np.ndarray:
    """Angles between its vertical and the true one, m x n. Arrays of m runs: t_s m x n, the others m x n x 3, body axes.

    The vertical turns with the body, and towards the direction of the force at the error's sine over TIME_CONSTANT_S.
    """
    interval_s = np.minimum(np.diff(t_s, axis=1, prepend=t_s[:, :1]), 0.1)
    direction = force / np.linalg.norm(force, axis=2, keepdims=True)
    up = direction[:, 0]
    errors = np.empty(t_s.shape)
    for k in range(t_s.shape[1]):
        turn = -rate[:, k] + np.cross(up, direction[:, k]) / TIME_CONSTANT_S
        up = Rotation.from_rotvec(turn * interval_s[:, k, None]).apply(up)
        errors[:, k] = np.arccos(np.clip(np.sum(up * up_b[:, k], axis=1), -1, 1))
    return errors


# --------------------------------------------------------------------------------------------- events


SETTLED_DEG = 5.0  # within it an angle is found again
WRONG_SIGMAS = 5.0  # and beyond SETTLED_DEG: a ready angle is false
WATCHED_S = 60.0  # after an event
BAND_SIGMAS = 3.0
CHUNK = 10  # seeds that a worker takes at a time
PEER = "vqf"
TRIALS = (3, 9, 15, 29)


def options_of(filter: str, settings: Mapping[str, str]) -> Options:
    """Rates of these sensors are means of the interval before a sample. Raises HnavError."""
    return Options(filter, **({"gyro_hold": "backward"} | dict(settings) | {"navigation_frame": "enu"}))


def settled_s(error_deg: np.ndarray, end: int) -> float:
    """error_deg: n, of which the event's last row is end - 1. NaN is an error."""
    wrong = np.flatnonzero(~(error_deg[end - 1 :] <= SETTLED_DEG))
    if len(wrong) and wrong[-1] == len(error_deg) - end:
        return np.inf
    return float(wrong[-1] / RATE_HZ) if len(wrong) else 0.0


def judge(samples: Samples, run: Run, heading: bool) -> tuple[float, float, float]:
    """Settled after, share of false samples, noticed after."""
    _, heading_rad, inclination_rad = errors_rad(run.q_nb, samples.attitude.as_quat(scalar_first=True))
    error_deg = np.degrees(heading_rad if heading else inclination_rad)
    sigma_deg = np.degrees(run.sigma_rad[:, 2] if heading else run.sigma_rad[:, :2].max(axis=1))
    ready = run.ready[:, int(heading)]
    begin, end = round(BEFORE_S * RATE_HZ), int(np.flatnonzero(samples.during)[-1]) + 1
    watched = slice(begin, end + round(WATCHED_S * RATE_HZ))
    false = ready & (error_deg > SETTLED_DEG) & (error_deg > WRONG_SIGMAS * sigma_deg)
    down = np.flatnonzero(~ready[begin:])
    return settled_s(error_deg, end), float(false[watched].mean()), float(down[0] / RATE_HZ) if len(down) else np.inf


def recoveries(seeds: Sequence[int], event: str, filter: str, settings: Mapping[str, str]) -> pd.DataFrame:
    """The event for each seed. settled_s: from its end until the error stays within SETTLED_DEG; peer_settled_s: of the
    complementary filter, NaN when it is the heading that suffers; false_share: of the samples from its begin to WATCHED_S after
    its end; noticed_s: from its begin until the flag was down. Times are infinite for never. Raises HnavError."""
    heading, options = EVENTS[event].heading, options_of(filter, settings)
    given = [simulated(event, seed) for seed in seeds]
    outputs = ("q_nb", "sigma_rad", "ready")
    runs = (Filter(options).run(s.t_s, s.rate, s.force, s.field, only=outputs, check=False) for s in given)  # faults are meant
    judged = [judge(samples, run, heading) for samples, run in zip(given, runs)]
    found = pd.DataFrame(judged, columns=["settled_s", "false_share", "noticed_s"])
    return found.assign(event=event, seed=list(seeds), peer_settled_s=np.nan if heading else _complementary(given))


def _complementary(given: Sequence[Samples]) -> list[float]:
    ups = [np.asarray(s.attitude.apply(np.tile([0.0, 0.0, 1.0], (len(s.t_s), 1)), inverse=True)) for s in given]
    arrays = (np.stack(rows) for rows in zip(*((s.t_s, s.rate, s.force, up) for s, up in zip(given, ups))))
    errors_deg = np.degrees(tilt_errors_rad(*arrays))
    return [settled_s(error, int(np.flatnonzero(s.during)[-1]) + 1) for error, s in zip(errors_deg, given)]


def experiment(seeds: int, filter: str, settings: Mapping[str, str], workers: int = 1) -> Iterator[pd.DataFrame]:
    """Event after event, some seeds at a time; the same whatever the number of workers. Raises HnavError."""
    options_of(filter, settings)
    shares = [range(first, min(first + CHUNK, seeds)) for first in range(0, seeds, CHUNK)]
    for event in EVENTS:
        yield from in_order(partial(recoveries, event=event, filter=filter, settings=settings), shares, workers)


# --------------------------------------------------------------------------------------------- recordings


def damage_of(recording: Recording, fault: str, index: int, filter: str, settings: Mapping[str, str]) -> dict[str, Any]:
    """What a fault came to on one recording: errors in deg, the peer's NaN where it is not installed; shares of the scored rows:
    beyond BAND_SIGMAS while ready (inclination, heading), ready (tilt, heading); said: for what share of the time a sensor was
    not ok, "gyro stuck" and the like. index: of the recording among those of the study, for the random numbers. Raises
    HnavError."""
    damaged = FAULTS[fault](recording, np.random.default_rng([15, index]))
    reference, movement = damaged.needed("reference_q_nb"), damaged.movement
    run = Filter(options_of(filter, settings)).run(damaged.t_s, damaged.rate_b_rad_s, damaged.force_b_m_s2, damaged.field_b_tesla)
    _, heading, inclination = errors_rad(run.q_nb, reference)
    known = np.isfinite(inclination) if movement is None else np.isfinite(inclination) & movement
    errors = np.stack([inclination, heading], axis=1)
    sigmas = np.stack([np.linalg.norm(run.sigma_rad[:, :2], axis=1), run.sigma_rad[:, 2]], axis=1)
    beyond, ready = ((errors > BAND_SIGMAS * sigmas) & run.ready)[known].mean(axis=0), run.ready[known].mean(axis=0)
    length_s = float(np.diff(recording.t_s).sum())
    return {
        "total_deg": score(run.q_nb, reference, movement).total,
        "peer_deg": _peer_deg(recording, damaged),
        "shares": [*beyond, *ready],
        "said": {f"{found.sensor} {found.state}": found.lasted_s / length_s for found in findings(damaged.t_s, run.health)},
    }


def _peer_deg(recording: Recording, damaged: Recording) -> float:
    """Total error of the peer, deg. It gets the true rate of the recording and no time stamps."""
    if not PEERS[PEER].installed():
        return np.nan
    q_nb, _ = run_peer(PEER, damaged, float(1 / np.median(np.diff(recording.t_s))))
    return score(q_nb, damaged.needed("reference_q_nb"), damaged.movement).total
