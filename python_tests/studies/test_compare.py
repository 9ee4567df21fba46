"""The comparison of two revisions: it detects a changed last bit and a NaN that became a number, states differences in
sigmas, and finds no difference between a revision and itself."""

import json
import math
from fnmatch import fnmatch

import numpy as np
import pytest

from hnav.places import CHECKOUT
from studies.command import main_of
from studies.compare.recordings import FAULTS, write
from studies.compare.scenarios import all_scenarios
from studies.compare.verdict import Moved, judged, sigma_of
from studies.compare.worker import FAILURE

main = main_of("compare")

VALUES = np.array([1.0, math.nan, 0.0, -3.0])
needs_build = pytest.mark.skipif(not (CHECKOUT / "build/fmus/fmi2/Pendulum.fmu").is_file(), reason="no build: ./run build")


def changed(row: int, value: float) -> np.ndarray:
    copy = VALUES.copy()
    copy[row] = value
    return copy


def test_the_same_bits_are_equal_and_so_are_any_two_nan():
    other_nan = np.array([0x7FF8000000000001], np.uint64).view(float)[0]
    assert judged("s", {"x": VALUES}, {"x": changed(1, other_nan)}).verdict == "equal"


@pytest.mark.parametrize(
    "after", [changed(0, np.nextafter(1, 2)), changed(2, -0.0), changed(1, 2.0), changed(3, math.nan), VALUES[:1]]
)
def test_whatever_else_differs_has_moved(after):
    verdict = judged("s", {"x": VALUES}, {"x": after})
    assert verdict.verdict == "moved" and [moved.column for moved in verdict.moved] == ["x"]


def test_a_column_says_in_how_many_rows_it_moved_how_far_and_in_sigmas():
    old = {"heading": np.array([359.0, 10.0, 20.0]), "sigma_heading": np.array([0.5, 1.0, 2.0])}
    (moved,) = judged("s", old, old | {"heading": np.array([1.0, 10.0, 21.0])}).moved
    assert moved == Moved("heading", 2, 3, 2.0, 4.0)
    assert str(moved) == "heading: 2 of 3 rows, at most 2 (4 sigma)"


def test_integers_and_flags_are_compared_as_such():
    old = {"count": np.array([3, 4], np.uint64), "flag": np.array([True, False])}
    assert judged("s", old, {"count": np.array([3, 4], np.int32), "flag": np.array([1, 0])}).verdict == "equal"
    (moved,) = judged("s", old, old | {"count": np.array([3, 6])}).moved
    assert (moved.rows, moved.largest, moved.sigmas) == (1, 2.0, None)


def test_what_stands_on_one_side_only_is_listed_and_no_fault():
    verdict = judged("s", {"x": VALUES, "gone": VALUES}, {"x": VALUES, "new": VALUES})
    assert (verdict.verdict, verdict.only_old, verdict.only_new) == ("equal", ["gone"], ["new"])


def test_a_failed_side_is_named_and_two_refusals_in_the_same_words_agree():
    verdict = judged("s", {"x": VALUES}, {FAILURE: np.array("Traceback\nKeyError: 'q'")})
    assert verdict.verdict == "failed" and verdict.failure.endswith("KeyError: 'q'")
    refusal = {FAILURE: np.array("refused: too short")}
    assert judged("s", refusal, refusal).verdict == "equal"
    assert judged("s", refusal, {FAILURE: np.array("refused: too long")}).verdict == "failed"
    crash = {FAILURE: np.array("its process ended with -11")}
    assert judged("s", crash, crash).verdict == "failed"


@pytest.mark.parametrize(
    ("column", "sigma"),
    [("roll_deg", "sigma_x_deg"), ("bias_y_deg_s", "sigma_bias_y_deg_s"), ("vn", "sigma_vn"), ("ins.att.euler[3]", "ins.att.sigma[3]"),
     ("bias.gyro[2]", "bias.gyro_sigma[2]"), ("estimate.phi", "sigma.phi"), ("post.angle", "post_sigma.angle"), ("level", "sigma.level")],
)  # fmt: skip
def test_a_column_finds_its_sigma(column, sigma):
    assert sigma_of(column, {column: VALUES, sigma: VALUES}) is not None
    assert sigma_of(column, {column: VALUES}) is None


def test_a_place_in_degrees_is_weighed_by_a_sigma_in_metres():
    sigma = sigma_of("lat_deg", {"sigma_north": np.array([111_195.0])})
    assert sigma == pytest.approx([1.0])


def test_names_are_those_of_one_scenario_each_and_cover_every_product():
    names = [scenario.name for scenario in all_scenarios()]
    assert len(set(names)) == len(names)
    for pattern in ("ahrs/smooth/*", "hrekf/paper", "ins/start/ship", "ins/gyrocompass", "observer/tank", "fmu/fmi3/InsErrorFilter*/mdkf",
                    "fmu/fault/Ins/ahead", "calibration/*", "system/navigation/*"):  # fmt: skip
        assert any(fnmatch(name, pattern) for name in names), pattern


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_changes_the_rows_and_leaves_those_that_it_was_given(fault):
    rows = np.arange(1200.0)[:, None] + np.zeros((1, 7))
    spoilt = FAULTS[fault](rows)
    assert np.array_equal(rows, np.arange(1200.0)[:, None] + np.zeros((1, 7)))
    assert np.array_equal(spoilt, rows) == (fault == "none")


def test_a_recording_is_written_in_full(tmp_path):
    write("tumbling-nan.csv", tmp_path)
    table = np.genfromtxt(tmp_path / "tumbling-nan.csv", delimiter=",", skip_header=1)
    from studies.compare.recordings import tumbling

    assert np.array_equal(table, FAULTS["nan"](tumbling()), equal_nan=True)


@needs_build
def test_this_checkout_answers_as_itself(tmp_path, capsys):
    only = [word for name in ("observer/tank", "ahrs/option/closed_form", "fmu/fmi2/Pendulum/cs") for word in ("--only", name)]
    main(["--old", str(CHECKOUT), "--json", str(tmp_path / "table.json"), *only])
    assert "3 scenarios" in capsys.readouterr().out
    table = json.loads((tmp_path / "table.json").read_text())
    assert table["counts"] == {"equal": 3}
    assert all(row["numbers"] > 1000 and not row["moved"] for row in table["scenarios"])
