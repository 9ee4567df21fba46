"""Directional and adjoint derivatives over every pair of the description: against differences of the outputs themselves, with
steps to the size of each state, at small and large covariances."""

import ctypes as C
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
import pytest

from hnav.fmi.fmus import Fmu, fmu_path

VERSIONS = (2, 3)
CASES = [
    ("Hrekf", 1e-5),
    ("Hrekf", 1e-3),
    ("Hrekf", 0.1),
    ("Ahrs", 1e-5),
    ("Ahrs", 1e-2),
    ("Ahrs", 0.5),
    ("Ins", 1.0),
    ("Turntable", 1.0),
    ("Pendulum", 1.0),
]
versions = pytest.mark.parametrize("version", VERSIONS, ids=lambda v: f"fmi{v}")
cases = pytest.mark.parametrize("name, size", CASES)
SAMPLE = {
    **{f"gyro.rate[{i}]": v for i, v in enumerate((0.1, -0.2, 0.3), start=1)},
    **{f"accel.force[{i}]": v for i, v in enumerate((0.1, -3.3, -9.2), start=1)},
    **{f"mag.field[{i}]": v for i, v in enumerate((1.4e-5, 0.6e-5, 4.7e-5), start=1)},
}
EPS = np.finfo(float).eps


def parameters(name: str, size: float) -> dict[str, float | str]:
    """size: of the standard deviations at the start of the attitude filters, whose covariance is no state. The body is known, else its
    tilt would have a larger one."""
    if name == "Pendulum":
        return {"start.angle_rad": 0.4}
    if name == "Turntable":
        return {"yaw.motion": 2, "yaw.amplitude_rad": 0.5, "pitch.angle_rad": 0.3}
    if name == "Ins":
        return {"start.start": 1, "start.start_place": 1, "start.start_latitude_rad": 0.8, "start.start_longitude_rad": 0.2}
    common = {"frame.declination_rad": 0.1, "frame.navigation_frame": 1, "start.start_samples": 1}
    sigmas = {f"start.start_sigma_{what}": size for what in ("tilt_rad", "heading_rad", "bias_rad_s")}
    return common | sigmas | ({"timing.output_latency_s": 0.02, "noise.body": "hand"} if name == "Ahrs" else {})


def random_states(name: str, size: float, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """States away from the start, and the size of each, of which a difference may take a small part."""
    if name == "Pendulum":
        return x + [0.2, -0.5], np.ones(2)
    rng = np.random.default_rng(3)
    q = rng.normal(size=4)
    x = x.copy()
    if name == "Ins":
        sizes = np.array([1e4] * 3 + [10.0] * 3 + [1.0] * 4)
        return np.concatenate([sizes[:6] * rng.normal(size=6), 1.02 * q / np.linalg.norm(q)]), sizes
    x[:4] = 1.02 * q / np.linalg.norm(q)  # an integrator does not keep the length
    sizes = np.ones(len(x))
    if name in ("Hrekf", "Ahrs"):
        x[4:13], x[13] = 0.02 * rng.normal(size=9), 0.02
        sizes[4:] = 0.1
    return x, sizes


@dataclass
class Pairs:
    """An instance in continuous-time mode, its states, and the unknowns with the states that they may depend on."""

    fmu: Fmu
    x: np.ndarray
    sizes: np.ndarray
    states: list[int]  # value references
    unknowns: list[int]
    depends: list[set[int]]  # for each unknown: which states, by value reference

    @classmethod
    def of(cls, fmu: Fmu, name: str, size: float) -> "Pairs":
        for parameter, value in parameters(name, size).items():
            fmu.set(parameter, value)
        fmu.initialise()
        for variable, value in SAMPLE.items():
            if variable in fmu.variables:
                fmu.set(variable, value)
        fmu.update_discrete_states()
        fmu.call(fmu.fmu.enterContinuousTimeMode)
        fmu.call(fmu.fmu.setTime, 0.004)
        derivatives = [v for v in fmu.description.modelVariables if v.derivative is not None]
        listed = [*fmu.description.outputs, *fmu.description.derivatives]
        real = [u for u in listed if u.variable.type in ("Real", "Float64")]
        x = (C.c_double * len(derivatives))()
        fmu.fmu.getContinuousStates(x, len(x))
        moved, sizes = random_states(name, size, np.array(x))
        pairs = cls(
            fmu, moved, sizes, [v.derivative.valueReference for v in derivatives], [u.variable.valueReference for u in real],
            [{d.valueReference for d in u.dependencies} for u in real],
        )  # fmt: skip
        pairs.values(moved)
        return pairs

    def values(self, x: np.ndarray) -> np.ndarray:
        self.fmu.fmu.setContinuousStates((C.c_double * len(x))(*x), len(x))
        out = (C.c_double * len(self.unknowns))()
        self.fmu.crossing("Get", "real", (C.c_uint32 * len(out))(*self.unknowns), out)()
        return np.array(out)

    def differences(self) -> tuple[np.ndarray, np.ndarray]:
        """Unknowns x states by differences of fourth order, and their rounding error."""
        found, rounding = [], []
        for k, size in enumerate(self.sizes):
            h = 2e-3 * size
            step = h * np.eye(len(self.x))[k]
            near = self.values(self.x + step) - self.values(self.x - step)
            far = self.values(self.x + 2 * step) - self.values(self.x - 2 * step)
            found.append((8 * near - far) / (12 * h))
            rounding.append(50 * EPS * np.abs(self.values(self.x)) / h)
        self.values(self.x)
        return np.stack(found, axis=1), np.stack(rounding, axis=1)

    def directional(self, seed: np.ndarray) -> np.ndarray:
        return np.array(self.fmu.call(self.fmu.fmu.getDirectionalDerivative, self.unknowns, self.states, seed.tolist()))

    def jacobian(self) -> np.ndarray:
        return np.stack([self.directional(e) for e in np.eye(len(self.states))], axis=1)

    def adjoint(self, seed: np.ndarray) -> np.ndarray:
        return np.array(self.fmu.fmu.getAdjointDerivative(self.unknowns, self.states, seed.tolist(), len(self.states)))


@contextmanager
def pairs_of(name: str, size: float, version: int) -> Iterator[Pairs]:
    with Fmu(fmu_path(name, version), model_exchange=True) as fmu:
        yield Pairs.of(fmu, name, size)


@cases
@versions
def test_every_pair_is_what_differences_of_the_outputs_say(name, size, version):
    with pairs_of(name, size, version) as pairs:
        expected, rounding = pairs.differences()
        found = pairs.jacobian()
        largest = np.abs(found).max(axis=1, keepdims=True) * pairs.sizes.max() / pairs.sizes
        off = np.abs(found - expected) > 1e-7 * largest + rounding
        names = {v.valueReference: v.name for v in pairs.fmu.description.modelVariables}
        assert not off.any(), [
            (names[pairs.unknowns[i]], names[pairs.states[k]], found[i, k], expected[i, k]) for i, k in np.argwhere(off)[:5]
        ]
        assert np.abs(found).max() > 0


@cases
@versions
def test_what_is_not_declared_to_depend_on_a_state_does_not(name, size, version):
    with pairs_of(name, size, version) as pairs:
        found = pairs.jacobian()
        for row, depends in zip(found, pairs.depends):
            assert not any(value for value, state in zip(row, pairs.states) if state not in depends)


@cases
@versions
def test_derivatives_are_linear_in_the_direction_however_long_it_is(name, size, version):
    with pairs_of(name, size, version) as pairs:
        jacobian = pairs.jacobian()
        seed = np.random.default_rng(5).normal(size=len(pairs.states))
        for length in (1e-12, 1.0, 1e6):
            np.testing.assert_allclose(pairs.directional(length * seed) / length, jacobian @ seed, rtol=1e-7,
                                       atol=1e-9 * np.abs(jacobian).max())  # fmt: skip


@cases
def test_adjoint_derivatives_are_the_transposed_ones(name, size):
    with pairs_of(name, size, 3) as pairs:
        jacobian = pairs.jacobian()
        for i in range(len(pairs.unknowns)):
            np.testing.assert_array_equal(pairs.adjoint(np.eye(len(pairs.unknowns))[i]), jacobian[i])
        seed = np.random.default_rng(6).normal(size=len(pairs.unknowns))
        np.testing.assert_allclose(pairs.adjoint(seed), seed @ jacobian, rtol=1e-9, atol=1e-12 * np.abs(seed @ jacobian).max())


def test_fmi3_says_that_it_has_adjoint_derivatives():
    for name in ("Hrekf", "Ahrs", "Ins", "Turntable", "Pendulum"):
        with Fmu(fmu_path(name, 3), model_exchange=True) as fmu:
            assert fmu.description.modelExchange.providesAdjointDerivatives
