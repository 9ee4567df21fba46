"""The picture of the mathematics: a few samples seen from near.

The estimate flows between samples and its covariance grows; at each sample it jumps, and the covariance falls. By the HREKF,
which corrects at every sample, on one trial of the BROAD data set.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib import rc_context

from hnav.filters.attitude import Filter
from hnav.filters.options import Options
from hnav.io.readers import read
from hnav.io.readers.broad import find_trial
from hnav.io.recordings import Recording
from hnav.reports import colours, plots
from hnav.rotations import rotation_error_rad

TRIAL = 5  # slow rotation by hand with breaks, undisturbed field
ZOOM_BEGIN_S, ZOOM_S = 47.9, 0.050
LOOKS_PER_INTERVAL = 24


@dataclass(frozen=True)
class Zoom:
    """The estimate between samples, by looking ahead: the last look of each interval is the one before the jump."""

    t_s: np.ndarray  # looks, n
    q_nb: np.ndarray  # n x 4
    sigma_rad: np.ndarray  # n x 3, about the navigation axes
    sample_t_s: np.ndarray  # the samples
    after_jump: np.ndarray  # index of the look just after each sample


def look_between(recording: Recording, begin_s: float, length_s: float, settings: dict[str, str]) -> Zoom:
    """Runs the filter sample by sample and looks ahead many times in each interval of the zoom.

    A look changes nothing: the same samples give the same estimates, looked at or not.
    """
    tracker = Filter(Options("hrekf", **settings))
    looks: list[list[float]] = []
    after_jump, sample_t_s = [], []
    field = recording.needed("field_b_tesla")
    t_s = recording.t_s
    for k in range(np.searchsorted(t_s, begin_s + length_s)):
        tracker.push_imu(t_s[k], recording.rate_b_rad_s[k], recording.force_b_m_s2[k])
        tracker.push_mag(t_s[k], field[k])
        tracker.advance(t_s[k])
        if t_s[k] < begin_s:
            continue
        sample_t_s.append(t_s[k])
        after_jump.append(len(looks))
        # The last look is a nanosecond before the next sample: the estimate that the jump starts from.
        for look_t_s in np.linspace(t_s[k], t_s[k + 1] - 1e-9, LOOKS_PER_INTERVAL):
            tracker.advance(look_t_s)
            attitude = tracker.attitude()
            looks.append([look_t_s, *attitude.q_nb, *attitude.sigma_rad])
    table = np.array(looks)
    return Zoom(table[:, 0], table[:, 1:5], table[:, 5:8], np.array(sample_t_s), np.array(after_jump))


def corrections_deg(zoom: Zoom) -> np.ndarray:
    """What the jumps since the first look have turned the estimate by, at each look (n x 3, deg, navigation axes).

    The flow alone keeps this constant, so a line of it is a staircase.
    """
    first = zoom.after_jump[1:]
    jumps = np.zeros((len(zoom.t_s), 3))
    jumps[first] = np.degrees(rotation_error_rad(zoom.q_nb[first - 1], zoom.q_nb[first]))
    return np.cumsum(jumps, axis=0)


def draw_hybrid(broad: Path) -> plots.Figure:
    """The picture, 1200 x 1000 pixels, from the BROAD trials in a folder."""
    zoom = look_between(read(find_trial(broad, TRIAL)), ZOOM_BEGIN_S, ZOOM_S, {"navigation_frame": "enu"})
    with plots.styled(), rc_context(plots.LARGE_TEXT):
        fig = plots.figure(1200, 1000)
        axes = list(fig.subplots(2, 1, sharex=True))
        draw_zoom(axes, zoom)
        fig.align_ylabels(axes)
        fig.tight_layout(h_pad=1.0)
    return fig


def draw_zoom(axes: list[plots.Axes], zoom: Zoom) -> None:
    """Staircase of the corrections and sawtooth of sigma, in thousandths of a degree over milliseconds."""
    t_ms = 1e3 * (zoom.t_s - zoom.t_s[0])
    samples_ms = 1e3 * (zoom.sample_t_s - zoom.t_s[0])
    names = ("east", "north", "up")
    turned = 1e3 * corrections_deg(zoom)
    sigma_deg = np.degrees(zoom.sigma_rad)
    change = 1e3 * (sigma_deg - sigma_deg.mean(axis=0))
    for panel, lines in zip(axes, (turned, change)):
        for t in samples_ms:
            panel.axvline(t, color="#DDDDDD", lw=0.8, zorder=0)
        panel.grid(axis="x", visible=False)
        panel.set_xlim(t_ms[0], t_ms[-1])
        for column, colour in enumerate(colours.AXIS_COLOURS):
            panel.plot(t_ms, lines[:, column], color=colour, label=f"about {names[column]}")
            panel.plot(t_ms[zoom.after_jump], lines[zoom.after_jump, column], "o", color=colour, ms=3)
    plots.legend_above(axes[0])
    axes[0].set_title("Rotation by the corrections")
    axes[0].set_ylabel("rotation / (0.001 deg)")
    axes[1].set_title("σ grows between samples and falls at each")
    axes[1].set_ylabel("σ less its mean / (0.001 deg)")
    axes[-1].set_xlabel(f"time after {zoom.t_s[0]:.3f} s / ms (grey lines: samples)")
