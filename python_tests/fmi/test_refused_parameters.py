"""Parameters that an FMU refuses: one line that names the variable and what it must be."""

import math
import re

import pytest

from hnav.errors import HnavError
from hnav.fmi.fmus import Fmu
from importing import built_fmu

versions = pytest.mark.parametrize("version", (2, 3), ids=lambda v: f"fmi{v}")
CURES = "it must be|its length must be|0 means never|a filter may take|exceeds"
WALKED = ("Ahrs", "Hrekf", "Ins", "InsErrorFilterLateral", "Observer", "Vehicle", "ImuMagSensor", "AircraftInsLateral")


def refusal(fmu: Fmu, **values: float) -> str:
    """The message of the FMU, "" where it takes the values; the FMU is reset afterwards."""
    try:
        for name, value in values.items():
            fmu.set(name, value)
        fmu.initialise()
    except HnavError as error:
        return str(error)
    finally:
        fmu.call(fmu.fmu.reset)
    return ""


@versions
@pytest.mark.parametrize("name", WALKED)
def test_whatever_is_refused_is_named_with_the_cure(name, version):
    refused = 0
    with Fmu(built_fmu(name, version)) as fmu:
        for v in (v for v in fmu.variables.values() if v.causality == "parameter" and v.type != "Boolean"):
            for value in (0.0, -1.0, math.nan, 1e300) if v.type in ("Real", "Float64") else (-1, 2**31 - 1):
                said = refusal(fmu, **{v.name: value})
                named = re.sub(r"\[\d+\]$", "", v.name) in said and re.search(CURES, said) and "\n" not in said
                assert named or not said, (v.name, value, said)
                refused += bool(said)
    assert refused > 20


@versions
@pytest.mark.parametrize(
    ("name", "values", "said"),
    [
        ("Ahrs", {"robust.gamma": 0}, "robust.gamma = 0 is impossible: it must be in (0, 1e+12]"),
        ("Ahrs", {"frame.q_body_sensor[1]": 0}, "frame.q_body_sensor is no attitude: its length must be at least 0.1"),
        ("Hrekf", {"adaptation.adaptation_max_rad_s_per_sqrt_s": 0},
         "adaptation.adaptation_min_rad_s_per_sqrt_s exceeds adaptation.adaptation_max_rad_s_per_sqrt_s"),
        ("InsErrorFilterLateral", {"euler_colour": True, "ins_error_time_constant.p": 0.01},
         "ins_error_time_constant.p = 0.01 is impossible with euler_colour: it must be above half of interval = 0.1"),
        ("InsErrorFilterLateral", {"ins_error_time_constant.p": 0}, "ins_error_time_constant.p = 0 is impossible: it must be in (0, 1e+09]"),
        ("AircraftInsLateral", {"command_period.rudder": 0}, "command_period.rudder = 0 is impossible: it must be in (0, 1e+09]"),
        ("Observer", {"angle.noise": 0}, "angle.noise = 0: it must be above 0"),
        ("Observer", {"angle.period": 1e-9}, "angle.period = 1e-09 s is below 1e-06 s; 0 means never"),
        ("Observer", {"start.rate": math.inf}, "start.rate = inf is impossible: it must be in (-inf, inf)"),
        ("Gnss", {"gnss.latency_s": 100}, "gnss.latency_s + gnss.stamp_error_s = 100 is more than 30 times gnss.period_s = 0.2"),
    ],
)  # fmt: skip
def test_it_is_called_as_the_user_sees_it(name, version, values, said):
    with Fmu(built_fmu(name, version)) as fmu:
        assert refusal(fmu, **values) == said


@versions
@pytest.mark.parametrize("name", ("Ahrs", "Hrekf", "Ins"))
def test_a_queue_that_no_memory_holds_is_refused(name, version):
    with Fmu(built_fmu(name, version)) as fmu:
        said = refusal(fmu, **{"timing.queue_capacity": 1000000})
    assert re.fullmatch(r"timing\.queue_capacity = 1000000 takes [\d.]+ GiB: a filter may take 1 GiB, which holds \d+", said)


def test_model_exchange_names_the_option_that_it_cannot_have():
    with Fmu(built_fmu("Hrekf"), model_exchange=True) as fmu:
        assert refusal(fmu, **{"timing.gyro_hold": 1}).startswith("timing.gyro_hold needs to be forward in Model Exchange")
