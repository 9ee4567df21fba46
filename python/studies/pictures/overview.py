"""The picture of the README: what a hybrid filter does, on one trial of the BROAD data set.

Left, the attitude against the optical truth and the error inside the band of three sigma that the filter states.
Right, a few samples seen from near: the estimate flows between them, its covariance grows; at each it jumps, and the
covariance falls. Data: Laidig, Caruso, Cereatti, Seel, BROAD, Data 2021, 6(7), 72 (CC BY 4.0), not part of hnav.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hnav.filters.attitude import Filter, Options
from hnav.filters.rotations import rotation_error_rad
from hnav.fmi.engines import run_recording
from hnav.fmi.results import Result
from hnav.io.readers import read
from hnav.io.readers.broad import find_trial
from hnav.io.recordings import Recording
from hnav.reports import plots

TRIAL = 5  # slow rotation by hand with breaks, undisturbed field
SHOWN_S = (38.0, 58.0)
ZOOM_BEGIN_S, ZOOM_S = 47.9, 0.050
LOOKS_PER_INTERVAL = 24
CREDIT = "Data: BROAD trial {trial}, D. Laidig et al., Data 2021, 6(7), 72, doi 10.3390/data6070072, CC BY 4.0"


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


def draw_overview(broad: Path) -> plots.Figure:
    """The picture, 1600 x 900 pixels, from the BROAD trials in a folder."""
    recording = read(find_trial(broad, TRIAL))
    settings = {"navigation_frame": "enu"}
    result = run_recording(recording, "hrekf", "c", settings=settings)
    zoom = look_between(recording, ZOOM_BEGIN_S, ZOOM_S, settings)

    with plots.styled():
        fig = plots.figure(1600, 900)
        fig.text(0.035, 0.95, "hnav", fontsize=25, weight="bold", color=plots.INK)
        fig.text(
            0.107,
            0.967,
            "Attitude and heading as a hybrid system: an ODE solver carries estimate and covariance from sample to sample,",
            fontsize=12.5,
            color=plots.INK,
        )
        fig.text(
            0.107,
            0.942,
            "each sample of force and field makes them jump. One filter as C library, FMI 2 and FMI 3 FMU, and in Python.",
            fontsize=12.5,
            color=plots.INK,
        )
        grid = fig.add_gridspec(
            3,
            2,
            width_ratios=[1.55, 1],
            height_ratios=[1.5, 1, 1],
            left=0.05,
            right=0.985,
            top=0.875,
            bottom=0.095,
            hspace=0.42,
            wspace=0.15,
        )
        left = [fig.add_subplot(grid[row, 0]) for row in range(3)]
        right = grid[:, 1].subgridspec(2, 1, hspace=0.24)
        draw_against_truth(left, recording, result)
        draw_zoom([fig.add_subplot(right[row]) for row in range(2)], zoom)
        fig.align_ylabels(left)
        fig.text(0.985, 0.018, CREDIT.format(trial=TRIAL), ha="right", fontsize=8.5, color="#555555")
        fig.text(
            0.05,
            0.018,
            "Default preset, one for all 14 trials it was found on. Truth: optical motion capture.",
            fontsize=8.5,
            color="#555555",
        )
    return fig


def draw_against_truth(axes: list[plots.Axes], recording: Recording, result: Result) -> None:
    """Attitude, heading error and tilt error over the time shown."""
    shown = slice(*np.searchsorted(recording.t_s, SHOWN_S))
    t_s, q_nb, truth = recording.t_s[shown], result.q_nb[shown], recording.needed("reference_q_nb")[shown]
    error_deg = np.degrees(rotation_error_rad(q_nb, truth))
    sigma_deg = np.degrees(result.sigma_rad[shown])
    plots.draw_attitude(axes[0], t_s, q_nb, truth, "optical truth")
    axes[0].set_title("Attitude of a body turned by hand")
    plots.draw_error_band(axes[1], t_s, error_deg[:, 2], sigma_deg[:, 2], "heading")
    axes[1].set_title("Error of heading")
    plots.draw_error_band(axes[2], t_s, error_deg[:, 0], sigma_deg[:, 0], "tilt", plots.VERMILION)
    axes[2].set_title("Error of tilt about east")
    axes[2].set_xlabel("time / s")
    for panel in axes:
        panel.set_xlim(*SHOWN_S)
    for panel in axes[1:]:
        panel.set_ylabel("error / deg")


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
        for column, colour in enumerate(plots.AXIS_COLOURS):
            panel.plot(t_ms, lines[:, column], color=colour, label=f"about {names[column]}")
            panel.plot(t_ms[zoom.after_jump], lines[zoom.after_jump, column], "o", color=colour, ms=3)
        plots.legend_above(panel)
    axes[0].set_title("Jumps: turned by samples")
    axes[0].set_ylabel("rotation / (0.001 deg)")
    axes[1].set_title("σ: flows up, jumps down")
    axes[1].set_ylabel("σ less its mean / (0.001 deg)")
    axes[1].set_xlabel(f"time after {zoom.t_s[0]:.3f} s / ms (grey lines: samples)")
