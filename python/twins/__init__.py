"""The filters again in NumPy, slow and written to be read: the oracle of the tests, read in a checkout and not in the wheel."""
