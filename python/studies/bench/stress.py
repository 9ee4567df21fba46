"""Recordings made harder: starts in motion, a field that is false at the start, and what real sensors do to samples.

    for variant in variants("XREST", recordings): ...

| set    | what is done to a recording |
|--------|-----------------------------|
| BROAD  | nothing |
| CROP   | cut to begin with the motion that is scored: no rest to align in |
| XREST  | the field of the first 5 to 20 s is turned by 30 to 90 deg and scaled by 0.6 to 1.5 in the earth's frame; it is true again while the sensor still rests; twice over all recordings |
| XMOT   | cut as CROP, the field false as in XREST from there on; scored from 10 s after it is true again |
| DROP   | one sample in a hundred is lost, with its time stamp |
| JITTER | time stamps of arrival, up to 5 ms after the sampling, in order |
| LATE   | the magnetometer arrives 20 ms late; its time stamps are truthful |
| BURST  | each sensor falls silent for 10 to 100 ms, every 20 s on average |

The first four are about the start, the others about the sensors. Everything is seeded: the same seed and the same
recordings in the same order give the same bits. Recordings need a reference attitude and a scored phase.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from hnav.io.recordings import Recording, RecordingError
from studies.bench.peers import held

# What the magnetometer sees has to be true for this long before XMOT is scored.
SETTLING_S = 10.0
DROPPED_SHARE = 0.01
JITTER_S = 0.005
# Two stamps of a sample counter never fall together, even when a late sample catches up with the next.
STAMP_SPACING_S = 1e-5
FIELD_DELAY_S = 0.020
BURST_S, BURST_EVERY_S = (0.01, 0.1), 20.0


# --------------------------------------------------------------------------------------------- starts


class Distortion(NamedTuple):
    """A false field: the true one turned and scaled in the earth's frame, for the first duration_s."""

    duration_s: float
    rotation: Rotation
    scale: float


def draw_distortion(rng: np.random.Generator) -> Distortion:
    """5 to 20 s, 30 to 90 deg about any axis, strength 0.6 to 1.5."""
    duration_s = rng.uniform(5, 20)
    angle_rad = np.radians(rng.uniform(30, 90))
    axis = rng.normal(size=3)
    return Distortion(duration_s, Rotation.from_rotvec(angle_rad * axis / np.linalg.norm(axis)), rng.uniform(0.6, 1.5))


def from_motion(recording: Recording) -> Recording:
    """The recording from the first scored row on."""
    return with_rows(recording, slice(int(np.argmax(recording.needed("movement"))), None))


def distorted(recording: Recording, distortion: Distortion, settling_s: float | None = None) -> Recording:
    """The field of the first rows false; settling_s: score only what is later than this after the field's return."""
    n = min(int(distortion.duration_s * nominal_rate_hz(recording)), len(recording.t_s))
    # Without an optical attitude, the last one orients the distortion.
    attitude = Rotation.from_quat(held(recording.needed("reference_q_nb"))[0][:n][:, [1, 2, 3, 0]])
    field = recording.needed("field_b_tesla").copy()
    earth = distortion.scale * distortion.rotation.apply(attitude.apply(field[:n]))
    field[:n] = attitude.apply(earth, inverse=True)
    movement = recording.needed("movement").copy()
    if settling_s is not None:
        movement[: n + int(settling_s * nominal_rate_hz(recording))] = False
    return replace(recording, field_b_tesla=field, movement=movement)


# --------------------------------------------------------------------------------------------- sensor faults


def dropped(recording: Recording, rng: np.random.Generator, share: float = DROPPED_SHARE) -> Recording:
    """Without this share of the rows; the first row stays, and with it the instant of the start."""
    lost = rng.random(len(recording.t_s)) < share
    lost[0] = False
    return with_rows(recording, ~lost)


def jittered(recording: Recording, rng: np.random.Generator, jitter_s: float = JITTER_S) -> Recording:
    """Stamped on arrival: each sample up to jitter_s after its sampling, none before its predecessor."""
    spacing_s = STAMP_SPACING_S * np.arange(len(recording.t_s))
    arrival_s = recording.t_s + rng.uniform(0, jitter_s, len(recording.t_s))
    return replace(recording, t_s=np.maximum.accumulate(arrival_s - spacing_s) + spacing_s)


def late_field(recording: Recording, delay_s: float = FIELD_DELAY_S) -> Recording:
    """Each field arrives with the first row that is delay_s or more after its own; field_t_s keeps the truth.

    A filter without time stamps treats the field as one of the row's instant.
    """
    # Of the fields that have arrived by the instant of a row the newest is delivered; a hair more than the delay keeps
    # rounding from costing a row.
    newest = np.searchsorted(recording.t_s, recording.t_s - delay_s + 1e-9, side="right") - 1
    fresh = (newest >= 0) & (np.diff(newest, prepend=-1) > 0)
    field = np.where(fresh[:, None], recording.needed("field_b_tesla")[newest], np.nan)
    return replace(recording, field_b_tesla=field, field_t_s=np.where(fresh, recording.t_s[newest], np.nan))


def with_bursts(recording: Recording, rng: np.random.Generator) -> Recording:
    """Rate, force and field with independent bursts of NaN, as a Poisson process; the first second has none."""
    begin_s, end_s = recording.t_s[0] + 1.0, recording.t_s[-1]
    samples = {}
    for name in ("rate_b_rad_s", "force_b_m_s2", "field_b_tesla"):
        values = getattr(recording, name).copy()
        for start_s in rng.uniform(begin_s, end_s, rng.poisson((end_s - begin_s) / BURST_EVERY_S)):
            values[(recording.t_s >= start_s) & (recording.t_s < start_s + rng.uniform(*BURST_S))] = np.nan
        samples[name] = values
    return replace(recording, **samples)


# --------------------------------------------------------------------------------------------- sets

Variants = Callable[[Sequence[Recording], int], Iterator[Recording]]


def _distortions(recordings: Sequence[Recording], seed: int) -> list[Distortion]:
    # One stream for XREST (twice over all recordings) and XMOT (once), so that each set is the same without the other.
    rng = np.random.default_rng(seed)
    return [draw_distortion(rng) for _ in range(3 * len(recordings))]


def _xrest(recordings: Sequence[Recording], seed: int) -> Iterator[Recording]:
    for i, distortion in enumerate(_distortions(recordings, seed)[: 2 * len(recordings)]):
        variant = distorted(recordings[i % len(recordings)], distortion)
        yield replace(variant, name=f"{variant.name} #{i // len(recordings) + 1}")


def _xmot(recordings: Sequence[Recording], seed: int) -> Iterator[Recording]:
    for recording, distortion in zip(recordings, _distortions(recordings, seed)[2 * len(recordings) :]):
        yield distorted(from_motion(recording), distortion, SETTLING_S)


def _each(change: Callable[[Recording, np.random.Generator], Recording]) -> Variants:
    """Every recording changed with random numbers of its own."""

    def made(recordings: Sequence[Recording], seed: int) -> Iterator[Recording]:
        for i, recording in enumerate(recordings):
            yield change(recording, np.random.default_rng([seed, i]))

    return made


SETS: dict[str, Variants] = {
    "BROAD": _each(lambda recording, rng: recording),
    "CROP": _each(lambda recording, rng: from_motion(recording)),
    "XREST": _xrest,
    "XMOT": _xmot,
    "DROP": _each(dropped),
    "JITTER": _each(jittered),
    "LATE": _each(lambda recording, rng: late_field(recording)),
    "BURST": _each(with_bursts),
}


def variants(set_name: str, recordings: Sequence[Recording], seed: int = 5) -> Iterator[Recording]:
    """The recordings of a set, one after the other. Raises RecordingError for what a recording lacks."""
    if set_name not in SETS:
        raise RecordingError(f"set {set_name}: choose from {', '.join(SETS)}")
    for recording in recordings:
        for name in ("field_b_tesla", "reference_q_nb", "movement"):
            if getattr(recording, name) is None:
                raise RecordingError(f"{recording.name}: no {name}; stress needs field, reference attitude and scored phase")
        if not recording.needed("movement").any():
            raise RecordingError(f"{recording.name}: no row is scored")
    yield from SETS[set_name](recordings, seed)


def variant_count(set_name: str, recordings: int) -> int:
    """How many variants a set makes of so many recordings."""
    return 2 * recordings if set_name == "XREST" else recordings


def nominal_rate_hz(recording: Recording) -> float:
    """Rows per second by the median interval, which lost rows do not change."""
    return float(1 / np.median(np.diff(recording.t_s)))


def changed(recording: Recording, array: str, change: Callable[[np.ndarray], np.ndarray | float], rows: Any = ...) -> Recording:
    """With other values in these rows (or rows and columns) of the array of this name; change: the values -> those instead."""
    values: Any = recording.needed(array).copy()
    values[rows] = change(values[rows])
    return replace(recording, **{array: values})


def with_rows(recording: Recording, keep: slice | np.ndarray) -> Recording:
    arrays: dict[str, Any] = {k: v[keep] for k, v in vars(recording).items() if isinstance(v, np.ndarray)}
    return replace(recording, **arrays)
