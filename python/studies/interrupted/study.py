"""The command: kills, full and read-only disks, and the table of what was left behind."""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.table import Table

from hnav.cli.console import bar, say, show
from hnav.cli.words import UsageError
from hnav.errors import HnavError
from hnav.io.outputs import PART, temporary_folder
from hnav.systems.simulation import ABOUT, SIGNALS, read_run
from studies.command import titled_table
from studies.interrupted.children import full_after, kill, run, run_here, start, wait_for_writing, without_privilege

SYSTEM = "turntable"
STOP_S, RUNS, ROWS = 0.5, 3, 5_000
OLD, NEW, NOT_WHOLE = "old", "new", "not whole, and said so"


@dataclass(frozen=True)
class Command:
    """One command in a folder of its own. arguments: of its old and its new output."""

    name: str
    folder: Path
    arguments: Callable[[int], list[str]]  # 0: old, 1: new
    outputs: tuple[Path, ...]

    def state(self, old: dict[Path, bytes], new: dict[Path, bytes]) -> str:
        """OLD, NEW or NOT_WHOLE; any other text describes a fault."""
        now = contents(self.outputs)
        for name, known in ((OLD, old), (NEW, new)):
            if {path: comparable(path, data) for path, data in now.items()} == known:
                return name
        if self.name == "simulate" and self.folder / ABOUT not in now:
            try:
                read_run(self.folder)
            except HnavError as error:
                return NOT_WHOLE if "\n" not in str(error) else f"refused in more than a line: {error}"
        return f"{', '.join(path.name for path in now) or 'nothing'}: neither the old output nor the new one"


def contents(paths: tuple[Path, ...]) -> dict[Path, bytes]:
    """Of the files that are there."""
    return {path: path.read_bytes() for path in paths if path.is_file()}


def comparable(path: Path, data: bytes) -> bytes:
    """The bytes that two equal commands have in common: run.json without the times that it took."""
    if path.name != ABOUT:
        return data
    try:
        about = json.loads(data)
        del about["wall_s"]
    except (ValueError, KeyError, TypeError):
        return data
    return json.dumps(about).encode()


def commands(folder: Path) -> list[Command]:
    """All of them; makes what they read."""
    recordings = [write_recording(folder / f"recording_{seed}.csv", seed) for seed in (0, 1)]
    simulate, filtered, many, report = (folder / name for name in ("simulate", "filter", "montecarlo", "report"))
    for path in (simulate, filtered, many, report):
        path.mkdir()
    stop = f"--stop={STOP_S}"
    # The report is made of what another simulate wrote, of two seeds.
    runs = [folder / f"run_{which}" for which in (0, 1)]
    return [
        Command("simulate", simulate, lambda which: ["simulate", SYSTEM, stop, f"--seed={which}", f"--out={simulate}"],
                (simulate / SIGNALS, simulate / ABOUT)),
        Command("filter", filtered, lambda which: ["filter", str(recordings[which]), f"--out={filtered / 'out.csv'}"],
                (filtered / "out.csv",)),
        Command("montecarlo", many, lambda which: [
            "montecarlo", SYSTEM, f"--stop={STOP_S}", f"--runs={RUNS}", f"--first-seed={which}", f"--out={many / 'out.parquet'}"],
            (many / "out.parquet",)),
        Command("report", report, lambda which: ["report", str(runs[which]), f"--out={report / 'report.html'}"],
                (report / "report.html",)),
    ]  # fmt: skip


def prepare(folder: Path, run: Callable[[list[str]], None]) -> None:
    """What the reports are made of, by `run` of a command."""
    for which in (0, 1):
        run(["simulate", SYSTEM, f"--stop={STOP_S}", f"--seed={which}", f"--out={folder / f'run_{which}'}"])


def write_recording(path: Path, seed: int) -> Path:
    """A sensor at rest with noise."""
    rng = np.random.default_rng(seed)
    still = np.array([0, 0, 0, 0, 0, -9.81, 2e-5, 0, 4.5e-5])
    sigma = np.repeat([1e-3, 1e-2, 1e-7], 3)
    table = np.column_stack([0.01 * np.arange(ROWS), still + sigma * rng.normal(size=(ROWS, 9))])
    np.savetxt(path, table, fmt="%.9g", delimiter=",", header="t_s,gx,gy,gz,ax,ay,az,mx,my,mz", comments="")
    return path


# --------------------------------------------------------------------------------------------- the command


SIGNALS_SENT = (signal.SIGKILL, signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
ELSE_GO_ON = 0.2  # how often a command that does not resume is run again after a kill
WRITING_S = 0.005  # how long after the first new file, at most, the command is killed when it is writing
KILLED, FULL, READ_ONLY = "killed", "full disk", "read-only"


class Interrupted:
    """One command, interrupted many times. found: how often which state was left, by what was done; faults in words."""

    def __init__(self, command: Command, folder: Path, seed: int):
        self.command, self.random = command, random.Random(f"{command.name} {seed}")
        self.said = folder / f"{command.name}.txt"
        self.found: dict[str, Counter[str]] = {KILLED: Counter(), FULL: Counter(), READ_ONLY: Counter()}
        self.faults: list[str] = []
        self.resumed = self.resumed_equal = 0
        self.known: list[dict[Path, bytes]] = []
        self.saved: dict[Path, bytes] = {}
        # Once in this process: what it loads the children need not.
        run_here(command.arguments(0))
        for which in (1, 0):
            begin = time.monotonic()
            self.run_whole(which)
            self.seconds = time.monotonic() - begin
            self.saved = contents(command.outputs)
            self.known.insert(0, {path: comparable(path, data) for path, data in self.saved.items()})

    def run_whole(self, which: int) -> None:
        if code := run(self.command.arguments(which), self.said):
            raise UsageError(f"{self.command.name} ended with {code}: {self.said.read_text().strip()}")

    def restore(self) -> None:
        """The folder with the old output and nothing else."""
        for path in self.command.folder.iterdir():
            path.unlink()
        for path, data in self.saved.items():
            path.write_bytes(data)

    def kill(self) -> None:
        """At any moment of the command, or, every other time, while it is writing."""
        self.restore()
        while True:
            child = start(self.command.arguments(1), self.said)
            if self.random.random() < 0.5:
                wait_for_writing(child, self.command.folder)
                time.sleep(self.random.uniform(0, WRITING_S))
            else:
                time.sleep(self.random.uniform(0, 1.05 * self.seconds))
            kill(child, self.random.choice(SIGNALS_SENT))
            self.judge(KILLED, (OLD, NEW, NOT_WHOLE))
            # A montecarlo may be killed again before it comes to its end.
            if self.command.name != "montecarlo" or self.random.random() < 0.5:
                break
        if self.command.name == "montecarlo" or self.random.random() < ELSE_GO_ON:
            self.go_on()

    def go_on(self) -> None:
        """The same command once more, to its end."""
        self.run_whole(1)
        self.resumed += 1
        state = self.command.state(*self.known)
        left = [path.name for path in self.command.folder.iterdir() if path not in self.command.outputs]
        if state == NEW and not left:
            self.resumed_equal += 1
        else:
            self.faults.append(f"{self.command.name} after a kill and a whole command: {state}; beside it {left}")

    def fill(self) -> None:
        """A disk that takes no more than a random size of a file: the command refuses and leaves the old output."""
        self.restore()
        largest = max(len(data) for data in self.saved.values())
        code = run(self.command.arguments(1), self.said, full_after(self.random.randrange(largest)))
        self.judge(FULL, (OLD,), code)

    def forbid(self) -> None:
        """A folder without write permission."""
        self.restore()
        self.command.folder.chmod(0o555)
        self.said.unlink(missing_ok=True)
        code = run(self.command.arguments(1), self.said, without_privilege)
        self.command.folder.chmod(0o755)
        self.judge(READ_ONLY, (OLD,), code)

    def judge(self, done: str, allowed: tuple[str, ...], code: int | None = None) -> None:
        """code: of a command that was to refuse, in one line."""
        state, said = self.command.state(*self.known), self.said.read_text()
        self.found[done][state if state in (OLD, NEW, NOT_WHOLE) else "fault"] += 1
        parts = [path.name for path in self.command.folder.iterdir() if path.name.endswith(PART)]
        if state not in allowed:
            self.faults.append(f"{self.command.name}, {done}: {state}")
        if "Traceback" in said or len(said.strip().splitlines()) > 1:
            self.faults.append(f"{self.command.name}, {done}, said: {said.strip()}")
        if code is not None and (code != 2 or "cannot write" not in said or parts):
            self.faults.append(f"{self.command.name}, {done}: exit code {code}, said {said.strip()!r}, left {parts}")


def interrupt(kills: int, seed: int, folder: Path, names: list[str] | None = None) -> list[Interrupted]:
    """Every command in the folder: killed, and a tenth as often on a full and on a read-only disk."""
    # What killed commands have unpacked goes with the folder.
    (folder / "temporary").mkdir()
    tempfile.tempdir = str(folder / "temporary")
    prepare(folder, run_here)
    done = []
    with bar() as progress:
        for command in commands(folder):
            if names and command.name not in names:
                continue
            task = progress.add_task(command.name, total=kills)
            trial = Interrupted(command, folder, seed)
            for i in range(kills):
                trial.kill()
                if i % 10 == 0:
                    trial.fill()
                    trial.forbid()
                progress.advance(task)
            done.append(trial)
    return done


def table(done: list[Interrupted]) -> Table:
    """A row for each command and what was done to it."""
    names = f"command |  | times | old output, whole | new output, whole | {NOT_WHOLE} | fault"
    out = titled_table("What was left behind, times", names)
    for trial in done:
        for what, found in trial.found.items():
            counts = (found[state] for state in (OLD, NEW, NOT_WHOLE, "fault"))
            out.add_row(trial.command.name if what == KILLED else "", what, str(found.total()), *map(str, counts))
        out.add_section()
    return out


def command(
    kills: Annotated[int, typer.Option(min=1, help="Of each command")] = 100,
    seed: Annotated[int, typer.Option(help="Of the moments")] = 1,
) -> None:
    """Interrupts simulate, filter, montecarlo and report, and prints what they left behind."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    folder = temporary_folder("hnav_interrupted_")
    try:
        done = interrupt(kills, seed, folder)
    finally:
        tempfile.tempdir = None
        shutil.rmtree(folder, ignore_errors=True)
    show(table(done))
    for trial in done:
        equal = f"{trial.resumed_equal} of {trial.resumed}"
        say(f"{trial.command.name}: after a kill the repeated command gives the bytes of an uninterrupted one, {equal} times")
    faults = [fault for trial in done for fault in trial.faults]
    for fault in faults:
        say(f"fault: {fault}")
    if faults:
        raise UsageError(f"{len(faults)} faults")
