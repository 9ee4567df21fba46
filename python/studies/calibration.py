"""Whether the error that a magnetometer calibration states covers the true one: coverage, noise and outliers crossed.

    ./run study calibration [--recordings 24]

A sensor with hard iron, soft iron and a rotation of a degree or so against the accelerometer is turned in a true field; the
error is the angle between corrected and true field, root mean square over the whole sphere. Covered: recordings of those
that were answered whose error is at most the stated one, of which nine of ten are promised. Noise of the field in field
strengths; that of the force is .01 g; outliers are off by half a field strength on each axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Annotated, Any

import numpy as np
import pandas as pd
import typer
from rich.table import Table
from scipy.spatial.transform import Rotation

from hnav.cli.console import say, show
from hnav.errors import HnavError
from hnav.filters.calibration import calibrate_magnetometer
from studies.command import tracked

COVERAGES = ("every attitude", "tilt 60 deg", "tilt 45 deg", "tilt 35 deg", "tilt 25 deg", "tilt 10 deg", "one pole", "yaw only")
NOISES = (0.002, 0.005, 0.01, 0.02)
OUTLIERS = (0.0, 0.05, 0.2)
SAMPLES = 600
DIP_RAD = np.radians(60)
FORCE_NOISE, OUTLIER = 0.01, 0.5


def attitudes(coverage: str, rng: np.random.Generator) -> Rotation:
    """Body to navigation axes, north-east-down."""
    yaw = rng.uniform(-np.pi, np.pi, SAMPLES)
    if coverage == "every attitude":
        return Rotation.random(SAMPLES, rng)
    if coverage == "yaw only":
        return Rotation.from_euler("z", yaw[:, None])
    if coverage == "one pole":
        return Rotation.from_euler("z", yaw[:, None]) * Rotation.from_rotvec(np.radians(20) * rng.normal(size=(SAMPLES, 3)))
    tilt = np.radians(float(coverage.split()[1]))
    return Rotation.from_euler("ZYX", np.stack([yaw, *rng.uniform(-tilt, tilt, (2, SAMPLES))], axis=1))


def sphere(points: int = 500) -> np.ndarray:
    """points x 3 unit vectors, evenly spread (a Fibonacci lattice)."""
    k = np.arange(points)
    z = 1 - (2 * k + 1) / points
    turn = k * np.pi * (3 - np.sqrt(5))
    return np.stack([np.sqrt(1 - z**2) * np.cos(turn), np.sqrt(1 - z**2) * np.sin(turn), z], axis=1)


def answer(coverage: str, noise: float, outliers: float, seed: int) -> dict[str, Any] | None:
    """Of one recording: error_deg and what was stated, gave_up: whether the rotation was given up, the note; None where the
    calibration is refused."""
    rng = np.random.default_rng(seed)
    soft = 0.1 * rng.normal(size=(3, 3))
    distortion = Rotation.from_rotvec(0.02 * rng.normal(size=3)).as_matrix() @ (np.eye(3) + 0.5 * (soft + soft.T))
    offset = 0.3 * rng.normal(size=3)
    attitude = attitudes(coverage, rng)
    field_n = [np.cos(DIP_RAD), 0, np.sin(DIP_RAD)]
    field = attitude.apply(field_n, inverse=True) @ distortion.T + offset + noise * rng.normal(size=(SAMPLES, 3))
    field += np.where(rng.random(SAMPLES) < outliers, OUTLIER, 0)[:, None] * rng.normal(size=(SAMPLES, 3))
    force = 9.81 * (attitude.apply([0, 0, -1], inverse=True) + FORCE_NOISE * rng.normal(size=(SAMPLES, 3)))
    try:
        found = calibrate_magnetometer(field, force)
    except HnavError as error:
        if error.status != "ill-conditioned":
            raise
        return None
    true = sphere()
    corrected = found.apply(true @ distortion.T + offset)
    angles = np.arctan2(np.linalg.norm(np.cross(corrected, true), axis=1), np.sum(corrected * true, axis=1))
    stated_deg = float(np.degrees(found.direction_sigma_rad))
    error_deg = float(np.degrees(np.sqrt(np.mean(angles**2))))
    return {"error_deg": error_deg, "stated_deg": stated_deg, "gave_up": found.fit != "full", "note": found.note}


def row(answers: Sequence[dict[str, Any] | None]) -> tuple[str, ...]:
    """answered, without rotation, error and stated error (rms), and covered."""
    given = pd.DataFrame([found for found in answers if found])
    answered = f"{len(given)} of {len(answers)}"
    if given.empty:
        return answered, "", "", "", "", ""
    rms = np.sqrt(np.mean(given[["error_deg", "stated_deg"]] ** 2, axis=0))
    covered = f"{np.mean(given.error_deg <= given.stated_deg):.0%}"
    return answered, str(given.gave_up.sum()), f"{rms.iloc[0]:.2f}", f"{given.error_deg.max():.2f}", f"{rms.iloc[1]:.2f}", covered


def command(
    recordings: Annotated[int, typer.Option(min=1, help="of each coverage, noise and share of outliers")] = 24,
    seed: Annotated[int, typer.Option(min=0, help="of the first recording")] = 1,
) -> None:
    """Calibrates simulated recordings and compares the error that is stated with the true one."""
    columns = ("coverage", "noise", "outliers", "answered", "no rotation", "error deg", "largest", "stated deg", "covered")
    table = Table(*columns, title=f"{recordings} recordings each, seeds from {seed}")
    done: list[dict[str, Any] | None] = []
    for coverage, noise, outliers in tracked(list(product(COVERAGES, NOISES, OUTLIERS)), "coverage, noise and outliers"):
        answers = [answer(coverage, noise, outliers, seed + k) for k in range(recordings)]
        done += answers
        if any(answers):
            table.add_row(coverage, f"{noise:.1%}", f"{outliers:.0%}", *row(answers))
    table.add_section()
    table.add_row("all", "", "", *row(done))
    show(table, width=120)
    say(f"not listed: all refused; answers with an empty note: {sum(a is not None and not a['note'] for a in done)}")
