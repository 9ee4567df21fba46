"""The command: builds the mutated copy, tries every mutant, prints what lives."""

from __future__ import annotations

import csv
import os
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Annotated, NamedTuple

import typer
from rich.table import Table

from hnav.cli.console import say, show
from hnav.cli.words import UsageError
from hnav.places import CHECKOUT
from studies.command import tracked
from studies.mutants.mutated_copy import ROOMS, chosen, room_of, write_copy
from studies.mutants.sites import Mutant
from studies.mutants.trials import Build, Test, trial, with_reach

COUNT = 200
COUNT_OF_ROOM = 30
EVERYTHING = 10**9
GOAL = 0.9  # share of the mutants that differ from the original
EQUIVALENT = Path(__file__).parent / "equivalent.csv"


class Fate(NamedTuple):
    """The result of one mutant. by: the test that failed; empty if it survived."""

    mutant: Mutant
    by: str
    reached: bool
    equivalent: bool

    @property
    def lives(self) -> bool:
        return not self.by and not self.equivalent


def equivalents() -> dict[str, str]:
    """Name to reason."""
    with EQUIVALENT.open(newline="", encoding="utf-8") as file:
        return {row["name"]: row["reason"] for row in csv.DictReader(file)}


def fates(build: Build, tests: list[Test], mutants: list[Mutant]) -> Iterator[Fate]:
    """Of these mutants, in their order, on as many processes as there are cores."""
    same = equivalents()
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        found = pool.map(lambda mutant: trial(build, tests, mutant.name), mutants)
        for mutant, by in zip(mutants, found):
            yield Fate(mutant, by, any(mutant.name in test.reached for test in tests), mutant.name in same)


def table_of(found: list[Fate]) -> Table:
    """A row for each room, and one for all."""
    table = Table("room", "mutants", "killed by C++", "by Python alone", "by time-out", "equivalent", "alive", "killed, %")
    for room in (*ROOMS, "all"):
        of_room = [fate for fate in found if room in ("all", room_of(fate.mutant))]
        killed = [fate.by for fate in of_room if fate.by]
        python, late = sum("python_tests/" in by for by in killed), sum(by.startswith("time-out") for by in killed)
        equivalent, alive = sum(not f.by and f.equivalent for f in of_room), sum(f.lives for f in of_room)
        numbers = (len(of_room), len(killed) - python - late, python, late, equivalent, alive)
        share = f"{100 * len(killed) / (len(killed) + alive):.0f}" if killed or alive else ""
        table.add_row(room, *map(str, numbers), share)
    return table


def line_of(fate: Fate) -> str:
    mutant = fate.mutant
    how = fate.by or ("alive" if fate.reached else "alive, reached by no test")
    return f"{mutant.name} {mutant.path}:{mutant.line} {mutant.says}: {how}"


def asked_for(mutants: list[Mutant], only: str) -> list[Mutant]:
    """Those whose name is, or whose path has, one of the words; all without words."""
    words = [word for word in only.split(",") if word]
    found = [mutant for mutant in mutants if not words or any(word == mutant.name or word in mutant.path for word in words)]
    if not found:
        raise UsageError(f"--only {only} is no mutant's name or path")
    return found


def tried(build: Build, mutants: list[Mutant]) -> list[Fate]:
    """Runs each mutant with every test that reaches it, until one fails."""
    tests = [with_reach(build, test) for test in tracked(list(build.tests()), "what each test reaches")]
    return list(tracked(fates(build, tests, mutants), "mutants", len(mutants)))


def command(
    only: Annotated[
        str,
        typer.Option(
            metavar="ROOM|TEXT,...", help="30 mutants of a room, or those whose name is, or whose path has, one of these"
        ),
    ] = "",
    everything: Annotated[bool, typer.Option("--all", help="Lists every mutant, not only those that live")] = False,
    draw: Annotated[int, typer.Option(min=0, help="number of the choice: another number, other mutants")] = 0,
) -> None:
    """Prints a table of the rooms and the mutants that live; the exit status is 1 when less than 90 % are killed."""
    mutants = chosen(CHECKOUT, COUNT_OF_ROOM, (only,), draw) if only in ROOMS else chosen(CHECKOUT, COUNT, draw=draw)
    wanted = mutants if only in ROOMS else asked_for(mutants, only)
    build = Build(CHECKOUT / "build" / "mutants")
    write_copy(CHECKOUT, build.source, mutants)
    build.make()
    found = tried(build, wanted)
    show(table_of(found))
    for fate in found:
        if everything or fate.lives:
            say(line_of(fate))
    for name in sorted(equivalents().keys() - {mutant.name for mutant in chosen(CHECKOUT, EVERYTHING)}):
        say(f"equivalent.csv: there is no mutant {name} any more")
    alive = sum(fate.lives for fate in found)
    if alive > (1 - GOAL) * sum(bool(fate.by) or fate.lives for fate in found):
        raise typer.Exit(1)
