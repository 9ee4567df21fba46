"""Parameters as importers show and write them, the samples that a step loses or takes, and the log."""

import ctypes as C
import math
import os
import re
import subprocess
import xml.etree.ElementTree as ET
import zipfile

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from checkout import TOP
from hnav.errors import HnavError
from hnav.filters.options import Options, option_table
from hnav.fmi.fmus import Fmu, fmu_path, parameter_values

FILTERS = ("Hrekf", "Ahrs")
FMUS = (
    *FILTERS, "Turntable", "ImuMagSensor", "InsErrorFilterLateral", "AircraftInsLateral", "Pendulum", "Observer", "Ins", "Vehicle", "Gnss",
    "Baro", "Wheel",
)  # fmt: skip
VERSIONS = (2, 3)
versions = pytest.mark.parametrize("version", VERSIONS, ids=lambda v: f"fmi{v}")
filters = pytest.mark.parametrize("name", FILTERS)
fmus = pytest.mark.parametrize("name", FMUS)
SAMPLE = {
    **{f"gyro.rate[{i}]": v for i, v in enumerate((0.01, -0.02, 0.3), start=1)},
    **{f"accel.force[{i}]": v for i, v in enumerate((0.1, -3.3, -9.2), start=1)},
    **{f"mag.field[{i}]": v for i, v in enumerate((1.4e-5, 0.6e-5, 4.7e-5), start=1)},
}


def described(name, version):
    return fmpy.read_model_description(str(fmu_path(name, version)))


def xml(name, version, file="modelDescription.xml"):
    with zipfile.ZipFile(fmu_path(name, version)) as archive:
        return ET.fromstring(archive.read(file))


def numbers(name, version):
    """Every attribute that is a number, of variables and units."""
    for element in xml(name, version).iter():
        for attribute in ("start", "min", "max", "factor"):
            text = element.get(attribute)
            if text and text not in ("true", "false"):
                yield text


# --------------------------------------------------------------------------------------------- names, order, text


@filters
def test_parameters_are_the_options_of_the_library_in_their_groups(name):
    variables = {v.name: v for v in described(name, 3).modelVariables}
    table, defaults = option_table(name.lower()), Options(name.lower())
    for option, info in table.items():
        for i in range(info.count):
            parameter = f"{info.group}.{option}" + (f"[{i + 1}]" if info.count > 1 else "")
            variable = variables[parameter]
            value = np.ravel(getattr(defaults, option))[i] if not info.choices else info.choices.index(getattr(defaults, option))
            assert float(variable.start) == float(value), option
            assert variable.description == ("" if info.advanced else "[basic] ") + info.description
            if info.choices:
                items = [(item.name, item.description) for item in variable.declaredType.items]
                assert items == list(zip(info.choices, info.choice_descriptions))


@fmus
@versions
def test_what_one_meets_first_stands_first(name, version):
    options = [v for v in described(name, version).modelVariables if v.causality == "parameter" and "." in v.name]
    basic = [v.description.startswith("[basic]") for v in options]
    if name in FILTERS:
        assert 10 <= sum(basic) <= 30 and basic == sorted(basic, reverse=True)


@fmus
@versions
def test_numbers_are_written_in_their_shortest_form(name, version):
    for text in numbers(name, version):
        assert len(text) <= len(repr(float(text))), text


@fmus
@versions
def test_every_choice_says_what_it_means(name, version):
    for v in described(name, version).modelVariables:
        if v.type == "Enumeration":
            assert v.declaredType.items and all(item.name and item.description for item in v.declaredType.items), v.name


@versions
def test_verdicts_on_the_field_are_a_choice_by_name(version):
    gate = next(v for v in described("Ahrs", version).modelVariables if v.name == "field.gate")
    assert [item.name for item in gate.declaredType.items] == ["accepted", "rejected", "inflated"]


@versions
def test_derivatives_bear_the_unit_of_their_state_by_the_second(version):
    per_second = {"m": "m/s", "m/s": "m/s2", "rad": None, "rad/s": "rad/s2", "s": None, None: "1/s"}
    for name in ("Hrekf", "Ins", "Pendulum"):
        for v in described(name, version).modelVariables:
            if v.derivative is not None:
                assert v.unit == per_second[v.derivative.unit], (name, v.name)


@versions
def test_times_are_shown_in_seconds(version):
    for name in FILTERS:
        for v in described(name, version).modelVariables:
            if v.name == "post.t" or v.name.endswith(".t_meas"):
                assert v.displayUnit is None


@fmus
def test_fmi2_says_that_it_allocates_by_itself(name):
    interfaces = [e for e in xml(name, 2) if e.tag in ("CoSimulation", "ModelExchange")]
    assert interfaces and all(e.get("canNotUseMemoryManagementFunctions") == "true" for e in interfaces)


@versions
def test_the_date_is_that_of_the_sources(version, tmp_path):
    describe = TOP / "build" / "fmu" / "describe_ahrs"
    if not describe.is_file():
        pytest.skip("the build of this checkout is not there")
    for folder in ("documentation", "resources", "sources", "terminalsAndIcons", "extra/org.fmi-standard.fmi-ls-ref"):
        (tmp_path / folder).mkdir(parents=True)
    for epoch, expected in (("1000000000", "2001-09-09T01:46:40Z"), ("", None)):
        command = [describe, tmp_path, str(version), TOP / "fmu" / "ahrs" / "doc.html", "1.0"]
        subprocess.run(command, check=True, env={**os.environ, "SOURCE_DATE_EPOCH": epoch})
        assert ET.parse(tmp_path / "modelDescription.xml").getroot().get("generationDateAndTime") == expected


@fmus
def test_every_connectable_variable_is_in_one_terminal(name):
    members = [
        e.get("variableName") for e in xml(name, 3, "terminalsAndIcons/terminalsAndIcons.xml").iter("TerminalMemberVariable")
    ]
    wanted = {
        v.name for v in described(name, 3).modelVariables
        if v.causality in ("input", "output") and "." in v.name and not v.name.startswith("count.")
    }  # fmt: skip
    assert set(members) == wanted and len(members) == len(wanted)


@filters
def test_the_page_shows_ranges_and_display_units_and_begins_with_what_matters(name):
    with zipfile.ZipFile(fmu_path(name, 3)) as archive:
        page = archive.read("documentation/index.html").decode()
    heads = re.findall("<h2[^>]*>(.*?)</h2>", page)
    assert heads.index("Parameters to look at first") < heads.index("Inputs") < heads.index("All other parameters")
    assert "<th>min</th><th>max</th>" in page and "shown in deg/s" in page
    row = next(line for line in page.splitlines() if "<code>timing.queue_capacity</code>" in line)
    assert "<td>64</td><td>4</td><td>1000000</td>" in row


# --------------------------------------------------------------------------------------------- presets


def estimate_after_a_second(fmu: Fmu) -> list[float]:
    fmu.initialise()
    for name, value in SAMPLE.items():
        fmu.set(name, value)
    for k in range(100):
        fmu.do_step(0.01 * k, 0.01)
    return [fmu.get(f"post.q[{i}]") for i in range(1, 5)] + [fmu.get(f"cov.P[{i},{i}]") for i in range(1, 7)]


def write_all_parameters(fmu: Fmu, but: str) -> None:
    """As wrappers of OpenModelica do: every parameter with its start value."""
    for v in fmu.description.modelVariables:
        if v.causality == "parameter" and v.name != but:
            fmu.set(v.name, {"Boolean": bool, "Real": float, "Float64": float}.get(v.type, int)(float(v.start)))


@versions
def test_a_preset_is_the_same_whoever_writes_what(version):
    found = []
    for parameters_written in (False, True):
        with Fmu(fmu_path("Hrekf", version)) as fmu:
            if parameters_written:
                write_all_parameters(fmu, but="preset")
            fmu.set("preset", "paper")
            found.append(estimate_after_a_second(fmu))
            assert fmu.get("robust.gamma_mode") == 0  # a parameter shows what was written
    with Fmu(fmu_path("Hrekf", version)) as fmu:
        paper, default = Options("hrekf", "paper"), Options("hrekf")
        differing = {n: getattr(paper, n) for n in option_table("hrekf") if getattr(paper, n) != getattr(default, n)}
        for name, value in parameter_values(option_table("hrekf"), differing).items():
            fmu.set(name, value)
        found.append(estimate_after_a_second(fmu))
    with Fmu(fmu_path("Hrekf", version)) as fmu:
        without = estimate_after_a_second(fmu)
    assert found[0] == found[1] == found[2] != without


@versions
def test_what_differs_from_its_start_value_goes_before_the_preset(version):
    found = []
    for gain in (1e-3, 1e-2):
        with Fmu(fmu_path("Hrekf", version)) as fmu:
            fmu.set("preset", "paper")
            fmu.set("noise.quaternion_noise_per_sqrt_s", gain)
            found.append(estimate_after_a_second(fmu))
    assert found[0] != found[1]


def test_a_filter_with_one_set_of_defaults_has_no_preset():
    assert "preset" not in {v.name for v in described("Ahrs", 3).modelVariables}


@versions
def test_an_option_without_its_group_is_answered_with_its_name(version):
    with Fmu(fmu_path("Hrekf", version)) as fmu:
        with pytest.raises(HnavError, match=r"no variable gamma_mode; did you mean robust\.gamma_mode\?"):
            fmu.set("gamma_mode", "kl")
        with pytest.raises(HnavError, match=r"did you mean timing\.max_interval_s\?"):
            fmu.set("timing.max_intervall_s", 1.0)


# --------------------------------------------------------------------------------------------- lost samples


def run_steps(fmu: Fmu, step_s: float, stop_s: float) -> None:
    for name, value in SAMPLE.items():
        fmu.set(name, value)
    for k in range(round(stop_s / step_s)):
        fmu.do_step(k * step_s, (k + 1) * step_s - k * step_s)


@filters
@versions
def test_lost_samples_are_said_once_with_step_period_and_cure(name, version):
    with Fmu(fmu_path(name, version)) as fmu:

        def initialise():
            fmu.set("sampling_mode", "periodic")
            fmu.initialise()

        initialise()
        run_steps(fmu, 0.08, 4)
        assert fmu.get("count.missed") > 100
        assert len(fmu.messages) == 1
        for word in ("0.08 s", "gyro.period = 0.01 s", "count.missed", "sampling_mode = auto"):
            assert word in fmu.messages[0]
        fmu.call(fmu.fmu.reset)
        initialise()
        run_steps(fmu, 0.01, 0.5)
        assert len(fmu.messages) == 1  # nothing is lost, nothing is said
        fmu.call(fmu.fmu.reset)
        initialise()
        run_steps(fmu, 0.02, 0.5)
        assert len(fmu.messages) == 2  # a new simulation


@versions
def test_a_counter_that_runs_ahead_is_said_too(version):
    with Fmu(fmu_path("Ahrs", version)) as fmu:
        fmu.set("sampling_mode", "counter")
        fmu.initialise()
        for k, count in enumerate((1, 2, 5, 9)):
            fmu.set("accel.sample", count)
            fmu.do_step(0.01 * k, 0.01)
        assert len(fmu.messages) == 1 and "accel.sample" in fmu.messages[0]


@versions
def test_the_filter_of_an_ins_and_the_sensors_say_it_too(version):
    for name, period in (("InsErrorFilterLateral", "interval = 0.1 s"), ("ImuMagSensor", "gyro.period_s = 0.01 s")):
        with Fmu(fmu_path(name, version)) as fmu:
            if "sampling_mode" in fmu.variables:
                fmu.set("sampling_mode", "periodic")
            fmu.initialise()
            for k in range(3):
                fmu.do_step(0.5 * k, 0.5)
            assert len(fmu.messages) == 1 and period in fmu.messages[0], name


@filters
@versions
def test_a_gamma_that_is_raised_at_every_correction_is_said_once(name, version):
    for gamma, lines in ((1e-4, 1), (10.0, 0)):
        with Fmu(fmu_path(name, version)) as fmu:
            fmu.set("robust.gamma_mode", "fixed")
            fmu.set("robust.gamma", gamma)
            fmu.set("sampling_mode", "held")
            fmu.initialise()
            run_steps(fmu, 0.01, 6)
            assert fmu.get("count.corrections") > 100
            assert len(fmu.messages) == lines == sum("robust.gamma was infeasible at" in line for line in fmu.messages)
            assert (fmu.get("count.gamma_raised") > 0.9 * fmu.get("count.corrections")) == bool(lines)


@versions
def test_the_default_call_of_fmpy_loses_no_samples(version, capsys):
    # Without a logger of our own: fmpy keeps the last one given for every later FMU of the process, also when it is gone.
    result = fmpy.simulate_fmu(str(fmu_path("Ahrs", version)), stop_time=60, output=["count.missed"])
    assert result["count.missed"][-1] == 0 and "samples" not in capsys.readouterr().out


@filters
@versions
def test_held_inputs_are_a_sample_at_each_period_inside_a_longer_step(name, version):
    """The same samples as at the period's own step, so the same bits."""
    found = []
    for step_s in (0.01, 0.08, 0.4, 2.0):
        with Fmu(fmu_path(name, version)) as fmu:
            fmu.set("sampling_mode", "held")
            fmu.initialise()
            run_steps(fmu, step_s, 2)
            assert fmu.get("count.missed") == 0 and fmu.messages == []
            found.append([fmu.get(v) for v in ("count.accel_used", *[f"post.q[{i}]" for i in range(1, 5)], "cov.P[1,1]")])
    assert found[0][0] == 200 and all(one == found[0] for one in found)


@filters
@versions
def test_auto_takes_one_sample_of_a_longer_step_and_says_so_once(name, version):
    with Fmu(fmu_path(name, version)) as fmu:
        fmu.initialise()
        run_steps(fmu, 0.08, 2)
        assert fmu.get("count.accel_used") == 25 and fmu.get("count.missed") == 0
        assert (
            len(fmu.messages) == 1
            and "communication step 0.08 s > gyro.period = 0.01 s: inputs are one sample" in fmu.messages[0]
        )


SEEN = ("count.accel_used", *[f"post.q[{i}]" for i in range(1, 5)], "post.t", "cov.P[1,1]")


@filters
@versions
def test_auto_takes_new_inputs_at_the_end_of_a_step_where_nothing_is_lost(name, version):
    """Steps that are no longer than the period: as periodic, with the inputs of the point."""
    found = []
    for mode in ("periodic", "auto"):
        with Fmu(fmu_path(name, version)) as fmu:
            fmu.set("sampling_mode", mode)
            fmu.initialise()
            for k in range(400):
                for variable, value in SAMPLE.items():
                    fmu.set(variable, value * (1 + 1e-3 * math.sin(k)))
                fmu.do_step(0.0035 * k, 0.0035 * (k + 1) - 0.0035 * k)
            assert fmu.get("count.missed") == 0 and fmu.messages == []
            found.append([fmu.get(v) for v in SEEN])
    np.testing.assert_allclose(found[1], found[0], rtol=1e-12)


@filters
@versions
def test_auto_goes_by_the_counter_from_its_first_change_on_and_forgets_what_was_no_sample(name, version):
    found = []
    for mode, late in (("counter", 0), ("auto", 0), ("auto", 3)):
        with Fmu(fmu_path(name, version)) as fmu:
            fmu.set("sampling_mode", mode)
            fmu.initialise()
            for k in range(-late, 200):
                if k >= 0:
                    for variable, value in SAMPLE.items():
                        fmu.set(variable, value * (1 + 1e-3 * math.sin(k)))
                    for sensor in ("gyro", "accel", "mag"):
                        fmu.set(f"{sensor}.sample", k + 1)
                        fmu.set(f"{sensor}.t_meas", 0.01 * (k + late))
                fmu.do_step(0.01 * (k + late), 0.01)
            assert len(fmu.messages) == (late > 0) and all("gyro.sample changed" in line for line in fmu.messages)
            found.append([fmu.get(v) for v in SEEN if v != "post.t"])
    assert found[0] == found[1]
    np.testing.assert_allclose(found[2], found[0], rtol=1e-6)


@versions
def test_held_inputs_of_the_filter_of_an_ins(version):
    with Fmu(fmu_path("InsErrorFilterLateral", version)) as fmu:
        fmu.set("sampling_mode", "held")
        fmu.initialise()
        for k in range(4):
            fmu.do_step(0.5 * k, 0.5)
        assert fmu.get("count.samples") == 20 and fmu.get("count.missed") == 0 and fmu.messages == []


@versions
def test_steps_of_several_intervals_are_one_sample_of_the_filter_of_an_ins(version):
    with Fmu(fmu_path("InsErrorFilterLateral", version)) as fmu:
        fmu.initialise()
        for k in range(4):
            fmu.do_step(0.5 * k, 0.5)
        assert fmu.get("count.samples") == 4 and fmu.get("count.missed") == 0
        assert len(fmu.messages) == 1 and "communication step 0.5 s > interval = 0.1 s: inputs are one sample" in fmu.messages[0]


@versions
def test_a_step_that_holds_too_many_samples_is_refused(version):
    with Fmu(fmu_path("InsErrorFilterLateral", version)) as fmu:
        fmu.set("sampling_mode", "held")
        fmu.initialise()
        with pytest.raises(HnavError, match="holds more than 50000 samples"):
            fmu.do_step(0, 1e6)


# --------------------------------------------------------------------------------------------- log


def instance_with_log(version: int, on: bool) -> tuple[Fmu, list[tuple[int, str, str]]]:
    fmu, said = Fmu(fmu_path("Ahrs", version)), []
    f = fmu.fmu
    # The library stays loaded: only the instance is created again.
    (f.fmi3FreeInstance if fmu.fmi3 else f.fmi2FreeInstance)(f.component)

    def logged(*line):
        status, category, text = line[-3:]
        said.append((status, category.decode(), text.decode()))

    if fmu.fmi3:
        f.instantiate(loggingOn=on, logMessage=logged)
    else:
        fmu._callbacks.logger = type(fmu._callbacks.logger)(logged)
        f.instantiate(callbacks=fmu._callbacks, loggingOn=on)
    return fmu, said


@versions
def test_events_are_logged_when_logging_is_on_and_errors_and_warnings_always(version):
    for on in (False, True):
        fmu, said = instance_with_log(version, on)
        with fmu:
            fmu.set("sampling_mode", "periodic")
            fmu.initialise()
            run_steps(fmu, 0.08, 0.4)
            with pytest.raises(HnavError):
                fmu.do_step(math.nan, 0.01)
            categories = [category for _, category, _ in said]
            assert ("logEvents" in categories) == on
            # Samples that are lost, at a level that importers show by default, and the error.
            assert categories.count("logStatusError") == 2 and categories[-1] == "logStatusError"
            assert {status for status, category, _ in said if category == "logStatusError"} == {3}


@versions
def test_categories_are_switched_by_name(version):
    fmu, said = instance_with_log(version, False)
    with fmu:
        switch = fmu.fmu.fmi3SetDebugLogging if fmu.fmi3 else fmu.fmu.fmi2SetDebugLogging
        switch(fmu.fmu.component, 0, 1, (C.c_char_p * 1)(b"logStatusError"))
        fmu.set("sampling_mode", "periodic")
        fmu.initialise()
        run_steps(fmu, 0.08, 0.4)
        assert said == []
        switch(fmu.fmu.component, 1, 1, (C.c_char_p * 1)(b"logStatusError"))
        with pytest.raises(FMICallException):
            switch(fmu.fmu.component, 1, 1, (C.c_char_p * 1)(b"logAnything"))
        assert "logAnything" in said[-1][2]
