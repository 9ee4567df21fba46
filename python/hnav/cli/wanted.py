"""The options of the command line for each recording that is filtered."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from math import radians
from pathlib import Path
from typing import Annotated, Any

import typer

from hnav.cli.completion import among
from hnav.cli.parameters import FilterOrIns, Preset, Settings, parse_settings
from hnav.cli.recordings import Reading
from hnav.cli.words import UsageError
from hnav.filters.options import BODIES, option_table, options_of_place, options_of_sensor
from hnav.io.plausibility import hemisphere_at
from hnav.io.recordings import Recording
from hnav.io.sensors import GRADES, read_grade

INS = "ins"
BODY = "body"
SMOOTHED = "smoothed: every row from all samples, before and after it"
Corrected = Callable[[Recording], Recording]


@dataclass(frozen=True)
class Wanted:
    """Options by name; settings are those of the filter, including values from grade, sensor, place and body."""

    reading: Reading
    filter: str = "ahrs"
    engine: str = "c"
    settings: Mapping[str, str] = field(default_factory=dict)
    preset: str = "default"
    step: float | None = None
    frame: str | None = None
    strict: bool = False
    force: bool = False
    smooth: bool = False
    sensor: Path | None = None
    gnss: Path | None = None
    truth: Path | None = None
    outages: str | None = None

    def corrected(self) -> Corrected | None:
        """The correction of a recording by the calibrations of the sensor file; None if it has none. Raises HnavError."""
        grade = None if self.sensor is None else read_grade(self.sensor)
        return grade.apply_to if grade is not None and grade.corrections else None

    def made_of(self, recording: Path) -> list[str]:
        """The sources in the head of a table."""
        how = f"satellites {self.gnss}" if self.filter == INS else f"engine {self.engine}"
        return [
            f"recording {recording}", *([how] if self.gnss or self.filter != INS else []), *([SMOOTHED] if self.smooth else []),
            *([f"sensors by {self.sensor}"] if self.sensor else []),
        ]  # fmt: skip


@dataclass(frozen=True)
class Choice:
    """Which filter, with what settings: the options of each command that filters a recording or arriving samples."""

    filter: FilterOrIns = "ahrs"
    settings: Settings = None
    preset: Preset = "default"
    frame: Annotated[
        str | None,
        typer.Option(help="Navigation frame, ned or enu; default: enu for telephones, whose z axis points up, else ned"),
    ] = None
    place_and_date: Annotated[
        str | None,
        typer.Option(
            metavar="LAT,LON,HEIGHT,YEAR", help="deg, deg, m, decimal year: the magnetic field of the place, true headings"
        ),
    ] = None
    grade: Annotated[
        str | None, typer.Option(metavar="NAME", help=f"Grade of the sensors: {', '.join(GRADES)}; of the INS its preset")
    ] = None
    sensor: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Sensor file: figures by the datasheet, of the INS beside those of its preset, and calibrations, which correct the recording",
        ),
    ] = None
    body: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help=f"Kind of body: {', '.join(BODIES)}; default: any, nothing is assumed",
            autocompletion=among(*BODIES),
        ),
    ] = None

    def wanted(self, reading: Reading, **more: Any) -> Wanted:
        """With further options by name. The hemisphere is that of the place, unless it is given. Raises UsageError, HnavError."""
        place = None if self.place_and_date is None else place_of(self.place_and_date)
        if place is not None and reading.hemisphere is None:
            reading = replace(reading, hemisphere=hemisphere_at(place[0]))
        of_ins = self.filter == INS  # its preset is the grade
        found = options_of_sensor(self.filter, self.sensor if of_ins else self._sensor_or_grade())
        found |= options_of_place(self.filter, place)
        settings = {name: str(value) for name, value in found.items()} | self._of_body() | parse_settings(self.settings)
        preset = (self.grade if of_ins else None) or self.preset
        return Wanted(reading, self.filter, settings=settings, preset=preset, frame=self.frame, sensor=self.sensor, **more)

    def _sensor_or_grade(self) -> Path | str | None:
        if self.grade is not None and self.sensor is not None:
            raise UsageError("--grade and --sensor: give one of them")
        if self.grade is not None and self.grade not in GRADES:
            raise UsageError(f"--grade {self.grade}: choose one of {', '.join(GRADES)}, or give --sensor FILE")
        return self.sensor or self.grade

    def _of_body(self) -> dict[str, str]:
        if self.body is None:
            return {}
        if BODY not in option_table(self.filter):
            raise UsageError(f"--body {self.body}: {self.filter} has no such option: use --filter ahrs or --filter ins")
        option_table(self.filter)[BODY].numbers(self.body)  # refuses what is no body
        return {BODY: self.body}


def place_of(place_and_date: str) -> tuple[float, float, float, float]:
    """Latitude and longitude in rad, height in m, and year. Raises UsageError."""
    try:
        latitude_deg, longitude_deg, height_m, year = map(float, place_and_date.split(","))
    except ValueError:
        raise UsageError(f"--place-and-date {place_and_date}: write LAT,LON,HEIGHT,YEAR, as 48.1,11.6,500,2026.5") from None
    return radians(latitude_deg), radians(longitude_deg), height_m, year
