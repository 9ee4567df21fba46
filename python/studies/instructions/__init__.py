"""Instructions for each IMU sample with a field, counted by valgrind: they do not depend on what else the machine does.

    ./run study instructions                 of this checkout and of revision b991a70, and the ratio
    ./run study instructions --only 'hrekf*' some of them

The first 20000 rows (70 s, 286 Hz) of BROAD trial 07 in one call of hnav_filter_run or hnav_filter_smooth.
"""
