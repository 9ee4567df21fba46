"""Health in the reports: only where something was not ok, in colour and in words."""

import numpy as np
import pytest

from hnav.filters.filter_answers import HEALTH_SENSORS, SENSOR_STATES
from hnav.fmi.engines import run_recording
from hnav.reports import colours
from hnav.reports.recording_picture import draw_recording
from hnav.reports.recording_run import RecordingRun
from hnav.systems.simulation import Run
from motion import tilted_motion

pytest.importorskip("plotly", reason="plotly is not installed: no report")
from hnav.reports.health_panel import health_panel
from hnav.reports.page import section


def run_of(health: np.ndarray) -> Run:
    """One filter, sampled at 100 Hz, with these sensor states."""
    n = len(health)
    columns = {f"ahrs.att.q[{i}]": np.full(n, float(i == 1)) for i in (1, 2, 3, 4)}
    columns |= {f"ahrs.att.sigma[{i}]": np.ones(n) for i in (1, 2, 3)} | {"ahrs.align.started": np.ones(n)}
    columns |= {f"ahrs.health.{sensor}.state": health[:, i].astype(float) for i, sensor in enumerate(HEALTH_SENSORS)}
    return Run(0.01 * np.arange(n), columns, {}, {"components": {"ahrs": {}}})


@pytest.fixture
def clipped_and_stuck() -> np.ndarray:
    health = np.zeros((4000, 3), np.uint8)
    health[1000:1500, 0] = SENSOR_STATES.index("saturated")
    health[1700, 0] = SENSOR_STATES.index("outlier")
    health[2000:, 2] = SENSOR_STATES.index("stuck")
    return health


def test_there_is_no_panel_when_every_sensor_was_ok():
    health = np.zeros((4000, 3), np.uint8)
    assert not health_panel.applies(run_of(health))
    health[:50] = SENSOR_STATES.index("missing")  # before the first samples
    assert not health_panel.applies(run_of(health))
    health[:200, 1] = SENSOR_STATES.index("missing")
    assert health_panel.applies(run_of(health))


def test_a_run_without_health_has_no_panel(clipped_and_stuck):
    run = run_of(clipped_and_stuck)
    columns = {name: values for name, values in run.columns.items() if "health" not in name}
    assert not health_panel.applies(Run(run.t_s, columns, {}, run.about))


def test_the_panel_shows_each_state_where_it_was_and_says_so(clipped_and_stuck):
    run = run_of(clipped_and_stuck)
    drawn = {bar.name: bar for bar in health_panel.draw(run).data}
    assert set(drawn) == {"saturated", "outlier", "stuck"} and set(drawn["stuck"].y) == {"ahrs  mag"}
    assert drawn["saturated"].base[0] == pytest.approx(10, abs=0.03) and drawn["saturated"].x[0] == pytest.approx(5, abs=0.06)
    assert drawn["outlier"].x[0] > 0 and drawn["stuck"].text == "stuck"
    text = section(health_panel, run)
    assert "<li>ahrs: gyro saturated for 5.0 s, from 10.0 s on</li>" in text
    assert "<li>ahrs: mag stuck for 20.0 s, from 20.0 s on</li>" in text


def test_the_picture_of_a_recording_has_the_band_only_where_it_is_needed():
    clean = tilted_motion(8).recording
    faulty = tilted_motion(8).recording
    faulty.field_b_tesla[300:] = faulty.field_b_tesla[300]
    pictures = [draw_recording(RecordingRun(r, run_recording(r, "ahrs"), "", "ahrs")) for r in (clean, faulty)]
    last = [picture.axes[-1] for picture in pictures]
    assert last[0].get_title(loc="left") == "Gyro bias"
    assert last[1].get_title(loc="left").startswith("mag stuck for")
    assert [label.get_text() for label in last[1].get_yticklabels()] == ["mag"]


def test_every_state_but_ok_has_a_colour():
    assert tuple(colours.STATE_COLOURS) == SENSOR_STATES[1:]
