"""Flights with a fault of every kind, and what adaptive filters make of them: errors, consistency, false alarms.

    ./run study ins_error_faults [--runs 120] [--seed 1] [--only CASE]

All filters see the same flights of the F-4C and have the same augmented model, that of its file; the truth differs from
that in one thing a case, from 8 to 15 s unless stated otherwise. The oracle has the true noise of each channel and nothing else.
"""
