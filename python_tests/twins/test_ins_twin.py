"""The navigation filter in C beside its twin in NumPy."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import hnav
from hnav import earth
from studies.ins.vehicles import fields as fields_of
from studies.ins.vehicles import vehicle
from twins.ins import InsReference

STATED_M = (InsReference.SIGMA_M, 1.0, 4.0, 20.0, 0.1, 2.0)
"""The stated sigma of each fix in turn."""


@pytest.mark.parametrize(
    "kind, magnetometer, other_s",
    [
        ("car", False, 0.0),
        ("aircraft", False, 0.0),
        ("quadrotor", False, 0.0),
        ("car", True, 0.0),
        ("aircraft", True, 0.0),
        ("car", True, 2.0),
        ("car", True, 6.0),
    ],
)
def test_the_twin_navigates_as_the_library_does(kind, magnetometer, other_s):
    """other_s: seconds with another field, which the filter rejects for 4 s and then accepts."""
    samples, truth = vehicle(kind, "industrial", 4, 20.0)
    fields = dict(zip(*fields_of(np.random.default_rng(4), truth))) if magnetometer else {}
    fields = {t_s: (4 if 0 < t_s - truth.t_s[0] - 8 < other_s else 1) * field for t_s, field in fields.items()}
    t, rate, force = samples.t_s, samples.rate_b_rad_s, samples.force_b_m_s2
    axes = earth.axes_at(earth.place_of(truth.position_e))
    attitude = Rotation.from_matrix(np.swapaxes(axes, 1, 2) @ truth.attitude_e.as_matrix())
    velocity = np.einsum("nij,ni->nj", axes, truth.velocity_e)
    start = (attitude[1] * Rotation.from_rotvec([0.01, -0.02, 0.03])).as_quat(scalar_first=True)
    options = hnav.Options(
        "ins", "industrial", start="state", start_q_nb=tuple(start), start_velocity_n_m_s=tuple(velocity[1]), solver="closed_form",
        gyro_hold="forward", rest_rate_rad_s=0.0, gate_nis=200.0 if other_s else 0.0, gate_longest_s=4.0, start_sigma_velocity_m_s=1.0, declination_rad=0.1,
        antenna_b_m=(0.4, -0.2, -0.8),
    )  # fmt: skip
    ins, twin = hnav.Ins(options), None
    rng = np.random.default_rng(1)
    for i in range(len(t)):
        ins.push_imu(t[i], rate[i], force[i])
        fixed, sigma_m = i % 20 == 1, STATED_M[i // 20 % len(STATED_M)]
        if fixed:
            place = earth.place_of(truth.position_e[i] + sigma_m * rng.standard_normal(3))
            seen = velocity[i] + 0.1 * rng.standard_normal(3)
            ins.push_velocity(t[i], seen, InsReference.SIGMA_M_S)
            ins.push_position(t[i], *place, sigma_m)
        if t[i] in fields:
            ins.push_mag(t[i], fields[t[i]])
        ins.advance(t[i])
        if twin is None:
            twin = InsReference(options, t[i], place, rate[:2], force[:2], t[i] - t[0]) if fixed else None
        else:
            twin.advance(t[i], rate[i], force[i], *((seen, place) if fixed else (None, None)), fields.get(t[i]), sigma_m)
        if fixed and i > 1:
            now = ins.navigation()
            assert now.phase == "navigating"
            sigma = np.sqrt(np.diag(twin.P)[:15])
            off = now.position_e_m - (twin.anchor_e + twin.T @ twin.d)
            np.testing.assert_allclose(off, 0, atol=1e-7)
            np.testing.assert_allclose(now.velocity_e_m_s, twin.T @ twin.v, atol=1e-8)
            np.testing.assert_allclose(now.gyro_bias_rad_s, twin.gyro_bias, atol=1e-10)
            np.testing.assert_allclose(now.accel_bias_m_s2, twin.accel_bias, atol=1e-8)
            np.testing.assert_allclose(now.latency_s, twin.latency, atol=1e-9)
            R = (
                earth.axes_at(np.array([now.latitude_rad, now.longitude_rad, now.height_m]))
                @ Rotation.from_quat(now.q_nb, scalar_first=True).as_matrix()
            )
            np.testing.assert_allclose(R, twin.T @ twin.R, atol=1e-10)
            np.testing.assert_allclose(
                ins.covariance() / np.outer(sigma, sigma), twin.P[:15, :15] / np.outer(sigma, sigma), atol=1e-7
            )
    left_out = ins.diagnostics().gated["mag"]
    assert left_out == pytest.approx(10 * min(other_s, 4.0) + (40 if other_s > 4.0 else 0), abs=3)
