"""Options of the commands that simulate a system."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from hnav.cli.completion import grade_names, system_names
from hnav.cli.parameters import AllowOutside, parse_settings
from hnav.cli.words import UsageError

SystemName = Annotated[
    str,
    typer.Argument(
        help="Name (hnav systems lists them), an .ssp file, or a folder with SystemStructure.ssd", autocompletion=system_names
    ),
]


@dataclass(frozen=True)
class Setup:
    """How a system is simulated, whatever scenario and seed."""

    grade: Annotated[
        str | None, typer.Option(help="A sensor grade of the system; hnav systems NAME lists them", autocompletion=grade_names)
    ] = None
    sensor: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="A sensor file as the grade: its figures in the sensors, and in the filters that assume them",
        ),
    ] = None
    settings: Annotated[
        list[str] | None, typer.Option("--set", metavar="COMPONENT.PARAMETER=VALUE", help="A parameter, after grade and scenario")
    ] = None
    step: Annotated[float | None, typer.Option(metavar="SECONDS", help="Communication step; default: the system's")] = None
    stop: Annotated[float | None, typer.Option(metavar="SECONDS", help="End of a run; default: the system's")] = None
    allow_outside: AllowOutside = False

    def arguments(self) -> dict[str, Any]:
        """The options as arguments of hnav.systems.simulation.simulate. Raises UsageError."""
        settings = parse_settings(self.settings)
        for name, value in settings.items():
            if "." not in name:
                raise UsageError(f"--set {name}={value}: component.parameter=value is wanted")
        times = {"step_s": self.step, "stop_s": self.stop}
        return {"grade": self._grade_or_sensor(), "settings": settings, **times, "allow_outside": self.allow_outside}

    def _grade_or_sensor(self) -> str | None:
        """The grade, or the file of one. Raises UsageError when both are given, and for a sensor file without its suffix."""
        if self.sensor is None:
            return self.grade
        if self.grade is not None:
            raise UsageError("--grade and --sensor: give one of them")
        if self.sensor.suffix != ".json":
            raise UsageError(f"--sensor {self.sensor}: a sensor file ends in .json")
        return str(self.sensor)
