"""Every archive that PyFMI can run, with its defaults: no error, the end of the experiment, finite ends. Its master goes the way of ours."""

import math

import numpy as np
import pytest

from checkout import built_system
from hnav.fmi.fmus import fmu_path
from hnav.systems.simulation import simulate
from hnav.systems.ssp_reader import read_system
from importers import pyfmi_state_space, run_pyfmi, run_pyfmi_master

COUPLED = ("Ahrs", "Hrekf", "Ins", "Turntable", "Vehicle", "Pendulum", "Observer")
SAMPLED = ("ImuMagSensor", "Gnss", "Baro", "Wheel")
FEW = (("Ahrs", 2, "CS"), ("Turntable", 2, "ME"))
REST = [
    *((name, 2, kind) for name in COUPLED for kind in ("CS", "ME") if (name, 2, kind) not in FEW),
    *((name, 2, "CS") for name in SAMPLED),
    *((name, 3, "ME") for name in COUPLED),
]


@pytest.mark.parametrize(
    ("name", "version", "kind"),
    [*(pytest.param(*case) for case in FEW), *(pytest.param(*case, marks=pytest.mark.slow) for case in REST)],
)
def test_pyfmi_runs_it_with_its_defaults(name, version, kind, tmp_path):
    answer = run_pyfmi(fmu_path(name, version), kind, tmp_path)
    assert answer["errors"] == [] and answer["t_s"] > 0
    assert [output for output, end in answer["ends"].items() if math.isinf(end)] == []
    if name in ("Ahrs", "Hrekf"):  # 500 steps over the experiment, whatever the sensors' periods; a level body that points north
        assert answer["ends"].get("count.missed", 0) == 0 and answer["ends"].get("align.started", 1) == 1
        assert max(abs(answer["ends"][f"att.euler[{i}]"]) for i in (1, 2, 3)) < 1e-6


STOP_S, AT_S = 10.0, 9.0
LOOP, SEEN = ("turntable", "sensor", "ahrs"), ("ahrs.att.euler[1]", "ahrs.att.euler[2]", "ahrs.att.euler[3]")
STEPS = {"fixed": {"step_size": 0.01}, "error_controlled": {"error_controlled": True, "maxh": 0.01}}


@pytest.mark.parametrize("steps", STEPS)
def test_a_loop_that_pyfmi_couples_ends_in_the_attitude_of_hnav(steps, tmp_path):
    with read_system(built_system("turntable")) as system:
        answer = run_pyfmi_master(system, LOOP, SEEN, tmp_path, STOP_S, **STEPS[steps])
    run = simulate("turntable", stop_s=STOP_S, record=SEEN)
    assert answer["errors"] == []
    for output in SEEN:
        found, expected = np.interp(AT_S, answer["t_s"], answer["columns"][output]), np.interp(AT_S, run.t_s, run[output])
        assert abs(math.degrees(math.remainder(found - expected, 2 * math.pi))) < 0.01


@pytest.mark.parametrize(
    "name", ["Observer", *(pytest.param(name, marks=pytest.mark.slow) for name in COUPLED if name != "Observer")]
)
def test_pyfmi_makes_a_state_space_of_it(name, tmp_path):
    """Where the archive offers no derivatives, as Observer and Vehicle, PyFMI takes differences of the values that it gets by reference."""
    answer = pyfmi_state_space(fmu_path(name, 2), tmp_path)
    A, differences = np.array(answer["A"]), np.array(answer["differences"])
    # It reads counts as reals on its way, which is refused.
    assert [line for line in answer["errors"] if "is integer, not real" not in line] == []
    assert A.shape == differences.shape and np.isfinite(A).all() and A.size > 0
    np.testing.assert_allclose(A, differences, rtol=1e-4, atol=1e-5)
