"""Arguments and options that several commands share, and how their text becomes values."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hnav.cli.words import UsageError
from hnav.fmi.engines import ENGINES
from hnav.renamed import now_called


def known_filter(name: str) -> str:
    """The name, or a UsageError with the new one."""
    if new := now_called(name, "filter"):
        raise UsageError(f"--filter {name}{new}")
    return name


FilterName = Annotated[
    str, typer.Option("--filter", metavar="NAME", callback=known_filter, help="ahrs (real sensors) or hrekf (the paper's)")
]
Engine = Annotated[str, typer.Option(help=", ".join(ENGINES))]
Settings = Annotated[
    list[str] | None, typer.Option("--set", metavar="NAME=VALUE", help="An option of the filter; see hnav options")
]
MagUnit = Annotated[str, typer.Option(help="Unit of the field in a CSV: T, uT, G or au (arbitrary)")]
Preset = Annotated[str, typer.Option(help="default or paper")]
Smooth = Annotated[
    bool, typer.Option("--smooth", help="With hindsight: every row from all samples, before and after it (ahrs, engine c)")
]
Folder = Annotated[Path, typer.Argument(metavar="DIR", help="Folder with BROAD trials")]

SystemName = Annotated[str, typer.Argument(help="Name of a built system, an .ssp file, or a folder with SystemStructure.ssd")]
Grade = Annotated[str | None, typer.Option(help="A sensor grade of the system")]
SystemSettings = Annotated[
    list[str] | None, typer.Option("--set", metavar="COMPONENT.PARAMETER=VALUE", help="A parameter, after grade and scenario")
]
SystemStep = Annotated[float | None, typer.Option("--step", metavar="SECONDS", help="Communication step; default: the system's")]
AllowOutside = Annotated[
    bool, typer.Option("--allow-outside", help="Also run FMUs that an .ssp names and does not hold (absolute paths, ../)")
]
SystemStop = Annotated[float | None, typer.Option("--stop", metavar="SECONDS", help="End of a run; default: the system's")]


def parse_settings(pairs: list[str] | None) -> dict[str, str]:
    """NAME=VALUE each, to values by name."""
    found = {}
    for pair in pairs or []:
        name, separator, value = pair.partition("=")
        if not (separator and name and value):
            raise UsageError(f"--set {pair}: write NAME=VALUE")
        found[name] = value
    return found


def parse_system_settings(pairs: list[str] | None) -> dict[str, str]:
    """COMPONENT.PARAMETER=VALUE each, to values by name."""
    found = parse_settings(pairs)
    for name in found:
        if "." not in name:
            raise UsageError(f"--set {name}={found[name]}: component.parameter=value is wanted")
    return found
