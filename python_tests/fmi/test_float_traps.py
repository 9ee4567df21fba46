"""Hosts that trap invalid operations, as programs in Fortran do: to the FMUs NaN is a sample that is missing."""

import subprocess
import sys

import pytest

STEPS = """
import ctypes, sys
from hnav.fmi.fmus import Fmu, fmu_path
with Fmu(fmu_path(sys.argv[1], int(sys.argv[2]))) as fmu:
    fmu.initialise()
    numbers = [name for name, of in fmu.variables.items() if of.causality == "output" and of.type in ("Real", "Float64")]
    libm = ctypes.CDLL("libm.so.6")
    invalid, divided, overflown = 1, 4, 8
    libm.feenableexcept(invalid | divided | overflown)
    for k in range(200):
        fmu.do_step(0.01 * k, 0.01)
        for name in numbers:
            fmu.get(name)
    traps = libm.fegetexcept()
    libm.fedisableexcept(traps)
print(traps)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="skipped where glibc is not: it can trap")
@pytest.mark.parametrize("name", ["Ahrs", "Hrekf", "Ins", "Vehicle"])
@pytest.mark.parametrize("version", [2, 3])
def test_a_host_that_traps_invalid_operations_is_not_stopped(name, version):
    """And its traps are as they were after every call. Without the mask three of these end by a signal."""
    ended = subprocess.run([sys.executable, "-c", STEPS, name, str(version)], capture_output=True, text=True)
    assert ended.returncode == 0, ended.stderr[-500:]
    assert ended.stdout.split() == [str(1 | 4 | 8)]
