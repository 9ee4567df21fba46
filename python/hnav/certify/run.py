"""From a recording, a folder of results or the paper's experiment to a certificate and its JSON file."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from hnav.certify.attenuation import attenuation
from hnav.certify.certificate import Certificate, Progress, certify
from hnav.certify.gain_record import GainRecord, record_gains
from hnav.certify.results_folder import filter_of_run, read_results
from hnav.errors import HnavRuntimeError, HnavValueError
from hnav.filters.options import Options
from hnav.io.outputs import write_files
from hnav.io.readers import read
from hnav.io.recordings import Recording
from hnav.systems.turntable_recording import Experiment, Turntable

FILTER = "hrekf"
EXPERIMENT_S = 40.0


@dataclass(frozen=True)
class Thinning:
    """What a recording keeps of force and field, to ask what slower or lossy sensors would do to the same run."""

    force_every: int = 1
    field_every: int = 1
    lost: float = 0.0  # share of the samples that are left, each lost by itself

    def __post_init__(self) -> None:
        for name in ("force_every", "field_every"):
            if getattr(self, name) < 1:
                raise HnavValueError("option", f"{name} = {getattr(self, name)}: give 1 or more")
        if not 0 <= self.lost < 1:
            raise HnavValueError("option", f"lost = {self.lost:g}: give a share from 0 to below 1")

    def of(self, data: Recording, seed: int) -> Recording:
        if self == Thinning():
            return data
        rng = np.random.default_rng(seed)

        def kept(values: np.ndarray, every: int) -> np.ndarray:
            rows = np.flatnonzero(np.isfinite(values).all(axis=1))[::every]
            rows = rows[rng.random(len(rows)) >= self.lost]
            left = np.full_like(values, np.nan)
            left[rows] = values[rows]
            return left

        field = None if data.field_b_tesla is None else kept(data.field_b_tesla, self.field_every)
        return replace(data, force_b_m_s2=kept(data.force_b_m_s2, self.force_every), field_b_tesla=field)


def certify_run(
    recording: Path | None,
    experiment: str | None = None,
    *,
    preset: str | None = None,
    settings: Mapping[str, str] | None = None,
    begin_s: float = 15.0,
    duration_s: float | None = None,
    seed: int = 5,
    gain_factor: float = 1.0,
    mag_unit: str | None = None,
    thinning: Thinning = Thinning(),
    progress: Progress = lambda what, done, of: None,
    announce: Callable[[float], None] | None = None,
) -> Certificate:
    """recording: file or folder; else experiment by name. The flow is solved in closed form unless settings say otherwise.

    Of a folder the filter is that of the simulation's component hrekf; a preset given replaces its settings. begin_s: leave
    out the corrections before; gain_factor: of the gains that are certified; thinning: of the samples that the filter
    gets; announce: as of certify. Raises HnavError and RecordingError.
    """
    settings = dict(settings or {})
    known: Experiment | None = None
    if recording is None:
        if experiment != "turntable":
            raise HnavValueError("option", f"experiment = {experiment}: choose turntable", "experiment")
        known = Turntable().run(EXPERIMENT_S if duration_s is None else duration_s, seed)
        data, settings = known.recording, known.settings | settings
    else:
        data, preset, simulated = _read(recording, preset, mag_unit)
        settings = simulated | settings
        data = data if duration_s is None else data.cropped(duration_s)
    data = thinning.of(data, seed)
    options = Options(FILTER, preset or "default", **{"solver": "closed_form"} | settings)
    whole = record_gains(data, options, lambda done, of: progress("samples", done, of))
    record = whole.from_time(data.t_s[0] + begin_s)
    if len(record.corrections) < 2:
        raise HnavRuntimeError("no data", f"begin_s = {begin_s:g}: {data.name} has no corrections after it; give less", "begin_s")
    found = certify(record.with_gain(gain_factor) if gain_factor != 1 else record, progress, seed=seed, announce=announce)
    if known is not None and gain_factor == 1:
        found.attenuation = attenuation_of(whole, known, options)
    return found


def _read(path: Path, preset: str | None, mag_unit: str | None) -> tuple[Recording, str | None, dict[str, str]]:
    """Recording, preset and settings: of a folder without a preset given those of its simulation."""
    if not path.is_dir():
        return read(path, mag_unit=mag_unit), preset, {}
    return read_results(path), *((preset, {}) if preset is not None else filter_of_run(path))


def attenuation_of(record: GainRecord, known: Experiment, options: Options) -> float:
    """From the first correction on, whose transient the ratio weighs against the start's covariance."""
    rows = np.searchsorted(known.recording.t_s, [c.t_s for c in record.corrections])
    weight = np.repeat([options.gamma_weight_attitude, options.gamma_weight_bias], 3)
    return attenuation(record.corrections, known.q_nb[rows], known.gyro_bias_rad_s, weight)


def write_certificate(path: Path, found: Certificate) -> None:
    """The figures as JSON. Raises OutputError."""
    write_files({path: json.dumps(found.figures(), indent=2, allow_nan=False) + "\n"})
