"""The panel of the report about sensors that were not ok: a band for each, coloured and named by what was wrong."""

from __future__ import annotations

import numpy as np

from hnav.filters.filter_answers import HEALTH_SENSORS, SENSOR_STATES
from hnav.filters.health import Finding, findings, spells
from hnav.reports.colours import STATE_COLOURS
from hnav.reports.graphs import go
from hnav.reports.panels import bars, blocks, lay_out_bars, panel
from hnav.systems.results import Run
from hnav.systems.run_views import Estimate, estimates

ROW_PX = 34
BLOCKS = 2000


def _found(estimate: Estimate) -> list[Finding]:
    return [] if estimate.health is None else findings(estimate.run.t_s, estimate.health)


def was_not_ok(run: Run) -> bool:
    """Whether any filter found any sensor other than ok."""
    return any(_found(estimate) for estimate in estimates(run))


def lines(run: Run) -> list[str]:
    """One for each finding."""
    return [f"{estimate.name}: {finding}" for estimate in estimates(run) for finding in _found(estimate)]


@panel("health", "Health of the sensors", "What each filter took its sensors for, where that was not ok. Samples that are outliers, stuck or "
       "saturated are left out; those of a gyroscope are used, outliers apart, and sigma grows by what they may have missed.", was_not_ok, lines)  # fmt: skip
def health_panel(run: Run) -> go.Figure:
    figure, rows = go.Figure(), []
    named: set[str] = set()
    for estimate in estimates(run):
        for sensor in dict.fromkeys(finding.sensor for finding in _found(estimate)):
            rows.append(f"{estimate.name}  {sensor}")
            assert estimate.health is not None, "findings need a health record"
            _draw(figure, rows[-1], run.t_s, estimate.health[:, HEALTH_SENSORS.index(sensor)], named)
    lay_out_bars(figure, rows, 130 + ROW_PX * len(rows))
    return figure


def _draw(figure: go.Figure, row: str, t_s: np.ndarray, states: np.ndarray, named: set[str]) -> None:
    # The worst state of each block, so that decimation hides no single row.
    starts = blocks(len(t_s), BLOCKS)
    drawn = list(spells(t_s[starts], np.maximum.reduceat(states, starts)))
    for state in SENSOR_STATES[1:]:
        begins = np.array([begin for name, begin, _ in drawn if name == state])
        ends = np.array([end for name, _, end in drawn if name == state])
        if len(begins):
            legend = dict(name=state, legendgroup=state, showlegend=state not in named)
            figure.add_trace(bars(row, state, STATE_COLOURS[state], begins, ends, 2, **legend))
            named.add(state)
