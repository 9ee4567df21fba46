"""Starts of the navigation filter: what the study tells the filter is what it simulates."""

import numpy as np

from studies.ins.experiment import experiment, figures


def test_a_telephone_is_told_how_slow_and_large_the_error_of_its_satellites_is():
    told = figures(list(experiment("walker", "consumer", 24, 3, 1)))
    # 24 starts of three axes: a mean of 72 squares of standard deviation 0.17, and errors of one start hang together.
    assert 0.5 < told.position_z2 < 1.6
    assert told.false == 0 and np.isnan(told.median_s)
