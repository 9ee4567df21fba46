"""The errors of the package: what they are for a Python user."""

import pickle

import pytest

from hnav.errors import HnavError, HnavRuntimeError, HnavValueError, error_of


@pytest.mark.parametrize("status, kind", [
    ("option", ValueError), ("size", ValueError), ("non-finite", ValueError), ("ill-conditioned", ValueError),
    ("late sample", RuntimeError), ("not started", RuntimeError), ("out of memory", RuntimeError), ("solver", RuntimeError),
])  # fmt: skip
def test_a_status_becomes_the_error_that_python_users_expect(status, kind):
    error = error_of(status, "row 3: wrong")
    assert isinstance(error, HnavError) and isinstance(error, kind)
    assert (error.status, str(error), error.argument) == (status, "row 3: wrong", None)


@pytest.mark.parametrize("kind", [HnavValueError, HnavRuntimeError])
def test_errors_travel_between_processes(kind):
    error = kind("option", "filter = x: choose ahrs", argument="filter")
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is kind and str(again) == str(error)
    assert (again.status, again.argument) == ("option", "filter")
