"""The command: simulated starts by kind, or those of the recorded flight, as a table."""

from __future__ import annotations

import os
from functools import partial
from itertools import product
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.table import Table

from hnav import earth
from hnav.cli.console import say, show
from hnav.cli.words import UsageError
from hnav.filters.options import INS_PRESETS, Options
from studies.command import WORKERS, Seed, Workers, after, check_choices, titled_table, tracked
from studies.ins import flight as flights
from studies.ins import hindsight, wheels
from studies.ins import tilt as tilted
from studies.ins.conditions import CONDITIONS
from studies.ins.experiment import DURATIONS_S, KINDS, experiment, figures
from studies.ins.flight import JUDGED_S, STARTS, Flight
from studies.ins.hands import LAST_S, LENGTH_S, WAYS, minutes, trials
from studies.ins.motions import AT_REST
from studies.ins.rules import RULES, library_without
from studies.ins.vehicles import latitude_at_rest, starts_of
from studies.processes import in_order


def command(
    runs: Annotated[int, typer.Option("--starts", "--runs", min=1, help="of each kind")] = 200,
    kinds: Annotated[str, typer.Option(help=f"any of {', '.join(KINDS)}, separated by commas")] = "car,aircraft,ship",
    grade: Annotated[str, typer.Option(help="preset of the filter and of the sensors")] = "industrial",
    workers: Workers = WORKERS,
    seed: Seed = 1,
    magnetometer: Annotated[
        bool,
        typer.Option("--magnetometer", help="the same starts with an uncalibrated magnetometer, beside those without"),
    ] = False,
    conditions: Annotated[
        str, typer.Option("--conditions", help=f"what the starts meet: any of {', '.join(CONDITIONS)}, separated by commas")
    ] = "usual",
    without: Annotated[
        str | None, typer.Option(metavar="RULE", help=f"with a copy of the library that lacks a rule of {', '.join(RULES)}")
    ] = None,
    with_wheels: Annotated[
        bool, typer.Option("--wheels", help="cars that lose the satellites instead, with the speed of their wheels and without")
    ] = False,
    smooth: Annotated[
        bool, typer.Option("--smooth", help="the smoother beside the filter instead, with half a minute without satellites")
    ] = False,
    tilt: Annotated[
        bool, typer.Option("--tilt", help="the tilt of trains and of quadrotors that hover first, by every grade, instead")
    ] = False,
    gyrocompass: Annotated[
        bool, typer.Option("--gyrocompass", help="bodies at rest that find north by the rate of the Earth instead")
    ] = False,
    flight: Annotated[Path | None, typer.Option(metavar="FOLDER", help="the recorded flight instead")] = None,
    hands: Annotated[Path | None, typer.Option(metavar="FOLDER", help="BROAD trials with optical positions instead")] = None,
) -> None:
    """Simulates starts from any heading and prints when the heading was ready, and how often falsely."""
    check_choices("--grade", [grade], INS_PRESETS)
    chosen = kinds.split(",")
    check_choices("--kinds", chosen, KINDS)
    met = conditions.split(",")
    check_choices("--conditions", met, CONDITIONS)
    if without is not None:
        leave_out(without)
    if flight is not None:
        shown, width = flight_table(recorded(flight)), 120
    elif hands is not None:
        shown, width = hands_table(hands, workers), 150
    elif with_wheels:
        shown, width = wheel_table(grade, runs, seed, workers), 120
    elif smooth:
        shown, width = hindsight_table(chosen, grade, runs, seed, workers), 200
    elif tilt:
        shown, width = tilt_table(runs, seed, workers), 150
    elif gyrocompass:
        shown, width = north_table(runs, seed, workers), 120
    else:
        shown, width = starts_table(chosen, met, grade, runs, seed, workers, magnetometer), 150
    show(shown, width=width)


def leave_out(rule: str) -> None:
    """From now on the library lacks it."""
    check_choices("--without", [rule], RULES)
    os.environ["HNAV_LIBRARY"] = str(library_without(rule))
    say(f"without {rule}: {RULES[rule].repairs}")


def recorded(folder: Path) -> Flight:
    """Raises UsageError where it is not."""
    if not (folder / "thor75.csv").is_file():
        raise UsageError(f"--flight {folder}: there is no thor75.csv")
    return Flight(folder)


def starts_table(
    kinds: list[str], conditions: list[str], grade: str, runs: int, seed: int, workers: int, magnetometer: bool
) -> Table:
    """A row for each kind under each condition, with a progress bar; magnetometer: and one with it."""
    heads = "runs | ready | median | 95 % | false | heading rms at the end | stated | z2 | position z2 | tilt z2 after 5 s | at the end"
    out = titled_table(f"{grade}, seed {seed}: first heading_ready, and the end", "kind", heads)
    for kind, field, met in product(kinds, (False, True) if magnetometer else (False,), conditions):
        name = ", ".join(filter(None, (kind, "magnetometer" if field else "", CONDITIONS[met].text)))
        f = figures(tracked(experiment(kind, grade, runs, seed, workers, field, met), name, runs))
        z2 = ("" if np.isnan(f[of]) else f"{f[of]:.2f}" for of in ("heading_z2", "position_z2", "early_tilt_z2", "tilt_z2"))
        out.add_row(name, str(f["runs"]), str(f["ready"]), after(f["median_s"]), after(f["late_s"]), *_heading(f), *z2)
    return out


def _heading(f: dict[str, Any]) -> list[str]:
    """Of figures: false, root mean square and stated sigma at the end."""
    return [str(f["false"]), f"{f['rms_end']:.3g} deg", f"{f['stated_end']:.3g} deg"]


def north_table(runs: int, seed: int, workers: int) -> Table:
    """A row for each base and grade."""
    title = f"{runs} starts each, seed {seed}, {DURATIONS_S['rest']:g} s at rest: north by the rate of the Earth"
    heads = "ready | median | false | heading rms at the end | stated | z2 | bias over Earth's rate | rms over that"
    out = titled_table(title, "base | grade", heads)
    for kind, grade in (*((kind, "navigation") for kind in AT_REST), ("rest", "tactical")):
        f = figures(experiment(kind, grade, runs, seed, workers))
        due = np.degrees(Options("ins", grade).start_sigma_gyro_bias_rad_s / (earth.RATE_RAD_S * np.cos(latitude_at_rest(kind))))
        z2, over_due = f"{f['heading_z2']:.2f}", f"{f['rms_end'] / due:.2f}"
        ready = f"{f['ready']} of {f['runs']}", after(f["median_s"])
        out.add_row(kind, grade, *ready, *_heading(f), z2, f"{due:.3g} deg", over_due)
    return out


def tilt_table(runs: int, seed: int, workers: int) -> Table:
    """A row for each kind and grade."""
    title = f"{runs} starts each, seed {seed}: z2 of the tilt, so long after it is found"
    times = " | ".join(f"{after_s:g} s" for after_s in tilted.AFTER_S)
    out = titled_table(title, "kind | grade", f"{times} | all rows | falsely ready")
    for kind, grade in product(tilted.KINDS, INS_PRESETS):
        *z2, false_share = zip(*in_order(partial(tilted.tilt, kind, grade), starts_of(seed, runs), workers, 4))
        out.add_row(kind, grade, *(f"{np.mean(values):.2f}" for values in z2), f"{100 * np.nanmean(false_share):.2f} %")
    return out


def wheel_table(grade: str, runs: int, seed: int, workers: int) -> Table:
    """Rows for cars without wheels, and for both ways in which wheels may be put."""
    title = f"{grade}, {runs} cars each, seed {seed}: horizontal error at the end of outages of the satellites"
    out = titled_table(title, "speed of wheels", "lasts | rms | median | worst | z2")
    for name, car in wheels.CARS.items():
        for length, of in wheels.outages(name, grade, runs, seed, workers).groupby("length_s"):
            error = of.error_m
            rms, median, worst = f"{np.sqrt(np.mean(error**2)):.2f} m", f"{error.median():.2f} m", f"{error.max():.1f} m"
            out.add_row(car.text if car else "none", f"{length:g} s", rms, median, worst, f"{of.z2.mean():.2f}")
    return out


def hindsight_table(kinds: list[str], grade: str, runs: int, seed: int, workers: int) -> Table:
    """Three rows for each kind: before the heading is found, after it, and in the middle of the outage."""
    title = f"{grade}, {runs} starts each, seed {seed}: rms of filter and smoother, and z2"
    heads = " | ".join(f"{name}: filter | smoother | z2 | smoother" for name in ("heading", "tilt", "position"))
    out = titled_table(title, "kind | rows", heads)
    for kind in kinds:
        starts = in_order(partial(hindsight.compared, kind, grade), starts_of(seed, runs), workers, 4)
        figures_of = hindsight.summary(list(starts))
        for part, name in enumerate(hindsight.PARTS):
            cells = []
            for i, unit in enumerate(("deg", "deg", "m")):
                before, after, z2, z2_after = (figures_of[who, part, i + place] for place in (0, 3) for who in (0, 1))
                cells += [*(f"{value:.2g} {unit}" if np.isfinite(value) else "" for value in (before, after))]
                cells += [*(f"{value:.2f}" if np.isfinite(value) else "" for value in (z2, z2_after))]
            out.add_row(kind if part == 0 else "", name, *cells)
    return out


def flight_table(flight: Flight) -> Table:
    """The figures of the starts in the air, and of one from the ground."""
    caption = (
        f"from the ground, {JUDGED_S:g} s after take-off to the landing: {np.degrees(flight.from_the_ground()):.2f} deg; "
        f"the reference is stamped {flight.late_s:.2f} s late"
    )
    title = f"{STARTS} starts in flight, {JUDGED_S:g} to {flights.LENGTH_S:g} s after each"
    heads = "rms median | rms worst | mean | ready | ready after: median | false"
    out = titled_table(title, "latency of the satellites", heads, caption=caption, caption_justify="left")
    none: dict[str, object] = {"start_sigma_latency_s": 0.0}
    for name, options in (("estimated", {}), ("none", none)):
        starts = flight.starts(**options)
        rms, mean, ready_s = np.degrees(starts.rms), np.degrees(starts["mean"]), starts.ready_s
        cells = (f"{rms.median():.2f} deg", f"{rms.max():.2f} deg", f"{mean.mean():+.2f} deg", str(ready_s.count()))
        out.add_row(name, *cells, f"{ready_s.median():.0f} s", str(starts.is_false.sum()))
    return out


def hands_table(folder: Path, workers: int) -> Table:
    """A row for each source of positions. Raises UsageError without trials."""
    if not trials(folder):
        raise UsageError(f"--hands {folder}: there is no .hdf5 of a BROAD trial that moves about")
    title = f"{LENGTH_S:g} s of a hand's motion each, consumer preset: the heading"
    heads = f"minutes | rms of the last {LAST_S:g} s: median | worst | stated | z2 | ready | false"
    out = titled_table(title, "positions", f"{heads} | smoothed | whole minute: median | worst | z2")
    for fixes in WAYS:
        of = minutes(folder, fixes, workers)
        rms, stated, after = (np.degrees(of[name]) for name in ("rms", "stated", "smoothed_rms"))
        out.add_row(
            fixes.text, str(len(of)), f"{rms.median():.2f} deg", f"{rms.max():.2f} deg", f"{stated.median():.2f} deg", f"{of.z2.mean():.2f}",
            str(of.is_ready.sum()), str(of.is_false.sum()), str(after.count()), f"{after.median():.2f} deg", f"{after.max():.2f} deg",
            f"{of.smoothed_z2.mean():.2f}",
        )  # fmt: skip
    return out
