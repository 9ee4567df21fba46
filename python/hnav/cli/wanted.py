"""The options of the command line for each recording that is filtered."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from math import radians
from pathlib import Path

from hnav.cli.recordings import Reading
from hnav.cli.words import UsageError
from hnav.filters.options import option_table, options_of_place, options_of_sensor
from hnav.io.plausibility import hemisphere_at
from hnav.io.recordings import Recording
from hnav.io.sensors import GRADES, read_grade

INS = "ins"
BODY = "body"
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
        """The correction of a recording by the calibrations of the sensor file. Raises HnavError."""
        return corrected_by(self.sensor)

    def made_of(self, recording: Path) -> list[str]:
        """The sources in the head of a table."""
        return [f"recording {recording}", *([f"sensors by {self.sensor}"] if self.sensor else [])]


def corrected_by(sensor: Path | None) -> Corrected | None:
    """None if the sensor file has no calibration. Raises HnavError."""
    grade = None if sensor is None else read_grade(sensor)
    return grade.apply_to if grade is not None and grade.corrections else None


def preset_and_settings(
    filter: str, preset: str, grade: str | None, sensor: Path | None, place_and_date: str | None, body: str | None
) -> tuple[str, dict[str, str]]:
    """The preset, which for the INS is the grade, and the settings of sensors, place and body. Raises UsageError, HnavError."""
    of_place = settings_of_place(filter, place_and_date) | _of_body(filter, body)
    if filter == INS:
        return grade or preset, _of_sensor(filter, sensor) | of_place
    if grade is not None and sensor is not None:
        raise UsageError("--grade and --sensor: give one of them")
    if grade is not None and grade not in GRADES:
        raise UsageError(f"--grade {grade}: choose one of {', '.join(GRADES)}, or give --sensor FILE")
    return preset, _of_sensor(filter, sensor or grade) | of_place


def _of_body(filter: str, body: str | None) -> dict[str, str]:
    if body is None:
        return {}
    if BODY not in option_table(filter):
        raise UsageError(f"--body {body}: {filter} has no such option: use --filter ahrs or --filter ins")
    option_table(filter)[BODY].parse(body)  # refuses what is no body
    return {BODY: body}


def _of_sensor(filter: str, sensor: Path | str | None) -> dict[str, str]:
    return {name: str(value) for name, value in options_of_sensor(filter, sensor).items()}


def settings_of_place(filter: str, place_and_date: str | None) -> dict[str, str]:
    """Raises UsageError for text that is no place and date, HnavError for a place or a date outside the model."""
    if place_and_date is None:
        return {}
    return {name: str(value) for name, value in options_of_place(filter, place_of(place_and_date)).items()}


def reading_at(place_and_date: str | None, reading: Reading) -> Reading:
    """With the hemisphere of the place, unless it is given. Raises UsageError."""
    if place_and_date is None or reading.hemisphere is not None:
        return reading
    return replace(reading, hemisphere=hemisphere_at(place_of(place_and_date)[0]))


def place_of(place_and_date: str) -> tuple[float, float, float, float]:
    """Latitude and longitude in rad, height in m, and year. Raises UsageError."""
    try:
        latitude_deg, longitude_deg, height_m, year = map(float, place_and_date.split(","))
    except ValueError:
        raise UsageError(f"--place-and-date {place_and_date}: write LAT,LON,HEIGHT,YEAR, as 48.1,11.6,500,2026.5") from None
    return radians(latitude_deg), radians(longitude_deg), height_m, year
