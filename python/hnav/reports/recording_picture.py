"""The picture of a filter run over a recording: attitude, differences, innovations and bias over time."""

from __future__ import annotations

import numpy as np

from hnav.filters.health import findings
from hnav.reports import colours, plots
from hnav.reports.recording_run import RecordingRun, compare, tilt_sigma_deg


def draw_recording(run: RecordingRun) -> plots.Figure:
    """Attitude, differences in the filter's own 3 sigma, NIS, gyro bias, over time in s."""
    names = ["attitude"] + (["heading", "inclination"] if run.reference else ["sigma"]) + ["nis", "bias"]
    heights = [1.5] + [1.0] * (len(names) - 1)
    if findings(run.result.t_s, run.result.health):
        names.append("health")
        heights.append(0.6)
    with plots.styled():
        fig = plots.figure(850, 205 + round(230 * sum(heights)))
        grid = fig.subplots(len(names), 1, sharex=True, height_ratios=heights)
        _draw(dict(zip(names, grid, strict=True)), run)
        fig.align_ylabels()
        fig.tight_layout(h_pad=1.2, w_pad=2.0)
    return fig


def _draw(panels: dict[str, plots.Axes], run: RecordingRun) -> None:
    recording, result = run.recording, run.result
    t_s = recording.t_s - recording.t_s[0]
    reference_q_nb = run.reference_q_nb
    drawn = plots.draw_attitude(panels["attitude"], t_s, result.q_nb, reference_q_nb, run.reference)
    panels["attitude"].set_title(f"{recording.name}\n{drawn}, body to {'-'.join(run.axes)}")
    if reference_q_nb is None:
        plots.draw_sigma(panels["sigma"], t_s, np.degrees(result.sigma_rad), run.axes)
        panels["sigma"].set_title("Standard deviation of the rotation about")
    else:
        against = compare(recording.t_s, result.q_nb, reference_q_nb)
        plots.draw_error_band(panels["heading"], t_s, against.heading_deg, np.degrees(result.sigma_rad[:, 2]), "heading")
        panels["heading"].set_title(f"Heading against the {run.reference}")
        tilt = tilt_sigma_deg(result)
        plots.draw_error_band(
            panels["inclination"], t_s, against.inclination_deg, tilt, "inclination", colours.GREEN, one_sided=True
        )
        panels["inclination"].set_title(f"Inclination against the {run.reference}")
    plots.draw_nis(panels["nis"], t_s, {"force": result.accel_nis, "field": result.mag_nis})
    panels["nis"].set_title("Innovations")
    plots.draw_bias(panels["bias"], t_s, np.degrees(result.gyro_bias_rad_s), np.degrees(result.gyro_bias_sigma_rad_s))
    panels["bias"].set_title("Gyro bias")
    if "health" in panels:
        said = plots.draw_health(panels["health"], t_s, result.health)
        panels["health"].set_title("\n".join(said) or "Every sensor was ok")
    last = list(panels.values())[-1]
    last.set_xlabel("time / s")
    last.set_xlim(t_s[0], t_s[-1])
