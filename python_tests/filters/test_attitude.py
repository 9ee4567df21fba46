"""The attitude filters from Python: laws, and the errors that a caller gets."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hnav import Filter, HnavError, Options
from hnav.filters.options import FILTERS, option_table
from hnav.reports.scores import errors_rad, score
from motion import readings, tilted_motion, turning

NOISE = dict(accel_noise_per_sqrt_hz=1e-3, mag_noise_per_sqrt_hz=1e-3, gyro_noise_rad_per_sqrt_s=1e-3)


def push(f: Filter, m, k: int) -> None:
    f.push_imu(m.t_s[k], m.rate_b_rad_s[k], m.force_b_m_s2[k])
    f.push_mag(m.t_s[k], m.field_b_tesla[k])


def numbers(record) -> str:
    """All digits of a result."""
    return repr([np.asarray(value).tolist() for value in vars(record).values()])


def test_options_are_read_and_written_by_name():
    o = Options("hrekf", "paper", gamma_mode="kl", start_q_nb=[0.5, 0.5, 0.5, 0.5], queue_capacity=10)
    assert (o.gamma_mode, o.solver, o.queue_capacity) == ("kl", "euler", 10)
    assert o.start_q_nb == (0.5,) * 4
    assert o.quaternion_noise_per_sqrt_s == 1e-3
    o.gamma = "2.5"
    assert o.gamma == 2.5


@pytest.mark.parametrize("name, value, named", [
    ("no_such_option", 1, "no_such_option"),
    ("gamma_mode", "sideways", "off, fixed, relative, kl"),
    ("start_q_nb", [1, 0], "4 numbers"),
    ("gamma", "abc", "not a number"),
    ("queue_capacity", "2.5", "whole number"),
])  # fmt: skip
def test_wrong_options_are_named(name, value, named):
    with pytest.raises(HnavError, match=named):
        Options("hrekf", **{name: value})


@pytest.mark.parametrize("filter", FILTERS)
def test_impossible_options_are_refused_by_the_library_with_their_name(filter):
    for info in option_table(filter).values():
        if info.choices:
            continue
        value = info.max * 1.01 + 1 if info.max > 0 else 1.0
        with pytest.raises(HnavError, match=info.name) as error:
            Filter(Options(filter, **{info.name: [value] * info.count if info.count > 1 else value}))
        assert (error.value.status, error.value.argument) == ("option", info.name)


def test_sigma_covers_the_error_of_a_wrong_gyro_hold():
    """Rates of 10 rad/s that act an interval later than stated: the attitude is up to an interval's turn off."""
    m = tilted_motion(60, bias=(0.005, -0.008, 0.003)).recording
    shown = slice(4000, None)

    def run(hold: str) -> tuple[np.ndarray, np.ndarray]:
        r = Filter(Options("ahrs", gyro_hold=hold)).run(m.t_s, m.rate_b_rad_s, m.force_b_m_s2, m.field_b_tesla)
        inclination = errors_rad(r.q_nb[shown], m.reference_q_nb[shown])[2]
        return inclination, np.hypot(*r.sigma_rad[shown, :2].T)

    (right, right_sigma), (wrong, wrong_sigma) = run("forward"), run("backward")
    assert np.sqrt(np.mean(wrong**2)) > 10 * np.sqrt(np.mean(right**2))
    assert np.mean(wrong < 3 * wrong_sigma) > 0.99
    assert wrong_sigma[-1] > 1.2 * right_sigma[-1]


def run_of_readings(rate_hz: float, faster: float, duration_s: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Error (rad), its sigma and the flags after 30 s, of rates, forces and fields that are read at instants while the body turns."""
    t = np.arange(0, duration_s, 1 / rate_hz)
    rate, force, field = readings(faster * t, noise=0.3)
    run = Filter(Options("ahrs")).run(t, faster * rate, force, field)
    shown = t > 30
    error = (Rotation.from_quat(run.q_nb[shown][:, [1, 2, 3, 0]]) * turning(faster * t[shown]).inv()).as_rotvec()
    return error, run.sigma_rad[shown], run.ready[shown]


@pytest.mark.parametrize("rate_hz", [25, 50, 100])
def test_sigma_covers_rates_that_are_readings_of_their_instant(rate_hz):
    """Half an interval early, as force and field are: nothing in the samples shows it."""
    error, sigma, _ = run_of_readings(rate_hz, 2.5, 90)
    assert np.mean(error**2 / sigma**2) < 1.5


@pytest.mark.parametrize("rate_hz", [25, 40])
def test_a_tilt_that_leads_by_half_an_interval_is_not_ready(rate_hz):
    """The body turns by up to 500 deg/s: the flag follows sigma."""
    error, _, ready = run_of_readings(rate_hz, 14, 60)
    off = np.hypot(error[:, 0], error[:, 1]) > np.radians(3)
    assert np.mean(off) > 0.2
    assert np.mean(off & ready[:, 0]) < 0.03


def test_a_batch_run_is_push_and_advance_row_by_row(motion):
    m = motion.recording
    options = Options("hrekf", start_samples=1, **NOISE)  # started by the first row
    run = Filter(options).run(m.t_s, m.rate_b_rad_s, m.force_b_m_s2, m.field_b_tesla)
    f = Filter(options)
    for k in range(len(m.t_s)):
        push(f, m, k)
        f.advance(m.t_s[k])
        a = f.attitude()
        assert list(a.q_nb) == list(run.q_nb[k]) and list(a.sigma_rad) == list(run.sigma_rad[k])
        assert list(a.euler_rad) == list(run.euler_rad[k])
        bias, sigma = f.gyro_bias()
        assert (bias == run.gyro_bias_rad_s[k]).all() and (sigma == run.gyro_bias_sigma_rad_s[k]).all()
    assert f.innovation("accel").nis == run.accel_nis[-1]
    assert f.innovation("mag").dimension == 3
    np.testing.assert_allclose(np.sqrt(np.diag(f.covariance()))[:3], run.sigma_rad[-1])
    status = f.diagnostics()
    assert status.started and list(status.used.values())[:3] == [len(m.t_s)] * 3 and status.solver_rhs_evals > 0


def test_the_same_samples_give_the_same_bits_for_every_advance_pattern(motion):
    m = motion.recording
    posteriors = set()
    for step in (0.01, 0.0037, 0.0173, 1.0, None):
        rng = np.random.default_rng(1)
        f = Filter(Options("hrekf", queue_capacity=300, **NOISE))
        t, k = 0.0, 0
        while t < 3:
            t = min(3.0, t + (step or rng.uniform(1e-4, 0.1)))
            while k < len(m.t_s) and m.t_s[k] <= t:
                push(f, m, k)
                k += 1
            f.advance(t)
        posteriors.add(numbers(f.posterior()))
    assert len(posteriors) == 1


_CONTINUE = """
import sys
sys.path[:0] = {folders!r}
from motion import tilted_motion
from hnav import Filter, Options
from test_attitude import NOISE, numbers, push
m = tilted_motion(1).recording
f = Filter(Options("hrekf", **NOISE))
f.load(open({file!r}, "rb").read())
for k in range(50, 100):
    push(f, m, k)
    f.advance(m.t_s[k] + 0.002)
print(numbers(f.posterior()))
"""


def test_a_saved_filter_goes_on_bit_for_bit_in_a_new_process(tmp_path):
    m = tilted_motion(1).recording
    f = Filter(Options("hrekf", **NOISE))
    for k in range(100):
        push(f, m, k)
        f.advance(m.t_s[k] + 0.002)
        if k == 49:
            state = f.save()
    file = tmp_path / "state.bin"
    file.write_bytes(state)
    here = Path(__file__).parent
    code = _CONTINUE.format(folders=[str(here), str(here.parent)], file=str(file))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.strip() == numbers(f.posterior()), done.stderr
    f.load(state)  # wrecked by fifty samples, and back
    with pytest.raises(HnavError, match="damaged|options"):
        Filter(Options("hrekf")).load(state)


def test_errors_carry_the_message_of_the_object(motion):
    f = Filter(Options("hrekf"))
    for call, status, words in (
        (lambda: f.push_gyro(0, [0, np.nan, 0]), "non-finite", "gyro"),
        (lambda: f.push_mag(0, [0, 0, 0]), "zero vector", "mag"),
        (lambda: f.push_heading(0, 0.1, -1), "out of range", "sigma_rad"),
        (lambda: f.attitude(), "not started", "no attitude"),
        (lambda: f.innovation("accel"), "no data", "accel"),
        (lambda: f.load(b"short"), "size", "bytes"),
        (lambda: f.push_accel(0, [1, 2]), "size", "force_b_m_s2"),
    ):  # fmt: skip
        with pytest.raises(HnavError, match=words) as error:
            call()
        assert error.value.status == status
    f.advance(1)
    with pytest.raises(HnavError, match="before the last advance"):
        f.advance(0)


def test_the_hybrid_view_integrates_to_the_same_estimate(motion):
    from scipy.integrate import solve_ivp

    m = motion.recording
    inside = Filter(Options("hrekf", **NOISE)).run(m.t_s[:30], m.rate_b_rad_s[:30], m.force_b_m_s2[:30], m.field_b_tesla[:30])
    f = Filter(Options("hrekf", **NOISE))
    x = f.get_x()
    for k in range(30):
        if k:
            x = solve_ivp(f.derivative, (m.t_s[k - 1], m.t_s[k]), x, method="DOP853", rtol=1e-11, atol=1e-14).y[:, -1]
        push(f, m, k)
        assert f.next_event_s() == m.t_s[k]
        x = f.jump(m.t_s[k], x)
    np.testing.assert_allclose(f.posterior().q_nb, inside.q_nb[-1], atol=1e-8)
    assert (f.nominal_x() > 0).all()
    seed = np.random.default_rng(1).normal(size=14)
    central = (f.derivative(0, x + 1e-5 * seed) - f.derivative(0, x - 1e-5 * seed)) / 2e-5
    np.testing.assert_allclose(f.derivative_along(0, x, seed), central, atol=1e-8)


def test_smoothing_improves_the_tilt_and_leaves_no_row_out(broad_trial):
    t = broad_trial
    arrays = (t.t_s, t.rate_b_rad_s, t.force_b_m_s2, t.field_b_tesla)
    f = Filter(Options("ahrs", navigation_frame="enu", solver="closed_form"))
    forward, smoothed = f.run(*arrays), f.smooth(*arrays)
    inclination = [score(r.q_nb, t.reference_q_nb, t.movement).inclination for r in (forward, smoothed)]
    assert inclination[1] < 0.95 * inclination[0]
    assert np.isfinite(smoothed.q_nb).all()
    assert np.median(smoothed.sigma_rad[:, :2]) < np.nanmedian(forward.sigma_rad[:, :2])
    assert f.diagnostics().corrections == 0  # the filter is reset


def test_smoothing_goes_by_the_closed_form_whatever_the_solver_and_the_filter_goes_on_by_its_own(motion):
    m = motion.recording
    arrays = (m.t_s, m.rate_b_rad_s, m.force_b_m_s2, m.field_b_tesla)
    by_solver, exact = (Filter(Options("ahrs", solver=solver)) for solver in ("erkstep", "closed_form"))
    there, here = by_solver.smooth(*arrays), exact.smooth(*arrays)
    for name in ("q_nb", "sigma_rad", "gyro_bias_rad_s", "ready"):
        np.testing.assert_array_equal(getattr(there, name), getattr(here, name), name)
    assert by_solver.diagnostics().solver_steps == 0
    by_solver.run(*arrays)
    assert by_solver.diagnostics().solver_steps > 0


def test_smoothing_does_not_depend_on_the_direction_of_time(motion):
    """Turned round, a recording of rates held backward holds them forward, and gives the same attitudes."""
    m = motion.recording
    # Three seconds are too short to estimate the latency of the forces.
    known = {"start_accel_latency": 0.0, "start_sigma_accel_latency": 1e-3}
    there = Filter(Options("ahrs", **known)).smooth(m.t_s, m.rate_b_rad_s, m.force_b_m_s2, m.field_b_tesla)
    back = Filter(Options("ahrs", gyro_hold="forward", **known)).smooth(
        m.t_s[-1] - m.t_s[::-1], -m.rate_b_rad_s[::-1], m.force_b_m_s2[::-1], m.field_b_tesla[::-1]
    )
    total, _, _ = errors_rad(back.q_nb[::-1], there.q_nb)
    assert np.degrees(total).max() < 1.0


def test_what_cannot_smooth_says_so(motion):
    m = motion.recording
    with pytest.raises(HnavError, match="smoother") as error:
        Filter(Options("hrekf")).smooth(m.t_s, m.rate_b_rad_s, m.force_b_m_s2, m.field_b_tesla)
    assert error.value.status == "unsupported"
    with pytest.raises(HnavError, match="nothing to smooth"):
        Filter(Options("ahrs")).smooth(m.t_s, m.rate_b_rad_s)


def test_realigning_forgets_the_attitude_and_keeps_bias_and_counters(motion):
    m = motion.recording
    f = Filter(Options("hrekf"))
    f.run(m.t_s, m.rate_b_rad_s, m.force_b_m_s2, m.field_b_tesla)
    bias, used = f.gyro_bias()[0], f.diagnostics().used
    f.realign()
    assert not f.diagnostics().started and f.diagnostics().used == used
    assert (f.gyro_bias()[0] == bias).all() and (f.rate() == m.rate_b_rad_s[-1] - bias).all()
    with pytest.raises(HnavError, match="no attitude"):
        f.covariance()


def test_the_gyroscope_calibration_is_a_matrix_with_its_sigmas(motion):
    m = motion.recording
    f = Filter(Options("ahrs"))
    matrix, sigma = f.gyro_calibration()
    assert (matrix == 0).all() and (np.diag(sigma) > 0).all()
    f.run(m.t_s, m.rate_b_rad_s, m.force_b_m_s2, m.field_b_tesla)
    learnt, after = f.gyro_calibration()
    assert learnt.shape == (3, 3) and np.diag(after).min() < np.diag(sigma).min()
    assert (Filter(Options("hrekf")).gyro_calibration()[1] == 0).all()


def test_a_heading_by_another_source_turns_the_estimate(motion):
    m = motion.recording.cropped(1)
    f = Filter(Options("hrekf"))
    f.run(m.t_s, m.rate_b_rad_s, m.force_b_m_s2, m.field_b_tesla)
    heading = f.attitude().heading_rad
    f.push_heading(1.0, heading + 0.01, 1e-4)
    f.advance(1.0)
    assert f.attitude().heading_rad == pytest.approx(heading + 0.01, abs=2e-3)
    assert f.diagnostics().used["heading"] == 1 and f.innovation("heading").dimension == 1


@pytest.mark.parametrize("off_deg", [90, 150, -100])
def test_a_heading_that_a_true_field_turns_makes_no_tilt_known(off_deg):
    """With the accelerometer's bias unknown, the tilt is 1.5 deg off while the body stands; the first field is a false one."""
    t_s = np.arange(0, 25, 0.01)
    moves = np.clip((t_s - 15) / 3, 0, 1)
    yaw, roll = 0.6 * moves * np.sin(0.5 * (t_s - 15)), 0.1 * moves * np.sin(0.8 * (t_s - 15))
    true = Rotation.from_euler("ZYX", np.stack([yaw, 0 * t_s, roll], 1))
    rate = np.zeros((len(t_s), 3))
    rate[1:] = 100 * (true[:-1].inv() * true[1:]).as_rotvec()
    force = true.inv().apply([0, 0, -9.81]) + [0.15, -0.2, 0]
    north = np.array([20e-6, 0, 45e-6])
    false = Rotation.from_euler("z", off_deg, degrees=True).apply(north)
    field = true.inv().apply(np.where(t_s[:, None] < 8, false, north))
    run = Filter("ahrs", start_sigma_accel_bias_m_s2=0.3).run(t_s, rate, force, field)
    off = (true[-1] * Rotation.from_quat(run.q_nb[-1], scalar_first=True).inv()).as_rotvec()[:2]
    assert np.hypot(*off) < 2 * np.hypot(*run.sigma_rad[-1, :2])
    assert abs(np.degrees(run.euler_rad[-1, 2]) - np.degrees(yaw[-1])) < 5


def test_the_hybrid_view_shows_a_state_of_the_caller(motion):
    m = motion.recording.cropped(1)
    f = Filter(Options("hrekf"))
    f.run(m.t_s, m.rate_b_rad_s, m.force_b_m_s2, m.field_b_tesla)
    x = f.get_x()
    x[:4] = [0.6, 0, 0.8, 0]
    f.show(1.5, x)
    np.testing.assert_allclose(f.attitude().q_nb, [0.6, 0, 0.8, 0], atol=1e-15)
    assert f.attitude().t_s == 1.5
