"""The study of the robust law and the adaptation: short samples of its tables, and what they have to show."""

import numpy as np
import pytest

from command_line import answered
from studies.command import main_of
from studies.robust import CLAIMS, FILTERS, SCENARIOS, WALK, adapted, seconds_to, settled_rms, simulate

main = main_of("robust")


def test_a_run_is_what_its_scenario_says():
    run = simulate(SCENARIOS["bias ramp"], seed=1, duration_s=20)
    np.testing.assert_allclose((run.bias[-1] - run.bias[0]) / 20, 2e-3, rtol=0.1)
    turned = (run.attitude[:-1].inv() * run.attitude[1:]).as_rotvec() * 100
    assert np.std(run.rate[:-1] - run.bias[:-1] - turned) == pytest.approx(0.01, rel=0.05)
    assert simulate(SCENARIOS["bias walk x 100"], 1, 20).bias.std() > 10 * WALK


def test_an_ekf_with_a_larger_q_wins_where_the_model_is_wrong_and_loses_where_it_is_right():
    assumed, robust, _, larger = zip(
        *(settled_rms(SCENARIOS[name], FILTERS.values(), 2) for name in ("as assumed", "bias walk x 100"))
    )
    assert assumed[0] < min(robust[0], larger[0])
    assert larger[1] < robust[1] < assumed[1]


def test_the_robust_law_is_faster_from_an_over_confident_start():
    slow, fast = seconds_to(3, [{}, {"gamma_mode": "relative", "gamma_relative_rate_1_s": 15.0}], 3)
    assert fast < 0.7 * slow


@pytest.mark.parametrize("mode", ["relative", "kl"])
def test_the_rate_of_samples_drops_out(mode):
    slow, fast = (settled_rms(SCENARIOS["as assumed"], [{"gamma_mode": mode}], 2, rate)[0] for rate in (50, 200))
    assert fast == pytest.approx(slow, rel=0.15)


@pytest.mark.parametrize("claim", CLAIMS)
def test_the_adaptation_converges_from_both_sides(claim):
    median, _, _, bias_ratio, _ = adapted(claim, seeds=8, rate_hz=20)
    assert 0.4 < median < 2 and bias_ratio < 1.15


def test_a_part_that_there_is_not_is_one_line():
    done = answered(main, "--part", "everything")
    assert (
        done.returncode == 2
        and done.stderr.count("\n") == 1
        and "scenarios, measurements, start, rates, adaptation" in done.stderr
    )
