"""How to choose gamma: error, stated sigma and measured attenuation of the HREKF over the rate of its robust law.

    ./run study gamma [--seeds 20] [--picture FILE]

The runs of studies.robust. Error and sigma are root mean squares of the whole attitude over 5 to 20 s with the noise as stated.
Convergence is the median time to 3 deg from a heading 135 deg off, with 5 deg claimed (studies.convergence). The attenuation is the
error energy over the disturbance energy (hnav.certify.attenuation), which the law bounds by gamma^2: median and largest of the seeds,
beside the largest gamma^2 that was used.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pandas as pd
import typer

from hnav.certify.attenuation import attenuation
from hnav.certify.gain_record import record_gains
from hnav.cli.console import show
from hnav.filters.attitude import Filter
from hnav.filters.options import Options
from hnav.io.recordings import Recording
from hnav.reports.colours import BLUE, GREEN, VERMILION
from hnav.reports.plots import figure
from studies.command import WORKERS, Workers, draw_into, titled_table
from studies.convergence import RATE_HZ, TILT_RAD, options_of, runs_of, settles, start_of
from studies.processes import in_order
from studies.robust import SETTLED_S, Run, attitude_error_deg

RATES_1_S = (0.03, 0.1, 0.3, 0.75, 1.5, 3.0, 5.0, 8.0, 12.0, 20.0)
MODES = ("relative", "kl")
ERROR_DEG, CLAIM_DEG = 135.0, 5.0
RECORDED_S = 5.0  # of each run: the reference that records the gains is slow


def ratio(run: Run, options: Options) -> tuple[float, float]:
    """Attenuation of the first seconds, and the largest gamma^2 in them; the bias is taken at its mean."""
    n = round(RECORDED_S * RATE_HZ)
    recording = Recording("robust", run.t_s[:n], run.rate[:n], run.force[:n], run.field[:n])
    record = record_gains(recording, options)
    rows = np.searchsorted(recording.t_s, [c.t_s for c in record.corrections])
    weight = np.repeat([options.gamma_weight_attitude, options.gamma_weight_bias], 3)
    q = run.attitude.as_quat()[:, [3, 0, 1, 2]]
    found = attenuation(record.corrections, q[rows], run.bias[:n].mean(axis=0), weight)
    return found, max(c.gamma for c in record.corrections) ** 2


def measured(case: tuple[str, float], seeds: int) -> dict[str, Any]:
    """Of one mode (off: the HEKF) and rate, over the seeds: error and sigma in deg, seconds until below 3 deg, attenuation and
    its largest, and the smallest gamma^2 of the seeds; infinite for never and for off."""
    mode, rate = case
    law = {} if mode == "off" else {"gamma_mode": mode, f"gamma_{mode}_rate_1_s": rate}
    runs = runs_of(seeds)
    errors, sigmas, seconds, ratios = [], [], [], []
    for seed, run in enumerate(runs):
        near = start_of(run, seed, 0.0)
        chosen = options_of(law, near, TILT_RAD)
        made = Filter(chosen).run(run.t_s, run.rate, run.force, run.field)
        settled = run.t_s >= SETTLED_S
        errors.append(np.mean(attitude_error_deg(made.q_nb, run.attitude)[settled] ** 2))
        sigmas.append(np.mean(np.sum(np.degrees(made.sigma_rad[settled]) ** 2, axis=1)))
        far = Filter(options_of(law, start_of(run, seed, ERROR_DEG), np.radians(CLAIM_DEG)))
        seconds.append(settles(attitude_error_deg(far.run(run.t_s, run.rate, run.force, run.field).q_nb, run.attitude)))
        ratios.append(ratio(run, chosen))
    attenuations, bounds = np.array(ratios).T
    rmse_deg, sigma_deg = (float(np.sqrt(np.mean(squares))) for squares in (errors, sigmas))
    return {
        "mode": mode, "rate_1_s": rate, "rmse_deg": rmse_deg, "sigma_deg": sigma_deg, "ratio": rmse_deg / sigma_deg,
        "seconds": np.median(seconds), "attenuation": np.median(attenuations), "worst": attenuations.max(), "gamma_squared": bounds.min(),
    }  # fmt: skip


def draw(found: pd.DataFrame) -> Any:
    """Three panels over the rate: error and sigma, time to converge, attenuation and its bound; dotted: without the law."""
    picture = figure(720, 1150)
    picture.set_layout_engine("constrained")
    panels = picture.subplots(3, 1, sharex=True)
    shown = (
        (("rmse_deg", "error", BLUE), ("sigma_deg", "stated sigma", VERMILION)),
        (("seconds", f"from {ERROR_DEG:g} deg, {CLAIM_DEG:g} claimed", GREEN),),
        (("worst", "measured, largest", BLUE), ("gamma_squared", "bound gamma²", VERMILION)),
    )
    attenuations = "attenuation: error energy over disturbance energy"
    titles = ("attitude after convergence, deg", "median s until below 3 deg", attenuations)
    off = found[found["mode"] == "off"].iloc[0]
    for ax, title, lines in zip(panels, titles, shown):
        for name, label, colour in lines:
            for mode, style in zip(MODES, ("-", "--")):
                laws = found[found["mode"] == mode]
                known = laws[name].where(np.isfinite(laws[name]))
                ax.plot(laws.rate_1_s, known, style, marker=".", color=colour, label=f"{label}, {mode}", linewidth=2)
            if np.isfinite(off[name]):
                ax.axhline(off[name], color=colour, linestyle=":", linewidth=1.5)
        ax.set_title(title, fontsize=14)
        ax.set_xscale("log")
        ax.tick_params(labelsize=13)
        ax.grid(alpha=0.3)
        ax.legend(fontsize=12)
    for ax in panels[:2]:
        ax.set_ylim(bottom=0)
    panels[2].set_yscale("log")
    panels[2].set_xlabel("rate of gamma, 1/s (dotted: without the law)", fontsize=14)
    return picture


def command(
    seeds: Annotated[int, typer.Option(min=2, help="of each figure")] = 20,
    workers: Workers = WORKERS,
    picture: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw error, sigma, time and attenuation over the rate")
    ] = None,
) -> None:
    """Error, stated sigma, convergence and attenuation over the rate of the robust law."""
    cases = [("off", 0.0), *((mode, rate) for mode in MODES for rate in RATES_1_S)]
    found = pd.DataFrame(in_order(partial(measured, seeds=seeds), cases, workers))
    table = titled_table(
        f"the robust law by its rate; {seeds} seeds", "law | rate, 1/s",
        "error, deg | sigma, deg | error/sigma | s to 3 deg | attenuation | largest | gamma^2",
    )  # fmt: skip
    for mode, rate, *figures in found.itertuples(index=False):
        table.add_row(mode, f"{rate:g}", *("-" if np.isinf(value) else f"{value:.3g}" for value in figures))
    show(table, width=120)
    draw_into(picture, draw, found)
