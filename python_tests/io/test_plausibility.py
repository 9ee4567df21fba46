"""The checks name every fault of the table with number and cure, and are silent about recordings without one."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hnav import Filter, HnavError, Ins, PlausibilityWarning, Recording, read
from hnav.io.aids import AidSamples
from hnav.io.plausibility import check
from hnav.io.plausible_rates import unit_of_rates
from hnav.io.recordings import Origin, Unit
from hnav.io.sensors import GRADES
from hnav.io.turning import IDENTITY, WAYS, axes_text, best_fit, fit_of, fixed_axes, stay_of
from motion import tilted_motion
from studies.plausibility.good import MOTIONS, good_recording
from studies.plausibility.study import FAULTS

SEEDS = 3


@pytest.fixture(scope="module")
def held() -> Recording:
    return good_recording("hand", "consumer", 1000)


def alarms(recording: Recording, **said) -> list[str]:
    return [f"{finding.sensor} {finding.code}" for finding in recording.check(**said) if finding.level != "note"]


@pytest.mark.parametrize("name", FAULTS)
def test_every_fault_is_named_with_its_cure(held, name):
    fault = FAULTS[name]
    found = [finding for finding in fault.make(held).check() if fault.is_named_by(finding)]
    assert len(found) == 1
    assert found[0].cure or "not testable" in found[0].message
    assert "\n" not in str(found[0])


@pytest.mark.parametrize("motion", MOTIONS)
def test_recordings_without_a_fault_give_no_alarm(motion):
    for seed in range(SEEDS):
        assert not alarms(good_recording(motion, GRADES[seed % len(GRADES)], seed, duration_s=25)), seed


def test_the_given_trials_give_no_alarm_and_every_fault_of_units_is_named_in_them(broad_trials):
    for path in list(broad_trials.values())[::5]:
        trial = read(path)
        assert not alarms(trial), path
        for name in ("force in g", "force negated", "rate in deg/s", "field axes swapped", "gravity removed", "time in ms"):
            assert any(map(FAULTS[name].is_named_by, FAULTS[name].make(replace(trial, origin=None)).check())), (path, name)


@pytest.mark.parametrize("wrong", ["y,x,z", "-x,y,z", "z,-x,y", "-y,-z,-x"])
def test_the_axes_that_are_named_mend_what_was_wrong(held, wrong):
    rows = {"x": 0, "y": 1, "z": 2}
    order = [rows[part[-1]] for part in wrong.split(",")]
    signs = [-1 if part.startswith("-") else 1 for part in wrong.split(",")]
    spoilt = replace(held, field_b_tesla=held.field_b_tesla[:, order] * signs)
    finding = next(finding for finding in spoilt.check() if finding.code == "axes")
    frame = spoilt.to_dataframe()
    sensor, _, axes = finding.value.partition("=")
    mended = Recording.from_dataframe(frame, axes={sensor: axes})
    np.testing.assert_allclose(mended.field_b_tesla, held.field_b_tesla)
    assert not alarms(mended)


def test_the_turning_of_a_field_shows_the_scale_of_the_rates_whatever_hard_iron_there_is():
    r = tilted_motion(20, noise=0).recording
    for offset in (0, 3e-5):
        for factor in (0.5, 1.0, 57.3):
            fit = fit_of(
                (r.t_s, factor * (r.rate_b_rad_s - [0.03, -0.05, 0.02])), (r.t_s, r.field_b_tesla + offset), 1.0, offset=True
            )
            assert fit.scale * factor == pytest.approx(1, abs=0.03)
            assert fit.as_it_is > 0.99 and axes_text(best_fit(fit).matrix) == "x,y,z"


def test_gravity_stays_where_it_is_when_the_rates_are_undone():
    r = tilted_motion(25, noise=0).recording
    gyro = (r.t_s, r.rate_b_rad_s - [0.03, -0.05, 0.02])
    attitude = Rotation.from_quat(np.roll(r.reference_q_nb, -1, axis=1))
    pushed = r.force_b_m_s2 + attitude.apply(3 * np.sin(9 * r.t_s)[:, None] * [1, 1, 0], inverse=True)
    stay = stay_of(gyro, (r.t_s, pushed), 1.0)
    assert stay.as_it_is == pytest.approx(1, abs=0.1) and not stay.off and stay.decides
    swapped = stay_of(gyro, (r.t_s, pushed[:, [1, 0, 2]]), 1.0)
    assert swapped.off and swapped.best.correlation == pytest.approx(stay.as_it_is)
    np.testing.assert_array_equal(np.abs(swapped.best.matrix), np.eye(3)[[1, 0, 2]])
    lying = stay_of((r.t_s, 0 * r.rate_b_rad_s), (r.t_s, np.tile([0, 0, 9.81], (len(r.t_s), 1))), 1.0)
    assert lying.as_it_is == pytest.approx(1) and not lying.decides
    assert stay_of(*(((r.t_s[:100], v[:100])) for v in (r.rate_b_rad_s, r.force_b_m_s2)), 1.0) is None


@pytest.mark.parametrize("error_m_s2, noted", [(0.05, False), (-0.3, True), (0.3, True)])
def test_a_force_at_rest_that_is_not_as_long_as_gravity_names_the_grade(error_m_s2, noted):
    t_s = np.arange(0, 10, 0.01)
    rng = np.random.default_rng(1)
    force = rng.normal(0, 0.03, (len(t_s), 3)) + [0, 0, 9.80665 + error_m_s2]
    lying = Recording("desk", t_s, rng.normal(0, 2e-3, (len(t_s), 3)), force)
    found = [finding for finding in lying.check() if (finding.sensor, finding.code) == ("accel", "bias")]
    assert [f"{abs(error_m_s2):.2f} off gravity" in finding.message for finding in found] == [True] * noted
    assert all("--grade consumer" in finding.cure for finding in found)


def test_ways_are_all_signed_permutations():
    assert len({way.tobytes() for way in WAYS}) == 48
    np.testing.assert_array_equal(WAYS[IDENTITY], np.eye(3))
    np.testing.assert_allclose(WAYS @ WAYS.transpose(0, 2, 1), np.broadcast_to(np.eye(3), (48, 3, 3)))
    for way in WAYS:
        fixed = fixed_axes(way, "mag", {}, None)
        np.testing.assert_allclose(np.abs(fixed), np.abs(way.T))


def test_south_of_the_magnetic_equator_the_field_points_up(held):
    southern = replace(held, force_b_m_s2=-held.force_b_m_s2)
    assert alarms(southern) == ["accel sign"]
    assert not alarms(southern, hemisphere="south")
    assert alarms(held, hemisphere="south") == ["accel sign"]
    with pytest.raises(HnavError, match="hemisphere = east: choose one of north, south"):
        held.check("east")


HONEST = ("field in uT", "field in G", "field in nT", "field all zero", "hard iron of 200 uT", "rows repeated", "field held")
"""Faults with which the AHRS is right, or states a heading sigma above 30 deg."""
UNCERTAIN = (
    "force negated",
    "gap of 5 s",
    "rates clipped",
    "field stuck",
    "an axis of the rates dead",
    "force negated, no field",
)
"""Faults that a recording without a fault may look like: the south, a model, a body at rest."""


@pytest.mark.parametrize("name", FAULTS)
def test_a_recording_is_meaningless_where_the_fault_is_certain_and_spoils_the_estimate(held, name):
    found = FAULTS[name].make(held).check()
    assert any(finding.is_meaningless for finding in found) == (name not in (*HONEST, *UNCERTAIN)), list(map(str, found))


def test_the_sign_of_the_force_is_certain_where_the_hemisphere_is_known(held):
    negated = replace(held, force_b_m_s2=-held.force_b_m_s2)
    assert not any(finding.is_meaningless for finding in negated.check())
    assert any(finding.is_meaningless for finding in negated.check("north")) and not alarms(negated, hemisphere="south")

    def at(latitude_deg: float) -> Recording:
        place = AidSamples(held.t_s[:1], np.array([[np.radians(latitude_deg), 0.1, 0.0]]), np.full((1, 3), np.nan))
        return replace(negated, aids={"position": place})

    assert not alarms(at(-30)) and any(finding.is_meaningless for finding in at(30).check())
    assert alarms(at(5)) == ["accel sign"] and not any(finding.is_meaningless for finding in at(5).check())


def test_arrays_in_deg_s_or_g_give_a_warning_at_the_line_that_runs_the_filter(held):
    arrays = (held.t_s, held.rate_b_rad_s, held.force_b_m_s2)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Filter("ahrs").run(*arrays, held.field_b_tesla)
        Filter("hrekf").run(*arrays)
        Ins().run(*arrays)
        Filter("ahrs").run(held.t_s, np.degrees(held.rate_b_rad_s), held.force_b_m_s2 / 9.81, check=False)
        Filter("ahrs").run_recording(FAULTS["force in g"].make(held))  # the recording's own check says it
    for run in (Filter("ahrs").run, Ins().run):
        with pytest.warns(PlausibilityWarning) as said:
            run(held.t_s, np.degrees(held.rate_b_rad_s), held.force_b_m_s2 / 9.81)
        assert {(str(one.message).partition(":")[0], one.filename) for one in said} == {("accel", __file__), ("gyro", __file__)}


@pytest.mark.parametrize("factor", [1 / 8, 1 / 4, 4, 8])
def test_a_wrong_range_of_the_chip_is_found_without_a_field_too(held, factor):
    wrong = replace(held, rate_b_rad_s=factor * held.rate_b_rad_s, field_b_tesla=None)
    found = [finding for finding in wrong.check() if finding.stops]
    assert [(finding.code, finding.sensor) for finding in found] == [("scale", "gyro")]
    assert float(found[0].message.split()[3]) == pytest.approx(1 / factor, rel=0.2)


def test_the_force_on_a_body_that_sways_below_the_sensor_gives_the_rates_no_scale():
    """A bicycle: 1 m above the axis of a sway of 1.3 Hz the force turns 8 times as far as the body, and the filter refused the file."""
    t_s, sway = np.arange(0, 60, 0.01), 2 * np.pi * 1.3
    roll, turn = np.radians(1.5) * np.sin(sway * t_s), 0.1 * np.sin(0.2 * t_s)
    rate = np.stack([np.radians(1.5) * sway * np.cos(sway * t_s), turn * np.sin(roll), turn * np.cos(roll)], 1)
    force = np.stack([0 * roll, -9.81 * np.sin(roll) - sway**2 * roll, -9.81 * np.cos(roll)], 1)
    noise = 0.02 * np.random.default_rng(0).standard_normal((len(t_s), 3))
    bicycle = Recording("bicycle", t_s, rate + 0.05 * noise, force + noise)
    assert [finding for finding in bicycle.check() if finding.code == "scale"] == []


@pytest.mark.parametrize("factor", [0.9, 1.1])
def test_stamps_of_a_clock_that_is_wrong_by_a_tenth_are_a_warning(held, factor):
    stretched = [finding for finding in replace(held, t_s=factor * held.t_s).check() if finding.code == "scale"]
    assert [(finding.sensor, finding.stops) for finding in stretched] == [("gyro", False)]
    assert float(stretched[0].message.split()[3]) == pytest.approx(1 / factor, abs=0.02)
    assert [finding for finding in held.check() if finding.code == "scale"] == []


def test_rates_and_force_that_are_exchanged_are_named_in_arrays_and_files(held):
    exchanged = replace(held, rate_b_rad_s=held.force_b_m_s2, force_b_m_s2=held.rate_b_rad_s)
    assert any(finding.stops and "exchanged" in finding.message for finding in exchanged.check())
    with pytest.warns(PlausibilityWarning, match="they look exchanged"):
        Filter().run(held.t_s, held.force_b_m_s2, held.rate_b_rad_s, held.field_b_tesla)


def test_rates_in_degrees_beside_a_force_in_g_are_not_taken_for_exchanged(held):
    """Whatever their length: rates of a moving body vary more than gravity does."""
    fast = np.median(np.linalg.norm(held.rate_b_rad_s, axis=1))
    for median in (9.0, 9.8, 11.0):
        odd = replace(held, rate_b_rad_s=median / fast * held.rate_b_rad_s, force_b_m_s2=held.force_b_m_s2 / 9.81)
        assert not any("exchanged" in finding.message for finding in odd.check())


def test_a_force_that_points_up_is_named_in_arrays(held):
    with pytest.warns(PlausibilityWarning, match="multiply the force by -1; south of the magnetic equator it is right"):
        Filter().run(held.t_s, held.rate_b_rad_s, -held.force_b_m_s2, held.field_b_tesla)


def test_a_sensor_that_is_not_given_is_named(held):
    for given, missing in (
        ((held.rate_b_rad_s, None, held.field_b_tesla), "force_b_m_s2"),
        ((None, held.force_b_m_s2), "rate_b_rad_s"),
    ):
        with pytest.warns(PlausibilityWarning, match=f"{missing} is None: give it as n x 3"):
            Filter().run(held.t_s, *given)


@pytest.mark.parametrize("gap_s, said", [(0.25, False), (0.35, True), (2.0, True)])
def test_a_gap_is_named_from_0_3_s_on(held, gap_s, said):
    kept = (held.t_s <= held.t_s[300]) | (held.t_s >= held.t_s[300] + gap_s)
    cut = replace(
        held,
        **{name: getattr(held, name)[kept] for name in ("t_s", "rate_b_rad_s", "force_b_m_s2", "field_b_tesla")},
        reference_q_nb=None,
    )
    assert [finding.sensor for finding in cut.check() if finding.code == "gaps"] == (["gyro", "accel", "mag"] if said else [])


def test_what_is_said_of_one_sensor_does_not_advise_on_another(held):
    for sensor, name in (("accel", "force_b_m_s2"), ("gyro", "rate_b_rad_s")):
        for value in (np.nan, 0.0):
            dead = replace(held, **{name: value * getattr(held, name)})
            assert all("magnetometer" not in str(finding) for finding in dead.check() if finding.sensor == sensor)


def test_axes_of_a_field_that_the_filter_does_not_use_spoil_nothing(held):
    swapped = FAULTS["field axes swapped"].make(held)
    assert not any(finding.is_meaningless for finding in FAULTS["field in G"].make(swapped).check())


def test_a_leg_that_swings_faster_forward_than_back_is_not_taken_for_degrees():
    """A telephone in a pocket: 1.2 rad/s forward for a quarter of a step, 0.4 rad/s back. The median of the rates is no bias."""
    rng, t = np.random.default_rng(1), np.arange(0, 120, 0.01)
    forward = (1.1 * t) % 1 < 0.25
    rate = 0.01 * rng.normal(size=(len(t), 3)) + np.where(forward[:, None], [0, 1.2, 0], [0, -0.4, 0])
    angle = np.cumsum(rate[:, 1]) * 0.01
    shaken = 6 * np.sin(2.2 * np.pi * t + 0.3)[:, None] * [1, 0, 0.5] + 0.5 * rng.normal(size=rate.shape)
    force = -9.8 * np.stack([-np.sin(angle), 0 * t, np.cos(angle)], axis=1) + shaken
    assert unit_of_rates({"gyro": (t, rate), "accel": (t, force)}).unit != "deg/s"


def test_a_turntable_whose_accelerometer_has_a_bias_is_not_taken_for_one_that_stands_still():
    """The force stays in the body, and its bias seems to be gravity beside the axis, which would turn."""
    t = np.arange(0, 120, 0.01)
    rate = np.where(t % 40 < 20, 1.1, -0.7)[:, None] * [0.0, 0.0, 1.0] + 1e-3 * np.random.default_rng(4).normal(size=(len(t), 3))
    force = np.tile([0.3, -0.3, -9.8], (len(t), 1))
    assert unit_of_rates({"gyro": (t, rate), "accel": (t, force)}).unit != "deg/s"


def test_a_body_that_turns_full_circles_between_windows_is_not_taken_for_one_that_stands_still(broad_trials):
    for path in broad_trials.values():
        assert not alarms(replace(read(path), field_b_tesla=None, origin=None)), path


def test_counts_of_a_chip_are_distinguished_from_units(held):
    counts = replace(
        held, rate_b_rad_s=np.round(np.degrees(held.rate_b_rad_s) * 131), force_b_m_s2=np.round(held.force_b_m_s2 * 1670)
    )
    finding = next(f for f in counts.check() if f.sensor == "accel")
    assert "counts of the chip" in str(finding) and "1/16384 g" in str(finding)
    whole_mg = replace(counts, force_b_m_s2=np.round(held.force_b_m_s2 / 9.80665e-3))
    assert ("accel_unit", "mg") in {(f.argument, f.value) for f in whole_mg.check()}


def test_units_are_named_against_those_the_file_was_read_with(held):
    units = {
        "accel": Unit("g", "given"),
        "mag": Unit("uT", "by header"),
        "gyro": Unit("deg/s", "given"),
        "time": Unit("ms", "given"),
    }
    origin = Origin("table", units)
    taken = replace(
        held,
        force_b_m_s2=9.80665 * held.force_b_m_s2,
        rate_b_rad_s=np.radians(held.rate_b_rad_s),
        t_s=1e-3 * held.t_s,
        origin=origin,
    )
    cures = {(finding.argument, finding.value) for finding in taken.check() if finding.level == "warning"}
    assert cures == {("accel_unit", "m/s2"), ("gyro_unit", "rad/s"), ("time_unit", "s")}
    words = {
        finding.argument: finding.cure
        for name in ("force in g", "rows repeated", "rate negated")
        for finding in FAULTS[name].make(held).check()
    }
    assert words["accel_unit"] == 'use accel_unit="g"' and words["drop_repeats"].startswith(
        "use drop_repeats=True; and gyro_hold=instant"
    )
    assert words["axes"] == 'use axes={"gyro": "-x,-y,-z"}'
    # Hard iron is as large as milligauss taken for microtesla.
    magnetised = replace(
        held, field_b_tesla=held.field_b_tesla + [2e-4, 0, 0], origin=replace(origin, units={"mag": Unit("uT", "by format")})
    )
    assert "mag strength" in alarms(magnetised)


def test_few_rows_are_judged_by_what_they_hold():
    one = Recording("one", np.zeros(1), np.zeros((1, 3)), np.full((1, 3), np.nan))
    assert [f"{f.level} {f.sensor} {f.code}" for f in check(one)][:2] == ["error accel no_samples", "warning gyro all_zero"]
    two = Recording("two", np.arange(2.0), np.ones((2, 3)), np.ones((2, 3)), np.ones((2, 3)))
    assert alarms(two) == ["time short"]
    ten = Recording("ten", np.arange(10.0), np.ones((10, 3)), np.ones((10, 3)), np.ones((10, 3)))
    assert not alarms(ten)


def test_a_check_of_60000_rows_changes_nothing_and_takes_no_time():
    import time

    r = tilted_motion(100).recording
    many = Recording(
        "many", np.arange(60000) / 285.7, *(np.tile(v, (6, 1)) for v in (r.rate_b_rad_s, r.force_b_m_s2, r.field_b_tesla))
    )
    before = many.force_b_m_s2.copy()
    begin = time.process_time()
    many.check()
    assert time.process_time() - begin < 1.5  # 0.3 s on a machine that does nothing else
    np.testing.assert_array_equal(many.force_b_m_s2, before)


def test_a_field_that_is_packed_at_the_top_of_its_column_is_named(held):
    packed = np.full_like(held.field_b_tesla, np.nan)
    few = held.field_b_tesla[np.isfinite(held.field_b_tesla).all(axis=1)][::5]
    packed[: len(few)] = few
    assert "mag ends_early" in alarms(replace(held, field_b_tesla=packed))


def test_no_piece_of_a_hand_that_turns_about_and_about_is_taken_for_degrees(broad_trials):
    """Seconds in which the mean rate is 2 rad/s: gravity seen from the body goes round, and its mean stays along the axis."""
    for path in broad_trials.values():
        trial = read(path)
        for first in range(0, len(trial.t_s) - 5000, 2500):
            piece = slice(first, first + 5000)
            live = {"gyro": (trial.t_s[piece], trial.rate_b_rad_s[piece]), "accel": (trial.t_s[piece], trial.force_b_m_s2[piece])}
            assert unit_of_rates(live).unit != "deg/s", (path, first)


def test_a_field_that_does_not_turn_with_the_rates_gives_them_no_scale(held):
    """One of a machine beside the body: a check that calls its axes not testable warned of the scale of the rates by it."""
    turns = Rotation.from_rotvec(8 * held.rate_b_rad_s * np.gradient(held.t_s)[:, None])
    fast = [Rotation.identity()]
    for turn in turns[:-1]:
        fast.append(fast[-1] * turn)
    field = Rotation.concatenate(fast).inv().apply([2e-5, 0, 4e-5])
    wander = np.cumsum(np.random.default_rng(3).normal(0, 1, field.shape), axis=0)
    for size, code in ((0.0, "scale"), (2.5e-7, "not_testable")):
        spoilt = replace(held, field_b_tesla=field + size * wander)
        codes = {finding.code for finding in spoilt.check() if finding.sensor in ("gyro", "mag")}
        assert code in codes and codes.isdisjoint({"scale", "not_testable"} - {code})


@pytest.mark.parametrize("hold", ["instant", "backward"])
def test_the_advice_on_a_table_that_holds_its_samples_gives_the_smallest_error(hold):
    """25 Hz in rows of 100 Hz: without the repeats the default hold doubled the error of rates that were read at instants."""
    count, step = 24_000, 40  # rows of 1 ms, and of a sample
    t_s = 1e-3 * np.arange(count)
    rate = 2 * np.stack([np.sin(4 * t_s), 0.8 * np.cos(3.1 * t_s), 0.6 * np.sin(2.2 * t_s + 1)], axis=1)
    turns = [Rotation.identity()]
    for turn in Rotation.from_rotvec(0.5e-3 * (rate[1:] + rate[:-1])):
        turns.append(turns[-1] * turn)
    back = Rotation.concatenate(turns).inv()
    means = np.cumsum(rate, axis=0)
    means[step:] = (means[step:] - means[:-step]) / step
    rows = np.arange(0, count, 10)
    sampled = rows // step * step
    arrays = (
        values[sampled]
        for values in (rate if hold == "instant" else means, back.apply([0, 0, -9.81]), back.apply([2e-5, 0, 4e-5]))
    )
    table = Recording("held", t_s[rows], *arrays)
    said = next(one for one in table.check() if one.sensor == "gyro")
    assert said.argument == "drop_repeats" and "gyro_hold=instant" in said.advice
    errors_deg = {}
    for drop in (False, True):
        for way in ("instant", "backward"):
            read = Recording.from_dataframe(table.to_dataframe(), drop_repeats=drop)
            q_nb = Filter("ahrs", gyro_hold=way).run_recording(read).q_nb[len(read.t_s) // 3 :]
            truth = Rotation.concatenate(turns)[np.round(1000 * read.t_s).astype(int)][len(read.t_s) // 3 :]
            wrong = (Rotation.from_quat(q_nb, scalar_first=True) * truth.inv()).magnitude()
            errors_deg[drop, way] = np.degrees(np.sqrt(np.mean(wrong**2)))
    assert min(errors_deg, key=lambda case: errors_deg[case]) == (True, hold)
    assert errors_deg[True, hold] < 0.3 * errors_deg[False, "backward"]


def test_an_overflow_of_the_magnetometer_hides_no_wrong_axes(held):
    field = held.field_b_tesla[:, [1, 0, 2]] * [1, 1, -1]
    field[len(field) // 2] = 4.9e-3
    found = check(replace(held, field_b_tesla=field))
    assert [str(finding) for finding in found if (finding.sensor, finding.code) == ("mag", "axes")]
    (note,) = [finding for finding in found if finding.code == "outliers"]
    assert note.level == "note" and "a sample is more than 10 times as far off as others" in note.message
