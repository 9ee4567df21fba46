"""Recordings damaged on purpose, as sensors, cables, queues and clocks damage them on an ordinary day."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from hnav.io.recordings import Recording
from studies.bench.stress import changed, with_rows

CLIP_RAD_S = np.radians(115)
SPIKE_EVERY_S = 10.0
GYRO_SPIKE_RAD_S = 35.0
FORCE_SPIKE_M_S2 = 160.0
FORCE_SPIKE_SHARE = 0.01
FLIP_S = 20.0
BURST = 10  # samples that share a stamp
LOST_S = 0.05  # of every second
HOUR_S = 3600.0


RATE, FORCE, FIELD, TIME = "rate_b_rad_s", "force_b_m_s2", "field_b_tesla", "t_s"


def _spikes(recording: Recording, array: str, rows: np.ndarray, size: float, rng: np.random.Generator) -> Recording:
    out: Any = recording.needed(array).copy()
    out[rows, rng.integers(3, size=len(rows))] = size * rng.choice([-1, 1], size=len(rows))
    return replace(recording, **{array: out})


def _gyro_spikes(recording: Recording, rng: np.random.Generator) -> Recording:
    times = np.arange(recording.t_s[0] + SPIKE_EVERY_S, recording.t_s[-1], SPIKE_EVERY_S)
    return _spikes(recording, RATE, np.searchsorted(recording.t_s, times), GYRO_SPIKE_RAD_S, rng)


def _force_spikes(recording: Recording, rng: np.random.Generator) -> Recording:
    rows = np.flatnonzero(rng.random(len(recording.t_s)) < FORCE_SPIKE_SHARE)
    return _spikes(recording, FORCE, rows, FORCE_SPIKE_M_S2, rng)


def _field_stuck(recording: Recording, rng: np.random.Generator) -> Recording:
    first = len(recording.t_s) // 3
    known = np.flatnonzero(np.isfinite(recording.needed(FIELD)).all(axis=1))
    held = recording.needed(FIELD)[known[known < first][-1]]
    return changed(recording, FIELD, lambda _: held, known[known >= first])


def _flipped(recording: Recording) -> np.ndarray:
    """The rows of FLIP_S from the middle on."""
    middle_s = 0.5 * (recording.t_s[0] + recording.t_s[-1])
    return np.asarray((recording.t_s >= middle_s) & (recording.t_s < middle_s + FLIP_S))


def _half(recording: Recording) -> slice:
    return slice(len(recording.t_s) // 2, None)


def _last_of_burst(values: np.ndarray) -> np.ndarray:
    return values[np.minimum(np.arange(len(values)) // BURST * BURST + BURST - 1, len(values) - 1)]


FAULTS: dict[str, Callable[[Recording, np.random.Generator], Recording]] = {
    "none": lambda r, rng: r,
    "gyro clipped at 115 deg/s": lambda r, rng: changed(r, RATE, lambda rate: np.clip(rate, -CLIP_RAD_S, CLIP_RAD_S)),
    "gyro z = 0 from half": lambda r, rng: changed(r, RATE, lambda _: 0.0, (_half(r), 2)),
    "gyro spike every 10 s": _gyro_spikes,
    "accelerometer spikes, 1 %": _force_spikes,
    "magnetometer stuck from 1/3": _field_stuck,
    "field x, y flipped for 20 s": lambda r, rng: changed(r, FIELD, np.negative, (_flipped(r), slice(2))),
    "10 samples share a stamp": lambda r, rng: changed(r, TIME, _last_of_burst),
    "50 ms lost each second": lambda r, rng: with_rows(r, (r.t_s - r.t_s[0]) % 1 >= LOST_S),
    "one stamp + 1 h": lambda r, rng: changed(r, TIME, lambda t_s: t_s + HOUR_S, len(r.t_s) // 2),
    "clock back to 0": lambda r, rng: changed(r, TIME, lambda t_s: t_s - t_s[0], _half(r)),
}
