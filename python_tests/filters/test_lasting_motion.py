"""Velocities of vehicles last, as errors of the horizon do; what errors of the sensors cannot explain is motion."""

import numpy as np
import pytest

from hnav import Filter
from hnav.reports.scores import errors_rad
from studies.bench.motions import motion


@pytest.mark.parametrize("kind", ["ship", "boat"])
def test_an_uncertain_bias_of_the_accelerometer_hides_no_velocity_that_lasts(kind):
    """Consumer grade: 0.2 m/s^2, 1.1 deg of tilt. As if the tilt alone explained velocities, ships and boats would be 3.5 and 1.4 deg off, and
    ready for 9 and 32 % of the time."""
    errors_deg, ready = [], []
    for seed in range(6):
        r = motion(kind, seed, "industrial")
        ahrs = Filter("ahrs", solver="closed_form", navigation_frame="enu", sensor="consumer")
        run = ahrs.run(r.t_s, r.rate_b_rad_s, r.force_b_m_s2, r.field_b_tesla)
        errors_deg.append(np.degrees(errors_rad(run.q_nb, r.reference_q_nb)[2]))
        ready.append(run.ready[:, 0])
    assert np.sqrt(np.nanmean(np.square(errors_deg))) < 1.2
    assert np.mean(ready) > 0.5


@pytest.mark.parametrize("gain_m_s2", [0.3, 0.6, 0.9])
def test_a_smooth_departure_is_not_the_force_of_the_rest_before_it(gain_m_s2):
    """A lift: level, at rest for 10 s, then up to 2 m/s and, two seconds later, slower again. The accelerometer was taken for one with an error
    of the size of the departure, and the tilt was not ready until the next rest."""
    rng, t = np.random.default_rng(0), np.arange(0, 60, 0.01)

    def pulse(begin_s):
        edges = (np.tanh((t - at_s) / 0.4) for at_s in (begin_s, begin_s + 2 / gain_m_s2))
        return 0.5 * gain_m_s2 * (next(edges) - next(edges))

    up = pulse(10) - pulse(12 + 2 / gain_m_s2)
    force = np.stack([0 * t, 0 * t, -9.81 - up], 1) + 0.01 * rng.normal(size=(len(t), 3))
    rate = 0.001 * rng.normal(size=(len(t), 3))
    rate[:, 2] += 0.3 * np.sin(0.7 * t) * (t > 12)
    yaw = 0.01 * np.cumsum(rate[:, 2])
    run = Filter("ahrs").run(t, rate, force, np.stack([2e-5 * np.cos(yaw), -2e-5 * np.sin(yaw), 4.2e-5 + 0 * t], 1))
    assert run.ready[t > 30, 0].mean() > 0.9
