"""Units by name, as what one of them is in SI."""

TESLA_PER = {"T": 1.0, "uT": 1e-6, "G": 1e-4, "au": 5e-5}
"""Of a magnetic field. au: arbitrary; the filter learns the strength anyway."""
