"""The systems in OMSimulator, as shipped: its numbers are those of hnav simulate."""

import math

import numpy as np
import pytest

from hnav.systems.simulation import simulate
from hnav.systems.ssp_reader import system_path
from importers import run_omsimulator

FEW, REST = ("turntable", "filter"), ("observer", "navigation", "gyrocompass", "aircraft")
STOP_S, AT_S = 10.0, 9.0
"""Not at the stop: the sum of its steps falls short of it, and a last one of 1e-13 s brings the sample that is due there."""


@pytest.mark.parametrize("name", [*FEW, *(pytest.param(name, marks=pytest.mark.slow) for name in REST)])
def test_omsimulator_opens_the_system_as_shipped_and_goes_the_way_of_hnav(name, tmp_path):
    ends = run_omsimulator(system_path(name), tmp_path, AT_S, f"--stopTime={STOP_S:g}")
    run = simulate(name, stop_s=STOP_S, record=("*",))
    assert not run.about["failure"]
    at, compared = int(np.argmin(abs(run.t_s - AT_S))), 0
    for column, values in run.columns.items():
        end = ends.get(f"{name}.{name}.{column}")
        if end is None or math.isnan(values[at]):
            continue
        assert end == pytest.approx(values[at], rel=1e-8, abs=1e-8 * max(1e-6, abs(values).max())), column
        compared += 1
    assert compared > 20
