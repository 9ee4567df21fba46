"""Files of recordings as devices, apps and robots write them, by the libraries of the formats where these write, else by hand from
their documentation."""

from __future__ import annotations

import struct
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from hnav.io.recordings import Recording

G = 9.80665
EPOCH_NS = 1_700_000_000_000_000_000


def columns(recording: Recording, rate: float = 1.0, force: float = 1.0, field: float = 1e6) -> list[np.ndarray]:
    """The nine columns, multiplied."""
    return [*(rate * recording.rate_b_rad_s).T, *(force * recording.force_b_m_s2).T, *(field * recording.field_b_tesla).T]


def write_rows(path: Path, header: str, arrays: list[np.ndarray], delimiter: str = ",", decimal: str = ".") -> Path:
    """A line for each row, empty where there is no number; times keep all their digits."""
    rows = (delimiter.join("" if np.isnan(v) else repr(float(v)).replace(".", decimal) for v in row) for row in zip(*arrays))
    path.write_text(header + "\n" + "\n".join(rows) + "\n", encoding="utf-8")
    return path


def house(folder: Path, r: Recording) -> Path:
    return write_rows(folder / "house.csv", "t_s,gx,gy,gz,ax,ay,az,mx,my,mz", [r.t_s, *columns(r, field=1)])


def capitals(folder: Path, r: Recording) -> Path:
    header = "TIMESTAMP,GYRO_X,GYRO_Y,GYRO_Z,ACC_X,ACC_Y,ACC_Z,MAG_X,MAG_Y,MAG_Z"
    return write_rows(folder / "capitals.csv", header, [r.t_s, *columns(r, field=1)])


def semicolons(folder: Path, r: Recording) -> Path:
    header = "t_ms;wx [deg/s];wy [deg/s];wz [deg/s];ax [mg];ay [mg];az [mg];Bx [nT];By [nT];Bz [nT]"
    return write_rows(folder / "semicolons.csv", header, [1e3 * r.t_s, *columns(r, 180 / np.pi, 1e3 / G, 1e9)], ";", ",")


def tabs(folder: Path, r: Recording) -> Path:
    header = "# logger 3\ntime_us\tGyroX\tGyroY\tGyroZ\tAccX\tAccY\tAccZ\tMagX (G)\tMagY (G)\tMagZ (G)"
    return write_rows(folder / "tabs.txt", header, [1e6 * r.t_s, *columns(r, field=1e4)], "\t")


def x_io(folder: Path, r: Recording) -> Path:
    """As in the example of Fusion."""
    header = "Time (s),Gyroscope X (deg/s),Gyroscope Y (deg/s),Gyroscope Z (deg/s),Accelerometer X (g),Accelerometer Y (g),Accelerometer Z (g),Magnetometer X (uT),Magnetometer Y (uT),Magnetometer Z (uT)"
    return write_rows(folder / "x_io.csv", header, [r.t_s, *columns(r, 180 / np.pi, 1 / G)])


def xsens(folder: Path, r: Recording) -> Path:
    """MT Manager: SampleTimeFine wraps at 32 bits, the field in units of its strength at Xsens."""
    header = "// Start Time: Unknown\n// Update Rate: 100.0Hz\n// Filter Profile: human (46.1)\n// Firmware Version: 4.0.2\n"
    header += "PacketCounter\tSampleTimeFine\tAcc_X\tAcc_Y\tAcc_Z\tGyr_X\tGyr_Y\tGyr_Z\tMag_X\tMag_Y\tMag_Z\tQuat_q0"
    g, a, m = (columns(r, field=1 / 5e-5)[i : i + 3] for i in (0, 3, 6))
    ticks = (np.round(r.t_s * 1e4).astype(int) + 2**32 - 50) % 2**32
    lines = [
        "\t".join([str(k % 65536), str(t), *("" if np.isnan(v) else repr(float(v)) for v in row), "1"])
        for k, (t, *row) in enumerate(zip(ticks, *a, *g, *m))
    ]
    path = folder / "MT_00B421AF.txt"
    path.write_text(header + "\n" + "\n".join(lines) + "\n")
    return path


def dot(folder: Path, r: Recording) -> Path:
    """Movella DOT: commas, SampleTimeFine in us that wraps, deg/s, the field in units of its strength."""
    header = "sep=,\nDeviceTag:,DOT 1\nFirmwareVersion:,2.0.0\nPacketCounter,SampleTimeFine,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z,Mag_X,Mag_Y,Mag_Z"
    turned = columns(r, 180 / np.pi, field=1 / 5e-5)
    ticks = (np.round(r.t_s * 1e6) + 2**32 - 1_000_000) % 2**32
    counter = np.arange(len(r.t_s), dtype=float)
    return write_rows(folder / "dot.csv", header, [counter, ticks, *turned[3:6], *turned[:3], *turned[6:]])


def shimmer(folder: Path, r: Recording) -> Path:
    """ConsensysBASIC: every name begins with the device, units in a line of their own, a second accelerometer."""
    names = ["Timestamp_Unix", *(f"{sensor}_{axis}" for sensor in ("Accel_LN", "Accel_WR", "Gyro", "Mag") for axis in "XYZ")]
    units = ["ms", *["m/(s^2)"] * 6, *["deg/s"] * 3, *["local_flux"] * 3]
    header = '"sep=\t"\n' + "\t".join(f"Shimmer_5E4D_{name}_CAL" for name in names) + "\n" + "\t".join(units)
    g, a, m = (columns(r, 180 / np.pi, field=1 / 5e-5)[i : i + 3] for i in (0, 3, 6))
    return write_rows(folder / "shimmer.csv", header, [1e3 * r.t_s, *a, *(0.5 * v for v in a), *g, *m], "\t")


def blanks(folder: Path, r: Recording) -> Path:
    """A table as numpy.savetxt writes it: columns of one width, nan where there is no number."""
    path = folder / "blanks.txt"
    np.savetxt(path, np.stack([r.t_s, *columns(r, field=1)], axis=1), fmt="%24.16e", header="time  gx gy gz  ax ay az  mx my mz")
    return path


def euroc(folder: Path, r: Recording) -> Path:
    """Without a magnetometer, as the sets are."""
    file = folder / "V1_01" / "mav0" / "imu0" / "data.csv"
    file.parent.mkdir(parents=True)
    header = "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]"
    rows = [",".join([str(EPOCH_NS + round(t * 1e9)), *map(repr, map(float, row))]) for t, *row in zip(r.t_s, *columns(r)[:6])]
    file.write_text("\n".join([header, *rows]) + "\n")
    return file.parents[2]


def _phone_csv(t_s: np.ndarray, values: np.ndarray, after_s: float = 0.0) -> str:
    rows = [
        f"{EPOCH_NS + round((t + after_s) * 1e9)},{t + after_s!r},{z!r},{y!r},{x!r}"
        for t, (x, y, z) in zip(t_s.tolist(), values.tolist())
    ]
    return "\n".join(["time,seconds_elapsed,z,y,x", *rows]) + "\n"


def sensor_logger(folder: Path, r: Recording, ios: bool = False) -> Path:
    """A zip of Android: force with and without gravity, each sensor with times of its own; of iOS: gravity apart, signs opposite."""
    path = folder / ("ios.zip" if ios else "android.zip")
    (gt, g), (at, a), (mt, m) = (r.samples(sensor) for sensor in ("gyro", "accel", "mag"))
    gravity = np.broadcast_to([0, 0, G], a.shape)
    sign = -1.0 if ios else 1.0
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("Gyroscope.csv", _phone_csv(gt, g))
        archive.writestr("Accelerometer.csv", _phone_csv(at, sign * (a - gravity), 0.002))
        archive.writestr("Gravity.csv", _phone_csv(at, sign * gravity, 0.002))
        if not ios:
            archive.writestr("TotalAcceleration.csv", _phone_csv(at, a, 0.002))
        archive.writestr("Magnetometer.csv", _phone_csv(mt, 1e6 * m, 0.003))
        archive.writestr(
            "Metadata.csv", f"version,device name,platform,standardisation\n3,phone,{'ios' if ios else 'android'},false\n"
        )
        archive.writestr("Annotation.csv", "time,seconds_elapsed,text,millisecond_press_duration\n")
    return path


def metabase(folder: Path, r: Recording) -> Path:
    """A folder of files with long names; turn rates in deg/s, force in g, field in tesla."""
    path = folder / "MetaWear"
    path.mkdir()
    for sensor, name, unit, factor in (
        ("gyro", "Gyroscope", "deg/s", 180 / np.pi), ("accel", "Accelerometer", "g", 1 / G), ("mag", "Magnetometer", "T", 1.0)
    ):  # fmt: skip
        t_s, values = r.samples(sensor)
        header = "epoch (ms),timestamp (+0100),elapsed (s)," + ",".join(f"{axis}-axis ({unit})" for axis in "xyz")
        file = path / f"walk_MetaWear_2026-01-31T12.00.00.000_C0FFEE_{name}_100.000Hz_1.5.0.csv"
        write_rows(file, header, [EPOCH_NS * 1e-6 + 1e3 * t_s, 1e3 * t_s, t_s, *(factor * values).T])
    return path


def phyphox(folder: Path, r: Recording) -> Path:
    """A folder; quoted headers with units."""
    out = folder / "phyphox"
    (out / "meta").mkdir(parents=True)
    (out / "meta" / "device.csv").write_text('"property","value"\n"deviceModel","phone"\n')
    kinds = (("gyro", "Gyroscope", "Gyroscope {} (rad/s)", 1.0), ("accel", "Accelerometer", "Acceleration {} (m/s^2)", 1.0),
             ("mag", "Magnetometer", "Magnetic field {} (µT)", 1e6))  # fmt: skip
    for sensor, name, title, factor in kinds:
        t_s, values = r.samples(sensor)
        header = ",".join(f'"{h}"' for h in ("Time (s)", *(title.format(axis) for axis in "xyz")))
        write_rows(out / f"{name}.csv", header, [t_s + 0.001 * len(name), *(factor * values).T])
    linear = ",".join(f'"{h}"' for h in ("Time (s)", *(f"Linear Acceleration {axis} (m/s^2)" for axis in "xyz")))
    write_rows(out / "Linear Accelerometer.csv", linear, [r.t_s, *np.zeros((3, len(r.t_s)))])
    return out


def parquet(folder: Path, r: Recording) -> Path:
    path = folder / "table.parquet"
    frame = r.to_dataframe().reset_index().rename(columns={"t_s": "timestamp_ns"})
    frame["timestamp_ns"] = np.round(1e9 * frame["timestamp_ns"]).astype("int64")
    frame.to_parquet(path)
    return path


def ulog(folder: Path, r: Recording, more: dict[str, tuple[str, list[bytes]]] | None = None) -> Path:
    """By hand from https://docs.px4.io/main/en/dev_log/ulog_file_format.html: header, formats, subscriptions, data.

    more: other topics by name: their fields, and the bodies of their messages."""
    more = more or {}
    formats = {
        "sensor_combined": "uint64_t timestamp;float[3] gyro_rad;uint32_t gyro_integral_dt;int32_t accelerometer_timestamp_relative;float[3] accelerometer_m_s2;",
        "vehicle_magnetometer": "uint64_t timestamp;uint64_t timestamp_sample;float[3] magnetometer_ga;",
    }
    formats |= {name: fields for name, (fields, _) in more.items()}
    parts = [b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0)]

    def message(kind: str, body: bytes) -> None:
        parts.append(struct.pack("<HB", len(body), ord(kind)) + body)

    message("B", bytes(40))
    for name, fields in formats.items():
        message("F", f"{name}:{fields}".encode())
    for number, name in enumerate(formats):
        message("A", struct.pack("<BH", 0, number) + name.encode())
    for t, rate, force, field in zip(r.t_s, r.rate_b_rad_s, r.force_b_m_s2, r.field_b_tesla):
        us = round(1e6 * (t + 1))
        message("D", struct.pack("<HQ3fIi3f", 0, us, *rate, 10000, -500, *force))
        if np.isfinite(field).all():
            message("D", struct.pack("<HQQ3f", 1, us + 700, us, *(1e4 * field)))
    for number, name in enumerate(formats):
        for body in more[name][1] if name in more else []:
            message("D", struct.pack("<H", number) + body)
    path = folder / "log.ulg"
    path.write_bytes(b"".join(parts))
    return path


ONE_IMU = {"/imu/data": (1.0, 1.0)}


def bag(
    folder: Path,
    r: Recording,
    kind: str = "bag",
    fixes: list[tuple[float, int, float, float, float]] | None = None,
    imus: dict[str, tuple[float, float]] = ONE_IMU,
) -> Path:
    """By rosbags: kind bag, db3 or mcap. A second, shorter topic of an inertial sensor is there too. imus: topics, and what their rates and
    forces are multiplied by.

    fixes: of satellites, each time, status, latitude, longitude in deg, height; sigmas 2, 1, 3 m east, north, up."""
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import StoragePlugin
    from rosbags.rosbag2 import Writer as Writer2
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if kind == "bag" else Stores.ROS2_HUMBLE)
    names = ("sensor_msgs/msg/Imu", "sensor_msgs/msg/MagneticField", "std_msgs/msg/Header", "geometry_msgs/msg/Vector3",
             "geometry_msgs/msg/Quaternion", "builtin_interfaces/msg/Time", "sensor_msgs/msg/NavSatFix",
             "sensor_msgs/msg/NavSatStatus")  # fmt: skip
    imu, mag, header, vector, quaternion, stamp, fix, status = (store.types[name] for name in names)
    serialize = store.serialize_ros1 if kind == "bag" else store.serialize_cdr
    path = folder / (f"log.{kind}" if kind == "bag" else f"log_{kind}")
    plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
    with Writer1(path) if kind == "bag" else Writer2(path, version=9, storage_plugin=plugin) as writer:
        to = {name: writer.add_connection(name, kind.__msgtype__, typestore=store)
              for name, kind in (*((topic, imu) for topic in imus), ("/imu/other", imu), ("/imu/mag", mag))}  # fmt: skip

        def headed(k: int, t: float) -> tuple[int, Any]:
            ns = EPOCH_NS + round(1e9 * t)
            sequence = {"seq": k} if kind == "bag" else {}
            return ns, header(stamp=stamp(sec=ns // 10**9, nanosec=ns % 10**9), frame_id="imu", **sequence)

        if fixes:
            to["/fix"] = writer.add_connection("/fix", fix.__msgtype__, typestore=store)
        for k, (t, state, *place) in enumerate(fixes or []):
            ns, head = headed(k, t)
            message = fix(head, status(status=state, service=1), *place, np.diag([4.0, 1.0, 9.0]).ravel(), 2)
            writer.write(to["/fix"], ns, serialize(message, fix.__msgtype__))
        for k, (t, rate, force, field) in enumerate(zip(r.t_s, r.rate_b_rad_s, r.force_b_m_s2, r.field_b_tesla)):
            ns, head = headed(k, t)
            for topic, (of_rate, of_force) in imus.items():
                vectors = vector(*(of_rate * rate).tolist()), vector(*(of_force * force).tolist())
                sample = imu(head, quaternion(0.0, 0.0, 0.0, 1.0), np.zeros(9), vectors[0], np.zeros(9), vectors[1], np.zeros(9))
                writer.write(to[topic], ns + 3_000_000, serialize(sample, names[0]))
            if k < 3:
                writer.write(to["/imu/other"], ns, serialize(sample, names[0]))
            if np.isfinite(field).all():
                writer.write(to["/imu/mag"], ns, serialize(mag(head, vector(*field.tolist()), np.zeros(9)), names[1]))
    return path


SHAPES: dict[str, Callable[[Path, Recording], Path]] = {
    "house": house, "capitals": capitals, "semicolons": semicolons, "tabs": tabs, "x-io": x_io, "xsens text": xsens, "dot": dot,
    "shimmer": shimmer, "blanks": blanks, "euroc": euroc,
    "sensor logger": sensor_logger, "sensor logger, ios": lambda folder, r: sensor_logger(folder, r, ios=True), "phyphox": phyphox,
    "metabase": metabase,
    "parquet": parquet, "ulog": ulog, "ros 1": bag, "ros 2": lambda folder, r: bag(folder, r, "db3"),
    "mcap": lambda folder, r: bag(folder, r, "mcap"),
}  # fmt: skip
"""The writer of a file of each shape."""
