"""Samples in deg/s, in g, in uT: an FMU reads numbers without their unit, so its log warns of what gravity or the Earth's field contradicts."""

from dataclasses import replace

import numpy as np
import pytest

from hnav.fmi.fmus import Fmu, fmu_path
from motion import tilted_motion

SECONDS = 8


@pytest.fixture(scope="module")
def recording():
    return tilted_motion(SECONDS).recording


def warnings(filter: str, version: int, recording, rate_scale: float, force_scale: float, field_scale: float = 0.0) -> list[str]:
    """The lines of the log about units during a run over the samples; field_scale = 0: without a magnetometer."""
    with Fmu(fmu_path(filter, version)) as fmu:
        fmu.initialise(0.0)
        for row, t_s in enumerate(recording.t_s.tolist()):
            for axis in range(3):
                fmu.set(f"gyro.rate[{axis + 1}]", rate_scale * float(recording.rate_b_rad_s[row, axis]))
                fmu.set(f"accel.force[{axis + 1}]", force_scale * float(recording.force_b_m_s2[row, axis]))
                if field_scale:
                    fmu.set(f"mag.field[{axis + 1}]", field_scale * float(recording.field_b_tesla[row, axis]))
            fmu.do_step(t_s, 0.01)
        return [said for said in fmu.messages if "looks like" in said]


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("filter", ["Ahrs", "Hrekf", "Ins"])
def test_each_wrong_unit_is_logged_once_with_its_cure(filter, version, recording):
    (of_rate,) = warnings(filter, version, recording, np.degrees(1), 1)
    assert "looks like deg/s" in of_rate and "0.0174533" in of_rate
    (of_force,) = warnings(filter, version, recording, 1, 1 / 9.80665)
    assert "looks like g" in of_force and "9.80665" in of_force
    assert not warnings(filter, version, recording, 1, 1)


@pytest.mark.parametrize("filter", ["Ahrs", "Hrekf"])
@pytest.mark.parametrize(("unit", "scale"), [("uT", 1e6), ("mG", 1e7), ("gauss", 1e4), ("nT", 1e9)])
def test_a_field_in_another_unit_is_logged_with_its_cure(filter, unit, scale, recording):
    (said,) = warnings(filter, 2, recording, 1, 1, scale)
    assert f"looks like {unit}" in said and f"multiply it by {1 / scale:.0e}".replace("e-0", "e-") in said
    assert not warnings(filter, 2, recording, 1, 1, 1.0)


def test_a_direction_in_place_of_a_field_is_logged_by_the_filter_that_needs_its_strength(recording):
    scale = 1 / float(np.linalg.norm(recording.field_b_tesla, axis=1).mean())
    (said,) = warnings("Ahrs", 2, recording, 1, 1, scale)
    assert "no heading becomes ready" in said and "multiply it by 5e-5" in said
    assert not warnings("Hrekf", 2, recording, 1, 1, scale)


def test_ins_takes_a_field_in_any_unit(recording):
    assert not warnings("Ins", 2, recording, 1, 1, 1e6)


def test_a_field_in_uT_and_rates_in_deg_s_are_both_logged(recording):
    assert len(warnings("Ahrs", 2, recording, np.degrees(1), 1, 1e6)) == 2


@pytest.mark.parametrize("filter", ["Ahrs", "Hrekf", "Ins"])
def test_a_force_without_gravity_is_logged_and_not_taken_for_g(filter, recording):
    still = replace(recording, force_b_m_s2=np.random.default_rng(1).normal(0, 0.8, recording.force_b_m_s2.shape))
    (said,) = warnings(filter, 2, still, 1, 1)
    assert "without gravity" in said and "specific force" in said
