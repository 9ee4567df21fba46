"""The turntable from Python: kinematics against finite differences, corners, options."""

import math
import pickle

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hnav import HnavError, HnavValueError
from hnav.native.options import option_rows
from hnav.simulation.turntable import Truth, Turntable, TurntableOptions

SWING = dict(
    yaw_motion="sine", yaw_amplitude_rad=1.0, roll_motion="sine", roll_amplitude_rad=0.4, roll_period_s=3, pitch_angle_rad=0.3
)


def rotation(truth: Truth) -> Rotation:
    return Rotation.from_quat(truth.q_nb[[1, 2, 3, 0]])


@pytest.mark.parametrize("t_s", [0.2, 0.7, 4.1])
def test_the_rate_is_the_derivative_of_the_attitude(t_s):
    table, step = Turntable(**SWING), 1e-5
    turned = (rotation(table.at(t_s - step)).inv() * rotation(table.at(t_s + step))).as_rotvec() / (2 * step)
    np.testing.assert_allclose(table.at(t_s).rate_b_rad_s, turned, atol=1e-8)
    assert np.linalg.norm(turned) > 0.1


def test_force_and_field_are_gravity_and_the_field_of_the_place_in_body_axes():
    truth = Turntable(**SWING, field_dip_rad=math.radians(60), field_strength_tesla=5e-5).at(1.3)
    np.testing.assert_allclose(rotation(truth).apply(truth.force_b_m_s2), [0, 0, -9.80665], atol=1e-12)
    field_n = 5e-5 * np.array([0.5, 0, math.sqrt(0.75)])
    np.testing.assert_allclose(rotation(truth).apply(truth.field_b_tesla), field_n, atol=1e-18)
    np.testing.assert_allclose(rotation(truth).as_euler("ZYX")[::-1], truth.euler_rad, atol=1e-12)
    assert truth.t_s == 1.3


def test_what_a_body_reads_depends_on_its_attitude_alone():
    table = Turntable(**SWING)
    truth = table.at(2.0)
    force, field = table.seen_from(3 * truth.q_nb)
    np.testing.assert_allclose(force, truth.force_b_m_s2, atol=1e-12)
    np.testing.assert_allclose(field, truth.field_b_tesla, atol=1e-18)


def test_a_triangle_has_corners_and_goes_on_without_them_in_its_piece():
    table = Turntable(yaw_motion="triangle", yaw_amplitude_rad=0.5, yaw_rate_rad_s=0.25)
    corner = table.next_corner_s(0.0)
    assert corner == pytest.approx(2.0)
    before, after = table.in_piece(0.0, corner + 1), table.at(corner + 1)
    assert before.euler_rad[2] == pytest.approx(0.75) and after.euler_rad[2] == pytest.approx(0.25)
    assert Turntable(yaw_motion="constant").next_corner_s(0.0) == math.inf


def test_equal_options_make_equal_tables():
    table = Turntable(TurntableOptions(yaw_motion="sine", yaw_unknown_rad=0.2, seed=4))
    assert pickle.loads(pickle.dumps(table)).at(1.0) == table.at(1.0)
    assert table.options == TurntableOptions(yaw_motion="sine", yaw_unknown_rad=0.2, seed=4)
    assert Turntable(table.options, **{}).at(1.0) != Turntable(yaw_motion="sine", yaw_unknown_rad=0.2, seed=5).at(1.0)
    assert repr(table.options) == "TurntableOptions(yaw_motion='sine', yaw_unknown_rad=0.2, seed=4)"


@pytest.mark.parametrize("call, named", [
    (lambda: Turntable(yaw_motion="spin"), "yaw_motion = spin: choose one of constant, step, sine, triangle"),
    (lambda: Turntable(yaw_period_s=-1), "yaw.period_s"),
    (lambda: Turntable(yaw=1), "no option yaw"),
    (lambda: Turntable(TurntableOptions(), seed=1), "TurntableOptions are complete"),
    (lambda: Turntable().at(math.nan), "t_s"),
    (lambda: Turntable().seen_from([1, 0, 0]), "q_nb has the shape"),
])  # fmt: skip
def test_what_cannot_be_is_named(call, named):
    with pytest.raises(HnavValueError, match=named):
        call()


def test_options_are_described():
    assert {"yaw.motion", "gravity_m_s2", "seed"} <= set(option_rows("turntable"))
    with pytest.raises(HnavError):
        TurntableOptions(**{"yaw.motion": "sine"})
