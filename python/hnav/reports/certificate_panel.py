"""Panel of the report about the stability certificate that `hnav certify DIR --out DIR/certificate.json` left beside a run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hnav.reports.panels import panel, table
from hnav.systems.results import Run

# Key in certificate.json, unit, meaning. Figures that were not reached are null in the file and are left out.
FIGURES = (
    ("longest_window", "", "corrections in the longest window, which ends when every sensor was seen"),
    ("unfinished", "", "corrections at the end in a window that did not end: the error is bounded there, no decay is claimed"),
    ("rate_1_s", "1/s", "decay of small errors, one P for all windows"),
    ("spectral_rate_1_s", "1/s", "of the slowest single window: no certificate can exceed it"),
    ("region_deg", "deg", "largest attitude error inside the region"),
    ("sure_deg", "deg", "every attitude error below is inside, without bias error"),
    ("region_bias_deg_s", "deg/s", "largest bias error inside the region"),
    ("region_rate_1_s", "1/s", "decay inside the region, remainders included"),
    ("noise_floor_deg", "deg", "bound on the rms attitude error that noise sustains"),
    ("longest_interval_s", "s", "longest interval with these gains: linear part, all corrections equally far apart, gains frozen"),
    ("dwell_ratio", "", "the same in actual intervals"),
    ("interval_limit_s", "s", "beyond it the error grows over a single window"),
    ("mixed_interval_s", "s", "linear part, intervals from the actual one to this in any order"),
    ("region_interval_s", "s", "with the nonlinear remainders, in a region of half the radius, no decay asked"),
    ("attenuation", "", "error energy over disturbance energy"),
    ("gamma_squared", "", "what the attenuation must stay below"),
    ("free_rate_min_1_s", "1/s", "solver-free rate at the slowest correction"),
    ("free_rate_median_1_s", "1/s", "its median"),
    ("corrections", "", "corrections, every one verified by its eigenvalues when certified"),
)  # fmt: skip


def verdict(figures: Mapping[str, Any]) -> str:
    return "certified" if figures["certified"] else f"not certified: {figures['reason']}"


@panel("certificate", "Stability certificate", "Of the gains that the HREKF of this run has on its samples: hnav certify DIR --out DIR/certificate.json.",
       lambda run: "certificate" in run.about)  # fmt: skip
def certificate_panel(run: Run) -> str:
    found = run.about["certificate"]
    known = [figure for figure in FIGURES if isinstance(found.get(figure[0]), (int, float))]
    rows = [(key, f"{found[key]:.4g} {unit}".strip(), meaning) for key, unit, meaning in known]
    return table(["figure", "value", "meaning"], [("verdict", verdict(found), ""), *rows])
