"""Tables as spreadsheets, programs of other countries and loggers with faults write them: cells, times and lines that are not plain."""

from __future__ import annotations

import datetime
import zipfile
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path

import numpy as np

from hnav.io.recordings import Recording
from recorded import G, columns

DEG = 180 / np.pi
NOON = datetime.datetime(2026, 1, 31, 11, 59, 55)
SENSORS = [f"{sensor}_{axis} ({unit})" for sensor, unit in (("gyro", "dps"), ("acc", "g"), ("mag", "uT")) for axis in "xyz"]
Cells = list[list[str]]


def cells_of(r: Recording, cell: Callable[[float], str] = "{:.6f}".format) -> Cells:
    """Rows of nine cells."""
    return [[cell(v) if np.isfinite(v) else "" for v in row] for row in np.stack(columns(r, DEG, 1 / G), axis=1)]


def save(
    folder: Path, names: Iterable[str], rows: Iterable[Iterable[str]], mark: str = ",", end: str = "\n", coding: str = "utf-8"
) -> Path:
    path = folder / "export.csv"
    path.write_bytes((end.join([mark.join(names), *map(mark.join, rows)]) + end).encode(coding))
    return path


def timed(folder: Path, r: Recording, name: str, time: Callable[[datetime.datetime], str], mark: str = ",") -> Path:
    """With times as a program prints instants."""
    times = [time(NOON + datetime.timedelta(seconds=float(t))).split(mark) for t in r.t_s]
    return save(folder, [*name.split(mark), *SENSORS], ([*t, *row] for t, row in zip(times, cells_of(r))), mark)


def spelled(folder: Path, r: Recording, cell: Callable[[float], str], mark: str = ",", quote: str = "", **form: str) -> Path:
    """With numbers as cell writes them."""
    rows = ([f"{quote}{one}{quote}" for one in (cell(t), *row)] for t, row in zip(1e3 * r.t_s, cells_of(r, cell)))
    return save(folder, ["t_ms", *SENSORS], rows, mark, **form)


def german(v: float) -> str:
    """1.234,500000"""
    return f"{v:,.6f}".translate(str.maketrans(",.", ".,"))


def with_lines(folder: Path, r: Recording, lines: dict[int, str], end: str = "") -> Path:
    """Lines between the rows, and the text behind the last row."""
    path = spelled(folder, r, "{:.6f}".format)
    text = path.read_text().splitlines()
    for number, line in lines.items():
        text.insert(number, line or text[0])
    path.write_bytes(("\n".join(text) + "\n" + end).encode())
    return path


def with_words(folder: Path, r: Recording) -> Path:
    """Samples that are missing, in words."""
    rows = cells_of(r)
    for number, word in enumerate(("NaN", "null", "NA", "n/a", "-", "#N/A", "None", "--"), 100):
        rows[number] = [word] * 9
    return save(folder, ["t_s", *SENSORS], ([f"{t:.3f}", *row] for t, row in zip(r.t_s, rows)))


def wrapped(folder: Path, r: Recording) -> Path:
    """millis() of 32 bits, which starts over."""
    ticks = (2**32 - 8000 + np.round(1e3 * r.t_s).astype(np.int64)) % 2**32
    return save(folder, ["millis", *SENSORS], ([str(t), *row] for t, row in zip(ticks, cells_of(r))), end="\r\n")


def preamble(folder: Path, r: Recording) -> Path:
    path = spelled(folder, r, "{:.6f}".format)
    path.write_text("".join(f"# setting {i} = {i * i}\n" for i in range(150)) + path.read_text())
    return path


def unnamed(folder: Path, r: Recording) -> Path:
    """As write.table of R names its rows: a cell more than the header has."""
    return save(folder, ["t_s", *SENSORS], ([str(k), f"{t:.3f}", *row] for k, (t, row) in enumerate(zip(r.t_s, cells_of(r)), 1)))


def milliseconds(instant: datetime.datetime, form: str) -> str:
    return instant.strftime(form) + f"{instant.microsecond // 1000:03d}"


def headed(folder: Path, r: Recording, header: str, rate: float = DEG, force: float = 1 / G, field: float = 1e6) -> Path:
    """Of a header in which three columns stand for {axis} and {number}; columns without either hold ones."""
    values, names, arrays = iter(columns(r, rate, force, field)), [], []
    for name in header.split("|"):
        for axis, number in zip("XYZ", "123") if "{" in name else [("", "")]:
            names.append(name.format(axis=axis, number=number))
            beside = "{" not in name or name.startswith("*")
            arrays.append(r.t_s if not arrays else np.ones_like(r.t_s) if beside else next(values))
    return save(folder, [name.lstrip("*") for name in names], ([f"{v:.7g}" for v in row] for row in zip(*arrays)), ";")


def own_times(folder: Path, r: Recording, names: tuple[str, str, str], step: int = 5) -> Path:
    """A column of times before each sensor, which has rows of its own from the top of the table on."""
    parts = []
    for sensor, name in enumerate(names):
        every = step if sensor == 2 else 1
        times, rows = r.t_s[::every] + 0.001 * sensor, cells_of(r)[::every]
        part = [[f"{t:.3f}", *row[3 * sensor : 3 * sensor + 3]] for t, row in zip(times, rows)]
        parts.append([[name, *SENSORS[3 * sensor : 3 * sensor + 3]], *part, *([""] * 4 for _ in range(len(r.t_s) - len(part)))])
    head, *body = ([cell for cells in row for cell in cells] for row in zip(*parts))
    return save(folder, head, body)


def folder_of(
    folder: Path, r: Recording, sensors: dict[str, tuple[int, ...]], names: list[str] = SENSORS, packed: str = ""
) -> Path:
    """A table for each name, of these sensors, the field at a fifth of the rate; as a zip with a folder in it where packed names one."""
    inner = folder / "walk"
    inner.mkdir()
    for name, which in sensors.items():
        every = 5 if which == (2,) else 1
        rows = (
            [f"{t:.3f}", *(row[3 * s + i] for s in which for i in range(3))]
            for t, row in zip(r.t_s[::every], cells_of(r)[::every])
        )
        save(inner, ["t_s", *(names[3 * s + i] for s in which for i in range(3))], rows).rename(inner / f"{name}.csv")
    if not packed:
        return inner
    with zipfile.ZipFile(folder / "walk.zip", "w") as archive:
        for file in inner.iterdir():
            archive.write(file, f"{packed}/{file.name}")
    return folder / "walk.zip"


def workbook(folder: Path, r: Recording) -> Path:
    with zipfile.ZipFile(folder / "walk.xlsx", "w") as archive:
        archive.writestr("xl/worksheets/sheet1.xml", "<worksheet/>")
    return folder / "walk.xlsx"


AXES_ALONE = [f"{axis} ({unit})" for unit in ("dps", "g", "uT") for axis in "XYZ"]
"""As in a file whose name is that of the sensor."""
SHAPES: dict[str, Callable[[Path, Recording], Path]] = {
    "german instants": partial(timed, name="Zeitstempel", time=partial(milliseconds, form="%d.%m.%Y %H:%M:%S,"), mark=";"),
    "american instants": partial(timed, name="Timestamp", time=lambda t: t.strftime("%m/%d/%Y %I:%M:%S.%f %p")),
    "instants of MATLAB": partial(timed, name="Timestamp", time=partial(milliseconds, form="%d-%b-%Y %H:%M:%S.")),
    "date and time": partial(timed, name="Date,Time", time=lambda t: t.strftime("%Y-%m-%d,%H:%M:%S.%f")),
    "rtcDate and rtcTime": partial(timed, name="rtcDate,rtcTime", time=lambda t: t.strftime("%m/%d/%Y,%H:%M:%S.%f")),
    "clock with colons": partial(timed, name="Time", time=partial(milliseconds, form="%H:%M:%S:")),
    "minutes and seconds": partial(timed, name="Time", time=partial(milliseconds, form="%M:%S.")),
    "zone": partial(timed, name="time", time=lambda t: t.isoformat() + "+01:00"),
    "clock that starts over": wrapped,
    "quoted decimal commas": partial(spelled, cell=lambda v: f"{v:.6f}".replace(".", ","), quote='"'),
    "marks of thousands": partial(spelled, cell=german, mark=";", end="\r\n", coding="cp1252"),
    "minus of a word processor": partial(spelled, cell=lambda v: f"{v:.6f}".replace("-", "\u2212")),
    "apostrophes": partial(spelled, cell="'{:.6f}".format),
    "bars": partial(spelled, cell=" {:.6f} ".format, mark="|"),
    "UTF-16, tabs": partial(spelled, cell=lambda v: f"{v:.6f}".replace(".", ","), mark="\t", end="\r\n", coding="utf-16"),
    "ends of lines of 1990": partial(spelled, cell="{:.6f}".format, end="\r"),
    "missing in words": with_words,
    "remark at the end": partial(with_lines, lines={}, end="# end of log, 2000 samples\n"),
    "remarks between": partial(with_lines, lines={500: "I2C error, retrying", 900: "I2C error, retrying"}),
    "header again": partial(with_lines, lines={700: ""}),
    "cut off, and zeros": partial(with_lines, lines={}, end="15000.0,1.5,0.2,-" + 4096 * "\0"),
    "long preamble": preamble,
    "german, units behind in": partial(headed, header="Zeit in s|Drehrate_{axis} in °/s|Beschl_{axis} in g|Mag_{axis} in µT"),
    "Gauß": partial(headed, header="Zeit [s]|Gyro {axis} [Grad/s]|Acc {axis} [g]|Mag {axis} [Gauß]", field=1e4),
    "units in words": partial(
        headed, header="time in seconds|gyro {axis} in degrees per second|acceleration {axis} in milli-g|mag {axis} in nanotesla", force=1e3 / G, field=1e9,
    ),
    "italian": partial(headed, header="Tempo (s)|Velocità angolare {axis} (°/s)|Accelerazione {axis} (g)|Campo magnetico {axis} (µT)"),
    "LPMS": partial(
        headed,
        header="TimeStamp (s)|*LinAcc{axis} (g)|*Euler{axis} (deg)|Gyro{axis} (deg/s)|Acc{axis} (g)|Mag{axis} (uT)|QuatW|*Quat{axis}|Pressure (kPa)",
    ),
    "WitMotion": partial(headed, header="Time(s)|As{axis}(°/s)|Acc{axis}(g)|H{axis}(uT)|*Angle{axis}(°)"),
    "times of one name": partial(own_times, names=("Time (s)", "Time (s)", "Time (s)")),
    "times called after sensors": partial(own_times, names=("gyro_time", "acc_time", "mag_time")),
    "field in a file of its own": partial(folder_of, sensors={"imu": (0, 1), "mag": (2,)}),
    "a file for each sensor": partial(folder_of, sensors={"walk_gyr": (0,), "walk_acc": (1,), "walk_mag": (2,)}, names=AXES_ALONE),
    "zip of files": partial(folder_of, sensors={"Gyroskop": (0,), "Beschleunigung": (1,), "Magnetfeld": (2,)}, names=AXES_ALONE, packed="walk"),
    "zip of a table": partial(folder_of, sensors={"walk": (0, 1, 2)}, packed="logs"),
    "numbered from 1": partial(headed, header="t|gyro_{number}|acc_{number}|mag_{number}", rate=1, force=1),
}  # fmt: skip
"""The writer of a file of each shape."""
FAULTY: dict[str, tuple[str, Callable[[Path, Recording], Path]]] = {
    "decimal commas between commas": ("refused", partial(spelled, cell=lambda v: f"{v:.6f}".replace(".", ","))),
    "a cell more than the header": ("refused", unnamed),
    "workbook": ("refused", workbook),
    "field and force alone": ("refused", partial(folder_of, sensors={"acc": (1,), "mag": (2,)})),
    "angles alone": ("refused", partial(headed, header="Time (s)|Orientation {axis} (deg)|Acc {axis} (g)|Mag {axis} (uT)")),
    "seconds of four digits": ("refused", partial(timed, name="Time", time=lambda t: "1,77E+12", mark=";")),
}  # fmt: skip
"""By shape: the verdict, and the writer of the file."""
