"""One side of the comparison: answers scenarios by its own hnav, and leaves the columns of each in a file.

    python worker.py CHECKOUT INPUTS OUTPUTS SCENARIOS

It uses the command line, and FMUs by fmpy, but not hnav's Python and C interfaces. SCENARIOS: a JSON file.
"""

from __future__ import annotations

import contextlib
import io
import json
import re
import runpy
import shutil
import sys
import traceback
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

FAILURE = "!failure"
COUNTS = re.compile(r"(?<=[;,] )([a-z]\w+) (\d+)(?=,|$)", re.MULTILINE)
Columns = dict[str, NDArray[Any]]


def file_of(folder: Path, name: str) -> Path:
    return folder / (name.replace("/", "~") + ".npz")


def by_command(scenario: dict[str, Any], places: dict[str, str]) -> Columns:
    """What `hnav WORDS` writes, and the counts that it prints."""
    words = scenario["words"]
    for name, folder in places.items():
        words = [word.replace(f"{{{name}}}", folder) for word in words]
    said, sys.argv = io.StringIO(), ["hnav", *words]
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        try:
            runpy.run_module("hnav", run_name="__main__")
        except SystemExit as end:
            if end.code:
                raise RuntimeError(f"refused: {said.getvalue().strip()[-400:]}") from None
    counts = {f"said.{name}": np.array([int(number)]) for name, number in COUNTS.findall(said.getvalue())}
    return columns_of(Path(places["out"]) / scenario["answer"]) | counts


def columns_of(answer: Path) -> Columns:
    """Of a table, a calibration or a simulation, with all bits."""
    if answer.suffix == ".parquet":
        import pyarrow.parquet

        table = pyarrow.parquet.read_table(answer)
        return {name: table[name].to_numpy() for name in table.column_names}
    if answer.suffix == ".csv":
        lines = [line for line in answer.read_text().splitlines() if not line.startswith("#")]
        table = np.genfromtxt(lines[1:], delimiter=",", ndmin=2)
        return dict(zip(lines[0].split(","), table.T))
    found: Columns = {}
    if answer.suffix == ".json":
        found = {name: np.asarray(value) for name, value in json.loads(answer.read_text()).items()}
    else:
        import h5py

        with h5py.File(answer / "signals.h5") as file:
            file.visititems(lambda name, item: found.update({name: item[()]}) if isinstance(item, h5py.Dataset) else None)
    return {name: values for name, values in found.items() if values.dtype.kind in "fiub"}


def by_fmu(scenario: dict[str, Any], places: dict[str, str]) -> Columns:
    """All outputs while fmpy simulates it with its example input."""
    import fmpy

    path = Path(places["fmus"]) / f"{scenario['fmu']}.fmu"
    about = fmpy.read_model_description(str(path), validate=False)
    with zipfile.ZipFile(path) as archive:
        has = "resources/example_input.csv" in archive.namelist()
        text = archive.read("resources/example_input.csv").decode() if has else ""
    if scenario["samples"]:
        text = Path(scenario["samples"].replace("{in}", places["in"])).read_text()
    example = np.genfromtxt(io.StringIO(text), delimiter=",", names=True, deletechars="", replace_space=" ") if text else None
    variables = {v.name: v for v in about.modelVariables}
    result = fmpy.simulate_fmu(
        str(path), validate=False, fmi_type="ModelExchange" if scenario["exchange"] else "CoSimulation", start_time=0.0,
        stop_time=scenario["stop_s"], output_interval=0.01, input=example, relative_tolerance=1e-8,
        start_values=dict(_chosen(variables, *parameter) for parameter in scenario["parameters"].items()),
        output=[v.name for v in variables.values() if v.causality == "output" and v.type not in ("String", "Binary")],
    )  # fmt: skip
    return {name: np.ascontiguousarray(result[name]) for name in result.dtype.names}


def _chosen(variables: dict[str, Any], name: str, choice: str) -> tuple[str, int]:
    """A parameter, by its name in whatever group, and the number of a choice."""
    variable = next(v for v in variables.values() if v.causality == "parameter" and v.name.rpartition(".")[2] == name)
    return variable.name, next(int(item.value) for item in variable.declaredType.items if item.name == choice)


def own_hnav(checkout: Path) -> None:
    """Imports the checkout's own hnav; an editable install would be found first. Raises ImportError for another one."""
    sys.meta_path[:] = [finder for finder in sys.meta_path if "editable" not in type(finder).__module__]
    import hnav

    if not Path(str(hnav.__file__)).is_relative_to(checkout):
        raise ImportError(f"{hnav.__file__} answers instead of {checkout}")


def main(checkout: str, inputs: str, outputs: str, scenarios: str) -> None:
    own_hnav(Path(checkout))
    places = {"in": inputs, "out": str(Path(outputs) / "out"), "fmus": str(Path(checkout) / "build/fmus")}
    for scenario in json.loads(Path(scenarios).read_text()):
        Path(places["out"]).mkdir()
        found: Columns
        try:
            found = (by_fmu if scenario["fmu"] else by_command)(scenario, places)
        except Exception as error:
            found = {FAILURE: np.array(str(error) if type(error) is RuntimeError else traceback.format_exc(limit=-2))}
        shutil.rmtree(places["out"])
        # Renamed when complete, because the reader takes any file that exists.
        target = file_of(Path(outputs), scenario["name"])
        partial = target.with_suffix(".part")
        with partial.open("wb") as file:
            np.savez(file, **found)  # type: ignore[arg-type]
        partial.rename(target)


if __name__ == "__main__":
    main(*sys.argv[1:])
