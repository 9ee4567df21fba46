"""The command: false alarms on recordings without a fault, and what is said of recordings with one.

    ./run study plausibility [DIR] --seeds 100

Recordings without a fault are made, by sensors of each grade in turn (studies.plausibility.good); DIR is where BROAD trials lie.
Each fault (studies.plausibility.faults) is put into hand-held recordings and, as far as there is DIR, into the trials.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from typing import Annotated

import typer
from rich.table import Table

from hnav.cli.console import say, show
from hnav.cli.words import finding_line
from hnav.io.findings import Finding
from hnav.io.readers import read
from hnav.io.readers.broad import find_trials
from hnav.io.recordings import Recording
from hnav.io.sensors import GRADES
from studies.command import WORKERS, Trials, Workers, titled_table, tracked
from studies.plausibility.faults import FAULTS, Fault
from studies.plausibility.good import MOTIONS, good_recording
from studies.processes import in_order

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
