"""Faults while the filter navigates: are they gated or flagged, and when do they end?"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from hnav.filters.ins import Ins
from hnav.filters.ins_answers import InsRun
from hnav.native.arrays import Array, BoolArray
from hnav.native.library import SENSORS
from hnav.reference import earth
from hnav.systems.navigation_views import wrapped
from studies.ins.vehicles import OUTLIERS, Samples, Truth, fixes, starts_of, vehicle
from studies.processes import in_order

BEGIN_S = 90.0
"""After the start."""
AFTER_S = 60.0
RECOVERY_S = 30.0
EVERY = 20
CLIPPED_RAD_S = 0.05


@dataclass(frozen=True)
class Fault:
    """What happens from BEGIN_S on, for length_s."""

    text: str
    length_s: float
    of: Callable[[Samples, BoolArray, BoolArray], Samples]
    """Samples, the rows of the inertial sensor and of the fixes that it meets -> the samples with the fault."""


@dataclass(frozen=True)
class Outcome:
    """One start with one fault."""

    kind: str
    fault: str
    told: bool
    """Fixes were gated by more than by chance, or a flag of readiness fell, from its begin to RECOVERY_S after its end."""
    within: float
    """Share of the instants, from its begin to the end of the run, at which north and east lie within 3 sigma."""
    heading_within: float
    """The same of the heading."""
    largest_m: float
    """Horizontal error while it lasts and after it."""
    back_s: float
    """After its end: from then on the position stays within 3 sigma or 5 m."""


def _moved(samples: Samples, hit: BoolArray, north_m: Array | float) -> Samples:
    valid, _, sensor, value = samples.aids.arrays()
    rows = hit & (sensor == SENSORS.index("position"))
    value[rows, 0] += (np.broadcast_to(north_m, hit.shape) / 6.37e6)[rows]
    return replace(samples, aids=fixes(valid, sensor, value))


def _drifting(samples: Samples, _: BoolArray, hit: BoolArray) -> Samples:
    valid = samples.aids.arrays()[0]
    return _moved(samples, hit, 1.0 * (valid - samples.t_s[0] - BEGIN_S))


def _clipped(samples: Samples, rows: BoolArray, _: BoolArray) -> Samples:
    rate = samples.rate_b_rad_s.copy()
    rate[rows] = np.clip(rate[rows], -CLIPPED_RAD_S, CLIPPED_RAD_S)
    return replace(samples, rate_b_rad_s=rate)


def _silent(samples: Samples, _: BoolArray, hit: BoolArray) -> Samples:
    valid, _received, sensor, value = samples.aids.arrays()
    return replace(samples, aids=fixes(valid[~hit], sensor[~hit], value[~hit]))


def _as_it_is(samples: Samples, _: BoolArray, __: BoolArray) -> Samples:
    return samples


FAULTS = {
    "none": Fault("nothing", 30.0, _as_it_is),
    "jump": Fault("positions 100 m off", 10.0, lambda s, _, hit: _moved(s, hit, 100.0)),
    "long_jump": Fault("positions 100 m off, believed", 60.0, lambda s, _, hit: _moved(s, hit, 100.0)),
    "drift": Fault("positions drift by 1 m/s", 60.0, _drifting),
    "clipped": Fault(f"rates clipped at {CLIPPED_RAD_S:g} rad/s", 5.0, _clipped),
    "outage_10": Fault("no satellites", 10.0, _silent),
    "outage_30": Fault("no satellites", 30.0, _silent),
    "outage_60": Fault("no satellites", 60.0, _silent),
}


def _judged(kind: str, name: str, seed: int) -> Outcome:
    fault = FAULTS[name]
    samples, truth = vehicle(kind, "industrial", seed, BEGIN_S + fault.length_s + AFTER_S)
    begin = samples.t_s[0] + BEGIN_S
    end = begin + fault.length_s
    valid = samples.aids.arrays()[0]
    spoilt = fault.of(samples, (samples.t_s > begin) & (samples.t_s <= end), (valid > begin) & (valid <= end))
    ins = Ins("industrial", solver="closed_form")
    run = ins.run(spoilt.t_s, spoilt.rate_b_rad_s, spoilt.force_b_m_s2, spoilt.aids, EVERY)
    gated = ins.diagnostics().gated["position"] > 3 * OUTLIERS * len(valid) / 2
    return _outcome(kind, name, run, truth, begin, end, gated)


def _outcome(kind: str, name: str, run: InsRun, truth: Truth, begin_s: float, end_s: float, gated: bool) -> Outcome:
    rows = np.arange(EVERY - 1, len(truth.t_s), EVERY)
    off = earth.position_of(run.place) - truth.position_e[rows]
    off_n = np.einsum("nij,ni->nj", earth.axes_at(run.place), off)[:, :2]
    met = run.t_s > begin_s
    z = np.abs(off_n / run.sigma_position_m[:, :2])
    heading_z = np.abs(wrapped(run.heading_rad - truth.heading_rad()[rows]) / run.sigma_rotation_rad[:, 2])
    far = np.hypot(*off_n.T)
    lost = (run.t_s > end_s) & ~((z.max(1) < 3) | (far < 5))
    last = run.t_s[lost].max(initial=end_s)
    told = met & (run.t_s < end_s + RECOVERY_S) & ~run.ready[:, [1, 3]].all(1)
    return Outcome(
        kind, name, gated or bool(told.any()), float(np.mean(z[met].max(1) < 3)), float(np.mean(heading_z[met] < 3)),
        float(far[met].max()), float(last - end_s),
    )  # fmt: skip


def outcomes(kind: str, name: str, runs: int, seed: int, workers: int) -> Iterator[Outcome]:
    """The starts of a seed, in their order, with the fault of this name in FAULTS."""
    return in_order(partial(_judged, kind, name), starts_of(seed, runs), workers, 4)
