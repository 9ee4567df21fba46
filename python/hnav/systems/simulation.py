"""A simulation of a system of FMUs, and the two files of its results.

DIR/signals.h5   dataset `t_s` (n) and one dataset (n, float64) for each recorded "component.variable", attribute `unit`
DIR/run.json     what was run: system, scenario, grade, parameters, seed, step, wall times, lost samples, versions

The same system, parameters and seed give the same bytes of signals.h5.
"""

from __future__ import annotations

import importlib.metadata
import json
import math
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Any, Self

import h5py

from hnav import __version__
from hnav.filters.attitude_recording import Progress
from hnav.fmi.fmus import KeptFmus
from hnav.io.json_file import read_json
from hnav.io.outputs import write_files
from hnav.systems.master import RECORDED, Record, run_system
from hnav.systems.results import Run as Run
from hnav.systems.run_checks import check_about, check_certificate, check_signals
from hnav.systems.ssp_reader import read_system, system_path
from hnav.systems.structure import Parameter, System, Value, refuse

SIGNALS, ABOUT, CERTIFICATE = "signals.h5", "run.json", "certificate.json"
DEFAULT_STEP_S, DEFAULT_STOP_S = 0.01, 10.0


class LoadedSystem:
    """A system whose files and FMUs are loaded once, for many runs one after the other.

    Use as a context manager: it unloads the FMUs and removes unpacked files. Raises HnavError.
    """

    def __init__(self, system: str | Path, allow_outside: bool = False):
        """system: name, .ssp or folder."""
        self._system = read_system(system_path(str(system)), allow_outside)
        self.fmus = KeptFmus()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.fmus.__exit__()
        self._system.__exit__()

    def system(self) -> System:
        """The system with the parameters that its files bind."""
        return self._system.as_bound()


def simulate(
    system: str | Path | LoadedSystem,
    scenario: str | None = None,
    grade: str | None = None,
    settings: Mapping[str, Value] | None = None,
    seed: int | None = None,
    step_s: float | None = None,
    stop_s: float | None = None,
    record: Sequence[str] = RECORDED,
    progress: Progress | None = None,
    allow_outside: bool = False,
) -> Run:
    """Reads the system (name, .ssp or folder; of a LoadedSystem nothing more), sets its parameters and runs it.

    settings: values by "component.parameter", after grade and scenario; text will do. step_s, stop_s None: what the
    system asks for. allow_outside: an archive may name FMUs that are not in it. FMUs are native code, run by this process.
    A component that fails ends the run: about["failure"] states why and the samples until then are kept. Raises
    HnavError for what cannot begin.
    """
    with nullcontext(system) if isinstance(system, LoadedSystem) else LoadedSystem(system, allow_outside) as loaded:
        read = loaded.system()
        read.choose(grade, scenario)
        read.apply([Parameter(name, "", str(value)) for name, value in (settings or {}).items()], "settings")
        if seed is not None:
            read.seed(seed)
        step_s = step_s if step_s is not None else read.step_s or DEFAULT_STEP_S
        stop_s = stop_s if stop_s is not None else read.stop_s or DEFAULT_STOP_S
        left = run_system(read, stop_s, step_s, record, progress=progress, fmus=loaded.fmus)
        components = {
            c.name: {"model": c.description.modelName, "fmi": c.description.fmiVersion, "version": c.description.version or ""}
            for c in read.components.values()
        }
        about = {
            "system": read.name, "description": read.description, "scenario": scenario, "grade": grade, "seed": seed,
            "start_s": read.start_s, "stop_s": stop_s, "step_s": step_s, "parameters": read.parameters(), "components": components,
        }  # fmt: skip
    return Run(left.t_s, left.columns, left.units, about | _outcome(left))


def _outcome(left: Record) -> dict[str, Any]:
    packages = ("fmpy", "h5py", "numpy")
    versions = {"hnav": __version__} | {name: importlib.metadata.version(name) for name in packages}
    return {"wall_s": left.wall_s, "lost": left.lost, "failure": left.failure, "versions": versions}


def write_run(run: Run, folder: Path) -> None:
    """Makes a missing folder; run.json is written last and marks the folder as complete. Raises OutputError.

    The certificate of an earlier run is removed, because it is not about this one.
    """
    about = json.dumps(_plain(run.about), indent=2, allow_nan=False) + "\n"
    files: dict[Path, bytes | str] = {folder / SIGNALS: _signals(run), folder / ABOUT: about}
    write_files(files, make_folders=True, gone=[folder / CERTIFICATE])


def _plain(value: Any) -> Any:
    """The value for JSON: non-finite numbers, which a parameter may be, as text."""
    if isinstance(value, Mapping):
        return {name: _plain(part) for name, part in value.items()}
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value


def _signals(run: Run) -> bytes:
    """The bytes of signals.h5, made in memory: on a full disk HDF5 aborts the process that closes a file."""
    # Without creation times the bytes depend on the numbers only.
    with h5py.File(SIGNALS, "w", driver="core", backing_store=False, track_order=True) as target:
        target.create_dataset("t_s", data=run.t_s, track_times=False).attrs["unit"] = "s"
        for name, values in run.columns.items():
            target.create_dataset(name, data=values, track_times=False).attrs["unit"] = run.units.get(name, "")
        target.flush()
        return bytes(target.id.get_file_image())


def read_run(folder: Path) -> Run:
    """What write_run wrote, and the figures of hnav certify as about["certificate"] if certificate.json stands beside it.

    Raises HnavError that names the file that is missing or damaged.
    """
    for file in (folder / ABOUT, folder / SIGNALS):
        if not file.is_file():
            other = folder / (SIGNALS if file.name == ABOUT else ABOUT)
            refuse(f"{file}: file not found; hnav simulate writes it{', and was not done here' if other.is_file() else ''}")
    about = read_json(folder / ABOUT)
    check_about(about, folder / ABOUT)
    if (file := folder / CERTIFICATE).is_file():
        about["certificate"] = read_json(file)
        check_certificate(about["certificate"], file)
    file = folder / SIGNALS
    try:
        with h5py.File(file) as source:
            units = {name: str(source[name].attrs.get("unit", "")) for name in source if name != "t_s"}
            columns = {name: source[name][()] for name in units}
            t_s = source["t_s"][()]
    except Exception as error:  # HDF5 raises errors of any type for a damaged file
        refuse(f"{file}: cannot be read: {(str(error) or type(error).__name__).splitlines()[0]}")
    check_signals(t_s, columns, file)
    return Run(t_s, columns, units, about)
