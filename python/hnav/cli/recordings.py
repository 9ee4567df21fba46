"""Recordings as arguments of commands: read with the user's options, and checked."""

from __future__ import annotations

import functools
import inspect
import sys
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass, replace
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np

from hnav.cli.parameters import (
    AccelUnit,
    Axes,
    Columns,
    DropRepeats,
    FixesLate,
    Format,
    GyroUnit,
    Hemisphere,
    MagUnit,
    Rate,
    TimeUnit,
)
from hnav.cli.words import UsageError, finding_line
from hnav.io.aids import AidSamples
from hnav.io.findings import SEVERAL, Finding
from hnav.io.readers import read, read_aids
from hnav.io.readers.aid_columns import ROLES
from hnav.io.readers.pieces import LongTable, long_table
from hnav.io.readers.streams import Wishes
from hnav.io.recordings import Recording

Z_POINTS_UP = "the z axis of the sensor points up, which is a roll of 180 deg in ned"
OF_AIDS, OF_GNSS = (*ROLES, "gnss"), "gnss."
"""What --columns names in the file of --gnss, if there is one; and before a role that both may have: gnss.t_s."""
UPWARD = 0.7
"""Share of the mean force along z."""


def pairs(option: str, texts: list[str] | None) -> dict[str, str]:
    """NAME=VALUE each, or several with commas between, to values by name. Raises UsageError."""
    found = {}
    for text in (part for several in texts or [] for part in SEVERAL.split(several)):
        name, separator, value = text.partition("=")
        if not (separator and name.strip() and value.strip()):
            raise UsageError(f"{option} {text}: write NAME=VALUE")
        found[name.strip()] = value.strip()
    return found


@dataclass(frozen=True)
class Reading:
    """How to read and check a recording: the options of each command that reads one."""

    format: Format = None
    columns: Columns = None
    gyro_unit: GyroUnit = None
    accel_unit: AccelUnit = None
    mag_unit: MagUnit = None
    time_unit: TimeUnit = None
    rate_hz: Rate = None
    axes: Axes = None
    drop_repeats: DropRepeats = False
    fixes_late_s: FixesLate = 0.0
    hemisphere: Hemisphere = None

    def read(self, path: Path) -> Recording:
        """The recording. Raises HnavError."""
        return read(path, **self._arguments())

    def long_table(self, path: Path, corrected: Callable[[Recording], Recording] | None) -> LongTable | None:
        """The pieces of a long table of text, corrected; None for a file that must be read as a whole. Raises HnavError."""
        return long_table(path, self.hemisphere, corrected, **self._arguments())

    def read_aids(self, path: Path | None) -> dict[str, AidSamples]:
        """Satellites, pressure and wheels of a file of their own, if there is one. Raises HnavError, UsageError."""
        if path is None:
            return {}
        _, columns = self._columns_of_both()
        return read_aids(path, columns=columns, drop_repeats=self.drop_repeats, fixes_late_s=self.fixes_late_s)

    def beside(self, gnss: Path | None) -> Reading:
        """How to read the recording beside a file with aids, to which the columns of aids then belong. Raises UsageError."""
        if gnss is None:
            return self
        columns, _ = self._columns_of_both()
        return replace(self, columns=[f"{role}={name}" for role, name in columns.items()])

    def _columns_of_both(self) -> tuple[dict[str, str], dict[str, str]]:
        """The columns of a recording, and those of the file with aids beside it. Raises UsageError."""
        given = pairs("--columns", self.columns)
        of_aids = {role: name for role, name in given.items() if role in OF_AIDS or role.startswith(OF_GNSS)}
        own = {role: name for role, name in given.items() if role not in of_aids}
        return own, {role.removeprefix(OF_GNSS): name for role, name in of_aids.items()}

    def _arguments(self) -> dict[str, Any]:
        """The options as arguments of hnav.read."""
        arguments = {field.name: getattr(self, field.name) for field in fields(self) if field.name != "hemisphere"}
        return {**arguments, **{name: pairs(f"--{name}", arguments[name]) for name in ("columns", "axes")}}

    def wishes(self) -> Wishes:
        """Decoder for arriving lines. Raises HnavError."""
        return Wishes(**{name: value for name, value in self._arguments().items() if name != "format"})

    def check(self, data: Recording) -> list[Finding]:
        """Implausible properties of the recording."""
        return data.check(self.hemisphere)


def with_groups(command: Callable[..., None]) -> Callable[..., None]:
    """The command for typer: a parameter whose type is a dataclass becomes the options that are its fields, in its place."""
    hints = get_type_hints(command, include_extras=True)
    groups = {name: get_type_hints(hint, include_extras=True) for name, hint in hints.items() if is_dataclass(hint)}
    shown: list[inspect.Parameter] = []
    for name, parameter in inspect.signature(command).parameters.items():
        if name not in groups:
            shown.append(parameter.replace(annotation=hints[name]))
        for option, hint in groups.get(name, {}).items():
            shown.append(parameter.replace(name=option, default=getattr(hints[name], option), annotation=hint))

    @functools.wraps(command)
    def called(**given: Any) -> None:
        made = {name: hints[name](**{option: given.pop(option) for option in group}) for name, group in groups.items()}
        command(**made, **given)

    called.__annotations__ = {parameter.name: parameter.annotation for parameter in shown}
    called.__signature__ = inspect.Signature(shown)  # type: ignore[attr-defined]
    return called


def z_points_up(data: Recording) -> bool:
    """Whether the mean force of the recording points along z, against which gravity pulls."""
    _, force = data.samples("accel")
    mean = force.mean(axis=0) if len(force) else np.zeros(3)
    return bool(mean[2] > UPWARD * float(np.linalg.norm(mean)) > 0)


def read_as(data: Recording) -> str:
    """Format and units, and how they were found."""
    if data.origin is None:
        return ""
    return f"{data.origin.format}: {', '.join(f'{quantity} {unit}' for quantity, unit in data.origin.units.items())}"


def lines_of(findings: list[Finding]) -> list[str]:
    """A line for each finding: its level, the fault, and the option that corrects it."""
    return [f"{finding.level}: {finding_line(finding)}" for finding in findings]


def warnings_of(path: Path, findings: list[Finding], strict: bool, force: bool = True) -> list[str]:
    """A line for each warning. Raises UsageError, naming all at once: with strict for any, without force for those that make
    an estimate meaningless or need a decision of the user. A command without an estimate needs no force.
    """
    alarms = [finding for finding in findings if finding.level != "note"]
    stopping = alarms if strict else [finding for finding in alarms if finding.stops and not force]
    if stopping:
        left = len(alarms) - len(stopping)
        more = f" (and {left} more: hnav check {path})" if left else ""
        raise UsageError(
            f"{path}: {'; '.join(map(finding_line, stopping))}{more}{'' if strict else '; --force goes on in spite of it'}"
        )
    return [f"warning: {path.name}: {finding_line(finding)}" for finding in alarms]


def warn(lines: list[str]) -> None:
    """Notes go to stderr, because they are not part of a command's output."""
    for line in lines:
        print(line, file=sys.stderr)
