"""The capabilities that an archive declares: every capability of every archive is called, and derivatives are compared with differences."""

import ctypes as C
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from hnav.errors import HnavError
from hnav.fmi.fmus import Fmu, fmu_path

FOLDERS = {version: fmu_path("Ahrs", version).parent for version in (2, 3)}
ARCHIVES = [
    pytest.param(path, id=f"fmi{version}-{path.stem}")
    for version, folder in FOLDERS.items()
    for path in sorted(folder.glob("*.fmu"))
]
REAL = ("Real", "Float64")


def size(fmu: Fmu, variables) -> int:
    """Numbers of them, arrays and all."""
    return sum(int(np.prod([int(d.start) for d in v.dimensions])) if v.dimensions else 1 for v in variables)


def reals(fmu: Fmu, variables) -> np.ndarray:
    references, n = [v.valueReference for v in variables], size(fmu, variables)
    return np.array(fmu.call(fmu.fmu.getFloat64, references, n) if fmu.fmi3 else fmu.call(fmu.fmu.getReal, references))


def set_reals(fmu: Fmu, variables, values) -> None:
    fmu.call(fmu.fmu.setFloat64 if fmu.fmi3 else fmu.fmu.setReal, [v.valueReference for v in variables], list(values))


def outputs_of(fmu: Fmu) -> list:
    return [u.variable for u in fmu.description.outputs if u.variable.type in REAL and not u.variable.clocks]


class Flowing:
    """An FMU in Model Exchange, past its first event and in continuous-time mode."""

    def __init__(self, fmu: Fmu):
        self.fmu, f = fmu, fmu.fmu
        if "start.start_samples" in fmu.variables:
            fmu.set("start.start_samples", 1)  # derivatives are those of a filter that has started
        fmu.initialise()
        fmu.update_discrete_states()
        fmu.call(f.enterContinuousTimeMode)
        self.rates = [u.variable for u in fmu.description.derivatives]
        self.states = [v.derivative for v in self.rates]
        self.nx = size(fmu, self.states)
        self.outputs = outputs_of(fmu)
        self.unknowns = [*self.rates, *self.outputs]

    def x(self) -> np.ndarray:
        values = (C.c_double * self.nx)()
        self.fmu.call(self.fmu.fmu.getContinuousStates, values, self.nx)
        return np.array(values)

    def set_x(self, x: np.ndarray) -> None:
        self.fmu.call(self.fmu.fmu.setContinuousStates, (C.c_double * self.nx)(*x), self.nx)

    def dx(self) -> np.ndarray:
        values = (C.c_double * self.nx)()
        f = self.fmu.fmu
        self.fmu.call(f.getContinuousStateDerivatives if self.fmu.fmi3 else f.getDerivatives, values, self.nx)
        return np.array(values)

    def along(self, seed: np.ndarray) -> np.ndarray:
        f, n = self.fmu.fmu, size(self.fmu, self.unknowns)
        unknowns, knowns = [v.valueReference for v in self.unknowns], [v.valueReference for v in self.states]
        if not self.fmu.fmi3:
            return np.array(self.fmu.call(f.getDirectionalDerivative, unknowns, knowns, list(seed)))
        references = [(C.c_uint32 * len(r))(*r) for r in (unknowns, knowns)]
        found = (C.c_double * n)()
        self.fmu.call(
            f.fmi3GetDirectionalDerivative, f.component, references[0], len(unknowns), references[1], len(knowns),
            (C.c_double * self.nx)(*seed), self.nx, found, n,
        )  # fmt: skip
        return np.array(found)

    def adjoint(self, seed: np.ndarray) -> np.ndarray:
        f = self.fmu.fmu
        unknowns, knowns = [v.valueReference for v in self.unknowns], [v.valueReference for v in self.states]
        references = [(C.c_uint32 * len(r))(*r) for r in (unknowns, knowns)]
        found = (C.c_double * self.nx)()
        self.fmu.call(
            f.fmi3GetAdjointDerivative, f.component, references[0], len(unknowns), references[1], len(knowns),
            (C.c_double * len(seed))(*seed), len(seed), found, self.nx,
        )  # fmt: skip
        return np.array(found)


def declared(path: Path, interface: str, *spellings: str) -> bool | None:
    """A capability under any of its names; None: the archive does not have the interface."""
    with zipfile.ZipFile(path) as archive:
        names = {name.removeprefix("./"): name for name in archive.namelist()}
        element = ElementTree.fromstring(archive.read(names["modelDescription.xml"])).find(interface)
    return None if element is None else any(element.get(name) == "true" for name in spellings)


DIRECTIONAL = ("providesDirectionalDerivative", "providesDirectionalDerivatives")
MODEL_EXCHANGE = [a for a in ARCHIVES if declared(a.values[0], "ModelExchange") is not None]


@pytest.mark.parametrize("path", ARCHIVES)
def test_value_references_are_the_places_of_the_variables(path: Path):
    with Fmu(path) as fmu:
        assert [v.valueReference for v in fmu.description.modelVariables] == list(range(1, len(fmu.variables) + 1))


@pytest.mark.parametrize("path", MODEL_EXCHANGE)
def test_derivatives_are_differences_where_they_are_declared_and_refused_elsewhere(path: Path):
    with Fmu(path, model_exchange=True) as fmu:
        at = Flowing(fmu)
        if not declared(path, "ModelExchange", *DIRECTIONAL):
            with pytest.raises(HnavError, match="offers no directional derivatives"):
                at.along(np.ones(at.nx))
            return
        x, rng = at.x(), np.random.default_rng(1)
        for seed in [*np.eye(at.nx), *rng.normal(size=(3, at.nx))] if at.nx else [np.zeros(0)]:
            h = 1e-6 * max(1.0, float(np.abs(x).max(initial=0)))
            sides = []
            for side in (h, -h):
                at.set_x(x + side * seed)
                sides.append(np.concatenate([at.dx(), reals(fmu, at.outputs)]))
            at.set_x(x)
            found, differences = at.along(seed), (sides[0] - sides[1]) / (2 * h)
            np.testing.assert_allclose(found, differences, rtol=1e-4, atol=1e-5)
        if declared(path, "ModelExchange", "providesAdjointDerivatives"):
            back = rng.normal(size=size(fmu, at.unknowns))
            seeds = np.array([at.along(seed) for seed in np.eye(at.nx)]).reshape(at.nx, len(back))
            np.testing.assert_allclose(at.adjoint(back), seeds @ back, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("path", MODEL_EXCHANGE)
def test_states_and_derivatives_are_got_by_value_reference_as_by_their_own_calls(path: Path):
    with Fmu(path, model_exchange=True) as fmu:
        at = Flowing(fmu)
        at.set_x(at.x() * 1.01 + 1e-3)
        np.testing.assert_array_equal(reals(fmu, at.states), at.x())
        np.testing.assert_array_equal(reals(fmu, at.rates), at.dx())


@pytest.mark.parametrize("path", MODEL_EXCHANGE)
def test_states_are_set_by_value_reference_as_by_their_own_call(path: Path):
    with Fmu(path, model_exchange=True) as fmu:
        at = Flowing(fmu)
        x = at.x()
        moved = x * (1 + 1e-3) + 1e-3
        at.set_x(moved)
        expected = np.concatenate([at.dx(), reals(fmu, at.outputs)])
        at.set_x(x)
        set_reals(fmu, at.states, moved)
        np.testing.assert_array_equal(at.x(), moved)
        np.testing.assert_array_equal(np.concatenate([at.dx(), reals(fmu, at.outputs)]), expected)
        if at.nx:
            with pytest.raises(HnavError, match="is not finite"):
                set_reals(fmu, at.states[:1], [np.nan] * size(fmu, at.states[:1]))
        fmu.call(fmu.fmu.enterEventMode)
        set_reals(fmu, at.states, x)
        np.testing.assert_array_equal(at.x(), x)


@pytest.mark.parametrize("path", ARCHIVES)
def test_initialization_mode_has_the_values_that_come_after_it(path: Path):
    for model_exchange in {False, declared(path, "ModelExchange") is not None}:
        with Fmu(path, model_exchange=model_exchange) as fmu:
            fmu.enter_initialization()
            unknowns = [u.variable for u in fmu.description.initialUnknowns if u.variable.type in REAL]
            before = reals(fmu, unknowns)
            fmu.call(fmu.fmu.exitInitializationMode)
            np.testing.assert_array_equal(reals(fmu, unknowns), before)


@pytest.mark.parametrize("path", ARCHIVES)
def test_states_are_kept_given_back_and_written_down(path: Path):
    with Fmu(path) as fmu:
        assert declared(path, "CoSimulation", "canGetAndSetFMUstate", "canGetAndSetFMUState")
        assert declared(path, "CoSimulation", "canSerializeFMUstate", "canSerializeFMUState")
        assert declared(path, "CoSimulation", "canHandleVariableCommunicationStepSize")
        f, seen = fmu.fmu, outputs_of(fmu)
        fmu.initialise()
        fmu.do_step(0.0, 0.01)
        state = f.getFMUState()
        bytes_ = f.serializeFMUState(state)
        fmu.do_step(0.01, 0.0173)
        expected = reals(fmu, seen)
        for one in (state, f.deserializeFMUState(bytes_)):
            f.setFMUState(one)
            fmu.do_step(0.01, 0.0173)
            np.testing.assert_array_equal(reals(fmu, seen), expected)
            f.freeFMUState(one)


@pytest.mark.parametrize("path", [a for a in ARCHIVES if a.values[0].parent == FOLDERS[3]])
def test_event_mode_and_intermediate_updates_are_as_declared(path: Path):
    with Fmu(path, events=True) as fmu:
        assert declared(path, "CoSimulation", "hasEventMode") and declared(path, "CoSimulation", "providesIntermediateUpdate")
        fmu.initialise()
        t_s = 0.0
        for _ in range(5):
            rounds = 0
            while fmu.iterate():
                rounds += 1
                assert rounds < 10
            fmu.call(fmu.fmu.enterStepMode)
            _, _, early, last_s = fmu.call(fmu.fmu.doStep, t_s, 0.015)
            assert early or last_s == pytest.approx(t_s + 0.015)
            t_s = last_s
            fmu.call(fmu.fmu.enterEventMode)
    updates = []
    with Fmu(path) as fmu:
        fmu.fmu.freeInstance = lambda: None
        instance = fmu.fmu
        instance.instantiate(logMessage=lambda *_: None, intermediateUpdate=lambda *update: updates.append(update[1]))
        fmu.initialise()
        fmu.do_step(0.0, 0.01)
        instance.fmi3FreeInstance(instance.component)
    assert updates == [pytest.approx(0.01)]


# --------------------------------------------------------------------------------------------- before and beside


@pytest.mark.parametrize("version", (2, 3))
def test_parameters_can_be_read_before_initialization_and_nothing_else(version):
    with Fmu(fmu_path("AircraftInsLateral", version)) as fmu:
        assert fmu.get("interval") == 0.1
        fmu.set("interval", 0.2)
        assert fmu.get("interval") == 0.2
        with pytest.raises(HnavError, match="getting a calculated variable is not allowed in the mode before initialization"):
            fmu.get("z.beta")


@pytest.mark.parametrize(
    ("path", "model_exchange"),
    [*(pytest.param(*a.values, False, id=f"{a.id}-cs") for a in ARCHIVES),
     *(pytest.param(*a.values, True, id=f"{a.id}-me") for a in MODEL_EXCHANGE)],
)  # fmt: skip
def test_values_are_finite_before_the_first_sample_too(path: Path, model_exchange: bool):
    """Importers take NaN for an error. A counter that is 0, or a flag, says that there is no sample yet."""
    with Fmu(path, model_exchange) as fmu:
        if "sampling_mode" in fmu.variables:
            fmu.set("sampling_mode", "counter")
        fmu.enter_initialization(5.0)
        outputs = outputs_of(fmu)
        assert np.isfinite(reals(fmu, outputs)).all()
        fmu.call(fmu.fmu.exitInitializationMode)
        assert np.isfinite(reals(fmu, outputs)).all()
        if model_exchange:
            fmu.update_discrete_states()
        else:
            fmu.do_step(5.0, 0.003)
        assert np.isfinite(reals(fmu, outputs)).all()
        if "post.t" in fmu.variables:
            assert fmu.get("post.t") == 5.0


@pytest.mark.parametrize("version", (2, 3))
def test_initialization_mode_follows_parameters_as_they_change(version):
    with Fmu(fmu_path("Pendulum", version)) as fmu:
        fmu.enter_initialization()
        for angle in (0.3, -0.7):
            fmu.set("start.angle_rad", angle)
            assert fmu.get("truth.angle") == angle
        fmu.set("start.angle_rad", 0.1)
        fmu.call(fmu.fmu.exitInitializationMode)
        assert fmu.get("truth.angle") == 0.1


def test_a_bad_parameter_is_named_in_initialization_mode_and_can_be_mended():
    with Fmu(fmu_path("InsErrorFilterLateral", 3)) as fmu:
        fmu.enter_initialization()
        fmu.set("euler_colour", True)
        fmu.set("ins_error_time_constant.p", 0.01)
        with pytest.raises(HnavError, match="^ins_error_time_constant.p = 0.01"):
            fmu.get("sigma.p")
        fmu.set("ins_error_time_constant.p", 100.0)
        assert fmu.get("sigma.p") > 0


def test_states_of_a_vehicle_that_lie_beyond_the_earth_are_refused():
    with Fmu(fmu_path("Vehicle", 3), model_exchange=True) as fmu:
        at = Flowing(fmu)
        at.set_x(at.x() + [1e200, 0, 0, 0])
        with pytest.raises(HnavError, match="derivatives"):
            at.dx()
        assert np.isfinite(reals(fmu, at.outputs)).all()


def test_there_is_no_pressure_above_the_atmosphere_and_no_sample_of_a_height_that_is_none():
    with Fmu(fmu_path("Baro", 3)) as fmu:
        fmu.set("baro.noise_pa", 1e-9)
        fmu.set("baro.colour_pa", 0.0)
        fmu.set("baro.offset_sigma_pa", 0.0)
        fmu.initialise()
        fmu.set("truth.height", 1e300)
        fmu.do_step(0.0, 1.0)
        assert fmu.get("baro.sample") == 0 and fmu.get("baro.pressure") == 0
        fmu.set("truth.height", 1e6)
        fmu.do_step(1.0, 1.0)
        assert abs(fmu.get("baro.pressure")) < 1e-6


@pytest.mark.parametrize(
    "name, period", [("Gnss", "gnss.period_s"), ("ImuMagSensor", "gyro.period_s"), ("Vehicle", ""), ("Pendulum", "")]
)
def test_a_step_of_years_is_refused_at_once(name, period):
    with Fmu(fmu_path(name, 3)) as fmu:
        if period:
            fmu.set(period, 1e-6)
        fmu.initialise()
        fmu.do_step(0.0, 1e-3)
        with pytest.raises(HnavError, match="take a shorter one"):
            fmu.do_step(1e-3, 1e8)
