"""Recordings as arguments of commands: read with the user's options, and checked."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from hnav.cli.completion import among
from hnav.cli.parameters import MagUnit, pairs
from hnav.cli.words import UsageError, finding_line
from hnav.io.aids import AidSamples
from hnav.io.findings import SEVERAL, Finding
from hnav.io.readers import FORMATS, read, read_aids
from hnav.io.readers.aid_columns import ROLES
from hnav.io.readers.pieces import LongTable, long_table
from hnav.io.readers.streams import Wishes
from hnav.io.recordings import Recording

Z_POINTS_UP = "the z axis of the sensor points up, which is a roll of 180 deg in ned"
OF_AIDS, OF_GNSS = (*ROLES, "gnss"), "gnss."
"""What --columns names in the file of --gnss, if there is one; and before a role that both may have: gnss.t_s."""
UPWARD = 0.7
"""Share of the mean force along z."""


def roles(option: str, texts: list[str] | None) -> dict[str, str]:
    """NAME=VALUE each, or several with commas between, to values by name. Raises UsageError."""
    return pairs(option, [part for several in texts or [] for part in SEVERAL.split(several)])


@dataclass(frozen=True)
class Reading:
    """How to read and check a recording: the options of each command that reads one."""

    format: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help=f"Format of the recording, if it is not recognised: {', '.join(FORMATS)}",
            autocompletion=among(*FORMATS),
        ),
    ] = None
    columns: Annotated[
        list[str] | None,
        typer.Option(
            metavar="ROLE=NAME",
            help="Which column is t_s, gx to mz, lat_deg, ...; -NAME negates; of a bag, imu=TOPIC, mag=TOPIC and gnss=TOPIC; with --gnss, lat_deg and other aids are columns of that file, and gnss.t_s its times",
        ),
    ] = None
    gyro_unit: Annotated[
        str | None, typer.Option(metavar="UNIT", help="Of the rates: rad/s, deg/s or mdeg/s, whatever the file says")
    ] = None
    accel_unit: Annotated[str | None, typer.Option(metavar="UNIT", help="Of the force: m/s2, g or mg")] = None
    mag_unit: MagUnit = None
    time_unit: Annotated[str | None, typer.Option(metavar="UNIT", help="Of the times: s, ms, us or ns")] = None
    rate_hz: Annotated[
        float | None, typer.Option("--rate", metavar="HZ", help="Samples are at equal intervals, whatever the times are")
    ] = None
    axes: Annotated[
        list[str] | None,
        typer.Option(metavar="SENSOR=AXES", help="Axes of the file that are x, y, z: mag=y,x,-z (gyro, accel, mag)"),
    ] = None
    drop_repeats: Annotated[bool, typer.Option("--drop-repeats", help="A sample that equals the one before is none")] = False
    fixes_late_s: Annotated[
        float,
        typer.Option(
            "--fixes-late", metavar="S", help="The times of positions and velocities are so much too late, as when they arrived"
        ),
    ] = 0.0
    hemisphere: Annotated[
        str | None, typer.Option(metavar="NAME", help="north (as assumed) or south of the magnetic equator, to check signs")
    ] = None

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
        given = roles("--columns", self.columns)
        of_aids = {role: name for role, name in given.items() if role in OF_AIDS or role.startswith(OF_GNSS)}
        own = {role: name for role, name in given.items() if role not in of_aids}
        return own, {role.removeprefix(OF_GNSS): name for role, name in of_aids.items()}

    def _arguments(self) -> dict[str, Any]:
        """The options as arguments of hnav.read."""
        arguments = {field.name: getattr(self, field.name) for field in fields(self) if field.name != "hemisphere"}
        return {**arguments, **{name: roles(f"--{name}", arguments[name]) for name in ("columns", "axes")}}

    def wishes(self) -> Wishes:
        """Decoder for arriving lines. Raises HnavError."""
        return Wishes(**{name: value for name, value in self._arguments().items() if name != "format"})

    def check(self, data: Recording) -> list[Finding]:
        """Implausible properties of the recording."""
        return data.check(self.hemisphere)


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
