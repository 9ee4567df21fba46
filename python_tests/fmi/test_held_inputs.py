"""Continuous signals of a plant as inputs, at any communication step and with all defaults: what is stated holds."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hnav.fmi.fmus import Fmu, fmu_path
from motion import readings, turning

DURATION_S, SETTLED_S = 70.0, 30.0
STEPS_S = (0.01, 0.05, 0.1, 0.2, 0.5)


def driven(name: str, step_s: float, mode: str = "auto", noise: float = 1.0, wild: dict[int, float] | None = None):
    """Error (rad, navigation axes), its covariance and the flag of the tilt at every point after SETTLED_S; what was logged."""
    t = step_s * np.arange(round(DURATION_S / step_s))
    inputs = dict(zip(("gyro.rate", "accel.force", "mag.field"), readings(t, noise)))
    for row, rate in (wild or {}).items():
        inputs["gyro.rate"][row, 2] = rate
    attitudes, P, ready = [], [], []
    with Fmu(fmu_path(name, 3)) as fmu:
        fmu.set("sampling_mode", mode)
        fmu.initialise()
        for k, t_s in enumerate(t):
            for variable, rows in inputs.items():
                for axis in range(3):
                    fmu.set(f"{variable}[{axis + 1}]", float(rows[k, axis]))
            fmu.do_step(float(t_s), step_s)
            if t_s < SETTLED_S:
                continue
            attitudes.append([fmu.get(f"att.q[{i}]") for i in (2, 3, 4, 1)])
            P.append([fmu.get(f"cov.P[{min(i, j)},{max(i, j)}]") for i in (1, 2, 3) for j in (1, 2, 3)])
            ready.append(fmu.get("align.tilt_ready"))
        assert fmu.get("count.missed") == 0
        assert mode == "held" or fmu.get("count.gyro_used") == len(t) - len(wild or {})
        errors = (Rotation.from_quat(attitudes) * turning(t[t >= SETTLED_S] + step_s).inv()).as_rotvec()
        return errors, np.array(P).reshape(-1, 3, 3), np.array(ready), fmu.messages


def z2(errors: np.ndarray, P: np.ndarray) -> float:
    return float(np.mean(np.einsum("ki,kij,kj->k", errors, np.linalg.inv(P), errors)) / 3)


@pytest.mark.parametrize("step_s", STEPS_S)
def test_the_attitude_filter_states_its_error_at_every_step(step_s):
    errors, P, ready, said = driven("Ahrs", step_s)
    tilt_deg = np.degrees(np.hypot(errors[:, 0], errors[:, 1]))
    assert z2(errors, P) < 2
    assert not np.any(ready & (tilt_deg > 3))
    if step_s <= 0.1:
        assert np.mean(ready) > 0.8 and np.sqrt(np.mean(tilt_deg**2)) < 0.6
    assert len(said) == (step_s > 0.01) and all(
        f"communication step {step_s:g} s > gyro.period = 0.01 s" in line for line in said
    )


def test_samples_at_each_period_of_a_longer_step_would_count_one_reading_many_times():
    """Why only sampling_mode = held, which declares the inputs constant and free of noise, takes them."""
    errors, P, _, said = driven("Ahrs", 0.5, mode="held")
    assert z2(errors, P) > 10 and said == []


def test_a_rate_is_a_reading_of_its_instant():
    """By the trapezoid: without it the attitude leads by half a step, 0.8 deg at 0.05 s."""
    errors, *_ = driven("Ahrs", 0.05, noise=0)
    assert np.degrees(np.sqrt(np.mean(np.sum(errors**2, axis=1)))) < 0.3


def test_a_wild_sample_of_a_rate_stays_one():
    """A mean with its neighbours would be two, which the check takes for a movement: 146 deg off."""
    errors, *_ = driven("Ahrs", 0.01, wild={4000: 34.9, 5000: np.nan, 6000: 1000.0})
    assert np.degrees(np.abs(errors)).max() < 1


@pytest.mark.parametrize("kind, step_s, period_s", [
    ("car", 0.1, 1.0), ("car", 0.5, 1.0), ("aircraft", 0.1, 1.0), ("aircraft", 0.5, 1.0), ("ship", 0.1, 1.0), ("ship", 0.5, 1.0),
    ("car", 0.1, 0.1),
])  # fmt: skip
def test_the_navigation_filter_states_its_error_at_every_step(kind, step_s, period_s):
    """Of attitude and velocity, with held fixes of 1 Hz at any period. A reading taken for the mean of its interval: 5 of aircraft at 0.5 s;
    the same fix taken ten times while the heading is searched: 7 of the car."""
    rng = np.random.default_rng(1)
    with Fmu(fmu_path("Vehicle", 3)) as vehicle, Fmu(fmu_path("Ins", 3)) as ins:
        vehicle.set("motion.kind", kind)
        ins.set("preset", "industrial")
        for group in ("gnss", "gnssvel"):
            ins.set(f"{group}.valid", True)
            ins.set(f"{group}.period", period_s)
        vehicle.initialise()
        ins.initialise()

        def truth(name: str) -> np.ndarray:
            return np.array([vehicle.get(f"truth.{name}[{i}]") for i in (1, 2, 3)])

        def give(name: str, values: np.ndarray) -> None:
            for i, value in enumerate(values, start=1):
                ins.set(f"{name}[{i}]", float(value))

        z = []
        for k in range(round(220 / step_s)):
            give("gyro.rate", truth("rate") + 2e-3 * rng.normal(size=3))
            give("accel.force", truth("force") + 0.02 * rng.normal(size=3))
            if k % round(1 / step_s) == 0:
                for name, sigma in (("latitude", 3e-7), ("longitude", 3e-7), ("height", 4.0)):
                    ins.set(f"gnss.{name}", vehicle.get(f"truth.{name}") + sigma * rng.normal())
                give("gnssvel.velocity", truth("velocity") + 0.2 * rng.normal(size=3))
            vehicle.do_step(step_s * k, step_s)
            ins.do_step(step_s * k, step_s)
            if step_s * k < 100:
                continue
            q, true_q = ([fmu.get(f"{name}.q[{i}]") for i in (2, 3, 4, 1)] for fmu, name in ((ins, "att"), (vehicle, "truth")))
            turn = (Rotation.from_quat(q) * Rotation.from_quat(true_q).inv()).as_rotvec()
            drift = [ins.get(f"nav.velocity[{i}]") for i in (1, 2, 3)] - truth("velocity")
            sigma = [ins.get(f"{name}[{i}]") for name in ("att.sigma", "nav.sigma_velocity") for i in (1, 2, 3)]
            z.append((np.concatenate([turn, drift]) / sigma) ** 2)
        assert np.all(np.mean(z, axis=0) < 2)
        assert "accel.period" in ins.messages[0]
        assert ["gnss.period" in line and "source, 1 s" in line for line in ins.messages[1:]] == [True] * (period_s < 1)


@pytest.mark.parametrize("name", ("Ahrs", "Ins"))
def test_a_state_from_before_the_counters_is_taken_back(name):
    """Rates of counted samples are means, those of held inputs readings: the filter is another one, and is itself again."""

    def step(fmu: Fmu, k: int, counted: bool) -> None:
        for axis, (rate, force) in enumerate(zip((0.1, 0.2 * np.sin(0.3 * k), 0.1), (0.3, 0.2, -9.8)), start=1):
            fmu.set(f"gyro.rate[{axis}]", float(rate))
            fmu.set(f"accel.force[{axis}]", force)
        for sensor in ("gyro", "accel"):
            fmu.set(f"{sensor}.sample", k + 1 if counted else 0)
            fmu.set(f"{sensor}.t_meas", 0.01 * k)
        fmu.do_step(0.01 * k, 0.01)

    def attitude(fmu: Fmu) -> list[float]:
        return [fmu.get(f"att.q[{i}]") for i in range(1, 5)]

    with Fmu(fmu_path(name, 3)) as fmu:
        if name == "Ins":
            fmu.set("start.start", "state")
            fmu.set("start.start_place", "given")
        fmu.initialise()
        for k in range(100):
            step(fmu, k, counted=False)
        kept, here = fmu.fmu.getFMUState(), attitude(fmu)
        found = []
        for detour in (False, True):
            fmu.fmu.setFMUState(kept)
            for k in range(100, 120 if detour else 100):
                step(fmu, k, counted=True)
            fmu.fmu.setFMUState(kept)
            assert attitude(fmu) == here
            for k in range(100, 200):
                step(fmu, k, counted=False)
            found.append(attitude(fmu))
        fmu.fmu.freeFMUState(kept)
    assert found[0] == found[1] and found[0] != here
