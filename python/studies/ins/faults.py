"""Faults while the filter navigates: how soon is the estimate right again, and which wrong value is called ready meanwhile?

Simulated vehicles of KINDS have their exact truth. The recorded flight has none: there the reference is the filter over the same
samples without the fault.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial, reduce
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from hnav import earth
from hnav.errors import HnavRuntimeError
from hnav.filters.ins import Ins
from hnav.filters.ins_answers import InsRun
from hnav.native.arrays import Array, BoolArray
from hnav.native.library import SENSORS
from studies.ins.experiment import errors_of
from studies.ins.flight import FIRST_S, LANDING_S, Flight
from studies.ins.vehicles import EARTH_M, Samples, Truth, arriving, filter_of, fixes, starts_of, vehicle
from studies.processes import in_order

BEGIN_S = 90.0  # after the start
LONGEST_S = 60.0
JUDGED_S = 60.0  # after the end of a fault, readiness is judged for so long, and the estimate has to be right again within it
RECOVERY_S = 30.0
EVERY = 20
CLIPPED = 0.05  # rad/s
KINDS = ("car", "aircraft", "quadrotor", "walker")
FLIGHT = "flight"
GOOD = {"position": 15.0, "tilt": np.radians(3), "heading": np.radians(5)}  # in m and rad: an estimate is right again below these
AS_WITHOUT = 1.5  # or below so many times its error without the fault: a quadrotor that hovers may not have found its heading yet
LIES = GOOD | {"velocity": 1.5}
"""An error beyond this and beyond five sigmas counts as false while the filter is ready; in m, rad and m/s."""
FLAGS = ("tilt", "heading", "velocity", "position")
METRE = 1 / EARTH_M  # of latitude, in rad
FIRST = np.eye(6)[0]  # of velocity and its sigma, or of place and its sigma: north, latitude


Spoiler = Callable[[Samples, BoolArray, BoolArray], Samples]
"""Samples, the rows of the inertial sensor and of the fixes that a fault meets -> the samples with it."""


@dataclass(frozen=True)
class Fault:
    """What happens from BEGIN_S on, for length_s."""

    text: str
    length_s: float
    of: Spoiler


# --------------------------------------------------------------------------------------------- faults


def _fixes(sensor: str, change: Callable[[Array, Array], Array]) -> Spoiler:
    """change: seconds since the first fix that is met, and values (n x 6) -> the values instead."""

    def spoilt(samples: Samples, _: BoolArray, hit: BoolArray) -> Samples:
        valid, _received, kind, value = samples.aids.arrays()
        rows = hit & (kind == SENSORS.index(sensor))
        value = value.copy()
        value[rows] = change(valid[rows] - valid[rows][:1], value[rows])
        return replace(samples, aids=fixes(valid, kind, value))

    return spoilt


def _inertial(array: str, change: Callable[[Array], Array], for_good: bool = False) -> Spoiler:
    def spoilt(samples: Samples, rows: BoolArray, _: BoolArray) -> Samples:
        rows = rows | (for_good & (np.cumsum(rows) > 0))
        values = getattr(samples, array).copy()
        values[rows] = change(values[rows])
        return replace(samples, **{array: values})

    return spoilt


_rate, _force = partial(_inertial, "rate_b_rad_s"), partial(_inertial, "force_b_m_s2")


def _all(*of: Spoiler) -> Spoiler:
    """One after the other."""
    return lambda samples, rows, hit: reduce(lambda spoilt, spoiler: spoiler(spoilt, rows, hit), of, samples)


def _both(change: Callable[[Array, Array], Array]) -> Spoiler:
    return _all(_fixes("velocity", change), _fixes("position", change))


def _north(metres: Callable[[Array], Array | float]) -> Spoiler:
    """metres: of the seconds since the first fix that is met."""
    return _fixes("position", lambda since_s, value: value + np.multiply.outer(METRE * metres(since_s), FIRST))


def _faster(metres_per_second: float) -> Spoiler:
    return _fixes("velocity", lambda _, value: value + metres_per_second * FIRST)


def _noisy(sensor: str, noise: tuple[float, float, float], stated: float) -> Spoiler:
    def change(_: Array, value: Array) -> Array:
        noisy = value[:, :3] + np.array(noise) * np.random.default_rng(1).standard_normal((len(value), 3))
        return np.hstack([noisy, np.full_like(noisy, stated)])

    return _fixes(sensor, change)


def _silent(samples: Samples, _: BoolArray, hit: BoolArray) -> Samples:
    return samples.without_fixes(hit)


def _late(seconds: float) -> Spoiler:
    return lambda samples, _, hit: arriving(samples, np.where(hit, seconds, 0.0))


def _asleep(seconds: float) -> Spoiler:
    """All stamps from the fault on are so much later: nothing was recorded meanwhile, and the body is where it was."""

    def spoilt(samples: Samples, rows: BoolArray, hit: BoolArray) -> Samples:
        valid, _, sensor, value = samples.aids.arrays()
        begin_s = samples.t_s[np.argmax(rows)]
        aids = fixes(valid + seconds * (valid >= begin_s), sensor, value)
        return replace(samples, t_s=samples.t_s + seconds * (samples.t_s >= begin_s), aids=aids)

    return spoilt


def _missing(value: Array) -> Array:
    return np.full_like(value, np.nan)


def _stuck(value: Array) -> Array:
    return np.broadcast_to(value[0], value.shape)


def _one(size: float) -> Callable[[Array], Array]:
    """The first sample alone, on the first axis."""
    return lambda value: np.where(np.arange(value.size).reshape(value.shape) == 0, size, value)


def _three_turns(samples: Samples, _: BoolArray, __: BoolArray) -> Samples:
    """Twelve degrees in half a second, at the begin of each of the next three turns that are 20 s apart, as far as there are any."""
    rate, t_s = samples.rate_b_rad_s.copy(), samples.t_s
    next_s = t_s[0] + BEGIN_S
    for _turn in range(3):
        turns = np.flatnonzero((t_s > next_s) & (np.abs(samples.rate_b_rad_s[:, 2]) > 0.1))
        if len(turns) and t_s[turns[0]] < t_s[0] + BEGIN_S + LONGEST_S:
            rate[turns[0] : turns[0] + 50, 2] += np.radians(12) / 0.5
            next_s = t_s[turns[0]] + 20
    return replace(samples, rate_b_rad_s=rate)


def _with(axis: int, value: float) -> Callable[[Array], Array]:
    return lambda old: np.where(np.arange(3) == axis, value, old)


FAULTS = {
    "none": Fault("nothing", 30.0, lambda samples, _, __: samples),
    "force_bias": Fault("force along x steps by 2 m/s2", 30.0, _force(lambda f: f + 2 * np.eye(3)[0], True)),
    "rate_bias": Fault("rate about z steps by 1 deg/s", 30.0, _rate(lambda w: w + np.radians(1) * np.eye(3)[2], True)),
    "rate_dead": Fault("rate about z 0 from then on", 30.0, _rate(_with(2, 0.0), True)),
    "rate_dead_short": Fault("rate about z 0", 10.0, _rate(_with(2, 0.0))),
    "rate_stuck": Fault("rates stuck", 10.0, _rate(_stuck)),
    "force_stuck": Fault("forces stuck", 10.0, _force(_stuck)),
    "clipped": Fault(f"rates clipped at {CLIPPED} rad/s", 5.0, _rate(lambda w: np.clip(w, -CLIPPED, CLIPPED))),
    "turns": Fault("three rate errors of 12 deg", 60.0, _three_turns),
    "shock": Fault("16 g on one axis", 1.0, _force(_with(0, 157.0))),
    "wild_35": Fault("one rate of 35 rad/s", 1.0, _rate(_one(35.0))),
    "wild_400": Fault("one rate of 400 rad/s", 1.0, _rate(_one(400.0))),
    "wild_rate": Fault("one rate of 1e6 rad/s", 1.0, _rate(_one(1e6))),
    "wild_force": Fault("one force of 1e6 m/s2", 1.0, _force(_one(1e6))),
    "missing_10": Fault("no inertial samples", 10.0, _all(_rate(_missing), _force(_missing))),
    "missing_60": Fault("no inertial samples", 60.0, _all(_rate(_missing), _force(_missing))),
    "day": Fault("no samples for a day", 1.0, _asleep(86400.0)),
    "faster": Fault("velocities 20 m/s off", 60.0, _faster(20.0)),
    "frozen": Fault("fixes frozen", 60.0, _both(lambda _, value: np.broadcast_to(value[0], value.shape))),
    "nowhere": Fault("fixes at (0, 0, 0), velocity 0", 60.0, _both(lambda _, value: value * (np.arange(6) > 2))),
    "spoof": Fault("positions, velocities off by 1 m/s", 60.0, _all(_faster(1.0), _north(lambda since_s: since_s))),
    "once": Fault("one position 100 km off", 1.0, _north(lambda since_s: 1e5 * (since_s == 0))),
    "jump": Fault("positions 100 m off", 10.0, _north(lambda _: 100.0)),
    "long_jump": Fault("positions 100 m off", 60.0, _north(lambda _: 100.0)),
    "far": Fault("positions 100 km off", 10.0, _north(lambda _: 1e5)),
    "long_far": Fault("positions 100 km off", 60.0, _north(lambda _: 1e5)),
    "drift": Fault("positions drift by 1 m/s", 60.0, _north(lambda since_s: since_s)),
    "noisy_position": Fault("positions +- 20 m, stated 1 m", 60.0, _noisy("position", (20 * METRE, 20 * METRE, 0), 1.0)),
    "noisy_velocity": Fault("velocities +- 1 m/s, stated 0.05", 60.0, _noisy("velocity", (1, 1, 1), 0.05)),
    "sharp": Fault("positions stated 1 mm", 60.0, _noisy("position", (0, 0, 0), 1e-3)),
    "late": Fault("fixes stamped 1 s late", 60.0, _late(1.0)),
    "outage_10": Fault("no satellites", 10.0, _silent),
    "outage_30": Fault("no satellites", 30.0, _silent),
    "outage_60": Fault("no satellites", 60.0, _silent),
}


# --------------------------------------------------------------------------------------------- outcomes


@dataclass(frozen=True)
class Drive:
    """Samples without a fault, the truth in their rows, and the filter that takes them."""

    samples: Samples
    truth: Truth
    made: Callable[[], Ins]  # with its options

    def run(self, samples: Samples, smooth: bool = False) -> InsRun:
        """Raises HnavRuntimeError where the filter fails."""
        return self.made().run(*samples.arrays(), EVERY, check=False, smooth=smooth)

    def with_fault(self, name: str) -> tuple[Samples, float, float]:
        """The samples with this fault of FAULTS, and the times of its begin and end."""
        fault, samples = FAULTS[name], self.samples
        begin = samples.t_s[0] + BEGIN_S
        end = begin + fault.length_s
        valid = samples.aids.arrays()[0]
        met = (samples.t_s > begin) & (samples.t_s <= end)
        return fault.of(samples, met, (valid > begin) & (valid <= end)), begin, end


def simulated(kind: str, seed: int) -> Drive:
    """One of KINDS, of the industrial grade."""
    samples, truth = vehicle(kind, "industrial", seed, BEGIN_S + LONGEST_S + JUDGED_S)
    return Drive(samples, truth, partial(filter_of, kind, "industrial"))


@lru_cache(1)
def _recorded(folder: Path) -> Flight:
    return Flight(folder)


def flown(folder: Path, part: float) -> Drive:
    """From the recorded flight; part: 0 is the earliest start in the air, 1 the latest."""
    flight, length_s = _recorded(folder), BEGIN_S + LONGEST_S + JUDGED_S
    begin_s = FIRST_S + part * (LANDING_S - FIRST_S - length_s)
    log = flight.log[(flight.log["t_s"] >= begin_s) & (flight.log["t_s"] <= begin_s + length_s)]
    rate, force = (np.stack([log[name + axis] for axis in "xyz"], 1) for name in "ga")
    samples = Samples(log["t_s"], rate, force, flight.aids(log))
    clean = flight.run(log)
    known = np.isfinite(clean.q_nb[:, 0])
    place = np.where(known[:, None], clean.place, clean.place[-1])
    axes = earth.axes_at(place)
    attitude = Rotation.from_quat(np.where(known[:, None], clean.q_nb, clean.q_nb[-1]), scalar_first=True)
    velocity_e = np.einsum("nij,nj->ni", axes, np.where(known[:, None], clean.velocity_n_m_s, 0.0))
    truth = Truth(clean.t_s, earth.position_of(place), velocity_e, Rotation.from_matrix(axes) * attitude)
    return Drive(samples, truth, partial(Ins, "consumer", solver="closed_form"))


def _judged(kind: str, names: Sequence[str], folder: Path | None, start: float) -> list[dict[str, Any]]:
    drive = flown(folder, start) if kind == FLIGHT and folder is not None else simulated(kind, int(start))
    without = errors(drive.run(drive.samples), drive.truth)
    return [_with_fault(drive, without, name) for name in names]


def _with_fault(drive: Drive, without: dict[str, Array], name: str) -> dict[str, Any]:
    spoilt, begin, end = drive.with_fault(name)
    try:
        return _outcome(name, drive.run(spoilt), drive.truth, without, begin, end)
    except HnavRuntimeError:  # the filter raised an error
        never, always = dict.fromkeys(GOOD, np.inf), dict.fromkeys(LIES, 1.0)
        return _shown(name, never, np.inf, never, always, (1.0, 1.0, 1.0), 1.0)


def errors(run: InsRun, truth: Truth) -> dict[str, Array]:
    """Sizes of the errors by name, in rad, m and m/s, with "height"; NaN where there is no estimate."""
    of = errors_of(run, truth, EVERY)
    return {
        "position": np.hypot(*of.position_m[:, :2].T), "height": np.abs(of.position_m[:, 2]),
        "velocity": np.hypot(*of.velocity_m_s[:, :2].T), "tilt": np.hypot(*of.tilt_rad.T), "heading": np.abs(of.heading_rad),
    }  # fmt: skip


def lying(run: InsRun, error: dict[str, Array]) -> dict[str, BoolArray]:
    """By name of LIES: the rows that are ready and wrong."""
    sigma = {
        "tilt": run.sigma_rotation_rad[:, :2].max(1), "heading": run.sigma_rotation_rad[:, 2],
        "velocity": run.sigma_velocity_m_s[:, :2].max(1), "position": run.sigma_position_m[:, :2].max(1),
    }  # fmt: skip
    wrong = {what: np.greater(error[what], np.fmax(LIES[what], 5 * sigma[what])) for what in FLAGS}
    return {what: wrong[what] & run.ready[:, i] for i, what in enumerate(FLAGS)}


def _shown(name: str, back_s: dict[str, float], *figures: Any) -> dict[str, Any]:
    """One start with one fault. back_s: by name of GOOD, from when after the end of the fault on the error stays below it,
    infinite where it does not; is_back: within RECOVERY_S; largest_m: horizontal error from the begin on; at_end: errors in the
    last row; shares of the time from the begin to JUDGED_S after the end: lies, by name of LIES, beyond the protection levels
    (horizontal, vertical, heading), and ready (position and heading)."""
    names = ("largest_m", "at_end", "lies", "beyond", "ready")
    return {"fault": name, "back_s": back_s, "is_back": max(back_s.values()) <= RECOVERY_S, **dict(zip(names, figures))}


def _outcome(name: str, run: InsRun, truth: Truth, without: dict[str, Array], begin_s: float, end_s: float) -> dict[str, Any]:
    """Of a run in rows of EVERY, with the fault between these times of the truth. without: errors of the run without it."""
    error, t_s = errors(run, truth), truth.t_s[EVERY - 1 :: EVERY]
    met = (t_s > begin_s) & (t_s <= end_s + JUDGED_S)
    lies = {what: float(np.mean(rows[met])) for what, rows in lying(run, error).items()}
    back = {}
    for what, limit in GOOD.items():
        right = error[what] < np.fmax(limit, AS_WITHOUT * without[what])
        last = t_s[(t_s > end_s) & ~right].max(initial=end_s)
        back[what] = float(last - end_s) if last < t_s[-1] - 1 else np.inf
    bounds = (run.protection_m[:, 0], run.protection_m[:, 1], run.protection_heading_rad)
    beyond = [float(np.mean((error[what] > bound)[met])) for what, bound in zip(("position", "height", "heading"), bounds)]
    largest = float(np.nanmax(error["position"][t_s > begin_s], initial=0.0))
    at_end = {what: float(error[what][-1]) for what in GOOD}
    ready = float(np.mean(run.ready[met, 1] & run.ready[met, 3]))
    return _shown(name, back, largest, at_end, lies, beyond, ready)


def outcomes(
    kind: str, names: Sequence[str], runs: int, seed: int, workers: int, folder: Path | None = None
) -> Iterator[list[dict[str, Any]]]:
    """For each start, in their order, the faults of these names in FAULTS. folder: of the recorded flight, for the kind FLIGHT."""
    starts: Sequence[float] = starts_of(seed, runs)
    if kind == FLIGHT:
        starts = [float(part) for part in np.linspace(0, 1, runs)]
    return in_order(partial(_judged, kind, tuple(names), folder), starts, workers)


# --------------------------------------------------------------------------------------------- hindsight


Both = dict[str, tuple[float, float]]  # by name of FLAGS, of filter and smoother


def in_hindsight(drive: Drive, name: str) -> tuple[Both, Both]:
    """Filter and smoother over the same samples with a fault: root mean squares of errors over the rows in which both know them,
    in m, rad and m/s, and the shares of all rows that are ready and wrong. Raises HnavRuntimeError where the filter fails."""
    spoilt, _, _ = drive.with_fault(name)
    runs = [drive.run(spoilt, smooth) for smooth in (False, True)]
    found = [errors(run, drive.truth) for run in runs]
    rms, lies = {}, {}
    wrong = [lying(run, error) for run, error in zip(runs, found)]
    for what in FLAGS:
        both = np.isfinite(found[0][what]) & np.isfinite(found[1][what])
        before, after = (float(np.sqrt(np.mean(error[what][both] ** 2))) for error in found)
        rms[what], lies[what] = (before, after), (float(np.mean(wrong[0][what])), float(np.mean(wrong[1][what])))
    return rms, lies


def hindsights(kind: str, names: Sequence[str], runs: int, seed: int, workers: int) -> Iterator[list[tuple[Both, Both]]]:
    """For each start of a simulated body, in their order, the faults of these names in FAULTS."""
    return in_order(partial(_in_hindsight, kind, tuple(names)), starts_of(seed, runs), workers)


def _in_hindsight(kind: str, names: Sequence[str], start: int) -> list[tuple[Both, Both]]:
    drive = simulated(kind, start)
    return [in_hindsight(drive, name) for name in names]
