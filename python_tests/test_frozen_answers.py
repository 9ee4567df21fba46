"""The answers of revision d7bc172, or of the last change of their mathematics, kept in a file, and those of today: to 1e-12
of the size of each array. Processors round sines and square roots differently: where a rounding of the samples moves an answer
by more than that, as it does at the limit of the robust law, the answer is held to what such roundings move.

    .venv/bin/python python_tests/test_frozen_answers.py CASE...

stores the answers of these cases again, after a change of their mathematics; the others stay as they are.
"""

import sys
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest

import frozen_cases as cases
from closed_loop import ClosedLoop
from hnav import Filter, Observer, Options, Plan, Plant
from hnav.filters.calibration import calibrate_magnetometer
from hnav.filters.ins import Ins
from hnav.filters.ins_aids import Aids
from hnav.filters.ins_error import InsErrorFilter, InsErrorOptions
from hnav.filters.linear_model import LinearModel

TOLERANCE = 1e-12
FILE = Path(__file__).with_name("frozen_answers.npz")
ROUNDINGS = 10  # of what one in each sample moves
FROZEN_SENSORS = ("gyro", "accel", "mag", "heading")  # that there were then


@pytest.fixture(scope="module")
def frozen() -> dict[str, np.ndarray]:
    with np.load(FILE) as data:
        return dict(data)


def assert_frozen(frozen, case: str, answers: dict[str, np.ndarray], rounded: dict[str, np.ndarray] | None = None) -> None:
    """All that was kept of the case is answered as it was. rounded: the answers to samples of another rounding."""
    kept = {name.partition("/")[2]: values for name, values in frozen.items() if name.startswith(f"{case}/")}
    assert kept.keys() == answers.keys()
    for name, before in kept.items():
        size = np.nanmax(np.abs(before), initial=0.0)
        assert size > 0 or name in ("ready", "fault_probability"), f"{name} says nothing"
        now = np.asarray(answers[name], float)
        moved = 0.0 if rounded is None else ROUNDINGS * np.nanmax(np.abs(np.asarray(rounded[name], float) - now), initial=0.0)
        np.testing.assert_allclose(now, before, rtol=0, atol=max(TOLERANCE * size, moved), equal_nan=True, err_msg=name)


def nudged(samples: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Every number of the samples by one unit of its last place larger."""
    return [np.nextafter(values, np.inf) for values in samples]


def rows_of(run, names: tuple[str, ...], rows: slice) -> dict[str, np.ndarray]:
    return {name: np.squeeze(getattr(run, name)[rows]) for name in names}


def attitude_answers(case: str, *samples: np.ndarray) -> dict[str, np.ndarray]:
    kind, preset, settings = cases.ATTITUDE[case]
    target = Filter(Options(kind, preset, **settings))
    run = target.run(*samples)
    used = target.diagnostics().used
    return rows_of(run, cases.OUTPUTS, cases.ROWS) | {"used": np.array([used[sensor] for sensor in FROZEN_SENSORS])}


def smoothed_answers(case: str, *samples: np.ndarray) -> dict[str, np.ndarray]:
    run = Filter(Options("ahrs", **cases.SMOOTHED[case])).smooth(*samples)
    return rows_of(run, cases.OUTPUTS[:4], cases.ROWS)


def ins_error_answers(case: str, u: np.ndarray, z: np.ndarray) -> dict[str, np.ndarray]:
    target = InsErrorFilter(LinearModel(**cases.ins_model()), InsErrorOptions(**cases.INS_ERROR[case]))
    return rows_of(target.run(u, z), cases.INS_OUTPUTS, cases.STEPS)


def calibration_answers(case: str, *samples: np.ndarray) -> dict[str, np.ndarray]:
    fit = calibrate_magnetometer(*samples, **cases.CALIBRATION[case])
    return {name: np.ravel(getattr(fit, name)) for name in cases.CALIBRATED}


def sensor_answers(case: str) -> dict[str, np.ndarray]:
    parameters = {f"turntable.{name}": value for name, value in cases.TABLE.items()}
    parameters |= {f"sensor.{name}": value for name, value in cases.SENSOR.items()}
    with ExitStack() as stack:
        loop = ClosedLoop(stack, parameters, filters=(), seed=cases.SENSOR["seed"])
        shown = loop.run(cases.SENSOR_STOP_S, {"sensor": cases.SENSOR_OUTPUTS}, cases.SENSOR_STEP_S)["sensor"]
    return {"values": shown[cases.STEPS]}


def navigation_answers(case: str, rate: np.ndarray, force: np.ndarray) -> dict[str, np.ndarray]:
    preset, kinds, settings = cases.NAVIGATION[case]
    d, aids = cases.drive(), Aids()
    given = {
        "velocity": lambda: aids.velocity(d.fix_s, d.velocity, 0.1),
        "position": lambda: aids.position(d.fix_s, *d.place.T, 0.5),
        "pressure": lambda: aids.pressure(d.fix_s, d.pressure_pa, 5.0),
        "speed": lambda: aids.speed(d.fix_s, d.speed_m_s, 0.1),
    }
    for kind in kinds:
        given[kind]()
    rows = slice(None) if kinds else slice(cases.AT_REST)
    run = Ins(preset, **settings).run(d.t_s[rows], rate[rows], force[rows], aids, smooth=case == "ins smoothed")
    return rows_of(run, cases.NAVIGATED, cases.EVERY_FIX)


def observer_answers(case: str, samples: np.ndarray) -> dict[str, np.ndarray]:
    noise, states, parameters = cases.OBSERVED[case]
    plant = Plant(**cases.PLANTS[case])
    (sensor,), (t, _, torque) = plant.sensors, cases.observed_samples(case)
    plan = Plan(plant).sensor(sensor, noise=noise, gate_nis=cases.GATE_NIS)
    for name, (start, sigma, walk) in states.items():
        plan.state(name, start=start, start_sigma=sigma, noise=walk)
    for name, (sigma, walk) in parameters.items():
        plan.parameter(name, start_sigma=sigma, noise=walk)
    for name in plant.inputs:
        plan.input(name)
    run = Observer(plan).run(t, {sensor: samples}, dict.fromkeys(plant.inputs, torque))
    found = {
        "x": np.stack([*run.x.values()]),
        "sigma": np.stack([*run.sigma.values()]),
        "nis": run.nis[sensor],
        "parts": run.parts,
    }
    return {name: np.asarray(values, float)[..., cases.STEPS] for name, values in found.items()}


def attitude_samples() -> tuple[np.ndarray, ...]:
    m = cases.motion()
    return m.rate, m.force, m.field


Answers = dict[str, np.ndarray]
# Of each kind: its cases, what answers one of them, its samples, and whether it is held to what roundings of them move.
KINDS: dict[str, tuple[Iterable[str], Callable[..., Answers], Callable[[str], Sequence[np.ndarray]], bool]] = {
    "attitude": (
        cases.ATTITUDE, lambda case, *s: attitude_answers(case, cases.motion().t_s, *s), lambda _: attitude_samples(), True,
    ),
    "smoother": (cases.SMOOTHED, lambda case, *s: smoothed_answers(case, cases.motion().t_s, *s), lambda _: attitude_samples(), False),
    "ins error": (cases.INS_ERROR, ins_error_answers, lambda _: cases.ins_signals(), False),
    "calibration": (cases.CALIBRATION, calibration_answers, lambda _: cases.turned_magnetometer(), True),
    "sensor": (["sensor"], sensor_answers, lambda _: (), False),
    "navigation": (cases.NAVIGATION, navigation_answers, lambda _: (cases.drive().rate, cases.drive().force), True),
    "observer": (cases.OBSERVED, observer_answers, lambda case: cases.observed_samples(case)[1:2], True),
}  # fmt: skip


@pytest.mark.parametrize("kind, case", [(kind, case) for kind, (of_kind, *_) in KINDS.items() for case in of_kind])
def test_a_case_is_answered_as_it_was(kind, case, frozen):
    _, answers, samples, rounds = KINDS[kind]
    given = samples(case)
    assert_frozen(frozen, case, answers(case, *given), answers(case, *nudged(given)) if rounds else None)


def keep(*wanted: str) -> None:
    """The answers of these cases by this library, of all cases without names. Raises ValueError for an unknown case."""
    if unknown := set(wanted).difference(case for of_kind, *_ in KINDS.values() for case in of_kind):
        raise ValueError(f"no such case: {sorted(unknown)}")
    with np.load(FILE) as data:
        kept = {name: values for name, values in data.items() if wanted and name.partition("/")[0] not in wanted}
    for of_kind, answers, samples, _ in KINDS.values():
        for case in of_kind:
            if not wanted or case in wanted:
                kept |= {f"{case}/{name}": values for name, values in answers(case, *samples(case)).items()}
    np.savez_compressed(FILE, **kept)
    print(f"{FILE}: {len(kept)} arrays, {sum(np.size(a) for a in kept.values())} numbers, {FILE.stat().st_size} bytes")


if __name__ == "__main__":
    keep(*sys.argv[1:])
