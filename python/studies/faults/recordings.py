"""Recordings damaged on purpose, as sensors, cables, queues and clocks damage them on an ordinary day."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from hnav.io.recordings import Recording
from studies.bench.stress import with_rows

CLIP_RAD_S = np.radians(115)
SPIKE_EVERY_S = 10.0
GYRO_SPIKE_RAD_S = 35.0
FORCE_SPIKE_M_S2 = 160.0
FORCE_SPIKE_SHARE = 0.01
FLIP_S = 20.0
BURST = 10  # samples that share a stamp
LOST_S = 0.05  # of every second
HOUR_S = 3600.0


def _spikes(samples: np.ndarray, rows: np.ndarray, size: float, rng: np.random.Generator) -> np.ndarray:
    out = samples.copy()
    out[rows, rng.integers(3, size=len(rows))] = size * rng.choice([-1, 1], size=len(rows))
    return out


def gyro_axis_dead(recording: Recording, rng: np.random.Generator) -> Recording:
    rate = recording.rate_b_rad_s.copy()
    rate[len(rate) // 2 :, 2] = 0
    return replace(recording, rate_b_rad_s=rate)


def gyro_spikes(recording: Recording, rng: np.random.Generator) -> Recording:
    times = np.arange(recording.t_s[0] + SPIKE_EVERY_S, recording.t_s[-1], SPIKE_EVERY_S)
    rows = np.searchsorted(recording.t_s, times)
    return replace(recording, rate_b_rad_s=_spikes(recording.rate_b_rad_s, rows, GYRO_SPIKE_RAD_S, rng))


def force_spikes(recording: Recording, rng: np.random.Generator) -> Recording:
    rows = np.flatnonzero(rng.random(len(recording.t_s)) < FORCE_SPIKE_SHARE)
    return replace(recording, force_b_m_s2=_spikes(recording.force_b_m_s2, rows, FORCE_SPIKE_M_S2, rng))


def field_stuck(recording: Recording, rng: np.random.Generator) -> Recording:
    field = recording.needed("field_b_tesla").copy()
    first = len(field) // 3
    known = np.flatnonzero(np.isfinite(field[:first]).all(axis=1))[-1]
    rows = np.arange(len(field)) >= first
    field[rows & np.isfinite(field).all(axis=1)] = field[known]
    return replace(recording, field_b_tesla=field)


def field_flipped(recording: Recording, rng: np.random.Generator) -> Recording:
    middle_s = 0.5 * (recording.t_s[0] + recording.t_s[-1])
    field = recording.needed("field_b_tesla").copy()
    field[(recording.t_s >= middle_s) & (recording.t_s < middle_s + FLIP_S), :2] *= -1
    return replace(recording, field_b_tesla=field)


def shared_stamps(recording: Recording, rng: np.random.Generator) -> Recording:
    last = np.minimum(np.arange(len(recording.t_s)) // BURST * BURST + BURST - 1, len(recording.t_s) - 1)
    return replace(recording, t_s=recording.t_s[last])


def lost_each_second(recording: Recording, rng: np.random.Generator) -> Recording:
    keep = (recording.t_s - recording.t_s[0]) % 1 >= LOST_S
    return with_rows(recording, keep)


def one_stamp_late(recording: Recording, rng: np.random.Generator) -> Recording:
    t_s = recording.t_s.copy()
    t_s[len(t_s) // 2] += HOUR_S
    return replace(recording, t_s=t_s)


def clock_set_back(recording: Recording, rng: np.random.Generator) -> Recording:
    t_s, half = recording.t_s.copy(), len(recording.t_s) // 2
    t_s[half:] -= t_s[half]
    return replace(recording, t_s=t_s)


FAULTS: dict[str, Callable[[Recording, np.random.Generator], Recording]] = {
    "none": lambda recording, rng: recording,
    "gyro clipped at 115 deg/s": lambda r, rng: replace(r, rate_b_rad_s=np.clip(r.rate_b_rad_s, -CLIP_RAD_S, CLIP_RAD_S)),
    "gyro z = 0 from half": gyro_axis_dead,
    "gyro spike every 10 s": gyro_spikes,
    "accelerometer spikes, 1 %": force_spikes,
    "magnetometer stuck from 1/3": field_stuck,
    "field x, y flipped for 20 s": field_flipped,
    "10 samples share a stamp": shared_stamps,
    "50 ms lost each second": lost_each_second,
    "one stamp + 1 h": one_stamp_late,
    "clock back to 0": clock_set_back,
}
