"""A magnetometer in the navigation filter: iron is found, headings are held, and motion prevails over a false field."""

import copy
import pickle

import numpy as np
import pytest

import hnav
from driven import push_aid
from hnav.filters.ins_answers import PHASES
from hnav.filters.ins_recording import NavigationRun, inertial_rows
from hnav.io.recordings import Recording
from hnav.native.library import SENSORS
from hnav.systems.navigation_views import wrapped
from studies.ins.vehicles import fixes, vehicle

FAST = {"solver": "closed_form"}
LATE_S = 0.15


@pytest.fixture(scope="module")
def hovering():
    return vehicle("quadrotor", "consumer", 3, 60.0, magnetometer=True)


@pytest.fixture(scope="module")
def driving():
    return vehicle("car", "industrial", 11, 60.0, magnetometer=True)


def with_fields(samples, change, late_s=0.0):
    """The aids with other fields, received later; none: without them."""
    valid, _, sensor, value = samples.aids.arrays()
    aids = fixes(valid, sensor, value)
    rows = sensor == SENSORS.index("mag")
    return aids.mag(valid[rows], change(value[rows, :3]), valid[rows] + late_s) if change else aids


def fields_until(samples, until_s, late_s):
    """The aids, without fields after a time from the begin on."""
    valid, _, sensor, _ = samples.aids.arrays()
    seen = valid[sensor == SENSORS.index("mag")] - samples.t_s[0] <= until_s
    return with_fields(samples, lambda m: np.where(seen[:, None], m, np.nan), late_s)


def run_of(samples, aids, grade="consumer", call="run", **options):
    return getattr(hnav.Ins(grade, **FAST, **options), call)(samples.t_s, samples.rate_b_rad_s, samples.force_b_m_s2, aids)


def rms_deg(run, truth, late=0.5):
    error = wrapped(run.heading_rad - truth.heading_rad())[int(late * len(run.t_s)) :]
    return float(np.degrees(np.sqrt(np.mean(error**2))))


def assert_equal(one, other, rows=slice(None)):
    for name in ("q_nb", "place", "velocity_n_m_s", "sigma_rotation_rad", "gyro_bias_rad_s"):
        np.testing.assert_array_equal(getattr(one, name)[rows], getattr(other, name)[rows])


def test_bodies_that_turn_find_their_iron_and_by_it_their_heading():
    rms = []
    for seed in range(20, 36):
        samples, truth = vehicle("walker", "consumer", seed, 60.0, magnetometer=True)
        changes = (None, lambda m: m, lambda m: m + 3e-5)
        rms.append([rms_deg(run_of(samples, with_fields(samples, change)), truth) for change in changes])
    without, found, with_iron = np.sqrt(np.mean(np.square(rms), axis=0))
    assert found < 0.65 * without
    assert abs(with_iron - found) < 0.2 * found


def test_the_unit_of_the_field_is_free(hovering):
    samples, _ = hovering
    assert_equal(*(run_of(samples, with_fields(samples, lambda m, unit=unit: unit * m)) for unit in (1.0, 2.0**20)))


def test_the_declination_turns_the_field(hovering):
    samples, _ = hovering
    off = 0.4
    options = dict(field_direction_rad=0.02, start_sigma_iron=0.3)
    runs = [run_of(samples, with_fields(samples, lambda m: m), declination_rad=d, **options) for d in (0.0, off)]
    turned = wrapped(runs[1].heading_rad - runs[0].heading_rad)[len(samples.t_s) // 2]
    assert 0.8 * off < turned < 1.1 * off


def test_what_is_known_by_motion_is_not_spoilt(driving):
    samples, truth = driving
    plain = run_of(samples, with_fields(samples, None), "industrial")
    begin = len(plain.t_s) // 2
    mirrored = run_of(samples, with_fields(samples, lambda m: m * [1, -1, 1]), "industrial")
    jumping = run_of(samples, with_fields(samples, lambda m: m + 4e-5 * (np.arange(len(m)) % 200 > 100)[:, None]), "industrial")
    for run in (mirrored, jumping):
        assert rms_deg(run, truth) < rms_deg(plain, truth) + 0.1
        assert np.array_equal(run.ready[begin:, 1], plain.ready[begin:, 1])
    ins = hnav.Ins("industrial", **FAST)
    ins.run(samples.t_s, samples.rate_b_rad_s, samples.force_b_m_s2, samples.aids)
    seen = ins.diagnostics()
    assert seen.used["mag"] > 500 and seen.gated["mag"] < 0.1 * seen.used["mag"]
    assert 0 < ins.observed().by_field < 2
    assert ins.innovation("mag").dimension == 2


FALSE_S = (20.0, 30.0)


def while_false(samples, change):
    """The fields of the seconds FALSE_S are changed: by m (n x 3) and how far the time has gone, 0 to 1 (n x 1)."""
    valid, _, sensor, _ = samples.aids.arrays()
    seconds = valid[sensor == SENSORS.index("mag")] - samples.t_s[0]
    gone = (seconds - FALSE_S[0]) / (FALSE_S[1] - FALSE_S[0])
    inside = (gone > 0) & (gone < 1)
    return lambda m: np.where(inside[:, None], change(m, gone[:, None]), m)


@pytest.mark.parametrize(
    "change",
    [
        lambda m, _: 1.5 * m,
        lambda m, _: 0.5 * m,
        lambda m, gone: m * (1 + np.minimum(1, 3 * gone)),
        lambda m, _: m + 20e-6 * np.array([0.6, -0.8, 0.0]),
    ],
    ids=["larger", "smaller", "slowly", "beside steel"],
)
def test_a_field_that_changes_by_itself_is_as_good_as_none_even_before_the_heading_is_known(change):
    """The median of five: the likeliest heading of an almost flat density may flip."""
    usually, at_end = [], []
    for seed in (1, 4, 6, 8, 10):
        samples, _ = vehicle("ship", "industrial", seed, 40.0, magnetometer=True)
        runs, left_out = [], []
        for changed in (while_false(samples, change), while_false(samples, lambda m, _: np.nan * m)):
            ins = hnav.Ins("industrial", **FAST)
            aids = with_fields(samples, changed)
            runs.append(ins.run(samples.t_s, samples.rate_b_rad_s, samples.force_b_m_s2, aids))
            left_out.append(ins.diagnostics().gated["mag"])
        assert left_out[0] > 60 and left_out[1] == 0
        off = wrapped(runs[0].heading_rad - runs[1].heading_rad) / runs[1].sigma_rotation_rad[:, 2]
        off = np.abs(off[np.isfinite(off)])
        usually.append(np.quantile(off, 0.9))
        at_end.append(off[-1])
    assert np.median(usually) < 0.05 and np.median(at_end) < 0.05


def test_a_field_that_stays_another_is_accepted_after_a_while(hovering):
    samples, _ = hovering
    used = []
    for longest_s in (5.0, 1e3):
        ins = hnav.Ins("consumer", gate_longest_s=longest_s, **FAST)
        seconds = samples.aids.arrays()[0] - samples.t_s[0]
        seconds = seconds[samples.aids.arrays()[2] == SENSORS.index("mag")]
        aids = with_fields(samples, lambda m, late=seconds > 30: np.where(late[:, None], 3 * m, m))
        ins.run(samples.t_s, samples.rate_b_rad_s, samples.force_b_m_s2, aids)
        used.append(ins.diagnostics().gated["mag"])
    assert used[0] < 80 and used[1] > 250


def test_sigma_covers_false_fields_that_pass_the_gate():
    z2 = []
    for seed in range(40, 48):
        samples, truth = vehicle("quadrotor", "consumer", seed, 60.0, magnetometer=True)
        false = while_false(samples, lambda m, _, seed=seed: m + 20e-6 * np.random.default_rng(seed).standard_normal(3))
        run = run_of(samples, with_fields(samples, false))
        late = samples.t_s - samples.t_s[0] > FALSE_S[0]
        error = wrapped(run.heading_rad - truth.heading_rad())[late]
        z2.append(np.mean((error / run.sigma_rotation_rad[late, 2]) ** 2))
    assert np.mean(z2) < 1.5


def test_a_field_alone_makes_no_heading_ready():
    ins = hnav.Ins("industrial", start_sigma_iron=0.05, **FAST)
    for k in range(6000):
        t = k * 0.02
        ins.push_imu(t, [0, 0, 0], [0, 0, -9.81])
        ins.push_mag(t, [20.0, 0, 40])
        if k % 50 == 0:
            ins.push_position(t, 0.8, 0.2, 100, 1.0)
            ins.push_rest(t, 0.01)
        ins.advance(t)
    now = ins.navigation()
    assert abs(now.euler_rad[2]) < 0.05 and 0.1 < now.sigma_rotation_rad[2] < 0.3
    assert not now.heading_ready and ins.observed().by_field > 1


def test_late_fields_and_restored_filters_give_the_same_bits(driving):
    samples, _ = driving
    aids = with_fields(samples, lambda m: m)
    options = dict(horizon_s=0.3, queue_capacity=300)
    punctual, late = (run_of(samples, fields_until(samples, 55.0, s), "industrial", **options) for s in (0.0, LATE_S))
    all_there = samples.t_s >= samples.t_s[0] + 55.0 + LATE_S
    assert all_there.any()
    assert_equal(punctual, late, all_there)
    half = len(samples.t_s) // 2
    ins = hnav.Ins("industrial", **FAST)
    ins.run(samples.t_s[:half], samples.rate_b_rad_s[:half], samples.force_b_m_s2[:half], aids)
    made = [
        one.run(samples.t_s[half:], samples.rate_b_rad_s[half:], samples.force_b_m_s2[half:])
        for one in (ins, copy.deepcopy(ins), pickle.loads(pickle.dumps(ins)))
    ]
    assert_equal(made[0], made[1])
    assert_equal(made[0], made[2])


def test_times_that_are_asked_for_change_no_bit(hovering):
    samples, _ = hovering
    valid, _, sensor, value = samples.aids.arrays()
    seen = []
    for often in (1, 3):
        ins, aid = hnav.Ins("consumer", **FAST), 0
        for i, t in enumerate(samples.t_s[:2500]):
            ins.push_imu(t, samples.rate_b_rad_s[i], samples.force_b_m_s2[i])
            while aid < len(valid) and valid[aid] <= t:
                push_aid(ins, valid[aid], sensor[aid], value[aid])
                aid += 1
            if i % often == 0:
                ins.advance(t - 0.003 if often == 3 else t)
        ins.advance(samples.t_s[2499])
        seen.append(ins.navigation())
    np.testing.assert_array_equal(seen[0].q_nb, seen[1].q_nb)
    np.testing.assert_array_equal(seen[0].sigma_rotation_rad, seen[1].sigma_rotation_rad)
    assert seen[0].phase == seen[1].phase


@pytest.mark.parametrize("grade, of", [("industrial", "driving"), ("consumer", "hovering")])
def test_hindsight_with_a_magnetometer_is_no_worse(request, grade, of):
    samples, truth = request.getfixturevalue(of)
    aids = with_fields(samples, lambda m: m)
    run, smoothed = (run_of(samples, aids, grade, call) for call in ("run", "smooth"))
    np.testing.assert_array_equal(run.q_nb[-1], smoothed.q_nb[-1])
    if PHASES[run.phase[-1]] == "navigating":
        assert rms_deg(smoothed, truth) < 1.05 * rms_deg(run, truth)
        error = wrapped(smoothed.heading_rad - truth.heading_rad())
        assert np.mean((error / smoothed.sigma_rotation_rad[:, 2])[len(error) // 2 :] ** 2) < 3


def test_a_recording_brings_its_field_along(driving):
    samples, _ = driving
    valid, _, sensor, value = samples.aids.arrays()
    rows = sensor == SENSORS.index("mag")
    field = np.full((len(samples.t_s), 3), np.nan)
    field[np.searchsorted(samples.t_s, valid[rows])] = value[rows, :3]
    recording = Recording("drive", samples.t_s, samples.rate_b_rad_s, samples.force_b_m_s2, field)
    given = run_of(samples, hnav.Aids().mag(valid[rows], value[rows, :3]), "industrial", start="state")
    assert_equal(hnav.Ins("industrial", start="state", **FAST).run_recording(recording), given)


def test_late_fields_of_a_recording_are_waited_for(driving):
    samples, _ = driving
    valid, _, sensor, value = samples.aids.arrays()
    rows = sensor == SENSORS.index("mag")
    field, measured_s = np.full((len(samples.t_s), 3), np.nan), np.full(len(samples.t_s), np.nan)
    arrived = np.searchsorted(samples.t_s, valid[rows] + LATE_S)
    fits = arrived < len(samples.t_s)
    field[arrived[fits]], measured_s[arrived[fits]] = value[rows, :3][fits], valid[rows][fits]
    late = Recording("drive", samples.t_s, samples.rate_b_rad_s, samples.force_b_m_s2, field, field_t_s=measured_s)
    run = NavigationRun.over(late, hnav.Options("ins", "industrial", start="state", **FAST))
    seen = run.go_on(inertial_rows(late))
    assert run.counts["mag"] == fits.sum() > 500 and run.counts["late"] == 0
    assert_equal(hnav.Ins("industrial", start="state", **FAST).run_recording(late), seen)


def test_fields_that_are_none_are_refused():
    ins = hnav.Ins()
    with pytest.raises(hnav.HnavValueError, match="mag sample at t = 0 s is zero"):
        ins.push_mag(0, [0, 0, 0])
    with pytest.raises(hnav.HnavValueError, match="mag"):
        ins.push_mag(0, [1, np.nan, 0])
    assert ins.diagnostics().non_finite == 2
    aids = hnav.Aids().mag([0.0, 1.0, 2.0], [[0, 0, 0], [1, 2, 3], [np.nan, 0, 0]])
    np.testing.assert_array_equal(aids.arrays()[0], [1.0])
