"""Arrays as notebooks hold them: of other types, in other units, of other shapes. They are used as they are meant, or named."""

import contextlib

import numpy as np
import pandas as pd
import pytest

from hnav import Aids, Filter, HnavError, Ins, PlausibilityWarning, Recording
from hnav.io.recordings import RecordingError
from motion import tilted_motion

START = np.datetime64("2026-01-31T12:00:00", "ns")


@pytest.fixture(scope="module")
def arrays() -> list[np.ndarray]:
    made = tilted_motion(5).recording
    return [made.t_s, made.rate_b_rad_s, made.force_b_m_s2, made.field_b_tesla]


def with_times(arrays: list[np.ndarray], times: object) -> Filter:
    return Filter("ahrs").run(times, *arrays[1:])


def test_instants_and_spans_of_time_are_seconds(arrays):
    spans = (1e9 * arrays[0]).round().astype("timedelta64[ns]")
    plain = with_times(arrays, arrays[0])
    for times in (spans, spans.astype("timedelta64[us]"), START + spans, pd.DatetimeIndex(START + spans), pd.Series(spans)):
        np.testing.assert_allclose(with_times(arrays, times).q_nb[-1], plain.q_nb[-1], atol=1e-6)
    assert with_times(arrays, START + spans).t_s[0] == pytest.approx(1769860800)


@pytest.mark.parametrize("place, factor, named", [
    (0, 1e3, "ms; multiply by 0.001"), (1, 180 / np.pi, "deg/s; multiply by 0.0174533"), (2, 1 / 9.80665, "g; multiply by 9.80665"),
    (3, 1e6, "uT; multiply by 1e-06"),
])  # fmt: skip
def test_arrays_in_another_unit_give_a_warning_with_the_factor(arrays, place, factor, named):
    given = [factor * array if i == place else array for i, array in enumerate(arrays)]
    with pytest.warns(PlausibilityWarning, match=named), contextlib.suppress(HnavError):
        Filter("ahrs").run(*given)


def test_stamps_that_a_short_type_made_equal_are_named(arrays):
    with pytest.warns(PlausibilityWarning, match="100 % of the time stamps equal the one before; give t_s as float64"):
        with_times(arrays, (1.7e9 + arrays[0]).astype(np.float32))


def test_rows_in_another_order_are_named_with_the_cure(arrays):
    with pytest.raises(HnavError, match="sort the rows by it"):
        with_times(arrays, arrays[0][::-1])


@pytest.mark.parametrize("name", ["ahrs", "hrekf", "ins"])
def test_a_horizon_admits_rows_that_run_back_within_it(arrays, name):
    """What the message of a late sample promises."""
    given = Ins("industrial", horizon_s=0.1) if name == "ins" else Filter(name, horizon_s=0.1)
    swapped = [array.copy() for array in arrays[: 3 if name == "ins" else 4]]
    in_order = given.run(*swapped)
    given.reset()
    for array in swapped:
        array[100:102] = array[101:99:-1]
    np.testing.assert_allclose(given.run(*swapped).q_nb[-1], in_order.q_nb[-1], atol=1e-9)


def test_masked_samples_are_none(arrays):
    """As netCDF4 and astropy give them, with a fill value below the mask."""
    hidden = np.broadcast_to((arrays[0] > 2)[:, None], arrays[3].shape)
    field = np.where(hidden, -9999.0, arrays[3])
    plain = Filter("ahrs").run(*arrays[:3], np.where(hidden, np.nan, field))
    masked = Filter("ahrs").run(*arrays[:3], np.ma.masked_array(field, hidden))
    np.testing.assert_array_equal(plain.q_nb, masked.q_nb)
    recorded = Recording("masked", *arrays[:3], np.ma.masked_array(field, hidden))
    assert np.isnan(recorded.field_b_tesla[hidden]).all()
    heading = np.ma.masked_array([0.1, -9999.0], [False, True])
    assert len(Aids().heading([0.0, 1.0], heading, 0.1).arrays()[0]) == 1


def test_an_infinite_sample_is_none(arrays):
    rate = arrays[1].copy()
    rate[100, 1] = np.inf
    recording = Recording("infinite", arrays[0], rate, *arrays[2:])
    assert len(recording.samples("gyro")[0]) == len(rate) - 1
    assert not [finding for finding in recording.check() if finding.level != "note"]


def test_a_recording_of_lists_is_one_of_arrays_and_other_shapes_are_named(arrays):
    lists = Recording("lists", *(array.tolist() for array in arrays))
    np.testing.assert_array_equal(lists.samples("mag")[1], arrays[3])
    with pytest.raises(RecordingError, match=r"rate_b_rad_s has the shape \(10, 3\), t_s \(500,\)"):
        Recording("short", arrays[0], arrays[1][:10], *arrays[2:])


def test_data_frames_of_every_index_and_type_are_read(arrays):
    frame = Recording("frame", *arrays).to_dataframe()
    spans = pd.TimedeltaIndex((1e9 * arrays[0]).round().astype("timedelta64[ns]"))
    texts = frame.reset_index().astype(str)
    under = pd.concat({"gyro": frame[["gx", "gy", "gz"]], "acc": frame[["ax", "ay", "az"]]}, axis=1)
    under.columns = pd.MultiIndex.from_product([["gyro", "acc"], list("xyz")])
    for given in (frame.rename_axis(None), frame.set_index(spans), texts, texts.apply(lambda c: c.str.replace(".", ",")), under):
        read_back = Recording.from_dataframe(given)
        np.testing.assert_allclose(read_back.t_s, arrays[0], atol=1e-9)
        np.testing.assert_allclose(read_back.rate_b_rad_s, arrays[1])
    with pytest.raises(RecordingError, match="a dict, and no DataFrame"):
        Recording.from_dataframe({"t_s": [0, 1]})


def test_aids_of_another_shape_unit_or_clock_are_named(arrays):
    t, rate, force, field = arrays
    for values in (np.zeros((5, 2)), np.zeros((3, 5)), np.zeros(15)):
        with pytest.raises(HnavError, match=r"expected \(5, 3\)"):
            Aids().velocity(t[:5], values, 0.1)
    for place, name in (((48.1, 0.2), "latitude_rad"), ((0.8, 11.6), "longitude_rad")):
        with pytest.raises(HnavError, match=f"{name} = .*np.radians"):
            Aids().position(t[:5], *place, 400.0, 2.0)
    with pytest.raises(HnavError, match="Aids"):
        Ins().run(t, rate, force, field)
    with pytest.warns(PlausibilityWarning, match="one clock"):
        Ins().run(t, rate, force, Aids().velocity(t[:5] + 1.7e9, np.zeros((5, 3)), 0.1))
