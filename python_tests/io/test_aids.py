"""Satellites, pressure, wheels and headings are the same samples in every shape of file, and never a reason to refuse inertial sensors."""

import io
import re
import struct
import zipfile

import numpy as np
import pytest

import devices
import recorded
from hnav import read
from hnav.filters.ins_recording import aids_of, with_aids
from hnav.io.aids import arrived_within
from hnav.io.plausible_aids import check_aids
from hnav.io.readers import read_aids
from hnav.io.readers.aid_columns import aid_column
from hnav.io.readers.pieces import long_table
from hnav.io.recordings import Recording, RecordingError
from motion import tilted_motion

FIX_S = np.array([0.1, 0.3, 0.5])
PLACE_DEG = np.array([[45.5, -93.25, 250.0], [45.5001, -93.2499, 251.0], [45.5002, -93.2498, 252.5]])
VELOCITY = np.array([[1.0, -2.0, 0.25], [1.5, -2.5, -0.5], [2.0, -3.0, 0.0]])


@pytest.fixture(scope="module")
def motion():
    return tilted_motion(1).recording


def with_fixes(motion, header, *others):
    """A table of inertial samples with the fixes in some rows, empty cells in the others."""

    def in_rows(values):
        column = np.full(len(motion.t_s), np.nan)
        column[np.searchsorted(motion.t_s, FIX_S - 1e-9)] = values
        return column

    columns = [*PLACE_DEG.T, *VELOCITY.T, *others]
    return "t_s,gx,gy,gz,ax,ay,az," + header, [motion.t_s, *recorded.columns(motion)[:6], *map(in_rows, columns)]


def assert_fixes(aids, after_s=0.0, down=True):
    position, velocity = aids["position"], aids.get("velocity")
    np.testing.assert_allclose(position.t_s, FIX_S + after_s, rtol=0, atol=1e-6)
    np.testing.assert_allclose(position.values[:, :2], np.radians(PLACE_DEG[:, :2]), rtol=0, atol=2e-9)
    np.testing.assert_allclose(position.values[:, 2], PLACE_DEG[:, 2], atol=1e-3)
    if velocity is not None:
        np.testing.assert_allclose(velocity.values[:, :2], VELOCITY[:, :2], atol=1e-5)
        assert np.isnan(velocity.values[:, 2]).all() != down


@pytest.mark.parametrize("header", [
    "lat_deg,lon_deg,alt_m,vn,ve,vd", "GPS_Latitude,GPS_Longitude,GPS_Altitude,VelN (m/s),VelE (m/s),VelD (m/s)",
    "lat,lng,alt,v_north,v_east,v_down", "Latitude [deg],Longitude [deg],Height [m],vel_n_m_s,vel_e_m_s,vel_d_m_s",
])  # fmt: skip
def test_columns_are_known_by_their_usual_names(tmp_path, motion, header):
    recording = read(recorded.write_rows(tmp_path / "flight.csv", *with_fixes(motion, header)))
    assert_fixes(recording.aids)
    np.testing.assert_array_equal(recording.rate_b_rad_s, motion.rate_b_rad_s)
    assert "position 3 at 5 Hz; velocity 3 at 5 Hz" in repr(recording)
    assert len(recording.cropped(0.35).aids["position"].t_s) == 2


@pytest.mark.parametrize("name, role, unit", [
    ("baro_hPa", "pressure_pa", "hPa"), ("wheel_speed_km_h", "speed_m_s", "km/h"), ("hAcc", "sigma_h", None), ("climb_rate", "vd", None),
    ("lat_1e7", "lat_deg", "1e7deg"), ("airspeed_m_s", None, None), ("velocity", None, None), ("heading", None, None), ("vx", None, None),
    ("temperature", None, None), ("antenna_heading_rad", "antenna_heading_deg", "rad"), ("relPosHeading_deg", "antenna_heading_deg", "deg"),
    ("accHeading", "sigma_heading_deg", None), ("locationLatitude(WGS84)", "lat_deg", None), ("hMSL_mm", "alt_m", "mm"),
    ("SDNorth (m)", "sigma_n", "m"), ("EAST SD", "sigma_e", None), ("latitudeStd(m)", "sigma_n", "m"), ("H-Ell (m)", "alt_m", "m"),
    ("altitude_above_seaLevel(feet)", "alt_m", "ft"), ("longitude_decimal_degree", "lon_deg", "deg"), ("GPS(0):Lat[degrees]", "lat_deg", "deg"),
    ("GPS(0):velN[meters/Sec]", "vn", "m/s"), ("ellipsoidal_height_m", "alt_m", "m"), ("track", None, None),
])  # fmt: skip
def test_what_a_name_means(name, role, unit):
    found = aid_column(name)
    assert (found and found.role, found and found.unit) == (role, unit)


def test_units_signs_and_sigmas(tmp_path, motion):
    header, rows = with_fixes(
        motion, "lat,lon,alt_ft,vn_km_h,ve_kn,vu,hAcc,baro_hPa,wheel_speed_km_h", [2.0, 0.0, 3.0], [1000.0] * 3, [36.0] * 3
    )
    aids = read(recorded.write_rows(tmp_path / "units.csv", header, rows)).aids
    np.testing.assert_allclose(aids["position"].values[:, 2], 0.3048 * PLACE_DEG[:, 2])
    np.testing.assert_allclose(aids["velocity"].values, VELOCITY * [1 / 3.6, 1852 / 3600, -1])
    np.testing.assert_array_equal(aids["position"].sigma, [[2, 2, np.nan], [np.nan] * 3, [3, 3, np.nan]])
    np.testing.assert_allclose(aids["pressure"].values, 1e5)
    np.testing.assert_allclose(aids["speed"].values, 10.0)


def test_headings_of_two_antennas_have_the_sigmas_of_their_rows(tmp_path, motion):
    """A row without a sigma has a usual one; a row without a heading is no sample."""
    header, rows = with_fixes(
        motion, "lat,lon,alt,vn,ve,vd,antenna_heading_deg,heading_sigma_deg", [350.0, np.nan, 20.0], [0.3, 0.3, np.nan]
    )
    heading = read(recorded.write_rows(tmp_path / "antennas.csv", header, rows)).aids["heading"]
    np.testing.assert_allclose(heading.t_s, FIX_S[[0, 2]])
    np.testing.assert_allclose(heading.sigma[:, 0], [np.radians(0.3), np.nan])
    value = aids_of({"heading": heading}).arrays()[3]
    np.testing.assert_allclose(value[:, :2], [[np.radians(350), np.radians(0.3)], [np.radians(20), 0.02]])


INERTIAL_EXPLORER = """Project:     Drive1
Datum:       WGS84, (processing datum)

   Week    GPSTime       Latitude      Longitude   H-Ell  SDNorth  SDEast  SDHeight  VNorth  VEast    VUp  Q
(weeks)      (sec)          (deg)          (deg)     (m)      (m)     (m)       (m)   (m/s)  (m/s)  (m/s)
"""


def test_a_trajectory_with_units_under_its_names_and_a_sigma_of_each_axis(tmp_path):
    path = tmp_path / "drive.txt"
    row = "   2300  {:.3f}  48.0000000000  11.0000000000  500.1  0.01  0.02  0.03  1.5  -2.5  0.1  1\n"
    path.write_text(INERTIAL_EXPLORER + "".join(row.format(345600 + k) for k in range(9)))
    aids = read_aids(path)
    np.testing.assert_array_equal(aids["position"].t_s, 345600 + np.arange(9))
    np.testing.assert_allclose(np.degrees(aids["position"].values[0, :2]), [48, 11])
    np.testing.assert_allclose(aids["position"].sigma[0], [0.01, 0.02, 0.03])
    np.testing.assert_allclose(aids["velocity"].values[0], [1.5, -2.5, -0.1])


def test_a_report_of_gpsd_has_a_velocity_by_its_track_and_a_height_above_the_ellipsoid(tmp_path):
    path = tmp_path / "gpsd.json"
    report = '{"class":"TPV","time":"2026-03-04T12:00:%02d.000Z","lat":48,"lon":11,"altHAE":500,"altMSL":455,"track":90,"speed":2,"epv":6}\n'
    path.write_text("".join(report % k for k in range(9)))
    aids = read_aids(path)
    np.testing.assert_allclose(aids["velocity"].values[:, :2], np.tile([0, 2], (9, 1)), atol=1e-12)
    assert (aids["position"].values[:, 2] == 500).all() and not aids["position"].above_sea


def test_a_file_of_places_without_a_height_is_answered_by_what_lacks(tmp_path):
    path = tmp_path / "ride.csv"
    path.write_text("time,latitude,longitude\n" + "".join(f"{k},48,11\n" for k in range(9)))
    with pytest.raises(RecordingError, match="positions were left out: lat_deg, lon_deg without alt_m; no position"):
        read_aids(path)
    path.write_text("".join(f"{k},48,11,500,1,2,0\n" for k in range(9)))
    with pytest.raises(
        RecordingError, match="must name the columns t_s,lat_deg.*say their places, such as columns t_s=1,lat_deg=2"
    ):
        read_aids(path)


def test_speed_and_course_are_a_velocity_and_no_fix_is_none(tmp_path, motion):
    path = tmp_path / "gnss.csv"
    path.write_text("time,latitude,longitude,altitude,speed,bearing\n1,0,0,0,-1,-1\n2,45,7,100,10,90\n3,45,7,100,0,nan\n")
    aids = read_aids(path)
    np.testing.assert_array_equal(aids["position"].t_s, [2, 3])
    np.testing.assert_allclose(aids["velocity"].values[:, :2], [[0, 10], [0, 0]], atol=1e-12)


@pytest.mark.parametrize("header, values, note", [
    ("lat,lon", "45,7", "positions were left out: lat_deg, lon_deg without alt_m"),
    ("lat,lon,alt,speed", "45,7,100,3", "velocities were left out: ground_speed without course_deg"),
    ("lat,lon,alt,course", "45,7,100,3", "velocities were left out: course_deg without ground_speed"),
    ("lat,lon,alt,speed_m_s,course", "45,7,100,3,90", "course_deg was left out: speed_m_s is along body x"),
    ("lat,lon,alt,speed,course", "45,7,100,3,90", None),
    ("vn,ve,speed", "1,2,3", None),
])  # fmt: skip
def test_columns_without_the_one_that_belongs_to_them_are_named(tmp_path, header, values, note):
    path = tmp_path / "lonely.csv"
    rows = "".join(f"{0.01 * k:.2f},0,0,0,0,{k % 3},9.8,{values}\n" for k in range(100))
    path.write_text(f"t_s,gx,gy,gz,ax,ay,az,{header}\n{rows}")
    recording = read(path)
    notes = [note for note in recording.origin.notes if "left out" in note]
    assert len(notes) == (note is not None) and (note is None or notes[0].startswith(note))
    found = [finding for finding in check_aids(recording) if finding.code == "absent"]
    assert [one.level for one in found] == (["warning"] if note and note.startswith("positions") else [])
    assert all(note in one.message and "alt_m may be a rough constant" in one.advice for one in found)


def test_fixes_of_a_file_of_their_own_come_in_the_order_of_arrival(tmp_path):
    path = tmp_path / "gnss.csv"
    path.write_text("t_s,received_s,lat_deg,lon_deg,alt_m\n1.0,1.4,45,7,100\n1.2,1.3,45,7,101\n1.1,1.35,45,7,102\n")
    position = read_aids(path)["position"]
    np.testing.assert_array_equal(position.t_s, [1.2, 1.1, 1.0])
    np.testing.assert_array_equal(position.received_s, [1.3, 1.35, 1.4])
    assert [len(arrived_within({"position": position}, a, b)["position"].t_s) for a, b in ((0, 1.3), (1.3, 2.0))] == [1, 2]
    with pytest.raises(RecordingError, match="gnss.csv.*no position .lat_deg, lon_deg, alt_m.*columns lat_deg=NAME"):
        path.write_text("t_s,temperature\n1,20\n")
        read_aids(path, columns={"t_s": "t_s"})


def test_a_cell_that_is_no_number_costs_the_aids_alone(tmp_path, motion):
    header, rows = with_fixes(motion, "lat_deg,lon_deg,alt_m,vn,ve,vd")
    path = recorded.write_rows(tmp_path / "text.csv", header, rows)
    lines = path.read_text().splitlines()
    lines[3] = lines[3].rsplit(",", 6)[0] + ",no fix,,,,,"
    path.write_text("\n".join(lines))
    recording = read(path)
    assert not recording.aids and len(recording.t_s) == len(motion.t_s)
    assert recording.origin.notes[0].endswith("line 4, column lat_deg: 'no fix' is not a number")


@pytest.mark.parametrize("step, unit_s", [(1000, 1e-3), (200, 1e-3), (2e5, 1e-6), (1, 1), (5, 1), (0.2, 1), (10, 1e-3)])
def test_times_of_fixes_without_a_unit_go_by_the_intervals_of_fixes(tmp_path, step, unit_s):
    """Milliseconds at 1 Hz were taken for microseconds, and 5 s for 5 ms: intervals of inertial sensors."""
    path = tmp_path / "fixes.csv"
    path.write_text("timestamp,lat,lon,alt\n" + "".join(f"{step * k},45,7,100\n" for k in range(20)))
    aids = read_aids(path)
    np.testing.assert_allclose(aids["position"].t_s, step * unit_s * np.arange(20))
    assert any("by its intervals" in note for note in aids.notes) == (unit_s < 1)


def test_parts_of_an_instant_are_no_times_and_a_height_beside_one_above_the_sea_is_above_the_ellipsoid(tmp_path):
    """NAV-PVT of u-blox, whose hour was taken for the times."""
    path = tmp_path / "pvt.csv"
    rows = "".join(f"{1000 * k},2024,1,2,3,4,{k % 60},45,7,100,52,1,0\n" for k in range(90))
    path.write_text("iTOW,year,month,day,hour,min,sec,lat,lon,height,hMSL,velN,velE\n" + rows)
    position = read_aids(path)["position"]
    np.testing.assert_array_equal(position.t_s, np.arange(90))
    assert position.values[0, 2] == 100 and not position.above_sea


def test_fixes_in_a_folder_are_read_beside_a_table_of_all_sensors_by_the_clock_that_they_share(tmp_path, motion):
    """A table with a magnetometer hid them; PX4 writes the time of UTC beside that of the log."""
    recorded.write_rows(
        tmp_path / "log_imu_0.csv", "timestamp,gx,gy,gz,ax,ay,az,mx,my,mz", [1e6 * motion.t_s, *recorded.columns(motion)]
    )
    fixes = tmp_path / "log_vehicle_gps_position_0.csv"
    fixes.write_text(
        "timestamp,time_utc_usec,lat,lon,alt\n"
        + "".join(f"{200000 * k},{1700000000000000 + 200000 * k},45,7,100\n" for k in range(5))
    )
    for k in range(60):
        (tmp_path / f"log_actuator_{k}.csv").write_text("timestamp,control[0]\n1,2\n")
    recording = read(tmp_path)
    np.testing.assert_allclose(recording.aids["position"].t_s, 0.2 * np.arange(5))
    assert recording.origin.notes[-1] == "read log_imu_0, log_vehicle_gps_position_0"
    assert "clock" not in {finding.code for finding in check_aids(recording)}
    fixes.write_text(fixes.read_text().replace("timestamp,", "row,", 1))
    late = [finding for finding in check_aids(read(tmp_path)) if finding.code == "clock"]
    assert [one.sensor for one in late] == ["position"] and "times from 1700000000 to 1700000001 s" in late[0].message


def test_a_file_of_fixes_says_what_of_it_was_left_out(tmp_path, motion):
    path = tmp_path / "fixes.csv"
    path.write_text("t_s,lat,lon,vn,ve\n0,45,7,1,2\n0.5,45,7,1,2\n")
    beside = with_aids(read(recorded.house(tmp_path, motion)), read_aids(path))
    assert "positions were left out: lat_deg, lon_deg without alt_m" in beside.origin.notes
    path.write_text(path.read_text().replace("vn,ve", "height above ellipsoid (m),ve"))
    assert read_aids(path)["position"].values[0, 2] == 1


def test_fixes_without_a_height_in_a_folder_are_named(tmp_path, motion):
    recorded.house(tmp_path, motion)
    (tmp_path / "gps.csv").write_text("t_s,lat,lon,vn,ve\n0,45,7,1,2\n0.5,45,7,1,2\n")
    recording = read(tmp_path)
    assert {*recording.aids} == {"velocity"} and [one.code for one in check_aids(recording)] == ["absent"]
    (tmp_path / "gps.csv").write_text("lat,lon,alt\n45,7,1\n45,7,2\n")
    assert any(note.startswith("left out: ") and "column t_s is missing" in note for note in read(tmp_path).origin.notes)


def test_what_stands_in_a_log_of_android_beside_the_sensors(tmp_path, motion):
    for shape, sigma, kinds in (
        (devices.gnss_logger, 3.9, {"position", "velocity"}),
        (devices.get_sensor_data, 3.9, {"position", "velocity", "pressure"}),
    ):
        recording = read(shape(tmp_path, motion))
        assert {*recording.aids} == kinds
        position, velocity = recording.aids["position"], recording.aids["velocity"]
        np.testing.assert_allclose(position.t_s[0], recording.t_s[0], atol=1e-6)
        np.testing.assert_allclose(
            [*np.degrees(position.values[0, :2]), position.values[0, 2], position.sigma[0, 0]], [48.1, 11.5, 500, sigma]
        )
        np.testing.assert_allclose(velocity.values[0, :2], [0, 1], atol=1e-12)


def test_pieces_hold_the_aids_of_their_rows(tmp_path, motion):
    n = 2**17 + 500
    t_s = np.arange(n) / 100
    path = tmp_path / "long.csv"
    rows = "".join(
        f"{t!r},0.1,{k % 7},0,0,{k % 5},9.8,{'45,7,100' if k % 100 == 0 else ',,'}\n" for k, t in enumerate(t_s.tolist())
    )
    path.write_text("t_s,gx,gy,gz,ax,ay,az,lat_deg,lon_deg,alt_m\n" + rows)
    pieces = [piece.aids["position"].t_s for piece in long_table(path)]
    np.testing.assert_array_equal(np.concatenate(pieces), t_s[::100])


def nmea(text):
    check = 0
    for c in text:
        check ^= ord(c)
    return f"${text}*{check:02X}\n"


def sentences(seconds, stamp="", date="100224"):
    for s, (lat, lon, height), (vn, ve, _) in zip(seconds, PLACE_DEG, VELOCITY):
        time = f"{int(s // 3600) % 24:02d}{int(s // 60) % 60:02d}{s % 60:05.2f}"
        at = f"{int(lat):02d}{60 * (lat % 1):09.6f},N,{int(-lon):03d}{60 * (-lon % 1):09.6f},W"
        prefix = stamp.format(s)
        yield prefix + nmea(f"GPGGA,{time},{at},1,08,1.5,{height - 30:.3f},M,30.000,M,,")
        yield prefix + nmea(
            f"GNRMC,{time},A,{at},{np.hypot(vn, ve) * 3600 / 1852:.6f},{np.degrees(np.arctan2(ve, vn)) % 360:.6f},{date},,"
        )


def test_sentences_of_a_receiver(tmp_path):
    path = tmp_path / "receiver.log"
    # Across midnight, with a line that was cut off and one with a wrong checksum.
    path.write_text(
        "".join([*sentences(86400 - 0.6 + FIX_S * 4)]) + "$GPGGA,12\n$GPGGA,000001.00,4530.0,N,00700.0,E,1,08,1,1,M,0,M,,*00\n"
    )
    aids = read_aids(path)
    begin_s = 1707523200 + 86400 - 0.6
    np.testing.assert_allclose(aids["position"].t_s, begin_s + 4 * FIX_S)
    np.testing.assert_allclose(aids["velocity"].t_s, begin_s + 4 * FIX_S)
    np.testing.assert_allclose(np.degrees(aids["position"].values[:, :2]), PLACE_DEG[:, :2], atol=1e-7)
    np.testing.assert_allclose(aids["position"].values[:, 2], PLACE_DEG[:, 2])
    np.testing.assert_allclose(aids["velocity"].values[:, :2], VELOCITY[:, :2], atol=1e-5)
    np.testing.assert_allclose(aids["position"].sigma, [[3, 3, 4.5]] * 3)
    assert repr(aids["position"]).startswith("AidSamples(3 of 3 numbers; 17076096")
    with pytest.raises(RecordingError, match="satellites alone.*--gnss"):
        read(path)
    # A logger's own time, before each sentence.
    path.write_text("".join(sentences(FIX_S, "{:.3f} ")))
    np.testing.assert_allclose(read_aids(path)["position"].t_s, FIX_S)
    path.write_text(nmea("GPGGA,120000,,,,,0,00,,,M,,M,,"))
    with pytest.raises(RecordingError, match="no sentence GGA or RMC with a fix"):
        read_aids(path)


def test_logs_of_px4(tmp_path, motion):
    pytest.importorskip("pyulog")
    gps = "uint64_t timestamp;int32_t lat;int32_t lon;int32_t alt;int32_t alt_ellipsoid;float s_variance_m_s;float eph;float epv;" \
          "float vel_n_m_s;float vel_e_m_s;float vel_d_m_s;uint8_t fix_type;bool vel_ned_valid;"  # fmt: skip
    bodies = [
        struct.pack(
            "<Qiiiifff3fB?", round(1e6 * t), round(1e7 * lat), round(1e7 * lon), 0, round(1e3 * h), 0.3, 1.2, 2.4, *v, 3, True
        )
        for t, (lat, lon, h), v in zip(FIX_S, PLACE_DEG, VELOCITY)
    ]
    bodies.append(struct.pack("<Qiiiifff3fB?", 900_000, 10, 10, 0, 0, 9, 9, 9, 0, 0, 0, 1, False))
    air = ("uint64_t timestamp;float baro_pressure_pa;", [struct.pack("<Qf", 200_000, 98500.0)])
    recording = read(recorded.ulog(tmp_path, motion, {"vehicle_gps_position": (gps, bodies), "vehicle_air_data": air}))
    assert_fixes(recording.aids)
    np.testing.assert_allclose(recording.aids["position"].sigma, [[1.2, 1.2, 2.4]] * 3, rtol=1e-6)
    np.testing.assert_array_equal(recording.aids["pressure"].values, [[98500]])


@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_fixes_of_ros(tmp_path, motion, kind):
    pytest.importorskip("rosbags")
    fixes = [(t, 0, *place) for t, place in zip(FIX_S, PLACE_DEG.tolist())] + [(0.7, -1, 0.0, 0.0, 0.0)]
    path = recorded.bag(tmp_path, motion, kind, fixes)
    aids = read(path).aids
    assert_fixes({"position": aids["position"]}, recorded.EPOCH_NS * 1e-9)
    np.testing.assert_array_equal(aids["position"].sigma, [[1, 2, 3]] * 3)
    assert list(read_aids(path)) == ["position"]
    with pytest.raises(RecordingError, match="no such topic of sensor_msgs/msg/NavSatFix, but /fix"):
        read_aids(path, columns={"gnss": "/other"})


def test_a_phone_export_holds_its_location(tmp_path, motion):
    path = recorded.sensor_logger(tmp_path, motion)
    header = "time,seconds_elapsed,bearingAccuracy,speedAccuracy,verticalAccuracy,horizontalAccuracy,speed,bearing,altitude,longitude,latitude\n"
    rows = [
        f"{recorded.EPOCH_NS + round(1e9 * t)},{t},1,0.5,4,3,{np.hypot(*v[:2]):.9f},{np.degrees(np.arctan2(v[1], v[0])) % 360:.9f},{h},{lon},{lat}\n"
        for t, (lat, lon, h), v in zip(FIX_S, PLACE_DEG.tolist(), VELOCITY.tolist())
    ]
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("Location.csv", header + "".join(rows))
        archive.writestr("Barometer.csv", "time,seconds_elapsed,relativeAltitude,pressure\n1,0.1,0,985\n2,0.2,0,985.1\n")
    recording = read(path)
    assert_fixes(recording.aids, down=False)
    np.testing.assert_array_equal(recording.aids["position"].sigma, [[3, 3, 4]] * 3)
    np.testing.assert_allclose(recording.aids["pressure"].values, [[98500], [98510]])


def test_fixes_that_are_held_between_are_noticed_and_dropped(tmp_path, motion):
    held = np.minimum((motion.t_s // 0.2).astype(int), 2)
    columns = [motion.t_s, *recorded.columns(motion)[:6], *PLACE_DEG[held].T]
    path = recorded.write_rows(tmp_path / "held.csv", "t_s,gx,gy,gz,ax,ay,az,lat_deg,lon_deg,alt_m", columns)
    (finding,) = check_aids(read(path))
    assert (finding.code, finding.argument, finding.value) == ("repeated", "drop_repeats", "yes")
    kept = read(path, drop_repeats=True)
    assert len(kept.aids["position"].t_s) == 3 and not check_aids(kept)


def ulog_with_pressure(tmp_path, motion):
    pytest.importorskip("pyulog")
    bodies = [struct.pack("<Qf", 1_000_000 + 10_000 * i, 95e3) for i in range(100)]
    return recorded.ulog(tmp_path, motion, {"vehicle_air_data": ("uint64_t timestamp;float baro_pressure_pa;", bodies)})


def damages(path):
    return [finding.message for finding in read(path).check() if finding.code == "damaged"]


def test_a_log_that_was_cut_off_says_so(tmp_path, motion):
    path = ulog_with_pressure(tmp_path, motion)
    assert damages(path) == []
    whole = path.read_bytes()
    path.write_bytes(whole[:-5])
    (said,) = damages(path)
    assert said.startswith("the log was cut off within its last message") and "samples were read of sensor_combined" in said


def test_a_log_with_foreign_bytes_says_where_and_what_is_missing(tmp_path, motion):
    path = ulog_with_pressure(tmp_path, motion)
    whole = path.read_bytes()
    begin = whole.rindex(struct.pack("<HBH", 14, ord("D"), 2))  # the last pressure
    path.write_bytes(whole[:begin] + bytes(range(200, 217)) + whole[begin + 17 :])
    (said,) = damages(path)
    assert said.startswith(f"the log is damaged at byte {begin} of {len(whole)}, and messages are lost")
    first = whole.index(struct.pack("<HBH", 14, ord("D"), 2))
    path.write_bytes(whole[:first] + 5 * bytes(range(200, 217)))
    (said,) = damages(path)
    assert said.endswith("and none of vehicle_air_data") and re.search(r"samples were read of sensor_combined \d+", said)


def datum_notes(aids):
    rows_s = aids["position"].t_s[[0, -1]] + [0, 1]
    return [one.code for one in check_aids(Recording("x", rows_s, np.zeros((2, 3)), np.zeros((2, 3)), aids=aids))]


@pytest.mark.parametrize("name, above_sea", [
    ("alt_m", False), ("hMSL", True), ("altitude (msl)", True), ("height_ellipsoid", False), ("Altitude WGS84 (m)", False),
])  # fmt: skip
def test_a_name_that_says_above_sea_level_is_noted(tmp_path, name, above_sea):
    path = tmp_path / "fixes.csv"
    path.write_text(f"t_s,lat_deg,lon_deg,{name}\n" + "".join(f"{t},45,7,100\n" for t in range(5)))
    aids = read_aids(path)
    assert aids["position"].above_sea == above_sea and datum_notes(aids) == ["datum"] * above_sea


def test_the_height_above_the_ellipsoid_goes_first(tmp_path):
    path = tmp_path / "fixes.csv"
    path.write_text("t_s,lat_deg,lon_deg,hMSL,Altitude WGS84 (m)\n" + "".join(f"{t},45,7,100,147\n" for t in range(5)))
    position = read_aids(path)["position"]
    np.testing.assert_array_equal(position.values[:, 2], 147)
    assert not position.above_sea


@pytest.mark.parametrize("geoid, height, above_sea", [("47.0", 547.0, False), ("", 500.0, True)])
def test_the_height_of_the_geoid_in_a_sentence_and_in_a_track_converts(tmp_path, geoid, height, above_sea):
    sentence, track = tmp_path / "receiver.nmea", tmp_path / "track.gpx"
    sentence.write_text("".join(nmea(f"GPGGA,12000{s}.00,4530.0,N,00700.0,E,1,08,1,500.0,M,{geoid},M,,") for s in range(3)))
    inner = f"<geoidheight>{geoid}</geoidheight>" if geoid else ""
    points = [f'<trkpt lat="45.5" lon="7"><ele>500</ele><time>2024-02-10T12:00:0{s}Z</time>{inner}</trkpt>' for s in range(3)]
    track.write_text(f'<gpx version="1.1"><trk><trkseg>{"".join(points)}</trkseg></trk></gpx>')
    for path in (sentence, track):
        position = read_aids(path)["position"]
        np.testing.assert_array_equal(position.values[:, 2], height)
        assert position.above_sea == above_sea and datum_notes({"position": position}) == ["datum"] * above_sea


@pytest.mark.parametrize("undulation, height", [(-47.5, 547.5), (0.0, 500.0)])
def test_ardupilot_states_the_height_above_sea_less_that_above_the_ellipsoid(tmp_path, motion, undulation, height):
    pytest.importorskip("pymavlink")
    path = devices.ardupilot_text(tmp_path, motion)
    lines = [
        "FMT, 131, 50, GPS, QBBIHBLLffff, TimeUS,I,Status,GMS,GWk,NSats,Lat,Lng,Alt,Spd,GCrs,VZ",
        "FMT, 132, 30, GPA, QBfffff, TimeUS,I,VDop,HAcc,VAcc,SAcc,Und",
    ]
    for i in range(1, 4):
        lines.append(
            f"GPS, {1_000_000 + 200_000 * i}, 0, 3, {381_600_000 + 200 * i}, 2399, 15, 48.1, 11.5, 500.0, 0.1, 90.0, 0.0"
        )
        lines.append(f"GPA, {1_000_000 + 200_000 * i}, 0, 1.2, 1.5, 2.5, 0.15, {undulation}")
    path.write_text(path.read_text() + "\n".join(lines) + "\n")
    position = read(path).aids["position"]
    np.testing.assert_allclose(position.values[:, 2], height)
    assert position.above_sea == (undulation == 0)


NAV_SAT_FIX = ["Time", "status.status", "latitude", "longitude", "altitude", *(f"position_covariance_{i}" for i in range(9))]


@pytest.mark.parametrize(
    "name, cells, kept",
    [
        ("fix_type", ["0", "1", "2", "3", "6"], [2, 3, 4]),
        ("fix_type", ["0", "1", "1", "", "1"], [1, 2, 3, 4]),
        ("fixType", ["3", "0", "", "4", "5"], [0, 2, 3, 4]),
        ("gps_fix_type", ["No fix", "3D", "RTK fixed", "none", "float"], [1, 2, 4]),
        ("fix", ["0", "1", "2", "4", "5"], [1, 2, 3, 4]),
        ("fix_quality", ["0", "1", "no_fix", "2D", "GPS_FIX_TYPE_NO_FIX"], [1, 3]),
        ("status.status", ["-1", "0", "1", "2", "-1"], [1, 2, 3]),
    ],
)
@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_rows_that_state_no_fix_are_left_out_and_counted(tmp_path, name, cells, kept, kind):
    path = tmp_path / f"fixes.{kind}"
    rows = [f"{k},45,7,{100 + k},1,0,{cell}" for k, cell in enumerate(cells)]
    text = "\n".join([f"t_s,lat_deg,lon_deg,alt_m,vn,ve,{name}", *rows]) + "\n"
    if kind == "csv":
        path.write_text(text)
    else:
        pandas = pytest.importorskip("pandas")
        pandas.read_csv(io.StringIO(text)).to_parquet(path)
    aids = read_aids(path)
    for one in ("position", "velocity"):
        np.testing.assert_array_equal(aids[one].t_s, kept)
    assert sum(note.endswith(f"left out: {len(cells) - len(kept)}") for note in aids.notes) == 1


def test_fixes_of_bagpy_have_their_status_and_covariance(tmp_path):
    path = tmp_path / "fix.csv"
    rows = [
        (k, status, 48, 11.5, 500, 4, 0, 0, 0, 9, 0, 0, 0, 25, kind) for k, status, kind in ((0, 0, 2), (1, -1, 2), (2, 0, 0))
    ]
    lines = [[*NAV_SAT_FIX, "position_covariance_type"], *rows]
    path.write_text("\n".join(",".join(map(str, line)) for line in lines) + "\n")
    position = read_aids(path, time_unit="s")["position"]
    np.testing.assert_array_equal(position.t_s, [0, 2])
    np.testing.assert_array_equal(position.sigma, [[3, 2, 5], [np.nan] * 3])
