"""Steps the binaries of a release through the same drive, each on its platform, and compares what comes out.

    python release/trajectories.py DIST PLATFORM=PROGRAM...

PROGRAM is fmu/tests/trajectory.c built for the platform. The drive is the example input of the FMU, and for inputs that
it does not name those of DRIVE; every input is set and every output read at each step. The reference is fmpy driving this
machine's binary; a platform whose emulator is not installed is named and left out. Exits when a number differs by more than
TOLERANCE of itself (or of 1, when it is smaller).
"""

from __future__ import annotations

import csv
import math
import os
import re
import struct
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.model_description import ModelDescription, ScalarVariable
from platforms import PLATFORMS, Platform

TOLERANCE = 1e-9
# Their positions are differences of distances from the centre of the Earth, of which one rounding is 1e-9 m.
TOLERANCE_OF = {"Ins": 1e-8, "Gnss": 1e-8}
# Types by FMI version, in the order of the plan: reals, integers, booleans.
LEFT_OUT = "left out"
TYPES = {2: ("Real", "Integer", "Boolean"), 3: ("Float64", "Int32", "Boolean")}
# What an input is at time t of a drive that ends at T, by its name: the first that fits counts. Aid and realign take the
# attitude filters, missing channels and reset the error filters where the example input does not lead.
DRIVE: tuple[tuple[str, Callable[[float, float], float]], ...] = (
    (r"command\.\w+", lambda t, T: 0.02 * math.sin(0.7 * t)),
    (r"aid\.heading", lambda t, T: math.sin(0.5 * t)),
    (r"aid\.valid", lambda t, T: t % 2 > 1),
    (r"present\.[pqw]", lambda t, T: t % 3 < 2),
    (r"realign", lambda t, T: 0.5 * T < t < 0.6 * T),
    (r"reset", lambda t, T: 0.8 * T < t < 0.9 * T),
)


@dataclass(frozen=True)
class Plan:
    """t_s: n points. inputs: n x m values in the order of input_references, which are grouped by type like outputs."""

    version: int
    token: str
    identifier: str
    input_references: tuple[list[int], ...]
    output_references: tuple[list[int], ...]
    t_s: np.ndarray
    inputs: np.ndarray

    def text(self, resources: Path) -> str:
        """As fmu/tests/trajectory.c reads it."""
        where = resources.as_uri() if self.version == 2 else f"{resources}/"
        groups = [*self.input_references, *self.output_references]
        lines = [str(self.version), self.token, where, " ".join(str(len(g)) for g in groups) + f" {len(self.t_s)}"]
        lines.append(" ".join(str(r) for g in groups for r in g))
        rows = np.column_stack([self.t_s, self.inputs])
        lines += [" ".join(struct.pack(">d", x).hex() for x in row) for row in rows]
        return "\n".join(lines) + "\n"


def read_plan(folder: Path) -> Plan:
    """folder: an unpacked FMU. Exits when its inputs or outputs are of a type that a plan has no place for."""
    description = fmpy.read_model_description(str(folder), validate=False)
    version = int(description.fmiVersion[0])
    inputs, outputs = (grouped(description, causality, TYPES[version]) for causality in ("input", "output"))
    example = read_example(folder / "resources" / "example_input.csv")
    experiment = description.defaultExperiment
    stop_s, step_s = example["time"][-1] if example else float(experiment.stopTime), float(experiment.stepSize)
    t_s = step_s * np.arange(round(stop_s / step_s) + 1)
    columns = [drive(v, example, t_s) for group in inputs for v in group]
    return Plan(
        version, description.guid, description.coSimulation.modelIdentifier, references(inputs), references(outputs),
        t_s, np.column_stack(columns) if columns else np.empty((len(t_s), 0)),
    )  # fmt: skip


def grouped(description: ModelDescription, causality: str, types: tuple[str, ...]) -> list[list[ScalarVariable]]:
    """The variables of this causality, a list for each type. Enumerations are integers of FMI 2; those of FMI 3 have 64 bits,
    for which a plan has no place, and are left out."""
    variables = [v for v in description.modelVariables if v.causality == causality and kind_of(v, types) != LEFT_OUT]
    for v in variables:
        if kind_of(v, types) not in types:
            sys.exit(f"trajectories: {description.modelName}: {v.name} is of type {v.type}, a plan has {', '.join(types)}")
    return [[v for v in variables if kind_of(v, types) == kind] for kind in types]


def kind_of(variable: ScalarVariable, types: tuple[str, ...]) -> str:
    if variable.type != "Enumeration":
        return str(variable.type)
    return "Integer" if "Integer" in types else LEFT_OUT


def references(groups: list[list[ScalarVariable]]) -> tuple[list[int], ...]:
    return tuple([v.valueReference for v in group] for group in groups)


def read_example(path: Path) -> dict[str, np.ndarray]:
    """Columns by name, or nothing: an FMU without inputs has no example."""
    if not path.is_file():
        return {}
    with path.open() as file:
        header, *rows = csv.reader(file)
    return dict(zip(header, np.array(rows, float).T))


def drive(variable, example: dict[str, np.ndarray], t_s: np.ndarray) -> np.ndarray:
    """What one input is at every point: the held example, unless it is 0 throughout, else DRIVE, else the start value."""
    if variable.name in example and example[variable.name].any():
        # The decimals of a file and multiples of the step differ in the last bits.
        held = np.searchsorted(example["time"], t_s + 1e-9, side="right") - 1
        return example[variable.name][held]
    for pattern, value in DRIVE:
        if re.fullmatch(pattern, variable.name):
            return np.array([value(t, t_s[-1]) for t in t_s], float)
    return np.full(len(t_s), float({"true": 1, "false": 0}.get(variable.start, variable.start)))


def run_by_fmpy(plan: Plan, folder: Path) -> np.ndarray:
    """Outputs after each step, n - 1 x outputs."""
    kind = FMU2Slave if plan.version == 2 else FMU3Slave
    fmu = kind(guid=plan.token, unzipDirectory=str(folder), modelIdentifier=plan.identifier, instanceName="trajectory")
    fmu.instantiate()
    if plan.version == 2:
        fmu.setupExperiment(startTime=plan.t_s[0])
        fmu.enterInitializationMode()
        setters, getters = (fmu.setReal, fmu.setInteger, fmu.setBoolean), (fmu.getReal, fmu.getInteger, fmu.getBoolean)
    else:
        fmu.enterInitializationMode(startTime=plan.t_s[0])
        setters, getters = (fmu.setFloat64, fmu.setInt32, fmu.setBoolean), (fmu.getFloat64, fmu.getInt32, fmu.getBoolean)
    fmu.exitInitializationMode()
    casts = (float, int, bool)
    result = []
    for k in range(len(plan.t_s) - 1):
        values = iter(plan.inputs[k])
        for references, setter, cast in zip(plan.input_references, setters, casts):
            if references:
                setter(references, [cast(next(values)) for _ in references])
        fmu.doStep(plan.t_s[k], plan.t_s[k + 1] - plan.t_s[k])
        result.append(
            [float(x) for references, getter in zip(plan.output_references, getters) if references for x in getter(references)]
        )
    fmu.terminate()
    fmu.freeInstance()
    return np.array(result)


def run_by_program(plan: Plan, folder: Path, platform: Platform, program: Path) -> np.ndarray:
    """Outputs after each step, by the platform's own binary. Raises RuntimeError with what the program said."""
    # Relative paths mean the same to an emulated system.
    Path(folder, "plan.txt").write_text(plan.text(folder / "resources"))
    binary = f"binaries/{platform.folder(plan.version)}/{plan.identifier}{platform.suffix}"
    command = [*(platform.runner() or []), program, binary, "plan.txt"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, env=os.environ | {"WINEDEBUG": "-all"})
    if done.returncode:
        raise RuntimeError(done.stderr.strip().splitlines()[-1] if done.stderr.strip() else f"status {done.returncode}")
    return np.array([[struct.unpack(">d", bytes.fromhex(word))[0] for word in line.split()] for line in done.stdout.splitlines()])


def difference(a: np.ndarray, b: np.ndarray) -> float:
    """Largest difference relative to max(1, |b|); infinite when shapes or the places of NaN differ."""
    if a.shape != b.shape or not np.array_equal(np.isnan(a), np.isnan(b)):
        return np.inf
    return float(np.nanmax(np.abs(a - b) / np.maximum(1, np.abs(b)), initial=0))


def compare(fmu: Path, version: int, programs: Mapping[Platform, Path]) -> dict[str, float]:
    """Largest difference to fmpy, by platform. Exits when one is too large."""
    where = f"fmi{version}/{fmu.name}"
    found = {}
    with tempfile.TemporaryDirectory() as unpacked:
        folder = Path(fmpy.extract(str(fmu), unzipdir=unpacked))
        plan = read_plan(folder)
        reference = run_by_fmpy(plan, folder)
        for platform, program in programs.items():
            if not platform.folder(version):
                continue
            try:
                worst = difference(run_by_program(plan, folder, platform, program), reference)
            except RuntimeError as error:
                sys.exit(f"trajectories: {where} on {platform.name}: {error}")
            if worst > TOLERANCE_OF.get(fmu.stem, TOLERANCE):
                sys.exit(f"trajectories: {where} on {platform.name} differs from fmpy by {worst:.2g}")
            found[platform.name] = worst
    said = ", ".join(f"{name} {worst:.1g}" for name, worst in found.items())
    print(f"{where}: {reference.shape[0]} steps, {reference.shape[1]} outputs; largest difference to fmpy: {said}")
    return found


def has_arrays(fmu: Path) -> bool:
    return any(v.dimensions for v in fmpy.read_model_description(str(fmu), validate=False).modelVariables)


def has_clocks(fmu: Path) -> bool:
    return any(v.type == "Clock" for v in fmpy.read_model_description(str(fmu), validate=False).modelVariables)


def comparable(dist: Path) -> list[tuple[int, Path]]:
    """The FMUs of all versions but those with arrays or clocks: the tests compare these with their scalar twins, the program reads
    scalars. Exits when there are none."""
    fmus = [(version, fmu) for version in (2, 3) for fmu in sorted((dist / f"fmi{version}").glob("*.fmu"))]
    if not fmus:
        sys.exit(f"trajectories: no FMU in {dist}")
    return [(version, fmu) for version, fmu in fmus if not has_arrays(fmu) and not has_clocks(fmu)]


def main(dist: Path, programs: dict[str, Path]) -> None:
    platforms = [p for p in PLATFORMS if p.name in programs]
    runnable = {p: programs[p.name] for p in platforms if p.runner() is not None}
    largest = {p.name: 0.0 for p in runnable}
    fmus = comparable(dist)
    for version, fmu in fmus:
        for name, worst in compare(fmu, version, runnable).items():
            largest[name] = max(largest[name], worst)
    worst_of_all = ", ".join(f"{name} {worst:.2g}" for name, worst in largest.items())
    print(f"trajectories: {len(fmus)} FMUs; largest difference to fmpy: {worst_of_all}")
    for platform in (p for p in platforms if p not in runnable):
        print(f"trajectories: {platform.name} not run: {platform.advice()}")


if __name__ == "__main__":
    main(Path(sys.argv[1]), {p: Path(f).resolve() for p, f in (a.split("=", 1) for a in sys.argv[2:])})
