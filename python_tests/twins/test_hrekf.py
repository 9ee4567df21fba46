"""The paper's filter again in NumPy: the library agrees with it, and with its errata."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from attitude_twins import PRECISE, difference
from hnav import Filter, Options
from motion import tilted_motion
from twins.hrekf import bias_error_deg_s, run_reference

SETTINGS = {
    "hekf": {},
    "gamma fixed": {"gamma_mode": "fixed", "gamma": 0.3},
    "gamma relative": {"gamma_mode": "relative"},
    "gamma kl": {"gamma_mode": "kl"},
    "weighted": {"gamma_mode": "kl", "gamma_weight_bias": 0.1},
    "adaptation as printed": {"adaptation": "paper", "adaptation_gain": 0.1},
    "backward hold": {"gyro_hold": "backward"},
    "instants": {"gyro_hold": "instant"},
    "tight gates": {"accel_gate_nis": 3, "mag_gate_nis": 3},
    "frames": {"navigation_frame": "enu", "declination_rad": 0.1, "q_body_sensor": [0.8, 0.1, -0.3, 0.2]},
    "mean start, given field": {
        "start_samples": 3, "reference_mode": "given", "reference_strength_tesla": 4.9e-5, "reference_dip_rad": 1.15,
    },
    "noise on q": {"quaternion_noise_per_sqrt_s": 1e-3},
}  # fmt: skip


@pytest.mark.parametrize("name", SETTINGS)
def test_the_library_is_the_numpy_reference(name):
    m = tilted_motion(0.6).recording
    options = Options("hrekf", **PRECISE | SETTINGS[name], solver_rtol=1e-12, solver_atol=1e-14)
    run = Filter(options).run(m.t_s, m.rate_b_rad_s, m.force_b_m_s2, m.field_b_tesla)
    q, bias, sigma = run_reference(m.t_s, m.rate_b_rad_s, m.force_b_m_s2, m.field_b_tesla, options)
    assert difference(q, run.q_nb) < 1e-11
    assert np.nanmax(np.abs(bias - run.gyro_bias_rad_s)) < 1e-11
    if name != "frames":  # the reference's sigmas are about its internal axes
        assert np.nanmax(np.abs(sigma - run.sigma_rad)) < 1e-11


@pytest.mark.parametrize("gamma_mode", ["off", "relative"])
def test_the_library_adapts_as_the_reference_does(gamma_mode):
    """Long enough for two windows after the start has settled; ten samples in a second, of a body that turns slowly."""
    t = 0.1 * np.arange(420)
    rng = np.random.default_rng(4)
    attitude = Rotation.from_euler("ZYX", np.stack([0.5 * np.sin(0.3 * t), 0.2 + 0 * t, 0.1 * np.sin(0.2 * t)], axis=1))
    turned = (attitude[:-1].inv() * attitude[1:]).as_rotvec() / 0.1
    rate = np.vstack([turned, turned[-1]]) + 0.01 * np.sin(0.2 * t)[:, None] + 1e-3 * rng.normal(size=(len(t), 3))
    force = attitude.apply([0, 0, -9.81], inverse=True) + 0.05 * rng.normal(size=(len(t), 3))
    field = attitude.apply([2e-5, 0, 4.5e-5], inverse=True) + 2e-7 * rng.normal(size=(len(t), 3))
    options = Options("hrekf", adaptation="corrected", gamma_mode=gamma_mode, solver="closed_form")
    target = Filter(options)
    run = target.run(t, rate, force, field)
    q, bias, sigma = run_reference(t, rate, force, field, options)
    stated, found = options.gyro_bias_walk_rad_s_per_sqrt_s, target.diagnostics().adapted_bias_walk_rad_s_per_sqrt_s
    assert abs(np.log(found / stated)) > 0.1
    assert difference(q, run.q_nb) < 1e-10
    assert np.nanmax(np.abs(bias - run.gyro_bias_rad_s)) < 1e-10 and np.nanmax(np.abs(sigma - run.sigma_rad)) < 1e-10


def test_the_library_is_the_reference_on_a_real_recording(broad_trial):
    m = broad_trial.cropped(2)
    options = Options("hrekf", solver_rtol=1e-12, solver_atol=1e-14)
    run = Filter(options).run(m.t_s, m.rate_b_rad_s, m.force_b_m_s2, m.field_b_tesla)
    q, bias, _ = run_reference(m.t_s, m.rate_b_rad_s, m.force_b_m_s2, m.field_b_tesla, options)
    assert difference(q, run.q_nb) < 1e-10
    assert np.nanmax(np.abs(bias - run.gyro_bias_rad_s)) < 1e-10


def test_the_printed_equations_lose_the_bias_off_level_and_the_corrected_ones_find_it():
    """Equation (9), wrong side: a level body hides it, at 20 deg of tilt it costs degrees per second."""
    assert bias_error_deg_s(0, "kinematics", 25) < 0.1
    assert bias_error_deg_s(20, "kinematics", 25) > 1
    assert bias_error_deg_s(20, "all", 25) > 1
    assert bias_error_deg_s(20, "", 25) < 0.1
