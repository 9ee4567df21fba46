"""Arguments and options shared by several commands, and the conversion of their text to values."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from hnav.cli.completion import among, grade_names, option_names, scenario_names, system_names
from hnav.cli.words import UsageError
from hnav.filters.options import BODIES, FILTERS
from hnav.fmi.engines import ENGINES
from hnav.io.readers import FORMATS
from hnav.io.sensors import GRADES


def _filter(said: str, *names: str) -> Any:
    return typer.Option("--filter", metavar="NAME", help=said, autocompletion=among(*names))


def page_option(said: str) -> Any:
    """An option of a page to write; a name that no browser opens as a page is refused."""
    return typer.Option(metavar="FILE.html", help=said, callback=_page)


def _page(file: Path | None) -> Path | None:
    if file is not None and file.suffix.lower() not in (".html", ".htm"):
        raise UsageError(f"{file}: a page is HTML: name it .html")
    return file


FilterName = Annotated[str, _filter("ahrs (real sensors) or hrekf (the paper's)", *FILTERS)]
FilterOrIns = Annotated[
    str, _filter("ahrs (real sensors), hrekf (the paper's) or ins (position, velocity and attitude)", *FILTERS, "ins")
]
PlaceAndDate = Annotated[
    str | None,
    typer.Option(metavar="LAT,LON,HEIGHT,YEAR", help="deg, deg, m, decimal year: the magnetic field of the place, true headings"),
]
SensorGrade = Annotated[
    str | None, typer.Option(metavar="NAME", help=f"Grade of the sensors: {', '.join(GRADES)}; of the INS its preset")
]
Sensor = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="Sensor file: figures by the datasheet, of the INS beside those of its preset, and calibrations, which correct the recording",
    ),
]
Body = Annotated[
    str | None,
    typer.Option(
        metavar="NAME",
        help=f"Kind of body: {', '.join(BODIES)}; default: any, nothing is assumed",
        autocompletion=among(*BODIES),
    ),
]
Gnss = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="Of --filter ins: satellites, pressure or wheels in a file of their own: a table, NMEA, a log of PX4 or ROS",
    ),
]
TruthFile = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="Of --filter ins: print its errors, by a CSV of t_s, lat_deg, lon_deg, alt_m, vn, ve, vd, roll, pitch, heading or q0 to q3",
    ),
]
Outages = Annotated[
    str | None, typer.Option(metavar="SECONDS,...", help="With --truth: artificial outages of the satellites, such as 10,30,60")
]
Workers = Annotated[int, typer.Option(help="Processes on this machine")]
Scheduler = Annotated[str | None, typer.Option(metavar="ADDRESS", help="A Dask scheduler instead")]
Engine = Annotated[str, typer.Option(help=", ".join(ENGINES), autocompletion=among(*ENGINES))]
Settings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="An option of the filter; see hnav options", autocompletion=option_names),
]
Format = Annotated[
    str | None,
    typer.Option(
        metavar="NAME",
        help=f"Format of the recording, if it is not recognised: {', '.join(FORMATS)}",
        autocompletion=among(*FORMATS),
    ),
]
Columns = Annotated[
    list[str] | None,
    typer.Option(
        metavar="ROLE=NAME",
        help="Which column is t_s, gx to mz, lat_deg, ...; -NAME negates; of a bag, imu=TOPIC, mag=TOPIC and gnss=TOPIC; with --gnss, lat_deg and other aids are columns of that file, and gnss.t_s its times",
    ),
]
GyroUnit = Annotated[
    str | None, typer.Option(metavar="UNIT", help="Of the rates: rad/s, deg/s or mdeg/s, whatever the file says")
]
AccelUnit = Annotated[str | None, typer.Option(metavar="UNIT", help="Of the force: m/s2, g or mg")]
MagUnit = Annotated[str | None, typer.Option(metavar="UNIT", help="Of the field: T, uT, nT, G, mG or au (arbitrary)")]
TimeUnit = Annotated[str | None, typer.Option(metavar="UNIT", help="Of the times: s, ms, us or ns")]
Rate = Annotated[
    float | None, typer.Option("--rate", metavar="HZ", help="Samples are at equal intervals, whatever the times are")
]
Axes = Annotated[
    list[str] | None, typer.Option(metavar="SENSOR=AXES", help="Axes of the file that are x, y, z: mag=y,x,-z (gyro, accel, mag)")
]
DropRepeats = Annotated[bool, typer.Option("--drop-repeats", help="A sample that equals the one before is none")]
FixesLate = Annotated[
    float,
    typer.Option(
        "--fixes-late", metavar="S", help="The times of positions and velocities are so much too late, as when they arrived"
    ),
]
Hemisphere = Annotated[
    str | None, typer.Option(metavar="NAME", help="north (as assumed) or south of the magnetic equator, to check signs")
]
Strict = Annotated[bool, typer.Option("--strict", help="Refuse a recording that is not plausible in any way")]
Force = Annotated[
    bool, typer.Option("--force", help="Go on where unit, axes, sign or a dead sensor make the estimate meaningless")
]
Frame = Annotated[
    str | None, typer.Option(help="Navigation frame, ned or enu; default: enu for telephones, whose z axis points up, else ned")
]
Preset = Annotated[
    str,
    typer.Option(
        help="default or paper; of ins consumer, industrial, tactical or navigation",
        autocompletion=among("default", "paper", "consumer", "industrial", "tactical", "navigation"),
    ),
]
Smooth = Annotated[
    bool,
    typer.Option("--smooth", help="With hindsight: every row from all samples, before and after it (ahrs and ins, engine c)"),
]
Folder = Annotated[Path, typer.Argument(metavar="DIR", help="Folder with BROAD trials")]

SystemName = Annotated[
    str,
    typer.Argument(
        help="Name (hnav systems lists them), an .ssp file, or a folder with SystemStructure.ssd", autocompletion=system_names
    ),
]
Grade = Annotated[
    str | None, typer.Option(help="A sensor grade of the system; hnav systems NAME lists them", autocompletion=grade_names)
]
SystemSensor = Annotated[
    Path | None,
    typer.Option(
        "--sensor",
        metavar="FILE",
        help="A sensor file as the grade: its figures in the sensors, and in the filters that assume them",
    ),
]
Scenario = Annotated[
    str | None, typer.Option(help="A scenario of the system; hnav systems NAME lists them", autocompletion=scenario_names)
]
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


def grade_or_sensor(grade: str | None, sensor: Path | None) -> str | None:
    """The grade of a system. Raises UsageError when both are given, and for a sensor file without its suffix."""
    if sensor is None:
        return grade
    if grade is not None:
        raise UsageError("--grade and --sensor: give one of them")
    if sensor.suffix != ".json":
        raise UsageError(f"--sensor {sensor}: a sensor file ends in .json")
    return str(sensor)


def parse_system_settings(pairs: list[str] | None) -> dict[str, str]:
    """COMPONENT.PARAMETER=VALUE each, to values by name."""
    found = parse_settings(pairs)
    for name in found:
        if "." not in name:
            raise UsageError(f"--set {name}={found[name]}: component.parameter=value is wanted")
    return found
