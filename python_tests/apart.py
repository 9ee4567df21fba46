"""Recordings whose samples or units stand apart: a row for each sample of one sensor, files of one axis, units beside the numbers."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import scipy.io

from devices import AXES, DEG, vectors
from hnav.io.recordings import Recording
from recorded import G, write_rows

SI = (1.0, 1.0, 1.0)
USUAL = (DEG, 1 / G, 1e6)
UNITS = ("deg/s", "g", "uT")
NAMES = ("gyroscope", "accelerometer", "magnetometer")


def samples(r: Recording, factors: tuple[float, float, float], late: float = 0.0) -> Iterator[tuple[float, int, list[float]]]:
    """Time, sensor and three numbers of each sample, in the order of the rows; each sensor later than the one before."""
    arrays = vectors(r, *factors)
    for k, t in enumerate(r.t_s.tolist()):
        for sensor, values in enumerate(arrays):
            if np.isfinite(values[k]).all():
                yield t + late * sensor, sensor, values[k].tolist()


def long(
    folder: Path,
    r: Recording,
    header: str = "time,sensor,x,y,z",
    names: tuple[str, ...] = NAMES,
    factors: tuple[float, float, float] = SI,
    units: tuple[str, ...] = (),
    mark: str = ",",
    beside: str = "",
) -> Path:
    """A row for each sample, with its unit behind it where there are units, and rows of something else."""
    rows = []
    for t, sensor, vector in samples(r, factors, late=0.002):
        cells = [f"{t:.4f}", names[sensor], *(f"{v:.9g}" for v in vector), *(units[sensor : sensor + 1])]
        rows += [mark.join(cells), *([beside] if beside and sensor == 0 else [])]
    path = folder / "long.csv"
    path.write_text("\n".join([header] * bool(header) + rows) + "\n")
    return path


def of_axes(folder: Path, r: Recording) -> Path:
    """A row for each axis, as melt of pandas makes it."""
    rows = [
        f"{t:.4f},{('gyro', 'acc', 'mag')[s]}_{axis},{v:.9g}" for t, s, vector in samples(r, SI) for axis, v in zip(AXES, vector)
    ]
    path = folder / "melted.csv"
    path.write_text("\n".join(["time,variable,value", *rows]) + "\n")
    return path


def cut_long(folder: Path, r: Recording) -> Path:
    path = long(folder, r)
    path.write_text(path.read_text() + "15.1,gyroscope,0.1")
    return path


def files_of_axes(folder: Path, r: Recording) -> Path:
    inner = folder / "axes"
    inner.mkdir()
    for sensor, values in zip(("gyro", "acc", "mag"), vectors(r, field=1)):
        kept = np.isfinite(values).all(axis=1)
        for axis, column in zip(AXES, values[kept].T):
            write_rows(inner / f"{sensor}_{axis}.csv", "time,value", [r.t_s[kept], column])
    return inner


def force_in_rows_of_its_own(folder: Path, r: Recording) -> Path:
    """3 ms after the rates."""
    rows = []
    for t, *row in zip(r.t_s, *(np.char.mod("%.9g", values).tolist() for values in vectors(r, field=1))):
        rate, force, field = (",".join(cell.replace("nan", "") for cell in cells) for cells in row)
        rows += [f"{t:.4f},{rate},,,,{field}", f"{t + 0.003:.4f},,,,{force},,,"]
    path = folder / "apart.csv"
    path.write_text("\n".join(["t_s,gx,gy,gz,ax,ay,az,mx,my,mz", *rows]) + "\n")
    return path


def as_json(folder: Path, tree: object) -> Path:
    path = folder / "log.json"
    path.write_text(json.dumps(tree))
    return path


def lists(r: Recording) -> dict[str, Any]:
    """Times in ms, and n x 3 by sensor."""
    t_ms = (1e3 * r.t_s).tolist()
    return {"t": t_ms, **{name: np.nan_to_num(v).tolist() for name, v in zip(("gyro", "accel", "mag"), vectors(r, *USUAL))}}


def units_of_all(folder: Path, r: Recording, **units: str) -> Path:
    return as_json(folder, {"meta": {"units": {"time": "ms", "gyro": "deg/s", "accel": "g", "mag": "uT", **units}}, **lists(r)})


def units_by_name(folder: Path, r: Recording) -> Path:
    return as_json(folder, {**lists(r), "timeUnit": "ms", "gyro_unit": "deg/s", "accelUnits": ["g"] * 3, "mag_unit": "uT"})


def units_by_sensor(folder: Path, r: Recording) -> Path:
    tree = {}
    for sensor, name in enumerate(NAMES):
        own = [(t, v) for t, s, v in samples(r, USUAL) if s == sensor]
        tree[name] = {"unit": UNITS[sensor], "samples": [{"t": t, **dict(zip(AXES, vector))} for t, vector in own]}
    return as_json(folder, tree)


def units_of_records(folder: Path, r: Recording) -> Path:
    rows = [{"time": t, "sensor": NAMES[s], "unit": UNITS[s], "values": vector} for t, s, vector in samples(r, USUAL)]
    return as_json(folder, {"samples": rows})


def units_of_values(folder: Path, r: Recording) -> Path:
    """Each number with its unit."""
    rows: dict[float, dict[str, Any]] = {}
    for t, s, vector in samples(r, USUAL):
        named = {"gam"[s] + axis: {"value": v, "unit": UNITS[s]} for axis, v in zip(AXES, vector)}
        rows.setdefault(t, {"t": t}).update(named)
    return as_json(folder, list(rows.values()))


def npz(folder: Path, r: Recording) -> Path:
    gyro, acc, mag = vectors(r, *USUAL)
    np.savez(folder / "log.npz", t=r.t_s, gyro=gyro, acc=acc, mag=mag, fs=100.0, name="walk", gyro_unit="deg/s", acc_unit="g")
    return folder / "log.npz"


def mat(folder: Path, r: Recording) -> Path:
    gyro, acc, mag = vectors(r, *USUAL)
    units = {"gyr": "deg/s", "acc": "g", "mag": "uT"}
    scipy.io.savemat(folder / "log.mat", {"imu": {"t": r.t_s, "gyr": gyro, "acc": acc, "mag": mag, "units": units}})
    return folder / "log.mat"


def hdf5(folder: Path, r: Recording) -> Path:
    with h5py.File(folder / "log.h5", "w") as file:
        file["imu/t"] = r.t_s
        for name, values, unit in zip(("gyr", "acc", "mag"), vectors(r, *USUAL), UNITS):
            file.create_dataset(f"imu/{name}", data=values).attrs["Units" if name == "acc" else "units"] = unit
    return folder / "log.h5"


ANDROID = ("android.sensor.gyroscope", "android.sensor.accelerometer", "android.sensor.magnetic_field")
WITH_UNITS = ("Gyro (deg/s)", "Acc (g)", "Mag (uT)")
SHAPES: dict[str, Callable[[Path, Recording], Path]] = {
    "long": long,
    "long, no header": partial(long, header="", names=("GYRO", "ACC", "MAG")),
    "long, semicolons": partial(long, header="seconds;type;V0;V1;V2", mark=";"),
    "long, Android": partial(long, header="timestamp_s,sensor_name,value_x,value_y,value_z", names=ANDROID),
    "long, a column of units": partial(long, header="time,sensor,x,y,z,unit", factors=USUAL, units=UNITS),
    "long, units behind names": partial(long, names=WITH_UNITS, factors=USUAL),
    "long, of a barometer too": partial(long, beside="0.1,pressure,1013"),
    "long, of axes": of_axes,
    "long, cut off": cut_long,
    "files of axes": files_of_axes,
    "force in rows of its own": force_in_rows_of_its_own,
    "json, units of all": units_of_all,
    "json, units by name": units_by_name,
    "json, units by sensor": units_by_sensor,
    "json, units of records": units_of_records,
    "json, units of values": units_of_values,
    "npz with units": npz,
    "mat with units": mat,
    "hdf5 with units": hdf5,
}
"""The writer of a file of each shape."""
FAULTY: dict[str, tuple[str, Callable[[Path, Recording], Path]]] = {
    "long, deg/s and g of no unit": ("stops", partial(long, factors=USUAL)),
    "long, a unit that is none": ("refused", partial(long, header="time,sensor,x,y,z,unit", units=("furlong/s", "g", "uT"))),
    "long, without a gyroscope": ("refused", partial(long, names=("pressure", "accelerometer", "magnetometer"))),
    "json, a unit that is none": ("refused", partial(units_of_all, gyro="furlong/s")),
    "json, a unit that is wrong": ("stops", partial(units_of_all, gyro="rad/s")),
}
"""By shape: the verdict, and the writer of the file."""
