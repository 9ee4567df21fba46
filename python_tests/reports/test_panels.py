"""A page draws many samples by their extremes, at every size."""

import numpy as np
import pytest

pytest.importorskip("plotly", reason="plotly is not installed: no report")
from hnav.reports.angles import near_turn
from hnav.reports.panels import BAND_POINTS, POINTS, band, dots, extremes, line


@pytest.mark.parametrize("n", [0, 1, 2, POINTS - 1, POINTS, POINTS + 1, 3 * POINTS + 7, 60_000])
def test_no_peak_is_lost(n):
    values = np.random.default_rng(n).normal(size=n)
    rows = extremes(values)
    assert len(rows) <= min(n, 2 * POINTS + 2) and (np.diff(rows) > 0).all()
    if n:
        assert {0, n - 1, values.argmin(), values.argmax()} <= set(rows)
    width = -(-n // POINTS) if n else 1
    for begin in range(0, n, width):
        block = values[begin : begin + width]
        assert {begin + block.argmin(), begin + block.argmax()} <= set(rows)


def test_a_gap_stays_a_gap():
    values = np.sin(np.arange(50_000) / 900)
    values[20_000:30_000] = np.nan
    drawn = line(np.arange(50_000.0), values, "#000000", "x", True)
    assert np.isnan(drawn.y).any() and np.nanmax(drawn.y) == np.float32(np.nanmax(values))
    assert not np.isfinite(drawn.y[(drawn.x > 20_100) & (drawn.x < 29_900)]).any()
    assert drawn.x.dtype == drawn.y.dtype == np.float32


def test_a_band_is_as_wide_as_its_widest_rows():
    t_s = np.arange(60_000.0)
    half = 1 + np.random.default_rng(1).random(60_000)
    half[777] = 9
    drawn = band(t_s, -half, half, "#000000", "x", True)
    assert len(drawn.x) <= 2 * BAND_POINTS + 2
    assert drawn.y.max() == 9 and drawn.y.min() == -9 and drawn.x.max() == t_s[-1]


def test_dots_keep_the_density_and_the_largest():
    values = np.random.default_rng(2).chisquare(3, 60_000)
    drawn = dots(np.arange(60_000.0), values, "#000000", "x", True)
    assert drawn.y.max() == np.float32(values.max())
    # Nearly all dots are every k-th sample: the share above a level is that of the samples.
    assert np.mean(drawn.y > 7.81) == pytest.approx(np.mean(values > 7.81), abs=0.12)


def test_angles_stay_in_their_turn_where_the_other_is_unknown():
    angles, near = np.linspace(0, 700, 50), np.linspace(0, 700, 50) - 360
    near[:10] = near[20:30] = np.nan
    np.testing.assert_allclose(near_turn(angles, near), angles - 360)
    np.testing.assert_allclose(near_turn(angles, np.full(50, np.nan)), angles)
