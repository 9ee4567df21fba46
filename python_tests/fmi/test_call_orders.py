"""Model Exchange by the orders in which importers call: they differ in when inputs, states and parameters are written, and an
answer may depend on none of that. Each order is a row of a table and drives the same Runge-Kutta integrator, so answers are
compared bit for bit."""

import ctypes as C
import io
import zipfile
from dataclasses import dataclass

import numpy as np
import pytest

from hnav.fmi.fmus import Fmu, fmu_path

STOP_S = 0.3
KINDS = ("real", "integer", "boolean")


@dataclass(frozen=True)
class Order:
    """The order in which an importer writes its inputs. It always writes the values of that time."""

    parameters_in: str = ""  # "instantiated" or "initialization": all are written, with their start values
    inputs_in_initialization: bool = False
    inputs_in_continuous_time: tuple[str, ...] = ()  # of these types, before each evaluation of the derivatives
    inputs_at_end_of_step: bool = False
    inputs_in_event_mode: tuple[str, ...] = KINDS
    rhs: tuple[str, ...] = ("time", "states", "inputs")  # the order before an evaluation
    time_in_event_mode: bool = False  # set again there
    updates: int = 1  # of the discrete states at an event
    states_again: bool = False  # set to what they were, after each event and each step
    nominals: bool = False  # asked for after each event
    outputs_everywhere: bool = False  # read at each evaluation, in initialization too
    derivatives_in_initialization: bool = False  # directional ones, for algebraic loops
    rounds: int = 1  # simulations with the same instance, by terminate and reset


ORDERS = {
    "the standard's example": Order(),
    "PyFMI with Assimulo": Order(
        inputs_in_initialization=True, inputs_in_continuous_time=("real",), inputs_at_end_of_step=True, time_in_event_mode=True,
        nominals=True, outputs_everywhere=True,
    ),
    "OMSimulator": Order(
        inputs_in_initialization=True, inputs_in_continuous_time=("real",), inputs_in_event_mode=("integer", "boolean"),
        outputs_everywhere=True, derivatives_in_initialization=True, nominals=True,
    ),
    "Simulink": Order(
        parameters_in="instantiated", inputs_in_initialization=True, inputs_in_continuous_time=KINDS, inputs_in_event_mode=(),
        rhs=("time", "inputs", "states"), outputs_everywhere=True,
    ),
    "Dymola": Order(
        parameters_in="initialization", inputs_in_initialization=True, inputs_in_continuous_time=KINDS, inputs_at_end_of_step=True,
        rhs=("states", "time", "inputs"), updates=2, states_again=True,
    ),
    "wrappers of OpenModelica": Order(
        parameters_in="initialization", inputs_in_initialization=True, inputs_in_continuous_time=("real", "boolean"), updates=2,
        states_again=True, outputs_everywhere=True, rounds=2,
    ),
    "MapleSim": Order(
        parameters_in="instantiated", inputs_in_continuous_time=KINDS, rhs=("inputs", "time", "states"), time_in_event_mode=True,
        nominals=True, rounds=2,
    ),
}  # fmt: skip
FMUS = ("Hrekf", "Ahrs", "Turntable", "InsErrorFilterLateral", "AircraftInsLateral", "Pendulum", "Observer", "Ins", "Vehicle")


def example_input(name: str, version: int) -> tuple[list[str], np.ndarray]:
    """Names and rows of the signal in the archive, time first; without inputs a column of times."""
    with zipfile.ZipFile(fmu_path(name, version)) as archive:
        if "resources/example_input.csv" not in archive.namelist():
            return [], np.zeros((1, 1))
        text = archive.read("resources/example_input.csv").decode()
    return text.splitlines()[0].split(",")[1:], np.atleast_2d(np.loadtxt(io.StringIO(text), delimiter=",", skiprows=1))


class Importer:
    """Simulates an FMU in Model Exchange by one of the orders, with two Runge-Kutta steps between events."""

    def __init__(self, fmu: Fmu, order: Order, names: list[str], rows: np.ndarray, offers_derivatives: bool):
        self.fmu, self.order, self.names, self.rows = fmu, order, names, rows
        self.offers_derivatives = offers_derivatives
        variables = fmu.description.modelVariables
        self.parameters = [v for v in variables if v.causality == "parameter"]
        inputs = [v for v in variables if v.causality == "input"]
        self.inputs = {
            "real": [v for v in inputs if v.type in ("Real", "Float64")],
            "integer": [v for v in inputs if v.type in ("Integer", "Int32")],
            "boolean": [v for v in inputs if v.type == "Boolean"],
        }
        self.outputs = fmu.references(v.name for v in variables if v.causality == "output" and v.type in ("Real", "Float64"))
        self.nx = sum(v.derivative is not None for v in variables)
        self.f = fmu.fmu

    def read_outputs(self) -> list[float]:
        values = (C.c_double * len(self.outputs))()
        self.fmu.crossing("Get", "real", self.outputs, values)()
        return list(values)

    def write_parameters(self, mode: str) -> None:
        if self.order.parameters_in == mode:
            for v in self.parameters:
                self.fmu.set(v.name, v.start == "true" if v.type == "Boolean" else float(v.start) if "." in v.start or "e" in v.start
                             or v.type in ("Real", "Float64") else int(v.start))  # fmt: skip

    def write_inputs(self, t_s: float, kinds: tuple[str, ...]) -> None:
        row = self.rows[max(np.searchsorted(self.rows[:, 0], t_s + 1e-9, side="right") - 1, 0)]
        values = dict(zip(self.names, row[1:]))
        for kind in kinds:
            for v in self.inputs[kind]:
                start = v.start == "true" if kind == "boolean" else float(v.start)
                self.fmu.set(v.name, {"real": float, "integer": int, "boolean": bool}[kind](values.get(v.name, start)))

    def states(self) -> np.ndarray:
        x = (C.c_double * self.nx)()
        self.fmu.call(self.f.getContinuousStates, x, self.nx)
        return np.array(x)

    def set_states(self, x: np.ndarray) -> None:
        self.fmu.call(self.f.setContinuousStates, (C.c_double * self.nx)(*x), self.nx)

    def set_point(self, t_s: float, x: np.ndarray, inputs_s: float) -> None:
        steps = {
            "time": lambda: self.fmu.call(self.f.setTime, t_s),
            "states": lambda: self.set_states(x),
            "inputs": lambda: self.write_inputs(inputs_s, self.order.inputs_in_continuous_time),
        }
        for step in self.order.rhs:
            steps[step]()

    def derivatives(self, t_s: float, x: np.ndarray, inputs_s: float) -> np.ndarray:
        self.set_point(t_s, x, inputs_s)
        dx = (C.c_double * self.nx)()
        self.fmu.call(self.f.getContinuousStateDerivatives if self.fmu.fmi3 else self.f.getDerivatives, dx, self.nx)
        if self.order.outputs_everywhere:
            self.read_outputs()
        return np.array(dx)

    def runge_kutta(self, t_s: float, end_s: float, x: np.ndarray) -> np.ndarray:
        h = (end_s - t_s) / 2
        for t in (t_s, t_s + h):
            k1 = self.derivatives(t, x, t_s)
            k2 = self.derivatives(t + h / 2, x + h / 2 * k1, t_s)
            k3 = self.derivatives(t + h / 2, x + h / 2 * k2, t_s)
            k4 = self.derivatives(t + h, x + h * k3, t_s)
            x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        return x

    def event(self, t_s: float) -> tuple[np.ndarray, float]:
        """In event mode; answers the states after it and the time of the next event."""
        self.write_inputs(t_s, self.order.inputs_in_event_mode)
        if self.order.time_in_event_mode:
            self.fmu.call(self.f.setTime, t_s)
        for _ in range(self.order.updates):
            next_s = self.fmu.update_discrete_states()
        self.fmu.call(self.f.enterContinuousTimeMode)
        x = self.states()
        if self.order.states_again:
            self.set_states(x)
        if self.order.nominals:
            nominals = (C.c_double * self.nx)()
            self.fmu.call(self.f.getNominalsOfContinuousStates, nominals, self.nx)
            assert all(n > 0 for n in nominals)
        return x, STOP_S if next_s is None else next_s

    def initialise(self) -> None:
        self.write_parameters("instantiated")
        if self.fmu.fmi3:
            self.fmu.call(self.f.enterInitializationMode)
        else:
            self.fmu.call(self.f.setupExperiment)
            self.fmu.call(self.f.enterInitializationMode)
        self.write_parameters("initialization")
        if self.order.inputs_in_initialization:
            self.write_inputs(0.0, KINDS)
        if self.order.outputs_everywhere:
            self.read_outputs()
        if self.order.derivatives_in_initialization and self.inputs["real"] and self.offers_derivatives:
            known = [v.valueReference for v in self.inputs["real"]]
            slopes = self.fmu.call(self.f.getDirectionalDerivative, list(self.outputs), known, [1.0] * len(known))
            assert not np.any(slopes)
        self.fmu.call(self.f.exitInitializationMode)

    def simulate(self) -> list[float]:
        self.initialise()
        t_s = 0.0
        while True:
            x, next_s = self.event(t_s)
            end_s = min(next_s, STOP_S)
            x = self.runge_kutta(t_s, end_s, x)
            t_s = end_s
            # Before the event inputs jump to their values of this time: some importers write them before they enter event mode.
            self.set_point(t_s, x, t_s)
            if self.order.inputs_at_end_of_step:
                self.write_inputs(t_s, self.order.inputs_in_continuous_time)
            assert self.fmu.call(self.f.completedIntegratorStep) in ((0, 0), (False, False))
            if self.order.states_again:
                self.set_states(x)
            if t_s >= STOP_S - 1e-12:
                return self.read_outputs()
            self.fmu.call(self.f.enterEventMode)


def by_order(name: str, version: int, order: Order) -> list[float]:
    with Fmu(fmu_path(name, version), model_exchange=True) as fmu:
        importer = Importer(fmu, order, *example_input(name, version), name != "Observer")
        for _ in range(order.rounds):
            outputs = importer.simulate()
            fmu.call(fmu.fmu.terminate)
            fmu.call(fmu.fmu.reset)
        assert fmu.messages == []
    return outputs


@pytest.mark.parametrize("version", (2, 3), ids=lambda v: f"fmi{v}")
@pytest.mark.parametrize("name", FMUS)
@pytest.mark.parametrize("order", [name for name in ORDERS if name != "the standard's example"])
def test_the_order_of_calls_changes_no_bit(order, name, version):
    assert by_order(name, version, ORDERS[order]) == by_order(name, version, ORDERS["the standard's example"])
