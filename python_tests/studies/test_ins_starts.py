"""Starts of the navigation filter: its options equal the simulated errors."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hnav import earth
from hnav.filters.ins import Ins
from hnav.simulation.vehicle import Vehicle
from studies.ins.experiment import experiment, figures, judged
from studies.ins.vehicles import Truth, ideal, vehicle


def test_a_telephone_has_the_options_of_its_slow_satellite_error():
    found = figures(experiment("walker", "consumer", 24, 3, 1))
    # 24 starts of three axes: a mean of 72 squares of standard deviation 0.17, and errors of one start hang together.
    assert 0.5 < found["position_z2"] < 1.6
    assert found["false"] == 0 and np.isnan(found["median_s"])


@pytest.mark.parametrize(("kind", "grade"), [("swaying", "navigation"), ("vibrating", "navigation"), ("rest", "tactical")])
def test_bodies_at_rest_find_north_as_well_as_they_say(kind, grade):
    found = figures(experiment(kind, grade, 3, 1, 1))
    assert found["false"] == 0 and found["heading_z2"] < 3
    assert found["ready"] == (3 if grade == "navigation" else 0)


def test_the_sensors_of_the_study_read_what_those_of_the_simulated_vehicles_read():
    """Two simulations that share no code: one finds rate and force from successive places, the other from derivatives in closed form."""
    drive = Vehicle(kind="aircraft", seed=4, mean_over_s=0.01).run(5 + np.arange(2000) / 100)
    axes = earth.axes_at(drive.place)
    attitude = Rotation.from_matrix(axes) * Rotation.from_quat(drive.q_nb, scalar_first=True)
    velocity = np.einsum("nij,nj->ni", axes, drive.velocity_n_m_s)
    rate, force = ideal(Truth(drive.t_s, earth.position_of(drive.place), velocity, attitude))
    np.testing.assert_allclose(rate[10:], drive.rate_b_rad_s[10:], atol=1e-7)
    # The study takes gravity and Coriolis at the begin of each interval.
    np.testing.assert_allclose(force[10:], drive.force_b_m_s2[10:], atol=2e-4)


def test_satellites_that_are_noisier_than_they_state_start_with_a_tilt_that_holds():
    """Four times as noisy. Levelling measures it by the residuals of its velocities; without that the mean square of 24 starts is 6 after 5 s. No
    position is a jump that lasts: one of these starts was never ready."""
    starts = [judged("aircraft", "industrial", 3_000_000 + number, condition="noisy") for number in range(12)]
    early, end = np.mean([(start["early_tilt_z2"], start["tilt_z2"]) for start in starts], axis=0)
    assert early < 1.5 and end < 2 and all(np.isfinite(start["ready_s"]) for start in starts)


def test_the_noise_of_the_force_is_no_latency():
    """The velocity has integrated the noise that the mean acceleration contains. Taken for motion it made these latencies .16 s wrong (rms)."""
    off_s = []
    for seed in range(8):
        samples, _ = vehicle("quadrotor", "consumer", seed, 150.0)
        late_s = samples.aids.arrays()[0][0] - samples.t_s[1]
        ins = Ins("consumer", solver="closed_form")
        ins.run(samples.t_s, samples.rate_b_rad_s, samples.force_b_m_s2, samples.aids, every=1000)
        off_s.append(ins.navigation().latency_s - late_s)
    assert np.sqrt(np.mean(np.square(off_s))) < 0.08 and abs(np.median(off_s)) < 0.04


def test_a_wrong_given_state_is_not_explained_by_a_latency():
    """Its sigma grows by a misfit to that of the start. Without this limit this car is never ready, and ends 120 deg off."""
    assert judged("car", "industrial", 3_000_026, condition="state")["ready_s"] < 90
