"""The picture of the README: attitude by the recommended filter against optical truth, and the error in the band that it states.

The trial is the middle one: of the 14 that hnav compare lists, seven have a smaller total error. Data: Laidig, Caruso,
Cereatti, Seel, BROAD, Data 2021, 6(7), 72 (CC BY 4.0), not part of hnav.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib import rc_context

from hnav.filters.attitude import Filter
from hnav.filters.attitude_answers import Run
from hnav.filters.options import Options
from hnav.io.readers import read
from hnav.io.readers.broad import find_trial
from hnav.io.recordings import Recording
from hnav.reports import colours, plots
from hnav.rotations import rotation_error_rad

TRIAL = 3  # slow rotation by hand, undisturbed field
SHOWN_S = 40.0  # from the first motion on
CREDIT = "Data: BROAD trial {trial}, D. Laidig et al., Data 2021, 6(7), 72, CC BY 4.0"


def filtered(recording: Recording) -> Run:
    """What the AHRS makes of it, with its defaults."""
    filter = Filter(Options("ahrs", navigation_frame="enu"))
    return filter.run(recording.t_s, recording.rate_b_rad_s, recording.force_b_m_s2, recording.field_b_tesla)


def draw_overview(broad: Path) -> plots.Figure:
    """The picture, 1200 x 900 pixels, from the BROAD trials in a folder."""
    recording = read(find_trial(broad, TRIAL))
    run = filtered(recording)
    with plots.styled(), rc_context(plots.LARGE_TEXT):
        fig = plots.figure(1200, 900)
        axes = list(fig.subplots(3, 1, sharex=True, height_ratios=[1.5, 1, 1]))
        draw_against_truth(axes, recording, run)
        fig.align_ylabels(axes)
        fig.tight_layout(h_pad=1.0, rect=(0, 0.03, 1, 1))
        fig.text(0.985, 0.012, CREDIT.format(trial=TRIAL), ha="right", fontsize=11, color="#555555")
    return fig


def draw_against_truth(axes: list[plots.Axes], recording: Recording, run: Run) -> None:
    """Attitude, heading error and tilt error over the time shown; the error's scale is that of the band."""
    begin_s = recording.t_s[np.flatnonzero(recording.needed("movement"))[0]]
    shown = slice(*np.searchsorted(recording.t_s, [begin_s, begin_s + SHOWN_S]))
    t_s, q_nb, truth = recording.t_s[shown] - begin_s, run.q_nb[shown], recording.needed("reference_q_nb")[shown]
    error_deg = np.degrees(rotation_error_rad(q_nb, truth))
    sigma_deg = np.degrees(run.sigma_rad[shown])
    plots.draw_attitude(axes[0], t_s, q_nb, truth, "optical truth")
    axes[0].set_title("Quaternion of a body turned by hand")
    axes[1].set_title("Error of heading")
    axes[2].set_title("Error of tilt about east")
    plots.draw_error_band(axes[1], t_s, error_deg[:, 2], sigma_deg[:, 2], "heading")
    plots.draw_error_band(axes[2], t_s, error_deg[:, 0], sigma_deg[:, 0], "tilt", colours.VERMILION)
    axes[2].set_xlabel("time / s")
    axes[2].set_xlim(0, SHOWN_S)
    for panel in axes[1:]:
        panel.set_ylabel("error / deg")
