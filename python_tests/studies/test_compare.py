"""The comparison of old and new: it sees a last bit, a NaN that is not one, what is missing, and what was declared."""

import csv
import math

import numpy as np
import pytest

from studies.compare.names import TABLE, Names
from studies.compare.verdict import FAILURE, Declared, Difference, declared_exceptions, differences, reason_for

VALUES = np.array([[1.0, math.nan], [0.0, -3.0]])


def changed(row: int, column: int, value: float) -> np.ndarray:
    copy = VALUES.copy()
    copy[row, column] = value
    return copy


def test_the_same_bits_are_equal_and_so_are_any_two_nan():
    other_nan = np.array([0x7FF8000000000001], np.uint64).view(float)[0]
    assert differences({"x": VALUES}, {"x": changed(0, 1, other_nan), "more": VALUES}) == []


@pytest.mark.parametrize(
    "after", [changed(0, 0, np.nextafter(1, 2)), changed(1, 0, -0.0), changed(0, 1, 2.0), changed(1, 1, math.nan), VALUES[:1]]
)
def test_whatever_else_differs_is_told(after):
    assert [d.value for d in differences({"x": VALUES}, {"x": after})] == ["x"]


def test_the_largest_difference_is_told_with_its_place():
    after = changed(0, 0, 1.5)
    after[1, 1] = -7.0
    (found,) = differences({"x": VALUES}, {"x": after})
    assert "2 of 4 differ, first at [0, 0]; most, by 4, at [1, 1]" in found.text


def test_a_tolerance_is_of_one_or_of_the_size_of_the_number():
    old = {"x": np.array([1e-3, 1e6, math.nan, math.inf])}
    assert differences(old, {"x": old["x"] + [5e-13, 5e-7, 0, 0]}, tolerance=1e-12) == []
    assert differences(old, {"x": old["x"] + [0, 5e-6, 0, 0]}, tolerance=1e-12)
    assert differences(old, {"x": np.array([1e-3, 1e6, 0.0, math.inf])}, tolerance=1e-12)


def test_integers_and_texts_are_compared_as_such():
    old = {"count": np.array([3, 4], np.uint64), "unit": np.array(["rad", "s"])}
    assert differences(old, {"count": np.array([3, 4], np.int32), "unit": np.array(["rad", "s"], "U9")}) == []
    assert len(differences(old, {"count": np.array([3, 5]), "unit": np.array(["rad", "m"])})) == 2


def test_what_is_missing_and_a_side_that_failed_are_differences():
    assert differences({"x": VALUES}, {})[0].text == "the new side has no such value"
    (found,) = differences({"x": VALUES}, {FAILURE: np.array("Traceback\nKeyError: 'q'")})
    assert found.value == FAILURE and found.text.endswith("KeyError: 'q'")


def test_an_exception_has_a_reason_and_holds_where_its_patterns_say():
    declared = [Declared("c/ahrs/*", "diagnostics.*", "counted otherwise")]
    assert reason_for("c/ahrs/trial/07", Difference("diagnostics.late", ""), declared) == "counted otherwise"
    assert reason_for("c/ahrs/trial/07", Difference("q_nb", ""), declared) is None
    assert reason_for("c/hrekf/trial/07", Difference("diagnostics.late", ""), declared) is None
    assert all(row.reason for row in declared_exceptions())


def test_a_thing_is_found_by_either_name_and_called_by_the_new_one():
    names = Names()
    assert names.find("filter", "ahrs", ["aligner", "hrekf"]) == "aligner"
    assert names.find("filter", "aligner", ["ahrs", "hrekf"]) == "ahrs"
    assert names.canonical("filter", "aligner") == "ahrs"
    with pytest.raises(KeyError, match="there is no filter ekf"):
        names.find("filter", "ekf", ["ahrs"])


def test_the_table_of_names_gives_each_old_name_one_new_one():
    with TABLE.open(newline="") as file:
        rows = [(row["kind"], row["old"], row["new"]) for row in csv.DictReader(file)]
    assert len({(kind, old) for kind, old, _ in rows}) == len(rows)
    assert all(old != new and old.strip() and new.strip() for _, old, new in rows)
