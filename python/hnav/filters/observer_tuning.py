"""Noise of a plan from a recording: the densities and sensor sigmas that make its samples most likely.

    tuned = tune(plan, t_s, {"x": y})
    tuned.plan, tuned.undetermined, tuned.ahead_nis

The likelihood of the innovations says how large noises are, as far as the data determine it; whether the model is right says
prediction over several samples.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.optimize import minimize

from hnav.errors import HnavError, HnavValueError
from hnav.filters.observer import Observer, ObserverOptions
from hnav.filters.observer_findings import findings
from hnav.filters.observer_plan import Plan
from hnav.native.arrays import Array

AHEAD = 10  # samples that a prediction goes ahead
LAGS = 5  # innovations after one, that it must not foretell
_CHANCE = 4.0  # sigmas of a correlation
_RANGE = math.log(1e4)  # of a factor
_ENOUGH = 0.05  # nats, about: what a better step has to bring
_NATS = 2.0  # that half or twice of a noise must cost to be determined


@dataclass(frozen=True)
class Tuned:
    """A plan whose noises fit a recording."""

    plan: Plan
    """With the noises found; otherwise as given."""
    factors: dict[str, float]
    """By which each noise was multiplied: "sensor x", "state v", ..."""
    log_likelihood: tuple[float, float]
    """Before and after, of all samples."""
    undetermined: tuple[str, ...]
    """Noises of which half or twice is about as likely."""
    correlation: dict[str, float]
    """By sensor: the largest correlation of an innovation with one of the next LAGS, 0 where chance explains it."""
    mean_nis: dict[str, float]
    """By sensor, of all innovations with the noises found; 1 where their size is as stated."""
    ahead_nis: dict[str, float]
    """By sensor: mean NIS of predictions over AHEAD samples, outside of what findings tells of. Far above 1: the model is wrong, not
    its noise."""


def tune(
    plan: Plan, t_s: npt.ArrayLike, sensors: Mapping[str, npt.ArrayLike], inputs: Mapping[str, npt.ArrayLike] | None = None,
    options: ObserverOptions | None = None, progress: Callable[[float], None] = lambda _: None,
) -> Tuned:  # fmt: skip
    """The most likely noises, each within a factor of 10 000 of the plan's; those that are 0 stay so. Arrays as of Observer.run.

    progress: called with the log-likelihood of each trial. Raises HnavValueError for a plan without noise.
    """
    names = _noises(plan)
    if not any(name.startswith("state") for name in names) and len(names) < 2:
        raise HnavValueError("option", "no state has noise: give one that is disturbed a first value, however rough")
    seen = {name: np.asarray(values, float) for name, values in sensors.items()}

    def likelihood(logs: Array) -> float:
        try:
            run = Observer(_scaled(plan, dict(zip(names, np.exp(logs)))), options).run(t_s, seen, inputs)
        except HnavError:
            return -math.inf
        told = float(np.nansum(run.log_likelihood)) if run.dropped == 0 else -math.inf
        progress(told)
        return told

    first = likelihood(np.zeros(len(names)))
    if not math.isfinite(first):
        raise HnavValueError(
            "option", "the plan itself has no likelihood: its run drops samples or fails, see hnav observe --data"
        )
    # What has no likelihood is far less likely than the plan itself.
    worst = first - 1e6

    def unlikelihood(logs: Any) -> float:
        return -max(likelihood(logs), worst)

    bounds = [(-_RANGE, _RANGE)] * len(names)
    count = sum(int(np.isfinite(values).sum()) for values in seen.values())
    stop: Any = {"eps": 0.02, "ftol": _ENOUGH / max(count, 1), "maxiter": 60}
    found = minimize(unlikelihood, np.zeros(len(names)), method="L-BFGS-B", bounds=bounds, options=stop)
    best, logs = -float(found.fun), np.asarray(found.x)
    factors = dict(zip(names, np.exp(logs).tolist()))
    tuned = _scaled(plan, factors)
    undetermined = [name for i, name in enumerate(names) if _is_flat(likelihood, logs, i, best)]
    run = Observer(tuned, options).run(t_s, seen, inputs)
    correlation = {name: _correlation(run.innovation[name], run.nis[name]) for name in run.nis}
    mean_nis = {name: float(np.nanmean(nis)) if np.isfinite(nis).any() else math.nan for name, nis in run.nis.items()}
    ahead = _ahead(tuned, t_s, seen, inputs, options)
    return Tuned(tuned, factors, (first, best), tuple(undetermined), correlation, mean_nis, ahead)


def _noises(plan: Plan) -> list[str]:
    kinds = {"state": plan.states, "unknown_input": plan.unknown_inputs, "parameter": plan.parameters}
    names = [f"sensor {name}" for name in plan.sensors]
    return names + [f"{kind} {name}" for kind, known in kinds.items() for name, told in known.items() if told.noise > 0]


def _scaled(plan: Plan, factors: Mapping[str, float]) -> Plan:
    made = plan.copy()
    for name, factor in factors.items():
        kind, variable = name.split(" ", 1)
        if kind == "sensor":
            made.sensors[variable] = replace(made.sensors[variable], noise=factor * made.sensors[variable].noise)
        else:
            known = {"state": made.states, "unknown_input": made.unknown_inputs, "parameter": made.parameters}[kind]
            known[variable] = replace(known[variable], noise=factor * known[variable].noise)
    return made


def _is_flat(likelihood: Callable[[Array], float], logs: Array, index: int, best: float) -> bool:
    for step in (-math.log(2), math.log(2)):
        moved = logs.copy()
        moved[index] += step
        if best - likelihood(moved) < _NATS:
            return True
    return False


def _correlation(innovation: Array, nis: Array) -> float:
    """The largest of the first LAGS autocorrelations of the normalised innovations, if it is beyond chance."""
    used = np.isfinite(nis)
    normal = np.copysign(np.sqrt(nis[used]), innovation[used])
    normal -= normal.mean() if len(normal) else 0.0
    power = float(normal @ normal)
    if len(normal) < 2 * LAGS or power == 0:
        return 0.0
    found = max((float(normal[lag:] @ normal[:-lag]) / power for lag in range(1, LAGS + 1)), key=abs)
    return found if abs(found) > _CHANCE / math.sqrt(len(normal)) else 0.0


def _ahead(
    plan: Plan, t_s: npt.ArrayLike, sensors: Mapping[str, Array], inputs: Mapping[str, npt.ArrayLike] | None, options: ObserverOptions | None
) -> dict[str, float]:  # fmt: skip
    """Mean NIS where every AHEADth sample is all that a sensor gives, its first AHEAD of them left to the start."""
    sparse = {}
    for name, values in sensors.items():
        there = np.flatnonzero(np.isfinite(values))
        sparse[name] = np.full(len(values), math.nan)
        sparse[name][there[::AHEAD]] = values[there[::AHEAD]]
    run = Observer(plan, options).run(t_s, sparse, inputs)
    usual = np.ones(len(run.t_s), bool)
    for one in findings(run, plan):
        if one.kind == "away":
            usual &= (run.t_s < one.start_s) | (run.t_s > one.end_s)
    used = {name: nis[np.isfinite(nis) & usual][AHEAD:] for name, nis in run.nis.items()}
    return {name: float(nis.mean()) if len(nis) else math.nan for name, nis in used.items()}
