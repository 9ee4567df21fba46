"""The paper's Table 1 beside ours: the turntable experiment by HEKF and HREKF, in closed co-simulation, many seeds.

    ./run study table1 --runs 200

Two regimes of the system `turntable` (models/systems/turntable). `fitted`: the paper prints no start covariance and no
rho; P0 = 1e-6 I and rho = 0.015 were searched for until its ratios came back. `fitted_honest`: the same sensors and the
same unknown start, with a start covariance that says how unknown it is. Beside both filters an EKF with a larger Q, see
studies.larger_q.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

import numpy as np
import typer
from rich.table import Table

from hnav.cli.console import show
from hnav.errors import HnavRuntimeError
from hnav.rotations import euler_rad
from hnav.systems.run_views import estimates, truth_q_nb
from hnav.systems.simulation import LoadedSystem, Run, simulate
from hnav.systems.statistics import mean_interval, ratio_interval
from studies.command import titled_table, tracked
from studies.larger_q import NAME, in_turntable

SYSTEM = "turntable"
FILTERS = {"HEKF": "hekf", "HREKF": "hrekf", NAME: "hekf"}  # the last in runs of its own, with the same samples
ANGLES = ("yaw", "pitch", "roll")
# Tabriz Journal of Electrical Engineering 54(4), 2024, Table 1: mean squared errors in deg^2.
PAPER = {"HEKF": (74.4, 1.418, 1.006), "HREKF": (20.6, 0.516, 0.400)}
REGIMES = {"fitted": "fitted: P0 and rho searched for", "fitted_honest": "honest P0"}
RECORDED = ("*.truth.q[?]", "*.att.q[?]", "*.att.sigma[1]", "*.align.started", "*.count.mag_used")


def squared_errors_deg2(run: Run) -> dict[str, np.ndarray]:
    """Mean squared error of yaw, pitch and roll of each filter over the run, from its first correction on: the attitude
    that it was given is not its own."""
    true_q_nb = truth_q_nb(run)
    assert true_q_nb is not None, f"system {run.about['system']} puts out no truth"
    truth = euler_rad(true_q_nb)
    found = {}
    for estimate in estimates(run):
        corrected = estimate.started & (run[f"{estimate.name}.count.mag_used"] > 1)  # the start takes the first sample
        error = np.degrees(np.angle(np.exp(1j * (euler_rad(estimate.q_nb[corrected]) - truth[corrected]))))
        found[estimate.name] = np.mean(error[:, ::-1] ** 2, axis=0)
    return found


def errors_of(system: LoadedSystem, regime: str, seed: int, settings: Mapping[str, str]) -> dict[str, np.ndarray]:
    run = simulate(system, regime, seed=seed, record=RECORDED, settings=settings)
    if run.about["failure"]:
        raise HnavRuntimeError("solver", f"{regime}, seed {seed}: {run.about['failure']}")
    return squared_errors_deg2(run)


def experiment(runs: int, regimes: list[str]) -> dict[str, dict[str, np.ndarray]]:
    """Regime -> filter -> squared errors (runs x 3). Seeds 1, 2, ... Raises HnavError when a run fails."""
    found: dict[str, dict[str, list[np.ndarray]]] = {regime: {name: [] for name in FILTERS} for regime in regimes}
    with LoadedSystem(SYSTEM) as system:
        for regime in regimes:
            for seed in tracked(range(1, runs + 1), regime):
                errors = [errors_of(system, regime, seed, settings) for settings in ({}, in_turntable(regime))]
                for name, component in FILTERS.items():
                    found[regime][name].append(errors[name == NAME][component])
    return {regime: {name: np.array(rows) for name, rows in of_regime.items()} for regime, of_regime in found.items()}


def table(found: dict[str, dict[str, np.ndarray]]) -> Table:
    """The paper's rows, and below them each regime with 95 % intervals."""
    runs = len(next(iter(next(iter(found.values())).values())))
    title = f"Table 1, mean squared error / deg², {runs} runs [95 % interval]"
    out = titled_table(title, " | ".join(("regime", "filter", *ANGLES, "yaw, HEKF / this")))
    for name, values in PAPER.items():
        ratio = f"{PAPER['HEKF'][0] / values[0]:.2f}" if name != "HEKF" else ""
        out.add_row("the paper" if name == "HEKF" else "", name, *(f"{v:.3g}" for v in values), ratio)
    for regime, filters in found.items():
        out.add_section()
        for name, errors in filters.items():
            cells = ["{:.3g} [{:.3g}, {:.3g}]".format(*mean_interval(column)) for column in errors.T]
            if name != "HEKF":
                cells.append("{:.2f} [{:.2f}, {:.2f}]".format(*ratio_interval(filters["HEKF"][:, 0], errors[:, 0])))
            out.add_row(REGIMES[regime] if name == "HEKF" else "", name, *cells)
    return out


def command(runs: Annotated[int, typer.Option(min=2, help="Seeds of each regime")] = 200) -> None:
    """Prints the paper's Table 1 beside ours."""
    show(table(experiment(runs, list(REGIMES))), width=190)
