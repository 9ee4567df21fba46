"""The law of Run.observability() on motions whose answer is known: at rest, turning and manoeuvring."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import hnav
from hnav.errors import HnavValueError
from hnav.filters.observability import SEEN, Windows, run_observability

RATE_HZ = 50.0
FIELD_N = np.array([2e-5, 0, 4.5e-5])
BIAS = np.array([0.01, -0.02, 0.015])


def turning(kind: str, t: np.ndarray) -> np.ndarray:
    """n x 3: rates of a level rest, yaw only, a tumble, and a roll by a quarter turn at 12 s."""
    w = np.zeros((len(t), 3))
    if kind == "yaw":
        w[:, 2] = 0.6 * np.sin(0.5 * t)
    elif kind == "tumble":
        w = np.stack([1.1 * np.sin(1.1 * t), 1.3 * np.cos(0.7 * t), 1.2 * np.sin(0.4 * t)], axis=1)
    elif kind == "roll":
        w[(t >= 12) & (t < 13), 0] = np.pi / 2
    return w


def made(kind: str, filter: str, field: bool, sway_m_s2: float = 1.0, **options):
    """A run of 40 s and its recording. sway_m_s2: the body shakes, so that it is not at rest."""
    t, rng = np.arange(0, 40, 1 / RATE_HZ), np.random.default_rng(1)
    w = turning(kind, t)
    attitude = [Rotation.identity()]
    for rate in w[1:]:
        attitude.append(attitude[-1] * Rotation.from_rotvec(rate / RATE_HZ))
    attitude = Rotation.concatenate(attitude)
    shake = sway_m_s2 * np.sin(2 * np.pi * 4 * t)[:, None] * [1.0, 0.7, 0.0]
    force = attitude.apply(shake + [0, 0, -9.81], inverse=True) + 0.02 * rng.normal(size=w.shape)
    magnetic = attitude.apply(FIELD_N, inverse=True) + 2e-7 * rng.normal(size=w.shape)
    rate = w + BIAS + 0.002 * rng.normal(size=w.shape)
    recording = hnav.Recording(kind, t, rate, force, magnetic if field else None)
    begin = {} if field else {"start_mode": "heading", "start_heading_rad": 0.0, "start_sigma_heading_rad": 0.1}
    run = hnav.Filter(filter, **begin | options).run(t, rate, force, recording.field_b_tesla, check=False)
    return run, recording


def vertical(found) -> str:
    return next(name for name in found.remaining if "vertical" in name)


def test_level_rest_without_a_field_leaves_heading_and_the_bias_about_the_vertical():
    found = made("rest", "ahrs", field=False, sway_m_s2=0.0)[0].observability()
    assert found.determined_s("roll") < 1 and found.needs["pitch"] == ("force",)
    assert max(found.determined_s(f"gyro bias {axis}") for axis in "xy") < 15
    assert min(found.remaining["heading"][-1], found.remaining[vertical(found)][-1]) > 0.95
    assert "heading and gyro bias z (vertical at the start): not observable" in found.sentences()


def test_a_field_determines_both():
    found = made("rest", "ahrs", field=True)[0].observability()
    assert "heading: only by the field, from the start" in found.sentences()
    assert found.needs[vertical(found)] == ("field",) and 5 < found.determined_s(vertical(found)) < 30


def test_rest_is_a_measurement_of_all_three_biases_of_the_ahrs():
    run, recording = made("rest", "ahrs", field=False, sway_m_s2=0.0)
    found = run.observability(recording)
    assert found.needs[vertical(found)] == ("rest",) and found.determined_s(vertical(found)) < 3
    assert run.observability().remaining[vertical(found)][-1] > 0.95  # without the recording no rest is found


def test_yaw_alone_does_not_turn_the_bias_away_from_the_vertical():
    run, recording = made("yaw", "ahrs", field=False)
    found = run.observability(recording)
    assert found.remaining["heading"][-1] == 1.0 and found.remaining[vertical(found)][-1] > 0.9
    assert all(found.determined_s(f"gyro bias {axis}") < 20 for axis in "xy")


def test_a_tumbling_body_determines_all_biases_by_force_alone():
    found = made("tumble", "ahrs", field=False)[0].observability()
    assert found.remaining["heading"][-1] == 1.0
    assert all(np.isfinite(found.determined_s(name)) for name in found.remaining if name != "heading")
    assert vertical(found) in found.by_motion  # a body at rest would not determine it


def test_a_turn_away_from_the_vertical_is_named_with_its_time():
    run, _ = made("roll", "ahrs", field=False)
    found = run.observability()
    name = vertical(found)
    assert found.by_motion[name] == pytest.approx(12.5, abs=0.6)
    assert f"{name}: only by the force, after the turn at {found.by_motion[name]:.3g} s" in found.sentences()
    assert (found.remaining[name][found.t_s < 12] > 0.99).all() and found.remaining[name][-1] ** 2 < SEEN


def test_the_hrekf_needs_force_and_field_for_the_heading_and_more_time():
    """Its field is a vector, which leaves the rotation about itself; its noise is larger than the AHRS's."""
    found = made("rest", "hrekf", field=True)[0].observability()
    assert found.needs["heading"] == ("force", "field")
    quiet = made("rest", "hrekf", field=True, accel_noise_per_sqrt_hz=0.01, mag_noise_per_sqrt_hz=0.01)[0].observability()
    assert quiet.determined_s("gyro bias x") < 0.5 * found.determined_s("gyro bias x")
    alone = made("rest", "hrekf", field=False)[0].observability()
    assert alone.remaining["heading"][-1] == alone.remaining[vertical(alone)][-1] == 1.0


def test_the_sigma_of_a_steady_bias_is_that_of_the_filter():
    """The recursion over windows is the filter's covariance: closed against its own sigma, which has the same noise."""
    options = {"accel_gate_nis": 0.0, "mag_gate_nis": 0.0, "start_mode": "attitude", "reference_mode": "given",
               "reference_strength_tesla": float(np.linalg.norm(FIELD_N)), "reference_dip_rad": float(np.arctan2(4.5, 2.0))}  # fmt: skip
    run, _ = made("rest", "hrekf", field=True, sway_m_s2=0.0, **options)
    found, start = run.observability(), run.options.start_sigma_bias_rad_s
    for axis, name in enumerate(n for n in found.remaining if "bias" in n):
        assert found.remaining[name][-1] * start == pytest.approx(run.gyro_bias_sigma_rad_s[-1, axis], rel=0.05)


# --------------------------------------------------------------------------------------------- navigation


def drive(kind: str, seed: int = 1):
    """60 s at 20 m/s, level: rest, straight, S-turns from 15 s on, a bend of 90 deg at 12 s; satellites at 5 Hz."""
    t, rng = np.arange(0, 60, 1 / RATE_HZ), np.random.default_rng(seed)
    heading = {"s": 0.6 * np.sin(0.4 * np.maximum(0, t - 15)), "bend": np.clip((t - 12) / 4, 0, 1) * np.pi / 2}.get(kind, 0 * t)
    speed = 0.0 if kind == "rest" else 20.0
    velocity = speed * np.stack([np.cos(heading), np.sin(heading), 0 * t], axis=1)
    attitude, latitude = Rotation.from_euler("z", heading[:, None]), 0.8
    earth = 7.292115e-5 * np.array([np.cos(latitude), 0, -np.sin(latitude)])
    rate = attitude.apply(earth, inverse=True) + np.stack([0 * t, 0 * t, np.gradient(heading, t)], axis=1)
    force = np.gradient(velocity, t, axis=0) - [0, 0, 9.807] + 2 * np.cross(earth, velocity)
    rate = rate + np.radians([0.2, -0.1, 0.3]) + 1.4e-3 * rng.normal(size=rate.shape)
    force = attitude.apply(force, inverse=True) + 0.05 + 0.014 * rng.normal(size=rate.shape)
    fix = np.arange(0, len(t), 10)
    place = np.cumsum(velocity, axis=0)[fix] / RATE_HZ / 6378137.0
    aids = hnav.Aids().velocity(t[fix], velocity[fix] + 0.05 * rng.normal(size=(len(fix), 3)), 0.05)
    aids.position(t[fix], latitude + place[:, 0], 0.2 + place[:, 1] / np.cos(latitude), 100.0, 1.0)
    return hnav.Ins("industrial").run(t, rate, force, aids, check=False)


HORIZONTAL = ("accelerometer bias x", "accelerometer bias y")


def test_standing_finds_the_tilt_by_satellites_and_no_heading():
    found = drive("rest").observability()
    assert found.needs[vertical(found)] == ("rest",)
    assert min(found.remaining[name][-1] for name in ("heading", *HORIZONTAL)) > 0.95
    assert found.determined_s("roll") - found.begin_s < 1


def test_straight_flight_leaves_heading_and_horizontal_biases():
    found = drive("straight").observability()
    assert min(found.remaining[name][-1] for name in (vertical(found), *HORIZONTAL)) > 0.95
    assert np.isinf(found.determined_s("heading"))


def test_s_turns_determine_everything():
    found = drive("s").observability()
    assert all(np.isfinite(found.determined_s(name)) for name in found.remaining)
    assert 14.5 < found.by_motion["heading"] < 16.5 and found.determined_s("heading") > 15
    assert all(name in found.by_motion for name in HORIZONTAL)


def test_a_bend_is_when_the_heading_is_found():
    run = drive("bend")
    found = run.observability()
    assert 12 <= found.determined_s("heading") < 14 and 12 <= found.by_motion["heading"] < 14
    assert np.isfinite(run.t_s[run.ready[:, 1]][:1]).all()


def test_a_run_without_an_attitude_or_samples_is_refused_by_name():
    t = np.arange(0, 1, 0.02)
    lying = hnav.Filter("ahrs").run(t, np.zeros((50, 3)), None, None, check=False)
    with pytest.raises(HnavValueError, match="no attitude over time"):
        lying.observability()
    run = drive("rest")
    run.samples = None
    with pytest.raises(HnavValueError, match=r"does not hold its samples: take that of Ins\.run"):
        run.observability()


def test_what_holds_after_a_gap_is_what_counts():
    """An error that was determined and is lost again is not determined at the end."""
    m, nothing = 40, np.zeros((40, 1, 1))
    information = np.where(np.arange(m) < 10, 100.0, 0.0)[:, None, None]
    windows = Windows(np.arange(1.0, m + 1), 0.0, np.ones((m, 1, 1)), nothing + 0.1, {"force": information})
    found = run_observability(windows, windows, ("heading",), np.zeros(m))
    assert found.remaining["heading"][9] ** 2 < SEEN and np.isinf(found.determined_s("heading"))
    assert found.sentences() == ["heading: not observable"]
