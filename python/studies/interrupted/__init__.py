"""Commands killed at random moments, and on disks that are full or read-only: what do they leave behind?

    ./run study interrupted --kills 100

Each command overwrites an output of an earlier one. Afterwards that must be the old output or the new one, whole; a folder of
results may also be one that its readers refuse. A montecarlo that was killed is run again, to the bytes of one that was not.
"""
