"""Noises of a plan, and offsets of its sensors, from a recording: those that make its samples most likely.

    tuned = tune(plan, t_s, {"x": y})
    tuned.plan, tuned.offsets, tuned.undetermined, tuned.ahead_nis

L-BFGS on the likelihood of the innovations, from the noises of the plan to the maximum next to them: a larger one far away may explain by one
noise what the plan means another for. The logarithms of the noises have a wide Gaussian around the plan's, so that a noise that the samples do
not determine stays there. The likelihood determines how large noises are; prediction over several samples and white innovations say whether the
model is right.
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
from hnav.filters.observer import Observer, ObserverOptions, ObserverRun
from hnav.filters.observer_findings import findings
from hnav.filters.observer_offsets import offsets, with_offsets
from hnav.filters.observer_plan import Plan
from hnav.native.arrays import Array
from hnav.numbers import floats

AHEAD = 10  # samples that a prediction goes ahead
LAGS = 5  # innovations after one, that it must not foretell
_CHANCE = 4.0  # sigmas of a correlation
_RANGE = math.log(1e4)  # of a factor
_PRIOR = math.log(10)  # sigma of the logarithm of a factor, before the samples
_STEP = 0.01  # of a logarithm, for differences
_ENOUGH = 0.05  # nats, about: what a further step has to bring
_ITERATIONS, _ROUNDS = 60, 3
_UNDETERMINED = 0.35  # sigma of a logarithm: half or twice of the noise costs less than 2 nats


@dataclass(frozen=True)
class Tuned:
    """A plan whose noises fit a recording."""

    plan: Plan
    """With the noises and offsets found; otherwise as given."""
    factors: dict[str, float]
    """By which each noise was multiplied: "sensor x", "state v", ..."""
    offsets: dict[str, float]
    """By sensor, where the samples determine another one than that of the plan: what is to be added to its samples, in its own unit."""
    log_likelihood: tuple[float, float]
    """Before and after, of all samples."""
    undetermined: tuple[str, ...]
    """Noises that the samples do not determine: half or twice is about as likely, if the others follow."""
    correlation: dict[str, float]
    """By sensor: the largest correlation of an innovation with one of the next LAGS, 0 where chance explains it."""
    mean_nis: dict[str, float]
    """By sensor, of all innovations with the noises found; 1 where their size is as stated."""
    predicted_nis: dict[str, Array]
    """By sensor: NIS of predictions over AHEAD samples, without the intervals that findings reports."""

    @property
    def ahead_nis(self) -> dict[str, float]:
        """By sensor: the mean of predicted_nis, NaN where there is none. Far from 1: the model is wrong, not its noise."""
        return {name: float(nis.mean()) if len(nis) else math.nan for name, nis in self.predicted_nis.items()}

    @property
    def predictions(self) -> dict[str, int]:
        """By sensor: number of these predictions."""
        return {name: len(nis) for name, nis in self.predicted_nis.items()}


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
    seen = {name: floats(values) for name, values in sensors.items()}

    given = plan

    def run_at(logs: Array) -> ObserverRun | None:
        run = _run(_scaled(given, dict(zip(names, np.exp(logs)))), t_s, seen, inputs, options)
        progress(-math.inf if run is None else _likelihood(run))
        return run

    first = run_at(np.zeros(len(names)))
    if first is None:
        raise HnavValueError(
            "option", "the plan itself has no likelihood: its run drops samples or fails, see hnav observe --data"
        )
    logs, run, found, information = np.zeros(len(names)), first, dict[str, float](), np.eye(len(names))
    for _ in range(_ROUNDS):
        # An offset that is left in looks like noise, and beside much noise it does not stand out.
        more = offsets(
            run, _scaled(given, dict(zip(names, np.exp(logs)))), lambda changed: _run(changed, t_s, seen, inputs, options)
        )
        if more:
            found |= more
            given = with_offsets(plan, found)
            run = run_at(logs) or run
        elif run is not first:
            break
        logs, run, information = _most_likely(run_at, logs, run)
    factors = dict(zip(names, np.exp(logs).tolist()))
    tuned = _scaled(given, factors)
    sigma = np.sqrt(np.diag(np.linalg.inv(information)))
    undetermined = tuple(name for name, one in zip(names, sigma) if one > _UNDETERMINED)
    correlation = {name: _correlation(run.innovation[name], run.nis[name]) for name in run.nis}
    mean_nis = {name: float(np.nanmean(nis)) if np.isfinite(nis).any() else math.nan for name, nis in run.nis.items()}
    predicted = _ahead(tuned, t_s, seen, inputs, options)
    likelihoods = _likelihood(first), _likelihood(run)
    return Tuned(tuned, factors, found, likelihoods, undetermined, correlation, mean_nis, predicted)


def _run(
    plan: Plan, t_s: npt.ArrayLike, seen: Mapping[str, Array], inputs: Mapping[str, npt.ArrayLike] | None, options: ObserverOptions | None
) -> ObserverRun | None:  # fmt: skip
    """None: the samples have no likelihood."""
    try:
        run = Observer(plan, options).run(t_s, seen, inputs)
    except HnavError:
        return None
    return run if run.dropped == 0 and math.isfinite(_likelihood(run)) else None


def _likelihood(run: ObserverRun) -> float:
    return float(np.nansum(run.log_likelihood))


def _posterior(run: ObserverRun, logs: Array) -> float:
    return _likelihood(run) - 0.5 * float(logs @ logs) / _PRIOR**2


def _most_likely(
    run_at: Callable[[Array], ObserverRun | None], logs: Array, run: ObserverRun
) -> tuple[Array, ObserverRun, Array]:  # fmt: skip
    """Logarithms of the factors, their run and the information about them."""
    # What has no likelihood is far less likely than the beginning.
    worst, best = _posterior(run, logs) - 1e6, (logs, run)

    def unlikely(at: Array) -> tuple[float, Array]:
        nonlocal best
        tried = run_at(at)
        if tried is None:
            return -worst, np.zeros(len(at))
        if _posterior(tried, at) > _posterior(best[1], best[0]):
            best = at.copy(), tried
        return -_posterior(tried, at), -_score(run_at, at, tried)[0]

    stop: Any = {"ftol": _ENOUGH / max(int(np.isfinite(run.log_likelihood).sum()), 1), "maxiter": _ITERATIONS}
    minimize(unlikely, logs, jac=True, method="L-BFGS-B", bounds=[(-_RANGE, _RANGE)] * len(logs), options=stop)
    return *best, _score(run_at, *best)[1]


def _score(run_at: Callable[[Array], ObserverRun | None], logs: Array, run: ObserverRun) -> tuple[Array, Array]:
    """Gradient of the posterior by the logarithms, and its information: squares of the scores of the rows, divided by those of the
    mean NIS where innovations are larger than stated."""
    rows = []
    for k in range(len(logs)):
        step, other = _STEP, run_at(logs + _STEP * np.eye(len(logs))[k])
        if other is None:
            step, other = -_STEP, run_at(logs - _STEP * np.eye(len(logs))[k])
        rows.append(np.zeros(len(run.t_s)) if other is None else (other.log_likelihood - run.log_likelihood) / step)
    scores = np.nan_to_num(np.array(rows))
    size = max(1.0, float(np.nanmean(np.concatenate([*run.nis.values()]))))
    return scores.sum(axis=1) - logs / _PRIOR**2, scores @ scores.T / size**2 + np.eye(len(logs)) / _PRIOR**2


def _noises(plan: Plan) -> list[str]:
    """Kind and name of each, such as "sensor x"; a plan has the dictionaries sensors, states, ..."""
    kinds = {"state": plan.states, "unknown_input": plan.unknown_inputs, "parameter": plan.parameters}
    names = [f"sensor {name}" for name in plan.sensors]
    return names + [f"{kind} {name}" for kind, known in kinds.items() for name, told in known.items() if told.noise > 0]


def _scaled(plan: Plan, factors: Mapping[str, float]) -> Plan:
    made = plan.copy()
    for name, factor in factors.items():
        kind, variable = name.split(" ", 1)
        known = getattr(made, f"{kind}s")
        known[variable] = replace(known[variable], noise=factor * known[variable].noise)
    return made


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
) -> dict[str, Array]:  # fmt: skip
    """NIS where every AHEADth sample is all that a sensor gives, its first AHEAD of them left to the start."""
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
    return {name: nis[np.isfinite(nis) & usual][AHEAD:] for name, nis in run.nis.items()}
