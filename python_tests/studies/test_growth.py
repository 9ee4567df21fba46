"""The study of growth: short runs of its measurements."""

import numpy as np
import pytest

from command_line import answered
from hnav.errors import HnavError
from hnav.io.readers import read
from studies.command import main_of
from studies.growth.measures import of_age, of_filters, of_rows, of_workers, write_rows
from studies.growth.study import PARTS
from studies.long import Motion

main = main_of("growth")


def test_the_file_holds_the_motion_however_long_it_is(tmp_path):
    write_rows(tmp_path / "x.csv", 100_003)
    recording, motion = read(tmp_path / "x.csv"), Motion()
    np.testing.assert_allclose(np.diff(recording.t_s), 0.01, rtol=1e-9)
    np.testing.assert_allclose(recording.rate_b_rad_s[[0, 99_999, 100_000]], motion.rate[[0, 99_999, 0]], rtol=1e-8)


def test_a_file_is_filtered_in_a_process_of_its_own():
    (found,) = of_rows([500])
    assert found["rows"] == 500 and found["cpu_s"] > 0.1 and 20 < found["memory_mb"] < 1000


def test_filters_side_by_side_are_all_fed():
    one, many = of_filters((1, 50), samples=2000)
    assert (one["filters"], many["filters"]) == (1, 50)
    assert 0 < many["us_per_sample"] < 1000 and np.isfinite(many["kb_per_filter"])


def test_a_later_field_costs_more():
    near, far = of_age((0.02, 0.9), rows=600)
    assert far["us_per_late_sample"] > max(0.0, near["us_per_late_sample"])


def test_runs_are_distinguished_by_how_fmus_are_loaded():
    try:
        fresh, kept = of_workers(3, (1,), stop_s=0.2)
    except HnavError as error:
        pytest.skip(str(error))
    assert (fresh["how"], kept["how"]) == ("loaded for each run", "loaded once, 1 worker")
    assert 0 < fresh["runs_per_s"] == fresh["per_worker"] and kept["runs_per_s"] == kept["per_worker"]


def test_a_part_is_printed_and_drawn(tmp_path):
    done = answered(main, "--part", "filters", "--most-rows", "1e4", "--pictures", tmp_path)
    assert done.returncode == 0 and "1000" in done.stdout
    assert (tmp_path / "growth_filters.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("options, said", [(("--part", "all"), ", ".join(PARTS)), (("--most-rows", "10"), "1e4 to 1e9")])
def test_what_cannot_be_measured_is_one_line(options, said):
    done = answered(main, *options)
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and said in done.stderr
