"""Magnetometer calibration by the C API: good recordings, poor ones, and those that are refused."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from studies.compare.native import MESSAGE_BYTES, Options
from studies.compare.scenario import Arrays, Named, Settings, Source, given, of_trial
from studies.compare.side import Side

DISTORTION = np.array([[1.1, 0.04, -0.02], [0.03, 0.95, 0.05], [0.01, -0.03, 1.02]])
Vectors = NDArray[Any]
Recording = tuple[Vectors, Vectors | None]
OFFSET = np.array([12.0, -30.0, 8.0])


def turned(n: int = 400, seed: int = 1, noise: float = 0.2, plane: bool = False, cone_deg: float = 180.0) -> Recording:
    """field (n x 3, microtesla) and force (n x 3) of a sensor that is turned about all axes, or in one plane or cone."""
    rng = np.random.default_rng(seed)
    attitude = Rotation.random(n, random_state=seed)
    if plane:
        attitude = Rotation.from_euler("z", rng.uniform(0, 2 * np.pi, (n, 1)))
    elif cone_deg < 180:
        attitude = Rotation.from_rotvec(np.radians(cone_deg) * rng.uniform(-1, 1, (n, 3)))
    force = attitude.apply([0, 0, -9.81], inverse=True) + 0.05 * rng.normal(size=(n, 3))
    field = attitude.apply([20.0, 1.0, 44.0], inverse=True) @ DISTORTION.T + OFFSET + noise * rng.normal(size=(n, 3))
    return np.ascontiguousarray(field), force


def calibrate(side: Side, field: Vectors, force: Vectors | None, **settings: Any) -> Arrays:
    library = side.library
    options = Options(library, "magnetometer", **settings)
    answer = library.argument("hnav_calibrate_magnetometer", 4)
    message = library.ffi.new("char[]", MESSAGE_BYTES)
    pointers = [library.pointer(values) for values in (field, force)]
    call = library.function("hnav_calibrate_magnetometer")
    status = call(len(field), *pointers, options.struct, answer, message, MESSAGE_BYTES)
    return {"status": np.array([status])} | library.numbers(answer)


def _outliers() -> Recording:
    field, force = turned()
    field[::17] += 4.0
    field[5::40] = np.nan
    return field, force


# How the recording is made, and the options.
CASES: dict[str, tuple[Callable[[], Recording], Settings]] = {
    "good": (turned, {}),
    "without_force": (lambda: (turned()[0], None), {}),
    "outliers": (_outliers, {}),
    "plain_least_squares": (_outliers, {"robust": 0}),
    "noisy": (lambda: turned(noise=1.0), {}),
    "plane": (lambda: turned(plane=True), {"allow_hard_iron_only": 1}),
    "plane_refused": (lambda: turned(plane=True), {}),
    "cone": (lambda: turned(cone_deg=35), {"allow_hard_iron_only": 1}),
    "cone_tolerant": (lambda: turned(cone_deg=35), {"max_condition": 1e9, "min_coverage": 0.0, "max_ambiguity": 1.0}),
    "few": (lambda: turned(n=20), {"min_samples": 30}),
    "limits": (lambda: turned(noise=2.0), {"max_axis_ratio": 1.05, "max_direction_sigma_rad": 1e-3}),
    "tolerance": (turned, {"force_tolerance": 0.01, "outlier_sigma": 2.0}),
}


def _of_made(side: Side, make: Callable[[], Recording], **settings: Any) -> Arrays:
    return calibrate(side, *make(), **settings)


def _of_trial(side: Side, source: Source, **settings: Any) -> Arrays:
    samples = source(side)
    field, force = (np.ascontiguousarray(rows[::8]) for rows in (samples.field, samples.force))
    return calibrate(side, field, force, **settings)


def scenarios(trials: list[int]) -> Iterator[Named]:
    for name, (make, settings) in CASES.items():
        yield f"c/calibration/{name}", given(_of_made, make, **settings)
    for number in trials:
        yield f"c/calibration/trial/{number:02d}", given(_of_trial, of_trial(number), allow_hard_iron_only=1)
