"""Starts whose first force or field is wrong: is the attitude later as good as without that sample?

Undisturbed starts of studies.readiness.starts. The first sample of one sensor gets 0 to 3 times the strength of the true one, in any
direction; beside it runs the same start without that sample.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from hnav.filters.attitude import Filter
from hnav.filters.options import Options
from hnav.io.recordings import Recording
from hnav.reports.scores import score
from studies.bench.stress import changed
from studies.faults.events import unit_vector
from studies.processes import in_order
from studies.readiness.starts import DISTURBANCES, GRAVITY_M_S2, MOTIONS, RATE_HZ, simulated_start

SENSORS = {"force": "force_b_m_s2", "field": "field_b_tesla"}
MAX_STRENGTH = 3.0  # in units of gravity, or of the field
JUDGED_S = (10.0, 20.0)
AS_GOOD_DEG = 0.05  # RMS of the total error over JUDGED_S, beyond that of the start without the sample


def first_samples(starts: int, sensor: str, options: Options, workers: int = 1) -> Iterator[tuple[float, float]]:
    """One start after the other, motions take turns. sensor: of SENSORS. Raises HnavError."""
    yield from in_order(partial(first_sample, sensor=sensor, options=options), range(starts), workers, 8)


def first_sample(index: int, sensor: str, options: Options) -> tuple[float, float]:
    """RMS of the total error over JUDGED_S, in deg: of the start with the false sample, and of the start without it."""
    groups = len(MOTIONS) * len(DISTURBANCES)
    undisturbed = groups * (index // len(MOTIONS)) + index % len(MOTIONS)
    recording = simulated_start(undisturbed, duration_s=JUDGED_S[1]).recording
    rng = np.random.default_rng([index, 99])
    samples = np.array(getattr(recording, SENSORS[sensor]))
    strength = GRAVITY_M_S2 if sensor == "force" else float(np.linalg.norm(samples[0]))
    false = unit_vector(rng) * rng.uniform(0, MAX_STRENGTH) * strength
    with_it, without = (changed(recording, SENSORS[sensor], change, 0) for change in (lambda _: false, lambda _: np.nan))
    return error_deg(with_it, options), error_deg(without, options)


def error_deg(recording: Recording, options: Options) -> float:
    samples = recording.t_s, recording.rate_b_rad_s, recording.force_b_m_s2, recording.field_b_tesla
    run = Filter(options).run(*samples, only=("q_nb",))
    judged = slice(*(round(t_s * RATE_HZ) for t_s in JUDGED_S))
    return score(run.q_nb[judged], recording.needed("reference_q_nb")[judged]).total


def verdict(sensor: str, starts: list[tuple[float, float]]) -> str:
    """A line for the user."""
    beyond = np.array([false - without for false, without in starts])
    return (
        f"first {sensor} of 0 to {MAX_STRENGTH:g} times its strength in any direction: {np.sum(beyond <= AS_GOOD_DEG)} of {len(starts)} starts "
        f"as good as without it after {JUDGED_S[0]:g} s, worst {beyond.max():.2f} deg beyond"
    )
