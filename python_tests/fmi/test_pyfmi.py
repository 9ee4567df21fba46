"""Every archive that PyFMI can run, with its defaults: no error, the end of the experiment, finite ends."""

import math

import pytest

from hnav.fmi.fmus import fmu_path
from importers import run_pyfmi

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
