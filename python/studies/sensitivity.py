"""How much a filter's score hangs on each of its parameters: every one times and divided by a factor, one at a time.

    ./run study sensitivity DIR [--filter ahrs] [--factor 1.3]

DIR holds BROAD trials. Parameters are the real options that are not zero in the default preset; those that state a fact of
the place or the mounting, or belong to the integrators, are left out. Prints the mean total error in deg (hnav.reports.scores) and
the worst case.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any

import numpy as np
import typer
from rich.table import Table

from hnav.cli.console import say, show
from hnav.cli.parameters import FilterName, Folder
from hnav.filters.attitude import Filter
from hnav.filters.options import Options, option_table
from hnav.io.readers import read
from hnav.io.readers.broad import find_trials
from hnav.io.recordings import Recording
from hnav.reports.scores import score

NO_TUNING = (
    "start_q_nb", "q_body_sensor", "reference_strength_tesla", "reference_dip_rad", "solver_rtol", "solver_atol", "euler_step_s",
)  # fmt: skip


def tuned_options(filter: str) -> dict[str, float]:
    """The parameters and their default values."""
    defaults = Options(filter)
    return {
        name: getattr(defaults, name)
        for name, info in option_table(filter).items()
        if not (info.choices or info.is_integer or info.count > 1 or name in NO_TUNING) and getattr(defaults, name) != 0
    }


def mean_error_deg(recordings: Sequence[Recording], filter: str, **values: Any) -> float:
    """Mean over the recordings of the total error of the scored phase, deg; rates are held backward, closed form. Raises
    HnavError."""
    options = Options(filter, navigation_frame="enu", solver="closed_form", gyro_hold="backward", **values)
    totals = []
    for r in recordings:
        q_nb = Filter(options).run(r.t_s, r.rate_b_rad_s, r.force_b_m_s2, r.field_b_tesla, only=("q_nb",)).q_nb
        totals.append(score(q_nb, r.needed("reference_q_nb"), r.movement).total)
    return float(np.mean(totals))


def command(
    folder: Folder,
    filter: FilterName = "ahrs",
    factor: Annotated[float, typer.Option(min=1.0, help="Each parameter times and divided by this")] = 1.3,
) -> None:
    """Prints the mean total error with each parameter times and divided by a factor."""
    recordings = [read(path) for path in find_trials(folder).values()]
    title = f"{filter}: mean total error in deg, {len(recordings)} trials"
    table = Table("parameter", "default", f"x {factor:g}", f"/ {factor:g}", title=title)
    table.add_row("", "", f"{mean_error_deg(recordings, filter):.3f}", "as it is")
    worst = 0.0
    for name, value in tuned_options(filter).items():
        up, down = (mean_error_deg(recordings, filter, **{name: v}) for v in (value * factor, value / factor))
        worst = max(worst, up, down)
        table.add_row(name, f"{value:g}", f"{up:.3f}", f"{down:.3f}")
    show(table, width=110)
    say(f"worst: {worst:.3f} deg")
