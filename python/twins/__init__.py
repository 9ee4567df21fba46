"""The filters again in NumPy, slow and written to be read: the oracle of tests and studies, not in the wheel."""
