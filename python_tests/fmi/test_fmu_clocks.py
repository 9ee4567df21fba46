"""Triggered clocks of FMI 3: a sensor's sample is a tick, not a held value. The estimates are those of the archives whose samples
are told by counters, bit for bit."""

import math

import numpy as np
import pytest

from hnav.fmi.fmus import Fmu, fmu_path
from importing import assert_fits_the_standard

CLOCKED = ("AhrsClocks", "InsClocks", "ImuMagSensorClocks", "GnssClocks", "BaroClocks", "WheelClocks")
STEP_S = 0.01
STEPS = 800
# Periods of the sensors in steps: several tick at one instant, and not always the same ones.
PERIODS = {
    "Ahrs": {"gyro": 1, "accel": 2, "mag": 5},
    "Ins": {"accel": 1, "gyro": 1, "gnss": 20, "gnssvel": 10, "baro": 4},
}


def members(fmu: Fmu, sensor: str) -> list[str]:
    """Inputs of a sensor that are numbers, without what marks a sample."""
    names = [n for n, v in fmu.variables.items() if v.causality == "input" and n.startswith(sensor + ".") and v.type == "Float64"]
    return [n for n in names if not n.endswith(".t_meas")]


def sample(fmu: Fmu, sensor: str, k: int) -> dict[str, float]:
    """Of a body that turns to and fro about its vertical at one place; any other number is the input's start value."""
    turn = 0.3 * math.sin(0.7 * STEP_S * k)
    values = {name: float(fmu.variables[name].start) for name in members(fmu, sensor)}
    given = {
        "gyro.rate[3]": 0.21 * math.cos(0.7 * STEP_S * k), "accel.force[3]": -9.80665 + 1e-3 * math.sin(k),
        "mag.field[1]": 2e-5 * math.cos(turn), "mag.field[2]": -2e-5 * math.sin(turn), "mag.field[3]": 4.5e-5,
        "gnss.latitude": 0.8, "gnss.longitude": 0.2, "gnss.height": 400 + math.sin(3.0 * k), "gnssvel.velocity[1]": 0.1 * math.cos(2.0 * k),
        "baro.pressure": 96600.0 + math.sin(k),
    }  # fmt: skip
    return values | {name: value for name, value in given.items() if name in values}


class Estimates:
    """A filter and what it answers, read after each step."""

    def __init__(self, fmu: Fmu, names: list[str]):
        self.fmu, self.names, self.rows = fmu, names, []

    def read(self) -> None:
        self.rows.append([self.fmu.get(name) for name in self.names])


def outputs(name: str) -> list[str]:
    """All but what it cost to compute them."""
    with Fmu(fmu_path(name, 3)) as scalar:
        return [n for n, v in scalar.variables.items() if v.causality == "output" and not n.startswith("solver.")]


def by_counters(name: str) -> np.ndarray:
    with Fmu(fmu_path(name, 3)) as fmu:
        fmu.set("sampling_mode", "counter")
        fmu.initialise()
        seen = Estimates(fmu, outputs(name))
        for sensor in PERIODS[name]:
            fmu.set(f"{sensor}.valid", True)
        for k in range(STEPS):
            for sensor, period in PERIODS[name].items():
                if k % period == 0:
                    for member, value in sample(fmu, sensor, k).items():
                        fmu.set(member, value)
                    fmu.set(f"{sensor}.t_meas", STEP_S * k)
                    fmu.set(f"{sensor}.sample", k // period + 1)
            fmu.do_step(STEP_S * k, STEP_S)
            seen.read()
        return np.array(seen.rows, dtype=float)


def by_clocks(name: str, together: bool) -> tuple[np.ndarray, int]:
    """together: all sensors of an instant tick in one iteration, else each in one of its own. Also how often the estimate was corrected."""
    with Fmu(fmu_path(name + "Clocks", 3), events=True) as fmu:
        fmu.initialise()
        seen, corrected = Estimates(fmu, outputs(name)), 0
        for k in range(STEPS):
            if k > 0:
                fmu.call(fmu.fmu.enterEventMode)
            due = [sensor for sensor, period in PERIODS[name].items() if k % period == 0]
            for sensors in [due] if together else [[sensor] for sensor in due]:
                fmu.tick(f"{sensor}.tick" for sensor in sensors)
                for sensor in sensors:
                    for member, value in sample(fmu, sensor, k).items():
                        fmu.set(member, value)
                    fmu.set(f"{sensor}.t_meas", STEP_S * k)
                assert fmu.iterate()
            while fmu.iterate():
                corrected += fmu.ticks("correction")
            fmu.call(fmu.fmu.enterStepMode)
            fmu.do_step(STEP_S * k, STEP_S)
            seen.read()
        return np.array(seen.rows, dtype=float), corrected


@pytest.mark.parametrize("name", CLOCKED)
def test_archives_with_clocks_fit_the_standard(name):
    assert_fits_the_standard(fmu_path(name, 3), 3)


@pytest.mark.parametrize("together", [True, False])
@pytest.mark.parametrize("name", PERIODS)
def test_ticks_and_counters_give_the_same_bits(name, together):
    expected, (found, corrected) = by_counters(name), by_clocks(name, together)
    np.testing.assert_array_equal(found, expected)
    assert np.ptp(expected, axis=0).max() > 0 and corrected > STEPS / 50
