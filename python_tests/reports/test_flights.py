"""Flights with coloured INS errors as the report sees them, and the paper's Table 1."""

import numpy as np
import pytest

from hnav.errors import HnavError
from hnav.reports.flights import channels, is_flight
from hnav.systems.simulation import Run, simulate


@pytest.fixture(scope="module")
def run() -> Run:
    try:
        return simulate("aircraft", seed=3)
    except HnavError as error:
        pytest.skip(str(error))


def test_a_flight_has_the_channels_of_both_motions_with_three_filters_each(run):
    flight = channels(run)
    assert is_flight(run)
    assert [c.name for c in flight] == ["u", "w", "q", "theta", "beta", "p", "r", "phi"]
    for channel in flight:
        assert [t.filter for t in channel.tracks] == ["mdkf", "amdkf", "augmented"]


def test_the_fault_stands_where_the_paper_has_it(run):
    windows = {c.name: c.fault_windows() for c in channels(run)}
    assert windows.pop("q") == windows.pop("theta") == [(8.0, 15.0)]
    assert not any(windows.values())


def test_errors_are_taken_at_the_sample_that_the_estimate_is_about(run):
    channel = next(c for c in channels(run) if c.name == "q")
    late, _, now = channel.tracks
    # Differencing needs the next sample: at the end it is about the one before.
    assert now.t_s[-1] - late.t_s[-1] == pytest.approx(0.1)
    for track in channel.tracks:
        truth = np.interp(track.t_s, channel.t_s, channel.truth)
        np.testing.assert_allclose(track.error, track.estimate - truth, atol=1e-9)
        # Errors of one sample's motion would be as large as the motion: up to 0.7 deg/s here.
        assert np.sqrt(np.mean(track.error[channel.fault[: len(track.error)] == 0] ** 2)) < 0.3


def test_plants_of_one_system_draw_noise_of_their_own(run):
    noise = {c.name: c.measurement - c.truth for c in channels(run)}
    assert abs(np.corrcoef(np.diff(noise["u"]), np.diff(noise["beta"]))[0, 1]) < 0.25


def test_a_stretch_that_is_too_short_has_no_mean(run):
    channel = next(c for c in channels(run) if c.name == "u")
    assert np.isnan(channel.rmse(channel.tracks[0], faulty=True)) and channel.rmse(channel.tracks[0], faulty=False) > 0


def test_the_picture_has_a_row_for_each_state(run):
    pytest.importorskip("plotly", reason="plotly is not installed: no picture")
    from hnav.reports.flight_panels import estimates_of
    from hnav.reports.pictures import picture_of

    flight = [c for c in channels(run) if c.aircraft == "aircraft_longitudinal"]
    figure = estimates_of(flight)
    picture = picture_of(figure, run)
    rows = np.reshape(picture.axes, (4, 3))
    assert [axes.get_ylabel() for axes in rows[:, 0]] == [f"{c.title} / {c.unit}" for c in flight]
    assert [text.get_text() for text in picture.texts] == ["estimate", "error", "fault probability"]
    for axes, x in zip(rows.ravel(), figure.select_xaxes()):
        assert axes.get_xlim() == tuple(x.range) == (run.t_s[0], run.t_s[-1])
    drawn = rows[2, 0].get_lines()
    np.testing.assert_allclose(drawn[-1].get_ydata(), next(t for t in figure.data if t.name == "truth" and t.yaxis == "y7").y)
    # The time of the fault is shaded behind the state with more noise, and behind no other.
    shaded = [sum(patch.get_width() == 7.0 for patch in axes.patches) for axes in rows[:, 0]]
    assert shaded == [0, 0, 1, 1]


def test_the_report_and_its_pictures_show_the_flight(run, tmp_path):
    pytest.importorskip("plotly", reason="plotly is not installed: no report")
    from hnav.reports.page import write_report
    from hnav.reports.pictures import write_pictures

    assert write_report(run, tmp_path / "report.html") == [
        "flight",
        "flight-innovations",
        "flight-faults",
        "flight-table",
        "timing",
    ]
    assert [f.name for f in write_pictures(run, tmp_path)] == ["aircraft_lateral.png", "aircraft_longitudinal.png"]
