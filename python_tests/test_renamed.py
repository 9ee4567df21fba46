"""Who asks for a name of version 0.1 is told the new one in one line."""

import csv
import re

import pytest

from hnav import HnavError, Options
from hnav.filters.attitude_options import FILTERS, option_table
from hnav.filters.calibration import calibrate_magnetometer
from hnav.fmi.engines import run_recording
from hnav.fmi.fmu_run import filter_parameters
from hnav.fmi.fmus import Fmu, fmu_path
from hnav.native.options import option_rows
from hnav.renamed import TABLE, new_name, now_called
from hnav.systems.ssp_reader import read_system, system_path
from hnav.systems.structure import Parameter
from importing import built_fmu

ROWS = [tuple(row.values()) for row in csv.DictReader(TABLE.open())]
OPTIONS = [(old, new) for kind, old, new in ROWS if kind == "option"]


def one_line(call, old: str, new: str) -> None:
    with pytest.raises(HnavError, match=re.escape(old)) as error:
        call()
    assert f"now called {new}" in str(error.value) and "\n" not in str(error.value)


def test_no_name_is_both_old_and_new():
    assert not {(kind, old) for kind, old, _ in ROWS} & {(kind, new) for kind, _, new in ROWS}
    assert now_called("gamma", "option") == "" and new_name("gamma", "option") is None


def test_every_option_that_has_a_new_name_has_it_in_some_list():
    lists = (
        *FILTERS,
        "ins",
        "ins_error",
        "magnetometer",
        "turntable",
        "imu_mag_sensor",
        "vehicle",
        "aid_sensor",
        "aircraft",
        "observer",
    )
    known = {name for options in lists for name in option_rows(options)}
    assert {new for _, new in OPTIONS} <= known and not {old for old, _ in OPTIONS} & known


@pytest.mark.parametrize("old, new", OPTIONS)
def test_an_option_by_its_old_name(old, new):
    for filter in FILTERS:
        one_line(lambda f=filter: Options(f, **{old: 1.0}), old, new)
        one_line(lambda f=filter: filter_parameters(f, {old: "1"}, "default"), old, new)
    one_line(lambda: calibrate_magnetometer([[1, 0, 0]], **{old: 1.0}), old, new)


def test_a_filter_by_its_old_name(motion):
    one_line(lambda: option_table("aligner"), "aligner", "ahrs")
    one_line(lambda: run_recording(motion.recording, "aligner"), "aligner", "ahrs")


def test_an_fmu_by_its_old_name():
    for version in (2, 3):
        one_line(lambda v=version: fmu_path("Aligner", v), "Aligner", "Ahrs")


def test_a_variable_of_an_fmu_by_its_old_name():
    with Fmu(built_fmu("Ahrs", 3)) as fmu:
        one_line(lambda: fmu.references(["field.adopted"]), "field.adopted", "field.reference_changes")
        one_line(lambda: fmu.set("turn_least_rad", 0.1), "turn_least_rad", "reference.turn_min_rad")


def test_a_parameter_of_a_system_by_its_old_name():
    built_fmu("Ahrs")
    with read_system(system_path("turntable")) as system:
        old = [Parameter("ahrs.unseen_turn_factor", "", "1")]
        one_line(lambda: system.apply(old, "--set"), "unseen_turn_factor", "timing.gap_turn_factor")
        one_line(lambda: system.apply([Parameter("aligner.trust_s", "", "1")], "--set"), "aligner", "ahrs")
