"""Random calls on every archive of build/fmus, in each kind: crashes, broken promises and the longest call.

    ./run study calls --seconds 30

Half of the sequences keep to the ranges that the archive declares; driver.cpp lists the other calls and the checks.
"""

from __future__ import annotations

import math
import re
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from itertools import chain
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import fmpy
import typer
from fmpy.model_description import ModelDescription, ScalarVariable

from hnav.cli.console import say, show
from hnav.cli.words import UsageError
from hnav.fmi.fmus import fmu_path
from hnav.places import CHECKOUT
from studies.command import WORKERS, Workers, titled_table, tracked
from studies.processes import fmi_headers, said_by

PROGRAM = CHECKOUT / ".cache" / "calls" / "driver"
TYPES = {"Real": "r", "Float64": "r", "Integer": "i", "Int32": "i", "Enumeration": "e", "Boolean": "b", "Clock": "c"}
CAUSALITIES = {"parameter": "p", "structuralParameter": "s", "input": "i", "output": "o"}


class Case(NamedTuple):
    archive: Path
    version: int
    kind: str


class Counts(NamedTuple):
    """Of one archive and kind: calls, those that answered OK, sequences, the longest call (s of the thread), and the lines about
    broken promises and calls of more than a second."""

    calls: int
    ok: int
    sequences: int
    longest_s: float
    broken: list[str]


def built() -> Path:
    """The program. Raises UsageError."""
    PROGRAM.parent.mkdir(parents=True, exist_ok=True)
    headers, source = fmi_headers(), Path(__file__).with_name("driver.cpp")
    folders = [f"-I{folder}" for folder in (headers, CHECKOUT / "c_src", source.parents[1])]
    said_by(["c++", "-std=c++17", "-O2", "-g1", *folders, source, "-ldl", "-o", PROGRAM])
    return PROGRAM


def cases(only: str | None = None) -> list[Case]:
    """Every archive that is built, in each of its kinds."""
    found = []
    for version in (2, 3):
        for archive in sorted(fmu_path("Ahrs", version).parent.glob("*.fmu")):
            description = fmpy.read_model_description(str(archive), validate=False)
            kinds = {"CS": description.coSimulation, "ME": description.modelExchange}
            found += [Case(archive, version, kind) for kind, there in kinds.items() if there]
    return [case for case in found if only is None or case.archive.stem == only]


def row_of(variable: ScalarVariable, limits: dict[str, tuple[int, int]]) -> str:
    """The variable in a plan: reference, type, causality, numbers, minimum, maximum."""
    type_name = TYPES[variable.type]
    count = math.prod(int(dimension.start or 1) for dimension in variable.dimensions)
    low, high = (math.nan if end is None else float(end) for end in (variable.min, variable.max))
    if type_name == "e":
        low, high = limits[variable.declaredType.name]
    ends = [repr(unbounded if math.isnan(end) else end) for end, unbounded in ((low, -math.inf), (high, math.inf))]
    return f"{variable.valueReference} {type_name} {CAUSALITIES.get(variable.causality, 'l')} {count} {' '.join(ends)}"


def plan_of(description: ModelDescription, case: Case, unpacked: Path) -> str:
    limits = {
        of.name: (min(int(item.value) for item in of.items), max(int(item.value) for item in of.items))
        for of in description.typeDefinitions
        if of.items
    }
    variables = [v for v in description.modelVariables if v.type in TYPES and v.name != "time"]
    states = sum(math.prod(int(d.start) for d in unknown.variable.dimensions) for unknown in description.derivatives)
    resources = unpacked / "resources"
    head = f"{case.version} {case.kind}\n{description.guid or description.instantiationToken}\n"
    head += f"{resources.as_uri() if case.version == 2 else f'{resources}/'}\n{states} {len(variables)}\n"
    return head + "\n".join(row_of(v, limits) for v in variables) + "\n"


def counts_of(program: Path, case: Case, seed: int, seconds: float) -> Counts:
    """Of the sequences that one process runs in so many seconds of processor."""
    description = fmpy.read_model_description(str(case.archive), validate=False)
    kind: Any = description.coSimulation if case.kind == "CS" else description.modelExchange
    platform = "linux64" if case.version == 2 else "x86_64-linux"
    with tempfile.TemporaryDirectory(prefix="hnav_calls_") as folder:
        fmpy.extract(str(case.archive), folder)
        plan = Path(folder) / "plan.txt"
        plan.write_text(plan_of(description, case, Path(folder)))
        binary = Path(folder) / "binaries" / platform / f"{kind.modelIdentifier}.so"
        arguments = [str(argument) for argument in (program, binary, plan, seed, seconds)]
        done = subprocess.run(arguments, capture_output=True, text=True, check=False, cwd=folder)
    if done.returncode > 1:
        raise UsageError(f"{case.archive.name}: {done.stderr.strip() or done.returncode}")
    lines = done.stdout.strip().splitlines()
    totals = re.fullmatch(r"(\d+) calls, (\d+) ok, in (\d+) sequences, longest ([\d.]+) s", lines[-1] if lines else "")
    if not totals:
        return Counts(0, 0, 0, math.nan, lines or [f"exit status {done.returncode}"])
    return Counts(int(totals[1]), int(totals[2]), int(totals[3]), float(totals[4]), lines[:-1])


def row_of_counts(counts: Counts) -> tuple[str, ...]:
    share = f"{100 * counts.ok / counts.calls:.0f}" if counts.calls else "-"
    return str(counts.calls), share, str(counts.sequences), f"{counts.longest_s:.3f}", str(len(counts.broken))


def command(
    seconds: Annotated[float, typer.Option(min=0.1, help="Of processor, for each archive and kind")] = 10,
    seed: Annotated[int, typer.Option(min=0, help="Of the first sequence")] = 1,
    only: Annotated[str | None, typer.Option(help="One archive, such as Ahrs")] = None,
    workers: Workers = WORKERS,
) -> None:
    """Random calls on every archive in each kind. Exit status 1 when one crashes, breaks a promise or takes more than 1 s."""
    program, every = built(), cases(only)
    with ThreadPoolExecutor(workers) as pool:
        counted = list(tracked(pool.map(lambda case: counts_of(program, case, seed, seconds), every), "archives", len(every)))
    table = titled_table("random calls", "FMU | kind", "calls | OK, % | sequences | longest, s | broken")
    for case, counts in zip(every, counted, strict=True):
        table.add_row(case.archive.stem, f"FMI {case.version} {case.kind}", *row_of_counts(counts))
    columns = list(zip(*counted, strict=True))
    total = Counts(sum(columns[0]), sum(columns[1]), sum(columns[2]), max(columns[3]), list(chain.from_iterable(columns[4])))
    table.add_row("all", "", *row_of_counts(total))
    show(table)
    for case, counts in zip(every, counted, strict=True):
        for line in counts.broken:
            say(f"{case.archive.stem} FMI {case.version} {case.kind}: {line}")
    if total.broken:
        raise typer.Exit(1)
