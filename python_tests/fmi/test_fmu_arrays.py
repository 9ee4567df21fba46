"""The Ahrs with arrays, for importers that have them: the same numbers as the one with scalars, bit for bit."""

import ctypes as C
import math

import fmpy
import numpy as np
import pytest

from hnav.errors import HnavError
from hnav.fmi.fmus import Fmu, fmu_path
from importing import assert_fits_the_standard

ARRAYS, SCALARS = "AhrsArrays", "Ahrs"


def elements(variable) -> list[str]:
    """The names of the scalars that an array stands for, in its order."""
    sizes = [int(dimension.start) for dimension in variable.dimensions]
    if not sizes:
        return [variable.name]
    base, closing = variable.name.removesuffix(")"), ")" if variable.name.endswith(")") else ""
    if len(sizes) == 2:
        return [f"{base}[{i + 1},{j + 1}]{closing}" for i in range(sizes[0]) for j in range(sizes[1])]
    if base == "cov.P":
        return [f"{base}[{i},{j}]" for i in range(1, 7) for j in range(i, 7)]
    if base.endswith("state.G"):
        return [f"{base}[{i},{j}]{closing}" for j in (1, 2, 3) for i in (1, 2, 3)]
    return [f"{base}[{i + 1}]{closing}" for i in range(sizes[0])]


def size(variable) -> int:
    return len(elements(variable))


def set_reals(fmu: Fmu, values: dict[str, list[float]]) -> None:
    """Arrays by one call."""
    for name, value in values.items():
        fmu.call(fmu.fmu.setFloat64, [fmu.variables[name].valueReference], value)


def get_reals(fmu: Fmu, names: list[str]) -> list[float]:
    variables = [fmu.variables[name] for name in names]
    return fmu.call(fmu.fmu.getFloat64, [v.valueReference for v in variables], sum(map(size, variables)))


def sample(k: int) -> dict[str, list[float]]:
    t = 0.01 * k
    return {
        "gyro.rate": [0.1 * math.sin(t), 0.2, -0.1 * math.cos(3 * t)], "accel.force": [0.3 * math.sin(t), -0.2, -9.8],
        "mag.field": [2e-5, 1e-6 * math.sin(t), 4.5e-5],
    }  # fmt: skip


def scalars_of(values: dict[str, list[float]]) -> dict[str, float]:
    return {f"{name}[{i}]": v for name, value in values.items() for i, v in enumerate(value, start=1)}


def real_outputs(fmu: Fmu) -> list[str]:
    return [v.name for v in fmu.variables.values() if v.causality == "output" and v.type == "Float64"]


def test_it_fits_the_standard_and_has_the_same_variables():
    assert_fits_the_standard(fmu_path(ARRAYS, 3), 3)
    arrays, scalars = (fmpy.read_model_description(str(fmu_path(name, 3))).modelVariables for name in (ARRAYS, SCALARS))
    assert [name for v in arrays for name in elements(v)] == [v.name for v in scalars]
    starts = [float(x) for v in arrays for x in (v.start or "").split() if v.type == "Float64"]
    assert starts == [float(v.start) for v in scalars if v.type == "Float64" and v.start]
    dimensions = {v.name: [d.start for d in v.dimensions] for v in arrays if v.dimensions}
    assert dimensions["gyro.rate"] == ["3"] or dimensions["gyro.rate"] == [3]
    assert len(dimensions["gyro_calibration.S"]) == 2


def test_co_simulation_gives_the_same_bits():
    with Fmu(fmu_path(ARRAYS, 3)) as arrays, Fmu(fmu_path(SCALARS, 3)) as scalars:
        mounting = {"frame.q_body_sensor": [0.8, 0.0, 0.6, 0.0]}
        set_reals(arrays, mounting)
        for name, value in scalars_of(mounting).items():
            scalars.set(name, value)
        for fmu in (arrays, scalars):
            fmu.set("timing.output_latency_s", 0.01)
            fmu.initialise()
        names = real_outputs(arrays)
        flat = [element for name in names for element in elements(arrays.variables[name])]
        for k in range(150):
            set_reals(arrays, sample(k))
            for name, value in scalars_of(sample(k)).items():
                scalars.set(name, value)
            arrays.do_step(0.01 * k, 0.01)
            scalars.do_step(0.01 * k, 0.01)
            if k % 10 == 9:
                assert get_reals(arrays, names) == [scalars.get(name) for name in flat]
        assert arrays.get("count.accel_used") == scalars.get("count.accel_used") == 150


def test_model_exchange_gives_the_same_derivatives_directional_and_adjoint_ones_too():
    found = []
    for name in (ARRAYS, SCALARS):
        with Fmu(fmu_path(name, 3), model_exchange=True) as fmu:
            fmu.initialise()
            if name == ARRAYS:
                set_reals(fmu, sample(3))
            else:
                for variable, value in scalars_of(sample(3)).items():
                    fmu.set(variable, value)
            fmu.update_discrete_states()
            f = fmu.fmu
            fmu.call(f.enterContinuousTimeMode)
            fmu.call(f.setTime, 0.004)
            dx = (C.c_double * 14)()
            fmu.call(f.getContinuousStateDerivatives, dx, 14)
            rates = [v for v in fmu.description.modelVariables if v.derivative is not None]
            knowns = [v.derivative.valueReference for v in rates]
            unknowns = [v.valueReference for v in rates] + [fmu.variables[n].valueReference for n in real_outputs(fmu)]
            n = sum(size(v) for v in rates) + sum(size(fmu.variables[o]) for o in real_outputs(fmu))
            seed = np.random.default_rng(1).normal(size=14).tolist()
            along = fmu.call(f.getDirectionalDerivative, unknowns, knowns, seed, n)
            back = fmu.call(f.getAdjointDerivative, unknowns, knowns, np.random.default_rng(2).normal(size=n).tolist(), 14)
            found.append((list(dx), along, back))
    assert found[0] == found[1] and any(found[0][2])


def test_sizes_that_do_not_fit_and_references_of_no_variable_are_refused():
    with Fmu(fmu_path(ARRAYS, 3)) as fmu:
        reference = fmu.variables["gyro.rate"].valueReference
        with pytest.raises(HnavError, match="variables of 3 elements go with 2 values"):
            fmu.call(fmu.fmu.setFloat64, [reference], [0.0, 0.0])
        with pytest.raises(HnavError, match="no variable with value reference"):
            fmu.call(fmu.fmu.setFloat64, [len(fmu.variables) + 1], [])
        with pytest.raises(HnavError, match=r"start\.start_q_nb\[2\]"):
            fmu.call(fmu.fmu.setFloat64, [fmu.variables["start.start_q_nb"].valueReference], [1.0, 7.0, 0.0, 0.0])


def test_the_two_do_not_take_each_other_s_description():
    tokens = {fmpy.read_model_description(str(fmu_path(name, 3))).guid for name in (ARRAYS, SCALARS)}
    assert len(tokens) == 2


def test_fmpy_simulates_it():
    for kind in ("CoSimulation", "ModelExchange"):
        result = fmpy.simulate_fmu(
            str(fmu_path(ARRAYS, 3)),
            fmi_type=kind,
            stop_time=1,
            output_interval=0.01,
            output=["att.q", "att.sigma", "align.started"],
        )
        assert result["align.started"][-1] and result["att.q"][-1] == pytest.approx([1, 0, 0, 0], abs=1e-6)
