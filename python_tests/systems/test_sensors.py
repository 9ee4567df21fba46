"""Grades of sensors: read, checked, turned into parameters."""

import json
import math

import fmpy
import pytest

from command_line import hnav
from hnav import Options
from hnav.errors import HnavError
from hnav.fmi.fmus import fmu_path
from hnav.io.sensors import ENTRIES, GRADES, models_folder, read_grade, write_sensor
from hnav.systems.simulation import LoadedSystem


def test_every_file_in_the_folder_is_a_grade_that_can_be_read():
    assert sorted(path.stem for path in models_folder().glob("*.json")) == sorted(GRADES)
    for name in GRADES:
        assert read_grade(name).name == name


@pytest.mark.parametrize("name", GRADES)
def test_parameters_are_those_of_the_sensor_fmu_and_within_their_ranges(name):
    variables = {v.name: v for v in fmpy.read_model_description(str(fmu_path("ImuMagSensor", 2))).modelVariables}
    for parameter, value in read_grade(name).parameters().items():
        assert variables[parameter].causality == "parameter"
        assert float(variables[parameter].min) <= value <= float(variables[parameter].max), parameter


def test_every_entry_that_a_file_may_hold_is_a_parameter_of_the_sensor_fmu():
    variables = {v.name for v in fmpy.read_model_description(str(fmu_path("ImuMagSensor", 2))).modelVariables}
    for sensor, entries in ENTRIES.items():
        for parameter, _ in entries.values():
            assert f"{sensor}.{parameter}" in variables


def test_a_better_grade_is_better_in_every_figure():
    figures = [
        {
            k: v
            for k, v in read_grade(name).values.items()
            if not k.endswith(("period_s", "range_rad_s", "range_m_s2", "range_tesla"))
        }
        for name in GRADES
    ]
    for worse, better in zip(figures, figures[1:], strict=False):
        assert set(worse) == set(better)
        for key in worse:
            assert better[key] <= worse[key], key


@pytest.mark.parametrize(
    "sensor, entry, equal",
    [
        (
            "gyro",
            "noise",
            [
                (0.6, "deg/sqrt(h)"),
                (0.01, "deg/s/sqrt(Hz)"),
                (10, "mdeg/s/sqrt(Hz)"),
                (36, "deg/h/sqrt(Hz)"),
                (math.radians(0.01), "rad/s/sqrt(Hz)"),
            ],
        ),
        ("gyro", "bias_instability", [(3600, "deg/h"), (1, "deg/s"), (1000, "mdeg/s"), (math.radians(1), "rad/s")]),
        ("gyro", "random_walk", [(216000, "deg/h/sqrt(h)"), (1, "deg/s/sqrt(s)"), (math.radians(1), "rad/s/sqrt(s)")]),
        ("gyro", "g_sensitivity", [(3600, "deg/h/g"), (1, "deg/s/g"), (math.radians(1) / 9.80665, "rad/s/(m/s2)")]),
        (
            "accel",
            "noise",
            [(100, "ug/sqrt(Hz)"), (0.1, "mg/sqrt(Hz)"), (9.80665e-4, "m/s2/sqrt(Hz)"), (9.80665e-4 * 60, "m/s/sqrt(h)")],
        ),
        ("accel", "random_walk", [(60, "ug/sqrt(h)"), (0.06, "mg/sqrt(h)"), (9.80665e-6, "m/s2/sqrt(s)")]),
        ("accel", "range", [(2, "g"), (2000, "mg"), (2e6, "ug"), (19.6133, "m/s2")]),
        ("mag", "noise", [(20, "nT/sqrt(Hz)"), (0.02, "uT/sqrt(Hz)"), (2e-8, "T/sqrt(Hz)")]),
        ("mag", "random_walk", [(60, "nT/sqrt(h)"), (0.06, "uT/sqrt(h)"), (1e-9, "T/sqrt(s)")]),
        ("mag", "hard_iron", [(1, "uT"), (1000, "nT"), (10, "mG"), (0.01, "G"), (1e-6, "T")]),
        ("mag", "soft_iron", [(1, "%"), (0.01, "1"), (10000, "ppm")]),
        ("mag", "misalignment", [(1, "deg"), (math.radians(1), "rad"), (math.radians(1000), "mrad")]),
        ("mag", "latency", [(5, "ms"), (0.005, "s"), (5000, "us")]),
    ],
)
def test_equal_figures_in_different_units_are_equal_parameters(tmp_path, sensor, entry, equal):
    assert {unit for _, unit in equal} == set(ENTRIES[sensor][entry][1])
    values = []
    for value, unit in equal:
        file = tmp_path / "grade.json"
        file.write_text(json.dumps({"name": "x", "source": "x", "assumed": "x", sensor: {entry: {"value": value, "unit": unit}}}))
        (parsed,) = read_grade(file).values.values()
        values.append(parsed)
    assert values == pytest.approx([values[0]] * len(values), rel=1e-12)


def test_noise_for_the_filter_is_that_of_the_sensor_in_its_units():
    noise = read_grade("industrial").filter_parameters(strength_tesla=4e-5)
    assert noise["gyro_noise_rad_per_sqrt_s"] == pytest.approx(math.radians(0.2 / 60))
    assert noise["accel_noise_per_sqrt_hz"] == pytest.approx(50e-6)
    assert noise["mag_noise_per_sqrt_hz"] == pytest.approx(20e-9 / 4e-5)
    assert noise["gyro_bias_walk_rad_s_per_sqrt_s"] == pytest.approx(
        math.radians(math.hypot(6 / 3600 / 60, 3 / 3600 / math.sqrt(1000)))
    )


GOOD = {"name": "x", "source": "x", "assumed": "x"}


@pytest.mark.parametrize(
    "content, reason",
    [
        ("{", "grade.json: no JSON"),
        (b"\xff\xfe", "grade.json: no JSON"),
        ("[" * 100_000, "grade.json: no JSON"),
        ("[]", "grade.json: no object of sensors"),
        (GOOD | {"name": ""}, "grade.json: name is missing"),
        (GOOD | {"source": 1}, "grade.json: source is no text"),
        (GOOD | {"version": 2}, "grade.json: version = 2: this hnav reads version 1"),
        (GOOD | {"baro": {}}, "grade.json: there is no sensor baro; there are gyro, accel, mag"),
        (GOOD | {"gyro": {"noize": {"value": 1, "unit": "1"}}}, "grade.json: gyro.noize is unknown"),
        (GOOD | {"gyro": {"noise": 1}}, "grade.json: gyro.noise must have value and unit"),
        (
            GOOD | {"gyro": {"noise": {"value": 1, "unit": "deg/s"}}},
            "grade.json: gyro.noise: unit deg/s is not one of deg/sqrt(h), ",
        ),
        (GOOD | {"gyro": {"noise": {"value": 1, "unit": []}}}, "grade.json: gyro.noise: unit [] is not one of"),
        (GOOD | {"gyro": {"noise": {"value": 10**400, "unit": "deg/sqrt(h)"}}}, "grade.json: gyro.noise = 1000"),
        (GOOD | {"mag": {"range": {"value": -1, "unit": "uT"}}}, "grade.json: mag.range = -1 uT must be a number of at least 0"),
        (GOOD | {"mag": {"range": {"value": "8", "unit": "uT"}}}, "grade.json: mag.range = 8 uT must be a number of at least 0"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(tmp_path, content, reason):
    file = tmp_path / "grade.json"
    if isinstance(content, bytes):
        file.write_bytes(content)
    else:
        file.write_text(content if isinstance(content, str) else json.dumps(content))
    with pytest.raises(HnavError) as error:
        read_grade(file)
    assert str(error.value).startswith(reason)
    assert "\n" not in str(error.value)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(HnavError, match="nothing.json"):
        read_grade(tmp_path / "nothing.json")


def test_a_sensor_file_is_a_grade_of_a_system(tmp_path):
    file = tmp_path / "sensor.json"
    write_sensor(file, {"gyro": {"noise": {"value": 0.3, "unit": "deg/sqrt(h)"}, "range": {"value": 250, "unit": "deg/s"}}})
    with LoadedSystem("turntable") as loaded:
        system, as_it_is = loaded.system(), loaded.system()
        system.choose(str(file), "outliers")
        as_it_is.choose(None, "outliers")
        changed = {name: value for name, value in system.parameters().items() if as_it_is.parameters().get(name) != value}
    noise = math.radians(0.3 / 60)
    assert changed == pytest.approx({
        "sensor.gyro.noise_deg_per_sqrt_h": 0.3, "sensor.gyro.range_rad_s": math.radians(250), "ahrs.fault.gyro_range_rad_s": math.radians(250),
        **{f"{name}.noise.gyro_noise_rad_per_sqrt_s": noise for name in ("ahrs", "hekf", "hrekf")},
    })  # fmt: skip
    for options, said in (
        (["turntable", "--sensor", file, "--grade", "consumer"], "--grade and --sensor: give one of them"),
        (["turntable", "--sensor", tmp_path / "nothing.json"], "nothing.json"), (["turntable", "--sensor", "consumer"], "ends in .json"),
        (["observer", "--sensor", file], "has no component ImuMagSensor"),
    ):  # fmt: skip
        done = hnav("simulate", *options, "--out", tmp_path / "run")
        assert done.returncode == 2 and said in done.stderr and done.stderr.count("\n") == 1, done.stderr
    done = hnav("simulate", "turntable", "--sensor", file, "--stop", 1, "--out", tmp_path / "run")
    assert done.returncode == 0 and json.loads((tmp_path / "run" / "run.json").read_text())["grade"] == str(file), done.stderr


def test_a_grade_sets_the_options_of_a_filter():
    options, plain = Options("ahrs", sensor="consumer"), Options("ahrs")
    assert options.start_sigma_accel_bias_m_s2 == pytest.approx(0.196, abs=0.002)  # 20 mg
    assert options.start_sigma_bias_rad_s == pytest.approx(math.radians(0.5), rel=1e-3)
    assert options.gyro_noise_rad_per_sqrt_s == pytest.approx(math.radians(0.42) / 60)
    assert options.velocity_noise_m_s_per_sqrt_hz == plain.velocity_noise_m_s_per_sqrt_hz
    assert Options("hrekf", sensor="consumer").mag_noise_per_sqrt_hz == pytest.approx(60e-9 / 5e-5)
    assert Options("ahrs", sensor="consumer", start_sigma_bias_rad_s=0.5).start_sigma_bias_rad_s == 0.5
    with pytest.raises(HnavError, match="sensor = consumer: ins has grades as presets: consumer, industrial"):
        Options("ins", sensor="consumer")


def test_the_ins_takes_noise_and_what_is_known_of_the_start(tmp_path):
    file, deg_s, noise = tmp_path / "sensor.json", {"value": 1, "unit": "deg/s"}, {"value": 9, "unit": "mdeg/s/sqrt(Hz)"}
    write_sensor(
        file, {"gyro": {"noise": noise, "bias_instability": deg_s}, "accel": {"noise": {"value": 200, "unit": "ug/sqrt(Hz)"}}}
    )
    # The instability of a bias does not bound the bias itself.
    assert read_grade(file).options("ins") == pytest.approx(
        {"gyro_noise_rad_per_sqrt_s": math.radians(9e-3), "accel_noise_m_s_per_sqrt_s": 200e-6 * 9.80665}
    )
    assert "start_sigma_bias_rad_s" not in read_grade(file).options("ahrs")
    write_sensor(file, {"gyro": {"turn_on_bias": deg_s, "range": deg_s}})
    options = Options("ins", "industrial", sensor=file)
    assert options.start_sigma_gyro_bias_rad_s == pytest.approx(
        math.radians(math.sqrt(2))
    ) and options.gyro_range_rad_s == pytest.approx(math.radians(1))
    assert options.gyro_bias_walk_rad_s_per_sqrt_s == Options("ins", "industrial").gyro_bias_walk_rad_s_per_sqrt_s


def test_a_file_of_one_figure_leaves_the_other_options(tmp_path):
    file = tmp_path / "sensor.json"
    file.write_text(json.dumps({"version": 1, "name": "robot", "accel": {"turn_on_bias": {"value": 0.3, "unit": "m/s2"}}}))
    given, plain = Options("ahrs", sensor=file).as_dict(), Options("ahrs").as_dict()
    assert {name for name in plain if given[name] != plain[name]} == {"start_sigma_accel_bias_m_s2"}
    assert given["start_sigma_accel_bias_m_s2"] == 0.3
