"""The paper's Table 1 beside ours."""

import numpy as np
import pytest

from command_line import answered
from hnav.errors import HnavError
from hnav.systems.simulation import simulate
from studies import table1
from studies.command import main_of
from studies.table1 import FILTERS, REGIMES, experiment, squared_errors_deg2

main = main_of("table1")


@pytest.fixture(scope="module")
def found() -> dict[str, dict[str, np.ndarray]]:
    try:
        return experiment(2, list(REGIMES))
    except HnavError as error:
        pytest.skip(str(error))


def test_table1_starts_at_the_first_correction_and_follows_the_regimes(found):
    assert {regime: list(rows) for regime, rows in found.items()} == {
        regime: list(FILTERS) for regime in ("fitted", "fitted_honest")
    }
    # The over-confident start keeps the yaw wrong for the whole minute; an honest one forgets it at once.
    assert found["fitted"]["HEKF"][:, 0].min() > 10 * found["fitted_honest"]["HEKF"][:, 0].max()
    one = simulate("turntable", "fitted_honest", seed=1)
    np.testing.assert_array_equal(squared_errors_deg2(one)["hekf"], found["fitted_honest"]["HEKF"][0])


def test_the_table_prints_the_paper_beside_both_regimes(found, monkeypatch):
    def again(runs, regimes):
        assert (runs, regimes) == (2, list(REGIMES))
        return found

    monkeypatch.setattr(table1, "experiment", again)
    done = answered(main, "--runs", 2)
    assert done.returncode == 0, done.stderr
    for word in ("the paper", "3.61", "fitted", "honest P0"):
        assert word in done.stdout
