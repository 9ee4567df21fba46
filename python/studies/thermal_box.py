"""A heated box whose lid is opened for minutes: does an observer with a plan of a few lines find when, and are its innovations as large
as their sigmas once its noises have been tuned?

    ./run study thermal_box [--runs 5] [--hours 2]
    ./run study thermal_box --write FOLDER      # box.py, plan.toml and recording.csv, to try hnav observe on

The truth has what the model of the observer has not: walls that store heat, sensors that lag, read in steps of 1/16 K and are off by
some tenths. Where HNAV_PLANTS names the folder of FMUs, the same model as FMU is observed, a hundred times as fast: a heated room, its
air as the heater.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import numpy as np
import typer
from rich.table import Table

from hnav.cli.console import say, show
from hnav.filters.observer import Observer
from hnav.filters.observer_findings import findings
from hnav.filters.observer_plan import Plan, read_plan
from hnav.filters.observer_tuning import tune
from hnav.io.outputs import write_files
from hnav.io.sample_table import sample_table
from hnav.native.arrays import Array

INTERVAL_S = 3.0
EPOCH_S = 1_600_000_000.0
STEP = 1 / 16  # K, of a reading

MODEL = '''"""A box with a heater: the heater warms the air, the box loses to the room."""

import hnav


def derivatives(t, x, u, p):
    heater, air = x
    power, room = u
    C_heater, G_heater, C_air, G_box = p
    return (power - G_heater * (heater - air)) / C_heater, (G_heater * (heater - air) - G_box * (air - room)) / C_air


box = hnav.Plant(
    derivatives,
    outputs=lambda t, x, u, p: x[1],
    states={"heater": 25.0, "air": 25.0},
    inputs={"power": 0.0, "room": 21.0},
    parameters={"C_heater": 240.0, "G_heater": 0.87, "C_air": 270.0, "G_box": 0.74},
    sensors=["air"],
)
'''

PLAN = """[plant]
fmu = "box.py"

[sensor."T1"]                 # three sensors of one thing
of = "air"
noise = 0.1
[sensor."T2"]
of = "air"
noise = 0.1
[sensor."T3"]
of = "air"
noise = 0.1

[input."power"]               # W; the recording has 0 and 1
column = "heater_on"
factor = 110
[input."room"]
column = "T_room"

[state."heater"]
start_sigma = 5
noise = 0.01
[state."air"]
start_sigma = 1
noise = 0.01

[parameter."G_box"]           # what the lid changes: it may wander
start_sigma = 0.3
noise = 0.05
"""

# The same model in HeatedRoom.fmu, whose air is the heater here and whose wall is the air.
FMU_NAMES = {
    '"box.py"': '"HeatedRoom.fmu"\nset = {C_air = 240, K = 0.87, C_wall = 270, G = 0.74}', 'of = "air"': 'of = "T_wall"',
    '[state."heater"]': '[state."T_air"]\nstart = 25', '[state."air"]': '[state."T_wall"]\nstart = 25', '[input."room"]': '[input."T_out"]',
    '"G_box"': '"G"', "factor = 110": "factor = 110\nstart = 0",
}  # fmt: skip


@dataclass(frozen=True)
class Lid:
    """Open from one time to another, from the start of the recording."""

    start_s: float
    end_s: float


def lids(hours: float) -> tuple[Lid, ...]:
    """One of three minutes in each hour, and a longer one at the end of the second."""
    made = [Lid(3600 * hour + 2400, 3600 * hour + 2580) for hour in range(int(hours + 0.5))]
    return (*made, Lid(5000, 5240)) if hours >= 2 else tuple(made)


def recorded(rng: np.random.Generator, hours: float) -> dict[str, Array]:
    """The columns of a recording: the heater is switched to hold 35 degC."""
    opened, rows = lids(hours), []
    heater, air, wall, seen, on, switched_s = 25.0, 25.0, 23.0, np.full(3, 25.0), False, 0.0
    offsets, h = np.array([0.0, 0.31, -0.22]), INTERVAL_S / 10
    for t_s in np.arange(0, 3600 * hours, INTERVAL_S):
        if t_s - switched_s >= (20 if on else 30) and (on or seen[1] < 35):
            on, switched_s = not on, t_s
        loss = 0.74 * (6.0 if any(lid.start_s <= t_s < lid.end_s for lid in opened) else 1.0)
        room = 21.5 + 0.5 * np.sin(2 * np.pi * t_s / 5000)
        power = 110.0 * on
        for _ in range(10):
            to_air, to_wall = 0.87 * (heater - air), 0.4 * (air - wall)
            seen += h * (air - seen) / 8
            heater += h * (power - to_air) / 240
            air += h * (to_air - to_wall - loss * (air - room)) / 270 + 0.004 * np.sqrt(h) * rng.standard_normal()
            wall += h * to_wall / 900
        reads = np.append(seen + offsets, room) + 0.02 * rng.standard_normal(4)
        rows.append([EPOCH_S + t_s + INTERVAL_S, on, 1, *(np.round(reads / STEP) * STEP)])
    names = ("time", "heater_on", "fan_on", "T1", "T2", "T3", "T_room")
    return dict(zip(names, np.array(rows, float).T))


def observed(plan: Plan, columns: dict[str, Array], hours: float, tuned: bool = True) -> dict[str, Any]:
    """Of one recording: nis of each sensor, in the mean, with tuned noises; late_s, long_s: how late each lid was found, and how
    much longer than it was open G_box was away; lids that were missed, and times that it was away without one (false)."""
    t_s = columns["time"]
    sensors = {name: columns[name] for name in plan.sensors}
    inputs = {name: columns[known.column] for name, known in plan.inputs.items()}
    if tuned:
        plan = tune(plan, t_s, sensors, inputs).plan
    run = Observer(plan).run(t_s, sensors, inputs)
    away = [one for one in findings(run, plan) if one.kind == "away"]
    late, long, hits = list[float](), list[float](), set[int]()
    for lid in lids(hours):
        start, end = EPOCH_S + lid.start_s + INTERVAL_S, EPOCH_S + lid.end_s + INTERVAL_S
        at = [k for k, one in enumerate(away) if one.start_s < end and one.end_s > start]
        hits.update(at)
        if at:
            late.append(away[at[0]].start_s - start)
            long.append(away[at[-1]].end_s - end)
    nis = [float(np.nanmean(values)) for values in run.nis.values()]
    return {"nis": nis, "late_s": late, "long_s": long, "missed": len(lids(hours)) - len(late), "false": len(away) - len(hits)}


def plan_of_model(folder: Path) -> tuple[str, Plan]:
    """The plan for the FMU, or, where there is none, for functions in Python, written into a folder; and which it is."""
    write_example(folder)
    plants = os.environ.get("HNAV_PLANTS")
    if not plants:
        return "functions in Python", read_plan(folder / "plan.toml")
    text = PLAN
    for old, new in FMU_NAMES.items():
        text = text.replace(old, new)
    (folder / "fmu.toml").write_text(text)
    return "FMU", read_plan(folder / "fmu.toml", Path(plants) / "fmi3/HeatedRoom.fmu")


def write_example(folder: Path, hours: float = 0.0) -> None:
    """The model, its plan, and a recording of so many hours."""
    files = {folder / "box.py": MODEL, folder / "plan.toml": PLAN}
    if hours:
        files[folder / "recording.csv"] = sample_table(["a simulated box"], recorded(np.random.default_rng(1), hours))
    write_files(files, make_folders=True)


def command(
    runs: Annotated[int, typer.Option(min=1, help="Recordings")] = 5,
    hours: Annotated[float, typer.Option(min=0.75, help="Of each")] = 2.0,
    write: Annotated[Path | None, typer.Option(metavar="FOLDER", help="Only write an example there")] = None,
) -> None:
    """A heated box whose lid is opened: is it found?"""
    if write is not None:
        write_example(write, hours)
        say(f"hnav observe {write / 'box.py'} --plan {write / 'plan.toml'} --data {write / 'recording.csv'} --report page.html")
        return
    table = Table("model", "NIS by sensor", "lids", "found", "too late / s", "too long / s", "false")
    with TemporaryDirectory() as folder:
        name, plan = plan_of_model(Path(folder))
        results = [observed(plan, recorded(np.random.default_rng(seed), hours), hours) for seed in range(runs)]
    nis, late, long = (np.concatenate([result[of] for result in results]) for of in ("nis", "late_s", "long_s"))
    missed, false = (sum(result[of] for result in results) for of in ("missed", "false"))
    found = f"{nis.min():.2f} to {nis.max():.2f}", str(len(late) + missed), str(len(late))
    table.add_row(name, *found, _range(late), _range(long), str(false))
    show(table)


def _range(values: Array) -> str:
    return f"{values.min():.0f} to {values.max():.0f}" if len(values) else "-"
