"""Monte Carlo comparison in the form of the paper's Table 1: the paper's filters against the augmented one and the oracle.

    ./run study ins_error_table --runs 1000
    ./run study ins_error_table --runs 60 --settings 100      # the same for random noise levels, periods and intervals

A root mean square is taken over each run's fault window, then the mean over the runs with its 95 % interval.
"""
