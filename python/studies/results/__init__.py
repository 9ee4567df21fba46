"""Rewrites docs/results.md: what was measured, by which command, on what machine, when, and of which revision.

    ./run study results                    what takes less than two minutes
    ./run study results readiness table1   these
    ./run study results --all              everything, which takes hours

A section holds what its command prints. Sections that are not measured stay as they are, with the revision that they are of.
"""
