"""Files as devices, apps and sketches write them, by the documentation of each format, in addition to those of recorded.py."""

from __future__ import annotations

import functools
import gzip
import json
import operator
import struct
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import scipy.io

import recorded
from hnav.io.recordings import Recording
from recorded import EPOCH_NS, G, columns, write_rows

DEG = 180 / np.pi
AXES = "xyz"


def vectors(r: Recording, rate: float = 1.0, force: float = 1.0, field: float = 1e6) -> list[np.ndarray]:
    """n x 3 of gyro, accel and mag."""
    return [rate * r.rate_b_rad_s, force * r.force_b_m_s2, field * r.field_b_tesla]


def _json(path: Path, tree: object) -> Path:
    path.write_text(json.dumps(tree), encoding="utf-8")
    return path


def json_records(folder: Path, r: Recording) -> Path:
    g, a, m = vectors(r)
    rows = [{"timestamp": 1e3 * t, "gyro": dict(zip(AXES, gyro)), "acc": dict(zip(AXES, acc)), "mag": dict(zip(AXES, mag))}
            for t, gyro, acc, mag in zip(r.t_s.tolist(), g.tolist(), a.tolist(), m.tolist())]  # fmt: skip
    return _json(folder / "records.json", {"device": "x", "data": rows})


def json_columns(folder: Path, r: Recording) -> Path:
    names = ["t_s", *(f"{kind}{axis}" for kind in "gam" for axis in AXES)]
    return _json(folder / "columns.json", dict(zip(names, [r.t_s.tolist(), *(c.tolist() for c in columns(r, field=1))])))


def json_lines(folder: Path, r: Recording) -> Path:
    g, a, m = vectors(r, field=1)
    path = folder / "lines.jsonl"
    path.write_text("".join(json.dumps({"t": t, "gyro": x, "accel": y, "mag": z}) + "\n"
                            for t, x, y, z in zip(r.t_s.tolist(), g.tolist(), a.tolist(), m.tolist())))  # fmt: skip
    return path


def sensor_logger_json(folder: Path, r: Recording) -> Path:
    """Texts for numbers, a record for each sample, force without gravity too."""
    rows: list[dict[str, str]] = [{"sensor": "Metadata", "platform": "android"}]
    for name, values in zip(("Gyroscope", "TotalAcceleration", "Magnetometer"), vectors(r)):
        for t, vector in zip(r.t_s.tolist(), values.tolist()):
            reading = {"sensor": name, "time": str(EPOCH_NS + round(1e9 * t)), "seconds_elapsed": str(t)}
            rows.append(reading | {axis: str(v) for axis, v in zip(AXES, vector)})
    rows += [{**row, "sensor": "Accelerometer", "z": "0.1"} for row in rows if row["sensor"] == "TotalAcceleration"]
    return _json(folder / "sensor_logger.json", rows)


def movesense(folder: Path, r: Recording) -> Path:
    """Four samples for each time stamp in ms; deg/s."""
    g, a, m = vectors(r, DEG)
    rows = []
    for i in range(0, len(r.t_s) - 3, 4):
        batch = {
            name: [dict(zip(AXES, v)) for v in values[i : i + 4].tolist()]
            for name, values in (("ArrayAcc", a), ("ArrayGyro", g), ("ArrayMagn", m))
        }
        rows.append({"imu9": {"Timestamp": round(1e3 * r.t_s[i]), **batch}})
    return _json(folder / "movesense.json", {"data": rows})


def npz(folder: Path, r: Recording) -> Path:
    g, a, m = vectors(r, field=1)
    np.savez(folder / "arrays.npz", time=r.t_s, gyro=g, acc=a.T, mag=m)
    return folder / "arrays.npz"


def mat(folder: Path, r: Recording) -> Path:
    g, a, m = vectors(r, field=1)
    scipy.io.savemat(folder / "log.mat", {"imu": {"t": r.t_s, "gyr": g, "acc": a, "mag": m}, "note": "walk"})
    return folder / "log.mat"


def packed(folder: Path, r: Recording) -> Path:
    plain = recorded.x_io(folder, r)
    path = folder / "x_io.csv.gz"
    path.write_bytes(gzip.compress(plain.read_bytes()))
    plain.unlink()
    return path


def only_table(folder: Path, r: Recording) -> Path:
    inner = folder / "session"
    inner.mkdir()
    recorded.x_io(inner, r)
    (inner / "notes.txt").write_text("walked around the house\n")
    (inner / "settings.json").write_text('{"rate": 100}')
    return inner


def adafruit_mpu6050(folder: Path, r: Recording) -> Path:
    g, a, _ = vectors(r)
    path = folder / "mpu6050.txt"
    lines = ["Adafruit MPU6050 test!", "MPU6050 Found!", "Accelerometer range set to: +-8G"]
    for t, gyro, acc in zip(r.t_s, g, a):
        stamp = f"12:00:{t:09.6f} -> "
        lines.append(stamp + "Acceleration X: {:.9f}, Y: {:.9f}, Z: {:.9f} m/s^2".format(*acc))
        lines.append(stamp + "Rotation X: {:.9f}, Y: {:.9f}, Z: {:.9f} rad/s".format(*gyro))
        lines.append(stamp + "Temperature: 30.5 degC")
    path.write_text("\n".join(lines) + "\n")
    return path


def bno055(folder: Path, r: Recording) -> Path:
    lines = []
    for t, *rows in zip(r.t_s, *vectors(r)):
        lines.append(f"t_ms: {1e3 * t:.3f}")
        for name, row in zip(("Gyro", "Accl", "Mag"), rows):
            lines.append(f"{name}:\tx= {row[0]:.9f} |\ty= {row[1]:.9f} |\tz= {row[2]:.9f}")
        lines.append("Linear:\tx= 0.0 |\ty= 0.0 |\tz= 0.1")
    path = folder / "bno055.log"
    path.write_text("\n".join(lines) + "\n")
    return path


def icm20948(folder: Path, r: Recording) -> Path:
    """SparkFun's sketch behind the time of a terminal: units and brackets, numbers of one width."""
    path = folder / "icm20948.log"
    rows = np.stack(columns(r, DEG, 1e3 / G), axis=1)
    line = "12:00:{:09.6f} -> Scaled. Acc (mg) [ {:012.5f}, {:012.5f}, {:012.5f} ], Gyr (DPS) [ {:011.5f}, {:011.5f}, {:011.5f} ], Mag (uT) [ {:09.5f}, {:09.5f}, {:09.5f} ], Tmp (C) [ 00030.12 ]"
    path.write_text("\n".join(line.format(t, *row[3:6], *row[:3], *row[6:]) for t, row in zip(r.t_s, rows)) + "\n")
    return path


def vectors_of_a_sketch(folder: Path, r: Recording) -> Path:
    """millis() in brackets, a unit behind each vector."""
    path = folder / "sketch.log"
    line = "[{:.0f}] w=({:.6f}, {:.6f}, {:.6f}) deg/s, a=({:.6f}, {:.6f}, {:.6f}) m/s2, B=({:.4f}, {:.4f}, {:.4f}) uT"
    path.write_text("\n".join(line.format(1e3 * t, *row) for t, row in zip(r.t_s, np.stack(columns(r, DEG), axis=1))) + "\n")
    return path


def plotter(folder: Path, r: Recording) -> Path:
    names = [f"{kind}{axis}" for kind in "gam" for axis in AXES]
    path = folder / "plotter.txt"
    path.write_text("".join(f"ms:{1e3 * t:.3f}," + ",".join(f"{n}:{v:.9f}" for n, v in zip(names, row)) + "\n"
                            for t, row in zip(r.t_s, np.stack(columns(r), axis=1))))  # fmt: skip
    return path


def rostopic(folder: Path, r: Recording) -> Path:
    """rostopic echo -p /imu/data: ns, covariances, the whole force called linear."""
    names = ["%time", "field.header.seq", "field.header.stamp", "field.header.frame_id"]
    names += [f"field.orientation.{axis}" for axis in "xyzw"] + [f"field.orientation_covariance{i}" for i in range(9)]
    names += [f"field.angular_velocity.{axis}" for axis in AXES] + [f"field.angular_velocity_covariance{i}" for i in range(9)]
    names += [f"field.linear_acceleration.{axis}" for axis in AXES] + [
        f"field.linear_acceleration_covariance{i}" for i in range(9)
    ]
    c, zero = columns(r), ["0.0"] * 9
    rows = [[str(EPOCH_NS + round(1e9 * t)), str(i), str(EPOCH_NS + round(1e9 * t)), "imu", "0", "0", "0", "1", *zero,
             *(repr(float(c[k][i])) for k in range(3)), *zero, *(repr(float(c[k][i])) for k in range(3, 6)), *zero]
            for i, t in enumerate(r.t_s)]  # fmt: skip
    path = folder / "imu.csv"
    path.write_text("\n".join([",".join(names), *map(",".join, rows)]) + "\n")
    return path


def betaflight(folder: Path, r: Recording, with_head: bool = True, units: dict[str, str] | None = None) -> Path:
    """Blackbox Explorer: a preamble of settings, then quoted names; deg/s and counts of 1/2048 g, or the units that the names state."""
    head = [
        '"Product","Blackbox flight data recorder by Nicholas Sherlock"',
        *(f'"setting_{i}","{i}"' for i in range(120)),
        '"acc_1G","2048"',
    ]
    names = [
        "loopIteration",
        "time",
        "axisP[0]",
        *(f"gyroADC[{i}]" for i in range(3)),
        *(f"gyroUnfilt[{i}]" for i in range(3)),
        *(f"accSmooth[{i}]" for i in range(3)),
    ]
    if units:
        names = [f"{name} ({units[name[:3]]})" if name[:3] in units else name for name in names]
    c = columns(r, 1.0, 1 / G) if units else columns(r, DEG, 2048 / G)
    path = write_rows(folder / "blackbox.csv", ",".join(f'"{n}"' for n in names),
                      [np.arange(len(r.t_s)), 1e6 * r.t_s, 0 * r.t_s, *c[:3], *c[:3], *c[3:6]])  # fmt: skip
    if with_head:
        path.write_text("\n".join(head) + "\n" + path.read_text())
    return path


def ardupilot(folder: Path, r: Recording) -> Path:
    """Dataflash by hand from its documentation: FMT messages describe the others."""
    formats = {"FMT": (128, "BBnNZ", "Type,Length,Name,Format,Columns"), "IMU": (129, "QBffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ"),
               "MAG": (130, "QBfff", "TimeUS,I,MagX,MagY,MagZ")}  # fmt: skip
    packs = {"FMT": "<BB4s16s64s", "IMU": "<QBffffff", "MAG": "<QBfff"}
    parts = []
    for name, (number, kinds, labels) in formats.items():
        length = struct.calcsize(packs[name]) + 3
        parts.append(b"\xa3\x95\x80" + struct.pack(packs["FMT"], number, length, name.encode(), kinds.encode(), labels.encode()))
    for t, rate, force, field in zip(r.t_s, *vectors(r, field=1e7)):
        us = round(1e6 * t) + 1_000_000
        parts.append(b"\xa3\x95\x81" + struct.pack(packs["IMU"], us, 0, *rate, *force))
        parts.append(b"\xa3\x95\x81" + struct.pack(packs["IMU"], us, 1, *(rate + 1), *force))
        parts.append(b"\xa3\x95\x82" + struct.pack(packs["MAG"], us, 0, *field))
    path = folder / "00000001.BIN"
    path.write_bytes(b"".join(parts))
    return path


def ardupilot_text(folder: Path, r: Recording) -> Path:
    lines = ["FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns", "FMT, 129, 36, IMU, QBffffff, TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ",
             "FMT, 130, 24, MAG, QBfff, TimeUS,I,MagX,MagY,MagZ"]  # fmt: skip
    for t, rate, force, field in zip(r.t_s, *vectors(r, field=1e7)):
        us = round(1e6 * t) + 1_000_000
        lines.append(f"IMU, {us}, 0, " + ", ".join(f"{v:.9g}" for v in (*rate, *force)))
        lines.append(f"MAG, {us}, 0, " + ", ".join(f"{v:.9g}" for v in field))
    path = folder / "flight.log"
    path.write_text("\n".join(lines) + "\n")
    return path


def milliseconds(folder: Path, r: Recording) -> Path:
    """Times without a unit: whole ms."""
    header = "timestamp;gyro_x_dps;gyro_y_dps;gyro_z_dps;acc_x_g;acc_y_g;acc_z_g;mag_x_uT;mag_y_uT;mag_z_uT"
    return write_rows(folder / "ms.csv", header, [1e3 * r.t_s, *columns(r, DEG, 1 / G)], ";", ",")


def spelled(folder: Path, r: Recording) -> Path:
    """Units as theses spell them, columns in another order, a byte order mark."""
    header = "\ufeffMag X [µT],Mag Y [µT],Mag Z [µT],Acc X [m·s⁻²],Acc Y [m·s⁻²],Acc Z [m·s⁻²],Gyro X [deg.s^-1],Gyro Y [deg.s^-1],Gyro Z [deg.s^-1],Time [msec]"
    c = columns(r, DEG)
    return write_rows(folder / "spelled.csv", header, [*c[6:], *c[3:6], *c[:3], 1e3 * r.t_s])


def ordinal_degrees(folder: Path, r: Recording) -> Path:
    header = "Time (s)\t" + "\t".join(
        [*(f"Gyro{a} (º/s)" for a in "XYZ"), *(f"Acc{a} (G)" for a in "XYZ"), *(f"Mag{a} (mGauss)" for a in "XYZ")]
    )
    return write_rows(folder / "ordinal.txt", header, [r.t_s, *columns(r, DEG, 1 / G, 1e7)], "\t")


def rpm(folder: Path, r: Recording) -> Path:
    header = "time_s," + ",".join(
        [*(f"gyro_{a} [rpm]" for a in AXES), *(f"acc_{a} [cm/s^2]" for a in AXES), *(f"mag_{a} [nT]" for a in AXES)]
    )
    return write_rows(folder / "rpm.csv", header, [r.t_s, *columns(r, 30 / np.pi, 100, 1e9)])


def cut_off(folder: Path, r: Recording) -> Path:
    path = recorded.x_io(folder, r)
    text = path.read_text() + "9.99,0.1,0.2,-"
    path.write_text(text)
    return path


GNSS_LOGGER = """# Header Description:
# Raw,utcTimeMillis,TimeNanos,LeapSecond
# UncalAccel,utcTimeMillis,elapsedRealtimeNanos,UncalAccelXMps2,UncalAccelYMps2,UncalAccelZMps2,BiasXMps2,BiasYMps2,BiasZMps2
# UncalGyro,utcTimeMillis,elapsedRealtimeNanos,UncalGyroXRadPerSec,UncalGyroYRadPerSec,UncalGyroZRadPerSec,DriftXRadPerSec,DriftYRadPerSec,DriftZRadPerSec
# UncalMag,utcTimeMillis,elapsedRealtimeNanos,UncalMagXMicroT,UncalMagYMicroT,UncalMagZMicroT,BiasXMicroT,BiasYMicroT,BiasZMicroT
# Fix,Provider,LatitudeDegrees,LongitudeDegrees,AltitudeMeters,SpeedMps,AccuracyMeters,BearingDegrees,UnixTimeMillis
"""
SENSOR_DATA = """% LogFile created by the App 'GetSensorData' for Android.
%  ACCE;AppTimestamp(s);SensorTimestamp(s);Acc_X(m/s^2);Acc_Y(m/s^2);Acc_Z(m/s^2);Accuracy(integer)
%  GYRO;AppTimestamp(s);SensorTimestamp(s);Gyr_X(rad/s);Gyr_Y(rad/s);Gyr_Z(rad/s);Accuracy(integer)
%  MAGN;AppTimestamp(s);SensorTimestamp(s);Mag_X(uT);;Mag_Y(uT);Mag_Z(uT);Accuracy(integer)
%  PRES;AppTimestamp(s);SensorTimestamp(s);Pres(mbar);Accuracy(integer)
%  GNSS;AppTimestamp(s);SensorTimeStamp(s);Latit(deg);Long(deg);Altitude(m);Bearing(deg);Accuracy(m);Speed(m/s);SatInView;SatInUse
"""


def _logged(
    folder: Path, name: str, r: Recording, head: str, row: Callable[[str, float, str], str], names: str, fix: str
) -> Path:
    """A row for each sample under a header of remarks, and remarks between the rows."""
    lines = []
    for k, (t, *samples) in enumerate(zip(r.t_s.tolist(), *vectors(r))):
        mark = row(",", t, "")[-1]
        lines += [row(kind, t, mark.join(f"{v:.9f}" for v in sample)) for kind, sample in zip(names.split(), samples)]
        lines += [fix.format(ms=EPOCH_NS // 10**6 + round(1e3 * t), t=t)] if k % 100 == 0 else []
        lines += [head.splitlines()[1]] if k == 500 else []
    (folder / name).write_text(head + "\n".join(lines) + "\n")
    return folder / name


def gnss_logger(folder: Path, r: Recording) -> Path:
    """GnssLogger of Google: a second time, and biases behind the samples."""

    def row(kind: str, t: float, sample: str) -> str:
        return f"{kind},{EPOCH_NS // 10**6 + round(1e3 * t)},{5 * 10**12 + round(1e9 * t)},{sample}" + (sample and ",0.0,0.0,0.0")

    return _logged(
        folder, "gnss_log.txt", r, GNSS_LOGGER, row, "UncalGyro UncalAccel UncalMag", "Fix,GPS,48.1,11.5,500.0,1.0,3.9,90.0,{ms}"
    )


def get_sensor_data(folder: Path, r: Recording, head: str = SENSOR_DATA) -> Path:
    """GetSensorData of LOPSI: two times, and a cell too many in one of its headers."""

    def row(kind: str, t: float, sample: str) -> str:
        return f"{kind};{t:.3f};{t + 2000:.6f};{sample}" + (sample and ";3")

    fix = "GNSS;{t:.3f};1700000000.0;48.1;11.5;500.0;90;3.9;1.0;20;12\nPRES;{t:.3f};{t:.6f};1013.2;3"
    return _logged(folder, "logfile.txt", r, head, row, "GYRO ACCE MAGN", fix)


def sensor_log(folder: Path, r: Recording) -> Path:
    """SensorLog of iOS: readings, and beside them those of the filter of iOS; force negated."""
    g, a, m = vectors(r, force=-1 / G)
    groups = [("accelerometerAcceleration", "G", a), ("gyroRotation", "rad/s", g), ("magnetometer", "µT", m), ("motionRotationRate", "rad/s", g + 1),
              ("motionUserAcceleration", "G", 0 * a), ("motionGravity", "G", a), ("motionMagneticField", "µT", 2 * m)]  # fmt: skip
    names = ["loggingTime(s)", *(f"{name}{axis}({unit})" for name, unit, _ in groups for axis in "XYZ")]
    return write_rows(folder / "sensorlog.csv", ",".join(names), [r.t_s, *(column for *_, v in groups for column in v.T)])


def merged(folder: Path, r: Recording) -> Path:
    """Sensor Logger, all sensors in one table: force with and without gravity."""
    g, a, m = vectors(r)
    groups = [("Accelerometer", 0.01 * a), ("Gravity", a), ("Gyroscope", g), ("TotalAcceleration", a), ("Magnetometer", m)]
    names = ["seconds_elapsed", *(f"{name}_{axis}" for name, _ in groups for axis in AXES)]
    path = write_rows(folder / "merged.csv", ",".join(names), [r.t_s, *(column for _, v in groups for column in v.T)])
    return path


def delsys(folder: Path, r: Recording) -> Path:
    """Trigno: before each axis its own times."""
    names, arrays = [], []
    for kind, unit, values in zip(
        ("ACC", "GYRO", "MAG"), ("g", "°/s", "µT"), (r.force_b_m_s2 / G, DEG * r.rate_b_rad_s, 1e6 * r.field_b_tesla)
    ):
        for axis, column in zip("XYZ", values.T):
            names += ["X[s]", f"Avanti sensor 1: {kind}.{axis} 1 [{unit}]"]
            arrays += [r.t_s, column]
    return write_rows(folder / "delsys.csv", ",".join(names), arrays)


def raw_and_calibrated(folder: Path, r: Recording) -> Path:
    """Consensys of Shimmer, both boxes ticked."""
    groups = zip(("Gyro", "Accel_LN", "Mag"), vectors(r, DEG), ("deg/s", "m/(s^2)", "uT"))
    columns_of = [(f"Shimmer_5E4D_{name}_{axis}_{kind}", unit if kind == "CAL" else "no_units", v[:, i] * (1 if kind == "CAL" else 300))
                  for name, v, unit in groups for kind in ("RAW", "CAL") for i, axis in enumerate("XYZ")]  # fmt: skip
    names, units, arrays = zip(("Shimmer_5E4D_Timestamp_Unix_CAL", "ms", 1e3 * r.t_s), *columns_of)
    return write_rows(folder / "shimmer.csv", "\t".join(names) + "\n" + "\t".join(units), list(arrays), "\t")


def instants_between_blanks(folder: Path, r: Recording) -> Path:
    lines = [
        f"2026-01-31 12:00:{t:09.6f} " + " ".join(f"{v:.9f}" for v in row) for t, row in zip(r.t_s, np.stack(columns(r), axis=1))
    ]
    (folder / "blanks.txt").write_text("# time gx gy gz ax ay az mx_uT my_uT mz_uT\n" + "\n".join(lines) + "\n")
    return folder / "blanks.txt"


def kitti(folder: Path, r: Recording) -> Path:
    """A file for each row; instants with nine decimals."""
    (folder / "drive" / "oxts" / "data").mkdir(parents=True)
    instants = [f"2011-09-26 13:02:{t:012.9f}\n" for t in r.t_s]
    (folder / "drive" / "oxts" / "timestamps.txt").write_text("".join(instants))
    for k, (rate, force) in enumerate(zip(r.rate_b_rad_s, r.force_b_m_s2)):
        row = [49.0, 8.4, 112.8, *(8 * [0.0]), *force, *force, *rate, *rate, 0.05, 0.02, 4, 10, 4, 4, 0]
        (folder / "drive" / "oxts" / "data" / f"{k:010d}.txt").write_text(" ".join(map(str, row)))
    return folder / "drive"


def ronin(folder: Path, r: Recording) -> Path:
    """Groups of which one is whole: samples at common times, beside those as they were read."""
    with h5py.File(folder / "walk.hdf5", "w") as file:
        for name, values in zip(("gyro", "acce", "magnet"), vectors(r)):
            file[f"synced/{name}"] = values
            file[f"raw/imu/{name}"] = np.column_stack([1e9 * r.t_s, values])
        file["synced/time"], file["synced/gyro_uncalib"] = r.t_s, r.rate_b_rad_s + 0.01
    return folder / "walk.hdf5"


def dat_con(folder: Path, r: Recording) -> Path:
    """Of DJI; an instance in brackets stands before each name."""
    names = [f"IMU_ATTI(0):{name}" for name in ("Longitude[degrees]", "velN[meters/Sec]", "accelComposite[meters/Sec2]")]
    for name, unit in (("gyro", "[degrees/Sec]"), ("accel", "[meters/Sec2]"), ("mag", "[uT]")):
        names += [f"IMU_ATTI(0):{name}{axis}{unit}" for axis in "XYZ"]
    of_filter = np.tile([11.5, 0.1, 9.8], (len(r.t_s), 1))
    return write_rows(folder / "flight.csv", ",".join(["Clock:offsetTime", *names]), [r.t_s, *of_filter.T, *columns(r, DEG)])


def vectornav(folder: Path, r: Recording) -> Path:
    """Behind the time of a logger; a sentence that was damaged is none."""
    lines = []
    for t, *rows in zip(r.t_s, *vectors(r, field=1e4)):
        body = "VNYMR,+010.071,+000.278,-002.026," + ",".join(f"{v:+.9f}" for row in rows[::-1] for v in row)
        lines.append(f"{t:.6f} ${body}*{functools.reduce(operator.xor, body.encode()):02X}\n")
    lines.insert(5, lines[5].replace("+010", "+011"))
    (folder / "vn100.txt").write_text("".join(lines))
    return folder / "vn100.txt"


def blue_trident(folder: Path, r: Recording) -> Path:
    names = [
        "time_s",
        *(f"g{axis}_deg/s" for axis in AXES),
        *(f"a{axis}_m/s/s" for axis in AXES),
        *(f"m{axis}_ut" for axis in AXES),
    ]
    return write_rows(folder / "trident.csv", ",".join(names), [r.t_s, *columns(r, DEG)])


def inertial_sense(folder: Path, r: Recording) -> Path:
    names = ["time", *(f"{name}[{k}]" for name in ("pqr", "acc", "mag") for k in range(3))]
    return write_rows(folder / "imu.csv", ",".join(names), [r.t_s, *columns(r)])


def nuscenes(folder: Path, r: Recording) -> Path:
    """Of its CAN bus: times in us since 1970, and an attitude too."""
    g, a, m = vectors(r)
    rows = [{"linear_accel": force, "mag": field, "orientation": [1, 0, 0, 0], "rotation_rate": rate, "utime": EPOCH_NS // 1000 + round(1e6 * t)}
            for t, rate, force, field in zip(r.t_s.tolist(), g.tolist(), a.tolist(), m.tolist())]  # fmt: skip
    return _json(folder / "scene_ms_imu.json", rows)


SHAPES: dict[str, Callable[[Path, Recording], Path]] = {
    "json records": json_records, "json columns": json_columns, "json lines": json_lines, "sensor logger json": sensor_logger_json,
    "movesense": movesense, "npz": npz, "mat": mat, "packed": packed, "folder of one table": only_table, "mpu6050": adafruit_mpu6050,
    "bno055": bno055, "icm20948": icm20948, "vectors of a sketch": vectors_of_a_sketch, "plotter": plotter, "rostopic": rostopic, "betaflight": betaflight,
    "betaflight, decoded": lambda folder, r: betaflight(folder, r, with_head=False),
    "betaflight, units": lambda folder, r: betaflight(folder, r, units={"tim": "us", "gyr": "rad/s", "acc": "g"}), "ardupilot": ardupilot, "ardupilot text": ardupilot_text,
    "milliseconds": milliseconds, "spelled": spelled, "ordinal degrees": ordinal_degrees, "rpm": rpm, "cut off": cut_off,
    "gnss logger": gnss_logger, "get sensor data": get_sensor_data, "get sensor data, no header": lambda folder, r: get_sensor_data(folder, r, "%\n%\n"),
    "sensor log": sensor_log, "merged": merged, "delsys": delsys, "raw and calibrated": raw_and_calibrated, "instants between blanks": instants_between_blanks,
    "kitti": kitti, "ronin": ronin, "dat con": dat_con, "vectornav": vectornav, "blue trident": blue_trident, "inertial sense": inertial_sense,
    "nuscenes": nuscenes,
}  # fmt: skip
"""The writer of a file of each shape."""
