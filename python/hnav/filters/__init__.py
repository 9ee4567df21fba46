"""Filters and calibration of the C library, as Python objects."""
