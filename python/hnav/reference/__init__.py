"""The mathematics again in NumPy, slow and written to be read: the oracle of the tests."""
