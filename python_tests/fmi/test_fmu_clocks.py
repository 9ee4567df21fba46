"""Triggered clocks of FMI 3: a sensor's sample is a tick, not a held value. The estimates are those of the archives whose samples
are marked by counters, bit for bit."""

import math

import numpy as np
import pytest

from hnav.errors import HnavError
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
    """Numeric inputs of a sensor, without the clock or flag that marks a sample."""
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
    """A filter and its outputs, read after each step."""

    def __init__(self, fmu: Fmu, names: list[str]):
        self.fmu, self.names, self.rows = fmu, names, []

    def read(self) -> None:
        self.rows.append([self.fmu.get(name) for name in self.names])


def outputs(name: str) -> list[str]:
    """All outputs except the counters of computing cost."""
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


# --------------------------------------------------------------------------------------------- sensor and filter, event by event

SENSORS = ("gyro", "accel", "mag")
WIRES = {
    "gyro": [*(f"gyro.rate[{i}]" for i in (1, 2, 3)), "gyro.t_meas"],
    "accel": [*(f"accel.force[{i}]" for i in (1, 2, 3)), "accel.t_meas"],
    "mag": [*(f"mag.field[{i}]" for i in (1, 2, 3)), "mag.t_meas"],
}
TRUTH = [f"truth.{name}[{i}]" for name, n in (("q", 4), ("rate", 3), ("force", 3), ("field", 3)) for i in range(1, n + 1)]
POSTERIOR = ["post.t", *(f"post.q[{i}]" for i in range(1, 5)), *(f"post.sigma[{i}]" for i in range(1, 7))]
PARAMETERS = {"gyro.period_s": 0.01, "accel.period_s": 0.02, "mag.period_s": 0.05, "mag.latency_s": 0.013}
END_S = 4.0


def carry(source: Fmu, target: Fmu, names: list[str]) -> None:
    for name in names:
        target.set(name, source.get(name))


def by_held_values() -> list[list[float]]:
    """Posteriors, by a fixed step and counters."""
    rows = []
    with Fmu(fmu_path("Turntable", 3)) as table, Fmu(fmu_path("ImuMagSensor", 3)) as sensor, Fmu(fmu_path("Ahrs", 3)) as ahrs:
        for name, value in PARAMETERS.items():
            sensor.set(name, value)
        ahrs.set("sampling_mode", "counter")
        for fmu in (table, sensor, ahrs):
            fmu.initialise()
        step_s = 0.001  # meets each sample and each delivery
        for k in range(round(END_S / step_s) + 30):
            t_s = k * step_s
            carry(table, sensor, TRUTH)
            sensor.do_step(t_s, step_s)
            for name in SENSORS:
                carry(sensor, ahrs, [*WIRES[name], f"{name}.sample"])
            ahrs.do_step(t_s, step_s)
            table.do_step(t_s, step_s)
            rows.append([ahrs.get(name) for name in POSTERIOR])
    return rows


def at_event(sensor: Fmu, ahrs: Fmu) -> None:
    """The iterations of one instant: FMI 3.0.2, section 2.2.8."""
    again = True
    while again:
        ticking = [name for name in SENSORS if sensor.ticks(f"{name}.tick")]
        ahrs.tick(f"{name}.tick" for name in ticking)
        for name in ticking:
            carry(sensor, ahrs, WIRES[name])
        again = any([sensor.iterate(), ahrs.iterate()])


def by_events() -> list[list[float]]:
    """Posteriors: no step is longer than to the next sample or delivery, and each is an event."""
    rows, t_s = [], 0.0
    with (
        Fmu(fmu_path("Turntable", 3)) as table,
        Fmu(fmu_path("ImuMagSensorClocks", 3), events=True) as sensor,
        Fmu(fmu_path("AhrsClocks", 3), events=True) as ahrs,
    ):
        for name, value in PARAMETERS.items():
            sensor.set(name, value)
        for fmu in (table, sensor, ahrs):
            fmu.initialise()
        while t_s < END_S:
            carry(table, sensor, TRUTH)
            at_event(sensor, ahrs)
            for fmu in (sensor, ahrs):
                fmu.call(fmu.fmu.enterStepMode)
            event, _, early, end_s = sensor.call(sensor.fmu.doStep, t_s, 0.1)  # returns early where something is due
            assert event and early
            for fmu in (table, ahrs):
                fmu.do_step(t_s, end_s - t_s)
            t_s = end_s
            rows.append([ahrs.get(name) for name in POSTERIOR])
            for fmu in (sensor, ahrs):
                fmu.call(fmu.fmu.enterEventMode)
    return rows


def test_a_master_of_events_finds_what_a_master_of_held_values_finds():
    held, events = ({round(row[0], 6): row for row in rows if row[0] > 0} for rows in (by_held_values(), by_events()))
    common = sorted(held.keys() & events.keys())
    assert len(common) > 250
    # Each master adds up steps of its own, so instants differ in last bits and the truth with them.
    np.testing.assert_allclose([held[t] for t in common], [events[t] for t in common], rtol=1e-9, atol=1e-12)


def test_without_event_mode_a_filter_with_clocks_warns():
    with Fmu(fmu_path("AhrsClocks", 3)) as fmu:
        fmu.initialise()
        assert "eventModeUsed" in fmu.messages[-1]


def test_clocks_are_named_where_they_are_none_or_not_to_be_set():
    with Fmu(fmu_path("AhrsClocks", 3), events=True) as fmu:
        fmu.initialise()
        for name, message in (("correction", "correction is no input clock"), ("gyro.rate[1]", "is real, not a clock")):
            with pytest.raises(HnavError, match=message):
                fmu.tick([name])
        fmu.tick(["gyro.tick", "gyro.tick"])
        assert fmu.ticks("gyro.tick") and not fmu.ticks("mag.tick")
        fmu.iterate()
        assert not fmu.ticks("gyro.tick")
