"""Commands killed at random moments, and on disks that are full or read-only: what do they leave behind?

    ./run study interrupted --kills 100

Each command overwrites an output of an earlier one. Afterwards that must be the old output or the new one, whole; a folder of
results may also be refused by its readers. A killed montecarlo is run again and must give the bytes of an uninterrupted run.
"""
