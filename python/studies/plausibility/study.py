"""The command: false alarms on recordings without a fault, and what is said of recordings with one.

    ./run study plausibility [DIR] --seeds 100

Recordings without a fault are made, by sensors of each grade in turn (studies.plausibility.good); DIR is where BROAD trials lie.
Each fault (FAULTS) is put into hand-held recordings and, as far as there is DIR, into the trials.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import Annotated

import numpy as np
import typer
from rich.table import Table
from scipy.ndimage import uniform_filter1d

from hnav.cli.console import say, show
from hnav.cli.words import finding_line
from hnav.io.findings import Finding
from hnav.io.readers import read
from hnav.io.readers.broad import find_trials
from hnav.io.recordings import Recording
from hnav.io.sensors import GRADES
from hnav.units import G_M_S2
from studies.bench.stress import changed, with_rows
from studies.command import WORKERS, Trials, Workers, titled_table, tracked
from studies.plausibility.good import MOTIONS, good_recording
from studies.processes import in_order


@dataclass(frozen=True)
class Fault:
    """A fault, and the finding that it must give."""

    make: Callable[[Recording], Recording]
    sensor: str
    code: str
    value: str = ""  # of the argument that mends it

    def is_named_by(self, finding: Finding) -> bool:
        """Whether a finding says what it is, and the cure."""
        return (finding.sensor, finding.code, finding.value) == (self.sensor, self.code, self.value)


def _gravity_removed(r: Recording) -> Recording:
    """What a telephone calls linear acceleration: what is left above a slow mean."""
    held = np.where(np.isnan(r.force_b_m_s2), np.nanmean(r.force_b_m_s2, axis=0), r.force_b_m_s2)
    width = max(3, round(0.4 / float(np.median(np.diff(r.t_s)))))
    return replace(r, force_b_m_s2=r.force_b_m_s2 - uniform_filter1d(held, width, axis=0, mode="nearest", origin=-1))


def _gap(r: Recording) -> Recording:
    middle = 0.5 * (r.t_s[0] + r.t_s[-1])
    return with_rows(r, np.abs(r.t_s - middle) > 2.5)


def _rows_repeated(r: Recording) -> Recording:
    rows = np.arange(len(r.t_s)) // 2 * 2
    return replace(r, rate_b_rad_s=r.rate_b_rad_s[rows], force_b_m_s2=r.force_b_m_s2[rows])


def _field_held(r: Recording) -> Recording:
    """The last field is repeated in each row until there is a new one, at 5 Hz."""
    t_s, field = r.samples("mag")
    news = np.searchsorted(t_s, np.floor(r.t_s * 5) / 5, side="right") - 1
    return replace(r, field_b_tesla=field[np.clip(news, 0, None)])


def _of(array: str, change: Callable[[np.ndarray], np.ndarray]) -> Callable[[Recording], Recording]:
    return lambda r: changed(r, array, change)


def _without_field(make: Callable[[Recording], Recording]) -> Callable[[Recording], Recording]:
    return lambda r: replace(make(r), field_b_tesla=None)


_rate, _force, _field, _time = (partial(_of, array) for array in ("rate_b_rad_s", "force_b_m_s2", "field_b_tesla", "t_s"))
SWAPPED = [1, 0, 2]
FAULTS = {
    "force in g": Fault(_force(lambda x: x / G_M_S2), "accel", "unit", "g"),
    "force in mg": Fault(_force(lambda x: x / G_M_S2 * 1e3), "accel", "unit", "mg"),
    "force negated": Fault(_force(lambda x: -x), "accel", "sign", "accel=-x,-y,-z"),
    "force negated, no field": Fault(_without_field(_force(lambda x: -x)), "accel", "not_testable"),
    "gravity removed": Fault(_gravity_removed, "accel", "gravity_removed"),
    "force axes swapped": Fault(_force(lambda x: x[:, SWAPPED]), "accel", "axes", "accel=y,x,z"),
    "field axes swapped": Fault(_field(lambda x: x[:, SWAPPED]), "mag", "axes", "mag=y,x,z"),
    "field z negated": Fault(_field(lambda x: x * [1, 1, -1]), "mag", "axes", "mag=x,y,-z"),
    "rate axes swapped": Fault(_rate(lambda x: x[:, SWAPPED]), "gyro", "axes", "gyro=y,x,z"),
    "rate negated": Fault(_rate(lambda x: -x), "gyro", "axes", "gyro=-x,-y,-z"),
    "rate in deg/s": Fault(_rate(np.degrees), "gyro", "unit", "deg/s"),
    "rate in deg/s, no field": Fault(_without_field(_rate(np.degrees)), "gyro", "unit", "deg/s"),
    "time in ms": Fault(_time(lambda x: x * 1e3), "time", "unit", "ms"),
    "time in us": Fault(_time(lambda x: x * 1e6), "time", "unit", "us"),
    "time in ns": Fault(_time(lambda x: x * 1e9), "time", "unit", "ns"),
    "half the rate": Fault(_time(lambda x: x * 2), "gyro", "scale"),
    "field in uT": Fault(_field(lambda x: x * 1e6), "mag", "unit", "uT"),
    "field in G": Fault(_field(lambda x: x * 1e4), "mag", "unit", "G"),
    "field in nT": Fault(_field(lambda x: x * 1e9), "mag", "unit", "nT"),
    "hard iron of 200 uT": Fault(_field(lambda x: x + [2e-4, 0, 0]), "mag", "strength"),
    "force all zero": Fault(_force(lambda x: x * 0), "accel", "all_zero"),
    "rates missing": Fault(_rate(lambda x: x * np.nan), "gyro", "no_samples"),
    "field all zero": Fault(_field(lambda x: x * 0), "mag", "all_zero"),
    "field stuck": Fault(_field(lambda x: x * 0 + [2e-5, 0, 4e-5]), "mag", "constant"),
    "an axis of the rates dead": Fault(_rate(lambda x: x * [1, 0, 1] + 0.0), "gyro", "constant"),  # no negative zero
    "gap of 5 s": Fault(_gap, "gyro", "gaps"),
    "rates clipped": Fault(_rate(lambda x: np.clip(x * 2, -2.2, 2.2)), "gyro", "saturated"),
    "rows repeated": Fault(_rows_repeated, "gyro", "repeated", "yes"),
    "field held": Fault(_field_held, "mag", "repeated", "yes"),
}


# --------------------------------------------------------------------------------------------- the command


SPOILT = 5  # recordings that each fault is put into


def command(
    folder: Trials = None,
    seeds: Annotated[int, typer.Option(min=1, help="Recordings without a fault, of each motion")] = 100,
    workers: Workers = WORKERS,
) -> None:
    """Counts the false alarms of the checks of recordings, and the faults that they find."""
    trials = [read(path) for path in find_trials(folder).values()] if folder else []
    alarms = dict(false_alarms(seeds, workers))
    if trials:
        alarms["BROAD"] = [alarms_of(trial) for trial in trials]
    show(alarm_table(alarms))
    made = [good_recording("hand", GRADES[seed % len(GRADES)], 1000 + seed) for seed in range(SPOILT)]
    # Their units are then assumed, as those of a file that says nothing.
    show(fault_table(made, [replace(trial, origin=None) for trial in trials]), width=190)
    say("named: the finding of the sensor, with the right cure; said: another warning or error")


def alarms_of(recording: Recording) -> list[Finding]:
    return [finding for finding in recording.check() if finding.level != "note"]


def one(job: tuple[str, int]) -> tuple[str, list[Finding]]:
    motion, seed = job
    return motion, alarms_of(good_recording(motion, GRADES[seed % len(GRADES)], seed))


def false_alarms(seeds: int, workers: int) -> dict[str, list[list[Finding]]]:
    """By motion, of each recording."""
    jobs = list(product(MOTIONS, range(seeds)))
    found: dict[str, list[list[Finding]]] = {motion: [] for motion in MOTIONS}
    for motion, findings in tracked(in_order(one, jobs, workers, 4), "recordings", len(jobs)):
        found[motion].append(findings)
    return found


def alarm_table(alarms: dict[str, list[list[Finding]]]) -> Table:
    table = Table("without a fault", "recordings", "with a warning", "which", title="false alarms", title_justify="left")
    for motion, found in alarms.items():
        codes = Counter(f"{finding.sensor} {finding.code}" for findings in found for finding in findings)
        table.add_row(motion, str(len(found)), str(sum(map(bool, found))), ", ".join(f"{c} {n}" for c, n in codes.items()) or "-")
    return table


def outcomes(fault: Fault, recordings: list[Recording]) -> Iterator[str]:
    """named, said or silent, of each recording."""
    for recording in recordings:
        findings = fault.make(recording).check()
        alarms = [finding for finding in findings if finding.level != "note" or finding.code == fault.code]
        yield "named" if any(fault.is_named_by(finding) for finding in alarms) else "said" if alarms else "silent"


def fault_table(made: list[Recording], trials: list[Recording]) -> Table:
    heads = "hand: named | said | silent" + " | BROAD: named | said | silent" * bool(trials)
    table = titled_table("faults", "fault | what is said", heads)
    for name, fault in FAULTS.items():
        said = next((finding_line(finding) for finding in fault.make(made[0]).check() if fault.is_named_by(finding)), "")
        counts = [Counter(outcomes(fault, some)) for some in (made, trials) if some]
        table.add_row(name, said, *(str(count[word]) for count in counts for word in ("named", "said", "silent")))
    return table
