"""Iron that a calibration leaves: the AHRS states it in the sigma of the heading."""

import numpy as np
from scipy.spatial.transform import Rotation

from hnav import Filter

FIELD_N = np.array([21e-6, 0, 45e-6])
RATE_HZ = 50


def heading_of(turn_rad_s: float, seed: int, iron: float = 0.01) -> tuple[float, float]:
    """Error and stated sigma of the heading in deg, after a minute level with iron of 0.5 uT (sigma) on each axis; turns after 10 s.

    iron: the option."""
    rng = np.random.default_rng([seed, 8])
    t_s = np.arange(0, 60, 1 / RATE_HZ)
    rates = np.where(t_s > 10, turn_rad_s, 0)[:, None] * [0, 0, 1.0]
    attitude = Rotation.from_rotvec(np.cumsum(rates, 0) / RATE_HZ)
    noise = rng.normal(0, [0.002, 0.02, 3e-7], (len(t_s), 3, 3))
    fields = attitude.inv().apply(FIELD_N) + rng.normal(0, 0.5e-6, 3)
    run = Filter("ahrs", solver="closed_form", residual_iron=iron, start_sigma_accel_bias_m_s2=0.035).run(
        t_s, rates + noise[:, :, 0], [0, 0, -9.81] + noise[:, :, 1], fields + noise[:, :, 2], check=False
    )
    error = Rotation.from_quat(run.q_nb[-1], scalar_first=True) * attitude[-1].inv()
    return np.degrees(error.as_rotvec()[2]), np.degrees(run.sigma_rad[-1, 2])


def test_a_body_that_never_turned_states_what_iron_may_turn_its_heading_by():
    """Without iron the mean square of error over sigma is 3.0."""
    errors, sigmas = np.transpose([heading_of(0.0, seed) for seed in range(24)])
    assert 0.3 < np.mean((errors / sigmas) ** 2) < 1.8
    assert heading_of(0.0, 0, iron=1e-6)[1] < 0.6 * sigmas[0]


def test_a_body_that_turns_averages_iron_out_and_states_less():
    at_rest, turning = ([heading_of(turn, seed) for seed in range(8)] for turn in (0.0, 1.0))
    assert np.mean([sigma for _, sigma in turning]) < 0.9 * np.mean([sigma for _, sigma in at_rest])
    assert np.mean([(error / sigma) ** 2 for error, sigma in turning]) < 1.8
