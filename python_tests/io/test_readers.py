"""Every shape of recording holds the same samples at the same times, whatever it is called and in whatever units."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import devices
import recorded
from command_line import hnav
from hnav import Recording, read
from hnav.io.readers import FORMATS
from hnav.io.recordings import RecordingError
from motion import tilted_motion

EPOCH_S = recorded.EPOCH_NS * 1e-9
# Times of a sensor that a shape shifts against the gyroscope's, in s.
SHIFTS = {
    "sensor logger": (0, 0.002, 0.003),
    "sensor logger, ios": (0, 0.002, 0.003),
    "phyphox": (0.009, 0.013, 0.012),
    "ulog": (0, -5e-4, 0),
}
EPOCHS = {"ulog": 1.0, "euroc": EPOCH_S, "ros 1": EPOCH_S, "ros 2": EPOCH_S, "mcap": EPOCH_S, "metabase": EPOCH_S}


@pytest.fixture(scope="module")
def motion() -> Recording:
    """A magnetometer at a fifth of the rate."""
    whole = tilted_motion(1).recording
    field = np.full_like(whole.field_b_tesla, np.nan)
    field[::5] = whole.field_b_tesla[::5]
    return replace(whole, field_b_tesla=field)


@pytest.mark.parametrize("shape", recorded.SHAPES)
def test_every_shape_is_recognised_and_nothing_is_resampled(tmp_path, motion, shape):
    for package in {
        "ulog": ["pyulog"],
        "parquet": ["pyarrow"],
        "ros 1": ["rosbags"],
        "ros 2": ["rosbags"],
        "mcap": ["rosbags"],
    }.get(shape, []):
        pytest.importorskip(package)
    recording = read(recorded.SHAPES[shape](tmp_path, motion))
    assert (np.diff(recording.t_s) > 0).all()
    shifts = SHIFTS.get(shape, (0, 0, 0))
    for sensor, shift_s in zip(("gyro", "accel", "mag"), shifts):
        if shape == "euroc" and sensor == "mag":
            assert recording.field_b_tesla is None
            continue
        t_s, values = recording.samples(sensor)
        expected_t_s, expected = motion.samples(sensor)
        np.testing.assert_allclose(t_s - EPOCHS.get(shape, 0.0), expected_t_s + shift_s, rtol=0, atol=1e-6)
        np.testing.assert_allclose(values, expected, rtol=1e-6, atol=1e-6 * np.abs(expected).max())
    assert recording.origin.format in FORMATS or recording.origin.format in ("csv", "sensor-logger", "phyphox", "folder")
    assert f"gyro {len(motion.t_s)} at 100 Hz" in repr(recording)


@pytest.mark.parametrize("header, fault", [
    ("t_s,gx [deg/s],gy [furlong/s],gz [deg/s],ax,ay,az", "the unit 'furlong/s' of the column gy .furlong/s. is not supported: give gyro_unit"),
    ("t_s,gx,gy,gz,ax,ay,az\ns,deg/s,deg/s,smoot,g,g,g", "the unit 'smoot' of the column gz is not supported: give gyro_unit"),
    ("time [ticks],gx,gy,gz,ax,ay,az", "the unit 'ticks' of the column time .ticks. is not supported: give time_unit=s or ms or us, or rate_hz"),
])  # fmt: skip
def test_a_unit_that_is_not_known_is_refused_also_beside_one_that_is(tmp_path, motion, header, fault):
    path = recorded.write_rows(tmp_path / "strange.csv", header, [1e3 * motion.t_s, *recorded.columns(motion)[:6]])
    with pytest.raises(RecordingError, match=fault):
        read(path)
    read(path, gyro_unit="deg/s", time_unit="ms")


def test_of_columns_that_may_be_of_one_sensor_the_reading_is_taken_and_the_other_named(tmp_path, motion):
    whole = replace(motion, field_b_tesla=tilted_motion(1).recording.field_b_tesla)
    notes = read(devices.sensor_log(tmp_path, whole)).origin.notes
    assert notes[:3] == (
        "gyro: gyroRotationX(rad/s), not motionRotationRateX(rad/s) (choose by columns gx=NAME)",
        "accel: accelerometerAccelerationX(G), not motionUserAccelerationX(G) (choose by columns ax=NAME)",
        "mag: magnetometerX(µT), not motionMagneticFieldX(µT) (choose by columns mx=NAME)",
    )


def test_bags_say_which_topics_were_taken(tmp_path, motion):
    pytest.importorskip("rosbags")
    path = recorded.bag(tmp_path, motion, "db3")
    assert read(path).origin.notes == ("imu: /imu/data, not /imu/other (choose by columns imu=TOPIC)",)
    assert len(read(path, columns={"imu": "/imu/other"}).samples("gyro")[0]) == 3
    assert len(read(next(path.glob("*.db3"))).t_s) == len(motion.t_s)
    with pytest.raises(RecordingError, match="/nowhere.*has no such topic.*/imu/data"):
        read(path, columns={"imu": "/nowhere"})


def test_gyroscope_and_accelerometer_may_have_topics_of_their_own(tmp_path, motion):
    """As of a RealSense: in each the vector of the other sensor is zero."""
    pytest.importorskip("rosbags")
    apart = {"/camera/accel/sample": (0.0, 1.0), "/camera/gyro/sample": (1.0, 0.0)}
    recording, whole = read(recorded.bag(tmp_path, motion, imus=apart)), read(recorded.bag(tmp_path, motion, "db3"))
    assert recording.origin.notes == ("gyro: /camera/gyro/sample", "accel: /camera/accel/sample")
    np.testing.assert_array_equal(recording.rate_b_rad_s, whole.rate_b_rad_s)
    np.testing.assert_array_equal(recording.force_b_m_s2, whole.force_b_m_s2)


def test_units_go_by_the_caller_then_the_header_then_the_format(tmp_path, motion):
    path = recorded.x_io(tmp_path, motion)
    by_header = read(path)
    assert {k: str(v) for k, v in by_header.origin.units.items()} == {
        "time": "s by header", "gyro": "deg/s by header", "accel": "g by header", "mag": "uT by header"}  # fmt: skip
    given = read(path, gyro_unit="rad/s", accel_unit="mg", mag_unit="nT", time_unit="ms")
    np.testing.assert_allclose(given.rate_b_rad_s, np.degrees(by_header.rate_b_rad_s))
    np.testing.assert_allclose(1e3 * given.force_b_m_s2, by_header.force_b_m_s2)
    np.testing.assert_allclose(1e3 * given.samples("mag")[1], by_header.samples("mag")[1])
    np.testing.assert_allclose(1e3 * given.t_s, by_header.t_s)
    assert str(read(recorded.capitals(tmp_path, motion)).origin.units["gyro"]) == "rad/s assumed"


def test_columns_are_named_negated_and_counted(tmp_path, motion):
    plain = recorded.columns(motion, field=1)
    path = recorded.write_rows(tmp_path / "odd.csv", "when,p,q,r,u,v,w2", [motion.t_s, *plain[:6]])
    names = dict(zip(("t_s", "gx", "gy", "gz", "ax", "ay", "az"), ("when", "q", "p", "-r", "u", "v", "w2")))
    recording = read(path, columns=names)
    np.testing.assert_array_equal(recording.rate_b_rad_s, motion.rate_b_rad_s[:, [1, 0, 2]] * [1, 1, -1])
    np.testing.assert_array_equal(recording.force_b_m_s2, motion.force_b_m_s2)
    bare = tmp_path / "bare.txt"
    np.savetxt(bare, np.stack([motion.t_s, *plain[:6]], axis=1), delimiter=";")
    counted = read(bare, columns=dict(zip(names, "1234567")))
    np.testing.assert_allclose(counted.force_b_m_s2, motion.force_b_m_s2)
    with pytest.raises(RecordingError, match="columns gx=spin: .* has no such column, but when, p"):
        read(path, columns=names | {"gx": "spin"})


def test_axes_are_turned_for_every_format(tmp_path, motion):
    turned = read(recorded.house(tmp_path, motion), axes={"mag": "y,x,-z"})
    np.testing.assert_array_equal(turned.field_b_tesla, motion.field_b_tesla[:, [1, 0, 2]] * [1, 1, -1])
    for wrong in ("y,x", "x,x,z", "x,y,-q", "--x,y,z"):
        with pytest.raises(RecordingError, match="three axes with their signs"):
            read(tmp_path / "house.csv", axes={"mag": wrong})


def test_a_rate_replaces_times_that_are_missing_or_wrong(tmp_path, motion):
    header = "gx,gy,gz,ax,ay,az"
    path = recorded.write_rows(tmp_path / "untimed.csv", header, recorded.columns(motion)[:6])
    np.testing.assert_allclose(read(path, rate_hz=50).t_s, np.arange(len(motion.t_s)) / 50)
    with pytest.raises(RecordingError, match="the column t_s is missing; the file has gx, .*, or give rate_hz"):
        read(path)
    stuck = recorded.write_rows(tmp_path / "stuck.csv", "t_s," + header, [np.zeros(100), *recorded.columns(motion)[:6]])
    with pytest.raises(RecordingError, match="give rate_hz"):
        read(stuck)
    assert read(stuck, rate_hz=100).t_s[-1] == pytest.approx(0.99)


def test_instants_of_a_calendar_are_times(tmp_path):
    lines = ["datetime,gx,gy,gz,ax,ay,az"] + [f"2026-01-31 12:00:0{k}.25,0.1,0.2,0.3,0,0,9.81" for k in range(4)]
    (tmp_path / "dated.csv").write_text("\n".join(lines))
    recording = read(tmp_path / "dated.csv")
    np.testing.assert_allclose(np.diff(recording.t_s), 1)
    assert recording.t_s[0] == pd.Timestamp("2026-01-31 12:00:00.25", tz="UTC").timestamp()


def test_times_of_a_clock_pass_midnight(tmp_path):
    rows = [f"{clock},0.1,0.2,0.3,0,0,9.81" for clock in ("23:59:58.5", "23:59:59.5", "00:00:00.5", "00:00:01.5")]
    (tmp_path / "night.csv").write_text("\n".join(["time,gx,gy,gz,ax,ay,az", *rows]))
    recording = read(tmp_path / "night.csv")
    np.testing.assert_allclose(recording.t_s, 86398.5 + np.arange(4))


WRONG_CLOCKS = {
    "one wrong stamp": (
        lambda row, t: np.where(row == 700, 1e6, t),
        "time stamps that do not fit their neighbours were interpolated: 1;",
    ),
    "set back": (
        lambda row, t: t - 3600.0 * (row >= 700),
        "the clock was set back once, by 3599.99 s at 6.99 s; time goes on there;",
    ),
    "set back twice": (
        lambda row, t: t - 2.5 * (row >= 700) - 60.0 * (row >= 900),
        "the clock was set back 2 times, first by 2.49 s at 6.99 s; time goes on there;",
    ),
}


@pytest.mark.parametrize("fault", WRONG_CLOCKS)
def test_a_wrong_clock_is_mended_and_reported_and_stops_nothing(tmp_path, fault):
    spoil, note = WRONG_CLOCKS[fault]
    body = tilted_motion(15).recording
    path = recorded.house(tmp_path, replace(body, t_s=spoil(np.arange(len(body.t_s)), body.t_s)))
    recording = read(path)
    np.testing.assert_allclose(recording.t_s, body.t_s, rtol=0, atol=1e-9)
    np.testing.assert_array_equal(recording.rate_b_rad_s, body.rate_b_rad_s)
    checked = hnav("check", path)
    assert checked.returncode == 1 and f"warning: time: {note}" in checked.stdout + checked.stderr
    done = hnav("filter", path, "--out", tmp_path / "out.csv")
    assert done.returncode == 0 and note in done.stderr
    right = hnav("filter", recorded.house(tmp_path, body), "--out", tmp_path / "right.csv")
    assert right.returncode == 0 and not right.stderr
    ours, its = (pd.read_csv(tmp_path / name, comment="#") for name in ("out.csv", "right.csv"))
    np.testing.assert_allclose(ours, its, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("header", [
    "Zeit (s);Drehrate X (°/s);Drehrate Y (°/s);Drehrate Z (°/s);Beschleunigung X (g);Beschleunigung Y (g);Beschleunigung Z (g)",
    "Temps (s);Gyroscope x (°/s);Gyroscope y (°/s);Gyroscope z (°/s);Accélération x (g);Accélération y (g);Accélération z (g)",
    "Tiempo (s);Giroscopio x (°/s);Giroscopio y (°/s);Giroscopio z (°/s);Aceleración x (g);Aceleración y (g);Aceleración z (g)",
])  # fmt: skip
def test_headers_in_other_languages_are_read(tmp_path, motion, header):
    rows = [motion.t_s, *recorded.columns(motion, 180 / np.pi, 1 / recorded.G)[:6]]
    read_back = read(recorded.write_rows(tmp_path / "abroad.csv", header, rows, ";", ","))
    np.testing.assert_allclose(read_back.rate_b_rad_s, motion.rate_b_rad_s, rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(read_back.force_b_m_s2, motion.force_b_m_s2, rtol=1e-12, atol=1e-15)


def test_words_below_a_header_are_units_only_when_one_of_them_is(tmp_path):
    header, row = "time,gx,gy,gz,ax,ay,az", "1,0.1,0.2,0.3,0,0,1"
    units = tmp_path / "units.csv"
    units.write_text("\n".join([header, "s,deg/s,deg/s,deg/s,g,g,g", "0,0.1,0.2,0.3,0,0,1", row]))
    np.testing.assert_allclose(read(units).force_b_m_s2[:, 2], recorded.G)
    with pytest.raises(RecordingError, match="line 4, column gx: 'odd' is not a number"):
        read(_written(tmp_path, [header, "s,deg/s,deg/s,deg/s,g,g,g", row, "2,odd,0.2,0.3,0,0,1"]))
    with pytest.raises(RecordingError, match="line 2, column time: 'some' is not a number"):
        read(_written(tmp_path, [header, "some,words,that,are,not,units,here", row]))


def test_prose_of_words_that_look_like_columns_is_no_header(tmp_path):
    comment = "# columns: time gx gy gz ax ay az"
    path = _written(tmp_path, [comment, "time,gx,gy,gz,ax,ay,az", "0,0.1,0.2,0.3,0,0,9.81", "1,0.1,0.2,0.3,0,0,9.81"])
    assert len(read(path).t_s) == 2


def _written(folder, lines):
    path = folder / "written.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


def test_a_frame_makes_a_recording_and_a_recording_a_frame(motion):
    again = Recording.from_dataframe(motion.to_dataframe(), "again")
    for name in ("t_s", "rate_b_rad_s", "force_b_m_s2", "field_b_tesla"):
        np.testing.assert_array_equal(getattr(again, name), getattr(motion, name))
    frame = motion.to_dataframe().set_index(pd.to_datetime(motion.t_s, unit="s", utc=True)).rename(columns=str.upper)
    np.testing.assert_allclose(Recording.from_dataframe(frame).t_s, motion.t_s, atol=1e-9)
    with pytest.raises(RecordingError, match="holds no numbers"):
        Recording.from_dataframe(motion.to_dataframe().assign(gx="much"))
    with pytest.raises(RecordingError, match="no column of a sensor among"):
        Recording.from_dataframe(pd.DataFrame({"price": [1.0]}))


def test_samples_that_stand_twice_are_left_out_and_reported(tmp_path, motion):
    rows = np.repeat(np.arange(len(motion.t_s)), np.where(np.arange(len(motion.t_s)) % 7, 1, 2))
    path = recorded.write_rows(
        tmp_path / "twice.csv", "t_s,gx,gy,gz,ax,ay,az", [c[rows] for c in (motion.t_s, *recorded.columns(motion)[:6])]
    )
    recording = read(path)
    np.testing.assert_array_equal(recording.t_s, motion.t_s)
    assert "gyro: 15 samples that stood twice were left out" in recording.origin.notes


@pytest.mark.parametrize("name, content, named", [
    ("data.mtb", b"\xfa\xff\x0d\x00", "export text from MT Manager"),
    ("suit.mvnx", b'<?xml version="1.0"?><mvnx version="4">', "record the trackers with MT Manager"),
    ("picture.png", b"\x89PNG\r\n\x1a\n\0\0", "no supported format"),
    ("empty.csv", b"", "the file is empty"),
    ("prose.txt", b"Dear all,\nnothing here is a recording.\n", "no header"),
    ("broken.zip", b"PK\x03\x04 and no more", "the zip cannot be read"),
    ("broken.ulg", b"ULog\x01\x12\x35\x01 and no more", "cannot be read|has no topic"),
    ("broken.bag", b"#ROSBAG V2.0\n and no more", "cannot be read"),
    ("broken.mcap", b"\x89MCAP0\r\n and no more", "cannot be read"),
    ("broken.db3", b"SQLite format 3\0 and no more", "cannot be read"),
    ("broken.parquet", b"PAR1 and no more", "cannot be read"),
])  # fmt: skip
def test_what_cannot_be_read_is_answered_in_one_line(tmp_path, name, content, named):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(RecordingError, match=named) as error:
        read(path)
    assert name in str(error.value) and "\n" not in str(error.value)


def test_a_folder_without_files_is_refused(tmp_path):
    (tmp_path / "inner").mkdir()
    with pytest.raises(RecordingError, match="the folder holds no file: give the file of the recording"):
        read(tmp_path)


def test_a_library_that_is_missing_is_asked_for_by_name(tmp_path, motion, monkeypatch):
    pytest.importorskip("pyulog")
    path = recorded.ulog(tmp_path, motion)
    monkeypatch.setitem(__import__("sys").modules, "pyulog", None)
    with pytest.raises(RecordingError, match="needs the Python package pyulog: python -m pip install pyulog"):
        read(path)


@pytest.mark.parametrize("wrong, named", [
    ({"format": "tcx"}, "format = tcx: choose one of broad"),
    ({"gyro_unit": "knots"}, "gyro_unit = knots: choose one of rad/s, deg/s"),
    ({"time_unit": "days"}, "time_unit = days: choose one of s, ms"),
    ({"rate_hz": 0.0}, "rate_hz = 0: must be above 0 Hz"),
    ({"columns": {"gw": "x"}}, "columns = gw: choose from t_s, gx"),
    ({"axes": {"nose": "x,y,z"}}, "axes = nose: choose from gyro, accel, mag"),
])  # fmt: skip
def test_arguments_that_do_not_exist_are_named(tmp_path, motion, wrong, named):
    with pytest.raises(RecordingError, match=named):
        read(recorded.house(tmp_path, motion), **wrong)


@pytest.mark.parametrize("names", [("A", "B"), ("left", "right")])
@pytest.mark.parametrize("in_blocks", [False, True])
def test_rows_of_several_devices_are_not_read_as_one(tmp_path, names, in_blocks):
    """Merged, they would be 13 to 61 deg off in tilt, with a sigma of a degree."""
    rows = [f"{0.01 * k:.2f},{name},0,0,0,0,0,9.81" for k in range(100) for name in names]
    if in_blocks:
        rows.sort(key=lambda row: row.split(",")[1])
    path = tmp_path / "two.csv"
    path.write_text("\n".join(["time,device,gx,gy,gz,ax,ay,az", *rows]) + "\n")
    said = rf"rows of 2 devices by the column device \({names[0]}, {names[1]}\): .* keep the rows of one"
    with pytest.raises(RecordingError, match=said):
        read(path)
    frame = pd.read_csv(path)
    for table in (frame, frame.set_index(["device", "time"])):
        with pytest.raises(RecordingError, match=said):
            Recording.from_dataframe(table)
    path.with_suffix(".json").write_text(frame.to_json(orient="records"))
    with pytest.raises(RecordingError, match=said):
        read(path.with_suffix(".json"))
    path.write_text("\n".join(["time,device,gx,gy,gz,ax,ay,az", *[row for row in rows if names[0] in row]]) + "\n")
    assert len(read(path).t_s) == 100
    assert len(Recording.from_dataframe(pd.read_csv(path).set_index(["device", "time"])).t_s) == 100


@pytest.mark.parametrize("name, is_time", [
    ("sensor", False), ("log", False), ("system", False), ("gps", False), ("utc", True), ("gps_tow", True), ("elapsed", True),
    ("Sample Time (s)", True), ("sensor time", True), ("offset_ms", True),
])  # fmt: skip
def test_words_that_stand_beside_a_time_name_none_alone(tmp_path, motion, name, is_time):
    """A column "sensor" was taken for the time stamps, a text in it for a faulty one."""
    path = recorded.house(tmp_path, motion)
    factor = 1000 if name.endswith("_ms") else 1
    header, *rows = path.read_text().splitlines()
    cells = [f"{factor * float(row.partition(',')[0])!r}" if is_time else "IMU1" for row in rows]
    path.write_text(
        "\n".join([f"{name},{header.partition(',')[2]}", *(f"{c},{r.partition(',')[2]}" for c, r in zip(cells, rows))])
    )
    if is_time:
        np.testing.assert_allclose(read(path).t_s, motion.t_s, atol=1e-9)
        return
    with pytest.raises(RecordingError, match="column t_s is missing"):
        read(path)
    assert read(path, rate_hz=100).origin.notes == (f"columns not read: {name}",)


def test_columns_that_are_proposed_for_a_sensor_number_no_rows_and_hold_no_times(tmp_path):
    header = "time,counter,packet_no,systemtime_ms,date,Id,device,imu_p,imu_q,imu_r,acc_x,acc_y,acc_z"
    path = tmp_path / "unnamed.csv"
    path.write_text("\n".join([header, *(f"{k},1,1,0,0,1,A,0,0,0,0,0,9.8" for k in range(20))]))
    with pytest.raises(RecordingError, match="such as columns gx=imu_p columns gy=imu_q columns gz=imu_r$"):
        read(path)


def test_columns_that_are_proposed_have_the_unit_of_the_sensor(tmp_path):
    """Also where the units stand in a line of their own; beside a position the file is not taken for one of satellites alone."""
    path = tmp_path / "aim.csv"
    head = "Time,GPS Latitude,GPS Longitude,GPS Altitude,InlineAcc,LateralAcc,VerticalAcc,RollRate,PitchRate,YawRate\ns,deg,deg,m,g,g,g,deg/s,deg/s,deg/s\n"
    path.write_text(head + "".join(f"{k / 100},48,11,500,0,0,1,0,0,{k % 3}\n" for k in range(60)))
    with pytest.raises(RecordingError, match="such as columns gx=RollRate columns gy=PitchRate columns gz=YawRate$"):
        read(path)
    path.write_text(
        path.read_text().replace("RollRate", "attitude_x").replace("PitchRate", "attitude_y").replace("YawRate", "attitude_z")
    )
    given = {"gx": "attitude_x", "gy": "attitude_y", "gz": "attitude_z"}
    with pytest.raises(RecordingError, match="such as columns ax=InlineAcc columns ay=LateralAcc columns az=VerticalAcc$"):
        read(path, columns=given)
    force = {"ax": "InlineAcc", "ay": "LateralAcc", "az": "VerticalAcc"}
    np.testing.assert_allclose(read(path, columns=given | force).force_b_m_s2[0], [0, 0, 9.80665])


def test_numbers_without_names_are_asked_for_by_their_places_however_long_the_file_is(tmp_path):
    """The line in which the first part of the file ends, a number alone, is no header."""
    path = tmp_path / "numbers.csv"
    rows = (
        (f"{k / 100:08.3f}" + 12 * ",0.000001").ljust(122, "0") + "\n" for k in range(1000)
    )  # character 100 000 is of a first number
    path.write_text("".join(rows))
    with pytest.raises(RecordingError, match="line 1: no header; .* columns t_s=1,gx=2"):
        read(path)


@pytest.mark.parametrize("heartbeat", [b"\xfd\x09\0\0\0\x01\x01", b"\xfe\x09\0\x01\x01\0"])
@pytest.mark.parametrize("stamp", [b"", (1_700_000_000_000_000).to_bytes(8, "big")])
def test_telemetry_of_mavlink_is_answered_by_the_log_that_holds_all_samples(tmp_path, heartbeat, stamp):
    path = tmp_path / "flight.tlog"
    path.write_bytes(20 * (stamp + heartbeat.ljust(21, b"\0")))
    with pytest.raises(RecordingError, match="telemetry of MAVLink.*give the log of the vehicle"):
        read(path)


@pytest.mark.parametrize(
    "spelled, per_s", [("{:.4f} sec", 1), ("{:g} ms", 1e3), ("{:.9f} min", 1 / 60), ("{:.11f} hr", 1 / 3600)]
)
def test_times_are_spans_with_their_unit(tmp_path, motion, spelled, per_s):
    """As MATLAB writes a duration of its timetables."""
    frame = motion.to_dataframe().reset_index(names="Time")
    frame["Time"] = [spelled.format(per_s * t) for t in motion.t_s]
    frame.to_csv(tmp_path / "timetable.csv", index=False)
    np.testing.assert_allclose(read(tmp_path / "timetable.csv").t_s, motion.t_s, atol=1e-6)
    np.testing.assert_allclose(Recording.from_dataframe(frame).t_s, motion.t_s, atol=1e-6)
    frame.loc[50, "Time"] = "0.5 parsec"
    with pytest.raises(RecordingError, match="column Time: the times are neither numbers nor like .* 1.5 sec"):
        Recording.from_dataframe(frame)


@pytest.mark.parametrize(
    "of_day, of_clock", [("%Y-%m-%d", "%H:%M:%S.%f"), ("%d.%m.%Y", "%H:%M:%S.%f"), ("%m/%d/%Y", "%I:%M:%S.%f %p")]
)
@pytest.mark.parametrize("first", ["Date", "Time"])
def test_a_date_in_a_column_of_its_own_is_that_of_the_times(tmp_path, motion, of_day, of_clock, first):
    """Over midnight; beside times that have a date, or are numbers, it is none."""
    instants = pd.Timestamp("2026-03-14 23:59:55") + pd.to_timedelta(motion.t_s, unit="s")
    frame = motion.to_dataframe().reset_index(drop=True)
    frame.insert(0, "Date", instants.strftime(of_day))
    frame.insert(1 if first == "Date" else 0, "Time", instants.strftime(of_clock))
    frame.to_csv(tmp_path / "imu.csv", sep=";", index=False)
    begin_s = pd.Timestamp("2026-03-14 23:59:55").timestamp()
    for table in (read(tmp_path / "imu.csv"), Recording.from_dataframe(frame)):
        np.testing.assert_allclose(table.t_s - begin_s, motion.t_s, atol=1e-6)
    for times in (instants.strftime("%Y-%m-%dT%H:%M:%S.%f"), motion.t_s):
        np.testing.assert_allclose(
            np.diff(Recording.from_dataframe(frame.assign(Time=times)).t_s), np.diff(motion.t_s), atol=1e-6
        )


@pytest.mark.parametrize("names", [("header.stamp.secs", "header.stamp.nsecs"), ("sec", "nanosec"), ("stamp_s", "stamp_ns")])
def test_nanoseconds_beside_whole_seconds_are_their_fraction(tmp_path, motion, names):
    """As sensor_msgs/Imu is exported from bags: the whole seconds alone do not increase."""
    frame = motion.to_dataframe().reset_index(names="Time")
    ns = np.round(1e9 * motion.t_s).astype(int) + 1_700_000_000_990_000_000
    frame = frame.assign(**{names[0]: ns // 10**9, names[1]: ns % 10**9})
    frame.to_csv(tmp_path / "imu.csv", index=False)
    for table in (read(tmp_path / "imu.csv"), Recording.from_dataframe(frame)):
        np.testing.assert_allclose(table.t_s - 1.7e9 - 0.99, motion.t_s, atol=1e-6)
    whole = frame.assign(**{names[0]: 1e-9 * ns, names[1]: ns})  # each is the whole time
    np.testing.assert_allclose(Recording.from_dataframe(whole).t_s - 1.7e9 - 0.99, motion.t_s, atol=1e-6)


def test_axes_are_proposed_for_the_axes_that_their_names_say(tmp_path):
    path = tmp_path / "Gyroscope.csv"
    path.write_text("time,seconds_elapsed,z,y,x\n" + "".join(f"{k},{k},0,0,0\n" for k in range(20)))
    with pytest.raises(RecordingError, match="such as columns gx=x columns gy=y columns gz=z$"):
        read(path)


def test_axes_with_units_of_their_own_are_scaled_each_by_its_own(tmp_path):
    path = tmp_path / "mixed.csv"
    head = "t_s,gx [rad/s],gy [rad/s],gz [deg/s],ax [m/s2],ay [g],az [m/s2]\n"
    path.write_text(head + "".join(f"{k / 100},0.1,0.2,{float(np.degrees(0.3))!r},1,{-0.5},-9.8\n" for k in range(60)))
    recording = read(path)
    np.testing.assert_allclose(recording.rate_b_rad_s, np.tile([0.1, 0.2, 0.3], (60, 1)))
    np.testing.assert_allclose(recording.force_b_m_s2, np.tile([1, -0.5 * 9.80665, -9.8], (60, 1)))
    np.testing.assert_allclose(read(path, gyro_unit="deg/s").rate_b_rad_s[0], np.radians([0.1, 0.2, np.degrees(0.3)]))
