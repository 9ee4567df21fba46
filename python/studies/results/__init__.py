"""Writes docs/results/NAME.json: what was measured, by which command, on what machine, when, and of which revision.

    ./run study results                    what takes less than two minutes
    ./run study results readiness table1   these
    ./run study results --all              everything, which takes hours

A file holds what its command prints, as tables. docs/results.md quotes figures of these files; update it when they change. A new
measurement begins as a file with its title, says (the text of its page) and commands (one, as it is typed behind ./run; DIR stands for the
folder of BROAD_DIR, FLIGHT for that of HNAV_FLIGHT).
"""
