"""hnav simulate: one run of a system of FMUs, kept in a folder."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hnav.cli.completion import scenario_names
from hnav.cli.console import counting, say
from hnav.cli.parameters import with_groups
from hnav.cli.system_options import Setup, SystemName
from hnav.cli.words import UsageError
from hnav.io.outputs import refuse_overwriting
from hnav.systems.simulation import ABOUT, SIGNALS, simulate, write_run
from hnav.systems.ssp_reader import system_files


@with_groups
def command(
    system: SystemName,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for signals.h5 and run.json")] = Path("simulation_out"),
    scenario: Annotated[
        str | None, typer.Option(help="A scenario of the system; hnav systems NAME lists them", autocompletion=scenario_names)
    ] = None,
    seed: Annotated[int | None, typer.Option(help="Seed of every component that has one")] = None,
    *,
    setup: Setup,
) -> None:
    chosen = setup.arguments()
    refuse_overwriting([out / SIGNALS, out / ABOUT], system_files(system))
    with counting(system) as show:
        run = simulate(system, scenario, seed=seed, progress=show, **chosen)
    write_run(run, out)
    wall = ", ".join(f"{name} {1e6 * seconds / max(1, len(run.t_s) - 1):.1f}" for name, seconds in run.about["wall_s"].items())
    length = f"{len(run.t_s)} points to {run.t_s[-1]:g} s, step {run.about['step_s']:g} s"
    say(f"{length}, {len(run.columns)} signals to {out}; us/step: {wall}")
    for name, lost in run.about["lost"].items():
        if lost:
            say(f"{name} lost {lost} samples between the communication points: take a finer --step")
    if run.about["failure"]:
        raise UsageError(f"{run.about['failure']}; the samples until then are in {out}")
