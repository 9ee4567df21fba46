"""Readers of files that others wrote, under damage of every kind: the result is complete, or the error states the reason.

HNAV_FUZZ_EXAMPLES=20000 tries harder than the default, --all a little.
"""

import contextlib
import json
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io
from hypothesis import example, given, settings
from hypothesis import strategies as st

import apart
import devices
import recorded
from fuzzing import bounded, damaged, json_values, places
from hnav.errors import HnavError
from hnav.filters.ins import Ins
from hnav.io.aids import AIDS
from hnav.io.readers import read, read_aids
from hnav.io.recordings import Recording, RecordingError
from hnav.systems.aircraft import models_folder, read_aircraft
from motion import tilted_motion
from twins.aircraft import inputs, noise_factors

bounded_shape = settings(bounded, max_examples=max(1, bounded.max_examples // 2))
# MATLAB files are read in a process of their own, which takes a second on a busy machine.
bounded_mat = settings(bounded, max_examples=max(1, bounded.max_examples // 6))

NUMBERS = [
    "0",
    "-0",
    "1",
    "nan",
    "inf",
    "-inf",
    "1e400",
    "1e-400",
    "0x10",
    "1_000",
    "1,5",
    "",
    " ",
    "abc",
    "٣",
    "\x00",
    '"',
    "1e",
    "--1",
]
HEADER = "t_s,gx,gy,gz,ax,ay,az,mx,my,mz"


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("fuzz")


def is_whole(recording: Recording) -> None:
    """Asserts the invariants of a recording."""
    n = len(recording.t_s)
    assert n > 0 and recording.t_s.shape == (n,)
    assert np.isfinite(recording.t_s).all() and (np.diff(recording.t_s) > 0).all()
    columns = {"rate_b_rad_s": 3, "force_b_m_s2": 3, "field_b_tesla": 3, "reference_q_nb": 4}
    for name, width in columns.items():
        value = getattr(recording, name)
        assert value is None or (value.shape == (n, width) and value.dtype == float), name
    assert recording.movement is None or recording.movement.shape == (n,)


def read_or_say_why(path: Path) -> None:
    try:
        recording = read(path)
    except RecordingError as error:
        assert path.name in str(error) and "\n" not in str(error)
    else:
        is_whole(recording)


# --------------------------------------------------------------------------------------------- CSV

cells = st.one_of(st.sampled_from(NUMBERS), st.floats().map(repr), st.text(max_size=4))
rows = st.lists(st.lists(cells, min_size=8, max_size=11), max_size=4)


@bounded
@given(
    header=st.one_of(st.just(HEADER.split(",")), st.lists(st.sampled_from(HEADER.split(",") + ["", "x", "\ufeff"]), max_size=12)),
    rows=rows,
)
@example(header=HEADER.split(","), rows=[['"', *"0" * 7], ["0", '"', *"0" * 7, "1,5"]])  # a quoted cell over two lines
def test_a_csv_of_any_cells_is_read_whole_or_refused(folder, header, rows):
    path = folder / "cells.csv"
    path.write_text("\n".join(",".join(row) for row in [header, *rows]) + "\n", encoding="utf-8", errors="replace")
    read_or_say_why(path)


@bounded
@given(seed=st.integers(0, 2**32))
def test_a_damaged_csv_is_read_whole_or_refused(folder, seed):
    path = folder / "damaged.csv"
    good = HEADER + "\n" + "".join(f"{0.01 * k:.2f},0.1,0.2,0.3,0,0,-9.81,2e-5,0,4e-5\n" for k in range(5))
    path.write_bytes(damaged(good.encode(), seed))
    read_or_say_why(path)


# --------------------------------------------------------------------------------------------- satellites

GNSS = "t_s,received_s,lat_deg,lon_deg,alt_m,vn,ve,vd,sigma_h,sigma_v,sigma_vel,pressure_pa,speed_m_s,speed,course,antenna_heading_deg,accHeading"
NMEA = (
    "$GPRMC,120000.00,A,4530.0000,N,00700.0000,E,10.0,90.0,100224,,*28\n$GPGGA,120000.00,4530.0000,N,00700.0000,E,1,08,1.5,400.0,M,48.0,M,,\n"
    "1.5,$GNGST,120000.00,,,,,1.0,2.0,3.0\n$GPGGA,120001.00,4530.0010,N,00700.0000,E,1,08,1.5,400.0,M,48.0,M,,\n"
)


def navigate_or_say_why(path: Path) -> None:
    """Aiding samples are complete, and a filter accepts them."""
    try:
        aids = read_aids(path)
    except RecordingError as error:
        assert path.name in str(error) and "\n" not in str(error)
        return
    for kind, one in aids.items():
        n, width = len(one.t_s), len(AIDS[kind])
        assert n > 0 and one.values.shape == one.sigma.shape == (n, width) and (np.diff(one.arrived_s) >= 0).all()
        assert np.isfinite(one.t_s).all() and np.isfinite(one.values[:, : min(width, 2)]).all()
        assert not (one.sigma <= 0).any()
    times = aids[next(iter(aids))].t_s
    t_s = times[0] + 0.01 * np.arange(20)
    if (np.diff(t_s) > 0).all() and abs(t_s[0]) < 1e9:
        still = np.zeros((20, 3))
        with contextlib.suppress(HnavError):
            Ins().run_recording(Recording("still", t_s, still, still + [0, 0, -9.8], aids=aids))


@bounded
@given(rows=st.lists(st.lists(cells, min_size=16, max_size=18), max_size=4), columns=st.permutations(GNSS.split(",")))
def test_satellites_of_any_cells_are_read_whole_or_refused(folder, rows, columns):
    path = folder / "gnss.csv"
    path.write_text("\n".join(",".join(row) for row in [columns, *rows]) + "\n", encoding="utf-8", errors="replace")
    navigate_or_say_why(path)


@bounded
@given(seed=st.integers(0, 2**32), sentences=st.booleans())
def test_damaged_satellites_are_read_whole_or_refused(folder, seed, sentences):
    path = folder / ("damaged.nmea" if sentences else "damaged_gnss.csv")
    table = GNSS + "\n" + "".join(f"{k},{k}.2,45,7,400,1,2,0,2,4,0.2,98000,3,5,90,90,1\n" for k in range(5))
    path.write_bytes(damaged((NMEA if sentences else table).encode(), seed))
    navigate_or_say_why(path)


# --------------------------------------------------------------------------------------------- BROAD


def broad_trial(n: int = 6) -> dict:
    return {
        "imu_gyr": np.zeros((n, 3)), "imu_acc": np.tile([0, 0, 9.81], (n, 1)), "imu_mag": np.tile([20.0, 0, -40], (n, 1)),
        "opt_quat": np.tile([1.0, 0, 0, 0], (n, 1)), "movement": np.ones(n), "sampling_rate": 286.0,
    }  # fmt: skip


odd_values = st.one_of(
    st.sampled_from([0.0, -1.0, np.nan, np.inf, 1e-320, "text", np.zeros(0), np.zeros((6, 2)), np.zeros((5, 3)), np.zeros((1, 3)),
                     np.zeros((6, 3, 2)), np.zeros((0, 3)), np.zeros((6, 3), complex), np.full((6, 3), np.nan), np.zeros(3)]),
    st.floats(),
)  # fmt: skip


@bounded_mat
@given(changes=st.dictionaries(st.sampled_from(list(broad_trial())), st.one_of(st.none(), odd_values), min_size=1, max_size=2),
       suffix=st.sampled_from([".hdf5", ".mat"]))  # fmt: skip
def test_a_trial_with_arrays_of_any_shape_is_read_whole_or_refused(folder, changes, suffix):
    data = {name: value for name, value in (broad_trial() | changes).items() if value is not None}
    path = folder / f"01_undisturbed_odd{suffix}"
    if suffix == ".mat":
        scipy.io.savemat(path, data)
    else:
        with h5py.File(path, "w") as file:
            for name, value in data.items():
                if name == "sampling_rate":
                    file.attrs[name] = value
                else:
                    file[name] = value
    read_or_say_why(path)


@bounded_mat
@given(seed=st.integers(0, 2**32))
@example(seed=22)  # SciPy's reader ends its process
def test_a_damaged_mat_file_is_read_whole_or_refused(folder, seed):
    path = folder / "01_undisturbed_damaged.mat"
    scipy.io.savemat(path, broad_trial())
    path.write_bytes(damaged(path.read_bytes(), seed))
    read_or_say_why(path)


@bounded
@given(seed=st.integers(0, 2**32))
def test_a_damaged_hdf5_file_is_read_whole_or_refused(folder, seed):
    path = folder / "01_undisturbed_damaged.hdf5"
    with h5py.File(path, "w") as file:
        for name, value in broad_trial().items():
            if name == "sampling_rate":
                file.attrs[name] = value
            else:
                file[name] = value
    path.write_bytes(damaged(path.read_bytes(), seed))
    read_or_say_why(path)


# --------------------------------------------------------------------------------------------- what devices and robots write

PACKAGES = {"ulog": "pyulog", "ros 1": "rosbags", "mcap": "rosbags", "parquet": "pyarrow", "ardupilot": "pymavlink", "ardupilot text": "pymavlink"}  # fmt: skip
SHAPES = {**recorded.SHAPES, **devices.SHAPES, **apart.SHAPES}
"""Writers of the files that are then damaged, by shape; for a folder, of its one file."""


@pytest.fixture(scope="module")
def small() -> Recording:
    return tilted_motion(0.08).recording


@pytest.mark.parametrize("shape", SHAPES)
def test_a_damaged_file_of_any_shape_is_read_whole_or_refused(tmp_path_factory, small, shape):
    """HNAV_FUZZ_EXAMPLES=200 makes 100 files of each shape, 33 of those of MATLAB."""
    if shape in PACKAGES:
        pytest.importorskip(PACKAGES[shape])
    path = SHAPES[shape](tmp_path_factory.mktemp("shape"), small)
    file = path if path.is_file() else max((f for f in path.rglob("*") if f.is_file()), key=lambda f: f.stat().st_size)
    whole = file.read_bytes()

    @(bounded_mat if shape.startswith("mat") else bounded_shape)
    @given(seed=st.integers(0, 2**32), cut=st.booleans())
    def damage(seed, cut):
        file.write_bytes(whole[: seed % len(whole)] if cut else damaged(whole, seed))
        read_or_say_why(path)

    damage()


names = st.sampled_from(
    ["t", "time_ms", "GyroX", "gyro y (deg/s)", "wz", "ax", "acc_y", "Acc_Z [g]", "mx", "PacketCounter", "", "x", "//", "#"]
)


@bounded
@given(
    header=st.lists(names, max_size=10), rows=rows, delimiter=st.sampled_from(";\t,"),
    wishes=st.fixed_dictionaries({}, optional={"rate_hz": st.floats(), "columns": st.dictionaries(st.sampled_from(["gx", "t_s"]), st.text(max_size=3), max_size=1),
                                               "drop_repeats": st.booleans()}),
)  # fmt: skip
def test_a_table_of_any_names_and_cells_is_read_whole_or_refused(folder, header, rows, delimiter, wishes):
    path = folder / "names.txt"
    path.write_text("\n".join(delimiter.join(row) for row in [header, *rows]) + "\n", encoding="utf-8", errors="replace")
    try:
        recording = read(path, **wishes)
    except RecordingError as error:
        assert "\n" not in str(error)
    else:
        is_whole(recording)
        recording.check()


# --------------------------------------------------------------------------------------------- aircraft


def is_usable(path: Path) -> None:
    try:
        aircraft = read_aircraft(path)
    except HnavError as error:
        assert path.name in str(error) and "\n" not in str(error)
        return
    n, m = len(aircraft.channels), len(aircraft.controls)
    assert aircraft.A_1_s.shape == (n, n) and aircraft.B_1_s.shape == (n, m)
    assert 0 < aircraft.interval_s < np.inf
    factors = noise_factors(aircraft, 20)
    assert factors.shape == (21, n) and np.isfinite(factors).all() and (factors > 0).all()
    assert np.isfinite(inputs(aircraft, 20)).all()


MODEL = models_folder() / "f4c_lateral.json"


@bounded
@given(data=st.data())
def test_a_model_with_any_value_in_any_place_is_usable_or_refused(folder, data):
    model = json.loads(MODEL.read_text())
    *branch, leaf = data.draw(st.sampled_from([p for p in places(model) if p]))
    node = model
    for key in branch:
        node = node[key]
    node[leaf] = data.draw(json_values)
    path = folder / "aircraft.json"
    path.write_text(json.dumps(model))
    is_usable(path)


@bounded
@given(seed=st.integers(0, 2**32))
def test_a_damaged_model_is_usable_or_refused(folder, seed):
    path = folder / "aircraft.json"
    path.write_bytes(damaged(MODEL.read_bytes(), seed))
    is_usable(path)
