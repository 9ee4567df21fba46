"""Steps the binaries of a release over their example input, each on its platform, and compares what comes out.

    python release/trajectories.py DIST PLATFORM=PROGRAM...

PROGRAM is fmu/tests/trajectory.c built for the platform. The reference is fmpy driving this machine's binary; a platform
whose emulator is not installed is named and left out. Exits when a number differs by more than 1e-9 of itself (or of 1,
when it is smaller).
"""

from __future__ import annotations

import csv
import shutil
import struct
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from platforms import PLATFORMS, Platform

TOLERANCE = 1e-9
# Types by FMI version, in the order of the plan: reals, integers, booleans. Enumerations are parameters or echoes of them.
TYPES = {2: ("Real", "Integer", "Boolean"), 3: ("Float64", "Int32", "Boolean")}


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
    """folder: an unpacked FMU."""
    description = fmpy.read_model_description(str(folder), validate=False)
    version = int(description.fmiVersion[0])
    variables = {v.name: v for v in description.modelVariables}
    with (folder / "resources" / "example_input.csv").open() as file:
        header, *rows = csv.reader(file)
    table = np.array(rows, float)
    columns = [[i for i, n in enumerate(header) if i and variables[n].type == kind] for kind in TYPES[version]]
    outputs = [[v.valueReference for v in variables.values() if v.causality == "output" and v.type == kind] for kind in TYPES[version]]
    return Plan(
        version, description.guid, description.coSimulation.modelIdentifier,
        tuple([variables[header[i]].valueReference for i in group] for group in columns), tuple(outputs),
        table[:, 0], table[:, [i for group in columns for i in group]],
    )  # fmt: skip


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
        result.append([float(x) for references, getter in zip(plan.output_references, getters) if references for x in getter(references)])
    fmu.terminate()
    fmu.freeInstance()
    return np.array(result)


def run_by_program(plan: Plan, folder: Path, platform: Platform, program: Path) -> np.ndarray:
    """Outputs after each step, by the platform's own binary. Raises RuntimeError with what the program said."""
    # Relative paths mean the same to an emulated system.
    Path(folder, "plan.txt").write_text(plan.text(folder / "resources"))
    binary = f"binaries/{platform.folder(plan.version)}/{plan.identifier}{platform.suffix}"
    done = subprocess.run([*platform.runner, program, binary, "plan.txt"], cwd=folder, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(done.stderr.strip().splitlines()[-1] if done.stderr.strip() else f"status {done.returncode}")
    return np.array([[struct.unpack(">d", bytes.fromhex(word))[0] for word in line.split()] for line in done.stdout.splitlines()])


def missing(platform: Platform) -> str | None:
    """Why the platform cannot be run here, or None."""
    if platform.runner and shutil.which(platform.runner[0]) is None:
        return f"{platform.name} not run: {platform.runner[0]} is not installed (Debian: {platform.runner_package})"
    folders = [Path(word) for word in platform.runner[1:] if word.startswith("/")]
    absent = [str(f) for f in folders if not f.is_dir()]
    return f"{platform.name} not run: no {absent[0]} (Debian: {platform.runner_package})" if absent else None


def difference(a: np.ndarray, b: np.ndarray) -> float:
    """Largest difference relative to max(1, |b|); infinite when shapes or the places of NaN differ."""
    if a.shape != b.shape or not np.array_equal(np.isnan(a), np.isnan(b)):
        return np.inf
    return float(np.nanmax(np.abs(a - b) / np.maximum(1, np.abs(b)), initial=0))


def main(dist: Path, programs: dict[str, Path]) -> None:
    left_out = {p.name: reason for p in PLATFORMS if p.name in programs and (reason := missing(p))}
    for reason in left_out.values():
        print(reason)
    for version in (2, 3):
        for fmu in sorted((dist / f"fmi{version}").glob("*.fmu")):
            with tempfile.TemporaryDirectory() as unpacked:
                folder = Path(fmpy.extract(str(fmu), unzipdir=unpacked))
                plan = read_plan(folder)
                reference = run_by_fmpy(plan, folder)
                said = []
                for platform in PLATFORMS:
                    if platform.folder(version) is None or platform.name not in programs or platform.name in left_out:
                        continue
                    try:
                        worst = difference(run_by_program(plan, folder, platform, programs[platform.name]), reference)
                    except RuntimeError as error:
                        sys.exit(f"trajectories: fmi{version}/{fmu.name} on {platform.name}: {error}")
                    if worst > TOLERANCE:
                        sys.exit(f"trajectories: fmi{version}/{fmu.name} on {platform.name} differs from fmpy by {worst:.2g}")
                    said.append(f"{platform.name} {worst:.1g}")
                print(f"fmi{version}/{fmu.name}: {reference.shape[0]} steps, {reference.shape[1]} outputs; largest difference to fmpy: {', '.join(said)}")


if __name__ == "__main__":
    main(Path(sys.argv[1]), {p: Path(f).resolve() for p, f in (a.split("=", 1) for a in sys.argv[2:])})
