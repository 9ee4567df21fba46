"""Sensors of a run that read too much or too little in the median, where following this advice confirms it.

offsets(run, plan, lambda changed: Observer(changed).run(t_s, {"x": y}))
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from hnav.filters.observer import ObserverRun
from hnav.filters.observer_plan import Plan

_FEW = 100  # samples, of which a median is uncertain
_MATTERS = 0.3  # in sigmas of the sensor
_SURE = 5.0  # in sigmas of a mean
_GAIN = 5.0  # nats that the changed plan has to bring


def with_offsets(plan: Plan, offsets: Mapping[str, float]) -> Plan:
    """The plan with these offsets of sensors, in their own units."""
    made = plan.copy()
    for name, own in offsets.items():
        sensor = made.sensors[name]
        more = sensor.factor * (own - sensor.own_offset)
        made.sensors[name] = replace(sensor, own_offset=own, offset=sensor.offset + more)
    return made


def offsets(run: ObserverRun, plan: Plan, follow: Callable[[Plan], ObserverRun | None]) -> dict[str, float]:
    """By sensor: the offset for its table, where its median innovation asks for another one than that of the plan.

    follow: a run of a changed plan, None if it fails. An offset is named only if, in the run with it, the innovations have lost half of the
    median or more and the samples are more likely: what another run would take back is an error of the model.
    """
    medians = {name: median for name, median in _medians(run).items() if _stands_out(run, plan, name, median)}
    while medians:
        found = {name: plan.sensors[name].own_offset - median for name, median in medians.items()}
        other = follow(with_offsets(plan, found))
        if other is None or not np.nansum(other.log_likelihood) > np.nansum(run.log_likelihood) + _GAIN:
            return {}
        after = _medians(other)
        confirmed = {name: median for name, median in medians.items() if abs(after[name]) < 0.5 * abs(median)}
        if len(confirmed) == len(medians):
            return found
        medians = confirmed
    return {}


def _medians(run: ObserverRun) -> dict[str, float]:
    used = {name: innovation[np.isfinite(innovation)] for name, innovation in run.innovation.items()}
    return {name: float(np.median(values)) for name, values in used.items() if len(values) >= _FEW}


def _stands_out(run: ObserverRun, plan: Plan, name: str, median: float) -> bool:
    used = run.innovation[name][np.isfinite(run.innovation[name])]
    limit: float = max(_MATTERS * plan.sensors[name].noise, _SURE * float(used.std()) / np.sqrt(len(used)))
    return abs(median) > limit
