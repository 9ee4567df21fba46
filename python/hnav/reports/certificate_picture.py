"""The picture of a certificate: Lyapunov value of simulated starts under the certified bound, and the decay over the run."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from matplotlib.figure import Figure

from hnav.reports.colours import BLUE, FAINT, INK, VERMILION
from hnav.reports.plots import figure, legend_above, styled

LEAST_SHOWN = 1e-8  # smallest V shown, as a share of the level


class Starts(Protocol):
    """Simulated errors that begin on the boundary of the region: how many, and their V over the level, starts x (n + 1)."""

    @property
    def starts(self) -> int: ...
    @property
    def V(self) -> np.ndarray: ...


class Certificate(Protocol):
    """The figures of a certificate of n corrections for the picture; hnav.certify.certificate has the meaning of each."""

    name: str
    certified: bool
    interval_s: float
    rate_1_s: float
    region_rate_1_s: float
    noise_share: float
    t_s: np.ndarray  # n
    free_rate_1_s: np.ndarray  # n - 1

    @property
    def starts(self) -> Starts | None: ...


def draw_certificate(found: Certificate) -> Figure:
    """Above: V over the level of its region (1), log scale; below: rates in 1/s; time in s."""
    with styled():
        picture = figure(1100, 760)
        upper, lower = picture.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        begin_s = found.t_s[0] - found.interval_s
        if found.starts is None:
            upper.text(0.5, 0.5, "no region", transform=upper.transAxes, ha="center", color=FAINT)
        else:
            t_s = np.r_[begin_s, found.t_s]
            V = np.maximum(found.starts.V, LEAST_SHOWN)
            low, middle, high = np.min(V, axis=0), np.median(V, axis=0), np.max(V, axis=0)
            drawn = f"{found.starts.starts} starts on the boundary"
            upper.fill_between(t_s, low, high, color=BLUE, alpha=0.18, lw=0, label=drawn)
            upper.plot(t_s, middle, color=BLUE, label="their median")
            bound = np.exp(-2 * found.region_rate_1_s * (t_s - begin_s))
            upper.plot(t_s, bound, color=VERMILION, ls="--", label=f"certified bound, |e| by {found.region_rate_1_s:.3g} 1/s")
            if np.isfinite(found.noise_share):
                upper.axhline(found.noise_share, color=INK, lw=0.9, ls=":", label="noise floor")
            upper.set_yscale("log")
            legend_above(upper)
        upper.set_ylabel("V / level")
        verdict = "certified" if found.certified else "not certified"
        upper.set_title(f"{found.name}: {verdict}", pad=24)
        free = "e'P⁻¹e with the filter's own P, correction by correction"
        lower.plot(found.t_s[1:], found.free_rate_1_s, color=BLUE, lw=0.9, label=free)
        if np.isfinite(found.rate_1_s):
            lower.axhline(found.rate_1_s, color=VERMILION, ls="--", label=f"one P for all: {found.rate_1_s:.3g} 1/s")
        lower.set_ylim(0, 1.1 * np.nanmax([found.rate_1_s, *found.free_rate_1_s]))
        lower.set_ylabel("decay rate / (1/s)")
        lower.set_xlabel("time / s")
        legend_above(lower)
        picture.align_ylabels()
        picture.subplots_adjust(left=0.08, right=0.98, top=0.9, bottom=0.08, hspace=0.2)
        return picture
