"""Axes of rates and force against the velocities of satellites."""

import dataclasses

import numpy as np
import pytest

from hnav.cli.words import finding_line
from hnav.io.accelerating import following_of
from hnav.io.aids import AidSamples
from hnav.io.plausible_aids import check_aids
from hnav.io.readers.streams import turned
from hnav.io.recordings import Recording
from hnav.native.library import SENSORS
from studies.ins.motions import AT_REST, MOTIONS
from studies.ins.vehicles import vehicle


def driven(kind: str, seed: int, length_s: float = 100.0) -> Recording:
    """A simulated vehicle with the velocities of its satellites."""
    samples, _ = vehicle(kind, "industrial", seed, length_s)
    valid_s, _, sensor, value = samples.aids.arrays()
    rows = sensor == SENSORS.index("velocity")
    aids = {"velocity": AidSamples(valid_s[rows], value[rows, :3], value[rows, 3:])}
    return Recording(kind, samples.t_s, samples.rate_b_rad_s, samples.force_b_m_s2, aids=aids)


def named(values: np.ndarray, axes: str) -> np.ndarray:
    order, signs = turned(axes)
    return values[:, order] * signs


def with_axes(recording: Recording, gyro: str = "x,y,z", accel: str = "x,y,z") -> Recording:
    rate, force = named(recording.rate_b_rad_s, gyro), named(recording.force_b_m_s2, accel)
    return dataclasses.replace(recording, rate_b_rad_s=rate, force_b_m_s2=force)


def of_axes(recording: Recording) -> list:
    return [finding for finding in check_aids(recording) if finding.code == "axes"]


@pytest.mark.parametrize("kind", [kind for kind in MOTIONS if kind not in AT_REST])
def test_right_axes_give_no_alarm_however_the_body_moves(kind):
    for seed in (1, 2):
        assert of_axes(driven(kind, seed)) == []


@pytest.mark.parametrize("sensor", ["gyro", "accel"])
@pytest.mark.parametrize("axes", ["x,y,-z", "-x,-y,-z", "x,z,y", "y,x,z", "x,-y,z"])
def test_exchanged_or_negated_axes_of_one_sensor_are_named_with_the_cure(sensor, axes):
    """These are their own inverse: what spoilt them mends them."""
    (finding,) = of_axes(with_axes(driven("walker", 2), **{sensor: axes}))
    assert (finding.sensor, finding.argument, finding.value) == (sensor, "axes", f"{sensor}={axes}") and finding.stops
    assert finding_line(finding).endswith(f"use --axes {sensor}={axes}") and f'use axes={{"{sensor}": "{axes}"}}' in str(finding)


def test_the_cure_of_mirrored_axes_makes_them_right():
    mirrored = with_axes(driven("walker", 2), "y,x,z", "y,x,z")
    (finding,) = of_axes(mirrored)
    assert 'axes={"gyro": "x,-y,z", "accel": "x,-y,z"}; both are mirrored' in str(finding)
    assert of_axes(with_axes(mirrored, "x,-y,z", "x,-y,z")) == []


def test_what_several_axes_explain_is_said_without_one():
    (finding,) = of_axes(with_axes(driven("straight", 1), "-x,-y,-z"))
    assert finding.argument is None and "several other axes" in finding.message


def test_a_bias_and_late_fixes_are_no_wrong_axes():
    recording = driven("car", 2)
    velocity = recording.aids["velocity"]
    late = {"velocity": dataclasses.replace(velocity, t_s=velocity.t_s + 1.0)}
    biased = recording.rate_b_rad_s + np.radians([3.0, -2.0, 1.0])
    assert of_axes(dataclasses.replace(recording, rate_b_rad_s=biased, aids=late)) == []


def test_units_and_gaps_with_which_nothing_fits_show_nothing():
    recording = driven("walker", 2)
    assert of_axes(dataclasses.replace(recording, rate_b_rad_s=np.degrees(recording.rate_b_rad_s))) == []
    seldom = {"velocity": recording.aids["velocity"].rows(np.arange(0, len(recording.aids["velocity"].t_s), 5))}
    spoilt = with_axes(dataclasses.replace(recording, aids=seldom), "x,y,-z")
    assert following_of(spoilt.samples("gyro"), spoilt.samples("accel"), seldom["velocity"]) is None
    assert of_axes(spoilt) == []


@pytest.mark.parametrize("kind", ["car", "take_off"])
def test_velocities_that_contradict_the_positions_accuse_neither_rates_nor_force(kind):
    samples, _ = vehicle(kind, "industrial", 2, 100.0)
    recording = driven(kind, 2)
    valid_s, _, sensor, value = samples.aids.arrays()
    rows, velocity = sensor == SENSORS.index("position"), recording.aids["velocity"]
    aids = {
        "position": AidSamples(valid_s[rows], value[rows, :3], value[rows, 3:]),
        "velocity": dataclasses.replace(velocity, values=velocity.values[:, [1, 0, 2]]),
    }
    (finding,) = of_axes(dataclasses.replace(recording, aids=aids))
    assert finding.sensor == "velocity" and "north and east look exchanged" in finding.message
