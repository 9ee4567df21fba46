"""hnav live: every kind of source, recorded and filtered again to the same numbers; faults are counted; the page."""

from __future__ import annotations

import csv
import json
import os
import random
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import recorded
from browser import Tab
from command_line import hnav
from driven import as_recording
from motion import tilted_motion
from studies.ins.vehicles import vehicle

LOCAL = "127.0.0.1"
DEADLINE_S = 40


@pytest.fixture(scope="module")
def lines(tmp_path_factory) -> list[str]:
    """Of a table in deg/s, g and uT: the header, and eight seconds at 100 Hz."""
    path = recorded.x_io(tmp_path_factory.mktemp("lines"), tilted_motion(8).recording)
    return path.read_text().splitlines()


class Session:
    """hnav live in a process of its own."""

    def __init__(self, folder: Path, source: str, *options: object, stdin: object = subprocess.DEVNULL):
        self.record, self._out, self._err = folder / "live.csv", folder / "out", folder / "err"
        command = [sys.executable, "-m", "hnav", "live", source, "--record", self.record, *options]
        with self._out.open("w") as out, self._err.open("w") as err:
            self.process = subprocess.Popen([str(part) for part in command], stdin=stdin, stdout=out, stderr=err)

    @property
    def said(self) -> str:
        return self._err.read_text()

    @property
    def answers(self) -> list[str]:
        return self._out.read_text().splitlines()

    def wait_for(self, holds, what: str):
        end_s = time.monotonic() + DEADLINE_S
        while not (found := holds()):
            assert time.monotonic() < end_s and self.process.poll() is None, f"{what}: {self.said}"
            time.sleep(0.02)
        return found

    def wait_for_rows(self, n: int) -> None:
        self.wait_for(lambda: self.record.exists() and self.record.read_text().count("\n") > n, f"{n} rows")

    def end(self) -> dict[str, int]:
        """Ctrl-C; the counts of the last line."""
        self.process.send_signal(signal.SIGINT)
        assert self.process.wait(timeout=DEADLINE_S) == 0, self.said
        return {name: int(n) for name, n in re.findall(r"([a-z][a-z ]*) (\d+)", self.said.splitlines()[-1])}

    def check_same_numbers(self, folder: Path, *options: object) -> int:
        """The table of hnav filter for the recording as text, and its number of rows."""
        table = folder / "again.csv"
        done = hnav("filter", self.record, "--out", table, "--force", *options)
        assert done.returncode == 0, done.stderr
        rows = list(csv.DictReader(line for line in table.read_text().splitlines() if not line.startswith("#")))
        found = [json.loads(line, parse_float=str, parse_int=str) for line in self.answers]
        assert [{name: "nan" if cell is None else cell for name, cell in row.items()} for row in found] == rows
        return len(rows)


@contextmanager
def session(folder: Path, source: str, *options: object, **more: object):
    live = Session(folder, source, *options, **more)
    try:
        yield live
    finally:
        live.process.kill()
        live.process.wait()


def free_port(kind: int = socket.SOCK_DGRAM) -> int:
    with socket.socket(socket.AF_INET, kind) as here:
        here.bind((LOCAL, 0))
        return here.getsockname()[1]


def listened(live: Session) -> set[str]:
    """Addresses, in hexadecimal as /proc has them, at which the process takes connections and datagrams."""
    inodes = set()
    for descriptor in Path(f"/proc/{live.process.pid}/fd").iterdir():
        try:
            inodes |= set(re.findall(r"socket:\[(\d+)\]", os.readlink(descriptor)))
        except FileNotFoundError:
            continue
    found = set()
    for table in ("tcp", "tcp6", "udp", "udp6"):
        for row in Path(f"/proc/{live.process.pid}/net/{table}").read_text().splitlines()[1:]:
            _, local, _, state, *cells = row.split()
            if cells[5] in inodes and state in ("0A", "07"):  # listens; a socket of datagrams
                found.add(local.split(":")[0])
    return found


def test_standard_input(tmp_path, lines):
    text = tmp_path / "in.csv"
    text.write_text("\n".join(["boot 1.2", *lines]) + "\n")
    with text.open() as stdin, session(tmp_path, "-", stdin=stdin) as live:
        assert live.process.wait(timeout=DEADLINE_S) == 0
    assert live.check_same_numbers(tmp_path) == 800
    assert "lines 802, rows 800, no sample 1" in live.said and "boot 1.2" in live.said
    # The same as of the file itself.
    whole = tmp_path / "whole.csv"
    hnav("filter", text, "--out", whole, "--columns", "t_s=Time (s)")
    assert whole.read_text().splitlines()[-1].split(",")[1] == json.loads(live.answers[-1], parse_float=str)["q0"]


def test_a_stream_without_a_magnetometer_has_no_column_to_look_at(tmp_path, lines):
    without = tmp_path / "in.csv"
    without.write_text("\n".join(",".join(line.split(",")[:7]) for line in lines) + "\n")
    with without.open() as stdin, session(tmp_path, "-", stdin=stdin) as live:
        assert live.process.wait(timeout=DEADLINE_S) == 0
    assert "rows 800" in live.said and "warning" not in live.said
    assert json.loads(live.answers[-1])["heading_ready"] == 0


def test_serial_port(tmp_path, lines):
    pytest.importorskip("serial", reason="pyserial is not installed")
    device, port = os.openpty()
    with session(tmp_path, os.ttyname(port), "--baud", 921600) as live:
        live.wait_for(lambda: "opened" in live.said, "the start")
        os.write(device, b",0.1,9.8\xff\xfe\n" + lines[0].encode() + b"\r\n")  # the middle of a line comes first
        for line in lines[1:]:
            os.write(device, line.encode() + b"\r\n")
        live.wait_for_rows(800)
        counts = live.end()
    assert counts["rows"] == live.check_same_numbers(tmp_path) == 800 and counts["no sample"] == 1


def test_udp_of_json_to_udp(tmp_path, lines):
    port = free_port()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        client.bind((LOCAL, 0))
        client.settimeout(DEADLINE_S)
        to = f"udp://{LOCAL}:{client.getsockname()[1]}"
        with session(tmp_path, f"udp://:{port}", "--to", to, "--gyro-unit", "deg/s", "--accel-unit", "g") as live:
            live.wait_for(lambda: ": opened" in live.said, "the start")
            answers: list[dict] = []
            reader = threading.Thread(
                target=lambda: answers.extend(json.loads(client.recv(4096)) for _ in range(800)), daemon=True
            )
            reader.start()
            for i, line in enumerate(lines[1:]):
                if i > 60:  # no more than the kernel keeps
                    live.wait_for(lambda least=i - 55: len(answers) > least, "the answers")
                t_s, *values = map(float, line.split(","))
                sample = {"t": t_s, "gyro": values[:3], "accel": dict(zip("xyz", values[3:6])), "mag": values[6:]}
                client.sendto(json.dumps(sample).encode(), (LOCAL, port))
                time.sleep(0.0002)
            live.wait_for_rows(800)
            reader.join(timeout=DEADLINE_S)
            assert listened(live) == {"0100007F"}
            live.end()
    assert [one["t_s"] for one in answers] == [float(line.split(",")[0]) for line in lines[1:]]
    assert answers[-1]["mag_health"] == 0 and live.answers == []


def test_tcp_that_breaks_off_and_comes_back(tmp_path, lines):
    with socket.create_server((LOCAL, 0)) as server:
        server.settimeout(DEADLINE_S)
        with session(tmp_path, f"tcp://{LOCAL}:{server.getsockname()[1]}") as live:
            connection, _ = server.accept()
            with connection:
                connection.sendall("\n".join(lines[:401]).encode() + b"\n12.5,1.0")  # and half a line
            live.wait_for_rows(400)
            connection, _ = server.accept()
            with connection:
                connection.sendall("\n".join([lines[0], *lines[401:]]).encode() + b"\n")
                live.wait_for_rows(800)
                counts = live.end()
    assert live.check_same_numbers(tmp_path) == 800
    assert counts["opened"] == 2 and counts["cut off"] == 1 and "closed by the other side; trying again" in live.said


def test_a_clock_that_restarts_and_a_source_that_stalls(tmp_path, lines):
    port = free_port()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client, session(tmp_path, f"udp://{LOCAL}:{port}") as live:
        live.wait_for(lambda: ": opened" in live.said, "the start")

        def send(some: list[str]) -> None:
            for line in some:
                client.sendto(line.encode(), (LOCAL, port))
                time.sleep(0.0005)

        send([lines[0], *lines[1:601]])
        live.wait_for(lambda: "nothing came for 2 s" in live.said, "the stall")
        send(lines[1:201])
        send([lines[150], lines[200]])  # a late and a repeated line
        live.wait_for_rows(800)
        live.wait_for(lambda: "goes on after" in live.said, "the end of the stall")
        time.sleep(0.2)
        counts = live.end()
    assert counts["rows"] == live.check_same_numbers(tmp_path) == 800
    assert counts["clock set"] == 1 and counts["stalls"] == 1 and counts["late"] == 2
    assert "the clock of the source was set by -5.99" in live.said


def test_mavlink(tmp_path):
    mavutil = pytest.importorskip("pymavlink.mavutil", reason="pymavlink is not installed")
    port, r = free_port(), tilted_motion(2).recording
    with session(tmp_path, f"mavlink:udpin:{LOCAL}:{port}") as live:
        live.wait_for(lambda: ": opened" in live.said, "the start")
        link = mavutil.mavlink_connection(f"udpout:{LOCAL}:{port}", source_system=1)
        for i, t_s in enumerate(r.t_s):
            rate, force, field = r.rate_b_rad_s[i], r.force_b_m_s2[i], 1e4 * r.field_b_tesla[i]
            link.mav.highres_imu_send(
                round(1e6 * t_s) + 1000, *force, *rate, *field, 0, 0, 0, 0, 0x3F | (0x1C0 if i % 4 == 0 else 0)
            )
            link.mav.heartbeat_send(2, 3, 0, 0, 0)
            time.sleep(0.004)  # the buffer of a socket holds half a second of lines
        live.wait_for_rows(len(r.t_s))
        live.end()
        link.close()
    assert live.check_same_numbers(tmp_path) == len(r.t_s)
    rows = [row.split(",") for row in live.record.read_text().splitlines()[1:]]
    assert float(rows[0][4]) == pytest.approx(r.force_b_m_s2[0, 0], rel=1e-6)
    assert float(rows[0][7]) == pytest.approx(r.field_b_tesla[0, 0], rel=1e-6)
    assert [row[7] == "" for row in rows[:5]] == [False, True, True, True, False]


@pytest.fixture(scope="module")
def drive():
    """A car with satellites, pressure and wheels, 25 s at 100 Hz, industrial sensors."""
    return as_recording(vehicle("car", "industrial", 11, 25.0)[0])


INS = ("--filter", "ins", "--preset", "industrial")


def cells(values) -> str:
    return ",".join("" if value is None else repr(float(value)) for value in values)


def lines_of_drive(drive, fix, empty: str = "") -> list[str]:
    """A line for each row, and after those that came before a fix the lines that fix(i) makes of it."""
    lines, due = [], np.searchsorted(drive.t_s, drive.aids["position"].t_s)
    for row, t_s in enumerate(drive.t_s):
        lines.append(cells([t_s, *drive.rate_b_rad_s[row], *drive.force_b_m_s2[row]]) + empty)
        lines += [line for i in np.flatnonzero(due == row) for line in fix(i)]
    return lines


def fix_of(drive, i: int) -> tuple[list[float], list[float]]:
    """Latitude and longitude in deg, height in m; velocity."""
    latitude, longitude, height = drive.aids["position"].values[i].tolist()
    return [np.degrees(latitude), np.degrees(longitude), height], drive.aids["velocity"].values[
        min(i, len(drive.aids["velocity"].t_s) - 1)
    ].tolist()


def sentence(text: str) -> str:
    check = 0
    for c in text.encode():
        check ^= c
    return f"${text}*{check:02X}"


def sentences(drive, i: int) -> list[str]:
    """GGA and RMC; GSV and GST have neither place nor velocity."""
    (latitude, longitude, height), (north, east, _) = fix_of(drive, i)
    clock = f"1200{i % 60:02d}.00"
    angles = [
        f"{int(abs(a)):0{width}d}{60 * (abs(a) % 1):010.7f},{side[int(a < 0)]}"
        for a, width, side in ((latitude, 2, "NS"), (longitude, 3, "EW"))
    ]
    speed, course = np.hypot(north, east) * 3600 / 1852, np.degrees(np.arctan2(east, north)) % 360
    return [
        sentence(f"GPGGA,{clock},{','.join(angles)},4,12,0.8,{height:.3f},M,0.0,M,,"), sentence("GPGSV,1,1,00"),
        sentence(f"GPRMC,{clock},A,{','.join(angles)},{speed:.4f},{course:.3f},010126,,"), sentence(f"GPGST,{clock},1,,,,1.5,1.5,3.0"),
    ]  # fmt: skip


def navigated(live: Session, folder: Path, rows: int) -> pd.DataFrame:
    """The estimates, which equal those of the recording and are close to the true position."""
    assert live.check_same_numbers(folder, *INS) == rows
    found = pd.DataFrame([json.loads(line) for line in live.answers])
    assert found["tilt_ready"].iloc[-1] == 1 and found["sigma_north"].iloc[-1] < 5
    return found


def test_the_ins_by_columns_json_and_sentences(tmp_path, drive):
    header = "t_s,gx,gy,gz,ax,ay,az"

    def as_columns(i: int) -> list[str]:
        place, velocity = fix_of(drive, i)
        return [cells([drive.aids["position"].t_s[i] + (0.009 if i % 2 else 0.0), *[None] * 6, *place, *velocity, 1.5, 101325])]

    def as_json(i: int) -> list[str]:
        (latitude, longitude, height), (north, east, down) = fix_of(drive, i)
        return [
            json.dumps({"gps": {"lat": latitude, "lon": longitude, "alt": height, "vel_n": north, "vel_e": east, "vel_d": down}})
        ]

    ends = []
    for name, first, fix in (
        ("columns", f"{header},lat_deg,lon_deg,alt_m,vn,ve,vd,sigma_h,baro_pa", as_columns), ("json", header, as_json), ("nmea", header, lambda i: sentences(drive, i)),
    ):  # fmt: skip
        (folder := tmp_path / name).mkdir()
        text = folder / "in.csv"
        text.write_text("\n".join([first, *lines_of_drive(drive, fix, "," * (first.count(",") - 6))]) + "\n")
        with text.open() as stdin, session(folder, "-", *INS, stdin=stdin) as live:
            assert live.process.wait(timeout=DEADLINE_S) == 0, live.said
        rows = len(drive.t_s) + (len(drive.aids["position"].t_s) // 2 if name == "columns" else 0)
        ends.append(navigated(live, folder, rows).iloc[-1])
        assert "no sample" not in live.said and ("other sentences 250" in live.said) == (name == "nmea"), live.said
    for end in ends:
        assert abs(end["lat_deg"] - ends[0]["lat_deg"]) < 5e-5 and abs(end["vn"] - ends[0]["vn"]) < 1


def test_the_ins_by_mavlink(tmp_path, drive):
    mavutil = pytest.importorskip("pymavlink.mavutil", reason="pymavlink is not installed")
    port = free_port()
    due = np.searchsorted(drive.t_s, drive.aids["position"].t_s)
    with session(tmp_path, f"mavlink:udpin:{LOCAL}:{port}", *INS) as live:
        live.wait_for(lambda: ": opened" in live.said, "the start")
        link = mavutil.mavlink_connection(f"udpout:{LOCAL}:{port}", source_system=1)
        for row, t_s in enumerate(drive.t_s):
            link.mav.highres_imu_send(
                round(1e6 * t_s) + 1000, *drive.force_b_m_s2[row], *drive.rate_b_rad_s[row], 0, 0, 0, 1013.25, 0, 0, 0, 0x23F
            )
            for i in np.flatnonzero(due == row):
                (latitude, longitude, height), (north, east, _) = fix_of(drive, i)
                course = round(100 * np.degrees(np.arctan2(east, north))) % 36000
                of_fix = (
                    round(1e7 * latitude),
                    round(1e7 * longitude),
                    round(1e3 * height),
                    80,
                    120,
                    round(100 * np.hypot(north, east)),
                    course,
                    12,
                )
                link.mav.gps_raw_int_send(0, 1, *of_fix)  # without a fix
                link.mav.gps_raw_int_send(0, 3, *of_fix)
            if row % 50 == 49:  # no more than the kernel keeps
                live.wait_for_rows(row - 50)
        live.wait_for_rows(len(drive.t_s))
        live.end()
        link.close()
    found = navigated(live, tmp_path, len(drive.t_s))
    assert abs(found["lat_deg"].iloc[-1] - np.degrees(drive.aids["position"].values[-1, 0])) < 5e-5
    fixes = pd.read_csv(live.record)
    assert fixes["lat_deg"].notna().sum() == len(due) and fixes["pressure_pa"].iloc[0] == pytest.approx(101325)


def test_the_ins_needs_both_inertial_sensors_in_a_line(tmp_path):
    text = tmp_path / "in.jsonl"
    rows = [
        json.dumps({"t": 0.01 * i, sensor: [0, 0, value]})
        for i in range(100)
        for sensor, value in (("gyro", 0.1), ("accel", 9.8))
    ]
    text.write_text("\n".join(rows) + "\n")
    with text.open() as stdin, session(tmp_path, "-", *INS, stdin=stdin) as live:
        assert live.process.wait(timeout=DEADLINE_S) == 2
    assert "record the samples, and filter the file" in live.said and "Traceback" not in live.said


def test_a_flood_and_garbage_lose_nothing_silently(tmp_path, lines):
    port, sent, chance = free_port(), 0, random.Random(3)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client, session(tmp_path, f"udp://{LOCAL}:{port}") as live:
        live.wait_for(lambda: ": opened" in live.said, "the start")
        values = lines[1].split(",", 1)[1]
        client.sendto(lines[0].encode(), (LOCAL, port))
        begin_s = time.monotonic()
        for i in range(10_000):
            sample = f"{i / 20_000!r},{values}".encode()
            if i % 10 == 9:
                sample = bytes(chance.choice(b'{[,:.-"x0\x00\xff\xc3') for _ in range(chance.randint(1, 80))).strip() or b"x"
            client.sendto(sample, (LOCAL, port))
            sent += 1
            while time.monotonic() < begin_s + i / 20_000:
                pass
        for i in range(3):  # what was dropped is said with what comes after it
            time.sleep(0.5)
            client.sendto(f"{10 + i},{values}".encode(), (LOCAL, port))
            sent += 1
        live.wait_for(lambda: live.record.read_text().rstrip().rsplit("\n", 1)[-1].startswith("12.0,"), "the last row")
        counts = live.end()
    assert counts["lines"] + counts.get("dropped by the system", 0) == sent + 1
    assert counts["lines"] == counts["rows"] + counts["no sample"] + counts.get("late", 0) + 1
    assert counts["rows"] == live.check_same_numbers(tmp_path)
    assert counts["rows"] > 4500 and "Traceback" not in live.said


def test_the_page_in_a_browser(tmp_path, lines):
    pytest.importorskip("websockets", reason="websockets is not installed")
    port, page = free_port(), free_port(socket.SOCK_STREAM)
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client,
        session(tmp_path, f"udp://{LOCAL}:{port}", "--page", "--port", page) as live,
    ):
        live.wait_for(lambda: "page: http://127.0.0.1" in live.said, "the page")
        tab = Tab(f"http://{LOCAL}:{page}/", tmp_path)
        try:
            for line in [lines[0], *lines[1:]]:
                client.sendto(line.encode(), (LOCAL, port))
                time.sleep(0.002)
            live.wait_for(
                lambda: "7.99 s" in str(tab.value("document.getElementById('body-says').textContent")), "the newest row"
            )
            assert re.search(r"heading \d+\.\d°", str(tab.value("document.getElementById('body-says').textContent")))
            state = str(tab.value("document.getElementById('state-rows').textContent"))
            assert "tilt ready" in state and re.search(r"gyrook, \d+ Hz", state)
            counts = str(tab.value("document.getElementById('count-rows').textContent"))
            assert "lines801" in counts and "rows800" in counts
            painted = "[...document.getElementById('heading-canvas').getContext('2d').getImageData(0, 0, 800, 200).data].some(v => v > 0)"
            assert tab.value(painted) is True
            for width in (1600, 390):
                tab.call("Emulation.setDeviceMetricsOverride", width=width, height=1400, deviceScaleFactor=1, mobile=False)
                assert tab.value("document.documentElement.scrollWidth <= innerWidth") is True
            assert listened(live) == {"0100007F"}
            live.end()
            live_lost = "document.getElementById('lost').hidden"
            end_s = time.monotonic() + DEADLINE_S
            while tab.value(live_lost) is True and time.monotonic() < end_s:
                time.sleep(0.05)
            assert tab.value(live_lost) is False
        finally:
            tab.close()


def test_another_site_may_not_read_the_page(tmp_path):
    websockets = pytest.importorskip("websockets.sync.client", reason="websockets is not installed")
    from websockets.exceptions import InvalidStatus

    from hnav.reports.live_page import LivePage

    with LivePage("-", "ahrs", port=0) as page:
        assert page.url.startswith(f"http://{LOCAL}:")
        address = f"ws://{LOCAL}:{page.port}/state"
        page.show({"t_s": 1.0})
        with websockets.connect(address, origin=f"http://{LOCAL}:{page.port}") as own:
            assert json.loads(own.recv(timeout=5)) == {"t_s": 1.0}
        for foreign in ({"origin": "http://example.org"}, {"additional_headers": {"Host": "example.org"}}):
            with pytest.raises(InvalidStatus), websockets.connect(address, **foreign):
                pass


def test_another_host_is_explicit_and_warned_of():
    pytest.importorskip("websockets", reason="websockets is not installed")
    for options, warned in (([], False), (["--host", "0.0.0.0"], True)):
        done = hnav("live", "udp://127.0.0.1:0", "--page", "--port", 0, "--seconds", 0.1, *options)
        assert done.returncode == 0 and ("whoever reaches this machine can see the page" in done.stderr) == warned


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("ftp://here",), "is no source: give a serial port"),
        ((__file__,), "is a file: hnav filter reads it, and hnav live - < FILE its lines"),
        (("/dev/no-such-port",), "is no source"),
        (("udp://127.0.0.1",), "write udp://HOST:PORT"),
        (("-", "--filter", "ins", "--frame", "enu"), "--frame with --filter ins"),
        (("-", "--to", "tcp://x:1"), "--to tcp://x:1: write udp://HOST:PORT"),
        (("-", "--format", "csv"), "--format csv"),
    ],
)
def test_what_cannot_be_done_is_one_line(arguments, said):
    done = hnav("live", *arguments)
    assert done.returncode == 2 and said in done.stderr and done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("text", "options", "said"),
    [
        ("$GPGSV,1,1,00*79\n", ["--filter", "ins"], "no line had samples of a gyroscope and an accelerometer"),
        (
            "t_s,gx,gy,gz,ax,ay,az\n0,0,0,0,0,0,-9.8\n0.01,0,0,0,0,0,-9.8\n",
            ["--filter", "ins"],
            "no position of satellites was used",
        ),
    ],
)
def test_what_is_missing_is_said_at_the_end(tmp_path, text, options, said):
    file = tmp_path / "lines.txt"
    file.write_text(text)
    with file.open() as stdin, session(tmp_path, "-", *options, stdin=stdin) as live:
        assert live.process.wait(timeout=DEADLINE_S) == 0
    assert said in live.said and live.said.count("warning") == 1
    done = hnav("live", file)
    assert done.returncode == 2 and "lines.txt: is a file: hnav filter reads it" in done.stderr


def test_a_recording_is_not_overwritten(tmp_path):
    (tmp_path / "old.csv").write_text("mine\n")
    done = hnav("live", "udp://127.0.0.1:0", "--record", tmp_path / "old.csv", "--seconds", 0.1)
    assert done.returncode == 2 and "it exists already" in done.stderr and (tmp_path / "old.csv").read_text() == "mine\n"


def test_lines_without_a_sensor_end_in_one_line(tmp_path):
    text = tmp_path / "in.csv"
    text.write_text("t_s,gx,gy,gz,mx,my,mz\n0,1,2,3,4,5,6\n")
    with text.open() as stdin, session(tmp_path, "-", stdin=stdin) as live:
        assert live.process.wait(timeout=DEADLINE_S) == 2
    assert (
        "the column ax is missing" in live.said
        and "nothing of the accel: record gyroscope and accelerometer together" in live.said
    )
