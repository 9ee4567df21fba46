"""Tables of a run: every bit of the times, the answers of the C library at each row, and the options and files that it was made with."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from hnav import Filter, __version__
from hnav.errors import HnavError
from hnav.filters.attitude_answers import Run
from hnav.filters.filter_answers import SENSOR_STATES
from hnav.filters.run_files import columns, write_table
from hnav.fmi.engines import run_recording
from motion import tilted_motion

EPOCH_S = 1.7e9
ENGINES = ("c", "fmi3-cs")


@pytest.fixture(scope="module")
def recording():
    return tilted_motion(60).recording


def disturbed(recording) -> np.ndarray:
    """Its field, with something for the gate."""
    field = recording.field_b_tesla.copy()
    field[3000:3100] += [1e-4, 0, 0]
    return field


@pytest.fixture(scope="module", params=["ahrs", "hrekf"])
def run(request, recording) -> Run:
    gate = {"accel_gate_nis": 0.001} if request.param == "hrekf" else {"mag_gate": 0.05}
    return Filter(request.param, navigation_frame="enu", **gate).run(
        EPOCH_S + recording.t_s, recording.rate_b_rad_s, recording.force_b_m_s2, disturbed(recording)
    )


def test_epoch_times_come_back_bit_for_bit(run, tmp_path):
    write_table(tmp_path / "x.csv", run)
    t_s = pd.read_csv(tmp_path / "x.csv", comment="#")["t_s"].to_numpy()
    assert len(t_s) == 6000 == len(set(t_s)) and t_s[0] == EPOCH_S
    np.testing.assert_array_equal(t_s, run.t_s)
    with (tmp_path / "x.csv").open() as file:
        rows = [line for line in file if not line.startswith("#")]
    np.testing.assert_array_equal([float(line.split(",")[0]) for line in rows[1:]], run.t_s)


def test_the_head_says_what_made_the_file(run, tmp_path):
    write_table(tmp_path / "x.csv", run, ["recording walk\n.csv"])
    head = [line for line in (tmp_path / "x.csv").read_text().splitlines() if line.startswith("#")]
    assert head[0] == f"# hnav {__version__}" and head[1] == "# recording walk .csv"
    assert f"# filter {run.options.filter}, preset default" in head
    changed = next(line for line in head if line.startswith("# options that differ from the preset: "))
    assert changed.partition(": ")[2] == ", ".join(f"{name}={value}" for name, value in run.options.changed().items())
    assert "navigation_frame=enu" in changed and "gate" in changed
    assert f"# health: {', '.join(f'{i} {name}' for i, name in enumerate(SENSOR_STATES))}" in head


def test_the_columns_are_those_of_the_run(run, tmp_path):
    write_table(tmp_path / "x.csv", run)
    table = pd.read_csv(tmp_path / "x.csv", comment="#")
    np.testing.assert_allclose(table[["q0", "q1", "q2", "q3"]], run.q_nb, rtol=1e-8)
    np.testing.assert_allclose(table[["roll_deg", "pitch_deg", "yaw_deg"]], np.degrees(run.euler_rad), rtol=1e-8)
    np.testing.assert_allclose(table[[f"sigma_{axis}_deg" for axis in "xyz"]], np.degrees(run.sigma_rad), rtol=1e-8)
    np.testing.assert_array_equal(table[["tilt_ready", "heading_ready"]], run.ready)
    np.testing.assert_allclose(table["mag_nis"], run.mag_nis, rtol=1e-8)
    np.testing.assert_array_equal(table["mag_accepted"].isna(), np.isnan(run.mag_nis))
    np.testing.assert_array_equal(table["mag_accepted"] == 1, run.accepted[:, 1])
    np.testing.assert_array_equal(table[["gyro_health", "accel_health", "mag_health"]], run.health)


def test_heading_and_tilt_are_geometry_in_both_frames(recording):
    """Heading is that of body x clockwise from north, tilt the angle from body z to the vertical, whatever the axes."""
    for frame, north, east in (("ned", 0, 1), ("enu", 1, 0)):
        run = Filter("ahrs", navigation_frame=frame).run(
            recording.t_s, recording.rate_b_rad_s, recording.force_b_m_s2, recording.field_b_tesla
        )
        w, x, y, z = run.q_nb.T
        body_x = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)], axis=1)
        table = columns(run)
        heading = np.degrees(np.arctan2(body_x[:, east], body_x[:, north])) % 360
        known = np.isfinite(heading) & (np.abs(np.degrees(run.euler_rad[:, 1])) < 89)
        np.testing.assert_allclose(np.cos(np.radians(table["heading_deg"] - heading))[known], 1, atol=1e-12)
        np.testing.assert_allclose(np.cos(np.radians(table["tilt_deg"])), 1 - 2 * (x * x + y * y), atol=1e-12)


def test_heading_is_what_the_library_says(recording):
    for frame in ("ned", "enu"):
        filter = Filter("ahrs", navigation_frame=frame, declination_rad=0.2)
        run = filter.run(recording.t_s, recording.rate_b_rad_s, recording.force_b_m_s2, recording.field_b_tesla)
        assert run.heading_rad[-1] == pytest.approx(filter.attitude().heading_rad, abs=1e-12)
        assert (np.abs(run.heading_rad[np.isfinite(run.heading_rad)]) <= np.pi).all()


def test_gates_are_those_of_the_innovations(run, recording):
    by_row = Filter(run.options)
    samples = (recording.rate_b_rad_s, recording.force_b_m_s2, disturbed(recording))
    for i in range(3100):
        by_row.run(run.t_s[i : i + 1], *(values[i : i + 1] for values in samples), only=("q_nb",))
        for column, (sensor, nis) in enumerate((("accel", run.accel_nis), ("mag", run.mag_nis))):
            assert run.accepted[i, column] == (np.isfinite(nis[i]) and by_row.innovation(sensor).accepted), (i, sensor)
    used = np.isfinite(np.stack([run.accel_nis, run.mag_nis], axis=1))
    assert (used & ~run.accepted).any()


def test_a_row_that_fails_is_named(recording):
    t_s = recording.t_s.copy()
    t_s[50] = np.inf
    with pytest.raises(HnavError, match="row 50:"):
        Filter("ahrs").run(t_s, recording.rate_b_rad_s, recording.force_b_m_s2)


def test_parquet_holds_the_same_and_its_comments(run, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed")
    write_table(tmp_path / "x.parquet", run, ["recording walk.csv"])
    read = parquet.read_table(tmp_path / "x.parquet")
    np.testing.assert_array_equal(read["t_s"].to_numpy(), run.t_s)
    np.testing.assert_array_equal(read["q3"].to_numpy(), run.q_nb[:, 3])
    assert read.column_names == list(columns(run))
    assert read.schema.metadata[b"hnav"].decode().splitlines()[1] == "recording walk.csv"


def test_without_pyarrow_parquet_says_what_to_install(run, tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    with pytest.raises(HnavError, match="x.parquet: Parquet needs pyarrow: python -m pip install pyarrow"):
        write_table(tmp_path / "x.parquet", run)
    assert not list(tmp_path.iterdir())


def test_a_run_shows_its_figures(run):
    assert repr(run).startswith("<Run: 6000 rows in 59.99 s, last roll ") and len(repr(run)) < 200
    html = run._repr_html_()
    assert len(html) < 4000
    for said in ("heading", "gyro bias", "tilt ready", "mean NIS of the field", "navigation_frame"):
        assert said in html
    nothing = Filter("ahrs").run(np.arange(5.0))
    assert "no attitude" in repr(nothing) and "the filter did not start" in nothing._repr_html_()
    assert "0 rows" in repr(Filter("ahrs").run(np.empty(0)))


def test_an_fmu_has_the_same_gates(recording):
    made = replace(recording, field_b_tesla=disturbed(recording))
    by_library, by_fmu = (run_recording(made, "ahrs", engine) for engine in ENGINES)
    used = np.isfinite(by_library.mag_nis)
    assert (used & ~by_library.accepted[:, 1]).any()
    # An FMU holds its flags between corrections.
    np.testing.assert_array_equal(by_fmu.accepted[used, 1], by_library.accepted[used, 1])
