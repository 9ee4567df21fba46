"""The commands that are interrupted, what they write over, and what their outputs are worth afterwards."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hnav.errors import HnavError
from hnav.systems.simulation import ABOUT, SIGNALS, read_run

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
