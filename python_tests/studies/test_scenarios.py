"""The study of the turntable's scenarios: which rows it has, and which filter the EKF with a larger Q is."""

import numpy as np
import pytest

from command_line import answered
from hnav.errors import HnavError
from hnav.filters.options import Options
from hnav.systems.montecarlo import Job, rows_of
from studies.bench.contenders import LARGER_Q, own_contender
from studies.command import main_of
from studies.larger_q import FACTOR, NAME, WALK, in_turntable, larger_q
from studies.scenarios import measured

main = main_of("scenarios")


@pytest.fixture(scope="module")
def table():
    try:
        return measured(["gyro_drift", "nominal"], 2, 1, stop_s=0.5)
    except HnavError as error:
        pytest.skip(str(error))


def test_a_scenario_has_every_filter_and_the_ekf_with_a_larger_q(table):
    assert [*table["scenario"].unique()] == ["gyro_drift", "nominal"]
    for _, rows in table.groupby("scenario"):
        assert [*rows["filter"].unique()] == ["hekf", "hrekf", "ahrs", NAME]
        assert (rows.groupby("filter").size() == 2).all()


def test_the_ekf_with_a_larger_q_is_the_hekf_with_its_walk_a_hundred_times_as_large(table):
    settings = in_turntable("nominal")
    assert float(settings[f"hekf.noise.{WALK}"]) == FACTOR * 1e-3
    one = rows_of(Job("turntable", "nominal", 2, settings=settings, stop_s=0.5))[0]
    row = table[(table["scenario"] == "nominal") & (table["filter"] == NAME) & (table["seed"] == 2)].iloc[0]
    assert one["filter"] == "hekf" and one["mse_deg2"] == row["mse_deg2"]
    assert not np.isclose(row["mse_deg2"], table[(table["filter"] == "hekf")]["mse_deg2"]).any()


def test_on_recordings_it_is_the_hrekf_without_its_law_and_with_the_larger_walk():
    given = own_contender(LARGER_Q)
    assert given.ours and not given.offline
    chosen = larger_q(Options("hrekf").gyro_bias_walk_rad_s_per_sqrt_s)
    assert chosen == {"gamma_mode": "off", "adaptation": "off", WALK: 100 * Options("hrekf").gyro_bias_walk_rad_s_per_sqrt_s}


def test_a_scenario_that_there_is_not_is_one_line():
    done = answered(main, "--scenarios", "none")
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and "gyro_drift" in done.stderr
