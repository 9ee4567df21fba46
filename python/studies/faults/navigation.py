"""The faults of studies.ins.faults as a table: a row for each kind of vehicle and fault."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from rich.table import Table

from hnav.filters.readiness import LIMITS
from studies.command import titled_table, tracked
from studies.ins.faults import FAULTS, FLAGS, GOOD, RECOVERY_S, hindsights, outcomes


def fault_table(kinds: Sequence[str], names: Sequence[str], starts: int, seed: int, workers: int, folder: Path | None) -> Table:
    """kinds: of studies.ins.faults.KINDS, or FLIGHT with its folder; names: of FAULTS. A bar shows the starts."""
    out = titled_table(
        f"ins, {starts} starts each, seed {seed}; back: within {RECOVERY_S:g} s after the end; lies, beyond: share of the time",
        "body | fault | lasts",
        f"back | slowest, s: {' / '.join(GOOD)} | worst | at the end, median | lies: {' / '.join(FLAGS)} "
        "| beyond levels: horizontal / vertical / heading | ready",
    )
    for kind in kinds:
        found = list(tracked(outcomes(kind, names, starts, seed, workers, folder), kind, starts))
        for i, name in enumerate(names):
            out.add_row(kind, FAULTS[name].text, f"{FAULTS[name].length_s:g} s", *_cells([of_start[i] for of_start in found]))
    return out


def hindsight_table(kinds: Sequence[str], names: Sequence[str], starts: int, seed: int, workers: int) -> Table:
    """Of simulated bodies: root mean squares of filter and smoother over the rows that both know, and how often each is ready and wrong."""
    out = titled_table(
        f"ins, {starts} starts each, seed {seed}: rms of filter > smoother; lies: share of all rows",
        "body | fault",
        " | ".join(f"{what}: rms | lies" for what in FLAGS),
    )
    for kind in kinds:
        found = list(tracked(hindsights(kind, names, starts, seed, workers), kind, starts))
        for i, name in enumerate(names):
            cells = []
            for what in FLAGS:
                before, after = np.sqrt(np.mean(np.square([of_start[i][0][what] for of_start in found]), axis=0))
                lies = np.mean([of_start[i][1][what] for of_start in found], axis=0)
                unit, per_si = LIMITS[what].unit, LIMITS[what].per_si
                cells += [f"{per_si * before:.3g} > {per_si * after:.3g} {unit}", f"{lies[0]:.1%} > {lies[1]:.1%}"]
            out.add_row(kind, FAULTS[name].text, *cells)
    return out


def _cells(of: Sequence[dict[str, Any]]) -> list[str]:
    table = pd.DataFrame(of)
    back_s, at_end, lies = (pd.DataFrame([*table[name]]) for name in ("back_s", "at_end", "lies"))
    position, tilt, heading = at_end.median()[[*GOOD]]
    return [
        f"{table.is_back.sum()} of {len(of)}",
        " / ".join(f"{s:.0f}" if np.isfinite(s) else "never" for s in back_s.max()[[*GOOD]]),
        f"{table.largest_m.max():.3g} m",
        f"{position:.1f} m / {np.degrees(tilt):.2f} / {np.degrees(heading):.2f} deg",
        " / ".join(f"{share:.1%}" for share in lies.mean()[[*FLAGS]]),
        " / ".join(f"{share:.2%}" for share in np.mean([*table.beyond], axis=0)),
        f"{table.ready.mean():.0%}",
    ]
