"""A file is read as it was measured, or refused, or stopped with its cure: no shape of file gives a wrong attitude in silence."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import apart
import devices
import exported
import recorded
from hnav import Filter, Recording, read
from hnav.io.recordings import RecordingError
from hnav.reports.scores import errors_rad
from motion import tilted_motion
from recorded import G, columns, write_rows

NEEDS = {
    "ardupilot": "pymavlink",
    "ardupilot text": "pymavlink",
    "ulog": "pyulog",
    "parquet": "pyarrow",
    "ros 1": "rosbags",
    "ros 2": "rosbags",
    "mcap": "rosbags",
}
DEG = 180 / np.pi


def table(header: str, rate: float, force: float, field: float | None, folder: Path, r: Recording) -> Path:
    """t_s and the sensors, multiplied, under a header of which {axis} stands for three columns."""
    names = [name.format(axis=axis) for name in header.split("|") for axis in ("xyz" if "{axis}" in name else "-")]
    arrays = [r.t_s, *columns(r, rate, force, field or 1)[: len(names) - 1]]
    return write_rows(folder / "table.csv", ",".join(names), arrays)


def counts(folder: Path, r: Recording) -> Path:
    rounded = replace(r, rate_b_rad_s=np.round(16.4 * DEG * r.rate_b_rad_s), force_b_m_s2=np.round(2048 / G * r.force_b_m_s2))
    return table("time|gyro_{axis}|acc_{axis}|mag_{axis}", 1, 1, 1e6, folder, rounded)


def changed(folder: Path, r: Recording, **arrays: Callable[[np.ndarray], np.ndarray]) -> Path:
    return recorded.house(folder, replace(r, **{name: change(getattr(r, name)) for name, change in arrays.items()}))


def linear_acceleration(folder: Path, r: Recording) -> Path:
    """A telephone's force without gravity."""
    return recorded.phyphox(folder, replace(r, force_b_m_s2=0.01 * r.force_b_m_s2))


SWAPPED = [1, 0, 2]
ALL = "time_s|gyro_{axis}|acc_{axis}|mag_{axis}"
FAULTY: dict[str, tuple[str, Callable[[Path, Recording], Path]]] = {
    "deg/s, no unit": ("stops", partial(table, ALL, DEG, 1, 1e6)),
    "deg/s, no unit, no field": ("stops", partial(table, "time_s|gyro_{axis}|acc_{axis}", DEG, 1, None)),
    "g, no unit": ("stops", partial(table, ALL, 1, 1 / G, 1e6)),
    "deg/s and g": ("stops", partial(table, ALL, DEG, 1 / G, 1e6)),
    "mg, no unit": ("stops", partial(table, ALL, 1, 1e3 / G, 1e6)),
    "a unit of the rates that is none": ("refused", partial(table, "time_s|gyro_{axis} [furlong/s]|acc_{axis}", 1, 1, None)),
    "a unit of the force that is none": ("refused", partial(table, "time_s|gyro_{axis} [rad/s]|acc_{axis} [stone]", 1, 1, None)),
    "counts that are called so": ("refused", partial(table, "time_s|gyro_{axis} [LSB]|acc_{axis} [LSB]", 1, 1, None)),
    "counts": ("stops", counts),
    "rates called rad/s that are deg/s": ("stops", partial(table, "time_s|gyro_{axis} [rad/s]|acc_{axis}|mag_{axis}", DEG, 1, 1e6)),
    "force called m/s2 that is g": ("stops", partial(table, "time_s|gyro_{axis}|acc_{axis} [m/s^2]|mag_{axis}", 1, 1 / G, 1e6)),
    "linear acceleration": ("stops", linear_acceleration),
    "force of zeros": ("stops", partial(changed, force_b_m_s2=lambda v: 0 * v)),
    "rates missing": ("stops", partial(changed, rate_b_rad_s=lambda v: np.nan * v)),
    "rates swapped": ("stops", partial(changed, rate_b_rad_s=lambda v: v[:, SWAPPED])),
    "rates negated": ("stops", partial(changed, rate_b_rad_s=lambda v: -v)),
    "force swapped": ("stops", partial(changed, force_b_m_s2=lambda v: v[:, SWAPPED])),
    "field swapped": ("stops", partial(changed, field_b_tesla=lambda v: v[:, SWAPPED])),
    "force negated": ("stops", partial(changed, force_b_m_s2=lambda v: -v)),
    "field of zeros": ("warned", partial(changed, field_b_tesla=lambda v: 0 * v)),
    "field stuck": ("warned", partial(changed, field_b_tesla=lambda v: 0 * v + [2e-5, 0, 4e-5])),
    "field in another unit": ("right", partial(table, "time_s|gyro_{axis}|acc_{axis}|mag_{axis} [T]", 1, 1, 1e4)),
    "no force": ("refused", partial(table, "time_s|gyro_{axis}", 1, 1, None)),
    "no times": ("refused", partial(table, "row|gyro_{axis}|acc_{axis}", 1, 1, None)),
    "names of nothing": ("refused", partial(table, "time_s|left_{axis}|right_{axis}", 1, 1, None)),
}  # fmt: skip
"""By shape: the verdict, and the writer of the file."""
SHAPES = {**recorded.SHAPES, **devices.SHAPES, **exported.SHAPES, **apart.SHAPES}
FAULTY |= exported.FAULTY | apart.FAULTY


@pytest.fixture(scope="module")
def motion() -> Recording:
    return tilted_motion(15).recording


def verdict(path: Path, truth: Recording) -> str:
    """refused: not read; stops: hnav filter stops; warned; right: within 5 deg RMS in the second half; else silent."""
    try:
        recording = read(path)
    except RecordingError as error:
        assert "\n" not in str(error) and path.name in str(error)
        return "refused"
    findings = recording.check()
    if any(finding.stops and finding.cure for finding in findings):
        return "stops"
    run = Filter("ahrs").run_recording(recording)
    t_s = run.t_s - run.t_s[0] + truth.t_s[0]
    reference = truth.reference_q_nb[np.searchsorted(truth.t_s, t_s - 5e-3).clip(0, len(truth.t_s) - 1)]
    total, heading, inclination = (
        np.degrees(np.sqrt(np.mean(error[len(t_s) // 2 :] ** 2))) for error in errors_rad(run.q_nb, reference)
    )
    if (total if recording.field_b_tesla is not None else inclination) < 5:
        return "right"
    return "warned" if any(finding.level == "warning" for finding in findings) else "silent"


@pytest.mark.parametrize("shape", SHAPES)
def test_what_a_device_writes_gives_the_attitude_that_it_had(tmp_path, motion, shape):
    if shape in NEEDS:
        pytest.importorskip(NEEDS[shape])
    assert verdict(SHAPES[shape](tmp_path, motion), motion) == "right"


@pytest.mark.parametrize("shape", FAULTY)
def test_what_is_written_wrong_is_refused_or_stopped_or_at_least_warned_of(tmp_path, motion, shape):
    expected, write = FAULTY[shape]
    assert verdict(write(tmp_path, motion), motion) == expected


# ------------------------------------------------------------------------------------------ bodies that hardly turn


def slow(seed: int) -> Recording:
    """A body at rest, or turning at 0.2 to 6 deg/s; biases and noises of chips of telephones (deg/s: 0.1 to 2; 0.004 to 0.03 per
    sqrt(Hz)); half of them with a magnetometer."""
    rng = np.random.default_rng(seed)
    t_s = np.arange(0, 40, 0.01)
    size = rng.choice([0.0, 0.2, 1.0, 6.0]) / DEG
    rate = size * np.stack([np.sin(rng.uniform(0.1, 1) * t_s + rng.uniform(0, 6)) for _ in range(3)], axis=1)
    attitude = Rotation.from_quat(rng.normal(size=4))
    turns = [attitude]
    for k in range(len(t_s) // 10 - 1):
        turns.append(turns[-1] * Rotation.from_rotvec(rate[10 * k : 10 * k + 10].mean(axis=0) * 0.1))
    seen = Rotation.concatenate(turns)[np.arange(len(t_s)) // 10]
    noise = rng.uniform(0.004, 0.03) / DEG * np.sqrt(50) * rng.normal(size=rate.shape)
    force = seen.apply([0, 0, -9.81], inverse=True) + rng.uniform(0.005, 0.03) * rng.normal(size=rate.shape)
    field = seen.apply([2e-5, 0, 4.5e-5], inverse=True) + 3e-7 * rng.normal(size=rate.shape)
    bias = rng.uniform(0.1, 2) / DEG * rng.normal(size=3)
    return Recording("slow", t_s, rate + bias + noise, force, field if seed % 2 else None)


def test_no_file_of_a_slow_or_still_body_is_read_in_deg_s_for_rad_s_in_silence(tmp_path):
    called, unknown = 0, 0
    for seed in range(10):
        body = slow(seed)
        header = ALL if body.field_b_tesla is not None else ALL.rpartition("|")[0]
        field = body.field_b_tesla if body.field_b_tesla is not None else np.zeros_like(body.force_b_m_s2)
        body = replace(body, field_b_tesla=field)
        found = read(table(header, DEG, 1, 1e6, tmp_path, body)).check()
        assert any(f.is_meaningless and f.sensor == "gyro" and "gyro_unit" in f.cure for f in found), seed
        right = read(table(header, 1, 1, 1e6, tmp_path, body)).check()
        called += any(f.argument == "gyro_unit" for f in right)
        unknown += any(f.is_meaningless and f.argument is None for f in right)
    assert called == 0  # rad/s that is called deg/s
    assert unknown < 5  # and of which nothing decides
