"""Recordings of inertial and magnetic sensors: BROAD trials (HDF5 and MAT) and CSV files.

BROAD: D. Laidig, M. Caruso, A. Cereatti, T. Seel, "BROAD - A Benchmark for Robust Inertial Orientation Estimation",
Data 6(7):72, 2021, doi 10.3390/data6070072. Its reference attitude is optical, sensor to east-north-up.
"""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from hnav.errors import HnavValueError
from hnav.io.mat_file import read_mat
from hnav.units import TESLA_PER

CSV_COLUMNS = ("t_s", "gx", "gy", "gz", "ax", "ay", "az", "mx", "my", "mz")
TRIAL_NAME = re.compile(r"(\d\d)_(un)?disturbed_")


class RecordingError(HnavValueError):
    """A file cannot be read; the text names file, line and column as far as they are known."""

    def __init__(self, text: str, argument: str | None = None):
        super().__init__("no data", text, argument)

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (str(self), self.argument)


@dataclass(frozen=True)
class Recording:
    """Samples in SI units, one row for each instant; a row of NaN is a missing sample.

    reference_q_nb is the attitude by another system, body to east-north-up, scalar first; NaN where it is unknown.
    movement marks the rows that a score is taken over. A row stands for the instant at which its samples arrive:
    field_t_s, on instants of t_s, tells of a magnetometer whose samples arrive late; NaN where none arrives.
    """

    name: str
    t_s: np.ndarray  # n, increasing
    rate_b_rad_s: np.ndarray  # n x 3
    force_b_m_s2: np.ndarray  # n x 3
    field_b_tesla: np.ndarray | None = None  # n x 3
    reference_q_nb: np.ndarray | None = None  # n x 4
    movement: np.ndarray | None = None  # n, bool
    field_t_s: np.ndarray | None = None  # n: when the field of a row was measured; None: at t_s, as the rest of the row

    def needed(self, name: str) -> np.ndarray:
        """One of the arrays that a recording may lack, by name. Raises RecordingError if this one lacks it."""
        values: np.ndarray | None = getattr(self, name)
        if values is None:
            raise RecordingError(f"{self.name}: has no {name}")
        return values

    def cropped(self, duration_s: float) -> Recording:
        """The first duration_s seconds."""
        keep = self.t_s < self.t_s[0] + duration_s
        cut = {k: v[keep] if isinstance(v, np.ndarray) else v for k, v in vars(self).items()}
        return Recording(**cut)

    def in_order_of_measurement(self) -> Recording:
        """Late fields in the rows of their measurement."""
        if self.field_t_s is None:
            return self
        measured = self.needed("field_b_tesla")
        field = np.full_like(measured, np.nan)
        arrived = np.isfinite(self.field_t_s)
        field[np.searchsorted(self.t_s, self.field_t_s[arrived])] = measured[arrived]
        return replace(self, field_b_tesla=field, field_t_s=None)


def read_recording(path: str | Path, mag_unit: str = "T") -> Recording:
    """By extension: .csv (mag_unit: T, uT, G or au), .hdf5 and .mat (BROAD). Raises RecordingError."""
    path = Path(path)
    readers = {".csv": lambda p: read_csv(p, mag_unit), ".hdf5": read_broad, ".mat": read_broad}
    if path.suffix not in readers:
        raise RecordingError(f"{path}: unknown extension '{path.suffix}'; a recording is .csv, .hdf5 or .mat")
    if not path.is_file():
        raise RecordingError(f"{path}: no such file")
    return readers[path.suffix](path)


# --------------------------------------------------------------------------------------------- BROAD


def find_trials(folder: str | Path) -> dict[int, Path]:
    """Trial number to file, for all BROAD trials below the folder; HDF5 before MAT, which hold the same numbers."""
    if not Path(folder).is_dir():
        raise RecordingError(f"{folder}: no such folder")
    found: dict[int, Path] = {}
    for pattern in ("*.mat", "*.hdf5"):
        for path in sorted(Path(folder).rglob(pattern)):
            if match := TRIAL_NAME.match(path.name):
                found[int(match.group(1))] = path
    if not found:
        raise RecordingError(f"{folder}: no BROAD trials (NN_undisturbed_*.hdf5, NN_disturbed_*.mat)")
    return dict(sorted(found.items()))


def is_disturbed(name: str) -> bool:
    """Whether a BROAD trial of this name was recorded in a disturbed field."""
    match = TRIAL_NAME.match(name)
    return match is not None and match.group(2) is None


def find_trial(folder: str | Path, number: int) -> Path:
    """The file of one BROAD trial below the folder. Raises RecordingError."""
    trials = find_trials(folder)
    if number not in trials:
        raise RecordingError(f"{folder}: no BROAD trial {number:02d}")
    return trials[number]


def read_broad(path: Path) -> Recording:
    """One trial. The field is in microtesla there, and rows are at equal intervals."""
    names = ("imu_gyr", "imu_acc", "imu_mag", "opt_quat", "movement")
    try:
        if path.suffix == ".hdf5":
            import h5py

            with h5py.File(path) as file:
                data = {name: file[name][:] for name in names}
                rate_hz = float(file.attrs["sampling_rate"])
        else:
            contents = read_mat(path, (*names, "sampling_rate"))
            data = {name: contents[name] for name in names}
            rate_hz = float(contents["sampling_rate"])
    except KeyError as error:
        raise RecordingError(f"{path}: not a BROAD trial: {error.args[0]}") from None
    except Exception as error:  # the readers of both formats raise whatever a damaged file makes them stumble over
        raise RecordingError(
            f"{path}: cannot be read: {str(error).splitlines()[0] if str(error) else type(error).__name__}"
        ) from None
    if not 0 < rate_hz < np.inf:
        raise RecordingError(f"{path}: not a BROAD trial: sampling_rate = {rate_hz:g} Hz")
    n = np.shape(data["imu_gyr"])[0] if np.ndim(data["imu_gyr"]) else 0

    def array(name: str, *shape: int) -> np.ndarray:
        value = np.asarray(data[name])
        if value.dtype.kind not in "biuf":
            raise RecordingError(f"{path}: not a BROAD trial: {name} holds no real numbers")
        if value.shape != (n, *shape) or n == 0:
            raise RecordingError(f"{path}: not a BROAD trial: {name} has the shape {value.shape}, expected {(n or 'n', *shape)}")
        return np.ascontiguousarray(value, float)

    with np.errstate(over="ignore"):  # a rate next to nothing is refused below
        t_s = np.arange(n) / rate_hz
    if not np.isfinite(t_s).all() or (np.diff(t_s) <= 0).any():
        raise RecordingError(f"{path}: not a BROAD trial: sampling_rate = {rate_hz:g} Hz")
    data["movement"] = np.ravel(data["movement"])
    return Recording(
        name=path.stem,
        t_s=t_s,
        rate_b_rad_s=array("imu_gyr", 3),
        force_b_m_s2=array("imu_acc", 3),
        field_b_tesla=array("imu_mag", 3) * 1e-6,
        reference_q_nb=array("opt_quat", 4),
        movement=array("movement").astype(bool),
    )


# --------------------------------------------------------------------------------------------- CSV


def read_csv(path: Path, mag_unit: str = "T") -> Recording:
    """Columns t_s,gx,gy,gz,ax,ay,az,mx,my,mz in any order, header required; mx,my,mz may be absent.

    Rates in rad/s, force in m/s2, field in mag_unit. Empty cells and nan are missing samples; time must increase.
    """
    if mag_unit not in TESLA_PER:
        raise RecordingError(f"mag_unit = {mag_unit}: choose one of {', '.join(TESLA_PER)}", "mag_unit")
    columns = _header(path)
    import pandas

    try:
        table = pandas.read_csv(path, dtype=float, skipinitialspace=True)
    except (ValueError, pandas.errors.ParserError, UnicodeDecodeError):
        raise RecordingError(_fault(path, columns) or f"{path}: cannot be read as CSV") from None
    # A short line looks like one with empty cells at its end.
    if len(table) and np.isnan(table.iloc[:, -1].to_numpy()).any() and (fault := _fault(path, columns)):
        raise RecordingError(fault)
    if table.empty:
        raise RecordingError(f"{path}: no rows after the header")
    values = {name: table[name].to_numpy() for name in columns}
    t_s = values["t_s"]
    # Line 1 is the header, so row i is line i + 2.
    if len(bad := np.flatnonzero(~np.isfinite(t_s))):
        raise RecordingError(f"{path}, line {bad[0] + 2}, column t_s: a time is missing or not finite")
    if len(bad := np.flatnonzero(np.diff(t_s) <= 0)):
        i = bad[0]
        raise RecordingError(f"{path}, line {i + 3}, column t_s: time {t_s[i + 1]:g} does not increase after {t_s[i]:g}")

    def vector(prefix: str) -> np.ndarray:
        return np.stack([values[prefix + axis] for axis in "xyz"], axis=1)

    field = vector("m") * TESLA_PER[mag_unit] if "mx" in columns else None
    return Recording(path.stem, t_s, vector("g"), vector("a"), field)


def _header(path: Path) -> list[str]:
    """The columns of the file, checked."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            columns = [name.strip() for name in next(csv.reader(file), [])]
    except (UnicodeDecodeError, csv.Error):  # bytes that are no text, or a cell without end
        raise RecordingError(f"{path}: not a text file") from None
    if not columns:
        raise RecordingError(f"{path}: the file is empty")
    if not any(name in CSV_COLUMNS for name in columns):
        raise RecordingError(f"{path}, line 1: no header; the first line must name the columns {','.join(CSV_COLUMNS)}")
    needed = CSV_COLUMNS if any(name in columns for name in CSV_COLUMNS[7:]) else CSV_COLUMNS[:7]
    for name in needed:
        if name not in columns:
            raise RecordingError(f"{path}, line 1: the column {name} is missing")
    if len(set(columns)) != len(columns):
        raise RecordingError(f"{path}, line 1: a column appears twice")
    return list(needed)


def _fault(path: Path, columns: list[str]) -> str | None:
    """The first fault of a file that the fast reader did not digest, found line by line."""
    with path.open(newline="", encoding="utf-8-sig", errors="replace") as file:
        rows = csv.reader(file)
        header = [name.strip() for name in next(rows)]
        for line, row in enumerate(rows, start=2):
            if row and len(row) != len(header):
                return f"{path}, line {line}: {len(row)} cells, the header has {len(header)} columns"
            for name, cell in zip(header, row):
                if name in columns and cell.strip():
                    try:
                        float(cell)
                    except ValueError:
                        # A quoted cell may hold anything: its beginning, on one line.
                        return f"{path}, line {line}, column {name}: {cell.strip()[:40]!r} is not a number"
    return None
