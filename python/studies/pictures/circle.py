"""The picture of the INS's heading search: a Gaussian of u = (cos alpha, sin alpha) and the heading's density on the circle.

A car gains speed along body x with an unknown heading. Each velocity of GNSS is linear in u, equation (N3) of docs/filter_ins.md, and
corrects its Gaussian, which starts with the moments of the uniform distribution. (N4) restricts it to the circle.
"""

from __future__ import annotations

import numpy as np
from matplotlib import rc_context

from hnav.reports import colours, plots

HEADING_RAD = np.radians(40.0)
GAIN_M_S2, FIX_S, SIGMA_M_S = 1.0, 0.2, 0.5  # acceleration, interval of the fixes, white noise of a velocity
FIXES = (0, 2, 4, 12)  # after so many fixes
SEED = 37  # of the first 101 the one with the median error over sigma


def posteriors() -> list[tuple[np.ndarray, np.ndarray]]:
    """Mean (2) and covariance (2 x 2) of u after each number of FIXES."""
    rng = np.random.default_rng(SEED)
    m, S, found = np.zeros(2), 0.5 * np.eye(2), []
    for k in range(max(FIXES) + 1):
        if k > 0:
            speed = GAIN_M_S2 * FIX_S * k
            z = speed * np.array([np.cos(HEADING_RAD), np.sin(HEADING_RAD)]) + rng.normal(0, SIGMA_M_S, 2)
            H = np.array([[z[0], z[1]], [z[1], -z[0]]])
            gain = S @ H.T @ np.linalg.inv(H @ S @ H.T + SIGMA_M_S**2 * np.eye(2))
            m = m + gain @ (np.array([speed, 0.0]) - H @ m)
            S = (np.eye(2) - gain @ H) @ S
        if k in FIXES:
            found.append((m, S))
    return found


def density(alpha: np.ndarray, m: np.ndarray, S: np.ndarray) -> np.ndarray:
    """(N4) at equally spaced angles of the whole circle, 1/rad."""
    off = np.stack([np.cos(alpha), np.sin(alpha)]) - m[:, None]
    p = np.exp(-0.5 * np.einsum("ik,ij,jk->k", off, np.linalg.inv(S), off))
    return np.asarray(p / (p.sum() * (alpha[1] - alpha[0])))


def draw_circle() -> plots.Figure:
    """The Gaussian of u with its 1-sigma ellipse, and the density of the heading; 1200 x 620 pixels."""
    alpha = np.linspace(-np.pi, np.pi, 720, endpoint=False)
    circle = np.stack([np.cos(alpha), np.sin(alpha)])
    with plots.styled(), rc_context(plots.LARGE_TEXT):
        fig = plots.figure(1200, 620)
        plane, line = fig.subplots(1, 2, width_ratios=(1, 1.15))
        plane.plot(*circle, color="black", lw=1, ls=":", label="|u| = 1")
        for number, (m, S), colour in zip(FIXES, posteriors(), ("#999999", *colours.AXIS_COLOURS)):
            plane.plot(*(m[:, None] + np.linalg.cholesky(S) @ circle), color=colour)
            line.plot(np.degrees(alpha), density(alpha, m, S), color=colour, label=f"{number} fixes")
        plane.plot(np.cos(HEADING_RAD), np.sin(HEADING_RAD), "k+", ms=14, mew=2, label="truth")
        line.axvline(np.degrees(HEADING_RAD), color="black", lw=1, label="truth")
        plane.set(xlabel="u₁ = cos α", ylabel="u₂ = sin α", xlim=(-1.15, 1.15), ylim=(-1.15, 1.15), aspect="equal")
        line.set(xlabel="heading α / deg", ylabel="density / (1/rad)", xlim=(-180, 180), xticks=np.arange(-180, 181, 90))
        plane.set_title("1σ ellipse of u")
        line.set_title("Density of the heading")
        plots.legend_above(plane)
        line.legend(loc="upper left", handlelength=1.4)
        fig.tight_layout(w_pad=1.5)
    return fig
