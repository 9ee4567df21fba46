"""Options and filters as a Python user expects objects to be."""

import copy
import pickle

import numpy as np
import pytest

import hnav
from hnav import (
    Filter,
    HnavError,
    HnavRuntimeError,
    HnavValueError,
    InsErrorFilter,
    InsErrorOptions,
    LinearModel,
    Options,
)  # fmt: skip
from hnav.filters import attitude_answers, calibration, filter_answers, ins_error
from hnav.filters.filter_answers import SENSOR_STATES
from hnav.filters.options import FILTERS, option_table
from hnav.native.library import ffi
from hnav.native.options import OptionInfo, OptionSet
from hnav.simulation import imu_mag_sensor, turntable

EYE = np.eye(2)
MODEL = LinearModel(A=0.5 * EYE, H=EYE, Qw=EYE, Qv=EYE, P0=EYE, An=0.9 * EYE, QU=EYE)
CHANGED: list[OptionSet] = [
    Options("ahrs", navigation_frame="enu", q_body_sensor=[0.5, 0.5, -0.5, 0.5]),
    Options("hrekf", "paper", gamma_mode="kl", queue_capacity=100),
    InsErrorOptions(form="amdkf", window=7),
]
COPIES = {
    "copy": copy.copy, "deepcopy": copy.deepcopy, "pickle": lambda o: pickle.loads(pickle.dumps(o)),
    "repr": lambda o: eval(repr(o), vars(hnav)),
}  # fmt: skip


@pytest.mark.parametrize("way", COPIES)
@pytest.mark.parametrize("options", CHANGED, ids=repr)
def test_a_copy_is_equal_and_goes_its_own_way(way, options):
    again = COPIES[way](options)
    assert again == options and type(again) is type(options) and again is not options
    name = "solver" if isinstance(options, Options) else "noise_scaling"
    setattr(again, name, "none" if name == "noise_scaling" else "adams")
    assert again != options
    assert again.changed() == options.changed() | {name: getattr(again, name)}


def test_the_text_of_options_says_what_differs_from_the_preset():
    assert repr(Options("ahrs")) == "Options('ahrs')"
    assert repr(Options("hrekf", "paper", gamma=2)) == "Options('hrekf', 'paper', gamma=2.0)"
    assert repr(InsErrorOptions(form="mdkf")) == "InsErrorOptions(form='mdkf')"
    assert repr(Filter("ahrs", navigation_frame="enu")) == "Filter(Options('ahrs', navigation_frame='enu'))"


def test_options_are_equal_by_their_values():
    assert Options("ahrs", navigation_frame="ned") == Options("ahrs")
    assert Options("ahrs") != Options("hrekf") and Options("hrekf") != Options("hrekf", "paper")
    assert Options("ahrs") != "ahrs"
    with pytest.raises(TypeError, match="unhashable"):
        hash(Options("ahrs"))


@pytest.mark.parametrize("filter", FILTERS)
def test_names_can_be_completed_and_asked_for(filter):
    options = Options(filter)
    assert set(option_table(filter)) <= set(dir(options))
    assert hasattr(options, "gyro_noise_rad_per_sqrt_s") and not hasattr(options, "gyro_noise")
    assert getattr(options, "gyro_noise", None) is None
    assert options.as_dict().keys() == option_table(filter).keys()
    assert (options.filter, options.preset) == (filter, "default")


def test_arrays_of_numpy_and_text_of_files_are_values():
    options = Options("ahrs", q_body_sensor=np.array([1.0, 0, 0, 0]), start_samples=np.int64(3), declination_rad=np.float32(0.5))
    assert (options.q_body_sensor, options.start_samples, options.declination_rad) == ((1, 0, 0, 0), 3, 0.5)
    options.q_body_sensor = "0.5,0.5,0.5,0.5"
    assert options.q_body_sensor == (0.5,) * 4


@pytest.mark.parametrize("name, value, said", [
    ("body", "boat", "body = boat: write ship"), ("body", "Drone", "body = Drone: write quadrotor"),
    ("body", "foot", "body = foot: write walker"), ("body", "plane", "body = plane: write aircraft"),
    ("body", "phone", "body = phone: write hand"), ("body", "cart", "body = cart: choose one of any, hand, walker, car, ship"),
    ("solver", 1, "solver = 1: choose one of erkstep, adams, closed_form, euler"),
    ("solver", "ADAMS", "solver = ADAMS: choose one of erkstep"),
    ("q_body_sensor", [1, 0, 0], "q_body_sensor takes 4 numbers, not 3"),
    ("declination_rad", [1, 2], "declination_rad takes 1 number, not 2"),
    ("declination_rad", None, "declination_rad = None: not a number"),
    ("queue_capacity", 2.5, "queue_capacity = 2.5: not a whole number"),
    ("queue_capacity", 1e12, "queue_capacity = 1000000000000.0: it lies between"),
])  # fmt: skip
def test_an_impossible_value_is_refused_and_nothing_changes(name, value, said):
    options = Options("ahrs")
    with pytest.raises(HnavValueError, match=said) as error:
        setattr(options, name, value)
    assert (error.value.status, error.value.argument) == ("option", name)
    assert options == Options("ahrs")


def test_a_name_that_does_not_exist_proposes_the_nearest():
    with pytest.raises(HnavError, match="ahrs has no option gyro_noise_rad_sqrt_s; did you mean gyro_noise_rad_per_sqrt_s?"):
        Options("ahrs", gyro_noise_rad_sqrt_s=1)
    with pytest.raises(HnavError, match="ahrs has no option gyro_noise; did you mean gyro_noise_rad_per_sqrt_s?"):
        Options("ahrs", gyro_noise=1)
    options = Options("ahrs")
    with pytest.raises(AttributeError, match="did you mean navigation_frame"):
        options.navigation = "enu"
    with pytest.raises(HnavValueError, match=r"ahrs has no option xyzzy$"):
        _ = options.xyzzy
    with pytest.raises(AttributeError, match="can be set, not deleted"):
        del options.solver


@pytest.mark.parametrize("arguments, said", [
    (("nosuch",), "filter = nosuch: choose one of hrekf, ahrs"),
    (("ahrs", "paper"), "preset = paper: ahrs has default"),
])  # fmt: skip
def test_filters_and_presets_that_do_not_exist_are_named(arguments, said):
    for made in (Options, Filter):
        with pytest.raises(HnavValueError, match=said) as error:
            made(*arguments)
        assert error.value.argument == said.split()[0]


def test_an_option_has_a_unit_a_description_and_choices():
    info = option_table("ahrs")["gyro_noise_rad_per_sqrt_s"]
    assert isinstance(info, OptionInfo) and info.unit == "rad/sqrt(s)" and info.description and not info.choices
    assert option_table("ahrs")["solver"].choices == ("erkstep", "adams", "closed_form", "euler")
    assert issubclass(Options, OptionSet)


# --------------------------------------------------------------------------------------------- filters


def test_a_filter_is_made_by_name_or_by_options():
    assert Filter("hrekf", "paper", gamma=3).options == Options("hrekf", "paper", gamma=3)
    assert Filter("ahrs", navigation_frame="enu", preset="default").options == Options("ahrs", navigation_frame="enu")
    with pytest.raises(HnavValueError, match="Options are complete"):
        Filter(Options("ahrs"), navigation_frame="enu")
    with pytest.raises(HnavValueError, match="InsErrorOptions are complete"):
        InsErrorFilter(MODEL, InsErrorOptions(), lag=1)
    assert InsErrorFilter(MODEL, form="plain").options == InsErrorOptions(form="plain")


def test_options_are_those_of_the_moment_when_the_filter_was_made():
    options = Options("ahrs")
    filter = Filter(options)
    options.navigation_frame = "enu"
    filter.options.navigation_frame = "enu"
    assert filter.options.navigation_frame == "ned"


@pytest.mark.parametrize("way", ["copy", "deepcopy", "pickle"])
def test_a_copied_filter_goes_on_from_its_state(way, motion):
    m = motion.recording
    filter = Filter("ahrs", solver="closed_form")
    filter.run(m.t_s[:100], m.rate_b_rad_s[:100], m.force_b_m_s2[:100], m.field_b_tesla[:100])
    again = COPIES[way](filter)
    assert again.posterior() == filter.posterior() and again.diagnostics().corrections == filter.diagnostics().corrections
    rest = (m.t_s[100:], m.rate_b_rad_s[100:], m.force_b_m_s2[100:], m.field_b_tesla[100:])
    assert np.array_equal(again.run(*rest).q_nb, filter.run(*rest).q_nb)


def test_a_copied_filter_for_coloured_errors_goes_on_with_its_model():
    other = LinearModel(A=0.6 * EYE, H=EYE, Qw=EYE, Qv=EYE, P0=EYE, An=0.8 * EYE, QU=EYE)
    z = np.random.default_rng(1).normal(size=(40, 2))
    filter = InsErrorFilter(MODEL, lag=1)
    filter.run(None, z[:20])
    filter.replace_model(other)
    filter.run(None, z[20:30])
    again = pickle.loads(pickle.dumps(filter))
    assert np.array_equal(again.run(None, z[30:]).x, filter.run(None, z[30:]).x)
    assert again.info() == filter.info() and again.info().steps == 40 and again.info().estimates_lambda is True


# --------------------------------------------------------------------------------------------- results


@pytest.fixture
def started(motion) -> Filter:
    m = motion.recording
    filter = Filter("hrekf")
    filter.run(m.t_s, m.rate_b_rad_s, m.force_b_m_s2, m.field_b_tesla)
    return filter


def test_results_are_arrays_numbers_flags_and_names(started):
    attitude = started.attitude()
    assert np.linalg.norm(attitude.q_nb * 2) == pytest.approx(2)
    assert attitude.sigma_rad.shape == (3,) and isinstance(attitude.t_s, float) and attitude.tilt_ready in (True, False)
    innovation = started.innovation("mag")
    assert innovation.S.shape == (3, 3) and innovation.accepted in (True, False)
    assert innovation.nis == pytest.approx(innovation.value @ np.linalg.inv(innovation.S) @ innovation.value)
    assert started.diagnostics().used.items() >= {"gyro": 300, "accel": 300, "mag": 300, "heading": 0}.items()
    assert started.field().gate in ("accepted", "rejected", "inflated")


def test_results_are_equal_when_their_numbers_are(started):
    assert started.posterior() == started.posterior() and started.posterior() != Filter("hrekf").diagnostics()
    assert Filter("ahrs").field() == Filter("ahrs").field()  # NaN while there is no reference
    started.advance(10)
    before = started.attitude()
    started.advance(20)
    assert started.attitude() != before


def test_the_results_have_the_fields_of_the_structs():
    records = {
        filter_answers.Attitude: "hnav_attitude", attitude_answers.Posterior: "hnav_posterior", filter_answers.Innovation: "hnav_innovation",
        attitude_answers.Field: "hnav_field", filter_answers.Diagnostics: "hnav_diagnostics", filter_answers.Health: "hnav_health",
        filter_answers.SensorHealth: "hnav_sensor_health", ins_error.InsErrorInfo: "hnav_ins_error_info",
        calibration.MagnetometerCalibration: "hnav_magnetometer_calibration", turntable.Truth: "hnav_truth",
        imu_mag_sensor.Reading: "hnav_reading",
    }  # fmt: skip
    for record, struct in records.items():
        ffi.sizeof(struct)
        in_c = {name for name, _ in ffi.typeof(struct).fields} - {"size", "reserved"}
        assert set(record.__annotations__) - {"note", "unit"} == in_c, struct


def test_a_run_becomes_a_table(motion):
    m = motion.recording
    run = Filter("ahrs").run(m.t_s, m.rate_b_rad_s, m.force_b_m_s2, m.field_b_tesla)
    table = run.to_dataframe()
    assert table.index.name == "t_s" and len(table) == len(m.t_s)
    np.testing.assert_array_equal(table[["q_w", "q_x", "q_y", "q_z"]].to_numpy(), run.q_nb)
    np.testing.assert_array_equal(table["yaw_rad"], run.euler_rad[:, 2])
    np.testing.assert_array_equal(table["gyro_bias_sigma_z_rad_s"], run.gyro_bias_sigma_rad_s[:, 2])
    np.testing.assert_array_equal(table["mag_nis"], run.mag_nis)
    assert table["heading_ready"].dtype == bool and table.shape[1] == 23
    assert list(table["gyro_health"].cat.categories) == list(SENSOR_STATES)
    np.testing.assert_array_equal(table["mag_health"], np.array(SENSOR_STATES)[run.health[:, 2]])


@pytest.mark.parametrize("filter", FILTERS)
def test_a_second_run_says_that_the_filter_wants_a_reset(filter, motion):
    m = motion.recording.cropped(1)
    arrays = (m.t_s, m.rate_b_rad_s, m.force_b_m_s2, m.field_b_tesla)
    f = Filter(filter)
    first = f.run(*arrays)
    with pytest.raises(HnavRuntimeError, match="t_s begins at 0 s, before the time of this filter: reset"):
        f.run(*arrays)
    f.reset()
    np.testing.assert_array_equal(f.run(*arrays).q_nb, first.q_nb)


@pytest.mark.parametrize("call, argument", [
    (lambda f: f.run(0.0), "t_s"),
    (lambda f: f.run([0, 1], [[0, 0, 0]]), "rate_b_rad_s"),
    (lambda f: f.run([0, 1], force_b_m_s2="fast"), "force_b_m_s2"),
    (lambda f: f.run([0, 1], only=("q",)), "only"),
    (lambda f: f.push_imu(0, [0, 0, 0], [0, 0]), "force_b_m_s2"),
    (lambda f: f.innovation("baro"), "sensor"),
])  # fmt: skip
def test_a_wrong_argument_is_named(call, argument):
    with pytest.raises(HnavValueError, match=argument) as error:
        call(Filter("ahrs"))
    assert error.value.argument == argument


def test_only_the_arrays_that_are_asked_for_are_filled(motion):
    m = motion.recording.cropped(1)
    run = Filter("ahrs").run(m.t_s, m.rate_b_rad_s, m.force_b_m_s2, m.field_b_tesla, only=("q_nb", "ready"))
    assert np.isfinite(run.q_nb[-1]).all() and np.isnan(run.sigma_rad).all()
