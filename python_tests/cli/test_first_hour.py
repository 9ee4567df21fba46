"""Commands that new users typed in their first hour, in three roles, from README alone: each works, or a sentence names the next step."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import recorded
from command_line import hnav
from hnav import Filter, Recording, calibrate_magnetometer, read
from hnav.errors import HnavError
from motion import tilted_motion
from recorded import G

DEG = 180 / np.pi


@pytest.fixture(scope="module")
def motion() -> Recording:
    return tilted_motion(15).recording


@pytest.fixture(scope="module")
def frame(motion) -> pd.DataFrame:
    return pd.DataFrame(dict(zip(("time", "gx", "gy", "gz", "ax", "ay", "az"), [motion.t_s, *recorded.columns(motion)])))


def filtered(path: Path, *options: str) -> str:
    """The error text of hnav filter; empty without an error."""
    return hnav("filter", path, *options, "--out", path.with_name("out.csv")).stderr


# --------------------------------------------------------------------------------------------- a phone, a cheap IMU


def chip(folder: Path, motion: Recording, header: str = "") -> Path:
    """Counts of an MPU-6050 at 2 g and 2000 deg/s: force, then rates."""
    counts = np.hstack([motion.force_b_m_s2 / G * 16384, motion.rate_b_rad_s * DEG * 16.4])
    times = np.round(1e3 * motion.t_s)[:, None]
    np.savetxt(
        folder / "mpu.csv", np.hstack([times, counts])[:, not header :], fmt="%d", delimiter=",", header=header, comments=""
    )
    return folder / "mpu.csv"


UNITS = ("--gyro-unit", "1/16.4 deg/s", "--accel-unit", "1/16384 g")


def test_numbers_of_a_sketch_without_a_header(tmp_path, motion):
    path = chip(tmp_path, motion)
    assert "say their places, such as --columns gx=1,gy=2,gz=3,ax=4,ay=5,az=6 --rate=100\n" in filtered(path)
    named = ("--columns", "ax=1,ay=2,az=3,gx=4,gy=5,gz=6", "--rate", "100")
    assert "these look like counts of the chip" in filtered(path, *named)
    assert not filtered(path, *named, *UNITS)


def test_a_range_that_the_sketch_did_not_set(tmp_path, motion):
    path = chip(tmp_path, motion, "millis,ax,ay,az,gx,gy,gz")
    assert "the force turns 8.0" in filtered(path, "--gyro-unit", "1/131 deg/s", *UNITS[2:])
    assert not filtered(path, *UNITS)


def test_an_accelerometer_alone(tmp_path, motion):
    path = recorded.write_rows(tmp_path / "phone.csv", "time,ax,ay,az", [motion.t_s, *motion.force_b_m_s2.T])
    said = filtered(path)
    assert "the file has time, ax, ay, az, and nothing of the gyro: record gyroscope and accelerometer together" in said


# --------------------------------------------------------------------------------------------- arrays and notebooks


@pytest.mark.parametrize("orient", ["columns", "index", "split", "records", "list"])
def test_tables_of_pandas_in_json(tmp_path, frame, orient):
    path = tmp_path / "walk.json"
    if orient == "list":
        path.write_text(pd.Series(frame.to_dict("list")).to_json())
    else:
        frame.to_json(path, orient=orient)
    assert len(read(path).t_s) == len(frame)


def test_feather_pickle_and_a_matrix(tmp_path, frame):
    np.save(tmp_path / "walk.npy", frame.to_numpy())
    places = "t_s=1,gx=2,gy=3,gz=4,ax=5,ay=6,az=7"
    assert f"say their places, such as --columns {places}" in filtered(tmp_path / "walk.npy")
    assert not filtered(tmp_path / "walk.npy", "--columns", places)
    frame.to_pickle(tmp_path / "walk.pkl")
    assert "a pickle, which may run any code: save .csv, .npz or .parquet" in filtered(tmp_path / "walk.pkl")
    pytest.importorskip("pyarrow")
    frame.to_feather(tmp_path / "walk.feather")
    assert not filtered(tmp_path / "walk.feather")


@pytest.mark.parametrize(
    "call, said",
    [
        (lambda r: Filter().run(r), "t_s is no array of numbers but a Recording: give its arrays, or a filter run_recording"),
        (lambda r: Filter().run(0.01, r.rate_b_rad_s), "of samples at equal intervals np.arange(n) / rate_hz"),
        (lambda r: calibrate_magnetometer(r), "but a Recording: give its arrays"),
        (
            lambda r: read(r.rate_b_rad_s),
            "a ndarray: Recording(name, t_s, rate_b_rad_s, force_b_m_s2, field_b_tesla) takes arrays",
        ),
        (lambda r: Recording.from_dataframe(r.rate_b_rad_s), "write pandas.DataFrame(array, columns=['t_s', 'gx', ...])"),
        (
            lambda r: Recording.from_dataframe(pd.DataFrame(np.ones((9, 7)))),
            "such as columns t_s=1,gx=2,gy=3,gz=4,ax=5,ay=6,az=7",
        ),
        (lambda r: Recording.from_dataframe(pd.DataFrame({"p": [1]})), "among p; say which by columns gx=NAME"),
        (lambda r: read(pd.DataFrame()), "path is no file or folder but a DataFrame: Recording.from_dataframe takes tables"),
        (
            lambda r: Recording(r.t_s, r.rate_b_rad_s, r.force_b_m_s2, r.field_b_tesla),
            "name is no text but a ndarray: write Recording(name, t_s",
        ),
        (lambda r: Filter().run_recording(r).report(r, "walk.html"), "path is no file but a Recording: write report(path"),
    ],
)
def test_arguments_in_another_order_than_they_are(motion, call, said):
    with pytest.raises(HnavError) as error:
        call(motion)
    assert said in str(error.value) and "\n" not in str(error.value)


# --------------------------------------------------------------------------------------------- fmpy and an own plant


def test_an_fmu_is_no_system(tmp_path):
    (tmp_path / "plant.fmu").write_bytes(b"PK")
    done = hnav("simulate", tmp_path / "plant.fmu")
    assert done.returncode == 2 and "an FMU is no system: hnav observe estimates its states" in done.stderr


def test_the_options_of_a_filter_by_its_name():
    assert hnav("options", "INS").stdout == hnav("options", "--filter", "ins").stdout


def test_a_system_without_noise_has_no_many_runs(tmp_path):
    from checkout import built_system

    built_system("filter")
    done = hnav("montecarlo", "filter", "--runs", 2, "--out", tmp_path / "runs.parquet")
    assert done.returncode == 2 and "so every run would be the same: take a system with noise of its own" in done.stderr
