"""hnav certify: from a recording, a folder of results or an experiment to a certificate, its table and its JSON file."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from hnav.certify.attenuation import attenuation
from hnav.certify.certificate import Certificate, Progress, certify
from hnav.certify.gain_record import GainRecord, record_gains
from hnav.errors import HnavRuntimeError, HnavValueError
from hnav.io.recordings import Recording, RecordingError, read_recording
from hnav.native.library import PRESETS, Options, option_table
from hnav.systems.turntable import Experiment, Turntable

EXPERIMENT_S = 40.0


def read_results(folder: Path) -> Recording:
    """signals.h5 of a simulation: t_s and one dataset of three columns, or three of one, for each sensor.

    Sensors are found by the ends of their names: gyro.rate, accel.force, mag.field, each as `component.variable` or with
    [1], [2], [3] behind; a row of NaN is a missing sample. Where a counter stands beside (gyro.sample, ...), the value is
    held between samples, and rows at which the counter stays are missing ones. Raises RecordingError.
    """
    import h5py

    path = folder / "signals.h5"
    if not path.is_file():
        raise RecordingError(f"{folder}: no signals.h5 in this folder")
    try:
        with h5py.File(path) as file:
            signals: dict[str, np.ndarray] = {}
            file.visititems(
                lambda name, item: signals.update({name.replace("/", "."): item[:]}) if isinstance(item, h5py.Dataset) else None
            )
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read: {str(error).splitlines()[0]}") from None
    if "t_s" not in signals:
        raise RecordingError(f"{path}: the dataset t_s is missing")

    def vector(end: str) -> np.ndarray:
        owners = [name[: -len(last)] for last in (end, f"{end}[1]") for name in signals if name.endswith(last)]
        for owner in owners:
            parts = [signals.get(f"{owner}{end}[{i}]") for i in (1, 2, 3)]
            values = (
                signals[owner + end]
                if owner + end in signals
                else None
                if any(p is None for p in parts)
                else np.stack(parts, axis=1)
            )
            if values is None or values.ndim != 2 or values.shape[1] != 3:
                continue
            counter = signals.get(f"{owner}{end.split('.')[0]}.sample")
            fresh = np.ones(len(values), bool) if counter is None else np.diff(counter, prepend=0.0) != 0
            return np.where(fresh[:, None], values, np.nan)
        raise RecordingError(f"{path}: no dataset ends in {end}, nor in {end}[1] to {end}[3]")

    return Recording(
        folder.name, signals["t_s"], *(vector(end).astype(float) for end in ("gyro.rate", "accel.force", "mag.field"))
    )


def filter_of_run(folder: Path, component: str = "hrekf") -> tuple[str, dict[str, str]]:
    """(preset, settings) that the component had in the simulation, from its run.json; ("default", {}) where it says nothing.

    Without its solver: the certificate's reference knows the closed form only. Raises RecordingError.
    """
    path = folder / "run.json"
    try:
        said = json.loads(path.read_text())["parameters"] if path.is_file() else {}
        values = {name[len(component) + 1 :]: float(value) for name, value in said.items() if name.startswith(component + ".")}
        preset = PRESETS[int(values.pop("preset", 0))]
    except (OSError, ValueError, TypeError, KeyError, IndexError, AttributeError):
        raise RecordingError(f"{path}: no parameters of a simulation in it") from None
    settings = {}
    for name, option in option_table("hrekf").items():
        if name in values and name != "solver":
            settings[name] = option.choices[int(values[name])] if option.choices else f"{values[name]:.17g}"
        elif f"{name}[1]" in values:
            settings[name] = ",".join(f"{values[f'{name}[{i + 1}]']:.17g}" for i in range(option.count))
    return preset, settings


def certify_run(
    recording: Path | None, experiment: str | None, filter: str, preset: str | None, settings: dict[str, str], begin_s: float,
    duration_s: float | None, seed: int, gain_factor: float, mag_unit: str, progress: Progress,
) -> Certificate:  # fmt: skip
    """recording: file or folder; else experiment by name. The flow is solved in closed form unless settings say otherwise.

    Of a folder the filter is that of the simulation's component hrekf; a preset given replaces its settings.
    """
    if filter != "hrekf":
        raise HnavRuntimeError("unsupported", f"--filter {filter}: the certificate is of hrekf, whose gains the theorem is about")
    known: Experiment | None = None
    if experiment is not None:
        if experiment != "turntable":
            raise HnavValueError("option", f"--experiment {experiment}: choose turntable")
        known = Turntable().run(EXPERIMENT_S if duration_s is None else duration_s, seed)
        data, settings = known.recording, known.settings | settings
    else:
        data = read_results(recording) if recording.is_dir() else read_recording(recording, mag_unit)
        if recording.is_dir() and preset is None:
            preset, simulated = filter_of_run(recording)
            settings = simulated | settings
        data = data if duration_s is None else data.cropped(duration_s)
    options = Options(filter, preset or "default", **{"solver": "closed_form"} | settings)
    whole = record_gains(data, options, lambda done, of: progress("samples", done, of))
    record = whole.from_time(data.t_s[0] + begin_s)
    if len(record.corrections) < 2:
        raise HnavRuntimeError("no data", f"{data.name}: no corrections after {begin_s:g} s: give an earlier --from")
    found = certify(record.with_gain(gain_factor) if gain_factor != 1 else record, progress, seed=seed)
    if known is not None and gain_factor == 1:
        found.attenuation = attenuation_of(whole, known, options)
    return found


def attenuation_of(record: GainRecord, known: Experiment, options: Options) -> float:
    """From the first correction on, whose transient the ratio weighs against the start's covariance."""
    rows = np.searchsorted(known.recording.t_s, [c.t_s for c in record.corrections])
    weight = np.repeat([options.gamma_weight_attitude, options.gamma_weight_bias], 3)
    return attenuation(record.corrections, known.q_nb[rows], known.gyro_bias_rad_s, weight)


def write_certificate(path: Path, found: Certificate) -> None:
    path.write_text(json.dumps(found.figures(), indent=2, allow_nan=False) + "\n")


def certificate_rows(found: Certificate) -> list[tuple[str, str, str]]:
    """(figure, value, meaning) for tables and reports, without the figures that were not reached."""

    def number(value: float, unit: str = "", digits: int = 3) -> str:
        return "-" if not np.isfinite(value) else f"{value:.{digits}g}{unit}"

    printed, starts = found.printed, found.starts
    free = found.free_rate_1_s
    bound = number(found.gamma_squared) if np.isfinite(found.gamma_squared) else "infinite, gamma is off"
    limit = (
        f"; beyond {number(found.interval_limit_s)} s the correction at {found.interval_limit_at_s:g} s alone lets errors grow"
        if np.isfinite(found.interval_limit_s)
        else ""
    )
    rows = [
        ("corrections", f"{found.corrections}", f"every {1e3 * found.interval_s:.4g} ms; library and reference agree to {found.largest_difference:.0e}"),
        ("decay rate", number(found.rate_1_s, " 1/s"), f"one P for all corrections; the slowest single one allows {number(found.spectral_rate_1_s)}"),
        ("region", number(found.region_deg, " deg"), f"largest attitude error inside; all below {number(found.sure_deg)} deg are, without bias error"),
        ("", number(found.region_bias_deg_s, " deg/s"), f"largest bias error inside; errors decay by {number(found.region_rate_1_s)} 1/s or more"),
        ("noise floor", number(found.noise_floor_deg, " deg"), f"bound on the rms error; {number(found.noise_share)} of the level, must stay below 1"),
        ("longest interval", number(found.longest_interval_s, " s"), f"{number(found.longest_interval_s / found.interval_s)} times the actual one: linear part, these gains, all corrections equally far apart{limit}"),
        ("", number(found.mixed_interval_s, " s"), f"{number(found.mixed_interval_s / found.interval_s)} times: linear part, intervals from the actual one to this in any order; checked at both ends and four between"),
        ("", number(found.region_interval_s, " s"), f"{number(found.region_interval_s / found.interval_s)} times: with the nonlinear remainders, in a region of half the radius, no decay asked"),
        ("boundary starts", "-" if starts is None else f"{starts.worst_ratio:.6f}", "V over its bound at the worst correction of the nonlinear equations; must not exceed 1"),
        ("attenuation", number(found.attenuation), f"error energy over disturbance energy; gamma^2 = {bound}"),
        ("solver-free rate", number(float(free.min()), " 1/s"), f"by the filter's own covariance, at the slowest correction; median {number(float(np.median(free)))}"),
        ("theorem as printed", "holds" if printed.holds else "fails", f"d > 0 never; d < 0 needs a flow that contracts by {printed.needed_flow_rate_1_s:.3g} 1/s, it has {printed.flow_rate_1_s:.3g}"),
        ("search", f"{found.seconds:.1f} s" if found.solves else "-", f"{found.solves} programs over up to {found.vertices} corrections; least eigenvalue over all {number(found.smallest_eigenvalue)}"),
    ]  # fmt: skip
    return [row for row in rows if row[1] != "-"]


def print_certificate(found: Certificate, console: Console) -> None:
    table = Table("", "value", "meaning", title=found.name, show_header=False)
    for row in certificate_rows(found):
        table.add_row(*row)
    console.print(table)
    console.print(
        "certified" if found.certified else f"not certified: {found.reason}", highlight=False, soft_wrap=True, markup=False
    )
