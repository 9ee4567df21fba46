"""Recordings made harder: seeded, harder where they should be, and nowhere else."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats
from scipy.spatial.transform import Rotation

from hnav.errors import HnavError
from hnav.fmi.engines import run_recording
from hnav.io.recordings import Recording, RecordingError
from hnav.reports.scores import score
from studies.bench.stress import (
    BURST_S,
    DROPPED_SHARE,
    FIELD_DELAY_S,
    JITTER_S,
    SETS,
    SETTLING_S,
    STAMP_SPACING_S,
    draw_distortion,
    late_field,
    variant_count,
    variants,
)  # fmt: skip
from studies.readiness.starts import simulated_start

REST_S = 25.0


@pytest.fixture(scope="module")
def recordings() -> list[Recording]:
    """Hand-held and fast; scored after a rest that is longer than any distortion of the field."""
    made = [simulated_start(index, duration_s=60).recording for index in (1, 3)]
    return [replace(r, movement=r.t_s >= REST_S) for r in made]


def attitude(recording: Recording, rows=slice(None)) -> Rotation:
    return Rotation.from_quat(recording.reference_q_nb[rows][:, [1, 2, 3, 0]])


def same_bits(a: Recording, b: Recording) -> bool:
    return all(
        np.array_equal(v, vars(b)[k], equal_nan=True)
        if isinstance(v, np.ndarray) and v.dtype != bool
        else np.array_equal(v, vars(b)[k])
        for k, v in vars(a).items()
    )


# ------------------------------------------------------------------------------------------ all sets


@pytest.mark.parametrize("set_name", SETS)
def test_the_same_seed_gives_the_same_bits(recordings, set_name):
    first, second = (list(variants(set_name, recordings, seed=9)) for _ in range(2))
    assert len(first) == variant_count(set_name, len(recordings))
    assert all(same_bits(a, b) for a, b in zip(first, second, strict=True))


@pytest.mark.parametrize("set_name", ["XREST", "XMOT", "DROP", "JITTER", "BURST"])
def test_another_seed_gives_other_recordings(recordings, set_name):
    for a, b in zip(variants(set_name, recordings, seed=9), variants(set_name, recordings, seed=10), strict=True):
        assert not same_bits(a, b)


@pytest.mark.parametrize("set_name", SETS)
def test_time_increases_and_rows_stay_together(recordings, set_name):
    for variant in variants(set_name, recordings):
        assert (np.diff(variant.t_s) > 0).all()
        assert {len(v) for v in vars(variant).values() if isinstance(v, np.ndarray)} == {len(variant.t_s)}
        assert variant.movement.any()


@pytest.mark.parametrize("set_name", SETS)
def test_the_recordings_given_are_left_as_they_are(recordings, set_name):
    before = [replace(r, **{k: v.copy() for k, v in vars(r).items() if isinstance(v, np.ndarray)}) for r in recordings]
    list(variants(set_name, recordings))
    assert all(same_bits(a, b) for a, b in zip(before, recordings))


def test_broad_is_what_was_recorded(recordings):
    assert all(same_bits(a, b) for a, b in zip(variants("BROAD", recordings), recordings, strict=True))


# ------------------------------------------------------------------------------------------ starts


def test_crop_begins_with_the_scored_phase(recordings):
    for variant, recording in zip(variants("CROP", recordings), recordings, strict=True):
        assert variant.movement[0]
        assert variant.t_s[0] == recording.t_s[np.argmax(recording.movement)]
        assert variant.t_s[-1] == recording.t_s[-1]
        assert variant.movement.sum() == recording.movement.sum()


def test_a_false_field_is_the_true_one_turned_and_scaled_in_the_earths_frame(recordings):
    rng = np.random.default_rng(5)
    expected = [draw_distortion(rng) for _ in range(2 * len(recordings))]
    for variant, distortion, recording in zip(variants("XREST", recordings), expected, 2 * recordings, strict=True):
        n = int(distortion.duration_s * 100)
        assert 5 <= distortion.duration_s <= 20 and 0.6 <= distortion.scale <= 1.5
        assert 30 <= np.degrees(distortion.rotation.magnitude()) <= 90
        earth = attitude(recording, slice(0, n)).apply(recording.field_b_tesla[:n])
        false = attitude(variant, slice(0, n)).apply(variant.field_b_tesla[:n])
        np.testing.assert_allclose(false, distortion.scale * distortion.rotation.apply(earth), atol=1e-15)
        np.testing.assert_array_equal(variant.field_b_tesla[n:], recording.field_b_tesla[n:])
        np.testing.assert_array_equal(variant.rate_b_rad_s, recording.rate_b_rad_s)
        np.testing.assert_array_equal(variant.movement, recording.movement)


def test_the_two_passes_of_xrest_have_different_names(recordings):
    names = [variant.name for variant in variants("XREST", recordings)]
    assert len(set(names)) == 2 * len(recordings)


def test_xmot_is_scored_from_ten_seconds_after_the_fields_return(recordings):
    rng = np.random.default_rng(5)
    # The stream of XREST comes first, so that both sets hold the same recordings alone and together.
    drawn = [draw_distortion(rng) for _ in range(3 * len(recordings))][2 * len(recordings) :]
    for variant, distortion in zip(variants("XMOT", recordings), drawn, strict=True):
        since_start_s = variant.t_s - variant.t_s[0]
        assert since_start_s[np.argmax(variant.movement)] == pytest.approx(distortion.duration_s + SETTLING_S, abs=0.021)


def test_where_the_optics_lost_the_body_its_last_attitude_places_the_distortion(recordings):
    reference = recordings[0].reference_q_nb.copy()
    reference[100:140] = np.nan
    reference[0] = np.nan
    broken = replace(recordings[0], reference_q_nb=reference)
    variant = next(variants("XREST", [broken]))
    whole = next(variants("XREST", recordings[:1]))
    assert np.isfinite(variant.field_b_tesla).all()
    np.testing.assert_array_equal(variant.field_b_tesla[140:], whole.field_b_tesla[140:])


# ------------------------------------------------------------------------------------------ sensor faults


def test_one_sample_in_a_hundred_is_lost_with_its_stamp(recordings):
    for variant, recording in zip(variants("DROP", recordings), recordings, strict=True):
        n = len(recording.t_s)
        low, high = stats.binom.ppf([0.0005, 0.9995], n, DROPPED_SHARE)
        assert low <= n - len(variant.t_s) <= high
        assert variant.t_s[0] == recording.t_s[0]
        kept = np.isin(recording.t_s, variant.t_s)
        np.testing.assert_array_equal(variant.rate_b_rad_s, recording.rate_b_rad_s[kept])


def test_stamps_of_arrival_are_late_by_up_to_five_milliseconds_and_in_order(recordings):
    for variant, recording in zip(variants("JITTER", recordings), recordings, strict=True):
        late_s = variant.t_s - recording.t_s
        assert late_s.min() >= 0
        assert late_s.max() <= JITTER_S + STAMP_SPACING_S
        assert late_s.mean() == pytest.approx(JITTER_S / 2, rel=0.05)
        assert np.diff(variant.t_s).min() >= 0.99 * STAMP_SPACING_S
        np.testing.assert_array_equal(variant.field_b_tesla, recording.field_b_tesla)


def test_jitter_beyond_the_interval_keeps_samples_in_order(recordings):
    from studies.bench.stress import jittered

    crowded = jittered(recordings[0], np.random.default_rng(1), jitter_s=0.05)
    assert np.diff(crowded.t_s).min() >= 0.99 * STAMP_SPACING_S


def test_late_fields_say_truthfully_when_they_were_measured(recordings):
    for variant, recording in zip(variants("LATE", recordings), recordings, strict=True):
        arrived = np.isfinite(variant.field_t_s)
        delay_s = (variant.t_s - variant.field_t_s)[arrived]
        np.testing.assert_allclose(delay_s, FIELD_DELAY_S, atol=1e-9)
        assert not arrived[:2].any() and arrived[2:].all()
        back = variant.in_order_of_measurement()
        np.testing.assert_array_equal(back.field_b_tesla[:-2], recording.field_b_tesla[:-2])
        assert np.isnan(back.field_b_tesla[-2:]).all() and back.field_t_s is None


def test_a_delay_between_two_rows_is_rounded_up(recordings):
    variant = late_field(recordings[0], 0.014)
    np.testing.assert_allclose((variant.t_s - variant.field_t_s)[2:], 0.020, atol=1e-9)


@pytest.mark.parametrize("filter", ["hrekf", "ahrs"])
def test_late_fields_with_true_stamps_cost_a_filter_next_to_nothing(recordings, filter):
    recording = recordings[0].cropped(30)
    late = late_field(recording)
    results = [run_recording(r, filter, settings={"navigation_frame": "enu"}) for r in (recording, late)]
    assert results[1].counts["late"] == 0
    assert results[1].counts["mag_used"] == results[0].counts["mag_used"] - 2
    totals = [score(r.q_nb, recording.reference_q_nb, recording.movement).total for r in results]
    assert totals[1] == pytest.approx(totals[0], abs=0.05)
    # What is committed is the same to the last bit; only the look-ahead over the delay differs.
    assert results[1].q_nb[10] == pytest.approx(results[0].q_nb[10], abs=0.02)


def test_late_samples_and_an_fmu_do_not_go_together(recordings):
    with pytest.raises(HnavError, match="late samples need engine c"):
        run_recording(late_field(recordings[0]), "ahrs", engine="fmi3-cs")


def test_smoothing_puts_late_fields_where_they_belong(recordings):
    late = late_field(recordings[0].cropped(10))
    smoothed = [run_recording(r, "ahrs", smooth=True).q_nb for r in (late, late.in_order_of_measurement())]
    np.testing.assert_array_equal(*smoothed)


def test_each_sensor_falls_silent_for_short_times_of_its_own(recordings):
    for variant in variants("BURST", recordings):
        silent = [np.isnan(getattr(variant, name)).all(axis=1) for name in ("rate_b_rad_s", "force_b_m_s2", "field_b_tesla")]
        assert not any(s[variant.t_s < variant.t_s[0] + 1].any() for s in silent)
        assert not np.array_equal(silent[0], silent[1]) and not np.array_equal(silent[1], silent[2])
        for s in silent:
            begins = np.flatnonzero(np.diff(s.astype(int), prepend=0) == 1)
            ends = np.flatnonzero(np.diff(s.astype(int), append=0) == -1)
            assert len(begins) == len(ends)
            # Two bursts may touch; none alone is longer than the longest.
            assert (ends - begins + 1).sum() * 0.01 <= stats.poisson.ppf(0.9995, 60 / 20) * (BURST_S[1] + 0.01)
    assert any(np.isnan(variant.field_b_tesla).any() for variant in variants("BURST", recordings))


# ------------------------------------------------------------------------------------------ bad input


@pytest.mark.parametrize(
    "without, named", [("field_b_tesla", "field_b_tesla"), ("reference_q_nb", "reference_q_nb"), ("movement", "movement")]
)
def test_what_a_recording_lacks_is_named(recordings, without, named):
    with pytest.raises(RecordingError, match=named):
        list(variants("BROAD", [replace(recordings[0], **{without: None})]))


def test_a_recording_without_a_scored_row_is_refused(recordings):
    with pytest.raises(RecordingError, match="no row is scored"):
        list(variants("CROP", [replace(recordings[0], movement=np.zeros(len(recordings[0].t_s), bool))]))


def test_an_unknown_set_is_refused_with_the_known_ones(recordings):
    with pytest.raises(RecordingError, match="XREST"):
        list(variants("YREST", recordings))
