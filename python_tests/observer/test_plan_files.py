"""Plans in files: TOML of the user, and the text that the library reads."""

import numpy as np
import pytest

import hnav
from hnav.filters.observer import Observer
from hnav.native.library import ffi, library
from observer.test_fmu_plants import T_S, little_plan, samples

TEXT = """
[plant]
fmu = "little.fmu"
set = {mode = 0}
[sensor.x]
noise = 0.02
[input.u]
start = 0
[state.x]
start_sigma = 0.2
[state.v]
start_sigma = 0.5
noise = 0.1
[options]
horizon_s = 0.1
"""


def test_a_plan_of_a_file_is_the_same_plan(little_fmu, tmp_path):
    (tmp_path / "plan.toml").write_text(TEXT)
    plan = hnav.read_plan(tmp_path / "plan.toml", little_fmu)
    assert plan.text() == little_plan(little_fmu).text()
    observer = Observer(plan)
    assert observer.options.horizon_s == 0.1
    run, expected = (o.run(T_S, {"x": samples()}) for o in (observer, Observer(little_plan(little_fmu))))
    assert np.array_equal(run.x["v"], expected.x["v"])
    assert Observer(plan, horizon_s=0.3).options.horizon_s == 0.3


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("[sensor.x]", "[sensors.x]", r"\[sensors\] is no table of a plan"),
        ("noise = 0.02", "sigma = 0.02", r'\[sensor."x"\] has no sigma; it has gate_nis, noise, of, offset, unit'),
        ("noise = 0.02", "", r'\[sensor."x"\] needs noise'),
        ("noise = 0.02", 'noise = "much"', "sensor.x.noise = 'much' is no number"),
        ("[state.v]", "[state.w]", "the plant has no state 'w'"),
        ("[input.u]\nstart = 0", "[input]\nu = 1", r'\[input\] has no tables: write \[input."u"\]'),
        ("[plant]", "[plant", "no TOML"),
        ("horizon_s", "horizn_s", "did you mean horizon_s"),
        ("set = {mode = 0}", "neverfreed = true", r"\[plant\] has no neverfreed; it has fmu, set, memoryless, never_freed"),
    ],
)
def test_a_wrong_file_is_refused_by_its_entry(little_fmu, tmp_path, old, new, said):
    (tmp_path / "plan.toml").write_text(TEXT.replace(old, new, 1))
    with pytest.raises(hnav.HnavValueError, match=said):
        Observer(hnav.read_plan(tmp_path / "plan.toml", little_fmu))


def test_a_file_names_its_fmu(little_fmu):
    file = little_fmu.with_name("beside.toml")
    file.write_text(TEXT)
    assert [*hnav.read_plan(file).states] == ["x", "v"]
    file.write_text(TEXT.replace('fmu = "little.fmu"', ""))
    with pytest.raises(hnav.HnavValueError, match="names no fmu"):
        hnav.read_plan(file)


def opened(folder) -> str:
    """The library's message for a folder with a plan; empty if it accepts it."""
    observer, message = ffi.new("hnav_filter **"), ffi.new("char[]", 320)
    options = ffi.new("hnav_observer_options *", library().hnav_observer_defaults())
    library().hnav_observer_open(observer, options, str(folder).encode(), message, len(message))
    library().hnav_filter_destroy(observer[0])
    return ffi.string(message).decode()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda t: t.replace("plan 1", "plan 7"), "line 1: this is no plan of this version"),
        (lambda t: t.replace("fmi 2", "fmi 4"), "fmi is 4, not 2 or 3"),
        (lambda t: t.replace("state 0 2", "state 0 two"), "a number is missing or is none"),
        (lambda t: t.replace("sensor 0 1 0.02 0.0 x", "sensor 0 1 0.02"), "a number is missing or is none"),
        (lambda t: t.replace("sensor 0 1", "sensor -1 1"), "a number is missing or is none"),
        (lambda t: t.replace("token", "key"), "its first word is not known"),
        (lambda t: t.replace("end\n", ""), 'ends before its last line, "end"'),
        (
            lambda t: t.replace("end\n", "state 0 2 nan 0 0 0 inf\n" * 5001 + "end\n"),
            "take more than 1 GiB, the most of an observer: estimate",
        ),
        (lambda t: t.replace("end\n", "sensor 0 1 0.02 0.0\n" * 62 + "end\n"), "inputs and sensors are 64, the most is 62"),
        (lambda t: t.replace("end\n", "bound 2 0 1\nend\n"), "line 19: there is nothing of that place"),
        (lambda t: t.replace("end\n", "logarithmic 0\nend\n"), "line 19: there is nothing of that place"),
        (lambda t: t.replace("end\n", "depends 0 2\nend\n"), "line 19: there is nothing of that place"),
        (lambda t: t.replace("end\n", "depends 2 0\nend\n"), "line 19: there is nothing of that place"),
        (lambda t: t.replace("identifier little", "identifier " + "x" * 900), "a text is too long"),
        (lambda t: t.replace("binaries/linux64/little.so", "binaries/none.so"), "binaries/none.so cannot be loaded"),
        (lambda t: t.replace("{little}", "{other}"), "little could not be instantiated"),
        (lambda t: t.replace("fmi 2", "fmi 3"), "it does not offer Model Exchange of FMI 3"),
        (lambda t: t, ""),
    ],
)
def test_a_damaged_plan_is_refused_by_its_line(little_fmu, little_binary, tmp_path, change, said):
    (tmp_path / "binaries/linux64").mkdir(parents=True)
    (tmp_path / "resources").mkdir()
    (tmp_path / "binaries/linux64/little.so").write_bytes(little_binary.read_bytes())
    assert "observer.plan cannot be read" in opened(tmp_path)
    (tmp_path / "observer.plan").write_text(change(little_plan(little_fmu).text()))
    message = opened(tmp_path)
    assert said in message and bool(message) == bool(said)


def test_a_plan_has_as_many_unknown_inputs_and_start_values_as_it_likes(little_fmu, little_binary, tmp_path):
    """150 unknown inputs, 1001 start values, and a parameter that starts at the FMU's own value."""
    (tmp_path / "binaries/linux64").mkdir(parents=True)
    (tmp_path / "resources").mkdir()
    (tmp_path / "binaries/linux64/little.so").write_bytes(little_binary.read_bytes())
    lines = "unknown 6 0.0 0.1 0.01 1.0 inf 0.0 d\n" * 150 + "parameter 4 nan 0.5 0.0 0.0 inf k\n" + "set 9 0.0 mode\n" * 1001
    (tmp_path / "observer.plan").write_text(little_plan(little_fmu).text().replace("sensor 0", lines + "sensor 0"))
    filter, x = ffi.new("hnav_filter **"), ffi.new("double[153]")
    options = ffi.new("hnav_observer_options *", library().hnav_observer_defaults())
    assert library().hnav_observer_open(filter, options, str(tmp_path).encode(), ffi.NULL, 0) == 0
    assert library().hnav_observer_estimate(filter[0], x, ffi.NULL) == 0
    library().hnav_filter_destroy(filter[0])
    assert list(x) == [1.0] + [0.0] * 151 + [4.0]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[sensor.x]\nnoise = -1\n", "plan.toml: line 4: noise of x is -1"),
        (
            '[sensor."x"]\nnoise = 1\n[state."v"] # of the mass\nstart_sigma = 1\n\nnois = 2\n',
            "plan.toml: line 8: .* has no nois",
        ),
        ("[sensor.x]\ngate_nis = 3\n", "plan.toml: line 3: .* needs noise"),
    ],
)
def test_an_error_names_its_line(little_fmu, tmp_path, text, said):
    (tmp_path / "plan.toml").write_text("[plant]\nfmu = 'little.fmu'\n" + text)
    with pytest.raises(hnav.HnavValueError, match=said):
        hnav.read_plan(tmp_path / "plan.toml", little_fmu)
