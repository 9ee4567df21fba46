"""Who takes part: hnav's filters by name and options, and those of others."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hnav.cli.parameters import parse_settings
from hnav.errors import HnavValueError
from hnav.filters.attitude import Filter
from hnav.filters.options import FILTERS, Options
from hnav.fmi.engines import run_recording
from hnav.io.recordings import Recording
from studies.bench.motions import body_of, sensor_of
from studies.bench.peers import PEERS, find_peer, run_peer
from studies.larger_q import WALK, larger_q

SMOOTH = "-smooth"
# Peers in pure Python take minutes for what the others do in seconds; they run when they are named.
DEFAULT_PEERS = tuple(name for name, peer in PEERS.items() if peer.package != "ahrs")
LARGER_Q = "ekf-larger-q"
OWN_BODY = "body=own"  # the setting that gives each recording the word for what it was made on
OWN_SPEED = "speed=own"  # the setting that gives each recording of MOTION the speeds that it has
OWN_SENSOR = "sensor=own"  # the setting that gives each recording of MOTION the datasheet of its sensors
DEFAULT_FILTERS = ("hrekf", LARGER_Q, "ahrs", "ahrs:solver=closed_form", f"ahrs{SMOOTH}")


@dataclass(frozen=True)
class Estimate:
    """What a contender makes of a recording."""

    q_nb: np.ndarray  # n x 4, body to east-north-up
    sigma_rad: np.ndarray | None  # n x 3, if it states any
    us_per_sample: float | None  # if this very run may serve as a timing
    ready: np.ndarray | None = None  # n x 2, bool: tilt and heading, if it has such flags


@dataclass(frozen=True)
class Contender:
    """One filter in the benchmark. time_us gives the time per sample of one run, NaN where it would mean nothing."""

    name: str
    ours: bool
    offline: bool  # sees the future
    estimate: Callable[[Recording, float], Estimate]  # recording, its nominal rate in Hz
    time_us: Callable[[Recording, float], float]
    looped: bool = False  # its time is mostly Python's


def contenders(filters: Sequence[str], peers: Sequence[str]) -> tuple[list[Contender], list[str]]:
    """Those that can run, and a line for each peer whose package is missing. Raises HnavError or UsageError for wrong names.

    A filter is NAME, NAME-smooth for its smoother, or either with options: NAME:option=value:option=value. body=own is the body that each
    recording was made on, sensor=own the datasheet of its sensors, speed=own its speeds along body x.
    """
    ready, missing = [own_contender(name) for name in filters], []
    for name in peers:
        peer = find_peer(name)
        if peer.installed():
            ready.append(_peer_contender(name))
        else:
            missing.append(f"{name} is not beside them: the package {peer.package} is not installed (pip install {peer.package})")
    return ready, missing


def own_contender(name: str) -> Contender:
    """A filter of hnav by name, or the hrekf without its robust law and with a larger Q. Raises HnavError or UsageError for wrong filters and options."""
    head, *pairs = name.split(":")
    smooth = head.endswith(SMOOTH)
    filter, others = head.removesuffix(SMOOTH), dict[str, str]()
    if filter == LARGER_Q:
        filter = "hrekf"
        others = {option: str(value) for option, value in larger_q(getattr(Options(filter), WALK)).items()}
    if filter not in FILTERS:
        raise HnavValueError("option", f"filter {name}: choose from {', '.join(DEFAULT_FILTERS)}")
    own_body, own_sensor, own_speed = OWN_BODY in pairs, OWN_SENSOR in pairs, OWN_SPEED in pairs
    chosen = parse_settings([pair for pair in pairs if pair not in (OWN_BODY, OWN_SENSOR, OWN_SPEED)])
    settings = {"navigation_frame": "enu"} | others | chosen
    Options(filter, **settings)  # an invalid setting is refused before the first run

    def estimate(recording: Recording, rate_hz: float) -> Estimate:
        own: dict[str, Any] = {"body": body_of(recording)} if own_body else {}
        if own_sensor:
            own |= sensor_of(recording)
        if not own_speed:
            recording = replace(recording, aids={})
        result = run_recording(recording, filter, settings=settings | own, smooth=smooth)
        return Estimate(result.q_nb, result.sigma_rad, None, result.ready)

    def time_us(recording: Recording, rate_hz: float) -> float:
        if recording.field_t_s is not None and not smooth:
            return math.nan  # samples pushed one by one from Python: its time, not the filter's
        attitude_filter = Filter(Options(filter, **settings))
        batch = attitude_filter.smooth if smooth else attitude_filter.run
        samples = (recording.t_s, recording.rate_b_rad_s, recording.force_b_m_s2, recording.field_b_tesla)
        begin = time.thread_time()
        batch(*samples, only=("q_nb",))
        return 1e6 * (time.thread_time() - begin) / len(recording.t_s)

    return Contender(name, True, smooth, estimate, time_us)


def _peer_contender(name: str) -> Contender:
    def estimate(recording: Recording, rate_hz: float) -> Estimate:
        q_nb, us = run_peer(name, recording, rate_hz)
        return Estimate(q_nb, None, us)

    def time_us(recording: Recording, rate_hz: float) -> float:
        return run_peer(name, recording, rate_hz)[1]

    return Contender(name, False, PEERS[name].offline, estimate, time_us, PEERS[name].looped)
