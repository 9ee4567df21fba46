"""What an observer of many states costs: rods of many cells, as FMUs that say which derivatives depend on which states."""

from __future__ import annotations

import multiprocessing
import tempfile
import time
import zipfile
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from hnav.filters.observer import Observer
from hnav.filters.observer_plan import Plan
from hnav.native.arrays import Array
from hnav.systems.statistics import normalised_squares
from studies.long import memory_mb
from studies.observer.smooth import stepped
from studies.processes import fmi_headers, said_by

SOURCE = Path(__file__).with_name("rod.c")
SIZES = (10, 64, 200)
RATE_1_S, INTERVAL_S = 0.2, 1.0
SENSORS, NOISE, SENSOR_SIGMA, START_SIGMA = 5, 0.05, 0.1, 0.5
SAMPLES = 40

_STATE = '<ScalarVariable name="x{i}" valueReference="{i}" causality="output" initial="exact"><Real start="0"/></ScalarVariable>'
_RATE = '<ScalarVariable name="der(x{i})" valueReference="{r}"><Real derivative="{of}"/></ScalarVariable>'
_DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Rod" guid="{{rod{count}}}" numberOfEventIndicators="0">
<ModelExchange modelIdentifier="rod" providesDirectionalDerivative="{directional}"/>
<ModelVariables>{states}{rates}</ModelVariables>
<ModelStructure><Derivatives>{unknowns}</Derivatives></ModelStructure>
</fmiModelDescription>
"""


def rod_fmu(folder: Path, count: int, reach: int | None = 1, directional: bool = False) -> Path:
    """A rod of so many cells x0, x1, ... reach: cells to each side that a derivative is said to depend on, of which 1 is right; None: nothing
    is said. Raises UsageError without a C compiler."""
    binary = folder / f"rod{count}.so"
    defined = [f"-DN={count}", f"-DRATE={RATE_1_S}", *(["-DDIRECTIONAL"] if directional else [])]
    said_by(["cc", "-O2", "-shared", "-fPIC", *defined, f"-I{fmi_headers()}", SOURCE, "-o", binary])

    def unknown(i: int) -> str:
        near = [] if reach is None else [str(k + 1) for k in range(max(0, i - reach), min(count, i + reach + 1))]
        said = "" if reach is None else f' dependencies="{" ".join(near)}"'
        return f'<Unknown index="{count + i + 1}"{said}/>'

    cells = range(count)
    text = _DESCRIPTION.format(
        count=count, directional=str(directional).lower(), states="".join(_STATE.format(i=i) for i in cells),
        rates="".join(_RATE.format(i=i, r=count + i, of=i + 1) for i in cells), unknowns="".join(map(unknown, cells)),
    )  # fmt: skip
    path = folder / f"rod{count}.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", text)
        archive.write(binary, "binaries/linux64/rod.so")
    return path


def plan_of(fmu: Path, count: int) -> Plan:
    """Sensors evenly along the rod."""
    plan = Plan(fmu)
    for i in np.linspace(0, count - 1, SENSORS).astype(int):
        plan.sensor(f"x{i}", noise=SENSOR_SIGMA)
    for i in range(count):
        plan.state(f"x{i}", start_sigma=START_SIGMA, noise=NOISE)
    return plan


def results(sizes: tuple[int, ...] = SIZES, runs: int = 10) -> Iterator[dict[str, Any]]:
    """Each in a process of its own, whose memory is measured."""
    for count in sizes:
        with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as process:
            yield process.submit(measured, count, runs).result()


def measured(count: int, runs: int) -> dict[str, Any]:
    """Of some runs: median time of a processor for a sample, by how much the process grew, and NEES."""
    with tempfile.TemporaryDirectory() as name:
        plan = plan_of(rod_fmu(Path(name), count), count)
        before_mb = memory_mb()
        observer = Observer(plan, start_mode="given")
        spent, squares, grown_mb = [], [], 0.0
        for seed in range(runs):
            truth, y = truth_and_samples(count, np.random.default_rng(seed))
            observer.reset()
            for k, (x, row) in enumerate(zip(truth, y), 1):
                begin = time.thread_time()
                for sensor, value in zip(plan.sensors, row):
                    observer.push(sensor, k * INTERVAL_S, value)
                observer.advance(k * INTERVAL_S)
                spent.append(time.thread_time() - begin)
                grown_mb = max(grown_mb, memory_mb() - before_mb)
                estimate = np.array([*observer.estimate()[0].values()])
                squares.append(float(normalised_squares(x - estimate, observer.covariance())) / count)
    return {"states": count, "ms_per_sample": 1e3 * np.median(spent), "memory_mb": grown_mb, "nees": np.mean(squares)}


def truth_and_samples(count: int, rng: np.random.Generator) -> tuple[Array, Array]:
    """All cells at each sample, exactly as the rod goes, and its sensors."""
    A = RATE_1_S * (np.eye(count, k=1) + np.eye(count, k=-1) - 2 * np.eye(count))
    A[0, 0] = A[-1, -1] = -RATE_1_S
    flow, _, root = stepped(A, np.zeros((count, 0)), NOISE**2 * np.eye(count), INTERVAL_S)
    x, rows = START_SIGMA * rng.standard_normal(count), []
    for _ in range(SAMPLES):
        x = flow @ x + root @ rng.standard_normal(count)
        rows.append(x)
    truth = np.array(rows)
    seen = truth[:, np.linspace(0, count - 1, SENSORS).astype(int)]
    return truth, seen + SENSOR_SIGMA * rng.standard_normal(seen.shape)
