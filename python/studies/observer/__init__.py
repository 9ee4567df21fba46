"""Whether the observer is right, and what it costs: of plants in Python and, where HNAV_PLANTS names the folder of the Reference FMUs
and of a heated room, of FMUs.

    ./run study observer [--runs 50] [--part errors]

Part errors: many runs with known truth; plants with events stand beside particles on the same samples. NEES/n is the normalised square of
the error over the number of what is estimated, NIS that of the innovations: 1 where sigmas are right. Part laws: single figures beside
closed forms, a Kalman filter, 20 000 samples and a tight solution. Part bounds: a positive
parameter near zero, beside a filter without bounds. Part size: time, memory and NEES of 10, 64 and
200 states. Part cost: instructions and time of plants in C. Without --part all.
"""
