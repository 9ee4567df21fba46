"""Attitude filters by others over a recording, with their default settings, answers in hnav's conventions.

    q_nb, us_per_sample = run_peer("vqf", recording)

Each is the filter its authors publish, with the defaults they chose. A fair start: those that take an initial
attitude get TRIAD of the first sample, the others align themselves as they are made to. None takes time stamps, and not
all accept NaN, so each gets what a careful user would feed it: rows at its fixed rate, a lost row put back, a missing sample
left out where the filter can do without, else the last one held.

| name | package | source |
|------|---------|--------|
| vqf, basicvqf, offlinevqf | vqf | Laidig and Seel 2023, doi 10.1016/j.inffus.2022.10.014; offlinevqf sees the future |
| imufusion | imufusion | xio Technologies' Fusion, a revised Madgwick filter |
| ahrs-madgwick, ahrs-mahony, ahrs-ekf | ahrs | Madgwick 2010; Mahony et al. 2008; Sabatini's EKF; in pure Python |
"""

from __future__ import annotations

import importlib.util
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.spatial.transform import Rotation

from hnav.errors import HnavValueError
from hnav.io.recordings import Recording
from hnav.rotations import quaternion_product

STANDARD_GRAVITY_M_S2 = 9.80665
# Stamps farther than this share of an interval from the sensor's grid do not determine lost rows.
STAMP_TOLERANCE = 0.2
# Peers count x as north where hnav's east-north-up has y: a quarter turn about up.
QUARTER_TURN = np.array([np.sqrt(0.5), 0, 0, np.sqrt(0.5)])


@dataclass(frozen=True)
class Samples:
    """What a peer is fed: n x 3 arrays, contiguous, in rad/s, m/s2 and microtesla; no NaN, no gaps."""

    rate_hz: float
    row: np.ndarray  # of each row of the recording
    rate_rad_s: np.ndarray
    force_m_s2: np.ndarray
    field_ut: np.ndarray
    seen_force: np.ndarray  # n, bool: a sample of its own, not one held
    seen_field: np.ndarray

    def first_attitude(self) -> np.ndarray:
        """TRIAD of the first force and field: body to east-north-up, scalar first."""
        up = self.force_m_s2[0] / np.linalg.norm(self.force_m_s2[0])
        east = np.cross(self.field_ut[0], up)
        east /= np.linalg.norm(east)
        scalar_last: np.ndarray = Rotation.from_matrix([east, np.cross(up, east), up]).as_quat()
        return scalar_last[[3, 0, 1, 2]]


@dataclass(frozen=True)
class Peer:
    """A filter by others: the package it is in, Samples -> q (n x 4), whether it sees the future, and whether its time is
    mostly Python's because there is no call on whole arrays in compiled code."""

    package: str
    run: Callable[[Samples], np.ndarray]
    offline: bool = False
    looped: bool = False

    def installed(self) -> bool:
        return importlib.util.find_spec(self.package) is not None


# --------------------------------------------------------------------------------------------- vqf


def _ignored(values: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """VQF leaves out samples that are zero."""
    return values if seen.all() else np.where(seen[:, None], values, 0.0)


def _vqf(s: Samples, kind: str = "VQF") -> np.ndarray:
    import vqf

    force, field = _ignored(s.force_m_s2, s.seen_force), _ignored(s.field_ut, s.seen_field)
    return np.asarray(getattr(vqf, kind)(1 / s.rate_hz).updateBatch(s.rate_rad_s, force, field)["quat9D"])


def _offlinevqf(s: Samples) -> np.ndarray:
    from vqf import offlineVQF

    return np.asarray(offlineVQF(s.rate_rad_s, s.force_m_s2, s.field_ut, 1 / s.rate_hz)["quat9D"])


# --------------------------------------------------------------------------------------------- imufusion


def _imufusion(s: Samples) -> np.ndarray:
    import imufusion

    # It starts by itself: gains are raised for the first three seconds. Its frame stays north-west-up: the settings of
    # version 1.3.3 take a convention and ignore it.
    ahrs = imufusion.Ahrs()
    ahrs.set_settings(imufusion.AhrsSettings(sample_rate=s.rate_hz))
    rate_deg_s, force_g = np.degrees(s.rate_rad_s), s.force_m_s2 / STANDARD_GRAVITY_M_S2
    q = np.empty((len(rate_deg_s), 4))
    for i in range(len(q)):
        ahrs.update(rate_deg_s[i], force_g[i], s.field_ut[i])
        q[i] = ahrs.get_quaternion()
    return quaternion_product(QUARTER_TURN, q)


# --------------------------------------------------------------------------------------------- ahrs


def _ahrs_madgwick(s: Samples) -> np.ndarray:
    from ahrs.filters import Madgwick

    # Its navigation frame has x north and z up.
    x_north = quaternion_product(QUARTER_TURN * [1, -1, -1, -1], s.first_attitude())
    q = Madgwick(gyr=s.rate_rad_s, acc=s.force_m_s2, mag=s.field_ut, frequency=s.rate_hz, q0=x_north).Q
    return quaternion_product(QUARTER_TURN, q)


def _ahrs_mahony(s: Samples) -> np.ndarray:
    from ahrs.filters import Mahony

    # Its reference field is (0, horizontal, vertical): y north, z up.
    found = Mahony(gyr=s.rate_rad_s, acc=s.force_m_s2, mag=s.field_ut, frequency=s.rate_hz, q0=s.first_attitude())
    return np.asarray(found.Q)


def _ahrs_ekf(s: Samples) -> np.ndarray:
    from ahrs.filters import EKF

    # Its argument is the dip of the field; in east-north-up its gravity points down, so the reading is turned round.
    q0 = s.first_attitude()
    east, north, up = Rotation.from_quat(q0[[1, 2, 3, 0]]).apply(s.field_ut[0])
    dip_deg = np.degrees(np.arctan2(-up, np.hypot(east, north)))
    found = EKF(
        gyr=s.rate_rad_s, acc=-s.force_m_s2, mag=s.field_ut, frequency=s.rate_hz, frame="ENU", magnetic_ref=dip_deg, q0=q0
    )
    return np.asarray(found.Q)


PEERS = {
    "vqf": Peer("vqf", _vqf),
    "basicvqf": Peer("vqf", partial(_vqf, kind="BasicVQF")),
    "offlinevqf": Peer("vqf", _offlinevqf, offline=True),
    "imufusion": Peer("imufusion", _imufusion, looped=True),
    "ahrs-madgwick": Peer("ahrs", _ahrs_madgwick, looped=True),
    "ahrs-mahony": Peer("ahrs", _ahrs_mahony, looped=True),
    "ahrs-ekf": Peer("ahrs", _ahrs_ekf, looped=True),
}


# --------------------------------------------------------------------------------------------- running


def find_peer(name: str) -> Peer:
    """Raises HnavError for a name that is unknown."""
    if name not in PEERS:
        raise HnavValueError("option", f"peer {name}: choose from {', '.join(PEERS)}")
    return PEERS[name]


def samples_of(recording: Recording, rate_hz: float | None = None) -> Samples:
    """rate_hz: what the user would know from the sensor's settings; None: from the median interval."""
    if recording.field_b_tesla is None:
        raise HnavValueError("size", f"{recording.name}: no field; every peer needs one")
    if rate_hz is None:
        rate_hz = float(1 / np.median(np.diff(recording.t_s)))
    row = _rows_at_fixed_rate(recording.t_s, rate_hz)

    def fed(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        with_gaps = np.full((row[-1] + 1, 3), np.nan)
        with_gaps[row] = values
        return held(with_gaps)

    force, seen_force = fed(recording.force_b_m_s2)
    field, seen_field = fed(recording.field_b_tesla)
    return Samples(rate_hz, row, fed(recording.rate_b_rad_s)[0], force, field * 1e6, seen_force, seen_field)


def run_peer(name: str, recording: Recording, rate_hz: float | None = None) -> tuple[np.ndarray, float]:
    """(q_nb n x 4, body to east-north-up; microseconds per sample of the peer's own call). Raises HnavError."""
    peer = find_peer(name)
    if not peer.installed():
        raise HnavValueError("option", f"peer {name}: the package {peer.package} is not installed (pip install {peer.package})")
    samples = samples_of(recording, rate_hz)
    begin = time.thread_time()
    q_nb = peer.run(samples)
    seconds = time.thread_time() - begin
    return q_nb[samples.row], 1e6 * seconds / len(q_nb)


def _rows_at_fixed_rate(t_s: np.ndarray, rate_hz: float) -> np.ndarray:
    """The place of each row when lost ones are counted; none counts as lost where the stamps are too irregular."""
    intervals = np.diff(t_s) * rate_hz
    whole = np.maximum(np.round(intervals), 1)
    if np.abs(intervals - whole).max(initial=0.0) > STAMP_TOLERANCE:
        return np.arange(len(t_s))
    return np.concatenate([[0], np.cumsum(whole)]).astype(int)


def held(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Each missing row replaced by the last one seen (before the first by the first), and which rows were seen."""
    seen = np.isfinite(values).all(axis=1)
    if not seen.any():
        raise HnavValueError("size", "a sensor has no sample at all")
    last = np.maximum.accumulate(np.where(seen, np.arange(len(values)), -1))
    return np.ascontiguousarray(values[np.where(last < 0, np.argmax(seen), last)], float), seen
