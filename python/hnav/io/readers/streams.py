"""Shared by readers: samples of one sensor with their own times, the options of the caller, and the merge into a recording."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from hnav.io.aids import AidSamples, by_arrival
from hnav.io.readers.aid_columns import ROLES
from hnav.io.readers.clock import WITHIN_S, mended
from hnav.io.readers.unit_names import asked_unit
from hnav.io.recordings import ARRAYS, CSV_COLUMNS, Origin, Recording, RecordingError, Unit
from hnav.units import SI_PER, si_per

LATEST_S = 60.0  # of fixes_late_s
FIXES = ("position", "velocity")
SOURCES = ("imu", "gyro", "accel", "mag", "gnss")  # what columns may name in a file of topics
CUT_OFF = "the last line was cut off and is left out"
BY_RATE = Unit("s", "by the rate given")
"""Of times that a reader has put at the intervals of rate_hz; rows without a sample and lost packets take theirs."""


@dataclass(frozen=True)
class Wishes:
    """Options of the caller, which override the file. Raises RecordingError for unknown ones."""

    columns: Mapping[str, str] = field(default_factory=dict)
    gyro_unit: str | None = None
    accel_unit: str | None = None
    mag_unit: str | None = None
    time_unit: str | None = None
    rate_hz: float | None = None
    axes: Mapping[str, str] = field(default_factory=dict)
    drop_repeats: bool = False
    fixes_late_s: float = 0.0
    only_aids: bool = False
    """Inertial sensors may be missing."""

    def __post_init__(self) -> None:
        for quantity, known in SI_PER.items():
            unit = getattr(self, f"{quantity}_unit")
            if unit is None:
                continue
            if (asked := asked_unit(quantity, unit)) is None:
                more = "" if quantity == "time" else f", or so many of one, as '1/128 {next(iter(known))}'"
                raise RecordingError(f"{quantity}_unit = {unit}: choose one of {', '.join(known)}{more}", f"{quantity}_unit")
            object.__setattr__(self, f"{quantity}_unit", asked)
        if self.rate_hz is not None and not 0 < self.rate_hz < np.inf:
            raise RecordingError(f"rate_hz = {self.rate_hz:g}: must be above 0 Hz", "rate_hz")
        if not abs(self.fixes_late_s) <= LATEST_S:
            raise RecordingError(f"fixes_late_s = {self.fixes_late_s:g}: must lie within {LATEST_S:g} s", "fixes_late_s")
        for name in self.columns:
            if name not in (roles := (*CSV_COLUMNS, *ROLES, *SOURCES)):
                raise RecordingError(f"columns = {name}: choose from {', '.join(roles)}", "columns")
        for sensor, axes in self.axes.items():
            if sensor not in ARRAYS:
                raise RecordingError(f"axes = {sensor}: choose from {', '.join(ARRAYS)}", "axes")
            turned(axes)

    def unit(self, quantity: str, by_header: str | None = None, by_format: str | None = None) -> Unit:
        """The unit of gyro, accel, mag or time: as given, else by the header, else by the format, else SI."""
        given: str | None = getattr(self, f"{quantity}_unit")
        for name, source in ((given, "given"), (by_header, "by header"), (by_format, "by format")):
            if name:
                return Unit(name, source)
        return Unit(next(iter(SI_PER[quantity])), "assumed")


@dataclass(frozen=True)
class Stream:
    """Samples of one sensor, in the unit of the file."""

    sensor: str
    """gyro, accel or mag."""
    t_s: np.ndarray
    """n."""
    values: np.ndarray
    """n x 3; a row with NaN is no sample."""
    unit: Unit
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Raw:
    """The samples of a file."""

    format: str
    streams: Sequence[Stream]
    time_unit: Unit
    notes: tuple[str, ...] = ()
    extra: Mapping[str, np.ndarray] = field(default_factory=dict)
    """Other arrays of a Recording, on the times of the streams, which are then all the same."""
    aids: Mapping[str, AidSamples] = field(default_factory=dict)
    """By kind; in any order, samples that are none among them."""
    names: Collection[str] = (*CSV_COLUMNS, *ROLES)
    """What columns may name in a file of this format."""


def recording_of(name: str, shown: str, raw: Raw, wishes: Wishes) -> Recording:
    """The streams in SI units, merged by time. shown: what messages call the file. Raises RecordingError."""
    refuse_unused_names(shown, raw, wishes)
    notes = list(raw.notes)
    streams = []
    rate_hz = None if raw.time_unit == BY_RATE else wishes.rate_hz
    for stream in raw.streams:
        ordered, note = _in_order(shown, stream, rate_hz)
        streams.append(_without_repeats(ordered) if wishes.drop_repeats else ordered)
        notes += [*stream.notes, *([note] if note else [])]
    if not streams or not any(len(stream.t_s) for stream in streams):
        raise RecordingError(f"{shown}: no samples of a gyroscope, an accelerometer or a magnetometer")
    t_s = streams[0].t_s
    if not all(np.array_equal(t_s, stream.t_s) for stream in streams[1:]):
        t_s = np.unique(np.concatenate([stream.t_s for stream in streams]))
    arrays: dict[str, Any] = {ARRAYS[s]: np.full((len(t_s), 3), np.nan) for s in ("gyro", "accel")}
    for stream in streams:
        merged = np.full((len(t_s), 3), np.nan)
        with np.errstate(over="ignore"):
            merged[np.searchsorted(t_s, stream.t_s)] = stream.values * si_per(stream.sensor, stream.unit.name)
        order, signs = turned(wishes.axes.get(stream.sensor, "x,y,z"))
        arrays[ARRAYS[stream.sensor]] = np.ascontiguousarray(merged[:, order] * signs)
    units = {stream.sensor: stream.unit for stream in streams} | {"time": raw.time_unit}
    aids = aids_of(raw, wishes)
    return Recording(name, t_s, **arrays, **raw.extra, aids=aids, origin=Origin(raw.format, units, tuple(notes)))


def refuse_unused_names(shown: str, raw: Raw, wishes: Wishes) -> None:
    """Raises RecordingError for columns that a file of this format cannot have."""
    for role, name in wishes.columns.items():
        if role not in raw.names:
            there = f"name {', '.join(raw.names)}" if raw.names else "leave it out"
            raise RecordingError(
                f"columns {role}={name}: {shown} is read as {raw.format}, which has no such column: {there}", "columns"
            )


def aids_of(raw: Raw, wishes: Wishes) -> dict[str, AidSamples]:
    """What aids navigation, in the order of arrival; kinds without samples are left out."""
    found = {kind: by_arrival(one) for kind, one in raw.aids.items() if len(one.t_s)}
    found |= {kind: replace(found[kind], t_s=found[kind].t_s - wishes.fixes_late_s) for kind in FIXES if kind in found}
    return {kind: one.without_repeats() for kind, one in found.items()} if wishes.drop_repeats else found


def alone(shown: object, wishes: Wishes) -> None:
    """Raises RecordingError for a file that is to hold inertial sensors."""
    if not wishes.only_aids:
        raise RecordingError(
            f"{shown}: holds satellites alone: give the recording of the inertial sensors, and this as --gnss {shown}"
        )


def _in_order(shown: str, stream: Stream, rate_hz: float | None) -> tuple[Stream, str]:
    """The stream with increasing times, and notes on corrections. Raises RecordingError where the user must decide."""
    if rate_hz is not None:
        return replace(stream, t_s=np.arange(len(stream.t_s)) / rate_hz), ""
    steps_s = np.diff(stream.t_s)
    if (steps_s > 0).all() and np.isfinite(stream.t_s).all():
        return stream, ""
    if not np.isfinite(stream.t_s).all() or steps_s.min() < -WITHIN_S:
        return _mended(shown, stream)
    order = np.argsort(stream.t_s, kind="stable")
    t_s, values = stream.t_s[order], stream.values[order]
    twice = np.diff(t_s) == 0
    if (twice & (values[1:] != values[:-1]).any(axis=1)).any():
        return _mended(shown, replace(stream, t_s=t_s, values=values))
    keep = np.concatenate([[True], ~twice])
    done = [f"{twice.sum()} samples that stood twice were left out"] if twice.any() else []
    done += ["samples were put in the order of their times"] if (np.diff(order) < 0).any() else []
    return replace(stream, t_s=t_s[keep], values=values[keep]), f"{stream.sensor}: {', '.join(done)}"


def _mended(shown: str, stream: Stream) -> tuple[Stream, str]:
    """Raises RecordingError where too many times are wrong."""
    if done := mended(stream.t_s):
        return replace(stream, t_s=done[0]), done[1]
    raise RecordingError(
        f"{shown}: the times of {stream.sensor} are missing, run back or stand still too often: give rate_hz for samples at equal intervals"
    )


def _without_repeats(stream: Stream) -> Stream:
    """The samples that differ from the one before."""
    present = np.flatnonzero(~np.isnan(stream.values).any(axis=1))
    values = stream.values[present]
    fresh = present[np.concatenate([[True], (values[1:] != values[:-1]).any(axis=1)])] if len(present) else present
    return replace(stream, t_s=stream.t_s[fresh], values=stream.values[fresh])


def turned(axes: str) -> tuple[list[int], np.ndarray]:
    """Places and signs of "y,x,-z": which axis of the file stands for x, y and z. Raises RecordingError."""
    parts = [part.strip() for part in axes.split(",")]
    letters = [part.lstrip("+-") for part in parts]
    if sorted(letters) != ["x", "y", "z"] or any(len(part) > 2 for part in parts):
        raise RecordingError(f"axes = {axes}: write three axes with their signs, such as y,x,-z", "axes")
    return ["xyz".index(letter) for letter in letters], np.array([-1.0 if part.startswith("-") else 1.0 for part in parts])


def cannot_be_read(path: Path, error: Exception) -> RecordingError:
    """The error for a file that a foreign parser refuses, in one line."""
    return RecordingError(f"{path}: cannot be read: {' '.join(str(error).split())[:200] or type(error).__name__}")


def library(name: str, extra: str, shown: str) -> ModuleType:
    """A package that only some formats need. Raises RecordingError that says how to install it."""
    try:
        return import_module(name)
    except ImportError:
        package = name.split(".")[0]
        raise RecordingError(
            f"{shown}: reading it needs the Python package {package}: python -m pip install {package} (all of them: the extra '{extra}')"
        ) from None
