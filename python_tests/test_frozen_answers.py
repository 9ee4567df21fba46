"""The answers of revision b991a70, or of the last change of their mathematics, kept in a file, and those of today: to 1e-12
of the size of each array.
"""

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
FROZEN_SENSORS = ("gyro", "accel", "mag", "heading")  # that there were then


@pytest.fixture(scope="module")
def frozen() -> dict[str, np.ndarray]:
    with np.load(Path(__file__).with_name("frozen_answers.npz")) as data:
        return dict(data)


def assert_frozen(frozen, case: str, answers: dict[str, np.ndarray]) -> None:
    """All that was kept of the case is answered as it was."""
    kept = {name.partition("/")[2]: values for name, values in frozen.items() if name.startswith(f"{case}/")}
    assert kept.keys() == answers.keys()
    for name, before in kept.items():
        size = np.nanmax(np.abs(before), initial=0.0)
        assert size > 0 or name in ("ready", "fault_probability"), f"{name} says nothing"
        now = np.asarray(answers[name], float)
        np.testing.assert_allclose(now, before, rtol=0, atol=TOLERANCE * size, equal_nan=True, err_msg=name)


def rows_of(run, names: tuple[str, ...], rows: slice) -> dict[str, np.ndarray]:
    return {name: np.squeeze(getattr(run, name)[rows]) for name in names}


@pytest.mark.parametrize("case", cases.ATTITUDE)
def test_an_attitude_filter_answers_as_it_did(case, frozen):
    kind, preset, settings = cases.ATTITUDE[case]
    m, target = cases.motion(), Filter(Options(kind, preset, **settings))
    run = target.run(m.t_s, m.rate, m.force, m.field)
    used = target.diagnostics().used
    assert_frozen(
        frozen, case, rows_of(run, cases.OUTPUTS, cases.ROWS) | {"used": np.array([used[sensor] for sensor in FROZEN_SENSORS])}
    )


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
    fit = calibrate_magnetometer(*cases.turned_magnetometer(), **cases.CALIBRATION[case])
    assert_frozen(frozen, case, {name: np.ravel(getattr(fit, name)) for name in cases.CALIBRATED})


def test_the_sensor_answers_as_it_did(frozen):
    parameters = {f"turntable.{name}": value for name, value in cases.TABLE.items()}
    parameters |= {f"sensor.{name}": value for name, value in cases.SENSOR.items()}
    with ExitStack() as stack:
        loop = ClosedLoop(stack, parameters, filters=(), seed=cases.SENSOR["seed"])
        shown = loop.run(cases.SENSOR_STOP_S, {"sensor": cases.SENSOR_OUTPUTS}, cases.SENSOR_STEP_S)["sensor"]
    assert_frozen(frozen, "sensor", {"values": shown[cases.STEPS]})
