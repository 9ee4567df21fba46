"""Navigation with hindsight: never worse than the filter, as good as it says, from the first sample on, to the filter's last row."""

from dataclasses import replace

import numpy as np
import pytest

import hnav
from hnav import earth
from hnav.filters.ins_answers import PHASES, InsRun
from hnav.systems.navigation_views import wrapped
from studies.ins import faults, hindsight
from studies.ins.faults import FAULTS
from studies.ins.vehicles import fixes, vehicle

FAST = {"solver": "closed_form"}
NAVIGATING = PHASES.index("navigating")


@pytest.fixture(scope="module")
def drive():
    return vehicle("car", "industrial", 11, 40.0)


def both(samples, aids=None, grade="industrial", **options):
    arrays = samples.t_s, samples.rate_b_rad_s, samples.force_b_m_s2, samples.aids if aids is None else aids
    return (getattr(hnav.Ins(grade, **FAST, **options), call)(*arrays) for call in ("run", "smooth"))


def arrays_of(run):
    return {name: value for name, value in vars(run).items() if isinstance(value, np.ndarray)}


def received(aids, late_s, until_s):
    """The samples of up to a time, received later."""
    valid, _, sensor, value = aids.arrays()
    rows = valid <= until_s
    return fixes(valid[rows], sensor[rows], value[rows], valid[rows] + late_s)


def test_hindsight_is_better_than_the_filter_and_as_good_as_it_says():
    figures = hindsight.summary([hindsight.compared("car", "industrial", 7_000_000 + i) for i in range(3)])
    filtered, smoothed = figures
    before, after, middle = range(3)
    assert (smoothed[after, :3] < [0.5, 0.5, 0.95] * filtered[after, :3]).all()
    assert (smoothed[middle, :3] < 0.9 * filtered[middle, :3]).all()
    assert (smoothed[before:middle, 0] < 0.3).all() and (smoothed[:, 2] < 2).all()
    assert (smoothed[after:, 3:] < 2.5).all() and (smoothed[after:, 3:] > 0.2).all()


def test_an_outage_of_half_a_minute_costs_little_in_its_middle():
    samples, truth = vehicle("aircraft", "consumer", 5, 150.0)
    begin, end = samples.t_s[0] + 100, samples.t_s[0] + 130
    valid = samples.aids.arrays()[0]
    silent = FAULTS["outage_30"].of(samples, samples.t_s < 0, (valid > begin) & (valid <= end))
    middle = np.abs(samples.t_s - 115) < 2 + samples.t_s[0]
    rms, sigma = [], []
    for run in both(silent, grade="consumer"):
        off = np.linalg.norm(earth.position_of(run.place[middle]) - truth.position_e[middle], axis=1)
        rms.append(np.sqrt(np.mean(off**2)))
        sigma.append(run.sigma_position_m[middle].max())
    assert rms[1] < 4 and sigma[1] < sigma[0]


@pytest.mark.parametrize("kind, fault", [("car", "rate_bias"), ("car", "force_bias"), ("aircraft", "force_bias")])
def test_a_step_of_the_sensors_leaves_the_smoother_no_worse_than_the_filter(kind, fault):
    """A second pass over such a recording contradicts the samples, so the smoother keeps the first one. Positions have slow errors of metres
    in either, so the law holds for the mean of some recordings."""
    rms = [faults.in_hindsight(faults.simulated(kind, 3_000_000 + k), fault)[0] for k in range(4)]
    for what in ("position", "tilt", "heading"):
        before, after = np.mean([np.square(one[what]) for one in rms], axis=0)
        assert after < before, what


def test_a_second_pass_over_false_steps_is_given_up():
    for kind, seed in (("aircraft", 3_000_046), ("ship", 3_000_060)):
        means = np.sqrt(hindsight.compared(kind, "industrial", seed))
        assert means[1, 1, 2] < means[0, 1, 2] and means[1, 1, 0] < means[0, 1, 0], kind


@pytest.mark.parametrize(
    "kind, seeds, fault", [("car", range(1, 6), "late"), ("car", [3_000_004], "late"), ("walker", [3], "rate_bias")]
)
def test_hindsight_of_an_inconsistent_filter_is_no_worse_and_not_ready(kind, seeds, fault):
    """What an inconsistency adds to the errors is a factor of the transition too: without it the car's position is 300 m off and ready.
    Where hindsight is beyond three sigmas of the filter, an error has stepped, and nothing is ready; beyond ten sigmas it ends: without that
    the second car is 8 km off."""
    found = [faults.in_hindsight(faults.simulated(kind, seed), fault) for seed in seeds]
    for what in ("heading", "position"):
        before, after = np.sqrt(np.mean([np.square(rms[what]) for rms, _ in found], axis=0))
        assert after < 1.1 * before
    assert max(lies[what][1] - lies[what][0] for _, lies in found for what in faults.FLAGS) < 0.03


def test_an_uncertain_heading_leaves_the_tilt_a_sigma():
    """The prediction turns the tilt with an unknown drift of the heading. Hindsight that did not left 0.02 deg, of other ships 0."""
    samples, _ = vehicle("ship", "consumer", 2, 200.0)
    run = hnav.Ins("consumer", **FAST).smooth(samples.t_s, samples.rate_b_rad_s, samples.force_b_m_s2, samples.aids)
    assert np.nanmin(run.sigma_rotation_rad[:, :2]) > np.radians(0.05)


def test_the_last_row_is_the_filters_and_nothing_of_the_filter_moves(drive):
    samples, _ = drive
    filtered, smoothed = both(samples)
    for name, value in arrays_of(filtered).items():
        np.testing.assert_array_equal(value[-1], getattr(smoothed, name)[-1], err_msg=name)
    ins = hnav.Ins("industrial")
    state = ins.save()
    ins.smooth(samples.t_s[:500], samples.rate_b_rad_s[:500], samples.force_b_m_s2[:500], samples.aids)
    assert ins.save() == state


@pytest.mark.parametrize("stamps", ["in bursts", "one far ahead", "two rows swapped", "two receivers", "almost those of rows"])
def test_stamps_are_those_of_a_filter_that_waits(drive, stamps):
    """The last row is the filter's, whatever it makes of the stamps; for hindsight no sample is late."""
    samples, _ = drive
    t, (valid, _, sensor, value) = samples.t_s.copy(), samples.aids.arrays()
    if stamps == "in bursts":
        t = np.ceil(t / 0.05 - 1e-6) * 0.05
    elif stamps == "one far ahead":
        t[len(t) // 2] += 1e5
    elif stamps == "two rows swapped":
        t[500:502] = t[501:499:-1]
    elif stamps == "two receivers":
        value = value + 1e-7 * np.arange(2)[:, None, None]
        valid, sensor, value = np.repeat(valid, 2), np.repeat(sensor, 2), value.transpose(1, 0, 2).reshape(-1, value.shape[-1])
    else:
        valid = valid * (1 + 2 * np.finfo(float).eps)
    filtered, smoothed = both(replace(samples, t_s=t, aids=fixes(valid, sensor, value)), horizon_s=0.1)
    assert filtered.phase[-1] == NAVIGATING
    for name, last in arrays_of(filtered).items():
        if name != "t_s":
            np.testing.assert_array_equal(last[-1], getattr(smoothed, name)[-1], err_msg=name)


def test_rows_from_before_the_heading_was_found_navigate_from_the_first_sample_on():
    samples, truth = vehicle("car", "industrial", 12, 40.0)
    filtered, smoothed = both(samples)
    assert (filtered.phase < NAVIGATING).sum() > 500 and (smoothed.phase == NAVIGATING).all()
    error = wrapped(smoothed.heading_rad - truth.heading_rad())
    assert np.abs(error).max() < np.radians(1.5) and smoothed.ready[:, 1].mean() > 0.99
    assert np.abs(error / smoothed.sigma_rotation_rad[:, 2]).max() < 3
    assert (smoothed.heading_second[:, 1] == 0).all()
    # Rows between corrections, and between pieces of the way back, lie on one path.
    away = np.diff(earth.position_of(smoothed.place), axis=0) - np.diff(truth.position_e, axis=0)
    assert np.abs(away).max() < 0.01


def test_rows_that_are_left_out_and_late_aids_change_nothing(drive):
    samples, _ = drive
    smoothed = list(both(samples))[1]
    arrays = samples.t_s, samples.rate_b_rad_s, samples.force_b_m_s2
    sparse = hnav.Ins("industrial", **FAST).smooth(*arrays, samples.aids, every=10)
    np.testing.assert_array_equal(sparse.place, smoothed.place[9::10])
    np.testing.assert_array_equal(sparse.ready, smoothed.ready[9::10])
    # What comes after the last row is not used.
    here = received(samples.aids, 0, samples.t_s[-1] - 0.3)
    for aids in (received(samples.aids, 0.3, np.inf), received(here, 0.2, np.inf)):
        late = hnav.Ins("industrial", **FAST).smooth(*arrays, aids)
        np.testing.assert_array_equal(hnav.Ins("industrial", **FAST).smooth(*arrays, here).q_nb, late.q_nb)


def test_a_gap_ends_hindsight_and_both_sides_of_it_have_their_own():
    samples, truth = vehicle("car", "industrial", 14, 80.0)
    kept = (samples.t_s < samples.t_s[0] + 40) | (samples.t_s > samples.t_s[0] + 43)
    run = hnav.Ins("industrial", **FAST).smooth(
        samples.t_s[kept], samples.rate_b_rad_s[kept], samples.force_b_m_s2[kept], samples.aids
    )
    error = wrapped(run.heading_rad - truth.heading_rad()[kept])
    assert (run.phase == NAVIGATING).mean() > 0.99
    assert np.abs(error[run.phase == NAVIGATING]).max() < np.radians(2)


def test_a_state_that_is_given_is_where_hindsight_begins():
    squares = []
    for seed in range(11, 15):
        samples, truth = vehicle("car", "industrial", seed, 40.0)
        heading = truth.heading_rad()[0]
        q_nb = [np.cos(heading / 2), 0, 0, np.sin(heading / 2)]
        runs = list(both(samples, start="state", start_q_nb=q_nb, start_sigma_velocity_m_s=30.0))
        navigating = runs[0].phase == NAVIGATING
        np.testing.assert_array_equal(runs[1].phase, runs[0].phase)
        squares.append([np.mean(wrapped(run.heading_rad - truth.heading_rad())[navigating] ** 2) for run in runs])
    filtered, smoothed = np.sqrt(np.mean(squares, axis=0))
    assert smoothed < 0.5 * filtered


def test_where_no_heading_is_found_the_rows_are_those_of_the_filter():
    n = 2000
    t = np.arange(n) * 0.01
    rate, force = np.zeros((n, 3)), np.tile([0.0, 0, -9.81], (n, 1))
    aids = hnav.Aids().position(t[::100], np.full(20, 0.8), np.full(20, 0.2), np.full(20, 100.0), 1.0)
    ins = hnav.Ins("industrial", **FAST)
    runs = [hnav.Ins("industrial", **FAST).run(t, rate, force, aids), ins.smooth(t, rate, force, aids)]
    assert (runs[0].phase < NAVIGATING).all()
    for name, value in arrays_of(runs[0]).items():
        np.testing.assert_array_equal(value, getattr(runs[1], name), err_msg=name)
    nothing = ins.smooth([], np.empty((0, 3)), np.empty((0, 3)))
    assert isinstance(nothing, InsRun) and len(nothing.t_s) == 0


def test_what_cannot_be_smoothed_is_said_with_its_row():
    ins = hnav.Ins("industrial")
    with pytest.raises(hnav.HnavRuntimeError, match="row 2: t_s = 0.01 s is before that of the row before it"):
        ins.smooth([0, 0.02, 0.01], np.array([[0.0] * 3, [0.0] * 3, [np.nan] * 3]), np.ones((3, 3)))
    with pytest.raises(hnav.HnavValueError, match="every = 0"):
        ins.smooth([0], np.zeros((1, 3)), np.ones((1, 3)), every=0)
