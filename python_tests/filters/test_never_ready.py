"""What is said of an estimate that was never ready."""

import numpy as np
import pytest

import hnav
from hnav.filters.options import Options
from hnav.filters.readiness import sigmas, smallest, why_never
from hnav.filters.run_summary import rows, summary


def test_the_sigma_compared_is_the_largest_of_its_axes():
    rotation = np.array([[0.3, 0.1, 2.0], [0.1, 0.2, 1.0], [np.nan] * 3])
    three = np.array([[1.0, 2.0, 9.0], [3.0, 1.0, 4.0], [np.nan] * 3])
    np.testing.assert_array_equal(smallest(sigmas(rotation, three, three)), [0.2, 1.0, 4.0, 2.0])
    assert np.isinf(smallest(np.full((3, 1), np.nan))).all()


@pytest.mark.parametrize("name, reached, said", [
    ("heading", np.radians(12), "its sigma reached 12 deg, and has to be below 1 deg (ready_heading_rad)"),
    ("position", 3.0, "its sigma reached 3 m, which is below 10 m (ready_position_m), but not for long enough"),
    ("tilt", np.inf, "there was no estimate"),
])  # fmt: skip
def test_quantity_sigma_and_limit_are_named(name, reached, said):
    options = Options("ins", "industrial", ready_heading_rad=np.radians(1), ready_position_m=10.0)
    assert why_never(name, reached, options).startswith(said)


def test_a_run_without_a_field_says_what_its_heading_lacks():
    t_s = np.arange(1000) / 100
    run = hnav.Filter("ahrs").run(t_s, np.zeros((1000, 3)) + 1e-4, np.zeros((1000, 3)) + [0, 0, -9.81])
    said = dict(rows(summary(run)))["heading ready"]
    assert said.startswith("never: its sigma reached ") and "has to be below 5 deg (ready_heading_rad)" in said
