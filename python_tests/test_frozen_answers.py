"""The answers of revision b991a70, or of the last change of their mathematics, kept in a file, and those of today: to 1e-12
of the size of each array. Processors round sines and square roots differently: where a rounding of the samples moves an answer
by more than that, as it does at the limit of the robust law, the answer is held to what such roundings move.
"""

from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest

import frozen_cases as cases
from closed_loop import ClosedLoop
from hnav import Filter, Options
from hnav.filters.calibration import calibrate_magnetometer
from hnav.filters.ins_error import InsErrorFilter, InsErrorOptions
from hnav.filters.linear_model import LinearModel

TOLERANCE = 1e-12
ROUNDINGS = 10  # of what one in each sample moves
FROZEN_SENSORS = ("gyro", "accel", "mag", "heading")  # that there were then


@pytest.fixture(scope="module")
def frozen() -> dict[str, np.ndarray]:
    with np.load(Path(__file__).with_name("frozen_answers.npz")) as data:
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


@pytest.mark.parametrize("case", cases.ATTITUDE)
def test_an_attitude_filter_answers_as_it_did(case, frozen):
    m = cases.motion()
    samples = (m.rate, m.force, m.field)
    assert_frozen(frozen, case, attitude_answers(case, m.t_s, *samples), attitude_answers(case, m.t_s, *nudged(samples)))


@pytest.mark.parametrize("case", cases.SMOOTHED)
def test_the_smoother_answers_as_it_did(case, frozen):
    m = cases.motion()
    run = Filter(Options("ahrs", **cases.SMOOTHED[case])).smooth(m.t_s, m.rate, m.force, m.field)
    assert_frozen(frozen, case, rows_of(run, cases.OUTPUTS[:4], cases.ROWS))


@pytest.mark.parametrize("case", cases.INS_ERROR)
def test_the_ins_error_filter_answers_as_it_did(case, frozen):
    target = InsErrorFilter(LinearModel(**cases.ins_model()), InsErrorOptions(**cases.INS_ERROR[case]))
    assert_frozen(frozen, case, rows_of(target.run(*cases.ins_signals()), cases.INS_OUTPUTS, cases.STEPS))


@pytest.mark.parametrize("case", cases.CALIBRATION)
def test_the_calibration_answers_as_it_did(case, frozen):
    def answers(*samples: np.ndarray) -> dict[str, np.ndarray]:
        fit = calibrate_magnetometer(*samples, **cases.CALIBRATION[case])
        return {name: np.ravel(getattr(fit, name)) for name in cases.CALIBRATED}

    samples = cases.turned_magnetometer()
    assert_frozen(frozen, case, answers(*samples), answers(*nudged(samples)))


def test_the_sensor_answers_as_it_did(frozen):
    parameters = {f"turntable.{name}": value for name, value in cases.TABLE.items()}
    parameters |= {f"sensor.{name}": value for name, value in cases.SENSOR.items()}
    with ExitStack() as stack:
        loop = ClosedLoop(stack, parameters, filters=(), seed=cases.SENSOR["seed"])
        shown = loop.run(cases.SENSOR_STOP_S, {"sensor": cases.SENSOR_OUTPUTS}, cases.SENSOR_STEP_S)["sensor"]
    assert_frozen(frozen, "sensor", {"values": shown[cases.STEPS]})
