"""Recordings of inertial and magnetic sensors, in SI units: what every reader answers and every filter takes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from hnav.errors import HnavValueError
from hnav.io.aids import AidSamples, arrived_within
from hnav.numbers import floats
from hnav.units import TESLA_PER

if TYPE_CHECKING:
    import pandas as pd

    from hnav.io.findings import Finding

CSV_COLUMNS = ("t_s", "gx", "gy", "gz", "ax", "ay", "az", "mx", "my", "mz")
ARRAYS = {"gyro": "rate_b_rad_s", "accel": "force_b_m_s2", "mag": "field_b_tesla"}
"""Where the samples of a sensor stand in a Recording."""
ORDER = "Recording(name, t_s, rate_b_rad_s, force_b_m_s2, field_b_tesla)"


class RecordingError(HnavValueError):
    """A file cannot be read; the text names file, line and column as far as they are known."""

    def __init__(self, text: str, argument: str | None = None):
        super().__init__("no data", text, argument)

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (str(self), self.argument)


@dataclass(frozen=True)
class Unit:
    """The unit that was assumed for the numbers of a file."""

    name: str
    """One of hnav.units.SI_PER[sensor]."""
    source: str
    """given, by header, by format, by its intervals, by its size, or assumed."""

    @property
    def is_inferred(self) -> bool:
        """From the numbers themselves."""
        return self.source.startswith("by its")

    def __str__(self) -> str:
        return f"{self.name} {self.source}"


@dataclass(frozen=True)
class Origin:
    """How a recording was read."""

    format: str
    """The name of the format, one of those of hnav.io.readers.FORMATS."""
    units: Mapping[str, Unit]
    """By gyro, accel, mag and time."""
    notes: tuple[str, ...] = ()
    """Other choices of the reader: topics, rows left out."""


@dataclass(frozen=True, repr=False)
class Recording:
    """Samples in SI units, one row for each instant; a row of NaN is a missing sample.

    Sensors of different rates keep their own times: t_s holds the instants of all of them, and nothing is resampled.
    reference_q_nb is the attitude by another system, body to east-north-up, scalar first; NaN where it is unknown.
    movement marks the rows that a score is taken over. A row stands for the instant at which its samples arrive:
    field_t_s, on instants of t_s, is the measurement time of a delayed magnetometer; NaN where no sample arrives. Satellites,
    pressure and wheels stand beside the rows, in aids, with their own times; of them the AHRS uses the speed, the HREKF none.
    """

    name: str
    t_s: np.ndarray  # n, increasing
    rate_b_rad_s: np.ndarray  # n x 3
    force_b_m_s2: np.ndarray  # n x 3
    field_b_tesla: np.ndarray | None = None  # n x 3
    reference_q_nb: np.ndarray | None = None  # n x 4
    movement: np.ndarray | None = None  # n, bool
    field_t_s: np.ndarray | None = None  # n: when the field of a row was measured; None: at t_s, as the rest of the row
    aids: Mapping[str, AidSamples] = field(default_factory=dict, kw_only=True)  # by kind, one of hnav.io.aids.AIDS
    origin: Origin | None = field(default=None, kw_only=True)  # how it was read; None: made, in SI units

    def __post_init__(self) -> None:
        """Lists are arrays. Raises RecordingError for arrays of other shapes, and for a name that is not a text."""
        if not isinstance(self.name, str):
            raise RecordingError(f"name is no text but a {type(self.name).__name__}: write {ORDER}", "name")
        object.__setattr__(self, "t_s", floats(self.t_s))
        shape = self.t_s.shape
        for name in ARRAYS.values():
            if (values := getattr(self, name)) is not None:
                array = floats(values)
                if len(shape) != 1 or array.shape != (*shape, 3):
                    raise RecordingError(f"{self.name}: {name} has the shape {array.shape}, t_s {shape}: n x 3 and n are needed")
                object.__setattr__(self, name, array)

    def __repr__(self) -> str:
        sensors = [_described(self, sensor) for sensor in ARRAYS]
        sensors += [f"{kind} {len(one.t_s)}{_rate(one.t_s)}" for kind, one in self.aids.items()]
        read_as = f"{self.origin.format}, " if self.origin else ""
        span = f"{self.t_s[-1] - self.t_s[0]:.6g} s from {self.t_s[0]:.10g} s, " if len(self.t_s) else ""
        return f"Recording({self.name!r}: {read_as}{span}{len(self.t_s)} rows; {'; '.join(sensors)})"

    def samples(self, sensor: str) -> tuple[np.ndarray, np.ndarray]:
        """Times (m) and samples (m x 3) of gyro, accel or mag, without the rows that have none."""
        values: np.ndarray | None = getattr(self, ARRAYS[sensor])
        if values is None:
            return np.empty(0), np.empty((0, 3))
        present = np.isfinite(values).all(axis=1)
        return self.t_s[present], values[present]

    def check(self, hemisphere: str | None = None) -> list[Finding]:
        """Implausible properties of the recording, the worst first: units, axes, signs, gaps, sensors that do not work.

        hemisphere: "north" or "south" of the magnetic equator, if it is known; without it, north is taken.
        """
        from hnav.io.plausibility import check  # imports this module

        return check(self, hemisphere)

    def to_dataframe(self) -> pd.DataFrame:
        """The samples as a table of pandas, indexed by t_s, with the columns gx to mz in rad/s, m/s2 and tesla."""
        import pandas as pd

        columns: dict[str, Any] = {}
        for sensor, array in ARRAYS.items():
            values = getattr(self, array)
            if values is not None:
                columns |= {sensor[0] + axis: values[:, i] for i, axis in enumerate("xyz")}
        return pd.DataFrame(columns, index=pd.Index(self.t_s, name="t_s"))

    @classmethod
    def from_dataframe(cls, frame: pd.DataFrame, name: str = "table", **options: Any) -> Recording:
        """From a table of pandas whose columns are named as those of a file may be; options as of hnav.read.

        Times are a column, or the index: numbers in s, or instants. Raises RecordingError.
        """
        from hnav.io.readers import from_dataframe  # imports this module

        return from_dataframe(frame, name, **options)

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
        return Recording(**cut | {"aids": arrived_within(self.aids, -np.inf, float(self.t_s[0]) + duration_s)})

    def in_order_of_measurement(self) -> Recording:
        """Late fields in the rows of their measurement."""
        if self.field_t_s is None:
            return self
        measured = self.needed("field_b_tesla")
        field = np.full_like(measured, np.nan)
        arrived = np.isfinite(self.field_t_s)
        field[np.searchsorted(self.t_s, self.field_t_s[arrived])] = measured[arrived]
        return replace(self, field_b_tesla=field, field_t_s=None)

    def mag_unit(self) -> str:
        """The unit that the field had in the file; uT where that is not known."""
        unit = self.origin.units.get("mag") if self.origin else None
        return unit.name if unit and unit.name in TESLA_PER else "uT"


def _described(recording: Recording, sensor: str) -> str:
    """Rate and unit of a sensor."""
    t_s, _ = recording.samples(sensor)
    if not len(t_s):
        return f"no {sensor}"
    unit = f" ({recording.origin.units[sensor]})" if recording.origin and sensor in recording.origin.units else ""
    return f"{sensor} {len(t_s)}{_rate(t_s)}{unit}"


def _rate(t_s: np.ndarray) -> str:
    steps_s = np.diff(t_s)
    return f" at {1 / np.median(steps_s):.4g} Hz" if len(steps_s) and np.median(steps_s) > 0 else ""
